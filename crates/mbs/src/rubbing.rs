//! Coulomb's friction: its size by the multipliers of the joint whose surfaces rub, which is therefore cut.
//!
//! ```text
//! guide      F = μ |N|                       N the reaction across the motion
//! sleeve     F = μ (|N₁| + |N₂|)             N₁, N₂ = N/2 ± (a × M)/l at its ends, a along the motion
//! journal    F = μ r/√(1 + μ²) |N|           the moment of a force at the rim, N with its friction
//! track      F = μ |N| |c′|                  the force on the parameter s of the curve c, N across c′
//! thread     F = μ r (1 + m²) |λ|/(1 − ς sign(λ) μ m) + c |λ|   m = p/r the slope of the thread, c the arm of its collar
//! touch      F = μ |λ|                             λ the force along the normal of curves that touch
//! teeth      F = μ H |λ|                           λ the force of the coupling, H its loss factor
//! ```
//!
//! The moment M is about the successor's joint point, the middle of the sleeve; λ is the axial force, of which a
//! part is friction. Sources: A. Föppl, *Vorlesungen über technische Mechanik* I (circle of friction of a
//! journal); J. E. Shigley, *Mechanical Engineering Design* (mechanics of power screws).

use bksim_expr::{Expr, Function, Pool, SymbolId};
use bksim_model::{Frame, Joint, JointId, Measure, Model, MotionKind, Signal, Space};
use bksim_model::{Surface, Vector};

use crate::constraint::{Constraint, Source};
use crate::folding::short;
use crate::joint::OnCurve;
use crate::kinematics::Kinematics;
use crate::kinematics::bending;
use crate::spatial;

/// The reaction of a cut joint on its successor.
struct Reaction<'a> {
    pool: &'a Pool,
    force: Vector,
    /// About the successor's joint point.
    moment: Vector,
    /// Unit vector along or about which the joint moves, world axes.
    axis: Vector,
    /// Unit vectors across it, world axes.
    across: [Vector; 2],
}

/// The friction of a joint for a coefficient `mu`, N or N m; `slip` is the sign of the motion that it is against.
pub(crate) fn friction(
    model: &Model,
    kinematics: &Kinematics,
    constraints: &[Constraint],
    (id, surface): (JointId, Surface),
    (mu, slip): (Expr, Expr),
) -> Expr {
    let pool = &model.pool;
    let joint = &model.joints[id.0];
    let rows = constraints.iter().filter(|row| row.source == Source::Joint(id));
    let square = |e: Expr| pool.mul(e, e);
    match surface {
        Surface::Guide { length } => {
            let ends = reaction(model, kinematics, joint, rows).ends(length);
            let sizes = ends.into_iter().map(|end| magnitude(pool, end));
            pool.mul(mu, pool.sum(sizes.collect::<Vec<_>>()))
        }
        Surface::Journal { radius } => {
            let across = reaction(model, kinematics, joint, rows).across();
            let lever = pool.div(radius, pool.sqrt(pool.add(pool.one(), square(mu))));
            pool.product([mu, lever, magnitude(pool, across)])
        }
        Surface::Track => {
            let force = reaction(model, kinematics, joint, rows).force;
            let sides = kinematics.sides(model, joint);
            let Some(OnCurve { tangent, .. }) = &sides.on_curve else {
                unreachable!("only joints that follow a curve have tracks")
            };
            let speed = pool.sqrt(spatial::dot(pool, tangent, tangent));
            let along = spatial::scale(pool, pool.div(pool.one(), speed), tangent);
            let along = sides.predecessor.rotation.apply(pool, &along);
            let across = match model.space {
                Space::Planar => {
                    let normal = spatial::cross(pool, &spatial::z_axis(pool), &along);
                    vec![short(pool, spatial::dot(pool, &normal, &force))]
                }
                Space::Spatial => {
                    let part = spatial::dot(pool, &along, &force);
                    spatial::sub(pool, &force, &spatial::scale(pool, part, &along)).to_vec()
                }
            };
            pool.product([mu, speed, magnitude(pool, across)])
        }
        Surface::Touch { .. } => {
            let normal = rows.filter(|row| row.direction == "normal").map(|row| row.lambda);
            let normal = normal.map(|lambda| pool.symbol_expr(lambda)).next();
            pool.mul(mu, magnitude(pool, vec![normal.unwrap_or(pool.zero())]))
        }
        Surface::Teeth { coupling, loss } => {
            let row = constraints.iter().find(|row| row.source == Source::Coupling(coupling));
            let force = row.map_or(pool.zero(), |row| pool.symbol_expr(row.lambda));
            pool.product([mu, loss, magnitude(pool, vec![force])])
        }
        Surface::Thread { radius, collar } => {
            let lead = joint.kind.lead().expect("only screws have threads");
            let axial = rows.filter(|row| row.direction == "screw").map(|row| row.lambda);
            let axial = axial.map(|lambda| pool.symbol_expr(lambda)).next().unwrap_or(pool.zero());
            let circumference = pool.product([pool.int(2), pool.pi(), radius]);
            let slope = pool.div(lead, circumference);
            let sense = pool.call(Function::Sign, &[axial]).expect("one argument");
            let part = pool.product([slip, sense, mu, slope]);
            let factor = pool.div(pool.add(pool.one(), square(slope)), pool.sub(pool.one(), part));
            let arm = pool.add(pool.product([mu, radius, factor]), collar);
            pool.mul(arm, magnitude(pool, vec![axial]))
        }
    }
}

/// An axis of the ground, or of the frame of the first point of a joint, in the axes of the ground.
pub(crate) fn component_axis(
    model: &Model,
    kinematics: &Kinematics,
    (joint, frame): (JointId, Frame),
    axis_idx: usize,
) -> Vector {
    let pool = &model.pool;
    let axis = unit(pool, axis_idx);
    match frame {
        Frame::World => axis,
        Frame::Body => {
            let sides = kinematics.sides(model, &model.joints[joint.0]);
            sides.predecessor.rotation.apply(pool, &axis)
        }
    }
}

/// The symbols of reactions that act, and the multipliers of which they are made.
pub(crate) fn measured_reactions(
    model: &Model,
    kinematics: &Kinematics,
    constraints: &[Constraint],
) -> Vec<(SymbolId, Expr)> {
    let value = |signal: &Signal| {
        let Measure::Reaction(id, frame, component) = signal.measure else { return None };
        if !model.acts(signal) {
            return None;
        }
        let joint = &model.joints[id.0];
        let rows = constraints.iter().filter(|row| row.source == Source::Joint(id));
        let of_joint = reaction(model, kinematics, joint, rows);
        let axis = component_axis(model, kinematics, (id, frame), component % 3);
        let vector = if component < 3 { of_joint.force } else { of_joint.moment };
        Some((signal.symbol, of_joint.component(&vector, &axis)))
    };
    model.signals.iter().filter_map(value).collect()
}

/// The sum of the rows of a cut joint, each times its multiplier.
fn reaction<'a, 'c>(
    model: &'a Model,
    kinematics: &Kinematics,
    joint: &Joint,
    rows: impl Iterator<Item = &'c Constraint>,
) -> Reaction<'a> {
    let pool = &model.pool;
    let [mut force, mut moment] = [spatial::zero(pool); 2];
    let [_, successor] = bending::bearers(model, joint);
    for row in rows {
        let wrench = row.wrenches.iter().find(|wrench| wrench.body == successor);
        let Some(wrench) = wrench.map(|w| w.scaled(pool, pool.symbol_expr(row.lambda))) else {
            continue;
        };
        force = spatial::add(pool, &force, &wrench.force);
        moment = spatial::add(pool, &moment, &wrench.moment);
    }
    let rotation = &kinematics.sides(model, joint).predecessor.rotation;
    let turns = joint.kind.motions().first() == Some(&MotionKind::Rotation);
    let across = match model.space {
        // World axes as they are: no angle of the predecessor comes in.
        Space::Planar if turns => {
            let [x, y] = [0, 1].map(|at| unit(pool, at));
            [x, y]
        }
        _ => spatial::perpendicular(pool, &joint.axis).map(|e| rotation.apply(pool, &e)),
    };
    Reaction { pool, force, moment, axis: rotation.apply(pool, &joint.axis), across }
}

impl Reaction<'_> {
    fn component(&self, vector: &Vector, along: &Vector) -> Expr {
        short(self.pool, spatial::dot(self.pool, vector, along))
    }

    /// The components of the force across the motion.
    fn across(&self) -> Vec<Expr> {
        self.across.iter().map(|e| self.component(&self.force, e)).collect()
    }

    /// The forces at which the guide bears: one, or one at either end of the sleeve.
    fn ends(&self, length: Option<Expr>) -> Vec<Vec<Expr>> {
        let pool = self.pool;
        let Some(length) = length else { return vec![self.across()] };
        let couple = spatial::cross(pool, &self.axis, &self.moment);
        let end = |sense: i64| {
            let component = |e: &Vector| {
                let half = pool.mul(pool.rational(1, 2), self.component(&self.force, e));
                let arm = pool.div(self.component(&couple, e), length);
                pool.add(half, pool.mul(pool.int(sense), arm))
            };
            self.across.iter().map(component).collect()
        };
        vec![end(1), end(-1)]
    }
}

/// √(Σ cᵢ²), of a single component its absolute value.
fn magnitude(pool: &Pool, mut components: Vec<Expr>) -> Expr {
    components.retain(|&component| !pool.is_zero(component));
    if let [only] = components[..] {
        return pool.call(Function::Abs, &[only]).expect("one argument");
    }
    let squares: Vec<Expr> = components.iter().map(|&c| pool.mul(c, c)).collect();
    pool.sqrt(pool.sum(squares))
}

fn unit(pool: &Pool, at: usize) -> Vector {
    let mut unit = spatial::zero(pool);
    unit[at] = pool.one();
    unit
}
