//! [`Equations`]: the equations at rest in letters, solved by exact elimination.

use bksim_expr::{Expr, Pool, SymbolId};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Model, ParameterId};

use super::blocks::{Blocks, MAX_DETERMINANT, MAX_TERMS};
use crate::channels::Input;
use crate::forces::residuals;
use crate::loaded::Loaded;

/// A matrix of expressions: a row, or where it says so a column, one after the other.
pub(super) type Symbolic = Vec<Vec<Expr>>;

/// A column of a matrix by rows.
pub(super) fn column(matrix: &Symbolic, j: usize) -> Vec<Expr> {
    matrix.iter().map(|row| row[j]).collect()
}

/// The equations at rest in letters.
pub(super) struct Equations<'a> {
    pub(super) model: &'a Model,
    pub(super) system: &'a SymbolicSystem,
    pub(super) rows: &'a [usize],
    /// Independent coordinates, then the others.
    by: &'a [usize],
    dependent: Vec<usize>,
    mass: Symbolic,
    stiffness: Symbolic,
    damping: Symbolic,
    jacobian: Symbolic,
    residual: Vec<Expr>,
    /// Names for what is long.
    pub(super) blocks: Blocks<'a>,
    /// Velocities, accelerations and modes, with what they are at rest.
    rest: Vec<(SymbolId, Expr)>,
}

impl<'a> Equations<'a> {
    /// The equations by the coordinates `by`, at velocities of a steady motion.
    pub(super) fn of(
        loaded: &'a Loaded,
        (rows, by): (&'a [usize], &'a [usize]),
        steady: &[f64],
    ) -> Self {
        let (model, system) = (loaded.model(), loaded.system());
        let pool = &model.pool;
        let coordinates = system.coordinates();
        let n = coordinates.len();
        let states = loaded.state_coordinates();
        // A coordinate that a drive moves has its rate in letters.
        let driven = |i: usize| {
            let mut rows = rows.iter().map(|&row| (row, system.constraint_jacobian.row(row)));
            let (row, own) = rows.find(|(_, own)| own.len() == 1 && own[0].0 == i)?;
            Some(pool.neg(pool.div(system.constraint_rate[row], own[0].1)))
        };
        let rate = |i: usize| match steady[i] {
            0.0 => pool.zero(),
            rate => driven(i).unwrap_or_else(|| pool.float(rate)),
        };
        let still = (0..n).filter(|i| !states.contains(i)).map(|i| (coordinates[i].v, rate(i)));
        let still = still.chain(coordinates.iter().map(|c| (c.a, pool.zero())));
        let modes = system.parameters(model).into_iter().zip(&loaded.parameters);
        let modes = modes.skip(model.parameters.len());
        let rest: Vec<(SymbolId, Expr)> =
            still.chain(modes.map(|(symbol, value)| (symbol, pool.float(*value)))).collect();
        let residual = residuals(model, system, rows);
        let dense = |symbols: Vec<SymbolId>| -> Symbolic {
            let slopes = |&e: &Expr| {
                let own = pool.gradient(e, &symbols);
                own.into_iter().map(|slope| pool.substitute(slope, &rest)).collect()
            };
            residual.iter().map(slopes).collect()
        };
        let row = |&row: &usize| {
            let mut entries = vec![pool.zero(); n];
            for &(column, e) in system.constraint_jacobian.row(row) {
                entries[column] = pool.substitute(e, &rest);
            }
            entries
        };
        Self {
            model,
            system,
            rows,
            by,
            dependent: (0..n).filter(|i| !by.contains(i)).collect(),
            mass: dense(coordinates.iter().map(|c| c.a).collect()),
            stiffness: dense(coordinates.iter().map(|c| c.q).collect()),
            damping: dense(coordinates.iter().map(|c| c.v).collect()),
            jacobian: rows.iter().map(row).collect(),
            residual,
            blocks: Blocks::new(pool),
            rest,
        }
    }

    /// Names of coordinates.
    fn name(&self, i: usize) -> &'a str {
        &self.system.coordinates()[i].name
    }

    pub(super) fn pool(&self) -> &'a Pool {
        &self.model.pool
    }

    /// Unknowns of linear equations.
    fn unknowns(&self, n: usize) -> (Vec<Expr>, Vec<SymbolId>) {
        let pool = self.pool();
        let symbols: Vec<Expr> = (0..n).map(|k| pool.symbol(&format!("'x{k}"))).collect();
        let ids = symbols.iter().filter_map(|&e| pool.symbol_id(e)).collect();
        (symbols, ids)
    }

    fn dot(&self, row: &[Expr], x: &[Expr]) -> Expr {
        let pool = self.pool();
        pool.sum(row.iter().zip(x).map(|(&a, &b)| pool.mul(a, b)).collect::<Vec<_>>())
    }

    pub(super) fn times(&self, matrix: &Symbolic, x: &[Expr]) -> Vec<Expr> {
        matrix.iter().map(|row| self.dot(row, x)).collect()
    }

    /// Z: nq × free motions; `None` where the rows do not determine the dependent coordinates.
    ///
    /// Where the determinant of their columns would be long, it is found in names for its entries.
    pub(super) fn free_motions(&mut self) -> Option<Symbolic> {
        let pool = self.pool();
        let terms = |row: &Vec<Expr>| {
            let of_dependent = self.dependent.iter().map(|&i| row[i]).filter(|&e| !pool.is_zero(e));
            of_dependent.map(|e| pool.multiplied_out(e)).sum::<u64>()
        };
        let n_terms = self.jacobian.iter().map(terms).fold(1, u64::saturating_mul);
        if n_terms > MAX_DETERMINANT {
            let plain = self.jacobian.clone();
            self.jacobian = self.named_jacobian();
            if let Some(z) = self.solved_free_motions(true) {
                return Some(z);
            }
            self.jacobian = plain;
        }
        self.solved_free_motions(false)
    }

    /// A name for each slope of the rows that is no number.
    fn named_jacobian(&self) -> Symbolic {
        let named = |(k, row): (usize, &Vec<Expr>)| {
            let entry = |(i, &e): (usize, &Expr)| {
                self.blocks.named(e, || format!("G_{}_{}", k + 1, self.name(i)))
            };
            row.iter().enumerate().map(entry).collect()
        };
        self.jacobian.iter().enumerate().map(named).collect()
    }

    /// Z by exact elimination. In names a pivot may vanish that would be seen to vanish written out: then there is none.
    fn solved_free_motions(&self, in_names: bool) -> Option<Symbolic> {
        let pool = self.pool();
        let n = self.by.len() + self.dependent.len();
        let (symbols, ids) = self.unknowns(self.dependent.len());
        let mut z = vec![vec![pool.zero(); self.by.len()]; n];
        for (j, &own) in self.by.iter().enumerate() {
            z[own][j] = pool.one();
            if self.dependent.is_empty() {
                continue;
            }
            let equation = |row: &Vec<Expr>| {
                let others: Vec<Expr> = self.dependent.iter().map(|&i| row[i]).collect();
                pool.add(self.dot(&others, &symbols), row[own])
            };
            let equations: Vec<Expr> = self.jacobian.iter().map(equation).collect();
            let solution = pool.solve_linear(&equations, &ids).ok()?;
            let vanishes = |&pivot: &Expr| pool.certificate(pivot, pool.zero()).is_equal();
            if in_names && self.blocks.written_out(&solution.nonzero).iter().any(vanishes) {
                return None;
            }
            for (&i, value) in self.dependent.iter().zip(solution.values) {
                let name = || format!("Z_{}_{}", self.name(i), self.name(own));
                z[i][j] =
                    if in_names { self.blocks.named(value, name) } else { pool.simplify(value) };
            }
        }
        Some(z)
    }

    /// ∂r along y, along ẏ and by the inputs: a column for each.
    pub(super) fn forces(
        &self,
        z: &Symbolic,
        loaded: &Loaded,
        inputs: &[Input],
        free: &[ParameterId],
    ) -> [Symbolic; 3] {
        let pool = self.pool();
        let n = self.by.len();
        let along = |matrix: &Symbolic| (0..n).map(|j| self.times(matrix, &column(z, j))).collect();
        let by_input = |input: &Input| match input {
            Input::Parameter(idx) => {
                let symbol = self.model.parameters[free[*idx].0].symbol;
                let own = |&e: &Expr| {
                    let followed = crate::forces::with_definitions(self.model, free, e);
                    pool.substitute(pool.diff(followed, symbol), &self.rest)
                };
                self.residual.iter().map(own).collect()
            }
            Input::Effort(quantity) => {
                let q: Vec<SymbolId> = loaded.system().coordinates().iter().map(|c| c.q).collect();
                let slopes = pool.gradient(quantity.value, &q).into_iter();
                slopes.map(|slope| pool.neg(pool.substitute(slope, &self.rest))).collect()
            }
        };
        let by_input = inputs.iter().map(by_input).collect();
        [along(&self.stiffness), along(&self.damping), by_input]
    }

    /// ÿ for each of some columns of ∂r, a column of as many; `letter` names the columns.
    pub(super) fn accelerations(
        &self,
        z: &Symbolic,
        (letter, forces): (&str, &Symbolic),
    ) -> Option<Symbolic> {
        let pool = self.pool();
        let n = self.by.len();
        let onto = |forces: &[Expr]| -> Vec<Expr> {
            (0..n).map(|j| self.dot(&column(z, j), forces)).collect()
        };
        let mass: Symbolic = (0..n).map(|j| onto(&self.times(&self.mass, &column(z, j)))).collect();
        let (symbols, ids) = self.unknowns(n);
        let of = |i: usize| self.name(self.by[i]);
        let solved = |(column, forces): (usize, &Vec<Expr>)| -> Option<Vec<Expr>> {
            let right = onto(forces);
            let equation = |i: usize| {
                let row: Vec<Expr> = (0..n).map(|j| mass[j.max(i)][j.min(i)]).collect();
                let whole = pool.add(self.dot(&row, &symbols), right[i]);
                if self.blocks.is_empty() && pool.multiplied_out(whole) <= MAX_TERMS {
                    return pool.simplify(whole);
                }
                let entry = |(j, &e): (usize, &Expr)| {
                    let name = || format!("M_{}_{}", of(j.max(i)), of(j.min(i)));
                    self.blocks.named(e, name)
                };
                let row: Vec<Expr> = row.iter().enumerate().map(entry).collect();
                let name = || format!("{letter}_{}_{}", of(i), column + 1);
                pool.add(self.dot(&row, &symbols), self.blocks.named(right[i], name))
            };
            let equations: Vec<Expr> = (0..n).map(equation).collect();
            let values = pool.solve_linear(&equations, &ids).ok()?.values;
            Some(self.folded(&values))
        };
        forces.iter().enumerate().map(solved).collect()
    }

    /// The expressions in their cheapest forms, if they are short.
    pub(super) fn folded(&self, values: &[Expr]) -> Vec<Expr> {
        let pool = self.pool();
        if values.iter().all(|&e| pool.multiplied_out(e) <= MAX_TERMS) {
            return pool.simplify_all(values);
        }
        values.iter().map(|&e| pool.simplify_up_to(e, MAX_TERMS)).collect()
    }

    /// δλ for each of some columns of ∂r with its ÿ, from the rows of the dependent coordinates:
    /// Gᵀ δλ = −∂r − M Z ÿ.
    pub(super) fn multipliers(
        &self,
        z: &Symbolic,
        (letter, forces): (&str, &Symbolic),
        accelerations: &Symbolic,
    ) -> Option<Symbolic> {
        let pool = self.pool();
        let (symbols, ids) = self.unknowns(self.rows.len());
        let solved = |(column, (forces, own)): (usize, (&Vec<Expr>, &Vec<Expr>))| {
            if ids.is_empty() {
                return Some(Vec::new());
            }
            let inertia = self.times(&self.mass, &self.times(z, own));
            let equation = |&i: &usize| {
                let held: Vec<Expr> = self.jacobian.iter().map(|row| row[i]).collect();
                let rest = pool.add(forces[i], inertia[i]);
                let whole = pool.add(self.dot(&held, &symbols), rest);
                if pool.multiplied_out(whole) <= MAX_TERMS {
                    return pool.simplify(whole);
                }
                let name = || format!("R{letter}_{}_{}", self.name(i), column + 1);
                pool.add(self.dot(&held, &symbols), self.blocks.named(rest, name))
            };
            let equations: Vec<Expr> = self.dependent.iter().map(equation).collect();
            pool.solve_linear(&equations, &ids).ok().map(|solution| solution.values)
        };
        forces.iter().zip(accelerations).enumerate().map(solved).collect()
    }

    /// The change of each output for one of a column: δz = z_q δq + z_v δv + z_a δa + z_λ δλ.
    pub(super) fn outputs(
        &self,
        expressions: &[Expr],
        [q, v, a]: [Option<&[Expr]>; 3],
        lambda: &[Expr],
    ) -> Vec<Expr> {
        let pool = self.pool();
        let coordinates = self.system.coordinates();
        let symbols = |of: fn(&bksim_mbs::coordinate::Coordinate) -> SymbolId| -> Vec<SymbolId> {
            coordinates.iter().map(of).collect()
        };
        let own: Vec<SymbolId> =
            self.rows.iter().map(|&row| self.system.constraints[row].lambda).collect();
        let parts = [
            (symbols(|c| c.q), q),
            (symbols(|c| c.v), v),
            (symbols(|c| c.a), a),
            (own, Some(lambda)),
        ];
        let change = |&e: &Expr| {
            let part = |(symbols, change): &(Vec<SymbolId>, Option<&[Expr]>)| {
                change.map_or(pool.zero(), |change| {
                    let slopes = pool.gradient(e, symbols).into_iter();
                    let slopes: Vec<Expr> = slopes.map(|slope| self.at_rest(slope)).collect();
                    self.dot(&slopes, change)
                })
            };
            pool.sum(parts.iter().map(part).collect::<Vec<_>>())
        };
        expressions.iter().map(change).collect()
    }

    /// An expression at rest; multipliers of rows that follow from others are zero.
    pub(super) fn at_rest(&self, e: Expr) -> Expr {
        let pool = self.pool();
        let constraints = self.system.constraints.iter().enumerate();
        let others = constraints.filter(|(row, _)| !self.rows.contains(row));
        let others = others.map(|(_, c)| (c.lambda, pool.zero()));
        pool.substitute(e, &self.rest.iter().copied().chain(others).collect::<Vec<_>>())
    }

    /// The letters of a pose that occur, with their values: coordinates, states, multipliers.
    pub(super) fn pose(
        &self,
        entries: &[Expr],
        (q, v, lambda): (&[f64], &[f64], &[f64]),
    ) -> Vec<(String, f64)> {
        let pool = self.pool();
        let coordinates = self.system.coordinates();
        let positions = coordinates.iter().zip(q).map(|(c, value)| (c.q, *value));
        let rates = coordinates.iter().zip(v).map(|(c, value)| (c.v, *value));
        let multipliers = self.rows.iter().zip(lambda);
        let multipliers =
            multipliers.map(|(&row, value)| (self.system.constraints[row].lambda, *value));
        let all = positions.chain(rates).chain(multipliers);
        let occurs = |symbol: SymbolId| entries.iter().any(|&e| pool.depends_on(e, symbol));
        let named = all.filter(|(symbol, _)| occurs(*symbol));
        named.map(|(symbol, value)| (pool.symbol_name(symbol), value)).collect()
    }
}
