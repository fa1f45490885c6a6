//! Joints of bodies: where they are, what moves in them, what acts in them.

use crate::codes;
use crate::draft::{Body, Table, list, number};
use crate::job::short;
use crate::loads::Motion;
use crate::spatial::{Inertia, Pose, Rotation, Vector, add, scale, unit};

use super::bodies::Item;
use super::defaults::ClassId;
use super::{MadeJoint, Reader};

impl Reader<'_, '_> {
    /// Adds a body with its joints to a parent, in which its frame is at `pose`; returns the body.
    pub(super) fn joints_of(
        &mut self,
        name: &str,
        joints: &[&Item],
        parent: Option<usize>,
        pose: Pose,
    ) -> usize {
        if joints.is_empty() {
            let body = self.add_body(name);
            let first = self.draft.frame(parent, name, pose);
            let joint = self.names.coin(&format!("{name}_fixed"));
            self.draft.joints.push(Table::new(joint, "weld").between(&first, name));
            return body;
        }
        let mut from = parent;
        let mut at = pose;
        for (idx, item) in joints.iter().enumerate() {
            let class = self.class_of(item.node, item.class, "class");
            let is_free = self.tree.tag(item.node) == "freejoint";
            let kind = if is_free {
                "free".to_owned()
            } else {
                self.word(item.node, class, "type").unwrap_or_else(|| "hinge".to_owned())
            };
            let written = self.tree.value(item.node, "name").map(str::to_owned);
            let joint = match &written {
                Some(written) => self.names.take("joint", written),
                None => self.names.coin(&format!("{name}_{kind}")),
            };
            let to = if idx + 1 < joints.len() {
                self.massless(name, &joint)
            } else {
                self.add_body(name)
            };
            let reference = self.number(item.node, class, "ref").unwrap_or(0.0);
            let reference = if kind == "hinge" { self.radians(reference) } else { reference };
            let made = MadeJoint { name: joint, kind, reference };
            self.joint(item, class, &made, ([from, Some(to)], at));
            if let Some(written) = written {
                self.joints.insert(written, made);
            }
            from = Some(to);
            at = Pose::NONE;
        }
        from.unwrap_or_default()
    }

    fn add_body(&mut self, name: &str) -> usize {
        self.draft.bodies.push(Body::new(name.to_owned(), Inertia::default()));
        self.draft.bodies.len() - 1
    }

    /// One joint between two bodies of the draft; the second has its frame at `at` in the first.
    fn joint(
        &mut self,
        item: &Item,
        class: ClassId,
        made: &MadeJoint,
        ([from, to], at): ([Option<usize>; 2], Pose),
    ) {
        let point = self.vector(item.node, class, "pos").unwrap_or([0.0; 3]);
        let point = item.frame.apply(point);
        let axis = item.frame.turn.apply(self.axis(item, class));
        let name = made.name.clone();
        let (kind, first) = match made.kind.as_str() {
            "hinge" => {
                let turn = Rotation::about(unit(axis).unwrap_or([0.0, 0.0, 1.0]), -made.reference);
                ("revolute", at.then(Pose { at: point, turn }))
            }
            "slide" => {
                let back = scale(-made.reference, unit(axis).unwrap_or([0.0, 0.0, 1.0]));
                ("prismatic", at.then(Pose::at(add(point, back))))
            }
            "ball" => ("spherical", at.then(Pose::at(point))),
            "free" => ("free", Pose::NONE),
            other => {
                let place = self.tree.place(item.node).clone();
                let help =
                    crate::job::suggestion(other, ["hinge", "slide", "ball", "free"].into_iter());
                let message =
                    format!("joint `{}` has the unknown type `{}`", short(&name), short(other));
                self.job.error(codes::UNKNOWN_WORD, message, (&place, ""), &help);
                return;
            }
        };
        let first = self.draft.frame(from, &name, first);
        let second = if kind == "free" { Pose::NONE } else { Pose::at(point) };
        let second = self.draft.frame(to, &name, second);
        let mut table = Table::new(name.clone(), kind).between(&first, &second);
        if matches!(kind, "revolute" | "prismatic") {
            table = table.vector("axis", axis);
        }
        let armature = self.number(item.node, class, "armature").unwrap_or(0.0);
        if armature != 0.0 && matches!(kind, "revolute" | "prismatic") {
            table = table.number("armature", armature);
        }
        self.draft.joints.push(table);
        // The file has its bodies where the joint is at `ref`, and its motion starts there.
        let word = match kind {
            "revolute" => Some("angle"),
            "prismatic" => Some("position"),
            _ => None,
        };
        if let Some(word) = word.filter(|_| made.reference != 0.0) {
            self.draft.starts.push((name.clone(), word.to_owned(), [made.reference; 2]));
        }
        match kind {
            "free" => self.start_of(&name, at),
            "spherical" => self.ball_damping(item, class, [from, to]),
            _ => self.forces(item, class, made),
        }
        if armature != 0.0 && matches!(kind, "free" | "spherical") {
            let place = self.tree.place(item.node).clone();
            self.job.leave_out(format!("armature of joint {name}"), &place);
        }
    }

    fn axis(&mut self, item: &Item, class: ClassId) -> Vector {
        let axis = self.vector(item.node, class, "axis").unwrap_or([0.0, 0.0, 1.0]);
        let kind = self.word(item.node, class, "type").unwrap_or_else(|| "hinge".to_owned());
        if unit(axis).is_none() && matches!(kind.as_str(), "hinge" | "slide") {
            let place = self.tree.place(item.node).clone();
            let help = "write for example `axis=\"0 0 1\"`";
            self.job.error(
                codes::NOT_A_NUMBER,
                "an axis has no direction".to_owned(),
                (&place, ""),
                help,
            );
            return [0.0, 0.0, 1.0];
        }
        axis
    }

    /// A free body starts where the file has it.
    fn start_of(&mut self, name: &str, at: Pose) {
        let [x, y, z] = at.at.map(number);
        let place = format!("position1 = {x}, position2 = {y}, position3 = {z}");
        self.draft.initial.push((name.to_owned(), format!("{{ {place} }}")));
        let body = self.draft.bodies.last().map(|body| body.name.clone()).unwrap_or_default();
        let turn = list(&at.turn.0);
        self.draft.initial.push((body, format!("{{ quaternion = {turn} }}")));
    }

    /// Springs, dampers, friction and limits of a hinge or slide.
    fn forces(&mut self, item: &Item, class: ClassId, made: &MadeJoint) {
        let turns = made.kind == "hinge";
        let angle = |reader: &Self, value: f64| if turns { reader.radians(value) } else { value };
        let stiffness = self.number(item.node, class, "stiffness").unwrap_or(0.0);
        let damping = self.number(item.node, class, "damping").unwrap_or(0.0);
        let rest = self.number(item.node, class, "springref").unwrap_or(0.0);
        let rest = angle(self, rest);
        let friction = self.number(item.node, class, "frictionloss").unwrap_or(0.0);
        let motion = Motion::only(&made.name, turns);
        self.draft.add_spring(self.names, motion, [stiffness, rest, damping]);
        let place = self.tree.place(item.node).clone();
        self.draft.add_friction(self.names, motion, friction, &place);
        for key in ["springdamper", "actuatorfrcrange"] {
            if self.attribute(item.node, class, key).is_some() {
                self.job.leave_out(format!("{key} of joint {}", made.name), &place);
            }
        }
        let limits =
            self.limits(item, class).map(|limits| limits.map(|limit| Some(angle(self, limit))));
        if let Some(limits) = limits {
            self.draft.add_stop(self.names, motion, limits);
        }
    }

    /// The range of a joint that is limited.
    fn limits(&mut self, item: &Item, class: ClassId) -> Option<[f64; 2]> {
        let range = self.numbers(item.node, class, "range");
        let range: Option<[f64; 2]> = range.and_then(|range| range.try_into().ok());
        let is_limited = match self.word(item.node, class, "limited").as_deref() {
            Some("true") => true,
            Some("false") => false,
            _ => self.compiler.has_auto_limits && range.is_some(),
        };
        let range = range.filter(|_| is_limited)?;
        if range[0] < range[1] {
            return Some(range);
        }
        let what = format!("limits of {} that leave no room", self.label(item.node));
        let place = self.tree.place(item.node).clone();
        self.job.leave_out(what, &place);
        None
    }

    /// Damping of a ball joint by the angular velocity of one body against the other.
    fn ball_damping(&mut self, item: &Item, class: ClassId, [from, to]: [Option<usize>; 2]) {
        for key in ["stiffness", "frictionloss"] {
            if self.number(item.node, class, key).is_some_and(|value| value != 0.0) {
                let what = format!("{key} of {}", self.label(item.node));
                let place = self.tree.place(item.node).clone();
                self.job.leave_out(what, &place);
            }
        }
        if self.limits(item, class).is_some() {
            let what = format!("limit of {}", self.label(item.node));
            let place = self.tree.place(item.node).clone();
            self.job.leave_out(what, &place);
        }
        let damping = self.number(item.node, class, "damping").unwrap_or(0.0);
        let Some(to) = to.filter(|_| damping != 0.0) else { return };
        let body = self.draft.bodies[to].name.clone();
        let parent = from.map(|from| self.draft.bodies[from].name.clone());
        let rate = |axis: &str| match &parent {
            Some(parent) => format!("\"{}*({body}.{axis} - {parent}.{axis})\"", number(-damping)),
            None => format!("\"{}*{body}.{axis}\"", number(-damping)),
        };
        let parts = ["wx", "wy", "wz"].map(rate).join(", ");
        let name = self.names.coin(&format!("{body}_damping"));
        let mut table = Table::new(name, "torque").text("on", &body);
        if let Some(parent) = &parent {
            table = table.text("from", parent);
        }
        self.draft.loads.push(table.key("vector", format!("[{parts}]")));
    }
}
