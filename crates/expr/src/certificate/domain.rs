//! Points inside of a domain: from a random start, coordinate by coordinate towards where more of the
//! functions have a value.

use crate::op::{Function, Op, small_integer};
use crate::pool::{Pool, SymbolId};
use crate::sweep::{Step, Sweep};
use std::collections::HashMap;
use std::convert::Infallible;

/// Rounds over all coordinates; a step grows or shrinks by two in each.
const MAX_ROUNDS: usize = 80;
/// Values of steps computed for all points.
const MAX_WORK: usize = 4_000_000;
/// Starts tried for each point wanted.
const STARTS: usize = 2;
/// Distance from an edge without a value, such as that of `ln` at 0, in steps that cross it.
const EDGE: f64 = 1e-3;

/// One value for each symbol.
pub(super) type Point = HashMap<SymbolId, f64>;

impl Pool {
    /// Up to `n_wanted` points where the roots have finite values.
    pub(super) fn points_inside(&self, sweep: &Sweep, n_wanted: usize) -> Vec<Point> {
        let symbols: Vec<SymbolId> = sweep.steps.iter().filter_map(Step::symbol).collect();
        let mut found = Vec::new();
        let mut work = MAX_WORK;
        for start in 0..STARTS * n_wanted {
            let point: Vec<f64> = symbols.iter().map(|&s| self.sample(s, start)).collect();
            if let Some(inside) = self.moved_inside(sweep, &symbols, point, &mut work) {
                found.push(symbols.iter().copied().zip(inside).collect());
            }
            if found.len() == n_wanted || work == 0 {
                break;
            }
        }
        found
    }

    /// The point moved to where the roots have finite values; `None` if that does not succeed.
    fn moved_inside(
        &self,
        sweep: &Sweep,
        symbols: &[SymbolId],
        mut point: Vec<f64>,
        work: &mut usize,
    ) -> Option<Vec<f64>> {
        let mut distance_at = |point: &[f64]| {
            *work = work.saturating_sub(sweep.steps.len());
            let of = |symbol: SymbolId| {
                let at = symbols.iter().position(|&s| s == symbol);
                at.map_or(f64::NAN, |at| point[at])
            };
            let Ok(values) = self.values(sweep, &|symbol| Ok::<_, Infallible>(of(symbol)));
            if *work == 0 { f64::NAN } else { distance(sweep, &values) }
        };
        let mut steps = vec![1.0; point.len()];
        let mut least = distance_at(&point);
        for _ in 0..MAX_ROUNDS {
            for i in 0..point.len() {
                if least == 0.0 {
                    return Some(point);
                }
                let from = point[i];
                let mut has_moved = false;
                for to in [from + steps[i], from - steps[i]] {
                    point[i] = to;
                    let there = distance_at(&point);
                    if there < least {
                        (least, has_moved) = (there, true);
                        break;
                    }
                    point[i] = from;
                }
                steps[i] *= if has_moved { 2.0 } else { 0.5 };
            }
        }
        (least == 0.0).then_some(point)
    }
}

/// How far arguments are from where their functions have values, in all; zero where both roots have
/// one.
fn distance(sweep: &Sweep, values: &[f64]) -> f64 {
    if sweep.roots.iter().all(|&root| values[root].is_finite()) {
        return 0.0;
    }
    let missing = sweep.steps.iter().zip(values).filter(|(_, value)| !value.is_finite());
    let distances = missing.map(|(step, _)| {
        let mut operands = sweep.operands(step).map(|o| values[o]);
        let (a, b) = (operands.next().unwrap_or(0.0), operands.next().unwrap_or(0.0));
        if !(a.is_finite() && b.is_finite()) {
            return 0.0;
        }
        EDGE + match step.op {
            Op::Call(Function::Ln | Function::Sqrt) => -a,
            Op::Call(Function::Asin | Function::Acos) => a.abs() - 1.0,
            Op::Pow if a < 0.0 && small_integer(b).is_none() => -a,
            // A pole, or a value too large.
            _ => a.abs().max(b.abs()),
        }
    });
    distances.sum()
}
