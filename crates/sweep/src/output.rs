//! Outputs of a run: one number each, from what varies over its time.
//!
//! ```text
//! final(state.x)        min(energy.total)      mean(state.x)      theta1@0.5
//! max(reactions.B.fx)   rms(rod.B.x)           quantile(theta1, 0.95)
//! max(hypot(reactions.B.fx, reactions.B.fy)) / (m*9.81 m/s^2)
//! max(theta1) - min(theta1)        peak_to_peak(theta1)        first(theta1 > 90 deg)
//! ```
//!
//! A quantity over time is an expression of signals, of what the model can name, of parameters and of
//! the time `t`; a *take* makes one number of it, and an output is an expression of such numbers.
//! `reading` reads the text, `quantity` evaluates quantities at samples, `reduce` takes numbers.

mod quantity;
mod reading;
mod reduce;
mod unit;

use bksim::Mechanism;
use bksim::expr::{Pool, SymbolId, Tape, Workspace};
use bksim::model::diagnostic::Diagnostic;
use bksim::record::Channels;
use bksim::sim::run::Sample;

use quantity::Quantities;
use reading::Reader;
use reduce::Reduced;

/// How a quantity over time becomes one number.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Take {
    /// Value at the end of the run.
    Final,
    /// Smallest sample, or value on either side of an event.
    Min,
    /// Largest sample, or value on either side of an event.
    Max,
    /// The largest less the smallest.
    PeakToPeak,
    /// Mean over time, by the trapezoidal rule.
    Mean,
    /// The root of the mean of its square over time, by the trapezoidal rule.
    Rms,
    /// The value that it is below for this part of the time.
    Quantile(f64),
    /// The first time at which it is not below zero, s; NaN when it never is.
    First,
    /// Value at a time, s.
    At(f64),
}

impl Take {
    fn is_extreme(self) -> bool {
        matches!(self, Self::Min | Self::Max | Self::PeakToPeak)
    }
}

/// One number of a run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Output {
    /// Name of the output, such as `max(reactions.B.fx)` or `state.theta@0.5`.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
}

/// The numbers of each run of a sweep, and the functions that give them.
#[derive(Clone, Debug)]
pub struct Outputs {
    all: Vec<Output>,
    quantities: Quantities,
    /// By take: which quantity it is of.
    takes: Vec<(Take, usize)>,
    /// By take: the output that asks for it, as it was written.
    asked_by: Vec<String>,
    /// From takes and parameters to outputs.
    results: Tape,
}

impl Outputs {
    /// Reads outputs; a field may be named alone where no other signal has a field of its name, and a quantity
    /// without a take means its final value. Without any, these are the final value, the smallest and the largest
    /// of every coordinate.
    ///
    /// # Errors
    /// A diagnostic with [`UNKNOWN_OUTPUT`](crate::codes::UNKNOWN_OUTPUT).
    pub fn read(
        texts: &[String],
        mechanism: &Mechanism,
        channels: &Channels,
    ) -> Result<Self, Diagnostic> {
        let mut reader = Reader::new(mechanism, channels);
        let mut all = Vec::new();
        let mut results = Vec::new();
        let defaults = if texts.is_empty() { defaults(mechanism) } else { Vec::new() };
        for text in texts.iter().chain(&defaults) {
            let (output, result) = reader.output(text)?;
            all.push(output);
            results.push(result);
        }
        let Reader { pool, names, takes, over_time, .. } = reader;
        let symbols = takes.iter().map(|take| take.symbol).collect::<Vec<SymbolId>>();
        let parameters = names.parameter_symbols();
        let results = compile(&pool, &results, &symbols, &parameters)?;
        let asked_by = takes.iter().map(|take| take.output.clone()).collect();
        let takes = takes.into_iter().map(|take| (take.take, take.quantity)).collect();
        let quantities = Quantities::compile(&pool, &over_time, names, mechanism)?;
        Ok(Self { all, quantities, takes, asked_by, results })
    }

    /// Names and units.
    pub fn all(&self) -> &[Output] {
        &self.all
    }

    /// True if an output is the extreme of a quantity that may jump at an event.
    pub(crate) fn has_extremes(&self) -> bool {
        self.takes.iter().any(|(take, _)| take.is_extreme())
    }

    /// The takes, each with the output that asks for it, as it was written.
    pub(crate) fn takes(&self) -> impl Iterator<Item = (Take, &str)> {
        self.takes.iter().zip(&self.asked_by).map(|(&(take, _), output)| (take, output.as_str()))
    }
}

/// The final value, the smallest and the largest of every coordinate.
fn defaults(mechanism: &Mechanism) -> Vec<String> {
    let coordinates = mechanism.compiled.coordinates.iter();
    let takes = ["final", "min", "max"];
    coordinates.flat_map(|c| takes.map(|take| format!("{take}(state.{})", c.name))).collect()
}

/// A function of numbers; every symbol of its outputs is one of `inputs` or `parameters`.
fn compile(
    pool: &Pool,
    outputs: &[bksim::expr::Expr],
    inputs: &[SymbolId],
    parameters: &[SymbolId],
) -> Result<Tape, Diagnostic> {
    Tape::compile(pool, outputs, inputs, parameters)
        .map_err(|error| Diagnostic::error(crate::codes::UNKNOWN_OUTPUT, error.to_string()))
}

/// The outputs of one run as it goes on.
#[derive(Clone, Debug)]
pub(crate) struct Reducer {
    quantities: Quantities,
    reduced: Vec<Reduced>,
    results: Workspace,
    taken: Vec<f64>,
    t: f64,
}

impl Reducer {
    /// Room for the outputs of runs.
    pub(crate) fn new(outputs: &Outputs, parameters: &[f64]) -> Self {
        Self {
            quantities: outputs.quantities.clone(),
            reduced: outputs.takes.iter().map(|&(take, _)| Reduced::new(take)).collect(),
            results: outputs.results.workspace(parameters),
            taken: Vec::new(),
            t: 0.0,
        }
    }

    /// Begins a run with these values of the parameters.
    pub(crate) fn begin(&mut self, outputs: &Outputs, parameters: &[f64]) {
        self.quantities.set_parameters(parameters);
        self.results = outputs.results.workspace(parameters);
        self.reduced.iter_mut().for_each(Reduced::clear);
    }

    /// Takes a sample; those of a run come in its order.
    pub(crate) fn take(&mut self, outputs: &Outputs, channels: &Channels, sample: &Sample) {
        let values = self.quantities.at(channels, sample);
        let takes = outputs.takes.iter().map(|&(_, quantity)| values[quantity]);
        for (reduced, value) in self.reduced.iter_mut().zip(takes) {
            reduced.take(sample.t, value);
        }
        self.t = sample.t;
    }

    /// Takes what there is between two samples, on one side of an event: extremes count it.
    pub(crate) fn take_between(&mut self, outputs: &Outputs, channels: &Channels, sample: &Sample) {
        let values = self.quantities.at(channels, sample);
        for (reduced, &(take, quantity)) in self.reduced.iter_mut().zip(&outputs.takes) {
            if take.is_extreme() {
                reduced.take(sample.t, values[quantity]);
            }
        }
    }

    /// Writes the outputs of the run that has ended.
    pub(crate) fn finish(&mut self, outputs: &Outputs, out: &mut Vec<f64>) {
        self.taken.clear();
        self.taken.extend(self.reduced.iter_mut().map(Reduced::finish));
        let first = out.len();
        out.resize(first + outputs.all.len(), 0.0);
        outputs.results.evaluate(&mut self.results, &self.taken, &mut out[first..]);
    }
}
