//! Both kernels solve, agree, and refuse singular matrices.

use super::*;

const SHIFT: f64 = 2.3;
const COMPLEX_SHIFT: c64 = c64::new(1.2, -0.7);

/// A regular, unsymmetric matrix with zeros on the diagonal, so that pivoting is needed.
fn example(n: usize) -> (Pattern, Jacobian) {
    let entries = |i: usize| [(i, (i + 1) % n), ((i + 2) % n, i), (i, (i + n / 2) % n)];
    let pattern = Pattern::new(n, (0..n).flat_map(entries)).expect("entries lie inside");
    let mut jacobian = Jacobian::new(pattern.n_entries());
    for k in 0..pattern.n_entries() {
        jacobian.df_dy[k] = (k as f64 * 1.7).sin();
        jacobian.df_dydot[k] = (k as f64 * 0.9 + 1.0).cos();
    }
    (pattern, jacobian)
}

fn right_side(n: usize) -> Vec<c64> {
    (0..n).map(|i| c64::new((i as f64).cos(), (3.0 * i as f64).sin())).collect()
}

/// `max |A x − b|` for the complex matrix.
fn defect(pattern: &Pattern, jacobian: &Jacobian, x: &[c64], b: &[c64]) -> f64 {
    let mut rest: Vec<c64> = b.to_vec();
    for ((row, col), value) in pattern.entries().zip(jacobian.combined(COMPLEX_SHIFT)) {
        rest[row] -= value * x[col];
    }
    rest.iter().map(|x| x.magnitude()).fold(0.0, f64::max)
}

#[test]
fn both_kernels_solve_and_agree() {
    for n in [1, 2, 7, 40] {
        let (pattern, jacobian) = example(n);
        let mut solutions = Vec::new();
        for solver in [LinearSolver::Dense, LinearSolver::Sparse] {
            let mut matrix = IterationMatrix::new(&pattern, 1, solver).expect("small");
            // Factoring twice shows that nothing is left over from the first time.
            for h in [0.5, 1.0] {
                matrix.factor(&pattern, &jacobian, SHIFT, &[COMPLEX_SHIFT], h).expect("regular");
            }
            let b = right_side(n);
            let mut x = b.clone();
            matrix.solve_complex(0, &mut x);
            let defect = defect(&pattern, &jacobian, &x, &b);
            assert!(defect < 1e-11, "{solver:?}, n = {n}: defect {defect:e}");
            let mut real: Vec<f64> = b.iter().map(|b| b.re).collect();
            matrix.solve_real(&mut real);
            solutions.push(real);
        }
        let gap = |(a, b): (&f64, &f64)| (a - b).abs();
        let gap = solutions[0].iter().zip(&solutions[1]).map(gap).fold(0.0, f64::max);
        assert!(gap < 1e-10, "n = {n}: the kernels differ by {gap:e}");
    }
}

#[test]
fn singular_and_nan_matrices_are_refused() {
    for solver in [LinearSolver::Dense, LinearSolver::Sparse] {
        // Rows 1 and 2 are equal.
        let entries = [(0, 0), (1, 1), (2, 1), (1, 2), (2, 2)];
        let pattern = Pattern::new(3, entries).expect("entries lie inside");
        let mut matrix = IterationMatrix::new(&pattern, 0, solver).expect("small");
        let mut jacobian = Jacobian::new(5);
        jacobian.df_dy.fill(2.0);
        let result = matrix.factor(&pattern, &jacobian, SHIFT, &[], 1.0);
        assert_eq!(result, Err(Singular), "{solver:?}");

        jacobian.df_dy[4] = f64::NAN;
        let result = matrix.factor(&pattern, &jacobian, SHIFT, &[], 1.0);
        assert_eq!(result, Err(Singular), "{solver:?}");

        jacobian.df_dy[4] = 3.0;
        assert_eq!(matrix.factor(&pattern, &jacobian, SHIFT, &[], 1.0), Ok(()), "{solver:?}");
    }
}

#[test]
fn structurally_singular_matrices_are_refused() {
    for solver in [LinearSolver::Dense, LinearSolver::Sparse] {
        // Column 2 is empty.
        let pattern = Pattern::new(3, [(0, 0), (1, 1), (2, 1)]).expect("entries lie inside");
        let mut matrix = IterationMatrix::new(&pattern, 0, solver).expect("small");
        let mut jacobian = Jacobian::new(3);
        jacobian.df_dy.fill(2.0);
        assert_eq!(
            matrix.factor(&pattern, &jacobian, SHIFT, &[], 1.0),
            Err(Singular),
            "{solver:?}"
        );
    }
}
