//! Tables of two variables: their rows, and their calls.

use super::codes;
use super::grids::Grid;
use super::pieces::{Beyond, Interpolation};
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::Node;
use super::value::{Kind, Lowered};
use crate::diagnostic::{Diagnostic, Span};
use crate::message::short;

/// Most rows of a table of two variables: every cell is written out in every call.
const MOST_ROWS: usize = 10_000;

/// The rows of a table, SI.
pub(super) struct Rows {
    /// By column.
    pub(super) kinds: Vec<Kind>,
    pub(super) are_angles: Vec<bool>,
    /// With their positions in the file.
    pub(super) points: Vec<(Vec<f64>, Span)>,
}

impl Reader<'_> {
    /// A grid from rows of both arguments and the value, of which the second argument runs fastest.
    pub(super) fn read_grid(
        &mut self,
        node: &Node,
        rows: Rows,
        how: (Interpolation, Beyond),
        fields: &Fields<'_>,
    ) -> Option<Grid> {
        let Rows { kinds, are_angles, points } = rows;
        if how.0 == Interpolation::Monotone {
            let message = format!("{} has two arguments and cannot be monotone", fields.owner);
            let at = fields.get("interpolation").unwrap_or(node).span.clone();
            self.report(
                Diagnostic::error(codes::BAD_TABLE, message)
                    .at(at, "for tables of one argument")
                    .help("write `interpolation = \"linear\"`, or leave it out for splines"),
            );
            return None;
        }
        if points.len() > MOST_ROWS {
            let message = format!("{} has {} rows", fields.owner, points.len());
            self.report(
                Diagnostic::error(codes::BAD_TABLE, message)
                    .at(node.span.clone(), format!("at most {MOST_ROWS} with two arguments"))
                    .help("leave out rows; smooth tables need few"),
            );
            return None;
        }
        // The second arguments are those of the rows with the first one of the first.
        let first = points.first()?.0[0];
        let n = points.iter().take_while(|(row, _)| row[0].total_cmp(&first).is_eq()).count();
        let y: Vec<f64> = points[..n].iter().map(|(row, _)| row[1]).collect();
        let mut x = Vec::new();
        for (row_idx, (row, span)) in points.iter().enumerate() {
            let (block, place) = (row_idx / n, row_idx % n);
            let fault = if place == 0 {
                x.push(row[0]);
                (block > 0 && row[0] <= x[block - 1])
                    .then(|| format!("begins with {} after {}", short(row[0]), short(x[block - 1])))
            } else if row[0].total_cmp(&x[block]).is_ne() {
                Some(format!("has the first argument {}, not {}", short(row[0]), short(x[block])))
            } else {
                None
            };
            let fault = fault.or_else(|| {
                if block == 0 && place > 0 && row[1] <= y[place - 1] {
                    return Some(format!("has {} after {}", short(row[1]), short(y[place - 1])));
                }
                (row[1].total_cmp(&y[place]).is_ne()).then(|| {
                    format!("has the second argument {}, not {}", short(row[1]), short(y[place]))
                })
            });
            if let Some(fault) = fault {
                let message = format!("row {} of {} {fault}", row_idx + 1, fields.owner);
                self.report(
                    Diagnostic::error(codes::BAD_TABLE, message)
                        .at(span.clone(), "does not follow the grid")
                        .note("rows go through all second arguments for each of the first, both ascending")
                        .help("sort the rows, and add those that are missing"),
                );
                return None;
            }
        }
        if n < 2 || x.len() < 2 || points.len() % n != 0 {
            let message = format!(
                "{} has {} rows, with {} and {} arguments",
                fields.owner,
                points.len(),
                x.len(),
                n
            );
            self.report(
                Diagnostic::error(codes::BAD_TABLE, message)
                    .at(node.span.clone(), "no grid")
                    .note("a grid has a row for every pair of two first and two second arguments at least")
                    .help("add the rows that are missing; of one argument, leave out its column"),
            );
            return None;
        }
        let value = |i: usize, j: usize| points[i * n + j].0[2];
        let of = ([kinds[0], kinds[1], kinds[2]], [are_angles[0], are_angles[1], are_angles[2]]);
        Some(Grid::through((&x, &y), &value, how, of))
    }

    /// The value of a table at two arguments.
    pub(super) fn look_up_grid(
        &mut self,
        name: &str,
        grid: &Grid,
        [first, second]: [&Lowered; 2],
        span: Span,
    ) -> Lowered {
        let values = [first, second].map(|argument| argument.value);
        let value = match values {
            [Some(x), Some(y)] => {
                let at = [x, y].map(|value| self.constants.pinned(value));
                Some(Constant::written(grid.at(at)))
            }
            _ => None,
        };
        if value.is_none() && grid.beyond == Beyond::Refused {
            for (i, argument) in [first, second].into_iter().enumerate() {
                let of = (grid.kinds[i], grid.are_angles[i]);
                self.note_call(name, (argument.expr, grid.ranges[i]), of, &span);
            }
        }
        let function = self.function_of_grid(name, grid);
        let expr = self.pool.apply(function, &[first.expr, second.expr]);
        let is_angle = grid.are_angles[2];
        Lowered { is_angle, ..Lowered::new(expr, grid.kinds[2], value, span) }
    }
}
