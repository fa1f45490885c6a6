//! `[couplings.…]`: gears, belts, ropes, racks, screws and relations between the motions of joints; `[conditions.…]`: what
//! holds between rates alone.

use bksim_expr::Expr;

use super::codes;
use super::flanks::FLANK_KEYS;
use super::reader::{Fields, Reader};
use super::ropes::ROPE_KEYS;
use super::tree::{Node, Table};
use super::units::Quantity;
use super::value::{Kind, Scalar, Scope};
use super::words::cut;
use crate::coupling::{Coupling, CouplingKind, Rack};
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::JointId;
use crate::joint::MotionKind;
use crate::load::Load;
use crate::measure::{Measure, Signal};

/// Keys of a condition on rates.
pub(super) const CONDITION_KEYS: [&str; 1] = ["rate"];

/// The types of coupling and their keys.
pub(super) const COUPLINGS: [(&str, &[&str]); 7] = [
    (
        "gear",
        &[
            "type",
            "between",
            "teeth",
            "module",
            "radii",
            "ratio",
            "internal",
            "worm_radius",
            "carrier",
            "phase",
            FLANK_KEYS[0],
            FLANK_KEYS[1],
            FLANK_KEYS[2],
            FLANK_KEYS[3],
            "stiffness",
            "damping",
        ],
    ),
    (
        "belt",
        &[
            "type",
            "between",
            "teeth",
            "module",
            "radii",
            "crossed",
            "carrier",
            "phase",
            "turns",
            "length",
            "stiffness",
            "damping",
        ],
    ),
    (
        "chain",
        &[
            "type",
            "between",
            "teeth",
            "module",
            "radii",
            "carrier",
            "phase",
            "turns",
            "length",
            "stiffness",
            "damping",
        ],
    ),
    (
        "rack",
        &[
            "type",
            "between",
            "teeth",
            "module",
            "radius",
            "reversed",
            "phase",
            FLANK_KEYS[0],
            FLANK_KEYS[1],
            FLANK_KEYS[2],
            FLANK_KEYS[3],
            "stiffness",
            "damping",
        ],
    ),
    ("screw", &["type", "between", "lead", "phase"]),
    ("relation", &["type", "relation"]),
    ("rope", ROPE_KEYS),
];

impl Reader<'_> {
    /// Reads all couplings, in file order.
    pub(super) fn read_couplings(&mut self, root: &Table) -> Vec<Coupling> {
        let mut couplings = Vec::new();
        for (name, span, table) in self.own_tables(root, "coupling") {
            self.usable_name(name, &span, "coupling");
            let read = self.read_coupling(name, table, span);
            self.topology_unknown |= read.is_none();
            couplings.extend(read.unwrap_or_default());
        }
        for (name, span, table) in self.own_tables(root, "condition") {
            self.usable_name(name, &span, "condition");
            if couplings.iter().any(|known| known.name == name) {
                let message = format!("`{name}` is a coupling and a condition");
                self.report(
                    Diagnostic::error(codes::DUPLICATE, message)
                        .at(span, "results have both as `couplings.NAME`")
                        .help(format!("rename the condition, for example `{name}_rate`")),
                );
                continue;
            }
            let owner = format!("condition `{name}`");
            let fields = Fields::open(self, table, owner, span, &CONDITION_KEYS);
            if let Some((relation, effort)) = self.read_rate(&fields) {
                let span = fields.location(&["rate"]);
                let kind = CouplingKind::Rate;
                couplings.push(Coupling { name: name.to_owned(), kind, relation, effort, span });
            }
        }
        couplings
    }

    fn read_coupling(&mut self, name: &str, table: &Table, span: Span) -> Option<Vec<Coupling>> {
        let owner = format!("coupling `{name}`");
        let (word, fields) = Fields::of_type(self, table, owner, span, &COUPLINGS)?;
        let (kind, relation, effort) = match word {
            "relation" => self.read_relation(&fields)?,
            "rack" => self.read_rack(&fields)?,
            "screw" => self.read_screw(&fields)?,
            "rope" => return self.read_rope(name, &fields),
            "belt" | "chain" if Self::is_loop(&fields) => return self.read_belt(name, &fields),
            _ => self.read_wheels(word, &fields)?,
        };
        let keys = ["relation", "ratio", "teeth", "radii", "radius", "lead"];
        let span = fields.location(&keys);
        let coupling = Coupling { name: name.to_owned(), kind, relation, effort, span };
        if fields.has("stiffness") && ["gear", "rack"].contains(&word) {
            self.read_elastic_teeth(&fields, &coupling)?;
            return Some(Vec::new());
        }
        if word == "gear" && fields.has("damping") {
            let help = "write for example `stiffness = \"200 MN/m\"`: rigid teeth have no damping";
            fields.require(self, "stiffness", help)?;
        }
        let has_play = fields.has("backlash");
        self.log_flanks(&coupling, has_play);
        if has_play {
            self.read_play(&fields, &coupling)?;
            return Some(Vec::new());
        }
        if fields.has("restitution") {
            let help = "write for example `backlash = \"0.1 mm\"`: teeth without play never part";
            fields.require(self, "backlash", help)?;
        }
        Some(vec![coupling])
    }

    /// Reports forces of couplings that are measured and are none, or have another dimension.
    pub(super) fn check_forces(&mut self, couplings: &[Coupling]) {
        let used = self.names.signals.iter().filter_map(|signal| match signal.measure {
            Measure::Force(idx) => Some((idx, MotionKind::Translation)),
            Measure::Moment(idx) => Some((idx, MotionKind::Rotation)),
            _ => None,
        });
        let name = |idx: usize| self.names.forces[idx].0.clone();
        let used: Vec<(String, MotionKind)> = used.map(|(idx, kind)| (name(idx), kind)).collect();
        let known = couplings.iter().map(|of| (of.name.clone(), of.effort));
        let ropes = self.rope_loads.iter().filter(|of| of.is_coupling() || of.is_capstan());
        let ropes = ropes.map(|of| (of.name.clone(), of.effort()));
        let teeth = self.rope_loads.iter().filter_map(Load::teeth);
        let ropes = ropes.chain(teeth.map(|teeth| (teeth.name.clone(), teeth.effort)));
        let elastic = self.ropes.iter().flat_map(|rope| &rope.sections);
        let elastic = elastic.filter(|section| section.pull.is_some());
        let elastic = elastic.map(|section| (section.name.clone(), MotionKind::Translation));
        let known: Vec<(String, MotionKind)> = known.chain(ropes).chain(elastic).collect();
        for force in used {
            if self.topology_unknown || known.contains(&force) {
                continue;
            }
            let names: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
            let message = format!("nothing has the force `couplings.{}`", force.0);
            let help = if names.is_empty() {
                "a belt that stretches has signals in its place, such as `belt_tension_A_B`"
                    .to_owned()
            } else {
                format!("name one of: {}", names.join(", "))
            };
            self.report(Diagnostic::error(codes::UNKNOWN_NAME, message).help(help));
        }
    }

    /// A relation of any positions, which is zero.
    fn read_relation(&mut self, fields: &Fields<'_>) -> Option<(CouplingKind, Expr, MotionKind)> {
        let help = "write for example `relation = \"2*A.angle - B.angle\"`, which is then zero";
        let node = fields.require(self, "relation", help)?;
        let what = fields.what("relation");
        if self.is_of_rates(node, &what) {
            return None;
        }
        let kinds =
            [(Quantity::ANGLE, MotionKind::Rotation), (Quantity::LENGTH, MotionKind::Translation)];
        let (scalar, effort) = self.one_of(node, &what, kinds)?;
        let pool = &self.pool;
        let signals = self.names.signals.iter();
        let used: Vec<Measure> = signals
            .filter(|signal| pool.depends_on(scalar.expr, signal.symbol))
            .map(|signal| signal.measure)
            .collect();
        let fault = match used.iter().any(|measure| measure.is_velocity()) {
            true => Some(("depends on a rate", "write it in positions: `A.angle`, `rod.P.x`")),
            false if self.is_held(scalar.expr) => Some((
                "jumps with a signal that is held",
                "write it in positions: `A.angle`, `rod.P.x`",
            )),
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

    /// A condition on rates, which is zero: linear in the rates.
    fn read_rate(&mut self, fields: &Fields<'_>) -> Option<(Expr, MotionKind)> {
        const EXAMPLE: &str = "write for example `rate = \"skate.P.vy*cos(skate.angle) - skate.P.vx*sin(skate.angle)\"`, which is then zero";
        let node = fields.require(self, "rate", EXAMPLE)?;
        let what = fields.what("rate");
        let kinds =
            [(Quantity::RATE, MotionKind::Rotation), (Quantity::VELOCITY, MotionKind::Translation)];
        let (scalar, effort) = self.one_of(node, &what, kinds)?;
        let (pool, expr) = (&self.pool, scalar.expr);
        let used = self.names.signals.iter().filter(|signal| pool.depends_on(expr, signal.symbol));
        let (rates, positions): (Vec<Signal>, Vec<Signal>) =
            used.partition(|signal| signal.measure.is_velocity());
        let help = "write it in rates: `A.rate`, `rod.P.vx`, `wheel.wy`";
        let is_linear = rates.iter().all(|signal| {
            let slope = pool.diff(expr, signal.symbol);
            !rates.iter().any(|other| pool.depends_on(slope, other.symbol))
        });
        let fault = if let Some(other) = rates.iter().find(|signal| !signal.measure.is_rate()) {
            let name = pool.symbol_name(other.symbol);
            Some((format!("depends on `{name}`, which is no rate of a position"), help))
        } else if rates.is_empty() && !positions.is_empty() {
            Some((
                "depends on positions alone".to_owned(),
                "write a `relation` of `[couplings]` for what holds between positions, or rates here",
            ))
        } else if rates.is_empty() {
            Some(("depends on nothing that moves".to_owned(), help))
        } else if !is_linear {
            Some((
                "is not linear in the rates".to_owned(),
                "write a sum of rates, each times a factor of positions, time and parameters",
            ))
        } else if self.is_held(expr) {
            Some(("jumps with a signal that is held".to_owned(), help))
        } else {
            None
        };
        if let Some((fault, help)) = fault {
            self.report(
                Diagnostic::error(codes::BAD_RATE, format!("{what} {fault}"))
                    .at(scalar.span.clone(), "must hold between rates")
                    .help(help),
            );
            return None;
        }
        Some((expr, effort))
    }

    /// Reports a relation that says how fast things move: a condition on rates, which no positions keep.
    fn is_of_rates(&mut self, node: &Node, what: &str) -> bool {
        let Some(quoted) = node.text(self.text) else { return false };
        let (n_faults, n_calls) = (self.faults.len(), self.table_calls.len());
        let lowered = self.lowered(node, what, Scope::Motion);
        self.faults.truncate(n_faults);
        self.table_calls.truncate(n_calls);
        let Some(lowered) = lowered else { return false };
        let of = |quantity: Quantity| lowered.kind == Kind::Known(quantity.dimension());
        if !of(Quantity::VELOCITY) && !of(Quantity::RATE) {
            return false;
        }
        let (text, span) = (quoted.text.to_owned(), quoted.span_of(&(0..quoted.text.len())));
        self.report(
            Diagnostic::error(codes::BAD_RELATION, format!("{what} is a condition on rates"))
                .at(span, "must hold between positions")
                .note("a relation is kept by positions; what holds between rates alone, as of a blade or a wheel, is none")
                .help(format!(
                    "write it in `[conditions.NAME]` in its place: `rate = \"{}\"`",
                    cut(&text)
                )),
        );
        true
    }

    /// A pinion and its rack: radius · angle − travel.
    fn read_rack(&mut self, fields: &Fields<'_>) -> Option<(CouplingKind, Expr, MotionKind)> {
        let help =
            "write `between = [\"A\", \"B\"]`: the joint of the pinion, then that of the rack";
        let joints = self.two_joints(fields, help);
        let phase = self.phase(fields, Quantity::LENGTH);
        let helix = self.helix(fields);
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
            (self.module_radii(fields, &[teeth], helix?)?[0], Some(number))
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
        let is_reversed = reversed.unwrap_or(Some(false))?;
        let radius = if is_reversed { pool.neg(radius) } else { radius };
        let travel = if is_first { pool.neg(travel) } else { travel };
        let relation = pool.sum([pool.mul(radius, angle), phase?, pool.neg(travel)]);
        let flanks = self.flanks(fields, true, [!is_reversed, !is_reversed])?;
        let rack = Rack { joints, bodies, radius, teeth, is_reversed, flanks };
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

    /// A value of one of two dimensions, and which of both; a bare number is of the first.
    pub(super) fn one_of(
        &mut self,
        node: &Node,
        what: &str,
        [(first, of_first), (second, of_second)]: [(Quantity, MotionKind); 2],
    ) -> Option<(Scalar, MotionKind)> {
        let n_faults = self.faults.len();
        if let Some(value) = self.scalar(node, first, what, Scope::Motion) {
            return Some((value, of_first));
        }
        // What is neither is said once.
        let faults = self.faults.split_off(n_faults);
        let is_other = faults.iter().all(|fault| fault.code == codes::WRONG_DIMENSION);
        if is_other && let Some(value) = self.scalar(node, second, what, Scope::Motion) {
            return Some((value, of_second));
        }
        self.faults.truncate(n_faults);
        self.faults.extend(faults);
        None
    }

    /// The position of the second member where that of the first is zero.
    pub(super) fn phase(&mut self, fields: &Fields<'_>, quantity: Quantity) -> Option<Expr> {
        match fields.get("phase") {
            Some(node) => {
                let what = fields.what("phase");
                Some(self.scalar(node, quantity, &what, Scope::Constant)?.expr)
            }
            None => Some(self.pool.zero()),
        }
    }
}
