//! Gradients: the derivatives of one number of the motion by many parameters and stated initial values.
//!
//! One run forward and one way back along it serve all quantities, however many they are; see
//! [`bksim_sim::sensitivity::gradient()`].

use bksim_dae::Control;
use bksim_expr::{Expr, SymbolId, Tape};
use bksim_model::Model;
use bksim_model::diagnostic::Rejected;
use bksim_sim::Mechanism;
use bksim_sim::run::Sample;
use bksim_sim::sensitivity::{
    GradientPlan, Sensitive, SensitivityError, diagnose_sensitivity, plan_gradient,
    plan_gradient_by_some,
};
use bksim_sim::start::Start;

use crate::error::AnalysisError;
use crate::goal::{Goal, GoalTake};
use crate::table::{Column, Table};
use crate::watch::Watch;

/// The number that is differentiated, and by what.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct GradientRequest {
    /// A quantity of the run by any of its names: `theta1`, `A.angle`, `energy.total`, `reactions.B.force`, `rod.B.ax`.
    pub of: String,
    /// How it becomes one number.
    pub take: GoalTake,
    /// Parameters and stated initial values; all of the model where none are named, but for those without a
    /// derivative.
    pub by: Vec<String>,
}

/// The derivatives of one number of the motion.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionGradient {
    /// The quantity over time, and its unit.
    pub of: Column,
    /// How it became one number.
    pub take: GoalTake,
    /// That number.
    pub value: f64,
    /// By quantity, in the order in which they were named, else parameters, then initial values, in file order.
    pub by: Vec<Derivative>,
    /// Quantities without a derivative, where all were asked for.
    pub left_out: Vec<LeftOut>,
    /// Steps of the run.
    pub n_steps: usize,
    /// Steps of the way back.
    pub n_steps_back: usize,
}

/// The derivative by one quantity, SI.
#[derive(Clone, PartialEq, Debug)]
pub struct Derivative {
    /// The parameter or initial value, and its unit.
    pub by: Column,
    /// Value of the derivative.
    pub value: f64,
    /// The derivative by it.
    pub derivative: f64,
    /// Unit of the derivative.
    pub unit: String,
}

/// A quantity without a derivative.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LeftOut {
    /// The parameter or initial value.
    pub name: String,
    /// The reason, as a message has it.
    pub why: String,
}

impl Derivative {
    /// The change of the number where the quantity grows by a hundredth, to first order.
    pub fn by_percent(&self) -> f64 {
        0.01 * self.derivative * self.value
    }
}

impl MotionGradient {
    /// The derivatives by what a hundredth of each quantity does, the largest first; those that this tells
    /// nothing of, as of a value that is zero, come last, by the size of the derivative.
    pub fn by_weight(&self) -> Vec<&Derivative> {
        let mut all: Vec<&Derivative> = self.by.iter().collect();
        all.sort_by(|a, b| {
            let of_percent = b.by_percent().abs().total_cmp(&a.by_percent().abs());
            of_percent.then(b.derivative.abs().total_cmp(&a.derivative.abs()))
        });
        all
    }

    /// A row for each quantity: its value, the derivative by it, and what a hundredth of it does.
    pub fn table(&self) -> Table {
        let unit = &self.of.unit;
        let columns = vec![
            Column::new("value", ""),
            Column::new("derivative", ""),
            Column::new("by_percent", unit.clone()),
        ];
        let row = |one: &Derivative| vec![one.value, one.derivative, one.by_percent()];
        Table { columns, rows: self.by.iter().map(row).collect() }
    }

    /// [`MotionGradient::table`] as comma-separated values, with the names of the quantities in front.
    pub fn csv(&self) -> String {
        let names = self.by.iter().map(|one| one.by.name.as_str());
        let table = self.table().csv();
        let lines = std::iter::once("quantity").chain(names).zip(table.lines());
        lines.flat_map(|(name, line)| [name, ",", line, "\n"]).collect()
    }
}

/// The derivatives of one number of the run of `model`; `None` where `watch` has stopped it.
///
/// # Errors
/// [`AnalysisError`] when nothing with a derivative has the name, the model has no start, the run ends early, or
/// there is no derivative by what was named.
pub fn gradient(
    model: Model,
    request: &GradientRequest,
    watch: Watch<'_>,
) -> Result<Option<MotionGradient>, AnalysisError> {
    let mechanism = Mechanism::derive(model, Vec::new())?;
    let mut goal = Goal::named(&mechanism, &request.of)?;
    let simulation = mechanism.simulation()?;
    let start = simulation.start()?;
    let Planned { plan, by, left_out } = if request.by.is_empty() {
        plan_by_all(&mechanism, &start, goal.more())?
    } else {
        let by = mechanism.all_sensitive(&request.by)?;
        let plan = plan(&mechanism, &start, (&by, goal.more()))
            .map_err(|error| refused(&mechanism, &error))?;
        Planned { plan, by, left_out: Vec::new() }
    };

    // The run, the number, and the way back.
    let mut reached = |sample: &Sample| {
        (watch.reached)("the run", sample.t);
        Control::Continue
    };
    let (mut value, mut is_smooth) = (f64::NAN, true);
    let mut weigh = |samples: &[Sample]| {
        let times: Vec<f64> = samples.iter().map(|sample| sample.t).collect();
        let values: Vec<f64> = samples.iter().map(|sample| goal.value(sample)).collect();
        let (number, slopes) = request.take.of(&times, &values);
        (value, is_smooth) = (number, slopes.is_some());
        let slopes = slopes.unwrap_or_else(|| vec![0.0; samples.len()]);
        let weights = |&slope: &f64| (slope != 0.0).then(|| goal.weights(slope));
        slopes.iter().map(weights).collect()
    };
    let found = simulation
        .gradient(&start, &plan, &mut reached, &mut weigh, watch.stop)
        .map_err(|failure| Rejected(vec![simulation.diagnose(&failure)]))?;
    let Some(found) = found else { return Ok(None) };
    if !is_smooth {
        return Err(AnalysisError::NoSlope { name: goal.column().name.clone() });
    }

    let of = goal.column().clone();
    let values = values(&mechanism, &by)?;
    let numbers = by.iter().zip(values).zip(found.by);
    let derivative = |((by, value), derivative): ((&Sensitive, f64), f64)| {
        let model = &mechanism.model;
        let unit = by.unit_of_derivative(model, &of.unit);
        Derivative { by: Column::new(by.name(model), by.unit(model)), value, derivative, unit }
    };
    Ok(Some(MotionGradient {
        by: numbers.map(derivative).collect(),
        of,
        take: request.take,
        value,
        left_out,
        n_steps: found.summary.stats.n_accept,
        n_steps_back: found.n_steps_back,
    }))
}

/// The way to a gradient.
struct Planned {
    plan: GradientPlan,
    by: Vec<Sensitive>,
    left_out: Vec<LeftOut>,
}

fn plan(
    mechanism: &Mechanism,
    start: &Start,
    by: (&[Sensitive], &[String]),
) -> Result<GradientPlan, SensitivityError> {
    let Mechanism { model, system, compiled, parameters, .. } = mechanism;
    plan_gradient(model, system, compiled, (start, parameters), by)
}

/// The plan by all parameters and stated initial values, but for those without a derivative.
///
/// # Errors
/// Those of the model as a whole, and where no quantity is left.
fn plan_by_all(
    mechanism: &Mechanism,
    start: &Start,
    more: &[String],
) -> Result<Planned, AnalysisError> {
    let model = &mechanism.model;
    let stated = (0..model.initial.len()).filter(|&k| !model.initial[k].is_guess);
    let parameters = (0..model.parameters.len()).map(Sensitive::Parameter);
    let all: Vec<Sensitive> = parameters.chain(stated.map(Sensitive::Initial)).collect();
    let Mechanism { system, compiled, parameters, .. } = mechanism;
    let (plan, why) =
        plan_gradient_by_some(model, system, compiled, (start, parameters), (&all, more))
            .map_err(|error| refused(mechanism, &error))?;
    if let (true, Some((_, error))) = (plan.sensitive().is_empty(), why.first()) {
        return Err(refused(mechanism, error));
    }
    let left_out = |(by, error): &(Sensitive, SensitivityError)| LeftOut {
        name: by.name(model).to_owned(),
        why: diagnose_sensitivity(model, error).message,
    };
    let left_out = why.iter().map(left_out).collect();
    Ok(Planned { by: plan.sensitive().to_vec(), plan, left_out })
}

fn refused(mechanism: &Mechanism, error: &SensitivityError) -> AnalysisError {
    Rejected(vec![diagnose_sensitivity(&mechanism.model, error)]).into()
}

/// The values of some quantities, SI.
fn values(mechanism: &Mechanism, by: &[Sensitive]) -> Result<Vec<f64>, AnalysisError> {
    let Mechanism { model, parameters, .. } = mechanism;
    let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let expression = |by: &Sensitive| match *by {
        Sensitive::Parameter(k) => model.pool.symbol_expr(model.parameters[k].symbol),
        Sensitive::Initial(k) => model.initial[k].value,
    };
    let expressions: Vec<Expr> = by.iter().map(expression).collect();
    let tape = Tape::compile(&model.pool, &expressions, &[], &symbols)?;
    let mut values = vec![0.0; by.len()];
    tape.evaluate(&mut tape.workspace(parameters), &[], &mut values);
    Ok(values)
}
