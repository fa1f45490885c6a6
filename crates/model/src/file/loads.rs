//! `[loads.…]` and `[drives.…]`: what acts on the mechanism, and what motion is prescribed.

use bksim_expr::Expr;

use super::codes;
use super::friction::Connections;
use super::names::{JointName, quantities};
use super::reader::{Fields, Reader};
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::Scope;
use super::words::cut;
use crate::diagnostic::{Diagnostic, Span};
use crate::drive::Drive;
use crate::ids::{BodyId, GROUND, JointId, Vector};
use crate::joint::{MotionKind, motion_words};
use crate::load::{Load, LoadKind};

/// The types of load and their keys.
pub(super) const LOADS: [(&str, &[&str]); 8] = [
    ("gravity", &["type", "acceleration"]),
    ("force", &["type", "on", "vector", "axes", "between", "joint", "of", "value"]),
    ("torque", &["type", "on", "from", "joint", "of", "value", "vector"]),
    ("spring", &["type", "between", "joint", "of", "stiffness", "length", "damping"]),
    ("damper", &["type", "between", "joint", "of", "damping"]),
    ("torsion", &["type", "joint", "of", "stiffness", "angle", "damping"]),
    ("stop", &["type", "joint", "of", "min", "max", "restitution"]),
    (
        "friction",
        &[
            "type",
            "joint",
            "of",
            "force",
            "torque",
            "mu",
            "static",
            "radius",
            "length",
            "coupling",
            "pressure_angle",
            "loss",
            "flank_angle",
            "collar_mu",
            "collar_radius",
        ],
    ),
];

/// Keys of a drive; `between` is answered with the joint that it needs.
pub(super) const DRIVE_KEYS: [&str; 3] = ["joint", "motion", "of"];

impl Reader<'_> {
    /// Reads all loads, in file order.
    pub(super) fn read_loads(&mut self, root: &Table, connections: &Connections<'_>) -> Vec<Load> {
        let mut loads = Vec::new();
        for (name, span, table) in self.own_tables(root, "load") {
            self.usable_name(name, &span, "load");
            loads.extend(self.read_load((name, span), table, connections));
        }
        self.read_joint_limits(root, &mut loads);
        loads
    }

    fn read_load(
        &mut self,
        (name, span): (&str, Span),
        table: &Table,
        connections: &Connections<'_>,
    ) -> Option<Load> {
        let owner = format!("load `{name}`");
        let (word, fields) = Fields::of_type(self, table, owner, span, &LOADS)?;
        let kind = match word {
            "gravity" => {
                let help = "write for example `acceleration = [0, \"-9.81 m/s^2\"]`";
                let node = fields.require(self, "acceleration", help)?;
                let what = fields.what("acceleration");
                let vector = self.vector(node, Quantity::ACCELERATION, &what, Scope::Motion)?;
                self.check_gravity(&what, &vector);
                LoadKind::Gravity { acceleration: vector.components }
            }
            "force" => self.read_force(&fields)?,
            "torque" => self.read_torque(&fields)?,
            "torsion" => self.read_torsion(&fields)?,
            "stop" => self.read_stop(&fields)?,
            "friction" => {
                let (joint, motion_idx, law) = self.read_friction(&fields, connections)?;
                LoadKind::Friction { joint, motion_idx, law }
            }
            _ => self.read_spring(word, &fields)?,
        };
        let keys = [
            "value",
            "vector",
            "acceleration",
            "stiffness",
            "damping",
            "force",
            "joint",
            "coupling",
        ];
        Some(Load { name: name.to_owned(), kind, span: fields.location(&keys) })
    }

    fn load_vector(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        quantity: Quantity,
        help: &str,
    ) -> Option<Vector> {
        let node = fields.require(self, key, help)?;
        Some(self.vector(node, quantity, &fields.what(key), Scope::Load)?.components)
    }

    /// The value of a key that may change with the motion.
    fn load_scalar(&mut self, fields: &Fields<'_>, key: &str, quantity: Quantity) -> Option<Expr> {
        let help = format!("write for example `{key} = \"{}\"`", quantity.example);
        let node = fields.require(self, key, &help)?;
        Some(self.scalar(node, quantity, &fields.what(key), Scope::Load)?.expr)
    }

    /// Load ([`Self::load_scalar`]) with a default of zero.
    pub(super) fn load_or_zero(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        quantity: Quantity,
    ) -> Option<Expr> {
        if fields.has(key) {
            self.load_scalar(fields, key, quantity)
        } else {
            Some(self.pool.zero())
        }
    }

    fn read_force(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let ways = [
            ("on", "between"),
            ("vector", "between"),
            ("on", "joint"),
            ("vector", "joint"),
            ("between", "joint"),
        ];
        if ways.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        if fields.has("joint") {
            return self.read_effort(fields, MotionKind::Translation);
        }
        if fields.has("between") {
            let ends = self.between(fields);
            let value = self.load_scalar(fields, "value", Quantity::FORCE);
            let [a, b] = ends?;
            return Some(LoadKind::ForceBetween { a, b, value: value? });
        }
        let help = "write `on = \"body.point\"`, or `between` with two points";
        let on = fields.require(self, "on", help);
        let on = on.and_then(|node| self.anchor(node, &fields.what("on"), &fields.owner));
        let axes = fields.get("axes").map(|node| {
            self.choice(node, &fields.what("axes"), &[("world", false), ("body", true)])
        });
        let help = "write for example `vector = [\"20 N\", 0]`";
        let vector = self.load_vector(fields, "vector", Quantity::FORCE, help);
        if on.is_some_and(|on| on.body == GROUND) {
            self.without_effect(fields, "on", "the ground does not move", "let it act on a body");
        }
        Some(LoadKind::Force {
            on: on?,
            vector: vector?,
            follows_body: axes.unwrap_or(Some(false))?,
        })
    }

    /// A force or torque in one motion of a joint.
    fn read_effort(&mut self, fields: &Fields<'_>, motion: MotionKind) -> Option<LoadKind> {
        let quantity = match motion {
            MotionKind::Translation => Quantity::FORCE,
            MotionKind::Rotation => Quantity::TORQUE,
        };
        let target = self.motion_of_kind(fields, motion);
        let value = self.load_scalar(fields, "value", quantity);
        let (joint, motion_idx) = target?;
        Some(LoadKind::Effort { joint, motion_idx, value: value? })
    }

    /// True where `joint` names one that turns about an axis of its own.
    fn names_turning_joint(&self, fields: &Fields<'_>) -> bool {
        let Some(Value::Text(name)) = fields.get("joint").map(|node| &node.value) else {
            return false;
        };
        let freedoms = self.names.joint(name).and_then(|joint| self.names.joints[joint.0].freedoms);
        freedoms.is_some_and(|freedoms| freedoms.contains(&MotionKind::Rotation))
    }

    fn read_torque(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        if ["on", "from"].iter().any(|key| fields.conflict(self, "joint", key)) {
            return None;
        }
        if fields.has("joint") && !fields.has("vector") && self.names_turning_joint(fields) {
            return self.read_effort(fields, MotionKind::Rotation);
        }
        let (on, from) = if fields.has("joint") {
            let node = fields.get("joint")?;
            let joint = self.joint_named(node, fields);
            // A joint that could not be read was reported there.
            let ends = joint.and_then(|joint| self.joint_bodies.get(joint.0).copied().flatten());
            (ends.map(|[_, on]| on), ends.map(|[from, _]| from))
        } else {
            let help = "write `on = \"body\"`, or `joint` for a torque between its bodies";
            let on = fields.require(self, "on", help);
            let on = on.and_then(|node| self.body_named(node, "on", fields));
            let from = match fields.get("from") {
                Some(node) => self.body_named(node, "from", fields),
                None => Some(GROUND),
            };
            (on, from)
        };
        if fields.conflict(self, "value", "vector") {
            return None;
        }
        let vector = if fields.has("vector") {
            self.load_vector(fields, "vector", Quantity::TORQUE, "")
        } else {
            let value = self.load_scalar(fields, "value", Quantity::TORQUE);
            value.map(|value| [self.pool.zero(), self.pool.zero(), value])
        };
        if let (Some(on), Some(from), false) = (on, from, fields.has("joint"))
            && on == from
        {
            let label =
                if on == GROUND { "the ground does not move" } else { "the same as `from`" };
            self.without_effect(fields, "on", label, "let it act on a body, or between two");
        }
        Some(LoadKind::Torque { on: on?, from: from?, vector: vector? })
    }

    fn body_named(&mut self, node: &Node, key: &str, fields: &Fields<'_>) -> Option<BodyId> {
        Some(self.anchor(node, &fields.what(key), &fields.owner)?.body)
    }

    /// The joint that a text names.
    pub(super) fn joint_named(&mut self, node: &Node, fields: &Fields<'_>) -> Option<JointId> {
        let quoted = self.text_of(node, &fields.what("joint"), "A")?;
        let found = self.names.joint(quoted.text);
        if found.is_none() {
            let names = self.owned_names(|names| names.joint_names());
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let location = quoted.span_of(&(0..quoted.text.len()));
            let message =
                format!("{} refers to unknown joint `{}`", fields.owner, cut(quoted.text));
            let label = (location, "no joint has this name");
            self.unknown(codes::UNKNOWN_JOINT, message, label, (quoted.text, &names));
        }
        found
    }

    /// The motion of one sort of a joint that `joint` and `of` name.
    pub(super) fn motion_of_kind(
        &mut self,
        fields: &Fields<'_>,
        motion: MotionKind,
    ) -> Option<(JointId, usize)> {
        let (word, sort) = match motion {
            MotionKind::Translation => ("position", "slides"),
            MotionKind::Rotation => ("angle", "turns"),
        };
        let help = format!("write `joint = \"A\"` with the name of a joint that {sort}");
        let node = fields.require(self, "joint", &help)?;
        let joint = self.joint_named(node, fields)?;
        let freedoms = self.names.joints[joint.0].freedoms?;
        let mut same = (0..freedoms.len()).filter(|&idx| freedoms[idx] == motion);
        if let (Some(idx), None, false) = (same.next(), same.next(), fields.has("of")) {
            return Some((joint, idx));
        }
        if !freedoms.contains(&motion) {
            self.no_such_motion(joint, word, node, fields);
            return None;
        }
        let (_, idx, _) = self.motion_of(fields, &help)?;
        if freedoms[idx] != motion {
            self.no_such_motion(joint, word, node, fields);
            return None;
        }
        Some((joint, idx))
    }

    /// The position of a freedom among those of a joint; reports a joint without it. A joint whose
    /// type could not be read was reported before.
    fn freedom_of(
        &mut self,
        joint: JointId,
        wanted: &str,
        node: &Node,
        fields: &Fields<'_>,
    ) -> Option<usize> {
        let freedoms = self.names.joints[joint.0].freedoms?;
        let found = (0..freedoms.len()).position(|idx| motion_words(freedoms, idx)[0] == wanted);
        if found.is_none() {
            self.no_such_motion(joint, wanted, node, fields);
        }
        found
    }

    pub(super) fn no_such_motion(
        &mut self,
        joint: JointId,
        word: &str,
        node: &Node,
        fields: &Fields<'_>,
    ) {
        let name = self.names.joints[joint.0].name.clone();
        let message =
            format!("{} needs the {word} of joint `{name}`, which has none", fields.owner);
        let able: Vec<&str> = self
            .names
            .joints
            .iter()
            .filter(|joint| {
                let freedoms = joint.freedoms.unwrap_or_default();
                (0..freedoms.len())
                    .any(|idx| word == "motion" || motion_words(freedoms, idx)[0] == word)
            })
            .map(|joint| joint.name.as_str())
            .collect();
        // Springs, dampers and forces that lack `of` have other names where a joint turns.
        let turns = self.names.joints[joint.0].freedoms.is_some_and(|freedoms| {
            (0..freedoms.len()).any(|idx| motion_words(freedoms, idx)[0] == "angle")
        }) && !fields.has("of");
        let help = match able.as_slice() {
            _ if word == "position" && turns && fields.owner.starts_with("load") => {
                "a joint that turns has `type = \"torsion\"`, with `stiffness` and `damping`, or `type = \"torque\"`"
                    .to_owned()
            }
            [] => "add a joint that has one, for example of type \"revolute\"".to_owned(),
            names => format!("joints that have one: `{}`", names.join("`, `")),
        };
        self.report(
            Diagnostic::error(codes::WRONG_JOINT, message)
                .at(node.span.clone(), "this joint")
                .help(help),
        );
    }

    /// Reads all drives, in file order, and refuses two of one motion.
    pub(super) fn read_drives(&mut self, root: &Table) -> Vec<Drive> {
        let mut drives: Vec<Drive> = Vec::new();
        let mut taken: Vec<(JointId, usize, Span, &str)> = Vec::new();
        // No key of a drive, but answered with the joint that it needs.
        let known = [DRIVE_KEYS.as_slice(), &["between"]].concat();
        for (name, span, table) in self.own_tables(root, "drive") {
            self.usable_name(name, &span, "drive");
            let fields = Fields::open(self, table, format!("drive `{name}`"), span.clone(), &known);
            if let Some(entry) = fields.entry("between") {
                self.drive_of_points(name, &fields, entry.key_span.clone());
                continue;
            }
            let help = "write `joint = \"A\"` with the name of the driven joint";
            let target = self.motion_of(&fields, help);
            // A motion follows one drive only.
            if let Some((joint, motion_idx, location)) = target.clone() {
                let same = |of: &&(JointId, usize, Span, &str)| (of.0, of.1) == (joint, motion_idx);
                if let Some((_, _, first, other)) = taken.iter().find(same).cloned() {
                    let JointName { name: joint_name, freedoms, .. } = &self.names.joints[joint.0];
                    let [word, ..] = motion_words(freedoms.unwrap_or_default(), motion_idx);
                    let message =
                        format!("drives `{other}` and `{name}` both drive `{joint_name}.{word}`");
                    self.report(
                        Diagnostic::error(codes::TWO_DRIVES, message)
                            .at(location.clone(), "driven again here")
                            .at(first, "first driven here")
                            .note("one degree of freedom can follow one drive only")
                            .help(format!(
                                "remove `[drives.{name}]` or `[drives.{other}]`, or let one drive another joint"
                            )),
                    );
                }
                taken.push((joint, motion_idx, location, name));
            }
            // The motion as a function of time, in the quantity of the joint.
            let quantity = target.as_ref().map_or(Quantity::ANGLE, |(joint, idx, _)| {
                let freedoms = self.names.joints[joint.0].freedoms.unwrap_or_default();
                quantities(freedoms[*idx])[0]
            });
            let help = "write for example `motion = \"2 rad/s * t\"`";
            let Some(node) = fields.require(self, "motion", help) else { continue };
            let Some((joint, motion_idx, _)) = target else { continue };
            let what = fields.what("motion");
            if matches!(node.value, Value::Array(_) | Value::Table(_)) {
                let example = quantity.example;
                let help = format!(
                    "write one value in time, for example \"{example}*sin(2 rad/s*t)\"; `if` and `min` join pieces"
                );
                self.wrong_kind(node, &what, "an expression of `t`", &node.value, &help);
                continue;
            }
            let Some(motion) = self.scalar(node, quantity, &what, Scope::Time) else { continue };
            let span = motion.span;
            drives.push(Drive {
                name: name.to_owned(),
                joint,
                motion_idx,
                motion: motion.expr,
                span,
            });
        }
        drives
    }

    /// Reports a drive between two points, which need a joint to be driven.
    fn drive_of_points(&mut self, name: &str, fields: &Fields<'_>, span: Span) {
        let message = format!("{} is `between` points, and drives move joints", fields.owner);
        let help = format!(
            "add `[joints.{name}]` with `type = \"cylinder\"` and this `between`, and drive it with `joint = \"{name}\"`"
        );
        self.report(
            Diagnostic::error(codes::UNKNOWN_KEY, message).at(span, "of a joint").help(help),
        );
    }

    /// The one motion of a joint that `joint` and `of` name, and the position of the joint's name.
    pub(super) fn motion_of(
        &mut self,
        fields: &Fields<'_>,
        help: &str,
    ) -> Option<(JointId, usize, Span)> {
        let node = fields.require(self, "joint", help)?;
        let joint = self.joint_named(node, fields)?;
        // A joint with several motions says which words it has; of others, these two are asked for.
        let own = self.names.joints[joint.0].freedoms.unwrap_or_default();
        let mut own: Vec<&str> = (0..own.len()).map(|idx| motion_words(own, idx)[0]).collect();
        own.sort_unstable();
        let words = if own.len() > 1 { own } else { vec!["angle", "position"] };
        let choices: Vec<(&str, &str)> = words.iter().map(|&word| (word, word)).collect();
        let wanted = match fields.get("of") {
            Some(of) => Some(self.choice(of, &fields.what("of"), &choices)?),
            None => None,
        };
        let freedoms = self.names.joints[joint.0].freedoms?;
        let motion_idx = match (wanted, freedoms) {
            (Some(wanted), _) => self.freedom_of(joint, wanted, node, fields)?,
            (None, [_]) => 0,
            (None, []) => {
                self.no_such_motion(joint, "motion", node, fields);
                return None;
            }
            (None, _) => {
                let choices = words.iter().map(|word| format!("`of = \"{word}\"`"));
                let help = format!("write {}", choices.collect::<Vec<_>>().join(" or "));
                fields.require(self, "of", &help)?;
                return None;
            }
        };
        Some((joint, motion_idx, node.span.clone()))
    }
}
