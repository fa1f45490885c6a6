//! Sweeps under Python: the cases of one mechanism on all cores, or some parts of them for a worker
//! on another machine. Ctrl-C stops either.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;

use bksim::model::file::Limits;
use bksim::options::{FORMULATIONS, JITS, METHODS, SolveChanges};
use bksim_load::{Text, label_of, whole};
use bksim_sweep::{
    Axis, Column, Design, Existing, Monitor, Parts, Plan, Request, Row, Spacing, SweepError,
    Values, codes, is_whole, stated_axes, write,
};
use numpy::PyArray2;
use pyo3::exceptions::{PyFileExistsError, PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{table, transposed};
use crate::built::json_all;
use crate::engine::Engine;
use crate::fault::{Fault, guard};
use crate::interrupt::LOOK_EVERY;
use crate::solving::chosen;

/// The request of a sweep: plain, so that it can be sent.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SweepRequest {
    text: String,
    path: PathBuf,
    name: String,
    /// Parameters with one other value.
    fixed: Vec<(String, String)>,
    /// Joints that yield, each by name and stiffness.
    compliance: Vec<(String, String)>,
    axes: Vec<GivenAxis>,
    design: String,
    n: Option<u64>,
    seed: u64,
    outputs: Vec<String>,
    t_end: Option<f64>,
    rtol: Option<f64>,
    atol: Option<f64>,
    step: Option<f64>,
    every: Option<f64>,
    method: Option<String>,
    formulation: Option<String>,
    jit: Option<String>,
}

/// An axis: its name, `text`, `list` or `range`, the text or the unit, the numbers.
type GivenAxis = (String, String, String, Vec<f64>);

/// A sweep ready to run.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Study {
    source: Text,
    study: bksim_sweep::Study,
}

/// Some cases by column.
type Block<'py> = (
    // Their numbers.
    Vec<u64>,
    // Axes, then outputs, then the last instant: a row each, a value per case.
    Bound<'py, PyArray2<f64>>,
    // Steps of the integrator.
    Vec<u64>,
    // Those that failed: place in the block, how it ended, code, reason.
    Vec<Failed>,
);

type Failed = (usize, &'static str, &'static str, String);

/// The results of some parts, `None` for one that was stopped, and what stopped it.
type Done<T> = (Vec<Option<T>>, Option<Py<PyAny>>);

#[pymethods]
impl Study {
    /// Derives and compiles what all cases share.
    #[staticmethod]
    fn prepare(py: Python<'_>, wanted: SweepRequest) -> PyResult<Self> {
        guard(py, move || prepared(wanted))
    }

    #[getter]
    fn model_name(&self) -> &str {
        self.study.model_name()
    }

    #[getter]
    fn n_cases(&self) -> u64 {
        self.study.n_cases()
    }

    #[getter]
    fn n_parts(&self) -> u64 {
        self.study.n_parts()
    }

    /// First case of a part, and the first after it.
    fn cases_of(&self, part: u64) -> (u64, u64) {
        let cases = self.study.cases_of(part);
        (cases.start, cases.end)
    }

    /// The values of a case, as texts by name.
    fn settings(&self, case: u64) -> Vec<(String, String)> {
        self.study.overrides(case)
    }

    /// Values per axis of a grid; none of samples.
    #[getter]
    fn shape(&self) -> Option<Vec<u64>> {
        match self.study.plan().design() {
            Design::Grid => self.study.plan().axes().iter().map(Axis::n_values).collect(),
            _ => None,
        }
    }

    /// Axes: name, unit.
    fn inputs(&self) -> Vec<(String, String)> {
        self.study.input_columns().into_iter().map(named).collect()
    }

    /// Outputs: name, unit.
    fn outputs(&self) -> Vec<(String, String)> {
        self.study.output_columns().into_iter().map(named).collect()
    }

    #[getter]
    fn fingerprint(&self) -> String {
        self.study.fingerprint()
    }

    /// Warnings about the model, as JSON.
    fn diagnostics(&self) -> String {
        json_all(&self.source, self.study.warnings()).to_string()
    }

    /// The cases of some parts, those of a part together. `notify` is told now and then how many cases
    /// have ended.
    fn blocks<'py>(
        &self,
        py: Python<'py>,
        parts: Vec<u64>,
        jobs: usize,
        notify: Option<Py<PyAny>>,
    ) -> PyResult<Done<Block<'py>>> {
        self.check(&parts)?;
        let (columns, raised) = watched(py, notify.as_ref(), |monitor| {
            self.study
                .parts(&parts, jobs, monitor, |_, rows| Columns::of(rows, self.n_columns()))
                .map_err(|error| self.fault(error))
        })?;
        let blocks = columns.into_iter().map(|columns| columns.map(|columns| columns.block(py)));
        Ok((blocks.collect(), raised))
    }

    /// The cases of some parts, each part as a table in Parquet; the rest as [`Study::blocks`].
    fn tables<'py>(
        &self,
        py: Python<'py>,
        parts: Vec<u64>,
        jobs: usize,
        notify: Option<Py<PyAny>>,
    ) -> PyResult<Done<Bound<'py, PyBytes>>> {
        self.check(&parts)?;
        let (tables, raised) = watched(py, notify.as_ref(), |monitor| {
            let table_of = |_, rows: Vec<Row>| self.study.table_of(&rows);
            let tables = self.study.parts(&parts, jobs, monitor, table_of);
            let tables =
                tables.and_then(|tables| tables.into_iter().map(Option::transpose).collect());
            tables.map_err(|error| self.fault(error))
        })?;
        let tables: Vec<Option<Vec<u8>>> = tables;
        let bytes = tables.into_iter().map(|table| table.map(|table| PyBytes::new(py, &table)));
        Ok((bytes.collect(), raised))
    }

    /// Does all cases that are missing into a table of Parquet: whether it is whole, how many cases it
    /// or its parts hold, and what stopped it.
    fn write(
        &self,
        py: Python<'_>,
        path: PathBuf,
        existing: &str,
        jobs: usize,
        notify: Option<Py<PyAny>>,
    ) -> PyResult<(bool, u64, Option<Py<PyAny>>)> {
        let existing = existing_of(existing)?;
        let (report, raised) = watched(py, notify.as_ref(), |monitor| {
            write(&self.study, &path, existing, jobs, monitor).map_err(|error| self.fault(error))
        })?;
        Ok((!report.is_stopped, report.n_done + report.n_failed, raised))
    }

    /// Whether a file is the whole table of this very sweep.
    fn is_whole(&self, py: Python<'_>, path: PathBuf) -> PyResult<bool> {
        guard(py, || Ok(is_whole(&self.study, &path)))
    }

    /// Makes place for parts that are done elsewhere: the numbers of those that are missing.
    fn open_parts(&self, py: Python<'_>, path: PathBuf, existing: &str) -> PyResult<Vec<u64>> {
        let existing = existing_of(existing)?;
        guard(py, || Ok(self.parts(&path, existing)?.missing()))
    }

    /// Keeps a part that was done elsewhere.
    fn put_part(&self, py: Python<'_>, path: PathBuf, part: u64, bytes: &[u8]) -> PyResult<()> {
        self.check(&[part])?;
        guard(py, || {
            let parts = self.parts(&path, Existing::Resume)?;
            parts.put(part, bytes).map_err(|error| self.fault(error))
        })
    }

    /// Makes one table of all parts.
    fn join_parts(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        guard(py, || {
            let parts = self.parts(&path, Existing::Resume)?;
            parts.join().map_err(|error| self.fault(error))
        })
    }
}

impl Study {
    fn parts(&self, path: &std::path::Path, existing: Existing) -> Result<Parts<'_>, Fault> {
        Parts::open(&self.study, path, existing).map_err(|error| self.fault(error))
    }

    /// Of numbers: axes, outputs, the last instant.
    fn n_columns(&self) -> usize {
        self.study.plan().axes().len() + self.study.outputs().len() + 1
    }

    fn fault(&self, error: SweepError) -> Fault {
        fault(&self.source, error)
    }

    fn check(&self, parts: &[u64]) -> PyResult<()> {
        let n_parts = self.study.n_parts();
        match parts.iter().find(|part| **part >= n_parts) {
            Some(part) => Err(PyValueError::new_err(format!("part {part} of {n_parts}"))),
            None => Ok(()),
        }
    }
}

/// SI unit of a parameter or stated initial value; none when nothing has this name.
#[pyfunction]
pub(crate) fn si_unit(engine: &Engine, name: &str) -> Option<String> {
    bksim_sweep::si_unit(&engine.mechanism().model, name)
}

/// The place of the column that a name means.
#[pyfunction]
pub(crate) fn column_named(names: Vec<String>, asked: &str) -> PyResult<usize> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let fault = |help| PyKeyError::new_err(format!("no column is called `{asked}`: {help}"));
    bksim_sweep::column_named(&names, asked).map_err(fault)
}

fn named(column: Column) -> (String, String) {
    (column.name, column.unit)
}

fn existing_of(word: &str) -> PyResult<Existing> {
    match word {
        "refuse" => Ok(Existing::Refuse),
        "resume" => Ok(Existing::Resume),
        "replace" => Ok(Existing::Replace),
        other => Err(PyValueError::new_err(format!("{other:?} is no way to treat parts"))),
    }
}

fn prepared(wanted: SweepRequest) -> Result<Study, Fault> {
    let changes = SolveChanges {
        t_end: wanted.t_end,
        rtol: wanted.rtol,
        atol: wanted.atol,
        step: wanted.step,
        every: wanted.every,
        method: chosen("method", &METHODS, wanted.method.as_deref())?,
        formulation: chosen("formulation", &FORMULATIONS, wanted.formulation.as_deref())?,
        jit: chosen("jit", &JITS, wanted.jit.as_deref())?,
    };
    let (n, seed) = (wanted.n.unwrap_or_default(), wanted.seed);
    let design = match wanted.design.as_str() {
        "grid" => Design::Grid,
        "pairs" => Design::Pairs,
        "random" => Design::Random { n, seed },
        "latin-hypercube" => Design::LatinHypercube { n, seed },
        "sobol" => Design::Sobol { n, seed },
        other => {
            let known = r#""grid", "pairs", "random", "latin-hypercube" and "sobol""#;
            return Err(Fault::Value(format!("design = {other:?} is none of {known}")));
        }
    };
    let (source, _) = whole(Text::new(wanted.path, wanted.text), Limits::default())?;
    let mut fixed = wanted.fixed;
    let mut axes = Vec::new();
    for given in wanted.axes {
        let (name, text) = (given.0.clone(), given.2.clone());
        match axis(given) {
            Ok(Some(axis)) => axes.push(axis),
            // A text of one value.
            Ok(None) => fixed.push((name, text)),
            Err(error) => return Err(fault(&source, error)),
        }
    }
    if axes.is_empty() && design.is_sampled() {
        axes = stated_axes(&source.text, &fixed).map_err(|error| fault(&source, error.into()))?;
    }
    let plan = Plan::new(axes, design).map_err(|error| fault(&source, error.into()))?;
    let mut request = Request::new(&source.text, &wanted.name, plan);
    request.limits = Limits::default();
    request.file = label_of(&source.path);
    request.fixed = fixed;
    request.compliance = wanted.compliance;
    request.outputs = wanted.outputs;
    request.changes = changes;
    let study = bksim_sweep::Study::prepare(request);
    match study {
        Ok(study) => Ok(Study { source, study }),
        Err(rejected) => Err(fault(&source, rejected.into())),
    }
}

fn axis((name, kind, text, numbers): GivenAxis) -> Result<Option<Axis>, SweepError> {
    let values = match (kind.as_str(), numbers.as_slice()) {
        ("text", _) => return Ok(Axis::parse(&name, &text)?),
        ("range", &[from, to]) => Values::Range { from, to, spacing: Spacing::Linear },
        _ => Values::List(numbers),
    };
    Ok(Axis::new(&name, values, &text).map(Some)?)
}

fn fault(source: &Text, error: SweepError) -> Fault {
    match error {
        SweepError::Rejected(rejected) => {
            let found = rejected.0.iter().find(|fault| fault.code == codes::OTHER_SWEEP);
            match found {
                Some(found) => {
                    let way = "resume=True goes on with the same sweep, overwrite=True begins anew";
                    Fault::Python(PyFileExistsError::new_err(format!("{}: {way}", found.message)))
                }
                None => Fault::model(source, &rejected.0),
            }
        }
        SweepError::Threads(_) => Fault::Limit(error.to_string()),
        error => Fault::File(error.to_string()),
    }
}

/// Cases of a part, by column.
struct Columns {
    cases: Vec<u64>,
    /// Case by case: axes, outputs, the last instant.
    numbers: Vec<f64>,
    /// Numbers of a case.
    width: usize,
    steps: Vec<u64>,
    failed: Vec<Failed>,
}

impl Columns {
    fn of(rows: Vec<Row>, width: usize) -> Self {
        let mut columns = Self {
            cases: Vec::with_capacity(rows.len()),
            numbers: Vec::with_capacity(rows.len() * width),
            width,
            steps: Vec::with_capacity(rows.len()),
            failed: Vec::new(),
        };
        for (place, row) in rows.into_iter().enumerate() {
            columns.cases.push(row.case);
            columns.steps.push(row.n_steps);
            columns.numbers.extend(&row.inputs);
            columns.numbers.extend(&row.outputs);
            columns.numbers.resize((place + 1) * width - 1, f64::NAN);
            columns.numbers.push(row.t);
            let word = row.ending.word();
            if let Some(fault) = row.ending.fault() {
                columns.failed.push((place, word, fault.code, fault.reason.clone()));
            }
        }
        columns
    }

    fn block(self, py: Python<'_>) -> Block<'_> {
        let numbers = table(py, transposed(&self.numbers, self.width));
        (self.cases, numbers, self.steps, self.failed)
    }
}

/// Does work on threads of its own, while this one looks out for Ctrl-C and tells how many cases have
/// ended: what came of it, and what stopped it.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    notify: Option<&Py<PyAny>>,
    work: impl FnOnce(&Monitor<'_>) -> Result<T, Fault> + Send,
) -> PyResult<(T, Option<Py<PyAny>>)> {
    let (is_stopped, n_ended) = (AtomicBool::new(false), AtomicU64::new(0));
    let look = || {
        Python::attach(|py| {
            py.check_signals()?;
            match notify {
                Some(notify) => notify.call1(py, (n_ended.load(Ordering::Relaxed),)).map(drop),
                None => Ok(()),
            }
        })
    };
    let (done, raised) = guard(py, || {
        thread::scope(|scope| {
            let (tell, told) = channel::<()>();
            let worker = scope.spawn(|| {
                let monitor = Monitor {
                    stop: &|| is_stopped.load(Ordering::Relaxed),
                    progress: &|n| {
                        n_ended.fetch_max(n, Ordering::Relaxed);
                    },
                };
                let done = work(&monitor);
                drop(tell);
                done
            });
            let mut raised = None;
            // Dropped also by a panic.
            while let Err(RecvTimeoutError::Timeout) = told.recv_timeout(LOOK_EVERY) {
                if let Err(error) = look()
                    && raised.is_none()
                {
                    is_stopped.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            let done = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
            Ok((done, raised))
        })
    })?;
    let raised = raised.map(|error| error.value(py).clone().into_any().unbind());
    Ok((done, raised))
}
