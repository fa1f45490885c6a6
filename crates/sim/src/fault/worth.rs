//! Whether the numbers of a run are worth what its tolerances promise.
//!
//! ```text
//! energy       |T + V − W − T₀ − V₀|  ≤  r E + 1e-12 |T₀ + V₀| + 1e-15 max(1, |v|)³ max(1, |t − t₀|)
//!              E = max(|T| + |V − V₀| + |W|, ∫ Σ |λ ∂g/∂t| dt)
//!              r = min(1000 rtol, 0.05) + 1000 atol / |v|
//! constraints  |g| ≤ 1e3 (rtol max(1, |q|) + atol),   |G v + ∂g/∂t| ≤ 1e4 (rtol max(1, |v|) + atol)
//! ```
//!
//! in the largest numbers over the samples, where the integral is what goes in and out of drives: all there is where nothing has
//! a mass, or moves slowly against dampers; `|q|` and `|v|` are the largest coordinate and velocity, SI.
//! The constraints are looked at before samples are projected onto them. Tolerances bound the error of
//! coordinates, not of energies, whence the factor: in all examples, methods and formulations the
//! balance of energy closes to 180 `rtol`. A fixed step has no tolerance: it is held to the usual one,
//! 1e-6, where `rtol` is smaller.

use super::pole;
use crate::codes;
use crate::held_assembly::AssemblyChange;
use crate::rope_turns::{rope_left, rope_wound};
use crate::run::Summary;
use bksim_mbs::constraint::Source;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::{Diagnostic, Span};
use bksim_model::message::short;
use bksim_model::{LoadId, Model, SolveOptions};

/// The error of energies and constraints over that of coordinates which is still taken as usual.
const FACTOR: f64 = 1000.0;

/// Repeated steps whose error has not fallen with their size that are told: so many, and this part of all
/// steps.
const NOISY: usize = 10;
const NOISY_PART: f64 = 0.02;
/// A mean error beyond so many tolerances is not rounding where no singular pose was passed: it is of steps far too large,
/// as the first ones after an event may be, or of a motion that is stiff.
const MOST_NOISE: f64 = 30.0;
/// Nor does rounding reach a tolerance as large as this without one: there it is that of motions with a bend, such as
/// under a force of `t^0.3`.
const NOISELESS: f64 = 1e-8;
/// Steps follow a motion towards a singular pose until its noise meets the tolerance, whatever that is, so
/// the noise met says nothing of another tolerance. One, two, ten and forty square windows in absolute
/// coordinates are undisturbed at 1e-6: that is advised, or from there on so much more.
const UNDISTURBED: f64 = 1e-6;
const LOOSER: f64 = 100.0;

/// A relative error of energy that no tolerance excuses.
const LARGEST: f64 = 0.05;

/// Factor by which velocities lose more than positions: they are their derivatives.
const OF_RATES: f64 = 10.0;

/// The tolerance that a fixed step is held to.
const OF_FIXED_STEPS: f64 = 1e-6;

/// Rounding of the energies themselves.
const ROUNDING: f64 = 1e-12;

/// Force of a drive or constraint, N or N m, that is rounding where nothing has mass or is loaded, for each unit of
/// the accelerations that are found with it; these grow as |v|².
const NO_FORCE: f64 = 1e-15;

impl Summary {
    /// The largest error of the balance of energy that the tolerances allow, J.
    pub fn promised_energy_error(&self, options: &SolveOptions) -> f64 {
        let relative = (FACTOR * rtol(options)).min(LARGEST);
        let relative = relative + FACTOR * options.atol / self.largest[1];
        // Nothing has moved where there is no velocity.
        let of_motion = if self.largest[1] > 0.0 { relative * self.energy.scale } else { 0.0 };
        let duration = (self.t - options.t_start).abs().max(1.0);
        let no_work = NO_FORCE * self.largest[1].max(1.0).powi(3) * duration;
        let of_rounding = ROUNDING * self.energy.initial.abs() + no_work;
        of_motion + of_rounding
    }

    /// The largest violations of the constraints and of their rates that the tolerances allow.
    pub fn promised_drift(&self, options: &SolveOptions) -> [f64; 2] {
        let [position, velocity] =
            self.largest.map(|size| FACTOR * (rtol(options) * size.max(1.0) + options.atol));
        [position, OF_RATES * velocity]
    }
}

/// The relative tolerance that a run is held to.
fn rtol(options: &SolveOptions) -> f64 {
    if options.step.is_some() { options.rtol.max(OF_FIXED_STEPS) } else { options.rtol }
}

/// The warnings about a run whose numbers are worse than its tolerances promise.
pub fn diagnose_worth(
    model: &Model,
    system: &SymbolicSystem,
    options: &SolveOptions,
    summary: &Summary,
) -> Vec<Diagnostic> {
    let energy = &summary.energy;
    let mut faults: Vec<Diagnostic> =
        summary.pole.iter().map(|pole| pole::near_pole(model, system, pole)).collect();
    let (place, help) = cure(model, options);
    let at = |fault: Diagnostic| match &place {
        Some((span, text)) => fault.at(span.clone(), *text),
        None => fault,
    };

    faults.extend(summary.driving.map(|(t, load)| friction_drives(model, load, t)));
    faults.extend(summary.pushing.and_then(|(t, row)| rope_pushes(model, system, row, t)));
    faults.extend(summary.wound.and_then(|(place, turn)| rope_wound(model, place, turn)));
    faults.extend(summary.left.and_then(|(t, place)| rope_left(model, place, t)));
    faults.extend(below_noise(model, options, summary));
    faults.extend(another_assembly(model, &summary.assembly_changes, |t| {
        format!("t = {} s", short(t))
    }));

    // The balance of energy.
    let promised = summary.promised_energy_error(options);
    if energy.worst_error > promised {
        let message = format!(
            "the balance of energy is off by {} J of {} J",
            short(energy.worst_error),
            short(energy.scale)
        );
        let fault = Diagnostic::warning(codes::ENERGY_OFF, message).note(format!(
            "with `rtol` = {:e} it should close to {} J",
            rtol(options),
            short(promised)
        ));
        faults.push(at(fault).help(help));
    }

    // The constraints, of which the worse level is told.
    let found = [summary.position_residual[0], summary.velocity_residual[0]];
    let promised = summary.promised_drift(options);
    let excess = [0, 1].map(|level| found[level] / promised[level]);
    let level = usize::from(excess[1] > excess[0]);
    if excess[level] > 1.0 {
        let (what, unit) =
            [("constraints", "m or rad"), ("rates of the constraints", "m/s or rad/s")][level];
        let message = format!("the {what} are left open by up to {} {unit}", short(found[level]));
        let fault = Diagnostic::warning(codes::DRIFTED, message).note(format!(
            "with `rtol` = {:e} it should be below {} {unit}",
            rtol(options),
            short(promised[level])
        ));
        faults.push(at(fault).help(help));
    }
    faults
}

/// The warning that a rope which stays taut has to push at a sample.
fn rope_pushes(model: &Model, system: &SymbolicSystem, row: usize, t: f64) -> Option<Diagnostic> {
    let Source::Coupling(id) = system.constraints[row].source else { return None };
    let rope = &model.couplings[id.0];
    let message =
        format!("rope `{}` pushes at t = {} s: its pull is below zero", rope.name, short(t));
    let fault = Diagnostic::warning(codes::ROPE_PUSHES, message).at(rope.span.clone(), "this rope");
    Some(fault.help("write `slack = true` for a rope that becomes slack instead"))
}

/// The warning that the size of friction is below zero at a sample.
fn friction_drives(model: &Model, load: LoadId, t: f64) -> Diagnostic {
    let load = &model.loads[load.0];
    let message = format!(
        "friction `{}` drives the motion at t = {} s: its size is below zero",
        load.name,
        short(t)
    );
    Diagnostic::warning(codes::FRICTION_DRIVES, message)
        .at(load.span.clone(), "this slides")
        .help("write `max(0, …)` around it, or another expression that stays above zero")
}

/// The warning that a motion passes over into another assembly than the one that is held; `place` tells where.
pub fn another_assembly<P>(
    model: &Model<P>,
    changes: &[AssemblyChange],
    place: impl Fn(f64) -> String,
) -> Option<Diagnostic> {
    let chosen = model.assembly.as_ref()?;
    let (found, first) = (chosen.found.as_ref()?, changes.first()?);
    let joint = &model.joints[first.joint.0].name;
    let message = format!(
        "the assembly `{}` passes over into another one: joint `{joint}` goes through its dead centre at {}",
        found.name,
        place(first.t)
    );
    let fault = Diagnostic::warning(codes::ANOTHER_ASSEMBLY, message)
        .at(chosen.span.clone(), "held from the start on")
        .help("end the motion before, or leave `assembly` out where both may be passed");
    Some(match changes.len() {
        1 => fault,
        n => fault.note(format!("so it does {n} times")),
    })
}

/// The warning that a smaller tolerance makes no smaller error.
fn below_noise(model: &Model, options: &SolveOptions, summary: &Summary) -> Option<Diagnostic> {
    let noise = summary.noise;
    #[expect(clippy::cast_precision_loss, reason = "far below 2⁵²")]
    let least = NOISY_PART * summary.stats.n_accept as f64;
    #[expect(clippy::cast_precision_loss, reason = "far below 2⁵²")]
    let is_noisy = noise.count >= NOISY && noise.count as f64 > least;
    // Laws from outside and sampled signals jump between steps, and so do higher derivatives where tables, laws of
    // cams and curves go from piece to piece: the error of a step with a jump does not fall with its size, which
    // is no noise.
    let is_sampled = !model.inputs.is_empty() || model.held.iter().any(|signal| !signal.is_count());
    let is_in_pieces =
        !(model.table_calls.is_empty() && model.laws.is_empty() && model.curves.is_empty());
    let is_regular = summary.singular_poses.is_empty();
    let is_of_steps = is_regular && (noise.mean_error() > MOST_NOISE || options.rtol >= NOISELESS);
    if !is_noisy || is_of_steps || is_sampled || is_in_pieces || options.step.is_some() {
        return None;
    }
    let message =
        format!("`rtol` = {:e} asks for more than the accelerations are known to", options.rtol);
    let reached = (LOOSER * options.rtol).clamp(UNDISTURBED, 0.1);
    let fault = Diagnostic::warning(codes::BELOW_NOISE, message)
        .note(format!(
            "{} repeated steps had no smaller error for being smaller: it was the rounding of the \
             accelerations, {} tolerances of a step in the mean",
            noise.count,
            short(noise.mean_error())
        ))
        .help(format!("take `rtol` and `atol` of {}, which steps can keep to", short(reached)));
    let fault = match summary.singular_poses.len() {
        0 => fault,
        n => fault.note(format!(
            "{n} singular {} passed, near which accelerations are known to few digits at any tolerance",
            if n == 1 { "pose was" } else { "poses were" }
        )),
    };
    Some(match span_of(model, "rtol") {
        Some(span) => fault.at(span, "this tolerance"),
        None => fault,
    })
}

/// The change that helps, and its place.
fn cure(model: &Model, options: &SolveOptions) -> (Option<(Span, &'static str)>, &'static str) {
    let span = |key: &str| span_of(model, key);
    if options.step.is_some() {
        let place = span("step").map(|span| (span, "this step"));
        (place, "make `step` smaller, or leave it out: steps that adapt keep to `rtol`")
    } else {
        let place = span("rtol").map(|span| (span, "this tolerance"));
        (place, "make `rtol` smaller, and see whether the results stay")
    }
}

/// The place of an option in the model's text.
fn span_of(model: &Model, key: &str) -> Option<Span> {
    let found = model.solve.spans.iter().find(|(known, _)| known == key);
    found.map(|(_, span)| span.clone())
}
