//! Constants that get a name: what depends on parameters alone and takes more than one operation.
//!
//! A table collects every such part of the equations under a stand-in symbol; parts that differ by
//! a number share one. When all parts are known, a stand-in becomes a named constant if it is a sum,
//! or if it occurs more than once, and otherwise what it stood for.
//!
//! Names follow the unit, as in mechanics: `J1` is a moment of inertia, `S1` a first moment of mass,
//! `M1` a mass, `W1` the moment of a weight, `F1` a force, `K1` a stiffness, `D1` a damping, `L1` a
//! length, `r1` a root that depends on the motion, `P1` anything else. They are numbered in the order
//! in which the equations use them; numbers whose name the model has taken are left out.

use std::collections::{BTreeSet, HashMap};

use bksim_expr::{Expr, Number, Pool, SymbolId};

use super::dimension::{Dimension, letter};
use crate::coordinate::Coordinate;
use crate::system::SymbolicSystem;
use bksim_model::Model;

/// A named part of the equations.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Group {
    /// Name of the group.
    pub symbol: SymbolId,
    /// Definition of the group: the terms of a sum in the order of the links, or one product.
    pub terms: Vec<Expr>,
    /// SI unit as text (`"kg m^2"`); empty when it is a number or not known.
    pub unit: String,
    /// True if it depends on parameters alone; it has a value then.
    pub is_constant: bool,
}

impl Group {
    /// Definition of the group.
    pub fn definition(&self, pool: &Pool) -> Expr {
        pool.sum(self.terms.iter().copied())
    }
}

/// Multiples of a stand-in's base that are written as a number before its name: `2*J1`, `3*J1`.
const LARGEST_MULTIPLE: i64 = 4;
/// Number of operations above which a constant gets a name.
const WORTH_A_NAME: u64 = 2;

/// A constant part up to a number.
struct Entry {
    /// The part over its leading coefficient.
    key: Expr,
    stand_in: SymbolId,
    is_sum: bool,
    /// The numbers it was multiplied by, one for each occurrence.
    scales: Vec<Number>,
    dimension: Option<Dimension>,
}

/// The constant parts met so far.
pub(super) struct Constants<'a> {
    model: &'a Model,
    parameters: Vec<SymbolId>,
    entries: Vec<Entry>,
    by_key: HashMap<Expr, usize>,
}

impl<'a> Constants<'a> {
    pub(super) fn new(model: &'a Model) -> Self {
        let parameters = model.parameters.iter().map(|p| p.symbol).collect();
        Self { model, parameters, entries: Vec::new(), by_key: HashMap::new() }
    }

    pub(super) fn parameters(&self) -> &[SymbolId] {
        &self.parameters
    }

    /// The expressions with stand-ins for their constant parts, which are counted as occurrences
    /// if `counted`.
    pub(super) fn stand_in(&mut self, roots: &[Expr], counted: bool) -> Vec<Expr> {
        let model = self.model;
        let parameters = self.parameters.clone();
        model.pool.map_constants(roots, &parameters, &mut |part| self.image(part, counted))
    }

    /// Notes the unit of a constant part.
    pub(super) fn note_unit(&mut self, part: Expr, dimension: Option<Dimension>) {
        if let Some((index, _)) = self.find(part) {
            let known = &mut self.entries[index].dimension;
            *known = known.or(dimension);
        }
    }

    fn image(&mut self, part: Expr, counted: bool) -> Expr {
        let pool = &self.model.pool;
        let Some((index, scale)) = self.find(part) else {
            return part;
        };
        let entry = &mut self.entries[index];
        if counted {
            entry.scales.push(scale.clone());
        }
        pool.mul(pool.number(scale), pool.symbol_expr(entry.stand_in))
    }

    /// The entry of a constant part, a new one if need be, and the number before it; `None` for
    /// numbers and single symbols.
    fn find(&mut self, part: Expr) -> Option<(usize, Number)> {
        let pool = &self.model.pool;
        let terms = pool.split_terms(part, &[]);
        let lead = pool.as_number(terms.first()?.constant)?;
        let is_sum = terms.len() > 1;
        let work = pool.operation_count(&[terms[0].varying]);
        // A name for a symbol or a quotient of symbols says less than they do.
        if !is_sum && work.shared() == work.divisions {
            return None;
        }
        let inverse = pool.number(Number::ONE.over(&lead));
        let monic = terms.iter().map(|t| pool.product([inverse, t.constant, t.varying]));
        let key = pool.sum(monic.collect::<Vec<_>>());
        let index = *self.by_key.entry(key).or_insert_with(|| {
            // No identifier contains the sign, so no name of a model is taken.
            let stand_in = pool.symbol(&format!("§{}", self.entries.len()));
            let stand_in = pool.symbol_id(stand_in).expect("a symbol was just made");
            let entry = Entry { key, stand_in, is_sum, scales: Vec::new(), dimension: None };
            self.entries.push(entry);
            self.entries.len() - 1
        });
        Some((index, lead))
    }

    /// Decides which stand-ins get a name; returns the groups in the order of their first use in
    /// `roots`, and what each stand-in is replaced by.
    pub(super) fn named(
        self,
        roots: &[Expr],
        names: &mut Names,
    ) -> (Vec<Group>, Vec<(SymbolId, Expr)>) {
        let pool = &self.model.pool;
        let links = FirstBodies::of(self.model);
        let (mut groups, mut images) = (Vec::new(), Vec::new());
        for index in self.order_of_use(roots) {
            let entry = &self.entries[index];
            let base = entry.base();
            let definition = pool.expand(pool.mul(pool.number(base.clone()), entry.key));
            let definition = pool.simplify(definition);
            let n_operations = pool.printed_operations(&[definition]).total();
            let occurs_enough = entry.scales.len() > usize::from(!entry.is_sum);
            let image = if occurs_enough && n_operations >= WORTH_A_NAME {
                let symbol = names.next(pool, letter(entry.dimension));
                let terms = links.sorted(pool, pool.sum_terms(definition));
                let unit = entry.dimension.map(|d| d.to_string()).unwrap_or_default();
                groups.push(Group { symbol, terms, unit, is_constant: true });
                pool.mul(pool.number(Number::ONE.over(base)), pool.symbol_expr(symbol))
            } else {
                pool.simplify(entry.key)
            };
            images.push((entry.stand_in, image));
        }
        (groups, images)
    }

    /// Indices of the entries, those in the first of `roots` first.
    fn order_of_use(&self, roots: &[Expr]) -> Vec<usize> {
        let pool = &self.model.pool;
        let by_symbol: HashMap<SymbolId, usize> =
            self.entries.iter().map(|entry| entry.stand_in).zip(0..).collect();
        let mut order: Vec<usize> = Vec::new();
        let mut seen = BTreeSet::new();
        for &root in roots {
            let mut inside: Vec<usize> =
                pool.symbols_of(root).iter().filter_map(|s| by_symbol.get(s).copied()).collect();
            inside.sort_unstable();
            order.extend(inside.into_iter().filter(|&index| seen.insert(index)));
        }
        order.extend((0..self.entries.len()).filter(|&index| seen.insert(index)));
        order
    }
}

impl Entry {
    /// The number that the named constant contains: of a sum the one it is met with first, of a
    /// product one of which all occurrences are small multiples, if there is one.
    fn base(&self) -> Number {
        let magnitudes = self.scales.iter().map(Number::magnitude);
        let smallest = magnitudes.min_by(|a, b| a.order(b)).unwrap_or(Number::ONE);
        let is_multiple = |scale: &Number| {
            scale.over(&smallest).magnitude().as_integer().is_some_and(|n| n <= LARGEST_MULTIPLE)
        };
        if self.scales.iter().all(is_multiple) {
            return smallest;
        }
        match self.scales.first() {
            Some(first) if self.is_sum => first.magnitude(),
            _ => Number::ONE,
        }
    }
}

/// Names that the model has not taken.
pub(super) struct Names {
    taken: BTreeSet<String>,
    n_used: HashMap<&'static str, usize>,
}

impl Names {
    pub(super) fn of(model: &Model, system: &SymbolicSystem) -> Self {
        let pool = &model.pool;
        let coordinate = |c: &Coordinate| [c.q, c.v, c.a];
        let symbols = system.coordinates().iter().flat_map(coordinate);
        let symbols = symbols.chain(model.parameters.iter().map(|p| p.symbol));
        let symbols = symbols.chain(system.constraints.iter().map(|c| c.lambda));
        let symbols = symbols.chain([model.time]);
        let taken = symbols.map(|symbol| pool.symbol_name(symbol)).collect();
        Self { taken, n_used: HashMap::new() }
    }

    /// The next free name of a letter.
    pub(super) fn next(&mut self, pool: &Pool, letter: &'static str) -> SymbolId {
        let n = self.n_used.entry(letter).or_insert(0);
        loop {
            *n += 1;
            let name = format!("{letter}{n}");
            if !self.taken.contains(&name) {
                return pool.symbol_id(pool.symbol(&name)).expect("a symbol was just made");
            }
        }
    }
}

/// The body at which each parameter is first met.
struct FirstBodies {
    by_symbol: HashMap<SymbolId, usize>,
}

impl FirstBodies {
    fn of(model: &Model) -> Self {
        let mut by_symbol = HashMap::new();
        for (body_idx, body) in model.bodies.iter().enumerate() {
            let points = body.points.iter().flat_map(|point| point.position);
            let all = [body.mass].into_iter().chain(body.com).chain(body.inertia.moments);
            let all = all.chain(body.inertia.products).chain(points);
            for symbol in all.flat_map(|e| model.pool.symbols_of(e)) {
                by_symbol.entry(symbol).or_insert(body_idx);
            }
        }
        Self { by_symbol }
    }

    /// Terms of nearer links first: a term belongs to the farthest link it mentions.
    fn sorted(&self, pool: &Pool, mut terms: Vec<Expr>) -> Vec<Expr> {
        let link = |e: &Expr| {
            let symbols = pool.symbols_of(*e);
            symbols.iter().filter_map(|s| self.by_symbol.get(s)).max().copied().unwrap_or(0)
        };
        let reading: HashMap<Expr, usize> = pool
            .split_terms(pool.sum(terms.iter().copied()), &[])
            .iter()
            .map(|t| pool.mul(t.constant, t.varying))
            .zip(0..)
            .collect();
        terms.sort_by_key(|e| (link(e), reading.get(e).copied().unwrap_or(usize::MAX)));
        terms
    }
}
