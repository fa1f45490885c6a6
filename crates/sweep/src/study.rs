//! What all cases of a sweep share: the plan, and the equations derived and compiled once.

use std::fmt::Write as _;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, Reading, Recording, Source, WrittenUnit, read_recorded, suggest};
use bksim::model::{Measure, Model, Outputs, SolveOptions};
use bksim::record::Channels;
use bksim::sim::compiled::CompiledSystem;
use bksim::sim::formulate::MotionEquations;
use bksim::sim::start::StartEquations;
use bksim::{Mechanism, Rejected, SolveChanges, VERSION};
use sha2::{Digest, Sha256};

use crate::axis::Axis;
use crate::codes;
use crate::output::{Output, Take};
use crate::parquet::Layout;
use crate::plan::Plan;

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// Text of the model.
    pub model: String,
    /// Name of the model unless the text states one.
    pub name: String,
    /// Limits that protect against hostile models.
    pub limits: Limits,
    /// Parameters with one other value, as for [`Source::overrides`].
    pub fixed: Vec<(String, String)>,
    /// The cases.
    pub plan: Plan,
    /// What is kept of each run, as for [`Output::parse`]; nothing for [`Output::defaults`].
    pub outputs: Vec<String>,
    /// Settings of the solution.
    pub changes: SolveChanges,
}

impl Request {
    /// A model and its cases; the rest as the model says.
    pub fn new(model: &str, name: &str, plan: Plan) -> Self {
        Self {
            model: model.to_owned(),
            name: name.to_owned(),
            limits: Limits::default(),
            fixed: Vec::new(),
            plan,
            outputs: Vec::new(),
            changes: SolveChanges::default(),
        }
    }
}

/// A sweep ready to run: equations derived and compiled, outputs found, shared by all threads.
#[derive(Debug)]
pub struct Study {
    pub(crate) request: Request,
    /// By axis.
    pub(crate) inputs: Vec<Input>,
    pub(crate) outputs: Vec<Output>,
    pub(crate) channels: Channels,
    pub(crate) shared: Compiled,
    /// How parameters and settings of a case follow from its values.
    pub(crate) recording: Recording,
    pub(crate) n_parameters: usize,
    /// Settings as the model has them, and as cases do where no axis changes them.
    pub(crate) solve: SolveOptions,
    pub(crate) options: SolveOptions,
    /// Its expressions cannot be shared; only faults are explained with them.
    mechanism: Mutex<Mechanism>,
    model_name: String,
    warnings: Vec<Diagnostic>,
    options_text: String,
    pub(crate) layout: OnceLock<Layout>,
}

/// The functions of a mechanism that a case needs.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    pub(crate) system: Arc<CompiledSystem>,
    pub(crate) equations: MotionEquations,
    pub(crate) start: StartEquations,
}

impl Compiled {
    pub(crate) fn of(mechanism: &Mechanism) -> Result<Self, Rejected> {
        let (equations, start) = (mechanism.formulate()?, mechanism.start_equations()?);
        Ok(Self { system: mechanism.compiled.clone(), equations, start })
    }
}

/// What an axis is of.
#[derive(Clone, Debug)]
pub(crate) struct Input {
    pub(crate) of: Of,
    /// From its numbers to SI; `None` for numbers without unit.
    unit: Option<WrittenUnit>,
    /// SI unit.
    si: String,
}

/// A varied quantity, by its place in the model.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Of {
    Parameter,
    Initial(usize),
}

impl Input {
    /// A number of the axis in SI.
    pub(crate) fn to_si(&self, number: f64) -> f64 {
        self.unit.map_or(number, |unit| unit.to_si(number))
    }
}

/// A column of numbers.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// SI unit of its values, empty for none.
    pub unit: String,
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
        let own = request.read(&[]).map_err(Rejected)?;
        let inputs = inputs(&request, &own).map_err(|fault| Rejected(vec![fault]))?;
        let (mut model, recording, warnings) = base(&request, &inputs)?;
        let solve = SolveOptions { spans: Vec::new(), ..model.solve.clone() };
        request.changes.check(solve.t_start).map_err(|bad| {
            let help = format!("give `{}` a value {}", bad.option, bad.range);
            Rejected(vec![Diagnostic::error(codes::BAD_OPTION, bad.to_string()).help(help)])
        })?;
        request.changes.apply(&mut model.solve);
        let model_name = model.name.clone();
        let mechanism = Mechanism::derive(model, Vec::new())?;
        let channels = Channels::new(&mechanism);
        let outputs: Result<Vec<Output>, Diagnostic> =
            request.outputs.iter().map(|text| Output::parse(text, &channels)).collect();
        let mut outputs = outputs.map_err(|fault| Rejected(vec![fault]))?;
        if outputs.is_empty() {
            outputs = Output::defaults(&mechanism, &channels);
        }
        check_times(&outputs, &mechanism.model.solve).map_err(|fault| Rejected(vec![fault]))?;
        let shared = Compiled::of(&mechanism)?;
        let mut study = Self {
            request,
            inputs,
            outputs,
            channels,
            shared,
            recording,
            n_parameters: mechanism.parameters.len(),
            options: solve.clone(),
            solve,
            mechanism: Mutex::new(mechanism),
            model_name,
            warnings,
            options_text: String::new(),
            layout: OnceLock::new(),
        };
        study.request.changes.apply(&mut study.options);
        study.options_text = format!("{:?}", study.options);
        let mut options = study.options.clone();
        study.sample_for_outputs(&mut options);
        study.options = options;
        Ok(study)
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

    /// What is kept of each run.
    pub fn outputs(&self) -> &[Output] {
        &self.outputs
    }

    /// The varied quantities, in SI; units are written as those of channels are.
    pub fn input_columns(&self) -> Vec<Column> {
        let axes = self.request.plan.axes().iter().zip(&self.inputs);
        let column = |(axis, input): (&Axis, &Input)| Column {
            name: axis.name.clone(),
            unit: input.si.replace(' ', "*"),
        };
        axes.map(column).collect()
    }

    /// What is kept of each run.
    pub fn output_columns(&self) -> Vec<Column> {
        let column = |o: &Output| Column { name: o.name.clone(), unit: o.unit.clone() };
        self.outputs.iter().map(column).collect()
    }

    /// The values of a case as `bksim solve --set` takes them; `A.rate` and the like stand in the
    /// model's table of initial values.
    pub fn settings(&self, case: u64) -> Vec<(String, String)> {
        let axes = self.request.plan.axes();
        let mut numbers = vec![0.0; axes.len()];
        self.request.plan.case(case, &mut numbers);
        axes.iter().zip(numbers).map(|(axis, n)| (axis.name.clone(), axis.text(n))).collect()
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
        let Request { model, name, limits, fixed, .. } = &self.request;
        let outputs: Vec<&str> = self.outputs.iter().map(|o| o.name.as_str()).collect();
        let plan = self.request.plan.describe();
        let all = format!(
            "{VERSION}\0{model}\0{name}\0{limits:?}\0{fixed:?}\0{plan}\0{outputs:?}\0{}",
            self.options_text
        );
        hex(&Sha256::digest(all.as_bytes()))
    }

    /// Explains something with the model at these values.
    pub(crate) fn explain(
        &self,
        parameters: &[f64],
        options: &SolveOptions,
        explain: &dyn Fn(&Mechanism) -> Diagnostic,
    ) -> Diagnostic {
        let mut mechanism = self.mechanism.lock().unwrap_or_else(PoisonError::into_inner);
        mechanism.parameters.copy_from_slice(parameters);
        for (known, value) in mechanism.model.parameters.iter_mut().zip(parameters) {
            known.value = *value;
        }
        mechanism.model.solve.clone_from(options);
        explain(&mechanism)
    }

    /// When samples are needed for the outputs.
    pub(crate) fn sample_for_outputs(&self, options: &mut SolveOptions) {
        let takes = || self.outputs.iter().map(|output| output.take);
        let mut times: Vec<f64> = takes()
            .filter_map(|take| if let Take::At(t) = take { Some(t) } else { None })
            .collect();
        let needs_all = takes().any(|take| !matches!(take, Take::At(_) | Take::Final));
        match &options.outputs {
            _ if !needs_all => (),
            _ if times.is_empty() => return,
            Outputs::Even => times.extend(even_times(options)),
            Outputs::Times(stated) => times.extend(stated),
            Outputs::Steps => return,
        }
        options.outputs = Outputs::Times(times);
    }
}

impl Request {
    /// Reads the model with these parameters set, too.
    pub(crate) fn read(&self, set: &[(String, String)]) -> Result<Model, Vec<Diagnostic>> {
        let (Reading { model, diagnostics }, _) = self.reading(set);
        model.ok_or(diagnostics)
    }

    fn reading(&self, set: &[(String, String)]) -> (Reading, Option<Recording>) {
        let overrides = [self.fixed.as_slice(), set].concat();
        let (text, name, limits) = (&self.model, &self.name, self.limits);
        let varied: Vec<String> = set.iter().map(|(name, _)| name.clone()).collect();
        read_recorded(&Source { text, name, overrides: &overrides, limits }, &varied)
    }

    /// The parameters that a case sets.
    pub(crate) fn overrides(&self, inputs: &[Input], numbers: &[f64]) -> Vec<(String, String)> {
        let axes = self.plan.axes().iter().zip(inputs).zip(numbers);
        let parameters = axes.filter(|((_, input), _)| input.of == Of::Parameter);
        parameters.map(|((axis, _), &number)| (axis.name.clone(), axis.text(number))).collect()
    }
}

/// The model at the first of some cases whose values it allows, with its warnings.
fn base(
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
            request.reading(&request.overrides(inputs, &numbers));
        match model.zip(recording) {
            Some((model, recording)) => return Ok((model, recording, diagnostics)),
            None => first = first.or(Some(diagnostics)),
        }
    }
    Err(Rejected(first.unwrap_or_default()))
}

/// What the axes are of.
fn inputs(request: &Request, model: &Model) -> Result<Vec<Input>, Diagnostic> {
    request.plan.axes().iter().map(|axis| input(request, model, axis)).collect()
}

fn input(request: &Request, model: &Model, axis: &Axis) -> Result<Input, Diagnostic> {
    let Axis { name, unit, .. } = axis;
    if request.fixed.iter().any(|(fixed, _)| fixed == name) {
        let message = format!("`{name}` is both given one value and varied");
        return Err(Diagnostic::error(codes::AXIS_TWICE, message).help("leave out one of the two"));
    }
    let written = WrittenUnit::parse(unit);
    if let Some(parameter) = model.parameters.iter().find(|p| p.name == *name) {
        // Numbers without unit are in units of the file; without any these are SI.
        let own = if request.model.contains("units") { "" } else { parameter.unit.as_str() };
        let si = written.map_or_else(|| own.to_owned(), |unit| unit.si());
        return Ok(Input { of: Of::Parameter, unit: written, si });
    }
    let Some(initial_idx) = model.initial.iter().position(|i| i.name == *name) else {
        let parameters = model.parameters.iter().map(|p| p.name.as_str());
        let known: Vec<&str> =
            parameters.chain(model.initial.iter().map(|i| i.name.as_str())).collect();
        let message = format!("the model has no parameter or stated initial value `{name}`");
        let fault = Diagnostic::error(codes::UNKNOWN_AXIS, message);
        return Err(fault.help(suggest(name, &known)));
    };
    let si = unit_of(model, model.initial[initial_idx].measure);
    if written.is_none_or(|written| written.si() != si) {
        let message = format!("the axis `{name}` needs a unit of the kind {si}");
        let help = format!("write it behind the numbers: `{name}=0:1 {si}:11`");
        return Err(Diagnostic::error(codes::BAD_AXIS, message).help(help));
    }
    Ok(Input { of: Of::Initial(initial_idx), unit: written, si: si.to_owned() })
}

/// SI unit of a parameter or stated initial value, for an [`Axis`] with numbers in SI; `None` when
/// nothing has this name.
pub fn si_unit(model: &Model, name: &str) -> Option<String> {
    let parameter = model.parameters.iter().find(|p| p.name == name);
    let initial = || model.initial.iter().find(|i| i.name == name);
    let of_initial = || Some(unit_of(model, initial()?.measure).to_owned());
    let unit = parameter.map(|parameter| parameter.unit.clone()).or_else(of_initial)?;
    // `1/s` would be read as a number: written, it is rad/s.
    Some(unit.strip_prefix("1/").map_or(unit.clone(), |rest| format!("rad/{rest}")))
}

/// SI unit of something of the motion, as written units have it.
fn unit_of(model: &Model, measure: Measure) -> &'static str {
    use bksim::mbs::joint::motions;
    use bksim::model::MotionKind;
    let kind = |joint: bksim::model::JointId, motion_idx: usize| {
        motions(&model.pool, &model.joints[joint.0]).get(motion_idx).map(|motion| motion.kind)
    };
    match measure {
        Measure::JointPosition(joint, idx) if kind(joint, idx) == Some(MotionKind::Rotation) => {
            "rad"
        }
        Measure::JointVelocity(joint, idx) if kind(joint, idx) == Some(MotionKind::Rotation) => {
            "1/s"
        }
        Measure::BodyAngle(_) => "rad",
        Measure::BodyRate(_) => "1/s",
        Measure::JointPosition(..) | Measure::PointPosition(..) => "m",
        Measure::JointVelocity(..) | Measure::PointVelocity(..) => "m/s",
    }
}

/// Times of outputs that no run has.
fn check_times(outputs: &[Output], solve: &SolveOptions) -> Result<(), Diagnostic> {
    for output in outputs {
        let Take::At(t) = output.take else { continue };
        let message = format!("`{}` asks for a time without sample", output.name);
        let fault = Diagnostic::error(codes::UNKNOWN_OUTPUT, message);
        let span = (solve.t_start.min(solve.t_end), solve.t_start.max(solve.t_end));
        if t < span.0 || t > span.1 {
            let help = format!("runs go from {} s to {} s", solve.t_start, solve.t_end);
            return Err(fault.help(help));
        }
        let is_instant = |o: &Output| matches!(o.take, Take::At(_) | Take::Final);
        if solve.outputs == Outputs::Steps && !outputs.iter().all(is_instant) {
            let help = "the model samples at steps: say `--every` for even samples";
            return Err(fault.help(help));
        }
    }
    Ok(())
}

/// The times of even outputs between start and end.
fn even_times(options: &SolveOptions) -> impl Iterator<Item = f64> {
    let (t_start, t_end, every) = (options.t_start, options.t_end, options.interval());
    let forward = (t_end - t_start).signum();
    #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
    let grid = (1u64..).map(move |idx| t_start + forward * every * idx as f64);
    // As a run takes them: a time that rounds onto the end is the end.
    grid.take_while(move |grid| (t_end - grid) * forward >= 1e-9 * every)
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a text cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
