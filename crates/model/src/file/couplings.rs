//! `[couplings.…]`: gears, belts, racks, screws and relations between the motions of joints.

use bksim_expr::Expr;

use super::codes;
use super::gather::sub_tables;
use super::reader::{Fields, Reader};
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::{Scalar, Scope};
use super::words::cut;
use crate::body::Anchor;
use crate::coupling::{Coupling, CouplingKind, Rack, Wheels};
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::{BodyId, JointId};
use crate::joint::{MotionKind, motion_words};
use crate::measure::Measure;

/// The types of coupling and their keys.
const COUPLINGS: [(&str, &[&str]); 6] = [
    ("relation", &["type", "relation"]),
    (
        "gear",
        &["type", "between", "teeth", "module", "radii", "ratio", "internal", "carrier", "phase"],
    ),
    ("belt", &["type", "between", "teeth", "module", "radii", "crossed", "carrier", "phase"]),
    ("chain", &["type", "between", "teeth", "module", "radii", "carrier", "phase"]),
    ("rack", &["type", "between", "teeth", "module", "radius", "reversed", "phase"]),
    ("screw", &["type", "between", "lead", "phase"]),
];

impl Reader<'_> {
    /// Reads all couplings, in file order.
    pub(super) fn read_couplings(&mut self, root: &Table) -> Vec<Coupling> {
        let mut couplings = Vec::new();
        for (name, span, table) in sub_tables(root, "couplings") {
            let Some(table) = table else {
                self.not_a_table("coupling", name, &span);
                continue;
            };
            self.usable_name(name, &span, "coupling");
            couplings.extend(self.read_coupling(name, table, span));
        }
        couplings
    }

    fn read_coupling(&mut self, name: &str, table: &Table, span: Span) -> Option<Coupling> {
        let owner = format!("coupling `{name}`");
        let types: Vec<(&str, usize)> =
            COUPLINGS.iter().enumerate().map(|(idx, (word, _))| (*word, idx)).collect();
        let Some(entry) = table.get("type") else {
            let known = COUPLINGS.map(|(_, keys)| keys).concat();
            let fields = Fields::open(self, table, owner, span, &known);
            fields.require(self, "type", "write for example `type = \"gear\"`");
            return None;
        };
        let kind_idx = self.choice(&entry.node, &format!("`type` of {owner}"), &types)?;
        let (word, keys) = COUPLINGS[kind_idx];
        let fields = Fields::open(self, table, owner, span.clone(), keys);
        let (kind, relation, effort) = match word {
            "relation" => self.read_relation(&fields)?,
            "rack" => self.read_rack(&fields)?,
            "screw" => self.read_screw(&fields)?,
            _ => self.read_wheels(word, &fields)?,
        };
        let mut keys = ["relation", "ratio", "teeth", "radii", "radius", "lead"].iter();
        let location = keys.find_map(|key| fields.get(key)).map_or(span, |node| node.span.clone());
        Some(Coupling { name: name.to_owned(), kind, relation, effort, span: location })
    }

    /// A relation of any positions, which is zero.
    fn read_relation(&mut self, fields: &Fields<'_>) -> Option<(CouplingKind, Expr, MotionKind)> {
        let help = "write for example `relation = \"2*A.angle - B.angle\"`, which is then zero";
        let node = fields.require(self, "relation", help)?;
        let what = fields.what("relation");
        let (scalar, effort) = self.length_or_angle(node, &what)?;
        let pool = &self.pool;
        let signals = self.names.signals.iter();
        let used: Vec<Measure> = signals
            .filter(|signal| pool.depends_on(scalar.expr, signal.symbol))
            .map(|signal| signal.measure)
            .collect();
        let fault = match used.iter().any(|measure| measure.is_velocity()) {
            true => Some(("depends on a rate", "write it in positions: `A.angle`, `rod.P.x`")),
            false if used.is_empty() => {
                Some(("depends on nothing that moves", "name positions: `A.angle`, `rod.P.x`"))
            }
            false => None,
        };
        if let Some((fault, help)) = fault {
            self.report(
                Diagnostic::error(codes::BAD_RELATION, format!("{what} {fault}"))
                    .at(scalar.span.clone(), "must hold between positions")
                    .help(help),
            );
            return None;
        }
        Some((CouplingKind::Relation, scalar.expr, effort))
    }

    /// Two wheels: gears, or those of a belt.
    fn read_wheels(
        &mut self,
        word: &str,
        fields: &Fields<'_>,
    ) -> Option<(CouplingKind, Expr, MotionKind)> {
        let is_gear = word == "gear";
        let members = self.two_members(fields);
        let flag = if is_gear { "internal" } else { "crossed" };
        let flagged = fields.get(flag).map(|node| self.flag(node, &fields.what(flag)));
        let sizes = self.wheel_sizes(fields);
        let phase = self.phase(fields, Quantity::ANGLE);
        let (carrier, axes, wheels) = self.wheels(members?, fields)?;
        // Gears turn in opposite senses, wheels of a belt in the same; the flag says otherwise.
        let is_same = flagged.unwrap_or(Some(false))? != (word != "gear");
        let sizes = sizes?;
        let ratio = self.signed_ratio(sizes, is_same, fields)?;
        let phase = phase?;

        // ratio · first + phase − second, times the pitch radius of the second where it is known.
        let turn = |reader: &mut Self, at: usize| {
            let measure = Measure::Turn(wheels[at].body, carrier, axes[at]);
            let body = reader.names.bodies[wheels[at].body.0].name.clone();
            reader.names.signal(&reader.pool, &format!("{body}.turn"), measure)
        };
        let [first, second] = [turn(self, 0), turn(self, 1)];
        let pool = &self.pool;
        let Sizes { radii, teeth, .. } = sizes;
        let radii =
            radii.map(|[first, second]| [if is_same { first } else { pool.neg(first) }, second]);
        let rest = pool.sub(phase, second);
        let (relation, effort) = match radii {
            Some([r_first, r_second]) => {
                let arcs = [pool.mul(r_first, first), pool.mul(r_second, rest)];
                (pool.sum(arcs), MotionKind::Translation)
            }
            None => (pool.add(pool.mul(ratio, first), rest), MotionKind::Rotation),
        };
        let wheels = Wheels { axes, wheels, carrier, ratio, radii, teeth, phase };
        let kind = if is_gear { CouplingKind::Gear(wheels) } else { CouplingKind::Belt(wheels) };
        Some((kind, relation, effort))
    }

    /// A pinion and its rack: radius · angle − travel.
    fn read_rack(&mut self, fields: &Fields<'_>) -> Option<(CouplingKind, Expr, MotionKind)> {
        let help =
            "write `between = [\"A\", \"B\"]`: the joint of the pinion, then that of the rack";
        let joints = self.two_joints(fields, help);
        let phase = self.phase(fields, Quantity::LENGTH);
        let reversed = fields.get("reversed").map(|node| self.flag(node, &fields.what("reversed")));
        if fields.conflict(self, "radius", "teeth") {
            return None;
        }
        let (radius, teeth) = if fields.has("teeth") {
            let node = fields.get("teeth")?;
            let what = fields.what("teeth");
            let teeth = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
            if !self.check_positive(&what, &teeth, Quantity::NUMBER) {
                return None;
            }
            let number = teeth.expr;
            (self.module_radii(fields, &[teeth])?[0], Some(number))
        } else {
            let help = "write `radius = \"20 mm\"`, or `teeth` and `module`";
            let node = fields.require(self, "radius", help)?;
            let what = fields.what("radius");
            let radius = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
            let is_positive = self.check_positive(&what, &radius, Quantity::LENGTH);
            (is_positive.then_some(radius.expr)?, None)
        };
        let joints = joints?;
        self.turning_of(joints[0], fields, 0)?;
        self.sliding_of(joints[1], fields)?;
        let (carrier, bodies) = self.carrier(joints, fields)?;

        // The travel of the rack against the carrier is that of its joint, or its opposite.
        let measure = Measure::Turn(bodies[0], carrier, joints[0]);
        let body = self.names.bodies[bodies[0].0].name.clone();
        let angle = self.names.signal(&self.pool, &format!("{body}.turn"), measure);
        let name = format!("{}.position", self.names.joints[joints[1].0].name);
        let slide = Measure::JointPosition(joints[1], 0);
        let travel = self.names.signal(&self.pool, &name, slide);
        let is_first = self.joint_bodies[joints[1].0].is_some_and(|[from, _]| from == bodies[1]);
        let pool = &self.pool;
        let radius = if reversed.unwrap_or(Some(false))? { pool.neg(radius) } else { radius };
        let travel = if is_first { pool.neg(travel) } else { travel };
        let relation = pool.sum([pool.mul(radius, angle), phase?, pool.neg(travel)]);
        let rack = Rack { joints, bodies, radius, teeth };
        Some((CouplingKind::Rack(rack), relation, MotionKind::Translation))
    }

    /// A nut on a spindle: lead/2π · angle − travel.
    fn read_screw(&mut self, fields: &Fields<'_>) -> Option<(CouplingKind, Expr, MotionKind)> {
        let help =
            "write `between = [\"A\", \"B\"]`: the joint that turns, then the one that slides";
        let joints = self.two_joints(fields, help);
        let phase = self.phase(fields, Quantity::LENGTH);
        let lead = self.lead(fields);
        let joints = joints?;
        let turning = self.turning_of(joints[0], fields, 0)?;
        let sliding = self.sliding_of(joints[1], fields)?;
        let mut position = |joint: JointId, idx: usize, word: &str| {
            let name = format!("{}.{word}", self.names.joints[joint.0].name);
            self.names.signal(&self.pool, &name, Measure::JointPosition(joint, idx))
        };
        let angle = position(joints[0], turning, "angle");
        let travel = position(joints[1], sliding, "position");
        let pool = &self.pool;
        let turns = pool.div(angle, pool.mul(pool.int(2), pool.pi()));
        let relation = pool.sum([pool.mul(lead?, turns), phase?, pool.neg(travel)]);
        Some((CouplingKind::Screw, relation, MotionKind::Translation))
    }

    /// A value that is a length or an angle, and which of both; a bare number is an angle.
    fn length_or_angle(&mut self, node: &Node, what: &str) -> Option<(Scalar, MotionKind)> {
        let n_faults = self.faults.len();
        let angle = self.scalar(node, Quantity::ANGLE, what, Scope::Motion);
        if let Some(angle) = angle {
            return Some((angle, MotionKind::Rotation));
        }
        // What is no angle may be a length; what is neither is said once.
        let faults = self.faults.split_off(n_faults);
        let is_other = faults.iter().all(|fault| fault.code == codes::WRONG_DIMENSION);
        if is_other && let Some(length) = self.scalar(node, Quantity::LENGTH, what, Scope::Motion) {
            return Some((length, MotionKind::Translation));
        }
        self.faults.truncate(n_faults);
        self.faults.extend(faults);
        None
    }

    /// The two wheels of `between`: joints about which they turn, or bodies with their centres.
    fn two_members(&mut self, fields: &Fields<'_>) -> Option<[Member; 2]> {
        let help =
            "write for example `between = [\"A\", \"B\"]` with the joints about which they turn";
        let node = fields.require(self, "between", help)?;
        let what = fields.what("between");
        let nodes = self.array(node, &what, "an array of two wheels", "[\"A\", \"B\"]")?;
        let [first, second] = nodes else {
            self.wrong_kind(node, &what, "an array of two wheels", &node.value, help);
            return None;
        };
        let mut member = |node: &Node| {
            let quoted = self.text_of(node, &what, "A")?;
            let owner = quoted.text.split('.').next().unwrap_or_default();
            if self.names.joint(quoted.text).is_none() && self.names.body(owner).is_some() {
                return Some(Member::Body(self.anchor(node, &what, &fields.owner)?));
            }
            let joint = self.joint_named(node, fields)?;
            self.only_motion(joint, MotionKind::Rotation, "angle", node, fields)?;
            Some(Member::Joint(joint))
        };
        let members = [member(first), member(second)];
        let [Some(first), Some(second)] = members else { return None };
        if first == second {
            self.coupled_with_itself(node, fields);
            return None;
        }
        Some([first, second])
    }

    /// The carrier of two wheels, the joints about whose axes they turn, and the wheels with their centres.
    fn wheels(
        &mut self,
        members: [Member; 2],
        fields: &Fields<'_>,
    ) -> Option<(BodyId, [JointId; 2], [Anchor; 2])> {
        let (carrier, axes) = match members {
            [Member::Joint(first), Member::Joint(second)] => {
                let joints = [first, second];
                (self.carrier(joints, fields)?.0, joints)
            }
            [Member::Joint(joint), Member::Body(_)] | [Member::Body(_), Member::Joint(joint)] => {
                let [from, _] = self.joint_bodies.get(joint.0).copied().flatten()?;
                let stated = match fields.get("carrier") {
                    Some(node) => Some(self.body_of(node, fields)?),
                    None => None,
                };
                (stated.unwrap_or(from), [joint; 2])
            }
            [Member::Body(_), Member::Body(_)] => {
                let node = fields.get("between")?;
                self.report(
                    Diagnostic::error(
                        codes::NO_CARRIER,
                        format!("{} names two bodies and no joint", fields.owner),
                    )
                    .at(node.span.clone(), "none of them has an axis")
                    .help("name the joint about which one of them turns"),
                );
                return None;
            }
        };
        let wheel = |member: Member| match member {
            Member::Body(anchor) => Some(anchor),
            Member::Joint(joint) => {
                let [from, to] = self.joint_ends.get(joint.0).copied().flatten()?;
                Some(if to.body == carrier { from } else { to })
            }
        };
        let wheels = [wheel(members[0])?, wheel(members[1])?];
        if let Some(same) = wheels.iter().find(|wheel| wheel.body == carrier) {
            let name = self.names.bodies[same.body.0].name.clone();
            let node = fields.get("between")?;
            self.report(
                Diagnostic::error(
                    codes::NO_CARRIER,
                    format!("`{name}` is both a wheel of {} and its carrier", fields.owner),
                )
                .at(node.span.clone(), "a wheel does not turn against itself")
                .help("name two wheels that turn against the body that carries their axes"),
            );
            return None;
        }
        Some((carrier, axes, wheels))
    }

    /// The two joints of `between`.
    fn two_joints(&mut self, fields: &Fields<'_>, help: &str) -> Option<[JointId; 2]> {
        let node = fields.require(self, "between", help)?;
        let what = fields.what("between");
        let Value::Array(names) = &node.value else {
            self.wrong_kind(node, &what, "an array of two joints", &node.value, help);
            return None;
        };
        let [first, second] = names.as_slice() else {
            self.wrong_kind(node, &what, "an array of two joints", &node.value, help);
            return None;
        };
        let joints = [self.joint_named(first, fields), self.joint_named(second, fields)];
        let [Some(first), Some(second)] = joints else { return None };
        if first == second {
            self.coupled_with_itself(node, fields);
            return None;
        }
        Some([first, second])
    }

    fn coupled_with_itself(&mut self, node: &Node, fields: &Fields<'_>) {
        let message = format!("{} couples a joint with itself", fields.owner);
        self.report(
            Diagnostic::error(codes::BAD_RELATION, message)
                .at(node.span.clone(), "the same twice")
                .help("name two joints"),
        );
    }

    /// The one rotation of a joint that carries a wheel.
    fn turning_of(&mut self, joint: JointId, fields: &Fields<'_>, at: usize) -> Option<usize> {
        let node = nth(fields.get("between")?, at);
        self.only_motion(joint, MotionKind::Rotation, "angle", node, fields)
    }

    /// The one translation of a joint that carries a rack or a nut.
    fn sliding_of(&mut self, joint: JointId, fields: &Fields<'_>) -> Option<usize> {
        let node = nth(fields.get("between")?, 1);
        self.only_motion(joint, MotionKind::Translation, "position", node, fields)
    }

    fn only_motion(
        &mut self,
        joint: JointId,
        kind: MotionKind,
        word: &str,
        node: &Node,
        fields: &Fields<'_>,
    ) -> Option<usize> {
        let freedoms = self.names.joints[joint.0].freedoms?;
        let found = (0..freedoms.len())
            .find(|&idx| freedoms[idx] == kind && motion_words(freedoms, idx)[0] == word);
        if found.is_none() {
            self.no_such_motion(joint, word, node, fields);
        }
        found
    }

    /// The body against which both joints move, and the bodies that they move.
    fn carrier(
        &mut self,
        joints: [JointId; 2],
        fields: &Fields<'_>,
    ) -> Option<(BodyId, [BodyId; 2])> {
        let ends = joints.map(|joint| self.joint_bodies.get(joint.0).copied().flatten());
        // A joint that could not be read was reported there.
        let [Some(first), Some(second)] = ends else { return None };
        let stated = match fields.get("carrier") {
            Some(node) => Some(self.body_of(node, fields)?),
            None => None,
        };
        let carrier = stated.or_else(|| first.into_iter().find(|body| second.contains(body)));
        let Some(carrier) = carrier else {
            let name = |body: BodyId| format!("`{}`", self.names.bodies[body.0].name);
            let [a, b] = joints.map(|joint| self.names.joints[joint.0].name.clone());
            let candidates: Vec<String> = second.into_iter().chain(first).map(name).collect();
            let node = fields.get("between")?;
            self.report(
                Diagnostic::error(
                    codes::NO_CARRIER,
                    format!(
                        "the joints `{a}` and `{b}` of {} have no body in common",
                        fields.owner
                    ),
                )
                .at(node.span.clone(), "no body carries both axes")
                .note("angles of wheels count against the body that carries their axes")
                .help(format!("write `carrier = …` with one of {}", candidates.join(", "))),
            );
            return None;
        };
        let moved = |[from, to]: [BodyId; 2]| if to == carrier { from } else { to };
        Some((carrier, [moved(first), moved(second)]))
    }

    fn body_of(&mut self, node: &Node, fields: &Fields<'_>) -> Option<BodyId> {
        let quoted = self.text_of(node, &fields.what("carrier"), "crank")?;
        let found = self.names.body(quoted.text);
        if found.is_none() {
            let names = self.owned_names(|names| names.body_names());
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let location = quoted.span_of(&(0..quoted.text.len()));
            let message = format!("{} refers to unknown body `{}`", fields.owner, cut(quoted.text));
            let label = (location, "no body has this name");
            self.unknown(codes::UNKNOWN_BODY, message, label, (quoted.text, &names));
        }
        found
    }

    /// The sizes of two wheels, in the form in which they are stated.
    fn wheel_sizes(&mut self, fields: &Fields<'_>) -> Option<Sizes> {
        let forms = [
            ("teeth", "radii"),
            ("teeth", "ratio"),
            ("radii", "ratio"),
            ("radii", "module"),
            ("ratio", "module"),
            ("ratio", "internal"),
        ];
        if forms.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        if let Some(node) = fields.get("ratio") {
            let what = fields.what("ratio");
            let ratio = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
            let value = ratio.value?;
            self.constants.pinned_sign(value);
            if value.look() == 0.0 {
                self.report(
                    Diagnostic::error(codes::BAD_RATIO, format!("{what} is 0"))
                        .at(ratio.span, "must not be 0")
                        .note("the ratio is the rate of the second wheel over that of the first")
                        .help("write for example `ratio = -0.5`, below 0 where they turn in opposite senses"),
                );
                return None;
            }
            return Some(Sizes { ratio: Some(ratio.expr), radii: None, teeth: None });
        }
        if let Some(node) = fields.get("radii") {
            let radii = self.two_sizes(node, "radii", Quantity::LENGTH, fields)?;
            let radii = Some(radii.map(|radius| radius.expr));
            return Some(Sizes { ratio: None, radii, teeth: None });
        }
        let help = "write `teeth = [20, 45]`, `radii = [\"20 mm\", \"45 mm\"]` or `ratio`";
        let node = fields.require(self, "teeth", help)?;
        let teeth = self.two_sizes(node, "teeth", Quantity::NUMBER, fields)?;
        let radii = if fields.has("module") {
            let radii = self.module_radii(fields, &teeth)?;
            Some([radii[0], radii[1]])
        } else {
            None
        };
        Some(Sizes { ratio: None, radii, teeth: Some(teeth.map(|teeth| teeth.expr)) })
    }

    fn two_sizes(
        &mut self,
        node: &Node,
        key: &str,
        quantity: Quantity,
        fields: &Fields<'_>,
    ) -> Option<[Scalar; 2]> {
        let what = fields.what(key);
        let nodes = self.array(node, &what, "an array of two sizes", "[20, 45]")?;
        let [first, second] = nodes else {
            let help = "write the size of the first wheel, then that of the second";
            self.wrong_kind(node, &what, "an array of two sizes", &node.value, help);
            return None;
        };
        let mut size = |node: &Node| {
            let size = self.scalar(node, quantity, &what, Scope::Constant)?;
            self.check_positive(&what, &size, quantity).then_some(size)
        };
        let sizes = [size(first), size(second)];
        let [Some(first), Some(second)] = sizes else { return None };
        Some([first, second])
    }

    /// Pitch radii m z/2 of wheels with these teeth.
    fn module_radii(&mut self, fields: &Fields<'_>, teeth: &[Scalar]) -> Option<Vec<Expr>> {
        let help = "write for example `module = \"2 mm\"`: pitch diameter over teeth";
        let node = fields.require(self, "module", help)?;
        let what = fields.what("module");
        let module = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        let is_positive = self.check_positive(&what, &module, Quantity::LENGTH);
        let pool = &self.pool;
        let half = pool.rational(1, 2);
        let radius = |teeth: &Scalar| pool.product([half, module.expr, teeth.expr]);
        is_positive.then(|| teeth.iter().map(radius).collect())
    }

    /// The ratio with its sign.
    fn signed_ratio(&mut self, sizes: Sizes, is_same: bool, fields: &Fields<'_>) -> Option<Expr> {
        let pool = &self.pool;
        let size = match sizes {
            Sizes { ratio: Some(ratio), .. } => return Some(ratio),
            Sizes { teeth, radii, .. } => teeth.or(radii)?,
        };
        let ratio = pool.div(size[0], size[1]);
        let ratio = if is_same { ratio } else { pool.neg(ratio) };
        if fields.get("internal").is_some() && is_same && pool.simplify(ratio) == pool.one() {
            let node = fields.get("internal")?;
            self.report(
                Diagnostic::error(
                    codes::BAD_RATIO,
                    format!("{} has an internal gear as large as the other", fields.owner),
                )
                .at(node.span.clone(), "a gear inside of one of its own size")
                .help("give the ring more teeth than the pinion, or remove `internal`"),
            );
            return None;
        }
        Some(ratio)
    }

    /// The position of the second member where that of the first is zero.
    fn phase(&mut self, fields: &Fields<'_>, quantity: Quantity) -> Option<Expr> {
        match fields.get("phase") {
            Some(node) => {
                let what = fields.what("phase");
                Some(self.scalar(node, quantity, &what, Scope::Constant)?.expr)
            }
            None => Some(self.pool.zero()),
        }
    }
}

/// A wheel as `between` names it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Member {
    /// By the joint about which it turns.
    Joint(JointId),
    /// By its body and centre.
    Body(Anchor),
}

/// The sizes of two wheels.
#[derive(Clone, Copy)]
struct Sizes {
    /// Rate of the second over that of the first, with its sign, where it is stated alone.
    ratio: Option<Expr>,
    /// Pitch radii, m.
    radii: Option<[Expr; 2]>,
    /// Numbers of teeth.
    teeth: Option<[Expr; 2]>,
}

/// An element of an array.
fn nth(node: &Node, at: usize) -> &Node {
    match &node.value {
        Value::Array(values) => values.get(at).unwrap_or(node),
        _ => node,
    }
}
