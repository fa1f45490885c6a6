//! Faults of a run: a drive at its dead centre, an expression without a value, a step too small.

use bksim_dae::{Cause, SolveError};
use bksim_expr::{Expr, SymbolId};
use bksim_model::ParameterId;
use nalgebra::{DMatrix, DVector};

use super::closing::{estimate, reach_note};
use super::number::not_finite;
use super::pace::with_reasons;
use super::pole::at_pole;
use super::reach::longest_in_loop;
use super::start::diagnose_start;
use super::switch;
use super::table::table_left;
use super::values::{FaultInstant, no_force, no_value, too_large};
use super::words::unit_of;
use crate::codes;
use crate::compiled::CompiledSystem;
use crate::formulate::MotionEquations;
use crate::mobility::loop_through;
use crate::run::Failure;
use bksim_mbs::constraint::Source;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{BodyId, DriveId, JointId, Measure, Model};

/// A drive whose row lies this close to the span of the joints' rows (as the sine of the angle
/// between them) has run into a pose it cannot pass. Steps shrink as the square root of the way
/// left, so a run stops within about this distance.
const DEAD_CENTRE: f64 = 0.2;

/// Two links whose directions differ by less than this (sine) are said to be in line.
const IN_LINE: f64 = 0.15;

/// The diagnostic of a run that stopped early.
pub fn diagnose_run(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    equations: &MotionEquations,
    parameters: &[f64],
    failure: &Failure,
) -> Diagnostic {
    if let Some(fault) = &failure.start {
        return diagnose_start(model, system, compiled, fault);
    }
    if let Some(fault) = &failure.no_sensitivity {
        return switch::no_sensitivity(model, fault);
    }
    let last = &failure.last;
    let (q, v) = (last.q.clone(), last.v.clone());
    let instant = FaultInstant { model, system, compiled, parameters, t: last.t, q, v };
    if let Some(fault) = table_left(&instant) {
        return fault;
    }
    // A sample that was not handed out.
    let of_sample = if last.t == model.solve.t_start {
        [codes::NOT_FINITE_AT_START; 2]
    } else {
        [codes::NO_VALUE, codes::NO_FINITE_NUMBER]
    };
    let has_infinite_force = last.reactions.as_flattened().iter().any(|force| !force.is_finite());
    let is_jammed = has_infinite_force && switch::jammed(model, last).is_some();
    if !last.is_finite()
        && !is_jammed
        && let Some(fault) = not_finite(&instant, last, of_sample)
    {
        return fault;
    }
    if let Some(fault) = &failure.no_modes {
        return switch::no_consistent_modes(model, system, fault, failure.summary.t);
    }
    let fault = match &failure.error {
        Some(
            SolveError::NotFinite { .. }
            | SolveError::StepTooSmall { cause: Cause::NotFinite { .. }, .. }
            | SolveError::FixedStepFailed { cause: Cause::NotFinite { .. }, .. },
        ) => no_value(model, system, compiled, parameters, failure)
            .or_else(|| no_force(model, system, compiled, parameters, failure))
            .or_else(|| blocked_drive(model, system, compiled, parameters, failure))
            .or_else(|| switch::jammed(model, last))
            .or_else(|| too_large(model, system, &failure.last)),
        Some(SolveError::StepTooSmall { .. } | SolveError::FixedStepFailed { .. }) | None => {
            blocked_drive(model, system, compiled, parameters, failure)
                .or_else(|| no_value(model, system, compiled, parameters, failure))
                .or_else(|| switch::jammed(model, &failure.last))
                .or_else(|| too_large(model, system, &failure.last))
        }
        // A root at the very edge of its domain stops all steps, too.
        Some(SolveError::TooManySteps { .. }) => {
            no_value(model, system, compiled, parameters, failure)
        }
        _ => None,
    };
    fault.unwrap_or_else(|| {
        let fault = stuck(model, equations, failure);
        let fault = match (&failure.error, &failure.summary.slowness) {
            // Steps of constant size follow nothing.
            (Some(SolveError::TooManySteps { .. }), Some(slowness))
                if model.solve.step.is_none() =>
            {
                with_reasons(fault, (model, system), compiled, parameters, slowness)
            }
            _ => fault,
        };
        at_pole(model, system, failure, &fault.message).unwrap_or(fault)
    })
}

/// A drive whose joint cannot turn further: its row has become dependent on the joints' rows.
///
/// The dead centre itself is not reached. Near it the sine s between the row and the others falls
/// as the square root of the way left, so s² is extrapolated to zero from the last two states.
fn blocked_drive(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    parameters: &[f64],
    failure: &Failure,
) -> Option<Diagnostic> {
    let last = &failure.last;
    let (nq, at) = (last.q.len(), failure.error.as_ref().and_then(SolveError::standstill));
    let (t, q) = match at {
        Some(at) => (at.t, &at.y[..nq]),
        None => (last.t, &last.q[..]),
    };
    let mut evaluator = compiled.evaluator(parameters);
    let mut sines = |t: f64, q: &[f64]| {
        sines_of_drives(model, system, &evaluator.constraints(t, q).jacobian_rows().dense())
    };
    let before = sines(last.t, &last.q);
    let here = sines(t, q);
    let (k, &(drive_id, sine)) = here.iter().enumerate().find(|(_, (_, s))| *s < DEAD_CENTRE)?;
    let fallen = before[k].1.powi(2) - sine.powi(2);
    let left = if fallen > 0.0 { (t - last.t) * sine.powi(2) / fallen } else { 0.0 };
    let t_dead = t + left.clamp(0.0, t - last.t);

    let drive = &model.drives[drive_id.0];
    let message = format!(
        "drive `{}` cannot pass {} = about {} at t = {} s",
        drive.name,
        model.joints[drive.joint.0].name,
        super::words::drive_position(model, drive, t_dead, estimate),
        estimate(t_dead)
    );
    let fault = Diagnostic::error(codes::DRIVE_CANNOT_PASS, message)
        .at(drive.span.clone(), "this motion leads into a dead centre")
        .help("drive a link that can make the full turn, or keep the motion away from the dead centre");
    let in_line = links_in_line(model, system, drive.joint, parameters, q);
    let is_length = unit_of(model, Measure::JointPosition(drive.joint, drive.motion_idx)) == "m";
    let reach = if is_length { reach_note(model, drive, t_dead) } else { None };
    Some([in_line, reach].into_iter().flatten().fold(fault, Diagnostic::note))
}

/// Sine of the angle between each drive's row of G and the span of the joints' rows; of a drive along
/// a line, what is left of its row where that is less, as the row itself vanishes at the end of its
/// reach.
fn sines_of_drives(
    model: &Model,
    system: &SymbolicSystem,
    jacobian: &DMatrix<f64>,
) -> Vec<(DriveId, f64)> {
    let rows = system.constraints.iter().enumerate();
    let joint_rows = rows.clone().filter(|(_, c)| c.source.is_geometric());
    let joint_rows: Vec<usize> = joint_rows.map(|(row, _)| row).collect();
    let sine = |row: usize, jacobian: &DMatrix<f64>| {
        let span = jacobian.select_rows(&joint_rows).transpose();
        let drive_row = jacobian.row(row).transpose();
        let (along, _) = crate::linear::dense::least_squares(&span, &drive_row);
        let rest: DVector<f64> = &drive_row - &span * along;
        [rest.norm() / drive_row.norm(), rest.norm()]
    };
    rows.filter_map(|(row, constraint)| match constraint.source {
        Source::Joint(_)
        | Source::Quaternion(_)
        | Source::Coupling(_)
        | Source::Stop(_)
        | Source::Friction(_) => None,
        Source::Drive(drive_id) => {
            let drive = &model.drives[drive_id.0];
            let [ratio, _] = sine(row, jacobian);
            let measure = Measure::JointPosition(drive.joint, drive.motion_idx);
            if unit_of(model, measure) == "rad" {
                return Some((drive_id, ratio));
            }
            // Angles in units of what moves as far as a length of the loop.
            let mut scaled = jacobian.clone();
            let size = longest_in_loop(model, drive.joint);
            for (mut column, coordinate) in scaled.column_iter_mut().zip(system.coordinates()) {
                if coordinate.kind != CoordinateKind::Length {
                    column /= size;
                }
            }
            let [_, rest] = sine(row, &scaled);
            Some((drive_id, ratio.min(rest)))
        }
    })
    .collect()
}

/// "`coupler` and `rocker` are in line there", if two neighbouring links of the loop are.
fn links_in_line(
    model: &Model,
    system: &SymbolicSystem,
    driven: JointId,
    parameters: &[f64],
    q: &[f64],
) -> Option<String> {
    let around = loop_through(model, driven);
    let n = around.len();
    let mut links: Vec<(BodyId, [f64; 2])> = Vec::new();
    for k in 0..n {
        let ends = |j: JointId| [model.joints[j.0].predecessor, model.joints[j.0].successor];
        let (a, b) = ends(around[k]).into_iter().find_map(|a| {
            let partner = ends(around[(k + 1) % n]).into_iter().find(|b| b.body == a.body);
            partner.map(|b| (a, b))
        })?;
        let place = |anchor| {
            system
                .kinematics
                .anchor(model, anchor)
                .map(|e| evaluate(model, system, e, parameters, q))
        };
        let (from, to) = (place(a), place(b));
        links.push((a.body, [to[0] - from[0], to[1] - from[1]]));
    }
    let sine = |a: [f64; 2], b: [f64; 2]| {
        let product = a[0].hypot(a[1]) * b[0].hypot(b[1]);
        if product == 0.0 { 1.0 } else { ((a[0] * b[1] - a[1] * b[0]) / product).abs() }
    };
    // The driven link and the ground may be in line at any time; the dead centre is elsewhere.
    let joint = &model.joints[driven.0];
    let driven_bodies = [joint.predecessor.body, joint.successor.body];
    let pairs = (0..n).map(|k| (&links[k], &links[(k + 1) % n]));
    let (a, b) = pairs
        .filter(|(a, b)| !driven_bodies.contains(&a.0) && !driven_bodies.contains(&b.0))
        .find(|(a, b)| sine(a.1, b.1) < IN_LINE)?;
    let name = |body: BodyId| &model.bodies[body.0].name;
    Some(format!("`{}` and `{}` are in line there", name(a.0), name(b.0)))
}

fn evaluate(model: &Model, system: &SymbolicSystem, e: Expr, parameters: &[f64], q: &[f64]) -> f64 {
    let value = |symbol: SymbolId| {
        let coordinate = system.coordinates().iter().position(|c| c.q == symbol);
        coordinate.map(|i| q[i]).or_else(|| {
            model.parameters.iter().position(|p| p.symbol == symbol).map(|k| parameters[k])
        })
    };
    model.pool.evaluate(e, &value).unwrap_or(f64::NAN)
}

/// The run stands still for a reason of the integrator's.
fn stuck(model: &Model, equations: &MotionEquations, failure: &Failure) -> Diagnostic {
    let t = failure.summary.t;
    let (code, help) = match &failure.error {
        Some(SolveError::TooManySteps { .. }) if model.solve.step.is_some() => {
            (codes::TOO_MANY_STEPS, "make `step` larger, leave it out, or shorten `t_end`")
        }
        Some(SolveError::TooManySteps { .. }) => (
            codes::TOO_MANY_STEPS,
            "loosen `rtol` or shorten `t_end`; look for a kink or a very stiff spring",
        ),
        Some(SolveError::StepTooSmall { cause: Cause::Singular, .. }) | None => (
            codes::SINGULAR,
            "the constraints lose rank in this pose: start elsewhere, or remove a redundant joint",
        ),
        Some(SolveError::StepTooSmall { .. } | SolveError::FixedStepFailed { .. }) => (
            codes::STEP_TOO_SMALL,
            "loosen `rtol`, or look for a kink, an impact or a singular pose near this time",
        ),
        Some(_) => (codes::STEP_TOO_SMALL, "check the options of `[solve]`"),
    };
    let n_step = failure.summary.stats.n_step;
    let why = match (&failure.error, &failure.summary.slowness) {
        (Some(SolveError::TooManySteps { .. }), Some(slowness)) => {
            format!("after {n_step} steps, the rest would take {} more", short(slowness.steps_left))
        }
        (Some(error), _) => error.to_string(),
        (None, _) => "it met a singular pose that it could not cross".to_owned(),
    };
    let message = format!("the run stopped at t = {} s: {why}", short(t));
    let mut fault = Diagnostic::error(code, message).help(help);
    // Of a run that was slow, more is known.
    let is_slow = failure.summary.slowness.is_some() && code == codes::TOO_MANY_STEPS;
    let at = failure.error.as_ref().and_then(SolveError::standstill);
    if let Some(at) = at.filter(|_| !is_slow) {
        let mut names: Vec<String> = at
            .worst
            .iter()
            .map(|worst| format!("`{}`", equations.layout().name(worst.i)))
            .collect();
        names.dedup();
        if !names.is_empty() {
            fault = fault.note(format!("the worst unknowns: {}", names.join(", ")));
        }
    }
    let inputs = model.inputs.iter().map(|&ParameterId(idx)| &model.parameters[idx].name);
    let inputs: Vec<String> = inputs.map(|name| format!("`{name}`")).collect();
    if !inputs.is_empty() {
        let inputs = inputs.join(", ");
        fault = fault
            .note(format!("functions of the motion: {inputs}; where they jump, steps are small"));
    }
    if let Some((_, span)) = model.solve.spans.iter().find(|(key, _)| key == "t_end") {
        fault = fault.at(span.clone(), "the run was to reach this time");
    }
    fault
}
