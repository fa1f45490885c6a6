//! Invariants over long runs and through singular poses: energy and constraints of a conservative
//! pendulum and four-bar over 1000 s; the branch of N-four-bars over 10 s, which pass poses with
//! all links in one line several times.

use bksim::Mechanism;
use bksim::sim::run::Sample;
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::context::Context;
use crate::error::BenchError;
use crate::models::{self, Coordinates, Cut, four_bar, n_four_bar};
use crate::precision::Method;
use crate::report::{Check, Report, Table};
use crate::timing::cpu_time;
use crate::windows::angle;

/// The suites, in the order they are run.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Debug)]
pub(crate) enum DriftSuite {
    /// Energy and constraints over 1000 s.
    Conserved,
    /// N-four-bars through their singular poses.
    Singular,
}

const PENDULUM: &str = include_str!("../models/pendulum.toml");
/// Start of the four-bar.
const FOUR_BAR_START: &str = "[initial]\nq1 = \"60 deg\"\nq1_dot = 0\nq2 = { guess = \"-30 deg\" }\nq3 = { guess = \"100 deg\" }\n";

/// A mechanism without dissipation.
struct Conservative {
    name: &'static str,
    text: String,
    /// Largest length, m.
    length: f64,
}

impl DriftSuite {
    /// Measures one suite.
    pub(crate) fn run(self, context: &Context) -> Report {
        match self {
            Self::Conserved => conserved(context),
            Self::Singular => singular(context),
        }
    }
}

/// Result of one run.
struct Kept {
    samples: Vec<Sample>,
    /// Largest error of T + V − W over its scale.
    energy: f64,
    /// Largest residuals at the samples, m and m/s.
    residuals: [f64; 2],
    n_step: usize,
    seconds: f64,
}

/// Runs a model until `t_end`, s.
fn keep(
    text: &str,
    name: &str,
    method: Method,
    tolerance: f64,
    t_end: f64,
) -> Result<Kept, BenchError> {
    let refused = |message: String| BenchError::Model { name: name.to_owned(), message };
    let mut model = models::model(text, name)?;
    method.choose(&mut model.solve);
    (model.solve.rtol, model.solve.atol) = (tolerance, tolerance);
    (model.solve.t_end, model.solve.every) = (t_end, Some(0.1));
    let mechanism = Mechanism::derive(model, Vec::new()).map_err(|e| refused(e.to_string()))?;
    let began = cpu_time();
    let motion = mechanism.solve().map_err(|e| refused(e.to_string()))?;
    let seconds = cpu_time() - began;
    let summary = &motion.summary;
    Ok(Kept {
        energy: summary.energy.worst_error / summary.energy.scale,
        residuals: [summary.position_residual[1], summary.velocity_residual[1]],
        n_step: summary.stats.n_step,
        samples: motion.samples,
        seconds,
    })
}

/// Measures energy and constraints over 1000 s.
fn conserved(context: &Context) -> Report {
    let mut report = Report::new("conserved", "Energy and constraints over 1000 s");
    let t_end = if context.effort.is_quick { 10.0 } else { 1000.0 };
    let four_bar = four_bar(Cut::Coupler) + FOUR_BAR_START;
    let mechanisms = [
        Conservative { name: "pendulum", text: PENDULUM.to_owned(), length: 1.0 },
        Conservative { name: "four-bar", text: four_bar, length: 0.3 },
    ];
    let mut table = Table::new([
        "mechanism",
        "method",
        "rtol",
        "energy",
        "position / L",
        "velocity / L",
        "steps",
        "time",
    ]);
    for Conservative { name, text, length } in &mechanisms {
        for (method, (tolerance, bound)) in runs(&[(1e-6, 2e-5), (1e-8, 1e-7)]) {
            // A run that fails has missed its goal.
            let run = format!("{name}, {}, {tolerance:.0e}", method.name());
            let what = format!("{run}: relative energy error");
            let kept = match keep(text, name, method, tolerance, t_end) {
                Ok(kept) => kept,
                Err(error) => {
                    report.notes.push(format!("{run}: {error}"));
                    report.checks.push(Check::at_most(what, f64::INFINITY, bound));
                    continue;
                }
            };

            // Its row of the table, goals and numbers.
            let [position, velocity] = kept.residuals.map(|residual| residual / length);
            let mut row = vec![(*name).to_owned(), method.name().to_owned()];
            row.push(format!("{tolerance:.0e}"));
            row.extend([kept.energy, position, velocity].map(|x| format!("{x:.1e}")));
            row.push(kept.n_step.to_string());
            row.push(crate::report::seconds(kept.seconds));
            table.push(row);
            report.checks.extend([
                Check::at_most(what, kept.energy, bound),
                Check::at_most(format!("{run}: position residual over L"), position, 1e-8),
                Check::at_most(format!("{run}: velocity residual over L"), velocity, 1e-6),
            ]);
            report.numbers.insert(
                run,
                json!({
                    "energy": kept.energy, "position": position, "velocity": velocity,
                    "n_step": kept.n_step, "seconds": kept.seconds,
                }),
            );
        }
    }
    report.tables.push(table);
    report
}

/// Every method at every tolerance.
fn runs<T: Copy>(tolerances: &[T]) -> impl Iterator<Item = (Method, T)> + use<'_, T> {
    Method::ALL.into_iter().flat_map(|method| tolerances.iter().map(move |&t| (method, t)))
}

/// Measures N-four-bars through their singular poses.
fn singular(context: &Context) -> Report {
    let mut report = Report::new("singular", "N-four-bars through their singular poses, 10 s");
    let sizes: &[usize] = if context.effort.is_quick { &[2] } else { &[2, 10, 40] };
    let mut table = Table::new([
        "windows",
        "method",
        "rtol",
        "error of the angle, rad",
        "energy",
        "steps",
        "time",
    ]);
    for &n in sizes {
        let text = n_four_bar(n, Coordinates::Chosen);
        for (method, tolerance) in runs(&[1e-6, 1e-8]) {
            // A run that fails has missed its goal.
            let run = format!("N = {n}, {}, {tolerance:.0e}", method.name());
            let what = format!("{run}: energy over its scale");
            let kept = match keep(&text, "n-four-bar", method, tolerance, 10.0) {
                Ok(kept) => kept,
                Err(error) => {
                    report.notes.push(format!("{run}: {error}"));
                    report.checks.push(Check::at_most(what, f64::INFINITY, 1e-5));
                    continue;
                }
            };

            // Its row of the table, goals and numbers.
            let error = branch_error(n, &kept.samples);
            let mut row = vec![n.to_string(), method.name().to_owned(), format!("{tolerance:.0e}")];
            row.extend([error, kept.energy].map(|x| format!("{x:.1e}")));
            row.push(kept.n_step.to_string());
            row.push(crate::report::seconds(kept.seconds));
            table.push(row);
            report.checks.push(Check::at_most(what, kept.energy, 1e-5));
            let on_branch = format!("{run}: error of the angle, rad");
            report.checks.push(Check::at_most(on_branch, error, BRANCH));
            let numbers: Value = json!({
                "error": error, "energy": kept.energy, "n_step": kept.n_step, "seconds": kept.seconds,
            });
            report.numbers.insert(run, numbers);
        }
    }
    report.tables.push(table);
    report
}

/// Largest error of the angle on the right branch, rad; on another branch it is of the order of
/// one.
const BRANCH: f64 = 1e-2;

/// Largest error of the angle of the first upright, which is the first coordinate with the opposite
/// sign.
fn branch_error(n: usize, samples: &[Sample]) -> f64 {
    let checked = samples.iter().skip(1).step_by(10);
    checked.map(|sample| (-sample.q[0] - angle(n, sample.t)).abs()).fold(0.0, f64::max)
}
