//! Faults of values: expressions that leave their domain, loads without a finite value, numbers too
//! large to be held.

use crate::codes;
use crate::compiled::CompiledSystem;
use crate::input::{InputValues, input_symbols};
use crate::run::{Failure, Sample};
use bksim_dae::{SolveError, Standstill};
use bksim_expr::{DomainFault, Expr, Pool, SymbolId};
use bksim_mbs::force::{self, Wrench};
use bksim_mbs::quantity::coordinate_units;
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use bksim_model::diagnostic::{Code, Diagnostic, Span};
use bksim_model::message::short;

/// Numbers beyond this are on their way out of those that can be held: squares of them still can.
pub(super) const HUGE: f64 = 1e100;

/// How far ahead of the last state an expression is tried, as parts of the run.
const AHEAD: [f64; 4] = [0.0, 1e-14, 1e-12, 1e-9];

/// A model at one instant.
pub(super) struct FaultInstant<'a> {
    pub(super) model: &'a Model,
    pub(super) system: &'a SymbolicSystem,
    pub(super) compiled: &'a CompiledSystem,
    pub(super) parameters: &'a [f64],
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
}

impl FaultInstant<'_> {
    /// The values of symbols: parameters, inputs, coordinates and time.
    pub(super) fn value(&self) -> impl Fn(SymbolId) -> Option<f64> {
        let Self { model, system, compiled, parameters, t, q, v } = self;
        let inputs = InputValues::new(&compiled.inputs).at(*t, q, v).to_vec();
        let coordinates = system.coordinates();
        let of_inputs = input_symbols(model);
        move |symbol: SymbolId| {
            let input = of_inputs.iter().position(|&input| input == symbol);
            let parameter = model.parameters.iter().position(|p| p.symbol == symbol);
            input
                .map(|k| inputs[k])
                .or_else(|| parameter.map(|k| parameters[k]))
                .or_else(|| coordinates.iter().position(|c| c.q == symbol).map(|i| q[i]))
                .or_else(|| coordinates.iter().position(|c| c.v == symbol).map(|i| v[i]))
                .or_else(|| (symbol == model.time).then_some(*t))
        }
    }

    /// The fastest coordinate, if any moves fast enough to matter: name, rate and unit.
    pub(super) fn largest_rate(&self) -> Option<(String, f64, String)> {
        let rates = self.system.coordinates().iter().zip(&self.v);
        let (coordinate, &rate) = rates.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let [_, unit, _] = coordinate_units(self.model, coordinate);
        let name = coordinate.rate_name.clone();
        (rate.abs() > HUGE).then_some((name, rate, unit))
    }

    /// The input that has no value.
    pub(super) fn no_input(&self) -> Option<Diagnostic> {
        let Self { model, compiled, t, q, v, .. } = self;
        let mut values = InputValues::new(&compiled.inputs);
        let k = values.at(*t, q, v).iter().position(|value| !value.is_finite())?;
        let parameter = &model.parameters[compiled.inputs.ids()[k].0];
        let message = format!("the input `{}` has no value at t = {} s", parameter.name, short(*t));
        Some(
            Diagnostic::error(codes::NO_VALUE, message)
                .at(parameter.span.clone(), "a function of the motion in this run")
                .help("let its function return a finite number at every state"),
        )
    }

    /// The load or drive with an expression that leaves its domain.
    pub(super) fn out_of_domain(&self, code: Code) -> Option<Diagnostic> {
        let Self { model, system, t, .. } = self;
        let pool = &model.pool;
        let value = self.value();
        let signals = signal_values(model, &system.kinematics);
        let laws = model.loads.iter().flat_map(|load| {
            let named = (format!("load `{}`", load.name), &load.span);
            load.kind.expressions().into_iter().map(move |e| (named.clone(), e))
        });
        let drives = model.drives.iter();
        let motions = drives.map(|d| ((format!("drive `{}`", d.name), &d.span), d.motion));
        for ((owner, span), e) in laws.chain(motions) {
            // The author's own text of the operand, with its value in this state.
            let resolved = pool.substitute(e, &signals);
            if let Some(fault) = pool.domain_fault(resolved, &value) {
                let written = written_operand(pool, e, &fault, &signals, &value);
                return Some(domain_diagnostic(code, &owner, span, &fault, &written, *t));
            }
        }
        None
    }

    /// The load whose law has a value, but not its force or energy.
    pub(super) fn no_force(&self, code: Code) -> Option<Diagnostic> {
        let (load, span, label) = self.load_without_value()?;
        let message = format!("load `{load}` has no finite value at t = {} s", short(self.t));
        let way_out = if code == codes::NOT_FINITE_AT_START {
            "move the start a little"
        } else {
            "keep the motion away from there"
        };
        let help = format!("{way_out}, or write a law that has a value there");
        Some(Diagnostic::error(code, message).at(span, label).help(help))
    }

    /// The load whose force or energy is no finite number, with the span of what it is by.
    fn load_without_value(&self) -> Option<(String, Span, &'static str)> {
        let Self { model, system, .. } = self;
        let value = self.value();
        let signals = signal_values(model, &system.kinematics);
        let is_finite = |&e: &Expr| {
            let resolved = model.pool.substitute(e, &signals);
            // A reaction has no value before its loads have.
            model.pool.evaluate(resolved, &value).map_or(true, f64::is_finite)
        };
        model.loads.iter().find_map(|load| {
            let action = force::action(model, &system.kinematics, &signals, &load.kind);
            let of = |w: &Wrench| [w.force, w.moment].concat();
            let forces = action.conservative.iter().chain(&action.applied).flat_map(of);
            let parts: Vec<Expr> = forces.chain(action.potential).collect();
            if parts.iter().all(is_finite) {
                return None;
            }
            let label = match load.kind.ends() {
                Some(_) => "its two points are in one place, or its value is too large",
                None => "this has no finite value there",
            };
            Some((load.name.clone(), load.span.clone(), label))
        })
    }
}

/// The expression that has left its domain where a run stands still, at the state that was tried or
/// a little ahead of the last one.
pub(super) fn no_value(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    parameters: &[f64],
    failure: &Failure,
) -> Option<Diagnostic> {
    let last = &failure.last;
    let nq = last.q.len();
    let at = failure.error.as_ref().and_then(SolveError::standstill);
    let instant = |t: f64, q: Vec<f64>, v: Vec<f64>| FaultInstant {
        model,
        system,
        compiled,
        parameters,
        t,
        q,
        v,
    };
    // The state that was tried, where it is one near the last.
    let mut tried: Vec<FaultInstant<'_>> = Vec::new();
    if let Some(Standstill { t, h, y, .. }) = at
        && y.len() >= 2 * nq
        && is_near(&y[..nq], &last.q)
    {
        let (q, v) = y[..2 * nq].split_at(nq);
        tried.extend([*t, t + h].map(|t| instant(t, q.to_vec(), v.to_vec())));
    }
    // The motion goes on ahead of the last state.
    let span = model.solve.t_end - model.solve.t_start;
    let to_pole = written_time(at.map_or(last.t, |at| at.t), span) - last.t;
    let steps = at.map(|at| at.h).into_iter().chain(AHEAD.map(|part| part * span));
    let steps = steps.chain([to_pole]);
    tried.extend(steps.map(|dt| {
        let q = last.q.iter().zip(&last.v).map(|(q, v)| q + dt * v).collect();
        let v =
            last.v.iter().zip(&last.a).map(|(v, a)| if a.is_finite() { v + dt * a } else { *v });
        instant(last.t + dt, q, v.collect())
    }));
    let input = tried.iter().find_map(FaultInstant::no_input);
    input.or_else(|| tried.iter().find_map(|instant| instant.out_of_domain(codes::NO_VALUE)))
}

/// The load whose law has a value where a run stands still, but not its force or energy.
pub(super) fn no_force(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    parameters: &[f64],
    failure: &Failure,
) -> Option<Diagnostic> {
    let Sample { t, q, v, .. } = &failure.last;
    let (t, q, v) = (*t, q.clone(), v.clone());
    FaultInstant { model, system, compiled, parameters, t, q, v }.no_force(codes::NO_VALUE)
}

/// The time nearest to `t` that has no more than nine decimals of the run's length: a pole in time stands at
/// a time that someone wrote, and steps may end short of it.
fn written_time(t: f64, span: f64) -> f64 {
    let decimals = 10.0_f64.powf(9.0 - span.abs().log10().floor());
    let written = (t * decimals).round() / decimals;
    if written.is_finite() { written } else { t }
}

/// True if two positions are those of one step.
fn is_near(a: &[f64], b: &[f64]) -> bool {
    const NEAR: f64 = 1e-2;
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= NEAR * b.abs().max(NEAR))
}

/// A motion whose numbers grow beyond what can be held.
pub(super) fn too_large(
    model: &Model,
    system: &SymbolicSystem,
    last: &Sample,
) -> Option<Diagnostic> {
    let coordinates = system.coordinates();
    let (positions, rates) = (last.q.iter().enumerate(), last.v.iter().enumerate());
    let position = |(i, &x): (usize, &f64)| {
        let [unit, ..] = coordinate_units(model, &coordinates[i]);
        (coordinates[i].name.clone(), x, unit)
    };
    let rate = |(i, &x): (usize, &f64)| {
        let [_, unit, _] = coordinate_units(model, &coordinates[i]);
        (coordinates[i].rate_name.clone(), x, unit)
    };
    let energies = [("kinetic", last.energy.kinetic), ("potential", last.energy.potential)];
    let energies = energies.map(|(what, x)| (format!("{what} energy"), x, "J".to_owned()));
    let all: Vec<(String, f64, String)> =
        positions.map(position).chain(rates.map(rate)).chain(energies).collect();
    let is_out = !last.is_finite() || all.iter().any(|(_, x, _)| x.abs() > HUGE);
    // The largest that is still a number tells most.
    let numbers = all.iter().filter(|(_, x, _)| x.is_finite());
    let (name, x, unit) = numbers.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    if !is_out {
        return None;
    }
    let message = format!(
        "the motion grows beyond all numbers at t = {} s: `{name}` is {} {unit}",
        short(last.t),
        short(*x)
    );
    let fault = Diagnostic::error(codes::TOO_LARGE, message)
        .note("beyond 1.8e308 there are no numbers: energies or reactions are infinite there")
        .help(
            "look for a load that feeds the motion, such as a force that grows with its own path",
        );
    let end = model.solve.spans.iter().find(|(key, _)| key == "t_end");
    Some(match end {
        Some((_, span)) => fault.at(span.clone(), "the run was to reach this time"),
        None => fault,
    })
}

pub(super) fn domain_diagnostic(
    code: Code,
    owner: &str,
    span: &Span,
    fault: &DomainFault,
    written: &str,
    t: f64,
) -> Diagnostic {
    let operands: Vec<String> = fault.operands.iter().map(|&v| short(v)).collect();
    let message = format!(
        "{owner} has no value at t = {} s: {} of {}",
        short(t),
        fault.operation,
        operands.join(" and ")
    );
    let help = match fault.operation {
        "division" => {
            "keep the divisor away from zero: start or end the run elsewhere, or write for example `1/max(x, 1e-3)` \
             instead of `1/x`"
        }
        _ => "keep the operand in its domain, for example `sqrt(max(x, 0))` instead of `sqrt(x)`",
    };
    Diagnostic::error(code, message)
        .at(span.clone(), "this expression leaves its domain")
        .note(written.to_owned())
        .help(help)
}

/// The values of what the expression names, such as `x = 0.0499`.
pub(super) fn written_operand(
    pool: &Pool,
    e: Expr,
    fault: &DomainFault,
    signals: &[(SymbolId, Expr)],
    value: &dyn Fn(SymbolId) -> Option<f64>,
) -> String {
    let named = pool.symbols_of(e).into_iter().filter_map(|symbol| {
        let signal = signals.iter().find(|(known, _)| *known == symbol);
        let number = match signal {
            Some(&(_, measure)) => pool.evaluate(measure, value).ok(),
            None => value(symbol),
        };
        // All digits: the operand may miss its domain by the last one.
        number.map(|number| format!("{} = {number}", pool.symbol_name(symbol)))
    });
    format!("in `{}` with {}", pool.to_text(fault.expr), named.collect::<Vec<_>>().join(", "))
}
