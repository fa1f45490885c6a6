//! [`Parts`]: bodies and joints that a flexible body is made of.

use crate::ids::{BodyId, JointId};

/// The hidden parts of a flexible body.
#[derive(Debug)]
pub(super) struct Parts {
    /// The body.
    pub(super) body: BodyId,
    /// Joints of the shapes by kind, each with its massless body.
    pub(super) shapes: [Vec<(JointId, BodyId)>; 3],
    /// Bodies of mass along the beam, each with the weld that holds it.
    pub(super) masses: Vec<(JointId, BodyId)>,
    /// A body without mass at the far end.
    pub(super) end: (JointId, BodyId),
    /// One at each point that the author wrote.
    pub(super) sections: Vec<(JointId, BodyId)>,
}
