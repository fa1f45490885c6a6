//! [`SymbolicSystem`]: the equations of motion of one model.

use bksim_expr::{Expr, Pool, SymbolId};
use bksim_model::Model;

use crate::constraint::Constraint;
use crate::contact::{Contact, Law};
use crate::coordinate::Coordinate;
use crate::force::Wrench;
use crate::kinematics::Kinematics;
use crate::sparse::SparseMatrix;
use crate::tree::Tree;

/// The way to M, h and ∂V/∂q.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Derivation {
    /// Lagrange's equations, written out and folded: short for planar mechanisms and few turns.
    Lagrange,
    /// Newton's and Euler's equations by recursion in body frames: their size
    /// grows with the number of bodies, also where turns about many axes follow each other.
    Recursion,
}

/// The equations of motion of one model, as expressions of its pool.
#[derive(Clone, Debug)]
pub struct SymbolicSystem {
    /// The way in which the left side was derived.
    pub derivation: Derivation,
    /// The spanning tree that was chosen.
    pub tree: Tree,
    /// Positions of the bodies, and the generalised coordinates q.
    pub kinematics: Kinematics,
    /// T(q, v), J.
    pub kinetic_energy: Expr,
    /// V(q), J.
    pub potential_energy: Expr,
    /// M(q), nq × nq, symmetric.
    pub mass_matrix: SparseMatrix,
    /// h(q, v), nq: Coriolis and centrifugal terms.
    pub bias: Vec<Expr>,
    /// ∂V/∂q, nq.
    pub potential_gradient: Vec<Expr>,
    /// h + ∂V/∂q, nq, by the way that is shortest for both at once.
    pub resistance: Vec<Expr>,
    /// See [`SymbolicSystem::inverse_dynamics`]; `None` where it is a sum over M.
    pub(crate) inverse_dynamics: Option<Vec<Expr>>,
    /// Q(t, q, v), nq: generalised forces without a potential.
    pub applied_force: Vec<Expr>,
    /// g(t, q) with multipliers, cut joints in file order, then drives, then contacts.
    pub constraints: Vec<Constraint>,
    /// G = ∂g/∂q, nc × nq.
    pub constraint_jacobian: SparseMatrix,
    /// ∂g/∂t, nc.
    pub constraint_rate: Vec<Expr>,
    /// Every wrench on a body: loads with and without potential.
    pub wrenches: Vec<Wrench>,
    /// Stops and friction: the rows that open and close.
    pub contacts: Vec<Contact>,
    /// The symbols that stand for reactions in expressions, and the multipliers of which they are made.
    pub reaction_values: Vec<(SymbolId, Expr)>,
    /// The conditions of latched signals, row by row: one where they hold, else zero.
    pub conditions: Vec<Expr>,
    /// Kinks of the expressions.
    pub switches: Vec<Switch>,
    /// The equations that are integrated, when they are not these.
    pub(crate) integrated: Option<Box<SymbolicSystem>>,
}

impl SymbolicSystem {
    /// The generalised coordinates.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.kinematics.coordinates
    }

    /// The equations that are integrated: with [modes](crate::modes) in place of everything that
    /// switches.
    pub fn integrated(&self) -> &Self {
        self.integrated.as_deref().unwrap_or(self)
    }

    /// M v̇ + h + ∂V/∂q, nq: the generalised forces that a motion needs, of q, v and v̇.
    pub fn inverse_dynamics(&self, pool: &Pool) -> Vec<Expr> {
        if let Some(forces) = &self.inverse_dynamics {
            return forces.clone();
        }
        let acceleration = |j: usize| pool.symbol_expr(self.coordinates()[j].a);
        let force = |(i, &resistance): (usize, &Expr)| {
            let inertia = self.mass_matrix.row(i).iter();
            let inertia = inertia.map(|&(j, m)| pool.mul(m, acceleration(j)));
            pool.sum(inertia.chain([resistance]).collect::<Vec<_>>())
        };
        self.resistance.iter().enumerate().map(force).collect()
    }

    /// Replaces the symbols of reactions in all loads by multipliers.
    pub(crate) fn put_reactions(&mut self, pool: &Pool) {
        if self.reaction_values.is_empty() {
            return;
        }
        let mut roots: Vec<&mut Expr> = self.applied_force.iter_mut().collect();
        roots.extend(self.inverse_dynamics.iter_mut().flatten());
        for wrench in &mut self.wrenches {
            roots.extend(&mut wrench.force);
            roots.extend(&mut wrench.moment);
        }
        for contact in &mut self.contacts {
            if let Law::Friction { sliding, sticking, .. } = &mut contact.law {
                roots.extend([sliding, sticking]);
            }
        }
        let exprs: Vec<Expr> = roots.iter().map(|root| **root).collect();
        let images = pool.substitute_all(&exprs, &self.reaction_values);
        roots.into_iter().zip(images).for_each(|(root, image)| *root = image);
    }

    /// Number of constraint rows that always hold; those of contacts follow.
    pub fn n_bilateral(&self) -> usize {
        self.constraints.len() - self.contacts.len()
    }

    /// Parameters of everything that is compiled: the model's own, then the modes: σ of every
    /// switch, then κ of every contact, after κ of friction its ς and p₀, then the values of the signals that are held.
    pub fn parameters(&self, model: &Model) -> Vec<SymbolId> {
        let own = model.parameters.iter().map(|p| p.symbol);
        let kinks = self.switches.iter().map(|switch| switch.mode);
        let of_contact = |contact: &Contact| match contact.law {
            Law::Stop { .. } => vec![contact.closed],
            Law::Friction { slip, stuck_at, .. } => vec![contact.closed, slip, stuck_at],
        };
        let contacts = self.contacts.iter().flat_map(of_contact);
        let held = model.held.iter().map(|signal| signal.held);
        own.chain(kinks).chain(contacts).chain(held).collect()
    }
}

/// A kink or jump of an expression.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Switch {
    /// u(t, q, v, λ), with the modes of kinks inside it: where it changes sign the expression kinks.
    pub function: Expr,
    /// Symbol of σ, the sign of u; zero leaves an expression that depends on multipliers as it is written.
    pub mode: SymbolId,
    /// Kind of quantities that decide u.
    pub of: SwitchOf,
    /// The value of σ with which the first condition on the sign of u is as written where u is zero; `None` without
    /// one, and for u that depends on time alone, or on multipliers.
    pub at_zero: Option<f64>,
}

/// Kind of quantities that decide a switch.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SwitchOf {
    /// On time alone.
    Time,
    /// On positions and velocities.
    State,
    /// On multipliers: its sign is known with the accelerations, its rate is not.
    Multipliers,
}
