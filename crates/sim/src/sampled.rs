//! Sampled signals: values that change at the ticks of clocks and are held in between.
//!
//! ```text
//! ticks      t = t₀ + k T,  k = 0, 1, 2, …
//! at one     x⁻ ← x,  x ← its value at (t, q, v), the values held now, and those before
//! ```
//!
//! Between ticks x is a number like a mode: a parameter of everything that is compiled. A run ends a step
//! exactly at a tick and goes on from there as from an event. Signals that conditions latch are held with these.

use bksim_dae::{Loader, Saver, SolveError, Step};
use bksim_expr::{SymbolId, TapeError};
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{ClockId, HeldChange, HeldSignal, MOST_OUTPUTS, Model, SolveOptions};

use crate::function::{Buffers, Function};
use crate::half_turns::{HalfTurn, HalfTurns};
use crate::input::{InputValues, Inputs, input_symbols, without_inputs};

/// Part of a period within which two instants are one tick: times that are sums and products of others
/// agree up to rounding only.
const SAME_TICK: f64 = 1e-6;

/// The sampled signals of one mechanism, compiled.
#[derive(Clone, Debug)]
pub(crate) struct SampledSignals {
    /// Start and period of every clock, then the first value of every signal that is held: of the parameters.
    constants: Function,
    n_clocks: usize,
    /// Each after those it uses.
    signals: Vec<CompiledSignal>,
    half_turns: HalfTurns,
}

#[derive(Clone, Debug)]
struct CompiledSignal {
    /// Place among the signals that are held.
    signal: usize,
    clock: ClockId,
    /// Of t, q, v, the inputs, the values held, and those before.
    value: Function,
}

/// The values that are held.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Held {
    /// Of every signal that is held, SI.
    pub values: Vec<f64>,
    /// Before the last tick of its clock.
    pub(crate) previous: Vec<f64>,
    /// The tick that was passed last, or the start of the run, s.
    t: f64,
}

/// The ticks of one clock.
#[derive(Clone, Copy, Debug)]
struct Ticks {
    start: f64,
    every: f64,
}

/// A tick that lies ahead.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tick {
    /// s.
    pub t: f64,
    /// Instants this near to it are the same, s.
    slack: f64,
}

/// A signal that is held takes no finite value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NoSignal {
    /// Index of the signal.
    pub signal: usize,
}

/// Sampled signals at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Sampling<'a> {
    signals: &'a SampledSignals,
    clocks: Vec<Ticks>,
    starts: Vec<f64>,
    buffers: Vec<Buffers>,
    half_turns: Buffers,
    inputs: InputValues,
}

impl SampledSignals {
    /// Compiles the sampled signals of a model: as they were written, since they have no modes.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(crate) fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let own: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let constants = model.clocks.iter().flat_map(|clock| [clock.start, clock.every]);
        let constants: Vec<_> = constants.chain(model.held.iter().map(|s| s.start)).collect();
        let own = without_inputs(model, own);

        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let held: Vec<SymbolId> = model.held.iter().map(|s| s.held).collect();
        let previous: Vec<SymbolId> = model.held.iter().map(|s| s.previous).collect();
        let (time, inputs) = ([model.time], input_symbols(model));
        let arguments = [&time[..], &q, &v, &inputs, &held, &previous];
        let measures =
            if held.is_empty() { Vec::new() } else { signal_values(model, &system.kinematics) };
        let signal = |(signal, of): (usize, &HeldSignal)| {
            let HeldChange::Tick { clock, value } = of.change else { return Ok(None) };
            let value = model.pool.substitute(value, &measures);
            let value = Function::compile(model, &[value], &arguments, &own)?;
            Ok(Some(CompiledSignal { signal, clock, value }))
        };
        let signals = model.held.iter().enumerate().filter_map(|held| signal(held).transpose());
        let half_turns = HalfTurns::compile(model, &measures, [&time, &q, &held], &own)?;
        Ok(Self {
            half_turns,
            constants: Function::compile(model, &constants, &[], &own)?,
            n_clocks: model.clocks.len(),
            signals: signals.collect::<Result<_, TapeError>>()?,
        })
    }

    /// True where no signal is sampled.
    pub(crate) fn is_empty(&self) -> bool {
        self.signals.is_empty()
    }

    /// The signals at these values of the model's own parameters.
    pub(crate) fn at(&self, parameters: &[f64], inputs: &Inputs) -> Sampling<'_> {
        let mut constants = self.constants.buffers(parameters);
        let constants = self.constants.evaluate(&mut constants, &[]);
        let (clocks, starts) = constants.split_at(2 * self.n_clocks);
        let clocks = clocks.as_chunks().0.iter().map(|&[start, every]| Ticks { start, every });
        Sampling {
            signals: self,
            clocks: clocks.collect(),
            starts: starts.to_vec(),
            buffers: self.signals.iter().map(|s| s.value.buffers(parameters)).collect(),
            half_turns: self.half_turns.buffers(parameters),
            inputs: InputValues::new(inputs),
        }
    }
}

impl Held {
    /// Of `n` signals, all zero.
    pub(crate) fn zeros(n: usize) -> Self {
        Self { values: vec![0.0; n], previous: vec![0.0; n], t: 0.0 }
    }

    /// With these values held and nothing else known.
    pub(crate) fn of_values(values: &[f64]) -> Self {
        Self { values: values.to_vec(), ..Self::zeros(values.len()) }
    }

    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.slice(&self.values);
        saver.slice(&self.previous);
        saver.real(self.t);
    }

    /// Takes over as many values.
    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        loader.fill(&mut self.values)?;
        loader.fill(&mut self.previous)?;
        self.t = loader.real()?;
        Ok(())
    }
}

impl Tick {
    /// True where `t` lies before it, and is not the same instant.
    pub fn is_after(&self, t: f64) -> bool {
        self.t - t > self.slack
    }

    /// True where it lies before `t`, and is not the same instant.
    pub(crate) fn is_before(&self, t: f64) -> bool {
        t - self.t > self.slack
    }

    /// Instants before this one lie before the tick, s.
    pub fn begin(&self) -> f64 {
        self.t - self.slack
    }
}

impl Ticks {
    /// The first tick after `t`.
    fn after(self, t: f64) -> Tick {
        let Self { start, every } = self;
        let k = ((t - start) / every + SAME_TICK).floor() + 1.0;
        Tick { t: start + k.max(0.0) * every, slack: SAME_TICK * every }
    }

    /// True where it ticks at `t`.
    fn is_at(self, t: f64) -> bool {
        let Self { start, every } = self;
        let k = ((t - start) / every).round();
        k >= 0.0 && (start + k * every - t).abs() <= SAME_TICK * every
    }
}

impl Sampling<'_> {
    /// The first clock that ticks more often in a run than can be told apart, with its period, s.
    pub(crate) fn too_many(&self, options: &SolveOptions) -> Option<(ClockId, f64)> {
        let SolveOptions { t_start, t_end, .. } = *options;
        let is_too_fast = |Ticks { start, every }: Ticks| {
            let times = [t_start, t_end, start, t_start - start, t_end - start];
            let longest = times.iter().fold(0.0, |longest: f64, t| longest.max(t.abs()));
            longest / every > MOST_OUTPUTS
        };
        let clock = self.clocks.iter().position(|&clock| is_too_fast(clock))?;
        Some((ClockId(clock), self.clocks[clock].every))
    }

    /// The values before any tick of a run that starts at `t`.
    pub fn begin(&self, t: f64) -> Held {
        let (values, previous) = (self.starts.clone(), self.starts.clone());
        Held { values, previous, t }
    }

    /// The first tick after the one that was passed last; `None` where there are no clocks.
    pub fn next(&self, held: &Held) -> Option<Tick> {
        let ticks = self.clocks.iter().map(|clock| clock.after(held.t));
        ticks.min_by(|a, b| a.t.total_cmp(&b.t))
    }

    /// True if ropes or belts have turns to count.
    pub(crate) fn counts_half_turns(&self) -> bool {
        !self.signals.half_turns.is_empty()
    }

    /// The first half turn of a rope or belt that is to be counted in a step.
    pub(crate) fn half_turn_in(&mut self, step: &Step<'_>, held: &Held) -> Option<HalfTurn> {
        self.signals.half_turns.first_in(&mut self.half_turns, step, &held.values)
    }

    /// Counts the half turns of ropes and belts up to a state.
    pub(crate) fn count_half_turns(&mut self, t: f64, q: &[f64], held: &mut Held) {
        self.signals.half_turns.count(&mut self.half_turns, (t, q), &mut held.values);
    }

    /// Takes the values of the signals whose clocks tick at `t`, at a state.
    ///
    /// # Errors
    /// [`NoSignal`] names the first without a finite value.
    pub fn tick(&mut self, t: f64, q: &[f64], v: &[f64], held: &mut Held) -> Result<(), NoSignal> {
        let Self { signals, clocks, buffers, inputs, .. } = self;
        let all = signals.signals.iter().zip(buffers);
        let ticking: Vec<_> = all.filter(|(signal, _)| clocks[signal.clock.0].is_at(t)).collect();
        for (CompiledSignal { signal, .. }, _) in &ticking {
            held.previous[*signal] = held.values[*signal];
        }
        for (signal, buffers) in ticking {
            let inputs = inputs.at(t, q, v);
            let arguments = [&[t], q, v, inputs, &held.values, &held.previous];
            let value = signal.value.evaluate(buffers, &arguments)[0];
            if !value.is_finite() {
                return Err(NoSignal { signal: signal.signal });
            }
            held.values[signal.signal] = value;
        }
        held.t = t;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_follow_each_other_however_they_round() {
        for (start, every) in [(0.0, 0.002), (0.0, 0.1), (-0.3, 0.007), (5.0, 1e-4)] {
            let clock = Ticks { start, every };
            let mut t = clock.after(-1.0);
            for k in 1..10_000 {
                let next = clock.after(t.t);
                assert!((next.t - t.t - every).abs() < 1e-9 * every.max(next.t), "{k}");
                assert!(clock.is_at(next.t) && !clock.is_at(next.t + 0.5 * every));
                // A sum that has lost its last digits.
                assert!(clock.is_at(next.t * (1.0 + 4.0 * f64::EPSILON)));
                t = next;
            }
        }
    }
}
