//! [`Panels`]: answers as small pictures, a panel each: where all bodies are, in one pose or in several that follow each
//! other, and what is marked on them.

use std::f64::consts::TAU;

use bksim_expr::TapeError;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{JointId, Model};
use bksim_sim::Mechanism;
use bksim_sim::pose::{Pose, Poses};

use crate::assemblies::{Assemblies, Assembly, assemblies, without_held_pose};
use crate::doctor::{Condition, Doctor, Placed, PlacedPose, doctor};
use crate::error::AnalysisError;
use crate::positions::Positions;

/// Small pictures of one mechanism.
#[derive(Debug)]
pub struct Panels {
    /// The mechanism.
    pub model: Model,
    /// Values of its parameters.
    pub parameters: Vec<f64>,
    /// The pictures.
    pub panels: Vec<Panel>,
}

/// A small picture.
#[derive(Clone, PartialEq, Debug)]
pub struct Panel {
    /// Title of the panel.
    pub title: String,
    /// Poses of all bodies, the ground first: one, or those of a motion to and fro, in equal steps.
    pub frames: Vec<Vec<Pose>>,
    /// The marks in the first of them.
    pub marks: Vec<Mark>,
}

/// A condition of a joint: a direction at a point, world axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Mark {
    /// m.
    pub at: [f64; 3],
    /// Of length one.
    pub along: [f64; 3],
    /// A moment; else a force.
    pub is_moment: bool,
    /// Others keep it already; else it is one of these others.
    pub is_repeated: bool,
}

/// Poses of a motion to and fro.
const FRAMES: usize = 24;
/// The largest turn, rad, and the largest way, longest links, to either side.
const VISIBLE: [f64; 2] = [0.3, 0.25];

/// The ways in which the start of `model` closes, a panel each.
///
/// # Errors
/// As [`assemblies`].
pub fn assembly_panels(model: Model) -> Result<(Assemblies, Panels), AnalysisError> {
    let found = assemblies(model.snapshot().to_model())?;
    let (model, _) = without_held_pose(model);
    let Mechanism { model, system, parameters, .. } = Mechanism::positions(model)?;
    let all = found.assemblies.iter().map(|a| a.q.as_slice());
    let poses = poses(&model, &system, &parameters, all)?;
    let panel = |(a, pose): (&Assembly, Vec<Pose>)| Panel {
        title: format!("{}  {}", a.number, a.name),
        frames: vec![pose],
        marks: Vec::new(),
    };
    let panels = found.assemblies.iter().zip(poses).map(panel).collect();
    Ok((found, Panels { model, parameters, panels }))
}

/// The free motions of `model`, each as a motion to and fro, and the conditions that repeat others, a panel each.
///
/// # Errors
/// As [`doctor`].
pub fn doctor_panels(model: Model) -> Result<(Doctor, Panels), AnalysisError> {
    let written = model.snapshot();
    let found = doctor(model)?;
    let positions = crate::doctor::start(written.to_model())?;
    let placed = Placed::of(positions.model(), &PlacedPose::of(&positions)?)?;
    let mut panels = Vec::new();
    for (k, motion) in found.motions.iter().enumerate() {
        let all = to_and_fro(&placed, &motion.direction);
        let states = all.iter().map(Vec::as_slice);
        let frames = poses(&placed.model, &placed.system, &placed.parameters, states)?;
        let first = motion.rates.first().map_or("", |(name, ..)| name.as_str());
        let ends = if motion.is_finite { "" } else { ", in this pose alone" };
        let title = format!("free motion {}: {first}{ends}", k + 1);
        panels.push(Panel { title, frames, marks: Vec::new() });
    }
    let at_rest = poses(
        &placed.model,
        &placed.system,
        &placed.parameters,
        std::iter::once(placed.q.as_slice()),
    )?;
    for repeated in &found.repeated {
        let own = mark(&positions, &repeated.condition, true)?;
        let mut marks: Vec<Mark> = own.into_iter().collect();
        for condition in &repeated.by {
            marks.extend(mark(&positions, condition, false)?);
        }
        let title = format!("repeats others: {}", repeated.condition.words);
        panels.push(Panel { title, frames: at_rest.clone(), marks });
    }
    let Placed { model, parameters, .. } = placed;
    Ok((found, Panels { model, parameters, panels }))
}

/// Coordinates of a free motion to and fro.
fn to_and_fro(placed: &Placed, direction: &[f64]) -> Vec<Vec<f64>> {
    let coordinates = placed.system.coordinates();
    let largest = |is_length: bool| {
        let own = coordinates.iter().zip(direction).filter(|(coordinate, _)| {
            (coordinate.kind == bksim_mbs::coordinate::CoordinateKind::Length) == is_length
        });
        own.map(|(_, d)| d.abs()).fold(0.0, f64::max)
    };
    let [turn, way] = [(VISIBLE[0], false), (VISIBLE[1], true)]
        .map(|(visible, is_length)| visible / largest(is_length));
    let far = turn.min(way);
    let at = |k: usize| {
        let aside = far * (TAU * k as f64 / FRAMES as f64).sin();
        let moved = placed.q.iter().zip(direction.iter().zip(&placed.units));
        let moved: Vec<f64> = moved.map(|(q, (d, unit))| q + aside * d * unit).collect();
        // Farther than the mechanism can go it is drawn as the small motion goes on.
        placed.closed(moved.clone()).unwrap_or(moved)
    };
    (0..FRAMES).map(at).collect()
}

/// Poses of all bodies in some positions.
fn poses<'a>(
    model: &Model,
    system: &SymbolicSystem,
    parameters: &[f64],
    all: impl Iterator<Item = &'a [f64]>,
) -> Result<Vec<Vec<Pose>>, TapeError> {
    let at_rest = vec![0.0; system.coordinates().len()];
    Ok(Poses::compile(model, system)?.at(parameters, all.map(|q| (q, at_rest.as_slice()))))
}

/// The place and the direction of a condition, if it has one direction.
fn mark(
    positions: &Positions,
    condition: &Condition,
    is_repeated: bool,
) -> Result<Option<Mark>, AnalysisError> {
    let (model, system) = (positions.model(), positions.system());
    let joint = model.joints.iter().position(|joint| joint.name == condition.of);
    let (Some(joint), Some(axis)) = (joint.map(JointId), condition.axis) else { return Ok(None) };
    let pool = &model.pool;
    let sides = system.kinematics.sides(model, &model.joints[joint.0]);
    let axis = axis.map(|x| pool.float(x));
    let along = sides.predecessor.rotation.apply(pool, &axis);
    let outputs = [sides.p_world_predecessor, along].concat();
    let parameters = &positions.mechanism.parameters;
    let mut scalars = crate::scalar::Scalars::compile(model, system, &outputs, parameters)?;
    let values = scalars.values(positions.t(), &positions.q);
    let [at, along] = [0, 3].map(|first| [0, 1, 2].map(|i| values[first + i]));
    Ok(Some(Mark { at, along, is_moment: condition.effort == "moment", is_repeated }))
}
