//! The compiled functions of a mechanism, at one state or over batches of them.

use std::sync::{Arc, Mutex};

use bksim::sim::compiled::CompiledSystem;
use bksim::sim::functions::{Functions as Evaluated, IdleFunctions};
use bksim::sim::state::{AccelerationRef, StateRef};
use numpy::ndarray::{Array2, ArrayView1, ArrayView2, IntoDimension, Ix1, Ix2};
use numpy::{PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
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

/// An array that is filled by `fill`, which says whether it did.
fn filled<S: IntoDimension>(
    py: Python<'_>,
    size: S,
    fill: impl FnOnce(&mut [f64]) -> PyResult<bool>,
) -> AtOne<'_, PyArray<f64, S::Dim>> {
    let out = PyArray::zeros(py, size, false);
    let is_done = match out.readwrite().as_slice_mut() {
        Ok(values) => fill(values)?,
        Err(_) => false,
    };
    Ok(is_done.then_some(out))
}

/// The methods of [`Functions`], two for each row: over a batch of states, and at one. Behind each state is its size,
/// behind the arrow the axes of the result, each as the sum of what stands in it.
macro_rules! functions {
    ($($name:ident $at:ident($($state:ident: $size:ident),*) -> $dimension:ident[$($($n:ident)+),*]
        |$f:ident, $t:ident, $out:ident| $evaluate:expr;)*) => {
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

            $(fn $name<'py>(
                &self,
                py: Python<'py>,
                t: Vector<'py>,
                $($state: Matrix<'py>),*
            ) -> Answer<'py> {
                let n = [$($(self.$n() +)+ 0),*].iter().product();
                let states = [$(&$state.as_array()),*];
                self.over(py, &t.as_array(), states, n, |$f, $t, [$($state),*], $out| $evaluate)
            }

            fn $at<'py>(
                &self,
                py: Python<'py>,
                t: &Bound<'py, PyAny>,
                $($state: &Bound<'py, PyAny>),*
            ) -> AtOne<'py, PyArray<f64, $dimension>> {
                let states = [$(($state, self.$size())),*];
                filled(py, [$($(self.$n() +)+ 0),*], |$out| {
                    self.at_one(py, t, states, |$f, $t, [$($state),*]| $evaluate)
                })
            })*
        }
    };
}

functions! {
    mass_matrix mass_matrix_at(q: nq) -> Ix2[nq, nq] |f, t, out| f.mass_matrix_into(t, q, out);
    constraint_jacobian constraint_jacobian_at(q: nq) -> Ix2[nc, nq]
        |f, t, out| f.constraint_jacobian_into(t, q, out);
    constraints constraints_at(q: nq) -> Ix1[nc] |f, t, out| f.constraints_into(t, q, out);
    forces forces_at(q: nq, v: nq) -> Ix1[nq] |f, t, out| f.force_into(t, q, v, out);
    accelerations accelerations_at(q: nq, v: nq) -> Ix1[nq nc] |f, t, out| {
        // Accelerations, then multipliers; NaN where there are none.
        let (a, lambda) = out.split_at_mut(q.len());
        let _ = f.accelerations_into(StateRef { t, q, v }, a, lambda);
    };
    residual residual_at(q: nq, v: nq, a: nq, lambda: nc) -> Ix1[nq nc] |f, t, out| {
        f.residual_into(StateRef { t, q, v }, AccelerationRef { a, lambda }, out);
    };
}
