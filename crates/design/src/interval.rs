//! Interval arithmetic over expressions, and the proof that a pose and its slopes stay within bounds over a box.
//!
//! ```text
//! K(X) = m − Y Φ(m, P) + (I − Y Φ_q(X, P)) (X − m)
//! K(X) ⊂ X:  one pose in X for every p in P, and Φ_q is regular throughout
//! ```
//!
//! Bounds are widened by a few units in the last place after each operation, more than rounding can be off. Source:
//! Neumaier, Interval Methods for Systems of Equations, ch. 5 (Krawczyk's operator).

use bksim::expr::{Expr, Pool};
use nalgebra::DMatrix;

/// All numbers from `lo` to `hi`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Interval {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

const WHOLE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

impl Interval {
    pub(crate) fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi }
    }

    pub(crate) fn point(x: f64) -> Self {
        Self::new(x, x)
    }

    pub(crate) fn middle(self) -> f64 {
        0.5 * self.lo + 0.5 * self.hi
    }

    /// Half of its width, rounded up.
    pub(crate) fn radius(self) -> f64 {
        (self.hi - self.middle()).max(self.middle() - self.lo) * (1.0 + f64::EPSILON)
    }

    /// Largest magnitude.
    pub(crate) fn size(self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    pub(crate) fn is_within(self, other: Self) -> bool {
        self.lo > other.lo && self.hi < other.hi
    }

    /// More than the rounding of one operation, and of the library's functions.
    fn wider(self) -> Self {
        if self.lo.is_nan() || self.hi.is_nan() {
            return WHOLE;
        }
        let pad = |x: f64| 4.0 * f64::EPSILON * x.abs() + f64::MIN_POSITIVE;
        Self::new(self.lo - pad(self.lo), self.hi + pad(self.hi))
    }

    pub(crate) fn add(self, other: Self) -> Self {
        Self::new(self.lo + other.lo, self.hi + other.hi).wider()
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        self.multiply(Self::point(factor))
    }

    pub(crate) fn multiply(self, other: Self) -> Self {
        let ends = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        if ends.iter().any(|x| x.is_nan()) {
            return WHOLE;
        }
        let least = ends.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let most = ends.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        Self::new(least, most).wider()
    }

    fn inverse(self) -> Self {
        if self.lo <= 0.0 && self.hi >= 0.0 {
            WHOLE
        } else {
            Self::new(1.0 / self.hi, 1.0 / self.lo).wider()
        }
    }

    fn monotone(self, f: impl Fn(f64) -> f64) -> Self {
        Self::new(f(self.lo), f(self.hi)).wider()
    }

    fn power(self, exponent: f64) -> Self {
        if exponent == 0.0 {
            return Self::point(1.0);
        }
        if exponent < 0.0 {
            return self.power(-exponent).inverse();
        }
        if exponent.fract() == 0.0 {
            let ends = [self.lo.powf(exponent), self.hi.powf(exponent)];
            let (least, most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let is_even = exponent % 2.0 == 0.0;
            let through_zero = self.lo < 0.0 && self.hi > 0.0;
            let least = if is_even && through_zero { 0.0 } else { least };
            return Self::new(least, most).wider();
        }
        if self.lo < 0.0 { WHOLE } else { self.monotone(|x| x.powf(exponent)) }
    }

    fn sine(self) -> Self {
        use std::f64::consts::{FRAC_PI_2, TAU};
        let width = self.hi - self.lo;
        if width.is_nan() || width >= TAU || self.size() > 1e9 {
            return Self::new(-1.0, 1.0);
        }
        // Extremes at π/2 + 2 k π and −π/2 + 2 k π, a little widened.
        let has = |at: f64| {
            let k = ((self.lo - at) / TAU - 1e-12).ceil();
            at + k * TAU <= self.hi + 1e-9
        };
        let (a, b) = (self.lo.sin(), self.hi.sin());
        let least = if has(-FRAC_PI_2) { -1.0 } else { a.min(b) };
        let most = if has(FRAC_PI_2) { 1.0 } else { a.max(b) };
        Self::new(least, most).wider()
    }

    fn cosine(self) -> Self {
        self.add(Self::point(std::f64::consts::FRAC_PI_2)).sine()
    }

    fn absolute(self) -> Self {
        match self {
            Self { lo, .. } if lo >= 0.0 => self,
            Self { hi, .. } if hi <= 0.0 => Self::new(-self.hi, -self.lo),
            _ => Self::new(0.0, self.size()),
        }
    }

    /// atan2 where the x axis to the left is not met.
    fn arctangent(y: Self, x: Self) -> Self {
        if x.lo <= 0.0 && y.lo <= 0.0 && y.hi >= 0.0 {
            return Self::new(-std::f64::consts::PI, std::f64::consts::PI).wider();
        }
        let ends = [y.lo.atan2(x.lo), y.lo.atan2(x.hi), y.hi.atan2(x.lo), y.hi.atan2(x.hi)];
        let least = ends.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let most = ends.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        Self::new(least, most).wider()
    }
}

/// Functions as a list of steps, for intervals.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    steps: Vec<Step>,
    roots: Vec<usize>,
}

#[derive(Clone, Debug)]
enum Step {
    Input(usize),
    Number(f64),
    Call(String, Vec<usize>),
}

impl Steps {
    /// The steps of some expressions; `inputs` are the names of symbols in the order of their values.
    pub(crate) fn of(pool: &Pool, expressions: &[Expr], inputs: &[String]) -> Option<Self> {
        let listing = pool.listing(expressions);
        let (mut steps, mut roots) = (Vec::new(), Vec::new());
        for line in listing.lines() {
            let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
            let operands = || {
                rest.split_whitespace().map(|n| n.parse::<usize>().ok()).collect::<Option<Vec<_>>>()
            };
            match word {
                "=" => roots = operands()?,
                "symbol" => steps.push(Step::Input(inputs.iter().position(|name| name == rest)?)),
                "pi" => steps.push(Step::Number(std::f64::consts::PI)),
                "number" => {
                    let value = pool.read_listing(&format!("{line}\n= 0\n")).ok()?;
                    steps.push(Step::Number(pool.as_number(value[0])?.to_f64()));
                }
                _ => steps.push(Step::Call(word.to_owned(), operands()?)),
            }
        }
        Some(Self { steps, roots })
    }

    /// Bounds of all expressions over a box.
    pub(crate) fn over(&self, inputs: &[Interval]) -> Vec<Interval> {
        let mut values: Vec<Interval> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let value = match step {
                Step::Input(k) => inputs[*k],
                Step::Number(x) => Interval::point(*x).wider(),
                Step::Call(name, operands) => {
                    let of: Vec<Interval> = operands.iter().map(|&k| values[k]).collect();
                    call(name, &of)
                }
            };
            values.push(value);
        }
        self.roots.iter().map(|&root| values[root]).collect()
    }
}

fn call(name: &str, of: &[Interval]) -> Interval {
    match (name, of) {
        ("add", _) => of.iter().skip(1).fold(of[0], |sum, x| sum.add(*x)),
        ("mul", _) => of.iter().skip(1).fold(of[0], |product, x| product.multiply(*x)),
        ("pow", [x, n]) if n.hi - n.lo < 1e-12 => {
            // Exponents are widened numbers; those that are met are simple.
            let exponent = n.middle();
            let near = (exponent * 2.0).round() / 2.0;
            x.power(if (near - exponent).abs() < 1e-12 { near } else { exponent })
        }
        ("sin", [x]) => x.sine(),
        ("cos", [x]) => x.cosine(),
        ("sqrt", [x]) if x.lo >= 0.0 => x.monotone(f64::sqrt),
        ("exp", [x]) => x.monotone(f64::exp),
        ("ln", [x]) if x.lo > 0.0 => x.monotone(f64::ln),
        ("atan", [x]) => x.monotone(f64::atan),
        ("asin", [x]) if x.lo >= -1.0 && x.hi <= 1.0 => x.monotone(f64::asin),
        ("acos", [x]) if x.lo >= -1.0 && x.hi <= 1.0 => {
            Interval::new(x.hi.acos(), x.lo.acos()).wider()
        }
        ("tanh", [x]) => x.monotone(f64::tanh),
        ("sinh", [x]) => x.monotone(f64::sinh),
        ("abs", [x]) => x.absolute(),
        ("atan2", [y, x]) => Interval::arctangent(*y, *x),
        ("min", [a, b]) => Interval::new(a.lo.min(b.lo), a.hi.min(b.hi)),
        ("max", [a, b]) => Interval::new(a.lo.max(b.lo), a.hi.max(b.hi)),
        _ => WHOLE,
    }
}

/// A matrix of numbers times one of intervals, a row of intervals for each row.
pub(crate) fn times(a: &DMatrix<f64>, b: &[Vec<Interval>]) -> Vec<Vec<Interval>> {
    let columns = b.first().map_or(0, Vec::len);
    let entry = |i: usize, j: usize| {
        let terms = (0..a.ncols()).map(|k| b[k][j].scaled(a[(i, k)]));
        terms.fold(Interval::point(0.0), Interval::add)
    };
    (0..a.nrows()).map(|i| (0..columns).map(|j| entry(i, j)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_every_value_of_a_sample() {
        let pool = Pool::new();
        let texts = [
            "sin(x)*y + x^3",
            "cos(x)/(2 + y)",
            "sqrt(x + 2)*atan2(x, y + 2)",
            "abs(x)^2 - y^2",
            "x^2 + exp(y)",
            "1/(x + 3)^2",
        ];
        let all: Vec<Expr> =
            texts.iter().map(|text| pool.parse(text).expect("an expression")).collect();
        let names = ["x".to_owned(), "y".to_owned()];
        let steps = Steps::of(&pool, &all, &names).expect("steps");
        let symbols = [pool.find_symbol("x").expect("x"), pool.find_symbol("y").expect("y")];
        let tape = bksim::expr::Tape::compile(&pool, &all, &symbols, &[]).expect("a tape");
        let bounds = steps.over(&[Interval::new(-0.7, 1.9), Interval::new(-0.4, 0.3)]);
        let mut space = tape.workspace(&[]);
        let mut values = vec![0.0; all.len()];
        for i in 0..=40 {
            for j in 0..=40 {
                let at = [-0.7 + 2.6 * f64::from(i) / 40.0, -0.4 + 0.7 * f64::from(j) / 40.0];
                tape.evaluate(&mut space, &at, &mut values);
                for ((value, bound), text) in values.iter().zip(&bounds).zip(texts) {
                    assert!(
                        bound.lo <= *value && *value <= bound.hi,
                        "{text}: {value} in {bound:?}"
                    );
                }
            }
        }
        assert!(bounds[0].hi < 10.0 && bounds[5].hi < 1.0, "not wider than need be: {bounds:?}");
    }
}
