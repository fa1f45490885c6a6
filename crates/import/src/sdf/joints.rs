//! Joints, loops among them, and links that none holds.

use crate::codes;
use crate::draft::{self, Table, list, number};
use crate::job::{short, suggestion};
use crate::loads::Motion;
use crate::spatial::{Inertia, Pose, Rotation, Vector, add, cross, dot, scale, sub, unit};
use crate::xml::NodeId;

use super::frames::{FrameId, Of};
use super::{Moving, Reader};

/// Limits beyond this are none.
const NO_LIMIT: f64 = 1e15;

/// Types of joints with the word of the model, and the number of axes.
const TYPES: [(&str, &str, usize); 9] = [
    ("revolute", "revolute", 1),
    ("continuous", "revolute", 1),
    ("prismatic", "prismatic", 1),
    ("fixed", "weld", 0),
    ("ball", "spherical", 0),
    ("universal", "universal", 2),
    ("revolute2", "universal", 2),
    ("screw", "screw", 1),
    ("gearbox", "", 0),
];

impl Reader<'_, '_> {
    pub(super) fn all_joints(&mut self) {
        let mut group: Vec<usize> = (0..=self.draft.bodies.len()).collect();
        let mut is_child = vec![false; self.draft.bodies.len()];
        self.has_loops = self.has_loops();
        for idx in 0..self.frames.len() {
            if self.frames[idx].of == Of::Joint {
                let Some(ends) = self.joint(FrameId(idx)) else { continue };
                if let Some(child) = ends[1] {
                    is_child[child] = true;
                }
                let [a, b] = ends.map(|end| representative(&group, end.map_or(0, |body| body + 1)));
                group[a.max(b)] = a.min(b);
            }
        }
        self.roots(&mut group, &is_child);
    }

    /// True if joints close a loop: more of them than a tree has.
    fn has_loops(&self) -> bool {
        let mut ends: Vec<Vec<String>> = Vec::new();
        for frame in self.frames.iter().filter(|frame| frame.of == Of::Joint) {
            let Some(joint) = frame.node else { continue };
            if self.tree.value(joint, "type") == Some("gearbox") {
                continue;
            }
            let prefix = &self.scopes[frame.scope].prefix;
            let names = ["parent", "child"].map(|tag| {
                self.tree.text_of(joint, tag).map(|(name, _)| format!("{prefix}{name}"))
            });
            let [Some(parent), Some(child)] = names else { continue };
            let place = |name: &String| ends.iter().position(|group| group.contains(name));
            match (place(&parent), place(&child)) {
                (Some(a), Some(b)) if a == b => return true,
                (Some(a), Some(b)) => {
                    let other = ends.remove(a.max(b));
                    ends[a.min(b)].extend(other);
                }
                (Some(a), None) => ends[a].push(child),
                (None, Some(b)) => ends[b].push(parent),
                (None, None) => ends.push(vec![parent, child]),
            }
        }
        false
    }

    /// Holds one link of each group that nothing joins to the world.
    fn roots(&mut self, group: &mut [usize], is_child: &[bool]) {
        for is_sought in [false, true] {
            for idx in 0..self.links.len() {
                let (body, is_static, frame) =
                    (self.links[idx].body, self.links[idx].is_static, self.links[idx].frame);
                if representative(group, body + 1) == 0 || is_child[body] != is_sought {
                    continue;
                }
                let root = representative(group, body + 1);
                group[root] = 0;
                let name = self.draft.bodies[body].name.clone();
                let world = self.world(frame);
                if is_static {
                    let first = self.draft.frame(None, &name, world);
                    let joint = self.names.coin(&format!("{name}_fixed"));
                    self.draft.joints.push(Table::new(joint, "weld").between(&first, &name));
                    continue;
                }
                let joint = self.names.coin(&format!("{name}_free"));
                let note = format!("nothing holds link {}", self.links[idx].written);
                self.draft
                    .joints
                    .push(Table::new(joint.clone(), "free").between("ground", &name).note(note));
                let [x, y, z] = world.at.map(number);
                let place = format!("{{ position1 = {x}, position2 = {y}, position3 = {z} }}");
                self.draft.initial.push((joint, place));
                let turn = format!("{{ quaternion = {} }}", list(&world.turn.0));
                self.draft.initial.push((name, turn));
            }
        }
    }

    /// The body at an end of a joint, `None` for the world.
    #[expect(clippy::option_option, reason = "a name that is wrong, the world, or a body")]
    fn end(&mut self, joint: FrameId, node: NodeId, tag: &str) -> Option<Option<usize>> {
        let Some((name, place)) = self.tree.text_of(node, tag) else {
            let place = self.place(node);
            let message = format!("joint `{}` has no `{tag}`", short(&self.frames[joint.0].name));
            self.job.error(
                codes::MISSING,
                message,
                (&place, ""),
                &format!("write `<{tag}>…</{tag}>` in it"),
            );
            return None;
        };
        let (name, place) = (name.to_owned(), place.clone());
        let frame = self.named(self.frames[joint.0].scope, (&name, &place))?;
        let Some(link) = self.link_of(frame) else { return Some(None) };
        Some(self.links.iter().find(|known| known.frame == link).map(|known| known.body))
    }

    /// Adds a joint; returns its bodies.
    fn joint(&mut self, id: FrameId) -> Option<[Option<usize>; 2]> {
        let frame = self.frames[id.0].clone();
        let node = frame.node?;
        let written = format!("{}{}", self.scopes[frame.scope].prefix, frame.name);
        let word = self.tree.value(node, "type").unwrap_or_default().to_owned();
        let Some(&(_, kind, n_axes)) = TYPES.iter().find(|(known, ..)| *known == word) else {
            let place = self.place(node);
            let help = suggestion(&word, TYPES.iter().map(|(known, ..)| *known));
            let message =
                format!("joint `{}` has the unknown type `{}`", short(&written), short(&word));
            self.job.error(codes::UNKNOWN_WORD, message, (&place, ""), &help);
            return None;
        };
        let (parent, child) = (self.end(id, node, "parent"), self.end(id, node, "child"));
        let ends = [parent?, child?];
        if kind.is_empty() {
            self.gearbox(node, &written);
            return None;
        }
        if ends[0] == ends[1] {
            let place = self.place(node);
            let message = format!("joint `{}` has one link at both ends", short(&written));
            self.job.error(codes::CIRCLE, message, (&place, ""), "name two different links");
            return None;
        }
        let name = self.names.take("joint", &written);
        // The axes of both frames are those of the second body, so that its point needs none of its own.
        let frames = ends.map(|end| end.map_or(FrameId::WORLD, |body| self.links[body].frame));
        let carrier = if ends[1].is_some() { frames[1] } else { frames[0] };
        let own = Pose { at: self.world(id).at, turn: self.world(carrier).turn };
        let points = [0, 1].map(|k| {
            let pose = self.world(frames[k]).inverse().then(own);
            self.draft.frame(ends[k], &name, pose)
        });
        let mut table = Table::new(name.clone(), kind).between(&points[0], &points[1]);
        let axes: Vec<NodeId> = ["axis", "axis2"]
            .iter()
            .take(n_axes)
            .filter_map(|tag| self.tree.child(node, tag))
            .collect();
        let vectors: Vec<Vector> =
            axes.iter().map(|&axis| self.axis(id, axis, own.turn.inverse())).collect();
        let second = match vectors[..] {
            [first, second] if is_skew(first, second) => {
                Some(self.names.coin(&format!("{name}_2")))
            }
            _ => None,
        };
        if let Some(second) = &second {
            // Axes that are not square to each other: two hinges, with a body without mass between them.
            let middle = self.names.coin(&format!("{name}_cross"));
            let none = Inertia::default();
            self.draft.bodies.push(draft::Body::new(middle.clone(), none));
            let first = Table::new(name.clone(), "revolute").between(&points[0], &middle);
            self.draft.joints.push(first.vector("axis", vectors[0]));
            table = Table::new(second.clone(), "revolute").between(&middle, &points[1]);
            table = table.vector("axis", vectors[1]);
        }
        for (idx, axis) in vectors.iter().enumerate().filter(|_| second.is_none()) {
            let across = if idx == 1 { perpendicular(*axis, vectors[0]) } else { *axis };
            table = table.vector(["axis", "second"][idx], across);
        }
        if n_axes == 1 && axes.is_empty() {
            table = table.vector(
                "axis",
                own.turn.inverse().apply(self.world(id).turn.apply([0.0, 0.0, 1.0])),
            );
        }
        if n_axes == 2 && axes.len() < 2 {
            let place = self.place(node);
            let message = format!("joint `{}` has two axes, and one is missing", short(&written));
            self.job.error(
                codes::MISSING,
                message,
                (&place, ""),
                "write `<axis>` and `<axis2>` in it",
            );
        }
        if kind == "screw" {
            table = table.number("lead", self.lead(node));
        }
        self.draft.joints.push(table);
        for (idx, axis) in axes.into_iter().enumerate() {
            let (joint, of) = match &second {
                Some(second) => (if idx == 0 { &name } else { second }, None),
                None => (&name, (n_axes == 2).then_some(["angle1", "angle2"][idx])),
            };
            let turns = kind != "prismatic";
            let word = of.unwrap_or(if turns { "angle" } else { "position" });
            let moving = Moving {
                joint: joint.clone(),
                scalar: (format!("{joint}.{word}"), !turns),
                mimic: self.tree.child(axis, "mimic"),
            };
            self.motions.insert((id, ["axis", "axis2"][idx].to_owned()), moving);
            self.forces(axis, Motion { joint, of, turns });
        }
        for child in self.tree.children(node) {
            if matches!(self.tree.tag(child), "sensor" | "physics" | "plugin") {
                self.leave_out(child, &format!("joint {written}"));
            }
        }
        Some(ends)
    }

    /// Motions that follow others: offset + multiplier (leader − reference).
    pub(super) fn all_mimics(&mut self) {
        let followers = self.motions.iter().filter_map(|((joint, _), moving)| {
            Some((*joint, moving.joint.clone(), moving.scalar.clone(), moving.mimic?))
        });
        let followers: Vec<_> = followers.collect();
        for (id, joint, scalar, mimic) in followers {
            let place = self.place(mimic);
            let attribute = |key: &str| self.tree.attribute(mimic, key).cloned();
            let (leader, axis) = (attribute("joint"), attribute("axis"));
            let Some(leader) = leader else {
                let message = format!("`mimic` of joint `{}` has no `joint`", short(&joint));
                let help = "write `<mimic joint=\"…\">`";
                self.job.error(codes::MISSING, message, (&place, ""), help);
                continue;
            };
            let scope = self.frames[id.0].scope;
            let Some(frame) = self.named(scope, (&leader.value, &leader.place)) else { continue };
            let axis = axis.map_or("axis".to_owned(), |axis| axis.value);
            let Some(by) = self.motions.get(&(frame, axis)).map(|by| by.scalar.clone()) else {
                let message =
                    format!("joint `{}` cannot follow `{}`", short(&joint), short(&leader.value));
                let help = "a joint that turns or slides can follow another such joint; the model leaves this out";
                self.job.warn(codes::NOT_MODELLED, message, (&place, "has no such axis"), help);
                continue;
            };
            let multiplier = self.number(mimic, "multiplier").unwrap_or(1.0);
            let offset = self.number(mimic, "offset").unwrap_or(0.0);
            let reference = self.number(mimic, "reference").unwrap_or(0.0);
            let values = [multiplier, offset - multiplier * reference];
            self.draft.add_mimic(self.names, &joint, [scalar, by], values);
        }
    }

    /// Translation of one turn of a screw.
    fn lead(&mut self, node: NodeId) -> f64 {
        if let Some(lead) = self.number(node, "screw_thread_pitch") {
            return lead;
        }
        let turns_per_length = self.number(node, "thread_pitch").unwrap_or(1.0);
        -2.0 * std::f64::consts::PI / turns_per_length
    }

    fn gearbox(&mut self, node: NodeId, written: &str) {
        let place = self.place(node);
        let message =
            format!("joint `{}` is a gearbox, which the model does not have", short(written));
        let help =
            "write a coupling of type `gear` between the joints of both wheels into the model";
        self.job.warn(codes::NOT_MODELLED, message, (&place, "left out"), help);
        self.leave_out(node, "type gearbox");
    }

    /// An axis in the frame that `own` turns the world's axes to.
    fn axis(&mut self, joint: FrameId, axis: NodeId, own: Rotation) -> Vector {
        const Z: Vector = [0.0, 0.0, 1.0];
        let Some(xyz) = self.vector(axis, "xyz") else {
            return own.apply(self.world(joint).turn.apply(Z));
        };
        if unit(xyz).is_none() {
            let place = self.place(axis);
            let help = "write for example `<xyz>0 0 1</xyz>`";
            self.job.error(
                codes::NOT_A_NUMBER,
                "an axis has no direction".to_owned(),
                (&place, "all zero"),
                help,
            );
            return Z;
        }
        let scope = self.frames[joint.0].scope;
        let element = self.tree.child(axis, "xyz");
        let expressed = element.and_then(|xyz| self.tree.attribute(xyz, "expressed_in")).cloned();
        let by_model = self.is_true(axis, "use_parent_model_frame").unwrap_or(self.version < 105);
        let frame = match expressed.filter(|found| !found.value.is_empty()) {
            Some(found) => self.named(scope, (&found.value, &found.place)),
            None if by_model && self.version < 107 => Some(self.scopes[scope].own),
            None => None,
        };
        let frame = frame.unwrap_or(joint);
        own.apply(self.world(frame).turn.apply(xyz))
    }

    /// Springs, dampers, friction and limits along an axis.
    fn forces(&mut self, axis: NodeId, motion: Motion<'_>) {
        if let Some(dynamics) = self.tree.child(axis, "dynamics") {
            let of = |reader: &mut Self, tag: &str| reader.number(dynamics, tag).unwrap_or(0.0);
            let stiffness = of(self, "spring_stiffness");
            let (rest, damping, friction) =
                (of(self, "spring_reference"), of(self, "damping"), of(self, "friction"));
            self.draft.add_spring(self.names, motion, [stiffness, rest, damping]);
            let place = self.place(dynamics);
            self.draft.add_friction(self.names, motion, friction, &place);
        }
        let Some(limit) = self.tree.child(axis, "limit") else { return };
        let [lower, upper] = ["lower", "upper"]
            .map(|tag| self.number(limit, tag).filter(|value| value.abs() < NO_LIMIT));
        match [lower, upper] {
            [None, None] => (),
            [Some(lower), Some(upper)] if lower >= upper => {
                self.leave_out(limit, &format!("joint {} that leaves no room", motion.joint));
            }
            // Loops are closed where the file has the links, whatever their limits.
            [lower, upper]
                if self.has_loops
                    && (lower.is_some_and(|it| it > 0.0) || upper.is_some_and(|it| it < 0.0)) =>
            {
                let of = format!("joint {} that excludes the poses of the file", motion.joint);
                self.leave_out(limit, &of);
            }
            limits => self.draft.add_stop(self.names, motion, limits),
        }
        for tag in ["effort", "velocity"] {
            if self
                .number(limit, tag)
                .is_some_and(|value| value.is_finite() && value > 0.0 && value < NO_LIMIT)
            {
                let what = format!("limit of {tag} of joint {}", motion.joint);
                let place = self.place(limit);
                self.job.leave_out(what, &place);
            }
        }
    }
}

/// True if two axes are neither square to each other nor along each other.
fn is_skew(first: Vector, second: Vector) -> bool {
    let [Some(first), Some(second)] = [first, second].map(unit) else { return false };
    (1e-9..1.0 - 1e-9).contains(&dot(first, second).abs())
}

/// The part of a second axis across the first one; of one along it, any direction across.
fn perpendicular(second: Vector, first: Vector) -> Vector {
    let Some(first) = unit(first) else { return second };
    let across = sub(second, scale(dot(second, first), first));
    if dot(across, across) < 1e-12 {
        return add(cross(first, [1.0, 0.0, 0.0]), cross(first, [0.0, 1.0, 0.0]));
    }
    if dot(second, first).abs() < 1e-15 { second } else { across }
}

fn representative(group: &[usize], mut at: usize) -> usize {
    while group[at] != at {
        at = group[at];
    }
    at
}
