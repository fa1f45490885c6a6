//! Regret of `method = "auto"`: its time over that of the better of the two methods it chooses from, on
//! models of which some are stiff, some turn stiff, and some never are.

mod models;

use bksim::Mechanism;
use bksim::dae::Control;
use bksim::model::{Jit, Method};
use bksim::sim::run::Sample;
use serde_json::json;

use self::models::{StiffModel, all};
use crate::error::BenchError;
use crate::peers::Context;
use crate::report::{Check, Report, Table};
use crate::timing::{Effort, cpu_time, repeat};

/// The tolerances, `rtol = atol`.
const TOLERANCES: [f64; 3] = [1e-4, 1e-6, 1e-8];
/// The regret allowed.
const GOAL: f64 = 1.5;
/// A run that takes so many times what the fastest did is given up: it is not the better one.
const GIVEN_UP: f64 = 30.0;

/// Runs that take less are not given up, s.
const SHORT: f64 = 0.05;

/// Attempts at a step and CPU time of one method, s; NaN and what was tried where it did not arrive.
#[derive(Clone, Copy)]
struct Work {
    n_step: usize,
    seconds: f64,
}

/// Measures all models.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("stiffness", "Regret of auto");
    let mut header = vec!["model".to_owned()];
    header.extend(
        TOLERANCES
            .map(|tolerance| format!("{tolerance:.0e}: regret, steps of auto, explicit, radau")),
    );
    let mut table = Table::new(header);
    let mut worst: f64 = 0.0;
    for model in all() {
        let mut row = vec![model.name.to_owned()];
        for tolerance in TOLERANCES {
            // Radau first: the others are given up where they take far longer.
            let run = |method: Method, longest: f64| {
                work(&model, (method, tolerance), longest, context.effort)
            };
            let radau = run(Method::Radau, f64::INFINITY)?;
            let explicit = run(Method::Explicit, (GIVEN_UP * radau.seconds).max(SHORT))?;
            let better = radau.seconds.min(explicit.seconds);
            let auto = run(Method::Auto, (GIVEN_UP * better).max(SHORT))?;
            let regret = auto.seconds / better;
            let steps = |work: Work| {
                if work.seconds.is_nan() { "–".to_owned() } else { work.n_step.to_string() }
            };
            row.push(format!(
                "{regret:.2}: {}, {}, {}",
                steps(auto),
                steps(explicit),
                steps(radau)
            ));
            worst = if regret.is_nan() { f64::INFINITY } else { worst.max(regret) };
            let what = format!("{}, {tolerance:.0e}", model.name);
            report.numbers.insert(
                what.clone(),
                json!({
                    "regret": regret,
                    "seconds": [auto.seconds, explicit.seconds, radau.seconds],
                    "n_step": [auto.n_step, explicit.n_step, radau.n_step],
                }),
            );
            report.checks.push(Check::at_most(format!("{what}: regret"), regret, GOAL));
        }
        table.push(row);
    }
    report.tables.push(table);
    report.checks.push(Check::at_most("the worst regret", worst, GOAL));
    Ok(report)
}

/// Runs a model by one method at one tolerance.
fn work(
    stiff: &StiffModel,
    (method, tolerance): (Method, f64),
    longest: f64,
    effort: Effort,
) -> Result<Work, BenchError> {
    let refused = |message: String| BenchError::Model { name: stiff.name.to_owned(), message };
    let mut model = crate::models::model(&stiff.text, stiff.name)?;
    let solve = &mut model.solve;
    (solve.rtol, solve.atol, solve.jit, solve.method) = (tolerance, tolerance, Jit::On, method);
    (solve.t_end, solve.every) = (stiff.t_end, Some(stiff.t_end));
    let mechanism = Mechanism::derive(model, Vec::new()).map_err(|e| refused(e.to_string()))?;
    let start = mechanism.start().map_err(|e| refused(e.to_string()))?;
    let simulation = mechanism.simulation().map_err(|e| refused(e.to_string()))?;
    let mut n_step = 0;
    let mut has_arrived = true;
    let samples = repeat(
        effort,
        || (),
        |()| {
            let began = cpu_time();
            let mut ignore = |_: &Sample| Control::Continue;
            let is_late = || cpu_time() - began > longest;
            let summary = simulation.run(&start, &mut ignore, &is_late);
            has_arrived &= summary.as_ref().is_ok_and(|summary| summary.reached_end);
            n_step = summary.map_or(0, |summary| summary.stats.n_step);
        },
    );
    let seconds = if has_arrived { samples.minimum() } else { f64::NAN };
    Ok(Work { n_step, seconds })
}
