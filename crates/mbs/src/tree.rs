//! The spanning tree of a mechanism and the joints that are cut to get it.
//!
//! A joint connects a body to its parent, or the body moves freely against the ground; every joint that is
//! not in the tree becomes constraint equations.

mod choice;

use std::collections::VecDeque;

use bksim_model::{
    BodyId, CoordinatePolicy, GROUND, JointId, Measure, Model, Signal, Space, Surface,
};

/// The connection of a body to the tree.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Branch {
    /// By a joint on `parent`; `reversed` when the body is the joint's predecessor.
    Joint {
        /// The joint.
        joint: JointId,
        /// The parent in the tree.
        parent: BodyId,
        /// True if the joint is passed from successor to predecessor.
        reversed: bool,
    },
    /// With coordinates of its own against the ground.
    Free,
}

/// A spanning tree.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The bodies but the ground, parents first, each with its branch.
    pub branches: Vec<(BodyId, Branch)>,
    /// Joints outside the tree, in file order.
    pub cuts: Vec<JointId>,
    /// The policy that was followed; never `Auto`.
    pub policy: CoordinatePolicy,
}

impl Tree {
    /// The tree of `model` under its own policy.
    pub fn of(model: &Model) -> Self {
        match model.coordinates {
            CoordinatePolicy::Auto => {
                let relative = Self::with_policy(model, CoordinatePolicy::Relative);
                if choice::is_short(model, &relative) {
                    relative
                } else {
                    Self::with_policy(model, CoordinatePolicy::Absolute)
                }
            }
            stated => Self::with_policy(model, stated),
        }
    }

    /// The tree that shows where the bodies are when only joint values are known: it closes nothing, and has joints that are
    /// to be cut only where no others lead to a body.
    pub fn uncut(model: &Model) -> Self {
        let may_carry = |id: JointId| !model.joints[id.0].kind.is_always_cut();
        if model.joints.iter().all(|joint| joint.cut != Some(true)) {
            return Self::grow(model, CoordinatePolicy::Relative, &may_carry);
        }
        // Which bodies hang together by the joints so far.
        let mut island: Vec<usize> = (0..model.bodies.len()).collect();
        let mut is_bridge = vec![false; model.joints.len()];
        for is_cut in [false, true] {
            for (idx, joint) in model.joints.iter().enumerate() {
                let [from, to] = [joint.predecessor, joint.successor].map(|end| island[end.body.0]);
                if (joint.cut == Some(true)) != is_cut || !may_carry(JointId(idx)) || from == to {
                    continue;
                }
                is_bridge[idx] = true;
                island.iter_mut().filter(|of| **of == from).for_each(|of| *of = to);
            }
        }
        Self::grow(model, CoordinatePolicy::Relative, &|id| {
            may_carry(id) && (is_bridge[id.0] || model.joints[id.0].cut != Some(true))
        })
    }

    fn with_policy(model: &Model, policy: CoordinatePolicy) -> Self {
        let coupled: Vec<bool> = (0..model.joints.len())
            .map(|joint_idx| model.space == Space::Spatial && is_coupled(model, JointId(joint_idx)))
            .collect();
        let mut counted = coupled.clone();
        count_turns(model, &mut counted);
        let tree = Self::keeping(model, policy, &counted);
        let is_long = counted != coupled && !choice::is_short(model, &tree);
        if policy == CoordinatePolicy::Absolute && is_long {
            return Self::keeping(model, policy, &coupled);
        }
        tree
    }

    /// The tree with these joints in it, where nothing else forbids that.
    fn keeping(model: &Model, policy: CoordinatePolicy, kept: &[bool]) -> Self {
        Self::grow(model, policy, &|id| {
            let joint = &model.joints[id.0];
            let is_cut = policy == CoordinatePolicy::Absolute || joint.kind.is_loose();
            let is_cut = is_cut && !kept[id.0];
            // Where something depends on a reaction, that must be among the multipliers.
            let is_cut = joint.cut.unwrap_or(is_cut) || rubs(model, id);
            !joint.kind.is_always_cut() && !is_cut
        })
    }

    fn grow(model: &Model, policy: CoordinatePolicy, may_carry: &dyn Fn(JointId) -> bool) -> Self {
        // The joints of each body that may be in the tree.
        let mut incident = vec![Vec::new(); model.bodies.len()];
        for (joint_idx, joint) in model.joints.iter().enumerate() {
            if may_carry(JointId(joint_idx)) {
                incident[joint.predecessor.body.0].push(JointId(joint_idx));
                incident[joint.successor.body.0].push(JointId(joint_idx));
            }
        }

        // Breadth first from the ground, then from every body that is not reached.
        let mut branches = Vec::new();
        let mut reached = vec![false; model.bodies.len()];
        let mut in_tree = vec![false; model.joints.len()];
        let mut frontier = VecDeque::from([GROUND]);
        reached[GROUND.0] = true;
        for seed in 0..model.bodies.len() {
            // A body that no tree joint reaches moves freely, and carries its own branches.
            if !reached[seed] {
                reached[seed] = true;
                branches.push((BodyId(seed), Branch::Free));
                frontier.push_back(BodyId(seed));
            }
            while let Some(parent) = frontier.pop_front() {
                for &joint_id in &incident[parent.0] {
                    let joint = &model.joints[joint_id.0];
                    let reversed = joint.successor.body == parent;
                    let child = if reversed { joint.predecessor } else { joint.successor }.body;
                    if reached[child.0] {
                        continue;
                    }
                    reached[child.0] = true;
                    in_tree[joint_id.0] = true;
                    branches.push((child, Branch::Joint { joint: joint_id, parent, reversed }));
                    frontier.push_back(child);
                }
            }
        }
        let cuts = (0..model.joints.len()).filter(|&j| !in_tree[j]).map(JointId).collect();
        Self { branches, cuts, policy }
    }

    /// The joint that carries a body in the tree; `None` of the ground and of a body that moves freely.
    pub fn joint_of(&self, body: BodyId) -> Option<JointId> {
        self.branches.iter().find_map(|&(of, branch)| match branch {
            Branch::Joint { joint, .. } if of == body => Some(joint),
            _ => None,
        })
    }

    /// Number of joints between the ground and the farthest body.
    pub fn depth(&self) -> usize {
        let n_bodies = self.branches.len() + 1;
        let mut depth = vec![0; n_bodies];
        for &(body, branch) in &self.branches {
            depth[body.0] = match branch {
                Branch::Joint { parent, .. } => depth[parent.0] + 1,
                Branch::Free => 1,
            };
        }
        depth.into_iter().max().unwrap_or(0)
    }
}

/// Sets, by joint, that something acts by how far it has turned. In space only a coordinate tells one turn from the
/// next; a cut screw counts its turns by its travel, and bodies that turn about all axes have a pole in such
/// coordinates.
fn count_turns(model: &Model, counted: &mut [bool]) {
    if model.space == Space::Planar {
        return;
    }
    let of_loads = model.loads.iter().filter_map(|load| load.position_it_follows(&model.pool));
    let of_signals = model.signals.iter().filter_map(|signal| match signal.measure {
        Measure::JointPosition(joint, motion_idx) => Some((joint, motion_idx)),
        _ => None,
    });
    for (joint, motion_idx) in of_loads.chain(of_signals) {
        let kind = &model.joints[joint.0].kind;
        let is_left_out = kind.lead().is_some() || kind.turns_freely();
        counted[joint.0] |= kind.turns(motion_idx) && !is_left_out;
    }
}

/// True where a coupling uses the position of a joint.
fn is_coupled(model: &Model, id: JointId) -> bool {
    let mut signals = model.signals.iter().filter(|signal| match signal.measure {
        Measure::JointPosition(joint, _) | Measure::Turn(_, _, joint) => joint == id,
        _ => false,
    });
    let uses = |symbol| model.all_couplings().any(|c| model.pool.depends_on(c.relation, symbol));
    signals.any(|signal| uses(signal.symbol))
}

/// True where friction or an expression that acts depends on the reaction of a joint.
fn rubs(model: &Model, id: JointId) -> bool {
    let of_friction = model.loads.iter().any(|load| match load.kind.coulomb() {
        // Teeth are pressed by the force of their coupling.
        None | Some(Surface::Teeth { .. }) => false,
        Some(_) => load.kind.joint_motion().is_some_and(|(joint, _)| joint == id),
    });
    let is_own =
        |signal: &Signal| matches!(signal.measure, Measure::Reaction(joint, ..) if joint == id);
    of_friction || model.signals.iter().any(|signal| is_own(signal) && model.acts(signal))
}
