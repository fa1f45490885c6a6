//! Belts and chains around any number of wheels: the ways of their strands as expressions of positions.
//!
//! ```text
//! d = c₂ − c₁,  δ = r₂ − r₁            radii below zero where the belt turns right around a wheel
//! s = √(d·d − δ²)                      free length of the strand
//! e = (s d − δ ẑ × d)/d·d              its direction
//! ℓ = s − s₀ + (r₁ − r₂) ψ − r₁ α₁ + r₂ α₂       what it has gained between two marks on the wheels
//! w = π + atan2(∓ e₁ × e₂, −e₁·e₂)     wrap between two strands, 0 … 2π
//! ```
//!
//! Values with a zero are those where the start puts the wheels, and α are the angles of the wheels since then. ψ, the
//! angle from e₀ to e, counts all turns in a run, and is within half a turn in answers about single poses.

use std::cmp::Ordering;

use bksim_expr::{Expr, Function};

use super::codes;
use super::names::PREVIOUS;
use super::reader::{Fields, Reader};
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::{Scalar, Scope};
use crate::belt::{Belt, BeltWheel};
use crate::body::Anchor;
use crate::coupling::{Coupling, CouplingKind};
use crate::diagnostic::Diagnostic;
use crate::ids::{BeltId, BodyId, GROUND, JointId};
use crate::joint::MotionKind;
use crate::measure::{Axis, Measure, Signal};
use crate::state::{HeldChange, HeldSignal, NamedSignal};

/// The senses in which a belt turns around a wheel.
const TURNS: [(&str, bool); 2] = [("left", true), ("right", false)];

/// Keys of belts around two wheels that do not go with more.
const OF_TWO: [&str; 3] = ["crossed", "carrier", "phase"];

/// A quantity where the mechanism is, and where the start puts it.
#[derive(Clone, Copy)]
pub(super) struct Twin<T> {
    pub(super) now: T,
    pub(super) first: T,
}

/// A wheel with what its strands depend on.
pub(super) struct Wheel {
    /// The name of its joint or body.
    pub(super) name: String,
    /// Of its centre, m.
    pub(super) center: Twin<[Expr; 2]>,
    pub(super) is_fixed: bool,
    /// Below zero where the belt turns right.
    pub(super) radius: Expr,
    /// Angle since the start, rad.
    pub(super) angle: Expr,
}

/// A strand from one wheel to the next.
pub(super) struct Strand {
    pub(super) length: Twin<Expr>,
    pub(super) direction: Twin<[Expr; 2]>,
    /// Angle of its direction since the start, rad, on and on; zero where nothing depends on it.
    pub(super) turn: Expr,
    /// The length it has gained between two marks on the wheels, m.
    pub(super) gain: Expr,
}

impl Reader<'_> {
    /// True of a belt or chain that [`Reader::read_belt`] reads.
    pub(super) fn is_loop(fields: &Fields<'_>) -> bool {
        let is_long = match fields.get("between").map(|node| &node.value) {
            Some(Value::Array(wheels)) => wheels.len() > 2,
            _ => false,
        };
        is_long || ["turns", "length", "stiffness", "damping"].iter().any(|key| fields.has(key))
    }

    /// A belt around any number of wheels; its strands become couplings, or tensions where it stretches.
    pub(super) fn read_belt(&mut self, name: &str, fields: &Fields<'_>) -> Option<Vec<Coupling>> {
        if let Some(entry) = OF_TWO.iter().find_map(|key| fields.entry(key)) {
            let message =
                format!("{} has `{}`, which goes with two wheels", fields.owner, entry.key);
            self.report(
                Diagnostic::error(codes::KEY_CONFLICT, message)
                    .at(entry.key_span.clone(), "of no meaning here")
                    .help("remove it; `turns` says in which sense the belt goes around each wheel"),
            );
            return None;
        }
        let help = "write `between = [\"A\", \"B\", \"C\"]` with the joints about which they turn";
        let node = fields.require(self, "between", help)?;
        let what = fields.what("between");
        let nodes = self.array(node, &what, "an array of joints", "[\"A\", \"B\", \"C\"]")?;
        if nodes.len() < 2 {
            self.wrong_kind(node, &what, "two joints at least", &node.value, help);
            return None;
        }
        let joints: Vec<Option<JointId>> = nodes
            .iter()
            .enumerate()
            .map(|(at, node)| {
                let joint = self.joint_named(node, fields)?;
                self.turning_of(joint, fields, at).map(|_| joint)
            })
            .collect();
        let radii = self.belt_radii(nodes.len(), fields);
        let turns = self.belt_turns(nodes.len(), fields);
        let lengths = |reader: &mut Self, key: &str, quantity: Quantity| match fields.get(key) {
            Some(node) => {
                let what = fields.what(key);
                let scalar = reader.scalar(node, quantity, &what, Scope::Constant)?;
                let is_positive = reader.check_positive(&what, &scalar, quantity);
                is_positive.then_some(Some(scalar.expr))
            }
            None => Some(None),
        };
        let length = lengths(self, "length", Quantity::LENGTH);
        let stiffness = lengths(self, "stiffness", Quantity::STIFFNESS);
        let damping = lengths(self, "damping", Quantity::DAMPING);
        if fields.has("damping") {
            fields.require(self, "stiffness", "write for example `stiffness = \"2e5 N/m\"`")?;
        }
        if fields.has("stiffness") {
            let help = "write the length of the belt without load, such as `length = \"1.6 m\"`";
            fields.require(self, "length", help)?;
        }
        let joints = joints.into_iter().collect::<Option<Vec<_>>>()?;
        if let Some(again) = (1..joints.len()).find(|&k| joints[..k].contains(&joints[k])) {
            let message = format!("{} comes twice to the same wheel", fields.owner);
            self.report(
                Diagnostic::error(codes::BAD_RELATION, message)
                    .at(nodes[again].span.clone(), "the same joint again")
                    .help("name each wheel once, in the order in which the belt comes to it"),
            );
            return None;
        }
        let (radii, turns) = (radii?, turns?);
        let (length, stiffness, damping) = (length?, stiffness?, damping?);
        let wheels: Vec<Option<Wheel>> = joints
            .iter()
            .enumerate()
            .map(|(k, &joint)| {
                let radius = if turns[k] { radii[k] } else { self.pool.neg(radii[k]) };
                self.belt_wheel(joint, radius, &nodes[k], fields)
            })
            .collect();
        let wheels = wheels.into_iter().collect::<Option<Vec<_>>>()?;

        // The strands and the whole way.
        let n = wheels.len();
        let strands: Vec<Strand> =
            (0..n).map(|k| self.strand(name, [&wheels[k], &wheels[(k + 1) % n]], false)).collect();
        let wraps: Vec<Twin<Expr>> =
            (0..n).map(|k| self.wrap(turns[k], &strands[(k + n - 1) % n], &strands[k])).collect();
        let way = |of: fn(Twin<Expr>) -> Expr| {
            let pool = &self.pool;
            let arcs = wraps.iter().zip(&radii).map(|(wrap, &r)| pool.mul(r, of(*wrap)));
            pool.sum(strands.iter().map(|strand| of(strand.length)).chain(arcs).collect::<Vec<_>>())
        };
        let [way, first_way] = [way(|twin| twin.now), way(|twin| twin.first)];
        self.log_belt(name, &wheels, &strands, &wraps, way);

        // Its strands: each keeps its length, the last one that of the whole.
        let belt = BeltId(self.belts.len());
        let ends = |k: usize| format!("{}_{}", wheels[k].name, wheels[(k + 1) % n].name);
        let mut tensions = Vec::new();
        let mut couplings = Vec::new();
        let span = fields.location(&["length", "between"]);
        match (stiffness, length) {
            (Some(stiffness), Some(length)) => {
                let count = i32::try_from(n).unwrap_or(i32::MAX).into();
                let share = self.pool.div(self.pool.sub(first_way, length), self.pool.int(count));
                for (k, strand) in strands.iter().enumerate() {
                    let tension = self.tension(strand, share, (stiffness, damping));
                    tensions.push(tension);
                    self.log(format!("{name}_tension_{}", ends(k)), tension, "N", &span);
                }
            }
            _ => {
                for (k, strand) in strands.iter().enumerate() {
                    let pool = &self.pool;
                    let relation = match (length, (k + 1).cmp(&n)) {
                        (_, Ordering::Less) => strand.gain,
                        (Some(length), _) => pool.sum([strand.gain, first_way, pool.neg(length)]),
                        // The last strand of a belt that is as long as its way follows from the others.
                        (None, _) => continue,
                    };
                    couplings.push(Coupling {
                        name: format!("{name}_{}", ends(k)),
                        kind: CouplingKind::Strand(belt, k),
                        relation,
                        effort: MotionKind::Translation,
                        span: span.clone(),
                    });
                }
            }
        }
        let wheels = joints.iter().zip(&wheels);
        let wheels = wheels.map(|(&joint, w)| BeltWheel { joint, radius: w.radius }).collect();
        self.belts.push(Belt { name: name.to_owned(), wheels, length, way, tensions, span });
        Some(couplings)
    }

    /// The radii of the wheels, stated or by their teeth.
    fn belt_radii(&mut self, n: usize, fields: &Fields<'_>) -> Option<Vec<Expr>> {
        let forms = [("teeth", "radii"), ("radii", "module")];
        if forms.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        if fields.has("teeth") {
            let node = fields.get("teeth")?;
            let teeth = self.sizes(node, "teeth", (Quantity::NUMBER, n), fields)?;
            return self.module_radii(fields, &teeth, self.pool.zero());
        }
        let help = "write `radii = [\"50 mm\", \"30 mm\", \"120 mm\"]`, or `teeth` and `module`";
        let node = fields.require(self, "radii", help)?;
        let radii = self.sizes(node, "radii", (Quantity::LENGTH, n), fields)?;
        Some(radii.into_iter().map(|radius| radius.expr).collect())
    }

    /// Sizes above zero, as many as the belt has wheels.
    fn sizes(
        &mut self,
        node: &Node,
        key: &str,
        (quantity, n): (Quantity, usize),
        fields: &Fields<'_>,
    ) -> Option<Vec<Scalar>> {
        let what = fields.what(key);
        let nodes = self.each_wheel(node, &what, "sizes", n)?;
        let sizes: Vec<Option<Scalar>> = nodes
            .iter()
            .map(|node| {
                let size = self.scalar(node, quantity, &what, Scope::Constant)?;
                self.check_positive(&what, &size, quantity).then_some(size)
            })
            .collect();
        sizes.into_iter().collect()
    }

    /// True for each wheel around which the belt turns left, as it does where nothing is said.
    fn belt_turns(&mut self, n: usize, fields: &Fields<'_>) -> Option<Vec<bool>> {
        let Some(node) = fields.get("turns") else { return Some(vec![true; n]) };
        let what = fields.what("turns");
        let nodes = self.each_wheel(node, &what, "senses", n)?;
        let turns: Vec<Option<bool>> =
            nodes.iter().map(|node| self.choice(node, &what, &TURNS)).collect();
        turns.into_iter().collect()
    }

    /// An array with one element for each wheel.
    fn each_wheel<'n>(
        &mut self,
        node: &'n Node,
        what: &str,
        of: &str,
        n: usize,
    ) -> Option<&'n [Node]> {
        let expected = format!("an array of {n} {of}, one for each wheel");
        match &node.value {
            Value::Array(nodes) if nodes.len() == n => Some(nodes),
            other => {
                let help = "write them in the order of `between`";
                self.wrong_kind(node, what, &expected, other, help);
                None
            }
        }
    }

    fn belt_wheel(
        &mut self,
        joint: JointId,
        radius: Expr,
        node: &Node,
        fields: &Fields<'_>,
    ) -> Option<Wheel> {
        let [from, to] = self.joint_ends.get(joint.0).copied().flatten()?;
        let (carrier, wheel) = if to.body == GROUND { (to, from) } else { (from, to) };
        let named = [carrier, wheel].into_iter().find(|end| end.point.is_some());
        let center = match named {
            Some(anchor) => [Axis::X, Axis::Y].map(|axis| self.twin_of_point(anchor, axis)),
            None if carrier.body == GROUND => {
                [Twin { now: self.pool.zero(), first: self.pool.zero() }; 2]
            }
            None => {
                let name = self.names.joints[joint.0].name.clone();
                let message = format!("{}: the centre of `{name}` has no name", fields.owner);
                self.report(
                    Diagnostic::error(codes::UNKNOWN_POINT, message)
                        .at(node.span.clone(), "turns about the origin of a body")
                        .help("give the body a point there, and name it in `between` of the joint"),
                );
                return None;
            }
        };
        let [x, y] = center;
        let angle = self.twin_of_angle(wheel.body).now;
        let against = match carrier.body {
            GROUND => self.pool.zero(),
            body => self.twin_of_angle(body).first,
        };
        Some(Wheel {
            name: self.names.joints[joint.0].name.clone(),
            center: Twin { now: [x.now, y.now], first: [x.first, y.first] },
            is_fixed: carrier.body == GROUND,
            radius,
            angle: self.pool.sub(angle, against),
        })
    }

    pub(super) fn twin_of_point(&mut self, anchor: Anchor, axis: Axis) -> Twin<Expr> {
        let body = self.names.bodies[anchor.body.0].name.clone();
        let point = anchor.point.map_or(0, |point| point.0);
        let point = self.names.bodies[anchor.body.0].points[point].clone();
        let word = match axis {
            Axis::X => "x",
            Axis::Y => "y",
            Axis::Z => "z",
        };
        let measure = Measure::PointPosition(anchor.body, anchor.point, axis);
        self.twin(&format!("{body}.{point}.{word}"), measure)
    }

    pub(super) fn twin_of_angle(&mut self, body: BodyId) -> Twin<Expr> {
        let name = self.names.bodies[body.0].name.clone();
        self.twin(&format!("{name}.angle"), Measure::BodyAngle(body))
    }

    /// A position, and what it is where the start puts it.
    fn twin(&mut self, name: &str, measure: Measure) -> Twin<Expr> {
        let now = self.names.signal(&self.pool, name, measure);
        let known = self.at_start.iter().find(|signal| signal.measure == measure);
        if let Some(known) = known {
            return Twin { now, first: self.pool.symbol_expr(known.symbol) };
        }
        let first = self.pool.symbol(&format!("'start {name}"));
        if let Some(symbol) = self.pool.symbol_id(first) {
            self.at_start.push(Signal { symbol, measure });
        }
        Twin { now, first }
    }

    /// The strand of a belt or rope between two wheels; its turn is counted where its gain depends on that, or it is asked
    /// for.
    pub(super) fn strand(
        &mut self,
        owner: &str,
        [from, to]: [&Wheel; 2],
        is_asked_for: bool,
    ) -> Strand {
        let pool = &self.pool;
        let line = |centers: [[Expr; 2]; 2]| {
            let [x, y] = [0, 1].map(|i| pool.sub(centers[1][i], centers[0][i]));
            let delta = pool.sub(to.radius, from.radius);
            let square = pool.add(pool.mul(x, x), pool.mul(y, y));
            let length = pool.sqrt(pool.sub(square, pool.mul(delta, delta)));
            let along = pool.add(pool.mul(length, x), pool.mul(delta, y));
            let across = pool.sub(pool.mul(length, y), pool.mul(delta, x));
            (length, [pool.div(along, square), pool.div(across, square)])
        };
        let first = line([from.center.first, to.center.first]);
        let is_fixed = from.is_fixed && to.is_fixed;
        let now = if is_fixed { first } else { line([from.center.now, to.center.now]) };
        let is_wound = from.radius != to.radius || is_asked_for;
        let turn = if is_fixed || !is_wound {
            self.pool.zero()
        } else {
            self.counted_turn(owner, first.1, now.1)
        };
        let pool = &self.pool;
        let rolled = pool.mul(pool.sub(from.radius, to.radius), turn);
        let turned = pool.sub(pool.mul(to.radius, to.angle), pool.mul(from.radius, from.angle));
        let gain = pool.sum([pool.sub(now.0, first.0), rolled, turned]);
        Strand {
            length: Twin { now: now.0, first: first.0 },
            direction: Twin { now: now.1, first: first.1 },
            turn,
            gain,
        }
    }

    /// Angle from a direction at the start to the present one, rad, on and on.
    ///
    /// ```text
    /// π k + atan2(c e₀ × e, c e₀ · e),  c = cos π k       k half turns, which a run counts
    /// ```
    fn counted_turn(&mut self, owner: &str, first: [Expr; 2], now: [Expr; 2]) -> Expr {
        let mut number = 1;
        let mut name = format!("{owner}_half_turns_{number}");
        while self.names.plain(&name).is_some() || self.counts.iter().any(|of| of.name == name) {
            number += 1;
            name = format!("{owner}_half_turns_{number}");
        }
        let pool = &self.pool;
        let [count, previous] =
            [name.clone(), format!("'{PREVIOUS}_{name}")].map(|name| pool.symbol(&name));
        let half_turns = pool.mul(pool.pi(), count);
        let sense = pool.call(Function::Cos, &[half_turns]).expect("one argument");
        let [cross, dot] = self.between_directions(first, now).map(|part| pool.mul(sense, part));
        let left_over = self.angle_of(cross, dot);
        let turn = pool.add(half_turns, left_over);
        let symbol = |expr| pool.symbol_id(expr).expect("a symbol was just made");
        let signal = HeldSignal {
            held: symbol(count),
            previous: symbol(previous),
            name,
            start: pool.zero(),
            change: HeldChange::HalfTurn { left_over },
            span: 0..0,
        };
        self.counts.push(signal);
        turn
    }

    /// Cross product and dot product of two directions.
    pub(super) fn between_directions(&self, a: [Expr; 2], b: [Expr; 2]) -> [Expr; 2] {
        let pool = &self.pool;
        let cross = pool.sub(pool.mul(a[0], b[1]), pool.mul(a[1], b[0]));
        [cross, pool.add(pool.mul(a[0], b[0]), pool.mul(a[1], b[1]))]
    }

    pub(super) fn angle_of(&self, sine: Expr, cosine: Expr) -> Expr {
        self.pool.call(Function::Atan2, &[sine, cosine]).expect("two arguments")
    }

    pub(super) fn wrap(&self, turns_left: bool, before: &Strand, after: &Strand) -> Twin<Expr> {
        let pool = &self.pool;
        let wrap = |a: [Expr; 2], b: [Expr; 2]| {
            let [cross, dot] = self.between_directions(a, b);
            let sine = if turns_left { pool.neg(cross) } else { cross };
            pool.add(pool.pi(), self.angle_of(sine, pool.neg(dot)))
        };
        Twin {
            now: wrap(before.direction.now, after.direction.now),
            first: wrap(before.direction.first, after.direction.first),
        }
    }

    /// Stiffness times what a strand is longer than without load, and damping times its rate: a belt only pulls.
    fn tension(
        &mut self,
        strand: &Strand,
        share: Expr,
        (stiffness, damping): (Expr, Option<Expr>),
    ) -> Expr {
        let elastic = self.pool.mul(stiffness, self.pool.add(strand.gain, share));
        let viscous = match damping {
            Some(damping) => {
                let rate = self.rate_of(strand.gain);
                self.pool.mul(damping, rate)
            }
            None => self.pool.zero(),
        };
        let pool = &self.pool;
        let pull = pool.add(elastic, viscous);
        pool.call(Function::Max, &[pool.zero(), pull]).expect("two arguments")
    }

    /// The lengths and wraps of a belt, as signals.
    fn log_belt(
        &mut self,
        name: &str,
        wheels: &[Wheel],
        strands: &[Strand],
        wraps: &[Twin<Expr>],
        way: Expr,
    ) {
        let span = 0..0;
        self.log(format!("{name}_length"), way, "m", &span);
        for (k, strand) in strands.iter().enumerate() {
            let [from, to] = [&wheels[k].name, &wheels[(k + 1) % wheels.len()].name];
            self.log(format!("{name}_strand_{from}_{to}"), strand.length.now, "m", &span);
        }
        for (wheel, wrap) in wheels.iter().zip(wraps) {
            self.log(format!("{name}_wrap_{}", wheel.name), wrap.now, "rad", &span);
        }
    }

    pub(super) fn log(
        &mut self,
        name: String,
        value: Expr,
        unit: &str,
        span: &crate::diagnostic::Span,
    ) {
        // A name that the author has given to something else keeps its meaning.
        if self.names.plain(&name).is_none() {
            let unit = unit.to_owned();
            self.belt_signals.push(NamedSignal {
                name,
                value,
                unit,
                is_output: false,
                span: span.clone(),
            });
        }
    }
}
