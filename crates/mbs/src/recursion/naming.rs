//! Names for the vectors of the recursion, so that it can be read.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

use bksim_expr::{Expr, Pool, SymbolId};
use bksim_model::{Model, Vector};

use crate::kinematics::Kinematics;

/// Letters of the three components.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Stand-ins for components that take an operation to compute; none when the recursion is to be run.
pub(super) struct Naming<'a> {
    pool: &'a Pool,
    /// The end of the names of each link; empty when nothing is named.
    labels: Vec<String>,
    found: RefCell<Found>,
}

#[derive(Default)]
struct Found {
    taken: HashSet<String>,
    /// Names with their definitions, each by numbers, symbols and names before it.
    definitions: Vec<(SymbolId, Expr)>,
    name_of: HashMap<Expr, Expr>,
}

impl<'a> Naming<'a> {
    /// No names.
    pub(super) fn none(pool: &'a Pool) -> Self {
        Self { pool, labels: Vec::new(), found: RefCell::default() }
    }

    /// Names that end in the labels of the links.
    pub(super) fn of(model: &'a Model, kinematics: &Kinematics, labels: Vec<String>) -> Self {
        // A name of the author must not be one of these.
        let authors = model.parameters.iter().map(|p| p.name.clone());
        let of_coordinate = |c: &crate::coordinate::Coordinate| {
            [&c.name, &c.rate_name, &c.second_rate_name].map(String::clone)
        };
        let taken = authors.chain(kinematics.coordinates.iter().flat_map(of_coordinate)).collect();
        Self { pool: &model.pool, labels, found: RefCell::new(Found { taken, ..Found::default() }) }
    }

    /// A vector of a link by the names of its components: `omega_arm_x`.
    pub(super) fn vector(&self, letter: &str, link_idx: usize, vector: &Vector) -> Vector {
        std::array::from_fn(|i| self.component(letter, link_idx, AXES[i], vector[i]))
    }

    /// A matrix of a link by the names of its entries: `A_arm_xy`.
    pub(super) fn matrix(&self, letter: &str, link_idx: usize, rows: &[Vector; 3]) -> [Vector; 3] {
        let entry = |i: usize, j: usize| {
            let axes = format!("{}{}", AXES[i], AXES[j]);
            self.component(letter, link_idx, &axes, rows[i][j])
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }

    /// A number of a link by its name: `h_arm`.
    pub(super) fn scalar(&self, letter: &str, link_idx: usize, value: Expr) -> Expr {
        self.component(letter, link_idx, "", value)
    }

    fn component(&self, letter: &str, link_idx: usize, axis: &str, value: Expr) -> Expr {
        let Some(label) = self.labels.get(link_idx) else { return value };
        if self.pool.printed_operations(&[value]).total() == 0 {
            return value;
        }
        let mut found = self.found.borrow_mut();
        if let Some(&name) = found.name_of.get(&value) {
            return name;
        }
        let parts = [letter, label, axis].into_iter().filter(|part| !part.is_empty());
        let mut text = parts.collect::<Vec<_>>().join("_");
        while !found.taken.insert(text.clone()) {
            text.push('_');
        }
        let name = self.pool.symbol(&text);
        let symbol = self.pool.symbol_id(name).expect("a symbol was just made");
        found.definitions.push((symbol, value));
        found.name_of.insert(value, name);
        name
    }

    /// The definitions that some expressions need, in an order in which each uses those before it.
    pub(super) fn needed(self, roots: &[Expr]) -> Vec<(SymbolId, Expr)> {
        let pool = self.pool;
        let mut needed: HashSet<SymbolId> =
            roots.iter().flat_map(|&root| pool.symbols_of(root)).collect();
        let mut definitions = self.found.into_inner().definitions;
        definitions.reverse();
        definitions.retain(|(symbol, definition)| {
            let is_needed = needed.contains(symbol);
            if is_needed {
                needed.extend(pool.symbols_of(*definition));
            }
            is_needed
        });
        definitions.reverse();
        definitions
    }
}
