//! [`Transmissions`]: the wrenches that the joints of loops transmit, as numbers, and their self-stresses.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::constraint::{Constraint, Source};
use bksim_mbs::system::SymbolicSystem;
use bksim_mbs::transmission::{Directions, transmission};
use bksim_model::{Compliance, DriveId, JointId, Model, MotionKind, Space};

use super::block::{Block, CouplingPart, JointPart};
use super::blocks::blocks;
use super::conditions::RepeatedCondition;
use super::sharing::{self, Spring};
use super::{Effort, SelfStress, Uniqueness, Yields};
use crate::function::Function;

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
    /// Of joints in loops.
    compliances: Vec<Compliance>,
    /// The row of each contact, and the effort along its motion for a multiplier of one.
    contact_rows: Vec<(usize, f64)>,
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
        // A place where outlines touch closes a loop as a joint does.
        let places = couplings.iter().zip(&of_coupling).filter(|((_, row), _)| is_place(row));
        places.filter_map(|(_, block)| *block).for_each(|block| n_members[block] += 1);
        let mut n_efforts = vec![0; n_blocks];
        for &(_, joint, _) in &efforts {
            n_efforts[of_joint[joint.0]] += 1;
        }
        let is_needed = |block: usize| n_members[block] > 1 || n_efforts[block] > 1;

        // The parts, and what is to be computed for them.
        let mut of_block = vec![Block::default(); n_blocks];
        let mut part_of = vec![0; model.joints.len()];
        let mut numbers =
            Numbers { of_body: vec![Vec::new(); model.bodies.len()], n_bodies: vec![0; n_blocks] };
        let mut outputs: Vec<Expr> = Vec::new();
        for (joint_idx, &block) in of_joint.iter().enumerate() {
            if !is_needed(block) {
                continue;
            }
            let joint = &model.joints[joint_idx];
            let bodies = [joint.predecessor.body.0, joint.successor.body.0]
                .map(|body| numbers.of(body, block));
            let transmission = transmission(model, &system.kinematics, JointId(joint_idx));
            let first = outputs.len();
            outputs.extend(transmission.at);
            outputs.extend(transmission.frame.as_flattened());
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
            // A body that joints of the block do not reach hangs on couplings, and is in balance by itself.
            let wrenches = constraint.wrenches.iter().map(|wrench| {
                let first = outputs.len();
                outputs.extend([wrench.at, wrench.force, wrench.moment].concat());
                (numbers.of(wrench.body.0, block), first)
            });
            let wrenches = wrenches.collect();
            let is_moment = constraint.effort == MotionKind::Rotation;
            let opens = is_place(constraint);
            of_block[block].couplings.push(CouplingPart { effort, is_moment, opens, wrenches });
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
        let compliances = model.compliances.clone();
        let row =
            |row: usize| (row, if system.constraints[row].direction == "max" { -1.0 } else { 1.0 });
        let contact_rows = system.contacts.iter().map(|contact| row(contact.row)).collect();
        Ok(Self { function, blocks: of_block, axes, sizes, compliances, contact_rows })
    }

    /// True if a self-stress is possible in any pose and mode.
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
        let Some(values) = self.values(parameters, (t, q)) else { return Vec::new() };
        self.blocks.iter().flat_map(|block| block.self_stresses(&values, self.axes, acts)).collect()
    }

    /// The conditions of joints and couplings that follow from those before them at a position, as many as there are
    /// self-stresses without efforts.
    pub(crate) fn repeated_conditions(
        &self,
        parameters: &[f64],
        at: (f64, &[f64]),
    ) -> Vec<RepeatedCondition> {
        let Some(values) = self.values(parameters, at) else { return Vec::new() };
        self.blocks.iter().flat_map(|block| block.repeated_conditions(&values, self.axes)).collect()
    }

    /// A basis of the self-stresses that no joint decides which yields.
    pub(crate) fn open_stresses(
        &self,
        parameters: &[f64],
        (t, q): (f64, &[f64]),
        acts: &dyn Fn(Effort) -> bool,
        yields: Yields,
    ) -> Vec<SelfStress> {
        let Some(values) = self.values(parameters, (t, q)) else { return Vec::new() };
        let stresses = |block: &Block| {
            let all = block.self_stresses(&values, self.axes, acts);
            let springs =
                if yields == Yields::AsStated { self.springs(&values) } else { Vec::new() };
            sharing::open(&springs, all)
        };
        self.blocks.iter().flat_map(stresses).collect()
    }

    /// The row of a contact, and the effort along its motion for a multiplier of one.
    pub(crate) fn contact_row(&self, contact_idx: usize) -> (usize, f64) {
        self.contact_rows[contact_idx]
    }

    /// True where a joint yields, so that reactions which are not unique follow from more than the equilibrium.
    pub(crate) fn may_yield(&self) -> bool {
        self.are_shared() && !self.compliances.is_empty()
    }

    /// How joints yield.
    pub(crate) fn compliances(&self) -> &[Compliance] {
        &self.compliances
    }

    /// Lets other joints yield.
    pub(crate) fn set_compliances(&mut self, compliances: &[Compliance]) {
        compliances.clone_into(&mut self.compliances);
    }

    /// The self-stress that brings these reactions, by joint, to what joints that yield share; nothing where none does.
    pub(crate) fn shared(
        &self,
        parameters: &[f64],
        (t, q): (f64, &[f64]),
        acts: &dyn Fn(Effort) -> bool,
        reactions: &[[f64; 6]],
    ) -> SelfStress {
        let mut sum = SelfStress::default();
        let Some(values) = self.values(parameters, (t, q)) else { return sum };
        let springs = self.springs(&values);
        for block in &self.blocks {
            let stresses = block.self_stresses(&values, self.axes, acts);
            if stresses.is_empty() {
                continue;
            }
            let factors = sharing::shares(&springs, &stresses, reactions).unwrap_or_default();
            stresses.iter().zip(factors).for_each(|(stress, factor)| sum.add(stress, factor));
        }
        sum
    }

    /// The springs of joints in loops.
    fn springs(&self, values: &[f64]) -> Vec<Spring> {
        let of = |compliance: &Compliance| {
            let mut parts = self.blocks.iter().flat_map(|block| &block.parts);
            let part = parts.find(|part| part.joint == compliance.joint);
            part.map_or_else(Vec::new, |part| Spring::of(compliance, &part.frame(values)))
        };
        self.compliances.iter().flat_map(of).collect()
    }

    /// The geometry at a position, if it is finite there.
    fn values(&self, parameters: &[f64], (t, q): (f64, &[f64])) -> Option<Vec<f64>> {
        let function = self.function.as_ref()?;
        let mut buffers = function.buffers(parameters);
        let values = function.evaluate(&mut buffers, &[&[t], q]);
        values.iter().all(|value| value.is_finite()).then(|| values.to_vec())
    }
}

/// The numbers of bodies within blocks, given as they are asked for.
struct Numbers {
    /// By body: the blocks that it is in, with its number there.
    of_body: Vec<Vec<(usize, usize)>>,
    /// By block.
    n_bodies: Vec<usize>,
}

impl Numbers {
    /// The number of a body in a block; `None` of the ground.
    fn of(&mut self, body: usize, block: usize) -> Option<usize> {
        if body == 0 {
            return None;
        }
        let known = &mut self.of_body[body];
        if let Some(&(_, number)) = known.iter().find(|(of, _)| *of == block) {
            return Some(number);
        }
        let number = self.n_bodies[block];
        self.n_bodies[block] += 1;
        known.push((block, number));
        Some(number)
    }
}

/// True of a row that holds while outlines touch or stick.
fn is_place(row: &Constraint) -> bool {
    ["touch", "along"].contains(&row.direction)
}

/// The rows of the couplings, of ropes, and of places where outlines may touch.
fn couplings(system: &SymbolicSystem) -> Vec<(Effort, &Constraint)> {
    let rows = system.constraints.iter();
    let of_coupling = rows.filter_map(|constraint| match constraint.source {
        Source::Coupling(coupling) => Some((Effort::Coupling(coupling), constraint)),
        _ => None,
    });
    // Ropes that are taut pull at several bodies, as couplings do.
    let ropes = system.contacts.iter().enumerate().filter_map(|(k, contact)| {
        let row = &system.constraints[contact.row];
        // Of teeth with play one flank at most bears: the first stands for both.
        (["rope", "forward"].contains(&row.direction) || is_place(row))
            .then_some((Effort::Contact(k, contact.load), row))
    });
    of_coupling.chain(ropes).collect()
}

/// The efforts of drives and contacts, each with its joint and the motion that it acts along.
fn efforts(model: &Model, system: &SymbolicSystem) -> Vec<(Effort, JointId, usize)> {
    let drives = model.drives.iter().enumerate();
    let drives =
        drives.map(|(k, drive)| (Effort::Drive(DriveId(k)), drive.joint, drive.motion_idx));
    let contacts = system.contacts.iter().enumerate().filter_map(|(k, contact)| {
        let (joint, motion_idx) = model.loads[contact.load.0].kind.joint_motion()?;
        Some((Effort::Contact(k, contact.load), joint, motion_idx))
    });
    drives.chain(contacts).collect()
}
