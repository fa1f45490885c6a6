//! A run that Python advances, setting inputs on the way.

use bksim::model::diagnostic::Rejected;
use bksim::options::{FORMULATIONS, METHODS, SolveChanges};
use bksim::sim::input::InputError;
use bksim::sim::{AdvanceError, SavedState as Saved, Stepping as Held};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::vector;
use crate::engine::Engine;
use crate::fault::{Fault, guard};
use crate::interrupt::Interruption;
use crate::solving::{changed, chosen, remembering};

/// A run that its caller advances.
#[pyclass(module = "bksim._bksim")]
pub(crate) struct Stepping {
    engine: Py<Engine>,
    held: Held,
}

/// A state of such a run.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct SavedState {
    engine: Py<Engine>,
    saved: Saved,
}

/// Options of a run that is begun.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SteppingRequest {
    t_end: Option<f64>,
    rtol: Option<f64>,
    atol: Option<f64>,
    step: Option<f64>,
    method: Option<String>,
    formulation: Option<String>,
}

impl SteppingRequest {
    fn changes(&self) -> Result<SolveChanges, Fault> {
        Ok(SolveChanges {
            t_end: self.t_end,
            rtol: self.rtol,
            atol: self.atol,
            step: self.step,
            every: None,
            method: chosen("method", &METHODS, self.method.as_deref())?,
            formulation: chosen("formulation", &FORMULATIONS, self.formulation.as_deref())?,
            jit: None,
        })
    }
}

/// A run held at its start.
#[pyfunction]
pub(crate) fn begin(
    py: Python<'_>,
    engine: Py<Engine>,
    wanted: SteppingRequest,
) -> PyResult<Stepping> {
    let inner = engine.get();
    let held = guard(py, || {
        let mut simulation = inner.simulation.clone();
        let options = changed(inner, wanted.changes()?)?;
        simulation.set_options(&options);
        let start = inner.start()?;
        remembering(&simulation, start, None)?;
        simulation.begin_at(start).map_err(|Rejected(faults)| Fault::model(inner.source(), &faults))
    })?;
    Ok(Stepping { engine, held })
}

type Numbers<'py> = Bound<'py, PyArray1<f64>>;

#[pymethods]
impl Stepping {
    #[getter]
    fn engine(&self, py: Python<'_>) -> Py<Engine> {
        self.engine.clone_ref(py)
    }

    /// Time at which it is held, s.
    #[getter]
    fn t(&self) -> f64 {
        self.held.t()
    }

    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        PyArray1::from_slice(py, &self.held.sample().q)
    }

    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        PyArray1::from_slice(py, &self.held.sample().v)
    }

    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        PyArray1::from_slice(py, &self.held.sample().a)
    }

    #[getter]
    fn lam<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        PyArray1::from_slice(py, &self.held.sample().lambda)
    }

    /// Six numbers per joint.
    #[getter]
    fn reactions<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        PyArray1::from_slice(py, self.held.reactions().as_flattened())
    }

    /// Everything that a log says of the instant, a value per column of the engine.
    fn row<'py>(&self, py: Python<'py>) -> Numbers<'py> {
        let mut row = Vec::new();
        self.engine.get().channels().append_row(self.held.sample(), &mut row);
        vector(py, row)
    }

    /// Lets a parameter have this value from now on, SI.
    fn set_input(&mut self, name: &str, value: f64) -> PyResult<()> {
        self.held.set_input(name, value).map_err(|error| match error {
            InputError::Unknown(_) => pyo3::exceptions::PyKeyError::new_err(error.to_string()),
            error => pyo3::exceptions::PyValueError::new_err(error.to_string()),
        })
    }

    /// Advances to a time, s.
    fn advance_to(&mut self, py: Python<'_>, t: f64) -> PyResult<()> {
        let Self { engine, held } = self;
        let source = engine.get().source();
        guard(py, || {
            let interruption = Interruption::new(None);
            let advanced = held.advance_to_unless(t, &|| interruption.is_wished(t));
            match (advanced, interruption.raised()) {
                (_, Some(error)) => Err(Fault::Python(error)),
                (Ok(_), None) => Ok(()),
                (Err(AdvanceError::Failed(fault)), None) => {
                    Err(Fault::motion(source, held.t(), &fault))
                }
                (Err(error), None) => Err(Fault::Value(error.to_string())),
            }
        })
    }

    /// The state in which it is held.
    fn save(&self, py: Python<'_>) -> SavedState {
        SavedState { engine: self.engine.clone_ref(py), saved: self.held.save() }
    }

    /// Holds it in a state that was saved.
    fn restore(&mut self, py: Python<'_>, state: Py<SavedState>) -> PyResult<()> {
        let state = state.get();
        let Self { engine, held } = self;
        guard(py, || held.restore(&state.saved).map_err(|error| Fault::Value(error.to_string())))?;
        *engine = state.engine.clone_ref(py);
        Ok(())
    }
}
