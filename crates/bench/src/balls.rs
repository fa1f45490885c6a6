//! Chains of rods on spherical joints: the time of an evaluation and of a run at equal accuracy, in both kinds of
//! coordinates, beside Pinocchio, MuJoCo and Exudyn.
//!
//! A chain of the length and mass one, straight and level at first, turns about the vertical and falls. Error is how
//! far its free end is from a reference, our own run in coordinates of bodies at the smallest tolerance, m. Each program
//! runs at several step sizes or tolerances; the time at an error of 10⁻⁴ m is interpolated.

use bksim::Mechanism;
use bksim::dae::Control;
use bksim::model::{CoordinatePolicy, Measure};
use bksim::sim::observable::{Observable, Observables};
use bksim::sim::run::Sample;
use serde_json::{Value, json};

use crate::context::Context;
use crate::error::BenchError;
use crate::mechanisms::{Run, seconds_at};
use crate::models;
use crate::report::{Report, Table, ratio, seconds};
use crate::timing::cpu_time;

/// End of the motion, s: of long chains, which have fast motions, a part of it.
fn t_end(n: usize) -> f64 {
    match n {
        0..=10 => 0.5,
        11..=100 => 0.1,
        _ => 0.01,
    }
}

/// Error at which times are compared, m.
const LEVEL: f64 = 1e-4;
/// The longest chain in relative coordinates: M is full, and each entry is a formula.
const LARGEST_RELATIVE: usize = 100;

/// A program to compare with.
struct Peer {
    name: &'static str,
    /// Its script in `peers/`.
    script: &'static str,
    /// Step sizes, s, or tolerances, from coarse to fine.
    sizes: &'static [f64],
}

const PEERS: [Peer; 3] = [
    Peer { name: "Pinocchio, DOP853", script: "balls_pinocchio", sizes: &[1e-4, 1e-6, 1e-8] },
    Peer { name: "MuJoCo, RK4", script: "balls_mujoco", sizes: &[2e-3, 1e-3, 5e-4, 2e-4] },
    Peer {
        name: "Exudyn, generalised alpha",
        script: "balls_exudyn",
        sizes: &[5e-3, 2e-3, 1e-3, 5e-4],
    },
];

/// The chain of `n` rods; x leads from the wall to its free end.
fn chain(n: usize) -> String {
    let (length, mass) = (1.0 / n as f64, 1.0 / n as f64);
    let (along, across) = moments(n);
    let half = 0.5 * length;
    let mut text = "space = \"spatial\"\n[loads.gravity]\ntype = \"gravity\"\n\
                    acceleration = [0, 0, -9.81]\n"
        .to_owned();
    let (mut joints, mut initial) = (String::new(), "[initial]\n".to_owned());
    for i in 1..=n {
        let from = if i == 1 { "ground".to_owned() } else { format!("b{}.E", i - 1) };
        text.extend([format!(
            "[bodies.b{i}]\nmass = {mass:?}\ninertia = [{along:?}, {across:?}, {across:?}]\n\
             points = {{ O = [-{half:?}, 0, 0], E = [{half:?}, 0, 0] }}\n"
        )]);
        joints.extend([format!(
            "[joints.j{i}]\ntype = \"spherical\"\nbetween = [\"{from}\", \"b{i}.O\"]\n"
        )]);
        let spin = u8::from(i == 1);
        initial.extend([format!(
            "j{i} = {{ angle1 = 0, angle2 = 0, angle3 = 0, rate1 = 0, rate2 = 0, rate3 = {spin} }}\n"
        )]);
    }
    text + &joints + &initial
}

/// Moments of inertia of a rod along itself and across, kg m².
fn moments(n: usize) -> (f64, f64) {
    let size = (1.0 / n as f64).powi(3);
    (0.02 * size, size / 12.0)
}

/// One run of ours.
struct Ours {
    ready_s: f64,
    run: Run,
    tip: [f64; 3],
    /// Of the accelerations.
    per_evaluation_s: f64,
}

fn ours(n: usize, policy: CoordinatePolicy, tolerance: f64) -> Result<Ours, BenchError> {
    let name = format!("chain of {n} balls");
    let refused = |message: String| BenchError::Model { name: name.clone(), message };
    let mut model = models::model(&chain(n), &name)?;
    model.coordinates = policy;
    let solve = &mut model.solve;
    (solve.rtol, solve.atol, solve.t_end) = (tolerance, tolerance, t_end(n));
    solve.every = Some(t_end(n));
    let began = cpu_time();
    let mechanism = Mechanism::derive(model, Vec::new()).map_err(|e| refused(e.to_string()))?;
    let simulation = mechanism.simulation().map_err(|e| refused(e.to_string()))?;
    let start = simulation.start().map_err(|e| refused(e.to_string()))?;
    let ready_s = cpu_time() - began;
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
    let model = &mechanism.model;
    let end = ["x", "y", "z"].map(|axis| Measure::named(model, &format!("b{n}.E.{axis}")));
    let end: Option<Vec<Observable>> =
        end.into_iter().map(|measure| measure.map(Observable::Measure)).collect();
    let end = end.ok_or_else(|| refused("the free end has no name".to_owned()))?;
    let mut observables =
        Observables::compile(model, &mechanism.system, &end, &mechanism.parameters)
            .map_err(|e| refused(e.to_string()))?;
    let sample = last.ok_or_else(|| refused("no sample".to_owned()))?;
    let mut tip = [0.0; 3];
    observables.at([&sample.q, &sample.v, &sample.a], &|_| [0.0; 6], &mut tip);
    let stats = summary.stats;
    Ok(Ours {
        ready_s,
        run: Run { size: tolerance, seconds, error: f64::NAN },
        tip,
        per_evaluation_s: seconds / stats.n_residual.max(1) as f64,
    })
}

/// The numbers of one program for one chain.
struct Row {
    name: String,
    /// Until it can run, s.
    ready_s: f64,
    evaluation_s: f64,
    runs: Vec<Run>,
}

impl Row {
    /// Time to the error of the comparison, s.
    fn at_level(&self) -> f64 {
        seconds_at(&self.runs, LEVEL)
    }

    fn json(&self) -> Value {
        let told =
            |run: &Run| json!({ "size": run.size, "error": run.error, "seconds": run.seconds });
        let runs: Vec<Value> = self.runs.iter().map(told).collect();
        json!({ "runs": runs, "ready_s": self.ready_s, "evaluation_s": self.evaluation_s })
    }
}

/// Compares all chains.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let sizes: &[usize] = if context.effort.is_quick { &[3] } else { &[10, 100, 1000] };
    let mut report = Report::new("balls", "Chains of spherical joints");
    let head =
        ["", "program", "ready in", "per evaluation", "time at 1e-4 m", "to the best of them"];
    let mut table = Table::new(head);
    for &n in sizes {
        let rows = rows(n, context, &mut report)?;
        let best = rows.iter().map(Row::at_level).fold(f64::INFINITY, f64::min);
        for row in rows {
            report.numbers.insert(format!("{n}, {}", row.name), row.json());
            table.push([
                n.to_string(),
                row.name.clone(),
                seconds(row.ready_s),
                seconds(row.evaluation_s),
                seconds(row.at_level()),
                ratio(row.at_level() / best),
            ]);
        }
    }
    report.tables.push(table);
    let note = "an evaluation: of bksim a whole run over its evaluations, of Pinocchio and MuJoCo forward \
                dynamics called from Python, of Exudyn one step";
    report.notes.push(note.to_owned());
    Ok(report)
}

/// All programs for the chain of `n`.
fn rows(n: usize, context: &Context, report: &mut Report) -> Result<Vec<Row>, BenchError> {
    let (finest, tolerances): (f64, &[f64]) = match n {
        0..=10 => (1e-11, &[1e-3, 1e-4, 1e-6, 1e-8]),
        11..=100 => (1e-9, &[1e-3, 1e-5, 1e-7]),
        _ => (1e-7, &[1e-4]),
    };
    let reference = ours(n, CoordinatePolicy::Absolute, finest)?.tip;
    let mut rows: Vec<Row> = Vec::new();
    let policies =
        [("relative", CoordinatePolicy::Relative), ("absolute", CoordinatePolicy::Absolute)];
    for (word, policy) in policies {
        if n > LARGEST_RELATIVE && policy == CoordinatePolicy::Relative {
            report.notes.push(format!("{n} in relative coordinates: not derived, M is full"));
            continue;
        }
        let mut row = Row {
            name: format!("bksim, {word}"),
            ready_s: f64::INFINITY,
            evaluation_s: f64::INFINITY,
            runs: Vec::new(),
        };
        for &tolerance in tolerances {
            let mut found = ours(n, policy, tolerance)?;
            found.run.error = distance(found.tip, reference);
            row.ready_s = row.ready_s.min(found.ready_s);
            row.evaluation_s = row.evaluation_s.min(found.per_evaluation_s);
            row.runs.push(found.run);
        }
        rows.push(row);
    }
    for peer in &PEERS {
        match theirs(peer, n, reference, context) {
            Ok(row) => rows.push(row),
            Err(absent) => report.notes.push(format!("{n}, {}: {absent}", peer.name)),
        }
    }
    Ok(rows)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The numbers of a peer.
fn theirs(
    peer: &Peer,
    n: usize,
    reference: [f64; 3],
    context: &Context,
) -> Result<Row, crate::peers::Absent> {
    let sizes = if context.effort.is_quick { &peer.sizes[..1] } else { peer.sizes };
    let (along, across) = moments(n);
    let request =
        json!({ "n": n, "along": along, "across": across, "t_end": t_end(n), "sizes": sizes });
    let output = context.peers.python(peer.script, &request)?;
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let one = |run: &Value| {
        let tip: [f64; 3] = std::array::from_fn(|i| number(&run["tip"][i]));
        let error = distance(tip, reference);
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
