//! Inputs whose laws are functions of Python.
//!
//! What such a function raises cannot leave through the integrator. It is kept for the thread, the law has
//! no value from then on, and whoever asked for the work raises it in the end.

use std::cell::RefCell;
use std::sync::Arc;

use bksim::mbs::input::Law;
use numpy::PyArray1;
use pyo3::prelude::*;

thread_local! {
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
}

/// What a law has raised in this thread since it was last asked.
pub(crate) fn raised() -> Option<PyErr> {
    RAISED.take()
}

/// The law of some inputs, each a function of t, q and v.
pub(crate) fn law(functions: Vec<Py<PyAny>>) -> Arc<Law> {
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
    functions: &[Py<PyAny>],
    t: f64,
    (q, v): (&[f64], &[f64]),
    values: &mut [f64],
) -> PyResult<()> {
    Python::attach(|py| {
        let (q, v) = (PyArray1::from_slice(py, q), PyArray1::from_slice(py, v));
        for (function, value) in functions.iter().zip(values) {
            *value = function.call1(py, (t, &q, &v))?.extract(py)?;
        }
        Ok(())
    })
}
