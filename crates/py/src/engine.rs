//! A model with its equations, derived once; whoever solves or evaluates shares them.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};

use bksim::describe;
use bksim::mbs::compile::{CompiledSystem, Quantity};
use bksim::mbs::diagnostic::Diagnostic;
use bksim::mbs::equations::page::{Page, Style, Subject};
use bksim::mbs::equations::{Equations, Notation, ReadingForm, proof};
use bksim::mbs::fault::diagnose_mobility;
use bksim::mbs::file::Limits;
use bksim::mbs::formulate::MotionEquations;
use bksim::mbs::input::Inputs;
use bksim::mbs::measure::Measures;
use bksim::mbs::mobility::mobility;
use bksim::mbs::model::{Formulation, Measure, Parameter, SolveOptions};
use bksim::mbs::start::{Start, start_at};
use bksim::options::{JITS, choice};
use bksim::record::Channels;
use bksim::{Mechanism, Rejected};
use bksim_input::{Loaded, Request, Text, json_all, load, parse};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use crate::arrays::{table, transposed};
use crate::fault::{Fault, guard};
use crate::functions::Functions;
use crate::laws::law;
use crate::solution::Run;
use crate::solving::{self, Wanted};

/// A model with its equations.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Engine {
    pub(crate) source: Text,
    pub(crate) overrides: Vec<(String, String)>,
    pub(crate) warnings: Vec<Diagnostic>,
    /// Values of the parameters.
    pub(crate) parameters: Vec<f64>,
    pub(crate) compiled: Arc<CompiledSystem>,
    pub(crate) channels: Channels,
    pub(crate) name: String,
    /// Settings of the model.
    pub(crate) options: SolveOptions,
    /// Name, value in SI, unit.
    values: Vec<(String, f64, String)>,
    /// Its expressions are for one thread at a time; what is compiled is for all.
    mechanism: Mutex<Mechanism>,
    start: OnceLock<Start>,
    equations: Mutex<Vec<(Formulation, Arc<MotionEquations>)>>,
}

/// A name with its unit and what it is.
type Described = (String, String, String);

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What is behind a lock is whole between calls, also after a panic.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Engine {
    pub(crate) fn new(
        source: Text,
        mechanism: Mechanism,
        overrides: Vec<(String, String)>,
        warnings: Vec<Diagnostic>,
    ) -> Self {
        let model = &mechanism.model;
        let value = |p: &Parameter| (p.name.clone(), p.value, p.unit.clone());
        Self {
            source,
            overrides,
            warnings,
            name: model.name.clone(),
            options: model.solve.clone(),
            values: model.parameters.iter().map(value).collect(),
            parameters: mechanism.parameters.clone(),
            compiled: mechanism.compiled.clone(),
            channels: Channels::new(&mechanism),
            mechanism: Mutex::new(mechanism),
            start: OnceLock::new(),
            equations: Mutex::default(),
        }
    }

    fn derived(
        loaded: Loaded,
        overrides: Vec<(String, String)>,
        jit: Option<&str>,
        inputs: Vec<(String, Py<PyAny>)>,
    ) -> Result<Self, Fault> {
        let Loaded { source, mut model, warnings } = loaded;
        if let Some(word) = jit {
            model.solve.jit = choice(&JITS, word).ok_or_else(|| {
                Fault::Value(format!("jit = {word:?} is none of \"auto\", \"on\" and \"off\""))
            })?;
        }
        if !inputs.is_empty() {
            let (names, functions): (Vec<String>, Vec<Py<PyAny>>) = inputs.into_iter().unzip();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            model.inputs = Inputs::new(&model, &names, law(functions))
                .map_err(|unknown| Fault::Name(unknown.to_string()))?;
        }
        let mechanism = Mechanism::derive(model, Vec::new())
            .map_err(|Rejected(faults)| Fault::model(&source, &faults))?;
        Ok(Self::new(source, mechanism, overrides, warnings))
    }

    /// The mechanism, for this thread alone. Who has it may wait for the interpreter, when a law is a
    /// function of Python: so nobody waits for it with the interpreter lock held.
    pub(crate) fn mechanism(&self) -> MutexGuard<'_, Mechanism> {
        match self.mechanism.try_lock() {
            Ok(mechanism) => mechanism,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => Python::attach(|py| {
                let locked = self.mechanism.lock_py_attached(py);
                locked.unwrap_or_else(PoisonError::into_inner)
            }),
        }
    }

    pub(crate) fn start(&self) -> Result<&Start, Fault> {
        if let Some(start) = self.start.get() {
            return Ok(start);
        }
        let refused = |Rejected(faults)| Fault::assembly(&self.source, &faults);
        let equations = self.mechanism().start_equations().map_err(refused)?;
        let start = start_at(&equations, &self.compiled, &self.parameters, &[], &self.options);
        let start = start.map_err(|error| {
            let fault = self.mechanism().diagnose_start(&error);
            refused(Rejected(vec![fault]))
        })?;
        Ok(self.start.get_or_init(|| start))
    }

    pub(crate) fn equations(&self, form: Formulation) -> Result<Arc<MotionEquations>, Fault> {
        let mut known = locked(&self.equations);
        if let Some((_, equations)) = known.iter().find(|(known, _)| *known == form) {
            return Ok(equations.clone());
        }
        let mut mechanism = self.mechanism();
        let own = std::mem::replace(&mut mechanism.model.solve.formulation, form);
        let equations = mechanism.formulate();
        mechanism.model.solve.formulation = own;
        drop(mechanism);
        let equations =
            equations.map_err(|Rejected(faults)| Fault::model(&self.source, &faults))?;
        let equations = Arc::new(equations);
        known.push((form, equations.clone()));
        Ok(equations)
    }
}

#[pymethods]
impl Engine {
    /// Reads the text of a model; `path` stands in messages.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        text: String,
        path: PathBuf,
        name: String,
        overrides: Vec<(String, String)>,
        jit: Option<String>,
        inputs: Vec<(String, Py<PyAny>)>,
    ) -> PyResult<Self> {
        guard(py, move || {
            let source = Text::new(path, text);
            let loaded = parse(source, &name, &overrides, Limits::default())?;
            Self::derived(loaded, overrides, jit.as_deref(), inputs)
        })
    }

    /// Opens a model file or a drawing.
    #[staticmethod]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        overrides: Vec<(String, String)>,
        unit: Option<String>,
        tolerance: Option<f64>,
        jit: Option<String>,
    ) -> PyResult<Self> {
        guard(py, move || {
            let request = Request {
                path: &path,
                overrides: &overrides,
                unit: unit.as_deref(),
                tolerance,
                limits: Limits::default(),
            };
            let loaded = load(&request)?;
            Self::derived(loaded, overrides, jit.as_deref(), Vec::new())
        })
    }

    #[getter]
    fn text(&self) -> &str {
        &self.source.text
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.source.path.clone()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Parameters: name, value in SI, unit.
    fn parameters(&self) -> Vec<(String, f64, String)> {
        self.values.clone()
    }

    fn coordinates(&self) -> Vec<Described> {
        self.compiled.coordinates.iter().map(described).collect()
    }

    fn joints(&self) -> Vec<String> {
        self.compiled.joints.clone()
    }

    /// Rows of a run's table.
    fn columns(&self) -> Vec<Described> {
        let described = |(name, field): (String, &bksim::log::Field)| {
            (name, field.unit.clone(), field.description.clone())
        };
        self.channels.columns().map(described).collect()
    }

    /// Options of the model: start, end, interval of the output, tolerances.
    fn options(&self) -> (f64, f64, f64, f64, f64) {
        let solve = &self.options;
        (solve.t_start, solve.t_end, solve.interval(), solve.rtol, solve.atol)
    }

    /// Warnings, as JSON.
    fn diagnostics(&self) -> String {
        json_all(&self.source, &self.warnings).to_string()
    }

    /// What the mechanism is made of and how it can move, as JSON.
    fn check(&self, py: Python<'_>) -> PyResult<String> {
        guard(py, || {
            let start = self.start()?;
            let mechanism = self.mechanism();
            let found = mobility(&mechanism.model, &mechanism.system, start);
            let mut warnings = self.warnings.clone();
            warnings.extend(diagnose_mobility(&mechanism.model, &found));
            let mut body = describe::parts(&mechanism, &found);
            body["diagnostics"] = json_all(&self.source, &warnings);
            Ok(body.to_string())
        })
    }

    /// The consistent start, as JSON.
    fn assemble(&self, py: Python<'_>) -> PyResult<String> {
        guard(py, || {
            let start = self.start()?;
            Ok(describe::start(&self.mechanism(), start).to_string())
        })
    }

    /// The equations, as JSON.
    fn equations_json(&self, py: Python<'_>) -> PyResult<String> {
        guard(py, || {
            let mechanism = self.mechanism();
            let Mechanism { model, system, .. } = &*mechanism;
            let form = ReadingForm::grouped(model, system);
            let proof = proof(model, system, &form);
            Ok(describe::equations(&mechanism, &form, &proof).to_string())
        })
    }

    /// The equations in a notation: formulas, or a whole document.
    fn equations_in(
        &self,
        py: Python<'_>,
        notation: String,
        is_document: bool,
        has_groups: bool,
    ) -> PyResult<String> {
        guard(py, || {
            let style = match notation.as_str() {
                "text" => Style::Text,
                "aligned" => Style::Aligned { width: 100, unicode: true },
                "latex" => Style::Latex,
                "typst" => Style::Typst,
                "mathml" => Style::MathMl,
                other => {
                    let known = "text, aligned, latex, typst and mathml";
                    return Err(Fault::Value(format!("{other:?} is none of {known}")));
                }
            };
            let mechanism = self.mechanism();
            let Mechanism { model, system, compiled, .. } = &*mechanism;
            let form = if has_groups {
                ReadingForm::grouped(model, system)
            } else {
                ReadingForm::plain(model, system)
            };
            let proof = proof(model, system, &form);
            let (coordinates, multipliers) = (&compiled.coordinates, &compiled.multipliers);
            let subject =
                Subject { model, system, coordinates, multipliers, form: &form, proof: &proof };
            let page = Page::new(&subject, style);
            Ok(if is_document { page.document() } else { page.formulas() })
        })
    }

    /// T, V, the left sides of the equations and of the constraints, as LaTeX.
    fn latex(&self, py: Python<'_>) -> PyResult<(String, String, Vec<String>, Vec<String>)> {
        guard(py, || {
            let mechanism = self.mechanism();
            let Mechanism { model, system, .. } = &*mechanism;
            let formulas = ReadingForm::plain(model, system).write(model, Notation::Latex);
            let Equations { kinetic_energy, potential_energy, equations, constraints } = formulas;
            Ok((kinetic_energy, potential_energy, equations, constraints))
        })
    }

    /// The unit of a measure such as `rod.B.x`; none when nothing has this name.
    fn measure_unit(&self, name: &str) -> Option<&'static str> {
        let mechanism = self.mechanism();
        Measure::named(&mechanism.model, name).map(|measure| measure.unit(&mechanism.model))
    }

    /// Measures along states: `q` and `v` have a row per coordinate, the result one per name.
    fn measured<'py>(
        &self,
        py: Python<'py>,
        names: Vec<String>,
        q: PyReadonlyArray2<'py, f64>,
        v: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (q, v) = (q.as_array(), v.as_array());
        let values = guard(py, || {
            let mechanism = self.mechanism();
            let Mechanism { model, system, parameters, .. } = &*mechanism;
            let found = |name: &String| {
                Measure::named(model, name)
                    .ok_or_else(|| Fault::Name(format!("nothing is called `{name}`")))
            };
            let measures = names.iter().map(found).collect::<Result<Vec<_>, _>>()?;
            let mut measures = Measures::compile(model, system, &measures, parameters)
                .map_err(|e| Fault::Value(e.to_string()))?;
            drop(mechanism);
            let n_samples = q.ncols();
            let mut values = vec![0.0; n_samples * names.len()];
            for (k, out) in values.chunks_exact_mut(names.len().max(1)).enumerate() {
                let (q, v) = (q.column(k).to_vec(), v.column(k).to_vec());
                measures.at(&q, &v, out);
            }
            Ok(transposed(&values, names.len()))
        })?;
        Ok(table(py, values))
    }

    /// The compiled functions.
    fn functions(slf: Py<Self>, py: Python<'_>) -> PyResult<Functions> {
        let dependent = {
            let engine = slf.get();
            guard(py, || Ok(engine.start()?.dependent_rows().to_vec()))?
        };
        Ok(Functions::new(slf, dependent))
    }

    /// Solves; what the run has left also tells when it ended early.
    fn solve(slf: Py<Self>, py: Python<'_>, wanted: Wanted) -> PyResult<Run> {
        solving::solve(py, slf, wanted)
    }
}

fn described(quantity: &Quantity) -> Described {
    (quantity.name.clone(), quantity.unit.to_owned(), quantity.description.clone())
}
