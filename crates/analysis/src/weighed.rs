//! [`Weighed`]: the derivatives of several numbers of a run, each of which depends on many quantities of its samples.

use std::cell::Cell;

use bksim_dae::Control;
use bksim_model::diagnostic::Rejected;
use bksim_sim::hybrid::Passage;
use bksim_sim::run::{Observer, Sample, StateSensitivity};
use bksim_sim::sensitivity::{GradientPlan, SampleWeights, diagnose_sensitivity, plan_gradient};
use bksim_sim::start::Start;
use bksim_sim::{Mechanism, Simulation};

use crate::error::AnalysisError;
use crate::goal::Goal;

/// Weights of quantities in the samples of a run: by number, by sample, by quantity.
pub type Weights<'w> = dyn FnMut(&[Sample]) -> Vec<Vec<Vec<f64>>> + 'w;

/// Quantities of a run by which numbers of it have derivatives, and the equations of these by some parameters and initial
/// values: one serves all values of the parameters.
#[derive(Clone, Debug)]
pub struct Weighed {
    goals: Vec<Goal>,
    plan: GradientPlan,
}

impl Weighed {
    /// Quantities of any names that [`GradientRequest::of`](crate::GradientRequest::of) takes, by parameters and stated initial
    /// values.
    ///
    /// # Errors
    /// [`AnalysisError`] when nothing with a derivative has one of the names, or there is none by one of the others.
    pub fn named(
        (simulation, start): (&Simulation, &Start),
        names: &[String],
        by: &[String],
    ) -> Result<Self, AnalysisError> {
        let mechanism = simulation.mechanism();
        let by = mechanism.all_sensitive(by)?;
        let (goals, more) = Goal::all(&mechanism, names)?;
        let Mechanism { model, system, compiled, parameters, .. } = &mechanism;
        let plan = plan_gradient(model, system, compiled, (start, parameters), (&by, &more))
            .map_err(|error| Rejected(vec![diagnose_sensitivity(model, &error)]))?;
        Ok(Self { goals, plan })
    }

    /// These for another run; `None` where its equations have to be made again, or it has no derivatives.
    pub fn at(&self, (simulation, start): (&Simulation, &Start)) -> Option<Self> {
        let plan = self.plan.at(simulation.compiled(), (start, simulation.parameters()))?;
        Some(Self { goals: self.goals.clone(), plan })
    }

    /// The derivatives of each number by each quantity, one run and a way back for each number; `None` where `stop` wished to
    /// stop, and where the run passes an event: what jumps there is in the number by its instant, too, which moves.
    ///
    /// # Errors
    /// [`AnalysisError`] where the run ends early, or there is no derivative.
    pub fn slopes(
        &self,
        (simulation, start): (&Simulation, &Start),
        weigh: &mut Weights<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Vec<Vec<f64>>>, AnalysisError> {
        let sample = |weights: Vec<f64>| {
            let mut all = SampleWeights::default();
            let own = self.goals.iter().zip(weights).filter(|(_, weight)| *weight != 0.0);
            own.for_each(|(goal, weight)| goal.weigh(weight, &mut all));
            (all != SampleWeights::default()).then_some(all)
        };
        let has_events = Cell::new(false);
        let mut goals = |samples: &[Sample]| {
            let numbers = if has_events.get() { Vec::new() } else { weigh(samples) }.into_iter();
            numbers.map(|number| number.into_iter().map(sample).collect()).collect()
        };
        let found = simulation
            .gradients(start, &self.plan, &mut Events(&has_events), &mut goals, stop)
            .map_err(|failure| Rejected(vec![simulation.diagnose(&failure)]))?;
        let found = found.filter(|_| !has_events.get());
        Ok(found.map(|found| found.into_iter().map(|gradient| gradient.by).collect()))
    }
}

/// Observer of whether a run passes an event.
struct Events<'a>(&'a Cell<bool>);

impl Observer for Events<'_> {
    fn sample(&mut self, _: &Sample, _: &[StateSensitivity]) -> Control {
        Control::Continue
    }

    fn passage(&mut self, _: &Passage) {
        self.0.set(true);
    }
}
