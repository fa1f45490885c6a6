//! Ropes: their ways as expressions of positions.
//!
//! With the spans of [belts](super::belts), each from its node k to the next, a rope whose part between two places that
//! it does not slip over has gained
//!
//! ```text
//! ℓ = Σ s_k − s_k0 + (r_k − r_k+1) ψ_k + r_b α_b − r_a α_a      α the turns of what holds its ends
//! ```
//!
//! Such a part is a condition ℓ + w₀ = l, a limit ℓ + w₀ ≤ l where the rope may become slack, or pulls with
//! EA δ/(w − δ), δ = ℓ + w₀ − l, for its way w and w₀ of the start.

use bksim_expr::{Expr, Function};

use super::belts::{Strand, Twin, Wheel};
use super::codes;
use super::leaving::Beside;
use super::reader::{Fields, Reader};
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::Anchor;
use crate::coupling::{Coupling, CouplingKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::{GROUND, RopeId};
use crate::joint::MotionKind;
use crate::load::{Load, LoadKind};
use crate::measure::{Axis, Measure};
use crate::rope::{Rope, RopeGrip, RopeNode, RopeSection};
use crate::state::NamedSignal;

/// Keys of a rope.
pub(super) const ROPE_KEYS: &[&str] =
    &["type", "over", "length", "EA", "stiffness", "damping", "slack", "restitution"];

/// Keys of what a rope goes over; `pulley` and `drum` are the same thing inside and at an end.
const NODE_KEYS: [&str; 9] =
    ["pulley", "drum", "radius", "turn", "whole_turns", "slips", "mu", "static", "leaves"];

/// The senses in which a rope goes around a pulley.
const TURNS: [(&str, bool); 2] = [("left", true), ("right", false)];

/// A node with what the rope's way depends on.
struct Stop {
    wheel: Wheel,
    center: Anchor,
    /// True if the rope turns left around it.
    is_left: bool,
    /// True if the rope ends a part here: at its ends and where it does not slip.
    holds: bool,
    /// Coefficients of friction where it slips under a large difference of pulls.
    mu: Option<[Expr; 2]>,
    /// True if the rope may leave it.
    leaves: bool,
    /// Whole turns of the rope about it at the start besides those that it needs, where they are stated.
    whole_turns: Option<Expr>,
}

/// How a rope resists being longer.
enum Give {
    Rigid,
    Slack {
        restitution: Expr,
    },
    /// Of the whole cross-section, N, or of each part, N/m, and the damping of each part.
    Elastic {
        modulus: Option<Expr>,
        stiffness: Option<Expr>,
        damping: Option<Expr>,
        pushes: bool,
    },
}

impl Reader<'_> {
    /// A rope; its parts become couplings, stops or pulls.
    pub(super) fn read_rope(&mut self, name: &str, fields: &Fields<'_>) -> Option<Vec<Coupling>> {
        let help = "write `over = [\"ground.P\", { pulley = \"sheave.C\", radius = \"80 mm\", turn = \"left\" }, \"load.hook\"]`";
        let node = fields.require(self, "over", help)?;
        let what = fields.what("over");
        let nodes = self.array(
            node,
            &what,
            "an array of ends and pulleys",
            "[\"ground.P\", \"load.hook\"]",
        )?;
        if nodes.len() < 2 {
            self.wrong_kind(node, &what, "two ends at least", &node.value, help);
            return None;
        }
        let last = nodes.len() - 1;
        let stops: Vec<Option<Stop>> = (nodes.iter().enumerate())
            .map(|(k, node)| self.rope_node(node, k == 0 || k == last, fields))
            .collect();
        let give = self.rope_give(fields);
        let length = match fields.get("length") {
            Some(node) => {
                let what = fields.what("length");
                let scalar = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
                self.check_positive(&what, &scalar, Quantity::LENGTH)
                    .then_some(Some(scalar.expr))?
            }
            None => None,
        };
        let stops = stops.into_iter().collect::<Option<Vec<_>>>()?;
        let rubs = stops.iter().any(|stop| stop.mu.is_some());
        if rubs && matches!(give, Some(Give::Elastic { .. } | Give::Slack { .. })) {
            let message = format!("{} rubs, and stretches or becomes slack", fields.owner);
            self.report(
                Diagnostic::error(codes::NO_GRIP, message)
                    .at(fields.location(&["EA", "stiffness", "slack", "restitution"]), "here")
                    .note("friction by `mu` is that of a taut rope of constant length")
                    .help("remove this key, or `mu`"),
            );
            return None;
        }
        let marks: Vec<(bool, bool)> =
            stops.iter().map(|stop| (stop.leaves, stop.mu.is_some())).collect();
        if !self.check_leaves(&marks, fields) {
            return None;
        }
        Some(self.lay_rope(name, fields, &stops, &give?, length))
    }

    /// An end, `"body.point"` or a drum; between the ends a pulley, or an eye through which the rope slips.
    fn rope_node(&mut self, node: &Node, is_end: bool, fields: &Fields<'_>) -> Option<Stop> {
        let zero = self.pool.zero();
        let what = fields.what("over");
        let Value::Table(table) = &node.value else {
            let center = self.anchor(node, &what, &fields.owner)?;
            let wheel = self.rope_wheel(center, zero, false, node, fields)?;
            return Some(Stop {
                wheel,
                center,
                is_left: true,
                holds: is_end,
                mu: None,
                leaves: false,
                whole_turns: None,
            });
        };
        let owner = format!("`over` of {}", fields.owner);
        let own = Fields::open(self, table, owner, node.span.clone(), &NODE_KEYS);
        if own.conflict(self, "pulley", "drum") {
            return None;
        }
        let key = if own.has("drum") { "drum" } else { "pulley" };
        let help = "write `pulley = \"sheave.C\"`, or at an end `drum = \"drum.C\"`: its centre";
        let center = own.require(self, key, help)?;
        let center = self.anchor(center, &own.what(key), &own.owner);
        let radius = own.require(self, "radius", "write for example `radius = \"80 mm\"`")?;
        let what = own.what("radius");
        let radius = self.scalar(radius, Quantity::LENGTH, &what, Scope::Constant)?;
        let is_eye = radius.value.is_some_and(|value| value.look() == 0.0);
        if !is_eye && !self.check_positive(&what, &radius, Quantity::LENGTH) {
            return None;
        }
        let is_left = match own.get("turn") {
            Some(node) => self.choice(node, &own.what("turn"), &TURNS)?,
            None if is_eye => true,
            None => {
                let help = "write `turn = \"left\"` where the rope goes around it counter-clockwise on its way from \
                    the first end, `\"right\"` where it goes clockwise";
                own.require(self, "turn", help)?;
                return None;
            }
        };
        let slips = match own.get("slips") {
            Some(node) => self.flag(node, &own.what("slips"))?,
            None => false,
        };
        let mu = self.rope_friction(&own, is_end || is_eye)?;
        let center = center?;
        let holds = is_end || !(slips || is_eye || center.body == GROUND || mu.is_some());
        let leaves = self.rope_leaves(&own, (is_end, holds))?;
        let whole_turns = self.whole_turns(&own, is_end || is_eye)?;
        let signed = if is_left { radius.expr } else { self.pool.neg(radius.expr) };
        let wheel = self.rope_wheel(center, signed, holds || mu.is_some(), node, fields)?;
        Some(Stop { wheel, center, is_left, holds, mu, leaves, whole_turns })
    }

    /// Coefficients of the friction of a rope, `Some(None)` where they are not stated.
    #[expect(clippy::option_option, reason = "at fault, not stated, or stated")]
    fn rope_friction(&mut self, own: &Fields<'_>, has_no_arc: bool) -> Option<Option<[Expr; 2]>> {
        if own.conflict(self, "mu", "slips") {
            return None;
        }
        let mut coefficient = |key: &str| match own.get(key) {
            Some(node) => {
                let what = own.what(key);
                let mu = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
                self.check_positive(&what, &mu, Quantity::NUMBER).then_some(Some(mu.expr))
            }
            None => Some(None),
        };
        let [sliding, sticking] = [coefficient("mu")?, coefficient("static")?];
        let Some(sliding) = sliding else {
            if own.has("static") {
                own.require(self, "mu", "write for example `mu = 0.15`")?;
            }
            return Some(None);
        };
        if has_no_arc {
            let message = format!("{} has `mu` where the rope goes around nothing", own.owner);
            self.report(
                Diagnostic::error(codes::NO_GRIP, message)
                    .at(own.location(&["mu"]), "an end, or an eye without a radius")
                    .help("remove `mu`, or write it of a pulley or post between the ends"),
            );
            return None;
        }
        Some(Some([sliding, sticking.unwrap_or(sliding)]))
    }

    /// A point or the centre of a pulley as a wheel, whose turns count where it holds the rope.
    fn rope_wheel(
        &mut self,
        center: Anchor,
        radius: Expr,
        holds: bool,
        node: &Node,
        fields: &Fields<'_>,
    ) -> Option<Wheel> {
        let zero = self.pool.zero();
        let body = self.names.bodies[center.body.0].name.clone();
        let at = match center.point {
            Some(_) => [Axis::X, Axis::Y].map(|axis| self.twin_of_point(center, axis)),
            None if center.body == GROUND => [Twin { now: zero, first: zero }; 2],
            None => {
                let message = format!("{}: this place on `{body}` has no name", fields.owner);
                self.report(
                    Diagnostic::error(codes::UNKNOWN_POINT, message)
                        .at(node.span.clone(), "the origin of a body")
                        .help(format!(
                            "give the body a point there, `points = {{ P = [0, 0] }}`, and write `{body}.P`"
                        )),
                );
                return None;
            }
        };
        let angle = if holds && center.body != GROUND {
            let turned = self.twin_of_angle(center.body);
            self.pool.sub(turned.now, turned.first)
        } else {
            zero
        };
        Some(Wheel {
            name: body,
            center: Twin { now: at.map(|twin| twin.now), first: at.map(|twin| twin.first) },
            is_fixed: center.body == GROUND,
            radius,
            angle,
        })
    }

    /// Behaviour of a rope when it is pulled, and when it is not.
    fn rope_give(&mut self, fields: &Fields<'_>) -> Option<Give> {
        if fields.conflict(self, "EA", "stiffness") {
            return None;
        }
        let elastic = ["EA", "stiffness"].into_iter().find(|key| fields.has(key));
        let size = |reader: &mut Self, key: &str, quantity: Quantity| match fields.get(key) {
            Some(node) => {
                let what = fields.what(key);
                let scalar = reader.scalar(node, quantity, &what, Scope::Constant)?;
                reader.check_positive(&what, &scalar, quantity).then_some(Some(scalar.expr))
            }
            None => Some(None),
        };
        let modulus = size(self, "EA", Quantity::FORCE);
        let stiffness = size(self, "stiffness", Quantity::STIFFNESS);
        let damping = size(self, "damping", Quantity::DAMPING);
        let slack = match fields.get("slack") {
            Some(node) => Some(self.flag(node, &fields.what("slack"))?),
            None => None,
        };
        let (modulus, stiffness, damping) = (modulus?, stiffness?, damping?);
        if let Some(key) = elastic {
            if fields.conflict(self, key, "restitution") {
                return None;
            }
            // It only pulls unless the author says that it stays taut.
            let pushes = slack == Some(false);
            return Some(Give::Elastic { modulus, stiffness, damping, pushes });
        }
        if fields.has("damping") {
            fields.require(self, "EA", "write for example `EA = \"2 MN\"`, or a `stiffness`")?;
        }
        let restitution = match fields.get("restitution") {
            Some(node) => Some(self.restitution(node, &fields.what("restitution"))?),
            None => None,
        };
        match (slack, restitution) {
            (Some(false) | None, None) => Some(Give::Rigid),
            (Some(false), Some(_)) => {
                let message = format!("{} has a `restitution` and is never slack", fields.owner);
                self.report(
                    Diagnostic::error(codes::KEY_CONFLICT, message)
                        .at(fields.location(&["restitution"]), "of a rope that becomes taut again")
                        .help("remove it, or write `slack = true`"),
                );
                None
            }
            (_, restitution) => {
                Some(Give::Slack { restitution: restitution.unwrap_or(self.pool.zero()) })
            }
        }
    }

    /// Puts the part of its largest friction with which a rope grips among the results: below zero where the pull after
    /// it is the larger one, ±1 where it slips.
    fn log_grip(&mut self, parts: &[String; 2], kind: &LoadKind, span: &Span) {
        let Some((wrap, [_, sticking])) = kind.grip() else { return };
        let mut pull = |name: &String| {
            let idx = self.names.forces.iter().position(|(known, _)| known == name)?;
            let name = format!("couplings.{name}");
            Some(self.names.signal(&self.pool, &name, Measure::Force(idx)))
        };
        let [Some(before), Some(after)] = [pull(&parts[0]), pull(&parts[1])] else { return };
        let pool = &self.pool;
        let ratio = pool.call(Function::Ln, &[pool.div(before, after)]).expect("one argument");
        let value = pool.div(ratio, pool.mul(sticking, wrap));
        let name = format!("{}_grip", parts[0]);
        if self.names.plain(&name).is_none() {
            let (unit, span) = (String::new(), span.clone());
            self.belt_signals.push(NamedSignal { name, value, unit, is_output: true, span });
        }
    }

    /// The parts of a rope, with what keeps their lengths.
    fn lay_rope(
        &mut self,
        name: &str,
        fields: &Fields<'_>,
        stops: &[Stop],
        give: &Give,
        length: Option<Expr>,
    ) -> Vec<Coupling> {
        let n_spans = stops.len() - 1;
        let has_arc = |k: usize| {
            (1..n_spans).contains(&k)
                && (stops[k].leaves || !self.pool.is_zero(stops[k].wheel.radius))
        };
        let is_around: Vec<bool> = (0..stops.len()).map(has_arc).collect();
        let mut spans: Vec<Strand> = (0..n_spans)
            .map(|k| {
                let wheels = [&stops[k].wheel, &stops[k + 1].wheel];
                self.strand(name, wheels, is_around[k] || is_around[k + 1])
            })
            .collect();
        let mut turns = vec![None; stops.len()];
        for k in (1..n_spans).filter(|&k| stops[k].leaves) {
            let wheels = [&stops[k - 1].wheel, &stops[k].wheel, &stops[k + 1].wheel];
            let Stop { is_left, whole_turns, .. } = stops[k];
            let beside = Beside { owner: name, wheels, is_left, whole_turns };
            let [before, after] = &mut spans[k - 1..=k] else { unreachable!("two spans") };
            turns[k] = Some(self.leave(&beside, [before, after]));
        }
        // Arcs around what the rope goes over; that of a place which it may leave is in the span before it.
        let zero = self.pool.zero();
        let mut arcs = vec![Twin { now: zero, first: zero }; n_spans - 1];
        for k in (1..n_spans).filter(|&k| is_around[k] && !stops[k].leaves) {
            let Stop { is_left, ref wheel, whole_turns, .. } = stops[k];
            let sides = [&spans[k - 1], &spans[k]];
            let least = self.wrap(is_left, sides[0], sides[1]).first;
            let first = self.with_whole_turns(least, whole_turns);
            let now = self.turn_about(is_left, sides, first);
            let pool = &self.pool;
            let radius = if is_left { wheel.radius } else { pool.neg(wheel.radius) };
            arcs[k - 1] = Twin { now: pool.mul(radius, now), first: pool.mul(radius, first) };
            turns[k] = Some(now);
        }
        let total = |reader: &Self, of: fn(&Twin<Expr>) -> Expr| {
            let lengths = spans.iter().map(|span| of(&span.length));
            reader.pool.sum(lengths.chain(arcs.iter().map(of)).collect::<Vec<_>>())
        };
        let [way, first_way] = [total(self, |twin| twin.now), total(self, |twin| twin.first)];
        let unit = fields.location(&["over"]);
        self.log(format!("{name}_length"), way, "m", &unit);

        let held: Vec<usize> = (0..stops.len()).filter(|&k| stops[k].holds).collect();
        let id = RopeId(self.ropes.len());
        let (mut sections, mut couplings) = (Vec::new(), Vec::new());
        for (number, ends) in held.windows(2).enumerate() {
            let [from, to] = [ends[0], ends[1]];
            let is_last = to == stops.len() - 1;
            let n_rubbing =
                |to: usize| stops[1..to].iter().filter(|stop| stop.mu.is_some()).count();
            let is_whole = held.len() == 2 && n_rubbing(stops.len() - 1) == 0;
            // The last of the pulls between two places that hold; each place that rubs has one before it.
            let part_name = |to: usize, number: usize| format!("{name}_{}", number + n_rubbing(to));
            let own = if is_whole { name.to_owned() } else { part_name(to, number + 1) };
            let gain: Vec<Expr> = spans[from..to].iter().map(|span| span.gain).collect();
            let gain = self.pool.sum(gain);
            let inner = &arcs[from..to - 1];
            let part = |reader: &Self, of: fn(&Twin<Expr>) -> Expr| {
                let lengths = spans[from..to].iter().map(|span| of(&span.length));
                reader.pool.sum(lengths.chain(inner.iter().map(of)).collect::<Vec<_>>())
            };
            let pool = &self.pool;
            // What a part is longer at the start than it is by itself: rigid ropes have all of it in the last.
            let more = match (give, length) {
                (Give::Elastic { .. }, Some(length)) => {
                    let first = part(self, |twin| twin.first);
                    let share = pool.sub(pool.one(), pool.div(length, first_way));
                    pool.mul(first, share)
                }
                (_, Some(length)) if is_last => pool.sub(first_way, length),
                _ => pool.zero(),
            };
            let excess = pool.add(gain, more);
            let span = fields.location(&["length", "over"]);
            for node in (from + 1..to).filter(|&node| stops[node].mu.is_some()) {
                let before: Vec<Expr> = spans[from..node].iter().map(|span| span.gain).collect();
                let wrap = turns[node].unwrap_or(self.pool.zero());
                let kind = LoadKind::Capstan {
                    rope: id,
                    section: number,
                    node,
                    slipped: self.pool.sum(before),
                    wrap,
                    mu: stops[node].mu.unwrap_or([self.pool.zero(); 2]),
                };
                let names = [number, number + 1].map(|part| part_name(node, part + 1));
                self.log(format!("{}_wrap", names[0]), wrap, "rad", &span);
                self.log_grip(&names, &kind, &span);
                let [name, _] = names;
                self.rope_loads.push(Load { name, kind, span: span.clone() });
            }
            let mut pull = None;
            match give {
                Give::Rigid => couplings.push(Coupling {
                    name: own.clone(),
                    kind: CouplingKind::Rope(id, number),
                    relation: excess,
                    effort: MotionKind::Translation,
                    span,
                }),
                Give::Slack { restitution } => self.rope_loads.push(Load {
                    name: own.clone(),
                    kind: LoadKind::Rope {
                        rope: id,
                        section: number,
                        excess,
                        restitution: *restitution,
                    },
                    span,
                }),
                Give::Elastic { modulus, stiffness, damping, pushes } => {
                    let now = part(self, |twin| twin.now);
                    let pool = &self.pool;
                    let unloaded = pool.sub(now, excess);
                    let stiffness = match (modulus, stiffness) {
                        (Some(modulus), _) => pool.div(*modulus, unloaded),
                        (None, stiffness) => stiffness.unwrap_or(pool.zero()),
                    };
                    let elastic = pool.mul(stiffness, excess);
                    let viscous = match damping {
                        Some(damping) => {
                            let rate = self.rate_of(excess);
                            self.pool.mul(*damping, rate)
                        }
                        None => self.pool.zero(),
                    };
                    let pool = &self.pool;
                    let sum = pool.add(elastic, viscous);
                    let pull_only = || pool.call(Function::Max, &[pool.zero(), sum]);
                    let own_pull = if *pushes { sum } else { pull_only().expect("two arguments") };
                    self.log(format!("{own}_pull"), own_pull, "N", &span);
                    pull = Some(own_pull);
                }
            }
            sections.push(RopeSection { name: own, spans: from..to, excess, pull });
        }
        let node = |(stop, turn): (&Stop, Option<Expr>)| {
            let Stop { center, is_left, leaves, .. } = *stop;
            let grip = if stop.holds { RopeGrip::Holds } else { RopeGrip::Slips };
            let is_counted = stop.whole_turns.is_some();
            RopeNode { center, radius: stop.wheel.radius, is_left, grip, turn, leaves, is_counted }
        };
        let nodes = stops.iter().zip(turns).map(node).collect();
        let span = fields.location(&["over"]);
        self.ropes.push(Rope { name: name.to_owned(), nodes, sections, length, span });
        couplings
    }
}
