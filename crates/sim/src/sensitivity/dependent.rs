//! Changes of dependent coordinates, which follow from those of independent ones by the constraints.
//!
//! ```text
//! G ∂q + g_p = 0,    G ∂v + ġ_q ∂q + ġ_p = 0         ġ = G v + ∂g/∂t
//! ∂q_D = X ∂q_I + ξ,    ∂v_D = X ∂v_I + Y ∂q_I + η
//! X = −G_D⁻¹ G_I,  ξ = −G_D⁻¹ g_p,  Y = −G_D⁻¹ (ġ_qI + ġ_qD X),  η = −G_D⁻¹ (ġ_p + ġ_qD ξ)
//! ```
//!
//! So the linear equations of a closed loop have as many unknowns as it has freedoms. Source: R. A. Wehage and E. J. Haug,
//! *Generalized coordinate partitioning for dimension reduction in analysis of constrained dynamic systems*, J. Mech. Des.
//! 104 (1982).

use bksim_dae::{LinearCoefficients, eliminate};
use bksim_expr::{Expr, SymbolId, TapeError};

use super::direction::Direction;
use crate::function::Function;
use bksim_mbs::levels::constraint_velocity;

/// G, ġ_q, g_p and ġ_p as functions of (t, q, v).
#[derive(Clone, Debug)]
pub(super) struct ConstraintChanges {
    pub(super) function: Function,
    /// Row and coordinate of the entries of G, then of ġ_q.
    cells: [Vec<(usize, usize)>; 2],
    /// Coordinates, constraints and directions.
    size: [usize; 3],
}

impl ConstraintChanges {
    /// Derives and compiles them.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(super) fn new(
        direction: &Direction<'_>,
        directions: &[Vec<Expr>],
    ) -> Result<Self, TapeError> {
        let Direction { model, system, own, q, v, .. } = direction;
        let (pool, nc) = (&model.pool, system.constraints.len());
        let positions: Vec<Expr> = system.constraints.iter().map(|c| c.expression).collect();
        let rates: Vec<Expr> = (0..nc).map(|row| constraint_velocity(pool, system, row)).collect();
        let entries = |rows: &[Expr], by: &[SymbolId]| pool.jacobian(rows, by).entries;
        let parts = [entries(&positions, q), entries(&rates, q)];
        let mut outputs: Vec<Expr> = parts.iter().flatten().map(|&(_, _, entry)| entry).collect();

        // g_p and ġ_p, one direction after the other.
        let rows = [positions, rates].concat();
        outputs.extend(directions.iter().flat_map(|by| pool.jvp(&rows, own, by)));
        let cells = parts.map(|part| part.into_iter().map(|(row, i, _)| (row, i)).collect());
        let function = direction.compile(&outputs, &[q, v])?;
        Ok(Self { function, cells, size: [q.len(), nc, directions.len()] })
    }

    /// Of none: for equations that are not reduced.
    ///
    /// # Errors
    /// As [`ConstraintChanges::new`].
    pub(super) fn none(direction: &Direction<'_>) -> Result<Self, TapeError> {
        let function = direction.compile(&[], &[&direction.q, &direction.v])?;
        Ok(Self { function, cells: [Vec::new(), Vec::new()], size: [0; 3] })
    }

    /// Number of directions.
    pub(super) fn n_directions(&self) -> usize {
        self.size[2]
    }
}

/// Coordinates that follow from the others by some constraint rows.
#[derive(Clone, Debug)]
pub(super) struct Partition {
    pub(super) independent: Vec<usize>,
    dependent: Vec<usize>,
    rows: Vec<usize>,
}

/// X, Y, ξ and η at one instant, by rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Dependents {
    x: Vec<f64>,
    y: Vec<f64>,
    xi: Vec<f64>,
    eta: Vec<f64>,
}

impl Partition {
    /// The partition with the largest pivots of G, by elimination of these rows; `None` where they depend on each other,
    /// or there are none.
    pub(super) fn choose(
        changes: &ConstraintChanges,
        values: &[f64],
        rows: &[usize],
    ) -> Option<Self> {
        /// Part of the first pivot below which rows depend on each other, or almost.
        const LEAST: f64 = 1e-4;
        let [nq, ..] = changes.size;
        let mut matrix: Vec<Vec<f64>> = rows.iter().map(|_| vec![0.0; nq]).collect();
        for (&(row, i), value) in changes.cells[0].iter().zip(values) {
            if let Some(own) = rows.iter().position(|&of| of == row) {
                matrix[own][i] += value;
            }
        }
        let (mut dependent, mut first) = (Vec::new(), 0.0);
        for k in 0..rows.len() {
            let places = (k..rows.len()).flat_map(|row| (0..nq).map(move |i| (row, i)));
            let size = |&(row, i): &(usize, usize)| matrix[row][i].abs();
            let (row, i) = places.max_by(|a, b| size(a).total_cmp(&size(b)))?;
            let pivot = matrix[row][i];
            first = f64::max(first, pivot.abs());
            if pivot.is_nan() || pivot.abs() <= LEAST * first {
                return None;
            }
            matrix.swap(k, row);
            let (above, below) = matrix.split_at_mut(k + 1);
            for other in below {
                let factor = other[i] / pivot;
                other.iter_mut().zip(&above[k]).for_each(|(x, y)| *x -= factor * y);
                other[i] = 0.0;
            }
            dependent.push(i);
        }
        let independent = (0..nq).filter(|i| !dependent.contains(i)).collect();
        (!dependent.is_empty()).then(|| Self { independent, dependent, rows: rows.to_vec() })
    }

    /// Writes X, Y, ξ and η; false where dependent coordinates change far more than independent ones, or have no value.
    pub(super) fn dependents_into(
        &self,
        changes: &ConstraintChanges,
        values: &[f64],
        out: &mut Dependents,
    ) -> bool {
        /// The largest entry of X.
        const LARGEST: f64 = 30.0;
        let [nq, nc, m] = changes.size;
        let (ni, nd) = (self.independent.len(), self.dependent.len());
        let [of_g, of_rate] = &changes.cells;
        let (g, rest) = values.split_at(of_g.len());
        let (rate, columns) = rest.split_at(of_rate.len());
        let dense = |cells: &[(usize, usize)], values: &[f64]| {
            let mut all = vec![0.0; nc * nq];
            cells.iter().zip(values).for_each(|(&(row, i), value)| all[row * nq + i] += value);
            all
        };
        let (g, rate) = (dense(of_g, g), dense(of_rate, rate));

        // G_D⁻¹.
        let mut inverse = vec![0.0; nd * 2 * nd];
        for (k, (&row, line)) in self.rows.iter().zip(inverse.chunks_exact_mut(2 * nd)).enumerate()
        {
            let own = line.iter_mut().zip(&self.dependent);
            own.for_each(|(x, &i)| *x = g[row * nq + i]);
            line[nd + k] = 1.0;
        }
        if !eliminate(&mut inverse, nd, 2 * nd) {
            return false;
        }
        // −G_D⁻¹ times a matrix whose entries a function tells.
        let solve = |width: usize, of: &dyn Fn(usize, usize) -> f64, out: &mut Vec<f64>| {
            out.clear();
            out.resize(nd * width, 0.0);
            for (k, &row) in self.rows.iter().enumerate() {
                for column in 0..width {
                    let value = of(row, column);
                    if value != 0.0 {
                        for (d, line) in inverse.chunks_exact(2 * nd).enumerate() {
                            out[d * width + column] -= line[nd + k] * value;
                        }
                    }
                }
            }
        };
        let Dependents { x, y, xi, eta } = out;
        solve(ni, &|row, k| g[row * nq + self.independent[k]], x);
        solve(m, &|row, k| columns[k * 2 * nc + row], xi);
        let turned = |row: usize, all: &[f64], width: usize, k: usize| -> f64 {
            let along = self.dependent.iter().enumerate();
            along.map(|(d, &i)| rate[row * nq + i] * all[d * width + k]).sum()
        };
        solve(ni, &|row, k| rate[row * nq + self.independent[k]] + turned(row, x, ni, k), y);
        solve(m, &|row, k| columns[k * 2 * nc + nc + row] + turned(row, xi, m, k), eta);
        x.iter().all(|entry| entry.abs() <= LARGEST)
    }

    /// Writes K, C and B of the independent coordinates alone, for m directions.
    pub(super) fn reduce(
        &self,
        full: &LinearCoefficients,
        dependents: &Dependents,
        out: &mut LinearCoefficients,
    ) {
        let (ni, nd) = (self.independent.len(), self.dependent.len());
        let nq = ni + nd;
        let m = full.forcing.len() / nq.max(1);
        let Dependents { x, y, xi, eta } = dependents;
        for (k, &row) in self.independent.iter().enumerate() {
            let by_position = &full.by_position[row * nq..][..nq];
            let by_velocity = &full.by_velocity[row * nq..][..nq];
            let out_position = &mut out.by_position[k * ni..][..ni];
            let out_velocity = &mut out.by_velocity[k * ni..][..ni];
            let forcing = &mut out.forcing[k * m..][..m];
            for (j, &i) in self.independent.iter().enumerate() {
                (out_position[j], out_velocity[j]) = (by_position[i], by_velocity[i]);
            }
            forcing.copy_from_slice(&full.forcing[row * m..][..m]);
            for (d, &i) in self.dependent.iter().enumerate() {
                let (of_q, of_v) = (by_position[i], by_velocity[i]);
                add(out_position, of_q, &x[d * ni..][..ni]);
                add(out_position, of_v, &y[d * ni..][..ni]);
                add(out_velocity, of_v, &x[d * ni..][..ni]);
                add(forcing, of_q, &xi[d * m..][..m]);
                add(forcing, of_v, &eta[d * m..][..m]);
            }
        }
    }

    /// Rows of the independent coordinates alone, of m columns.
    pub(super) fn independent_rows(&self, all: &[f64], m: usize) -> Vec<f64> {
        self.independent.iter().flat_map(|&i| &all[i * m..][..m]).copied().collect()
    }

    /// Writes the changes of all coordinates, of m columns, from those of the independent ones.
    pub(super) fn complete(
        &self,
        dependents: &Dependents,
        (q_i, v_i): (&[f64], &[f64]),
        (q, v): (&mut [f64], &mut [f64]),
        m: usize,
    ) {
        let ni = self.independent.len();
        let Dependents { x, y, xi, eta } = dependents;
        for (k, &i) in self.independent.iter().enumerate() {
            q[i * m..][..m].copy_from_slice(&q_i[k * m..][..m]);
            v[i * m..][..m].copy_from_slice(&v_i[k * m..][..m]);
        }
        for (d, &i) in self.dependent.iter().enumerate() {
            let (q, v) = (&mut q[i * m..][..m], &mut v[i * m..][..m]);
            q.copy_from_slice(&xi[d * m..][..m]);
            v.copy_from_slice(&eta[d * m..][..m]);
            for k in 0..ni {
                add(q, x[d * ni + k], &q_i[k * m..][..m]);
                add(v, x[d * ni + k], &v_i[k * m..][..m]);
                add(v, y[d * ni + k], &q_i[k * m..][..m]);
            }
        }
    }

    /// True where dependent coordinates follow from these rows.
    pub(super) fn is_by(&self, rows: &[usize]) -> bool {
        self.rows == rows
    }
}

fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}

#[cfg(test)]
mod tests {
    use super::super::{Sensitive, parameter_direction};
    use super::*;
    use crate::mechanism::Mechanism;

    const MODEL: &str = include_str!("../../../../examples/slider-crank/model.toml");
    /// Directions: by two parameters.
    const M: usize = 2;

    /// Numbers between −1 and 1, of no pattern.
    fn numbers(seed: f64, n: usize) -> Vec<f64> {
        (0..n).map(|k| (seed + 1.7 * k as f64).sin()).collect()
    }

    /// Changes of the constraints at some state off all symmetries, with G and ġ_q, nc × nq by rows.
    fn slider_crank() -> (ConstraintChanges, Vec<f64>, [Vec<f64>; 2]) {
        let mechanism = Mechanism::from_toml(MODEL, "slider-crank").expect("a model");
        let Mechanism { model, system, parameters, .. } = &mechanism;
        let direction = Direction::new(model, system.integrated());
        let find = |name: &str| model.parameters.iter().position(|p| p.name == name);
        let by = ["l1", "m3"].map(|name| Sensitive::Parameter(find(name).expect("it is there")));
        let directions = by.map(|by| parameter_direction(model, by));
        let changes = ConstraintChanges::new(&direction, &directions);
        let changes = changes.expect("it compiles");
        let [nq, nc, _] = changes.size;
        let mut buffers = changes.function.buffers(&parameters[..]);
        let arguments = [&[0.3][..], &numbers(0.4, nq), &numbers(2.0, nq)];
        let values = changes.function.evaluate(&mut buffers, &arguments).to_vec();
        let mut first = 0;
        let dense = changes.cells.each_ref().map(|cells| {
            let mut all = vec![0.0; nc * nq];
            for (k, &(row, i)) in cells.iter().enumerate() {
                all[row * nq + i] += values[first + k];
            }
            first += cells.len();
            all
        });
        (changes, values, dense)
    }

    fn partitioned() -> (ConstraintChanges, Vec<f64>, [Vec<f64>; 2], Partition, Dependents) {
        let (changes, values, dense) = slider_crank();
        let rows: Vec<usize> = (0..changes.size[1]).collect();
        let partition = Partition::choose(&changes, &values, &rows).expect("a partition");
        let mut dependents = Dependents::default();
        assert!(partition.dependents_into(&changes, &values, &mut dependents));
        (changes, values, dense, partition, dependents)
    }

    #[test]
    fn completed_changes_satisfy_the_constraints() {
        let (changes, values, [g, turning], partition, dependents) = partitioned();
        let [nq, nc, _] = changes.size;
        let ni = partition.independent.len();
        assert!(ni > 0 && ni + nc == nq, "{ni} freedoms");
        let (q_i, v_i) = (numbers(1.0, ni * M), numbers(3.0, ni * M));
        let (mut q, mut v) = (vec![0.0; nq * M], vec![0.0; nq * M]);
        partition.complete(&dependents, (&q_i, &v_i), (&mut q, &mut v), M);
        let columns = &values[values.len() - M * 2 * nc..];
        for row in 0..nc {
            for k in 0..M {
                let along = |matrix: &[f64], by: &[f64]| -> f64 {
                    (0..nq).map(|i| matrix[row * nq + i] * by[i * M + k]).sum()
                };
                let of_g = along(&g, &q) + columns[k * 2 * nc + row];
                let of_rate = along(&g, &v) + along(&turning, &q) + columns[k * 2 * nc + nc + row];
                assert!(of_g.abs() < 1e-12 && of_rate.abs() < 1e-12, "{of_g:e} {of_rate:e}");
            }
        }
        assert!(columns.iter().any(|by| by.abs() > 0.1), "a parameter moves the constraints");
    }

    #[test]
    fn reduced_equations_are_rows_of_all() {
        let (changes, _, _, partition, dependents) = partitioned();
        let ([nq, ..], ni) = (changes.size, partition.independent.len());
        let full = LinearCoefficients {
            by_position: numbers(0.1, nq * nq),
            by_velocity: numbers(0.2, nq * nq),
            forcing: numbers(0.3, nq * M),
        };
        let mut reduced = LinearCoefficients::zeros(ni, M);
        partition.reduce(&full, &dependents, &mut reduced);
        let (q_i, v_i) = (numbers(1.0, ni * M), numbers(3.0, ni * M));
        let (mut q, mut v) = (vec![0.0; nq * M], vec![0.0; nq * M]);
        partition.complete(&dependents, (&q_i, &v_i), (&mut q, &mut v), M);
        let (mut all, mut own) = (vec![0.0; nq * M], vec![0.0; ni * M]);
        full.apply((&q, &v), &mut all);
        reduced.apply((&q_i, &v_i), &mut own);
        for (own, all) in own.iter().zip(partition.independent_rows(&all, M)) {
            assert!((own - all).abs() < 1e-12 * (1.0 + all.abs()), "{own} and {all}");
        }
    }
}
