//! Rows of couplings: their conditions on the coordinates, and the wrenches that a unit multiplier puts on
//! the bodies.
//!
//! A row is the author's relation, zero where it holds. Its multiplier is a force where the relation is a
//! length and a moment where it is an angle; the generalised force −Gᵀλ is that of the wrenches:
//!
//! ```text
//! relation, screw   −∂g/∂s on what the position s measures: along or about the joint's motion
//! rate              −∂(G v)/∂ṡ on what the rate ṡ measures
//! gear, belt        λ r₂ about the axis of the second wheel, λ r₂ (i − 1) n × d / d² through its centre,
//!                   and the opposite on the first, with the ratio i and the line of centres d
//! rack              λ along the rack at the pitch point, and the opposite on the pinion
//! strand, rope      λ along the strand on the wheel that it leaves, and the opposite on the next: its tension
//! ```
//!
//! The pair of gears and of belts is the force at the pitch point, or the difference of the tensions of the two
//! strands, moved to the second centre; with r₂ = 1 where no radii are stated. Wheels on axes that are not
//! parallel, or on one axis, bear moments alone, the rest of which the carrier bears.

use bksim_expr::{Expr, SymbolId};

use crate::belt::strand_wrenches;
use crate::coordinate::Owner;
use crate::folding::short;
use crate::force::Wrench;
use crate::joint;
use crate::kinematics::Kinematics;
use crate::pose::orientation;
use crate::rope::section_wrenches;
use crate::signal::signal_values;
use crate::spatial;
use bksim_model::{
    Axis, BodyId, Coupling, CouplingId, CouplingKind, Frame, JointId, Measure, Model, Rack, Signal,
    Space, Vector, Wheels,
};

/// A row of a coupling before it has a multiplier.
pub(crate) struct CouplingRow {
    pub(crate) coupling: CouplingId,
    /// g, or what is zero between rates.
    pub(crate) expression: Expr,
    /// On the bodies for λ = 1.
    pub(crate) wrenches: Vec<Wrench>,
}

/// The rows of all couplings, in file order.
pub(crate) fn coupling_rows(model: &Model, kinematics: &Kinematics) -> Vec<CouplingRow> {
    if model.couplings.is_empty() {
        return Vec::new();
    }
    let values = signal_values(model, kinematics);
    let row = |(idx, coupling): (usize, &Coupling)| CouplingRow {
        coupling: CouplingId(idx),
        expression: model.pool.substitute(coupling.relation, &values),
        wrenches: wrenches(model, kinematics, coupling, &values),
    };
    model.couplings.iter().enumerate().map(row).collect()
}

/// Row of a condition between rates, zero, of t, q and v: the row of G are its slopes by v, the rest is ∂g/∂t.
pub(crate) fn rate_row(model: &Model, kinematics: &Kinematics, id: CouplingId) -> Expr {
    let values = signal_values(model, kinematics);
    model.pool.substitute(model.couplings[id.0].relation, &values)
}

/// The wrenches of a unit multiplier on the bodies.
pub fn wrenches(
    model: &Model,
    kinematics: &Kinematics,
    coupling: &Coupling,
    values: &[(SymbolId, Expr)],
) -> Vec<Wrench> {
    let pair = match coupling.kind {
        CouplingKind::Relation | CouplingKind::Rate | CouplingKind::Screw => None,
        CouplingKind::Gear(wheels) | CouplingKind::Belt(wheels) => {
            of_wheels(model, kinematics, &wheels)
        }
        CouplingKind::Rack(rack) => Some(of_rack(model, kinematics, &rack)),
        CouplingKind::Strand(belt, strand) => {
            Some(strand_wrenches(model, kinematics, &model.belts[belt.0], strand))
        }
        CouplingKind::Rope(rope, section) => {
            Some(section_wrenches(model, kinematics, rope, section))
        }
    };
    pair.unwrap_or_else(|| of_relation(model, kinematics, coupling, values))
}

/// Wrenches on what each position of the relation measures.
fn of_relation(
    model: &Model,
    kinematics: &Kinematics,
    coupling: &Coupling,
    values: &[(SymbolId, Expr)],
) -> Vec<Wrench> {
    let pool = &model.pool;
    let used = model.signals.iter().filter(|s| pool.depends_on(coupling.relation, s.symbol));
    let is_of_rates = coupling.kind == CouplingKind::Rate;
    let used = used.filter(|signal| !is_of_rates || signal.measure.is_rate());
    let of_signal = |signal: &Signal| {
        let slope = pool.diff(coupling.relation, signal.symbol);
        let effort = pool.neg(short(pool, pool.substitute(slope, values)));
        along(model, kinematics, signal.measure)
            .into_iter()
            .map(|wrench| wrench.scaled(pool, effort))
            .collect::<Vec<_>>()
    };
    used.flat_map(of_signal).collect()
}

/// The wrenches of a unit effort along a position, or along what a rate is of: they do the work ∂s.
pub(crate) fn along(model: &Model, kinematics: &Kinematics, position: Measure) -> Vec<Wrench> {
    let pool = &model.pool;
    let zero = spatial::zero(pool);
    let turning =
        |body: BodyId, axis: &Vector| Wrench { body, force: zero, at: zero, moment: *axis };
    match position {
        Measure::JointPosition(joint_id, motion_idx)
        | Measure::JointVelocity(joint_id, motion_idx) => {
            let joint = &model.joints[joint_id.0];
            let positions = kinematics.joint_positions(model, joint_id);
            let sides = kinematics.sides(model, joint);
            let unit = joint::effort(pool, joint, motion_idx, &positions, &sides);
            Wrench::through_joint(model, kinematics, joint_id, &unit)
        }
        Measure::PointPosition(body, point, axis) | Measure::PointVelocity(body, point, axis) => {
            let axis = spatial::axes(pool)[axis_idx(axis)];
            let at = kinematics.position(model, body, point);
            vec![Wrench { body, force: axis, at, moment: zero }]
        }
        Measure::BodyAngle(body) | Measure::BodyRate(body) => {
            vec![turning(body, &spatial::z_axis(pool))]
        }
        Measure::AngularVelocity(body, frame, axis) => {
            let axis = spatial::axes(pool)[axis_idx(axis)];
            let rotation = &kinematics.poses[body.0].rotation;
            let axis = if frame == Frame::Body { rotation.apply(pool, &axis) } else { axis };
            vec![turning(body, &axis)]
        }
        Measure::Turn(body, against, joint) => {
            let axis = axis_of(model, kinematics, joint);
            vec![turning(body, &axis), turning(against, &spatial::neg(pool, &axis))]
        }
        // Other positions are functions of the orientation: the moment that does their work is the slope of the
        // position along each axis, which no wrench of this room has a short form for.
        _ => Vec::new(),
    }
}

/// Wheels with parallel axes apart from each other; `None` of others.
fn of_wheels(model: &Model, kinematics: &Kinematics, wheels: &Wheels) -> Option<Vec<Wrench>> {
    let pool = &model.pool;
    let (line, square) = center_line(model, kinematics, wheels)?;
    let second = axis_of(model, kinematics, wheels.axes[1]);
    let center = kinematics.anchor(model, wheels.wheels[1]);
    let [first, radius] = wheels.radii.unwrap_or([wheels.ratio, pool.one()]);
    let side = pool.div(pool.sub(first, radius), square);
    let force = spatial::scale(pool, side, &spatial::cross(pool, &second, &line));
    let moment = spatial::scale(pool, radius, &second);
    let on_second = Wrench { body: wheels.wheels[1].body, force, at: center, moment };
    let on_first = Wrench { body: wheels.wheels[0].body, ..on_second.scaled(pool, pool.int(-1)) };
    Some(vec![on_second, on_first])
}

/// The line from the first centre to the second and its squared length, of wheels that turn about parallel axes
/// apart from each other; `None` of others.
pub fn center_line(
    model: &Model,
    kinematics: &Kinematics,
    wheels: &Wheels,
) -> Option<(Vector, Expr)> {
    let pool = &model.pool;
    let [first, second] = wheels.axes.map(|joint| axis_of(model, kinematics, joint));
    let across = spatial::cross(pool, &first, &second);
    let are_parallel = across.iter().all(|&part| pool.is_zero(pool.simplify(part)));
    let [from, to] = wheels.wheels.map(|wheel| kinematics.anchor(model, wheel));
    let line = spatial::sub(pool, &to, &from);
    let square = short(pool, spatial::dot(pool, &line, &line));
    (are_parallel && !pool.is_zero(square)).then_some((line, square))
}

/// A force along the rack at the pitch point: c + r (u × n) for the pinion's axis n at c and the rack along u.
fn of_rack(model: &Model, kinematics: &Kinematics, rack: &Rack) -> Vec<Wrench> {
    let pool = &model.pool;
    let [pinion, travel] = rack.joints.map(|joint| axis_of(model, kinematics, joint));
    let center = kinematics.anchor(model, model.joints[rack.joints[0].0].successor);
    let arm = spatial::scale(pool, rack.radius, &spatial::cross(pool, &travel, &pinion));
    let at = spatial::add(pool, &center, &arm);
    let zero = spatial::zero(pool);
    let on = |body: BodyId, force: Vector| Wrench { body, force, at, moment: zero };
    vec![on(rack.bodies[1], travel), on(rack.bodies[0], spatial::neg(pool, &travel))]
}

/// The axis of a joint in world axes.
fn axis_of(model: &Model, kinematics: &Kinematics, joint: JointId) -> Vector {
    let joint = &model.joints[joint.0];
    kinematics.sides(model, joint).predecessor.rotation.apply(&model.pool, &joint.axis)
}

/// The angle by which `body` has turned against another about the axis of `joint`, all turns counted: in a
/// plane the difference of their angles; in space where joints about parallel axes, all of them in the
/// tree, lead from one to the other. `None` where the angle is known up to whole turns only.
pub fn turn(
    model: &Model,
    kinematics: &Kinematics,
    body: BodyId,
    against: BodyId,
    joint: JointId,
) -> Option<Expr> {
    let pool = &model.pool;
    let of = &model.joints[joint.0];
    // The joint's own coordinate.
    let is_own = |ends: [BodyId; 2]| ends == [of.predecessor.body, of.successor.body];
    let coordinate = kinematics
        .coordinates
        .iter()
        .find(|c| c.owner == Owner::Joint(joint, 0))
        .map(|c| pool.symbol_expr(c.q));
    match coordinate {
        Some(angle) if is_own([against, body]) => return Some(angle),
        Some(angle) if is_own([body, against]) => return Some(pool.neg(angle)),
        _ => {}
    }
    // Turns about one axis in a row are one turn by the sum of their angles.
    let poses = [against, body].map(|id| &kinematics.poses[id.0].rotation);
    if model.space == Space::Planar {
        let z = spatial::z_axis(pool);
        let [against, body] = poses.map(|rotation| rotation.angle_about(pool, &z));
        return Some(short(pool, pool.sub(body?, against?)));
    }
    let relative = poses[0].inverse(pool).then(pool, poses[1]);
    let axis = orientation(model, of.predecessor).apply(pool, &of.axis);
    relative.angle_about(pool, &axis)
}

fn axis_idx(axis: Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}
