//! Work against precision: correct digits and CPU time of our integrators, of Fortran's RADAU5 and
//! DOP853, of SUNDIALS' IDA and of heyoka.
//!
//! Every solver runs with rtol = atol = 10⁻² … 10⁻¹². Digits are those of the state at the end
//! against a reference of 18 digits and more; time is that of the integration alone, of the fastest
//! of several runs. Between tolerances, the time to reach given digits is interpolated. The others
//! solve hand-written equations in C, compiled for this machine; we solve a model file.

mod curve;
mod ours;
mod problem;
mod theirs;

use std::path::Path;

use bksim_plot::{Axis, Figure, Panel, Scale, Theme};
use serde_json::Value;

use self::curve::{Curve, PARTS};
use self::ours::Method;
pub(crate) use self::problem::Definition;
use self::problem::{PROBLEMS, Problem};
use self::theirs::{Compiled, Solver};
use crate::error::BenchError;
use crate::peers::{Context, Workbench};
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::Effort;

/// Digits at which times are compared.
const LEVELS: [f64; 4] = [4.0, 6.0, 8.0, 10.0];

/// Goals: a solver, another one, and how many times faster the first must be at equal digits.
const GOALS: [(&str, &str, f64); 5] = [
    ("bksim radau", "RADAU5", 2.0),
    ("bksim auto", "DOP853", 1.5),
    ("bksim radau", "IDA", 10.0),
    ("bksim auto", "IDA", 10.0),
    ("bksim auto", "heyoka", 1.0),
];

/// The chosen problems; all of them if none is.
pub(crate) fn chosen(names: &[String]) -> Result<Vec<Definition>, BenchError> {
    let one = |name: &String| {
        let found = PROBLEMS.iter().find(|problem| problem.name == *name).copied();
        found.ok_or_else(|| BenchError::UnknownProblem(name.clone()))
    };
    if names.is_empty() { Ok(PROBLEMS.to_vec()) } else { names.iter().map(one).collect() }
}

/// Measures one problem.
pub(crate) fn run(
    definition: Definition,
    context: &Context,
    pictures: Option<&Path>,
) -> Result<Report, BenchError> {
    let problem = Problem::load(definition)?;
    let mut report = Report::new(definition.name, definition.title);
    let curves = measure(&problem, context, &mut report)?;
    report.tables.push(runs_table(&curves));
    for part in [0, 1] {
        report.tables.push(times_table(&curves, part));
    }
    report.checks = accuracy_checks(&curves);
    report.checks.extend(speed_checks(&curves));
    for curve in &curves {
        report.numbers.insert(curve.name.to_owned(), curve.to_json());
    }
    let at_levels = |curve: &Curve| {
        let times = |part: usize| LEVELS.map(|digits| curve.seconds_for(part, digits));
        (curve.name.to_owned(), Value::from_iter([times(0), times(1)].map(Vec::from)))
    };
    let times = curves.iter().map(at_levels).collect();
    report.numbers.insert("seconds for 4, 6, 8, 10 digits".to_owned(), Value::Object(times));
    if let Some(directory) = pictures {
        let path = directory.join(format!("{}.svg", definition.name));
        std::fs::create_dir_all(directory).map_err(|source| BenchError::io(directory, source))?;
        let picture = diagram(&problem, &curves);
        std::fs::write(&path, picture).map_err(|source| BenchError::io(&path, source))?;
    }
    Ok(report)
}

/// The curves of all solvers, ours first, the best of all rounds.
fn measure(
    problem: &Problem,
    context: &Context,
    report: &mut Report,
) -> Result<Vec<Curve>, BenchError> {
    let exponents = if context.effort.is_quick { 4..=6 } else { 2..=12 };
    let tolerances: Vec<f64> = exponents.map(|k: i32| 10f64.powi(-k)).collect();
    // All tolerances of all solvers: a tenth of the usual time each is enough.
    let effort = Effort { enough_s: context.effort.enough_s / 10.0, ..context.effort };
    let bench = Workbench::new()?;
    let mut compiled = Vec::new();
    for solver in Solver::ALL {
        match Compiled::new(solver, problem, &context.peers, &bench) {
            Ok(solver) => compiled.push(solver),
            Err(absent) => report.notes.push(format!("{}: {absent}", solver.name())),
        }
    }
    let mut curves: Vec<Curve> = Vec::new();
    let mut add = |curve: Curve| match curves.iter_mut().find(|known| known.name == curve.name) {
        Some(known) => known.merge(&curve),
        None => curves.push(curve),
    };
    for round in 0..effort.rounds {
        for method in Method::ALL {
            add(ours::curve(problem, method, &tolerances, effort)?);
        }
        for solver in &compiled {
            match solver.curve(problem, &tolerances, &context.peers, effort) {
                Ok(curve) => {
                    theirs::verify(problem, &curve, context.effort)?;
                    add(curve);
                }
                Err(absent) if round == 0 => report.notes.push(absent),
                Err(_) => (),
            }
        }
    }
    Ok(curves)
}

/// The table of all runs of all solvers.
fn runs_table(curves: &[Curve]) -> Table {
    let mut table = Table::new([
        "solver",
        "tolerance",
        "q",
        "v",
        "lambda",
        "time",
        "steps",
        "rejected",
        "residuals",
        "Jacobians",
        "factorisations",
    ]);
    for curve in curves {
        for point in &curve.points {
            let counters = point.counters;
            let counts = [
                counters.n_step,
                counters.n_reject,
                counters.n_residual,
                counters.n_jacobian,
                counters.n_factor,
            ];
            let digits = point.digits.map(|digits| {
                if digits.is_nan() { "-".to_owned() } else { format!("{digits:.1}") }
            });
            let mut row = vec![curve.name.to_owned(), format!("{:.0e}", point.tolerance)];
            row.extend(digits);
            row.push(seconds(point.seconds));
            row.extend(counts.map(|n| n.to_string()));
            table.push(row);
        }
    }
    table
}

/// The table of times to reach the digits of one part, and of their ratios to ours.
fn times_table(curves: &[Curve], part: usize) -> Table {
    let first = format!("digits in {}", PARTS[part]);
    let levels = LEVELS.map(|digits| format!("{digits}"));
    let mut table = Table::new([first].into_iter().chain(levels));
    for curve in curves {
        let times = LEVELS.map(|digits| seconds(curve.seconds_for(part, digits)));
        table.push([curve.name.to_owned()].into_iter().chain(times));
    }
    for (ours, theirs, goal) in GOALS {
        let ratios = LEVELS.map(|digits| ratio(speed(curves, (ours, theirs), part, digits)));
        let name = format!("{theirs} / {ours} (goal {goal})");
        table.push([name].into_iter().chain(ratios));
    }
    table
}

/// Speed of one solver relative to another at equal digits; zero if only the other reaches them,
/// NaN if neither does or a solver is missing.
fn speed(curves: &[Curve], (ours, theirs): (&str, &str), part: usize, digits: f64) -> f64 {
    let times = |name: &str| {
        let curve = curves.iter().find(|curve| curve.name == name);
        curve.map(|curve| curve.seconds_for(part, digits))
    };
    match (times(ours), times(theirs)) {
        (Some(own), Some(other)) if own.is_nan() && !other.is_nan() => 0.0,
        (Some(own), Some(other)) => other / own,
        _ => f64::NAN,
    }
}

/// Goals of speed: the least ratio over all digits, of positions and of velocities.
fn speed_checks(curves: &[Curve]) -> Vec<Check> {
    let one = |(ours, theirs, goal): (&str, &str, f64)| {
        [0, 1].map(|part| {
            let ratios = LEVELS.map(|digits| speed(curves, (ours, theirs), part, digits));
            let least = ratios.into_iter().fold(f64::NAN, f64::min);
            let what = format!("{ours} against {theirs}, {}, least ratio", PARTS[part]);
            Check::at_least(what, least, goal)
        })
    };
    GOALS.into_iter().flat_map(one).collect()
}

/// Goals of accuracy for our runs at tolerances from 10⁻³ on: at least the digits of the tolerance,
/// of the multipliers one fewer, and never fewer at a tighter tolerance.
fn accuracy_checks(curves: &[Curve]) -> Vec<Check> {
    /// Digits beyond which rounding errors dominate.
    const ROUNDING: f64 = 12.0;
    /// Bound of the tolerances that count.
    const LOOSEST: f64 = 3e-3;
    let ours = |curve: &&Curve| curve.name.starts_with("bksim");
    let one = |curve: &Curve| {
        // The least surplus of digits over the tolerance; a run that did not reach the end has no
        // digits.
        let points = || curve.points.iter().filter(|point| point.tolerance < LOOSEST);
        let surplus = |part: usize| {
            let surplus = |point: &curve::Point| {
                let expected = -point.tolerance.log10();
                if point.digits[part].is_nan() { -expected } else { point.digits[part] - expected }
            };
            points().map(surplus).fold(f64::NAN, f64::min)
        };

        // The least gain of digits from one tolerance to the next.
        let gain = |part: usize| {
            let gain = |(from, to): (&curve::Point, &curve::Point)| {
                let [from, to] = [from, to].map(|point| point.digits[part]);
                if from > ROUNDING { 0.0 } else { to - from }
            };
            points().zip(points().skip(1)).map(gain).fold(f64::NAN, f64::min)
        };

        let name = curve.name;
        [
            Check::at_least(
                format!("{name}: digits of positions beyond those asked"),
                surplus(0),
                0.0,
            ),
            Check::at_least(
                format!("{name}: digits of velocities beyond those asked"),
                surplus(1),
                0.0,
            ),
            Check::at_least(
                format!("{name}: digits of multipliers beyond those asked"),
                surplus(2),
                -1.0,
            ),
            Check::at_least(format!("{name}: least gain of positions per decade"), gain(0), 0.0),
        ]
    };
    curves.iter().filter(ours).flat_map(one).collect()
}

/// The diagram of digits of the positions against time, as SVG.
fn diagram(problem: &Problem, curves: &[Curve]) -> String {
    let curve = |curve: &Curve| {
        let point = |point: &curve::Point| [point.digits[0], 1e3 * point.seconds];
        bksim_plot::Curve::new(curve.name, curve.points.iter().map(point).collect())
    };
    let x = Axis::new("correct digits of the positions at the end", "");
    let y = Axis { scale: Scale::Logarithmic, ..Axis::new("CPU time", "ms") };
    let curves = curves.iter().map(curve).collect();
    let figure = Figure::new(problem.definition.title, vec![Panel::new(x, y, curves)]);
    figure.to_svg(figure.natural_size(), &Theme::LIGHT)
}
