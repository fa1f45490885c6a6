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
//! worm              λ where its threads press, and the opposite on the worm
//! bevel wheels      with a pressure angle λ where their pitch cones touch, and the opposite on the first
//! pressure angle    |λ| tan α/cos β on the second away from the first, and the opposite on the first
//! helix             λ tan β along the axis at the pitch point, and the opposite on the first
//! strand, rope      λ along the strand on the wheel that it leaves, and the opposite on the next: its tension
//! ```
//!
//! The pair of gears and of belts is the force at the pitch point, or the difference of the tensions of the two
//! strands, moved to the second centre; with r₂ = 1 where no radii are stated. Wheels on axes that are not
//! parallel, or on one axis, bear moments alone, the rest of which the carrier bears.

use bksim_expr::{Expr, Function, Pool, SymbolId};

use crate::belt::strand_wrenches;
use crate::constraint::{Constraint, Source};
use crate::coordinate::Owner;
use crate::folding::short;
use crate::force::Wrench;
use crate::joint;
use crate::kinematics::Kinematics;
use crate::pose::orientation;
use crate::rope::section_wrenches;
use crate::signal::signal_values;
use crate::spatial;
use crate::worm::Worm;
use bksim_model::{
    Axis, BodyId, Coupling, CouplingId, CouplingKind, Flanks, Frame, JointId, Measure, Model, Rack,
    Signal, Space, Vector, Wheels,
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
            let axis = kinematics.axis_of(model, joint);
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
    if let Some(worm) = Worm::of(model, kinematics, wheels) {
        return Some(worm.pair(pool, wheels));
    }
    let Some((line, square)) = center_line(model, kinematics, wheels) else {
        let cones = wheels.flanks.and_then(|_| Cones::of(model, kinematics, wheels))?;
        return Some(cones.pair(pool, wheels, cones.along));
    };
    let second = kinematics.axis_of(model, wheels.axes[1]);
    let center = kinematics.anchor(model, wheels.wheels[1]);
    let [first, radius] = wheels.radii.unwrap_or([wheels.ratio, pool.one()]);
    let side = pool.div(pool.sub(first, radius), square);
    let force = spatial::scale(pool, side, &spatial::cross(pool, &second, &line));
    let moment = spatial::scale(pool, radius, &second);
    // The axial force acts where the pitch circles touch.
    let (force, moment) = match wheels.flanks {
        Some(Flanks { axial, .. }) if is_felt(model, axial) => {
            let axial = spatial::scale(pool, axial, &second);
            let part = pool.div(radius, pool.sub(first, radius));
            let arm = spatial::scale(pool, part, &line);
            let turning = spatial::cross(pool, &arm, &axial);
            (spatial::add(pool, &force, &axial), spatial::add(pool, &moment, &turning))
        }
        _ => (force, moment),
    };
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
    let [first, second] = wheels.axes.map(|joint| kinematics.axis_of(model, joint));
    let across = spatial::cross(pool, &first, &second);
    let are_parallel = across.iter().all(|&part| pool.is_zero(pool.simplify(part)));
    let [from, to] = wheels.wheels.map(|wheel| kinematics.anchor(model, wheel));
    let line = spatial::sub(pool, &to, &from);
    let square = short(pool, spatial::dot(pool, &line, &line));
    (are_parallel && !pool.is_zero(square)).then_some((line, square))
}

/// Pitch cones of bevel wheels, where they touch.
///
/// ```text
/// p = ± (r₂ n₁ − r₁ n₂)/|w|         from the apex, w = n₁ × n₂, r₁ below zero where they turn in opposite senses
/// t = ∓ w/|w|                       moves the second forward
/// e = w × p/|w × p| (±)             across the line in which the cones touch, from the first to the second
/// ```
///
/// The sign is that on whose side of the apex the centres are.
pub struct Cones {
    /// Where the teeth press, in the axes of the ground.
    at: Vector,
    along: Vector,
    across: Vector,
    /// On which side of the apex each centre is as the senses of turning ask for, m²: both alike, and one not zero.
    pub sides: [Expr; 2],
    /// Distance of the axes, m, zero where they meet.
    pub apart: Expr,
}

impl Cones {
    /// Cones of wheels with pitch radii whose axes are not parallel; `None` of others.
    pub fn of(model: &Model, kinematics: &Kinematics, wheels: &Wheels) -> Option<Self> {
        let pool = &model.pool;
        let [first, second] = wheels.radii?;
        let [a, b] = wheels.axes.map(|joint| kinematics.axis_of(model, joint));
        let across = spatial::cross(pool, &a, &b);
        let square = short(pool, spatial::dot(pool, &across, &across));
        if pool.is_zero(square) || center_line(model, kinematics, wheels).is_some() {
            return None;
        }
        let length = pool.sqrt(square);
        let per =
            |vector: &Vector, by: Expr| spatial::scale(pool, pool.div(pool.one(), by), vector);
        let [from, to] = wheels.wheels.map(|wheel| kinematics.anchor(model, wheel));
        let line = spatial::sub(pool, &to, &from);
        let place = pool.div(spatial::dot(pool, &spatial::cross(pool, &line, &b), &across), square);
        let apex = spatial::add(pool, &from, &spatial::scale(pool, place, &a));
        let arm =
            spatial::sub(pool, &spatial::scale(pool, second, &a), &spatial::scale(pool, first, &b));
        let arm = per(&arm, length);
        let sides = [from, to].map(|center| {
            short(pool, spatial::dot(pool, &spatial::sub(pool, &center, &apex), &arm))
        });
        let side = pool.add(sides[0], sides[1]);
        let sign = pool.div(side, pool.sqrt(pool.powi(side, 2)));
        let normal = spatial::cross(pool, &across, &arm);
        let size = pool.sqrt(spatial::dot(pool, &normal, &normal));
        Some(Self {
            at: spatial::add(pool, &apex, &spatial::scale(pool, sign, &arm)),
            along: spatial::scale(pool, pool.neg(sign), &per(&across, length)),
            across: spatial::scale(pool, sign, &per(&normal, size)),
            sides,
            apart: pool.div(spatial::dot(pool, &line, &across), length),
        })
    }

    /// A force where the teeth press, on the second wheel, and the opposite on the first.
    fn pair(&self, pool: &Pool, wheels: &Wheels, force: Vector) -> Vec<Wrench> {
        let [first, second] = wheels.wheels.map(|wheel| wheel.body);
        let moment = spatial::zero(pool);
        let on = |body: BodyId, force: Vector| Wrench { body, force, at: self.at, moment };
        vec![on(second, force), on(first, spatial::neg(pool, &force))]
    }
}

/// A force along the rack at the pitch point: c + r (u × n) for the pinion's axis n at c and the rack along u.
fn of_rack(model: &Model, kinematics: &Kinematics, rack: &Rack) -> Vec<Wrench> {
    let pool = &model.pool;
    let [pinion, travel] = rack.joints.map(|joint| kinematics.axis_of(model, joint));
    let center = kinematics.anchor(model, model.joints[rack.joints[0].0].successor);
    let arm = spatial::scale(pool, rack.radius, &spatial::cross(pool, &travel, &pinion));
    let at = spatial::add(pool, &center, &arm);
    let zero = spatial::zero(pool);
    let on = |body: BodyId, force: Vector| Wrench { body, force, at, moment: zero };
    let force = match rack.flanks {
        Some(Flanks { axial, .. }) if is_felt(model, axial) => {
            spatial::add(pool, &travel, &spatial::scale(pool, axial, &pinion))
        }
        _ => travel,
    };
    vec![on(rack.bodies[1], force), on(rack.bodies[0], spatial::neg(pool, &force))]
}

/// True where bearings carry an axial force: in the plane nothing says where.
fn is_felt(model: &Model, axial: Expr) -> bool {
    model.space == Space::Spatial && !model.pool.is_zero(axial)
}

/// The forces that part the members of a gear or rack for a tooth force of size one, away from the first on the second,
/// and whether they do no work as the distance of the centres is constant; `None` without a pressure angle.
pub(crate) fn parting(
    model: &Model,
    kinematics: &Kinematics,
    kind: &CouplingKind,
) -> Option<(Vec<Wrench>, bool)> {
    let pool = &model.pool;
    let Flanks { radial, .. } = kind.flanks()?;
    let (at, along, bodies, is_held) = match kind {
        CouplingKind::Gear(wheels) => {
            if let Some(worm) = Worm::of(model, kinematics, wheels) {
                let force = spatial::scale(pool, radial, &worm.apart);
                return Some((worm.push(pool, wheels, force), true));
            }
            let Some((line, square)) = center_line(model, kinematics, wheels) else {
                let cones = Cones::of(model, kinematics, wheels)?;
                let across = spatial::scale(pool, radial, &cones.across);
                return Some((cones.pair(pool, wheels, across), true));
            };
            let along = spatial::scale(pool, pool.div(pool.one(), pool.sqrt(square)), &line);
            let at = kinematics.anchor(model, wheels.wheels[1]);
            let is_held = kinematics.coordinates_in(pool, &[square]).is_empty();
            (at, along, wheels.wheels.map(|wheel| wheel.body), is_held)
        }
        CouplingKind::Rack(rack) => {
            let [pinion, travel] = rack.joints.map(|joint| kinematics.axis_of(model, joint));
            let along = spatial::cross(pool, &travel, &pinion);
            let center = kinematics.anchor(model, model.joints[rack.joints[0].0].successor);
            (center, along, rack.bodies, false)
        }
        _ => return None,
    };
    let force = spatial::scale(pool, radial, &along);
    let on = |body: BodyId, force: Vector| Wrench { body, force, at, moment: spatial::zero(pool) };
    Some((vec![on(bodies[1], force), on(bodies[0], spatial::neg(pool, &force))], is_held))
}

/// The wrenches of one side of teeth with play, for a unit force that pushes them apart.
pub(crate) fn flank_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    teeth: &Coupling,
    is_back: bool,
) -> Vec<Wrench> {
    let pool = &model.pool;
    let values = signal_values(model, kinematics);
    let sense = pool.int(if is_back == teeth.kind.is_reversed() { 1 } else { -1 });
    let along = wrenches(model, kinematics, teeth, &values);
    let mut all: Vec<Wrench> = along.iter().map(|wrench| wrench.scaled(pool, sense)).collect();
    all.extend(
        parting(model, kinematics, &teeth.kind).into_iter().flat_map(|(parting, _)| parting),
    );
    all
}

/// The forces that part gears and racks without play, by the sizes of their multipliers, and whether they do no work.
///
/// # Panics
/// Never: `abs` has one argument.
pub(crate) fn separating_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    constraints: &[Constraint],
) -> Vec<(Vec<Wrench>, bool)> {
    let pool = &model.pool;
    let of_row = |row: &Constraint| {
        let Source::Coupling(id) = row.source else { return None };
        let (unit, is_held) = parting(model, kinematics, &model.couplings[id.0].kind)?;
        let size = pool.call(Function::Abs, &[pool.symbol_expr(row.lambda)]);
        let size = size.expect("one argument");
        Some((unit.iter().map(|wrench| wrench.scaled(pool, size)).collect(), is_held))
    };
    constraints.iter().filter_map(of_row).collect()
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
        .position(|c| c.owner == Owner::Joint(joint, 0))
        .map(|i| kinematics.of_motion(pool, i));
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
