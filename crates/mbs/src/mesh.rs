//! Teeth that give: a force of stated size along the pitch circles of a gear or rack, with the forces across them.

use bksim_expr::{Expr, Function, SymbolId};

use crate::coupling::{parting, wrenches};
use crate::force::Wrench;
use crate::kinematics::Kinematics;
use crate::spatial;
use bksim_model::{LoadKind, Model};

/// The wrenches of teeth that give, none of another load; `signals` are the measures as expressions.
///
/// # Panics
/// Never: `abs` has one argument.
pub(crate) fn elastic_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    kind: &LoadKind,
) -> Vec<Wrench> {
    let LoadKind::Mesh { teeth, force } = kind else { return Vec::new() };
    let pool = &model.pool;
    // Above zero the force turns the second forward; its size parts the two.
    let force = pool.substitute(*force, signals);
    let along = wrenches(model, kinematics, teeth, signals);
    let sense = if teeth.kind.is_reversed() { pool.neg(force) } else { force };
    let mut all: Vec<Wrench> = along.iter().map(|wrench| wrench.scaled(pool, sense)).collect();
    let size = pool.call(Function::Abs, &[force]).expect("one argument");
    let apart = parting(model, kinematics, &teeth.kind).into_iter().flat_map(|(parts, _)| parts);
    all.extend(apart.map(|wrench| wrench.scaled(pool, size)));
    // Generalised forces of loads ask for points of the bodies themselves, which the pitch point is not.
    for wrench in &mut all {
        let own = kinematics.poses[wrench.body.0].anchor_world;
        let arm = spatial::sub(pool, &wrench.at, &own);
        let turning = spatial::cross(pool, &arm, &wrench.force);
        wrench.moment = spatial::add(pool, &wrench.moment, &turning);
        wrench.at = own;
    }
    all
}
