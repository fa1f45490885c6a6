//! Joints of two curves in touch, and the lengths along curves that roll on each other.
//!
//! ```text
//! L(p) = ∫ |c′| dp                                     the length of a curve from a point of it
//! L(p) = |c′| (p − p₀)                                 of a line, a circle: where |c′| is one number
//! L(p) = a₀ (p − p₀) + Σ (aₖ sin kωp − bₖ cos kωp)/kω   of a closed curve: a Fourier series of |c′|
//! ```
//!
//! The coefficients are sums over points of equal distances in p, which for a smooth periodic function are
//! as good as the series is long. Source: Trefethen & Weideman (2014), "The exponentially convergent
//! trapezoidal rule", SIAM Review 56, §3.

use std::f64::consts::TAU;

use bksim_expr::{Expr, Pool, SymbolId};

use super::codes;
use super::reader::{Fields, Reader};
use super::units::Quantity;
use super::value::Scope;
use crate::curve::Curve;
use crate::diagnostic::Diagnostic;
use crate::ids::CurveId;
use crate::joint::JointKind;

/// How the tangents of two curves point where they touch.
const TANGENTS: [(&str, bool); 2] = [("opposite", false), ("same", true)];

/// Points of a closed curve at which |c′| is known.
const N_SAMPLES: usize = 1024;
/// The longest series.
const MOST_TERMS: usize = 160;
/// Coefficients below this part of the mean are rounding.
const ROUNDING: f64 = 1e-15;
/// Values of |c′| a period apart that differ by a larger part are not those of a closed curve.
const CLOSED: f64 = 1e-10;

impl Reader<'_> {
    /// A joint of type `curve-on-curve`.
    pub(super) fn curves_in_touch(&mut self, fields: &Fields<'_>) -> Option<JointKind> {
        let curves = ["curve", "second_curve"].map(|key| self.curve_of(fields, key));
        let is_same_way = match fields.get("tangents") {
            Some(node) => self.choice(node, &fields.what("tangents"), &TANGENTS),
            None => Some(false),
        };
        let together = fields.has("rolling").then(|| self.points_together(fields));
        let [first, second] = [curves[0]?, curves[1]?];
        let arcs = match together {
            Some(together) => Some(self.arcs(fields, [first, second], together?)?),
            None => None,
        };
        Some(JointKind::CurveOnCurve { curves: [first, second], is_same_way: is_same_way?, arcs })
    }

    /// The parameters of two points that come together.
    fn points_together(&mut self, fields: &Fields<'_>) -> Option<[Expr; 2]> {
        const EXAMPLE: &str = "[0, \"pi\"]";
        let node = fields.get("rolling")?;
        let what = fields.what("rolling");
        let kind = "an array of two parameters";
        let nodes = self.array(node, &what, kind, EXAMPLE)?;
        let [first, second] = nodes else {
            let help = "write the parameters of two points that come together, such as [0, \"pi\"]";
            self.wrong_kind(node, &what, kind, &node.value, help);
            return None;
        };
        let [first, second] =
            [first, second].map(|n| self.scalar(n, Quantity::ANGLE, &what, Scope::Constant));
        Some([first?.expr, second?.expr])
    }

    /// The lengths of both curves from the points that come together.
    fn arcs(
        &mut self,
        fields: &Fields<'_>,
        curves: [CurveId; 2],
        together: [Expr; 2],
    ) -> Option<[Expr; 2]> {
        let mut arcs = [self.pool.zero(); 2];
        for (place, id) in curves.into_iter().enumerate() {
            let from = together[place];
            let Some(length) = arc(&self.pool, self.curve(id)?, from) else {
                let help = "write numbers in the formula and the whole period in `range`, or remove `rolling`: the curves then slide";
                self.without_length(fields, id, ("rolls", "rolling", "without slip"), help);
                return None;
            };
            arcs[place] = length;
        }
        Some(arcs)
    }

    /// The length along a curve from the parameter zero, on which the owner of `fields` rubs.
    pub(super) fn length_along(&mut self, fields: &Fields<'_>, id: CurveId) -> Option<Expr> {
        let from = self.pool.zero();
        let length = arc(&self.pool, self.curve(id)?, from);
        if length.is_none() {
            let help = "write numbers in the formula and the whole period in `range`, or remove the friction";
            self.without_length(fields, id, ("rubs", "mu", "slides along it"), help);
        }
        length
    }

    /// The fault of a curve whose length has no formula.
    fn without_length(
        &mut self,
        fields: &Fields<'_>,
        id: CurveId,
        (what, key, label): (&str, &str, &str),
        help: &str,
    ) {
        let Some(curve) = self.curve(id) else { return };
        let (name, owner) = (&curve.name, &fields.owner);
        let message =
            format!("the length along curve `{name}`, on which {owner} {what}, is not known");
        let note = "lengths are known of curves whose formula is a line, a circle, or smooth and closed over its `range`, with numbers for all sizes but those of circles";
        self.report(
            Diagnostic::error(codes::NO_CURVE, message)
                .at(fields.location(&[key]), label)
                .note(note)
                .help(help),
        );
    }
}

/// The length of a curve from the parameter `from`, m.
fn arc(pool: &Pool, curve: &Curve, from: Expr) -> Option<Expr> {
    let parameter = curve.parameter;
    let [x, y, _] = curve.position.map(|e| pool.diff(e, parameter));
    let square = pool.simplify(pool.add(pool.powi(x, 2), pool.powi(y, 2)));
    let here = pool.symbol_expr(parameter);
    if !pool.depends_on(square, parameter) {
        return Some(pool.mul(pool.sqrt(square), pool.sub(here, from)));
    }
    let [start, end] =
        curve.range.map(|e| pool.evaluate(e, &|_: SymbolId| None).ok().filter(|x| x.is_finite()));
    let (start, period) = (start?, end? - start?);
    let speed = |at: f64| {
        let value = |symbol: SymbolId| (symbol == parameter).then_some(at);
        pool.evaluate(square, &value).ok().filter(|x| x.is_finite()).map(f64::sqrt)
    };
    let mut samples = Vec::with_capacity(N_SAMPLES);
    for k in 0..N_SAMPLES {
        samples.push(speed(start + period * k as f64 / N_SAMPLES as f64)?);
    }
    // What is no period shows beyond the range.
    for k in (0..N_SAMPLES).step_by(N_SAMPLES / 16) {
        let beyond = speed(start + period * (1.0 + k as f64 / N_SAMPLES as f64))?;
        if (beyond - samples[k]).abs() > CLOSED * samples[k] {
            return None;
        }
    }
    series(pool, &samples, start, TAU / period, [here, from])
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
