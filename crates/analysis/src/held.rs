//! The assembly that `[initial]` chooses, looked for and guessed, so that every start has it.

use std::f64::consts::TAU;

use bksim_model::{
    AssemblyChoice, Axis, BodyId, FoundAssembly, Initial, JointId, Measure, Model, Space,
    motion_words,
};

use crate::assemblies::{Assembly, assemblies_of, held};
use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::quantity::PoseQuantity;

/// `model` with the pose of the assembly that it chooses as the guess of its start; a model that chooses none as it
/// is. Stated values stay; other guesses of positions are left out.
///
/// # Errors
/// [`AnalysisError`] when the start does not close, or there is no such assembly.
pub fn with_held_assembly(mut model: Model) -> Result<Model, AnalysisError> {
    let Some(mut chosen) = model.assembly.take() else { return Ok(model) };
    if chosen.found.is_some() {
        model.assembly = Some(chosen);
        return Ok(model);
    }
    let positions = Positions::of(model.snapshot().to_model())?;
    let all = assemblies_of(&positions)?;
    let wanted = |a: &&Assembly| match &chosen.choice {
        AssemblyChoice::Number(number) => a.number == *number,
        AssemblyChoice::Name(name) => a.name == *name,
    };
    let Some(assembly) = all.assemblies.iter().find(wanted) else {
        return Err(AnalysisError::NoAssembly {
            choice: chosen.choice.clone(),
            span: chosen.span.clone(),
            known: all.assemblies.iter().map(|a| (a.number, a.name.clone())).collect(),
        });
    };
    let (held, _) = held(&positions)?;
    let written = model.initial.clone();
    chosen.found =
        Some(FoundAssembly { number: assembly.number, name: assembly.name.clone(), held, written });

    // Its pose takes the place of all guesses of positions.
    let q = near_start(&positions, &assembly.q);
    let guesses = pose_measures(&model);
    let quantity = |(name, measure): &(String, Measure)| positions.quantity_of(name, *measure);
    let quantities: Vec<PoseQuantity> = guesses.iter().map(quantity).collect();
    let values = positions.scalars(&quantities)?.values(positions.t(), &q);
    model.initial.retain(|initial| !initial.is_guess || initial.measure.is_velocity());
    for ((name, measure), value) in guesses.into_iter().zip(values) {
        let is_stated = model.initial.iter().any(|initial| initial.measure == measure);
        // At a pole an angle has no value.
        if is_stated || !value.is_finite() {
            continue;
        }
        let (value, span) = (model.pool.float(value), chosen.span.clone());
        model.initial.push(Initial { measure, value, is_guess: true, name, span });
    }
    model.assembly = Some(chosen);
    Ok(model)
}

/// Coordinates with their angles within half a turn of those of the start.
fn near_start(positions: &Positions, q: &[f64]) -> Vec<f64> {
    let coordinates = positions.system().coordinates().iter();
    let is_turn = coordinates.map(|c| c.kind == bksim_mbs::coordinate::CoordinateKind::Angle);
    let near = |((q, start), is_turn): ((&f64, &f64), bool)| {
        if is_turn { q + TAU * ((start - q) / TAU).round() } else { *q }
    };
    q.iter().zip(&positions.q).zip(is_turn).map(near).collect()
}

/// Positions of all joints, and where all bodies are.
fn pose_measures(model: &Model) -> Vec<(String, Measure)> {
    let mut all = Vec::new();
    for (idx, joint) in model.joints.iter().enumerate() {
        let motions = joint.kind.motions();
        for motion_idx in 0..motions.len() {
            let [word, ..] = motion_words(motions, motion_idx);
            let measure = Measure::JointPosition(JointId(idx), motion_idx);
            all.push((format!("{}.{word}", joint.name), measure));
        }
    }
    for (idx, body) in model.bodies.iter().enumerate().skip(1) {
        let mut push = |word: &str, measure| all.push((format!("{}.{word}", body.name), measure));
        let body = BodyId(idx);
        push("x", Measure::PointPosition(body, None, Axis::X));
        push("y", Measure::PointPosition(body, None, Axis::Y));
        if model.space == Space::Planar {
            push("angle", Measure::BodyAngle(body));
            continue;
        }
        push("z", Measure::PointPosition(body, None, Axis::Z));
        for (axis, word) in [(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")] {
            for (own, of) in [(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")] {
                push(&format!("{word}{of}"), Measure::DirectionCosine(body, axis, own));
            }
        }
    }
    all
}
