//! Half turns of ropes and belts: numbers that change within a run, and no value of the motion with them.
//!
//! ```text
//! ψ = π k + δ,  |δ| ≤ π      angle of a span since the start; k is counted on where |δ| comes to be so much above π/2
//! ```
//!
//! So δ never comes near π, where it would jump. A step is followed through its dense output, and ends where one is counted.

use std::f64::consts::{PI, TAU};

use bksim_dae::Step;
use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_model::{HeldChange, Model};

use crate::function::{Buffers, Function};

/// Half a turn is counted where |δ| is between these, rad.
const COUNTED: [f64; 2] = [1.8, 2.8];
/// Parts of a step in each of which a span turns by less than π − 1.8 rad: steps grow by less than that many times, from
/// one that has not turned by 1.8 rad.
const PARTS: u32 = 16;
/// Bisections of a part, more than a number has digits.
const MOST_BISECTIONS: u32 = 60;

/// Half a turn that a step comes to, with the instant, s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum HalfTurn {
    /// The step up to there is right.
    At(f64),
    /// The step goes on to where δ jumps, and is no part of the run; the instant is about right.
    Ahead(f64),
}

/// The counts of one mechanism, compiled.
#[derive(Clone, Debug)]
pub(crate) struct HalfTurns {
    /// Places among the signals that are held.
    signals: Vec<usize>,
    /// δ of each, rad: of t, q and the values held.
    left_over: Function,
}

impl HalfTurns {
    /// Compiles the counts among the signals that are held; `arguments` are t, q, and these.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither an argument nor a parameter.
    pub(crate) fn compile(
        model: &Model,
        measures: &[(SymbolId, Expr)],
        arguments: [&[SymbolId]; 3],
        own: &[SymbolId],
    ) -> Result<Self, TapeError> {
        let counts = model.held.iter().enumerate().filter_map(|(k, signal)| match signal.change {
            HeldChange::HalfTurn { left_over } => {
                Some((k, model.pool.substitute(left_over, measures)))
            }
            HeldChange::Tick { .. } | HeldChange::Event { .. } => None,
        });
        let (signals, left_over): (Vec<usize>, Vec<_>) = counts.unzip();
        let left_over = Function::compile(model, &left_over, &arguments, own)?;
        Ok(Self { signals, left_over })
    }

    /// True if nothing is counted.
    pub(crate) fn is_empty(&self) -> bool {
        self.signals.is_empty()
    }

    /// Buffers for these parameters.
    pub(crate) fn buffers(&self, parameters: &[f64]) -> Buffers {
        self.left_over.buffers(parameters)
    }

    /// The first half turn that is to be counted in a step.
    pub(crate) fn first_in(
        &self,
        buffers: &mut Buffers,
        step: &Step<'_>,
        held: &[f64],
    ) -> Option<HalfTurn> {
        let nq = self.left_over.tape().n_inputs() - 1 - held.len();
        let mut y = vec![0.0; step.y1().len()];
        let mut angles = |t: f64| {
            step.at(t, &mut y);
            self.left_over.evaluate(buffers, &[&[t], &y[..nq], held]).to_vec()
        };
        let mut from = step.t0();
        let mut before = angles(from);
        let mut first: Option<f64> = None;
        for k in 1..=PARTS {
            let part = f64::from(k) / f64::from(PARTS);
            let to = step.t0() + part * (step.t1() - step.t0());
            let to = if k == PARTS { step.t1() } else { to };
            let now = followed(&before, &angles(to));
            let reached = largest(&now);
            if first.is_none() && reached > COUNTED[0] {
                // Not so far that δ has jumped.
                let (mut low, mut high, mut t, mut there) = (from, to, to, reached);
                for _ in 0..MOST_BISECTIONS {
                    if there > COUNTED[1] {
                        high = t;
                    } else if there <= COUNTED[0] {
                        low = t;
                    } else {
                        break;
                    }
                    t = 0.5 * (low + high);
                    there = largest(&followed(&before, &angles(t)));
                }
                first = Some(t);
            }
            if let Some(t) = first
                && reached > COUNTED[1]
            {
                return Some(HalfTurn::Ahead(t));
            }
            (from, before) = (to, now);
        }
        first.map(HalfTurn::At)
    }

    /// Counts the half turns up to a state.
    pub(crate) fn count(&self, buffers: &mut Buffers, (t, q): (f64, &[f64]), held: &mut [f64]) {
        let left_over = self.left_over.evaluate(buffers, &[&[t], q, held]);
        for (&signal, angle) in self.signals.iter().zip(left_over) {
            if angle.abs() > COUNTED[0] {
                held[signal] += angle.signum();
            }
        }
    }
}

/// Angles followed from those before, within half a turn of them.
fn followed(before: &[f64], now: &[f64]) -> Vec<f64> {
    let on = |(before, now): (&f64, &f64)| before + (now - before + PI).rem_euclid(TAU) - PI;
    before.iter().zip(now).map(on).collect()
}

fn largest(angles: &[f64]) -> f64 {
    angles.iter().fold(0.0, |largest, angle| angle.abs().max(largest))
}
