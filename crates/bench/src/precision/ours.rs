//! Our own runs, through the facade: from a model file to the state at the end.

use bksim::dae::Control;
use bksim::model::{self, Jit, Model, SolveOptions};
use bksim::sim::run::Sample;
use bksim::sim::start::Start;
use bksim::{Mechanism, Rejected};

use super::curve::{Counters, Curve, Point, digits};
use super::problem::{Definition, Problem};
use crate::error::BenchError;
use crate::models;
use crate::timing::{Effort, repeat};

/// One of our integrators.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Method {
    /// Radau IIA.
    Radau,
    /// Explicit steps as long as the motion is not stiff.
    Auto,
}

impl Method {
    /// All of them.
    pub(crate) const ALL: [Self; 2] = [Self::Radau, Self::Auto];

    /// Name in the report.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Radau => "bksim radau",
            Self::Auto => "bksim auto",
        }
    }

    /// Sets the method in the options of a run.
    pub(crate) fn choose(self, options: &mut SolveOptions) {
        options.method = match self {
            Self::Radau => model::Method::Radau,
            Self::Auto => model::Method::Auto,
        };
    }
}

/// Runs a problem at all `tolerances`.
///
/// Timed is the run from the consistent start to the end. The equations are machine code from the
/// first evaluation on, and compiling it is not part of the fastest run: the other programs are
/// compiled beforehand, too.
pub(crate) fn curve(
    problem: &Problem,
    method: Method,
    tolerances: &[f64],
    effort: Effort,
) -> Result<Curve, BenchError> {
    let definition = &problem.definition;
    let refused = |error: Rejected| BenchError::Model {
        name: definition.name.to_owned(),
        message: error.to_string(),
    };
    let points = tolerances
        .iter()
        .map(|&tolerance| {
            let model = prepare(definition, method, tolerance)?;
            let mechanism = Mechanism::derive(model, Vec::new()).map_err(refused)?;
            let start = mechanism.start().map_err(refused)?;
            let order = DataOrder::new(definition, &mechanism)?;
            order.check_start(problem, &start)?;
            point(problem, &mechanism, &start, &order, effort).map_err(refused)
        })
        .collect::<Result<_, BenchError>>()?;
    Ok(Curve { name: method.name(), points })
}

/// The model with the options of a run: one sample, at the end.
fn prepare(definition: &Definition, method: Method, tolerance: f64) -> Result<Model, BenchError> {
    let mut model = models::model(definition.model, definition.name)?;
    let solve = &mut model.solve;
    (solve.rtol, solve.atol, solve.jit) = (tolerance, tolerance, Jit::On);
    solve.every = Some(solve.t_end - solve.t_start);
    method.choose(solve);
    Ok(model)
}

/// Our coordinates and multipliers in the order of the data.
struct DataOrder {
    coordinates: Vec<usize>,
    multipliers: &'static [(usize, f64)],
}

impl DataOrder {
    fn new(definition: &Definition, mechanism: &Mechanism) -> Result<Self, BenchError> {
        let ours = &mechanism.compiled.coordinates;
        let index = |name: &&str| ours.iter().position(|coordinate| coordinate.name == *name);
        let coordinates: Option<Vec<_>> = definition.coordinates.iter().map(index).collect();
        let coordinates =
            coordinates.ok_or(BenchError::Data("a coordinate is not in its model"))?;
        Ok(Self { coordinates, multipliers: definition.multipliers })
    }

    fn of(&self, values: &[f64]) -> Vec<f64> {
        self.coordinates.iter().map(|&i| values[i]).collect()
    }

    fn multipliers_of(&self, lambda: &[f64]) -> Vec<f64> {
        self.multipliers.iter().map(|&(row, factor)| factor * lambda[row]).collect()
    }

    /// Checks that our start is that of the data; otherwise no later comparison means anything.
    fn check_start(&self, problem: &Problem, start: &Start) -> Result<(), BenchError> {
        const LIMIT: f64 = 1e-12;
        let (q, v) = (self.of(&start.q), self.of(&start.v));
        let pairs = q.iter().zip(&problem.start.q).chain(v.iter().zip(&problem.start.v));
        for (i, (&found, &expected)) in pairs.enumerate() {
            if (found - expected).abs() > LIMIT * expected.abs().max(1.0) {
                return Err(BenchError::Disagreement {
                    who: "bksim".to_owned(),
                    what: format!("start of {}, value {i}", problem.definition.name),
                    found,
                    expected,
                });
            }
        }
        Ok(())
    }
}

/// Runs one tolerance.
fn point(
    problem: &Problem,
    mechanism: &Mechanism,
    start: &Start,
    order: &DataOrder,
    effort: Effort,
) -> Result<Point, Rejected> {
    // Repeated runs; the last sample and summary are the same in all of them.
    let simulation = mechanism.simulation()?;
    let mut last = Sample::default();
    let mut summary = None;
    let samples = repeat(
        effort,
        || (),
        |()| {
            let mut keep = |sample: &Sample| {
                last.clone_from(sample);
                Control::Continue
            };
            summary = simulation.run(start, &mut keep, &|| false).ok();
        },
    );

    // Correct digits, if the run has reached the end, and counters.
    let mut digits_found = [f64::NAN; 3];
    if summary.as_ref().is_some_and(|summary| summary.reached_end) {
        let reference = &problem.reference;
        digits_found = [
            digits(&order.of(&last.q), &reference.q),
            digits(&order.of(&last.v), &reference.v),
            digits(&order.multipliers_of(&last.lambda), &reference.lambda),
        ];
    }
    let stats = summary.map(|summary| summary.stats).unwrap_or_default();
    Ok(Point {
        tolerance: mechanism.model.solve.rtol,
        digits: digits_found,
        seconds: samples.minimum(),
        counters: Counters {
            n_step: stats.n_step,
            n_reject: stats.n_reject,
            n_residual: stats.n_residual,
            n_jacobian: stats.n_jacobian,
            n_factor: stats.n_factor,
        },
    })
}
