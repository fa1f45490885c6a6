//! On which side of a singular pose a state lies.
//!
//! Where the independent constraint rows G lose rank, the determinant of G over as many
//! coordinates vanishes, and in general it changes sign as the motion goes on. A step whose ends
//! lie on two sides has passed such a pose, or one in which only these coordinates no longer fix
//! the others; the rank where the sign changes tells them apart.

use bksim_dae::Step;
use nalgebra::{DMatrix, RowDVector};

use crate::compile::Evaluator;
use crate::crossing::{State, smallest_singular_value};

/// Part of its regular value below which the smallest singular value is that of a singular pose.
const SINGULAR: f64 = 1e-3;
/// Halvings of a step in search of the pose: to rounding.
const HALVINGS: usize = 50;

/// Part of its largest value below which det G calls for other coordinates, or for care.
const WEAK: f64 = 0.1;

/// What a step has come to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Pose {
    /// The constraints are independent by a good margin.
    Regular,
    /// They are not, but the step has not passed a singular pose.
    Weak,
    /// The step has passed a singular pose.
    Passed,
}

/// det G over the coordinates that the constraints fix best.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Side {
    columns: Vec<usize>,
    determinant: f64,
    /// The largest |det G| so far.
    regular: f64,
}

impl Side {
    /// The side of the first state of a leg; `regular` is the largest |det G| of the legs before.
    pub(crate) fn of(
        evaluator: &mut Evaluator,
        state: &State,
        dependent: &[usize],
        regular: f64,
    ) -> Self {
        let (columns, determinant) = best_columns(evaluator, state, dependent);
        Self { columns, determinant, regular: regular.max(determinant.abs()) }
    }

    /// The largest |det G| so far.
    pub(crate) fn regular(&self) -> f64 {
        self.regular
    }

    /// Follows a step from this side; `regular` is the smallest singular value of a regular pose.
    pub(crate) fn follow(
        &mut self,
        evaluator: &mut Evaluator,
        step: &Step<'_>,
        dependent: &[usize],
        regular: f64,
    ) -> Pose {
        let nq = evaluator.at.force.len();
        let mut y = vec![0.0; step.y1().len()];
        let mut state_at = |t: f64| {
            step.at(t, &mut y);
            State { t, q: y[..nq].to_vec(), v: y[nq..2 * nq].to_vec(), a: Vec::new() }
        };
        let last = state_at(step.t1());
        let determinant = |evaluator: &mut Evaluator, state: &State| {
            determinant(&independent_rows(evaluator, state, dependent), &self.columns)
        };
        let at_end = determinant(evaluator, &last);
        if at_end * self.determinant <= 0.0 {
            let (mut before, mut behind) = (step.t0(), step.t1());
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + behind);
                if determinant(evaluator, &state_at(middle)) * self.determinant > 0.0 {
                    before = middle;
                } else {
                    behind = middle;
                }
            }
            let least = smallest_singular_value(evaluator, &state_at(behind), dependent);
            if least < SINGULAR * regular {
                return Pose::Passed;
            }
        }
        self.determinant = at_end;
        if at_end.abs() < WEAK * self.regular {
            (self.columns, self.determinant) = best_columns(evaluator, &last, dependent);
        }
        self.regular = self.regular.max(self.determinant.abs());
        if self.determinant.abs() < WEAK * self.regular { Pose::Weak } else { Pose::Regular }
    }
}

/// The coordinates that the constraints fix best in a state, and det G over them.
fn best_columns(
    evaluator: &mut Evaluator,
    state: &State,
    dependent: &[usize],
) -> (Vec<usize>, f64) {
    let rows = independent_rows(evaluator, state, dependent);
    let mut columns = RowDVector::from_iterator(rows.ncols(), 0..rows.ncols());
    rows.clone().col_piv_qr().p().permute_columns(&mut columns);
    let columns: Vec<usize> = columns.iter().copied().take(rows.nrows()).collect();
    let determinant = determinant(&rows, &columns);
    (columns, determinant)
}

fn independent_rows(evaluator: &mut Evaluator, state: &State, dependent: &[usize]) -> DMatrix<f64> {
    let jacobian = &evaluator.dynamics(state.t, &state.q, &state.v).jacobian;
    let kept: Vec<usize> = (0..jacobian.nrows()).filter(|row| !dependent.contains(row)).collect();
    jacobian.select_rows(&kept)
}

/// det of some columns; 1 where there are no rows.
fn determinant(rows: &DMatrix<f64>, columns: &[usize]) -> f64 {
    if columns.len() < rows.nrows() {
        return 0.0;
    }
    rows.select_columns(columns).lu().determinant()
}
