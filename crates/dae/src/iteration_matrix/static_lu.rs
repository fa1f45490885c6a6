//! Sparse LU with static pivots of all matrices of a step at once, one in each lane of a register.
//!
//! ```text
//! lane 0   (γ/h) ∂F/∂y′ + ∂F/∂y
//! lane k   (λ_k/h) ∂F/∂y′ + ∂F/∂y          k = 1 … (s − 1)/2 ≤ 3
//! ```
//!
//! They share pattern and sizes of their entries, so one order of pivots serves all. It is kept from
//! step to step, as the elimination is then straight-line code without searches and exchanges, and
//! chosen again where it has become bad for a matrix.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use faer::c64;
use pulp::{Simd, WithSimd};

use super::pivots::{Pivot, Program, choose};
use super::{Jacobian, Singular};
use crate::checkpoint::{Loader, Saver};
use crate::error::SolveError;
use crate::lanes::{ComplexChunk, LANES, run};
use crate::system::Pattern;

/// Factors of `L` beyond which other pivots are chosen; rounding of the solution grows with them.
const LARGEST_FACTOR: f64 = 1e5;

const ZEROS: ComplexChunk = [[0.0; LANES]; 2];

/// The matrices of one step size, and their factors.
pub(super) struct StaticLu {
    pattern: Pattern,
    /// Pivots that come first: explicit rows.
    first: Vec<Pivot>,
    program: Program,
    values: Vec<ComplexChunk>,
    /// Reciprocals of the pivots.
    inverse: Vec<ComplexChunk>,
    x: Vec<ComplexChunk>,
}

/// Why factors are not to be used.
enum Failure {
    /// A pivot vanishes or is not finite.
    Singular,
    /// Factors are too large for the pivots to be good.
    Growth,
}

impl StaticLu {
    /// Before the first factorisation.
    pub(super) fn new(pattern: &Pattern, explicit: &[(usize, usize)]) -> Self {
        let n = pattern.n();
        Self {
            pattern: pattern.clone(),
            first: explicit.to_vec(),
            program: Program::default(),
            values: Vec::new(),
            inverse: vec![ZEROS; n],
            x: vec![ZEROS; n],
        }
    }

    /// Saves the order of the pivots.
    pub(super) fn save(&self, saver: &mut Saver) {
        let (rows, columns): (Vec<_>, Vec<_>) = self.program.order.iter().copied().unzip();
        saver.indices(&rows);
        saver.indices(&columns);
    }

    pub(super) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        let n = self.pattern.n();
        let (rows, columns) = (loader.indices(n)?, loader.indices(n)?);
        if rows.is_empty() && columns.is_empty() {
            return Ok(());
        }
        let order = rows.into_iter().zip(columns).collect();
        let program = Program::new(&self.pattern, order);
        self.program =
            program.ok_or(SolveError::Checkpoint { reason: "has no order of pivots" })?;
        self.values.resize(self.program.n_places, ZEROS);
        Ok(())
    }

    /// Factors the matrices with the real shift `gamma / h` and the complex ones `lambda / h`.
    pub(super) fn factor(
        &mut self,
        jacobian: &Jacobian,
        gamma: f64,
        lambda: &[c64],
        h: f64,
    ) -> Result<(), Singular> {
        // Lanes without a matrix of their own repeat the real one.
        let mut shift = [[gamma / h; LANES], [0.0; LANES]];
        for (lane, lambda) in lambda.iter().enumerate() {
            let scaled = lambda / h;
            (shift[0][lane + 1], shift[1][lane + 1]) = (scaled.re, scaled.im);
        }
        if !self.program.order.is_empty() {
            match self.eliminate(jacobian, &shift) {
                Ok(()) => return Ok(()),
                Err(Failure::Singular | Failure::Growth) => (),
            }
        }
        let real = jacobian.combined(gamma / h);
        let order = choose(&self.pattern, &self.first, real)?;
        self.program = Program::new(&self.pattern, order).ok_or(Singular)?;
        self.values.resize(self.program.n_places, ZEROS);
        match self.eliminate(jacobian, &shift) {
            Ok(()) | Err(Failure::Growth) => Ok(()),
            Err(Failure::Singular) => Err(Singular),
        }
    }

    fn eliminate(&mut self, jacobian: &Jacobian, shift: &ComplexChunk) -> Result<(), Failure> {
        let Self { program, values, inverse, first, .. } = self;
        let growth =
            run(Elimination { program, jacobian, shift, values, inverse, n_first: first.len() })?;
        if growth <= LARGEST_FACTOR { Ok(()) } else { Err(Failure::Growth) }
    }

    /// Solves with as many matrices as `x` has right sides: that of the real one, then for each complex
    /// one the real parts and the imaginary parts.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        let n = self.program.order.len();
        let n_complex = (x.len() / n.max(1)).saturating_sub(1) / 2;
        for (chunk, &(row, _)) in self.x.iter_mut().zip(&self.program.order) {
            *chunk = ZEROS;
            chunk[0][0] = x[row];
            for k in 0..n_complex {
                chunk[0][k + 1] = x[(2 * k + 1) * n + row];
                chunk[1][k + 1] = x[(2 * k + 2) * n + row];
            }
        }
        let Self { program, values, inverse, x: steps, .. } = self;
        run(Substitution { program, factors: values, inverse, x: steps });
        for (chunk, &(_, column)) in self.x.iter().zip(&self.program.order) {
            x[column] = chunk[0][0];
            for k in 0..n_complex {
                x[(2 * k + 1) * n + column] = chunk[0][k + 1];
                x[(2 * k + 2) * n + column] = chunk[1][k + 1];
            }
        }
    }
}

struct Elimination<'a> {
    program: &'a Program,
    jacobian: &'a Jacobian,
    shift: &'a ComplexChunk,
    values: &'a mut [ComplexChunk],
    inverse: &'a mut [ComplexChunk],
    /// Steps whose factors may be large.
    n_first: usize,
}

impl WithSimd for Elimination<'_> {
    /// The largest factor.
    type Output = Result<f64, Failure>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { program, jacobian, shift, values, inverse, n_first } = self;
        let (own, fill) = values.split_at_mut(jacobian.df_dy.len());
        let parts = jacobian.df_dy.iter().zip(&jacobian.df_dydot);
        for (value, (&dy, &dydot)) in own.iter_mut().zip(parts) {
            *value = std::array::from_fn(|part| {
                let dy = if part == 0 { dy } else { 0.0 };
                shift[part].map(|shift| shift * dydot + dy)
            });
        }
        fill.fill(ZEROS);

        let mut growth = [0.0; LANES];
        let (mut l_start, mut u_start, mut target) = (0, 0, 0);
        for (k, (step, inverse)) in program.steps.iter().zip(inverse).enumerate() {
            let [re, im] = values[step.pivot];
            let square: [f64; LANES] = std::array::from_fn(|i| re[i] * re[i] + im[i] * im[i]);
            if !square.iter().all(|&square| square > 0.0 && square.is_finite()) {
                return Err(Failure::Singular);
            }
            *inverse = [
                std::array::from_fn(|i| re[i] / square[i]),
                std::array::from_fn(|i| -im[i] / square[i]),
            ];
            let (l, u) = (&program.l[l_start..step.l_end], &program.u[u_start..step.u_end]);
            for entry in l {
                // Dividing eliminates equal rows exactly, which leaves a zero to be found as pivot.
                let [a, b] = values[entry.place];
                let factor: ComplexChunk = [
                    std::array::from_fn(|i| (a[i] * re[i] + b[i] * im[i]) / square[i]),
                    std::array::from_fn(|i| (b[i] * re[i] - a[i] * im[i]) / square[i]),
                ];
                values[entry.place] = factor;
                if k >= n_first {
                    for i in 0..LANES {
                        growth[i] = f64::max(growth[i], factor[0][i].abs() + factor[1][i].abs());
                    }
                }
                let targets = &program.targets[target..target + u.len()];
                for (&target, entry) in targets.iter().zip(u) {
                    let other = values[entry.place];
                    subtract(&mut values[target], &factor, &other);
                }
                target += u.len();
            }
            (l_start, u_start) = (step.l_end, step.u_end);
        }
        Ok(growth.into_iter().fold(0.0, f64::max))
    }
}

/// `x −= a b` in every lane.
#[inline(always)]
fn subtract(x: &mut ComplexChunk, a: &ComplexChunk, b: &ComplexChunk) {
    let [re, im] = *x;
    *x = [
        std::array::from_fn(|i| re[i] - a[0][i] * b[0][i] + a[1][i] * b[1][i]),
        std::array::from_fn(|i| im[i] - a[0][i] * b[1][i] - a[1][i] * b[0][i]),
    ];
}

/// Forward and backward; `x` is numbered by steps.
struct Substitution<'a> {
    program: &'a Program,
    factors: &'a [ComplexChunk],
    inverse: &'a [ComplexChunk],
    x: &'a mut [ComplexChunk],
}

impl WithSimd for Substitution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { program, factors, inverse, x } = self;
        let mut l_start = 0;
        for (k, step) in program.steps.iter().enumerate() {
            let solved = x[k];
            for entry in &program.l[l_start..step.l_end] {
                subtract(&mut x[entry.step], &factors[entry.place], &solved);
            }
            l_start = step.l_end;
        }
        for (k, step) in program.steps.iter().enumerate().rev() {
            let u_start = k.checked_sub(1).map_or(0, |before| program.steps[before].u_end);
            let mut value = x[k];
            for entry in &program.u[u_start..step.u_end] {
                subtract(&mut value, &factors[entry.place], &x[entry.step]);
            }
            let (a, b) = (value, inverse[k]);
            x[k] = [
                std::array::from_fn(|i| a[0][i] * b[0][i] - a[1][i] * b[1][i]),
                std::array::from_fn(|i| a[0][i] * b[1][i] + a[1][i] * b[0][i]),
            ];
        }
    }
}
