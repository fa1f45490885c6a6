//! A run of the integrator under Python: Ctrl-C stops it, and everything so far is kept.

use std::cell::Cell;

use bksim::dae::Control;
use bksim::log::Field;
use bksim::model::{Outputs, SolveOptions};
use bksim::options::{BadOption, FORMULATIONS, METHODS, SolveChanges, choice};
use bksim::record::{Channels, sensitivity_columns, sensitivity_row};
use bksim::sim::run::{Failure, Observer, Sample, Segment, Summary};
use bksim::sim::sensitivity::{Sensitive, StateSensitivity};
use bksim::sim::start::Start;
use bksim::{Rejected, SensitivityPlan, Simulation};
use pyo3::prelude::*;

use crate::arrays::{table, transposed, vector};
use crate::engine::Engine;
use crate::fault::{Fault, guard};
use crate::interrupt::Interruption;
use crate::laws;
use crate::solution::{Ending, Kept, Run};

/// The request of a run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RunRequest {
    t_end: Option<f64>,
    rtol: Option<f64>,
    atol: Option<f64>,
    step: Option<f64>,
    every: Option<f64>,
    times: Option<Vec<f64>>,
    method: Option<String>,
    formulation: Option<String>,
    /// Joints that yield, each by name and stiffness.
    compliance: Vec<(String, String)>,
    /// Names that the motion is differentiated by.
    sensitivity: Vec<String>,
    /// Whether the motion between samples is kept.
    dense: bool,
    /// Most bytes of samples and motion.
    most_bytes: usize,
    /// Told the time that is reached, s, now and then.
    notify: Option<Py<PyAny>>,
}

impl RunRequest {
    /// The options of the model with what is asked for.
    fn options(&self, engine: &Engine) -> Result<SolveOptions, Fault> {
        let mut options = changed(engine, self.changes()?)?;
        if let Some(times) = &self.times {
            let [first, last] =
                [options.t_start.min(options.t_end), options.t_start.max(options.t_end)];
            if let Some(t) = times.iter().find(|t| !(first..=last).contains(t)) {
                let words = format!("times: {t} s is outside of the run, {first} s to {last} s");
                return Err(Fault::Value(words));
            }
            options.outputs = Outputs::Times(times.clone());
        }
        Ok(options)
    }

    fn changes(&self) -> Result<SolveChanges, Fault> {
        Ok(SolveChanges {
            t_end: self.t_end,
            rtol: self.rtol,
            atol: self.atol,
            step: self.step,
            every: self.every,
            method: chosen("method", &METHODS, self.method.as_deref())?,
            formulation: chosen("formulation", &FORMULATIONS, self.formulation.as_deref())?,
            jit: None,
        })
    }
}

/// The options of the model with some changes.
pub(crate) fn changed(engine: &Engine, changes: SolveChanges) -> Result<SolveOptions, Fault> {
    let mut options = engine.simulation.options().clone();
    changes.check(options.t_start).map_err(|bad: BadOption| Fault::Value(bad.to_string()))?;
    changes.apply(&mut options);
    Ok(options)
}

/// The choice that a word stands for.
pub(crate) fn chosen<T: Copy>(
    option: &str,
    words: &[(&'static str, T)],
    word: Option<&str>,
) -> Result<Option<T>, Fault> {
    let Some(word) = word else { return Ok(None) };
    let known: Vec<_> = words.iter().map(|(word, _)| format!("{word:?}")).collect();
    let unknown = || Fault::Value(format!("{option} = {word:?} is none of {}", known.join(", ")));
    choice(words, word).map(Some).ok_or_else(unknown)
}

/// Keeps samples and motion.
struct Keeping<'a> {
    channels: &'a Channels,
    reached: &'a Cell<f64>,
    t: Vec<f64>,
    values: Vec<f64>,
    segments: Vec<Segment>,
    /// The first sample.
    like: Option<Sample>,
    is_dense: bool,
    n_bytes: usize,
    most_bytes: usize,
    /// A step may have more samples in it than anybody waits for.
    is_stop_wished: &'a dyn Fn() -> bool,
}

impl Keeping<'_> {
    fn is_full(&self) -> bool {
        self.n_bytes > self.most_bytes
    }
}

impl Observer for Keeping<'_> {
    fn sample(&mut self, sample: &Sample, by: &[StateSensitivity]) -> Control {
        let n_before = self.values.len();
        self.t.push(sample.t);
        self.channels.append_row(sample, &mut self.values);
        self.values.extend(by.iter().flat_map(sensitivity_row));
        self.n_bytes += size_of::<f64>() * (1 + self.values.len() - n_before);
        self.reached.set(sample.t);
        self.like.get_or_insert_with(|| sample.clone());
        let is_over = self.is_full() || (self.is_stop_wished)();
        if is_over { Control::Stop } else { Control::Continue }
    }

    fn wants_segments(&self) -> bool {
        self.is_dense
    }

    fn segment(&mut self, segment: &Segment) {
        self.n_bytes += size_of::<Segment>() + size_of_val(segment.values.as_slice());
        self.segments.push(segment.clone());
    }
}

/// Solves; what the run has left also tells when it ended early.
#[pyfunction]
pub(crate) fn solve(py: Python<'_>, engine: Py<Engine>, wanted: RunRequest) -> PyResult<Run> {
    let engine = if wanted.compliance.is_empty() {
        engine
    } else {
        let yielding = guard(py, || engine.get().yielding(wanted.compliance.clone()))?;
        Py::new(py, yielding)?
    };
    let (t, values, kept) = guard(py, || ran(engine.get(), &wanted))?;
    Ok(Run::new(engine, vector(py, t).unbind(), table(py, values).unbind(), kept))
}

type Ran = (Vec<f64>, numpy::ndarray::Array2<f64>, Kept);

fn ran(engine: &Engine, wanted: &RunRequest) -> Result<Ran, Fault> {
    // What to run, from where.
    let options = wanted.options(engine)?;
    let n_expected = expected(engine, &options, wanted.most_bytes)?;
    let mut simulation = engine.simulation.clone();
    let start = engine.start()?;
    simulation.set_options(&options);
    let (sensitive, derivatives, plan) = planned(engine, &simulation, start, &wanted.sensitivity)?;

    let inputs = remembering(&simulation, start, None)?;

    // Run, keeping everything, until Python wants it to stop.
    let n_columns = engine.channels().n_columns() + derivatives.len();
    let reached = Cell::new(start.t);
    let interruption = Interruption::new(wanted.notify.as_ref());
    let stop = || interruption.is_wished(reached.get());
    let mut keeping = Keeping {
        channels: engine.channels(),
        reached: &reached,
        t: Vec::with_capacity(n_expected),
        values: Vec::with_capacity(n_expected * n_columns),
        segments: Vec::new(),
        like: None,
        is_dense: wanted.dense,
        n_bytes: 0,
        most_bytes: wanted.most_bytes,
        is_stop_wished: &stop,
    };
    let outcome = match &plan {
        None => simulation.run(start, &mut keeping, &stop),
        Some(plan) => simulation.run_with_sensitivities(start, plan, &mut keeping, &stop),
    };

    // Tell how it ended.
    let is_full = keeping.is_full();
    let raised = laws::raised().or_else(|| interruption.raised());
    let Keeping { t, values, segments, like, .. } = keeping;
    if raised.is_none() {
        remembering(&simulation, start, Some(&inputs))?;
    }
    let (summary, ending) = ended(&simulation, outcome, raised, is_full);
    let like = like.unwrap_or_default();
    let kept = Kept { options, summary, segments, ending, like, sensitive, derivatives };
    Ok((t, transposed(&values, n_columns), kept))
}

/// The values of the inputs at the start. Refuses laws that remember what they were asked before: their
/// values there are compared before and after another state, and with those `before` the run.
pub(crate) fn remembering(
    simulation: &Simulation,
    start: &Start,
    before: Option<&[f64]>,
) -> Result<Vec<f64>, Fault> {
    /// How far the other state is, as a part of the run, rad and m.
    const AWAY: f64 = 0.01;
    let Start { t, q, v, .. } = start;
    let mechanism = simulation.mechanism();
    if mechanism.model.inputs.is_empty() {
        return Ok(Vec::new());
    }
    let here = || simulation.input_values(*t, q, v);
    let first = here();
    if before.is_none() {
        let away = |values: &[f64]| values.iter().map(|x| x + AWAY).collect::<Vec<_>>();
        let later = t + AWAY * (simulation.options().t_end - t);
        simulation.input_values(later, &away(q), &away(v));
        // What it cannot do there is none of our business.
        let _ = laws::raised();
    }
    let again = here();
    let known = before.unwrap_or(&first);
    let pairs = known.iter().zip(&again).zip(&mechanism.model.inputs);
    for ((known, found), id) in pairs {
        if known.to_bits() != found.to_bits() {
            let name = &mechanism.model.parameters[id.0].name;
            return Err(Fault::Value(format!(
                "the input `{name}` is {known} and then {found} at the same t, q and v: it remembers what it \
                 was asked before, and the integrator asks at states that it only tries. Use \
                 bksim.Sampled(law, every=...), or let the value follow from t, q and v alone"
            )));
        }
    }
    Ok(first)
}

/// How a run went, and how it ended.
fn ended(
    simulation: &Simulation,
    outcome: Result<Summary, Box<Failure>>,
    raised: Option<PyErr>,
    is_full: bool,
) -> (Summary, Ending) {
    match (outcome, raised) {
        (Ok(summary), Some(error)) => (summary, Ending::Stopped(Some(error))),
        (Err(failure), Some(error)) => (failure.summary, Ending::Stopped(Some(error))),
        (Ok(summary), None) if summary.reached_end => (summary, Ending::Reached),
        (Ok(summary), None) if is_full => (summary, Ending::Full),
        (Ok(summary), None) => (summary, Ending::Stopped(None)),
        (Err(failure), None) => {
            let fault = simulation.diagnose(&failure);
            (failure.summary, Ending::Failed(fault))
        }
    }
}

/// About how many samples there will be, as far as it is worth to make room for them at once. Refuses a
/// run whose samples alone would take more than there may be.
fn expected(engine: &Engine, options: &SolveOptions, most: usize) -> Result<usize, Fault> {
    if options.outputs != Outputs::Even {
        return Ok(0);
    }
    let n_samples = (options.t_end - options.t_start).abs() / options.interval();
    #[expect(clippy::cast_precision_loss, reason = "an estimate")]
    let (per_sample, most) = ((1 + engine.channels().n_columns()) as f64 * 8.0, most as f64);
    if n_samples * per_sample <= most {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "few")]
        return Ok(n_samples.min(MOST_ROOM / per_sample) as usize + 2);
    }
    Err(Fault::Limit(format!(
        "{n_samples:.3e} samples would take {:.3e} bytes, more than the {most:.3e} of \
         `memory_limit`: raise it, or `every`",
        n_samples * per_sample
    )))
}

/// Beyond so many bytes of samples, room is made as they come: the run may end early.
const MOST_ROOM: f64 = 6.4e7;

/// Inputs that a run is differentiated by, the names of its derivatives, and its start.
type Planned = (Vec<Sensitive>, Vec<(String, Field)>, Option<SensitivityPlan>);

fn planned(
    engine: &Engine,
    simulation: &Simulation,
    start: &Start,
    names: &[String],
) -> Result<Planned, Fault> {
    if names.is_empty() {
        return Ok((Vec::new(), Vec::new(), None));
    }
    let refused = |Rejected(faults)| Fault::model(engine.source(), &faults);
    let mechanism = simulation.mechanism();
    let sensitive = mechanism.all_sensitive(names).map_err(refused)?;
    let plan = simulation.plan_sensitivities(start, &sensitive);
    let derivatives = sensitivity_columns(&mechanism, &sensitive);
    Ok((sensitive, derivatives, Some(plan.map_err(refused)?)))
}
