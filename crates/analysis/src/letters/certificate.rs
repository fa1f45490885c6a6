//! [`Certificate`]: matrices in letters next to numbers that come another way.

use bksim_expr::{Expr, SymbolId, Tape};
use bksim_model::ParameterId;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::equations::Symbolic;
use crate::channels::Input;
use crate::error::AnalysisError;
use crate::forces::{At, Forces, ForcesAt};
use crate::linear_outputs::{Changes, OutputSlopes, beside};
use crate::loaded::Loaded;
use crate::reduced::{null_space, pseudo_inverse};
use crate::steady::steady_velocities;

/// Points at which both are compared.
pub(super) const N_POINTS: usize = 20;

/// Comparison of letters with numbers.
pub(super) struct Certificate<'a> {
    pub(super) loaded: &'a Loaded,
    /// Independent rows, and the coordinates that the free motions are by.
    pub(super) rows: &'a [usize],
    pub(super) by: &'a [usize],
    /// Places of the states among (y, ẏ).
    pub(super) kept: &'a [usize],
    pub(super) outputs: &'a OutputSlopes,
}

/// Entries of A and B, then of C and D, by rows.
type Entries = [Vec<f64>; 2];

impl Certificate<'_> {
    /// The largest difference at random points around a pose, over the largest entry of A and B, or of C and D.
    pub(super) fn largest(
        &self,
        matrices: [&Symbolic; 4],
        (forces, inputs): (&mut Forces, &[Input]),
        (q, free): (&[f64], &[ParameterId]),
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
        let n_first = matrices[..2].iter().flat_map(|matrix| matrix.iter().flatten()).count();
        let entries: Vec<Expr> =
            matrices.iter().flat_map(|matrix| matrix.iter().flatten()).copied().collect();
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
            if loaded.turns {
                let (t, q, lambda, p) = (loaded.t, &at_q, &lambda, &p);
                let still = forces.at(At { t, q, v: &rest, a: &rest, lambda, p });
                let steady = steady_velocities(loaded, &still).unwrap_or_default();
                v.iter_mut().zip(&steady).for_each(|(v, steady)| *v += steady);
            }
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
            let Some(expected) = self.numbers((&parameters, inputs), state, &at, &efforts) else {
                continue;
            };
            let mut found = vec![0.0; entries.len()];
            let numbers = [&[loaded.t][..], &at_q, &v, &lambda].concat();
            tape.evaluate(&mut tape.workspace(&parameters), &numbers, &mut found);
            let (first, second) = found.split_at(n_first);
            for (found, expected) in [first, second].into_iter().zip(&expected) {
                let size = expected.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
                let off = found.iter().zip(expected).map(|(x, y)| (x - y).abs());
                let worse =
                    |most: f64, x: f64| if x.is_nan() { f64::INFINITY } else { most.max(x) };
                largest = largest.max(off.fold(0.0, worse) / size.max(1.0));
            }
        }
        Ok(largest)
    }

    /// All matrices row by row, by singular values.
    fn numbers(
        &self,
        (parameters, inputs): (&[f64], &[Input]),
        state: At<'_>,
        at: &ForcesAt,
        efforts: &[DVector<f64>],
    ) -> Option<Entries> {
        let n = self.by.len();
        let free = null_space(&at.jacobian);
        if free.ncols() != n {
            return None;
        }
        let z = &free * free.select_rows(self.by).try_inverse()?;
        let inverse = (z.transpose() * &at.mass * &z).try_inverse()?;
        let n_inputs = efforts.len();
        let by_input = if efforts.is_empty() {
            DMatrix::zeros(z.nrows(), 0)
        } else {
            DMatrix::from_columns(efforts)
        };
        // Forces by y, ẏ and u; the accelerations and multipliers that they make.
        let forces = [-&at.stiffness * &z, -&at.damping * &z, by_input];
        let own = forces.each_ref().map(|forces| &inverse * z.transpose() * forces);
        let back = pseudo_inverse(&at.jacobian.transpose());
        let lambda: Vec<DMatrix<f64>> = (forces.iter().zip(&own))
            .map(|(forces, own)| &back * (forces - &at.mass * &z * own))
            .collect();

        let mut a = DMatrix::zeros(2 * n, 2 * n);
        a.view_mut((0, n), (n, n)).fill_with_identity();
        a.view_mut((n, 0), (n, n)).copy_from(&own[0]);
        a.view_mut((n, n), (n, n)).copy_from(&own[1]);
        let a = a.select_rows(self.kept).select_columns(self.kept);
        let mut b = DMatrix::zeros(2 * n, n_inputs);
        b.view_mut((n, 0), (n, n_inputs)).copy_from(&own[2]);
        let b = b.select_rows(self.kept);

        let nothing = |n_columns: usize| DMatrix::zeros(z.nrows(), n_columns);
        let changes = Changes {
            q: beside([&z, &nothing(n), &nothing(n_inputs)]),
            v: beside([&nothing(n), &z, &nothing(n_inputs)]),
            a: beside([&(&z * &own[0]), &(&z * &own[1]), &(&z * &own[2])]),
            lambda: beside([&lambda[0], &lambda[1], &lambda[2]]),
        };
        let numbers = (parameters, self.rows);
        let (c, d) = self.outputs.matrices(numbers, state, &changes, 2 * n, inputs);
        let c = c.select_columns(self.kept);
        let rows = |matrix: &DMatrix<f64>| matrix.transpose().iter().copied().collect::<Vec<f64>>();
        Some([[rows(&a), rows(&b)].concat(), [rows(&c), rows(&d)].concat()])
    }
}
