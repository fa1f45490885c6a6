//! Equations grouped as an engineer would.
//!
//! Each part of an equation is written in several ways — multiplied out and collected, collected
//! and factored, as the derivation left it — and the shortest is taken, a sum without nested
//! parentheses being allowed to be somewhat longer.

use bksim_expr::{Expr, Function, Pool, SymbolId};

use super::arrange::{Kind, kinetic_parts};
use super::constants::{Constants, Group, Names};
use super::dimension::{Dimension, Units, of_equation};
use super::form::ReadingForm;
use super::proof;
use crate::system::{Derivation, SymbolicSystem};
use bksim_model::Model;

/// A flat sum may be longer than a nested one by this ratio, and in inertias and products of
/// velocities, whose terms are looked for one by one, by some more operations.
const FLAT_RATIO: f64 = 1.25;
const FLAT_ALLOWANCE: f64 = 4.0;
/// Operations above which a part is left as the derivation wrote it.
const LONGEST_PART: u64 = 1_500;
/// Operations of a root, as printed, that make it worth a name.
const ROOT_WORTH_A_NAME: u64 = 4;

impl ReadingForm {
    /// The equations with named constants. Where equality with the plain equations cannot be shown,
    /// the plain equations are returned.
    pub fn grouped(model: &Model, system: &SymbolicSystem) -> Self {
        let plain = Self::plain(model, system);
        // A recursion is made of names already.
        if system.derivation == Derivation::Recursion {
            return plain;
        }
        let grouped = Grouping::run(model, system, &plain);
        let grouped = grouped.as_written(&model.pool);
        if proof::same(model, &plain, &grouped).is_equal() { grouped } else { plain }
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
                let unit = factor.zip(of_equation(model, coordinate));
                let unit = unit.map(|(factor, equation)| equation.over(factor));
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
