//! A run that Python advances, setting inputs on the way.

use bksim::Simulation;
use bksim::model::diagnostic::Rejected;
use bksim::options::{FORMULATIONS, METHODS, SolveChanges};
use bksim::sim::input::InputError;
use bksim::sim::start::Start;
use bksim::sim::{AdvanceError, SavedState as Saved, Stepping as Held};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::vector;
use crate::engine::Engine;
use crate::fault::{Fault, guard};
use crate::interrupt::Interruption;
use crate::solving::{changed, chosen, remembering};

/// A run that its caller advances.
#[pyclass(module = "bksim._bksim")]
pub(crate) struct Stepping {
    engine: Py<Engine>,
    wanted: SteppingRequest,
    held: Held,
}

/// A state of such a run.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct SavedState {
    engine: Py<Engine>,
    wanted: SteppingRequest,
    saved: Saved,
}

/// Options of a run that is begun.
#[derive(FromPyObject, Clone)]
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

/// The parts that a state is made of again: the model, the options, bytes.
type Parts<'py> = (Py<Engine>, Bound<'py, PyDict>, Bound<'py, PyBytes>);

impl SteppingRequest {
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Self { t_end, rtol, atol, step, method, formulation } = self;
        let dict = PyDict::new(py);
        for (name, value) in [("t_end", t_end), ("rtol", rtol), ("atol", atol), ("step", step)] {
            dict.set_item(name, value)?;
        }
        dict.set_item("method", method)?;
        dict.set_item("formulation", formulation)?;
        Ok(dict)
    }

    /// The equations with these options, and the start of the run.
    fn simulation<'e>(&self, engine: &'e Engine) -> Result<(Simulation, &'e Start), Fault> {
        let mut simulation = engine.simulation.clone();
        simulation.set_options(&changed(engine, self.changes()?)?);
        Ok((simulation, engine.start()?))
    }

    /// A run held at its start.
    fn begin(&self, engine: &Engine) -> Result<Held, Fault> {
        let (simulation, start) = self.simulation(engine)?;
        remembering(&simulation, start, None)?;
        let refused = |Rejected(faults): Rejected| Fault::model(engine.source(), &faults);
        simulation.begin_at(start).map_err(refused)
    }

    /// A state out of its bytes.
    fn saved(&self, engine: &Engine, bytes: &[u8]) -> Result<Saved, Fault> {
        let (simulation, start) = self.simulation(engine)?;
        simulation.saved_state(start, bytes).map_err(|error| Fault::Value(error.to_string()))
    }
}

/// A run held at its start.
#[pyfunction]
pub(crate) fn begin(
    py: Python<'_>,
    engine: Py<Engine>,
    wanted: SteppingRequest,
) -> PyResult<Stepping> {
    let held = guard(py, || wanted.begin(engine.get()))?;
    Ok(Stepping { engine, wanted, held })
}

/// A run held in a state that another process has saved.
#[pyfunction]
pub(crate) fn held_again(
    py: Python<'_>,
    engine: Py<Engine>,
    wanted: SteppingRequest,
    bytes: Vec<u8>,
) -> PyResult<Stepping> {
    let held = guard(py, || {
        let mut held = wanted.begin(engine.get())?;
        let saved = wanted.saved(engine.get(), &bytes)?;
        held.restore(&saved).map_err(|error| Fault::Value(error.to_string()))?;
        Ok(held)
    })?;
    Ok(Stepping { engine, wanted, held })
}

/// A state that another process has saved.
#[pyfunction]
pub(crate) fn saved_again(
    py: Python<'_>,
    engine: Py<Engine>,
    wanted: SteppingRequest,
    bytes: Vec<u8>,
) -> PyResult<SavedState> {
    let saved = guard(py, || wanted.saved(engine.get(), &bytes))?;
    Ok(SavedState { engine, wanted, saved })
}

/// A function of the compiled module, by which an object is made again.
fn maker<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("bksim._bksim")?.getattr(name)
}

#[pymethods]
impl SavedState {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts<'py>)> {
        let bytes = PyBytes::new(py, &self.saved.to_bytes());
        let parts = (self.engine.clone_ref(py), self.wanted.to_dict(py)?, bytes);
        Ok((maker(py, "saved_again")?, parts))
    }
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
        let Self { engine, held, .. } = self;
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
        let (engine, wanted) = (self.engine.clone_ref(py), self.wanted.clone());
        SavedState { engine, wanted, saved: self.held.save() }
    }

    /// Holds it in a state that was saved.
    fn restore(&mut self, py: Python<'_>, state: Py<SavedState>) -> PyResult<()> {
        let state = state.get();
        let Self { engine, wanted, held } = self;
        guard(py, || held.restore(&state.saved).map_err(|error| Fault::Value(error.to_string())))?;
        *engine = state.engine.clone_ref(py);
        wanted.clone_from(&state.wanted);
        Ok(())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts<'py>)> {
        let bytes = PyBytes::new(py, &self.held.save().to_bytes());
        let parts = (self.engine.clone_ref(py), self.wanted.to_dict(py)?, bytes);
        Ok((maker(py, "held_again")?, parts))
    }
}
