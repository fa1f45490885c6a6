//! Ropes: the forces with which a part of one pulls at its ends and at all that it goes over.
//!
//! Each span pulls along itself at the place where it leaves or meets a pulley, as a [strand](crate::belt) does. Over what
//! a rope slips, both spans pull alike, and their moments about its centre are equal and opposite.

use bksim_expr::{Expr, SymbolId};
use bksim_model::{Model, RopeId};

use crate::belt::span_wrenches;
use crate::force::Wrench;
use crate::kinematics::Kinematics;

/// The wrenches of the part of this number with a pull of one.
pub(crate) fn section_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    rope: RopeId,
    section: usize,
) -> Vec<Wrench> {
    let rope = &model.ropes[rope.0];
    let spans = rope.sections[section].spans.clone();
    let of_span = |k: usize| {
        let nodes = [&rope.nodes[k], &rope.nodes[k + 1]];
        let centers = nodes.map(|node| kinematics.anchor(model, node.center));
        let bodies = nodes.map(|node| node.center.body);
        span_wrenches(&model.pool, centers, centers, bodies, nodes.map(|node| node.radius))
    };
    spans.flat_map(of_span).collect()
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
