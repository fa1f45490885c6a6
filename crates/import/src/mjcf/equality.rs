//! Equalities as joints that close loops, and as relations.

use crate::codes;
use crate::draft::{Table, number, signed};
use crate::job::{Place, short, suggestion};
use crate::spatial::{Pose, Rotation};
use crate::xml::NodeId;

use super::defaults::ClassId;
use super::{MadeBody, MadeJoint, Reader};

/// A coordinate, or a sum of several, as it is compared: minus its value in the file's pose.
pub(super) struct Deviation {
    pub(super) text: String,
    pub(super) is_length: bool,
}

/// A joint's coordinate without its value in the file's pose.
pub(super) fn deviation(joint: &MadeJoint) -> Option<Deviation> {
    let (word, is_length) = match joint.kind.as_str() {
        "hinge" => ("angle", false),
        "slide" => ("position", true),
        _ => return None,
    };
    let text = match joint.reference {
        0.0 => format!("{}.{word}", joint.name),
        reference => {
            let unit = if is_length { " m" } else { "" };
            format!("({}.{word} {}{unit})", joint.name, signed(-reference))
        }
    };
    Some(Deviation { text, is_length })
}

/// `c0 + c1*x + …` of a pure number `x`.
fn polynomial(coefficients: &[f64], x: &str) -> String {
    let mut text = String::new();
    for (power, &c) in coefficients.iter().enumerate() {
        if c == 0.0 {
            continue;
        }
        let factor = match (power, c.abs() == 1.0) {
            (0, _) => number(c.abs()),
            (1, true) => x.to_owned(),
            (1, false) => format!("{}*{x}", number(c.abs())),
            (_, true) => format!("{x}^{power}"),
            (_, false) => format!("{}*{x}^{power}", number(c.abs())),
        };
        text = match (text.is_empty(), c < 0.0) {
            (true, false) => factor,
            (true, true) => format!("-{factor}"),
            (false, false) => format!("{text} + {factor}"),
            (false, true) => format!("{text} - {factor}"),
        };
    }
    if text.is_empty() { "0".to_owned() } else { text }
}

/// The relation y = c(x).
pub(super) fn relation(y: &Deviation, x: Option<&Deviation>, coefficients: &[f64]) -> String {
    let pure = x.map(|x| if x.is_length { format!("({}/(1 m))", x.text) } else { x.text.clone() });
    let sum = match &pure {
        Some(x) => polynomial(coefficients, x),
        None => polynomial(&coefficients[..1.min(coefficients.len())], ""),
    };
    match (sum.as_str(), y.is_length) {
        ("0", _) => y.text.clone(),
        (sum, true) => format!("{} - 1 m*({sum})", y.text),
        (sum, false) => format!("{} - ({sum})", y.text),
    }
}

impl Reader<'_, '_> {
    pub(super) fn all_equalities(&mut self, root: NodeId) {
        for section in self.tree.all(root, "equality") {
            for node in self.tree.children(section) {
                let class = self.class_of(node, ClassId::MAIN, "class");
                if self.word(node, class, "active").as_deref() == Some("false") {
                    let what = format!("inactive {}", self.label(node));
                    let place = self.tree.place(node).clone();
                    self.job.leave_out(what, &place);
                    continue;
                }
                match self.tree.tag(node) {
                    "connect" => self.closing(node, class, "spherical"),
                    "weld" => self.closing(node, class, "weld"),
                    "joint" => self.joint_equality(node, class),
                    "tendon" => self.tendon_equality(node, class),
                    _ => self.leave_out(node),
                }
            }
        }
    }

    /// The body that an attribute names; the world where there is none.
    #[expect(clippy::option_option, reason = "a name that is wrong, none, or one of a body")]
    fn body_named(&mut self, node: NodeId, key: &str) -> Option<Option<MadeBody>> {
        let Some(found) = self.tree.attribute(node, key).cloned() else { return Some(None) };
        if found.value == "world" {
            return Some(None);
        }
        if let Some(body) = self.bodies.get(&found.value) {
            return Some(Some(body.clone()));
        }
        let names = self.bodies.keys().map(String::as_str);
        let help = suggestion(&found.value, names);
        self.unknown("body", &found.value, &found.place, &help);
        None
    }

    pub(super) fn unknown(&mut self, what: &str, name: &str, place: &Place, help: &str) {
        let message = format!("no {what} is called `{}`", short(name));
        self.job.error(codes::UNKNOWN_NAME, message, (place, ""), help);
    }

    /// The sites of an equality, as bodies with poses on them.
    fn sites_of(&mut self, node: NodeId) -> Option<[(Option<usize>, Pose); 2]> {
        let mut ends = [(None, Pose::NONE); 2];
        for (end, key) in ends.iter_mut().zip(["site1", "site2"]) {
            let found = self.tree.attribute(node, key).cloned()?;
            let Some(site) = self.sites.get(&found.value) else {
                let help = suggestion(&found.value, self.sites.keys().map(String::as_str));
                self.unknown("site", &found.value, &found.place, &help);
                return None;
            };
            *end = *site;
        }
        Some(ends)
    }

    /// A joint that closes a loop.
    fn closing(&mut self, node: NodeId, class: ClassId, kind: &str) {
        let has_sites = self.tree.attribute(node, "site1").is_some();
        let ends =
            if has_sites { self.sites_of(node) } else { self.ends_by_bodies(node, class, kind) };
        let Some([(first, first_at), (second, second_at)]) = ends else { return };
        let called = |reader: &Self, body: Option<usize>| {
            body.map_or("world".to_owned(), |body| reader.draft.bodies[body].name.clone())
        };
        let name = if let Some(name) = self.tree.value(node, "name").map(str::to_owned) {
            self.names.take("joint", &name)
        } else {
            let tag = self.tree.tag(node);
            let name = format!("{tag}_{}_{}", called(self, first), called(self, second));
            self.names.coin(&name)
        };
        if first == second {
            let what = format!("{} of a body with itself", self.label(node));
            let place = self.tree.place(node).clone();
            self.job.leave_out(what, &place);
            return;
        }
        let first = self.draft.frame(first, &name, first_at);
        let second = self.draft.frame(second, &name, second_at);
        let table = Table::new(name, kind).between(&first, &second).key("cut", "true");
        self.draft.joints.push(table.note("closes a loop: exact here, soft in MuJoCo"));
    }

    /// The frames that an equality of two bodies holds together: where the file has them.
    fn ends_by_bodies(
        &mut self,
        node: NodeId,
        class: ClassId,
        kind: &str,
    ) -> Option<[(Option<usize>, Pose); 2]> {
        let [first, second] = ["body1", "body2"].map(|key| self.body_named(node, key));
        let (first, second) = (first?, second?);
        let world = |body: &Option<MadeBody>| body.as_ref().map_or(Pose::NONE, |body| body.world);
        let second_in_first = world(&first).inverse().then(world(&second));
        let id = |body: &Option<MadeBody>| body.as_ref().map(|body| body.body);
        if kind == "spherical" {
            let anchor = self.vector(node, class, "anchor").unwrap_or([0.0; 3]);
            let at = second_in_first.inverse().apply(anchor);
            return Some([(id(&first), Pose::at(anchor)), (id(&second), Pose::at(at))]);
        }
        // A weld: the pose of the second body in the first one, by the file's pose unless stated.
        let stated = self.numbers(node, class, "relpose").unwrap_or_default();
        let relative = match stated[..] {
            [x, y, z, w, i, j, k] => {
                Rotation::of_quaternion([w, i, j, k]).map(|turn| Pose { at: [x, y, z], turn })
            }
            _ => None,
        };
        let relative = relative.unwrap_or(second_in_first);
        Some([(id(&first), relative), (id(&second), Pose::NONE)])
    }

    #[expect(clippy::option_option, reason = "a name that is wrong, none, or one of a joint")]
    fn joint_named(&mut self, node: NodeId, key: &str) -> Option<Option<MadeJoint>> {
        let Some(found) = self.tree.attribute(node, key).cloned() else { return Some(None) };
        if let Some(joint) = self.joints.get(&found.value) {
            return Some(Some(joint.clone()));
        }
        let help = suggestion(&found.value, self.joints.keys().map(String::as_str));
        self.unknown("joint", &found.value, &found.place, &help);
        None
    }

    fn joint_equality(&mut self, node: NodeId, class: ClassId) {
        let (Some(first), Some(second)) =
            (self.joint_named(node, "joint1"), self.joint_named(node, "joint2"))
        else {
            return;
        };
        let Some(first) = first else { return self.leave_out(node) };
        let y = deviation(&first);
        let x = second.as_ref().map(deviation);
        let (Some(y), None | Some(Some(_))) = (y, &x) else { return self.leave_out(node) };
        let coefficients = self.numbers(node, class, "polycoef").unwrap_or_else(|| vec![0.0, 1.0]);
        let text = relation(&y, x.flatten().as_ref(), &coefficients);
        let written = self.tree.value(node, "name").map(str::to_owned);
        self.add_relation(written, &format!("{}_equality", first.name), &text);
    }

    pub(super) fn add_relation(&mut self, written: Option<String>, coined: &str, text: &str) {
        let name = match written {
            Some(written) => self.names.take("coupling", &written),
            None => self.names.coin(coined),
        };
        self.draft.couplings.push(Table::new(name, "relation").text("relation", text));
    }
}
