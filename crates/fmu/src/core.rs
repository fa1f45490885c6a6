//! [`Core`]: a mechanism as functions and tables in C, of which the solver and the units are made.

use bksim_analysis::{AnalysisError, without_contacts};
use bksim_expr::{Expr, SymbolId};
use bksim_mbs::contact::Law;
use bksim_mbs::coordinate::{Coordinate, CoordinateKind};
use bksim_mbs::modes::with_modes_of_state;
use bksim_mbs::system::{SwitchOf, SymbolicSystem};
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_model::{Method, Model, Outputs};
use bksim_sim::input::check_inputs;
use bksim_sim::start::Start;
use bksim_sim::{Mechanism, Simulation};

use crate::codes;
use crate::functions::{HeldTables, Symbols, Writer};
use crate::shown::{Shown, states};
use crate::variable::{Variable, identifier};

/// The most coordinates and conditions together: matrices are full.
const MOST_UNKNOWNS: usize = 400;

/// Request for a solver or a unit.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Request {
    /// Parameters of loads that become inputs; those of `[io]` where there are none.
    pub inputs: Vec<String>,
    /// Outputs by name; those of `[io]` where there are none, and all positions and rates where it has none either.
    pub outputs: Vec<String>,
}

/// Quantities by which the motion is computed.
pub(crate) struct Sizes {
    pub(crate) nq: usize,
    pub(crate) nc: usize,
    /// Rows that always hold.
    pub(crate) n_bilateral: usize,
    /// Free coordinates.
    pub(crate) n_free: usize,
    pub(crate) n_own: usize,
    pub(crate) n_switches: usize,
    pub(crate) n_contacts: usize,
    pub(crate) n_held: usize,
    pub(crate) n_clocks: usize,
    pub(crate) n_pressing: usize,
    pub(crate) n_initial: usize,
}

/// Numbers that the tables of the C code hold.
pub(crate) struct Tables {
    pub(crate) mass: Vec<[usize; 2]>,
    pub(crate) jacobian: Vec<[usize; 2]>,
    pub(crate) timed: Vec<bool>,
    /// Row, place of the modes and whether it is friction, by contact.
    pub(crate) contacts: Vec<(usize, usize, bool)>,
    pub(crate) pressing_rows: Vec<usize>,
    /// 0 of a stated position, 1 of a stated rate.
    pub(crate) levels: Vec<usize>,
    pub(crate) held: HeldTables,
    /// Changes of the coordinates that are alike, rad or m.
    pub(crate) sizes: Vec<f64>,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) modes: Vec<f64>,
}

/// A mechanism as functions and tables in C.
pub struct Core {
    /// Name of the model.
    pub name: String,
    /// Name as an identifier of C.
    pub identifier: String,
    /// Values that can be set: inputs first, then parameters, then start values.
    pub values: Vec<Variable>,
    /// How many of them are inputs.
    pub n_inputs: usize,
    /// Parameters that follow from others, with their place.
    pub calculated: Vec<(usize, Variable)>,
    /// Everything that can be read, outputs first.
    pub outputs: Vec<Variable>,
    /// How many of them are outputs; the others are only shown.
    pub n_outputs: usize,
    /// The states: coordinates, their rates, then the rates of these.
    pub states: Vec<Variable>,
    /// Start and end of the run that the model asks for, s.
    pub experiment: [f64; 2],
    pub(crate) atol: f64,
    pub(crate) is_stiff: bool,
    pub(crate) sizes: Sizes,
    pub(crate) tables: Tables,
    pub(crate) functions: String,
    /// Functions that only units have.
    pub(crate) unit_functions: String,
    /// Instants with coordinates and velocities that bksim computes, for tests.
    pub(crate) expected: Vec<(f64, Vec<f64>, Vec<f64>)>,
}

impl Core {
    /// Derives and writes everything of `mechanism`.
    ///
    /// # Errors
    /// [`AnalysisError`] is the fault of a model without a start, of an input or output that there is not, or of a
    /// mechanism that is too large.
    pub fn of(mechanism: &mut Mechanism, request: &Request) -> Result<Self, AnalysisError> {
        let inputs = inputs_of(mechanism, request)?;
        without_contacts(&mechanism.model)?;
        forward(&mechanism.model)?;
        let start = mechanism.start()?;
        let mechanism = &*mechanism;
        let model = &mechanism.model;
        let system = &with_modes_of_state(&model.pool, &mechanism.system);
        too_large(model, system)?;
        let symbols = Symbols::of(model, system);
        let mut writer = Writer::new(model);
        writer.equations(system, &symbols)?;

        // Values that can be set, and all that follows from them.
        let settings = Settings::of(mechanism, &inputs);
        let input_symbols: Vec<SymbolId> = settings.symbols[..inputs.len()].to_vec();
        writer.write("definitions", &settings.all, &[&settings.symbols], &[])?;
        let initial = initial_rows(model, system, &symbols);
        writer.write(
            "initial",
            &initial.rows,
            &[&symbols.time, &symbols.q, &symbols.v],
            &symbols.parameters,
        )?;
        writer.change(system, &symbols, &input_symbols)?;
        let held = writer.held(system, &symbols)?;

        // Outputs, then what else can be read.
        let shown = Shown::of(model, system, &start, &request.outputs)?;
        let state: [&[SymbolId]; 5] =
            [&symbols.time, &symbols.q, &symbols.v, &symbols.a, &symbols.lambda];
        writer.write("outputs", &shown.expressions, &state, &symbols.parameters)?;
        let functions = std::mem::take(&mut writer.text);
        writer.output_change(&shown.expressions[..shown.n_outputs], &symbols, &input_symbols)?;

        let sizes = sizes(model, system, &start, &symbols, initial.levels.len());
        let tables = tables(mechanism, system, &start, &symbols, (initial.levels, held));
        let options = &model.solve;
        Ok(Self {
            name: model.name.clone(),
            identifier: identifier(&model.name),
            values: settings.variables,
            n_inputs: inputs.len(),
            calculated: settings.calculated,
            n_outputs: shown.n_outputs,
            outputs: shown.variables,
            states: states(model, system, sizes.n_free),
            experiment: [options.t_start, options.t_end],
            atol: options.atol,
            is_stiff: options.method == Method::Radau,
            expected: expected(mechanism, 1e-10),
            sizes,
            tables,
            functions,
            unit_functions: writer.text,
        })
    }
}

impl Core {
    /// Number of states of model exchange.
    pub fn n_states(&self) -> usize {
        2 * self.sizes.n_free
    }

    /// Number of event indicators.
    pub fn n_events(&self) -> usize {
        self.sizes.n_switches + self.sizes.n_contacts
    }
}

/// The parameters that are inputs, by their places.
fn inputs_of(mechanism: &mut Mechanism, request: &Request) -> Result<Vec<usize>, AnalysisError> {
    let model = &mut mechanism.model;
    let place = |name: &String| model.parameters.iter().position(|p| p.name == *name);
    let inputs: Vec<usize> = if request.inputs.is_empty() {
        // Of the inputs that the model states, efforts along measures are none of a unit.
        model.io.inputs.iter().filter_map(place).collect()
    } else {
        let found = request.inputs.iter().map(|name| {
            place(name).ok_or_else(|| AnalysisError::UnknownParameter { name: name.clone() })
        });
        found.collect::<Result<_, _>>()?
    };
    model.inputs = inputs.iter().map(|&idx| bksim_model::ParameterId(idx)).collect();
    let faults = check_inputs(model, &mechanism.system);
    model.inputs.clear();
    if faults.is_empty() { Ok(inputs) } else { Err(Rejected(faults).into()) }
}

/// Refuses a run backwards in time.
fn forward(model: &Model) -> Result<(), AnalysisError> {
    let options = &model.solve;
    if options.t_end >= options.t_start {
        return Ok(());
    }
    let span = options.spans.iter().find(|(key, _)| key == "t_end");
    let span = span.map_or(0..0, |(_, span)| span.clone());
    let message = format!(
        "a solver in C cannot go back in time: the run ends at {} s, before its start at {} s",
        options.t_end, options.t_start
    );
    let fault = Diagnostic::error(codes::BACKWARDS, message)
        .at(span, "lies before the start")
        .help(format!("let it end later: `t_end = \"{} s\"`", options.t_start + 1.0));
    Err(Rejected(vec![fault]).into())
}

/// Refuses what full matrices are too slow for.
fn too_large(model: &Model, system: &SymbolicSystem) -> Result<(), AnalysisError> {
    let n = system.coordinates().len() + system.constraints.len();
    if n <= MOST_UNKNOWNS {
        return Ok(());
    }
    let span = model.joints.first().map_or(0..0, |joint| joint.span.clone());
    let message = format!(
        "a solver in C for {n} coordinates and conditions would be too slow; the most are {MOST_UNKNOWNS}"
    );
    let fault = Diagnostic::error(codes::TOO_LARGE, message)
        .at(span, "the first of its joints")
        .note("its matrices are full, and each step solves with them")
        .help("export a part of the mechanism, or run the model with `bksim solve`");
    Err(Rejected(vec![fault]).into())
}

/// Values that can be set, and how parameters and stated starts follow from them.
struct Settings {
    variables: Vec<Variable>,
    symbols: Vec<SymbolId>,
    calculated: Vec<(usize, Variable)>,
    /// All parameters of the model, then all stated values.
    all: Vec<Expr>,
}

impl Settings {
    fn of(mechanism: &Mechanism, inputs: &[usize]) -> Self {
        let model = &mechanism.model;
        let pool = &model.pool;
        let (mut variables, mut symbols, mut calculated) = (Vec::new(), Vec::new(), Vec::new());
        for &idx in inputs {
            let p = &model.parameters[idx];
            let variable = Variable::new(&p.name, &p.unit, "input of the loads");
            variables.push(variable.starting_at(mechanism.parameters[idx]));
            symbols.push(p.symbol);
        }
        let mut known: Vec<(SymbolId, Expr)> = Vec::new();
        let mut all = Vec::new();
        for (idx, p) in model.parameters.iter().enumerate() {
            let is_number = pool.symbols_of(p.definition).is_empty();
            if !is_number && !inputs.contains(&idx) {
                let value = pool.substitute(p.definition, &known);
                let variable =
                    Variable::new(&p.name, &p.unit, "parameter that follows from others");
                calculated.push((idx, variable));
                known.push((p.symbol, value));
                all.push(value);
                continue;
            }
            all.push(pool.symbol_expr(p.symbol));
            if !inputs.contains(&idx) {
                let variable = Variable::new(&p.name, &p.unit, "parameter of the model");
                variables.push(variable.starting_at(mechanism.parameters[idx]));
                symbols.push(p.symbol);
            }
        }
        for initial in model.initial.iter().filter(|initial| !initial.is_guess) {
            let value = pool.substitute(initial.value, &known);
            let Ok(number) = pool.evaluate(value, &|_| None) else {
                all.push(value);
                continue;
            };
            let symbol = pool.symbol(&format!("'start {}", initial.name));
            symbols.push(pool.symbol_id(symbol).expect("a symbol was just made"));
            let name = format!("start.{}", initial.name);
            let unit = initial.unit(model);
            let variable = Variable::new(&name, unit, "stated value of the start");
            variables.push(variable.starting_at(number));
            all.push(symbol);
        }
        Self { variables, symbols, calculated, all }
    }
}

/// The stated values of the start as rows with their slopes.
struct InitialRows {
    rows: Vec<Expr>,
    levels: Vec<usize>,
}

fn initial_rows(model: &Model, system: &SymbolicSystem, symbols: &Symbols) -> InitialRows {
    let pool = &model.pool;
    let (mut rows, mut levels) = (Vec::new(), Vec::new());
    for initial in model.initial.iter().filter(|initial| !initial.is_guess) {
        let measure = system.kinematics.measure(model, initial.measure);
        let used = pool.symbols_of(measure);
        let is_rate = symbols.v.iter().any(|v| used.contains(v));
        rows.push(measure);
        rows.extend(pool.gradient(measure, if is_rate { &symbols.v } else { &symbols.q }));
        levels.push(usize::from(is_rate));
    }
    InitialRows { rows, levels }
}

fn sizes(
    model: &Model,
    system: &SymbolicSystem,
    start: &Start,
    symbols: &Symbols,
    n_initial: usize,
) -> Sizes {
    let (nq, n_bilateral) = (symbols.q.len(), system.n_bilateral());
    let redundant = start.redundant_rows().iter().filter(|&&row| row < n_bilateral).count();
    Sizes {
        nq,
        nc: symbols.lambda.len(),
        n_bilateral,
        n_free: nq + redundant - n_bilateral,
        n_own: symbols.own.len(),
        n_switches: system.switches.len(),
        n_contacts: system.contacts.len(),
        n_held: model.held.len(),
        n_clocks: model.clocks.len(),
        n_pressing: symbols.pressing.len(),
        n_initial,
    }
}

fn tables(
    mechanism: &Mechanism,
    system: &SymbolicSystem,
    start: &Start,
    symbols: &Symbols,
    (levels, held): (Vec<usize>, HeldTables),
) -> Tables {
    let (n_own, n_switches) = (symbols.own.len(), system.switches.len());
    let mut at = n_own + n_switches;
    let contacts = system.contacts.iter().map(|contact| {
        let is_friction = matches!(contact.law, Law::Friction { .. });
        let place = at;
        at += if is_friction { 3 } else { 1 };
        (contact.row, place, is_friction)
    });
    let contacts = contacts.collect();
    // Signs as at the start; contacts open, nothing held: the start decides them.
    let at_start = start.parameters_with_modes(&mechanism.parameters).split_off(n_own);
    let signs = mechanism.system.switches.iter().zip(at_start);
    let signs = signs.filter(|(known, _)| known.of != SwitchOf::Multipliers).map(|(_, sign)| sign);
    let mut modes: Vec<f64> = signs.collect();
    modes.resize(system.parameters(&mechanism.model).len() - n_own, 0.0);
    let size = |c: &Coordinate| match c.kind {
        CoordinateKind::Length if start.longest_link > 0.0 => start.longest_link,
        _ => 1.0,
    };
    let row_of = |lambda: &SymbolId| {
        let mut rows = system.constraints.iter();
        rows.position(|row| row.lambda == *lambda).expect("a multiplier of the system")
    };
    Tables {
        mass: system.mass_matrix.lower().map(|(i, j, _)| [i, j]).collect(),
        jacobian: system.constraint_jacobian.entries().map(|(i, j, _)| [i, j]).collect(),
        timed: system.switches.iter().map(|switch| switch.of == SwitchOf::Time).collect(),
        contacts,
        pressing_rows: symbols.pressing.iter().map(row_of).collect(),
        levels,
        held,
        sizes: system.coordinates().iter().map(size).collect(),
        q: start.q.clone(),
        v: start.v.clone(),
        modes,
    }
}

/// States that bksim computes with a tight tolerance, soon after the start.
pub(crate) fn expected(mechanism: &Mechanism, tolerance: f64) -> Vec<(f64, Vec<f64>, Vec<f64>)> {
    const LONGEST_S: f64 = 0.5;
    let options = &mechanism.model.solve;
    let duration = (options.t_end - options.t_start).min(LONGEST_S);
    if duration.is_nan() || duration <= 0.0 {
        return Vec::new();
    }
    let times: Vec<f64> =
        [0.23, 0.57, 0.91].iter().map(|part| options.t_start + part * duration).collect();
    let run = || {
        let mut simulation = Simulation::of(mechanism).ok()?;
        let mut tight = options.clone();
        (tight.rtol, tight.atol) = (tolerance, tolerance);
        tight.step = None;
        tight.t_end = options.t_start + duration;
        tight.outputs = Outputs::Times(times.clone());
        simulation.set_options(&tight);
        simulation.solve().ok()
    };
    let Some(motion) = run() else { return Vec::new() };
    let samples = motion.samples.into_iter().filter(|sample| times.contains(&sample.t));
    samples.map(|sample| (sample.t, sample.q, sample.v)).collect()
}
