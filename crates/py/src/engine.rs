//! A model with its equations, at one set of values.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use bksim::analysis::{compliances, diagnose_singular_start};
use bksim::describe;
use bksim::log::Field;
use bksim::mbs::equations::{Equations, Notation};
use bksim::mbs::quantity::Quantity;
use bksim::model::JointId;
use bksim::model::Measure;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, Recording};
use bksim::options::{JITS, choice};
use bksim::reading::{Contents, Reading};
use bksim::record::Channels;
use bksim::sim::compiled::CompiledSystem;
use bksim::sim::input::find_inputs;
use bksim::sim::mobility::mobility;
use bksim::sim::observable::Observables;
use bksim::sim::start::Start;
use bksim::{Mechanism, Rejected, Simulation};
use bksim_load::{Loaded, Request, Text, load, parse, parse_recorded};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{table, transposed};
use crate::built::json_all;
use crate::derived::Derived;
use crate::fault::{Fault, guard};
use crate::laws::law;
use crate::reading;

/// A model with its equations, at one set of values.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Engine {
    pub(crate) derived: Arc<Derived>,
    pub(crate) overrides: Vec<(String, String)>,
    /// The equations, with the values and settings of this model.
    pub(crate) simulation: Simulation,
    /// Whether the equations were derived with other values.
    is_replayed: bool,
    /// Joints that yield, each by name and stiffness.
    pub(crate) compliance: Vec<(String, String)>,
    /// Statements that came besides the text.
    stated: Arc<Stated>,
    start: OnceLock<Start>,
}

/// Statements about a model besides its text.
#[derive(Default)]
struct Stated {
    jit: Option<String>,
    /// Parameters that are functions of Python.
    inputs: Vec<(String, Py<PyAny>)>,
    /// Overrides that may take other numbers later.
    varied: Vec<String>,
}

/// A model as text, and what is to be other than it says.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Written {
    text: String,
    /// Stands in messages.
    path: PathBuf,
    /// True where it was built in code.
    is_built: bool,
    name: String,
    overrides: Vec<(String, String)>,
    jit: Option<String>,
    inputs: Vec<(String, Py<PyAny>)>,
    /// Overrides that may take other numbers later.
    varied: Vec<String>,
    /// Joints that yield.
    compliance: Vec<(String, String)>,
}

/// The argument of [`Engine::read`].
type Reread<'py> = (Bound<'py, PyDict>,);

/// A name with its unit and what it is.
type Described = (String, String, String);

impl Engine {
    pub(crate) fn new(
        source: Text,
        mechanism: &Mechanism,
        overrides: Vec<(String, String)>,
        warnings: Vec<Diagnostic>,
        recording: Option<Recording>,
    ) -> Result<Self, Fault> {
        let simulation = mechanism.simulation();
        let simulation = simulation.map_err(|Rejected(faults)| Fault::model(&source, &faults))?;
        Ok(Self {
            overrides,
            simulation,
            derived: Arc::new(Derived::new(source, mechanism, warnings, recording)),
            is_replayed: false,
            compliance: Vec::new(),
            stated: Arc::default(),
            start: OnceLock::new(),
        })
    }

    /// Derives the equations of a text.
    fn of_text(written: Written) -> Result<Self, Fault> {
        let Written { text, path, is_built, name, overrides, jit, inputs, varied, compliance } =
            written;
        let source = Text { is_built, ..Text::new(path, text) };
        let loaded = parse_recorded(source, &name, &overrides, &varied, Limits::default())?;
        let laws = Python::attach(|py| {
            inputs.iter().map(|(name, law)| (name.clone(), law.clone_ref(py))).collect()
        });
        let engine = Self::derived(loaded, overrides, jit.as_deref(), laws)?;
        let engine = Self { stated: Arc::new(Stated { jit, inputs, varied }), ..engine };
        if compliance.is_empty() { Ok(engine) } else { engine.yielding(compliance) }
    }

    /// Equations with joints that yield, each by name and stiffness.
    pub(crate) fn yielding(&self, compliance: Vec<(String, String)>) -> Result<Self, Fault> {
        let mut simulation = self.simulation.clone();
        let springs = compliances(&self.mechanism().model, &compliance)
            .map_err(|error| Fault::model(self.source(), &error.diagnostics()))?;
        simulation.set_compliances(&springs);
        Ok(Self {
            compliance,
            simulation,
            derived: self.derived.clone(),
            overrides: self.overrides.clone(),
            is_replayed: self.is_replayed,
            stated: self.stated.clone(),
            start: OnceLock::new(),
        })
    }

    fn derived(
        (loaded, recording): (Loaded, Option<Recording>),
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
            let names: Vec<String> = inputs.iter().map(|(name, _)| name.clone()).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            model.inputs =
                find_inputs(&model, &names).map_err(|unknown| Fault::Name(unknown.to_string()))?;
        }
        let law = (!inputs.is_empty()).then(|| law(inputs));
        let mechanism = Mechanism::derive_with(model, law, Vec::new())
            .map_err(|Rejected(faults)| Fault::model(&source, &faults))?;
        Self::new(source, &mechanism, overrides, warnings, recording)
    }

    pub(crate) fn source(&self) -> &Text {
        &self.derived.source
    }

    pub(crate) fn compiled(&self) -> &Arc<CompiledSystem> {
        self.simulation.compiled()
    }

    pub(crate) fn channels(&self) -> &Channels {
        &self.derived.channels
    }

    /// The mechanism with the values of this model, its expressions made again.
    pub(crate) fn mechanism(&self) -> Mechanism {
        self.simulation.mechanism()
    }

    pub(crate) fn start(&self) -> Result<&Start, Fault> {
        if let Some(start) = self.start.get() {
            return Ok(start);
        }
        let refused = |Rejected(faults)| Fault::assembly(self.source(), &faults);
        let start = self.simulation.start().map_err(refused)?;
        Ok(self.start.get_or_init(|| start))
    }

    /// Warnings about its values.
    fn warnings(&self) -> Result<Vec<Diagnostic>, Fault> {
        let Derived { source, name, warnings, .. } = &*self.derived;
        if !self.is_replayed {
            return Ok(warnings.clone());
        }
        Ok(parse(source.clone(), name, &self.overrides, Limits::default())?.warnings)
    }
}

#[pymethods]
impl Engine {
    /// Reads the text of a model.
    #[staticmethod]
    fn read(py: Python<'_>, written: Written) -> PyResult<Self> {
        guard(py, move || Self::of_text(written))
    }

    /// The model as it is read again: in another process, or later.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Reread<'py>)> {
        let written = PyDict::new(py);
        let Stated { jit, inputs, varied } = &*self.stated;
        written.set_item("text", self.text())?;
        written.set_item("path", self.path())?;
        written.set_item("is_built", self.source().is_built)?;
        written.set_item("name", self.name())?;
        written.set_item("overrides", &self.overrides)?;
        written.set_item("jit", jit)?;
        let inputs: Vec<_> = inputs.iter().map(|(name, law)| (name, law.bind(py))).collect();
        written.set_item("inputs", inputs)?;
        written.set_item("varied", varied)?;
        written.set_item("compliance", &self.compliance)?;
        Ok((py.get_type::<Self>().getattr("read")?, (written,)))
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// Equations at other values, SI, of the parameters that vary; none where other values
    /// make another model, or one that is refused.
    fn at(&self, values: Vec<f64>, overrides: Vec<(String, String)>) -> Option<Self> {
        let recording = self.derived.recording.as_ref()?;
        let mut simulation = self.simulation.clone();
        let mut parameters = simulation.parameters().to_vec();
        let mut options = simulation.options().clone();
        if !recording.replay(&values, &mut Vec::new(), &mut parameters, &mut options) {
            return None;
        }
        simulation.set_parameters(&parameters);
        simulation.set_options(&options);
        Some(Self {
            derived: self.derived.clone(),
            overrides,
            simulation,
            is_replayed: true,
            compliance: self.compliance.clone(),
            stated: self.stated.clone(),
            start: OnceLock::new(),
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
                is_geometry: false,
            };
            let loaded = load(&request)?;
            let engine = Self::derived((loaded, None), overrides, jit.as_deref(), Vec::new())?;
            Ok(Self { stated: Arc::new(Stated { jit, ..Stated::default() }), ..engine })
        })
    }

    #[getter]
    fn text(&self) -> &str {
        &self.source().text
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.source().path.clone()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.derived.name
    }

    /// Parameters: name, value in SI, unit.
    fn parameters(&self) -> Vec<(String, f64, String)> {
        let units = self.derived.units.iter();
        let values = units.zip(self.simulation.parameters());
        values.map(|((name, unit), &value)| (name.clone(), value, unit.clone())).collect()
    }

    fn coordinates(&self) -> Vec<Described> {
        self.compiled().coordinates.iter().map(described).collect()
    }

    fn joints(&self) -> Vec<String> {
        self.compiled().joints.clone()
    }

    /// Rows of a run's table.
    pub(crate) fn columns(&self) -> Vec<Described> {
        self.channels().columns().map(|(name, field)| column(name, field)).collect()
    }

    /// Options of the model: start, end, interval of the output, tolerances.
    fn options(&self) -> (f64, f64, f64, f64, f64) {
        let solve = self.simulation.options();
        (solve.t_start, solve.t_end, solve.interval(), solve.rtol, solve.atol)
    }

    /// Warnings, as JSON.
    fn diagnostics(&self, py: Python<'_>) -> PyResult<String> {
        guard(py, || Ok(json_all(self.source(), &self.warnings()?).to_string()))
    }

    /// The parts of the mechanism and how it can move, as JSON.
    fn check(&self, py: Python<'_>) -> PyResult<String> {
        guard(py, || {
            let (start, warnings) = (self.start()?, self.warnings()?);
            let mechanism = self.mechanism();
            let found = mobility(&mechanism.model, &mechanism.system, start);

            let mut warnings = mechanism.warnings_of(start, &found, warnings);
            warnings.extend(diagnose_singular_start(&mechanism, start));
            let mut body = describe::parts(&mechanism, &found);
            body["diagnostics"] = json_all(self.source(), &warnings);
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
    fn equations_json(&self, py: Python<'_>, is_absolute: bool) -> PyResult<String> {
        guard(py, || {
            let contents = Contents {
                in_absolute_angles: is_absolute,
                has_named_constants: true,
                ..Contents::default()
            };
            let mechanism = self.mechanism();
            let reading = Reading::of(&mechanism, contents);
            Ok(reading.map_err(|why| reading::fault(self.source(), why))?.json().to_string())
        })
    }

    /// The equations in a notation: formulas, or a whole document; with named constants and the parts that are named.
    fn equations_in(
        &self,
        py: Python<'_>,
        notation: String,
        is_document: bool,
        has_groups: bool,
        is_absolute: bool,
        parts: Vec<String>,
    ) -> PyResult<String> {
        guard(py, || {
            let style = reading::style(&notation)?;
            let contents = reading::contents(is_absolute, has_groups, &parts);
            let mechanism = self.mechanism();
            let reading = Reading::of(&mechanism, contents)
                .map_err(|why| reading::fault(self.source(), why))?;
            Ok(reading.written(style, is_document))
        })
    }

    /// T, V, the left sides of the equations and of the constraints, as LaTeX.
    fn latex(
        &self,
        py: Python<'_>,
        is_absolute: bool,
    ) -> PyResult<(String, String, Vec<String>, Vec<String>)> {
        guard(py, || {
            let contents = Contents { in_absolute_angles: is_absolute, ..Contents::default() };
            let mechanism = self.mechanism();
            let reading = Reading::of(&mechanism, contents)
                .map_err(|why| reading::fault(self.source(), why))?;
            let Equations { kinetic_energy, potential_energy, equations, constraints } =
                reading.formulas(Notation::Latex);
            Ok((kinetic_energy, potential_energy, equations, constraints))
        })
    }

    /// The unit of a measure such as `rod.B.x`; none when nothing has this name.
    fn measure_unit(&self, name: &str) -> Option<String> {
        let mechanism = self.mechanism();
        let model = &mechanism.model;
        Measure::named(model, name).map(|measure| measure.unit(model).to_owned())
    }

    /// Names of a position, its rate and its acceleration; none of anything else.
    fn motion_names(&self, name: &str) -> Option<[String; 3]> {
        let mechanism = self.mechanism();
        Measure::named(&mechanism.model, name)?.motion_names(&mechanism.model)
    }

    /// Names of measures, as a message suggests them.
    fn measure_names(&self) -> Vec<String> {
        Measure::names(&self.mechanism().model)
    }

    /// Quantities along states: `q`, `v` and `a` have a row per coordinate, `lam` one per multiplier, `reactions` six
    /// per joint, the result one per name.
    #[expect(clippy::too_many_arguments, reason = "the parts of a state, as Python has them")]
    fn measured<'py>(
        &self,
        py: Python<'py>,
        names: Vec<String>,
        q: PyReadonlyArray2<'py, f64>,
        v: PyReadonlyArray2<'py, f64>,
        a: PyReadonlyArray2<'py, f64>,
        lam: PyReadonlyArray2<'py, f64>,
        reactions: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let states = [q.as_array(), v.as_array(), a.as_array(), lam.as_array()];
        let reactions = reactions.as_array();
        let values = guard(py, || {
            let mechanism = self.mechanism();
            let Mechanism { model, system, parameters, .. } = &mechanism;
            let found = |name: &String| {
                Observables::named(model, name)
                    .ok_or_else(|| Fault::Name(format!("nothing is called `{name}`")))
            };
            let named = names.iter().map(found).collect::<Result<Vec<_>, _>>()?;
            let mut observables = Observables::compile(model, system, &named, parameters)
                .map_err(|e| Fault::Value(e.to_string()))?;
            let n_samples = states[0].ncols();
            let mut values = vec![0.0; n_samples * names.len()];
            for (k, out) in values.chunks_exact_mut(names.len().max(1)).enumerate() {
                let state = states.map(|part| part.column(k).to_vec());
                let reaction = |joint: JointId| {
                    std::array::from_fn(|i| {
                        reactions.get([6 * joint.0 + i, k]).copied().unwrap_or(f64::NAN)
                    })
                };
                observables.at(state.each_ref().map(Vec::as_slice), &reaction, out);
            }
            Ok(transposed(&values, names.len()))
        })?;
        Ok(table(py, values))
    }
}

/// Reads a text with these values, for its faults alone: nothing is derived.
#[pyfunction]
pub(crate) fn check_values(
    py: Python<'_>,
    text: String,
    path: PathBuf,
    name: String,
    overrides: Vec<(String, String)>,
) -> PyResult<()> {
    guard(py, || {
        parse(Text::new(path, text), &name, &overrides, Limits::default())?;
        Ok(())
    })
}

/// A row of a table.
pub(crate) fn column(name: String, field: &Field) -> Described {
    (name, field.unit.clone(), field.description.clone())
}

fn described(quantity: &Quantity) -> Described {
    (quantity.name.clone(), quantity.unit.clone(), quantity.description.clone())
}
