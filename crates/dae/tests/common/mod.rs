//! Shared by the tests: test problems, exact derivatives by dual numbers, reference data.

#![allow(dead_code, unreachable_pub, reason = "every test binary uses its own part")]

pub mod by_hand;
pub mod dual;
pub mod mechanism;
pub mod problems;
pub mod reference;

use bksim_dae::{Index, Layout, NotFinite, Pattern, System};

use self::dual::{Dual, Real};

/// A residual written once for numbers and for dual numbers.
pub trait Residual {
    fn layout(&self) -> Layout;
    fn residual<T: Real>(&self, t: f64, y: &[T], ydot: &[T]) -> Vec<T>;

    /// See [`System::explicit_rows`].
    fn explicit_rows(&self) -> Vec<(usize, usize)> {
        Vec::new()
    }
}

/// Adapts a [`Residual`]: exact Jacobian, one column per evaluation on dual numbers.
pub struct Differentiated<R> {
    pub problem: R,
    layout: Layout,
    pattern: Pattern,
    explicit_rows: Vec<(usize, usize)>,
}

impl<R: Residual> Differentiated<R> {
    /// With a full pattern, and nothing to eliminate.
    pub fn dense(problem: R) -> Self {
        let layout = problem.layout();
        let pattern = Pattern::dense(layout.n());
        Self { problem, layout, pattern, explicit_rows: Vec::new() }
    }

    /// With the pattern found at one point without special values, and the rows that the problem
    /// declares to be explicit.
    pub fn sparse(problem: R) -> Self {
        let mut system = Self::dense(problem);
        let n = system.layout.n();
        let y: Vec<f64> = (0..n).map(|i| 0.3 + (1.3 * i as f64).sin() * 0.2).collect();
        let ydot: Vec<f64> = (0..n).map(|i| 0.7 + (2.1 * i as f64).cos() * 0.2).collect();
        let (mut df_dy, mut df_dydot) = (vec![0.0; n * n], vec![0.0; n * n]);
        system.jacobian(0.1, &y, &ydot, &mut df_dy, &mut df_dydot).expect("finite");
        let used: Vec<_> = system
            .pattern
            .entries()
            .enumerate()
            .filter(|&(k, _)| df_dy[k] != 0.0 || df_dydot[k] != 0.0)
            .map(|(_, entry)| entry)
            .collect();
        system.pattern = Pattern::new(n, used).expect("entries lie inside");
        system.explicit_rows = system.problem.explicit_rows();
        system
    }
}

fn lift(x: &[f64], seed: Option<usize>) -> Vec<Dual> {
    x.iter()
        .enumerate()
        .map(|(i, &value)| Dual { value, slope: f64::from(u8::from(seed == Some(i))) })
        .collect()
}

impl<R: Residual> System for Differentiated<R> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn explicit_rows(&self) -> &[(usize, usize)] {
        &self.explicit_rows
    }

    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        out.copy_from_slice(&self.problem.residual(t, y, ydot));
        Ok(())
    }

    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        let columns = |in_y: bool, col: usize| {
            let seed = |own: bool| (own == in_y).then_some(col);
            self.problem.residual(t, &lift(y, seed(true)), &lift(ydot, seed(false)))
        };
        for col in 0..y.len() {
            let (by_y, by_ydot) = (columns(true, col), columns(false, col));
            for row in 0..y.len() {
                if let Some(k) = self.pattern.position(row, col) {
                    df_dy[k] = by_y[row].slope;
                    df_dydot[k] = by_ydot[row].slope;
                }
            }
        }
        Ok(())
    }
}

/// `n` unknowns of index 1.
pub fn uniform(n: usize) -> Layout {
    Layout::from_groups(&[(n, Index::One)])
}

/// Slope of `log(error)` over `log(step)` by least squares.
pub fn fitted_order(steps: &[f64], errors: &[f64]) -> f64 {
    let logs = |x: &[f64]| x.iter().map(|x| x.ln()).collect::<Vec<_>>();
    let (x, y) = (logs(steps), logs(errors));
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (mx, my) = (mean(&x), mean(&y));
    let sxy: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let sxx: f64 = x.iter().map(|x| (x - mx) * (x - mx)).sum();
    sxy / sxx
}

/// Correct digits: `−log10 max |x − r| / max(1, |r|)`.
pub fn digits(x: &[f64], reference: &[f64]) -> f64 {
    let worst = max_error(x, reference);
    -worst.max(1e-17).log10()
}

/// `max |x − r| / max(1, |r|)`.
pub fn max_error(x: &[f64], reference: &[f64]) -> f64 {
    assert_eq!(x.len(), reference.len());
    let error = |(x, r): (&f64, &f64)| (x - r).abs() / r.abs().max(1.0);
    x.iter().zip(reference).map(error).fold(0.0, f64::max)
}
