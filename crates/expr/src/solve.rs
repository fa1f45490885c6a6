//! Exact solution of linear equations, with the conditions under which it holds.
//!
//! Gaussian elimination on expressions, without quotients: a row is multiplied by the pivot before
//! the multiple of the pivot's row is subtracted, so that terms cancel as soon as they are
//! multiplied out. A pivot that is a number is certain; any other one may be zero somewhere, so the
//! solution states it as a condition. Numbers are preferred as pivots, then short rows and
//! expressions.

use crate::pool::{Expr, Pool, SymbolId, ZERO};

/// The solution of linear equations.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LinearSolution {
    /// The value of each unknown, in the order asked for.
    pub values: Vec<Expr>,
    /// Expressions that must not be zero for the values to hold; numbers are left out.
    pub nonzero: Vec<Expr>,
}

/// Reason why equations have no unique solution.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// An unknown occurs otherwise than with a coefficient free of unknowns.
    #[error("equation {equation} is not linear in the unknowns")]
    NotLinear {
        /// Index of the equation, from 0.
        equation: usize,
    },
    /// There are fewer independent equations than unknowns.
    #[error("nothing determines `{name}`")]
    Undetermined {
        /// The unknown that stays free.
        symbol: SymbolId,
        /// Name of the symbol.
        name: String,
    },
    /// An equation left over without unknowns is not satisfied.
    #[error("equation {equation} contradicts the others")]
    Contradiction {
        /// Index of the equation, from 0.
        equation: usize,
    },
    /// An equation left over without unknowns could not be shown to be satisfied.
    #[error("equation {equation} holds only under a condition on the other symbols")]
    Conditional {
        /// Index of the equation, from 0.
        equation: usize,
        /// The expression that must be zero.
        remainder: Expr,
    },
    /// Symbol that is asked for twice.
    #[error("`{name}` is listed twice among the unknowns")]
    Repeated {
        /// The symbol.
        symbol: SymbolId,
        /// Name of the symbol.
        name: String,
    },
}

/// One equation `Σ coefficientᵢ unknownᵢ = right`.
struct LinearEquation {
    equation: usize,
    coefficients: Vec<Expr>,
    right: Expr,
}

impl Pool {
    /// Solves `equations` (each an expression that is to be zero) for `unknowns`, in which they
    /// must be linear; coefficients may contain any other symbol.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let equations = ["m*a + f - u", "k*a - f"].map(|text| pool.parse(text).expect("valid"));
    /// let unknowns = ["a", "f"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// let solution = pool.solve_linear(&equations, &unknowns).expect("regular");
    /// let texts: Vec<String> = solution.values.iter().map(|&e| pool.to_text(e)).collect();
    /// assert_eq!(texts, ["u/(k + m)", "u - m*u/(k + m)"]);
    /// // The values hold where this is not zero.
    /// assert_eq!(pool.to_text(solution.nonzero[0]), "k + m");
    /// ```
    ///
    /// # Errors
    /// [`SolveError`] for equations that are not linear, leave an unknown free, or contradict each
    /// other; more equations than unknowns are allowed if they agree.
    pub fn solve_linear(
        &self,
        equations: &[Expr],
        unknowns: &[SymbolId],
    ) -> Result<LinearSolution, SolveError> {
        let mut rows = self.linear_rows(equations, unknowns)?;
        let mut free: Vec<usize> = (0..unknowns.len()).collect();
        let mut solved: Vec<(usize, LinearEquation)> = Vec::new();
        let mut nonzero = Vec::new();
        while let Some((row, column)) = self.pivot(&rows, &free) {
            let mut row = rows.swap_remove(row);
            free.retain(|&other| other != column);
            let pivot = row.coefficients[column];
            if self.as_number(pivot).is_some() {
                self.divide(&mut row, pivot);
            } else {
                nonzero.push(self.split_coefficient(pivot).1);
            }
            for other in &mut rows {
                self.eliminate(other, &row, column, &free);
            }
            solved.push((column, row));
        }
        if let Some(&column) = free.first() {
            let symbol = unknowns[column];
            return Err(SolveError::Undetermined { symbol, name: self.symbol_name(symbol) });
        }
        self.check_left_over(&rows)?;
        Ok(LinearSolution { values: self.substitute_back(&solved), nonzero })
    }

    /// Splits each equation into coefficients and the rest.
    fn linear_rows(
        &self,
        equations: &[Expr],
        unknowns: &[SymbolId],
    ) -> Result<Vec<LinearEquation>, SolveError> {
        let mut sorted = unknowns.to_vec();
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            let symbol = pair[0];
            return Err(SolveError::Repeated { symbol, name: self.symbol_name(symbol) });
        }
        let zeros: Vec<(SymbolId, Expr)> = unknowns.iter().map(|&x| (x, ZERO)).collect();
        let mut rows = Vec::with_capacity(equations.len());
        for (equation, &e) in equations.iter().enumerate() {
            let coefficients = self.simplify_all(&self.gradient(e, unknowns));
            // Piecewise functions of an unknown have constant derivatives too.
            let rest = self.substitute(e, &zeros);
            let linear =
                coefficients.iter().zip(unknowns).map(|(&c, &x)| self.mul(c, self.symbol_expr(x)));
            let difference = self.sub(e, self.sum(linear.chain([rest])));
            let has_unknown = |e: Expr| {
                self.symbols_of(e).iter().any(|symbol| sorted.binary_search(symbol).is_ok())
            };
            let is_linear = !coefficients.iter().any(|&c| has_unknown(c))
                && !has_unknown(rest)
                && self.is_zero(self.simplify(self.expand(difference)));
            if !is_linear {
                return Err(SolveError::NotLinear { equation });
            }
            rows.push(LinearEquation {
                equation,
                coefficients,
                right: self.simplify(self.neg(rest)),
            });
        }
        Ok(rows)
    }

    /// The best coefficient to divide by: a number, otherwise the shortest expression.
    fn pivot(&self, rows: &[LinearEquation], free: &[usize]) -> Option<(usize, usize)> {
        let entries =
            rows.iter().enumerate().flat_map(|(i, row)| free.iter().map(move |&j| (i, j, row)));
        let nonzero = entries.filter(|&(_, j, row)| !self.is_zero(row.coefficients[j]));
        nonzero
            .min_by_key(|&(_, j, row)| {
                let e = row.coefficients[j];
                let n_entries = free.iter().filter(|&&k| row.coefficients[k] != ZERO).count();
                let length = self.sweep(&[e]).steps.len();
                (self.as_number(e).is_none(), n_entries, length, row.equation, j)
            })
            .map(|(i, j, _)| (i, j))
    }

    fn divide(&self, row: &mut LinearEquation, number: Expr) {
        for entry in row.coefficients.iter_mut().chain([&mut row.right]) {
            *entry = self.div(*entry, number);
        }
    }

    /// Removes one unknown: pivot · row − coefficient · pivot's row.
    fn eliminate(
        &self,
        row: &mut LinearEquation,
        by: &LinearEquation,
        column: usize,
        free: &[usize],
    ) {
        let (factor, pivot) = (row.coefficients[column], by.coefficients[column]);
        if factor == ZERO {
            return;
        }
        let reduced = |a: Expr, b: Expr| {
            let difference = self.sub(self.mul(pivot, a), self.mul(factor, b));
            if self.is_zero(self.expand(difference)) { ZERO } else { self.simplify(difference) }
        };
        for &other in free {
            row.coefficients[other] = reduced(row.coefficients[other], by.coefficients[other]);
        }
        row.right = reduced(row.right, by.right);
        row.coefficients[column] = ZERO;
    }

    /// Equations that have no unknown left must hold by themselves.
    fn check_left_over(&self, rows: &[LinearEquation]) -> Result<(), SolveError> {
        for row in rows {
            if self.is_zero(row.right) {
                continue;
            }
            let equation = row.equation;
            return Err(match self.as_number(row.right) {
                Some(_) => SolveError::Contradiction { equation },
                None => SolveError::Conditional { equation, remainder: row.right },
            });
        }
        Ok(())
    }

    /// Values from rows in triangular form, the last one first.
    fn substitute_back(&self, solved: &[(usize, LinearEquation)]) -> Vec<Expr> {
        let mut values = vec![ZERO; solved.len()];
        for (index, (column, row)) in solved.iter().enumerate().rev() {
            let known = solved[index + 1..]
                .iter()
                .map(|&(other, _)| self.neg(self.mul(row.coefficients[other], values[other])));
            let right = self.simplify(self.sum(known.chain([row.right])));
            values[*column] = self.div(right, row.coefficients[*column]);
        }
        values
    }
}
