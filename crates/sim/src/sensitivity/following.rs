//! The equations of the changes along a motion that is known, as linear equations of second order.
//!
//! ```text
//! F(t, q, v, z) = 0            M a + Gᵀ λ − f and G a + γ, with z = (a, λ)
//! F_z dz = −(F_q dq + F_v dv + F_p dp + F_t dt)
//! ```

use std::sync::Arc;

use bksim_dae::{LinearCoefficients, Pattern, System, eliminate};
use bksim_expr::{Expr, TapeError};

use super::dependent::ConstraintChanges;
use super::direction::Direction;
use super::written::{
    CoefficientLanes, Instants, OfInstants, WrittenCoefficients, coefficients, coefficients_into,
};
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::formulate::{MotionEquations, MotionSystem, formulate, load_columns, parameter_columns};
use crate::function::{Buffers, Function};
use crate::modes::indicators::indicator_functions;
use crate::multiplier::MultiplierSystem;
use crate::state::{AccelerationRef, StateRef};
use bksim_model::Formulation;

/// The derivatives that changes along a known motion need, compiled.
#[derive(Clone, Debug)]
pub(super) struct Following {
    /// At the level of accelerations.
    equations: Arc<MotionEquations>,
    /// F_p, then F_t, one column after the other; or loads on the rows of F, one by one.
    columns: Function,
    /// Changes of the constraints along the same.
    pub(super) constraints: ConstraintChanges,
    /// Changes of the functions of [`indicator_functions`].
    pub(super) indicators: Function,
    n_directions: usize,
    written: Arc<WrittenCoefficients>,
}

impl Following {
    /// Derives and compiles them, for these directions of the parameters.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(super) fn new(
        direction: &Direction<'_>,
        directions: &[Vec<Expr>],
    ) -> Result<Self, TapeError> {
        let Direction { model, system, .. } = direction;
        let equations = formulate(model, system, Formulation::Index1)?;
        Self::of(Arc::new(equations), direction, directions)
    }

    /// Equations along other directions.
    ///
    /// # Errors
    /// As [`Following::new`].
    pub(super) fn along(
        &self,
        direction: &Direction<'_>,
        directions: &[Vec<Expr>],
    ) -> Result<Self, TapeError> {
        Self::of(self.equations.clone(), direction, directions)
    }

    /// The changes by loads on the rows of F, each in the place of F_p of one quantity.
    ///
    /// # Errors
    /// As [`Following::new`].
    pub(super) fn of_loads(direction: &Direction<'_>) -> Result<Self, TapeError> {
        let Direction { model, system, .. } = direction;
        let equations = formulate(model, system, Formulation::Index1)?;
        let n_directions = system.coordinates().len() + system.constraints.len();
        Ok(Self {
            equations: Arc::new(equations),
            columns: load_columns(model, system)?,
            constraints: ConstraintChanges::none(direction)?,
            indicators: direction.changes(&[])?,
            n_directions,
            written: Arc::new(WrittenCoefficients::new(model.solve.jit)),
        })
    }

    fn of(
        equations: Arc<MotionEquations>,
        direction: &Direction<'_>,
        directions: &[Vec<Expr>],
    ) -> Result<Self, TapeError> {
        let Direction { model, system, own, .. } = direction;
        let pool = &model.pool;
        let wrt = [own.as_slice(), &[model.time]].concat();
        let extended = |by: &[Expr], dt: Expr| [by, &[dt]].concat();
        let mut all: Vec<Vec<Expr>> =
            directions.iter().map(|by| extended(by, pool.zero())).collect();
        all.push(extended(&vec![pool.zero(); own.len()], pool.one()));
        let level = Formulation::Index1;
        Ok(Self {
            equations,
            columns: parameter_columns(model, system, level, &wrt, &all)?,
            constraints: ConstraintChanges::new(direction, directions)?,
            indicators: direction.changes(&indicator_functions(model, system).0)?,
            n_directions: directions.len(),
            written: Arc::new(WrittenCoefficients::new(model.solve.jit)),
        })
    }
}

/// The linear equations of the changes in one phase of a run, at one state after the other.
pub(super) struct Variation<'a> {
    following: &'a Following,
    compiled: &'a CompiledSystem,
    parameters: Vec<f64>,
    /// Of the coefficients that are written down.
    lanes: Option<CoefficientLanes>,
    motion: MotionSystem<'a>,
    columns: Buffers,
    evaluator: Evaluator<'a>,
    multipliers: MultiplierSystem,
    /// Accelerations and multipliers of the state.
    pub(super) a: Vec<f64>,
    pub(super) lambda: Vec<f64>,
    df_dy: Vec<f64>,
    df_dydot: Vec<f64>,
    by_parameters: Vec<f64>,
    /// The entries of ∂F/∂y, and of ∂F/∂y′, with their places in the rows.
    places: [Vec<(usize, usize)>; 2],
    /// F_z, F_q, F_v, F_p and F_t, one row after the other; then −dz in the place of all but F_z.
    rows: Vec<f64>,
    /// Of the instants whose coefficients were written last, one after the other.
    pub(super) of_instants: OfInstants,
    constraints: Buffers,
    /// Rows of the constraints that hold.
    active: Vec<usize>,
}

impl<'a> Variation<'a> {
    /// At parameters that end with the modes, without the inactive rows.
    pub(super) fn new(
        following: &'a Following,
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        inactive: &[usize],
    ) -> Self {
        let motion = following.equations.at(parameters, inactive);
        let (nq, nc) = (compiled.nq(), compiled.nc());
        let n_entries = motion.pattern().n_entries();
        let n_directions = following.n_directions;
        Self {
            columns: following.columns.buffers(parameters),
            evaluator: compiled.evaluator(parameters),
            multipliers: compiled.multiplier_system(inactive),
            a: vec![0.0; nq],
            lambda: vec![0.0; nc],
            df_dy: vec![0.0; n_entries],
            df_dydot: vec![0.0; n_entries],
            by_parameters: vec![0.0; following.columns.n_outputs()],
            places: places(motion.pattern(), (nq, nc), Self::width_of(nq, nc, n_directions)),
            rows: vec![0.0; (nq + nc) * Self::width_of(nq, nc, n_directions)],
            following,
            motion,
            compiled,
            parameters: parameters.to_vec(),
            lanes: None,
            of_instants: OfInstants::default(),
            constraints: following.constraints.function.buffers(parameters),
            active: (0..nc).filter(|row| !inactive.contains(row)).collect(),
        }
    }

    /// Number of accelerations and multipliers.
    pub(super) fn n_unknowns(&self) -> usize {
        self.a.len() + self.lambda.len()
    }

    /// Rows of the constraints that hold.
    pub(super) fn active(&self) -> &[usize] {
        &self.active
    }

    /// The changes of the constraints at a state.
    fn constraints_at(&mut self, StateRef { t, q, v }: StateRef<'_>) -> &[f64] {
        self.following.constraints.function.evaluate(&mut self.constraints, &[&[t], q, v])
    }

    fn width_of(nq: usize, nc: usize, n_directions: usize) -> usize {
        3 * nq + nc + n_directions + 1
    }

    fn width(&self) -> usize {
        Self::width_of(self.a.len(), self.lambda.len(), self.following.n_directions)
    }

    /// Takes the equations at a state; false where they have no unique solution, or no finite values.
    pub(super) fn take(&mut self, StateRef { t, q, v }: StateRef<'_>) -> bool {
        let width = self.width();
        let Self { evaluator, multipliers, motion, a, lambda, df_dy, df_dydot, .. } = self;
        let (nq, nz) = (a.len(), a.len() + lambda.len());
        if multipliers.limit_into(evaluator, t, (q, v), a, lambda).is_err() {
            return false;
        }
        let start = self.following.equations.unknowns(
            StateRef { t, q, v },
            AccelerationRef { a: a.as_slice(), lambda: lambda.as_slice() },
        );
        if motion.jacobian(t, &start.y, &start.ydot, df_dy, df_dydot).is_err() {
            return false;
        }

        let Self { rows, places, columns, by_parameters, following, .. } = self;
        rows.fill(0.0);
        places[0].iter().for_each(|&(entry, place)| rows[place] += df_dy[entry]);
        places[1].iter().for_each(|&(entry, place)| rows[place] += df_dydot[entry]);
        let arguments = [&[t], &start.y[..], &start.ydot];
        following.columns.evaluate_into(columns, &arguments, by_parameters);
        for (k, column) in by_parameters.chunks_exact_mut(start.y.len()).enumerate() {
            motion.held().iter().for_each(|&row| column[row] = 0.0);
            for (i, value) in column[nq..].iter().enumerate() {
                rows[i * width + nz + 2 * nq + k] = *value;
            }
        }
        eliminate(rows, nz, width) && rows.iter().all(|value| value.is_finite())
    }

    /// Writes K, C and B of the equations of the changes at some instants; false as [`Variation::take`].
    pub(super) fn coefficients_at(
        &mut self,
        instants: Instants<'_>,
        out: &mut [LinearCoefficients],
    ) -> bool {
        let n_unknowns = self.n_unknowns();
        let Self { following, compiled, multipliers, lanes, of_instants, .. } = self;
        let Following { equations, columns, constraints, n_directions, written, .. } = following;
        let nc = compiled.nc();
        let constraints = &constraints.function;
        let n_changes = constraints.n_outputs();
        of_instants.unknowns.resize(instants.len() * n_unknowns, 0.0);
        of_instants.constraints.resize(instants.len() * n_changes, 0.0);
        if multipliers.is_whole(nc)
            && let Some(function) = written
                .due(|| coefficients(compiled, equations, (columns, *n_directions), constraints))
        {
            let make = || CoefficientLanes::new(function, &self.parameters);
            let lanes = lanes.get_or_insert_with(make);
            let into = (&mut *out, &mut *of_instants);
            if coefficients_into((function, lanes), (multipliers, nc), instants, into) {
                return true;
            }
        }
        instants.iter().zip(out).enumerate().all(|(k, (state, out))| {
            let is_regular = self.take(state);
            self.coefficients_into(out);
            let z = self.a.iter().chain(&self.lambda);
            let unknowns = self.of_instants.unknowns[k * n_unknowns..].iter_mut();
            unknowns.zip(z).for_each(|(x, z)| *x = *z);
            let mut changes = std::mem::take(&mut self.of_instants.constraints);
            changes[k * n_changes..][..n_changes].copy_from_slice(self.constraints_at(state));
            self.of_instants.constraints = changes;
            is_regular
        })
    }

    /// Writes K, C and B at the state that was taken last.
    fn coefficients_into(&self, out: &mut LinearCoefficients) {
        let (width, nq, nz) = (self.width(), self.a.len(), self.a.len() + self.lambda.len());
        let m = self.following.n_directions;
        for (i, row) in self.rows.chunks_exact(width).take(nq).enumerate() {
            let mut negated = row[nz..].iter().map(|value| -value);
            let LinearCoefficients { by_position, by_velocity, forcing } = out;
            let parts = [(by_position, nq), (by_velocity, nq), (forcing, m)];
            for (part, n) in parts {
                part[i * n..(i + 1) * n]
                    .iter_mut()
                    .zip(&mut negated)
                    .for_each(|(x, value)| *x = value);
            }
        }
    }

    /// Changes of a and λ along ∂q, ∂v, and the quantity of index `k`; time is the one after the last.
    pub(super) fn change_into(&self, k: usize, (dq, dv): (&[f64], &[f64]), dz: &mut [f64]) {
        let (width, nq, nz) = (self.width(), self.a.len(), dz.len());
        for (dz, row) in dz.iter_mut().zip(self.rows.chunks_exact(width)) {
            let by_state = row[nz..nz + 2 * nq].iter().zip(dq.iter().chain(dv));
            *dz = -row[nz + 2 * nq + k] - by_state.map(|(by, change)| by * change).sum::<f64>();
        }
    }

    /// Weights of q, v and of each direction but the last, from weights of a and λ.
    pub(super) fn pull_into(&self, weights: &[f64], out: &mut [f64]) {
        let (width, nz) = (self.width(), self.n_unknowns());
        out.fill(0.0);
        for (weight, row) in weights.iter().zip(self.rows.chunks_exact(width)) {
            out.iter_mut().zip(&row[nz..]).for_each(|(sum, change)| *sum -= weight * change);
        }
    }

    /// Index of time among the directions.
    pub(super) fn time(&self) -> usize {
        self.following.n_directions
    }
}

/// Where the entries of ∂F/∂y and ∂F/∂y′ are in rows of F_z, F_q, F_v. F_q and F_v are columns of ∂F/∂y, F_z of
/// ∂F/∂y′ (accelerations) and ∂F/∂y (multipliers); the first nq rows of F say q′ = v.
fn places(pattern: &Pattern, (nq, nc): (usize, usize), width: usize) -> [Vec<(usize, usize)>; 2] {
    let mut places = [Vec::new(), Vec::new()];
    for (entry, (row, column)) in pattern.entries().enumerate().filter(|(_, (row, _))| *row >= nq) {
        let begin = (row - nq) * width;
        let by_y =
            column.checked_sub(2 * nq).map_or(nq + nc + column, |multiplier| nq + multiplier);
        places[0].push((entry, begin + by_y));
        if (nq..2 * nq).contains(&column) {
            places[1].push((entry, begin + column - nq));
        }
    }
    places
}
