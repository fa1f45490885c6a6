//! Derivatives of the motion: forward with it, by few quantities, or back along it, of one number by many.

use bksim_dae::Control;
use bksim_model::diagnostic::Rejected;

use super::{Motion, SensitivityMotion, Simulation};
use crate::mechanism::{Mechanism, insensitive};
use crate::run::{Failure, Observer, Sample, Summary, WithSensitivities};
use crate::sensitivity::{
    self, Goal, Goals, Gradient, GradientPlan, Sensitive, SensitivityPlan, StateSensitivity,
    differentiate, run_with_sensitivities,
};
use crate::start::Start;

impl Simulation {
    /// Run ([`Simulation::run`]) whose samples have their sensitivities.
    ///
    /// # Errors
    /// [`Failure`] when the integrator cannot go on; see [`Simulation::diagnose`].
    pub fn run_with_sensitivities(
        &self,
        start: &Start,
        plan: &SensitivityPlan,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<Summary, Box<Failure>> {
        let start = self.beginning(start)?;
        run_with_sensitivities(self.problem(&start), plan, observer, stop)
    }

    /// The differentiated equations, and the sensitivities of the start.
    ///
    /// # Errors
    /// [`Rejected`] when there are none, as where no motion exists for other values near these.
    pub fn plan_sensitivities(
        &self,
        start: &Start,
        sensitive: &[Sensitive],
    ) -> Result<SensitivityPlan, Rejected> {
        let Mechanism { model, system, compiled, parameters, .. } = &self.mechanism();
        let options = &self.options;
        let plan = || {
            let equations = differentiate(model, system, compiled, options, sensitive, parameters)?;
            let start = sensitivity::start(&equations, model, compiled, start, parameters)?;
            Ok(SensitivityPlan { equations, start })
        };
        plan().map_err(|error| insensitive(model, &error))
    }

    /// The equations along weights, and the sensitivities of the start.
    ///
    /// # Errors
    /// [`Rejected`] as [`Simulation::plan_sensitivities`].
    pub fn plan_gradient(
        &self,
        start: &Start,
        sensitive: &[Sensitive],
    ) -> Result<GradientPlan, Rejected> {
        let Mechanism { model, system, compiled, parameters, .. } = &self.mechanism();
        let plan = sensitivity::plan_gradient(
            model,
            system,
            compiled,
            (start, parameters),
            (sensitive, &[]),
        );
        plan.map_err(|error| insensitive(model, &error))
    }

    /// Run ([`Simulation::run`]) and the way back along the motion for the gradient of `goal` by all quantities of the plan; `None`
    /// where `stop` wished to stop.
    ///
    /// # Errors
    /// [`Failure`] when the integrator cannot go on, or the motion has no derivative; see [`Simulation::diagnose`].
    pub fn gradient(
        &self,
        start: &Start,
        plan: &GradientPlan,
        observer: &mut dyn Observer,
        goal: &mut Goal<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Gradient>, Box<Failure>> {
        let start = self.beginning(start)?;
        sensitivity::gradient(self.problem(&start), plan, observer, goal, stop)
    }

    /// Gradients ([`Simulation::gradient`]) of several goals of one run.
    ///
    /// # Errors
    /// [`Failure`] as for one.
    pub fn gradients(
        &self,
        start: &Start,
        plan: &GradientPlan,
        observer: &mut dyn Observer,
        goals: &mut Goals<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Vec<Gradient>>, Box<Failure>> {
        let start = self.beginning(start)?;
        sensitivity::gradients(self.problem(&start), plan, observer, goals, stop)
    }

    /// Finds the start, runs to the end and keeps every sample with its derivatives by `sensitive`.
    ///
    /// # Errors
    /// [`Rejected`] when there is no consistent start, none near it, or the run stops early.
    pub fn sensitivities(&self, sensitive: &[Sensitive]) -> Result<SensitivityMotion, Rejected> {
        let start = self.start()?;
        let plan = self.plan_sensitivities(&start, sensitive)?;
        let (mut samples, mut sensitivities) = (Vec::new(), Vec::new());
        let mut keep = WithSensitivities(|sample: &Sample, by: &[StateSensitivity]| {
            samples.push(sample.clone());
            sensitivities.push(by.to_vec());
            Control::Continue
        });
        let summary = self
            .run_with_sensitivities(&start, &plan, &mut keep, &|| false)
            .map_err(|failure| Rejected(vec![self.diagnose(&failure)]))?;
        Ok(SensitivityMotion { motion: Motion { start, samples, summary }, sensitivities })
    }
}
