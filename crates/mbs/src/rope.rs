//! Ropes: the forces with which a part of one pulls at its ends and at all that it goes over.
//!
//! Each span pulls along itself at the place where it leaves or meets a pulley, as a [strand](crate::belt) does. Over what
//! a rope slips, both spans pull alike, and their moments about its centre are equal and opposite.

use std::ops::Range;

use bksim_expr::{Expr, Function, Pool, SymbolId};
use bksim_model::{CouplingKind, LoadId, Model, RopeId};

use crate::belt::span_wrenches;
use crate::constraint::{Constraint, Source};
use crate::force::Wrench;
use crate::kinematics::Kinematics;
use crate::kinematics::bending::bearer;
use crate::signal::signal_values;

/// The wrenches of the part of this number with a pull of one.
pub(crate) fn section_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    rope: RopeId,
    section: usize,
) -> Vec<Wrench> {
    let spans = model.ropes[rope.0].sections[section].spans.clone();
    wrenches_of(model, kinematics, rope, spans)
}

/// The wrenches of a unit friction along the way that a rope has slipped back over a node: its part up to there pulls
/// less.
pub(crate) fn slip_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    rope: RopeId,
    (section, node): (usize, usize),
) -> Vec<Wrench> {
    let first = model.ropes[rope.0].sections[section].spans.start;
    let pull = wrenches_of(model, kinematics, rope, first..node);
    pull.iter().map(|wrench| wrench.scaled(&model.pool, model.pool.int(-1))).collect()
}

/// The pulls of a rope before and after the node at which a load of friction acts.
///
/// ```text
/// T₋ = T₊ − λ + ς F       F = |T₊| ς (exp(ς μ φ) − 1)
/// ```
///
/// λ is the friction while it grips, F that while it slips.
pub(crate) fn pulls(model: &Model, constraints: &[Constraint], load: LoadId) -> [Expr; 2] {
    let pool = &model.pool;
    let (rope, section, node) = model.loads[load.0].kind.rope_node().expect("friction of a rope");
    // The pull after the last node that rubs is the multiplier of the whole part; nodes before it follow from there.
    let is_whole = |row: &&Constraint| match row.source {
        Source::Coupling(id) => model.couplings[id.0].kind == CouplingKind::Rope(rope, section),
        _ => false,
    };
    let whole = constraints.iter().find(is_whole);
    let mut pull = whole.map_or(pool.zero(), |row| pool.symbol_expr(row.lambda));
    let later = model.loads.iter().enumerate().rev().filter_map(|(k, load)| {
        let ((of, part, at), (_, [sliding, _])) = load.kind.rope_node().zip(load.kind.grip())?;
        ((of, part) == (rope, section) && at >= node).then_some((LoadId(k), sliding))
    });
    let mut after = pull;
    for (id, sliding) in later {
        let row = constraints.iter().find(|row| row.source == Source::Friction(id));
        let lambda = row.map_or(pool.zero(), |row| pool.symbol_expr(row.lambda));
        let slip = pool.symbol(&format!("'slip{}", id.0));
        let friction =
            pool.mul(slip, friction_of(model, id, after_of(pool, pull), (sliding, slip)));
        after = pull;
        pull = pool.sum([pull, pool.neg(lambda), friction]);
    }
    [pull, after]
}

/// Friction for a pull after the node, in a sense of slipping.
fn friction_of(model: &Model, load: LoadId, after: Expr, (mu, slip): (Expr, Expr)) -> Expr {
    let pool = &model.pool;
    let (wrap, _) = model.loads[load.0].kind.grip().expect("friction of a rope");
    let exponent = pool.product([slip, mu, wrap]);
    let growth = pool.call(Function::Exp, &[exponent]).expect("one argument");
    pool.product([after, slip, pool.sub(growth, pool.one())])
}

/// Friction at a node of a rope for a coefficient of friction and a sense of slipping, N.
pub(crate) fn friction(
    model: &Model,
    constraints: &[Constraint],
    load: LoadId,
    law: (Expr, Expr),
) -> Expr {
    let [_, after] = pulls(model, constraints, load);
    friction_of(model, load, after_of(&model.pool, after), law)
}

/// Size of a pull.
fn after_of(pool: &Pool, pull: Expr) -> Expr {
    pool.call(Function::Abs, &[pull]).expect("one argument")
}

fn wrenches_of(
    model: &Model,
    kinematics: &Kinematics,
    rope: RopeId,
    spans: Range<usize>,
) -> Vec<Wrench> {
    let (pool, rope) = (&model.pool, &model.ropes[rope.0]);
    let between = |ends: [usize; 2]| {
        let nodes = ends.map(|k| &rope.nodes[k]);
        let centers = nodes.map(|node| kinematics.anchor(model, node.center));
        let bodies = nodes.map(|node| bearer(model, node.center));
        span_wrenches(pool, centers, centers, bodies, nodes.map(|node| node.radius))
    };
    if rope.nodes.iter().all(|node| !node.leaves) {
        return spans.flat_map(|k| between([k, k + 1])).collect();
    }
    // Spans to what the rope may leave while they are in contact, and the straight span past it while they are not.
    let signals = signal_values(model, kinematics);
    let in_contact = |k: usize| {
        let turn = rope.nodes[k].turn.filter(|_| rope.nodes[k].leaves)?;
        let turn = pool.substitute(turn, &signals);
        Some(pool.call(Function::Ge, &[turn, pool.zero()]).expect("two arguments"))
    };
    let part = |ends: [usize; 2], share: Expr| -> Vec<Wrench> {
        between(ends).iter().map(|wrench| wrench.scaled(pool, share)).collect()
    };
    let of_span = |k: usize| match in_contact(k).or_else(|| in_contact(k + 1)) {
        Some(in_contact) => part([k, k + 1], in_contact),
        None => between([k, k + 1]),
    };
    let inner = spans.start + 1..spans.end;
    let straight = inner.filter_map(|k| {
        in_contact(k).map(|in_contact| part([k - 1, k + 1], pool.sub(pool.one(), in_contact)))
    });
    let straight: Vec<Wrench> = straight.flatten().collect();
    spans.flat_map(of_span).chain(straight).collect()
}

/// The wrenches of the parts of an elastic rope, none of another; `signals` are the measures as expressions.
pub(crate) fn elastic_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    rope: RopeId,
) -> Vec<Wrench> {
    let pool = &model.pool;
    let mut wrenches = Vec::new();
    for (number, section) in model.ropes[rope.0].sections.iter().enumerate() {
        let Some(pull) = section.pull else { continue };
        let pull = pool.substitute(pull, signals);
        let unit = section_wrenches(model, kinematics, rope, number);
        wrenches.extend(unit.iter().map(|wrench| wrench.scaled(pool, pull)));
    }
    wrenches
}
