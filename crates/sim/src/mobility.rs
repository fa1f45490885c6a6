//! How many ways a mechanism can move: Grübler's count and the numeric rank.

use crate::redundancy::RepeatedCondition;
use crate::start::Start;
use bksim_mbs::particle::particles;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{JointId, Model, Space};

/// Degrees of freedom, counted and computed.
#[derive(Clone, PartialEq, Debug)]
pub struct Mobility {
    /// Grübler's (planar) or Kutzbach's (spatial) count, drives aside.
    pub gruebler: i64,
    /// nq − rank of the joints' constraints at the start, drives aside: independent velocities.
    pub mobility: usize,
    /// Number of independent positions: more where conditions hold between rates alone.
    pub of_positions: usize,
    /// Number of constraint rows, drives included; the lengths of quaternions are none.
    pub n_constraints: usize,
    /// Number of independent ones.
    pub rank: usize,
    /// Number of conditions of the joints that repeat others, those that fold to 0 = 0 among them.
    pub n_redundant: usize,
    /// Joints whose constraints repeat one another; their reactions are not unique.
    pub redundant: Vec<JointId>,
    /// By joint: fx, fy, fz, mx, my, mz, true where the joints repeat no condition in that direction.
    pub unique: Vec<[bool; 6]>,
    /// The redundant conditions, each with those that it follows from.
    pub repeated: Vec<RepeatedCondition>,
}

/// Counts the degrees of freedom of `model` at its start.
pub fn mobility(model: &Model, system: &SymbolicSystem, start: &Start) -> Mobility {
    let redundancy = &start.redundancy;
    let n_lengths = system.kinematics.turnings.len();
    Mobility {
        gruebler: gruebler(model),
        mobility: start.mobility,
        of_positions: start.mobility_of_positions,
        n_constraints: system.constraints.len() - n_lengths,
        rank: start.dependence.rank - n_lengths,
        n_redundant: redundancy.n_self_stresses,
        redundant: redundancy.shared_joints().collect(),
        unique: redundancy.reactions.clone(),
        repeated: start.repeated.clone(),
    }
}

/// The freedoms of a body alone: 3 in a plane, 6 in space.
pub fn freedoms_of_body(space: Space) -> i64 {
    if space == Space::Planar { 3 } else { 6 }
}

/// The turns of a body, which are no freedoms of a particle: 1 in a plane, 3 in space.
pub fn turns(space: Space) -> i64 {
    if space == Space::Planar { 1 } else { 3 }
}

/// d (n − 1) − Σ u with d = 3 or 6 freedoms a body, u of which a joint takes, and a coupling one; turning is no
/// freedom of a particle.
pub fn gruebler(model: &Model) -> i64 {
    let taken: i64 = model.joints.iter().map(|joint| joint.kind.n_taken(model.space)).sum();
    let number = |n: usize| i64::try_from(n).unwrap_or(i64::MAX / 8);
    let n_particles = particles(model).into_iter().filter(|is| *is).count();
    let moving = freedoms_of_body(model.space) * number(model.bodies.len() - 1);
    moving - turns(model.space) * number(n_particles) - taken - number(model.couplings.len())
}

/// The joints of the loop that `joint` closes, in order around it, `joint` first.
///
/// Follows the tree of the whole mechanism, so that joints cut elsewhere do not hide the loop.
pub fn loop_through(model: &Model, joint: JointId) -> Vec<JointId> {
    let other_joints = (0..model.joints.len()).map(JointId).filter(|&j| j != joint);
    let others: Vec<JointId> = other_joints.collect();
    let (from, to) = (model.joints[joint.0].successor.body, model.joints[joint.0].predecessor.body);

    // Shortest way back from the successor to the predecessor.
    let mut came_by: Vec<Option<JointId>> = vec![None; model.bodies.len()];
    let mut frontier = std::collections::VecDeque::from([from]);
    let mut seen = vec![false; model.bodies.len()];
    seen[from.0] = true;
    while let Some(body) = frontier.pop_front() {
        for &id in &others {
            let next = &model.joints[id.0];
            let ends = [next.predecessor.body, next.successor.body];
            let far = match ends.iter().position(|&end| end == body) {
                Some(near) => ends[1 - near],
                None => continue,
            };
            if !seen[far.0] {
                seen[far.0] = true;
                came_by[far.0] = Some(id);
                frontier.push_back(far);
            }
        }
    }
    let mut path = Vec::new();
    let mut body = to;
    while let Some(id) = came_by[body.0] {
        path.push(id);
        let passed = &model.joints[id.0];
        body = if passed.successor.body == body {
            passed.predecessor.body
        } else {
            passed.successor.body
        };
    }
    if body != from {
        return vec![joint];
    }
    path.push(joint);
    path.reverse();
    path
}
