//! A run of the integrator under Python: Ctrl-C stops it, and everything so far is kept.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use bksim::dae::Control;
use bksim::log::Field;
use bksim::model::{Outputs, SolveOptions};
use bksim::options::{BadOption, FORMULATIONS, METHODS, SolveChanges, choice};
use bksim::record::{Channels, sensitivity_columns, sensitivity_row};
use bksim::sim::run::{self, Failure, Observer, Problem, Sample, Segment};
use bksim::sim::sensitivity::{Sensitive, StateSensitivity, run_with_sensitivities};
use bksim::sim::start::Start;
use bksim::{Rejected, SensitivityPlan};
use pyo3::prelude::*;

use crate::arrays::{table, transposed, vector};
use crate::engine::Engine;
use crate::fault::{Fault, guard};
use crate::laws;
use crate::solution::{Ending, Kept, Run};

/// How often Python is asked whether to go on: Ctrl-C is to work within a fifth of a second.
pub(crate) const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Tells when [`LOOK_EVERY`] has gone by. It is asked at every step, which may take less than to ask
/// the clock: as long as many calls fit, most go by without.
struct Pace {
    /// When the clock was asked last.
    asked: Cell<Instant>,
    /// When it was time last.
    due: Cell<Instant>,
    /// Calls between two questions, and those that are left.
    stride: Cell<u32>,
    left: Cell<u32>,
}

impl Pace {
    /// So that steps which suddenly are slow cost no more than as many.
    const LONGEST: u32 = 32;

    fn begin() -> Self {
        let now = Instant::now();
        let [asked, due] = [now; 2].map(Cell::new);
        Self { asked, due, stride: Cell::new(1), left: Cell::new(0) }
    }

    fn is_due(&self) -> bool {
        if let Some(left) = self.left.get().checked_sub(1) {
            self.left.set(left);
            return false;
        }
        let now = Instant::now();
        let taken = now.duration_since(self.asked.replace(now));
        let stride = self.stride.get();
        let stride = if taken < LOOK_EVERY / 16 { stride * 2 } else { stride / 4 };
        self.stride.set(stride.clamp(1, Self::LONGEST));
        self.left.set(self.stride.get() - 1);
        let is_due = now.duration_since(self.due.get()) >= LOOK_EVERY;
        if is_due {
            self.due.set(now);
        }
        is_due
    }
}

/// What a run is asked for.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Wanted {
    t_end: Option<f64>,
    rtol: Option<f64>,
    atol: Option<f64>,
    step: Option<f64>,
    every: Option<f64>,
    times: Option<Vec<f64>>,
    method: Option<String>,
    formulation: Option<String>,
    /// What the motion is differentiated by.
    sensitivity: Vec<String>,
    /// Whether the motion between samples is kept.
    dense: bool,
    /// Most bytes of samples and motion.
    most_bytes: usize,
    /// Told the time that is reached, s, now and then.
    notify: Option<Py<PyAny>>,
}

impl Wanted {
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

pub(crate) fn solve(py: Python<'_>, engine: Py<Engine>, wanted: Wanted) -> PyResult<Run> {
    let ran = guard(py, || ran(engine.get(), &wanted))?;
    let (t, values, kept) = ran;
    Ok(Run::new(engine, vector(py, t).unbind(), table(py, values).unbind(), kept))
}

type Ran = (Vec<f64>, numpy::ndarray::Array2<f64>, Kept);

fn ran(engine: &Engine, wanted: &Wanted) -> Result<Ran, Fault> {
    let mut options = engine.options.clone();
    let changes = wanted.changes()?;
    changes.check(options.t_start).map_err(|bad: BadOption| Fault::Value(bad.to_string()))?;
    changes.apply(&mut options);
    if let Some(times) = &wanted.times {
        let [first, last] =
            [options.t_start.min(options.t_end), options.t_start.max(options.t_end)];
        if let Some(t) = times.iter().find(|t| !(first..=last).contains(t)) {
            let words = format!("times: {t} s is outside of the run, {first} s to {last} s");
            return Err(Fault::Value(words));
        }
        options.outputs = Outputs::Times(times.clone());
    }
    let n_expected = expected(engine, &options, wanted.most_bytes)?;
    if !wanted.sensitivity.is_empty() && wanted.method.as_deref() == Some("explicit") {
        let words = "sensitivities are integrated by Radau IIA: leave method = \"explicit\" out";
        return Err(Fault::Value(words.to_owned()));
    }
    let start = engine.start()?;
    let equations = engine.equations(options.formulation)?;
    let (sensitive, derivatives, plan) = planned(engine, start, &options, &wanted.sensitivity)?;

    let reached = Cell::new(start.t);
    let pace = Pace::begin();
    let raised: RefCell<Option<PyErr>> = RefCell::new(None);
    let is_stop_wished = || {
        if !pace.is_due() {
            return false;
        }
        let heard = Python::attach(|py| {
            py.check_signals()?;
            match &wanted.notify {
                Some(notify) => notify.call1(py, (reached.get(),)).map(drop),
                None => Ok(()),
            }
        });
        let is_wished = heard.is_err();
        if let Err(error) = heard {
            raised.replace(Some(error));
        }
        is_wished
    };
    let n_columns = engine.channels().n_columns() + derivatives.len();
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
        is_stop_wished: &is_stop_wished,
    };
    let problem = Problem {
        compiled: engine.compiled(),
        equations: &equations,
        start,
        parameters: &engine.parameters,
        options: &options,
    };
    let outcome = match &plan {
        None => run::run(problem, &mut keeping, &is_stop_wished),
        Some(plan) => run_with_sensitivities(problem, plan, &mut keeping, &is_stop_wished),
    };
    let is_full = keeping.is_full();
    let error = laws::raised().or_else(|| raised.take());
    let Keeping { t, values, segments, like, .. } = keeping;
    let values = transposed(&values, n_columns);
    let (summary, ending) = match (outcome, error) {
        (Ok(summary), Some(error)) => (summary, Ending::Stopped(Some(error))),
        (Err(failure), Some(error)) => (failure.summary, Ending::Stopped(Some(error))),
        (Ok(summary), None) if summary.reached_end => (summary, Ending::Reached),
        (Ok(summary), None) if is_full => (summary, Ending::Full),
        (Ok(summary), None) => (summary, Ending::Stopped(None)),
        (Err(failure), None) => {
            let fault = engine.mechanism().diagnose(&equations, &failure);
            let Failure { summary, .. } = *failure;
            (summary, Ending::Failed(fault))
        }
    };
    let like = like.unwrap_or_default();
    let kept = Kept { options, summary, segments, ending, like, sensitive, derivatives };
    Ok((t, values, kept))
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

/// What a run is differentiated by, the names of its derivatives, and from where it starts.
type Planned = (Vec<Sensitive>, Vec<(String, Field)>, Option<SensitivityPlan>);

fn planned(
    engine: &Engine,
    start: &Start,
    options: &SolveOptions,
    names: &[String],
) -> Result<Planned, Fault> {
    if names.is_empty() {
        return Ok((Vec::new(), Vec::new(), None));
    }
    let refused = |Rejected(faults)| Fault::model(engine.source(), &faults);
    let mut mechanism = engine.mechanism();
    let sensitive = mechanism.all_sensitive(names).map_err(refused)?;
    mechanism.model.solve = options.clone();
    let plan = mechanism.plan_sensitivities(start, &sensitive);
    let derivatives = sensitivity_columns(&mechanism, &sensitive);
    Ok((sensitive, derivatives, Some(plan.map_err(refused)?)))
}
