//! `[loads.…]` of type `stop` and `friction`: what happens in one motion of a joint.

use super::codes;
use super::gather::sub_tables;
use super::names::quantities;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::Table;
use super::units::Quantity;
use super::value::{Scalar, Scope};
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::JointId;
use crate::joint::MotionKind;
use crate::load::{FrictionLaw, Load, LoadKind, Surface};
use crate::message::short;

impl Reader<'_> {
    /// Limits of a motion.
    pub(super) fn read_stop(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let help = "write `joint = \"A\"` with the name of the joint that is stopped";
        let target = self.motion_of(fields, help).map(|(joint, idx, _)| (joint, idx));
        self.limits(fields, target)
    }

    /// The limits that joints between two points have among their own keys, as stops of the same names.
    pub(super) fn read_joint_limits(&mut self, root: &Table, loads: &mut Vec<Load>) {
        for (idx, (name, span, table)) in sub_tables(root, "joints").into_iter().enumerate() {
            let joint = JointId(idx);
            let is_cylinder = self.names.joints[idx].kind == Some("cylinder");
            let Some(table) = table.filter(|_| is_cylinder) else { continue };
            // Other keys were judged with the joint.
            let keys: Vec<&str> = table.entries.iter().map(|entry| entry.key.as_str()).collect();
            let fields = Fields::open(self, table, format!("joint `{name}`"), span.clone(), &keys);
            if !fields.has("min") && !fields.has("max") {
                continue;
            }
            let Some(kind) = self.limits(&fields, Some((joint, 0))) else { continue };
            let mut name = name.to_owned();
            while loads.iter().any(|load| load.name == name) {
                name.push('_');
            }
            loads.push(Load { name, kind, span });
        }
    }

    /// The limits of a motion, which `fields` state.
    fn limits(
        &mut self,
        fields: &Fields<'_>,
        target: Option<(JointId, usize)>,
    ) -> Option<LoadKind> {
        let freedom = target.as_ref().and_then(|(joint, idx)| self.freedom(*joint, *idx));
        let quantity = freedom.map_or(Quantity::LENGTH, |freedom| quantities(freedom)[0]);
        let mut limit = |key| {
            // Without the joint nobody knows what its limits measure.
            let node = fields.get(key).filter(|_| freedom.is_some())?;
            self.scalar(node, quantity, &fields.what(key), Scope::Position)
        };
        let [min, max] = [limit("min"), limit("max")];
        if !fields.has("min") && !fields.has("max") {
            let help = format!("write `min = \"{0}\"`, `max = \"{0}\"` or both", quantity.example);
            fields.require(self, "min", &help);
            return None;
        }
        self.check_room(fields, min.as_ref(), max.as_ref());
        let restitution = match fields.get("restitution") {
            None => self.pool.zero(),
            Some(node) => {
                let what = fields.what("restitution");
                let value = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
                self.check_restitution(&what, &value);
                value.expr
            }
        };
        let (joint, motion_idx) = target?;
        // A limit that could not be read was reported.
        if fields.has("min") && min.is_none() || fields.has("max") && max.is_none() {
            return None;
        }
        let [min, max] = [min, max].map(|limit| limit.map(|scalar| scalar.expr));
        Some(LoadKind::Stop { joint, motion_idx, min, max, restitution })
    }

    /// Friction of a motion: `force` where it slides, `torque` where it turns, or `mu`.
    pub(super) fn read_friction(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let help = "write `joint = \"A\"` with the name of the joint that rubs";
        let target = self.motion_of(fields, help);
        let freedom = target.as_ref().and_then(|(joint, idx, _)| self.freedom(*joint, *idx));
        let turns = match freedom {
            Some(freedom) => freedom == MotionKind::Rotation,
            None => fields.has("torque"),
        };
        let (key, quantity) =
            if turns { ("torque", Quantity::TORQUE) } else { ("force", Quantity::FORCE) };
        let forms = [("force", "torque"), ("mu", "force"), ("mu", "torque")];
        if forms.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        if fields.has("mu") {
            let (joint, motion_idx, location) = target?;
            let law = self.coulomb(fields, (joint, motion_idx), location)?;
            return Some(LoadKind::Friction { joint, motion_idx, law });
        }
        let motion = if turns { "turns" } else { "slides" };
        let help = format!(
            "the joint {motion}: write for example `{key} = \"{}\"`, or a coefficient `mu`",
            quantity.example
        );
        let node = fields.require(self, key, &help);
        let (joint, motion_idx, _) = target?;
        let sliding = node.and_then(|node| self.friction(fields, key, node, quantity));
        let sticking = match fields.get("static") {
            Some(node) => self.friction(fields, "static", node, quantity),
            None => sliding.clone(),
        };
        let (sliding, sticking) = (sliding?, sticking?);
        self.check_static_friction(fields, [&sliding, &sticking], quantity);
        let law = FrictionLaw::Stated { sliding: sliding.expr, sticking: sticking.expr };
        Some(LoadKind::Friction { joint, motion_idx, law })
    }

    /// Coulomb's friction: `mu`, `static`, and the size of the surfaces that a joint of this kind has.
    fn coulomb(
        &mut self,
        fields: &Fields<'_>,
        (joint, motion_idx): (JointId, usize),
        location: Span,
    ) -> Option<FrictionLaw> {
        let node = fields.get("mu")?;
        let sliding = self.friction(fields, "mu", node, Quantity::NUMBER);
        let sticking = match fields.get("static") {
            Some(node) => self.friction(fields, "static", node, Quantity::NUMBER),
            None => sliding.clone(),
        };
        let surface = self.surface(fields, (joint, motion_idx), location);
        let (sliding, sticking, surface) = (sliding?, sticking?, surface?);
        self.check_static_friction(fields, [&sliding, &sticking], Quantity::NUMBER);
        Some(FrictionLaw::Coulomb { sliding: sliding.expr, sticking: sticking.expr, surface })
    }

    /// The surfaces of a joint that rub; some kinds have none that are known.
    fn surface(
        &mut self,
        fields: &Fields<'_>,
        (joint, motion_idx): (JointId, usize),
        location: Span,
    ) -> Option<Surface> {
        let kind = self.names.joints[joint.0].kind?;
        let (stated, others) = match (kind, motion_idx) {
            ("prismatic" | "slot" | "cylindrical", 0) => (Some("length"), ["radius"].as_slice()),
            ("revolute" | "screw", 0) | ("cylindrical", 1) => {
                (Some("radius"), ["length"].as_slice())
            }
            ("point-on-line", 0) => (None, ["length", "radius"].as_slice()),
            // A roller rolls, or rubs beside its centre.
            ("point-on-curve", 0) if !self.names.joints[joint.0].has_radius => {
                (None, ["length", "radius"].as_slice())
            }
            _ => {
                self.report(
                    Diagnostic::error(
                        codes::NO_SURFACE,
                        format!("{} has `mu`, but where a {kind} joint rubs is not known", fields.owner),
                    )
                    .at(location, "this motion")
                    .note("`mu` goes with revolute, prismatic, cylindrical and screw joints, and with points that slide in slots, on lines and on curves")
                    .help("state the friction itself: `force = \"5 N\"` or `torque = \"0.2 N m\"`"),
                );
                return None;
            }
        };
        if let Some(entry) = others.iter().find_map(|other| fields.entry(other)) {
            let help = match stated {
                Some(stated) => format!("remove it, or write `{stated}`"),
                None => "remove it".to_owned(),
            };
            self.report(
                Diagnostic::error(
                    codes::NO_SURFACE,
                    format!("{} has `{}`, which a {kind} joint has not", fields.owner, entry.key),
                )
                .at(entry.key_span.clone(), "of no meaning here")
                .help(help),
            );
            return None;
        }
        let Some(stated) = stated else {
            return Some(match kind {
                "point-on-line" => Surface::Guide { length: None },
                _ => Surface::Track,
            });
        };
        let size = match fields.get(stated) {
            Some(node) => {
                let what = fields.what(stated);
                let size = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
                if !self.check_positive(&what, &size, Quantity::LENGTH) {
                    return None;
                }
                Some(size.expr)
            }
            None => None,
        };
        if stated == "length" {
            return Some(Surface::Guide { length: size });
        }
        let Some(radius) = size else {
            fields.require(self, "radius", "write for example `radius = \"5 mm\"`: that of the pin, or the mean one of the thread");
            return None;
        };
        Some(match kind {
            "screw" => Surface::Thread { radius },
            _ => Surface::Journal { radius },
        })
    }

    fn friction(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        node: &super::tree::Node,
        quantity: Quantity,
    ) -> Option<Scalar> {
        let what = fields.what(key);
        let friction = self.scalar(node, quantity, &what, Scope::Load)?;
        let zero = Constant::written(0.0);
        let below = |value: &Constant| !self.constants.is_not_below(*value, zero);
        if let Some(value) = friction.value.filter(below) {
            let with_unit =
                |value: f64| format!("{value} {}", quantity.dimension()).trim_end().to_owned();
            let value = value.look();
            let message = format!("{what} is {} {}", short(value), quantity.dimension());
            self.report(
                Diagnostic::error(codes::NEGATIVE_FRICTION, message.trim_end())
                    .at(friction.span.clone(), "must not be negative")
                    .help(format!("write \"{}\"", with_unit(-value))),
            );
        }
        Some(friction)
    }

    fn freedom(&self, joint: JointId, motion_idx: usize) -> Option<MotionKind> {
        self.names.joints[joint.0].freedoms?.get(motion_idx).copied()
    }

    /// Between two limits there must be room.
    fn check_room(&mut self, fields: &Fields<'_>, min: Option<&Scalar>, max: Option<&Scalar>) {
        let (Some(min), Some(max)) = (min, max) else { return };
        let (Some(low), Some(high)) = (min.value, max.value) else { return };
        if self.constants.is_above(high, low) {
            return;
        }
        let (low, high) = (low.look(), high.look());
        let message = format!(
            "{} leaves no room: `min` is {}, `max` {}",
            fields.owner,
            short(low),
            short(high)
        );
        self.report(
            Diagnostic::error(codes::NO_ROOM, message)
                .at(max.span.clone(), "must be greater than `min`")
                .at(min.span.clone(), "the other limit")
                .help("exchange the two, or use a weld or `[drives]` to hold the joint"),
        );
    }

    fn check_restitution(&mut self, what: &str, restitution: &Scalar) {
        let Some(value) = restitution.value else { return };
        let [zero, one] = [0.0, 1.0].map(Constant::written);
        let is_good = self.constants.is_not_below(value, zero);
        if self.constants.is_not_below(one, value) && is_good {
            return;
        }
        let value = value.look();
        self.report(
            Diagnostic::error(codes::BAD_RESTITUTION, format!("{what} is {value}"))
                .at(restitution.span.clone(), "must lie between 0 and 1")
                .help("write 0 for bodies that stay together, 1 for an impact without loss"),
        );
    }
}
