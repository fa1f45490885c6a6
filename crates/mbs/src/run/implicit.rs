//! Radau's settings for a run.

use bksim_dae::{Settings, StepControl};

use crate::formulate::MotionEquations;
use crate::model::SolveOptions;

/// The integrator's settings for a model's options.
pub(crate) fn settings(options: &SolveOptions, equations: &MotionEquations) -> Settings {
    Settings {
        rtol: options.rtol,
        atol: equations.tolerances(options.atol),
        step: match options.step {
            None => StepControl::Adaptive,
            Some(h) => StepControl::Fixed { h, newton_tolerance: options.newton_tolerance },
        },
        ..Settings::default()
    }
}
