//! The results of a run: its table, the motion between samples, and how it went.

use bksim::model::SolveOptions;
use bksim::model::diagnostic::Diagnostic;
use bksim::player::Player;
use bksim::sim::run::{Sample, Segment, Summary};
use bksim::sim::sensitivity::Sensitive;
use bksim::{describe, log};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::arrays::{table, transposed};
use crate::built::{self, json_all};
use crate::engine::{Engine, column};
use crate::fault::{Fault, guard};

/// The results of a run.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Run {
    pub(crate) engine: Py<Engine>,
    t: Py<PyArray1<f64>>,
    table: Py<PyArray2<f64>>,
    pub(crate) kept: Kept,
    /// The source of the model, as the log has it.
    pub(crate) logged: Option<Logged>,
    /// Facts that came with the bytes of its log.
    pub(crate) carried: Option<Carried>,
}

/// A run that was brought from another process, or kept: the bytes of its log, and what that does not tell.
pub(crate) struct Carried {
    pub(crate) log: Vec<u8>,
    pub(crate) facts: Facts,
}

/// Facts of a run that its log tells in other words, or not at all: its properties of these names.
#[derive(Clone, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Facts {
    ending: String,
    fault: Option<(String, String)>,
    warnings: String,
    summary: String,
}

/// Everything kept of a run besides its table.
pub(crate) struct Kept {
    pub(crate) options: SolveOptions,
    pub(crate) summary: Summary,
    pub(crate) segments: Vec<Segment>,
    pub(crate) ending: Ending,
    /// A sample, whose sizes are those of all.
    pub(crate) like: Sample,
    /// Names that it was differentiated by.
    pub(crate) sensitive: Vec<Sensitive>,
    /// Names of the derivatives, the last rows of the table.
    pub(crate) derivatives: Vec<(String, log::Field)>,
}

/// Facts that a log tells of its run, and a run by itself does not.
pub(crate) struct Logged {
    pub(crate) end: Option<log::EndStatus>,
    pub(crate) notes: Vec<log::Note>,
    pub(crate) not_unique: Vec<log::NotUnique>,
    /// Rows of its table.
    pub(crate) columns: Vec<(String, String, String)>,
}

impl Logged {
    /// How the run went, as its end tells, with the reason of that and the lines of the log; `null`
    /// for the end of a log that was cut short.
    fn summary(&self) -> Value {
        let details = self.end.as_ref().and_then(|end| describe::logged_summary(&end.details));
        let mut summary = details.unwrap_or_else(|| json!({}));
        summary["end"] = self.end.as_ref().map_or(Value::Null, |end| {
            json!({ "reached": end.outcome == log::Outcome::ReachedEnd, "t": end.t_end,
                    "reason": end.reason })
        });
        summary["uniqueness"] = describe::logged_uniqueness(&self.not_unique).into();
        let note = |note: &log::Note| json!({ "t": note.t, "text": note.text });
        summary["notes"] = self.notes.iter().map(note).collect();
        summary
    }
}

/// How a run ended.
pub(crate) enum Ending {
    /// At its end time.
    Reached,
    /// Where the memory it may take was full.
    Full,
    /// By a signal, or what `notify` raised.
    Stopped(Option<PyErr>),
    /// Where the integrator could not go on.
    Failed(Diagnostic),
}

impl Run {
    pub(crate) fn new(
        engine: Py<Engine>,
        t: Py<PyArray1<f64>>,
        table: Py<PyArray2<f64>>,
        kept: Kept,
    ) -> Self {
        Self { engine, t, table, kept, logged: None, carried: None }
    }

    /// The facts of a run that was brought from elsewhere.
    fn facts(&self) -> Option<&Facts> {
        self.carried.as_ref().map(|carried| &carried.facts)
    }

    pub(crate) fn with_log(self, logged: Logged) -> Self {
        Self { logged: Some(logged), ..self }
    }

    pub(crate) fn with_carried(self, carried: Carried) -> Self {
        Self { carried: Some(carried), ..self }
    }
}

#[pymethods]
impl Run {
    #[getter]
    fn engine(&self, py: Python<'_>) -> Py<Engine> {
        self.engine.clone_ref(py)
    }

    #[getter]
    fn t(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.t.clone_ref(py)
    }

    /// A row per column of the engine, a value per sample.
    #[getter]
    pub(crate) fn table(&self, py: Python<'_>) -> Py<PyArray2<f64>> {
        self.table.clone_ref(py)
    }

    /// Rows of the table: name, unit, description.
    fn columns(&self) -> Vec<(String, String, String)> {
        if let Some(logged) = &self.logged {
            return logged.columns.clone();
        }
        let derivatives = self.kept.derivatives.iter();
        let derivatives = derivatives.map(|(name, field)| column(name.clone(), field));
        self.engine.get().columns().into_iter().chain(derivatives).collect()
    }

    /// Whether it was opened from a log.
    #[getter]
    fn is_logged(&self) -> bool {
        self.logged.is_some() && self.carried.is_none()
    }

    /// How it ended: `reached`, `full`, `stopped`, `failed`.
    #[getter]
    fn ending(&self) -> &str {
        if let Some(facts) = self.facts() {
            return &facts.ending;
        }
        match self.kept.ending {
            Ending::Reached => "reached",
            Ending::Full => "full",
            Ending::Stopped(_) => "stopped",
            Ending::Failed(_) => "failed",
        }
    }

    /// The exception that stopped it, if one did.
    #[getter]
    fn raised(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        match &self.kept.ending {
            // With its traceback.
            Ending::Stopped(Some(error)) => Some(error.clone_ref(py).into_value(py).into_any()),
            _ => None,
        }
    }

    /// Why the integrator could not go on: in words, and as JSON.
    #[getter]
    fn fault(&self) -> Option<(String, String)> {
        if let Some(facts) = self.facts() {
            return facts.fault.clone();
        }
        let Ending::Failed(fault) = &self.kept.ending else { return None };
        let source = self.engine.get().source();
        let all = json_all(source, std::slice::from_ref(fault));
        Some((built::words(source, fault), all.to_string()))
    }

    /// The warnings about what the results are worth, as JSON; a log tells its own among its notes.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> PyResult<String> {
        if let Some(facts) = self.facts() {
            return Ok(facts.warnings.clone());
        }
        guard(py, || {
            let engine = self.engine.get();
            let Kept { summary, ending, .. } = &self.kept;
            let slow = summary.slowness.as_ref().filter(|slowness| !slowness.is_hopeless);
            let slow = slow.map(|slowness| engine.simulation.diagnose_slowness(slowness));
            // What is wrong with a run that failed is said elsewhere.
            let worth = match ending {
                Ending::Failed(_) => Vec::new(),
                _ if self.logged.is_some() => Vec::new(),
                _ => engine.simulation.diagnose_worth(summary),
            };
            let all: Vec<Diagnostic> = slow.into_iter().chain(worth).collect();
            Ok(json_all(engine.source(), &all).to_string())
        })
    }

    /// How it went, as JSON.
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        if let Some(facts) = self.facts() {
            return Ok(facts.summary.clone());
        }
        guard(py, || {
            if let Some(logged) = &self.logged {
                return Ok(logged.summary().to_string());
            }
            let mut mechanism = self.engine.get().mechanism();
            mechanism.model.solve = self.kept.options.clone();
            Ok(describe::summary(&mechanism, &self.kept.summary).to_string())
        })
    }

    /// First and last instant of the motion between samples; none when it was not kept.
    fn span(&self) -> Option<[f64; 2]> {
        bksim::player::span(&self.kept.segments)
    }

    /// The table at other instants, from the motion between samples; NaN where a value is known in
    /// samples alone.
    fn at<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let times = times.as_array().to_vec();
        let engine = self.engine.get();
        let n_columns = self.columns().len();
        let values = guard(py, || {
            let mut player = Player::new(engine.compiled().clone(), engine.simulation.parameters());
            let is_lasting: Vec<bool> = engine.channels().are_lasting().collect();
            let mut values = Vec::with_capacity(times.len() * n_columns);
            for &t in &times {
                let sample = player
                    .at(&self.kept.segments, t)
                    .map_err(|error| Fault::Log(error.to_string()))?;
                let first = values.len();
                engine.channels().append_row(sample, &mut values);
                for (value, _) in
                    values[first..].iter_mut().zip(&is_lasting).filter(|(_, is)| !**is)
                {
                    *value = f64::NAN;
                }
                values.resize(first + n_columns, f64::NAN);
            }
            Ok(transposed(&values, n_columns))
        })?;
        Ok(table(py, values))
    }
}

/// Samples one after another.
pub(crate) struct Rows {
    pub(crate) t: Vec<f64>,
    /// Values of one sample together.
    pub(crate) values: Vec<f64>,
    pub(crate) n_columns: usize,
}

impl Run {
    /// Instants of the samples, s.
    pub(crate) fn instants(&self, py: Python<'_>) -> Vec<f64> {
        use numpy::PyArrayMethods;
        self.t.bind(py).readonly().as_array().to_vec()
    }

    /// The table, sample by sample.
    pub(crate) fn rows(&self, py: Python<'_>) -> Rows {
        use numpy::PyArrayMethods;
        let table = self.table.bind(py).readonly();
        let (t, table) = (self.instants(py), table.as_array());
        let n_columns = table.nrows();
        Rows { t, values: table.t().iter().copied().collect(), n_columns }
    }
}
