//! Outputs of a run: one number each, from what varies over its time.
//!
//! ```text
//! final(state.x)        min(energy.total)      mean(state.x)      theta1@0.5
//! max(reactions.B.fx)   rms(rod.B.x)           quantile(theta1, 0.95)
//! max(hypot(reactions.B.fx, reactions.B.fy)) / (m*9.81 m/s^2)
//! max(theta1) - min(theta1)        peak_to_peak(theta1)        first(theta1 > 90 deg)
//! max_between(theta1, 0.2 s, 0.4 s)
//! ```
//!
//! A quantity over time is an expression of signals, of what the model can name, of parameters and of
//! the time `t`; a *take* makes one number of it, and an output is an expression of such numbers.
//! `reading` reads the text, `quantity` evaluates quantities at samples, `reduce` takes numbers.

mod quantity;
mod reading;
mod reduce;
mod slopes;
mod trail;
mod unit;

use bksim::Mechanism;
use bksim::expr::{Pool, SymbolId, Tape, Workspace};
use bksim::model::diagnostic::Diagnostic;
use bksim::record::Channels;
use bksim::sim::run::Sample;

use quantity::Quantities;
use reading::Reader;
use reduce::Reduced;
use slopes::Slopes;
use trail::{Trail, between};

/// How a quantity over time becomes one number.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Take {
    /// Value at the end of the run.
    Final,
    /// Smallest value, between samples and on either side of events, too.
    Min,
    /// Largest value, between samples and on either side of events, too.
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

/// Whether outputs are to have derivatives by what they depend on.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum NeedsSlopes {
    /// Values alone.
    #[default]
    No,
    /// Derivatives, too.
    Yes,
}

/// One number that is taken of a quantity.
#[derive(Clone, Debug)]
struct Asked {
    take: Take,
    /// The part of the time that counts; all of it unless given.
    window: Option<[f64; 2]>,
    /// Which quantity it is of.
    quantity: usize,
    /// The output that asks for it, as it was written.
    output: String,
}

impl Asked {
    fn counts(&self, t: f64) -> bool {
        self.window.is_none_or(|[from, to]| from <= t && t <= to)
    }
}

/// The numbers of each run of a sweep, and the functions that give them.
#[derive(Clone, Debug)]
pub struct Outputs {
    all: Vec<Output>,
    quantities: Quantities,
    takes: Vec<Asked>,
    /// From takes and parameters to outputs.
    results: Tape,
    /// Where they were asked for.
    slopes: Option<Slopes>,
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
        needs_slopes: NeedsSlopes,
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
        let slopes = match needs_slopes {
            NeedsSlopes::No => None,
            NeedsSlopes::Yes => {
                Some(Slopes::compile(&pool, (&over_time, &results), &names, &symbols)?)
            }
        };
        let results = compile(&pool, &results, &symbols, &parameters)?;
        let takes = takes.into_iter().map(|taken| taken.asked).collect();
        let quantities = Quantities::compile(&pool, &over_time, names, mechanism)?;
        Ok(Self { all, quantities, takes, results, slopes })
    }

    /// Names and units.
    pub fn all(&self) -> &[Output] {
        &self.all
    }

    /// True if an output is the extreme of a quantity, which may be between samples or jump at an event.
    pub(crate) fn has_extremes(&self) -> bool {
        self.takes.iter().any(|asked| asked.take.is_extreme())
    }

    /// The takes, each with the output that asks for it, as it was written.
    pub(crate) fn takes(&self) -> impl Iterator<Item = (Take, &str)> {
        self.takes.iter().map(|asked| (asked.take, asked.output.as_str()))
    }

    /// The ends of the parts of the time that outputs are of.
    pub(crate) fn ends(&self) -> impl Iterator<Item = f64> {
        self.takes.iter().filter_map(|asked| asked.window).flatten()
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

/// A sample between two others, at an instant; `None` where there is none.
pub(crate) type Between<'a> = &'a mut dyn FnMut(f64) -> Option<Sample>;

/// The outputs of one run as it goes on.
#[derive(Clone, Debug)]
pub(crate) struct Reducer {
    quantities: Quantities,
    /// By take.
    reduced: Vec<Reduced>,
    trails: Vec<Trail>,
    results: Workspace,
    row: Vec<f64>,
    taken: Vec<f64>,
}

impl Reducer {
    /// Room for the outputs of runs.
    pub(crate) fn new(outputs: &Outputs, parameters: &[f64]) -> Self {
        Self {
            quantities: outputs.quantities.clone(),
            reduced: outputs.takes.iter().map(|asked| Reduced::new(asked.take)).collect(),
            trails: vec![Trail::default(); outputs.takes.len()],
            results: outputs.results.workspace(parameters),
            row: Vec::new(),
            taken: Vec::new(),
        }
    }

    /// Begins a run with these values of the parameters.
    pub(crate) fn begin(&mut self, outputs: &Outputs, parameters: &[f64]) {
        self.quantities.set_parameters(parameters);
        self.results = outputs.results.workspace(parameters);
        self.reduced.iter_mut().for_each(Reduced::clear);
        self.trails.iter_mut().for_each(Trail::clear);
    }

    /// Takes a sample; those of a run come in its order, with what is on either side of an event as two samples of one
    /// instant that extremes alone count.
    pub(crate) fn take(
        &mut self,
        outputs: &Outputs,
        channels: &Channels,
        (sample, is_event): (&Sample, bool),
        at: Between<'_>,
    ) {
        self.row.clear();
        self.row.extend_from_slice(self.quantities.at(channels, sample));
        for (k, asked) in outputs.takes.iter().enumerate() {
            let (is_extreme, value) = (asked.take.is_extreme(), self.row[asked.quantity]);
            if is_event && !is_extreme {
                continue;
            }
            let around = if asked.counts(sample.t) {
                self.reduced[k].take(sample.t, value);
                is_extreme.then(|| self.trails[k].next(sample.t, value))
            } else {
                is_extreme.then(|| self.trails[k].end())
            };
            if let Some(Some(samples)) = around {
                self.rise(k, (outputs, channels), samples, at);
            }
        }
    }

    /// Looks for a peak of a take between samples.
    fn rise(
        &mut self,
        k: usize,
        (outputs, channels): (&Outputs, &Channels),
        samples: [(f64, f64); 3],
        at: Between<'_>,
    ) {
        let Self { quantities, reduced, .. } = self;
        let mut value = |t: f64| {
            let quantity = outputs.takes[k].quantity;
            at(t).map_or(f64::NAN, |sample| quantities.at(channels, &sample)[quantity])
        };
        for side in reduced[k].sides().into_iter().flatten() {
            if let Some((_, found)) = between(samples, side, &mut value) {
                reduced[k].rise(found);
            }
        }
    }

    /// The earliest instant at which samples between others may still be asked for; `None` where none are.
    pub(crate) fn since(&self, is_forward: bool) -> Option<f64> {
        let earlier = |a: f64, b: f64| if is_forward { a.min(b) } else { a.max(b) };
        self.trails.iter().filter_map(Trail::since).reduce(earlier)
    }

    /// Writes the outputs of the run that has ended.
    pub(crate) fn finish(
        &mut self,
        (outputs, channels): (&Outputs, &Channels),
        at: Between<'_>,
        out: &mut Vec<f64>,
    ) {
        for k in 0..self.trails.len() {
            if let Some(samples) = self.trails[k].end() {
                self.rise(k, (outputs, channels), samples, at);
            }
        }
        self.taken.clear();
        self.taken.extend(self.reduced.iter_mut().map(Reduced::finish));
        let first = out.len();
        out.resize(first + outputs.all.len(), 0.0);
        outputs.results.evaluate(&mut self.results, &self.taken, &mut out[first..]);
    }
}
