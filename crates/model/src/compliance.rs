//! [`Compliance`]: how a joint yields to what it transmits, which decides how joints that repeat each other share a load.

use crate::ids::JointId;
use crate::measure::Frame;

/// A spring in a joint, in series with the others of the same joint.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Compliance {
    /// The joint.
    pub joint: JointId,
    /// The place in fx, fy, fz, mx, my, mz of what it yields to, and whose axes these are: of the ground, or of the
    /// joint's first point; `None` is alike in all directions.
    pub along: Option<(Frame, usize)>,
    /// True of a spring that turns.
    pub is_moment: bool,
    /// N/m, or N m/rad.
    pub stiffness: f64,
}
