//! Expressions for property tests: recipes over every operator and function, with shared parts,
//! built in any order, and a value that owes nothing to the library.

#![allow(dead_code, reason = "each program of tests uses its own part of this")]
#![allow(clippy::disallowed_methods, reason = "these values owe nothing to the library")]

use bksim_expr::{Expr, Function, Pool, SymbolId};
use proptest::prelude::*;

/// Largest part of a value that is compared: beyond it, rounding alone could explain anything.
const MAX_SCALE: f64 = 1e6;
/// The symbols of recipes.
pub(crate) const NAMES: [&str; 5] = ["a", "b", "q1", "q2", "q3"];
/// Values of the symbols, in the order of [`NAMES`].
pub(crate) type Point = [f64; NAMES.len()];

/// One step of a recipe; operands are earlier steps, by index.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    Symbol(usize),
    Rational(i64, i64),
    Pi,
    /// Terms with their signs.
    Sum(Vec<(usize, bool)>),
    Product(Vec<usize>),
    Quotient(usize, usize),
    IntegerPower(usize, i64),
    Power(usize, usize),
    Call(Function, [usize; 3]),
}

/// An expression as the steps that build it; the last one is the result.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    pub(crate) steps: Vec<Step>,
}

/// Functions that expressions of mechanics are made of.
pub(crate) const SMOOTH: [Function; 6] =
    [Function::Sin, Function::Cos, Function::Sin, Function::Cos, Function::Tan, Function::Sqrt];

/// Every function the library knows.
pub(crate) fn every_function() -> Vec<Function> {
    Function::names().filter_map(Function::from_name).collect()
}

fn leaf() -> impl Strategy<Value = Step> {
    prop_oneof![
        6 => (0..NAMES.len()).prop_map(Step::Symbol),
        2 => (-4i64..5).prop_map(|n| Step::Rational(n, 1)),
        1 => (-5i64..6, 2i64..5).prop_map(|(n, d)| Step::Rational(n, d)),
        1 => Just(Step::Pi),
    ]
}

/// A step whose operands are any numbers, taken modulo the number of earlier steps.
fn inner(functions: Vec<Function>) -> impl Strategy<Value = Step> {
    let at = || 0..1000usize;
    prop_oneof![
        5 => prop::collection::vec((at(), any::<bool>()), 2..5).prop_map(Step::Sum),
        5 => prop::collection::vec(at(), 2..4).prop_map(Step::Product),
        1 => (at(), at()).prop_map(|(a, b)| Step::Quotient(a, b)),
        2 => (at(), prop::sample::select(vec![2, 3, -1, -2, 0]))
            .prop_map(|(a, n)| Step::IntegerPower(a, n)),
        1 => (at(), at()).prop_map(|(a, b)| Step::Power(a, b)),
        6 => (prop::sample::select(functions), [at(), at(), at()])
            .prop_map(|(f, operands)| Step::Call(f, operands)),
    ]
}

/// Recipes of up to `n_inner` operations with the given functions.
pub(crate) fn recipes(functions: Vec<Function>, n_inner: usize) -> impl Strategy<Value = Recipe> {
    let leaves = prop::collection::vec(leaf(), 3..7);
    let inner = prop::collection::vec(inner(functions), 1..=n_inner);
    (leaves, inner).prop_map(|(mut steps, inner)| {
        for step in inner {
            let n = steps.len();
            // Recent steps more often, or most of the recipe would not be used.
            let earlier =
                |i: usize| if i.is_multiple_of(2) { n - 1 - (i / 2) % n.min(3) } else { i % n };
            steps.push(match step {
                Step::Sum(terms) => {
                    Step::Sum(terms.into_iter().map(|(t, sign)| (earlier(t), sign)).collect())
                }
                Step::Product(factors) => Step::Product(factors.into_iter().map(earlier).collect()),
                Step::Quotient(a, b) => Step::Quotient(earlier(a), earlier(b)),
                Step::IntegerPower(a, n) => Step::IntegerPower(earlier(a), n),
                Step::Power(a, b) => Step::Power(earlier(a), earlier(b)),
                Step::Call(f, operands) => Step::Call(f, operands.map(earlier)),
                leaf => leaf,
            });
        }
        Recipe { steps }
    })
}

/// Points in general position, and points at poles, on branch cuts, at ±0 and multiples of π/2.
pub(crate) fn points() -> impl Strategy<Value = Point> {
    let special = prop::sample::select(vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        2.0,
        std::f64::consts::FRAC_PI_2,
        -std::f64::consts::FRAC_PI_2,
        std::f64::consts::PI,
        -std::f64::consts::PI,
        2.0 * std::f64::consts::PI,
        std::f64::consts::FRAC_PI_4,
    ]);
    let coordinate = prop_oneof![2 => -2.0..2.0, 1 => special];
    prop::array::uniform5(coordinate)
}

/// A fixed sequence of numbers for shuffling.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// A number between −1 and 1.
    fn signed(&mut self) -> f64 {
        self.below(2_000_001) as f64 / 1e6 - 1.0
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        usize::try_from((z ^ (z >> 31)) % n as u64).expect("below a usize")
    }
}

impl Recipe {
    /// Builds the steps one after the other.
    pub(crate) fn build(&self, pool: &Pool) -> Expr {
        let mut built: Vec<Expr> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let e = |i: &usize| built[*i];
            built.push(match step {
                Step::Sum(terms) => pool.sum(terms.iter().map(|(term, is_negative)| {
                    if *is_negative { pool.neg(e(term)) } else { e(term) }
                })),
                Step::Product(factors) => pool.product(factors.iter().map(e)),
                other => build_step(pool, other, &built),
            });
        }
        built[built.len() - 1]
    }

    /// Builds the steps in random order, sums and products two by two in random order too, with
    /// other expressions between.
    pub(crate) fn build_in_disorder(&self, pool: &Pool, random: &mut Random) -> Expr {
        let mut built = vec![pool.zero(); self.steps.len()];
        let mut left: Vec<usize> = (0..self.steps.len()).collect();
        let mut is_built = vec![false; self.steps.len()];
        while !left.is_empty() {
            let ready: Vec<usize> = left
                .iter()
                .copied()
                .filter(|&i| self.steps[i].operands().iter().all(|&o| is_built[o]))
                .collect();
            let next = ready[random.below(ready.len())];
            if random.below(3) == 0 {
                let junk = pool.symbol(&format!("junk{}", random.below(5)));
                pool.sin(pool.mul(junk, built[random.below(built.len())]));
            }
            built[next] = match &self.steps[next] {
                Step::Sum(terms) => {
                    let terms = terms.iter().map(|(term, is_negative)| {
                        if *is_negative { pool.neg(built[*term]) } else { built[*term] }
                    });
                    two_by_two(terms.collect(), random, &|a, b| pool.add(a, b))
                }
                Step::Product(factors) => {
                    let factors = factors.iter().map(|&factor| built[factor]).collect();
                    two_by_two(factors, random, &|a, b| pool.mul(a, b))
                }
                other => build_step(pool, other, &built),
            };
            is_built[next] = true;
            left.retain(|&i| i != next);
        }
        built[built.len() - 1]
    }

    /// The recipe with a symbol replaced by the result of another recipe.
    pub(crate) fn with_symbol_replaced(&self, symbol: usize, inner: &Self) -> Self {
        let mut steps = inner.steps.clone();
        let (offset, result) = (steps.len(), steps.len() - 1);
        let position = |i: usize| match self.steps[i] {
            Step::Symbol(found) if found == symbol => result,
            _ => offset + i,
        };
        steps.extend(self.steps.iter().map(|step| match step {
            Step::Symbol(_) | Step::Rational(..) | Step::Pi => step.clone(),
            Step::Sum(terms) => Step::Sum(terms.iter().map(|t| (position(t.0), t.1)).collect()),
            Step::Product(factors) => Step::Product(factors.iter().map(|&f| position(f)).collect()),
            Step::Quotient(a, b) => Step::Quotient(position(*a), position(*b)),
            Step::IntegerPower(a, n) => Step::IntegerPower(position(*a), *n),
            Step::Power(a, b) => Step::Power(position(*a), position(*b)),
            Step::Call(f, operands) => Step::Call(*f, operands.map(position)),
        }));
        Self { steps }
    }

    /// The values of all steps as plain floating-point arithmetic gives them.
    pub(crate) fn values(&self, point: &Point) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let v = |i: &usize| values[*i];
            values.push(match step {
                Step::Symbol(i) => point[*i],
                Step::Rational(n, d) => *n as f64 / *d as f64,
                Step::Pi => std::f64::consts::PI,
                Step::Sum(terms) => {
                    terms.iter().map(|(t, negative)| if *negative { -v(t) } else { v(t) }).sum()
                }
                Step::Product(factors) => factors.iter().map(v).product(),
                Step::Quotient(a, b) => v(a) / v(b),
                Step::IntegerPower(a, n) => v(a).powi(i32::try_from(*n).expect("small")),
                Step::Power(a, b) => v(a).powf(v(b)),
                Step::Call(f, [a, b, c]) => call(*f, v(a), v(b), v(c)),
            });
        }
        values
    }

    /// The steps the result depends on.
    fn used(&self) -> Vec<bool> {
        let mut is_used = vec![false; self.steps.len()];
        is_used[self.steps.len() - 1] = true;
        for i in (0..self.steps.len()).rev().filter(|&i| i + 1 == self.steps.len() || i > 0) {
            if is_used[i] {
                self.steps[i].operands().into_iter().for_each(|o| is_used[o] = true);
            }
        }
        is_used
    }

    /// Whether some computed argument lies, up to rounding, on the edge of a domain, at a jump, on
    /// a branch cut or at a pole. (The symbols themselves are exact.)
    fn is_on_edge(&self, values: &[f64], used: &[bool], scale: f64) -> bool {
        let is_exact = |i: usize| matches!(self.steps[i], Step::Symbol(_) | Step::Rational(..));
        let is_near =
            |i: usize, edge: f64| !is_exact(i) && (values[i].abs() - edge).abs() < 1e-12 * scale;
        self.steps.iter().zip(used).filter(|(_, used)| **used).any(|(step, _)| match step {
            Step::Call(Function::Sqrt | Function::Ln | Function::Sign | Function::If, [a, ..])
            | Step::Quotient(_, a) => is_near(*a, 0.0),
            Step::Call(Function::Asin | Function::Acos, [a, ..]) => is_near(*a, 1.0),
            Step::Call(Function::Atan2, [y, x, _]) => is_near(*y, 0.0) && values[*x] <= 0.0,
            Step::Call(Function::Lt | Function::Le | Function::Gt | Function::Ge, [a, b, _]) => {
                let is_equal = (values[*a] - values[*b]).abs() < 1e-12 * scale;
                is_equal && !(is_exact(*a) && is_exact(*b))
            }
            Step::IntegerPower(base, n) => *n < 0 && is_near(*base, 0.0),
            // A power of a negative number needs an exponent that is an integer exactly.
            Step::Power(a, b) => {
                is_near(*a, 0.0)
                    || values[*a] <= 0.0 && !matches!(self.steps[*b], Step::Rational(..))
            }
            _ => false,
        })
    }

    /// The results allowed at a point.
    pub(crate) fn expected(&self, point: &Point) -> Expected {
        let used = self.used();
        let scale_of = |values: &[f64]| {
            let parts = values.iter().zip(&used).filter(|(v, used)| **used && v.is_finite());
            parts.map(|(v, _)| v.abs()).fold(1.0, f64::max)
        };
        let has_values =
            |values: &[f64]| values.iter().zip(&used).all(|(v, used)| !used || v.is_finite());
        let values = self.values(point);
        let (value, scale) = (values[values.len() - 1], scale_of(&values));
        let mut random = Random(7);
        let mut around = |distance: f64| -> Vec<f64> {
            let values = (0..12).map(|_| {
                let shift = |x: f64| x + distance * x.abs().max(1.0) * random.signed();
                self.values(&point.map(shift))
            });
            let tame = values.filter(|values| has_values(values) && scale_of(values) <= MAX_SCALE);
            tame.map(|values| values[values.len() - 1]).collect()
        };
        let (nearby, ring) = (around(1e-10), around(3e-3));
        let has_value = has_values(&values);
        let is_on_edge = self.is_on_edge(&values, &used, scale);
        Expected { value, has_value, is_on_edge, nearby, ring, scale }
    }
}

impl Step {
    pub(crate) fn operands(&self) -> Vec<usize> {
        match self {
            Self::Symbol(_) | Self::Rational(..) | Self::Pi => Vec::new(),
            Self::Sum(terms) => terms.iter().map(|term| term.0).collect(),
            Self::Product(factors) => factors.clone(),
            Self::Quotient(a, b) | Self::Power(a, b) => vec![*a, *b],
            Self::IntegerPower(a, _) => vec![*a],
            Self::Call(function, operands) => operands[..function.arity()].to_vec(),
        }
    }
}

fn build_step(pool: &Pool, step: &Step, built: &[Expr]) -> Expr {
    match step {
        Step::Symbol(i) => pool.symbol(NAMES[*i]),
        Step::Rational(n, d) => pool.rational(*n, *d),
        Step::Pi => pool.pi(),
        Step::Quotient(a, b) => pool.div(built[*a], built[*b]),
        Step::IntegerPower(a, n) => pool.powi(built[*a], *n),
        Step::Power(a, b) => pool.pow(built[*a], built[*b]),
        Step::Call(function, operands) => {
            let operands = operands.map(|o| built[o]);
            pool.call(*function, &operands[..function.arity()]).expect("its own arity")
        }
        Step::Sum(_) | Step::Product(_) => pool.zero(),
    }
}

fn two_by_two(mut rest: Vec<Expr>, random: &mut Random, op: &dyn Fn(Expr, Expr) -> Expr) -> Expr {
    while rest.len() > 1 {
        let a = rest.swap_remove(random.below(rest.len()));
        let b = rest.swap_remove(random.below(rest.len()));
        rest.push(op(a, b));
    }
    rest[0]
}

/// The functions by the standard library alone.
fn call(function: Function, a: f64, b: f64, c: f64) -> f64 {
    match function.name() {
        "sin" => a.sin(),
        "cos" => a.cos(),
        "tan" => a.tan(),
        "asin" => a.asin(),
        "acos" => a.acos(),
        "atan" => a.atan(),
        "sinh" => a.sinh(),
        "cosh" => a.cosh(),
        "tanh" => a.tanh(),
        "exp" => a.exp(),
        "ln" => a.ln(),
        "sqrt" => a.sqrt(),
        "abs" => a.abs(),
        "sign" if a == 0.0 => a,
        "sign" => a.signum(),
        "floor" => a.floor(),
        "atan2" => a.atan2(b),
        "min" | "max" if a.is_nan() || b.is_nan() => f64::NAN,
        "min" => a.min(b),
        "max" => a.max(b),
        "lt" => f64::from(a < b),
        "le" => f64::from(a <= b),
        "gt" => f64::from(a > b),
        "ge" => f64::from(a >= b),
        "if" if a.is_nan() => a,
        "if" if a == 0.0 => c,
        "if" => b,
        name => panic!("no value for `{name}`"),
    }
}

/// The values that an expression equal to a recipe may have at a point.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    /// The value of the recipe there.
    pub(crate) value: f64,
    /// Whether every part of the recipe has a finite value there.
    pub(crate) has_value: bool,
    /// Whether rounding decides if there is a value, or which.
    pub(crate) is_on_edge: bool,
    /// Values very near: where the recipe jumps, those of both sides are among them.
    pub(crate) nearby: Vec<f64>,
    /// Values around: near them lies the limit, if there is one.
    pub(crate) ring: Vec<f64>,
    /// Largest magnitude of any part: cancellation loses digits relative to it.
    pub(crate) scale: f64,
}

impl Expected {
    /// Whether `found` is right.
    ///
    /// - Where every part has a finite value, so has the result, and it is the same up to rounding;
    ///   where the function jumps, it may be the value of either side.
    /// - Elsewhere the result may have no value either. If it has one, the singularity was removed:
    ///   by filling it, when the value is that of the points around; by parts that have no value
    ///   cancelling, when around there is no value to compare with.
    pub(crate) fn allows(&self, found: f64) -> bool {
        if self.scale > MAX_SCALE || self.is_on_edge {
            return true;
        }
        if self.has_value {
            let spread = self.nearby.iter().map(|v| (v - self.value).abs()).fold(0.0, f64::max);
            return (found - self.value).abs() <= 10.0 * spread + 1e-9 * self.scale;
        }
        let is_limit = |v: &f64| (v - found).abs() <= 0.05 * (1.0 + v.abs());
        // A part may have been infinite and the whole still finite: 1/(1/0) is 0.
        let is_same = is_limit(&self.value);
        !found.is_finite() || is_same || self.ring.is_empty() || self.ring.iter().any(is_limit)
    }
}

/// The symbols of recipes in a pool.
pub(crate) fn symbols(pool: &Pool) -> [SymbolId; NAMES.len()] {
    NAMES.map(|name| pool.symbol_id(pool.symbol(name)).expect("a symbol"))
}

/// The value of an expression at a point.
pub(crate) fn value_at(pool: &Pool, e: Expr, point: &Point) -> f64 {
    let symbols = symbols(pool);
    pool.evaluate(e, &|s| symbols.iter().position(|&x| x == s).map(|i| point[i]))
        .expect("only the symbols of recipes occur")
}

/// Weighted operations on the shared graph, as the folding suite counts them: 1 for a sum or
/// product, 4 for a division, 12 for each sine, cosine or tangent, 8 for any other function.
pub(crate) fn cost(pool: &Pool, e: Expr) -> u64 {
    let count = pool.operation_count(&[e]);
    let text = pool.to_text(e);
    // Distinct calls by their printed text.
    let mut calls = std::collections::BTreeSet::new();
    for name in ["sin(", "cos(", "tan("] {
        for (at, _) in text.match_indices(name) {
            let mut depth = 0;
            let end = text[at..].find(|c| {
                depth += i32::from(c == '(') - i32::from(c == ')');
                c == ')' && depth == 0
            });
            calls.insert(&text[at..=at + end.unwrap_or(0)]);
        }
    }
    let n_trig = calls.len() as u64;
    count.multiplications
        + count.additions
        + 4 * count.divisions
        + 8 * (count.calls - n_trig)
        + 12 * n_trig
}
