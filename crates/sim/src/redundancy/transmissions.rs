//! [`Transmissions`]: the wrenches that the joints of loops transmit, as numbers, and their self-stresses.

use std::collections::BTreeMap;

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::constraint::{Constraint, Source};
use bksim_mbs::system::SymbolicSystem;
use bksim_mbs::transmission::{Directions, transmission};
use bksim_model::{BodyId, DriveId, JointId, LoadKind, Model, MotionKind, Space};

use super::blocks::blocks;
use super::{Effort, SelfStress, Uniqueness};
use crate::function::Function;
use crate::linear::rank::vanishing_combinations;
use crate::linear::rows::SparseRows;

/// Force and moment; the moment over a length where both are compared.
type Wrench = [f64; 6];

/// Parts of a self-stress below this are rounding, relative to its largest one.
const PART: f64 = 1e-6;

/// The joints that may have self-stresses, with their geometry as one function of (t, q).
#[derive(Clone, Debug)]
pub(crate) struct Transmissions {
    /// `None` where no self-stress can be.
    function: Option<Function>,
    blocks: Vec<Block>,
    /// Directions that wrenches have here: fx, fy, mz in a plane.
    axes: &'static [usize],
    /// Joints, couplings, drives and contacts of the mechanism.
    sizes: [usize; 4],
}

/// Joints whose loops share joints, with the efforts in them.
#[derive(Clone, Debug, Default)]
struct Block {
    parts: Vec<JointPart>,
    /// Each with the index of its part and the motion that it acts along.
    efforts: Vec<(Effort, usize, usize)>,
    couplings: Vec<CouplingPart>,
}

/// The wrenches of a coupling for a unit multiplier.
#[derive(Clone, Debug)]
struct CouplingPart {
    effort: Effort,
    is_moment: bool,
    /// The bodies, numbered within the block, `None` for the ground; each with the first number of its point,
    /// force and moment among the results of the function.
    wrenches: Vec<(Option<usize>, usize)>,
}

/// A joint of a block.
#[derive(Clone, Debug)]
struct JointPart {
    joint: JointId,
    /// Predecessor and successor, numbered within the block; `None` is the ground.
    bodies: [Option<usize>; 2],
    /// The motions that the joint allows; `None` of a link or a contact.
    motions: Option<Vec<MotionKind>>,
    /// Its first number among the results of the function: the joint point, then an axis for each
    /// motion and a pitch for each, or the force and the moment of a link or a contact.
    first: usize,
}

impl Transmissions {
    /// Compiles the geometry of the joints that may have self-stresses, as a function of t, q and
    /// `parameters`.
    ///
    /// # Errors
    /// [`TapeError`] when an expression cannot be compiled.
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        q: &[SymbolId],
        parameters: &[SymbolId],
    ) -> Result<Self, TapeError> {
        // A coupling connects the bodies that it acts on, one after the other, in one block.
        let couplings = couplings(system);
        let mut ends: Vec<[usize; 2]> =
            model.joints.iter().map(|j| [j.predecessor.body.0, j.successor.body.0]).collect();
        let mut groups = Vec::new();
        for (_, constraint) in &couplings {
            let first = ends.len();
            let bodies: Vec<usize> = constraint.wrenches.iter().map(|w| w.body.0).collect();
            ends.extend(bodies.windows(2).filter(|w| w[0] != w[1]).map(|w| [w[0], w[1]]));
            groups.push(first..ends.len());
        }
        let mut of_joint = blocks(model.bodies.len(), &ends);
        for group in groups.iter().filter(|group| !group.is_empty()) {
            let one = of_joint[group.start];
            for member in group.clone() {
                let other = of_joint[member];
                of_joint.iter_mut().filter(|block| **block == other).for_each(|block| *block = one);
            }
        }
        let of_coupling: Vec<Option<usize>> =
            groups.iter().map(|group| of_joint.get(group.start).copied()).collect();
        of_joint.truncate(model.joints.len());
        let efforts = efforts(model, system);

        // A block needs a loop, or two efforts in one joint.
        let n_blocks = ends.len();
        let mut n_members = vec![0; n_blocks];
        for &block in &of_joint {
            n_members[block] += 1;
        }
        let mut n_efforts = vec![0; n_blocks];
        for &(_, joint, _) in &efforts {
            n_efforts[of_joint[joint.0]] += 1;
        }
        let is_needed = |block: usize| n_members[block] > 1 || n_efforts[block] > 1;

        // The parts, and what is to be computed for them.
        let mut of_block = vec![Block::default(); n_blocks];
        let mut part_of = vec![0; model.joints.len()];
        let mut number_of_body = vec![Vec::new(); model.bodies.len()];
        let mut n_bodies = vec![0; n_blocks];
        let mut outputs: Vec<Expr> = Vec::new();
        for (joint_idx, &block) in of_joint.iter().enumerate() {
            if !is_needed(block) {
                continue;
            }
            let joint = &model.joints[joint_idx];
            let bodies = [joint.predecessor.body.0, joint.successor.body.0].map(|body| {
                if body == 0 {
                    return None;
                }
                let known: &mut Vec<(usize, usize)> = &mut number_of_body[body];
                if let Some(&(_, number)) = known.iter().find(|(of, _)| *of == block) {
                    return Some(number);
                }
                let number = n_bodies[block];
                n_bodies[block] += 1;
                known.push((block, number));
                Some(number)
            });
            let transmission = transmission(model, &system.kinematics, JointId(joint_idx));
            let first = outputs.len();
            outputs.extend(transmission.at);
            let motions = match transmission.directions {
                Directions::Alone(wrench) => {
                    outputs.extend(wrench.force);
                    outputs.extend(wrench.moment);
                    None
                }
                Directions::AllBut(motions) => {
                    outputs.extend(motions.iter().flat_map(|motion| motion.axis));
                    let pitches = motions.iter().map(|m| m.pitch.unwrap_or(model.pool.zero()));
                    outputs.extend(pitches);
                    Some(motions.iter().map(|motion| motion.kind).collect())
                }
            };
            part_of[joint_idx] = of_block[block].parts.len();
            let part = JointPart { joint: JointId(joint_idx), bodies, motions, first };
            of_block[block].parts.push(part);
        }
        for (effort, joint, motion_idx) in efforts {
            let block = &mut of_block[of_joint[joint.0]];
            block.efforts.push((effort, part_of[joint.0], motion_idx));
        }
        for ((effort, constraint), block) in couplings.into_iter().zip(of_coupling) {
            let Some(block) = block.filter(|&block| is_needed(block)) else { continue };
            let number = |BodyId(body): BodyId| {
                let known: &Vec<(usize, usize)> = &number_of_body[body];
                known.iter().find(|(of, _)| *of == block).map(|(_, number)| *number)
            };
            let wrenches = constraint.wrenches.iter().map(|wrench| {
                let first = outputs.len();
                outputs.extend([wrench.at, wrench.force, wrench.moment].concat());
                (number(wrench.body), first)
            });
            let wrenches = wrenches.collect();
            let is_moment = constraint.effort == MotionKind::Rotation;
            of_block[block].couplings.push(CouplingPart { effort, is_moment, wrenches });
        }
        of_block.retain(|block| !block.parts.is_empty());

        let time = [model.time];
        let compile = || Function::compile(model, &outputs, &[&time, q], parameters);
        let function = (!outputs.is_empty()).then(compile).transpose()?;
        let axes: &[usize] = match model.space {
            Space::Planar => &[0, 1, 5],
            Space::Spatial => &[0, 1, 2, 3, 4, 5],
        };
        let sizes =
            [model.joints.len(), model.couplings.len(), model.drives.len(), system.contacts.len()];
        Ok(Self { function, blocks: of_block, axes, sizes })
    }

    /// Whether a self-stress is possible in any pose and mode.
    pub(crate) fn are_shared(&self) -> bool {
        self.function.is_some()
    }

    /// Everything unique.
    pub(crate) fn all_unique(&self) -> Uniqueness {
        Uniqueness::all(self.sizes)
    }

    /// A basis of the self-stresses at a position, with the efforts that `acts` says are there.
    pub(crate) fn self_stresses(
        &self,
        parameters: &[f64],
        (t, q): (f64, &[f64]),
        acts: &dyn Fn(Effort) -> bool,
    ) -> Vec<SelfStress> {
        let Some(function) = &self.function else { return Vec::new() };
        let mut buffers = function.buffers(parameters);
        let values = function.evaluate(&mut buffers, &[&[t], q]);
        if values.iter().any(|value| !value.is_finite()) {
            return Vec::new();
        }
        self.blocks.iter().flat_map(|block| block.self_stresses(values, self.axes, acts)).collect()
    }
}

/// The rows of the couplings.
fn couplings(system: &SymbolicSystem) -> Vec<(Effort, &Constraint)> {
    let rows = system.constraints.iter();
    let of_coupling = rows.filter_map(|constraint| match constraint.source {
        Source::Coupling(coupling) => Some((Effort::Coupling(coupling), constraint)),
        _ => None,
    });
    of_coupling.collect()
}

/// The efforts of drives and contacts, each with its joint and the motion that it acts along.
fn efforts(model: &Model, system: &SymbolicSystem) -> Vec<(Effort, JointId, usize)> {
    let drives = model.drives.iter().enumerate();
    let drives =
        drives.map(|(k, drive)| (Effort::Drive(DriveId(k)), drive.joint, drive.motion_idx));
    let contacts = system.contacts.iter().enumerate().filter_map(|(k, contact)| {
        let (LoadKind::Stop { joint, motion_idx, .. }
        | LoadKind::Friction { joint, motion_idx, .. }) = model.loads[contact.load.0].kind
        else {
            return None;
        };
        Some((Effort::Contact(k, contact.load), joint, motion_idx))
    });
    drives.chain(contacts).collect()
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

impl Block {
    fn self_stresses(
        &self,
        values: &[f64],
        axes: &[usize],
        acts: &dyn Fn(Effort) -> bool,
    ) -> Vec<SelfStress> {
        let triple = |first: usize| [values[first], values[first + 1], values[first + 2]];
        let (center, length) = extent(self.parts.iter().map(|part| triple(part.first)));

        // The unknowns: reactions, then efforts.
        let mut unknowns: Vec<Unknown> = Vec::new();
        for (part_idx, part) in self.parts.iter().enumerate() {
            let wrenches = match &part.motions {
                None => {
                    let moment = triple(part.first + 6).map(|part| part / length);
                    vec![unit_wrench(triple(part.first + 3), moment)]
                }
                Some(motions) => {
                    let pitches = part.first + 3 * (motions.len() + 1);
                    let free = motions.iter().enumerate().map(|(k, &kind)| {
                        let axis = triple(part.first + 3 * (k + 1));
                        twist(kind, axis, values[pitches + k] / length)
                    });
                    complement(&free.collect::<Vec<_>>(), axes)
                }
            };
            let unknown = |wrench| Unknown::Through { part_idx, effort: None, wrench };
            unknowns.extend(wrenches.into_iter().map(unknown));
        }
        for &(of, part_idx, motion_idx) in self.efforts.iter().filter(|(of, ..)| acts(*of)) {
            let part = &self.parts[part_idx];
            let Some(motions) = &part.motions else { continue };
            let axis = triple(part.first + 3 * (motion_idx + 1));
            let wrench = effort(motions[motion_idx], axis);
            unknowns.push(Unknown::Through { part_idx, effort: Some(of), wrench });
        }
        unknowns.extend((0..self.couplings.len()).map(Unknown::Of));

        // Columns of W as rows: the wrench about the centre, on the successor and reversed on the
        // predecessor.
        let coupled = self.couplings.iter().flat_map(|c| &c.wrenches).filter_map(|(body, _)| *body);
        let n_bodies =
            self.parts.iter().flat_map(|part| part.bodies).flatten().chain(coupled).max();
        let mut columns = SparseRows::new(6 * n_bodies.map_or(0, |last| last + 1));
        for unknown in &unknowns {
            let arm = |p: [f64; 3]| std::array::from_fn(|i| (p[i] - center[i]) / length);
            let mut on: Vec<(usize, Wrench)> = Vec::new();
            match *unknown {
                Unknown::Through { part_idx, wrench, .. } => {
                    let part = &self.parts[part_idx];
                    let about = about_center(wrench, arm(triple(part.first)));
                    let both = part.bodies.iter().zip([-1.0, 1.0]);
                    on.extend(
                        both.filter_map(|(body, sign)| Some(((*body)?, about.map(|w| sign * w)))),
                    );
                }
                Unknown::Of(coupling_idx) => {
                    for &(body, first) in &self.couplings[coupling_idx].wrenches {
                        let [at, force, moment] = [0, 3, 6].map(|offset| triple(first + offset));
                        let [[fx, fy, fz], [mx, my, mz]] = [force, moment.map(|m| m / length)];
                        let about = about_center([fx, fy, fz, mx, my, mz], arm(at));
                        on.extend(body.map(|body| (body, about)));
                    }
                }
            }
            columns.push(summed(on));
        }
        let combinations = vanishing_combinations(&columns).into_iter();
        combinations.map(|combination| self.stress(&combination, &unknowns, length)).collect()
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
fn summed(on: Vec<(usize, Wrench)>) -> Vec<(usize, f64)> {
    let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
    for (body, wrench) in on {
        for (i, part) in wrench.into_iter().enumerate() {
            *sums.entry(6 * body + i).or_default() += part;
        }
    }
    sums.into_iter().filter(|(_, part)| *part != 0.0).collect()
}

/// The middle of some points and how far they lie from it; a metre where they are one point.
fn extent(points: impl Iterator<Item = [f64; 3]> + Clone) -> ([f64; 3], f64) {
    let (mut sum, mut n) = ([0.0; 3], 0.0);
    for point in points.clone() {
        sum = std::array::from_fn(|i| sum[i] + point[i]);
        n += 1.0;
    }
    let center = sum.map(|part| part / n);
    let far = |p: [f64; 3]| (0..3).map(|i| (p[i] - center[i]).powi(2)).sum::<f64>().sqrt();
    let length = points.map(far).fold(0.0, f64::max);
    (center, if length > 0.0 { length } else { 1.0 })
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

/// Orthonormal wrenches along some axes that do no work on the motions `free`: the axes themselves
/// where they can be.
fn complement(free: &[Wrench], axes: &[usize]) -> Vec<Wrench> {
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
    while basis.len() < axes.len() {
        let rests = axes.iter().map(|&axis| {
            let mut unit = [0.0; 6];
            unit[axis] = 1.0;
            freed(unit, &basis)
        });
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
