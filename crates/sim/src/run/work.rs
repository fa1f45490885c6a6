//! [`StepWork`]: the work of loads and drives over one step, by quadrature of their power along its dense output.
//!
//! ```text
//! P ≈ Σ c_k T_k(x),  x = (2 t − a − b)/(b − a)         at the roots of T_N, on pieces [a, b]
//! ∫ P dt = (b − a)/2 Σ c_k ∫ T_k dx                    ∫ T_k = (T_{k+1}/(k + 1) − T_{k−1}/(k − 1))/2
//! ```
//!
//! Error control of a motion knows nothing of its power: where drives leave nothing free, steps grow until
//! forces turn many times in one of them. So a piece is halved until its last two coefficients are below
//! the tolerance. Source: L. N. Trefethen, *Approximation Theory and Approximation Practice*, 2013, §19.

use std::f64::consts::FRAC_1_SQRT_2;

/// Nodes of a piece.
const N: usize = 8;
/// Pieces of a step at most: with more, the power is noise.
const MAX_PIECES: usize = 4096;
/// Rounding of a power, relative: no quadrature goes below.
const ROUNDING: f64 = 1e-12;
/// Part of the tolerance of a run that a piece may take.
const SHARE: f64 = 1e-3;

/// cos(m π/16) of the first quarter of a turn: nodes and terms are the same on all machines.
const COSINES: [f64; N + 1] = [
    1.0,
    0.980_785_280_403_230_4,
    0.923_879_532_511_286_7,
    0.831_469_612_302_545_2,
    FRAC_1_SQRT_2,
    0.555_570_233_019_602_3,
    0.382_683_432_365_089_84,
    0.195_090_322_016_128_33,
    0.0,
];

/// The tolerance that the work of a step keeps to.
#[derive(Clone, Copy, Debug)]
pub(super) struct WorkTolerance {
    pub(super) rtol: f64,
    /// J.
    pub(super) atol: f64,
    /// Work that went in and out before, J.
    pub(super) turnover: f64,
}

impl WorkTolerance {
    /// The error that is allowed with so much more work in and out, J.
    pub(super) fn allows(self, turnover: f64) -> f64 {
        self.atol + self.rtol * (self.turnover + turnover)
    }
}

/// Knowledge of the work over the present step.
#[derive(Clone, Debug)]
pub(super) enum WorkOver {
    /// The integrator has it, or there is none.
    Known,
    /// It has it not, or not well enough.
    Needed,
    /// By quadrature.
    Found(StepWork),
}

/// The work over one step at all of its instants.
#[derive(Clone, Debug, Default)]
pub(super) struct StepWork {
    pieces: Vec<Piece>,
    /// Sum of ∫ |P| dt, J.
    pub(super) turnover: f64,
}

#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    to: f64,
    /// At its start, J.
    work: f64,
    coefficients: [f64; N],
}

impl StepWork {
    /// From `work` at the start of the span, J, with the power at instants of it.
    pub(super) fn new(
        [from, to]: [f64; 2],
        mut work: f64,
        tolerance: WorkTolerance,
        mut power: impl FnMut(f64) -> f64,
    ) -> Self {
        let mut found = Self::default();
        let mut left = vec![(from, to)];
        while let Some((from, to)) = left.pop() {
            let piece = Piece::new([from, to], work, &mut power);
            let turnover = piece.turnover();
            let allowed = SHARE * tolerance.allows(found.turnover + turnover);
            let is_close = piece.tail() <= allowed.max(ROUNDING * turnover);
            let middle = 0.5 * (from + to);
            let is_last = found.pieces.len() + left.len() >= MAX_PIECES || middle == from;
            if is_close || is_last || middle == to {
                work = piece.at(to);
                found.turnover += turnover;
                found.pieces.push(piece);
            } else {
                left.extend([(middle, to), (from, middle)]);
            }
        }
        found
    }

    /// The work at an instant of the step, J.
    pub(super) fn at(&self, t: f64) -> f64 {
        let forward = self.pieces.first().map_or(1.0, |piece| (piece.to - piece.from).signum());
        let is_over = |piece: &Piece| (piece.to - t) * forward < 0.0;
        let idx = self.pieces.partition_point(is_over).min(self.pieces.len().saturating_sub(1));
        self.pieces.get(idx).map_or(0.0, |piece| piece.at(t))
    }
}

/// cos(m π/16).
fn cosine(m: usize) -> f64 {
    match m % (4 * N) {
        m @ 0..=N => COSINES[m],
        m if m <= 3 * N => -COSINES[m.abs_diff(2 * N)],
        m => COSINES[4 * N - m],
    }
}

impl Piece {
    #[expect(clippy::cast_precision_loss, reason = "a few nodes")]
    fn new([from, to]: [f64; 2], work: f64, power: &mut impl FnMut(f64) -> f64) -> Self {
        let mut values = [0.0; N];
        for (j, value) in values.iter_mut().enumerate() {
            *value = power(0.5 * (from + to) + 0.5 * (to - from) * cosine(2 * j + 1));
        }
        let mut coefficients = [0.0; N];
        for (k, coefficient) in coefficients.iter_mut().enumerate() {
            let terms = values.iter().enumerate();
            let sum: f64 = terms.map(|(j, value)| value * cosine(k * (2 * j + 1))).sum();
            *coefficient = sum * if k == 0 { 1.0 } else { 2.0 } / N as f64;
        }
        Self { from, to, work, coefficients }
    }

    fn half(&self) -> f64 {
        0.5 * (self.to - self.from)
    }

    /// Energy that the last terms may add, J.
    fn tail(&self) -> f64 {
        let [.., a, b] = self.coefficients;
        self.half().abs() * (a.abs() + b.abs())
    }

    /// ∫ |P| dt at most, J.
    fn turnover(&self) -> f64 {
        2.0 * self.half().abs() * self.coefficients.iter().fold(0.0, |sum: f64, c| sum.max(c.abs()))
    }

    fn at(&self, t: f64) -> f64 {
        if t == self.from {
            return self.work;
        }
        let x = ((t - self.from) - (self.to - t)) / (self.to - self.from);
        // T_0, T_1, …, T_N at x; at −1 they are ±1.
        let (mut before, mut now) = (1.0, x);
        let mut sum = self.coefficients[0] * (x + 1.0);
        let mut sign = -1.0;
        for (k, coefficient) in self.coefficients.iter().enumerate().skip(1) {
            let next = 2.0 * x * now - before;
            #[expect(clippy::cast_precision_loss, reason = "a few terms")]
            let k = k as f64;
            let integral = if k == 1.0 {
                0.5 * (x * x - 1.0)
            } else {
                0.5 * ((next + sign) / (k + 1.0) - (before + sign) / (k - 1.0))
            };
            sum += coefficient * integral;
            (before, now) = (now, next);
            sign = -sign;
        }
        self.work + self.half() * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosines_are_those_of_their_angles() {
        for m in 0..64 {
            let angle = f64::from(u32::try_from(m).expect("small")) * std::f64::consts::PI / 16.0;
            assert!((cosine(m) - angle.cos()).abs() < 1e-14, "{m}: {}", cosine(m));
        }
    }

    #[test]
    fn work_of_many_turns_keeps_to_its_tolerance_at_every_instant() {
        let tolerance = WorkTolerance { rtol: 1e-9, atol: 1e-12, turnover: 0.0 };
        for ([from, to], least) in [([0.0_f64, 10.0], 100), ([10.0, 0.0], 100), ([0.0, 0.01], 1)] {
            let exact = |t: f64| 2.0 + ((37.0 * from).cos() - (37.0 * t).cos()) / 37.0 + t - from;
            let found = StepWork::new([from, to], 2.0, tolerance, |t| (37.0 * t).sin() + 1.0);
            for t in [from, 0.7 * from + 0.3 * to, 0.5 * (from + to), to] {
                let error = found.at(t) - exact(t);
                assert!(error.abs() < 1e-8, "{from} to {to}: {} is off by {error:e}", found.at(t));
            }
            let n = found.pieces.len();
            assert!((least..20 * least).contains(&n), "{n} pieces");
        }
    }
}
