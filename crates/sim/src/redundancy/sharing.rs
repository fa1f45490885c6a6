//! How joints that repeat each other share a load where some of them yield: least energy of their springs.
//!
//! ```text
//! R = R₀ + N s,    ½ Σ (uᵢ · R)²/kᵢ least over s        springs along the unit wrenches uᵢ
//! W s = −b         by least squares, of smallest norm    W = uᵢ · N/√kᵢ,  b = uᵢ · R₀/√kᵢ
//! ```
//!
//! That is the limit of springs κ kᵢ for κ → ∞, whose deflections vanish but whose shares do not. What no spring takes part
//! in, the null space of W, stays open. A joint without a spring is rigid.
//!
//! Source: L. F. Menabrea's theorem of least work, e.g. S. P. Timoshenko, *Strength of Materials* (1955), part I, §72.

use bksim_model::{Compliance, Frame, JointId};
use nalgebra::{DMatrix, DVector};

use super::SelfStress;
use crate::linear::svd::Svd;

/// Parts of a self-stress below this are rounding, relative to its largest one.
const PART: f64 = 1e-6;
/// Self-stresses that bend springs by less than this, relative to the one that bends them most, are open.
const OPEN: f64 = 1e-9;

/// A spring in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spring {
    pub(super) joint: JointId,
    /// Force or moment of size one, world axes.
    wrench: [f64; 6],
    /// 1/√k.
    weight: f64,
}

impl Spring {
    /// The springs of a compliance in a joint whose frame has these axes.
    pub(super) fn of(compliance: &Compliance, axes: &[[f64; 3]; 3]) -> Vec<Self> {
        let Compliance { joint, along, is_moment, stiffness } = *compliance;
        let unit = |k: usize| std::array::from_fn(|i| f64::from(u8::from(i == k)));
        let directions: Vec<[f64; 3]> = match along {
            None => (0..3).map(unit).collect(),
            Some((Frame::World, k)) => vec![unit(k % 3)],
            Some((Frame::Body, k)) => vec![axes[k % 3]],
        };
        let spring = |[x, y, z]: [f64; 3]| Self {
            joint,
            wrench: if is_moment { [0.0, 0.0, 0.0, x, y, z] } else { [x, y, z, 0.0, 0.0, 0.0] },
            weight: 1.0 / stiffness.sqrt(),
        };
        directions.into_iter().map(spring).collect()
    }

    /// The part of a reaction that bends it.
    fn part(&self, reaction: &[f64; 6]) -> f64 {
        self.weight * self.wrench.iter().zip(reaction).map(|(u, r)| u * r).sum::<f64>()
    }
}

/// W: a row for each spring, and as many as there are self-stresses at least.
fn bending(springs: &[Spring], stresses: &[SelfStress]) -> DMatrix<f64> {
    let n_rows = springs.len().max(stresses.len());
    let mut matrix = DMatrix::zeros(n_rows, stresses.len());
    for (k, stress) in stresses.iter().enumerate() {
        for (i, spring) in springs.iter().enumerate() {
            let own = stress.reactions.iter().find(|(joint, _)| *joint == spring.joint);
            matrix[(i, k)] = own.map_or(0.0, |(_, six)| spring.part(six));
        }
    }
    matrix
}

/// The factors of the self-stresses with which the springs of these reactions, by joint, have least energy.
pub(super) fn shares(
    springs: &[Spring],
    stresses: &[SelfStress],
    reactions: &[[f64; 6]],
) -> Option<Vec<f64>> {
    let matrix = bending(springs, stresses);
    let mut right = DVector::zeros(matrix.nrows());
    for (i, spring) in springs.iter().enumerate() {
        right[i] = -spring.part(reactions.get(spring.joint.0)?);
    }
    let svd = Svd::new(&matrix)?;
    let factors = svd.solve(&right, OPEN * svd.largest());
    factors.iter().all(|s| s.is_finite()).then(|| factors.as_slice().to_vec())
}

/// The self-stresses that bend no spring.
pub(super) fn open(springs: &[Spring], stresses: Vec<SelfStress>) -> Vec<SelfStress> {
    if springs.is_empty() || stresses.is_empty() {
        return stresses;
    }
    let Some(svd) = Svd::new(&bending(springs, &stresses)) else { return stresses };
    let floor = OPEN * svd.largest();
    let open = (0..stresses.len()).filter(|&k| svd.singular_values[k] <= floor);
    open.map(|k| combined(&stresses, svd.v_t.row(k).iter().copied())).collect()
}

/// A combination of self-stresses, its largest component one.
fn combined(stresses: &[SelfStress], factors: impl Iterator<Item = f64>) -> SelfStress {
    let mut sum = SelfStress::default();
    for (stress, factor) in stresses.iter().zip(factors) {
        sum.add(stress, factor);
    }
    let parts = sum.reactions.iter().flat_map(|(_, six)| six);
    let parts = parts.copied().chain(sum.efforts.iter().map(|(_, part)| *part));
    let largest = parts.fold(0.0, |most: f64, part| most.max(part.abs()));
    let cleaned = |part: f64| if part.abs() > PART * largest { part / largest } else { 0.0 };
    sum.reactions.iter_mut().for_each(|(_, six)| *six = six.map(cleaned));
    sum.efforts.iter_mut().for_each(|(_, part)| *part = cleaned(*part));
    sum.reactions.retain(|(_, six)| *six != [0.0; 6]);
    sum.efforts.retain(|(_, part)| *part != 0.0);
    sum
}

impl SelfStress {
    /// Adds another one times a factor.
    pub(crate) fn add(&mut self, other: &Self, factor: f64) {
        for (joint, six) in &other.reactions {
            let scaled = six.map(|part| factor * part);
            match self.reactions.iter_mut().find(|(own, _)| own == joint) {
                Some((_, own)) => own.iter_mut().zip(scaled).for_each(|(own, part)| *own += part),
                None => self.reactions.push((*joint, scaled)),
            }
        }
        for &(effort, part) in &other.efforts {
            match self.efforts.iter_mut().find(|(own, _)| *own == effort) {
                Some((_, own)) => *own += factor * part,
                None => self.efforts.push((effort, factor * part)),
            }
        }
    }
}
