//! [`Study`]: all that the cases of a sweep share: the plan, and equations derived and compiled once.

use std::fmt::Write as _;
use std::sync::OnceLock;

use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use bksim::analysis::Weighed;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Reading, Recording};
use bksim::model::{Model, SolveOptions};
use bksim::record::Channels;
use bksim::sim::run::Sample;
use bksim::{Mechanism, Rejected, Simulation, VERSION};
use sha2::{Digest, Sha256};

use crate::axis::Axis;
use crate::codes;
use crate::input::{Input, Quantity, inputs, overrides};
use crate::output::{Output, Outputs, Reducer};
use crate::parquet::{Column, Layout, entry};
use crate::plan::Plan;
use crate::request::Request;
use crate::sampling::check_times;

/// A sweep ready to run: equations derived and compiled, outputs found, shared by all threads.
#[derive(Debug)]
pub struct Study {
    pub(crate) request: Request,
    /// By axis.
    pub(crate) inputs: Vec<Input>,
    pub(crate) outputs: Outputs,
    pub(crate) channels: Channels,
    /// The equations, derived once, with the values of one case.
    pub(crate) simulation: Simulation,
    /// How parameters and settings of a case follow from its values.
    pub(crate) recording: Recording,
    /// Settings as the model has them.
    pub(crate) solve: SolveOptions,
    /// Settings of cases where no axis changes them.
    pub(crate) options: SolveOptions,
    model_name: String,
    warnings: Vec<Diagnostic>,
    options_text: String,
    /// The way back along the motion of its cases, once it was needed; `None` where there is none.
    pub(crate) ways_back: OnceLock<Option<Weighed>>,
    /// The layout of its tables, once one was needed.
    layout: OnceLock<Layout>,
}

/// Cases that are tried for one whose values the model allows.
const N_TRIED: u64 = 64;

impl Study {
    /// Reads the model, derives and compiles its equations, and finds the outputs.
    ///
    /// # Errors
    /// [`Rejected`] for faults of the model, of axes and of outputs; also when none of some 64 cases
    /// has values that the model allows, with the faults of the first.
    pub fn prepare(request: Request) -> Result<Self, Rejected> {
        let rejected = |fault: Diagnostic| Rejected(vec![fault]);

        // The quantities of the axes, and the model at the values of one case.
        let stated = request.read_stated().map_err(Rejected)?;
        let inputs = inputs(&request, &stated).map_err(rejected)?;
        let (mut model, recording, warnings) = first_allowed(&request, &inputs)?;

        // Settings: those of the model, then with the changes of the request.
        let solve = SolveOptions { spans: Vec::new(), ..model.solve.clone() };
        request.changes.check(solve.t_start).map_err(|bad| {
            let help = format!("give `{}` a value {}", bad.option, bad.range);
            rejected(Diagnostic::error(codes::BAD_OPTION, bad.to_string()).help(help))
        })?;
        request.changes.apply(&mut model.solve);
        model.compliances = request.compliances(&model)?;
        let mut options = solve.clone();
        request.changes.apply(&mut options);
        let options_text = format!("{options:?}");

        // Equations and the channels of their samples.
        let model_name = model.name.clone();
        let mechanism = if request.is_geometry {
            Mechanism::positions(model)?
        } else {
            Mechanism::derive(model, Vec::new())?
        };
        let channels = Channels::new(&mechanism);

        // Outputs.
        let outputs = Outputs::read(&request.outputs, &mechanism, &channels, request.slopes)
            .map_err(rejected)?;
        check_times(&outputs, &mechanism.model.solve).map_err(rejected)?;

        Ok(Self {
            inputs,
            outputs,
            channels,
            simulation: mechanism.simulation()?,
            recording,
            solve,
            options,
            options_text,
            model_name,
            warnings,
            ways_back: OnceLock::new(),
            layout: OnceLock::new(),
            request,
        })
    }

    /// The model with its equations, at the values of one case.
    pub fn mechanism(&self) -> Mechanism {
        self.simulation.mechanism()
    }

    /// The parameters of the model where its axes have these values, SI; `None` where the model refuses them or is
    /// another one there. Initial values have no part in them.
    pub fn parameters_at(&self, point: &[f64]) -> Option<Vec<f64>> {
        let of_parameters = self.inputs.iter().zip(point);
        let is_parameter = |input: &&Input| input.quantity == Quantity::Parameter;
        let varied: Vec<f64> = of_parameters
            .filter(|(input, _)| is_parameter(input))
            .map(|(_, &value)| value)
            .collect();
        let mut parameters = self.simulation.parameters().to_vec();
        let (mut values, mut options) = (Vec::new(), self.options.clone());
        let is_known = self.recording.replay(&varied, &mut values, &mut parameters, &mut options);
        is_known.then_some(parameters)
    }

    /// The outputs of some samples of a mechanism that is not run, as of poses, at some parameters; `between` makes a
    /// sample between two of them, where there is one.
    pub fn outputs_of(
        &self,
        parameters: &[f64],
        samples: &[Sample],
        between: &mut dyn FnMut(f64) -> Option<Sample>,
    ) -> Vec<f64> {
        let mut reducer = Reducer::new(&self.outputs, parameters);
        reducer.begin(&self.outputs, parameters);
        for sample in samples {
            reducer.take(&self.outputs, &self.channels, (sample, false), between);
        }
        let mut values = Vec::new();
        reducer.finish((&self.outputs, &self.channels), between, &mut values);
        values
    }

    /// Number of cases.
    pub fn n_cases(&self) -> u64 {
        self.request.plan.n_cases()
    }

    /// The cases.
    pub fn plan(&self) -> &Plan {
        &self.request.plan
    }

    /// Name of the model.
    pub fn model_name(&self) -> &str {
        &self.model_name
    }

    /// Text of the model.
    pub fn model_text(&self) -> &str {
        &self.request.model
    }

    /// Warnings about the model.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// The outputs of each run.
    pub fn outputs(&self) -> &[Output] {
        self.outputs.all()
    }

    /// The varied quantities, in SI; units are written as those of channels are.
    pub fn input_columns(&self) -> Vec<Column> {
        let axes = self.request.plan.axes().iter().zip(&self.inputs);
        let column = |(axis, input): (&Axis, &Input)| Column {
            name: axis.name.clone(),
            unit: input.column_unit(),
        };
        axes.map(column).collect()
    }

    /// The columns of the outputs.
    pub fn output_columns(&self) -> Vec<Column> {
        let column = |o: &Output| Column { name: o.name.clone(), unit: o.unit.clone() };
        self.outputs.all().iter().map(column).collect()
    }

    /// The values of a case as `bksim solve --set` takes them; `A.rate` and the like stand in the
    /// model's table of initial values.
    pub fn settings(&self, case: u64) -> Vec<(String, String)> {
        let axes = self.request.plan.axes();
        let mut numbers = vec![0.0; axes.len()];
        self.request.plan.case(case, &mut numbers);
        axes.iter().zip(numbers).map(|(axis, n)| (axis.name.clone(), axis.text(n))).collect()
    }

    /// The values of a case as a reader of the model takes them: initial values by their path, `initial.A.rate`.
    pub fn overrides(&self, case: u64) -> Vec<(String, String)> {
        let path = |(input, (name, value)): (&Input, (String, String))| match input.quantity {
            Quantity::Parameter => (name, value),
            Quantity::Initial(_) => (format!("initial.{name}"), value),
        };
        self.inputs.iter().zip(self.settings(case)).map(path).collect()
    }

    /// The plan in words.
    pub fn plan_text(&self) -> String {
        self.request.plan.describe()
    }

    /// The settings of the solution in words.
    pub fn options_text(&self) -> &str {
        &self.options_text
    }

    /// Equal for sweeps with equal rows: of model, values, outputs, settings and version.
    pub fn fingerprint(&self) -> String {
        let Request { model, name, limits, fixed, compliance, .. } = &self.request;
        let outputs: Vec<&str> = self.outputs.all().iter().map(|o| o.name.as_str()).collect();
        let plan = self.request.plan.describe();
        let all = format!(
            "{VERSION}\0{model}\0{name}\0{limits:?}\0{fixed:?}\0{compliance:?}\0{plan}\0{outputs:?}\0{}",
            self.options_text
        );
        hex(&Sha256::digest(all.as_bytes()))
    }

    /// How its rows lie in a table; the same one whenever it is asked for.
    pub(crate) fn layout(&self) -> Result<&Layout, ParquetError> {
        match self.layout.get() {
            Some(layout) => Ok(layout),
            None => Layout::new(self.input_columns(), &self.output_columns(), self.about())
                .map(|layout| self.layout.get_or_init(|| layout)),
        }
    }

    /// The metadata of its tables, but for the units of their columns.
    fn about(&self) -> Vec<KeyValue> {
        let Request { model, fixed, compliance, .. } = &self.request;
        let lines = |pairs: &[(String, String)]| {
            let lines = pairs.iter().map(|(name, value)| format!("{name}={value}"));
            lines.collect::<Vec<_>>().join("\n")
        };
        vec![
            entry("bksim.version", VERSION),
            entry("bksim.model_name", &self.model_name),
            entry("bksim.model_file", &self.request.file),
            entry("bksim.model_sha256", &hex(&Sha256::digest(model.as_bytes()))),
            entry("bksim.model", model),
            entry("bksim.set", &lines(fixed)),
            entry("bksim.compliance", &lines(compliance)),
            entry("bksim.plan", &self.plan_text()),
            entry("bksim.options", &self.options_text),
            entry("bksim.fingerprint", &self.fingerprint()),
            entry("unit.t_reached", "s"),
        ]
    }
}

/// The model at the first of some cases whose values it allows, with its warnings.
fn first_allowed(
    request: &Request,
    inputs: &[Input],
) -> Result<(Model, Recording, Vec<Diagnostic>), Rejected> {
    let n_cases = request.plan.n_cases();
    let mut numbers = vec![0.0; inputs.len()];
    let mut first = None;
    // From the middle outwards through the whole: bounds of what is allowed are met at the ends.
    let n_tried = n_cases.min(N_TRIED);
    for tried in 0..n_tried {
        let case = (n_cases / 2 + tried * (n_cases / n_tried)) % n_cases;
        request.plan.case(case, &mut numbers);
        let (Reading { model, diagnostics }, recording) =
            request.read_recorded(&overrides(&request.plan, inputs, &numbers));
        match model.zip(recording) {
            Some((model, recording)) => return Ok((model, recording, diagnostics)),
            None => first = first.or(Some(diagnostics)),
        }
    }
    Err(Rejected(first.expect("a plan has at least one case")))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a text cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
