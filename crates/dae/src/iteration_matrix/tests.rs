//! All kernels solve, agree, and refuse singular matrices.

use super::*;
use crate::system::{Layout, NotFinite};

/// A system of which only the pattern is looked at.
struct Shape(Pattern, Vec<(usize, usize)>, Layout);

impl System for Shape {
    fn layout(&self) -> &Layout {
        &self.2
    }
    fn pattern(&self) -> &Pattern {
        &self.0
    }
    fn explicit_rows(&self) -> &[(usize, usize)] {
        &self.1
    }
    fn residual(&mut self, _: f64, _: &[f64], _: &[f64], _: &mut [f64]) -> Result<(), NotFinite> {
        Ok(())
    }
    fn jacobian(
        &mut self,
        _: f64,
        _: &[f64],
        _: &[f64],
        _: &mut [f64],
        _: &mut [f64],
    ) -> Result<(), NotFinite> {
        Ok(())
    }
}

fn matrices(
    pattern: &Pattern,
    explicit: &[(usize, usize)],
    n_complex: usize,
    solver: LinearSolver,
) -> Result<IterationMatrix, SolveError> {
    let layout = Layout::from_groups(&[(pattern.n(), Index::One)]);
    IterationMatrix::new(&Shape(pattern.clone(), explicit.to_vec(), layout), n_complex, solver)
}

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

/// Real parts, then imaginary parts.
fn right_side(n: usize) -> Vec<f64> {
    let parts = [f64::cos, f64::sin];
    parts.iter().flat_map(|part| (0..n).map(move |i| part(3.0 * i as f64))).collect()
}

/// `max |A x − b|`.
fn defect<T: Scalar>(
    (pattern, jacobian, shift): (&Pattern, &Jacobian, T),
    x: &[f64],
    b: &[f64],
) -> f64 {
    let n = pattern.n();
    let mut rest: Vec<T> = (0..n).map(|i| T::load(b, i, n)).collect();
    for ((row, col), value) in pattern.entries().zip(jacobian.combined(shift)) {
        rest[row] -= value * T::load(x, col, n);
    }
    rest.iter().map(|x| x.magnitude()).fold(0.0, f64::max)
}

/// The solution with the only complex matrix.
fn solve_complex(matrix: &mut IterationMatrix, b: &[f64]) -> Vec<f64> {
    let n = b.len() / 2;
    let mut all = [&b[..n], b].concat();
    matrix.solve_all(n, &mut all);
    all.split_off(n)
}

const KERNELS: [LinearSolver; 3] =
    [LinearSolver::Static, LinearSolver::Dense, LinearSolver::Sparse];

#[test]
fn all_kernels_solve_and_agree() {
    for n in [1, 2, 7, 40] {
        let (pattern, jacobian) = example(n);
        let mut solutions = Vec::new();
        for solver in KERNELS {
            let mut matrix = matrices(&pattern, &[], 1, solver).expect("small");
            // Factoring twice shows that nothing is left over from the first time.
            for h in [0.5, 1.0] {
                matrix.factor(&jacobian, SHIFT, &[COMPLEX_SHIFT], h).expect("regular");
            }
            let b = right_side(n);
            let x = solve_complex(&mut matrix, &b);
            let found = defect((&pattern, &jacobian, COMPLEX_SHIFT), &x, &b);
            assert!(found < 1e-11, "{solver:?}, n = {n}: defect {found:e}");
            let mut real = b[..n].to_vec();
            matrix.solve_real(&mut real);
            let found = defect((&pattern, &jacobian, SHIFT), &real, &b[..n]);
            assert!(found < 1e-11, "{solver:?}, n = {n}: defect {found:e}");
            solutions.push(real);
        }
        for other in &solutions[1..] {
            let gap = |(a, b): (&f64, &f64)| (a - b).abs();
            let gap = solutions[0].iter().zip(other).map(gap).fold(0.0, f64::max);
            assert!(gap < 1e-10, "n = {n}: the kernels differ by {gap:e}");
        }
    }
}

#[test]
fn singular_and_nan_matrices_are_refused() {
    for solver in KERNELS {
        // Rows 1 and 2 are equal.
        let entries = [(0, 0), (1, 1), (2, 1), (1, 2), (2, 2)];
        let pattern = Pattern::new(3, entries).expect("entries lie inside");
        let mut matrix = matrices(&pattern, &[], 0, solver).expect("small");
        let mut jacobian = Jacobian::new(5);
        jacobian.df_dy.fill(2.0);
        let result = matrix.factor(&jacobian, SHIFT, &[], 1.0);
        assert_eq!(result, Err(Singular), "{solver:?}");

        jacobian.df_dy[4] = f64::NAN;
        let result = matrix.factor(&jacobian, SHIFT, &[], 1.0);
        assert_eq!(result, Err(Singular), "{solver:?}");

        jacobian.df_dy[4] = 3.0;
        assert_eq!(matrix.factor(&jacobian, SHIFT, &[], 1.0), Ok(()), "{solver:?}");
    }
}

#[test]
fn structurally_singular_matrices_are_refused() {
    for solver in KERNELS {
        // Column 2 is empty.
        let pattern = Pattern::new(3, [(0, 0), (1, 1), (2, 1)]).expect("entries lie inside");
        let mut matrix = matrices(&pattern, &[], 0, solver).expect("small");
        let mut jacobian = Jacobian::new(3);
        jacobian.df_dy.fill(2.0);
        assert_eq!(matrix.factor(&jacobian, SHIFT, &[], 1.0), Err(Singular), "{solver:?}");
    }
}

/// A mechanism's matrix: `nq` rows `q′ − v − Gᵀμ = 0`, and values of no pattern elsewhere.
fn mechanism(nq: usize, nc: usize) -> (Pattern, Jacobian, Vec<(usize, usize)>) {
    let n = 2 * nq + nc;
    let explicit: Vec<_> = (0..nq).map(|i| (i, nq + (i + 1) % nq)).collect();
    let mut entries: Vec<(usize, usize)> = explicit.clone();
    for row in 0..n {
        entries.extend(
            (0..n)
                .filter(|&col| {
                    let is_velocity = (nq..2 * nq).contains(&col);
                    (row * 7 + col * 5) % 3 > 0 && !(row < nq && is_velocity)
                })
                .map(|col| (row, col)),
        );
    }
    let pattern = Pattern::new(n, entries).expect("entries lie inside");
    let mut jacobian = Jacobian::new(pattern.n_entries());
    for (k, (row, col)) in pattern.entries().enumerate() {
        let is_pivot = explicit.contains(&(row, col));
        jacobian.df_dy[k] = if is_pivot { -1.0 } else { (1.7 * (k * k) as f64).sin() };
        jacobian.df_dydot[k] = if is_pivot { 0.0 } else { (0.9 * (k * k) as f64 + 1.0).cos() };
    }
    (pattern, jacobian, explicit)
}

#[test]
fn eliminated_rows_leave_the_solution_as_it_is() {
    for (nq, nc) in [(1, 0), (1, 1), (4, 2), (7, 6), (20, 11)] {
        let (pattern, jacobian, explicit) = mechanism(nq, nc);
        let n = pattern.n();
        for solver in KERNELS {
            let mut matrix = matrices(&pattern, &explicit, 1, solver).expect("fits");
            let plan = Elimination::new(&pattern, &explicit).expect("fits");
            assert_eq!(plan.remainder().n(), nq + nc);
            for h in [0.5, 1.0] {
                matrix.factor(&jacobian, SHIFT, &[COMPLEX_SHIFT], h).expect("regular");
            }
            let b = right_side(n);
            let x = solve_complex(&mut matrix, &b);
            let found = defect((&pattern, &jacobian, COMPLEX_SHIFT), &x, &b);
            assert!(found < 1e-9, "{solver:?}, {nq} + {nc}: complex defect {found:e}");
            let mut x = b[..n].to_vec();
            matrix.solve_real(&mut x);
            let found = defect((&pattern, &jacobian, SHIFT), &x, &b[..n]);
            assert!(found < 1e-9, "{solver:?}, {nq} + {nc}: real defect {found:e}");
        }
    }
}

#[test]
fn a_vanishing_or_infinite_pivot_of_an_explicit_row_is_refused() {
    let (pattern, mut jacobian, explicit) = mechanism(4, 2);
    let mut matrix = matrices(&pattern, &explicit, 1, LinearSolver::Auto).expect("fits");
    let entry = pattern.position(explicit[2].0, explicit[2].1).expect("it holds its unknown");
    for bad in [0.0, f64::NAN, f64::INFINITY] {
        jacobian.df_dy[entry] = bad;
        let result = matrix.factor(&jacobian, SHIFT, &[COMPLEX_SHIFT], 1.0);
        assert_eq!(result, Err(Singular), "pivot {bad}");
    }
    jacobian.df_dy[entry] = -1.0;
    assert_eq!(matrix.factor(&jacobian, SHIFT, &[COMPLEX_SHIFT], 1.0), Ok(()));
}

#[test]
fn rows_that_do_not_give_their_unknown_are_refused_by_name() {
    let pattern = Pattern::new(3, [(0, 0), (0, 1), (1, 0), (1, 1), (2, 2)]).expect("inside");
    let refused = |explicit: &[(usize, usize)]| {
        let result = matrices(&pattern, explicit, 0, LinearSolver::Auto);
        result.err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(refused(&[(0, 2)]).contains("row 0 cannot give unknown 2: it does not hold it"));
    assert!(refused(&[(0, 0), (1, 1)]).contains("another explicit row"));
    for repeated in [[(0, 0), (0, 1)], [(0, 0), (2, 0)], [(0, 0), (3, 2)]] {
        assert!(refused(&repeated).contains("named twice"), "{repeated:?}");
    }
    assert_eq!(refused(&[(0, 1), (2, 2)]), "");
}

/// The entries that were large when pivots were chosen become tiny, one after the other.
#[test]
fn pivots_that_have_become_bad_are_replaced() {
    let (pattern, mut jacobian) = example(12);
    let mut matrix = matrices(&pattern, &[], 1, LinearSolver::Static).expect("small");
    matrix.factor(&jacobian, SHIFT, &[COMPLEX_SHIFT], 1.0).expect("regular");
    let b = right_side(12);
    for k in 0..pattern.n_entries() {
        let (dy, dydot) = (jacobian.df_dy[k], jacobian.df_dydot[k]);
        (jacobian.df_dy[k], jacobian.df_dydot[k]) = (1e-13 * dy, 1e-13 * dydot);
        if matrix.factor(&jacobian, SHIFT, &[COMPLEX_SHIFT], 1.0).is_ok() {
            let x = solve_complex(&mut matrix, &b);
            let size = x.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
            let found = defect((&pattern, &jacobian, COMPLEX_SHIFT), &x, &b);
            assert!(found < 1e-9 * size, "entry {k}: defect {found:e} of {size:e}");
        }
        (jacobian.df_dy[k], jacobian.df_dydot[k]) = (dy, dydot);
    }
}
