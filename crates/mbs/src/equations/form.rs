//! [`ReadingForm`]: the equations part by part, as they are read.

use bksim_expr::{Expr, Pool, SymbolId};

use super::arrange::{Part, kinetic_parts, lagrange_parts, recursive_parts, to_be_read};
use super::constants::Group;
use super::trailing;
use crate::force::Loads;
use crate::levels::constraint_velocity;
use crate::recursion;
use crate::signal::signal_values;
use crate::system::{Derivation, SymbolicSystem};
use bksim_model::Model;

/// The equations of one system in the form in which they are read.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ReadingForm {
    /// Named constants and roots; a definition uses names that come before it.
    pub groups: Vec<Group>,
    /// Terms of T, one for each product of velocities.
    pub kinetic_energy: Vec<Expr>,
    /// Terms of V.
    pub potential_energy: Vec<Expr>,
    /// Parts of the left sides of the Lagrange equations, one list per coordinate.
    pub equations: Vec<Vec<Part>>,
    /// Terms of the left sides of the constraints that always hold.
    pub constraints: Vec<Vec<Expr>>,
    /// Coordinates, written after parameters in products.
    pub(super) moving: Vec<SymbolId>,
    /// Symbols written last in products.
    pub(super) trailing: Vec<SymbolId>,
}

impl ReadingForm {
    /// The equations without named constants. Those of a recursion have names for its vectors: written
    /// out, they would be of exponential length.
    pub fn plain(model: &Model, system: &SymbolicSystem) -> Self {
        let system = to_be_read(model, system);
        let form = match system.derivation {
            Derivation::Lagrange => Self::solved(model, &system),
            Derivation::Recursion => Self::recursive(model, &system),
        };
        form.as_written(&model.pool)
    }

    /// The recursion over the bodies.
    fn recursive(model: &Model, system: &SymbolicSystem) -> Self {
        let SymbolicSystem { tree, kinematics, .. } = system;
        let loads = Loads::of(model, kinematics, &signal_values(model, kinematics));
        let named = recursion::named(model, tree, kinematics, &loads);
        let group = |(symbol, definition): (SymbolId, Expr)| Group {
            symbol,
            terms: vec![definition],
            unit: String::new(),
            is_constant: false,
        };
        let parts = recursive_parts(model, system, &named.inverse_dynamics);
        let form = Self {
            groups: named.definitions.into_iter().map(group).collect(),
            kinetic_energy: named.kinetic_energy,
            potential_energy: named.potential_energy,
            equations: parts,
            ..Self::solved(model, system)
        };
        form.map(&|exprs| model.pool.substitute_all(exprs, &system.reaction_values))
    }

    /// The equations as the derivation left them, without names.
    pub(super) fn solved(model: &Model, system: &SymbolicSystem) -> Self {
        let pool = &model.pool;
        let n = system.coordinates().len();
        let (kinetic_energy, equations) = match system.derivation {
            Derivation::Lagrange => {
                let kinetic = kinetic_parts(model, system);
                let terms = kinetic.into_iter().map(|(v, m)| pool.mul(v, m)).collect();
                (terms, (0..n).map(|i| lagrange_parts(model, system, i)).collect())
            }
            Derivation::Recursion => {
                let parts = recursive_parts(model, system, &system.inverse_dynamics(pool));
                (vec![system.kinetic_energy], parts)
            }
        };
        Self {
            groups: Vec::new(),
            kinetic_energy,
            potential_energy: vec![system.potential_energy],
            equations,
            constraints: system.constraints[..system.n_bilateral()]
                .iter()
                .enumerate()
                .map(|(row, c)| {
                    let rate = || pool.simplify(constraint_velocity(pool, system, row));
                    vec![if c.is_of_rates() { rate() } else { c.expression }]
                })
                .collect(),
            moving: system.coordinates().iter().map(|c| c.q).collect(),
            trailing: trailing(system),
        }
    }

    /// Terms of the left side of the i-th Lagrange equation, in the order of the parts.
    pub fn equation_terms(&self, pool: &Pool, i: usize) -> Vec<Expr> {
        self.equations[i].iter().flat_map(|part| part.terms(pool)).collect()
    }

    /// The left sides of all Lagrange equations.
    pub fn left_sides(&self, pool: &Pool) -> Vec<Expr> {
        (0..self.equations.len()).map(|i| pool.sum(self.equation_terms(pool, i))).collect()
    }

    /// Every expression that is shown.
    pub(super) fn everything(&self, pool: &Pool) -> Vec<Expr> {
        let mut all = self.left_sides(pool);
        all.extend(self.groups.iter().flat_map(|group| &group.terms));
        all.extend(self.constraints.iter().flatten());
        all.extend(&self.kinetic_energy);
        all.extend(&self.potential_energy);
        all
    }

    /// Form with `change` done to every expression.
    pub(super) fn map(&self, change: &dyn Fn(&[Expr]) -> Vec<Expr>) -> Self {
        let part = |part: &Part| Part {
            kind: part.kind,
            factor: change(&[part.factor])[0],
            sum: change(&part.sum),
        };
        let group = |group: &Group| Group { terms: change(&group.terms), ..group.clone() };
        Self {
            groups: self.groups.iter().map(group).collect(),
            kinetic_energy: change(&self.kinetic_energy),
            potential_energy: change(&self.potential_energy),
            equations: self.equations.iter().map(|e| e.iter().map(part).collect()).collect(),
            constraints: self.constraints.iter().map(|terms| change(terms)).collect(),
            moving: self.moving.clone(),
            trailing: self.trailing.clone(),
        }
    }

    /// Form with its numbers as a person writes them.
    pub(super) fn as_written(&self, pool: &Pool) -> Self {
        self.map(&|exprs| pool.as_written(exprs))
    }

    /// Form with other names for some symbols.
    pub(super) fn renamed(&self, pool: &Pool, names: &[(SymbolId, Expr)]) -> Self {
        let change = |exprs: &[Expr]| pool.substitute_all(exprs, names);
        let new = |symbol: &SymbolId| {
            let image = names.iter().find(|(old, _)| old == symbol);
            image.and_then(|&(_, new)| pool.symbol_id(new)).unwrap_or(*symbol)
        };
        let [moving, trailing] =
            [&self.moving, &self.trailing].map(|symbols| symbols.iter().map(new).collect());
        Self { moving, trailing, ..self.map(&change) }
    }
}
