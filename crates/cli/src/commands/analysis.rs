//! Questions besides motion in time, a file for each: read the model, ask, print the answer.

mod answer;
pub mod bode;
pub(crate) mod cam;
pub(crate) mod doctor;
pub(crate) mod inverse;
pub(crate) mod kinematics;
pub(crate) mod linearize;
pub(crate) mod modes;
pub(crate) mod statics;
pub(crate) mod verify;
