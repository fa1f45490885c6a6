//! [`MultiplierSystem`]: what is solved at one state, and what its factors serve for besides.
//!
//! ```text
//! [ M  Gᵀ ] [ v̇ ]   [  f ]        accelerations and multipliers
//! [ G  0  ] [ λ ] = [ −γ ]
//!
//! [ M  Gᵀ ] [ δ ]   [ 0 ]         the step δ, smallest in the norm of M, that takes r away
//! [ G  0  ] [ μ ] = [ r ]
//! ```
//!
//! Inactive rows of G, which depend on others or belong to open contacts, are left out. The recorded elimination serves wherever M is
//! positive definite and G of full rank; elsewhere dense factors with pivots do, and in a singular
//! pose the smallest solution of the equations without their weakest directions.

mod limit;
mod nearby;
mod planned;
mod pressed;
pub(crate) mod projection;
mod straight_line;

use bksim_dae::{Loader, NotFinite, Saver, SolveError};
use nalgebra::{DMatrix, DVector, Dyn, LU};

use self::limit::Solution;
use self::projection::Rows;
use crate::evaluator::{DynamicsAt, Evaluator};
use crate::linear::augmented::Augmented;
use crate::linear::dense::{self, truncated_inverse};
use crate::linear::elimination::{Elimination, Singular};
use crate::linear::rows::{Inverse, LARGEST_DENSE, SparseRows, shortest_solution};
use crate::linear::shape::Shape;

/// The multiplier system, factored at one state.
#[derive(Clone, Debug)]
pub(crate) struct MultiplierSystem {
    nq: usize,
    /// Rows of G that take part.
    active: Vec<usize>,
    elimination: Elimination,
    /// In the place of `elimination` once a coordinate has turned out to have no inertia.
    augmented: Option<Box<Augmented>>,
    factors: Factors,
    /// Right side, then solution: nq coordinates, then the active multipliers.
    x: Vec<f64>,
    /// Values of G that were factored.
    jacobian: Vec<f64>,
    residual: Vec<f64>,
    trial: Vec<f64>,
    rows: Rows,
}

#[derive(Clone, Debug)]
enum Factors {
    Recorded,
    Pivoted(LU<f64, Dyn, Dyn>),
    /// The inverse without the weakest directions.
    Truncated(DMatrix<f64>),
    /// Factors of a large system.
    Sparse(Box<Inverse>),
}

/// Pivots of the dense factors below this part of the largest call for the truncated inverse.
const WELL_CONDITIONED: f64 = 1e-14;
/// Rows of which those that are empty are left out of what is found by them all.
const MANY_ROWS: usize = 40;
/// The elimination loses as many digits as its weakest pivot; below this, refinement gets them back.
const REFINED_BELOW: f64 = 1e-5;
impl MultiplierSystem {
    /// The solution of systems of this shape of which these rows take part.
    fn new(shape: &Shape, active: Vec<usize>, elimination: Elimination) -> Self {
        let (nq, nc) = (shape.nq, shape.nc);
        Self {
            nq,
            elimination,
            augmented: None,
            factors: Factors::Recorded,
            x: vec![0.0; nq + active.len()],
            jacobian: vec![0.0; shape.jacobian.len()],
            residual: vec![0.0; nc],
            trial: vec![0.0; nq],
            rows: Rows::default(),
            active,
        }
    }

    /// Saves the numbers that outlive a state: the best pivots, by which the rank margin is measured.
    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.flag(self.augmented.is_some());
        saver.slice(match &self.augmented {
            Some(augmented) => augmented.best_pivots(),
            None => self.elimination.best_pivots(),
        });
    }

    /// Takes over what was saved by a system without the same rows.
    pub(crate) fn load(
        &mut self,
        shape: &Shape,
        loader: &mut Loader<'_>,
    ) -> Result<(), SolveError> {
        if !loader.flag()? {
            return loader.fill(self.elimination.best_pivots_mut());
        }
        let mut augmented = Augmented::new(shape, &self.active);
        loader.fill(augmented.best_pivots_mut())?;
        self.augmented = Some(Box::new(augmented));
        Ok(())
    }

    /// Rows of G that take part.
    pub(crate) fn active_rows(&self) -> &[usize] {
        &self.active
    }

    /// Distance of the factored state from a singular pose: about the square of the smallest singular
    /// value of G, as a part of the largest met so far.
    pub(crate) fn rank_margin(&self) -> f64 {
        match self.factors {
            Factors::Recorded => self.recorded_rank_margin(),
            _ => self.recorded_rank_margin().min(WELL_CONDITIONED),
        }
    }

    fn recorded_rank_margin(&self) -> f64 {
        match &self.augmented {
            Some(augmented) => augmented.rank_margin(),
            None => self.elimination.rank_margin(),
        }
    }

    /// The rank margin at a state, without factors that serve where there is none; NaN where the state
    /// has no finite values.
    pub(crate) fn rank_margin_at(&mut self, at: &DynamicsAt) -> f64 {
        // A singular state leaves a vanishing pivot, and the margin says so.
        let _ = self.eliminate(at);
        if at.is_finite() { self.recorded_rank_margin() } else { f64::NAN }
    }

    /// The recorded elimination, with coordinates without inertia allowed for once there are some.
    fn eliminate(&mut self, at: &DynamicsAt) -> Result<(), Singular> {
        if self.augmented.is_none() {
            match self.elimination.factor(at.mass, at.jacobian) {
                Err(Singular::Coordinate) if at.is_finite() => {
                    self.augmented = Some(Box::new(Augmented::new(at.shape, &self.active)));
                }
                outcome => return outcome,
            }
        }
        self.augmented.as_mut().map_or(Ok(()), |it| it.factor(at.mass, at.jacobian))
    }

    /// Factors the system at a state.
    ///
    /// # Errors
    /// [`NotFinite`] when an entry is not finite; its row is counted in (q, λ).
    pub(crate) fn factor(&mut self, at: &DynamicsAt) -> Result<(), NotFinite> {
        self.jacobian.copy_from_slice(at.jacobian);
        if self.eliminate(at).is_ok() {
            self.factors = Factors::Recorded;
            return Ok(());
        }
        let matrix = self.rows_at(at)?;
        if self.nq > LARGEST_DENSE {
            let inverse = Inverse::of(matrix).ok_or(NotFinite { row: 0 })?;
            self.factors = Factors::Sparse(Box::new(inverse));
            return Ok(());
        }
        let matrix = matrix.dense();
        let lu = matrix.clone().lu();
        let pivots = lu.u().diagonal().map(f64::abs);
        self.factors = if pivots.min() > WELL_CONDITIONED * pivots.max() {
            Factors::Pivoted(lu)
        } else {
            Factors::Truncated(truncated_inverse(&matrix))
        };
        Ok(())
    }

    /// The matrix of the system.
    fn rows_at(&self, at: &DynamicsAt) -> Result<SparseRows, NotFinite> {
        let entries = at.shape.mass.iter().map(|&(i, _)| i).zip(at.mass);
        let couplings = at.shape.jacobian.iter().map(|&(row, _)| self.nq + row).zip(at.jacobian);
        if let Some((row, _)) = entries.chain(couplings).find(|(_, value)| !value.is_finite()) {
            return Err(NotFinite { row });
        }
        let active = at.jacobian_rows().select(&self.active);
        let couplings = active.entries().map(|(k, i, g)| (self.nq + k, i, g));
        let lower = at.shape.mass.iter().zip(at.mass).map(|(&(i, j), &m)| (i, j, m));
        let lower: Vec<_> = lower.chain(couplings).collect();
        let upper = lower.iter().filter(|entry| entry.0 != entry.1).map(|&(i, j, e)| (j, i, e));
        let entries = lower.iter().copied().chain(upper);
        Ok(SparseRows::from_entries(self.x.len(), self.x.len(), entries))
    }

    /// Coordinates of a motion that the constraints, of which `jacobian` holds those that close
    /// loops, leave free and that has no inertia.
    pub(crate) fn motion_without_inertia(
        &mut self,
        at: &DynamicsAt,
        jacobian: &SparseRows,
    ) -> Option<Vec<usize>> {
        const VANISHING: f64 = 1e-9;
        const PART: f64 = 0.1;
        if self.nq <= LARGEST_DENSE {
            return dense::motion_without_inertia(&at.mass_matrix(), &jacobian.dense());
        }
        // With inertia in every direction there is none.
        if self.elimination.factor(at.mass, at.jacobian).is_ok() {
            return None;
        }
        let matrix = self.rows_at(at).ok()?;
        let size = matrix.norms().into_iter().fold(0.0, f64::max);
        let (direction, left) = Inverse::of(matrix)?.weakest_combination();
        let motion = &direction[..self.nq];
        // Otherwise only multipliers are not unique.
        let is_motion = largest(motion) > PART * largest(&direction);
        let is_part = |&i: &usize| motion[i].abs() > PART * largest(motion);
        let found = left <= VANISHING * size && is_motion;
        found.then(|| (0..self.nq).filter(is_part).collect())
    }

    fn is_truncated(&self) -> bool {
        matches!(self.factors, Factors::Truncated(_) | Factors::Sparse(_))
    }

    /// Solves for the right side in `x`, in place.
    fn solve(&mut self) {
        match &mut self.factors {
            Factors::Recorded => match &mut self.augmented {
                Some(augmented) => augmented.solve_in_place(&self.jacobian, &mut self.x),
                None => self.elimination.solve_in_place(&mut self.x),
            },
            Factors::Pivoted(lu) => {
                let mut x = DVector::from_column_slice(&self.x);
                if !lu.solve_mut(&mut x) {
                    x.fill(f64::NAN);
                }
                self.x.copy_from_slice(x.as_slice());
            }
            Factors::Sparse(inverse) => self.x = inverse.apply(&self.x),
            Factors::Truncated(inverse) => {
                let x = &*inverse * DVector::from_column_slice(&self.x);
                self.x.copy_from_slice(x.as_slice());
            }
        }
    }

    /// Factors the system at a state and solves it for the accelerations and the active multipliers;
    /// the others are set to zero. Loads follow the multipliers that they depend on.
    ///
    /// # Errors
    /// [`NotFinite`] when an entry, or the solution, is not finite.
    pub(crate) fn accelerations_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        if !evaluator.pressing_rows().is_empty() {
            return self.pressed_into(evaluator, t, (q, v), vdot, lambda);
        }
        self.solved_into(&evaluator.dynamics(t, q, v), vdot, lambda)
    }

    /// Accelerations ([`MultiplierSystem::accelerations_into`]) for loads that are known.
    pub(crate) fn solved_into(
        &mut self,
        at: &DynamicsAt,
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.factor(at)?;
        self.spread_solution((at.force, at.gamma), vdot, lambda);
        if self.rank_margin() < REFINED_BELOW {
            self.refine(at, vdot, lambda);
        }
        first_not_finite(vdot, lambda)
    }

    /// Solution ([`MultiplierSystem::solved_into`]) for other forces and γ, with the factors that there are.
    ///
    /// # Errors
    /// [`NotFinite`] when the solution is not finite.
    pub(crate) fn solve_with_factors(
        &mut self,
        right: (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.spread_solution(right, vdot, lambda);
        first_not_finite(vdot, lambda)
    }

    fn spread_solution(
        &mut self,
        (force, gamma): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) {
        self.x[..self.nq].copy_from_slice(force);
        for (x, &row) in self.x[self.nq..].iter_mut().zip(&self.active) {
            *x = -gamma[row];
        }
        self.solve();
        self.spread(vdot, lambda);
    }

    /// Number of coordinates.
    pub(crate) fn n_coordinates(&self) -> usize {
        self.nq
    }

    /// True where the recorded elimination of all rows serves.
    pub(crate) fn is_whole(&self, nc: usize) -> bool {
        self.active.len() == nc && self.augmented.is_none()
    }

    /// Limit ([`MultiplierSystem::limit_into`]), refined; the multipliers are the smallest ones where they
    /// are not unique.
    ///
    /// # Errors
    /// [`NotFinite`] when an entry, or the solution, is not finite.
    pub(crate) fn complete_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        let solution = self.limit_into(evaluator, t, (q, v), vdot, lambda)?;
        let at = evaluator.dynamics(t, q, v);
        if solution == Solution::Regular {
            self.refine(&at, vdot, lambda);
        }
        if solution == Solution::Limit || !self.is_unique(&at) {
            let found = lambda.to_vec();
            shortest_into(&at, vdot, lambda);
            let is_pressed = !evaluator.pressing_rows().is_empty();
            if is_pressed && !pressed::settles(evaluator, t, (q, v), vdot, lambda) {
                if solution == Solution::Regular {
                    lambda.copy_from_slice(&found);
                }
                evaluator.press(lambda);
            }
        }
        Ok(())
    }

    /// True if the multipliers are unique: every row takes part, or is empty as those of open contacts are.
    fn is_unique(&self, at: &DynamicsAt) -> bool {
        let nc = at.shape.nc;
        if self.active.len() == nc {
            return true;
        }
        let mut takes_part = vec![false; nc];
        self.active.iter().for_each(|&row| takes_part[row] = true);
        let mut entries = at.shape.jacobian.iter().zip(at.jacobian);
        entries.all(|(&(row, _), &g)| takes_part[row] || g == 0.0)
    }

    /// One step of iterative refinement of the accelerations and multipliers just found: reactions
    /// are differences of large numbers.
    fn refine(&mut self, at: &DynamicsAt, vdot: &mut [f64], lambda: &mut [f64]) {
        if self.is_truncated() {
            return;
        }
        let (upper, lower) = self.x.split_at_mut(self.nq);
        upper.copy_from_slice(at.force);
        self.residual.iter_mut().zip(at.gamma).for_each(|(r, gamma)| *r = -gamma);
        for (&(i, j), &m) in at.shape.mass.iter().zip(at.mass) {
            upper[i] -= m * vdot[j];
            if i != j {
                upper[j] -= m * vdot[i];
            }
        }
        for (&(row, i), &g) in at.shape.jacobian.iter().zip(at.jacobian) {
            upper[i] -= g * lambda[row];
            self.residual[row] -= g * vdot[i];
        }
        lower.iter_mut().zip(&self.active).for_each(|(x, &row)| *x = self.residual[row]);
        self.solve();
        vdot.iter_mut().zip(&self.x).for_each(|(a, change)| *a += change);
        let changes = self.x[self.nq..].iter().zip(&self.active);
        changes.for_each(|(change, &row)| lambda[row] += change);
    }

    fn spread(&self, vdot: &mut [f64], lambda: &mut [f64]) {
        vdot.copy_from_slice(&self.x[..self.nq]);
        lambda.fill(0.0);
        let values = self.x[self.nq..].iter().zip(&self.active);
        values.for_each(|(&value, &row)| lambda[row] = value);
    }
}

/// Finds the smallest multipliers of all rows for these accelerations under the loads at this state; what they leave
/// unbalanced, N or N·m.
fn shortest_into(at: &DynamicsAt, vdot: &[f64], lambda: &mut [f64]) -> f64 {
    let inertia = at.inertia_of(vdot);
    let needed: Vec<f64> = at.force.iter().zip(&inertia).map(|(f, inertia)| f - inertia).collect();
    // Empty rows, as of open contacts, have no part in it.
    let rows = at.jacobian_rows();
    let is_there = |&row: &usize| rows.row(row).iter().any(|&(_, g)| g != 0.0);
    let all = 0..rows.n_rows();
    let there: Vec<usize> =
        if rows.n_rows() > MANY_ROWS { all.filter(is_there).collect() } else { all.collect() };
    let columns = rows.select(&there).transposed();
    let found = shortest_solution(&columns, &needed);
    let left: Vec<f64> = columns.times(&found).iter().zip(&needed).map(|(g, f)| g - f).collect();
    lambda.fill(0.0);
    there.iter().zip(found).for_each(|(&row, force)| lambda[row] = force);
    largest(&left)
}

fn first_not_finite(vdot: &[f64], lambda: &[f64]) -> Result<(), NotFinite> {
    let row = vdot.iter().chain(lambda).position(|value| !value.is_finite());
    row.map_or(Ok(()), |row| Err(NotFinite { row }))
}

/// Largest magnitude; NaN when there is one.
pub(crate) fn largest(values: &[f64]) -> f64 {
    // `f64::max` drops NaN, which must come out on top here.
    values.iter().fold(0.0, |a: f64, b| if b.abs() > a || b.is_nan() { b.abs() } else { a })
}
