//! The functions of a mechanism as C: everything that its equations need, with modes as parameters.

use std::fmt::Write;

use bksim_analysis::AnalysisError;
use bksim_expr::{Expr, Quantity, Signature, SymbolId, Tape};
use bksim_mbs::levels::constraint_velocity;
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{HeldChange, Model};
use bksim_sim::compiled::{Terms, terms};
use bksim_sim::formulate::acceleration_level;
use bksim_sim::{event_functions, pressing_symbols};

/// Symbols of a state, in the order of all functions.
pub(crate) struct Symbols {
    pub(crate) time: Vec<SymbolId>,
    pub(crate) q: Vec<SymbolId>,
    pub(crate) v: Vec<SymbolId>,
    pub(crate) a: Vec<SymbolId>,
    pub(crate) lambda: Vec<SymbolId>,
    /// Multipliers that loads depend on.
    pub(crate) pressing: Vec<SymbolId>,
    /// Parameters, then modes.
    pub(crate) parameters: Vec<SymbolId>,
    /// Parameters alone.
    pub(crate) own: Vec<SymbolId>,
}

impl Symbols {
    pub(crate) fn of(model: &Model, system: &SymbolicSystem) -> Self {
        let coordinates = system.coordinates();
        Self {
            time: vec![model.time],
            q: coordinates.iter().map(|c| c.q).collect(),
            v: coordinates.iter().map(|c| c.v).collect(),
            a: coordinates.iter().map(|c| c.a).collect(),
            lambda: system.constraints.iter().map(|c| c.lambda).collect(),
            pressing: pressing_symbols(model, system),
            parameters: system.parameters(model),
            own: model.parameters.iter().map(|p| p.symbol).collect(),
        }
    }
}

/// Functions written one after the other.
pub(crate) struct Writer<'m> {
    model: &'m Model,
    pub(crate) text: String,
}

impl<'m> Writer<'m> {
    pub(crate) fn new(model: &'m Model) -> Self {
        Self { model, text: String::new() }
    }

    /// Writes `bk_<name>` of groups of arguments and of parameters.
    pub(crate) fn write(
        &mut self,
        name: &str,
        outputs: &[Expr],
        arguments: &[&[SymbolId]],
        parameters: &[SymbolId],
    ) -> Result<(), AnalysisError> {
        let pool = &self.model.pool;
        let arguments = arguments.concat();
        if outputs.is_empty() {
            let _ = writeln!(
                self.text,
                "static void bk_{name}(const double *inputs, const double *parameters, double *outputs) {{\n    \
                 (void)inputs;\n    (void)parameters;\n    (void)outputs;\n}}\n"
            );
            return Ok(());
        }
        let tape = Tape::compile(pool, outputs, &arguments, parameters)?;
        let named = |symbols: &[SymbolId]| -> Vec<Quantity> {
            symbols.iter().map(|&symbol| Quantity::new(&pool.symbol_name(symbol), "")).collect()
        };
        let signature = Signature {
            name: format!("bk_{name}"),
            inputs: named(&arguments),
            parameters: named(parameters),
            outputs: vec![Quantity::new("", ""); outputs.len()],
        };
        let program = tape.program(&signature).expect("a name for every argument and output");
        self.text.push_str(&program.to_c_part());
        self.text.push('\n');
        Ok(())
    }

    /// The equations of motion, and the functions that decide the modes.
    pub(crate) fn equations(
        &mut self,
        system: &SymbolicSystem,
        symbols: &Symbols,
    ) -> Result<(), AnalysisError> {
        let model = self.model;
        let Symbols { time, q, v, a, lambda, pressing, parameters, .. } = symbols;
        let Terms { mass, jacobian, force, gamma } = terms(model, system);
        let closed: Vec<Expr> = system.constraints.iter().map(|c| c.expression).collect();
        let constraints = [jacobian.as_slice(), &closed, &system.constraint_rate].concat();
        let slopes: Vec<Expr> =
            force.iter().flat_map(|&f| model.pool.gradient(f, pressing)).collect();
        let all = [mass, jacobian, force, gamma].concat();
        let state: [&[SymbolId]; 4] = [time, q, v, pressing];
        self.write("terms", &all, &state, parameters)?;
        self.write("constraints", &constraints, &[time, q], parameters)?;
        self.write("slopes", &slopes, &state, parameters)?;
        if !(system.switches.is_empty() && system.contacts.is_empty()) {
            let [functions, rates] = event_functions(model, system);
            self.write("indicators", &functions, &[time, q, v, lambda], parameters)?;
            self.write("rates", &rates, &[time, q, v, a], parameters)?;
        }
        Ok(())
    }

    /// The change of the equations of motion along a change of t, q, v and `inputs`.
    pub(crate) fn change(
        &mut self,
        system: &SymbolicSystem,
        symbols: &Symbols,
        inputs: &[SymbolId],
    ) -> Result<(), AnalysisError> {
        let pool = &self.model.pool;
        let Symbols { time, q, v, a, lambda, parameters, .. } = symbols;
        let mut rows = acceleration_level(self.model, system);
        rows.extend((0..lambda.len()).map(|row| constraint_velocity(pool, system, row)));
        let changing = [time, q, v, inputs].concat();
        let (directions, along) = self.directions(&changing);
        let changes = pool.jvp(&rows, &changing, &along);
        self.write("change", &changes, &[time, q, v, a, lambda, &directions], parameters)
    }

    /// The change of `outputs` along a change of everything that they depend on.
    pub(crate) fn output_change(
        &mut self,
        outputs: &[Expr],
        symbols: &Symbols,
        inputs: &[SymbolId],
    ) -> Result<(), AnalysisError> {
        let Symbols { time, q, v, a, lambda, parameters, .. } = symbols;
        let changing = [time, q, v, a, lambda, inputs].concat();
        let (directions, along) = self.directions(&changing);
        let changes = self.model.pool.jvp(outputs, &changing, &along);
        self.write("output_change", &changes, &[time, q, v, a, lambda, &directions], parameters)
    }

    /// A symbol for the change of each of these.
    fn directions(&self, changing: &[SymbolId]) -> (Vec<SymbolId>, Vec<Expr>) {
        let pool = &self.model.pool;
        let fresh = |&symbol: &SymbolId| pool.symbol(&format!("'d_{}", pool.symbol_name(symbol)));
        let along: Vec<Expr> = changing.iter().map(fresh).collect();
        let ids = along.iter().map(|&e| pool.symbol_id(e).expect("a symbol was just made"));
        (ids.collect(), along)
    }

    /// Clocks, sampled and latched signals; returns tables of them.
    pub(crate) fn held(
        &mut self,
        system: &SymbolicSystem,
        symbols: &Symbols,
    ) -> Result<HeldTables, AnalysisError> {
        let model = self.model;
        let mut tables = HeldTables::default();
        if model.held.is_empty() {
            return Ok(tables);
        }
        let constants = model.clocks.iter().flat_map(|clock| [clock.start, clock.every]);
        let constants: Vec<Expr> = constants.chain(model.held.iter().map(|s| s.start)).collect();
        self.write("constants", &constants, &[], &symbols.own)?;
        let held: Vec<SymbolId> = model.held.iter().map(|s| s.held).collect();
        let previous: Vec<SymbolId> = model.held.iter().map(|s| s.previous).collect();
        let arguments: [&[SymbolId]; 5] = [&symbols.time, &symbols.q, &symbols.v, &held, &previous];
        let measures = signal_values(model, &system.kinematics);
        for (signal, of) in model.held.iter().enumerate() {
            match &of.change {
                HeldChange::Tick { clock, value } => {
                    let name = format!("sample{}", tables.sampled.len());
                    let value = model.pool.substitute(*value, &measures);
                    self.write(&name, &[value], &arguments, &symbols.own)?;
                    tables.sampled.push([signal, clock.0]);
                }
                HeldChange::Event { rows } => {
                    for row in rows {
                        let name = format!("latch{}", tables.latches.len());
                        let value = model.pool.substitute(row.value, &measures);
                        self.write(&name, &[value], &arguments, &symbols.own)?;
                        tables.latches.push(signal);
                    }
                }
                HeldChange::HalfTurn { .. } => (),
            }
        }
        if !tables.latches.is_empty() {
            self.write("conditions", &system.conditions, &[], &symbols.parameters)?;
        }
        Ok(tables)
    }
}

/// Signals that are held.
#[derive(Default)]
pub(crate) struct HeldTables {
    /// Signal and clock of each that is sampled, in the order of computation.
    pub(crate) sampled: Vec<[usize; 2]>,
    /// Signal of each row of latched ones.
    pub(crate) latches: Vec<usize>,
}
