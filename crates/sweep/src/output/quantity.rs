//! Quantities over time: expressions of signals, of what the model can name, of parameters and of the time.

use bksim::Mechanism;
use bksim::expr::{Expr, Pool, SymbolId, Tape, Workspace};
use bksim::model::diagnostic::Diagnostic;
use bksim::model::{JointId, Measure};
use bksim::record::{Channels, Signal};
use bksim::sim::observable::Observables;
use bksim::sim::run::Sample;

use crate::codes;

/// Where the value of a symbol comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Origin {
    Time,
    Signal(Signal),
    Measure(Measure),
}

/// The symbols of quantities, and where their values come from.
#[derive(Clone, Debug)]
pub(super) struct Names {
    origins: Vec<(SymbolId, Origin)>,
    /// By parameter of the model.
    parameters: Vec<SymbolId>,
}

impl Names {
    /// The parameters of a model.
    pub(super) fn of_parameters(parameters: Vec<SymbolId>) -> Self {
        Self { origins: Vec::new(), parameters }
    }

    pub(super) fn parameter_symbols(&self) -> Vec<SymbolId> {
        self.parameters.clone()
    }

    /// The symbols of what varies over time; true of the time itself.
    pub(super) fn over_time(&self) -> impl Iterator<Item = (SymbolId, bool)> {
        self.origins.iter().map(|&(symbol, origin)| (symbol, origin == Origin::Time))
    }

    /// A symbol that stands for this.
    pub(super) fn add(&mut self, symbol: SymbolId, origin: Origin) {
        if !self.origins.iter().any(|(known, _)| *known == symbol) {
            self.origins.push((symbol, origin));
        }
    }
}

/// Quantities at samples, with their buffers.
#[derive(Clone, Debug)]
pub(super) struct Quantities {
    origins: Vec<Origin>,
    /// Observables; `None` where no quantity has one.
    observables: Option<Observables>,
    observed: Vec<f64>,
    tape: Tape,
    workspace: Workspace,
    arguments: Vec<f64>,
    values: Vec<f64>,
}

impl Quantities {
    /// Compiles quantities.
    pub(super) fn compile(
        pool: &Pool,
        quantities: &[Expr],
        names: Names,
        mechanism: &Mechanism,
    ) -> Result<Self, Diagnostic> {
        let Names { origins, parameters } = names;
        let symbols: Vec<SymbolId> = origins.iter().map(|&(symbol, _)| symbol).collect();
        let tape = super::compile(pool, quantities, &symbols, &parameters)?;
        let observed: Vec<Measure> = origins.iter().filter_map(measure).collect();
        let (model, values) = (&mechanism.model, &mechanism.parameters);
        let observables = if observed.is_empty() {
            None
        } else {
            let compiled = Observables::compile(model, &mechanism.system, &observed, values);
            Some(
                compiled
                    .map_err(|error| Diagnostic::error(codes::UNKNOWN_OUTPUT, error.to_string()))?,
            )
        };
        Ok(Self {
            workspace: tape.workspace(values),
            arguments: vec![0.0; origins.len()],
            values: vec![0.0; quantities.len()],
            observed: vec![0.0; observed.len()],
            origins: origins.into_iter().map(|(_, origin)| origin).collect(),
            observables,
            tape,
        })
    }

    /// Sets the values of the parameters.
    pub(super) fn set_parameters(&mut self, parameters: &[f64]) {
        self.workspace = self.tape.workspace(parameters);
        if let Some(observables) = &mut self.observables {
            observables.set_parameters(parameters);
        }
    }

    /// The quantities at a sample.
    pub(super) fn at(&mut self, channels: &Channels, sample: &Sample) -> &[f64] {
        self.take_arguments(channels, sample);
        self.tape.evaluate(&mut self.workspace, &self.arguments, &mut self.values);
        &self.values
    }

    /// The quantities of arguments that were taken before.
    pub(super) fn of_arguments(&mut self, arguments: &[f64]) -> &[f64] {
        self.tape.evaluate(&mut self.workspace, arguments, &mut self.values);
        &self.values
    }

    /// Arguments of the quantities at a sample.
    pub(super) fn arguments(&mut self, channels: &Channels, sample: &Sample) -> &[f64] {
        self.take_arguments(channels, sample);
        &self.arguments
    }

    fn take_arguments(&mut self, channels: &Channels, sample: &Sample) {
        if let Some(observables) = &mut self.observables {
            let reaction = |joint: JointId| sample.reactions[joint.0];
            observables.at(
                [&sample.q, &sample.v, &sample.a, &sample.lambda],
                &reaction,
                &mut self.observed,
            );
        }
        let mut observed = self.observed.iter();
        for (argument, origin) in self.arguments.iter_mut().zip(&self.origins) {
            *argument = match *origin {
                Origin::Time => sample.t,
                Origin::Signal(signal) => channels.value(signal, sample),
                Origin::Measure(_) => *observed.next().expect("one value for each measure"),
            };
        }
    }
}

fn measure(&(_, origin): &(SymbolId, Origin)) -> Option<Measure> {
    if let Origin::Measure(measure) = origin { Some(measure) } else { None }
}
