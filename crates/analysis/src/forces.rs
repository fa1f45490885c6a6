//! [`Forces`]: the equations of motion with all their slopes at one state.
//!
//! ```text
//! r = M a + h + ∂V/∂q − Q + Gᵀ λ = 0     nq rows
//! g = 0                                  nc rows, those that hold
//! K = ∂r/∂q    C = ∂r/∂v    M = ∂r/∂a
//! ```
//!
//! K has the term ∂(Gᵀ λ)/∂q: constraint forces turn as the mechanism moves.

use std::collections::HashSet;

use bksim_expr::{Expr, Pool, Runner, SparseJacobian, SymbolId, Tape, TapeError, Workspace};
use bksim_mbs::coordinate::Coordinate;
use bksim_mbs::levels::{constraint_acceleration, constraint_velocity};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::message::short;
use bksim_model::{Model, ParameterId};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::error::AnalysisError;

/// The equations of motion as functions of numbers, some parameters among their arguments.
#[derive(Clone, Debug)]
pub(crate) struct Forces {
    runner: Runner,
    space: Workspace,
    outputs: Vec<f64>,
    /// Shapes and entries of the matrices, in the order of the outputs.
    matrices: Vec<Shape>,
    n: usize,
    /// Constraint rows that hold.
    kept: Vec<usize>,
}

#[derive(Clone, Debug)]
struct Shape {
    n_rows: usize,
    n_columns: usize,
    entries: Vec<(usize, usize)>,
}

/// A state of the equations of motion, SI; λ of the rows that hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At<'a> {
    pub(crate) t: f64,
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) a: &'a [f64],
    pub(crate) lambda: &'a [f64],
    /// Values of the parameters that are arguments.
    pub(crate) p: &'a [f64],
}

/// The equations at a state, SI.
#[derive(Clone, Debug)]
pub(crate) struct ForcesAt {
    /// r, nq.
    pub(crate) residual: DVector<f64>,
    /// g, nc.
    pub(crate) closure: DVector<f64>,
    /// G v + ∂g/∂t, nc.
    pub(crate) rate: DVector<f64>,
    /// G, nc × nq.
    pub(crate) jacobian: DMatrix<f64>,
    /// M, nq × nq.
    pub(crate) mass: DMatrix<f64>,
    /// K, nq × nq.
    pub(crate) stiffness: DMatrix<f64>,
    /// C, nq × nq.
    pub(crate) damping: DMatrix<f64>,
    /// ∂r/∂p, nq × np.
    pub(crate) by_parameter: DMatrix<f64>,
    /// ∂g/∂p, nc × np.
    pub(crate) closure_by_parameter: DMatrix<f64>,
    /// ∂(G v + ∂g/∂t)/∂q, nc × nq.
    pub(crate) velocity_by_position: DMatrix<f64>,
    /// ∂(G a + γ)/∂q, nc × nq.
    pub(crate) acceleration_by_position: DMatrix<f64>,
    /// ∂(G a + γ)/∂v, nc × nq.
    pub(crate) acceleration_by_velocity: DMatrix<f64>,
    /// G by the wrenches of the rows, nc × nq: of wheels and of efforts in cut screws it differs from ∂g/∂q by rows of cut
    /// joints, and with it the multipliers of these are their reactions.
    pub(crate) wrenches: DMatrix<f64>,
    /// ∂r/∂λ without Gᵀ, nq × nc: of friction by the reactions of its own joint.
    pub(crate) pressing: DMatrix<f64>,
}

impl Forces {
    /// The equations of `system` with the constraint rows `kept`; `free` parameters are arguments, and what the
    /// model defines by them follows them.
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        kept: &[usize],
        free: &[ParameterId],
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        let pool = &model.pool;
        let coordinates = system.coordinates();
        let n = coordinates.len();
        let [q, v, a]: [Vec<SymbolId>; 3] = [
            coordinates.iter().map(|c| c.q).collect(),
            coordinates.iter().map(|c| c.v).collect(),
            coordinates.iter().map(|c| c.a).collect(),
        ];
        let lambda: Vec<SymbolId> =
            kept.iter().map(|&row| system.constraints[row].lambda).collect();
        let follow = |e: Expr| with_definitions(model, free, e);
        let residual: Vec<Expr> = residuals(model, system, kept).into_iter().map(follow).collect();
        let closure: Vec<Expr> =
            kept.iter().map(|&row| follow(system.constraints[row].expression)).collect();
        let velocity: Vec<Expr> =
            kept.iter().map(|&row| follow(constraint_velocity(pool, system, row))).collect();
        let accelerations: Vec<Expr> =
            kept.iter().map(|&row| follow(constraint_acceleration(model, system, row))).collect();
        let p: Vec<SymbolId> = free.iter().map(|id| model.parameters[id.0].symbol).collect();
        let pressed: Vec<Expr> =
            system.applied_force.iter().map(|&force| follow(pool.neg(force))).collect();

        // All matrices in the order of `ForcesAt`.
        let all = [
            pool.jacobian(&closure, &q),
            pool.jacobian(&residual, &a),
            pool.jacobian(&residual, &q),
            pool.jacobian(&residual, &v),
            pool.jacobian(&residual, &p),
            pool.jacobian(&closure, &p),
            pool.jacobian(&velocity, &q),
            pool.jacobian(&accelerations, &q),
            pool.jacobian(&accelerations, &v),
            wrench_rows(system, kept, &follow),
            pool.jacobian(&pressed, &lambda),
        ];
        let mut outputs = [residual, closure, velocity].concat();
        let shape = |jacobian: &SparseJacobian| Shape {
            n_rows: jacobian.n_rows,
            n_columns: jacobian.n_columns,
            entries: jacobian.entries.iter().map(|&(row, column, _)| (row, column)).collect(),
        };
        let matrices = all.iter().map(shape).collect();
        outputs
            .extend(all.iter().flat_map(|jacobian| jacobian.entries.iter().map(|entry| entry.2)));
        let arguments = [vec![model.time], q, v, a, lambda, p].concat();
        let symbols = vacated(pool, system.parameters(model), free);
        let tape = Tape::compile(pool, &outputs, &arguments, &symbols)?;
        Ok(Self {
            space: tape.workspace(parameters),
            outputs: vec![0.0; tape.n_outputs()],
            runner: Runner::new(tape, model.solve.jit),
            matrices,
            n,
            kept: kept.to_vec(),
        })
    }

    /// Gives the parameters that are no arguments other values.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) {
        self.space = self.runner.tape().workspace(parameters);
    }

    /// Number of coordinates.
    pub(crate) fn n(&self) -> usize {
        self.n
    }

    /// Number of rows that hold.
    pub(crate) fn nc(&self) -> usize {
        self.kept.len()
    }

    /// Multipliers of all rows from those of the rows that hold.
    pub(crate) fn all_multipliers(&self, n_rows: usize, lambda: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; n_rows];
        self.kept.iter().zip(lambda).for_each(|(&row, &value)| all[row] = value);
        all
    }

    /// The equations at a state.
    pub(crate) fn at(&mut self, At { t, q, v, a, lambda, p }: At<'_>) -> ForcesAt {
        let inputs = [&[t], q, v, a, lambda, p].concat();
        self.runner.evaluate(&mut self.space, &inputs, &mut self.outputs);
        let (values, mut rest) = self.outputs.split_at(self.n + 2 * self.kept.len());
        let (closure, rate) = values[self.n..].split_at(self.kept.len());
        let mut matrices = self.matrices.iter().map(|shape| {
            let (own, others) = rest.split_at(shape.entries.len());
            rest = others;
            let mut matrix = DMatrix::zeros(shape.n_rows, shape.n_columns);
            shape.entries.iter().zip(own).for_each(|(&at, &value)| matrix[at] = value);
            matrix
        });
        let mut next = || matrices.next().unwrap_or_default();
        ForcesAt {
            residual: DVector::from_column_slice(&values[..self.n]),
            closure: DVector::from_column_slice(closure),
            rate: DVector::from_column_slice(rate),
            jacobian: next(),
            mass: next(),
            stiffness: next(),
            damping: next(),
            by_parameter: next(),
            closure_by_parameter: next(),
            velocity_by_position: next(),
            acceleration_by_position: next(),
            acceleration_by_velocity: next(),
            wrenches: next(),
            pressing: next(),
        }
    }

    /// The multipliers that balance r without accelerations as well as any do; of those the smallest.
    pub(crate) fn balancing(&mut self, t: f64, [q, v]: [&[f64]; 2], p: &[f64]) -> Option<Vec<f64>> {
        let rest = vec![0.0; self.n];
        let nothing = vec![0.0; self.kept.len()];
        let at = self.at(At { t, q, v, a: &rest, lambda: &nothing, p });
        if self.kept.is_empty() {
            return Some(nothing);
        }
        let transposed = at.jacobian.transpose();
        let tolerance = crate::rows::RANK_TOLERANCE * transposed.norm();
        let lambda = Svd::new(&transposed)?.solve(&-at.residual, tolerance);
        Some(lambda.as_slice().to_vec())
    }
}

/// The rows `kept` of G as the equations of motion have them.
fn wrench_rows(
    system: &SymbolicSystem,
    kept: &[usize],
    follow: &dyn Fn(Expr) -> Expr,
) -> SparseJacobian {
    let rows = kept.iter().enumerate();
    let entries = rows.flat_map(|(k, &row)| {
        system.constraint_jacobian.row(row).iter().map(move |&(i, g)| (k, i, follow(g)))
    });
    SparseJacobian {
        n_rows: kept.len(),
        n_columns: system.coordinates().len(),
        entries: entries.collect(),
    }
}

/// r with the constraint rows `kept`, as expressions.
pub(crate) fn residuals(model: &Model, system: &SymbolicSystem, kept: &[usize]) -> Vec<Expr> {
    let pool = &model.pool;
    let coordinates = system.coordinates();
    let columns = system.constraint_jacobian.transposed();
    let residual = (0..coordinates.len()).map(|i| {
        let acceleration = |j: usize| pool.symbol_expr(coordinates[j].a);
        let inertia = system.mass_matrix.row(i).iter().map(|&(j, m)| pool.mul(m, acceleration(j)));
        let held = columns.row(i).iter().filter(|(row, _)| kept.contains(row));
        let held =
            held.map(|&(row, g)| pool.mul(g, pool.symbol_expr(system.constraints[row].lambda)));
        let applied = pool.neg(system.applied_force[i]);
        let rest = [system.bias[i], system.potential_gradient[i], applied];
        pool.sum(inertia.chain(held).chain(rest).collect::<Vec<_>>())
    });
    residual.collect()
}

impl ForcesAt {
    /// Refuses forces that are no numbers, as of a load with a pole, at an instant.
    pub(crate) fn check_forces(
        &self,
        coordinates: &[Coordinate],
        t: f64,
    ) -> Result<(), AnalysisError> {
        let bad = self.residual.iter().position(|force| !force.is_finite());
        bad.map_or(Ok(()), |i| {
            let name = format!("force along {}", coordinates[i].name);
            let place = format!("at t = {} s", short(t));
            Err(AnalysisError::NoNumber { name, place, value: self.residual[i] })
        })
    }

    /// Refuses forces, or slopes of them, that are no numbers in a position.
    pub(crate) fn check_slopes(
        &self,
        coordinates: &[Coordinate],
        q: &[f64],
    ) -> Result<(), AnalysisError> {
        for (i, of) in coordinates.iter().enumerate() {
            let slopes = self.stiffness.row(i);
            let own = [self.residual[i]].into_iter().chain(slopes.iter().copied());
            if let Some((k, value)) = own.enumerate().find(|(_, value)| !value.is_finite()) {
                let what = if k == 0 { "force" } else { "slope of the force" };
                let name = format!("{what} along {}", of.name);
                let place = format!("at {} = {} {}", of.name, short(q[i]), of.kind.unit());
                return Err(AnalysisError::NoNumber { name, place, value });
            }
        }
        Ok(())
    }

    /// Forces with the `states`, which are velocities of their coordinates, in the place of positions.
    pub(crate) fn with_states_as_positions(mut self, states: &[usize]) -> Self {
        for &i in states {
            self.stiffness.set_column(i, &self.damping.column(i));
            self.damping.set_column(i, &self.mass.column(i));
            self.mass.column_mut(i).fill(0.0);
        }
        self
    }
}

/// An expression in which parameters that the model defines by `free` ones stand as their definitions.
pub(crate) fn with_definitions(model: &Model, free: &[ParameterId], e: Expr) -> Expr {
    if free.is_empty() {
        return e;
    }
    let pool = &model.pool;
    let own: HashSet<SymbolId> = free.iter().map(|id| model.parameters[id.0].symbol).collect();
    let mut map: Vec<(SymbolId, Expr)> = Vec::new();
    // Each comes after those that its definition uses.
    for parameter in model.parameters.iter().filter(|p| !own.contains(&p.symbol)) {
        let definition = pool.substitute(parameter.definition, &map);
        if own.iter().any(|&symbol| pool.depends_on(definition, symbol)) {
            map.push((parameter.symbol, definition));
        }
    }
    pool.substitute(e, &map)
}

/// Symbols of parameters, with symbols that occur nowhere in place of those that are arguments.
pub(crate) fn vacated(
    pool: &Pool,
    mut symbols: Vec<SymbolId>,
    free: &[ParameterId],
) -> Vec<SymbolId> {
    for id in free {
        let vacant = pool.symbol(&format!("'free{}", id.0));
        symbols[id.0] = pool.symbol_id(vacant).unwrap_or(symbols[id.0]);
    }
    symbols
}
