//! The compiled functions of a mechanism over batches of states.

use std::sync::Arc;

use bksim::sim::compiled::CompiledSystem;
use bksim::sim::functions::Functions as Evaluated;
use bksim::sim::state::{AccelerationRef, StateRef};
use numpy::ndarray::{Array2, ArrayView1, ArrayView2};
use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::engine::Engine;
use crate::fault::{Fault, guard};

/// The compiled functions. A batch has a row per state; results have one, too, matrices row by row.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Functions {
    engine: Py<Engine>,
    compiled: Arc<CompiledSystem>,
    parameters: Vec<f64>,
    dependent: Vec<usize>,
}

type Vector<'py> = PyReadonlyArray1<'py, f64>;
type Matrix<'py> = PyReadonlyArray2<'py, f64>;
type Answer<'py> = PyResult<Bound<'py, PyArray2<f64>>>;

/// The compiled functions of a model.
#[pyfunction]
pub(crate) fn compiled_functions(py: Python<'_>, engine: Py<Engine>) -> PyResult<Functions> {
    let inner = engine.get();
    let dependent = guard(py, || Ok(inner.start()?.inactive_rows().to_vec()))?;
    let compiled = inner.simulation.compiled().clone();
    let parameters = inner.simulation.parameters().to_vec();
    Ok(Functions { engine, compiled, parameters, dependent })
}

impl Functions {
    /// Calls `each` with the functions, the instant and the states of every row of the batch.
    fn over<'py, const N: usize>(
        &self,
        py: Python<'py>,
        t: &ArrayView1<'_, f64>,
        states: [&ArrayView2<'_, f64>; N],
        n_outputs: usize,
        each: impl Fn(&mut Evaluated<'_>, f64, [&[f64]; N], &mut [f64]) + Sync,
    ) -> Answer<'py> {
        let n_states = t.len();
        let mut out = Array2::zeros((n_states, n_outputs));
        let mut work = || {
            for state in &states {
                if state.nrows() != n_states {
                    let rows = state.nrows();
                    let message = format!("{n_states} instants for {rows} states");
                    return Err(Fault::Value(message));
                }
            }
            let mut functions = Evaluated::new(&self.compiled, &self.parameters, &self.dependent);
            let mut rows: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
            for (k, mut out) in out.rows_mut().into_iter().enumerate() {
                for (row, state) in rows.iter_mut().zip(&states) {
                    row.clear();
                    row.extend(state.row(k));
                }
                let states = std::array::from_fn(|i| rows[i].as_slice());
                if let Some(out) = out.as_slice_mut() {
                    each(&mut functions, t[k], states, out);
                }
            }
            Ok(())
        };
        guard(py, &mut work)?;
        Ok(PyArray2::from_owned_array(py, out))
    }
}

#[pymethods]
impl Functions {
    #[getter]
    fn engine(&self, py: Python<'_>) -> Py<Engine> {
        self.engine.clone_ref(py)
    }

    /// Numbers of coordinates and of constraints.
    #[getter]
    fn sizes(&self) -> (usize, usize) {
        (self.compiled.nq(), self.compiled.nc())
    }

    fn mass_matrix<'py>(&self, py: Python<'py>, t: Vector<'py>, q: Matrix<'py>) -> Answer<'py> {
        let nq = self.compiled.nq();
        self.over(py, &t.as_array(), [&q.as_array()], nq * nq, |f, t, [q], out| {
            f.mass_matrix_into(t, q, out);
        })
    }

    fn constraint_jacobian<'py>(
        &self,
        py: Python<'py>,
        t: Vector<'py>,
        q: Matrix<'py>,
    ) -> Answer<'py> {
        let n = self.compiled.nc() * self.compiled.nq();
        self.over(py, &t.as_array(), [&q.as_array()], n, |f, t, [q], out| {
            f.constraint_jacobian_into(t, q, out);
        })
    }

    fn constraints<'py>(&self, py: Python<'py>, t: Vector<'py>, q: Matrix<'py>) -> Answer<'py> {
        let n = self.compiled.nc();
        self.over(py, &t.as_array(), [&q.as_array()], n, |f, t, [q], out| {
            f.constraints_into(t, q, out);
        })
    }

    fn forces<'py>(
        &self,
        py: Python<'py>,
        t: Vector<'py>,
        q: Matrix<'py>,
        v: Matrix<'py>,
    ) -> Answer<'py> {
        let n = self.compiled.nq();
        self.over(py, &t.as_array(), [&q.as_array(), &v.as_array()], n, |f, t, [q, v], out| {
            f.force_into(t, q, v, out);
        })
    }

    /// Accelerations, then multipliers.
    fn accelerations<'py>(
        &self,
        py: Python<'py>,
        t: Vector<'py>,
        q: Matrix<'py>,
        v: Matrix<'py>,
    ) -> Answer<'py> {
        let (nq, nc) = (self.compiled.nq(), self.compiled.nc());
        let states = [&q.as_array(), &v.as_array()];
        self.over(py, &t.as_array(), states, nq + nc, |f, t, [q, v], out| {
            let (a, lambda) = out.split_at_mut(nq);
            // Where there are none, they are NaN.
            let _ = f.accelerations_into(StateRef { t, q, v }, a, lambda);
        })
    }

    fn residual<'py>(
        &self,
        py: Python<'py>,
        t: Vector<'py>,
        q: Matrix<'py>,
        v: Matrix<'py>,
        a: Matrix<'py>,
        lambda: Matrix<'py>,
    ) -> Answer<'py> {
        let n = self.compiled.nq() + self.compiled.nc();
        let states = [&q.as_array(), &v.as_array(), &a.as_array(), &lambda.as_array()];
        self.over(py, &t.as_array(), states, n, |f, t, [q, v, a, lambda], out| {
            f.residual_into(StateRef { t, q, v }, AccelerationRef { a, lambda }, out);
        })
    }
}
