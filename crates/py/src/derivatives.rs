//! Functions and quantities with their derivatives, at one state or over batches of them.

use std::sync::Mutex;

use bksim::sim::derivatives::{
    By, DerivativeError, Derivatives as Derived, DerivativesAt, IdleDerivatives, Subject,
};
use bksim::sim::state::{AccelerationRef, StateRef};
use numpy::ndarray::{Array2, ArrayView2};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::fault::{Fault, guard};
use crate::functions::{Functions, Matrix, Vector, at_state, check_sizes};

/// A function with its derivatives, compiled.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Derivatives {
    functions: Py<Functions>,
    derived: Derived,
    /// The buffers of the last call at one state, for the next one.
    idle: Mutex<Option<IdleDerivatives>>,
}

/// The functions that have derivatives.
const SUBJECTS: [(&str, Subject); 7] = [
    ("mass_matrix", Subject::MassMatrix),
    ("forces", Subject::Forces),
    ("constraint_jacobian", Subject::ConstraintJacobian),
    ("constraints", Subject::Constraints),
    ("accelerations", Subject::Accelerations),
    ("multipliers", Subject::Multipliers),
    ("residual", Subject::Residual),
];

/// The variables of a state.
const VARIABLES: [(&str, By); 5] = [
    ("t", By::Time),
    ("q", By::Positions),
    ("v", By::Velocities),
    ("a", By::Accelerations),
    ("lam", By::Multipliers),
];

/// The derivatives of a function, or of the quantities of these names for an empty word.
#[pyfunction]
pub(crate) fn derivatives_of(
    py: Python<'_>,
    functions: Py<Functions>,
    of: String,
    names: Vec<String>,
    by: Vec<String>,
) -> PyResult<Derivatives> {
    let inner = functions.get();
    let engine = inner.engine.get();
    let derived = guard(py, || {
        let subject = SUBJECTS.iter().find(|(word, _)| *word == of);
        let subject = match subject {
            Some((_, subject)) => subject.clone(),
            None if of.is_empty() => Subject::Quantities(names),
            None => {
                let known = SUBJECTS.map(|(word, _)| word).join(", ");
                return Err(Fault::Value(format!("{of:?} is none of {known}")));
            }
        };
        let mechanism = engine.mechanism();
        let is_residual = subject == Subject::Residual;
        let parameter = |name: &str| {
            let is_it = |p: &bksim::model::Parameter| p.name == name;
            mechanism.model.parameters.iter().position(is_it).map(By::Parameter)
        };
        let variable = |name: &String| {
            let own = VARIABLES.iter().find(|(word, _)| word == name).map(|&(_, by)| by);
            // `a` may be a length: only a residual has accelerations as arguments.
            let of_residual = matches!(own, Some(By::Accelerations | By::Multipliers));
            let known = own.filter(|_| is_residual || !of_residual);
            let found = known.or_else(|| parameter(name.trim_start_matches("parameters.")));
            let words = "is no parameter, and none of t, q and v (of a residual also a and lam)";
            found.ok_or_else(|| Fault::Name(format!("`{name}` {words}")))
        };
        let by = by.iter().map(variable).collect::<Result<Vec<By>, Fault>>()?;
        Derived::compile(&mechanism, &subject, &by, &inner.dependent).map_err(|error| match error {
            DerivativeError::Unknown(_) => Fault::Name(error.to_string()),
            _ => Fault::Value(error.to_string()),
        })
    })?;
    Ok(Derivatives { functions, derived, idle: Mutex::new(None) })
}

/// Values, a row per state, and derivatives, a row per state with those of each value after one another.
type ValuesAndDerivatives<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Values at one state, and the derivatives of each in a row.
type AtOne<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

impl Derivatives {
    /// Calls `work` with the derivatives, with the buffers of the last call unless another thread has them.
    fn with<T>(&self, work: impl FnOnce(&mut DerivativesAt<'_>) -> T) -> T {
        let functions = self.functions.get();
        let idle = self.idle.try_lock().ok().and_then(|mut idle| idle.take());
        let mut at = match idle {
            Some(idle) => idle.resume(&self.derived, &functions.compiled),
            None => self.derived.with(functions.anew()),
        };
        let done = work(&mut at);
        if let Ok(mut idle) = self.idle.try_lock() {
            *idle = Some(at.pause());
        }
        done
    }
}

#[pymethods]
impl Derivatives {
    /// Values and columns.
    #[getter]
    fn sizes(&self) -> (usize, usize) {
        (self.derived.n_rows(), self.derived.n_columns())
    }

    /// At one state, as [`Self::at`]: a vector of values and
    /// the derivatives of each in a row. None where the arguments are no such state, but for example a batch.
    fn at_one<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        given: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<Option<AtOne<'py>>> {
        let (n_rows, n_columns) = (self.derived.n_rows(), self.derived.n_columns());
        let values = PyArray1::zeros(py, n_rows, false);
        let derivatives = PyArray2::zeros(py, [n_rows, n_columns], false);
        let (n, nc) = (self.functions.get().nq(), self.functions.get().nc());
        let (mut values_out, mut derivatives_out) = (values.readwrite(), derivatives.readwrite());
        let is_done = match (values_out.as_slice_mut(), derivatives_out.as_slice_mut(), &given) {
            (Ok(values), Ok(derivatives), None) => {
                at_state(py, t, [(q, n), (v, n)], |t, [q, v]| {
                    self.with(|at| at.at(StateRef { t, q, v }, None, values, derivatives));
                })?
            }
            (Ok(values), Ok(derivatives), Some((a, lambda))) => {
                let states = [(q, n), (v, n), (a, n), (lambda, nc)];
                at_state(py, t, states, |t, [q, v, a, lambda]| {
                    let given = Some(AccelerationRef { a, lambda });
                    self.with(|at| at.at(StateRef { t, q, v }, given, values, derivatives));
                })?
            }
            _ => false,
        };
        drop((values_out, derivatives_out));
        Ok(is_done.then_some((values, derivatives)))
    }

    /// At states; `given` are the accelerations and multipliers of a residual.
    fn at<'py>(
        &self,
        py: Python<'py>,
        t: Vector<'py>,
        q: Matrix<'py>,
        v: Matrix<'py>,
        given: Option<(Matrix<'py>, Matrix<'py>)>,
    ) -> PyResult<ValuesAndDerivatives<'py>> {
        let (n_rows, n_columns) = (self.derived.n_rows(), self.derived.n_columns());
        let mut values = Array2::zeros((t.len()?, n_rows));
        let mut derivatives = Array2::zeros((t.len()?, n_rows * n_columns));
        let (t, q, v) = (t.as_array(), q.as_array(), v.as_array());
        let given = given.as_ref().map(|(a, lambda)| (a.as_array(), lambda.as_array()));
        guard(py, || {
            check_sizes(&t, &[&q, &v])?;
            if let Some((a, lambda)) = &given {
                check_sizes(&t, &[a, lambda])?;
            }
            let mut at = self.derived.with(self.functions.get().anew());
            let rows = values.rows_mut().into_iter().zip(derivatives.rows_mut());
            for (k, (mut values, mut derivatives)) in rows.enumerate() {
                let row = |state: &ArrayView2<'_, f64>| state.row(k).to_vec();
                let (q, v) = (row(&q), row(&v));
                let given = given.as_ref().map(|(a, lambda)| (row(a), row(lambda)));
                let given = given.as_ref().map(|(a, lambda)| AccelerationRef { a, lambda });
                let state = StateRef { t: t[k], q: &q, v: &v };
                if let Some((values, derivatives)) =
                    values.as_slice_mut().zip(derivatives.as_slice_mut())
                {
                    at.at(state, given, values, derivatives);
                }
            }
            Ok(())
        })?;
        let array = |values| PyArray2::from_owned_array(py, values);
        Ok((array(values), array(derivatives)))
    }
}
