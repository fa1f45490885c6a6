//! Small dense linear algebra of one state: the multiplier system and minimum-norm solutions.

use nalgebra::{DMatrix, DVector};

use crate::compile::{Dynamics, Evaluator};
use crate::run::residuals;

/// Relative size below which a singular value counts as zero. A pose that is closed to rounding
/// shows dependent rows at 1e-12 and better; a mechanism within this of a singular pose is one.
pub(crate) const RANK_TOLERANCE: f64 = 1e-9;

/// Solution of M v̇ + Gᵀ λ = f, G v̇ = −γ.
#[derive(Clone, Debug)]
pub(crate) struct Accelerations {
    pub(crate) vdot: DVector<f64>,
    pub(crate) lambda: DVector<f64>,
}

/// Minimum-norm least-squares solution of `matrix x = rhs`, with the numeric rank.
pub(crate) fn least_squares(matrix: &DMatrix<f64>, rhs: &DVector<f64>) -> (DVector<f64>, usize) {
    truncated_least_squares(matrix, rhs, RANK_TOLERANCE)
}

/// As [`least_squares`], with singular values below `tolerance` times the largest taken as zero.
fn truncated_least_squares(
    matrix: &DMatrix<f64>,
    rhs: &DVector<f64>,
    tolerance: f64,
) -> (DVector<f64>, usize) {
    let n = matrix.ncols();
    if matrix.nrows() == 0 || n == 0 {
        return (DVector::zeros(n), 0);
    }
    if matrix.iter().any(|value| !value.is_finite()) {
        return (DVector::from_element(n, f64::NAN), 0);
    }
    let svd = matrix.clone().svd(true, true);
    let threshold = tolerance * svd.singular_values.max();
    let rank = svd.singular_values.iter().filter(|&&s| s > threshold).count();
    let x = svd.solve(rhs, threshold).unwrap_or_else(|_| DVector::zeros(n));
    (x, rank)
}

/// Rows of `jacobian` that depend on the others, and for each row whether it takes part in any
/// dependency. Rows are scaled to unit length first, so that units do not decide.
pub(crate) fn dependent_rows(jacobian: &DMatrix<f64>) -> Dependence {
    let nc = jacobian.nrows();
    let mut scaled = jacobian.clone();
    let longest = scaled.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
    for mut row in scaled.row_iter_mut() {
        let norm = row.norm();
        // A row of rounding errors constrains nothing in this pose.
        row /= if norm > RANK_TOLERANCE * longest { norm } else { f64::INFINITY };
    }
    // Rows are taken one by one in file order, each freed of its part along those kept before.
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut dependent = Vec::new();
    for row_idx in 0..nc {
        let mut rest = scaled.row(row_idx).transpose();
        for _ in 0..2 {
            for direction in &basis {
                let along = direction.dot(&rest);
                rest.axpy(-along, direction, 1.0);
            }
        }
        let norm = rest.norm();
        if norm > RANK_TOLERANCE.sqrt() * 1e-2 {
            basis.push(rest / norm);
        } else {
            dependent.push(row_idx);
        }
    }
    let involved = rows_in_dependencies(&scaled, &dependent);
    Dependence { rank: basis.len(), dependent, involved }
}

/// Which rows of a matrix depend on which.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Dependence {
    pub(crate) rank: usize,
    /// Rows that follow from rows before them.
    pub(crate) dependent: Vec<usize>,
    /// All rows that take part in a dependency, the dependent ones included.
    pub(crate) involved: Vec<usize>,
}

fn rows_in_dependencies(scaled: &DMatrix<f64>, dependent: &[usize]) -> Vec<usize> {
    let nc = scaled.nrows();
    let mut involved = vec![false; nc];
    for &row_idx in dependent {
        // The row as a combination of the independent ones: its coefficients name the partners.
        let others: Vec<usize> = (0..nc).filter(|row| !dependent.contains(row)).collect();
        let (coefficients, _) = least_squares(
            &scaled.select_rows(&others).transpose(),
            &scaled.row(row_idx).transpose(),
        );
        involved[row_idx] = true;
        for (&other, coefficient) in others.iter().zip(coefficients.iter()) {
            involved[other] |= coefficient.abs() > 1e-6;
        }
    }
    (0..nc).filter(|&row| involved[row]).collect()
}

/// Accelerations and multipliers of a state.
///
/// `dependent` rows are left out; the multipliers are then not unique and the smallest are
/// returned, as they are in a singular pose, where further rows become dependent for an instant.
/// `None` when no accelerations satisfy the equations.
pub(crate) fn accelerations(at: &Dynamics, dependent: &[usize]) -> Option<Accelerations> {
    let (matrix, rhs) = multiplier_system(at, dependent);
    let solution = solve_regular(&matrix, &rhs).or_else(|| solve_singular(&matrix, &rhs))?;
    Some(complete(at, dependent, &solution))
}

/// Like [`accelerations`], but never without an answer: what a singular system leaves open or
/// contradicts is taken as small as possible. For the moment of passing a singular pose.
pub(crate) fn nearest_accelerations(at: &Dynamics, dependent: &[usize]) -> Accelerations {
    const WELL_CONDITIONED: f64 = 1e-10;
    const TRUNCATION: f64 = 1e-7;
    let (matrix, rhs) = multiplier_system(at, dependent);
    let solution = solve_if(&matrix, &rhs, WELL_CONDITIONED)
        .unwrap_or_else(|| truncated_least_squares(&matrix, &rhs, TRUNCATION).0);
    complete(at, dependent, &solution)
}

/// The matrix and right side of M v̇ + Gᵀ λ = f, G v̇ = −γ over the rows that are not `dependent`.
fn multiplier_system(at: &Dynamics, dependent: &[usize]) -> (DMatrix<f64>, DVector<f64>) {
    let (nq, nc) = (at.force.len(), at.constraint.len());
    let kept: Vec<usize> = (0..nc).filter(|row| !dependent.contains(row)).collect();
    let n = nq + kept.len();
    let mut matrix = DMatrix::zeros(n, n);
    let mut rhs = DVector::zeros(n);
    matrix.view_mut((0, 0), (nq, nq)).copy_from(&at.mass);
    rhs.rows_mut(0, nq).copy_from(&at.force);
    for (k, &row) in kept.iter().enumerate() {
        for i in 0..nq {
            matrix[(nq + k, i)] = at.jacobian[(row, i)];
            matrix[(i, nq + k)] = at.jacobian[(row, i)];
        }
        rhs[nq + k] = -at.gamma[row];
    }
    (matrix, rhs)
}

/// Splits a solution, and finds the smallest multipliers when some rows were left out.
fn complete(at: &Dynamics, dependent: &[usize], solution: &DVector<f64>) -> Accelerations {
    let (nq, nc) = (at.force.len(), at.constraint.len());
    let vdot = solution.rows(0, nq).into_owned();
    let lambda = if dependent.is_empty() {
        solution.rows(nq, nc).into_owned()
    } else {
        let constraint_force = &at.force - &at.mass * &vdot;
        least_squares(&at.jacobian.transpose(), &constraint_force).0
    };
    Accelerations { vdot, lambda }
}

/// Largest residuals before and after a projection.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct Drift {
    /// |g|, m or rad.
    pub(crate) position: [f64; 2],
    /// |G v + ∂g/∂t|, m/s or rad/s.
    pub(crate) velocity: [f64; 2],
}

/// Moves q, then v, by the least amount onto the constraints.
pub(crate) fn project(
    evaluator: &mut Evaluator,
    t: f64,
    q: &mut [f64],
    v: &mut [f64],
    dependent: &[usize],
) -> Drift {
    const MAX_ITERATIONS: usize = 4;
    let [position, velocity] = residuals(evaluator, t, q, v);
    let mut drift = Drift { position: [position; 2], velocity: [velocity; 2] };
    for _ in 0..MAX_ITERATIONS {
        let at = evaluator.dynamics(t, q, v);
        let step = shortest_step(&at.jacobian, &at.constraint, dependent);
        let trial: Vec<f64> = q.iter().zip(step.iter()).map(|(q, s)| q - s).collect();
        let left = residuals(evaluator, t, &trial, v)[0];
        // Newton's steps gain until rounding; the first that does not is thrown away.
        if left.is_nan() || left >= drift.position[1] {
            break;
        }
        q.copy_from_slice(&trial);
        drift.position[1] = left;
    }
    let at = evaluator.dynamics(t, q, v);
    let rate = &at.jacobian * DVector::from_column_slice(v) + &at.rate;
    let step = shortest_step(&at.jacobian, &rate, dependent);
    v.iter_mut().zip(step.iter()).for_each(|(v, s)| *v -= s);
    drift.velocity[1] = residuals(evaluator, t, q, v)[1];
    drift
}

/// The shortest x with G x = r: x = Gᵀ (G Gᵀ)⁻¹ r over the independent rows.
fn shortest_step(
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    dependent: &[usize],
) -> DVector<f64> {
    if jacobian.nrows() == 0 {
        return DVector::zeros(jacobian.ncols());
    }
    let kept: Vec<usize> = (0..jacobian.nrows()).filter(|row| !dependent.contains(row)).collect();
    let (g, r) = (jacobian.select_rows(&kept), residual.select_rows(&kept));
    match solve_regular(&(&g * g.transpose()), &r) {
        Some(mu) => g.transpose() * mu,
        None => least_squares(jacobian, residual).0,
    }
}

/// Solves a square system; `None` when it is singular to working precision or not finite.
fn solve_regular(matrix: &DMatrix<f64>, rhs: &DVector<f64>) -> Option<DVector<f64>> {
    const SMALLEST_PIVOT: f64 = 1e-14;
    solve_if(matrix, rhs, SMALLEST_PIVOT)
}

/// Solves a square system whose pivots stay above a part of the largest.
fn solve_if(
    matrix: &DMatrix<f64>,
    rhs: &DVector<f64>,
    smallest_pivot: f64,
) -> Option<DVector<f64>> {
    if matrix.nrows() == 0 {
        return Some(DVector::zeros(0));
    }
    let lu = matrix.clone().lu();
    let pivots = lu.u().diagonal().map(f64::abs);
    let regular = pivots.min() > smallest_pivot * pivots.max();
    if !regular {
        return None;
    }
    let mut x = lu.solve(rhs)?;
    // One refinement step: reactions are differences of large numbers.
    let correction = lu.solve(&(rhs - matrix * &x))?;
    x += correction;
    x.iter().all(|value| value.is_finite()).then_some(x)
}

/// Minimum-norm solution of a singular but consistent system; `None` when it is inconsistent.
fn solve_singular(matrix: &DMatrix<f64>, rhs: &DVector<f64>) -> Option<DVector<f64>> {
    let (x, _) = least_squares(matrix, rhs);
    let error = (matrix * &x - rhs).amax();
    (error <= 1e-6 * rhs.amax().max(1e-300)).then_some(x)
}

/// Coordinates of a motion that the constraints leave free and that has no inertia.
pub(crate) fn motion_without_inertia(
    mass: &DMatrix<f64>,
    jacobian: &DMatrix<f64>,
) -> Option<Vec<usize>> {
    let nq = mass.nrows();
    if nq == 0 {
        return None;
    }
    let scale = mass.amax();
    // Padding to nq rows makes the decomposition return the null space as well.
    let mut padded = DMatrix::zeros(jacobian.nrows().max(nq), nq);
    padded.rows_mut(0, jacobian.nrows()).copy_from(jacobian);
    let svd = padded.svd(false, true);
    let v_t = svd.v_t?;
    let threshold = 1e-9 * svd.singular_values.max();
    let free: Vec<usize> = (0..nq).filter(|&k| svd.singular_values[k] <= threshold).collect();
    if free.is_empty() {
        return None;
    }
    let basis = v_t.select_rows(&free).transpose();
    let reduced = basis.transpose() * mass * &basis;
    let eigen = reduced.symmetric_eigen();
    let weak = eigen.eigenvalues.iter().position(|&value| value <= 1e-14 * scale)?;
    let direction = &basis * eigen.eigenvectors.column(weak);
    let largest = direction.amax();
    Some((0..nq).filter(|&i| direction[i].abs() > 0.1 * largest).collect())
}

/// Largest magnitude of the entries; zero without entries.
pub(crate) fn largest(vector: &DVector<f64>) -> f64 {
    if vector.is_empty() { 0.0 } else { vector.amax() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubled_row_is_dependent_and_names_its_partner() {
        let jacobian = DMatrix::from_row_slice(3, 3, &[1., 0., 0., 0., 2., 1., 3., 0., 0.]);
        let found = dependent_rows(&jacobian);
        let expected = Dependence { rank: 2, dependent: vec![2], involved: vec![0, 2] };
        assert_eq!(found, expected);
    }

    #[test]
    fn minimum_norm_shares_a_load_between_equal_supports() {
        let matrix = DMatrix::from_row_slice(1, 2, &[1.0, 1.0]);
        let (x, rank) = least_squares(&matrix, &DVector::from_element(1, 3.0));
        assert_eq!(rank, 1);
        assert!((x - DVector::from_element(2, 1.5)).amax() < 1e-14);
    }
}
