//! Cost of a solve from Python against the same solve from Rust.

use bksim::dae::Control;
use bksim::record::Channels;
use bksim::sim::run::{Observer, Sample, Segment};
use bksim::sim::sensitivity::StateSensitivity;
use bksim::sim::start::Start;
use bksim::{Mechanism, Simulation};
use serde_json::{Value, json};

use crate::context::Context;
use crate::error::BenchError;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::cpu_time;

/// Examples and their end times, s: a short run, a long one, and one with Radau IIA.
const RUNS: [(&str, f64); 3] = [("slider-crank", 2.0), ("four-bar", 20.0), ("governor", 10.0)];
/// Relative tolerance.
const RTOL: f64 = 1e-8;
/// Rounds for each round of the other suites: the least time needs many.
const ROUNDS: usize = 4;

/// Measures the suite.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("python", "a solve from Python against the same solve from Rust");
    let mut table = Table::new(["example", "kept", "Rust", "Python", "Python over Rust"]);
    for (name, t_end) in RUNS {
        let path = format!("{}/../../examples/{name}/model.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path)
            .map_err(|source| BenchError::io(path.as_ref(), source))?;
        let ours = Ours::new(name, &text, t_end)?;
        let runs = if context.effort.is_quick { 1 } else { 15 };

        // Rust, Python: the least of all rounds, since two processes rarely find the machine
        // equally busy.
        let mut least = [[f64::INFINITY; 2]; 2];
        for _ in 0..ROUNDS * context.effort.rounds {
            let request = json!({ "model": path, "t_end": t_end, "rtol": RTOL, "runs": runs });
            let theirs = match context.peers.python("package", &request) {
                Ok(found) => found,
                Err(absent) => {
                    report.notes.push(format!("Python: {absent}"));
                    return Ok(report);
                }
            };
            for (idx, key) in ["dense", "samples"].into_iter().enumerate() {
                let (own, last) = ours.least(runs, idx == 0)?;
                let their = least_of(&theirs[key]);
                if idx == 0 && !is_same(&last, &theirs["last"]) {
                    return Err(BenchError::Data("Python and Rust solve to the same state"));
                }
                least[idx] = [least[idx][0].min(own), least[idx][1].min(their)];
            }
        }

        // A row of the table and a goal for either kind of result.
        for (idx, kept) in ["samples and motion", "samples"].into_iter().enumerate() {
            let [own, their] = least[idx];
            let over = their / own;
            table.push([
                name.to_owned(),
                kept.to_owned(),
                seconds(own),
                seconds(their),
                ratio(over),
            ]);
            report.checks.push(Check::at_most(format!("{name}, {kept}"), over, 1.05));
            report.numbers.insert(format!("{name}_{}", kept.replace(' ', "_")), json!(over));
        }
    }
    report.tables.push(table);
    report.notes.push(
        "both from a model whose equations and start are known, into tables of numbers".to_owned(),
    );
    Ok(report)
}

/// The least of Python's times, s.
fn least_of(times: &Value) -> f64 {
    let times = times.as_array().into_iter().flatten().filter_map(Value::as_f64);
    times.fold(f64::INFINITY, f64::min)
}

/// Whether Python's coordinates are ours, bit by bit.
fn is_same(own: &[f64], theirs: &Value) -> bool {
    let theirs = theirs.as_array().into_iter().flatten().filter_map(Value::as_f64);
    own.iter().copied().eq(theirs)
}

/// A mechanism ready to run.
struct Ours {
    simulation: Simulation,
    start: Start,
    channels: Channels,
}

/// Observer that keeps the same results as Python's.
struct Keeping<'a> {
    channels: &'a Channels,
    t: Vec<f64>,
    values: Vec<f64>,
    segments: Vec<Segment>,
    last: Vec<f64>,
    is_dense: bool,
}

impl Observer for Keeping<'_> {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.t.push(sample.t);
        self.channels.append_row(sample, &mut self.values);
        self.last.clone_from(&sample.q);
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        self.is_dense
    }

    fn segment(&mut self, segment: &Segment) {
        self.segments.push(segment.clone());
    }
}

impl Ours {
    fn new(name: &str, text: &str, t_end: f64) -> Result<Self, BenchError> {
        let refused = |rejected: bksim::Rejected| BenchError::Model {
            name: name.to_owned(),
            message: rejected.to_string(),
        };
        let mut mechanism = Mechanism::from_toml(text, name).map_err(refused)?;
        (mechanism.model.solve.t_end, mechanism.model.solve.rtol) = (t_end, RTOL);
        let simulation = mechanism.simulation().map_err(refused)?;
        let start = mechanism.start().map_err(refused)?;
        let channels = Channels::new(&mechanism);
        Ok(Self { simulation, start, channels })
    }

    /// The least CPU time of some runs, s, and the last coordinates.
    fn least(&self, runs: usize, is_dense: bool) -> Result<(f64, Vec<f64>), BenchError> {
        let mut least = f64::INFINITY;
        let mut previous = self.keeping(is_dense);
        // One more run than in Python's list, where the first is not counted either.
        for idx in 0..=runs {
            let begun = cpu_time();
            let mut keeping = self.keeping(is_dense);
            let ran = self.simulation.run(&self.start, &mut keeping, &|| false);
            // As in Python, the previous result is freed when its name is bound to the next one.
            previous = keeping;
            let taken = cpu_time() - begun;
            ran.map_err(|_| BenchError::Data("an example runs to its end"))?;
            if idx > 0 {
                least = least.min(taken);
            }
        }
        Ok((least, previous.last))
    }

    fn keeping(&self, is_dense: bool) -> Keeping<'_> {
        Keeping {
            channels: &self.channels,
            t: Vec::new(),
            values: Vec::new(),
            segments: Vec::new(),
            last: Vec::new(),
            is_dense,
        }
    }
}
