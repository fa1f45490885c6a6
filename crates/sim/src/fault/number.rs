//! Numbers of a sample that are not finite: which quantity, when, and the part of the model that it is about.

use bksim_expr::SymbolId;
use bksim_mbs::constraint::Source;
use bksim_mbs::signal::signal_values;
use bksim_model::diagnostic::{Code, Diagnostic, Span};
use bksim_model::message::short;
use bksim_model::{Frame, Measure};

use super::values::{FaultInstant, HUGE, domain_diagnostic, written_operand};
use crate::run::Sample;

/// Components of a reaction, world axes.
const COMPONENTS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// A number that is not finite: its name as channels have it, and the part that it is about.
struct Quantity {
    name: String,
    value: f64,
    place: Option<(Span, &'static str)>,
}

/// The diagnostic of a sample at `instant` that is no result, unless its motion itself has grown beyond all numbers.
///
/// What explains the number comes first: an input, a load or drive that leaves its domain, a load without a force,
/// the expression of a signal or output. `of_cause` is the code of a load or drive that explains it, `code` that of any
/// other number.
pub(super) fn not_finite(
    instant: &FaultInstant<'_>,
    sample: &Sample,
    [of_cause, code]: [Code; 2],
) -> Option<Diagnostic> {
    let motion = [&sample.q[..], &sample.v, &sample.a].concat();
    if motion.iter().any(|value| !value.is_finite() || value.abs() > HUGE) {
        return None;
    }
    let quantity = first(instant, sample)?;
    let Quantity { name, value, .. } = &quantity;
    let cause = instant.no_input().or_else(|| instant.out_of_domain(of_cause));
    if let Some(cause) = cause.or_else(|| instant.no_force(of_cause)) {
        let note = format!("`{name}` is {value} there");
        return Some(Diagnostic { code: of_cause, ..cause }.note(note));
    }
    if let Some(cause) = named_out_of_domain(instant, sample, code) {
        return Some(cause);
    }
    let t = short(instant.t);
    let message = format!("`{name}` has no finite value at t = {t} s: it is {value}");
    let fault = Diagnostic::error(code, message).help(
        "look for a number beyond 1.8e308 on the way to it, and for a division by what passes zero there; \
         or leave the instant out of the run",
    );
    Some(match quantity.place {
        Some((span, label)) => fault.at(span, label),
        None => fault,
    })
}

/// The first quantity of a sample without a finite value, forces before what is made of them.
fn first(instant: &FaultInstant<'_>, sample: &Sample) -> Option<Quantity> {
    let FaultInstant { model, system, .. } = instant;
    let bad = |values: &[f64]| values.iter().position(|value| !value.is_finite());
    for (joint, reaction) in model.joints.iter().zip(&sample.reactions) {
        if let Some(k) = bad(reaction) {
            let name = format!("reactions.{}.{}", joint.name, COMPONENTS[k]);
            let place = Some((joint.span.clone(), "a reaction of this joint"));
            return Some(Quantity { name, value: reaction[k], place });
        }
    }
    if let Some(row) = bad(&sample.lambda) {
        let (name, span) = match system.constraints.get(row)?.source {
            Source::Drive(id) => {
                let drive = &model.drives[id.0];
                (format!("drives.{}", drive.name), &drive.span)
            }
            Source::Coupling(id) => {
                let coupling = &model.couplings[id.0];
                (format!("couplings.{}", coupling.name), &coupling.span)
            }
            Source::Joint(id) => {
                let joint = &model.joints[id.0];
                (format!("a multiplier of {}", joint.name), &joint.span)
            }
            Source::Quaternion(id) => {
                let body = &model.bodies[id.0];
                (format!("a multiplier of {}", body.name), &body.span)
            }
            Source::Stop(id) | Source::Friction(id) => {
                let load = &model.loads[id.0];
                (format!("the force of {}", load.name), &load.span)
            }
        };
        let place = Some((span.clone(), "the force of this"));
        return Some(Quantity { name, value: sample.lambda[row], place });
    }
    if let Some(k) = bad(&sample.signals) {
        let named = model.named_signals.get(k)?;
        let topic = if named.is_output { "outputs" } else { "signals" };
        let name = format!("{topic}.{}", named.name);
        let place = Some((named.span.clone(), "this has no finite value there"));
        return Some(Quantity { name, value: sample.signals[k], place });
    }
    let energy = &sample.energy;
    let energies = [
        ("energy.kinetic", energy.kinetic),
        ("energy.potential", energy.potential),
        ("energy.power", energy.power),
        ("energy.work", sample.work),
    ];
    let (name, value) = energies.into_iter().find(|(_, value)| !value.is_finite())?;
    Some(Quantity { name: name.to_owned(), value, place: None })
}

/// The signal or output with an expression that leaves its domain.
fn named_out_of_domain(
    instant: &FaultInstant<'_>,
    sample: &Sample,
    code: Code,
) -> Option<Diagnostic> {
    let FaultInstant { model, system, t, .. } = instant;
    let pool = &model.pool;
    let (signals, value) = (signal_values(model, &system.kinematics), instant.value());
    let of_sample = |symbol: SymbolId| {
        let used = model.signals.iter().find(|used| used.symbol == symbol)?;
        match used.measure {
            Measure::Reaction(joint, Frame::World, k) => {
                sample.reactions.get(joint.0).map(|reaction| reaction[k])
            }
            Measure::Effort(drive) => {
                let is_it = |source| source == Source::Drive(drive);
                let row = system.constraints.iter().position(|row| is_it(row.source))?;
                sample.lambda.get(row).copied()
            }
            _ => None,
        }
    };
    let accelerations = system.coordinates().iter().zip(&sample.a);
    let accelerations: Vec<(SymbolId, f64)> = accelerations.map(|(c, &a)| (c.a, a)).collect();
    let known = |symbol: SymbolId| {
        let of_motion = || accelerations.iter().find(|(a, _)| *a == symbol).map(|(_, a)| *a);
        value(symbol).or_else(of_motion).or_else(|| of_sample(symbol))
    };
    let lacking = model.named_signals.iter().zip(&sample.signals);
    lacking.filter(|(_, number)| !number.is_finite()).find_map(|(named, number)| {
        let resolved = pool.substitute(named.value, &signals);
        let fault = pool.domain_fault(resolved, &known)?;
        let written = written_operand(pool, named.value, &fault, &signals, &known);
        let kind = if named.is_output { "output" } else { "signal" };
        let owner = format!("{kind} `{}`", named.name);
        let fault = domain_diagnostic(code, &owner, &named.span, &fault, &written, *t);
        Some(fault.note(format!("it is {number} there")))
    })
}
