//! The derivatives that a gradient needs, compiled.

use bksim_expr::{Expr, SymbolId};

use super::super::channels::found;
use super::super::derive::{Way, derived};
use super::super::direction::Direction;
use super::super::following::Following;
use super::super::start::start_by_each;
use super::super::{Sensitive, SensitivityEquations, SensitivityError, SensitivityPlan};
use crate::compiled::CompiledSystem;
use crate::formulate::acceleration_level;
use crate::function::Function;
use crate::modes::indicators::indicator_functions;
use crate::quantities::Quantities;
use crate::run::StateSensitivity;
use crate::start::Start;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Initial, Model};

/// The derivatives of the equations and of what a run shows along weights, and those of the start.
#[derive(Clone, Debug)]
pub struct GradientPlan {
    /// The equations of the changes by loads on the rows of F, one after the other.
    pub(super) loads: Following,
    /// ∂(ρ·F)/∂P of (t, q, v, a, λ, ρ): parameters that any quantity moves.
    pub(super) forces: Function,
    /// ∂(w·h)/∂(q, v, a, λ, P) of (t, q, v, a, λ, w): h the channels, then the sizes of friction.
    pub(super) channels: Function,
    pub(super) sensitive: Vec<Sensitive>,
    /// ∂P/∂p: by quantity, of the parameters that any moves.
    pub(super) directions: Vec<f64>,
    /// Sensitivities of the start, by quantity.
    pub(super) start: Vec<StateSensitivity>,
    /// Changes across events: by quantity, then of q and of v one by one.
    pub(super) events: Option<SensitivityPlan>,
    /// The equations of the start by all quantities, those of these that are kept, and the parameters that any moves.
    opening: SensitivityEquations,
    initial: Vec<Initial>,
    kept: Vec<usize>,
    moved: Vec<usize>,
}

/// Derives and compiles what the gradient by `sensitive` needs, at these parameter values and from this start. After
/// the channels that a run shows, weights have a place for each of `more`, names of [quantities](Quantities).
///
/// # Errors
/// [`SensitivityError`] as [`differentiate`](super::super::differentiate) and [`start`](super::super::start()).
pub fn plan_gradient(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    (at, parameters): (&Start, &[f64]),
    (sensitive, more): (&[Sensitive], &[String]),
) -> Result<GradientPlan, SensitivityError> {
    let (plan, left_out) =
        plan_gradient_by_some(model, system, compiled, (at, parameters), (sensitive, more))?;
    left_out.into_iter().next().map_or(Ok(plan), |(_, error)| Err(error))
}

/// Plan ([`plan_gradient`]) by those of `sensitive` that there are derivatives by, in their order; and why there are none by
/// each of the others.
///
/// # Errors
/// [`SensitivityError`] of the model as a whole.
pub fn plan_gradient_by_some(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    (at, parameters): (&Start, &[f64]),
    (sensitive, more): (&[Sensitive], &[String]),
) -> Result<(GradientPlan, Vec<(Sensitive, SensitivityError)>), SensitivityError> {
    let system = system.integrated();
    let derivation = Direction::new(model, system);
    derivation.checked(compiled, &[])?;
    let loads = Following::of_loads(&derivation)?;

    // Quantities that latched signals do not take.
    let (mut free, mut directions, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for &by in sensitive {
        match derivation.checked(compiled, &[by]) {
            Ok(direction) => {
                free.push(by);
                directions.extend(direction);
            }
            Err(error) => left_out.push((by, error)),
        }
    }

    // The start, and the quantities that it has derivatives by.
    let way = Way::Followed(Box::new(loads.along(&derivation, &[])?));
    let equations = derived(&derivation, (&free, &directions), way, parameters)?;
    let (mut kept, mut start) = (Vec::new(), Vec::new());
    for (k, by) in start_by_each(&equations, &model.initial, compiled, at, parameters).enumerate() {
        match by {
            Ok(by) => {
                kept.push(k);
                start.push(by);
            }
            Err(error) => left_out.push((free[k], error)),
        }
    }

    // Parameters that none of these moves are left out.
    let moved = moved_by(&equations, &kept);
    let own: Vec<SymbolId> = moved.iter().map(|&k| derivation.own[k]).collect();
    let events = if compiled.indicators.is_empty() {
        None
    } else {
        let along: Vec<_> = kept.iter().map(|&k| directions[k].clone()).collect();
        Some(events(&derivation, &equations, (&loads, &kept), along, compiled)?)
    };
    let plan = GradientPlan {
        forces: forces(&derivation, &own)?.in_lanes(model),
        channels: channels(&derivation, &own, more)?,
        directions: along(&equations, &kept, &moved),
        sensitive: kept.iter().map(|&k| free[k]).collect(),
        start,
        events,
        loads,
        opening: equations,
        initial: model.initial.clone(),
        kept,
        moved,
    };
    Ok((plan, left_out))
}

/// Parameters that any of these quantities moves.
fn moved_by(equations: &SensitivityEquations, kept: &[usize]) -> Vec<usize> {
    let n_own = equations.n_parameters;
    let is_moved = |own: &usize| kept.iter().any(|&k| equations.directions[k * n_own + own] != 0.0);
    (0..n_own).filter(is_moved).collect()
}

/// ∂P/∂p of some quantities and parameters.
fn along(equations: &SensitivityEquations, kept: &[usize], moved: &[usize]) -> Vec<f64> {
    let n_own = equations.n_parameters;
    let of = |&k: &usize| moved.iter().map(move |own| equations.directions[k * n_own + own]);
    kept.iter().flat_map(of).collect()
}

impl GradientPlan {
    /// This plan at other values of the parameters and from another start; `None` where that has no derivatives, or other
    /// parameters are moved there, so that it has to be made again.
    pub fn at(
        &self,
        compiled: &CompiledSystem,
        (at, parameters): (&Start, &[f64]),
    ) -> Option<Self> {
        let opening = self.opening.clone().at(parameters);
        if moved_by(&opening, &self.kept).iter().any(|own| !self.moved.contains(own)) {
            return None;
        }
        let start: Vec<_> =
            start_by_each(&opening, &self.initial, compiled, at, parameters).collect();
        let own = |&k: &usize| start[k].as_ref().ok().cloned();
        let start = self.kept.iter().map(own).collect::<Option<Vec<StateSensitivity>>>()?;
        let events = self.events.clone().map(|mut plan| {
            let all: Vec<usize> = (0..opening.n_parameters).collect();
            let own = along(&opening, &self.kept, &all);
            plan.equations.directions[..own.len()].copy_from_slice(&own);
            plan
        });
        let directions = along(&opening, &self.kept, &self.moved);
        Some(Self { directions, start, events, opening, ..self.clone() })
    }

    /// Quantities that the gradient is by.
    pub fn sensitive(&self) -> &[Sensitive] {
        &self.sensitive
    }
}

/// ∂(ρ·F)/∂P.
fn forces(direction: &Direction<'_>, own: &[SymbolId]) -> Result<Function, SensitivityError> {
    let Direction { model, system, q, v, .. } = direction;
    let rows = acceleration_level(model, system);
    let weights = weights(model, "load", rows.len());
    let by = vjp(model, &rows, &weights, own);
    let [a, lambda] = unknowns(system);
    Ok(direction.compile(&by, &[q, v, &a, &lambda, &weights])?)
}

/// ∂(w·h)/∂(q, v, a, λ, P).
fn channels(
    direction: &Direction<'_>,
    own: &[SymbolId],
    more: &[String],
) -> Result<Function, SensitivityError> {
    let Direction { model, system, q, v, .. } = direction;
    let [a, lambda] = unknowns(system);
    let quantities = Quantities::new(model, system);
    let more = more.iter().filter_map(|name| quantities.named(name));
    let shown = found(model, system).map(|(function, _)| function);
    let shown: Vec<Expr> = shown.chain(more.map(|(function, _)| function)).collect();
    let mut rows = model.pool.substitute_all(&shown, &system.reaction_values);
    let (indicators, contacts) = indicator_functions(model, system);
    let of_contacts = indicators[indicators.len() - 4 * contacts.len()..].chunks_exact(4);
    rows.extend(of_contacts.map(|four| four[2]));
    let weights = weights(model, "weight", rows.len());
    let wrt = [q, v, &a, &lambda, own].concat();
    let by = vjp(model, &rows, &weights, &wrt);
    Ok(direction.compile(&by, &[q, v, &a, &lambda, &weights])?)
}

fn unknowns(system: &SymbolicSystem) -> [Vec<SymbolId>; 2] {
    let a = system.coordinates().iter().map(|c| c.a).collect();
    [a, system.constraints.iter().map(|c| c.lambda).collect()]
}

/// Symbols that are not identifiers, so that no name of the model can meet them.
fn weights(model: &Model, kind: &str, n: usize) -> Vec<SymbolId> {
    let symbol = |k: usize| model.pool.symbol(&format!("'{kind}{k}"));
    let id = |k: usize| model.pool.symbol_id(symbol(k)).expect("a symbol was just made");
    (0..n).map(id).collect()
}

fn vjp(model: &Model, rows: &[Expr], weights: &[SymbolId], wrt: &[SymbolId]) -> Vec<Expr> {
    let weights: Vec<Expr> = weights.iter().map(|&id| model.pool.symbol_expr(id)).collect();
    model.pool.vjp(rows, &weights, wrt)
}

/// The changes that go into an event: none of the state by a quantity itself, then one of each q and v.
fn events(
    derivation: &Direction<'_>,
    equations: &SensitivityEquations,
    (loads, kept): (&Following, &[usize]),
    mut along: Vec<Vec<Expr>>,
    compiled: &CompiledSystem,
) -> Result<SensitivityPlan, SensitivityError> {
    let (nq, n_own, n) = (compiled.nq(), derivation.own.len(), kept.len());
    along.resize(n + 2 * nq, vec![derivation.model.pool.zero(); n_own]);
    let of_quantity = |&k: &usize| &equations.directions[k * n_own..(k + 1) * n_own];
    let mut directions = kept.iter().map(of_quantity).collect::<Vec<_>>().concat();
    directions.resize((n + 2 * nq) * n_own, 0.0);
    let way = Way::Followed(Box::new(loads.along(derivation, &along)?));
    let change = |k: usize| {
        let unit = |first: usize| -> Vec<f64> {
            (0..nq).map(|i| if k == n + first + i { 1.0 } else { 0.0 }).collect()
        };
        StateSensitivity {
            q: unit(0),
            v: unit(nq),
            a: vec![0.0; nq],
            lambda: vec![0.0; compiled.nc()],
            channels: Vec::new(),
        }
    };
    let start = (0..n + 2 * nq).map(change).collect();
    Ok(SensitivityPlan {
        equations: SensitivityEquations { way, directions, ..equations.clone() },
        start,
    })
}
