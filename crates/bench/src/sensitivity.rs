//! Derivatives of a motion by its parameters against the runs that differences would take.
//!
//! The derivatives by P parameters go along one run; forward differences would take P + 1 runs, whose digits are half of theirs.
//! The gradient of one number goes back along it.

use bksim::dae::Control;
use bksim::sim::run::{Observer, Sample};
use bksim::sim::sensitivity::{GradientPlan, SampleWeights, Sensitive, StateSensitivity};
use bksim::sim::start::Start;
use bksim::{Mechanism, SensitivityPlan, Simulation};
use serde_json::json;

use crate::error::BenchError;
use crate::peers::Context;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::{Paired, repeat};

const NAME: &str = "slider-crank";
const MODEL: &str = include_str!("../../../examples/slider-crank/model.toml");
/// Parameters by which the motion is differentiated, the first ones of these.
const PARAMETERS: [&str; 8] = ["m1", "m2", "m3", "i1", "i2", "s1", "s2", "q1"];
const NUMBERS: [usize; 4] = [1, 2, 4, 8];
const TOLERANCES: [f64; 2] = [1e-6, 1e-8];
/// Runs with derivatives by P parameters should cost no more than P + 1 runs without.
const GOAL: f64 = 1.0;

/// Reads the last sample, as a programme that fits or optimises does.
#[derive(Default)]
struct Last {
    q: Vec<f64>,
    by: Vec<StateSensitivity>,
}

impl Observer for Last {
    fn sample(&mut self, sample: &Sample, by: &[StateSensitivity]) -> Control {
        self.q.clone_from(&sample.q);
        self.by = by.to_vec();
        Control::Continue
    }
}

/// Measures the suite.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("sensitivity", "slider-crank of 5 s and its derivatives");
    let mut table =
        Table::new(["rtol", "outputs", "parameters", "run", "with derivatives", "over a run"]);
    for tolerance in TOLERANCES {
        for n_outputs in [1, 500] {
            let subject = Subject::new(tolerance, n_outputs)?;
            for n in NUMBERS {
                let plan = subject.plan(n)?;
                let pair = subject.paired(context, || subject.derive(&plan));
                table.push(row((tolerance, n_outputs, n), &pair));
                report.numbers.insert(
                    format!("{tolerance:.0e}, {n_outputs} outputs, {n} parameters"),
                    json!(pair.ratio()),
                );
                if n == PARAMETERS.len() {
                    let what = format!(
                        "{n} parameters at {tolerance:.0e}, {n_outputs} outputs: over {} runs",
                        n + 1
                    );
                    #[expect(clippy::cast_precision_loss, reason = "a few")]
                    report.checks.push(Check::at_most(what, pair.ratio() / (n + 1) as f64, GOAL));
                }
            }
        }
    }
    report.tables.push(table);
    gradients(context, &mut report)?;
    Ok(report)
}

/// Gradients of a sum over all samples, by some parameters and by all.
fn gradients(context: &Context, report: &mut Report) -> Result<(), BenchError> {
    let mut table = Table::new(["rtol", "outputs", "gradient by", "run", "gradient", "over a run"]);
    for tolerance in TOLERANCES {
        for n_outputs in [1, 500] {
            let subject = Subject::new(tolerance, n_outputs)?;
            let all: Vec<Sensitive> =
                (0..subject.mechanism.model.parameters.len()).map(Sensitive::Parameter).collect();
            for n in [1, all.len()] {
                let plan = subject.simulation.plan_gradient(&subject.start, &all[..n]);
                let plan = plan.map_err(|rejected| refused(&rejected))?;
                let pair = subject.paired(context, || subject.go_back(&plan));
                table.push(row((tolerance, n_outputs, n), &pair));
                let name = format!("{tolerance:.0e}, {n_outputs} outputs, gradient by {n}");
                report.numbers.insert(name, json!(pair.ratio()));
            }
        }
    }
    report.tables.push(table);
    Ok(())
}

/// A row of a table: what was asked, a run, and what was timed next to it.
fn row((tolerance, n_outputs, n): (f64, u32, usize), pair: &Paired) -> [String; 6] {
    [
        format!("{tolerance:.0e}"),
        n_outputs.to_string(),
        n.to_string(),
        seconds(pair.theirs.minimum()),
        seconds(pair.ours.minimum()),
        ratio(pair.ratio()),
    ]
}

/// A mechanism at its start.
struct Subject {
    mechanism: Mechanism,
    simulation: Simulation,
    start: Start,
}

impl Subject {
    fn new(tolerance: f64, n_outputs: u32) -> Result<Self, BenchError> {
        let mut mechanism =
            Mechanism::from_toml(MODEL, NAME).map_err(|rejected| refused(&rejected))?;
        let solve = &mut mechanism.model.solve;
        (solve.rtol, solve.atol) = (tolerance, tolerance);
        solve.every = Some(solve.t_end / f64::from(n_outputs));
        let simulation = mechanism.simulation().map_err(|rejected| refused(&rejected))?;
        let start = simulation.start().map_err(|rejected| refused(&rejected))?;
        Ok(Self { mechanism, simulation, start })
    }

    fn plan(&self, n: usize) -> Result<SensitivityPlan, BenchError> {
        let names: Vec<String> = PARAMETERS[..n].iter().map(|&name| name.to_owned()).collect();
        let sensitive =
            self.mechanism.all_sensitive(&names).map_err(|rejected| refused(&rejected))?;
        self.simulation
            .plan_sensitivities(&self.start, &sensitive)
            .map_err(|rejected| refused(&rejected))
    }

    /// Times of something next to those of a run.
    fn paired(&self, context: &Context, timed: impl Fn()) -> Paired {
        let mut pair = Paired::default();
        for _ in 0..context.effort.rounds {
            let ours = repeat(context.effort, || (), |()| timed());
            pair.push(&ours, &repeat(context.effort, || (), |()| self.run()));
        }
        pair
    }

    fn run(&self) {
        let mut last = Last::default();
        let ran = self.simulation.run(&self.start, &mut last, &|| false);
        assert!(ran.is_ok() && !last.q.is_empty(), "the slider-crank runs to its end");
    }

    fn go_back(&self, plan: &GradientPlan) {
        let mut last = Last::default();
        let mut sum = |samples: &[Sample]| {
            let weights = |sample: &Sample| SampleWeights {
                q: vec![1.0; sample.q.len()],
                ..SampleWeights::default()
            };
            samples.iter().map(|sample| Some(weights(sample))).collect()
        };
        let found = self.simulation.gradient(&self.start, plan, &mut last, &mut sum, &|| false);
        let is_found = found.is_ok_and(|gradient| gradient.is_some());
        assert!(is_found && !last.q.is_empty(), "it does so back, too");
    }

    fn derive(&self, plan: &SensitivityPlan) {
        let mut last = Last::default();
        let ran = self.simulation.run_with_sensitivities(&self.start, plan, &mut last, &|| false);
        assert!(ran.is_ok() && !last.by.is_empty(), "it does so with derivatives");
    }
}

fn refused(rejected: &bksim::Rejected) -> BenchError {
    BenchError::Model { name: NAME.to_owned(), message: rejected.to_string() }
}
