//! [`Wrenches`]: forces and moments on bodies, with the points at which they act, along a run.

use bksim_expr::{Expr, TapeError};
use bksim_mbs::acting::of_contact;
use bksim_mbs::force::Wrench;
use bksim_model::ContactId;

use crate::Mechanism;
use crate::run::Sample;
use crate::values::{Values, modes_of};

/// A wrench as numbers, in world axes.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct WrenchAt {
    /// N.
    pub force: [f64; 3],
    /// The point at which the force acts, m.
    pub point: [f64; 3],
    /// N m, in addition to the moment of the force.
    pub moment: [f64; 3],
}

impl WrenchAt {
    /// The wrenches together, in the mean of their points by the sizes of the first `n` forces: of a contact those that press,
    /// for friction may be stated at any point of the line along which it acts.
    pub fn sum(wrenches: &[Self], n: usize) -> Self {
        let size = |w: &Self| w.force[0].hypot(w.force[1]).hypot(w.force[2]);
        let total: f64 = wrenches.iter().take(n).map(size).sum();
        let first = wrenches.first().copied().unwrap_or_default();
        let mut sum = Self { point: first.point, ..Self::default() };
        if total > 0.0 {
            let part = |i: usize| wrenches.iter().take(n).map(move |w| size(w) * w.point[i]);
            sum.point = std::array::from_fn(|i| part(i).sum::<f64>() / total);
        }
        for w in wrenches {
            let moment = w.moment_about(sum.point);
            for i in 0..3 {
                sum.force[i] += w.force[i];
                sum.moment[i] += moment[i];
            }
        }
        sum
    }

    /// Force, N, and moment, N m, as reactions of samples have them.
    pub fn six(&self) -> [f64; 6] {
        let ([fx, fy, fz], [mx, my, mz]) = (self.force, self.moment);
        [fx, fy, fz, mx, my, mz]
    }

    /// The moment about a point, N m.
    pub fn moment_about(&self, point: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = std::array::from_fn(|i| self.point[i] - point[i]);
        let ([fx, fy, fz], [mx, my, mz]) = (self.force, self.moment);
        [mx + y * fz - z * fy, my + z * fx - x * fz, mz + x * fy - y * fx]
    }
}

/// Numbers of a wrench: force, point, moment.
const NUMBERS: usize = 9;

/// Wrenches as functions of the samples of a run, with their buffers.
#[derive(Clone, Debug)]
pub struct Wrenches {
    values: Values,
}

impl Wrenches {
    /// Compiles wrenches of t, q, v, accelerations and multipliers.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is none of these.
    pub fn compile(mechanism: &Mechanism, wrenches: &[Wrench]) -> Result<Self, TapeError> {
        let Mechanism { model, system, compiled, parameters, .. } = mechanism;
        let outputs: Vec<Expr> =
            wrenches.iter().flat_map(|w| [w.force, w.at, w.moment]).flatten().collect();
        let modes = modes_of(model, system);
        let values = Values::compile(model, system, compiled, parameters, (&outputs, &modes))?;
        Ok(Self { values })
    }

    /// The wrenches at a sample with the modes that hold there, in the order of [`Wrenches::compile`].
    ///
    /// # Panics
    /// If the sample or the modes are those of another mechanism.
    pub fn at(&mut self, sample: &Sample, modes: &[f64]) -> Vec<WrenchAt> {
        let Sample { t, q, v, a, lambda, .. } = sample;
        let numbers = self.values.at((*t, q, v), a, lambda, modes);
        let three = |of: &[f64], first: usize| std::array::from_fn(|i| of[first + i]);
        let wrench = |of: &[f64]| WrenchAt {
            force: three(of, 0),
            point: three(of, 3),
            moment: three(of, 6),
        };
        numbers.chunks_exact(NUMBERS).map(wrench).collect()
    }
}

/// The forces of the contacts of a model on their second bodies.
#[derive(Clone, Debug)]
pub struct ContactForces {
    wrenches: Wrenches,
    /// By contact, counts of the wrenches that press and that rub.
    counts: Vec<[usize; 2]>,
}

impl ContactForces {
    /// Compiles the forces of all contacts; `None` of a model without contacts.
    ///
    /// # Errors
    /// [`TapeError`] as of [`Wrenches::compile`].
    pub fn compile(mechanism: &Mechanism) -> Result<Option<Self>, TapeError> {
        let model = &mechanism.model;
        if model.contacts.is_empty() {
            return Ok(None);
        }
        let contacts = (0..model.contacts.len()).map(ContactId);
        let found: Vec<[Vec<Wrench>; 2]> =
            contacts.map(|contact| of_contact(model, &mechanism.system, contact)).collect();
        let counts = found.iter().map(|of| of.each_ref().map(Vec::len)).collect();
        let wrenches = Wrenches::compile(mechanism, &found.concat().concat())?;
        Ok(Some(Self { wrenches, counts }))
    }

    /// The forces at a sample with the modes that hold there, in the order of the contacts; without one, zero.
    ///
    /// # Panics
    /// If the sample or the modes are those of another mechanism.
    pub fn at(&mut self, sample: &Sample, modes: &[f64]) -> Vec<WrenchAt> {
        let all = self.wrenches.at(sample, modes);
        let mut rest = &all[..];
        let of_contact = |&[n_press, n_rub]: &[usize; 2]| {
            let (own, others) = rest.split_at(n_press + n_rub);
            rest = others;
            WrenchAt::sum(own, n_press)
        };
        self.counts.iter().map(of_contact).collect()
    }
}
