//! The side on which curves touch, where their joint does not state it: the one that the initial values put them on.

use std::collections::HashMap;

use super::measure_of;
use bksim_expr::SymbolId;
use bksim_mbs::coordinate::{Coordinate, Owner};
use bksim_mbs::joint::alignments;
use bksim_mbs::kinematics::Kinematics;
use bksim_mbs::tree::Tree;
use bksim_model::Model;

/// Cosine of the tangents from which on initial values tell a side: those further off tell none.
const TOLD: f64 = 0.5;

/// Turns the joints of two curves over whose `tangents` are not stated and whose initial values, those of their own
/// parameters and of all joints that carry the curves, put the tangents the other way.
pub(crate) fn take_sides(model: &mut Model) {
    if !model.joints.iter().any(|joint| joint.kind.has_open_side()) {
        return;
    }
    let uncut = Kinematics::of_start(model, &Tree::uncut(model));
    let mut values: HashMap<SymbolId, f64> =
        model.parameters.iter().map(|p| (p.symbol, p.value)).collect();
    values.insert(model.time, model.solve.t_start);
    let given = |c: &Coordinate| {
        let measure = measure_of(model.space, c.owner)?;
        let initial = model.initial.iter().find(|initial| initial.measure == measure);
        let value = initial.and_then(|initial| {
            model.pool.evaluate(initial.value, &|symbol| values.get(&symbol).copied()).ok()
        });
        // A free body starts where the ground is.
        Some((c.q, value.or(matches!(c.owner, Owner::Body(..)).then_some(0.0))?))
    };
    let given: Vec<(SymbolId, f64)> = uncut.coordinates.iter().filter_map(given).collect();
    values.extend(given);
    let is_opposite = |joint: &bksim_model::Joint| {
        let cosines = alignments(&model.pool, joint, &uncut.sides(model, joint));
        let value = |cosine| model.pool.evaluate(cosine, &|symbol| values.get(&symbol).copied());
        cosines.into_iter().any(|cosine| value(cosine).is_ok_and(|cosine| cosine < -TOLD))
    };
    let turned = model.joints.iter().map(|joint| joint.kind.has_open_side() && is_opposite(joint));
    let turned: Vec<bool> = turned.collect();
    for (joint, is_turned) in model.joints.iter_mut().zip(turned) {
        if is_turned {
            joint.kind.turn_side();
        }
    }
}
