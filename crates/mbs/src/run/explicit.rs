//! The motion as an ordinary differential equation: accelerations from the multiplier system, the
//! constraints kept by projection.
//!
//! ```text
//! y = (q, v, W)      q′ = v,  v′ = a(t, q, v) of the multiplier system,  W′ = P
//! ```
//!
//! W, the work of loads and drives, rides along with the accuracy of the method and without a part
//! in its error control. Projection after every step: E. Eich, *Convergence results for a
//! coordinate projection method applied to mechanical systems with algebraic constraints*, SIAM
//! J. Numer. Anal. 30 (1993).

use bksim_dae::{Index, Layout, NotFinite, Ode, Settings, StepControl, Tolerance};

use crate::compile::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::model::SolveOptions;
use crate::multiplier::MultiplierSystem;

/// A mechanism as y′ = f(t, y).
pub(crate) struct ExplicitMotion<'a> {
    evaluator: Evaluator<'a>,
    pub(crate) multipliers: MultiplierSystem,
    /// The least weakness of the stages since it was last looked at.
    pub(crate) weakest: f64,
    layout: Layout,
    lambda: Vec<f64>,
}

/// The integrator is asked for this part of the tolerance: what it keeps below is the error of a
/// step in the mean over the unknowns, what is asked of it is the error of the run in each. A step
/// of order eight grows only by 1.8 for it.
const SAFETY: f64 = 0.01;

impl<'a> ExplicitMotion<'a> {
    /// The motion at one set of parameters, its accelerations from these multiplier systems.
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        multipliers: MultiplierSystem,
    ) -> Self {
        let quantities = &compiled.coordinates;
        let names = quantities.iter().map(|c| c.name.clone());
        let rates = quantities.iter().map(|c| format!("{}_dot", c.name));
        let names = names.chain(rates).chain(["work".to_owned()]).collect();
        Self {
            evaluator: compiled.evaluator(parameters),
            multipliers,
            weakest: 1.0,
            layout: Layout::from_groups(&[(2 * compiled.nq() + 1, Index::One)]).with_names(names),
            lambda: vec![0.0; compiled.nc()],
        }
    }

    /// The integrator's settings for a model's options.
    pub(crate) fn settings(options: &SolveOptions, nq: usize) -> Settings {
        let rtol = (SAFETY * options.rtol).max(1e-14);
        let mut atol = vec![SAFETY * options.atol; 2 * nq];
        // Not controlled.
        atol.push(f64::MAX.sqrt());
        let step = match options.step {
            None => StepControl::Adaptive,
            Some(h) => StepControl::Fixed { h, newton_tolerance: options.newton_tolerance },
        };
        Settings { rtol, atol: Tolerance::PerUnknown(atol), step, ..Settings::default() }
    }
}

impl Ode for ExplicitMotion<'_> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        let Self { evaluator, multipliers, weakest, lambda, .. } = self;
        let nq = (y.len() - 1) / 2;
        let (q, v) = y[..2 * nq].split_at(nq);
        let (qdot, rest) = ydot.split_at_mut(nq);
        let (vdot, power) = rest.split_at_mut(nq);
        qdot.copy_from_slice(v);
        let solved = multipliers.limit_into(evaluator, t, (q, v), vdot, lambda);
        solved.map_err(|NotFinite { row }| NotFinite { row: nq + row.min(nq) })?;
        *weakest = weakest.min(multipliers.weakness());
        power[0] = evaluator.power(t, q, v, lambda);
        Ok(())
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<(), NotFinite> {
        // What a step leaves open is so small that one Newton step with the factors of the last
        // stage closes it to rounding, but for long steps.
        const CLOSED: f64 = 1e-11;
        const MAX_PASSES: usize = 3;
        let nq = (y.len() - 1) / 2;
        let (q, rest) = y.split_at_mut(nq);
        let v = &mut rest[..nq];
        let size = q.iter().fold(1.0, |size: f64, q| size.max(q.abs()));
        for _ in 0..MAX_PASSES {
            let drift = self.multipliers.project(&mut self.evaluator, t, (&mut *q, &mut *v), 1);
            if drift.position[1].is_nan() || drift.velocity[1].is_nan() {
                return Err(NotFinite { row: 0 });
            }
            let has_gained = drift.position[1] < drift.position[0];
            if drift.position[1] <= CLOSED * size || !has_gained {
                break;
            }
        }
        Ok(())
    }
}
