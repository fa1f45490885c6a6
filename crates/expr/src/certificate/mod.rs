//! Evidence that two expressions are equal: their values at pseudo-random points, in `f64` and in
//! twice its precision.
//!
//! Two different analytic functions agree at a random point with probability zero, so a difference
//! at the level of rounding in both precisions is as good as proof; a difference that stays in the
//! second one is a counterexample.

mod domain;
mod extended;

use crate::number::Number;
use crate::op::{Function, Op, small_integer};
use crate::pool::{Expr, Pool, SymbolId, unit_random};
use crate::sweep::Sweep;
use extended::Extended;
use std::convert::Infallible;

/// How far two expressions differ at pseudo-random points.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Certificate {
    /// Points at which both expressions have a finite value.
    pub n_points: usize,
    /// Largest relative difference of the values in `f64`.
    pub worst_double: f64,
    /// Largest relative difference of the values with 106 bits.
    pub worst_extended: f64,
    /// True if a constant is a rounded one: then more bits show the rounding, not more.
    pub is_rounded: bool,
}

impl Certificate {
    /// True if all differences are as small as rounding makes them, at one point at least.
    pub fn is_equal(&self) -> bool {
        let extended = if self.is_rounded { ROUNDED_TOLERANCE } else { EXTENDED_TOLERANCE };
        self.n_points > 0
            && self.worst_double <= DOUBLE_TOLERANCE
            && self.worst_extended <= extended
    }
}

/// Rounding to be expected of values that lose six digits to cancellation, and four to the length
/// of the computation.
const DOUBLE_TOLERANCE: f64 = 1e-6;
/// Tolerance with 31 digits to start from.
const EXTENDED_TOLERANCE: f64 = 1e-20;
/// Tolerance where constants were rounded to 16 digits when they were folded.
const ROUNDED_TOLERANCE: f64 = 1e-12;
/// Values below this part of the largest term of any sum count as cancelled: differences are taken
/// relative to it.
const CANCELLATION: f64 = 1e-6;
/// Points at which expressions are compared.
const N_POINTS: usize = 8;
/// Points tried to find them; outside a domain there is no value to compare.
const MAX_TRIED: usize = 64;

impl Pool {
    /// Compares two expressions at up to eight points, each symbol between −1.7 and 1.7.
    ///
    /// The points depend on the names of the symbols alone: the same expressions give the same
    /// certificate in every pool. Functions with names are compared as such: a smooth function stands in for each,
    /// and its derivatives for theirs. Points where one of the values is infinite or NaN, or has an
    /// argument of sine or cosine beyond 10⁹, are left out; where there are no others, points inside
    /// of the domain are searched from there. Without any point nothing is shown, and
    /// [`Certificate::is_equal`] is false.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("sin(a)*cos(b) + cos(a)*sin(b)").expect("valid");
    /// let certificate = pool.certificate(e, pool.simplify(e));
    /// assert!(certificate.is_equal() && certificate.worst_extended < 1e-28);
    ///
    /// let wrong = pool.parse("sin(a + b)*(1 + 1/10^12)").expect("valid");
    /// assert!(!pool.certificate(e, wrong).is_equal());
    /// ```
    pub fn certificate(&self, a: Expr, b: Expr) -> Certificate {
        // Two expressions with functions that have names are equal whatever these functions are.
        let roots = self.map_named(&[a, b], |function, at| self.stand_in_call(function, at));
        let sweep = self.sweep(&roots);
        let is_float =
            |e| self.as_number(e).is_some_and(|n| n.as_float().is_some_and(f64::is_finite));
        let is_rounded = sweep.steps.iter().any(|step| is_float(step.expr));
        let mut found =
            Certificate { n_points: 0, worst_double: 0.0, worst_extended: 0.0, is_rounded };
        for point in 0..MAX_TRIED {
            self.compare_at(&sweep, &|symbol| self.sample(symbol, point), &mut found);
            if found.n_points == N_POINTS {
                break;
            }
        }
        if found.n_points == 0 {
            for inside in self.points_inside(&sweep, N_POINTS) {
                self.compare_at(&sweep, &|symbol| inside[&symbol], &mut found);
            }
        }
        found
    }

    /// Compares the two roots at one point, if both have a value there.
    fn compare_at(&self, sweep: &Sweep, value: &dyn Fn(SymbolId) -> f64, found: &mut Certificate) {
        let Some(extended) = difference(&self.extended_values(sweep, value), sweep) else {
            return;
        };
        found.n_points += 1;
        found.worst_extended = found.worst_extended.max(extended);
        let Ok(values) = self.values(sweep, &|symbol| Ok::<_, Infallible>(value(symbol)));
        let values: Vec<Extended> = values.into_iter().map(Extended::from).collect();
        // Where only `f64` overflows, the extended values decide.
        let double = difference(&values, sweep).unwrap_or(0.0);
        found.worst_double = found.worst_double.max(double);
    }

    /// The value of a symbol at a point: its sign alternates at random for half of the points, and
    /// is positive for the other half, since roots and logarithms want positive arguments.
    fn sample(&self, symbol: SymbolId, point: usize) -> f64 {
        let name = self.symbol_name(symbol);
        let seed = name.bytes().fold(point as u64, |hash, byte| {
            hash.wrapping_mul(0x0100_0000_01B3).wrapping_add(u64::from(byte))
        });
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let magnitude = 0.2 + 1.5 * unit_random(&mut state);
        let is_negative = point % 2 == 1 && unit_random(&mut state) < 0.5;
        if is_negative { -magnitude } else { magnitude }
    }

    /// Values of all steps with 106 bits.
    fn extended_values(&self, sweep: &Sweep, value: &dyn Fn(SymbolId) -> f64) -> Vec<Extended> {
        let nan = Extended::from(f64::NAN);
        let mut values: Vec<Extended> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let operands = sweep.operands(step).map(|o| values[o]);
            let result = match step.op {
                Op::Number => of_number(&self.number_of(step.expr)),
                Op::Pi => extended::PI,
                Op::Symbol => Extended::from(value(SymbolId(step.data))),
                Op::Add => operands.fold(Extended::from(0.0), |sum, term| sum + term),
                Op::Mul => operands.fold(Extended::from(1.0), |product, f| product * f),
                Op::Pow => {
                    let [base, exponent] = sweep.operand_array(step).map(|o| values[o]);
                    match small_integer(exponent.high()) {
                        Some(n) if exponent.is_double() => base.powi(n),
                        _ => base.power(exponent),
                    }
                }
                Op::Pair => Extended::from(0.0),
                Op::Named => nan,
                Op::Call(Function::If) => {
                    let [condition, then, otherwise] = sweep.branches(step);
                    let holds = values[condition].high();
                    let taken = values[if holds == 0.0 { otherwise } else { then }];
                    if holds.is_nan() { nan } else { taken }
                }
                Op::Call(function) if function.arity() == 1 => {
                    let [a] = sweep.operand_array(step).map(|o| values[o]);
                    a.call(function, a)
                }
                Op::Call(function) => {
                    let [a, b] = sweep.operand_array(step).map(|o| values[o]);
                    a.call(function, b)
                }
            };
            values.push(result);
        }
        values
    }
}

/// The nearest value to a number.
fn of_number(number: &Number) -> Extended {
    if let Some((numerator, denominator)) = number.short_parts() {
        let [n, d] = [numerator, denominator].map(|part| Extended::from(i128::from(part)));
        return n / d;
    }
    // The nearest float, and the one nearest to what is missing.
    let high = Extended::from(number.to_f64());
    let rest = Number::exact_float(high.high()).map(|float| number.plus(float.negated()));
    match rest {
        Some(rest) if number.is_exact() => high + Extended::from(rest.to_f64()),
        _ => high,
    }
}

/// Relative difference of the two roots; `None` where one has no finite value.
fn difference(values: &[Extended], sweep: &Sweep) -> Option<f64> {
    let [a, b] = [values[sweep.roots[0]], values[sweep.roots[1]]];
    if !(a.high().is_finite() && b.high().is_finite()) {
        return None;
    }
    // Digits are lost to cancellation in sums alone.
    let sums = sweep.steps.iter().filter(|step| step.op == Op::Add);
    let terms = sums.flat_map(|step| sweep.operands(step)).map(|o| values[o].high().abs());
    let scale = CANCELLATION * terms.filter(|term| term.is_finite()).fold(0.0, f64::max);
    let difference = (a - b).high().abs();
    if difference == 0.0 {
        return Some(0.0);
    }
    Some(difference / scale.max(a.high().abs()).max(b.high().abs()))
}
