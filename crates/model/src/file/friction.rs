//! `[loads.…]` of type `friction`: stated efforts, and Coulomb's friction of the surfaces that rub.

use bksim_expr::Expr;

use super::codes;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::{Scalar, Scope};
use crate::coupling::Coupling;
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::JointId;
use crate::joint::{Joint, MotionKind};
use crate::load::{FrictionLaw, Surface};
use crate::message::short;

/// The joints and couplings of a file, in which something may rub.
pub(super) struct Connections<'a> {
    /// `None` of one that could not be read.
    pub(super) joints: &'a [Option<Joint>],
    pub(super) couplings: &'a [Coupling],
}

/// Keys of the thread of a screw.
const THREAD_KEYS: [&str; 3] = ["flank_angle", "collar_mu", "collar_radius"];

impl Reader<'_> {
    /// Friction of a motion: `force` where it slides, `torque` where it turns, or `mu`.
    pub(super) fn read_friction(
        &mut self,
        fields: &Fields<'_>,
        connections: &Connections<'_>,
    ) -> Option<(JointId, usize, FrictionLaw)> {
        if fields.has("coupling") {
            return self.read_friction_of_teeth(fields, connections.couplings);
        }
        self.check_lifting(fields, connections.joints)?;
        for key in ["pressure_angle", "loss"] {
            if let Some(entry) = fields.entry(key) {
                let message = format!("{} has `{key}`, but no teeth", fields.owner);
                self.report(
                    Diagnostic::error(codes::NO_SURFACE, message)
                        .at(entry.key_span.clone(), "of teeth alone")
                        .help(
                            "write `coupling = \"NAME\"`, that of the gears that rub, or remove it",
                        ),
                );
                return None;
            }
        }
        if fields.has("mu")
            && let Some(curves) = self.curves_that_touch(fields, connections.joints)
        {
            return self.read_friction_of_curves(fields, curves);
        }
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
            return Some((joint, motion_idx, law));
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
        Some((joint, motion_idx, law))
    }

    /// Coulomb's friction: `mu`, `static`, and the size of the surfaces that a joint of this kind has.
    fn coulomb(
        &mut self,
        fields: &Fields<'_>,
        (joint, motion_idx): (JointId, usize),
        location: Span,
    ) -> Option<FrictionLaw> {
        let coefficients = self.coefficients(fields);
        let surface = self.surface(fields, (joint, motion_idx), location);
        let flank = self.flank(fields, surface);
        let ([sliding, sticking], surface, flank) = (coefficients?, surface?, flank?);
        // A flank that leans bears the load over its cosine.
        let [sliding, sticking] = [sliding, sticking].map(|mu| match flank {
            Some(angle) => self.pool.div(mu, self.pool.cos(angle)),
            None => mu,
        });
        Some(FrictionLaw::Coulomb { sliding, sticking, surface })
    }

    /// The angle of the flanks of a thread, `Some(None)` where it is not stated.
    #[expect(clippy::option_option, reason = "at fault, not stated, or stated")]
    fn flank(&mut self, fields: &Fields<'_>, surface: Option<Surface>) -> Option<Option<Expr>> {
        let is_thread = matches!(surface?, Surface::Thread { .. });
        for entry in THREAD_KEYS.iter().filter_map(|key| fields.entry(key)) {
            if !is_thread {
                let message = format!("{} has `{}`, but no thread", fields.owner, entry.key);
                let fault = Diagnostic::error(codes::NO_SURFACE, message)
                    .at(entry.key_span.clone(), "of a `screw` joint alone")
                    .help("remove it, or name a joint of type `screw`");
                self.report(fault);
                return None;
            }
        }
        let Some(node) = fields.get("flank_angle") else { return Some(None) };
        let what = fields.what("flank_angle");
        let angle = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?;
        if let Some(value) = angle.value {
            let [least, most] = [0.0, std::f64::consts::FRAC_PI_2].map(Constant::written);
            let is_above = self.constants.is_not_below(value, least);
            if !(self.constants.is_above(most, value) && is_above) {
                let degrees = short(value.look().to_degrees());
                let message = format!("{what} is {degrees} deg");
                let fault = Diagnostic::error(codes::NO_SURFACE, message)
                    .at(angle.span.clone(), "not from 0 to below 90 deg")
                    .help("write half of the angle of the thread: \"30 deg\" of a metric one, \"15 deg\" of a trapezoidal one");
                self.report(fault);
                return None;
            }
        }
        Some(Some(angle.expr))
    }

    /// The arm of the friction that the collar of a screw has of the axial force, m.
    fn collar(&mut self, fields: &Fields<'_>) -> Option<Expr> {
        let [mu_key, radius_key] = [THREAD_KEYS[1], THREAD_KEYS[2]];
        if !fields.has(mu_key) && !fields.has(radius_key) {
            return Some(self.pool.zero());
        }
        let mu = fields.require(self, mu_key, "write for example `collar_mu = 0.1`")?;
        let mu = self.friction(fields, mu_key, mu, Quantity::NUMBER)?;
        let help = "write for example `collar_radius = \"20 mm\"`, the mean one of its ring";
        let radius = fields.require(self, radius_key, help)?;
        let what = fields.what(radius_key);
        let radius = self.scalar(radius, Quantity::LENGTH, &what, Scope::Constant)?;
        let is_good = self.check_positive(&what, &radius, Quantity::LENGTH);
        is_good.then_some(self.pool.mul(mu.expr, radius.expr))
    }

    /// `mu` and `static`.
    pub(super) fn coefficients(&mut self, fields: &Fields<'_>) -> Option<[Expr; 2]> {
        let node = fields.require(self, "mu", "write a coefficient, for example `mu = 0.1`")?;
        let sliding = self.friction(fields, "mu", node, Quantity::NUMBER);
        let sticking = match fields.get("static") {
            Some(node) => self.friction(fields, "static", node, Quantity::NUMBER),
            None => sliding.clone(),
        };
        let (sliding, sticking) = (sliding?, sticking?);
        self.check_static_friction(fields, [&sliding, &sticking], Quantity::NUMBER);
        Some([sliding.expr, sticking.expr])
    }

    /// The joint of two curves, or of a curve and a face, that `fields` name; `None` of others.
    fn curves_that_touch<'j>(
        &mut self,
        fields: &Fields<'_>,
        joints: &'j [Option<Joint>],
    ) -> Option<(JointId, &'j Joint)> {
        let Value::Text(name) = &fields.get("joint")?.value else { return None };
        let idx = self.names.joints.iter().position(|joint| joint.name == *name)?;
        let joint = joints.get(idx)?.as_ref()?;
        joint.kind.is_touch().then_some((JointId(idx), joint))
    }

    /// Friction at the place where curves touch: `of`, `length` and `radius` have no meaning there.
    fn read_friction_of_curves(
        &mut self,
        fields: &Fields<'_>,
        (id, joint): (JointId, &Joint),
    ) -> Option<(JointId, usize, FrictionLaw)> {
        let coefficients = self.coefficients(fields);
        let kind = joint.kind.word();
        let fault = |reader: &mut Self, span: Span, message: String, help: &str| {
            let fault = Diagnostic::error(codes::NO_SURFACE, message);
            reader.report(fault.at(span, "of no meaning here").help(help));
        };
        for key in ["of", "force", "torque", "length", "radius"] {
            if let Some(entry) = fields.entry(key) {
                let message = format!(
                    "{} has `{key}` beside `mu`, which a {kind} joint has not",
                    fields.owner
                );
                fault(self, entry.key_span.clone(), message, "remove it");
                return None;
            }
        }
        if joint.kind.rolled_arcs().is_some() {
            let message = format!("{} has `mu`, but the curves of its joint roll", fields.owner);
            let help = "remove it: rolling takes the friction that it needs, or remove `rolling` of the joint";
            fault(self, fields.location(&["mu"]), message, help);
            return None;
        }
        let curves = [joint.kind.curve(), joint.kind.second_curve()].into_iter().flatten();
        let mut arcs = [self.pool.zero(); 2];
        for (arc, id) in arcs.iter_mut().zip(curves) {
            *arc = self.length_along(fields, id)?;
        }
        let [sliding, sticking] = coefficients?;
        let law = FrictionLaw::Coulomb { sliding, sticking, surface: Surface::Touch { arcs } };
        Some((id, 0, law))
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
            // A roller rolls, or rubs next to its centre.
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
                    .note("`mu` goes with revolute, prismatic, cylindrical and screw joints, with points that slide in slots, on lines and on curves, with faces and curves that touch, and with gears and racks")
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
        if kind != "screw" {
            return Some(Surface::Journal { radius });
        }
        Some(Surface::Thread { radius, collar: self.collar(fields)? })
    }

    pub(super) fn friction(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        node: &Node,
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
}
