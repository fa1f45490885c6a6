//! Starts at rest in a dead centre: the loads balance there, though they would move the mechanism on from any place
//! near it.
//!
//! ```text
//! v = 0, v′ = 0                             nothing moves
//! δ · M v′(q + s δ) > 0 for s > 0 or, with −δ, s < 0      and next to it the motion goes away
//! ```
//!
//! δ is a free motion, brought onto the constraints of the place next to the start.

use nalgebra::{DMatrix, DVector};

use super::words::unit_of;
use crate::codes;
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::linear::dense::least_squares;
use crate::multiplier::largest;
use crate::start::Start;
use bksim_mbs::coordinate::Owner;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{Measure, Model, motion_words};

/// Larger mechanisms are not looked at.
const MOST_COORDINATES: usize = 60;
/// The way from the start, rad or m.
const NEXT_TO: f64 = 1e-4;
/// Accelerations below this are those of rest.
const REST: f64 = 1e-9;

/// The warning of a start at rest from which any disturbance grows.
pub(super) fn at_rest(
    (model, system): (&Model, &SymbolicSystem),
    (compiled, parameters): (&CompiledSystem, &[f64]),
    start: &Start,
) -> Option<Diagnostic> {
    let load = model.loads.first()?;
    let is_at_rest = start.v.iter().all(|v| *v == 0.0) && largest(&start.a) <= REST;
    let switches =
        !compiled.indicators.is_empty() || model.held.iter().any(|signal| !signal.is_count());
    let acts_by_itself =
        !model.states.is_empty() || !model.inputs.is_empty() || !model.drives.is_empty();
    let is_timed = model
        .loads
        .iter()
        .flat_map(|load| load.kind.expressions())
        .any(|e| model.pool.depends_on(e, model.time));
    let n = start.q.len();
    if !is_at_rest || switches || acts_by_itself || is_timed || n > MOST_COORDINATES {
        return None;
    }
    let mut evaluator = compiled.evaluator(parameters);
    let rows = evaluator.constraints(start.t, &start.q).jacobian_rows().dense();
    let direction = free_motions(&rows).into_iter().find(|direction| {
        [1.0, -1.0]
            .into_iter()
            .any(|side| goes_on((compiled, parameters), start, &(direction * side)) == Some(true))
    })?;

    // The joint that moves most, of those that the file states where one of them moves.
    let coordinates = system.coordinates();
    let is_stated = |i: usize| {
        let Owner::Joint(joint, motion_idx) = coordinates[i].owner else { return false };
        let measure = Measure::JointPosition(joint, motion_idx);
        let moves = direction[i].abs() > 0.1 * direction.amax();
        moves && model.initial.iter().any(|of| of.measure == measure && !of.is_guess)
    };
    let of_joint = (0..n).filter(|&i| matches!(coordinates[i].owner, Owner::Joint(..)));
    let most = of_joint.max_by(|&a, &b| {
        let by_size = direction[a].abs().total_cmp(&direction[b].abs());
        is_stated(a).cmp(&is_stated(b)).then(by_size)
    });
    let example =
        most.map(|i| next_to(model, &coordinates[i].owner, start.q[i])).unwrap_or_default();
    let loads = match model.loads.len() {
        1 => format!("load `{}` has", load.name),
        _ => "all loads together have".to_owned(),
    };
    let message = format!(
        "the mechanism starts at rest in a dead centre: {loads} no arm there, and nothing sets it in motion"
    );
    Some(
        Diagnostic::warning(codes::AT_DEAD_CENTRE, message)
            .at(load.span.clone(), "balanced at the start, and nowhere near it")
            .note(format!(
                "every acceleration is 0; {} rad or m away it would move on",
                short(NEXT_TO)
            ))
            .help(format!("start a little off it{example}, or with a rate")),
    )
}

/// A start next to this one, for a help.
fn next_to(model: &Model, owner: &Owner, q: f64) -> String {
    let Owner::Joint(joint, motion_idx) = *owner else { return String::new() };
    let own = Measure::JointPosition(joint, motion_idx);
    let joint = &model.joints[joint.0];
    let [word, ..] = motion_words(joint.kind.motions(), motion_idx);
    let value = match word {
        "position" => format!("{} m", short(q + 1e-3)),
        _ => format!("{} deg", short(q.to_degrees() + 1.0)),
    };
    // What is stated by the name of a coordinate stays so, and what else is stated would hold the start where it is.
    let stated = || model.initial.iter().filter(|initial| !initial.is_guess);
    let name = stated().find(|initial| initial.measure == own).map(|initial| &initial.name);
    let others = stated().filter(|initial| {
        initial.measure != own && matches!(unit_of(model, initial.measure), "m" | "rad")
    });
    let others: Vec<&str> = others.map(|initial| initial.name.as_str()).collect();
    let guesses = match others.as_slice() {
        [] => String::new(),
        names => format!(" and guesses of `{}`", names.join("`, `")),
    };
    let plain = name.filter(|name| !name.contains('.'));
    let start = plain.map_or_else(
        || format!("{} = {{ {word} = \"{value}\" }}", joint.name),
        |name| format!("{name} = \"{value}\""),
    );
    format!(", for example `{start}`{guesses} in `[initial]`")
}

/// Orthogonal directions that keep the constraints to first order, each of length one.
fn free_motions(rows: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let n = rows.ncols();
    let mut found: Vec<DVector<f64>> = Vec::new();
    for i in 0..n {
        let mut direction = DVector::zeros(n);
        direction[i] = 1.0;
        let mut direction = kept(rows, &direction);
        for known in &found {
            direction -= known * known.dot(&direction);
        }
        let size = direction.norm();
        if size > 0.1 {
            found.push(direction / size);
        }
    }
    found
}

/// The part of a direction that keeps the constraints to first order.
fn kept(rows: &DMatrix<f64>, direction: &DVector<f64>) -> DVector<f64> {
    if rows.nrows() == 0 {
        return direction.clone();
    }
    let (along, _) = least_squares(&rows.transpose(), direction);
    direction - rows.transpose() * along
}

/// Whether the mechanism goes on in a direction once it is a little way along it; `None` where it cannot be there.
fn goes_on(
    (compiled, parameters): (&CompiledSystem, &[f64]),
    start: &Start,
    direction: &DVector<f64>,
) -> Option<bool> {
    const CLOSED: f64 = 1e-11;
    let mut evaluator = compiled.evaluator(parameters);
    let (t, n) = (start.t, start.q.len());
    let mut q = DVector::from_column_slice(&start.q) + direction * NEXT_TO;
    let rows = loop_closed(&mut evaluator, t, &mut q, CLOSED)?;
    let direction = kept(&rows, direction);

    // The force along the motion, of the accelerations there.
    let mut multipliers = compiled.multiplier_system(&start.dependence.dependent);
    let (mut a, mut lambda) = (vec![0.0; n], vec![0.0; compiled.nc()]);
    let v = vec![0.0; n];
    multipliers.complete_into(&mut evaluator, t, (q.as_slice(), &v), &mut a, &mut lambda).ok()?;
    let inertia = evaluator.dynamics(t, q.as_slice(), &v).inertia_of(&a);
    let force = DVector::from_column_slice(&inertia).dot(&direction);
    let noise = 1e-10 * (1.0 + largest(&lambda));
    Some(force > noise.max(1e-3 * NEXT_TO * largest(&inertia)))
}

/// Brings a position onto the constraints; their slopes there.
fn loop_closed(
    evaluator: &mut Evaluator<'_>,
    t: f64,
    q: &mut DVector<f64>,
    tolerance: f64,
) -> Option<DMatrix<f64>> {
    for _ in 0..6 {
        let at = evaluator.constraints(t, q.as_slice());
        let (value, rows) = (DVector::from_column_slice(at.value), at.jacobian_rows().dense());
        if value.amax() <= tolerance || value.is_empty() {
            return Some(rows);
        }
        let (by, _) = least_squares(&rows, &value);
        *q -= by;
    }
    None
}
