//! Tables of two variables: rows on a grid, and the pieces between them.
//!
//! Along the first argument every column of the grid has its own pieces, powers of the distance s from the left;
//! along the second one each coefficient of these has pieces in turn. Splines and straight lines are linear in
//! their values, so that it does not matter which argument comes first:
//!
//! ```text
//! f(x, y) = Σ c_nm s(x)ⁿ s(y)ᵐ        in the cell that holds (x, y)
//! ```

use super::pieces::{Beyond, Columns, Interpolation, Piece, spline, straight};
use super::value::Kind;
use crate::table::FunctionPiece;

/// A table that was read.
#[derive(Clone, Debug)]
pub(super) struct MeasuredTable {
    pub(super) name: String,
    /// Numbers of the table; `None` until it is read, and for ever when it is faulty.
    pub(super) form: Option<TableForm>,
}

/// The numbers of a table.
#[derive(Clone, Debug)]
pub(super) enum TableForm {
    /// Of one argument and of the value.
    Columns(Columns),
    /// Of two arguments and of the value.
    Grid(Grid),
}

/// A function of two variables, cell by cell.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Of the arguments and of the value.
    pub(super) kinds: [Kind; 3],
    pub(super) are_angles: [bool; 3],
    pub(super) beyond: Beyond,
    /// First and last argument, SI.
    pub(super) ranges: [[f64; 2]; 2],
    /// Along each argument where a piece begins, and from where its distance counts; the first begins at −∞.
    pub(super) borders: [Vec<(f64, f64)>; 2],
    /// By piece along the first argument, its power, piece along the second, and its power.
    pub(super) powers: Vec<Vec<Vec<Vec<f64>>>>,
}

/// Pieces through values at ascending arguments, with one before and one behind.
struct Line {
    borders: Vec<(f64, f64)>,
    pieces: Vec<Piece>,
}

impl Line {
    fn through(points: &[[f64; 2]], way: Interpolation, beyond: Beyond) -> Self {
        let inner = match way {
            Interpolation::Smooth => spline(points),
            Interpolation::Monotone => unreachable!("the reader refuses it with two arguments"),
            Interpolation::Linear => straight(points),
        };
        let (first, last) = (points[0], points[points.len() - 1]);
        let width = last[0] - points[points.len() - 2][0];
        let slopes = [inner[0].slope(0.0), inner[inner.len() - 1].slope(width)];
        let end = |value: f64, slope: f64| match beyond {
            Beyond::Constant => Piece::polynomial(vec![value]),
            Beyond::Refused | Beyond::Linear => Piece::polynomial(vec![value, slope]),
        };
        let mut borders = vec![(f64::NEG_INFINITY, first[0])];
        borders.extend(points.iter().map(|point| (point[0], point[0])));
        let mut pieces = vec![end(first[1], slopes[0])];
        pieces.extend(inner);
        pieces.push(end(last[1], slopes[1]));
        Self { borders, pieces }
    }

    /// The coefficient of a power in a piece.
    fn power(&self, piece: usize, n: usize) -> f64 {
        self.pieces[piece].powers.get(n).copied().unwrap_or(0.0)
    }
}

impl Grid {
    /// The grid through values by both arguments.
    pub(super) fn through(
        (x, y): (&[f64], &[f64]),
        value: &dyn Fn(usize, usize) -> f64,
        (way, beyond): (Interpolation, Beyond),
        (kinds, are_angles): ([Kind; 3], [bool; 3]),
    ) -> Self {
        let line = |at: &[f64], value: &dyn Fn(usize) -> f64| {
            let points: Vec<[f64; 2]> =
                at.iter().enumerate().map(|(k, &x)| [x, value(k)]).collect();
            Line::through(&points, way, beyond)
        };
        let columns: Vec<Line> = (0..y.len()).map(|j| line(x, &|i| value(i, j))).collect();
        let n_powers = match way {
            Interpolation::Smooth | Interpolation::Monotone => 4,
            Interpolation::Linear => 2,
        };
        let mut other = Vec::new();
        let powers = (0..columns[0].pieces.len())
            .map(|k| {
                let of_power = |n: usize| {
                    let across = line(y, &|j| columns[j].power(k, n));
                    let pieces = 0..across.pieces.len();
                    let rows = pieces.map(|l| (0..n_powers).map(|m| across.power(l, m)).collect());
                    let rows: Vec<Vec<f64>> = rows.collect();
                    other = across.borders;
                    rows
                };
                (0..n_powers).map(of_power).collect()
            })
            .collect();
        let range = |at: &[f64]| [at[0], at[at.len() - 1]];
        Self {
            kinds,
            are_angles,
            beyond,
            ranges: [range(x), range(y)],
            borders: [columns[0].borders.clone(), other],
            powers,
        }
    }

    /// The cells as they are told.
    pub(super) fn function_pieces(&self) -> Vec<FunctionPiece> {
        let ends = |i: usize| -> Vec<(f64, f64, f64)> {
            let borders = &self.borders[i];
            let to = borders.iter().skip(1).map(|border| border.0).chain([f64::INFINITY]);
            borders.iter().zip(to).map(|(&(from, origin), to)| (from, to, origin)).collect()
        };
        let (across, along) = (ends(0), ends(1));
        let mut told = Vec::new();
        for (k, &(x_from, x_to, x)) in across.iter().enumerate() {
            for (l, &(y_from, y_to, y)) in along.iter().enumerate() {
                let ranges = vec![[x_from, x_to], [y_from, y_to]];
                let is_inside = ranges.iter().flatten().all(|end| end.is_finite());
                if self.beyond == Beyond::Refused && !is_inside {
                    continue;
                }
                let of_power = |(n, rows): (usize, &Vec<Vec<f64>>)| {
                    let powers = rows[l].iter().enumerate();
                    powers.map(|(m, &c)| ([n, m], c)).collect::<Vec<_>>()
                };
                let terms = self.powers[k].iter().enumerate().flat_map(of_power).collect();
                told.push(FunctionPiece { ranges, origin: vec![x, y], terms, sine: None });
            }
        }
        told
    }

    /// The value at two arguments; not a number outside of the rows where that is refused.
    pub(super) fn at(&self, arguments: [f64; 2]) -> f64 {
        let is_inside = |(x, [first, last]): (f64, [f64; 2])| (first..=last).contains(&x);
        if self.beyond == Beyond::Refused && !arguments.into_iter().zip(self.ranges).all(is_inside)
        {
            return f64::NAN;
        }
        let [(k, s), (l, r)] = [0, 1].map(|i: usize| {
            let borders = &self.borders[i];
            let piece = borders.partition_point(|(from, _)| *from <= arguments[i]).max(1) - 1;
            // The last row belongs to the table.
            let is_last = arguments[i] == self.ranges[i][1];
            let piece = if is_last { piece - 1 } else { piece };
            (piece, arguments[i] - borders[piece].1)
        });
        let of = |powers: &Vec<Vec<f64>>| powers[l].iter().rev().fold(0.0, |sum, c| sum * r + c);
        self.powers[k].iter().rev().fold(0.0, |sum, powers| sum * s + of(powers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_of_a_product_is_the_product_of_its_splines() {
        let x = [0.0_f64, 0.5, 2.0, 2.5, 4.0];
        let y = [-1.0_f64, 0.0, 1.5, 2.0];
        let (f, g) = (|i: usize| (1.3 * x[i]).sin(), |j: usize| (0.4 * y[j] * y[j]).exp());
        let none = ([Kind::Bare; 3], [false; 3]);
        for way in [Interpolation::Smooth, Interpolation::Linear] {
            let how = (way, Beyond::Linear);
            let grid = Grid::through((&x, &y), &|i, j| f(i) * g(j), how, none);
            let of = |at: &[f64], value: &dyn Fn(usize) -> f64, argument: f64| {
                let points: Vec<[f64; 2]> = (0..at.len()).map(|k| [at[k], value(k)]).collect();
                let line = Line::through(&points, way, Beyond::Linear);
                let piece = line.borders.partition_point(|(from, _)| *from <= argument).max(1) - 1;
                line.pieces[piece].at(argument - line.borders[piece].1)
            };
            for at in [[0.3, -0.2], [2.2, 1.9], [3.0, 0.0], [-0.4, 1.0], [4.5, 2.5], [0.5, 2.0]] {
                let expected = of(&x, &f, at[0]) * of(&y, &g, at[1]);
                assert!((grid.at(at) - expected).abs() < 1e-13, "{at:?}");
            }
        }
    }
}
