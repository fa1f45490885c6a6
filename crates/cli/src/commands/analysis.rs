//! Questions besides motion in time, a file for each: read the model, ask, print the answer.

pub mod answer;
pub mod bode;
pub(crate) mod cam;
pub mod curves;
pub mod doctor;
pub mod gradient;
pub mod inverse;
pub mod kinematics;
pub mod limits;
pub mod linearize;
pub mod modes;
pub mod polygons;
pub mod state;
pub mod statics;
pub mod verify;
