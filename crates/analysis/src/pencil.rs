//! [`Pencil`]: M s² + C s + K of small motions along the free ones, its eigenvalues and vectors.

use bksim_sim::Svd;
use nalgebra::{Complex, DMatrix, DVector};

use crate::eigenvalues::eigenvalues;
use crate::forces::ForcesAt;
use crate::reduced::{Reduced, pseudo_inverse};

/// M s² + C s + K.
pub(crate) struct Pencil {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
}

/// Part of the largest mass below which one counts as none.
const NO_MASS: f64 = 1e-13;
/// Part of the largest damping below which one counts as none.
const NO_DAMPING: f64 = 1e-13;
/// Part of the stiffness and the damping up to which a motion counts as one that nothing acts on.
const RIGID: f64 = 1e-12;

impl Pencil {
    /// The matrices of the equations `at` an equilibrium along the free motions.
    pub(crate) fn of(at: &ForcesAt, reduced: &Reduced) -> Self {
        Self {
            mass: reduced.project(&at.mass),
            damping: reduced.project(&at.damping),
            stiffness: reduced.project(&at.stiffness),
        }
    }

    /// Eigenvalues with Im s ≥ 0, ascending by size, and the number of directions without mass.
    pub(crate) fn finite_eigenvalues(&self) -> (Vec<Complex<f64>>, usize) {
        let n = self.mass.nrows();
        if n == 0 {
            return (Vec::new(), 0);
        }
        let undamped =
            self.damping.norm() <= 1e-14 * (self.mass.norm() * self.stiffness.norm()).sqrt();
        let asymmetry = (&self.stiffness - self.stiffness.transpose()).norm();
        let masses = (&self.mass + self.mass.transpose()) * 0.5;
        let eigen = masses.symmetric_eigen();
        let largest = eigen.eigenvalues.iter().fold(0.0, |a: f64, b| a.max(*b));
        let (heavy, light): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&k| eigen.eigenvalues[k] > NO_MASS * largest);
        // Coordinates in which M is one on `heavy` directions and zero on the others.
        let basis = |which: &[usize], unit: bool| {
            DMatrix::from_fn(n, which.len(), |i, k| {
                let mass = eigen.eigenvalues[which[k]];
                eigen.eigenvectors[(i, which[k])] / if unit { mass.sqrt() } else { 1.0 }
            })
        };
        let (h, l) = (basis(&heavy, true), basis(&light, false));

        // Of the light directions some are damped.
        let (damped, directions) = symmetric(&(l.transpose() * &self.damping * &l));
        let most = self.damping.norm();
        let (slow, idle): (Vec<usize>, Vec<usize>) =
            (0..light.len()).partition(|&k| most > 0.0 && damped[k].abs() > NO_DAMPING * most);
        let pick = |which: &[usize]| {
            DMatrix::from_fn(light.len(), which.len(), |i, k| directions[(i, which[k])])
        };
        let (l1, l2) = (&l * pick(&slow), &l * pick(&idle));

        // Idle directions follow the others: y₂ = −K₂₂⁻¹ K₂ y.
        let k22 = l2.transpose() * &self.stiffness * &l2;
        let follow = |x: &DMatrix<f64>| {
            let pulled = l2.transpose() * &self.stiffness * x;
            x - &l2 * (pseudo_inverse(&k22) * pulled)
        };
        let (h, l1) = (follow(&h), follow(&l1));
        let (nh, n1) = (h.ncols(), l1.ncols());
        let on = |x: &DMatrix<f64>, a: &DMatrix<f64>, y: &DMatrix<f64>| x.transpose() * a * y;
        let k_hh = on(&h, &self.stiffness, &h);
        let mut values: Vec<Complex<f64>> = if undamped
            && n1 == 0
            && asymmetry <= 1e-11 * self.stiffness.norm()
        {
            // ω² are the eigenvalues of a symmetric matrix.
            let (squares, _) = symmetric(&k_hh);
            let size = squares.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            let of = |square: f64| {
                if square.abs() <= 1e-13 * size {
                    vec![Complex::new(0.0, 0.0)]
                } else if square > 0.0 {
                    vec![Complex::new(0.0, square.sqrt())]
                } else {
                    let rate = (-square).sqrt();
                    vec![Complex::new(rate, 0.0), Complex::new(-rate, 0.0)]
                }
            };
            squares.iter().flat_map(|&square| of(square)).collect()
        } else if let Some((n_rigid, rest)) =
            self.without_rigid(undamped).filter(|_| light.is_empty())
        {
            // Motions that nothing acts on: zero stands once for each, and is double in the others' matrix.
            let (others, _) = rest.finite_eigenvalues();
            std::iter::repeat_n(Complex::new(0.0, 0.0), n_rigid).chain(others).collect()
        } else {
            // x = (y_h, ẏ_h, y_1).
            let size = 2 * nh + n1;
            let mut a = DMatrix::zeros(size, size);
            a.view_mut((0, nh), (nh, nh)).fill_with_identity();
            let c11 = pseudo_inverse(&on(&l1, &self.damping, &l1));
            // ẏ_1 = −C₁₁⁻¹ (K_1h y_h + C_1h ẏ_h + K_11 y_1).
            let rate = [
                -(&c11 * on(&l1, &self.stiffness, &h)),
                -(&c11 * on(&l1, &self.damping, &h)),
                -(&c11 * on(&l1, &self.stiffness, &l1)),
            ];
            let c_h1 = on(&h, &self.damping, &l1);
            let own = [-k_hh, -on(&h, &self.damping, &h), -on(&h, &self.stiffness, &l1)];
            let columns = [0, nh, 2 * nh];
            for ((own, rate), &column) in own.iter().zip(&rate).zip(&columns) {
                let width = own.ncols();
                a.view_mut((nh, column), (nh, width)).copy_from(&(own - &c_h1 * rate));
                a.view_mut((2 * nh, column), (n1, width)).copy_from(rate);
            }
            eigenvalues(&a).into_iter().map(|s| self.polished(s)).filter(|s| s.im >= 0.0).collect()
        };
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(a.re.total_cmp(&b.re)));
        (values, light.len())
    }

    /// The number of motions that neither stiffness nor damping acts on, and the pencil of those across them; `None`
    /// where there are none of one kind.
    fn without_rigid(&self, is_undamped: bool) -> Option<(usize, Self)> {
        let n = self.mass.nrows();
        let [k, c] = [&self.stiffness, &self.damping];
        let both = [k.clone(), k.transpose(), c.clone(), c.transpose()];
        let mut all = DMatrix::zeros(4 * n, n);
        for (place, matrix) in both.iter().enumerate().take(if is_undamped { 2 } else { 4 }) {
            if matrix.norm() > 0.0 {
                all.rows_mut(place * n, n).copy_from(&(matrix / matrix.norm()));
            }
        }
        let svd = Svd::new(&all)?;
        let is_rigid = |k: &usize| svd.singular_values[*k] <= RIGID;
        let (rigid, others): (Vec<usize>, Vec<usize>) = (0..n).partition(is_rigid);
        if rigid.is_empty() || others.is_empty() {
            return None;
        }
        // M-orthogonal to the rigid ones: y − R (Rᵀ M R)⁻¹ Rᵀ M y.
        let pick =
            |which: &[usize]| DMatrix::from_fn(n, which.len(), |i, j| svd.v_t[(which[j], i)]);
        let (r, y) = (pick(&rigid), pick(&others));
        let own = (r.transpose() * &self.mass * &r).try_inverse()?;
        let across = &y - &r * (own * (r.transpose() * &self.mass * &y));
        let on = |a: &DMatrix<f64>| across.transpose() * a * &across;
        let rest = Self { mass: on(&self.mass), damping: on(c), stiffness: on(k) };
        Some((rigid.len(), rest))
    }

    fn at(&self, s: Complex<f64>) -> DMatrix<Complex<f64>> {
        let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
        complex(&self.mass) * (s * s) + complex(&self.damping) * s + complex(&self.stiffness)
    }

    /// An eigenvalue after Newton's steps on uᴴ P(s) x = 0, with the singular vectors of P.
    fn polished(&self, s: Complex<f64>) -> Complex<f64> {
        let is_real = s.im == 0.0;
        let mut best = s;
        for _ in 0..3 {
            let Some(svd) = Svd::new(&self.at(best)) else { return best };
            let last = svd.last();
            let (left, x) = (svd.u.column(last).adjoint(), svd.v_t.row(last).adjoint());
            let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
            let slope = complex(&self.mass) * (best * 2.0) + complex(&self.damping);
            let value = (&left * self.at(best) * &x)[(0, 0)];
            let slope = (&left * slope * &x)[(0, 0)];
            let step = value / slope;
            if !(step.re.is_finite() && step.im.is_finite()) || step.norm() > 1e-4 * best.norm() {
                return best;
            }
            best -= step;
            if is_real {
                best.im = 0.0;
            }
        }
        best
    }

    /// An eigenvector for each eigenvalue; for equal ones, different ones.
    pub(crate) fn vectors(&self, values: &[Complex<f64>]) -> Vec<DVector<Complex<f64>>> {
        let mut met: Vec<Complex<f64>> = Vec::new();
        let vector = |&s: &Complex<f64>| {
            let same = met.iter().filter(|&&other| (other - s).norm() <= 1e-9 * s.norm()).count();
            met.push(s);
            let Some(svd) = Svd::new(&self.at(s)) else {
                return DVector::zeros(self.mass.nrows());
            };
            svd.v_t.row(svd.last().saturating_sub(same)).adjoint()
        };
        values.iter().map(vector).collect()
    }
}

/// Eigenvalues and vectors of the symmetric part of a matrix, which may be empty.
fn symmetric(matrix: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    if matrix.is_empty() {
        return (DVector::zeros(0), DMatrix::zeros(0, 0));
    }
    let eigen = ((matrix + matrix.transpose()) * 0.5).symmetric_eigen();
    (eigen.eigenvalues, eigen.eigenvectors)
}
