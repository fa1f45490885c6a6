//! URDF: links, and joints whose frames are those of their child links.
//!
//! The frame of a joint is that of its child link where the joint is at zero; its axis is in this frame. Angles are
//! radians; `rpy` is Rz(yaw) Ry(pitch) Rx(roll). The first link is on the ground unless it is to be free.

use std::collections::BTreeMap;

use crate::Base;
use crate::codes;
use crate::draft::{Axes, Body, Draft, Point, Table};
use crate::job::{Job, Place, short, suggestion};
use crate::loads::Motion;
use crate::names::Names;
use crate::shapes::Solid;
use crate::spatial::{Inertia, Pose, Rotation, Vector, turned, unit};
use crate::xml::{NodeId, Tree};

/// Free fall where a file says nothing, m/s².
pub(crate) const GRAVITY: Vector = [0.0, 0.0, -9.81];

/// A joint of the file.
struct Joint {
    node: NodeId,
    /// Name in the file; `name` is that in the model.
    written: String,
    name: String,
    kind: String,
    parent: usize,
    child: usize,
}

struct Reader<'r, 'a> {
    job: &'r mut Job<'a>,
    names: &'r mut Names,
    tree: &'r Tree,
    draft: Draft,
    /// Links by the names of the file, with their bodies.
    links: BTreeMap<String, usize>,
}

/// Reads the robot at `root`.
pub(crate) fn draft(
    job: &mut Job<'_>,
    names: &mut Names,
    (tree, root): (&Tree, NodeId),
    base: Base,
) -> Draft {
    let name = tree.value(root, "name").unwrap_or("robot").to_owned();
    let file = job.sources[0].name.clone();
    let heading = vec![
        format!("From {file}, a robot in URDF."),
        "Metres, kilograms, seconds and radians. The frame of a body is that of its link, z is up."
            .to_owned(),
    ];
    let draft =
        Draft { name, heading, gravity: Some(GRAVITY), is_relative: true, ..Draft::default() };
    let mut reader = Reader { job, names, tree, draft, links: BTreeMap::new() };
    for link in tree.all(root, "link") {
        reader.link(link);
    }
    let joints: Vec<NodeId> = tree.all(root, "joint");
    let joints: Vec<Joint> =
        joints.into_iter().filter_map(|node| reader.joint_ends(node)).collect();
    reader.roots(&joints, base);
    for joint in &joints {
        reader.joint(joint);
    }
    for joint in &joints {
        reader.mimic(joint, &joints);
    }
    reader.rest(root);
    reader.draft
}

impl Reader<'_, '_> {
    /// Everything else of the robot is left out by name.
    fn rest(&mut self, root: NodeId) {
        for child in self.tree.children(root) {
            let tag = self.tree.tag(child);
            if !["link", "joint", "material"].contains(&tag) {
                let of =
                    self.tree.value(child, "name").map_or(String::new(), |name| format!(" {name}"));
                self.job.leave_out(format!("{tag}{of}"), self.tree.place(child));
            }
        }
    }

    /// The required attribute of an element; reports it where it is missing.
    fn required(&mut self, node: NodeId, name: &str) -> Option<(String, Place)> {
        if let Some(found) = self.tree.attribute(node, name) {
            return Some((found.value.clone(), found.place.clone()));
        }
        let tag = self.tree.tag(node).to_owned();
        let message = format!("`{tag}` has no `{name}`");
        let place = self.tree.place(node).clone();
        let help = format!("write `<{tag} {name}=\"…\">`");
        self.job.error(codes::MISSING, message, (&place, ""), &help);
        None
    }

    fn vector(&mut self, node: NodeId, name: &str, default: Vector) -> Vector {
        let Some(found) = self.tree.attribute(node, name).cloned() else { return default };
        self.job.exactly::<3>(&found.value, &found.place, &format!("`{name}`")).unwrap_or(default)
    }

    fn number(&mut self, node: NodeId, name: &str) -> Option<f64> {
        let found = self.tree.attribute(node, name)?.clone();
        let [value] = self.job.exactly::<1>(&found.value, &found.place, &format!("`{name}`"))?;
        Some(value)
    }

    /// The `origin` of an element: position and roll, pitch, yaw.
    fn origin(&mut self, node: NodeId) -> (Vector, Vector) {
        let Some(origin) = self.tree.child(node, "origin") else { return ([0.0; 3], [0.0; 3]) };
        (self.vector(origin, "xyz", [0.0; 3]), self.vector(origin, "rpy", [0.0; 3]))
    }

    fn link(&mut self, node: NodeId) {
        let Some((written, place)) = self.required(node, "name") else { return };
        if self.links.contains_key(&written) {
            let message = format!("two links are called `{}`", short(&written));
            self.job.error(
                codes::TWICE,
                message,
                (&place, "the second one"),
                "give each link a name of its own",
            );
            return;
        }
        let name = self.names.take("body", &written);
        let mut body = Body::new(name, self.inertia(node));
        if body.inertia.mass == 0.0 {
            body.notes.push("without mass in the file".to_owned());
        }
        let inertial = self.tree.child(node, "inertial").unwrap_or(node);
        body.place = Some(self.tree.place(inertial).clone());
        for visual in self.tree.all(node, "visual") {
            self.visual(visual, &written, &mut body);
        }
        for collision in self.tree.all(node, "collision") {
            let what = format!("collision shape of link {written}");
            self.job.leave_out(what, self.tree.place(collision));
        }
        self.links.insert(written, self.draft.bodies.len());
        self.draft.bodies.push(body);
    }

    fn inertia(&mut self, link: NodeId) -> Inertia {
        let Some(inertial) = self.tree.child(link, "inertial") else { return Inertia::default() };
        let (com, rpy) = self.origin(inertial);
        let mass = self.tree.child(inertial, "mass").and_then(|mass| self.number(mass, "value"));
        let mut tensor = [0.0; 6];
        if let Some(inertia) = self.tree.child(inertial, "inertia") {
            for (entry, key) in tensor.iter_mut().zip(["ixx", "iyy", "izz", "ixy", "iyz", "ixz"]) {
                *entry = self.number(inertia, key).unwrap_or(0.0);
            }
        }
        let tensor = turned(Rotation::of_rpy(rpy), tensor);
        Inertia { mass: mass.unwrap_or(0.0), com, tensor }
    }

    fn visual(&mut self, visual: NodeId, link: &str, body: &mut Body) {
        let (at, rpy) = self.origin(visual);
        let pose = Pose { at, turn: Rotation::of_rpy(rpy) };
        let Some(geometry) = self.tree.child(visual, "geometry") else { return };
        for shape in self.tree.children(geometry) {
            let solid = match self.tree.tag(shape) {
                "box" => {
                    let size = self.vector(shape, "size", [0.0; 3]);
                    Some(Solid::Box { half: size.map(|side| side / 2.0) })
                }
                "sphere" => self.number(shape, "radius").map(|radius| Solid::Sphere { radius }),
                "cylinder" | "capsule" => {
                    let radius = self.number(shape, "radius").unwrap_or(0.0);
                    let half = self.number(shape, "length").unwrap_or(0.0) / 2.0;
                    Some(Solid::Cylinder { radius, half })
                }
                tag => {
                    let file = self.tree.value(shape, "filename").unwrap_or_default();
                    let what = format!("{tag} {file} of link {link}");
                    self.job.leave_out(what, self.tree.place(shape));
                    None
                }
            };
            if let Some(solid) = solid.filter(|solid| solid.is_solid()) {
                body.shapes.extend(solid.drawn(pose));
            }
        }
    }

    /// The body of the link that a child element of a joint names.
    fn link_of(&mut self, joint: NodeId, tag: &str) -> Option<usize> {
        let Some(end) = self.tree.child(joint, tag) else {
            let message = format!("a joint has no `{tag}`");
            let place = self.tree.place(joint).clone();
            self.job.error(
                codes::MISSING,
                message,
                (&place, ""),
                &format!("write `<{tag} link=\"…\"/>` in it"),
            );
            return None;
        };
        let (written, place) = self.required(end, "link")?;
        if let Some(&body) = self.links.get(&written) {
            return Some(body);
        }
        let help = suggestion(&written, self.links.keys().map(String::as_str));
        let message = format!("no link is called `{}`", short(&written));
        self.job.error(codes::UNKNOWN_NAME, message, (&place, "not a link of the file"), &help);
        None
    }

    fn joint_ends(&mut self, node: NodeId) -> Option<Joint> {
        let (written, _) = self.required(node, "name")?;
        let (kind, _) = self.required(node, "type")?;
        let (parent, child) = (self.link_of(node, "parent"), self.link_of(node, "child"));
        let (parent, child) = (parent?, child?);
        if parent == child {
            let message = format!("joint `{}` has one link at both ends", short(&written));
            let place = self.tree.place(node).clone();
            self.job.error(codes::CIRCLE, message, (&place, ""), "name two different links");
            return None;
        }
        let name = self.names.take("joint", &written);
        Some(Joint { node, written, name, kind, parent, child })
    }

    /// Holds the links that no joint carries.
    fn roots(&mut self, joints: &[Joint], base: Base) {
        for body in 0..self.draft.bodies.len() {
            if joints.iter().any(|joint| joint.child == body) {
                continue;
            }
            let link = self.draft.bodies[body].name.clone();
            let (kind, note) = match base {
                Base::Fixed => (
                    "weld",
                    "The file does not say how the first link is held; here it is on the ground.",
                ),
                Base::Free => ("free", "The first link moves freely."),
            };
            let name = self.names.coin(&format!("{link}_base"));
            self.draft.joints.push(Table::new(name, kind).between("ground", &link).note(note));
        }
    }

    fn joint(&mut self, joint: &Joint) {
        let (at, rpy) = self.origin(joint.node);
        let axes = if rpy == [0.0; 3] { Axes::Own } else { Axes::Rpy(rpy) };
        let point = Point { name: String::new(), at, axes };
        let first = self.draft.point(Some(joint.parent), &joint.name, &point);
        let second = self.draft.bodies[joint.child].name.clone();
        let (kind, has_axis) = match joint.kind.as_str() {
            "revolute" | "continuous" => ("revolute", true),
            "prismatic" => ("prismatic", true),
            "fixed" => ("weld", false),
            "floating" => ("free", false),
            "planar" => ("planar", true),
            "spherical" => ("spherical", false),
            other => {
                let known = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];
                let help = suggestion(other, known.into_iter());
                let message = format!(
                    "joint `{}` has the unknown type `{}`",
                    short(&joint.written),
                    short(other)
                );
                let place = self.tree.attribute(joint.node, "type").map(|a| a.place.clone());
                let place = place.unwrap_or_else(|| self.tree.place(joint.node).clone());
                self.job.error(codes::UNKNOWN_WORD, message, (&place, "not a type of URDF"), &help);
                return;
            }
        };
        let mut table = Table::new(joint.name.clone(), kind).between(&first, &second);
        if has_axis {
            table = table.vector("axis", self.axis(joint.node));
        }
        if let Some(note) = self.effort_and_velocity(joint) {
            table = table.note(note);
        }
        self.draft.joints.push(table);
        if matches!(kind, "revolute" | "prismatic") {
            self.limits(joint, kind == "revolute");
            self.dynamics(joint, kind == "revolute");
        }
        for extra in ["safety_controller", "calibration"] {
            if let Some(node) = self.tree.child(joint.node, extra) {
                self.job.leave_out(
                    format!("{extra} of joint {}", joint.written),
                    self.tree.place(node),
                );
            }
        }
    }

    /// The axis of a joint, x unless given; one without direction is reported.
    fn axis(&mut self, joint: NodeId) -> Vector {
        const X: Vector = [1.0, 0.0, 0.0];
        let Some(node) = self.tree.child(joint, "axis") else { return X };
        let axis = self.vector(node, "xyz", X);
        if unit(axis).is_none() {
            let place = self.tree.place(node).clone();
            let help = "write for example `<axis xyz=\"0 0 1\"/>`";
            self.job.error(
                codes::NOT_A_NUMBER,
                "an axis has no direction".to_owned(),
                (&place, "all zero"),
                help,
            );
            return X;
        }
        axis
    }

    fn effort_and_velocity(&mut self, joint: &Joint) -> Option<String> {
        let limit = self.tree.child(joint.node, "limit")?;
        let parts = ["effort", "velocity"].map(|key| {
            let value = self.tree.value(limit, key)?;
            Some(format!("{key} {}", short(value)))
        });
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        if parts.is_empty() {
            return None;
        }
        let what = format!("limits of effort and velocity of joint {}", joint.written);
        self.job.leave_out(what, self.tree.place(limit));
        Some(format!("limits in the file: {}", parts.join(", ")))
    }

    fn limits(&mut self, joint: &Joint, turns: bool) {
        let Some(limit) = self.tree.child(joint.node, "limit") else { return };
        if joint.kind == "continuous" {
            return;
        }
        let [lower, upper] = ["lower", "upper"].map(|key| self.number(limit, key));
        if lower.is_none() && upper.is_none() {
            return;
        }
        let (lower, upper) = (lower.unwrap_or(0.0), upper.unwrap_or(0.0));
        if lower >= upper {
            let what = format!("limits of joint {} that leave no room", joint.written);
            self.job.leave_out(what, self.tree.place(limit));
            return;
        }
        let motion = Motion::only(&joint.name, turns);
        self.draft.add_stop(self.names, motion, [Some(lower), Some(upper)]);
    }

    fn dynamics(&mut self, joint: &Joint, turns: bool) {
        let Some(dynamics) = self.tree.child(joint.node, "dynamics") else { return };
        let damping = self.number(dynamics, "damping").unwrap_or(0.0);
        let friction = self.number(dynamics, "friction").unwrap_or(0.0);
        let motion = Motion::only(&joint.name, turns);
        self.draft.add_spring(self.names, motion, [0.0, 0.0, damping]);
        let place = self.tree.place(dynamics).clone();
        self.draft.add_friction(self.names, motion, friction, &place);
    }

    fn mimic(&mut self, joint: &Joint, joints: &[Joint]) {
        let Some(mimic) = self.tree.child(joint.node, "mimic") else { return };
        if joint.kind == "fixed" {
            let what = format!("mimic of the fixed joint {}", joint.written);
            self.job.leave_out(what, self.tree.place(mimic));
            return;
        }
        let Some((written, place)) = self.required(mimic, "joint") else { return };
        let Some(other) = joints.iter().find(|other| other.written == written) else {
            let message = format!(
                "joint `{}` mimics `{}`, which is not in the file",
                short(&joint.written),
                short(&written)
            );
            let others = joints.iter().filter(|other| other.written != joint.written);
            let help = suggestion(&written, others.map(|other| other.written.as_str()));
            let end = if help.ends_with('?') { "" } else { "." };
            let help = format!("{help}{end} Without it the joint moves by itself");
            self.job.warn(codes::UNKNOWN_NAME, message, (&place, "not a joint of the file"), &help);
            return;
        };
        let (of, by) = (scalar(joint), scalar(other));
        let (Some((of, is_length)), Some((by, by_length))) = (of, by) else {
            let message =
                format!("joint `{}` cannot follow `{}`", short(&joint.written), short(&written));
            let help = "a joint that turns or slides can follow another such joint; the model leaves this out";
            self.job.warn(codes::NOT_MODELLED, message, (&place, "has not one motion"), help);
            return;
        };
        let multiplier = self.number(mimic, "multiplier").unwrap_or(1.0);
        let offset = self.number(mimic, "offset").unwrap_or(0.0);
        let values = [multiplier, offset];
        // All joints that nothing else moves are at zero: the followed one does not give way to the offset.
        if offset != 0.0 && self.tree.child(other.node, "mimic").is_none() {
            let key = if by_length { "position" } else { "angle" };
            let stated = (other.name.clone(), format!("{{ {key} = 0 }}"));
            let is_placed = self.draft.starts.iter().any(|(joint, ..)| *joint == other.name);
            if !is_placed && !self.draft.initial.contains(&stated) {
                self.draft.initial.push(stated);
            }
        }
        self.draft.add_mimic(self.names, &joint.name, [(of, is_length), (by, by_length)], values);
    }
}

/// The one motion of a joint in expressions, and whether it is a length.
fn scalar(joint: &Joint) -> Option<(String, bool)> {
    match joint.kind.as_str() {
        "revolute" | "continuous" => Some((format!("{}.angle", joint.name), false)),
        "prismatic" => Some((format!("{}.position", joint.name), true)),
        _ => None,
    }
}
