//! `[joints.…]`: which points of which bodies are joined, and how.

use bksim_expr::Expr;

use super::codes;
use super::gather::sub_tables;
use super::joint_types::{DISTANCE, DISTANCE_KEYS, type_of};
use super::play::{LIFTS, PLAYING_TYPES, has_play, may_lift};
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::Anchor;
use crate::diagnostic::{Diagnostic, Span};
use crate::joint::{JOINT_TYPES, Joint, JointKind, JointType};

/// The sides of a curve as its parameter rises, with the sign of a distance to the left.
const SIDES: [(&str, i32); 2] = [("left", 1), ("right", -1)];

impl Reader<'_> {
    /// Reads all joints, in the order of their ids.
    pub(super) fn read_joints(&mut self, root: &Table) -> Vec<Option<Joint>> {
        let mut joints = Vec::new();
        for (name, span, table) in sub_tables(root, "joints") {
            if table.is_none() {
                self.not_a_table("joint", name, &span);
            }
            let joint = table.and_then(|table| self.read_joint(name, table, span));
            self.topology_unknown |= joint.is_none();
            joints.push(joint);
        }
        joints
    }

    fn read_joint(&mut self, name: &str, table: &Table, span: Span) -> Option<Joint> {
        let owner = format!("joint `{name}`");
        let words = JOINT_TYPES.iter().map(|of| of.word).chain([DISTANCE]);
        let types: Vec<(&str, &str)> = words.map(|word| (word, word)).collect();
        let Some(kind_entry) = table.get("type") else {
            // Without a type the other keys cannot be judged.
            let known: Vec<&str> = JOINT_TYPES.iter().flat_map(JointType::keys).collect();
            let fields = Fields::open(self, table, owner, span, &known);
            fields.require(self, "type", "write for example `type = \"revolute\"`");
            return None;
        };
        let written = self.choice(&kind_entry.node, &format!("`type` of {owner}"), &types)?;
        let facts = type_of(written, table)?;
        let word = facts.word;
        let plays = has_play(written, table);
        let keys = JointType::of_word(written).map_or(DISTANCE_KEYS.to_vec(), JointType::keys);
        let fields = Fields::open(self, table, owner, span.clone(), &keys);
        if written == DISTANCE && !self.is_distance(&fields) {
            return None;
        }
        let before = self.faults.len();
        let ends = self.between(&fields);
        if PLAYING_TYPES.contains(&written) {
            self.check_play(&fields);
        }
        if !plays && !facts.is_in_plane && self.spatial.is_none() {
            self.spatial = Some(kind_entry.node.span.clone());
        }
        let mut axis = self.joint_axis(if plays { written } else { word }, &fields);
        let alignment = self.alignment(word, &fields);
        let kind = self.joint_kind(word, &fields);
        let armature = self.armature(word, &fields);
        let mut cut = fields.get("cut").and_then(|node| self.flag(node, &fields.what("cut")));
        let mut coordinate_names = Vec::new();
        if let Some(node) = fields.get("coordinate") {
            coordinate_names = self.read_coordinate_names(node, &fields, &[facts.motions.len()]);
        }
        let [predecessor, successor] = ends?;
        if predecessor.body == successor.body {
            let location = fields.get("between").map_or(span.clone(), |node| node.span.clone());
            let body = &self.names.bodies[predecessor.body.0].name;
            let message = format!("{} has both ends on `{body}`", fields.owner);
            self.report(
                Diagnostic::error(codes::SELF_JOINT, message)
                    .at(location, "the same body twice")
                    .help("name two different bodies, or `ground` as one of them"),
            );
        }
        if self.faults[before..].iter().any(Diagnostic::is_error) {
            return None;
        }
        if plays {
            let play = self.play(name, written, &fields, [predecessor, successor], axis?)?;
            self.plays.push(play);
            // Bodies that contacts hold go their own ways.
            cut = Some(true);
            if written == "prismatic" {
                axis = Some([self.pool.zero(), self.pool.zero(), self.pool.one()]);
            }
        }
        if may_lift(word, table) {
            let play = self.lifting(name, &fields, [predecessor, successor])?;
            self.plays.push(play);
        }
        Some(Joint {
            name: name.to_owned(),
            kind: kind?,
            predecessor,
            successor,
            axis: axis?,
            alignment: alignment?,
            armature: armature?,
            cut,
            coordinate_names,
            span,
        })
    }

    /// The inertia of a rotor that turns with a revolute joint, kg m², or the mass that moves with a prismatic one, kg.
    fn armature(&mut self, word: &str, fields: &Fields<'_>) -> Option<Expr> {
        let Some(node) = fields.get("armature") else { return Some(self.pool.zero()) };
        let quantity = if word == "prismatic" { Quantity::MASS } else { Quantity::INERTIA };
        let what = fields.what("armature");
        let armature = self.scalar(node, quantity, &what, Scope::Constant)?;
        if let Some(value) = armature.value {
            let is_good = self.constants.is_not_below(value, Constant::written(0.0));
            if !is_good {
                let message = format!("{what} is {} {}", value.look(), quantity.dimension());
                self.report(
                    Diagnostic::error(codes::BAD_INERTIA, message)
                        .at(armature.span.clone(), "must not be negative")
                        .help("write 0 or more, the inertia of the rotor times the square of its gear ratio"),
                );
                return None;
            }
        }
        Some(armature.expr)
    }

    /// True where a distance says what it is: of a stated length, or between limits.
    fn is_distance(&mut self, fields: &Fields<'_>) -> bool {
        let limits = ["min", "max", "restitution"];
        if limits.iter().any(|limit| fields.conflict(self, "length", limit)) {
            return false;
        }
        if ["length", "min", "max"].iter().any(|key| fields.has(key)) {
            return true;
        }
        let help = "write `length = \"250 mm\"` of a rod, or `max = \"2 m\"` of a rope";
        fields.require(self, "length", help);
        false
    }

    fn joint_kind(&mut self, word: &str, fields: &Fields<'_>) -> Option<JointKind> {
        match word {
            "revolute" => Some(JointKind::Revolute),
            "slot" => Some(JointKind::PinInSlot),
            "spherical" => Some(JointKind::Spherical),
            "cylindrical" => Some(JointKind::Cylindrical),
            "planar" => Some(JointKind::Planar),
            "free" => Some(JointKind::Free),
            "point-on-line" => Some(JointKind::PointOnLine),
            "point-on-plane" => Some(JointKind::PointOnPlane),
            "parallel-axes" => Some(JointKind::ParallelAxes),
            "constant-velocity" => Some(JointKind::ConstantVelocity),
            "universal" => self.second_axis(fields).map(|second| JointKind::Universal { second }),
            "perpendicular-axes" => {
                self.second_axis(fields).map(|second| JointKind::PerpendicularAxes { second })
            }
            "point-on-curve" => {
                let lifts = self.lifts(fields);
                let has_roller = fields.has("radius") || fields.has("side") && !fields.has(LIFTS);
                let (curve, roller) =
                    (self.curve_of(fields, "curve"), has_roller.then(|| self.roller(fields)));
                let roller = match roller {
                    Some(distance) => Some(distance?),
                    None => None,
                };
                Some(JointKind::PointOnCurve { curve: curve?, roller, lifts: lifts? })
            }
            "line-on-curve" => {
                let lifts = self.lifts(fields);
                let curve = self.curve_of(fields, "curve");
                Some(JointKind::LineOnCurve { curve: curve?, lifts: lifts? })
            }
            "curve-on-curve" => self.curves_in_touch(fields),
            "screw" => self.lead(fields).map(|lead| JointKind::Screw { lead }),
            "link" => {
                let help = "write for example `length = \"250 mm\"`";
                let node = fields.require(self, "length", help)?;
                let what = fields.what("length");
                let length = self.scalar(node, Quantity::LENGTH, &what, Scope::Time)?;
                self.check_positive(&what, &length, Quantity::LENGTH)
                    .then_some(JointKind::Link { length: length.expr })
            }
            "cylinder" => Some(JointKind::Cylinder),
            "knife-edge" => Some(JointKind::KnifeEdge),
            "rolling" => self.rolling_shape(fields),
            _ => {
                let angle = match fields.get("angle") {
                    Some(node) => {
                        let what = fields.what("angle");
                        self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?.expr
                    }
                    None => self.pool.zero(),
                };
                Some(match word {
                    "prismatic" => JointKind::Prismatic { angle },
                    _ => JointKind::Weld { angle },
                })
            }
        }
    }

    /// The distance of the centre of a roller to the left of its curve, m.
    fn roller(&mut self, fields: &Fields<'_>) -> Option<Expr> {
        let node = fields.require(self, "radius", "write for example `radius = \"10 mm\"`");
        let help = "write `side = \"left\"` or `\"right\"` of the curve as its parameter rises: a curve that goes \
            around counter-clockwise has its inside on the left";
        let side = fields.require(self, "side", help);
        let (node, side) = (node?, side?);
        let what = fields.what("radius");
        let radius = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        let sign = self.choice(side, &fields.what("side"), &SIDES)?;
        let is_positive = self.check_positive(&what, &radius, Quantity::LENGTH);
        let distance = if sign < 0 { self.pool.neg(radius.expr) } else { radius.expr };
        is_positive.then_some(distance)
    }

    /// The translation of one turn of a screw, m.
    pub(super) fn lead(&mut self, fields: &Fields<'_>) -> Option<Expr> {
        let node = fields.require(self, "lead", "write for example `lead = \"5 mm\"`")?;
        let what = fields.what("lead");
        let lead = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        let value = lead.value?;
        self.constants.pinned_sign(value);
        if value.look() == 0.0 {
            self.report(
                Diagnostic::error(codes::NOT_POSITIVE, format!("{what} is 0 m"))
                    .at(lead.span.clone(), "must not be 0")
                    .note("a lead below 0 is that of a left-handed thread")
                    .help("write the translation of one turn, or `type = \"revolute\"`"),
            );
            return None;
        }
        Some(lead.expr)
    }

    /// The two anchors of `between`.
    pub(super) fn between(&mut self, fields: &Fields<'_>) -> Option<[Anchor; 2]> {
        let help = "write for example `between = [\"ground.O\", \"crank.A\"]`";
        let node = fields.require(self, "between", help)?;
        let what = fields.what("between");
        let ends: Vec<Option<Anchor>> = match &node.value {
            Value::Array(ends) if ends.len() == 2 => {
                ends.iter().map(|end| self.anchor(end, &what, &fields.owner)).collect()
            }
            other => {
                self.wrong_kind(node, &what, "an array of two points", other, help);
                return None;
            }
        };
        match ends.as_slice() {
            [Some(a), Some(b)] => Some([*a, *b]),
            _ => None,
        }
    }

    /// A body and a point, written `body.point`, or `body` for its origin.
    pub(super) fn anchor(&mut self, node: &Node, what: &str, owner: &str) -> Option<Anchor> {
        let quoted = self.text_of(node, what, "crank.A")?;
        let (body_name, point_name) = match quoted.text.split_once('.') {
            // A name that no body can have was reported where a body has it.
            _ if self.names.body(quoted.text).is_some() => (quoted.text, None),
            Some((body, point)) => (body, Some(point)),
            None => (quoted.text, None),
        };
        let body_place = quoted.span_of(&(0..body_name.len()));
        let Some(body) = self.names.body(body_name) else {
            let names = self.owned_names(|names| names.body_names());
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let message =
                format!("{owner} refers to unknown body `{}`", super::words::cut(body_name));
            let label = (body_place, "no body has this name");
            self.unknown(codes::UNKNOWN_BODY, message, label, (body_name, &names));
            return None;
        };
        let Some(point_name) = point_name else { return Some(Anchor { body, point: None }) };
        let point = self.names.point(body, point_name);
        if point.is_none() {
            let points = self.names.bodies[body.0].points.clone();
            let points: Vec<&str> = points.iter().map(String::as_str).collect();
            let start = body_name.len() + 1;
            let location = quoted.span_of(&(start..start + point_name.len()));
            let label = (location, "the body has no such point");
            let shown = super::words::cut(point_name);
            let message = format!("{owner} refers to unknown point `{shown}` of `{body_name}`");
            if points.is_empty() {
                let section = if body_name == "ground" {
                    body_name.to_owned()
                } else {
                    format!("bodies.{body_name}")
                };
                let help = format!(
                    "write `{body_name}` for its origin, or define the point in `[{section}]`: \
                     `points = {{ {shown} = [0, 0] }}`"
                );
                let fault = Diagnostic::error(codes::UNKNOWN_POINT, message);
                self.report(fault.at(label.0, label.1).help(help));
                return None;
            }
            self.unknown(codes::UNKNOWN_POINT, message, label, (point_name, &points));
            return None;
        }
        Some(Anchor { body, point })
    }

    /// Copies of some names, so that they can be shown while a fault is recorded.
    pub(super) fn owned_names<'s>(
        &'s self,
        pick: impl Fn(&'s super::names::Names) -> Vec<&'s str>,
    ) -> Vec<String> {
        if self.has_seen_enough() {
            return Vec::new();
        }
        pick(&self.names).into_iter().map(str::to_owned).collect()
    }
}
