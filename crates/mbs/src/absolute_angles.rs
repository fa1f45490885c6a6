//! Absolute angles of bodies as coordinates of the derivation.
//!
//! In relative coordinates the angle of a body is a sum, θ = Σ S_i q_i + const. Positions and
//! kinetic energy are short in terms of θ and long in terms of q, so Lagrange's equations are
//! derived in θ and pulled back to q. Their left side is covariant under linear maps of the
//! coordinates (by the chain rule), also when there are more θ than q:
//!
//! ```text
//! θ = S q + const:   M = Sᵀ M̃ S,   h = Sᵀ h̃,   ∂V/∂q = Sᵀ ∂V/∂θ
//! ```

use std::collections::{BTreeMap, HashMap};

use bksim_expr::{Expr, Number, Pool, SymbolId};

use crate::coordinate::Coordinate;
use crate::kinematics::Kinematics;
use crate::spatial::{self, Rotation, Turn};
use bksim_model::{Model, Vector};

/// A coordinate of the derivation and its rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variable {
    pub(crate) q: SymbolId,
    pub(crate) v: SymbolId,
}

/// The coordinates of the derivation: the generalised ones, then the sums that occur as angles.
pub(crate) struct AbsoluteAngles<'m> {
    pool: &'m Pool,
    pub(crate) coordinates: Vec<Variable>,
    n_generalised: usize,
    /// Rows of S, those of the angle sums only.
    rows: Vec<Vec<(usize, Number)>>,
    /// Index of each angle sum among the coordinates.
    known: HashMap<Expr, usize>,
    /// Index of the generalised coordinate whose value each symbol is.
    generalised: HashMap<SymbolId, usize>,
    /// Sines and cosines of the sums, and those of their symbols.
    to_angles: Vec<(Expr, Expr)>,
    /// The symbols of the sums and of their rates, and what they abbreviate in q and v.
    from_angles: Vec<(SymbolId, Expr)>,
}

/// A column of S as the sum of another one and a rest: `S_i = S_base + Σ factor e_k`.
struct Column {
    generalised: usize,
    base: Option<usize>,
    added: Vec<(usize, Number)>,
}

impl<'m> AbsoluteAngles<'m> {
    /// The angles of all poses.
    pub(crate) fn of(model: &'m Model, kinematics: &Kinematics) -> Self {
        let own = |c: &Coordinate| Variable { q: c.q, v: c.v };
        let mut angles = Self {
            pool: &model.pool,
            coordinates: kinematics.coordinates.iter().map(own).collect(),
            n_generalised: kinematics.coordinates.len(),
            rows: Vec::new(),
            known: HashMap::new(),
            generalised: kinematics.coordinates.iter().map(|c| c.q).zip(0..).collect(),
            to_angles: Vec::new(),
            from_angles: Vec::new(),
        };
        for pose in &kinematics.poses {
            for turn in pose.rotation.turns() {
                if let Turn::About { angle, .. } = turn {
                    angles.add(*angle);
                }
            }
        }
        angles
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
            self.to_angles.extend([(whole, short), (pool.neg(whole), pool.neg(short))]);
        }
        let rate = row.iter().map(|(i, factor)| {
            pool.mul(pool.number(factor.clone()), pool.symbol_expr(self.coordinates[*i].v))
        });
        let rate = pool.sum(rate.collect::<Vec<_>>());
        self.from_angles.extend([(id(q), angle), (id(v), rate)]);
        self.known.insert(angle, self.coordinates.len());
        self.coordinates.push(Variable { q: id(q), v: id(v) });
        self.rows.push(row);
    }

    /// ∂angle/∂q: the angles of a mechanism are linear in its coordinates.
    fn row(&self, angle: Expr) -> Vec<(usize, Number)> {
        let mut moving: Vec<usize> = self
            .pool
            .symbols_of(angle)
            .iter()
            .filter_map(|symbol| self.generalised.get(symbol).copied())
            .collect();
        moving.sort_unstable();
        let symbols: Vec<SymbolId> = moving.iter().map(|&i| self.coordinates[i].q).collect();
        let slopes = self.pool.jacobian(&[angle], &symbols).entries.into_iter();
        let number = |slope| self.pool.as_number(slope).expect("angles are linear in q");
        slopes.map(|(_, i, slope)| (moving[i], number(slope))).collect()
    }

    /// Expressions of q in terms of the absolute angles.
    pub(crate) fn to_angles(&self, roots: &[Expr]) -> Vec<Expr> {
        self.pool.replace_all(roots, &self.to_angles)
    }

    /// Expressions of the absolute angles and their rates in terms of q and v.
    pub(crate) fn back_to_q(&self, roots: &[Expr]) -> Vec<Expr> {
        self.pool.substitute_all(roots, &self.from_angles)
    }

    /// All symbols of the coordinates of the derivation, then of their rates.
    pub(crate) fn state(&self) -> Vec<SymbolId> {
        let (q, v) = (self.coordinates.iter().map(|c| c.q), self.coordinates.iter().map(|c| c.v));
        q.chain(v).collect()
    }

    /// Columns of the Jacobians ∂ω/∂θ̇ in body axes of some rotations.
    pub(crate) fn turning<'r>(
        &self,
        rotations: impl Iterator<Item = &'r Rotation>,
    ) -> Vec<Vec<(usize, Vector)>> {
        let columns: Vec<_> = rotations.map(|rotation| self.turning_of(rotation)).collect();
        let components: Vec<Expr> =
            columns.iter().flatten().flat_map(|(_, column)| *column).collect();
        let mut images = self.to_angles(&components).into_iter();
        let mut next = |(k, column): (usize, Vector)| {
            let image = |_| images.next().expect("one image for each component");
            (k, column.map(image))
        };
        columns.into_iter().map(|columns| columns.into_iter().map(&mut next).collect()).collect()
    }

    /// Each turn's axis, seen through the turns after it, in terms of q.
    fn turning_of(&self, rotation: &Rotation) -> Vec<(usize, Vector)> {
        let pool = self.pool;
        let mut columns: Vec<(usize, Vector)> = Vec::new();
        let mut inner = Rotation::default();
        let mut add = |k: usize, column: Vector| match columns.iter_mut().find(|it| it.0 == k) {
            Some(known) => known.1 = spatial::add(pool, &known.1, &column),
            None => columns.push((k, column)),
        };
        for turn in rotation.turns().iter().rev() {
            match turn {
                Turn::About { axis, angle } => {
                    let axis_body = inner.apply_inverse(pool, axis);
                    let through = match self.known.get(angle) {
                        Some(&k) => vec![(k, Number::ONE)],
                        None => self.row(*angle),
                    };
                    for (k, factor) in through {
                        add(k, spatial::scale(pool, pool.number(factor), &axis_body));
                    }
                    inner = Rotation::about(pool, axis, *angle).then(pool, &inner);
                }
                // Columns of s E, by the parts or their negatives.
                Turn::By(quaternion) => {
                    let s = quaternion.scale(pool);
                    let symbols = quaternion.0.iter().flat_map(|&part| pool.symbols_of(part));
                    for symbol in symbols {
                        let by = quaternion.0.map(|part| pool.diff(part, symbol));
                        let rate = quaternion.to_inner_rate(pool, &by);
                        let column = inner.apply_inverse(pool, &spatial::scale(pool, s, &rate));
                        if let Some(&k) = self.generalised.get(&symbol) {
                            add(k, column);
                        }
                    }
                    inner = Rotation::by(pool, *quaternion).then(pool, &inner);
                }
            }
        }
        columns
    }

    /// Sᵀ x, both by the coordinates where they are not zero. Sums that one column of S shares with
    /// another are shared.
    pub(crate) fn pull_back(&self, x: &BTreeMap<usize, Expr>) -> BTreeMap<usize, Expr> {
        let pool = self.pool;
        let mut result = BTreeMap::new();
        for column in self.columns(x.keys().copied()) {
            let base = column.base.map_or(pool.zero(), |i| result[&i]);
            let added = column.added.iter().map(|(k, c)| pool.mul(pool.number(c.clone()), x[k]));
            let sum = pool.sum(added.chain([base]).collect::<Vec<_>>());
            result.insert(column.generalised, sum);
        }
        result
    }

    /// Sᵀ X S of a symmetric X, both by their lower triangles.
    pub(crate) fn congruent(
        &self,
        lower: &BTreeMap<(usize, usize), Expr>,
    ) -> BTreeMap<(usize, usize), Expr> {
        let mut rows: BTreeMap<usize, BTreeMap<usize, Expr>> = BTreeMap::new();
        for (&(k, l), &e) in lower {
            rows.entry(k).or_default().insert(l, e);
            rows.entry(l).or_default().insert(k, e);
        }
        // X S by rows, then Sᵀ times each of its columns.
        let mut half: BTreeMap<usize, BTreeMap<usize, Expr>> = BTreeMap::new();
        for (&k, row) in &rows {
            for (j, e) in self.pull_back(row) {
                half.entry(j).or_default().insert(k, e);
            }
        }
        let below = |(j, column): (usize, BTreeMap<usize, Expr>)| {
            let product = self.pull_back(&column).into_iter();
            product.filter(move |&(i, _)| j <= i).map(move |(i, e)| ((i, j), e))
        };
        half.into_iter().flat_map(below).collect()
    }

    /// Number of coordinates of the derivation that each generalised coordinate moves.
    pub(crate) fn spreads(&self) -> Vec<usize> {
        let mut spreads = vec![1; self.n_generalised];
        for (i, _) in self.rows.iter().flatten() {
            spreads[*i] += 1;
        }
        spreads
    }

    /// The columns of S that are not zero, restricted to some `rows` in ascending order, each as
    /// another one and a little more; a column comes after its base.
    fn columns(&self, rows: impl Iterator<Item = usize>) -> Vec<Column> {
        let mut full: BTreeMap<usize, Vec<(usize, Number)>> = BTreeMap::new();
        for k in rows {
            match k.checked_sub(self.n_generalised) {
                None => full.entry(k).or_default().push((k, Number::ONE)),
                Some(row_idx) => {
                    for (i, factor) in &self.rows[row_idx] {
                        full.entry(*i).or_default().push((k, factor.clone()));
                    }
                }
            }
        }
        let mut full: Vec<(usize, Vec<(usize, Number)>)> = full.into_iter().collect();
        full.sort_by_key(|(_, column)| column.len());
        // A part of a column begins with one of its entries.
        let mut beginning_at: HashMap<usize, Vec<usize>> = HashMap::new();
        let mut columns: Vec<Column> = Vec::with_capacity(full.len());
        for (at, (generalised, own)) in full.iter().enumerate() {
            // The longest earlier column that is part of this one.
            let earlier = own.iter().filter_map(|(k, _)| beginning_at.get(k)).flatten();
            let mut earlier: Vec<usize> = earlier.copied().collect();
            earlier.sort_unstable_by(|a, b| b.cmp(a));
            let is_part = |&&at: &&usize| is_part(&full[at].1, own);
            let base = earlier.iter().find(is_part).map(|&at| &full[at]);
            beginning_at.entry(own[0].0).or_default().push(at);
            let added = own.iter().filter(|entry| base.is_none_or(|(_, b)| !b.contains(entry)));
            columns.push(Column {
                generalised: *generalised,
                base: base.map(|&(i, _)| i),
                added: added.cloned().collect(),
            });
        }
        columns
    }
}

/// True if all entries of `part` are entries of `whole`; both ascend.
fn is_part(part: &[(usize, Number)], whole: &[(usize, Number)]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|entry| rest.any(|other| other == entry))
}
