//! [`StatedRange`]: between which values a number of the model is moved.

/// Range of a number of the model, for sliders and searches; the motion does not depend on it.
#[derive(Clone, PartialEq, Debug)]
pub struct StatedRange {
    /// Path of the number from its section on: `parameters.l1`, `initial.A.angle`.
    pub path: String,
    /// Least and largest value, SI; of a number that is written without a unit, as that is written.
    pub ends: [f64; 2],
}
