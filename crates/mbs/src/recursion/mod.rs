//! Recursion over the links of the tree in body frames: the equations of motion of mechanisms in space.
//!
//! ```text
//! outwards:  ω, ω̇ and the acceleration a of each frame from those of the frame before
//! inwards:   F = Σ m (a + ω̇ × c + ω × (ω × c)),  N = Σ (I′ ω̇ + ω × I′ ω + c × F),  τ_i = S_i · (N, F)
//! ```
//!
//! Written in the frame of each link, where inertia is constant, the equations of a tree grow with the
//! number of its links, and M with that of its pairs; expanded into sums over products of sines and
//! cosines they would grow exponentially. Nothing here is expanded: an expression of one link is an
//! operand of the next one's.
//!
//! Sources: J. Y. S. Luh, M. W. Walker, R. P. C. Paul, *On-Line Computational Scheme for Mechanical
//! Manipulators*, J. Dyn. Sys. Meas. Control 102 (1980), for τ; R. Featherstone, *Rigid Body Dynamics
//! Algorithms* (2008), §6.2, for M by composite bodies.

mod composite;
mod energy;
mod ground_axes;
mod links;
mod naming;
mod newton_euler;
mod turn;

use bksim_expr::{Expr, Pool, SymbolId};
use bksim_model::{Model, Vector};

use crate::coordinate::Coordinate;
use crate::force::Loads;
use crate::kinematics::{Kinematics, Turning};
use crate::lagrange::LeftSide;
use crate::norm;
use crate::pose::Pose;
use crate::rotor;
use crate::spatial::{self, Turn};
use crate::tree::Tree;

use links::Links;
use naming::Naming;
use newton_euler::{TreeMotion, generalised_forces};

pub(crate) use newton_euler::BodyAcceleration;

/// Number of turns about different axes in a row from which on the recursion is shorter than
/// Lagrange's equations written out.
const MIN_TURNS: usize = 4;

/// True if the recursion is the shorter way to the equations of the bodies at `kinematics`.
pub(crate) fn is_shorter(pool: &Pool, kinematics: &Kinematics) -> bool {
    // A turn about a skew axis has the terms of two about axes of the frame; a quaternion those of three.
    if !kinematics.turnings.is_empty() {
        return true;
    }
    let weight = |turn: &Turn| match turn {
        Turn::About { axis, .. } => axis.iter().filter(|&&part| !pool.is_zero(part)).count().min(2),
        Turn::By(_) => MIN_TURNS,
    };
    let n_turns = |pose: &Pose| pose.rotation.turns().iter().map(weight).sum::<usize>();
    kinematics.poses.iter().any(|pose| n_turns(pose) >= MIN_TURNS)
}

/// The symbols of the motion, and the links.
struct Recursion<'a> {
    model: &'a Model,
    links: Links,
    rates: Vec<Expr>,
    accelerations: Vec<Expr>,
    /// The acceleration of the ground that stands for the uniform field: it falls the other way.
    lifted: Vector,
    /// ∂V/∂q of all but the field.
    slopes: Vec<Expr>,
}

impl<'a> Recursion<'a> {
    fn of(model: &'a Model, tree: &Tree, kinematics: &Kinematics, loads: &Loads) -> Self {
        let pool = &model.pool;
        let symbols: Vec<SymbolId> = kinematics.coordinates.iter().map(|c| c.q).collect();
        Self {
            model,
            links: Links::of(model, tree, kinematics),
            rates: expressions(model, kinematics, |c| c.v),
            accelerations: expressions(model, kinematics, |c| c.a),
            lifted: spatial::neg(pool, &loads.field),
            slopes: pool.gradient(pool.sum(loads.without_field.iter().copied()), &symbols),
        }
    }

    /// The generalised forces of a motion, with ∂V/∂q of all but the field if the field is there.
    fn forces(
        &self,
        [rates, accelerations]: [&[Expr]; 2],
        base: Option<&Vector>,
        naming: &Naming<'_>,
    ) -> Vec<Expr> {
        let pool = &self.model.pool;
        let resting = spatial::zero(pool);
        let motion = TreeMotion { rates, accelerations, base: base.unwrap_or(&resting) };
        let forces = generalised_forces(pool, &self.links, &motion, naming);
        match base {
            Some(_) => {
                forces.iter().zip(&self.slopes).map(|(&f, &slope)| pool.add(f, slope)).collect()
            }
            None => forces,
        }
    }
}

fn expressions(
    model: &Model,
    kinematics: &Kinematics,
    symbol: fn(&Coordinate) -> SymbolId,
) -> Vec<Expr> {
    kinematics.coordinates.iter().map(|c| model.pool.symbol_expr(symbol(c))).collect()
}

/// Derives the left side for the bodies of `model` under `loads`.
pub(crate) fn left_side(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
    loads: &Loads,
) -> LeftSide {
    let pool = &model.pool;
    let recursion = Recursion::of(model, tree, kinematics, loads);
    let Recursion { links, rates, accelerations, lifted, .. } = &recursion;
    let at_rest = vec![pool.zero(); rates.len()];
    let naming = Naming::none(pool);
    let (v, a, zero) = (rates.as_slice(), accelerations.as_slice(), at_rest.as_slice());
    let potential = energy::potential(pool, links, &loads.field, &naming);
    LeftSide {
        kinetic_energy: pool.sum(energy::kinetic(pool, links, v, &naming)),
        potential_energy: pool.sum(potential.iter().chain(&loads.without_field).copied()),
        mass_matrix: composite::mass_matrix(pool, links),
        bias: recursion.forces([v, zero], None, &naming),
        potential_gradient: recursion.forces([zero, zero], Some(lifted), &naming),
        resistance: recursion.forces([v, zero], Some(lifted), &naming),
        inverse_dynamics: Some(recursion.forces([v, a], Some(lifted), &naming)),
    }
}

/// The recursion with a name for every vector.
pub(crate) struct NamedRecursion {
    /// Names with their definitions, each by names before it.
    pub(crate) definitions: Vec<(SymbolId, Expr)>,
    /// Terms of T.
    pub(crate) kinetic_energy: Vec<Expr>,
    /// Terms of V.
    pub(crate) potential_energy: Vec<Expr>,
    /// M v̇ + h + ∂V/∂q, nq.
    pub(crate) inverse_dynamics: Vec<Expr>,
}

/// The recursion as it is read: `omega_`, `alpha_` and `a_` are ω, ω̇ and the acceleration of the origin
/// of a body's frame, `R_` the force that its mass needs, `F_` and `N_` force and moment on it and all that
/// it carries, `v_` and `c_` the velocities of origin and centre of mass, `g_` the field, `u_` its work on
/// a unit mass; all in the axes of the body. Of a body that turns by a quaternion `A_` is the matrix of the
/// turn, `w_` its angular velocity against the body before, `s_` is 2 / e·e, `d_` e·ė, and `n_` the inertial
/// force along e.
pub(crate) fn named(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
    loads: &Loads,
) -> NamedRecursion {
    let pool = &model.pool;
    let mut recursion = Recursion::of(model, tree, kinematics, loads);
    let naming = Naming::of(model, kinematics, recursion.links.labels(model, kinematics));
    recursion.links = recursion.links.named(pool, &naming);
    let Recursion { links, rates, accelerations, lifted, .. } = &recursion;
    // The lengths of quaternions.
    let name = |letter: &'static str| {
        let (links, naming) = (&links, &naming);
        move |turning: &Turning, e: Expr| naming.scalar(letter, links.of_turning(turning), e)
    };
    let mut kinetic_energy = energy::kinetic(pool, links, rates, &naming);
    kinetic_energy.extend(norm::kinetic_energy(model, kinematics, rates, &name("d")));
    kinetic_energy.extend(rotor::kinetic_energy(model, kinematics, rates));
    let mut potential_energy = energy::potential(pool, links, &loads.field, &naming);
    potential_energy.extend(&loads.without_field);
    let mut inverse_dynamics = recursion.forces([rates, accelerations], Some(lifted), &naming);
    let motion = [rates.as_slice(), accelerations];
    norm::add_forces(model, kinematics, motion, &mut inverse_dynamics, &name("n"));
    rotor::add_forces(model, kinematics, accelerations, &mut inverse_dynamics);
    let roots = [&kinetic_energy[..], &potential_energy, &inverse_dynamics].concat();
    let definitions = naming.needed(&roots);
    NamedRecursion { definitions, kinetic_energy, potential_energy, inverse_dynamics }
}

/// The accelerations of all bodies, world axes.
pub(crate) fn body_accelerations(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
) -> Vec<BodyAcceleration> {
    let pool = &model.pool;
    let rates = expressions(model, kinematics, |c| c.v);
    let accelerations = expressions(model, kinematics, |c| c.a);
    let base = spatial::zero(pool);
    let motion = TreeMotion { rates: &rates, accelerations: &accelerations, base: &base };
    let links = Links::of(model, tree, kinematics);
    newton_euler::body_accelerations(pool, &links, &motion, kinematics)
}
