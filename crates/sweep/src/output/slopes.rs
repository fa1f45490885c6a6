//! Slopes of outputs by what the samples of a run show.
//!
//! ```text
//! dR = Σₖ ∂R/∂takeₖ Σᵢ ∂takeₖ/∂xₖ(tᵢ) · (∂xₖ/∂h · dh(tᵢ) + ∂xₖ/∂p · dp) + ∂R/∂p · dp
//! ```
//!
//! R is an output, x a quantity over time, h what it is a function of: signals and measures of the run, whose changes follow from
//! the motion. The rest is what remains where these are held.

use bksim::analysis::GoalTake;
use bksim::expr::{Expr, Pool, SymbolId, Tape};
use bksim::model::diagnostic::Diagnostic;
use bksim::record::Channels;
use bksim::sim::run::Sample;

use super::quantity::{Names, Quantities};
use super::{Outputs, Take, compile};

/// The derivatives of outputs, and of quantities over time.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    /// Names of what quantities are functions of, but for the time, each with its place among these.
    names: Vec<(usize, String)>,
    /// By quantity, then by name.
    of_quantities: Tape,
    /// By output, then by take.
    of_outputs: Tape,
}

impl Slopes {
    pub(super) fn compile(
        pool: &Pool,
        (quantities, results): (&[Expr], &[Expr]),
        names: &Names,
        takes: &[SymbolId],
    ) -> Result<Self, Diagnostic> {
        let parameters = names.parameter_symbols();
        let all: Vec<SymbolId> = names.over_time().map(|(symbol, _)| symbol).collect();
        let own: Vec<(usize, SymbolId)> = (names.over_time().enumerate())
            .filter_map(|(idx, (symbol, is_time))| (!is_time).then_some((idx, symbol)))
            .collect();
        let symbols: Vec<SymbolId> = own.iter().map(|&(_, symbol)| symbol).collect();
        let by = |of: &[Expr], symbols: &[SymbolId]| -> Vec<Expr> {
            of.iter().flat_map(|&of| pool.gradient(of, symbols)).collect()
        };
        let name = |(idx, symbol)| (idx, pool.symbol_name(symbol));
        Ok(Self {
            of_quantities: compile(pool, &by(quantities, &symbols), &all, &parameters)?,
            of_outputs: compile(pool, &by(results, takes), takes, &parameters)?,
            names: own.into_iter().map(name).collect(),
        })
    }
}

/// A run whose samples are held: its outputs as functions of parameters alone.
pub(crate) struct Held<'o> {
    outputs: &'o Outputs,
    slopes: &'o Slopes,
    quantities: Quantities,
    times: Vec<f64>,
    /// By sample, what quantities are functions of.
    arguments: Vec<Vec<f64>>,
}

impl Outputs {
    /// Names of what outputs depend on over the time; `None` where one of them has no slopes: peaks, whose instants move,
    /// first times and quantiles.
    pub(crate) fn slopes_by(&self) -> Option<Vec<String>> {
        let is_smooth = |take: Take| match take {
            Take::Final | Take::Mean | Take::Rms | Take::At(_) => true,
            Take::Min | Take::Max | Take::PeakToPeak | Take::Quantile(_) | Take::First => false,
        };
        let slopes = self.slopes.as_ref().filter(|_| self.takes().all(|(take, _)| is_smooth(take)));
        slopes.map(|slopes| slopes.names.iter().map(|(_, name)| name.clone()).collect())
    }

    /// A run with its samples held; `None` without slopes.
    pub(crate) fn held(
        &self,
        channels: &Channels,
        parameters: &[f64],
        samples: &[Sample],
    ) -> Option<Held<'_>> {
        let slopes = self.slopes.as_ref()?;
        let mut quantities = self.quantities.clone();
        quantities.set_parameters(parameters);
        let arguments =
            samples.iter().map(|sample| quantities.arguments(channels, sample).to_vec());
        let arguments = arguments.collect();
        let times = samples.iter().map(|sample| sample.t).collect();
        Some(Held { outputs: self, slopes, quantities, times, arguments })
    }
}

impl Held<'_> {
    /// By take: its value, with its slopes by the values of the samples.
    fn takes(&mut self, parameters: &[f64]) -> Option<Vec<(f64, Vec<f64>)>> {
        let Self { outputs, quantities, times, arguments, .. } = self;
        quantities.set_parameters(parameters);
        let rows: Vec<Vec<f64>> =
            arguments.iter().map(|row| quantities.of_arguments(row).to_vec()).collect();
        let of = |asked: &super::Asked| {
            let values: Vec<f64> = rows.iter().map(|row| row[asked.quantity]).collect();
            let goal = match asked.take {
                Take::Mean => GoalTake::Mean,
                Take::Rms => GoalTake::Rms,
                Take::At(at) => {
                    let here: Vec<f64> =
                        times.iter().map(|t| f64::from(u8::from(*t == at))).collect();
                    let value = here.iter().position(|is| *is == 1.0).map(|idx| values[idx])?;
                    return Some((value, here));
                }
                _ => GoalTake::Last,
            };
            let (value, slopes) = goal.of(times, &values);
            Some((value, slopes?))
        };
        outputs.takes.iter().map(of).collect()
    }

    /// The outputs at other values of the parameters.
    pub(crate) fn at(&mut self, parameters: &[f64]) -> Option<Vec<f64>> {
        let takes: Vec<f64> = self.takes(parameters)?.into_iter().map(|(value, _)| value).collect();
        let results = &self.outputs.results;
        let mut values = vec![0.0; results.n_outputs()];
        results.evaluate(&mut results.workspace(parameters), &takes, &mut values);
        Some(values)
    }

    /// The derivatives of outputs by what the samples show: by output, by sample, by name.
    pub(crate) fn weights(&mut self, parameters: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let takes = self.takes(parameters)?;
        let Self { outputs, slopes, arguments, .. } = self;
        let values: Vec<f64> = takes.iter().map(|(value, _)| *value).collect();
        let Slopes { names, of_quantities, of_outputs } = slopes;
        let mut by_take = vec![0.0; of_outputs.n_outputs()];
        of_outputs.evaluate(&mut of_outputs.workspace(parameters), &values, &mut by_take);
        let (n, n_takes) = (names.len(), takes.len());
        let mut weights = vec![vec![vec![0.0; n]; arguments.len()]; outputs.all.len()];
        let (mut space, mut by) =
            (of_quantities.workspace(parameters), vec![0.0; of_quantities.n_outputs()]);
        for (i, row) in arguments.iter().enumerate() {
            of_quantities.evaluate(&mut space, row, &mut by);
            for (k, (asked, (_, of_samples))) in outputs.takes.iter().zip(&takes).enumerate() {
                let own = &by[asked.quantity * n..(asked.quantity + 1) * n];
                for (output, weights) in weights.iter_mut().enumerate() {
                    let factor = by_take[output * n_takes + k] * of_samples[i];
                    if factor != 0.0 {
                        weights[i].iter_mut().zip(own).for_each(|(w, slope)| *w += factor * slope);
                    }
                }
            }
        }
        Some(weights)
    }
}
