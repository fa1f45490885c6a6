//! Tendons: sums of coordinates as relations and loads, and ropes between two points.

use crate::draft::{Table, number, signed};
use crate::job::suggestion;
use crate::spatial::{Pose, norm, sub};
use crate::xml::NodeId;

use super::defaults::ClassId;
use super::equality::{Deviation, deviation, relation};
use super::{FixedTendon, MadeJoint, Reader};

impl FixedTendon {
    /// Length without that in the file's pose; a length where all parts slide.
    fn deviation(&self) -> Option<Deviation> {
        let is_length = self.parts.iter().all(|(joint, _)| joint.kind == "slide");
        self.sum(is_length, deviation).map(|text| Deviation { text, is_length })
    }

    /// Length, or its rate, as a pure number where joints turn and as a length where all slide.
    fn sum(&self, is_length: bool, of: impl Fn(&MadeJoint) -> Option<Deviation>) -> Option<String> {
        let mut text = String::new();
        for (joint, coefficient) in &self.parts {
            let part = of(joint)?;
            let part = if part.is_length && !is_length {
                format!("{}/(1 m)", part.text)
            } else {
                part.text
            };
            let sign = if text.is_empty() {
                number(*coefficient)
            } else {
                format!(" {}", signed(*coefficient))
            };
            text = format!("{text}{sign}*{part}");
        }
        Some(format!("({text})"))
    }
}

/// The rate of a joint's coordinate in expressions.
fn rate(joint: &MadeJoint) -> Option<Deviation> {
    match joint.kind.as_str() {
        "hinge" => Some(Deviation { text: format!("{}.rate", joint.name), is_length: false }),
        "slide" => Some(Deviation { text: format!("{}.velocity", joint.name), is_length: true }),
        _ => None,
    }
}

impl Reader<'_, '_> {
    pub(super) fn all_tendons(&mut self, root: NodeId) {
        for section in self.tree.all(root, "tendon") {
            for node in self.tree.children(section) {
                let class = self.class_of(node, ClassId::MAIN, "class");
                match self.tree.tag(node) {
                    "fixed" => self.fixed(node, class),
                    "spatial" => self.rope(node, class),
                    _ => self.leave_out(node),
                }
            }
        }
    }

    /// Attributes of tendons have their defaults under one word.
    fn tendon_number(&mut self, node: NodeId, class: ClassId, name: &str) -> Vec<f64> {
        let own = self.tree.attribute(node, name);
        let found =
            own.or_else(|| self.defaults.attribute(&self.tree, class, "tendon", name)).cloned();
        let numbers = found
            .and_then(|found| self.job.numbers(&found.value, &found.place, &format!("`{name}`")));
        numbers.unwrap_or_default()
    }

    fn fixed(&mut self, node: NodeId, class: ClassId) {
        let mut parts = Vec::new();
        for child in self.tree.all(node, "joint") {
            let Some(found) = self.tree.attribute(child, "joint").cloned() else { continue };
            let Some(joint) = self.joints.get(&found.value).cloned() else {
                let help = suggestion(&found.value, self.joints.keys().map(String::as_str));
                self.unknown("joint", &found.value, &found.place, &help);
                continue;
            };
            let coefficient = self.number(child, class, "coef").unwrap_or(1.0);
            parts.push((joint, coefficient));
        }
        let tendon = FixedTendon { parts };
        self.tendon_forces(node, class, &tendon);
        for key in ["range", "frictionloss"] {
            let values = self.tendon_number(node, class, key);
            if values.iter().any(|value| *value != 0.0) {
                let what = format!("{key} of {}", self.label(node));
                let place = self.tree.place(node).clone();
                self.job.leave_out(what, &place);
            }
        }
        if let Some(name) = self.tree.value(node, "name") {
            self.tendons.insert(name.to_owned(), tendon);
        }
    }

    /// A spring and damper along a sum of coordinates: its force times each coefficient acts in each joint.
    fn tendon_forces(&mut self, node: NodeId, class: ClassId, tendon: &FixedTendon) {
        let stiffness =
            self.tendon_number(node, class, "stiffness").first().copied().unwrap_or(0.0);
        let damping = self.tendon_number(node, class, "damping").first().copied().unwrap_or(0.0);
        if stiffness == 0.0 && damping == 0.0 {
            return;
        }
        let rest = self.tendon_number(node, class, "springlength");
        let at_start: f64 = tendon.parts.iter().map(|(joint, c)| c * joint.reference).sum();
        let rest = rest.first().copied().filter(|rest| *rest >= 0.0).unwrap_or(at_start);
        let (Some(stretch), Some(speed)) = (tendon.sum(false, deviation), tendon.sum(false, rate))
        else {
            return self.leave_out(node);
        };
        let mut force = String::new();
        if stiffness != 0.0 {
            let offset = at_start - rest;
            let offset = if offset == 0.0 { String::new() } else { format!(" {}", signed(offset)) };
            force = format!("{}*({stretch}{offset})", number(stiffness));
        }
        if damping != 0.0 {
            // Rates of joints that turn and slide are added as numbers.
            let speed = format!("{}*{speed}", number(damping));
            force = if force.is_empty() { speed } else { format!("{force} + {speed}*(1 s)") };
        }
        let label = self.tree.value(node, "name").unwrap_or("tendon").to_owned();
        for (joint, coefficient) in &tendon.parts {
            self.joint_load(&label, joint, &format!("{}*({force})", number(-coefficient)), "");
        }
    }

    /// A force or torque in a joint.
    pub(super) fn joint_load(&mut self, label: &str, joint: &MadeJoint, value: &str, note: &str) {
        let kind = if joint.kind == "hinge" { "torque" } else { "force" };
        let name = self.names.coin(&format!("{label}_{}", joint.name));
        let mut table = Table::new(name, kind).text("joint", &joint.name).text("value", value);
        if !note.is_empty() {
            table = table.note(note);
        }
        self.draft.loads.push(table);
    }

    /// A tendon between two sites is a rope or a spring; those with more on their way are left out.
    fn rope(&mut self, node: NodeId, class: ClassId) {
        let parts = self.tree.children(node);
        let sites: Vec<_> = parts
            .iter()
            .filter_map(|&part| {
                let name =
                    self.tree.value(part, "site").filter(|_| self.tree.tag(part) == "site")?;
                self.sites.get(name).copied()
            })
            .collect();
        let ([first, second], 2) = (sites.as_slice(), parts.len()) else {
            return self.leave_out(node);
        };
        if first.0 == second.0 {
            return self.leave_out(node);
        }
        let written = self.tree.value(node, "name").unwrap_or("tendon").to_owned();
        let name = self.names.take("joint", &written);
        let ends =
            [first, second].map(|(body, pose)| self.draft.frame(*body, &name, Pose::at(pose.at)));
        let range = self.tendon_number(node, class, "range");
        if let [least, most] = range[..] {
            let mut table = Table::new(name.clone(), "distance").between(&ends[0], &ends[1]);
            if least > 0.0 {
                table = table.number("min", least);
            }
            self.draft
                .joints
                .push(table.number("max", most).note("a rope: hard here, soft in MuJoCo"));
        }
        let stiffness =
            self.tendon_number(node, class, "stiffness").first().copied().unwrap_or(0.0);
        let damping = self.tendon_number(node, class, "damping").first().copied().unwrap_or(0.0);
        if stiffness == 0.0 && damping == 0.0 {
            if range.len() != 2 {
                self.leave_out(node);
            }
            return;
        }
        let world = |reader: &Self, (body, pose): &(Option<usize>, Pose)| {
            let of = reader.bodies.values().find(|made| Some(made.body) == *body);
            of.map_or(Pose::NONE, |made| made.world).apply(pose.at)
        };
        let at_start = norm(sub(world(self, first), world(self, second)));
        let rest = self.tendon_number(node, class, "springlength");
        let rest = rest.first().copied().filter(|rest| *rest >= 0.0).unwrap_or(at_start);
        let load = self.names.coin(&format!("{name}_spring"));
        let kind = if stiffness == 0.0 { "damper" } else { "spring" };
        let mut table = Table::new(load, kind).between(&ends[0], &ends[1]);
        if stiffness != 0.0 {
            table = table.number("stiffness", stiffness).number("length", rest);
        }
        if damping != 0.0 {
            table = table.number("damping", damping);
        }
        self.draft.loads.push(table);
    }

    /// Equality of tendons that are sums of coordinates.
    pub(super) fn tendon_equality(&mut self, node: NodeId, class: ClassId) {
        let mut sums = Vec::new();
        for key in ["tendon1", "tendon2"] {
            let Some(found) = self.tree.attribute(node, key).cloned() else { continue };
            let sum = self.tendons.get(&found.value).and_then(FixedTendon::deviation);
            let Some(sum) = sum else { return self.leave_out(node) };
            sums.push(sum);
        }
        let Some(y) = sums.first() else { return self.leave_out(node) };
        let coefficients = self.numbers(node, class, "polycoef").unwrap_or_else(|| vec![0.0, 1.0]);
        let text = relation(y, sums.get(1), &coefficients);
        let written = self.tree.value(node, "name").map(str::to_owned);
        self.add_relation(written, "tendon_equality", &text);
    }
}
