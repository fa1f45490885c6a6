//! Radau's settings for a run.

use bksim_dae::{ErrorTest, NewtonSettings, Settings, StepControl};

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
        // Multipliers feel a change of contact or a weak pose before positions do.
        error_test: ErrorTest::All,
        newton: NewtonSettings { keep_jacobian_below: Some(1e-3), ..NewtonSettings::default() },
        ..Settings::default()
    }
}
