//! [`Block`]: the wrenches that joints whose loops share joints transmit, and their combinations that vanish.

use bksim_model::{JointId, MotionKind};

use super::conditions::{Condition, Direction, Keeper, RepeatedCondition};
use super::{Effort, SelfStress};
use crate::linear::rank::vanishing_combinations;
use crate::linear::rows::SparseRows;

/// Force and moment; the moment over a length where both are compared.
pub(super) type Wrench = [f64; 6];

/// Parts of a self-stress below this are rounding, relative to its largest one.
const PART: f64 = 1e-6;

/// Joints whose loops share joints, with the efforts in them.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub(super) parts: Vec<JointPart>,
    /// Each with the index of its part and the motion that it acts along.
    pub(super) efforts: Vec<(Effort, usize, usize)>,
    pub(super) couplings: Vec<CouplingPart>,
}

/// The wrenches of a coupling for a unit multiplier.
#[derive(Clone, Debug)]
pub(super) struct CouplingPart {
    pub(super) effort: Effort,
    pub(super) is_moment: bool,
    /// True where it takes part only while its effort acts.
    pub(super) opens: bool,
    /// The bodies, numbered within the block, `None` for the ground; each with the first number of its point,
    /// force and moment among the results of the function.
    pub(super) wrenches: Vec<(Option<usize>, usize)>,
}

/// A joint of a block.
#[derive(Clone, Debug)]
pub(super) struct JointPart {
    pub(super) joint: JointId,
    /// Predecessor and successor, numbered within the block; `None` is the ground.
    pub(super) bodies: [Option<usize>; 2],
    /// The motions that the joint allows; `None` of a link or a contact.
    pub(super) motions: Option<Vec<MotionKind>>,
    /// First number of the part among the results of the function: the joint point, the axes of its frame, then an axis for
    /// each motion and a pitch for each, or the force and the moment of a link or a contact.
    pub(super) first: usize,
}

/// A wrench of a block whose size the equilibrium is to give.
#[derive(Clone, Copy)]
enum Unknown {
    /// Through a joint, on the successor at the joint point, moments over the length.
    Through {
        part_idx: usize,
        /// `None` of the joint's own reaction.
        effort: Option<Effort>,
        wrench: Wrench,
    },
    /// Of the coupling of this index.
    Of(usize),
}

/// The wrenches of a block in one pose, and their combinations that are in equilibrium without any load.
struct Equilibrium {
    unknowns: Vec<Unknown>,
    /// Each with the unknown that follows from those before it last.
    combinations: Vec<Vec<(usize, f64)>>,
    /// The unit of moments, m.
    length: f64,
}

/// Three results of the function, one after the other.
fn triple(values: &[f64], first: usize) -> [f64; 3] {
    [values[first], values[first + 1], values[first + 2]]
}

impl JointPart {
    /// Numbers of results ahead of the joint's directions: its point and the axes of its frame.
    pub(super) const N_AHEAD: usize = 12;

    /// The wrenches that it transmits, moments over `length`: along the axes of its frame where they can be.
    fn wrenches(&self, values: &[f64], axes: &[usize], length: f64) -> Vec<Wrench> {
        let own = self.first + Self::N_AHEAD;
        let Some(motions) = &self.motions else {
            let moment = triple(values, own + 3).map(|part| part / length);
            return vec![unit_wrench(triple(values, own), moment)];
        };
        let pitches = own + 3 * motions.len();
        let free = motions
            .iter()
            .enumerate()
            .map(|(k, &kind)| twist(kind, self.axis(values, k), values[pitches + k] / length));
        let unit = |&axis: &usize| {
            let along = self.frame(values)[axis % 3];
            effort(if axis < 3 { MotionKind::Translation } else { MotionKind::Rotation }, along)
        };
        complement(&free.collect::<Vec<_>>(), &axes.iter().map(unit).collect::<Vec<_>>())
    }

    /// The axis of a motion, world axes.
    fn axis(&self, values: &[f64], motion_idx: usize) -> [f64; 3] {
        triple(values, self.first + Self::N_AHEAD + 3 * motion_idx)
    }

    /// The axes of the joint's frame, world axes.
    pub(super) fn frame(&self, values: &[f64]) -> [[f64; 3]; 3] {
        [3, 6, 9].map(|offset| triple(values, self.first + offset))
    }

    /// The direction of one of its wrenches, in the axes of its frame.
    fn direction(&self, values: &[f64], [fx, fy, fz, mx, my, mz]: &Wrench) -> Direction {
        if self.motions.is_none() {
            return Direction::Alone;
        }
        let frame = self.frame(values);
        let in_joint = |v: [f64; 3]| frame.map(|axis| (0..3).map(|i| axis[i] * v[i]).sum());
        Direction::of(in_joint([*fx, *fy, *fz]), in_joint([*mx, *my, *mz]))
    }
}

impl Block {
    /// A basis of the self-stresses, with the efforts that `acts` says are there.
    pub(super) fn self_stresses(
        &self,
        values: &[f64],
        axes: &[usize],
        acts: &dyn Fn(Effort) -> bool,
    ) -> Vec<SelfStress> {
        let Equilibrium { unknowns, combinations, length } = self.equilibrium(values, axes, acts);
        combinations.iter().map(|of| self.stress(of, &unknowns, length)).collect()
    }

    /// The conditions of joints and couplings that follow from those before them.
    pub(super) fn repeated_conditions(
        &self,
        values: &[f64],
        axes: &[usize],
    ) -> Vec<RepeatedCondition> {
        let Equilibrium { unknowns, combinations, .. } = self.equilibrium(values, axes, &|_| false);
        let condition = |&(unknown_idx, _): &(usize, f64)| match &unknowns[unknown_idx] {
            Unknown::Through { part_idx, wrench, .. } => {
                let part = &self.parts[*part_idx];
                let direction = part.direction(values, wrench);
                Some(Condition { of: Keeper::Joint(part.joint), direction })
            }
            Unknown::Of(coupling_idx) => match self.couplings[*coupling_idx].effort {
                Effort::Coupling(coupling) => {
                    Some(Condition { of: Keeper::Coupling(coupling), direction: Direction::Alone })
                }
                Effort::Drive(_) | Effort::Contact(..) => None,
            },
        };
        let repeated = |combination: &Vec<(usize, f64)>| {
            let largest = combination.iter().fold(0.0, |most: f64, (_, part)| most.max(part.abs()));
            let (last, others) = combination.split_last()?;
            let has_part = |(_, part): &&(usize, f64)| part.abs() > PART * largest;
            let by = others.iter().filter(has_part).filter_map(condition).collect();
            Some(RepeatedCondition { condition: condition(last)?, by })
        };
        combinations.iter().filter_map(repeated).collect()
    }

    fn equilibrium(
        &self,
        values: &[f64],
        axes: &[usize],
        acts: &dyn Fn(Effort) -> bool,
    ) -> Equilibrium {
        let (_, size) = extent(self.parts.iter().map(|part| triple(values, part.first)));
        let length = if size > 0.0 { size } else { 1.0 };
        let unknowns = self.unknowns((values, length), axes, acts);
        let combinations = vanishing_combinations(&self.columns((values, length), &unknowns));
        Equilibrium { unknowns, combinations, length }
    }

    /// The unknowns: reactions, then efforts, then couplings.
    fn unknowns(
        &self,
        (values, length): (&[f64], f64),
        axes: &[usize],
        acts: &dyn Fn(Effort) -> bool,
    ) -> Vec<Unknown> {
        let mut unknowns: Vec<Unknown> = Vec::new();
        for (part_idx, part) in self.parts.iter().enumerate() {
            let unknown = |wrench| Unknown::Through { part_idx, effort: None, wrench };
            unknowns.extend(part.wrenches(values, axes, length).into_iter().map(unknown));
        }
        for &(of, part_idx, motion_idx) in self.efforts.iter().filter(|(of, ..)| acts(*of)) {
            let part = &self.parts[part_idx];
            let Some(motions) = &part.motions else { continue };
            let wrench = effort(motions[motion_idx], part.axis(values, motion_idx));
            unknowns.push(Unknown::Through { part_idx, effort: Some(of), wrench });
        }
        let couplings = self.couplings.iter().enumerate();
        let acting = couplings.filter(|(_, coupling)| !coupling.opens || acts(coupling.effort));
        unknowns.extend(acting.map(|(idx, _)| Unknown::Of(idx)));
        unknowns
    }

    /// The wrenches of the unknowns on the bodies, a row for each: on the successor, and reversed on the
    /// predecessor.
    ///
    /// On each body they are about the middle of its own joints, moments over its own size: about one middle of
    /// all, the joints of one body among many would differ by little, and no row would be far from the others.
    fn columns(&self, (values, length): (&[f64], f64), unknowns: &[Unknown]) -> SparseRows {
        let extents = self.extents(values);
        let on_body = |body: Option<usize>, wrench: Wrench, at: [f64; 3]| {
            let (center, size) = extents[body?];
            let own = if size > PART * length { size } else { length };
            let [fx, fy, fz, moment @ ..] = wrench;
            let [mx, my, mz] = moment.map(|m| m * length / own);
            let arm = std::array::from_fn(|i| (at[i] - center[i]) / own);
            Some((body?, about_center([fx, fy, fz, mx, my, mz], arm)))
        };
        let mut columns = SparseRows::new(6 * extents.len());
        for unknown in unknowns {
            let mut on: Vec<(usize, Wrench)> = Vec::new();
            match *unknown {
                Unknown::Through { part_idx, wrench, .. } => {
                    let part = &self.parts[part_idx];
                    let at = triple(values, part.first);
                    let both = part.bodies.into_iter().zip([-1.0, 1.0]);
                    on.extend(
                        both.filter_map(|(body, sign)| on_body(body, wrench.map(|w| sign * w), at)),
                    );
                }
                Unknown::Of(coupling_idx) => {
                    for &(body, first) in &self.couplings[coupling_idx].wrenches {
                        let [at, force, moment] =
                            [0, 3, 6].map(|offset| triple(values, first + offset));
                        let [[fx, fy, fz], [mx, my, mz]] = [force, moment.map(|m| m / length)];
                        on.extend(on_body(body, [fx, fy, fz, mx, my, mz], at));
                    }
                }
            }
            columns.push(summed(on));
        }
        columns
    }

    /// Of each body the middle of the points at which wrenches act on it, and how far they lie from it.
    fn extents(&self, values: &[f64]) -> Vec<([f64; 3], f64)> {
        let of_part = |part: &JointPart| part.bodies.map(|body| (body, part.first));
        let joints = self.parts.iter().flat_map(of_part);
        let couplings =
            self.couplings.iter().flat_map(|coupling| coupling.wrenches.iter().copied());
        let mut points: Vec<Vec<[f64; 3]>> = Vec::new();
        for (body, first) in joints.chain(couplings) {
            let Some(body) = body else { continue };
            if points.len() <= body {
                points.resize(body + 1, Vec::new());
            }
            points[body].push(triple(values, first));
        }
        points.iter().map(|points| extent(points.iter().copied())).collect()
    }

    /// The reactions and efforts of a combination of the unknowns.
    fn stress(
        &self,
        combination: &[(usize, f64)],
        unknowns: &[Unknown],
        length: f64,
    ) -> SelfStress {
        let mut sums = vec![[0.0; 6]; self.parts.len()];
        let mut efforts: Vec<(Effort, f64, f64)> = Vec::new();
        for &(unknown_idx, factor) in combination {
            let (part_idx, effort, wrench) = match unknowns[unknown_idx] {
                Unknown::Through { part_idx, effort, wrench } => (part_idx, effort, wrench),
                Unknown::Of(coupling_idx) => {
                    let CouplingPart { effort, is_moment, .. } = self.couplings[coupling_idx];
                    efforts.push((effort, factor, if is_moment { length } else { 1.0 }));
                    continue;
                }
            };
            match effort {
                None => {
                    sums[part_idx].iter_mut().zip(wrench).for_each(|(sum, w)| *sum += factor * w);
                }
                Some(of) => {
                    let is_moment = wrench[..3].iter().all(|&f| f == 0.0);
                    efforts.push((of, factor, if is_moment { length } else { 1.0 }));
                }
            }
        }
        let parts = sums.as_flattened().iter().copied().chain(efforts.iter().map(|e| e.1));
        let largest = parts.fold(0.0, |largest: f64, part| largest.max(part.abs()));
        let cleaned = |part: f64, unit: f64| {
            let relative = part / largest;
            if relative.abs() > PART { relative * unit } else { 0.0 }
        };
        let reactions = self.parts.iter().zip(sums).map(|(part, sum)| {
            let unit = |i: usize| if i < 3 { 1.0 } else { length };
            (part.joint, std::array::from_fn(|i| cleaned(sum[i], unit(i))))
        });
        let reactions = reactions.filter(|(_, six)| *six != [0.0; 6]).collect();
        let efforts = efforts.into_iter().map(|(of, part, unit)| (of, cleaned(part, unit)));
        SelfStress { reactions, efforts: efforts.filter(|(_, part)| *part != 0.0).collect() }
    }
}

/// Wrenches on bodies as the entries of a column: one for each component of a body that is not zero.
fn summed(on: Vec<(usize, Wrench)>) -> impl Iterator<Item = (usize, f64)> {
    let mut sums: Vec<(usize, Wrench)> = Vec::with_capacity(on.len());
    for (body, wrench) in on {
        match sums.iter_mut().find(|(known, _)| *known == body) {
            Some((_, sum)) => sum.iter_mut().zip(wrench).for_each(|(sum, part)| *sum += part),
            None => sums.push((body, wrench)),
        }
    }
    sums.sort_unstable_by_key(|(body, _)| *body);
    let entries = |(body, wrench): (usize, Wrench)| (0..6).map(move |i| (6 * body + i, wrench[i]));
    sums.into_iter().flat_map(entries).filter(|(_, part)| *part != 0.0)
}

/// The middle of some points, and how far the farthest of them lies from it.
fn extent(points: impl Iterator<Item = [f64; 3]> + Clone) -> ([f64; 3], f64) {
    let (mut sum, mut n) = ([0.0; 3], 0.0);
    for point in points.clone() {
        sum = std::array::from_fn(|i| sum[i] + point[i]);
        n += 1.0;
    }
    let center = sum.map(|part| part / f64::max(n, 1.0));
    let far = |p: [f64; 3]| (0..3).map(|i| (p[i] - center[i]).powi(2)).sum::<f64>().sqrt();
    (center, points.map(far).fold(0.0, f64::max))
}

fn effort(kind: MotionKind, axis: [f64; 3]) -> Wrench {
    let [x, y, z] = axis;
    match kind {
        MotionKind::Translation => [x, y, z, 0.0, 0.0, 0.0],
        MotionKind::Rotation => [0.0, 0.0, 0.0, x, y, z],
    }
}

/// The motion along or about an axis, a turn with the slide `pitch` that goes with it: translation and
/// rotation in the order of force and moment.
fn twist(kind: MotionKind, axis: [f64; 3], pitch: f64) -> Wrench {
    let mut twist = effort(kind, axis);
    if kind == MotionKind::Rotation {
        twist[..3].iter_mut().zip(axis).for_each(|(part, a)| *part = pitch * a);
    }
    twist
}

/// The wrench with a force of the size one.
fn unit_wrench(force: [f64; 3], moment: [f64; 3]) -> Wrench {
    let norm = force.iter().map(|part| part * part).sum::<f64>().sqrt();
    let [[fx, fy, fz], [mx, my, mz]] = [force, moment].map(|v| v.map(|part| part / norm));
    [fx, fy, fz, mx, my, mz]
}

/// (F, M + arm × F).
fn about_center([fx, fy, fz, mx, my, mz]: Wrench, [x, y, z]: [f64; 3]) -> Wrench {
    [fx, fy, fz, mx + y * fz - z * fy, my + z * fx - x * fz, mz + x * fy - y * fx]
}

/// Orthonormal wrenches, combinations of the orthonormal `units`, that do no work on the motions `free`: the units themselves
/// where they can be.
fn complement(free: &[Wrench], units: &[Wrench]) -> Vec<Wrench> {
    let dot = |a: &Wrench, b: &Wrench| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let freed = |mut rest: Wrench, basis: &[Wrench]| {
        for direction in basis.iter().chain(basis) {
            let along = dot(direction, &rest);
            rest.iter_mut().zip(direction).for_each(|(part, d)| *part -= along * d);
        }
        rest
    };
    let normed = |w: &Wrench| {
        let norm = dot(w, w).sqrt();
        w.map(|part| part / norm)
    };
    // Motions that repeat others, as those of a cylinder do, free nothing more.
    let mut basis: Vec<Wrench> = Vec::new();
    for motion in free {
        let rest = freed(*motion, &basis);
        if dot(&rest, &rest) > PART * PART * dot(motion, motion) {
            basis.push(normed(&rest));
        }
    }
    let n_free = basis.len();
    // Of the axes, always the one of which the most is left.
    while basis.len() < units.len() {
        let rests = units.iter().map(|unit| freed(*unit, &basis));
        let largest =
            rests.reduce(
                |best, rest| {
                    if dot(&rest, &rest) > dot(&best, &best) + PART { rest } else { best }
                },
            );
        let Some(largest) = largest else { break };
        basis.push(normed(&largest));
    }
    basis.split_off(n_free)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::rank::tests::weakest_rest;

    /// `n` square windows in a plane, `n + 1` uprights on the ground and `n` beams on top, and the numbers of their
    /// pins.
    fn windows(n: usize) -> (Block, Vec<f64>) {
        let (mut block, mut values) = (Block::default(), Vec::new());
        let mut pin = |bodies: [Option<usize>; 2], at: [f64; 2]| {
            let motions = Some(vec![MotionKind::Rotation]);
            let first = values.len();
            let joint = JointId(block.parts.len());
            block.parts.push(JointPart { joint, bodies, motions, first });
            values.extend([at[0], at[1], 0.0]);
            values.extend([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
            values.extend([0.0, 0.0, 1.0, 0.0]);
        };
        for i in 0..=n {
            pin([None, Some(i)], [i as f64, 0.0]);
        }
        for i in 0..n {
            let beam = Some(n + 1 + i);
            pin([Some(i), beam], [i as f64, 1.0]);
            pin([beam, Some(i + 1)], [i as f64 + 1.0, 1.0]);
        }
        (block, values)
    }

    #[test]
    fn pins_of_a_row_of_windows_are_as_far_from_each_other_however_long_it_is() {
        const PLANE: [usize; 3] = [0, 1, 5];
        let rest = |n: usize| {
            let (block, values) = windows(n);
            let at = (&values[..], 0.5 * n as f64);
            let unknowns = block.unknowns(at, &PLANE, &|_| false);
            assert_eq!(unknowns.len(), 2 * (3 * n + 1));
            weakest_rest(&block.columns(at, &unknowns))
        };
        let [short, long] = [rest(10), rest(400)];
        assert!(long > 0.9 * short && short > 0.05, "{short:e}, then {long:e}");
    }
}
