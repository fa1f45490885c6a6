//! One mechanism against other programs: until each is ready, an evaluation, and the time of a motion at equal accuracy.
//!
//! Error is how far what is measured at the end of the motion is from a reference, our own run at the smallest
//! tolerance, in the last of the coordinates that are compared; it is the length of the difference of all measures
//! together. Each program runs at several step sizes or tolerances; the time at the error of the comparison is
//! interpolated.

use bksim::Mechanism;
use bksim::dae::Control;
use bksim::model::{CoordinatePolicy, Measure};
use bksim::sim::observable::Observables;
use bksim::sim::run::Sample;
use serde_json::{Value, json};

use crate::error::BenchError;
use crate::models;
use crate::peers::Context;
use crate::report::{Report, Table, ratio, seconds};
use crate::timing::cpu_time;

/// A mechanism and its motion.
pub(crate) struct Case {
    pub(crate) name: String,
    /// Model file of the case.
    pub(crate) text: String,
    /// Names of what is measured at the end, lengths in m or angles in rad.
    pub(crate) measured: Vec<String>,
    pub(crate) t_end: f64,
    /// Error at which times are compared, m or rad.
    pub(crate) level: f64,
    /// Coordinates in which we run, one at least; the reference is in the last.
    pub(crate) policies: Vec<CoordinatePolicy>,
    /// Our tolerances, from coarse to fine, and that of the reference.
    pub(crate) tolerances: &'static [f64],
    pub(crate) finest: f64,
    pub(crate) peers: &'static [Peer],
    /// The mechanism as scripts take it.
    pub(crate) request: Value,
}

/// A program to compare with.
pub(crate) struct Peer {
    pub(crate) name: &'static str,
    /// Script in `peers/`.
    pub(crate) script: &'static str,
    /// Step sizes, s, or tolerances, from coarse to fine.
    pub(crate) sizes: &'static [f64],
}

/// One run of one program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// Step size, s, or tolerance.
    pub(crate) size: f64,
    pub(crate) seconds: f64,
    pub(crate) error: f64,
}

/// Time to reach an error: interpolated between neighbouring runs, logarithm over logarithm; that of
/// the coarsest run if it is good enough, that of the finest, a lower bound, if none is.
pub(crate) fn seconds_at(runs: &[Run], error: f64) -> f64 {
    let pair = runs.windows(2).find(|pair| pair[1].error <= error);
    match (runs.first(), pair, runs.last()) {
        (Some(first), ..) if first.error <= error => first.seconds,
        (_, Some([from, to]), _) => {
            let share = (from.error / error).ln() / (from.error / to.error).ln();
            (from.seconds.ln() + share * (to.seconds / from.seconds).ln()).exp()
        }
        (_, _, Some(last)) => last.seconds,
        _ => f64::NAN,
    }
}

/// Runs all programs on all mechanisms.
pub(crate) fn compare(
    cases: &[Case],
    context: &Context,
    report: &mut Report,
) -> Result<(), BenchError> {
    let head = ["", "program", "ready in", "per evaluation", "error", "time", "to the best"];
    let mut table = Table::new(head);
    for case in cases {
        let rows = rows(case, context, report)?;
        let best = rows.iter().map(|row| row.at(case.level)).fold(f64::INFINITY, f64::min);
        for row in rows {
            report.numbers.insert(format!("{}, {}", case.name, row.name), row.json());
            let time = row.at(case.level);
            table.push([
                case.name.clone(),
                row.name.clone(),
                seconds(row.ready_s),
                seconds(row.evaluation_s),
                format!("{:.0e}", case.level),
                row.bound(case.level).to_owned() + &seconds(time),
                ratio(time / best),
            ]);
        }
    }
    report.tables.push(table);
    let note = "an evaluation: of bksim a whole run over its evaluations, of Pinocchio and MuJoCo forward \
                dynamics called from Python, of Exudyn one step";
    report.notes.push(note.to_owned());
    Ok(())
}

/// The numbers of one program for one mechanism.
struct Row {
    name: String,
    /// Until it can run, s.
    ready_s: f64,
    evaluation_s: f64,
    runs: Vec<Run>,
}

impl Row {
    /// Time to an error, s.
    fn at(&self, level: f64) -> f64 {
        seconds_at(&self.runs, level)
    }

    /// The sign before a time that is a bound: no run is as exact, or the coarsest already is.
    fn bound(&self, level: f64) -> &'static str {
        let errors = || self.runs.iter().map(|run| run.error);
        match (errors().next(), errors().fold(f64::INFINITY, f64::min)) {
            (Some(first), _) if first <= level => "≤ ",
            (_, best) if best > level => "> ",
            _ => "",
        }
    }

    fn json(&self) -> Value {
        let told =
            |run: &Run| json!({ "size": run.size, "error": run.error, "seconds": run.seconds });
        let runs: Vec<Value> = self.runs.iter().map(told).collect();
        json!({ "runs": runs, "ready_s": self.ready_s, "evaluation_s": self.evaluation_s })
    }
}

/// All programs for one mechanism.
fn rows(case: &Case, context: &Context, report: &mut Report) -> Result<Vec<Row>, BenchError> {
    let policy = case.policies[case.policies.len() - 1];
    let reference = ours(case, policy, case.finest)?.measured;
    let mut rows: Vec<Row> = Vec::new();
    for &policy in &case.policies {
        let mut row = Row {
            name: format!("bksim, {}", format!("{policy:?}").to_lowercase()),
            ready_s: f64::INFINITY,
            evaluation_s: f64::INFINITY,
            runs: Vec::new(),
        };
        for &tolerance in case.tolerances {
            let mut found = ours(case, policy, tolerance)?;
            found.run.error = distance(&found.measured, &reference);
            row.ready_s = row.ready_s.min(found.ready_s);
            row.evaluation_s = row.evaluation_s.min(found.per_evaluation_s);
            row.runs.push(found.run);
        }
        rows.push(row);
    }
    for peer in case.peers {
        match theirs(peer, case, &reference, context) {
            Ok(row) => rows.push(row),
            Err(absent) => report.notes.push(format!("{}, {}: {absent}", case.name, peer.name)),
        }
    }
    Ok(rows)
}

/// One run of ours.
struct Ours {
    ready_s: f64,
    run: Run,
    measured: Vec<f64>,
    /// Of the accelerations.
    per_evaluation_s: f64,
}

fn ours(case: &Case, policy: CoordinatePolicy, tolerance: f64) -> Result<Ours, BenchError> {
    let refused = |message: String| BenchError::Model { name: case.name.clone(), message };
    let mut model = models::model(&case.text, &case.name)?;
    model.coordinates = policy;
    let solve = &mut model.solve;
    (solve.rtol, solve.atol, solve.t_end) = (tolerance, tolerance, case.t_end);
    solve.every = Some(case.t_end);

    // From the model to a start.
    let began = cpu_time();
    let mechanism = Mechanism::derive(model, Vec::new()).map_err(|e| refused(e.to_string()))?;
    let simulation = mechanism.simulation().map_err(|e| refused(e.to_string()))?;
    let start = simulation.start().map_err(|e| refused(e.to_string()))?;
    let ready_s = cpu_time() - began;

    // The motion.
    let mut last: Option<Sample> = None;
    let mut observe = |sample: &Sample| {
        last = Some(sample.clone());
        Control::Continue
    };
    let began = cpu_time();
    let summary = simulation
        .run(&start, &mut observe, &|| false)
        .map_err(|failure| refused(simulation.diagnose(&failure).message))?;
    let seconds = cpu_time() - began;

    // What is measured at its end.
    let model = &mechanism.model;
    let measures: Option<Vec<Measure>> =
        case.measured.iter().map(|name| Measure::named(model, name)).collect();
    let measures = measures.ok_or_else(|| refused("a measure has no name".to_owned()))?;
    let mut observables =
        Observables::compile(model, &mechanism.system, &measures, &mechanism.parameters)
            .map_err(|e| refused(e.to_string()))?;
    let sample = last.ok_or_else(|| refused("no sample".to_owned()))?;
    let mut measured = vec![0.0; measures.len()];
    observables.at([&sample.q, &sample.v, &sample.a, &sample.lambda], &|_| [0.0; 6], &mut measured);
    Ok(Ours {
        ready_s,
        run: Run { size: tolerance, seconds, error: f64::NAN },
        measured,
        per_evaluation_s: seconds / summary.stats.n_residual.max(1) as f64,
    })
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The numbers of a peer.
fn theirs(
    peer: &Peer,
    case: &Case,
    reference: &[f64],
    context: &Context,
) -> Result<Row, crate::peers::Absent> {
    let sizes = if context.effort.is_quick { &peer.sizes[..1] } else { peer.sizes };
    let mut request = case.request.clone();
    request["t_end"] = json!(case.t_end);
    request["sizes"] = json!(sizes);
    let output = context.peers.python(peer.script, &request)?;
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let one = |run: &Value| {
        let measured: Vec<f64> =
            (0..reference.len()).map(|i| number(&run["measured"][i])).collect();
        let error = distance(&measured, reference);
        Run { size: number(&run["size"]), seconds: number(&run["seconds"]), error }
    };
    let runs = output["runs"].as_array().ok_or("it printed no runs")?.iter().map(one).collect();
    Ok(Row {
        name: peer.name.to_owned(),
        ready_s: number(&output["ready_s"]),
        evaluation_s: number(&output["evaluation_s"]),
        runs,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_at_an_error_are_interpolated_in_powers() {
        let run = |error, seconds| Run { size: 1.0, seconds, error };
        let runs = [run(1e-4, 1.0), run(1e-8, 100.0)];
        assert!((seconds_at(&runs, 1e-6) - 10.0).abs() < 1e-9);
        assert_eq!(seconds_at(&runs, 1e-3), 1.0);
        assert_eq!(seconds_at(&runs, 1e-9), 100.0);
        assert!(seconds_at(&[], 1e-6).is_nan());
    }
}
