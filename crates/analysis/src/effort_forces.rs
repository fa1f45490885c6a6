//! Efforts at one instant of a motion, with the friction that grows with the reactions.
//!
//! ```text
//! λ = E(r(λ))        E: the efforts under loads that are known
//! ```
//!
//! Newton's method finds them, from those without the friction, as in a run.

use nalgebra::{DMatrix, DVector};

use crate::actuation::{EffortEquations, Efforts};
use crate::effort_contacts::{EffortContacts, Touch};
use crate::forces::{At, Forces, ForcesAt};

/// Newton steps that may be needed, as in a run.
const MAX_STEPS: usize = 40;
/// Multipliers found to this part of their size are found.
const FOUND: f64 = 4.0 * f64::EPSILON;
/// Multipliers that no longer get nearer are found too, if they are as near as this.
const NEAR: f64 = 1e-9;
/// Change of a multiplier for its slope, as a part of the largest one: laws of friction are straight but for their kinks.
const CHANGE: f64 = 1e-6;

/// The equations of one instant of a motion.
pub(crate) struct EffortInstant<'a> {
    pub(crate) t: f64,
    /// q, v and a.
    pub(crate) state: [&'a [f64]; 3],
    pub(crate) forces: &'a mut Forces,
    pub(crate) contacts: &'a mut EffortContacts,
    /// State of each contact.
    pub(crate) touches: &'a [Touch],
    pub(crate) equations: &'a EffortEquations,
    /// Coordinates that move.
    pub(crate) n_moving: usize,
}

/// Efforts with what they were found under.
#[derive(Clone, Debug)]
pub(crate) struct FoundEfforts {
    pub(crate) efforts: Efforts,
    /// Bounds of the forces of the contacts that touch.
    pub(crate) bounds: Vec<[f64; 2]>,
    /// Friction that slides with a force below zero.
    pub(crate) driving: Option<usize>,
    /// Largest of the terms along the free motions, in units of the motions.
    pub(crate) size: f64,
}

/// Efforts that are asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wanted<'a> {
    /// The smallest ones.
    Smallest,
    /// Nearest to these efforts of the actuators, with these forces of the contacts.
    Near(&'a DVector<f64>, &'a DVector<f64>),
}

impl EffortInstant<'_> {
    /// The efforts, or `None` where friction grows faster with the reactions than they with it.
    pub(crate) fn efforts(&mut self, wanted: Wanted<'_>) -> Option<FoundEfforts> {
        let rows = self.contacts.pressing.clone();
        let mut guess = DVector::zeros(rows.len());
        let mut found = self.under(wanted, &rows, &guess)?;
        if rows.is_empty() {
            return Some(found);
        }
        guess = pressing_of(&found.efforts, &rows);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            found = self.under(wanted, &rows, &guess)?;
            let own = pressing_of(&found.efforts, &rows);
            let gap = &own - &guess;
            let size = found.efforts.lambda.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let error = gap.amax();
            if error <= FOUND * size || error >= last && error <= NEAR * size {
                return Some(found);
            }
            last = error;

            // The change of the multipliers by those that they follow from.
            let mut slopes = DMatrix::zeros(rows.len(), rows.len());
            let step = CHANGE * size;
            for k in 0..rows.len() {
                let mut aside = guess.clone();
                aside[k] += step;
                let there = self.under(wanted, &rows, &aside)?;
                slopes.set_column(k, &((pressing_of(&there.efforts, &rows) - &own) / step));
            }
            let change = (DMatrix::identity(rows.len(), rows.len()) - slopes).lu().solve(&gap)?;
            guess += change;
        }
        None
    }

    /// The efforts under the loads that these multipliers of the pressing rows make.
    fn under(
        &mut self,
        wanted: Wanted<'_>,
        rows: &[usize],
        pressing: &DVector<f64>,
    ) -> Option<FoundEfforts> {
        let mut lambda = vec![0.0; self.contacts.n_rows()];
        rows.iter().zip(pressing).for_each(|(&row, value)| lambda[row] = *value);
        let [q, v, a] = self.state;
        let at = self.forces.at(At { t: self.t, q, v, a, lambda: &lambda, p: &[] });
        let (residual, terms) = self.loads_of(&at, &lambda, a);
        let laws = if self.contacts.all.is_empty() {
            Vec::new()
        } else {
            self.contacts.friction(self.t, [q, v], &lambda)
        };
        let each = || self.touches.iter().zip(&laws);
        let bounds: Vec<[f64; 2]> = each()
            .filter_map(|(touch, law)| match touch {
                Touch::Closed => Some([0.0, f64::INFINITY]),
                Touch::Rests(_) => Some(law.resting),
                _ => None,
            })
            .collect();
        let driving =
            each().position(|(touch, law)| matches!(touch, Touch::Slides(_)) && law.sliding < 0.0);
        let size = self.equations.size_along(&terms);
        let efforts = match wanted {
            Wanted::Smallest => self.equations.efforts(&residual, size, &bounds),
            Wanted::Near(tau, c) => self.equations.efforts_near(&residual, size, (tau, c)),
        };
        Some(FoundEfforts { efforts: efforts?, bounds, driving, size })
    }

    /// r without Gᵀ λ, and the size of its terms.
    fn loads_of(&self, at: &ForcesAt, lambda: &[f64], a: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let n = self.n_moving;
        let held = at.wrenches.transpose() * DVector::from_column_slice(lambda);
        let residual = (&at.residual - held).rows(0, n).into_owned();
        let inertia = (&at.mass * DVector::from_column_slice(a)).rows(0, n).into_owned();
        let terms = inertia.abs() + (&residual - inertia).abs();
        (residual, terms)
    }
}

fn pressing_of(efforts: &Efforts, rows: &[usize]) -> DVector<f64> {
    DVector::from_iterator(rows.len(), rows.iter().map(|&row| efforts.lambda[row]))
}
