//! [`Channels`]: inputs, outputs and states of linear equations, by name.

use bksim_model::Model;

use crate::quantity::PoseQuantity;

/// The quantities that a linear system is asked for in.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Channels {
    /// Parameters (`u`), or measures that an effort works on: `crank.angle` for a torque on the crank.
    pub inputs: Vec<String>,
    /// Measures: positions, angles, their rates; components of reactions, `reactions.A.fx`.
    pub outputs: Vec<String>,
    /// Measures whose deviations are the states; coordinates of the mechanism where there are none.
    pub states: Vec<String>,
}

impl Channels {
    /// These, with the inputs and outputs that the model states where none are named.
    #[must_use]
    pub fn or_stated(&self, model: &Model) -> Self {
        let or = |named: &[String], stated: &[String]| {
            if named.is_empty() { stated.to_vec() } else { named.to_vec() }
        };
        Self {
            inputs: or(&self.inputs, &model.io.inputs),
            outputs: or(&self.outputs, &model.io.outputs),
            states: self.states.clone(),
        }
    }
}

/// An input of a linear system.
pub(crate) enum Input {
    Parameter(usize),
    Effort(PoseQuantity),
}
