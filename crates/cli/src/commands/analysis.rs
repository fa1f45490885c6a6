//! Questions besides motion in time, a file for each: read the model, ask, print the answer.

mod answer;
pub(crate) mod cam;
pub(crate) mod inverse;
pub(crate) mod kinematics;
pub(crate) mod linearize;
pub(crate) mod modes;
pub(crate) mod statics;
