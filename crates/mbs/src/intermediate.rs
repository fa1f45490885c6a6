//! Angles of bodies as intermediate coordinates.
//!
//! In relative coordinates the angle of a body is a sum, θ = Σ S_i q_i + const. Positions and
//! kinetic energy are short in terms of θ and long in terms of q, so Lagrange's equations are
//! derived in θ and carried over. Their left side is covariant under linear maps of the
//! coordinates (by the chain rule), also when there are more θ than q:
//!
//! ```text
//! θ = S q + const:   M = Sᵀ M̃ S,   h = Sᵀ h̃,   ∂V/∂q = Sᵀ ∂V/∂θ
//! ```

use std::collections::{BTreeMap, HashMap};

use bksim_expr::{Expr, Number, Pool, SymbolId};

use crate::kinematics::{Coordinate, Kinematics};
use crate::model::{Model, Vector};
use crate::spatial::{self, Rotation};

/// An intermediate coordinate and its rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Intermediate {
    pub(crate) q: SymbolId,
    pub(crate) v: SymbolId,
}

/// The generalised coordinates themselves, then the sums that occur as angles.
pub(crate) struct Intermediates<'m> {
    pool: &'m Pool,
    pub(crate) coordinates: Vec<Intermediate>,
    n_generalised: usize,
    /// Rows of S, those of the angle sums only.
    rows: Vec<Vec<(usize, Number)>>,
    /// Position of each angle sum among the coordinates.
    known: HashMap<Expr, usize>,
    /// Sines and cosines of the sums, and those of their symbols.
    entering: Vec<(Expr, Expr)>,
    leaving: Vec<(SymbolId, Expr)>,
}

/// How a column of S follows from another one: `S_i = S_base + Σ factor e_k`.
struct Column {
    generalised: usize,
    base: Option<usize>,
    added: Vec<(usize, Number)>,
}

impl<'m> Intermediates<'m> {
    /// The angles of all poses.
    pub(crate) fn of(model: &'m Model, kinematics: &Kinematics) -> Self {
        let own = |c: &Coordinate| Intermediate { q: c.q, v: c.v };
        let mut intermediates = Self {
            pool: &model.pool,
            coordinates: kinematics.coordinates.iter().map(own).collect(),
            n_generalised: kinematics.coordinates.len(),
            rows: Vec::new(),
            known: HashMap::new(),
            entering: Vec::new(),
            leaving: Vec::new(),
        };
        for pose in &kinematics.poses {
            for turn in pose.rotation.turns() {
                intermediates.add(turn.angle);
            }
        }
        intermediates
    }

    fn add(&mut self, angle: Expr) {
        let pool = self.pool;
        if self.known.contains_key(&angle) {
            return;
        }
        let row = self.row(angle);
        let is_plain = row.iter().any(|&(i, _)| {
            let q = pool.symbol_expr(self.coordinates[i].q);
            angle == q || angle == pool.neg(q)
        });
        if row.is_empty() || is_plain {
            return;
        }
        // Names that no author can write.
        let name = format!("#{}", self.rows.len() + 1);
        let [q, v] = [name.clone(), format!("{name}'")].map(|name| pool.symbol(&name));
        let id = |e| pool.symbol_id(e).expect("a symbol was just made");
        for (whole, short) in [(pool.sin(angle), pool.sin(q)), (pool.cos(angle), pool.cos(q))] {
            // One of the two is the call itself; the other is minus the call.
            self.entering.extend([(whole, short), (pool.neg(whole), pool.neg(short))]);
        }
        let rate = row.iter().map(|&(i, factor)| {
            pool.mul(pool.number(factor), pool.symbol_expr(self.coordinates[i].v))
        });
        let rate = pool.sum(rate.collect::<Vec<_>>());
        self.leaving.extend([(id(q), angle), (id(v), rate)]);
        self.known.insert(angle, self.coordinates.len());
        self.coordinates.push(Intermediate { q: id(q), v: id(v) });
        self.rows.push(row);
    }

    /// ∂angle/∂q: the angles of a mechanism are linear in its coordinates.
    fn row(&self, angle: Expr) -> Vec<(usize, Number)> {
        let generalised: Vec<SymbolId> =
            self.coordinates[..self.n_generalised].iter().map(|c| c.q).collect();
        let slopes = self.pool.jacobian(&[angle], &generalised).entries.into_iter();
        slopes.filter_map(|(_, i, slope)| Some((i, self.pool.as_number(slope)?))).collect()
    }

    /// An expression of q in terms of the intermediate coordinates.
    pub(crate) fn enter(&self, roots: &[Expr]) -> Vec<Expr> {
        self.pool.replace_all(roots, &self.entering)
    }

    /// Back to q and v.
    pub(crate) fn leave(&self, roots: &[Expr]) -> Vec<Expr> {
        self.pool.substitute_all(roots, &self.leaving)
    }

    /// All symbols of the intermediate coordinates, then of their rates.
    pub(crate) fn state(&self) -> Vec<SymbolId> {
        let (q, v) = (self.coordinates.iter().map(|c| c.q), self.coordinates.iter().map(|c| c.v));
        q.chain(v).collect()
    }

    /// Columns of the Jacobian ∂ω/∂θ̇ in body axes: each turn's axis, seen through the turns after it.
    pub(crate) fn turning(&self, rotation: &Rotation) -> Vec<(usize, Vector)> {
        let pool = self.pool;
        let mut columns: Vec<(usize, Vector)> = Vec::new();
        let mut inner = Rotation::default();
        for turn in rotation.turns().iter().rev() {
            let axis_body = inner.apply_inverse(pool, &turn.axis).map(|e| self.enter(&[e])[0]);
            let through = match self.known.get(&turn.angle) {
                Some(&k) => vec![(k, Number::ONE)],
                None => self.row(turn.angle),
            };
            for (k, factor) in through {
                let column = spatial::scale(pool, pool.number(factor), &axis_body);
                match columns.iter_mut().find(|known| known.0 == k) {
                    Some(known) => known.1 = spatial::add(pool, &known.1, &column),
                    None => columns.push((k, column)),
                }
            }
            inner = Rotation::about(pool, &turn.axis, turn.angle).then(pool, &inner);
        }
        columns
    }

    /// Sᵀ x, with x given sparsely by intermediate coordinate. Sums that one column of S shares
    /// with another are shared.
    pub(crate) fn pull_back(&self, x: &BTreeMap<usize, Expr>) -> Vec<Expr> {
        let pool = self.pool;
        let mut result = vec![pool.zero(); self.n_generalised];
        for column in self.columns(&|k| x.contains_key(&k)) {
            let base = column.base.map_or(pool.zero(), |i| result[i]);
            let added = column.added.iter().map(|(k, c)| pool.mul(pool.number(*c), x[k]));
            result[column.generalised] = pool.sum(added.chain([base]).collect::<Vec<_>>());
        }
        result
    }

    /// Sᵀ X S of a symmetric X, given sparsely by its lower triangle.
    pub(crate) fn congruent(&self, lower: &BTreeMap<(usize, usize), Expr>) -> Vec<Vec<Expr>> {
        let mut rows: BTreeMap<usize, BTreeMap<usize, Expr>> = BTreeMap::new();
        for (&(k, l), &e) in lower {
            rows.entry(k).or_default().insert(l, e);
            rows.entry(l).or_default().insert(k, e);
        }
        // X S by rows, then Sᵀ times each of its columns.
        let half: BTreeMap<usize, Vec<Expr>> =
            rows.iter().map(|(&k, row)| (k, self.pull_back(row))).collect();
        let n = self.n_generalised;
        let columns: Vec<Vec<Expr>> = (0..n)
            .map(|j| self.pull_back(&half.iter().map(|(&k, row)| (k, row[j])).collect()))
            .collect();
        (0..n).map(|i| (0..n).map(|j| columns[i.min(j)][i.max(j)]).collect()).collect()
    }

    /// How many intermediate coordinates each generalised coordinate moves.
    pub(crate) fn spreads(&self) -> Vec<usize> {
        let of = |i: usize| self.rows.iter().filter(|row| row.iter().any(|e| e.0 == i)).count();
        (0..self.n_generalised).map(|i| 1 + of(i)).collect()
    }

    /// The columns of S, restricted to some rows, each as another one and a little more; a column
    /// comes after its base.
    fn columns(&self, is_wanted: &dyn Fn(usize) -> bool) -> Vec<Column> {
        let mut full: Vec<(usize, Vec<(usize, Number)>)> =
            (0..self.n_generalised).map(|i| (i, Vec::new())).collect();
        for (i, column) in &mut full {
            if is_wanted(*i) {
                column.push((*i, Number::ONE));
            }
        }
        for (row_idx, row) in self.rows.iter().enumerate() {
            let k = self.n_generalised + row_idx;
            if is_wanted(k) {
                for &(i, factor) in row {
                    full[i].1.push((k, factor));
                }
            }
        }
        full.retain(|(_, column)| !column.is_empty());
        full.sort_by_key(|(_, column)| column.len());
        let mut columns: Vec<Column> = Vec::with_capacity(full.len());
        for (at, (generalised, own)) in full.iter().enumerate() {
            // The longest earlier column that is part of this one.
            let base = full[..at]
                .iter()
                .rev()
                .find(|(_, earlier)| earlier.iter().all(|entry| own.contains(entry)));
            let added = own.iter().filter(|entry| base.is_none_or(|(_, b)| !b.contains(entry)));
            columns.push(Column {
                generalised: *generalised,
                base: base.map(|&(i, _)| i),
                added: added.copied().collect(),
            });
        }
        columns
    }
}
