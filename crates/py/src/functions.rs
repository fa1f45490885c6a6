//! The compiled functions of a mechanism, at one state or over batches of them.

use std::sync::{Arc, Mutex};

use bksim::sim::compiled::CompiledSystem;
use bksim::sim::functions::{Functions as Evaluated, IdleFunctions};
use bksim::sim::state::{AccelerationRef, StateRef};
use numpy::ndarray::{Array2, ArrayView1, ArrayView2};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt};

use crate::engine::Engine;
use crate::fault::{Fault, brief, guard};

/// The compiled functions. A batch has a row per state; results have one, too, matrices row by row.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Functions {
    pub(crate) engine: Py<Engine>,
    pub(crate) compiled: Arc<CompiledSystem>,
    parameters: Vec<f64>,
    pub(crate) dependent: Vec<usize>,
    /// The buffers of the last call, for the next one.
    idle: Mutex<Option<IdleFunctions>>,
}

pub(crate) type Vector<'py> = PyReadonlyArray1<'py, f64>;
pub(crate) type Matrix<'py> = PyReadonlyArray2<'py, f64>;
type Answer<'py> = PyResult<Bound<'py, PyArray2<f64>>>;
/// The result at one state; none where the arguments are no such state, but for example a batch.
type AtOne<'py, T> = PyResult<Option<Bound<'py, T>>>;

/// The compiled functions of a model.
#[pyfunction]
pub(crate) fn compiled_functions(py: Python<'_>, engine: Py<Engine>) -> PyResult<Functions> {
    let inner = engine.get();
    let dependent = guard(py, || Ok(inner.start()?.inactive_rows().to_vec()))?;
    let compiled = inner.simulation.compiled().clone();
    let parameters = inner.simulation.parameters().to_vec();
    Ok(Functions { engine, compiled, parameters, dependent, idle: Mutex::new(None) })
}

impl Functions {
    /// Calls `work` with the functions, with the buffers of the last call unless another thread has them.
    fn with<T>(&self, work: impl FnOnce(&mut Evaluated<'_>) -> T) -> T {
        let idle = self.idle.try_lock().ok().and_then(|mut idle| idle.take());
        let mut functions = match idle {
            Some(idle) => idle.resume(&self.compiled),
            None => self.anew(),
        };
        let done = work(&mut functions);
        if let Ok(mut idle) = self.idle.try_lock() {
            *idle = Some(functions.pause());
        }
        done
    }

    pub(crate) fn anew(&self) -> Evaluated<'_> {
        Evaluated::new(&self.compiled, &self.parameters, &self.dependent)
    }

    /// Calls `each` with the functions, the instant and the states of every row of the batch.
    fn over<'py, const N: usize>(
        &self,
        py: Python<'py>,
        t: &ArrayView1<'_, f64>,
        states: [&ArrayView2<'_, f64>; N],
        n_outputs: usize,
        each: impl Fn(&mut Evaluated<'_>, f64, [&[f64]; N], &mut [f64]) + Sync,
    ) -> Answer<'py> {
        let mut out = Array2::zeros((t.len(), n_outputs));
        guard(py, || {
            check_sizes(t, &states)?;
            self.with(|functions| {
                let mut rows: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
                for (k, mut out) in out.rows_mut().into_iter().enumerate() {
                    for (row, state) in rows.iter_mut().zip(&states) {
                        row.clear();
                        row.extend(state.row(k));
                    }
                    let states = std::array::from_fn(|i| rows[i].as_slice());
                    if let Some(out) = out.as_slice_mut() {
                        each(functions, t[k], states, out);
                    }
                }
            });
            Ok(())
        })?;
        Ok(PyArray2::from_owned_array(py, out))
    }

    /// Calls `each` with the functions, the instant and the state, if they are one, as for [`at_state`].
    fn at_one<const N: usize>(
        &self,
        py: Python<'_>,
        t: &Bound<'_, PyAny>,
        states: [(&Bound<'_, PyAny>, usize); N],
        each: impl FnOnce(&mut Evaluated<'_>, f64, [&[f64]; N]),
    ) -> PyResult<bool> {
        at_state(py, t, states, |t, states| self.with(|functions| each(functions, t, states)))
    }

    pub(crate) fn nq(&self) -> usize {
        self.compiled.nq()
    }

    pub(crate) fn nc(&self) -> usize {
        self.compiled.nc()
    }
}

/// Calls `each` with an instant and a state, if they are one: a number, and vectors of these lengths.
pub(crate) fn at_state<const N: usize>(
    py: Python<'_>,
    t: &Bound<'_, PyAny>,
    states: [(&Bound<'_, PyAny>, usize); N],
    each: impl FnOnce(f64, [&[f64]; N]),
) -> PyResult<bool> {
    let is_number = t.is_instance_of::<PyFloat>() || t.is_instance_of::<PyInt>();
    let Some(t) = is_number.then(|| t.extract::<f64>().ok()).flatten() else {
        return Ok(false);
    };
    let views = states.map(|(state, n)| {
        let view = state.cast::<PyArray1<f64>>().ok()?.try_readonly().ok()?;
        view.as_slice().is_ok_and(|values| values.len() == n).then_some(view)
    });
    let slices = views.each_ref().map(|view| view.as_ref().and_then(|v| v.as_slice().ok()));
    if slices.iter().any(Option::is_none) {
        return Ok(false);
    }
    let slices = slices.map(Option::unwrap_or_default);
    brief(py, || each(t, slices))?;
    Ok(true)
}

pub(crate) fn check_sizes(
    t: &ArrayView1<'_, f64>,
    states: &[&ArrayView2<'_, f64>],
) -> Result<(), Fault> {
    let n_states = t.len();
    match states.iter().find(|state| state.nrows() != n_states) {
        Some(state) => {
            Err(Fault::Value(format!("{n_states} instants for {} states", state.nrows())))
        }
        None => Ok(()),
    }
}

/// A vector that is filled by `fill`, which tells whether it did.
fn filled(
    py: Python<'_>,
    n: usize,
    fill: impl FnOnce(&mut [f64]) -> PyResult<bool>,
) -> AtOne<'_, PyArray1<f64>> {
    let out = PyArray1::zeros(py, n, false);
    let is_done = match out.readwrite().as_slice_mut() {
        Ok(values) => fill(values)?,
        Err(_) => false,
    };
    Ok(is_done.then_some(out))
}

/// Matrix that is [`filled`].
fn filled_matrix(
    py: Python<'_>,
    size: [usize; 2],
    fill: impl FnOnce(&mut [f64]) -> PyResult<bool>,
) -> AtOne<'_, PyArray2<f64>> {
    let out = PyArray2::zeros(py, size, false);
    let is_done = match out.readwrite().as_slice_mut() {
        Ok(values) => fill(values)?,
        Err(_) => false,
    };
    Ok(is_done.then_some(out))
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
        (self.nq(), self.nc())
    }

    fn mass_matrix<'py>(&self, py: Python<'py>, t: Vector<'py>, q: Matrix<'py>) -> Answer<'py> {
        let nq = self.nq();
        self.over(py, &t.as_array(), [&q.as_array()], nq * nq, |f, t, [q], out| {
            f.mass_matrix_into(t, q, out);
        })
    }

    fn mass_matrix_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
    ) -> AtOne<'py, PyArray2<f64>> {
        let nq = self.nq();
        filled_matrix(py, [nq, nq], |out| {
            self.at_one(py, t, [(q, nq)], |f, t, [q]| f.mass_matrix_into(t, q, out))
        })
    }

    fn constraint_jacobian<'py>(
        &self,
        py: Python<'py>,
        t: Vector<'py>,
        q: Matrix<'py>,
    ) -> Answer<'py> {
        let n = self.nc() * self.nq();
        self.over(py, &t.as_array(), [&q.as_array()], n, |f, t, [q], out| {
            f.constraint_jacobian_into(t, q, out);
        })
    }

    fn constraint_jacobian_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
    ) -> AtOne<'py, PyArray2<f64>> {
        let nq = self.nq();
        filled_matrix(py, [self.nc(), nq], |out| {
            self.at_one(py, t, [(q, nq)], |f, t, [q]| f.constraint_jacobian_into(t, q, out))
        })
    }

    fn constraints<'py>(&self, py: Python<'py>, t: Vector<'py>, q: Matrix<'py>) -> Answer<'py> {
        self.over(py, &t.as_array(), [&q.as_array()], self.nc(), |f, t, [q], out| {
            f.constraints_into(t, q, out);
        })
    }

    fn constraints_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
    ) -> AtOne<'py, PyArray1<f64>> {
        filled(py, self.nc(), |out| {
            self.at_one(py, t, [(q, self.nq())], |f, t, [q]| f.constraints_into(t, q, out))
        })
    }

    fn forces<'py>(
        &self,
        py: Python<'py>,
        t: Vector<'py>,
        q: Matrix<'py>,
        v: Matrix<'py>,
    ) -> Answer<'py> {
        let states = [&q.as_array(), &v.as_array()];
        self.over(py, &t.as_array(), states, self.nq(), |f, t, [q, v], out| {
            f.force_into(t, q, v, out);
        })
    }

    fn forces_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> AtOne<'py, PyArray1<f64>> {
        let n = self.nq();
        filled(py, n, |out| {
            self.at_one(py, t, [(q, n), (v, n)], |f, t, [q, v]| f.force_into(t, q, v, out))
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
        let (nq, nc) = (self.nq(), self.nc());
        let states = [&q.as_array(), &v.as_array()];
        self.over(py, &t.as_array(), states, nq + nc, |f, t, [q, v], out| {
            let (a, lambda) = out.split_at_mut(nq);
            // Where there are none, they are NaN.
            let _ = f.accelerations_into(StateRef { t, q, v }, a, lambda);
        })
    }

    /// Accelerations, then multipliers.
    fn accelerations_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> AtOne<'py, PyArray1<f64>> {
        let n = self.nq();
        filled(py, n + self.nc(), |out| {
            self.at_one(py, t, [(q, n), (v, n)], |f, t, [q, v]| {
                let (a, lambda) = out.split_at_mut(n);
                let _ = f.accelerations_into(StateRef { t, q, v }, a, lambda);
            })
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
        let states = [&q.as_array(), &v.as_array(), &a.as_array(), &lambda.as_array()];
        let n = self.nq() + self.nc();
        self.over(py, &t.as_array(), states, n, |f, t, [q, v, a, lambda], out| {
            f.residual_into(StateRef { t, q, v }, AccelerationRef { a, lambda }, out);
        })
    }

    fn residual_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
        lambda: &Bound<'py, PyAny>,
    ) -> AtOne<'py, PyArray1<f64>> {
        let (n, nc) = (self.nq(), self.nc());
        let states = [(q, n), (v, n), (a, n), (lambda, nc)];
        filled(py, n + nc, |out| {
            self.at_one(py, t, states, |f, t, [q, v, a, lambda]| {
                f.residual_into(StateRef { t, q, v }, AccelerationRef { a, lambda }, out);
            })
        })
    }
}
