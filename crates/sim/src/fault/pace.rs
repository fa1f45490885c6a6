//! A run that takes far more steps than expected, and why.

use super::pole;
use crate::codes;
use crate::compiled::CompiledSystem;
use crate::run::Slowness;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::{listed, short};

/// A coordinate whose inertia is smaller than this part of the largest is light.
const LIGHT: f64 = 1e-5;

/// A coordinate that moves so far in each step, rad, or as part of its own size, is followed round by
/// round.
const FOLLOWED: f64 = 0.02;

/// The warning about a run that takes far more steps than expected.
pub fn diagnose_slowness(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    parameters: &[f64],
    slowness: &Slowness,
) -> Diagnostic {
    let Slowness { t, n_step, steps_left, .. } = slowness;
    let message = format!(
        "after {n_step} steps the run is at t = {} s: at this pace the rest takes {} steps more",
        short(*t),
        short(*steps_left)
    );
    let fault = Diagnostic::warning(codes::SLOW, message);
    let fault = with_reasons(fault, (model, system), compiled, parameters, slowness);
    match model.solve.spans.iter().find(|(key, _)| key == "t_end") {
        Some((_, span)) => fault.at(span.clone(), "the run is to reach this time"),
        None => fault,
    }
}

/// Adds why the steps are small, and what to do about it.
pub(super) fn with_reasons(
    fault: Diagnostic,
    (model, system): (&Model, &SymbolicSystem),
    compiled: &CompiledSystem,
    parameters: &[f64],
    slowness: &Slowness,
) -> Diagnostic {
    let Slowness { t, step_size, worst, q, v, .. } = slowness;
    let coordinates = system.coordinates();
    let name = |i: usize| coordinates[i].name.as_str();
    let names: Vec<&str> = worst.iter().map(|&i| name(i)).collect();
    let followed =
        if names.is_empty() { String::new() } else { format!(" to follow {}", listed(&names)) };
    let fault = fault.note(format!("steps of {} s are needed{followed}", short(*step_size)));

    // Angles at their pole.
    if let Some([note, help]) = pole::reason(system, q) {
        return fault.note(note).help(help);
    }

    // A part far lighter than others of the same kind of motion.
    let mass = compiled.evaluator(parameters).dynamics(*t, q, v).mass_matrix();
    let of_kind = |kind: CoordinateKind| {
        let same = coordinates.iter().enumerate().filter(move |(_, c)| c.kind == kind);
        same.map(|(i, _)| (i, mass[(i, i)])).filter(|&(_, m)| m > 0.0)
    };
    let extremes = |kind: CoordinateKind| {
        let least = of_kind(kind).min_by(|a, b| a.1.total_cmp(&b.1))?;
        let most = of_kind(kind).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((least, most, if kind == CoordinateKind::Length { "kg" } else { "kg m^2" }))
    };
    let kinds = [CoordinateKind::Length, CoordinateKind::Angle, CoordinateKind::Quaternion];
    let light = kinds.into_iter().filter_map(extremes);
    let mut light = light.filter(|(least, most, _)| least.1 < LIGHT * most.1);
    let light = light.find(|((i, _), ..)| worst.contains(i));
    if let Some(((i, least), (k, most), unit)) = light {
        return fault
            .note(format!(
                "`{}` moves {} {unit}, `{}` {} {unit}",
                name(i),
                short(least),
                name(k),
                short(most)
            ))
            .help("look for a mass or length in a wrong unit; give the light part more, or leave it out");
    }

    // A motion that is itself fast.
    let moved = |&i: &usize| {
        let is_length = coordinates[i].kind == CoordinateKind::Length;
        let size = if is_length { q[i].abs().max(1e-9) } else { 1.0 };
        (v[i] * step_size).abs() / size
    };
    if let Some(&i) = worst.iter().find(|&i| moved(i) > FOLLOWED) {
        let [_, unit] = &compiled.coordinates[i].rates[0];
        return fault
            .note(format!("`{}` is {} {unit} there", coordinates[i].rate_name, short(v[i])))
            .help("look for a speed, force or length in a wrong unit, or end the run much sooner");
    }
    // An oscillation that is small against what moves with it is followed for the absolute tolerance.
    let options = &model.solve;
    let is_small = |&i: &usize| options.rtol * q[i].abs().max(v[i].abs()) < 100.0 * options.atol;
    let tolerance = if worst.iter().any(is_small) {
        format!("write `atol = {:.0e}` in `[solve]`", 1e2 * options.atol)
    } else {
        "loosen `rtol`".to_owned()
    };
    fault.help(format!(
        "soften very stiff springs or take them as rigid, {tolerance}, or let a fixed `step` pass over the oscillation"
    ))
}
