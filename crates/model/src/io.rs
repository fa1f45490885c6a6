//! [`Io`]: what goes into a mechanism and comes out of it, for questions about its linear form and for code.

use crate::ids::JointId;
use crate::model::Model;

/// Names of inputs and outputs, which stand where a question names none.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Io {
    /// Parameters of loads, joints or positions that an effort works on.
    pub inputs: Vec<String>,
    /// Measures of positions and rates, and components of reactions.
    pub outputs: Vec<String>,
}

/// A component of the reaction on the second body of a joint.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ReactionComponent {
    /// The joint.
    pub joint: JointId,
    /// The place in fx, fy, fz, mx, my, mz.
    pub component: usize,
    /// True along the axes of the joint's first point, else along those of the world.
    pub is_in_joint: bool,
}

impl ReactionComponent {
    /// The component of `reactions.A.fx` or `reactions.A.fx_joint`; none where the model has no such joint.
    pub fn named(model: &Model, name: &str) -> Option<Self> {
        let (joint, word) = name.strip_prefix("reactions.")?.rsplit_once('.')?;
        let joint = JointId(model.joints.iter().position(|of| of.name == joint)?);
        let is_in_joint = word.ends_with("_joint");
        let word = word.strip_suffix("_joint").unwrap_or(word);
        let component = ["fx", "fy", "fz", "mx", "my", "mz"].iter().position(|w| *w == word)?;
        Some(Self { joint, component, is_in_joint })
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        if self.component < 3 { "N" } else { "N m" }
    }
}
