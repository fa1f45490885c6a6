//! Nonlinear least squares with robust losses, and what the data leave open.
//!
//! ```text
//! min Σ ρ(rᵢ(θ))                Marquardt: (JᵀWJ + λ D) δ = −JᵀW r,   W = ρ'(r)/r
//! cov = (JᵀWJ)⁻¹                standard errors
//! J n = 0                       directions n that the data do not see
//! ```
//!
//! Source: Nocedal, Wright, Numerical Optimization, ch. 10; Huber, Robust Statistics.

use nalgebra::{DMatrix, DVector};

use crate::base::Watch;

/// How residuals, in standard deviations, count.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) enum Loss {
    #[default]
    Squares,
    /// Linear beyond so many standard deviations.
    Huber(f64),
    SoftL1(f64),
    Cauchy(f64),
}

impl Loss {
    /// The loss of this name, with the scale that keeps 95 % of the efficiency for normal noise unless given.
    pub(crate) fn named(name: &str, scale: Option<f64>) -> Option<Self> {
        match name {
            "squares" => Some(Self::Squares),
            "huber" => Some(Self::Huber(scale.unwrap_or(1.345))),
            "soft_l1" => Some(Self::SoftL1(scale.unwrap_or(1.0))),
            "cauchy" => Some(Self::Cauchy(scale.unwrap_or(2.385))),
            _ => None,
        }
    }

    /// Twice the loss of a residual, and the weight of its square.
    fn of(self, r: f64) -> (f64, f64) {
        match self {
            Self::Squares => (r * r, 1.0),
            Self::Huber(c) if r.abs() <= c => (r * r, 1.0),
            Self::Huber(c) => (2.0 * c * r.abs() - c * c, c / r.abs()),
            Self::SoftL1(c) => {
                let root = (1.0 + (r / c).powi(2)).sqrt();
                (2.0 * c * c * (root - 1.0), 1.0 / root)
            }
            Self::Cauchy(c) => {
                let z = 1.0 + (r / c).powi(2);
                (c * c * z.ln(), 1.0 / z)
            }
        }
    }

    /// The root of the weight of a residual.
    pub(crate) fn root(self, r: f64) -> f64 {
        self.of(r).1.sqrt()
    }

    fn sum(self, r: &[f64]) -> f64 {
        r.iter().map(|&r| self.of(r).0).sum()
    }
}

/// Residuals and their slopes.
pub(crate) trait Residuals {
    /// At a point; `None` where it has none.
    fn at(&self, x: &[f64]) -> Option<Vec<f64>>;
    /// Slopes, a row for each residual.
    fn slopes(&self, x: &[f64]) -> Option<DMatrix<f64>>;
}

/// The end of the iteration.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) x: Vec<f64>,
    pub(crate) residuals: Vec<f64>,
    /// Slopes times the roots of the weights.
    pub(crate) slopes: DMatrix<f64>,
    pub(crate) n_iterations: usize,
    pub(crate) converged: bool,
}

const MAX_ITERATIONS: usize = 200;
/// Columns of slopes below this part of the largest are rounding.
const NO_EFFECT: f64 = 1e-7;

/// The point of least loss near `x`; `scale` are the sizes of the unknowns.
pub(crate) fn least(
    problem: &dyn Residuals,
    x: Vec<f64>,
    scale: &[f64],
    loss: Loss,
    watch: Watch<'_>,
) -> Option<Found> {
    let n = x.len();
    let mut x = x;
    let mut r = problem.at(&x)?;
    let mut now = loss.sum(&r);
    let mut damping = 1e-4;
    let mut n_small = 0;
    let mut iteration = 0;
    let mut before: Option<Found> = None;
    loop {
        iteration += 1;
        let Some(mut j) = problem.slopes(&x) else {
            return before.filter(|_| (watch.stop)());
        };
        let mut weighted = DVector::from_column_slice(&r);
        for (i, &r) in r.iter().enumerate() {
            let root = loss.root(r);
            weighted[i] *= root;
            j.row_mut(i).scale_mut(root);
        }
        for k in 0..n {
            j.column_mut(k).scale_mut(scale[k]);
        }
        let converged = n_small >= 2;
        let mut slopes = j.clone();
        for k in 0..n {
            slopes.column_mut(k).scale_mut(1.0 / scale[k]);
        }
        let n_iterations = iteration - 1;
        let here = Found { x: x.clone(), residuals: r.clone(), slopes, n_iterations, converged };
        if converged || iteration > MAX_ITERATIONS || (watch.stop)() {
            return Some(here);
        }
        before = Some(here);
        (watch.kept)();
        (watch.reached)(&format!("iteration {iteration}, sum of squares {now:.6}"), 0.0);
        // Columns of unit length, so that damping means the same for all.
        let size: Vec<f64> = (0..n).map(|k| j.column(k).norm()).collect();
        let largest = size.iter().fold(0.0, |a: f64, b| a.max(*b)).max(1e-300);
        let mut is_down = false;
        for _ in 0..40 {
            let mut tall = DMatrix::zeros(j.nrows() + n, n);
            tall.rows_mut(0, j.nrows()).copy_from(&j);
            for k in 0..n {
                tall[(j.nrows() + k, k)] = f64::sqrt(damping) * size[k].max(1e-8 * largest);
            }
            let mut right = DVector::zeros(j.nrows() + n);
            right.rows_mut(0, j.nrows()).copy_from(&(-&weighted));
            let mut step = tall.svd(true, true).solve(&right, 1e-14).ok()?;
            // What has no effect stays where it is, whatever rounding says.
            for k in 0..n {
                if size[k] <= NO_EFFECT * largest {
                    step[k] = 0.0;
                }
            }
            let tried: Vec<f64> = (0..n).map(|k| x[k] + step[k] * scale[k]).collect();
            let is_small = step.amax() < 1e-9;
            if (watch.stop)() {
                break;
            }
            if let Some(found) = problem.at(&tried) {
                let then = loss.sum(&found);
                if then <= now * (1.0 + 4.0 * f64::EPSILON) {
                    n_small = if is_small || now - then <= 1e-13 * now { n_small + 1 } else { 0 };
                    (x, r, now) = (tried, found, then);
                    damping = (damping * 0.1).max(1e-14);
                    is_down = true;
                    break;
                }
            }
            if is_small {
                n_small = 2;
                is_down = true;
                break;
            }
            damping = (damping * 10.0).max(1e-10);
        }
        if !is_down {
            n_small = 2;
        }
    }
}

/// Knowledge about unknowns from slopes.
#[derive(Clone, Debug)]
pub(crate) struct Knowledge {
    pub(crate) rank: usize,
    /// Unknowns of which nothing depends.
    pub(crate) without_effect: Vec<usize>,
    /// Independent directions that nothing depends on, in units of the unknowns, the largest part one.
    pub(crate) null_vectors: Vec<Vec<f64>>,
    /// (JᵀJ)⁺.
    pub(crate) covariance: DMatrix<f64>,
}

/// The rank of slopes at unknowns of these sizes; singular values below `tolerance` of the largest are zero.
pub(crate) fn knowledge(slopes: &DMatrix<f64>, scale: &[f64], tolerance: f64) -> Option<Knowledge> {
    let n = scale.len();
    let mut j = slopes.clone();
    for k in 0..n {
        j.column_mut(k).scale_mut(scale[k]);
    }
    let size: Vec<f64> = (0..n).map(|k| j.column(k).norm()).collect();
    let largest = size.iter().fold(0.0, |a: f64, b| a.max(*b));
    let without_effect: Vec<usize> = (0..n).filter(|&k| size[k] <= tolerance * largest).collect();
    let seen: Vec<usize> = (0..n).filter(|k| !without_effect.contains(k)).collect();
    // Columns of unit length, rows enough for a square.
    let m = seen.len();
    let mut unit = DMatrix::zeros(j.nrows().max(m), m);
    for (column, &k) in seen.iter().enumerate() {
        unit.view_mut((0, column), (j.nrows(), 1)).copy_from(&(j.column(k) / size[k]));
    }
    let svd = unit.svd(false, true);
    let v_t = svd.v_t?;
    let first = svd.singular_values.iter().fold(0.0, |a: f64, b| a.max(*b));
    let is_null = |i: &usize| svd.singular_values[*i] <= tolerance * first;
    let nulls: Vec<usize> = (0..m).filter(is_null).collect();
    let mut covariance = DMatrix::zeros(n, n);
    for i in (0..m).filter(|i| !is_null(i)) {
        let s = svd.singular_values[i];
        for (a, &ka) in seen.iter().enumerate() {
            for (b, &kb) in seen.iter().enumerate() {
                let factor = scale[ka] / size[ka] * scale[kb] / size[kb];
                covariance[(ka, kb)] += v_t[(i, a)] * v_t[(i, b)] / (s * s) * factor;
            }
        }
    }
    let mut null_vectors = Vec::new();
    for row in reduced(DMatrix::from_fn(nulls.len(), m, |i, k| v_t[(nulls[i], k)])).row_iter() {
        let mut vector = vec![0.0; n];
        for (column, &k) in seen.iter().enumerate() {
            let part = row[column] * largest / size[k];
            vector[k] = part * scale[k];
        }
        let most = (0..n).map(|k| (vector[k] / scale[k]).abs()).fold(0.0, f64::max);
        for k in 0..n {
            let part = vector[k] / scale[k] / most;
            vector[k] = if part.abs() < 1e3 * tolerance { 0.0 } else { part * scale[k] };
        }
        null_vectors.push(vector);
    }
    Some(Knowledge { rank: m - nulls.len(), without_effect, null_vectors, covariance })
}

/// Rows reduced, so that each has as few entries as can be.
fn reduced(mut rows: DMatrix<f64>) -> DMatrix<f64> {
    let (n, m) = rows.shape();
    let mut used = Vec::new();
    for row in 0..n {
        let open = (0..m).filter(|column| !used.contains(column));
        let Some(pivot) =
            open.max_by(|a, b| rows[(row, *a)].abs().total_cmp(&rows[(row, *b)].abs()))
        else {
            break;
        };
        let value = rows[(row, pivot)];
        if value.abs() < 1e-12 {
            continue;
        }
        rows.row_mut(row).scale_mut(1.0 / value);
        for other in (0..n).filter(|other| *other != row) {
            let factor = rows[(other, pivot)];
            let change = rows.row(row) * factor;
            let mut other = rows.row_mut(other);
            other -= change;
        }
        used.push(pivot);
    }
    rows
}
