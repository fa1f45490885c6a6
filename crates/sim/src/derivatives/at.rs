//! Functions with their derivatives at states: the numbers, from compiled expressions and from dz, which is solved for.

use nalgebra::DMatrix;

use super::{Derivatives, Needs};
use crate::compiled::CompiledSystem;
use crate::function::Buffers;
use crate::functions::{Functions, IdleFunctions};
use crate::modes::Modes;
use crate::state::{AccelerationRef, StateRef};

/// [`Derivatives`] at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct DerivativesAt<'a> {
    derivatives: &'a Derivatives,
    functions: Functions<'a>,
    own: Own,
}

/// [`DerivativesAt`] between two uses: without what they are of, so that an owner of it keeps them.
#[derive(Clone, Debug)]
pub struct IdleDerivatives {
    functions: IdleFunctions,
    own: Own,
}

/// Buffers besides those of the functions.
#[derive(Clone, Debug)]
struct Own {
    buffers: Buffers,
    /// Modes that the buffers are for.
    modes: Modes,
    results: Vec<f64>,
    a: Vec<f64>,
    lambda: Vec<f64>,
}

impl Derivatives {
    /// These derivatives at the parameters of `functions`, with buffers.
    pub fn with<'a>(&'a self, functions: Functions<'a>) -> DerivativesAt<'a> {
        let (nq, nc) = (functions.compiled().nq(), functions.compiled().nc());
        let own = Own {
            buffers: self.function.buffers(functions.parameters_with_modes()),
            modes: functions.modes().clone(),
            results: vec![0.0; self.function.n_outputs()],
            a: vec![0.0; nq],
            lambda: vec![0.0; nc],
        };
        DerivativesAt { derivatives: self, functions, own }
    }
}

impl IdleDerivatives {
    /// The derivatives again.
    ///
    /// # Panics
    /// Calls panic if `derivatives` or `compiled` are others than they were of.
    pub fn resume<'a>(
        self,
        derivatives: &'a Derivatives,
        compiled: &'a CompiledSystem,
    ) -> DerivativesAt<'a> {
        let Self { functions, own } = self;
        DerivativesAt { derivatives, functions: functions.resume(compiled), own }
    }
}

impl DerivativesAt<'_> {
    /// The derivatives until they are used again: nothing is made again.
    pub fn pause(self) -> IdleDerivatives {
        IdleDerivatives { functions: self.functions.pause(), own: self.own }
    }

    /// Writes h and its derivatives, row by row, at a state; `given` are the accelerations and multipliers of a
    /// residual. Where there is no value, all are NaN.
    ///
    /// # Panics
    /// If a length is not that of the mechanism or of the derivatives.
    pub fn at(
        &mut self,
        state: StateRef<'_>,
        given: Option<AccelerationRef<'_>>,
        values: &mut [f64],
        derivatives: &mut [f64],
    ) {
        let StateRef { t, q, v } = state;
        let Self { derivatives: of, functions, own } = self;
        // Accelerations and multipliers, on the branches of the state.
        let solved = match (of.needs, given) {
            (Needs::Solved, _) => {
                functions.accelerations_into(state, &mut own.a, &mut own.lambda).is_ok()
            }
            (_, Some(AccelerationRef { a, lambda })) => {
                own.a.copy_from_slice(a);
                own.lambda.copy_from_slice(lambda);
                functions.follow(t, q, v);
                true
            }
            (needs, None) => {
                functions.follow(t, q, v);
                needs == Needs::Nothing
            }
        };
        if !solved {
            values.fill(f64::NAN);
            derivatives.fill(f64::NAN);
            return;
        }
        let function = &of.function;
        if own.modes != *functions.modes() {
            own.buffers = function.buffers(functions.parameters_with_modes());
            own.modes.clone_from(functions.modes());
        }
        let u = functions.inputs(t, q, v);
        let arguments = [&[t], q, v, own.a.as_slice(), &own.lambda, u];
        function.evaluate_into(&mut own.buffers, &arguments, &mut own.results);

        // h and h_x as they are; h_z dz added.
        let (found, entries) = own.results.split_at(of.n_rows);
        values.copy_from_slice(found);
        derivatives.fill(0.0);
        let n = of.n_columns;
        let [h_x, h_z, ..] = &of.blocks;
        let (direct, implicit) = entries.split_at(h_x.len());
        for (&(row, column), entry) in h_x.iter().zip(direct) {
            derivatives[row * n + column] += entry;
        }
        if h_z.is_empty() || n == 0 {
            return;
        }
        let Some(dz) = of.dz(&implicit[h_z.len()..]) else {
            derivatives.fill(f64::NAN);
            return;
        };
        for (&(row, k), entry) in h_z.iter().zip(implicit) {
            let out = &mut derivatives[row * n..][..n];
            out.iter_mut().enumerate().for_each(|(column, out)| *out += entry * dz[(k, column)]);
        }
    }
}

impl Derivatives {
    /// dz/dx, all of z by all columns, from the entries of F_x and F_z; none in a singular pose.
    fn dz(&self, entries: &[f64]) -> Option<DMatrix<f64>> {
        let [_, _, f_x, f_z] = &self.blocks;
        let n_z = self.kept.last().map_or(0, |last| last + 1);
        let mut position = vec![usize::MAX; n_z];
        self.kept.iter().enumerate().for_each(|(k, &of)| position[of] = k);
        let place = |of: usize| position.get(of).copied().filter(|&k| k != usize::MAX);
        let n = self.kept.len();
        let mut right = DMatrix::zeros(n, self.n_columns);
        let mut matrix = DMatrix::zeros(n, n);
        let (of_x, of_z) = entries.split_at(f_x.len());
        for (&(row, column), entry) in f_x.iter().zip(of_x) {
            if let Some(row) = place(row) {
                right[(row, column)] = -entry;
            }
        }
        for (&(row, column), entry) in f_z.iter().zip(of_z) {
            if let Some((row, column)) = place(row).zip(place(column)) {
                matrix[(row, column)] = *entry;
            }
        }
        let solved = matrix.lu().solve(&right)?;
        // Multipliers that others stand for do not change.
        let n_all = n_z.max(f_z.iter().map(|&(_, column)| column + 1).max().unwrap_or(0));
        let of = |k: usize, column: usize| place(k).map_or(0.0, |row| solved[(row, column)]);
        Some(DMatrix::from_fn(n_all, self.n_columns, of))
    }
}
