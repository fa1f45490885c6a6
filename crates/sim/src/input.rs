//! Inputs: parameters that are functions of time and state while a run goes on, such as what a
//! controller commands.
//!
//! Any parameter can be one that nothing but forces, torques and dampers depend on. The equations are
//! derived as for a number; compiled, it is one more argument. All that is known of a law is its values, so
//! that Jacobians take ∂u/∂q and ∂u/∂v from differences.

use std::fmt;
use std::sync::Arc;

use bksim_expr::{Expr, SymbolId};

use crate::codes;
use bksim_mbs::contact::Law as ContactLaw;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Model, ParameterId};

/// Writes the values of the inputs, SI, at a time, s, and a state: `law(t, q, v, values)`. What is NaN
/// has no value there: a run makes smaller steps, and ends where that does not help.
pub type Law = dyn Fn(f64, &[f64], &[f64], &mut [f64]) + Send + Sync;

/// The inputs of a mechanism: which parameters they are, and the law that gives their values.
#[derive(Clone, Default)]
pub struct Inputs {
    ids: Vec<ParameterId>,
    law: Option<Arc<Law>>,
}

/// Nothing is called so among the parameters of the model.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no parameter is called `{0}`")]
pub struct UnknownInput(pub String);

/// Why an input cannot be set.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// Nothing is called so.
    #[error(transparent)]
    Unknown(#[from] UnknownInput),
    /// More than the loads depends on it.
    #[error("{}", .0.message)]
    NotOnlyLoads(Box<Diagnostic>),
    /// Input whose values come from a law.
    #[error("`{0}` follows a law: give it to the run or set it, not both")]
    HasLaw(String),
    /// It is not a number.
    #[error("the input `{name}` must be a number, not {value}")]
    NotFinite {
        /// The input.
        name: String,
        /// The value that was asked for.
        value: f64,
    },
}

impl fmt::Debug for Inputs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Inputs").field("ids", &self.ids).finish_non_exhaustive()
    }
}

/// The parameters of these names, for [`Model::inputs`].
///
/// # Errors
/// [`UnknownInput`] names one that the model has not.
pub fn find_inputs(model: &Model, names: &[&str]) -> Result<Vec<ParameterId>, UnknownInput> {
    let find = |&name: &&str| {
        let parameter_idx = model.parameters.iter().position(|p| p.name == name);
        parameter_idx.map(ParameterId).ok_or_else(|| UnknownInput(name.to_owned()))
    };
    names.iter().map(find).collect()
}

/// Faults of a model in which more than the loads depends on an input, one for each such input.
pub fn check_inputs(model: &Model, system: &SymbolicSystem) -> Vec<Diagnostic> {
    let uses = |symbol: SymbolId, parts: &[Expr]| {
        parts.iter().any(|&part| model.pool.depends_on(part, symbol))
    };
    let fault = |&ParameterId(idx): &ParameterId| {
        let parameter = &model.parameters[idx];
        let name = &parameter.name;
        let parts = parts(model, system);
        let (what, _) = parts.iter().find(|(_, parts)| uses(parameter.symbol, parts))?;
        let message =
            format!("`{name}` cannot be an input: {what} depends on it, not the loads alone");
        Some(
            Diagnostic::error(codes::INPUT_ELSEWHERE, message)
                .at(parameter.span.clone(), "a number that must stay as it is")
                .help(
                    "write a parameter of its own for the input, and use it in forces, \
                         torques and dampers only",
                ),
        )
    };
    model.inputs.iter().filter_map(fault).collect()
}

impl Inputs {
    /// The inputs of a model, which have no values until a law is given.
    pub(crate) fn of(model: &Model) -> Self {
        Self { ids: model.inputs.clone(), law: None }
    }

    /// Takes values from `law`.
    pub(crate) fn follow(&mut self, law: Arc<Law>) {
        self.law = Some(law);
    }

    pub(crate) fn ids(&self) -> &[ParameterId] {
        &self.ids
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }
}

/// Symbols of the inputs of a model.
pub(crate) fn input_symbols(model: &Model) -> Vec<SymbolId> {
    model.inputs.iter().map(|&ParameterId(idx)| model.parameters[idx].symbol).collect()
}

/// Parameters of functions that are compiled with the inputs as arguments: symbols that occur nowhere stand
/// for the inputs, so that every other parameter keeps its position.
pub(crate) fn without_inputs(model: &Model, mut parameters: Vec<SymbolId>) -> Vec<SymbolId> {
    for &ParameterId(idx) in &model.inputs {
        let vacant = model.pool.symbol(&format!("'vacant{idx}"));
        parameters[idx] = model.pool.symbol_id(vacant).expect("a symbol was just made");
    }
    parameters
}

/// Parts that must not change with an input, with a name for messages.
fn parts(model: &Model, system: &SymbolicSystem) -> Vec<(String, Vec<Expr>)> {
    let shared = [
        ("the kinetic energy", vec![system.kinetic_energy]),
        ("the potential energy", vec![system.potential_energy]),
        ("a constraint", system.constraints.iter().map(|c| c.expression).collect()),
        (
            "where a force acts",
            system.wrenches.iter().flat_map(|wrench| wrench.at).collect::<Vec<_>>(),
        ),
        ("a switch (`if`, `abs`, `min`, `max`, `sign`)", {
            system.switches.iter().map(|switch| switch.function).collect()
        }),
        ("a stop or dry friction", {
            let law = |law: ContactLaw| match law {
                ContactLaw::Stop { restitution, .. } => vec![restitution],
                ContactLaw::Friction { sliding, sticking, .. } => vec![sliding, sticking],
            };
            system.contacts.iter().flat_map(|contact| law(contact.law)).collect()
        }),
        ("a condition of a latched signal", system.conditions.clone()),
        ("a clock, or where a signal that is held starts", {
            let clocks = model.clocks.iter().flat_map(|clock| [clock.start, clock.every]);
            clocks.chain(model.held.iter().map(|signal| signal.start)).collect()
        }),
        ("the start", model.initial.iter().map(|initial| initial.value).collect()),
    ];
    let named = shared.into_iter().map(|(what, parts)| (what.to_owned(), parts));
    let of_parameter = model.parameters.iter().map(|parameter| {
        (format!("the parameter `{}`", parameter.name), vec![parameter.definition])
    });
    named.chain(of_parameter).collect()
}

/// A law that follows samples, with straight lines between them: `values` has a row of numbers for each of
/// `times`, which rise or fall.
pub fn along(times: Vec<f64>, values: Vec<f64>) -> Arc<Law> {
    let n = values.len().checked_div(times.len()).unwrap_or(0);
    let forward = if times.last() < times.first() { -1.0 } else { 1.0 };
    Arc::new(move |t, _, _, out| {
        let row = |k: usize| &values[k * n..(k + 1) * n];
        let next = times.partition_point(|&sample| (sample - t) * forward < 0.0);
        let Some(last) = times.len().checked_sub(1) else {
            out.fill(f64::NAN);
            return;
        };
        let (before, next) = (next.saturating_sub(1), next.min(last));
        let width = times[next] - times[before];
        let share = if width == 0.0 { 0.0 } else { (t - times[before]) / width };
        for ((out, a), b) in out.iter_mut().zip(row(before)).zip(row(next)) {
            *out = a + share.clamp(0.0, 1.0) * (b - a);
        }
    })
}

/// The values of inputs along a run: those of one state are asked for once.
#[derive(Clone, Debug)]
pub(crate) struct InputValues {
    inputs: Inputs,
    /// t, q and v that the values are for.
    state: Vec<f64>,
    values: Vec<f64>,
    /// A neighbouring state, and its values.
    neighbour: [Vec<f64>; 2],
    slopes: Vec<f64>,
}

impl InputValues {
    pub(crate) fn new(inputs: &Inputs) -> Self {
        let values = vec![0.0; inputs.ids.len()];
        Self {
            inputs: inputs.clone(),
            state: Vec::new(),
            neighbour: [Vec::new(), values.clone()],
            slopes: Vec::new(),
            values,
        }
    }

    /// The values at a state.
    pub(crate) fn at(&mut self, t: f64, q: &[f64], v: &[f64]) -> &[f64] {
        let Some(law) = &self.inputs.law else { return &[] };
        let state = || std::iter::once(&t).chain(q).chain(v);
        if !self.state.iter().eq(state()) {
            self.state.clear();
            self.state.extend(state());
            law(t, q, v, &mut self.values);
        }
        &self.values
    }

    /// The values at a state, then ∂u/∂q and ∂u/∂v, a row for each input, by forward differences.
    pub(crate) fn with_slopes(&mut self, t: f64, q: &[f64], v: &[f64]) -> [&[f64]; 2] {
        self.at(t, q, v);
        let Some(law) = &self.inputs.law else { return [&[], &[]] };
        let [state, values] = &mut self.neighbour;
        state.clear();
        state.extend(q.iter().chain(v));
        let n = state.len();
        self.slopes.resize(values.len() * n, 0.0);
        for i in 0..n {
            let own = state[i];
            state[i] += f64::EPSILON.sqrt() * own.abs().max(1.0);
            let width = state[i] - own;
            let (q, v) = state.split_at(q.len());
            law(t, q, v, values);
            state[i] = own;
            for (k, (value, own)) in values.iter().zip(&self.values).enumerate() {
                self.slopes[k * n + i] = (value - own) / width;
            }
        }
        [&self.values, &self.slopes]
    }
}
