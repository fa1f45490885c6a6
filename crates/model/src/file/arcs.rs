//! Lengths along curves, as functions of their parameter.
//!
//! ```text
//! L(p) = ∫ |c′| dp                                     the length of a curve from a point of it
//! L(p) = |c′| (p − p₀)                                 of a line, a circle: where |c′| is one number
//! L(p) = a₀ (p − p₀) + Σ (aₖ sin kωp − bₖ cos kωp)/kω   of a closed curve: a Fourier series of |c′|
//! L(p) = Lₖ + Σ cₙ (p − pₖ)ⁿ                           of a curve in pieces: polynomials from border to border
//! ```
//!
//! The coefficients of the series are sums over points of equal distances in p, which for a smooth periodic function are
//! as good as the series is long. The polynomials go through |c′| at the points of Chebyshev, in halves of a piece where
//! they do not hold in the whole. Sources: Trefethen & Weideman (2014), "The exponentially convergent trapezoidal rule",
//! SIAM Review 56, §3; L. N. Trefethen, *Approximation Theory and Approximation Practice* (2013), chapters 3 and 8.

use std::f64::consts::{PI, TAU};

use bksim_expr::{Expr, Function, Pool, SymbolId, Tape, Workspace};

use super::pieces::{Columns, Piece};
use super::reader::Reader;
use super::value::Kind;
use crate::ids::CurveId;

/// Points of a closed curve at which |c′| is known.
const N_SAMPLES: usize = 1024;
/// The longest series.
const MOST_TERMS: usize = 160;
/// Coefficients below this part of the mean are rounding.
const ROUNDING: f64 = 1e-15;
/// Values of |c′| a period apart that differ by a larger part are not those of a closed curve.
const CLOSED: f64 = 1e-10;
/// Points of Chebyshev in a piece: the powers of one more still have coefficients without rounding.
const N_POINTS: usize = 20;
/// Largest error of a polynomial for |c′|, as a part of its largest value.
const HOLDS: f64 = 1e-12;
/// Coefficients below this part of the largest value are rounding.
const ROUNDED: f64 = 1e-14;
/// Halvings of a piece; where they are not enough the curve has a cusp.
const MOST_HALVINGS: usize = 10;
/// Most borders between the pieces of a curve.
const MOST_BORDERS: usize = 512;

impl Reader<'_> {
    /// The length of a curve from the parameter `from`, m; `None` where it is not known.
    pub(super) fn arc(&mut self, id: CurveId, from: Expr) -> Option<Expr> {
        let curve = self.curve(id)?;
        let (name, parameter, range) = (curve.name.clone(), curve.parameter, curve.range);
        let pool = &self.pool;
        let [x, y, _] = curve.position.map(|e| pool.diff(e, parameter));
        let square = pool.simplify(pool.add(pool.powi(x, 2), pool.powi(y, 2)));
        let here = pool.symbol_expr(parameter);
        if !pool.depends_on(square, parameter) {
            return Some(pool.mul(pool.sqrt(square), pool.sub(here, from)));
        }
        let sizes = self.pinned_in(&[square, range[0], range[1]]);
        let pool = &self.pool;
        let mut speed = Speed::of(pool, square, parameter, &sizes)?;
        let borders = borders(pool, square, parameter, &sizes).unwrap_or_default();
        if borders.is_empty() {
            let value = |symbol| sizes.iter().find(|size| size.0 == symbol).map(|size| size.1);
            let [start, end] = range.map(|e| pool.evaluate(e, &value).ok());
            return periodic(pool, &mut speed, [start?, end?], [here, from]);
        }
        let (x, pieces) = polynomials(&mut speed, &borders)?;
        let columns = Columns::endless([Kind::Bare; 2], [false; 2], x, pieces);
        let function = self.function_of_columns(&format!("{name}.length"), "p", &columns);
        let lengths = [here, from].map(|at| self.pool.apply(function, &[at]));
        Some(self.pool.sub(lengths[0], lengths[1]))
    }

    /// The values of the parameters of the model in some expressions: with others they need a reading of their own.
    fn pinned_in(&mut self, roots: &[Expr]) -> Vec<(SymbolId, f64)> {
        let (pool, constants) = (&self.pool, &mut self.constants);
        let is_used = |symbol: SymbolId| roots.iter().any(|&root| pool.depends_on(root, symbol));
        let used = self.parameters.iter().filter_map(|known| {
            let symbol = pool.symbol_id(known.symbol).filter(|&symbol| is_used(symbol))?;
            Some((symbol, constants.pinned(known.result.as_ref()?.value?)))
        });
        used.collect()
    }
}

/// |c′| of a curve.
struct Speed {
    tape: Tape,
    workspace: Workspace,
}

impl Speed {
    fn of(
        pool: &Pool,
        square: Expr,
        parameter: SymbolId,
        sizes: &[(SymbolId, f64)],
    ) -> Option<Self> {
        let (symbols, values): (Vec<SymbolId>, Vec<f64>) = sizes.iter().copied().unzip();
        let tape = Tape::compile(pool, &[pool.sqrt(square)], &[parameter], &symbols).ok()?;
        let workspace = tape.workspace(&values);
        Some(Self { tape, workspace })
    }

    /// Value at a parameter; `None` where it has none.
    fn at(&mut self, parameter: f64) -> Option<f64> {
        let mut speed = [0.0];
        self.tape.evaluate(&mut self.workspace, &[parameter], &mut speed);
        Some(speed[0]).filter(|speed| speed.is_finite())
    }
}

/// The parameters at which a formula becomes another one, ascending; `None` where they do not follow from numbers.
fn borders(
    pool: &Pool,
    formula: Expr,
    parameter: SymbolId,
    sizes: &[(SymbolId, f64)],
) -> Option<Vec<f64>> {
    use Function::{Abs, Ge, Gt, Le, Lt, Max, Min, Sign};
    let mut found = Some(Vec::new());
    let at_zero = |symbol| {
        let size = sizes.iter().find(|size| size.0 == symbol).map(|size| size.1);
        size.or((symbol == parameter).then_some(0.0))
    };
    pool.map_calls(&pool.expand_named(&[formula]), |function, operands| {
        let switch = match (function, operands) {
            (Abs | Sign, &[a]) => a,
            (Min | Max | Lt | Le | Gt | Ge, &[a, b]) => pool.sub(a, b),
            _ => return None,
        };
        if pool.depends_on(switch, parameter) {
            let slope = pool.simplify(pool.diff(switch, parameter));
            let is_line = !pool.depends_on(slope, parameter);
            let root = pool.neg(pool.div(switch, slope));
            let border = pool.evaluate(root, &at_zero).ok().filter(|x| is_line && x.is_finite());
            match (border, &mut found) {
                (Some(border), Some(found)) => found.push(border),
                _ => found = None,
            }
        }
        None
    });
    let mut found = found?;
    found.sort_by(f64::total_cmp);
    found.dedup();
    Some(found)
}

/// The length of a smooth curve that is closed over a range, from the second parameter to the first.
fn periodic(
    pool: &Pool,
    speed: &mut Speed,
    [start, end]: [f64; 2],
    ends: [Expr; 2],
) -> Option<Expr> {
    let period = end - start;
    let mut samples = Vec::with_capacity(N_SAMPLES);
    for k in 0..N_SAMPLES {
        samples.push(speed.at(start + period * k as f64 / N_SAMPLES as f64)?);
    }
    // What is no period shows beyond the range.
    for k in (0..N_SAMPLES).step_by(N_SAMPLES / 16) {
        let beyond = speed.at(start + period * (1.0 + k as f64 / N_SAMPLES as f64))?;
        if (beyond - samples[k]).abs() > CLOSED * samples[k] {
            return None;
        }
    }
    series(pool, &samples, start, TAU / period, ends)
}

/// The integral of a periodic function of frequency ω from `from` to `here`; `None` where its series is long.
fn series(
    pool: &Pool,
    samples: &[f64],
    start: f64,
    omega: f64,
    [here, from]: [Expr; 2],
) -> Option<Expr> {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let coefficients = |k: usize| {
        samples.iter().enumerate().fold([0.0; 2], |[a, b], (j, sample)| {
            // Of the whole turns nothing is left to round.
            let (sin, cos) = (TAU * ((j * k) % samples.len()) as f64 / n).sin_cos();
            [a + 2.0 * sample * cos / n, b + 2.0 * sample * sin / n]
        })
    };
    let all: Vec<[f64; 2]> = (1..=MOST_TERMS).map(coefficients).collect();
    let is_rounding = |c: &[f64; 2]| c.iter().all(|x| x.abs() < ROUNDING * mean);
    if !all[MOST_TERMS / 2..].iter().all(is_rounding) {
        return None;
    }
    let mut terms = vec![pool.mul(pool.float(mean), pool.sub(here, from))];
    for (k, [a, b]) in (1..).zip(all) {
        let frequency = f64::from(k) * omega;
        let phase = |at: Expr| pool.mul(pool.float(frequency), pool.sub(at, pool.float(start)));
        let [here, from] = [here, from].map(phase);
        for (size, of) in
            [(a, [pool.sin(here), pool.sin(from)]), (b, [pool.cos(from), pool.cos(here)])]
        {
            if size.abs() >= ROUNDING * mean {
                terms.push(pool.mul(pool.float(size / frequency), pool.sub(of[0], of[1])));
            }
        }
    }
    Some(pool.sum(terms))
}

/// The length of a curve from its first border, piece by piece, with the borders of these; beyond the outer ones the curve
/// goes on straight, or ends.
fn polynomials(speed: &mut Speed, borders: &[f64]) -> Option<(Vec<f64>, Vec<Piece>)> {
    let [first, .., last] = *borders else { return None };
    if borders.len() > MOST_BORDERS {
        return None;
    }
    let (mut x, mut pieces) = (vec![first], Vec::new());
    let mut length = 0.0;
    for ends in borders.windows(2) {
        // The left halves are at the top.
        let mut open = vec![([ends[0], ends[1]], 0)];
        while let Some(([from, to], halvings)) = open.pop() {
            if let Some(mut piece) = integral(speed, [from, to]) {
                piece.powers[0] = length;
                length = piece.at(to - from);
                x.push(to);
                pieces.push(piece);
            } else {
                if halvings == MOST_HALVINGS {
                    return None;
                }
                let middle = f64::midpoint(from, to);
                open.extend([[middle, to], [from, middle]].map(|half| (half, halvings + 1)));
            }
        }
    }
    let n = pieces.len();
    let slopes = [(first, pieces[0].slope(0.0)), (last, pieces[n - 1].slope(last - x[n - 1]))];
    for ((end, slope), outwards) in slopes.into_iter().zip([first - last, last - first]) {
        let beyond = [0.25, 1.0].map(|part| speed.at(end + part * outwards));
        let goes_on = |speed: &f64| (speed - slope).abs() > CLOSED * slope;
        if beyond.iter().flatten().any(goes_on) {
            return None;
        }
    }
    Some((x, pieces))
}

/// The integral of |c′| over a piece as a polynomial of the distance from its left end; `None` where there is none that
/// holds.
fn integral(speed: &mut Speed, [from, to]: [f64; 2]) -> Option<Piece> {
    let width = to - from;
    let n = N_POINTS as f64;
    let angle = |j: usize| PI * (j as f64 + 0.5) / n;
    let mut values = [0.0; N_POINTS];
    for (j, value) in values.iter_mut().enumerate() {
        *value = speed.at(from + 0.5 * width * (1.0 + angle(j).cos()))?;
    }
    let largest = values.into_iter().fold(0.0, f64::max);
    // Coefficients of the Chebyshev polynomials, those of rounding left out, then of powers of σ = (p − from)/width.
    let coefficient = |k: usize| {
        let sum: f64 = (0..N_POINTS).map(|j| values[j] * (k as f64 * angle(j)).cos()).sum();
        if k == 0 { sum / n } else { 2.0 * sum / n }
    };
    let coefficients: [f64; N_POINTS] = std::array::from_fn(coefficient);
    let last = coefficients.iter().rposition(|c| c.abs() > ROUNDED * largest)?;
    let mut powers = vec![0.0; last + 1];
    let (mut before, mut chebyshev) = ([0.0; N_POINTS], [0.0; N_POINTS]);
    chebyshev[0] = 1.0;
    for (k, coefficient) in coefficients[..=last].iter().enumerate() {
        for (power, c) in powers.iter_mut().zip(chebyshev) {
            *power += coefficient * c;
        }
        // T₁ = 2σ − 1, Tₖ₊₁ = 2 (2σ − 1) Tₖ − Tₖ₋₁.
        let factor = if k == 0 { 1.0 } else { 2.0 };
        let next = |m: usize| {
            let shifted = if m == 0 { 0.0 } else { chebyshev[m - 1] };
            factor * (2.0 * shifted - chebyshev[m]) - before[m]
        };
        (before, chebyshev) = (chebyshev, std::array::from_fn(next));
    }
    let (mut scale, mut integrated) = (1.0, vec![0.0]);
    for (m, power) in powers.into_iter().enumerate() {
        integrated.push(power * scale / (m + 1) as f64);
        scale /= width;
    }
    let piece = Piece::polynomial(integrated);
    // Between its points, and next to the ends.
    for j in 0..2 * N_POINTS {
        let s = 0.5 * width * (1.0 + (angle(j) * 0.5).cos());
        if (piece.slope(s) - speed.at(from + s)?).abs() > HOLDS * largest {
            return None;
        }
    }
    Some(piece)
}
