//! The gradient of a number that a whole motion makes, by the adjoint method: the run again, and back along it.

use bksim::dae::Control;
use bksim::record::weight_columns as columns_of;
use bksim::sim::run::{Failure, Sample};
use bksim::sim::sensitivity::{
    GradientPlan, SampleWeights, Sensitive, diagnose_sensitivity, plan_gradient_by_some,
};
use bksim::sim::start::Start;
use bksim::{Mechanism, Rejected, Simulation};
use numpy::PyReadonlyArray2;
use numpy::ndarray::{ArrayView1, ArrayView2};
use pyo3::prelude::*;

use crate::engine::Engine;
use crate::fault::{Fault, guard};
use crate::interrupt::Interruption;
use crate::solution::{Ending, Run};

/// Names of everything in a sample that a number may depend on.
#[pyfunction]
pub(crate) fn weight_columns(py: Python<'_>, engine: Py<Engine>) -> PyResult<Vec<String>> {
    guard(py, || Ok(columns_of(&engine.get().mechanism())))
}

/// The derivatives of a number by the quantities of these names, or by all that have one. `weights` are the
/// derivatives of the number by some of [`weight_columns`]: a row for each, a value per sample.
#[pyfunction]
pub(crate) fn gradient_of(
    py: Python<'_>,
    run: Py<Run>,
    columns: Vec<usize>,
    weights: PyReadonlyArray2<'_, f64>,
    by: Option<Vec<String>>,
) -> PyResult<Vec<(String, f64)>> {
    let run = run.get();
    let instants = run.instants(py);
    let weights = weights.as_array();
    guard(py, || {
        check_whole(run)?;
        let goal = Goal { instants: &instants, columns: &columns, weights };
        gradient(run, &goal, by.as_deref())
    })
}

/// Refuses runs that cannot be repeated.
fn check_whole(run: &Run) -> Result<(), Fault> {
    if run.logged.is_some() {
        let words = "the motion comes from a log: solve its model again for a gradient";
        return Err(Fault::Log(words.to_owned()));
    }
    if !matches!(run.kept.ending, Ending::Reached) {
        let t = run.kept.summary.t;
        return Err(Fault::Value(format!(
            "the motion ended early, at t = {t} s: give a `t_end` that it reaches for a gradient"
        )));
    }
    Ok(())
}

/// A number that the samples of a run make, by its derivatives.
struct Goal<'a> {
    /// The samples.
    instants: &'a [f64],
    /// Places of what it depends on.
    columns: &'a [usize],
    /// A row for each of these, a value per sample.
    weights: ArrayView2<'a, f64>,
}

impl Goal<'_> {
    /// Derivatives of the goal by the parts of each sample, whose sizes are given; `None` where it does not depend on one.
    fn by_sample(&self, sizes: [usize; 5]) -> Vec<Option<SampleWeights>> {
        self.weights.columns().into_iter().map(|of_sample| self.split(of_sample, sizes)).collect()
    }

    fn split(&self, of_sample: ArrayView1<'_, f64>, sizes: [usize; 5]) -> Option<SampleWeights> {
        // What has no weight stays empty: accelerations, multipliers and channels cost work.
        let mut parts: [Vec<f64>; 5] = Default::default();
        for (&column, &weight) in self.columns.iter().zip(of_sample).filter(|(_, w)| **w != 0.0) {
            let mut place = column;
            for (part, size) in parts.iter_mut().zip(sizes) {
                if place < size {
                    part.resize(size, 0.0);
                    part[place] += weight;
                    break;
                }
                place -= size;
            }
        }
        if parts.iter().all(Vec::is_empty) {
            return None;
        }
        let [q, v, a, lambda, channels] = parts;
        Some(SampleWeights { q, v, a, lambda, channels })
    }

    /// True of the samples that it was made for.
    fn is_of(&self, samples: &[Sample]) -> bool {
        samples.iter().map(|sample| sample.t).eq(self.instants.iter().copied())
            && self.weights.ncols() == samples.len()
    }
}

fn gradient(
    run: &Run,
    goal: &Goal<'_>,
    by: Option<&[String]>,
) -> Result<Vec<(String, f64)>, Fault> {
    // The run as it was.
    let engine = run.engine.get();
    let mut simulation = engine.simulation.clone();
    let start = engine.start()?;
    simulation.set_options(&run.kept.options);
    let mechanism = simulation.mechanism();
    let Some(plan) = planned(engine, (&simulation, &mechanism), start, by)? else {
        return Ok(Vec::new());
    };

    // Run and come back, until Python wants it to stop.
    let (nq, nc) = (mechanism.compiled.nq(), mechanism.compiled.nc());
    let n_channels = columns_of(&mechanism).len() - (3 * nq + nc);
    let sizes = [nq, nq, nq, nc, n_channels];
    let interruption = Interruption::new(None);
    let stop = || interruption.is_wished(start.t);
    let mut watch = |_: &Sample| if stop() { Control::Stop } else { Control::Continue };
    let mut is_repeated = true;
    let mut by_sample = |samples: &[Sample]| {
        is_repeated = goal.is_of(samples);
        // Without weights the way back is short.
        if is_repeated { goal.by_sample(sizes) } else { Vec::new() }
    };
    let outcome = simulation.gradient(start, &plan, &mut watch, &mut by_sample, &stop);

    // Tell what came of it.
    if let Some(error) = interruption.raised() {
        return Err(Fault::Python(error));
    }
    let found = outcome.map_err(|failure| stopped(engine, &simulation, &failure))?;
    let internal = |words: &str| Fault::Internal(words.to_owned());
    let found = found.ok_or_else(|| internal("a gradient was stopped by nobody"))?;
    if !is_repeated {
        return Err(internal("the run has other samples when it is repeated"));
    }
    let names = plan.sensitive().iter().map(|by| by.name(&mechanism.model).to_owned());
    Ok(names.zip(found.by).collect())
}

fn stopped(engine: &Engine, simulation: &Simulation, failure: &Failure) -> Fault {
    let t = failure.no_sensitivity.map_or(failure.summary.t, |fault| fault.t);
    Fault::motion(engine.source(), t, &simulation.diagnose(failure))
}

/// The plan for the quantities of these names, or for all that have a derivative; none where there are none.
fn planned(
    engine: &Engine,
    (simulation, mechanism): (&Simulation, &Mechanism),
    start: &Start,
    by: Option<&[String]>,
) -> Result<Option<GradientPlan>, Fault> {
    let refused = |Rejected(faults)| Fault::model(engine.source(), &faults);
    let Mechanism { model, system, compiled, parameters, .. } = mechanism;
    if let Some(names) = by {
        let sensitive = mechanism.all_sensitive(names).map_err(refused)?;
        let plan = || simulation.plan_gradient(start, &sensitive).map_err(refused);
        return (!sensitive.is_empty()).then(plan).transpose();
    }
    let initial = (0..model.initial.len()).filter(|&k| !model.initial[k].is_guess);
    let all = (0..model.parameters.len()).map(Sensitive::Parameter);
    let all: Vec<Sensitive> = all.chain(initial.map(Sensitive::Initial)).collect();
    if all.is_empty() {
        return Ok(None);
    }
    let (plan, _) =
        plan_gradient_by_some(model, system, compiled, (start, parameters), (&all, &[]))
            .map_err(|error| refused(Rejected(vec![diagnose_sensitivity(model, &error)])))?;
    Ok((!plan.sensitive().is_empty()).then_some(plan))
}
