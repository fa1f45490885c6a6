//! Functions of one variable, piece by piece: the numbers of tables and cam laws.

use super::value::Kind;
use crate::table::FunctionPiece;

/// A function of one variable, piece by piece.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub(super) kinds: [Kind; 2],
    pub(super) are_angles: [bool; 2],
    /// Ascending arguments, SI.
    pub(super) x: Vec<f64>,
    /// By interval.
    pub(super) pieces: Vec<Piece>,
    pub(super) beyond: Beyond,
}

/// A function of the distance s from the left end of an interval: powers of s and A sin(ω s + φ).
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Coefficients, of the power 0 first.
    pub(super) powers: Vec<f64>,
    /// A, ω and φ.
    pub(super) sine: Option<[f64; 3]>,
}

/// The way between two rows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Interpolation {
    /// A cubic spline with continuous second derivatives, which are zero at the ends.
    Smooth,
    /// Polynomials with continuous second derivatives, which rise and fall only where the rows do.
    Monotone,
    /// Straight lines.
    Linear,
}

/// The values of a table outside of its rows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Beyond {
    /// No value beyond the ends: the run ends there.
    Refused,
    /// The last value.
    Constant,
    /// The last polynomial's tangent.
    Linear,
}

impl Columns {
    /// The pieces between borders that ascend, one more than pieces; there is nothing beyond them.
    pub(super) fn new(
        kinds: [Kind; 2],
        are_angles: [bool; 2],
        x: Vec<f64>,
        pieces: Vec<Piece>,
    ) -> Self {
        Self { kinds, are_angles, x, pieces, beyond: Beyond::Refused }
    }

    /// Columns ([`Columns::new`]) whose end pieces go on straight beyond the ends.
    pub(super) fn endless(
        kinds: [Kind; 2],
        are_angles: [bool; 2],
        x: Vec<f64>,
        pieces: Vec<Piece>,
    ) -> Self {
        Self { beyond: Beyond::Linear, ..Self::new(kinds, are_angles, x, pieces) }
    }

    /// The piece that holds at an argument, and the distance from its left end.
    fn piece(&self, x: f64) -> (&Piece, f64) {
        let k = self.x.partition_point(|&from| from <= x).clamp(1, self.pieces.len()) - 1;
        (&self.pieces[k], x - self.x[k])
    }

    pub(super) fn at(&self, x: f64) -> f64 {
        let (first, last) = (self.x[0], self.x[self.x.len() - 1]);
        let inside = x.clamp(first, last);
        let (piece, s) = self.piece(inside);
        let value = piece.at(s);
        match self.beyond {
            Beyond::Refused if inside != x => f64::NAN,
            Beyond::Linear => value + self.slope(inside) * (x - inside),
            _ => value,
        }
    }

    pub(super) fn slope(&self, x: f64) -> f64 {
        let (piece, s) = self.piece(x);
        piece.slope(s)
    }

    /// From where each piece holds and from where its distance counts, with one before and one behind the rows.
    pub(super) fn with_ends(&self) -> Vec<(f64, f64, Piece)> {
        let (first, last) = (self.x[0], self.x[self.x.len() - 1]);
        let tangent = |at: f64| match self.beyond {
            Beyond::Constant => Piece::polynomial(vec![self.at(at)]),
            _ => Piece::polynomial(vec![self.at(at), self.slope(at)]),
        };
        let mut pieces = vec![(f64::NEG_INFINITY, first, tangent(first))];
        let inner = self.x.iter().zip(&self.pieces);
        pieces.extend(inner.map(|(&from, piece)| (from, from, piece.clone())));
        pieces.push((last, last, tangent(last)));
        pieces
    }

    /// The pieces as they are told.
    pub(super) fn function_pieces(&self) -> Vec<FunctionPiece> {
        let pieces = self.with_ends();
        let ends: Vec<f64> = pieces.iter().skip(1).map(|(from, ..)| *from).collect();
        let ends = ends.into_iter().chain([f64::INFINITY]);
        let told = pieces.into_iter().zip(ends).map(|((from, origin, piece), to)| FunctionPiece {
            ranges: vec![[from, to]],
            origin: vec![origin],
            terms: piece.powers.into_iter().enumerate().map(|(n, c)| ([n, 0], c)).collect(),
            sine: piece.sine,
        });
        let is_told = |piece: &FunctionPiece| piece.ranges.iter().flatten().all(|x| x.is_finite());
        told.filter(|piece| self.beyond != Beyond::Refused || is_told(piece)).collect()
    }
}

impl Piece {
    pub(super) fn polynomial(powers: Vec<f64>) -> Self {
        Self { powers, sine: None }
    }

    /// The piece with this value and slope at its left end, and the acceleration A sin(ω s + φ), or A where ω is
    /// zero.
    pub(super) fn of_acceleration(value: f64, slope: f64, [a, omega, phi]: [f64; 3]) -> Self {
        if omega == 0.0 {
            return Self::polynomial(vec![value, slope, 0.5 * a]);
        }
        let size = a / (omega * omega);
        let powers = vec![value + size * phi.sin(), slope + size * omega * phi.cos()];
        Self { powers, sine: Some([-size, omega, phi]) }
    }

    /// The piece with lengths `over` and values `rise` times as large, `height` higher.
    pub(super) fn stretched(&self, over: f64, rise: f64, height: f64) -> Self {
        let mut factor = rise;
        let scaled = |c: &f64| {
            let scaled = factor * c;
            factor /= over;
            scaled
        };
        let mut powers: Vec<f64> = self.powers.iter().map(scaled).collect();
        powers[0] += height;
        let sine = self.sine.map(|[a, omega, phi]| [rise * a, omega / over, phi]);
        Self { powers, sine }
    }

    pub(super) fn at(&self, s: f64) -> f64 {
        let sum = self.powers.iter().rev().fold(0.0, |sum, c| sum * s + c);
        sum + self.sine.map_or(0.0, |[a, omega, phi]| a * (omega * s + phi).sin())
    }

    /// Where a cubic polynomial has no slope, as far as it has such points.
    pub(super) fn turning_points(&self) -> [Option<f64>; 2] {
        let power = |n: usize| self.powers.get(n).copied().unwrap_or(0.0);
        // a s² + 2 b s + c = 0, its root of larger size first, as the other one is then exact, too.
        let (a, b, c) = (3.0 * power(3), power(2), power(1));
        let root = (b * b - a * c).sqrt();
        let sum = -(b + root.copysign(b));
        [sum / a, c / sum].map(|s| s.is_finite().then_some(s))
    }

    pub(super) fn slope(&self, s: f64) -> f64 {
        let powers = self.powers.iter().enumerate().skip(1).rev();
        let sum = powers.fold(0.0, |sum, (n, c)| sum * s + n as f64 * c);
        sum + self.sine.map_or(0.0, |[a, omega, phi]| a * omega * (omega * s + phi).cos())
    }
}

/// Straight lines between the points.
pub(super) fn straight(points: &[[f64; 2]]) -> Vec<Piece> {
    let line = |pair: &[[f64; 2]]| {
        let [[x, y], [next, then]] = [pair[0], pair[1]];
        Piece::polynomial(vec![y, (then - y) / (next - x)])
    };
    points.windows(2).map(line).collect()
}

/// The natural cubic spline through the points, by its second derivatives: C. de Boor, *A Practical Guide to
/// Splines* (2001), chapter IV.
pub(super) fn spline(points: &[[f64; 2]]) -> Vec<Piece> {
    let n = points.len();
    let width = |k: usize| points[k + 1][0] - points[k][0];
    let slope = |k: usize| (points[k + 1][1] - points[k][1]) / width(k);
    // h₋ m₋ + 2 (h₋ + h) m + h m₊ = 6 (s − s₋), m = 0 at the ends; eliminated from the left.
    let mut ahead = vec![0.0; n];
    let mut right = vec![0.0; n];
    for k in 1..n - 1 {
        let pivot = 2.0 * (width(k - 1) + width(k)) - width(k - 1) * ahead[k - 1];
        ahead[k] = width(k) / pivot;
        right[k] = (6.0 * (slope(k) - slope(k - 1)) - width(k - 1) * right[k - 1]) / pivot;
    }
    let mut second = vec![0.0; n];
    for k in (1..n - 1).rev() {
        second[k] = right[k] - ahead[k] * second[k + 1];
    }
    let piece = |k: usize| {
        let h = width(k);
        let b = slope(k) - h * (2.0 * second[k] + second[k + 1]) / 6.0;
        let powers =
            vec![points[k][1], b, 0.5 * second[k], (second[k + 1] - second[k]) / (6.0 * h)];
        Piece::polynomial(powers)
    };
    (0..n - 1).map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::spline;

    #[test]
    fn a_spline_has_continuous_second_derivatives_and_meets_its_points() {
        let points = [[0.0, 1.0], [0.5, 2.0], [2.0, -1.0], [2.5, 0.0], [4.0, 3.0]];
        let pieces = spline(&points);
        for k in 0..points.len() - 1 {
            let h = points[k + 1][0] - points[k][0];
            let bend =
                |piece: &super::Piece, s: f64| 2.0 * piece.powers[2] + 6.0 * s * piece.powers[3];
            let piece = &pieces[k];
            assert!((piece.at(h) - points[k + 1][1]).abs() < 1e-12);
            if let Some(next) = pieces.get(k + 1) {
                assert!((piece.slope(h) - next.slope(0.0)).abs() < 1e-12, "{k}");
                assert!((bend(piece, h) - bend(next, 0.0)).abs() < 1e-12, "{k}");
            } else {
                assert!(bend(piece, h).abs() < 1e-12);
            }
        }
    }
}
