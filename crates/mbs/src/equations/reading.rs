//! [`ReadingForm`]: the equations grouped as an engineer would.
//!
//! Each part of an equation is written in several ways — multiplied out and collected, collected
//! and factored, as the derivation left it — and the shortest is taken, a sum without nested
//! parentheses being allowed to be somewhat longer.

use bksim_expr::{Expr, Function, Pool, SymbolId};

use super::arrange::{Kind, Part, kinetic_parts, lagrange_parts, recursive_parts};
use super::constants::{Constants, Group, Names};
use super::dimension::{Dimension, Units, of_equation};
use super::{proof, trailing};
use crate::force::Loads;
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
    /// Symbols written last in products.
    pub(super) trailing: Vec<SymbolId>,
}

/// A flat sum may be longer than a nested one by this ratio, and in inertias and products of
/// velocities, whose terms are looked for one by one, by some more operations.
const FLAT_RATIO: f64 = 1.25;
const FLAT_ALLOWANCE: f64 = 4.0;
/// Operations above which a part is left as the derivation wrote it.
const LONGEST_PART: u64 = 1_500;
/// Operations of a root, as printed, that make it worth a name.
const ROOT_WORTH_A_NAME: u64 = 4;

impl ReadingForm {
    /// The equations without named constants. Those of a recursion have names for its vectors: written
    /// out, they would be of exponential length.
    pub fn plain(model: &Model, system: &SymbolicSystem) -> Self {
        match system.derivation {
            Derivation::Lagrange => Self::solved(model, system),
            Derivation::Recursion => Self::recursive(model, system),
        }
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
        Self {
            groups: named.definitions.into_iter().map(group).collect(),
            kinetic_energy: named.kinetic_energy,
            potential_energy: named.potential_energy,
            equations: parts,
            ..Self::solved(model, system)
        }
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
                .map(|c| vec![c.expression])
                .collect(),
            trailing: trailing(system),
        }
    }

    /// The equations with named constants. Where equality with the plain equations cannot be shown,
    /// the plain equations are returned.
    pub fn grouped(model: &Model, system: &SymbolicSystem) -> Self {
        if system.derivation == Derivation::Recursion {
            return Self::recursive(model, system);
        }
        let plain = Self::plain(model, system);
        let grouped = Grouping::run(model, system, &plain);
        if proof::same(model, &plain, &grouped).is_equal() { grouped } else { plain }
    }

    /// Terms of the left side of the i-th Lagrange equation, in the order of the parts.
    pub fn equation_terms(&self, pool: &Pool, i: usize) -> Vec<Expr> {
        self.equations[i].iter().flat_map(|part| part.terms(pool)).collect()
    }

    /// The left sides of all Lagrange equations.
    pub fn left_sides(&self, pool: &Pool) -> Vec<Expr> {
        (0..self.equations.len()).map(|i| pool.sum(self.equation_terms(pool, i))).collect()
    }

    /// The same form with `change` done to every expression.
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
            trailing: self.trailing.clone(),
        }
    }

    /// The same form with other names for some symbols.
    pub(super) fn renamed(&self, pool: &Pool, names: &[(SymbolId, Expr)]) -> Self {
        let change = |exprs: &[Expr]| pool.substitute_all(exprs, names);
        let new = |symbol: &SymbolId| {
            let image = names.iter().find(|(old, _)| old == symbol);
            image.and_then(|&(_, new)| pool.symbol_id(new)).unwrap_or(*symbol)
        };
        let trailing = self.trailing.iter().map(new).collect();
        Self { trailing, ..self.map(&change) }
    }
}

/// Where a part stands.
#[derive(Clone, Copy)]
enum Use {
    /// In an equation, as a part of this kind and unit: its constants are worth naming.
    Equation(Kind, Option<Dimension>),
    /// In the definition of a root; its constants are worth naming too.
    Root,
    /// In an energy, which uses the names of the equations.
    Energy,
    /// In a constraint, which has few constants to hide.
    Constraint,
}

/// The work of naming, part by part.
struct Grouping<'a> {
    pool: &'a Pool,
    units: Units,
    constants: Constants<'a>,
    roots: Roots<'a>,
}

impl<'a> Grouping<'a> {
    fn run(model: &'a Model, system: &'a SymbolicSystem, plain: &ReadingForm) -> ReadingForm {
        let pool = &model.pool;
        let mut names = Names::of(model, system);
        let mut work = Self {
            pool,
            units: Units::new(model, system),
            constants: Constants::new(model),
            roots: Roots::of(model, plain, &mut names),
        };

        // What occurs in the equations is worth a name; energies and constraints use the names.
        let mut form = plain.clone();
        for (parts, coordinate) in form.equations.iter_mut().zip(system.coordinates()) {
            for part in parts {
                let factor = work.units.of_product(pool, part.factor);
                let unit = factor.map(|factor| of_equation(coordinate.kind).over(factor));
                part.sum = work.shortened(&part.sum, Use::Equation(part.kind, unit));
            }
        }
        let radicands: Vec<Vec<Expr>> = (0..work.roots.list.len())
            .map(|k| work.shortened(&[work.roots.radicand(k)], Use::Root))
            .collect();
        let energy = kinetic_parts(model, system).into_iter().map(|(velocities, entry)| {
            pool.mul(pool.sum(work.shortened(&[entry], Use::Energy)), velocities)
        });
        form.kinetic_energy = energy.collect();
        form.potential_energy = work.shortened(&plain.potential_energy, Use::Energy);
        for terms in &mut form.constraints {
            *terms = work.shortened(terms, Use::Constraint);
            lead_with_positive(pool, terms);
        }

        // Now that all uses are known, stand-ins become names or what they stood for.
        let mut order = form.left_sides(pool);
        order.extend(radicands.iter().map(|terms| pool.sum(terms.iter().copied())));
        let (groups, images) = work.constants.named(&order, &mut names);
        let resolve = |exprs: &[Expr]| pool.substitute_all(exprs, &images);
        form = form.map(&resolve);
        form.groups = groups;
        for ((_, symbol), radicand) in work.roots.list.iter().zip(&radicands) {
            let terms = vec![pool.sqrt(pool.sum(resolve(radicand)))];
            let root = Group { symbol: *symbol, terms, unit: String::new(), is_constant: false };
            form.groups.push(root);
        }
        form
    }

    /// The shortest way to write a sum, with names for roots and stand-ins for constants.
    fn shortened(&mut self, sum: &[Expr], usage: Use) -> Vec<Expr> {
        let pool = self.pool;
        let e = pool.sum(self.roots.replaced(sum));
        let is_counted = !matches!(usage, Use::Energy | Use::Constraint);
        if pool.printed_operations(&[e]).total() > LONGEST_PART {
            return self.constants.stand_in(&[e], is_counted);
        }
        let parameters = self.constants.parameters().to_vec();
        let mut split = pool.split_terms(e, &parameters);
        if is_counted {
            // The constant part of an inertia comes before what it varies by.
            split.sort_by_key(|term| !pool.is_one(term.varying));
        }
        if let Use::Equation(_, Some(unit)) = usage {
            for term in &split {
                let varying = self.units.of_product(pool, term.varying);
                self.constants.note_unit(term.constant, varying.map(|varying| unit.over(varying)));
            }
        }
        let collected: Vec<Expr> =
            split.iter().map(|term| pool.mul(pool.simplify(term.constant), term.varying)).collect();
        // Names hide the length of constants.
        let mut hidden = |terms: &[Expr]| match usage {
            Use::Constraint => terms.to_vec(),
            _ => self.constants.stand_in(terms, false),
        };
        let (flat, nested) = (hidden(&collected), hidden(&[e]));
        let factored = vec![pool.simplify(pool.sum(flat.iter().copied()))];

        let length = |terms: &[Expr]| {
            let joining = terms.len().saturating_sub(1) as u64;
            (pool.printed_operations(terms).total() + joining) as f64
        };
        let allowance = match usage {
            Use::Equation(Kind::Inertia | Kind::Velocity, _) => FLAT_ALLOWANCE,
            _ => 0.0,
        };
        let shortest = length(&nested).min(length(&factored));
        if length(&flat) <= FLAT_RATIO * shortest + allowance {
            return self.constants.stand_in(&collected, is_counted);
        }
        let is_factored = length(&factored) < length(&nested);
        // Counted as they stand where they are used.
        let used = if is_factored { &collected } else { &vec![e] };
        let nested = self.constants.stand_in(used, is_counted);
        if is_factored { factored } else { nested }
    }
}

/// Brings the first term without a minus sign to the front.
fn lead_with_positive(pool: &Pool, terms: &mut [Expr]) {
    let is_negative = |&term: &Expr| {
        let number = pool.factors(term).first().and_then(|&(first, _)| pool.as_number(first));
        number.is_some_and(|n| n.is_negative())
    };
    if let Some(positive) = terms.iter().position(|term| !is_negative(term)) {
        terms[..=positive].rotate_right(1);
    }
}

/// Square roots that depend on the motion, such as the lengths of springs; inner ones first.
struct Roots<'a> {
    pool: &'a Pool,
    list: Vec<(Expr, SymbolId)>,
}

impl<'a> Roots<'a> {
    /// The roots of the equations and of V that are long enough.
    fn of(model: &'a Model, plain: &ReadingForm, names: &mut Names) -> Self {
        let pool = &model.pool;
        let mut everything = plain.left_sides(pool);
        everything.extend(&plain.potential_energy);
        let is_parameter = |s: &SymbolId| model.parameters.iter().any(|p| p.symbol == *s);
        let is_worth_a_name = |&call: &Expr| {
            pool.printed_operations(&[call]).total() >= ROOT_WORTH_A_NAME
                && !pool.symbols_of(call).iter().all(is_parameter)
        };
        let calls = pool.calls_of(Function::Sqrt, &everything);
        let list = calls.into_iter().filter(is_worth_a_name);
        Self { pool, list: list.map(|call| (call, names.next(pool, "r"))).collect() }
    }

    /// The expressions with names for all roots.
    fn replaced(&self, exprs: &[Expr]) -> Vec<Expr> {
        self.replaced_by(exprs, self.list.len())
    }

    fn replaced_by(&self, exprs: &[Expr], n_roots: usize) -> Vec<Expr> {
        let image = |&(call, symbol): &(Expr, SymbolId)| (call, self.pool.symbol_expr(symbol));
        let map: Vec<(Expr, Expr)> = self.list[..n_roots].iter().map(image).collect();
        self.pool.replace_all(exprs, &map)
    }

    /// The argument of the k-th root, with names for the roots inside.
    fn radicand(&self, k: usize) -> Expr {
        let call = self.list[k].0;
        let argument = self.pool.called_function(call).and_then(|call| call.1.first().copied());
        self.replaced_by(&[argument.unwrap_or(call)], k)[0]
    }
}
