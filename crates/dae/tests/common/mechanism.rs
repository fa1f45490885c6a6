//! Mechanisms in their formulations, as residuals.

use bksim_dae::Index::{One, Three, Two};
use bksim_dae::{Layout, Start};

use super::Residual;
use super::dual::Real;

/// `M(q) v′ = f(t, q, v) − Gᵀλ`, `g(t, q) = 0`; matrices by rows.
pub struct Terms<T> {
    pub mass: Vec<T>,
    pub force: Vec<T>,
    pub constraint: Vec<T>,
    /// `G = ∂g/∂q`, `nc × nq`.
    pub jacobian: Vec<T>,
    /// `∂g/∂t`.
    pub constraint_rate: Vec<T>,
}

pub trait Mechanism {
    fn nq(&self) -> usize;
    fn nc(&self) -> usize;
    fn terms<T: Real>(&self, t: f64, q: &[T], v: &[T]) -> Terms<T>;

    /// `d/dt(G v + ∂g/∂t) − G v′`, where a test needs it.
    fn acceleration_bias<T: Real>(&self, _t: f64, _q: &[T], _v: &[T]) -> Vec<T> {
        panic!("no test poses this mechanism at acceleration level")
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// Constraints on positions.
    Index3,
    /// Constraints on velocities.
    Index2,
    /// Both, with `q′ = v − Gᵀμ` (Gear, Gupta, Leimkuhler 1985; HW2 §VII.1).
    Ggl,
    /// Constraints on accelerations.
    Index1,
}

pub struct Formulated<M> {
    pub mechanism: M,
    pub form: Form,
}

impl<M: Mechanism> Formulated<M> {
    /// Start from positions, velocities, accelerations and multipliers.
    pub fn start(&self, [q, v, a, lambda]: [Vec<f64>; 4]) -> Start {
        let (n, nq) = (self.layout().n(), q.len());
        let mut y = [q, v.clone(), lambda].concat();
        let mut ydot = [v, a].concat();
        assert!(2 * nq <= n);
        y.resize(n, 0.0);
        ydot.resize(n, 0.0);
        Start { t: 0.0, y, ydot }
    }

    /// The parts `q`, `v`, `λ` of a state.
    pub fn split<'a>(&self, y: &'a [f64]) -> [&'a [f64]; 3] {
        let (nq, nc) = (self.mechanism.nq(), self.mechanism.nc());
        [&y[..nq], &y[nq..2 * nq], &y[2 * nq..2 * nq + nc]]
    }
}

impl<M: Mechanism> Residual for Formulated<M> {
    fn layout(&self) -> Layout {
        let (nq, nc) = (self.mechanism.nq(), self.mechanism.nc());
        match self.form {
            Form::Index3 => Layout::from_groups(&[(nq, One), (nq, Two), (nc, Three)]),
            Form::Index2 => Layout::from_groups(&[(2 * nq, One), (nc, Two)]),
            Form::Ggl => Layout::from_groups(&[(2 * nq, One), (2 * nc, Two)]),
            Form::Index1 => Layout::from_groups(&[(2 * nq + nc, One)]),
        }
    }

    fn explicit_rows(&self) -> Vec<(usize, usize)> {
        let nq = self.mechanism.nq();
        (0..nq).map(|i| (i, nq + i)).collect()
    }

    fn residual<T: Real>(&self, t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        let (nq, nc) = (self.mechanism.nq(), self.mechanism.nc());
        let (q, v, lambda) = (&y[..nq], &y[nq..2 * nq], &y[2 * nq..2 * nq + nc]);
        let (qdot, vdot) = (&ydot[..nq], &ydot[nq..2 * nq]);
        let terms = self.mechanism.terms(t, q, v);
        let transposed = |i: usize, x: &[T]| {
            (0..nc).fold(T::from(0.0), |sum, k| sum + terms.jacobian[k * nq + i] * x[k])
        };
        let along = |k: usize, x: &[T]| {
            (0..nq).fold(T::from(0.0), |sum, i| sum + terms.jacobian[k * nq + i] * x[i])
        };

        let mut out: Vec<T> = (0..nq)
            .map(|i| {
                let kinematic = qdot[i] - v[i];
                if self.form == Form::Ggl {
                    kinematic + transposed(i, &y[2 * nq + nc..])
                } else {
                    kinematic
                }
            })
            .collect();
        out.extend((0..nq).map(|i| {
            let inertia =
                (0..nq).fold(T::from(0.0), |sum, j| sum + terms.mass[i * nq + j] * vdot[j]);
            inertia - terms.force[i] + transposed(i, lambda)
        }));
        let velocity = (0..nc).map(|k| along(k, v) + terms.constraint_rate[k]);
        match self.form {
            Form::Index3 => out.extend(&terms.constraint),
            Form::Index2 => out.extend(velocity),
            Form::Ggl => {
                out.extend(velocity);
                out.extend(&terms.constraint);
            }
            Form::Index1 => {
                let bias = self.mechanism.acceleration_bias(t, q, v);
                out.extend((0..nc).map(|k| along(k, vdot) + bias[k]));
            }
        }
        out
    }
}
