//! [`Letters`]: A and B about a pose at rest in letters, with a certificate.
//!
//! ```text
//! G Z = 0, Z = 1 on the independent coordinates        by exact elimination
//! Zᵀ M Z w = −Zᵀ (K Z y + C Z ẏ) + Zᵀ B u              K with ∂(Gᵀ λ)/∂q; λ are letters, too
//! ```
//!
//! The certificate compares every entry with numbers that come another way, by singular values of G and compiled derivatives,
//! at random coordinates, multipliers and parameters. As entries are analytic functions, agreement there is
//! agreement everywhere but for an event of probability zero and rounding.

use bksim_expr::{Expr, Pool, SymbolId, Tape};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::balance::Balance;
use crate::channels::{Channels, Input};
use crate::curve::independent_rows;
use crate::error::AnalysisError;
use crate::forces::{At, Forces, ForcesAt, residuals};
use crate::linear::{inputs_of, kept_states};
use crate::loaded::Loaded;
use crate::reduced::null_space;
use crate::table::Column;

/// Linear equations in letters: ẋ = A x + B u.
#[derive(Clone, PartialEq, Debug)]
pub struct Letters {
    /// Names and units of the states.
    pub states: Vec<Column>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// n × n, row by row.
    pub a: Vec<Vec<String>>,
    /// n × inputs, row by row.
    pub b: Vec<Vec<String>>,
    /// Letters of the pose, coordinates, states and multipliers, with their values there, SI.
    pub pose: Vec<(String, f64)>,
    /// Random points at which the entries were compared with numbers.
    pub n_points: usize,
    /// Largest difference there, over the largest entry of its matrix.
    pub largest_difference: f64,
}

/// Most free motions, and most coordinates that depend on them, of equations in letters.
const LARGEST: usize = 4;
/// Points of the certificate.
const N_POINTS: usize = 20;

/// A matrix of expressions, row by row.
type Symbolic = Vec<Vec<Expr>>;

/// A and B of `model` about the equilibrium nearest to the start; `None` of a mechanism that is too large for letters.
///
/// # Errors
/// [`AnalysisError`] as [`crate::linearize`].
pub fn letters(model: Model, channels: &Channels) -> Result<Option<Letters>, AnalysisError> {
    let channels = channels.or_stated(&model);
    let loaded = Loaded::of(model)?;
    let (free, inputs) = inputs_of(&loaded, &channels.inputs)?;
    let mut balance = Balance::of(&loaded, &[], &[])?;
    let q = balance.nearest()?.q;
    let none = vec![0.0; balance.forces.nc()];
    let jacobian = balance.at(&q, &none).jacobian;
    let reduced = balance.reduced(&q, &jacobian)?;

    // Rows that do not follow from others, and the coordinates that the free motions are by.
    let (model, system) = (loaded.model(), loaded.system());
    let rows: Vec<usize> =
        independent_rows(&jacobian).into_iter().map(|k| loaded.kept[k]).collect();
    let coordinates = system.coordinates();
    let place = |name: &String| coordinates.iter().position(|c| c.name == *name);
    let by: Vec<usize> = reduced.names.iter().filter_map(place).collect();
    if by.len() > LARGEST + loaded.state_coordinates().len() || rows.len() > LARGEST {
        return Ok(None);
    }
    let symbolic = Equations::of(&loaded, &rows, &by);
    let Some(z) = symbolic.free_motions() else { return Ok(None) };
    let Some([stiffness, damping, by_input]) = symbolic.accelerations(&z, &loaded, &inputs, &free)
    else {
        return Ok(None);
    };

    // x = (y, ẏ, z) in letters.
    let pool = &model.pool;
    let n = by.len();
    let (kept, states) = kept_states(&loaded, &reduced);
    let rate = |i: usize, j: usize| if i == j { pool.one() } else { pool.zero() };
    let entry_a = |i: usize, j: usize| match (i < n, j < n) {
        (true, true) => pool.zero(),
        (true, false) => rate(i, j - n),
        (false, true) => stiffness[i - n][j],
        (false, false) => damping[i - n][j - n],
    };
    let entry_b = |i: usize, k: usize| if i < n { pool.zero() } else { by_input[i - n][k] };
    let a = kept.iter().map(|&i| kept.iter().map(|&j| entry_a(i, j)).collect()).collect();
    let b = kept.iter().map(|&i| (0..inputs.len()).map(|k| entry_b(i, k)).collect()).collect();
    let [a, b]: [Symbolic; 2] = [a, b];

    let mut forces = Forces::compile(model, system, &rows, &free, &loaded.parameters)?;
    let rest = balance.velocities(&q);
    let p: Vec<f64> = free.iter().map(|id| loaded.parameters[id.0]).collect();
    let lambda = forces.balancing(loaded.t, [&q, &rest], &p).unwrap_or_default();
    let certificate = Certificate { loaded: &loaded, rows: &rows, by: &by, kept: &kept };
    let largest_difference = certificate.largest([&a, &b], (&mut forces, &inputs), (&q, &free))?;
    let text = |rows: &Symbolic| {
        rows.iter().map(|row| row.iter().map(|&e| pool.to_text(e)).collect()).collect()
    };
    let entries: Vec<Expr> = a.iter().chain(&b).flatten().copied().collect();
    Ok(Some(Letters {
        states,
        inputs: channels.inputs.clone(),
        a: text(&a),
        b: text(&b),
        pose: symbolic.pose(&entries, (&q, &rest, &lambda)),
        n_points: N_POINTS,
        largest_difference,
    }))
}

/// The equations at rest in letters.
struct Equations<'a> {
    model: &'a Model,
    system: &'a SymbolicSystem,
    rows: &'a [usize],
    /// Independent coordinates, then the others.
    by: &'a [usize],
    dependent: Vec<usize>,
    mass: Symbolic,
    stiffness: Symbolic,
    damping: Symbolic,
    jacobian: Symbolic,
    residual: Vec<Expr>,
    /// Velocities, accelerations and modes, with what they are at rest.
    rest: Vec<(SymbolId, Expr)>,
}

impl<'a> Equations<'a> {
    fn of(loaded: &'a Loaded, rows: &'a [usize], by: &'a [usize]) -> Self {
        let (model, system) = (loaded.model(), loaded.system());
        let pool = &model.pool;
        let coordinates = system.coordinates();
        let n = coordinates.len();
        let states = loaded.state_coordinates();
        let still = (0..n).filter(|i| !states.contains(i)).map(|i| coordinates[i].v);
        let still =
            still.chain(coordinates.iter().map(|c| c.a)).map(|symbol| (symbol, pool.zero()));
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
            rest,
        }
    }

    fn pool(&self) -> &'a Pool {
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

    /// Z: nq × free motions; `None` where the rows do not determine the dependent coordinates.
    fn free_motions(&self) -> Option<Symbolic> {
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
            for (&i, value) in self.dependent.iter().zip(solution.values) {
                z[i][j] = pool.simplify(value);
            }
        }
        Some(z)
    }

    /// ÿ by y, by ẏ and by the inputs.
    fn accelerations(
        &self,
        z: &Symbolic,
        loaded: &Loaded,
        inputs: &[Input],
        free: &[bksim_model::ParameterId],
    ) -> Option<[Symbolic; 3]> {
        let pool = self.pool();
        let n = self.by.len();
        let column = |j: usize| z.iter().map(|row| row[j]).collect::<Vec<Expr>>();
        let onto = |forces: &[Expr]| -> Vec<Expr> {
            (0..n).map(|j| self.dot(&column(j), forces)).collect()
        };
        let times = |matrix: &Symbolic, j: usize| -> Vec<Expr> {
            let own = column(j);
            matrix.iter().map(|row| self.dot(row, &own)).collect()
        };
        let mass: Symbolic = (0..n).map(|j| onto(&times(&self.mass, j))).collect();
        let (symbols, ids) = self.unknowns(n);
        let solved = |forces: &[Expr]| -> Option<Vec<Expr>> {
            let right = onto(forces);
            let equation = |i: usize| {
                let row: Vec<Expr> = (0..n).map(|j| mass[j][i]).collect();
                pool.simplify(pool.add(self.dot(&row, &symbols), right[i]))
            };
            let equations: Vec<Expr> = (0..n).map(equation).collect();
            let values = pool.solve_linear(&equations, &ids).ok()?.values;
            Some(pool.simplify_all(&values))
        };
        let transposed = |columns: Vec<Vec<Expr>>| -> Symbolic {
            (0..n).map(|i| columns.iter().map(|column| column[i]).collect()).collect()
        };
        let all = |matrix: &Symbolic| -> Option<Symbolic> {
            let columns = (0..n).map(|j| solved(&times(matrix, j))).collect::<Option<Vec<_>>>()?;
            Some(transposed(columns))
        };
        let by_input = |input: &Input| {
            let forces: Vec<Expr> = match input {
                Input::Parameter(idx) => {
                    let symbol = self.model.parameters[free[*idx].0].symbol;
                    let own = |&e: &Expr| {
                        let followed = crate::forces::with_definitions(self.model, free, e);
                        pool.substitute(pool.diff(followed, symbol), &self.rest)
                    };
                    self.residual.iter().map(own).collect()
                }
                Input::Effort(quantity) => {
                    let q: Vec<SymbolId> =
                        loaded.system().coordinates().iter().map(|c| c.q).collect();
                    let slopes = pool.gradient(quantity.value, &q).into_iter();
                    slopes.map(|slope| pool.neg(pool.substitute(slope, &self.rest))).collect()
                }
            };
            solved(&forces)
        };
        let columns = inputs.iter().map(by_input).collect::<Option<Vec<_>>>()?;
        Some([all(&self.stiffness)?, all(&self.damping)?, transposed(columns)])
    }

    /// The letters of a pose that occur, with their values: coordinates, states, multipliers.
    fn pose(
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

/// Comparison of letters with numbers.
struct Certificate<'a> {
    loaded: &'a Loaded,
    rows: &'a [usize],
    by: &'a [usize],
    kept: &'a [usize],
}

impl Certificate<'_> {
    /// The largest difference at random points around a pose, over the largest entry of A and B.
    fn largest(
        &self,
        [a, b]: [&Symbolic; 2],
        (forces, inputs): (&mut Forces, &[Input]),
        (q, free): (&[f64], &[bksim_model::ParameterId]),
    ) -> Result<f64, AnalysisError> {
        let loaded = self.loaded;
        let (model, system) = (loaded.model(), loaded.system());
        let coordinates = system.coordinates();
        let lambda: Vec<SymbolId> =
            self.rows.iter().map(|&row| system.constraints[row].lambda).collect();
        let arguments: Vec<SymbolId> = std::iter::once(model.time)
            .chain(coordinates.iter().map(|c| c.q))
            .chain(coordinates.iter().map(|c| c.v))
            .chain(lambda)
            .collect();
        let entries: Vec<Expr> = a.iter().flatten().chain(b.iter().flatten()).copied().collect();
        let tape = Tape::compile(&model.pool, &entries, &arguments, &system.parameters(model))?;
        let states = loaded.state_coordinates();
        let mut random = Pcg64::seed_from_u64(1);
        let mut largest = 0.0_f64;
        for _ in 0..N_POINTS {
            let mut aside = |size: f64| size * random.random_range(-1.0..1.0);
            let mut parameters = loaded.parameters.clone();
            for value in parameters.iter_mut().take(model.parameters.len()) {
                *value *= 1.0 + aside(0.3);
            }
            let at_q: Vec<f64> = q.iter().map(|q| q + aside(0.2 * (1.0 + q.abs()))).collect();
            let mut v = vec![0.0; q.len()];
            for &i in &states {
                v[i] = at_q[i];
            }
            let lambda: Vec<f64> = self.rows.iter().map(|_| aside(10.0)).collect();
            let p: Vec<f64> = free.iter().map(|id| parameters[id.0]).collect();
            forces.set_parameters(&parameters);
            let rest = vec![0.0; q.len()];
            let state = At { t: loaded.t, q: &at_q, v: &v, a: &rest, lambda: &lambda, p: &p };
            let at = forces.at(state);
            let mut efforts = Vec::new();
            for input in inputs {
                efforts.push(match input {
                    Input::Parameter(idx) => -at.by_parameter.column(*idx),
                    Input::Effort(quantity) => {
                        let mut scalars = loaded.scalars(std::slice::from_ref(quantity))?;
                        scalars.set_parameters(&parameters);
                        DVector::from_vec(scalars.gradients(loaded.t, &at_q).swap_remove(0))
                    }
                });
            }
            // A point where nothing can be solved says nothing.
            let Some(expected) = self.numbers(&at, &efforts) else { continue };
            let mut found = vec![0.0; entries.len()];
            let numbers = [&[loaded.t][..], &at_q, &v, &lambda].concat();
            tape.evaluate(&mut tape.workspace(&parameters), &numbers, &mut found);
            let size = expected.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            let off = found.iter().zip(&expected).map(|(x, y)| (x - y).abs());
            let off =
                off.fold(0.0, |most: f64, x| if x.is_nan() { f64::INFINITY } else { most.max(x) });
            largest = largest.max(off / size.max(1.0));
        }
        Ok(largest)
    }

    /// A and B row by row, by singular values.
    fn numbers(&self, at: &ForcesAt, efforts: &[DVector<f64>]) -> Option<Vec<f64>> {
        let n = self.by.len();
        let free = null_space(&at.jacobian);
        if free.ncols() != n {
            return None;
        }
        let z = &free * free.select_rows(self.by).try_inverse()?;
        let inverse = (z.transpose() * &at.mass * &z).try_inverse()?;
        let solved = |forces: &DMatrix<f64>| &inverse * z.transpose() * forces;
        let [stiffness, damping] =
            [&at.stiffness, &at.damping].map(|matrix| -solved(&(matrix * &z)));
        let by_input = if efforts.is_empty() {
            DMatrix::zeros(n, 0)
        } else {
            solved(&DMatrix::from_columns(efforts))
        };
        let mut a = DMatrix::zeros(2 * n, 2 * n);
        a.view_mut((0, n), (n, n)).fill_with_identity();
        a.view_mut((n, 0), (n, n)).copy_from(&stiffness);
        a.view_mut((n, n), (n, n)).copy_from(&damping);
        let a = a.select_rows(self.kept).select_columns(self.kept);
        let mut b = DMatrix::zeros(2 * n, efforts.len());
        b.view_mut((n, 0), (n, efforts.len())).copy_from(&by_input);
        let b = b.select_rows(self.kept);
        let rows = |matrix: &DMatrix<f64>| matrix.transpose().iter().copied().collect::<Vec<f64>>();
        Some([rows(&a), rows(&b)].concat())
    }
}
