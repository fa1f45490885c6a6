//! Inputs whose laws are functions of Python.
//!
//! An exception of such a function cannot leave through the integrator. It is kept for the thread, the law has
//! no value from then on, and the caller raises it in the end.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use bksim::sim::input::Law;
use numpy::PyArray1;
use pyo3::exceptions::{PyRecursionError, PyTypeError};
use pyo3::prelude::*;

thread_local! {
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
    static DEPTH: Cell<usize> = const { Cell::new(0) };
}

/// The exception that a law has raised in this thread since it was last asked.
pub(crate) fn raised() -> Option<PyErr> {
    RAISED.take()
}

/// Runs in which a law may run models whose laws do so, too.
const MAX_DEPTH: usize = 16;

/// The law of some inputs, by name: each a function of t, q and v.
pub(crate) fn law(functions: Vec<(String, Py<PyAny>)>) -> Arc<Law> {
    Arc::new(move |t, q, v, values| {
        let has_raised = RAISED.with_borrow(Option::is_some);
        let called =
            if has_raised { Ok(false) } else { call(&functions, t, (q, v), values).map(|()| true) };
        match called {
            Ok(true) => (),
            Ok(false) => values.fill(f64::NAN),
            Err(error) => {
                values.fill(f64::NAN);
                RAISED.set(Some(error));
            }
        }
    })
}

fn call(
    functions: &[(String, Py<PyAny>)],
    t: f64,
    (q, v): (&[f64], &[f64]),
    values: &mut [f64],
) -> PyResult<()> {
    Python::attach(|py| {
        let (q, v) = (PyArray1::from_slice(py, q), PyArray1::from_slice(py, v));
        let _inside = Inside::enter()?;
        for ((name, function), value) in functions.iter().zip(values) {
            let found = function.call1(py, (t, &q, &v))?;
            *value = found.extract(py).map_err(|_| {
                let found =
                    found.bind(py).repr().map_or_else(|_| "?".to_owned(), |r| r.to_string());
                let words = format!("the input `{name}` is {found} at t = {t} s: return a number");
                PyTypeError::new_err(words)
            })?;
        }
        Ok(())
    })
}

/// A call of a law, which may itself lead to one.
struct Inside;

impl Inside {
    fn enter() -> PyResult<Self> {
        let depth = DEPTH.get();
        if depth == MAX_DEPTH {
            return Err(PyRecursionError::new_err("a law that solves its own model"));
        }
        DEPTH.set(depth + 1);
        Ok(Self)
    }
}

impl Drop for Inside {
    fn drop(&mut self) {
        DEPTH.set(DEPTH.get() - 1);
    }
}
