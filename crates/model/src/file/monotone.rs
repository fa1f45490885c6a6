//! Interpolation that rises and falls only where the rows do, and rows that a spline leaves.
//!
//! Between two rows h apart stands the polynomial of degree five with given slopes d and second derivatives c at both
//! ends. Its Bernstein coefficients are
//!
//! ```text
//! f₀,  f₀ + h d₀/5,  f₀ + 2h d₀/5 + h² c₀/20,  f₁ − 2h d₁/5 + h² c₁/20,  f₁ − h d₁/5,  f₁
//! ```
//!
//! and where these rise or fall throughout, so does the polynomial (G. Farin, *Curves and Surfaces for CAGD*, 2002,
//! §6.3). Slopes and second derivatives are those of the parabola through a row and its neighbours, made smaller as
//! far as that asks.

use super::pieces::Piece;

/// Largest sum of the slopes at both ends of an interval, in slopes of the line between them, for which the
/// coefficients in the middle are in order where nothing bends.
const STEEPEST: f64 = 2.5;

/// Part of a rise that is rounding.
const ROUNDING: f64 = 1e-14;

/// A row with its slope and second derivative.
#[derive(Clone, Copy, Debug)]
struct Row {
    x: f64,
    value: f64,
    slope: f64,
    bend: f64,
}

/// Pieces through the points with continuous second derivatives, which rise and fall as the points do.
pub(super) fn monotone(points: &[[f64; 2]]) -> Vec<Piece> {
    let mut rows = parabolas(points);
    for k in 1..rows.len() {
        limit_slopes(&mut rows[k - 1..=k]);
    }
    for k in 1..rows.len() {
        limit_bends(&mut rows[k - 1..=k]);
    }
    rows.windows(2).map(|ends| quintic(ends[0], ends[1])).collect()
}

/// The rows with the slopes and second derivatives of parabolas; level where the points turn.
fn parabolas(points: &[[f64; 2]]) -> Vec<Row> {
    let last = points.len() - 1;
    let width = |k: usize| points[k + 1][0] - points[k][0];
    let line = |k: usize| (points[k + 1][1] - points[k][1]) / width(k);
    let row = |k: usize| {
        let [x, value] = points[k];
        if last == 1 {
            return Row { x, value, slope: line(0), bend: 0.0 };
        }
        // The parabola through three rows, of which this one is in the middle or at an end.
        let middle = k.clamp(1, last - 1);
        let bend = 2.0 * (line(middle) - line(middle - 1)) / (width(middle - 1) + width(middle));
        let slope =
            line(middle - 1) + 0.5 * bend * width(middle - 1) + bend * (x - points[middle][0]);
        let sides = [k.saturating_sub(1), k.min(last - 1)].map(line);
        let is_on_way = sides.into_iter().all(|side| side * slope > 0.0);
        Row { x, value, slope: if is_on_way { slope } else { 0.0 }, bend }
    };
    (0..=last).map(row).collect()
}

/// Makes the slopes at both ends of an interval smaller until their sum is not too steep.
fn limit_slopes(ends: &mut [Row]) {
    let line = (ends[1].value - ends[0].value) / (ends[1].x - ends[0].x);
    let (sum, steepest) = (ends[0].slope.abs() + ends[1].slope.abs(), STEEPEST * line.abs());
    if sum > steepest {
        for end in ends {
            end.slope *= steepest / sum;
        }
    }
}

/// Makes the second derivatives at both ends of an interval smaller until the coefficients are in order.
fn limit_bends(ends: &mut [Row]) {
    let h = ends[1].x - ends[0].x;
    let rise = ends[1].value - ends[0].value;
    let sense = if rise < 0.0 { -1.0 } else { 1.0 };
    // What is left for the bends in the middle, half of it for each end.
    let slopes = ends[0].slope.abs() + ends[1].slope.abs();
    let left = rise.abs() - 0.4 * h * slopes;
    let room = if left > ROUNDING * rise.abs() { 10.0 * left / (h * h) } else { 0.0 };
    let at_end = [1.0, -1.0].map(|side| sense * side);
    for (end, side) in ends.iter_mut().zip(at_end) {
        let towards = (side * end.bend).clamp(-4.0 * end.slope.abs() / h, room);
        end.bend = side * towards;
    }
}

/// The polynomial of degree five between two rows.
fn quintic(from: Row, to: Row) -> Piece {
    let h = to.x - from.x;
    // What the end differs by from the parabola of the beginning, over powers of h.
    let value = (to.value - from.value - h * (from.slope + 0.5 * h * from.bend)) / h.powi(3);
    let slope = (to.slope - from.slope - h * from.bend) / h.powi(2);
    let bend = 0.5 * (to.bend - from.bend) / h;
    Piece::polynomial(vec![
        from.value,
        from.slope,
        0.5 * from.bend,
        10.0 * value - 4.0 * slope + bend,
        (-15.0 * value + 7.0 * slope - 2.0 * bend) / h,
        (6.0 * value - 3.0 * slope + bend) / h.powi(2),
    ])
}

/// The interval in which cubic pieces leave the values of both rows farthest, and the value there, although the points
/// next to them do not turn; only where it is more than a `part` of the range of all values.
pub(super) fn leaves_rows(
    points: &[[f64; 2]],
    pieces: &[Piece],
    part: f64,
) -> Option<(usize, f64)> {
    let values = points.iter().map(|point| point[1]);
    let lowest = values.clone().fold(f64::INFINITY, f64::min);
    let range = values.fold(f64::NEG_INFINITY, f64::max) - lowest;
    let rise = |k: usize| points[k + 1][1] - points[k][1];
    let last = pieces.len() - 1;
    let turns = |k: usize| {
        (k > 0 && rise(k - 1) * rise(k) < 0.0) || (k < last && rise(k + 1) * rise(k) < 0.0)
    };
    let farthest = |k: usize| {
        let (low, high) = (points[k][1].min(points[k + 1][1]), points[k][1].max(points[k + 1][1]));
        let beyond = |value: f64| (low - value).max(value - high);
        let width = points[k + 1][0] - points[k][0];
        let inside =
            pieces[k].turning_points().into_iter().flatten().filter(|s| (0.0..width).contains(s));
        let value =
            inside.map(|s| pieces[k].at(s)).max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)))?;
        (beyond(value) > part * range).then_some((k, value, beyond(value)))
    };
    let found = (0..pieces.len()).filter(|&k| !turns(k)).filter_map(farthest);
    found.max_by(|a, b| a.2.total_cmp(&b.2)).map(|(k, value, _)| (k, value))
}

#[cfg(test)]
mod tests {
    use super::super::pieces::spline;
    use super::*;

    /// Uneven rows that rise, stay, fall and jump.
    const UNEVEN: [[f64; 2]; 9] = [
        [-50.0, 9.0],
        [0.0, 8.0],
        [5.0, 6.0],
        [10.0, 1.0],
        [11.0, 1.0],
        [12.0, 4.0],
        [40.0, 4.5],
        [41.0, -30.0],
        [100.0, -60.0],
    ];

    /// The derivative of this order, 1 or 2.
    fn derivative(piece: &Piece, order: usize, s: f64) -> f64 {
        let mut powers = piece.powers.clone();
        for _ in 0..order {
            powers = powers.iter().enumerate().skip(1).map(|(n, c)| n as f64 * c).collect();
        }
        powers.iter().rev().fold(0.0, |sum, c| sum * s + c)
    }

    #[test]
    fn monotone_pieces_stay_between_their_rows_with_continuous_second_derivatives() {
        let pieces = monotone(&UNEVEN);
        for (k, piece) in pieces.iter().enumerate() {
            let ([x, from], [next, to]) = (UNEVEN[k], UNEVEN[k + 1]);
            let h: f64 = next - x;
            let sense = f64::signum(to - from);
            let mut before = from;
            for i in 1..=200 {
                let value = piece.at(h * f64::from(i) / 200.0);
                assert!(sense * (value - before) >= -1e-12, "interval {k}: {value} after {before}");
                before = value;
            }
            assert!((before - to).abs() < 1e-12, "{before} is not {to}");
            for order in 1..=2 {
                let Some(follower) = pieces.get(k + 1) else { continue };
                let (here, there) = (derivative(piece, order, h), derivative(follower, order, 0.0));
                assert!(
                    (here - there).abs() < 1e-9 * (1.0 + there.abs()),
                    "row {}: {here}, {there}",
                    k + 1
                );
            }
        }
    }

    #[test]
    fn a_parabola_is_interpolated_exactly() {
        let f = |x: f64| 3.0 - 2.0 * x + 0.5 * x * x;
        let points = [-1.0, 0.0, 1.0, 1.5, 2.0].map(|x| [x, f(x)]);
        for (piece, point) in monotone(&points).iter().zip(points) {
            for s in [0.1, 0.25, 0.4] {
                let expected = f(point[0] + s);
                assert!(
                    (piece.at(s) - expected).abs() < 1e-12,
                    "{} at {}",
                    piece.at(s),
                    point[0] + s
                );
            }
        }
    }

    #[test]
    fn only_a_spline_that_turns_where_its_rows_do_not_leaves_them() {
        let motor = [[0.0, 8.0], [100.0, 7.5], [110.0, 6.0], [120.0, 0.0]];
        let found = leaves_rows(&motor, &spline(&motor), 0.02);
        assert!(found.is_some_and(|(k, value)| k == 0 && value > 8.3), "{found:?}");
        let waves: Vec<[f64; 2]> =
            (0..20).map(|i| 0.4 * f64::from(i)).map(|x| [x, x.sin()]).collect();
        assert_eq!(
            leaves_rows(&waves, &spline(&waves), 0.02),
            None,
            "a spline has to turn between rows that turn"
        );
    }
}
