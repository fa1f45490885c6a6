//! Gradients: the derivatives of one number by many parameters and stated initial values, back along the motion.
//!
//! ```text
//! F(t, q, v, z, p) = 0          M a + Gᵀ λ − f and G a + γ, with z = (a, λ)
//! dJ = Σ weights · d(samples)   the goal J, of what a run shows
//! α′ = −Kᵀ β,  β′ = −α − Cᵀ β   costates: the derivatives of J by q and v, from the end to the start
//! ρ = −β·(F_z⁻¹)_a              what a load on each row of F does to J
//! dJ/dp = α·q_p + β·v_p at the start + ∫ ρ·F_p dt
//! ```
//!
//! A sample adds its weights to the costates, and an event turns them by the transpose of what it does to changes of the
//! state ([`saltation`](super::saltation)). The cost is that of a few runs, by one quantity or by a hundred; F_p is never
//! formed, as ρ·F_p is one backward sweep. Sources: Y. Cao, S. Li, L. Petzold and R. Serban, SIAM J. Sci. Comput. 24
//! (2003); for events E. Rozenvasser, *General sensitivity equations of discontinuous systems*, Autom. Remote Control 28
//! (1967), transposed.

mod backward;
mod equations;
mod phase;
mod recording;

use bksim_dae::Control;

use crate::run::{Failure, NoSensitivity, Observer, Problem, Sample, Summary, Undefined, run};
use backward::Backward;
pub use equations::{GradientPlan, plan_gradient, plan_gradient_by_some};
use recording::Recording;

/// Derivatives of a goal by everything that one sample shows.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct SampleWeights {
    /// By the coordinates, nq.
    pub q: Vec<f64>,
    /// By the velocities, nq.
    pub v: Vec<f64>,
    /// By the accelerations, nq.
    pub a: Vec<f64>,
    /// By the multipliers, nc.
    pub lambda: Vec<f64>,
    /// By the channels that [`channels`](super::channels) lists.
    pub channels: Vec<f64>,
}

/// A goal of a run: the derivatives of a number by everything that the samples show, one entry for each of them; none for
/// those on which it does not depend.
pub type Goal<'g> = dyn FnMut(&[Sample]) -> Vec<Option<SampleWeights>> + 'g;

/// Several goals of one run, each as a [`Goal`].
pub type Goals<'g> = dyn FnMut(&[Sample]) -> Vec<Vec<Option<SampleWeights>>> + 'g;

/// The gradient of a goal.
#[derive(Clone, PartialEq, Debug)]
pub struct Gradient {
    /// By quantity, in the order of the plan, in units of the goal over those of the quantity.
    pub by: Vec<f64>,
    /// The run.
    pub summary: Summary,
    /// Steps of the costates.
    pub n_steps_back: usize,
}

/// Runs from the start, asks for the goal, and goes back along the motion; `stop` is asked after every step in both
/// directions. `None` where it wished to stop.
///
/// # Errors
/// [`Failure`] when the integrator cannot go on, or where the motion has no derivative.
pub fn gradient(
    problem: Problem<'_>,
    plan: &GradientPlan,
    observer: &mut dyn Observer,
    goal: &mut Goal<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Gradient>, Box<Failure>> {
    let mut one = |samples: &[Sample]| vec![goal(samples)];
    let found = gradients(problem, plan, observer, &mut one, stop)?;
    Ok(found.and_then(|mut found| found.pop()))
}

/// Gradients ([`gradient`]) of several goals: one run, and a way back for each.
///
/// # Errors
/// [`Failure`] as for one.
pub fn gradients(
    problem: Problem<'_>,
    plan: &GradientPlan,
    observer: &mut dyn Observer,
    goals: &mut Goals<'_>,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Vec<Gradient>>, Box<Failure>> {
    let mut recording = Recording::new(observer);
    let summary = run(problem, &mut recording, stop)?;
    let Recording { pieces, samples, is_full, .. } = recording;
    let failure = |fault: NoSensitivity, summary: Summary| {
        let last = samples.last().cloned().unwrap_or_default();
        let no_sensitivity = Some(fault);
        Box::new(Failure {
            error: None,
            no_modes: None,
            no_sensitivity,
            start: None,
            summary,
            last,
        })
    };
    if is_full {
        return Err(failure(NoSensitivity { t: summary.t, why: Undefined::Room }, summary));
    }
    if !summary.reached_end {
        return Ok(None);
    }
    let mut found = Vec::new();
    for weights in goals(&samples) {
        // What no sample has a part in needs no way back.
        if weights.iter().all(Option::is_none) {
            let by = vec![0.0; plan.sensitive().len()];
            found.push(Gradient { by, summary: summary.clone(), n_steps_back: 0 });
            continue;
        }
        let mut backward = Backward::new(problem, plan);
        match backward.go(&pieces, (&samples, &weights), stop) {
            Err(fault) => return Err(failure(fault, summary)),
            Ok(Control::Stop) => return Ok(None),
            Ok(Control::Continue) => {
                let (by, n_steps_back) = (backward.gradient(), backward.n_steps());
                found.push(Gradient { by, summary: summary.clone(), n_steps_back });
            }
        }
    }
    Ok(Some(found))
}
