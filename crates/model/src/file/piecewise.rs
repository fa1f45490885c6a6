//! Functions by name: tables, laws and paths as nested conditions with a formula between two borders, so that
//! corners are located as those of any other condition, and derivatives are exact.

use bksim_expr::{Expr, Function, FunctionId, Number};

use super::grids::Grid;
use super::pieces::{Beyond, Columns, Piece};
use super::reader::Reader;
use crate::table::{FunctionPiece, NamedFunction};

/// Length beyond its rows, in lengths of the table, over which a table goes on before it has no value.
const HAIR: f64 = 1e-9;

impl Reader<'_> {
    /// The function of a name and its argument, piece by piece.
    pub(super) fn function_of_columns(
        &mut self,
        name: &str,
        argument: &str,
        columns: &Columns,
    ) -> FunctionId {
        if let Some(known) = self.function_named(name) {
            return known;
        }
        let x = self.pool.symbol(argument);
        let body = self.piecewise(columns, x);
        self.add_function(name, &[x], body, columns.function_pieces())
    }

    /// The function of a name and two arguments, cell by cell.
    pub(super) fn function_of_grid(&mut self, name: &str, grid: &Grid) -> FunctionId {
        if let Some(known) = self.function_named(name) {
            return known;
        }
        let arguments = ["x", "y"].map(|name| self.pool.symbol(name));
        let body = self.on_grid(grid, arguments);
        self.add_function(name, &arguments, body, grid.function_pieces())
    }

    fn function_named(&self, name: &str) -> Option<FunctionId> {
        let known = self.functions.iter().map(|known| known.function);
        known.clone().find(|&function| self.pool.signature_of(function).0 == name)
    }

    fn add_function(
        &mut self,
        name: &str,
        arguments: &[Expr],
        body: Expr,
        pieces: Vec<FunctionPiece>,
    ) -> FunctionId {
        let symbols = arguments.iter().filter_map(|&argument| self.pool.symbol_id(argument));
        let function = self.pool.define(name, &symbols.collect::<Vec<_>>(), body);
        self.functions.push(NamedFunction { function, pieces });
        function
    }

    /// Nested conditions on an argument: for the distance from the left end of its piece, and for
    /// every coefficient of the pieces. So a distance stays a distance: multiplied out in powers of the argument,
    /// pieces far from zero would lose their digits.
    fn piecewise(&self, columns: &Columns, x: Expr) -> Expr {
        let pool = &self.pool;
        let number = |value: f64| pool.number(Number::float(value));
        let pieces = columns.with_ends();
        let tree = |leaf: &dyn Fn(f64, &Piece) -> Expr| {
            let leaves = pieces.iter().map(|(from, left, piece)| (*from, leaf(*left, piece)));
            self.search(x, &leaves.collect::<Vec<_>>())
        };

        // c₀ + c₁ s + … and A sin(ω s + φ).
        let distance = tree(&|left, _| pool.sub(x, number(left)));
        let n_powers = pieces.iter().map(|(.., piece)| piece.powers.len()).max().unwrap_or(0);
        let power =
            |n: usize| tree(&|_, piece| number(piece.powers.get(n).copied().unwrap_or(0.0)));
        let sum = (0..n_powers)
            .rev()
            .fold(pool.zero(), |sum, n| pool.add(pool.mul(sum, distance), power(n)));
        let sine = |k: usize| tree(&|_, piece| number(piece.sine.map_or(0.0, |sine| sine[k])));
        let has_sine = pieces.iter().any(|(.., piece)| piece.sine.is_some());
        let wave = has_sine.then(|| {
            let angle = pool.add(pool.mul(sine(1), distance), sine(2));
            pool.mul(sine(0), pool.sin(angle))
        });
        let inside = wave.map_or(sum, |wave| pool.add(sum, wave));
        if columns.beyond != Beyond::Refused {
            return inside;
        }

        let range = [columns.x[0], columns.x[columns.x.len() - 1]];
        pool.add(inside, self.domain(x, range))
    }

    /// Zero within a range. Outside there is nothing but for a hair, within which the branch that is not taken has
    /// finite derivatives.
    fn domain(&self, x: Expr, [first, last]: [f64; 2]) -> Expr {
        let pool = &self.pool;
        let number = |value: f64| pool.number(Number::float(value));
        let hair = number(HAIR * (last - first));
        let domain =
            |inwards: Expr| pool.mul(number(f64::MIN_POSITIVE), pool.sqrt(pool.add(inwards, hair)));
        let ends = [
            (f64::NEG_INFINITY, domain(pool.sub(x, number(first)))),
            (first, pool.zero()),
            (last, domain(pool.sub(number(last), x))),
        ];
        self.search(x, &ends)
    }

    /// A balanced tree of conditions: each piece holds from its argument on to that of the next.
    fn search(&self, x: Expr, pieces: &[(f64, Expr)]) -> Expr {
        let pool = &self.pool;
        if let [(_, only)] = pieces {
            return *only;
        }
        let (left, right) = pieces.split_at(pieces.len() / 2);
        let border = pool.number(Number::float(right[0].0));
        // The last row belongs to the table.
        let is_end = right.len() == 1;
        let below = if is_end { Function::Le } else { Function::Lt };
        let [left, right] = [left, right].map(|part| self.search(x, part));
        let condition = pool.call(below, &[x, border]).expect("two arguments");
        pool.call(Function::If, &[condition, left, right]).expect("three arguments")
    }

    /// The grid as nested conditions: for both distances from the borders of the cell, and for its coefficients.
    fn on_grid(&self, grid: &Grid, arguments: [Expr; 2]) -> Expr {
        let pool = &self.pool;
        let number = |value: f64| pool.number(Number::float(value));
        let tree = |i: usize, leaf: &dyn Fn(usize) -> Expr| {
            let borders = grid.borders[i].iter().enumerate();
            let leaves: Vec<(f64, Expr)> = borders.map(|(k, (from, _))| (*from, leaf(k))).collect();
            self.search(arguments[i], &leaves)
        };
        let [s, r] = [0, 1]
            .map(|i: usize| tree(i, &|k| pool.sub(arguments[i], number(grid.borders[i][k].1))));
        let n_powers = grid.powers[0].len();
        let coefficient =
            |n: usize, m: usize| tree(0, &|k| tree(1, &|l| number(grid.powers[k][n][l][m])));
        let of_power = |n: usize| {
            let powers = (0..n_powers).rev();
            powers.fold(pool.zero(), |sum, m| pool.add(pool.mul(sum, r), coefficient(n, m)))
        };
        let powers = (0..n_powers).rev();
        let inside = powers.fold(pool.zero(), |sum, n| pool.add(pool.mul(sum, s), of_power(n)));
        if grid.beyond != Beyond::Refused {
            return inside;
        }
        let domains = [0, 1].map(|i: usize| self.domain(arguments[i], grid.ranges[i]));
        pool.sum([inside, domains[0], domains[1]])
    }
}
