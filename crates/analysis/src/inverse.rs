//! Inverse dynamics: a motion gives the efforts of the actuators, all reactions, and the power.
//!
//! ```text
//! positions, velocities and accelerations from the constraints and the prescribed motions
//! Gᵀ λ = f − M a        the efforts of the actuators are the multipliers of their rows
//! ```
//!
//! More actuators than free motions share the load by the smallest efforts, and fewer leave something out: see
//! [`crate::actuation`]. States of controllers follow the motion by their own rates: see [`crate::controllers`].

use bksim_mbs::constraint::Source;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_model::{Drive as ModelDrive, Initial, Measure, Model};
use bksim_sim::state::{AccelerationRef, StateRef};
use nalgebra::DMatrix;

use crate::PoseQuantity;
use crate::actuation::{Actuation, EffortLimit, Efforts};
use crate::controllers::{controller_states, with_held};
use crate::drive::Range;
use crate::duty::MotorCurve;
use crate::effort_channels::{Channel, act, channels, quantities};
use crate::effort_record::{Inverse, Record};
use crate::error::AnalysisError;
use crate::forces::{At, Forces};
use crate::loaded::{Loaded, known_along_a_motion};
use crate::motion::Motion;
use crate::positions::Positions;
use crate::rows::Clock;
use crate::walk::Walk;

/// The actuators, and how much each can give.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Actuators {
    /// Joints or drives that have an effort; the drives of the model and the joints of the motions where there are none.
    pub named: Vec<String>,
    /// Limits of efforts.
    pub limits: Vec<EffortLimit>,
    /// Curves of motors.
    pub curves: Vec<MotorCurve>,
}

/// Efforts that make `model` follow `motions`, and its own drives, at `times`.
///
/// # Errors
/// [`AnalysisError`] when there is no start, motions are left free, or the motion cannot be followed.
pub fn inverse(
    mut model: Model,
    motions: &[Motion],
    times: &Range,
    actuators: &Actuators,
) -> Result<Inverse, AnalysisError> {
    known_along_a_motion(&model, times)?;
    let mut channels = channels(&mut model, motions, &actuators.named)?;
    check_named(&model, &channels, actuators)?;
    let forced = model.snapshot();

    // Positions: each motion of a joint is a drive of the start.
    let n_own = model.drives.len();
    prescribe_start(&mut model, motions, times.from);
    let positions = Positions::of(model)?;
    positions.leads_on()?;
    let measures: Vec<Measure> = motions.iter().map(|m| m.measure).collect();
    let added: Vec<usize> = (n_own..positions.model().drives.len()).collect();
    let mut rows = positions.rows(&measures, &added, Clock::Running)?;
    let begin = || Walk { x: rows.scaled(&positions.q), t: times.from, motions };
    let (mut walk, mut first_walk) = (begin(), begin());
    walk.check_drives(&mut rows, positions.model().drives.len())?;

    // Forces of the same mechanism, masses and loads included, with a drive for each actuator.
    let mut forced = forced.to_model();
    act(&mut forced, &mut channels);
    (forced.solve.t_start, forced.solve.t_end) = (times.from, times.to);
    let mechanism = bksim_sim::Mechanism::derive(forced, Vec::new())?;
    let loaded = Loaded::at_position(mechanism, &positions);
    let system = loaded.system();
    let mut forces =
        Forces::compile(loaded.model(), system, &loaded.kept, &[], &loaded.parameters)?;
    let quantities = quantities(&loaded, &channels);
    let mut rates = loaded.rates(&quantities)?;
    let mut slopes = loaded.scalars(&quantities)?;
    let actuation = actuation(&loaded, &channels, &quantities, &actuators.limits);

    // States of controllers first, then what all forces need.
    let times = times.values();
    let states = controller_states(&loaded, &mut |t| first_walk.to(&mut rows, t), &times)?;
    let mut record = Record::default();
    for (&t, controllers) in times.iter().zip(states) {
        let [mut q, mut v, mut a] = walk.to(&mut rows, t).ok_or(AnalysisError::Lost { t })?;
        let n_moving = q.len();
        // Integrals of states are the last coordinates, and nothing depends on them.
        q.resize(n_moving + controllers.z.len(), 0.0);
        v.extend_from_slice(&controllers.z);
        a.extend_from_slice(&controllers.rates);
        let parameters = with_held(&loaded.parameters, &controllers.held);
        if !controllers.held.is_empty() {
            forces.set_parameters(&parameters);
        }
        let nothing = vec![0.0; forces.nc()];
        let at = forces.at(At { t, q: &q, v: &v, a: &a, lambda: &nothing, p: &[] });
        let gradients = slopes.gradients(t, &q);
        let prescribed: Vec<usize> =
            (0..channels.len()).filter(|&k| channels[k].is_prescribed).collect();
        let along =
            DMatrix::from_fn(prescribed.len(), n_moving, |k, i| gradients[prescribed[k]][i]);
        let Efforts { lambda, missing, inner } =
            actuation.efforts(&at, &along).ok_or(AnalysisError::Lost { t })?;
        let mut lambda = forces.all_multipliers(system.constraints.len(), &lambda);
        let reactions = loaded.reactions(t, &parameters, [&q, &v, &a], &mut lambda);
        let mut evaluator = loaded.mechanism.compiled.evaluator(&parameters);
        let (state, rates_there) =
            (StateRef { t, q: &q, v: &v }, AccelerationRef { a: &a, lambda: &lambda });
        record.signals.push(evaluator.signals(state, rates_there).to_vec());
        record.controllers.push(controllers);
        record.shown.push(rates.at(t, [&q, &v, &a]));
        record.efforts.push(efforts_of(&loaded, &channels, &lambda));
        record.missing.push(missing);
        record.inner.push(inner);
        record.reactions.push(reactions.concat());
        record.times.push(t);
    }
    let bounds = (actuators.limits.as_slice(), actuators.curves.as_slice());
    Ok(record.told(&loaded, (&channels, &quantities), bounds))
}

/// Refuses limits and curves of what is no actuator, and curves of another kind.
fn check_named(
    model: &Model,
    channels: &[Channel],
    Actuators { limits, curves, .. }: &Actuators,
) -> Result<(), AnalysisError> {
    let acting: Vec<&Channel> = channels.iter().filter(|c| c.drive_idx.is_some()).collect();
    let of = |name: &str| {
        let unknown = || AnalysisError::NoActuator {
            name: name.to_owned(),
            known: acting.iter().map(|channel| channel.name.clone()).collect(),
        };
        acting.iter().find(|channel| channel.name == name).ok_or_else(unknown)
    };
    limits.iter().try_for_each(|limit| of(&limit.name).map(drop))?;
    curves.iter().try_for_each(|curve| {
        let turns = of(&curve.name)?.measure.unit(model) == "rad";
        curve.check_units(turns)
    })
}

/// States where the motions begin: drives of joints, values of other measures.
fn prescribe_start(model: &mut Model, motions: &[Motion], from: f64) {
    model.solve.t_start = from;
    for motion in motions {
        let start = model.pool.float((motion.law)(from)[0]);
        match motion.measure {
            Measure::JointPosition(joint, motion_idx) => {
                let (span, name) = {
                    let of = &model.joints[joint.0];
                    (of.span.clone(), of.name.clone())
                };
                model.drives.push(ModelDrive { name, joint, motion_idx, motion: start, span });
            }
            measure => {
                model.initial.retain(|initial| initial.measure != measure);
                let (name, span) = (motion.name.clone(), 0..0);
                model.initial.push(Initial { measure, value: start, is_guess: false, name, span });
            }
        }
    }
    // What is stated of a driven joint would be stated twice.
    let is_driven = |measure: Measure| {
        model.drives.iter().any(|d| {
            measure == Measure::JointPosition(d.joint, d.motion_idx)
                || measure == Measure::JointVelocity(d.joint, d.motion_idx)
        })
    };
    model.initial.retain(|initial| !is_driven(initial.measure));
    let is_motion = |measure: Measure| motions.iter().any(|m| m.measure == measure);
    for initial in model.initial.iter_mut().filter(|initial| !is_motion(initial.measure)) {
        initial.is_guess = true;
    }
}

fn actuation(
    loaded: &Loaded,
    channels: &[Channel],
    quantities: &[PoseQuantity],
    limits: &[EffortLimit],
) -> Actuation {
    let system = loaded.system();
    let is_acting =
        |&k: &usize| matches!(system.constraints[loaded.kept[k]].source, Source::Drive(_));
    let (acting, bearing): (Vec<usize>, Vec<usize>) = (0..loaded.kept.len()).partition(is_acting);
    let actuators = || channels.iter().zip(quantities).filter(|(c, _)| c.drive_idx.is_some());
    // Efforts without a limit weigh as those with the largest.
    let own = |name: &str| limits.iter().find(|l| l.name == name).map(|l| l.limit);
    let largest = limits.iter().fold(0.0, |most: f64, l| most.max(l.limit));
    let weight = |(channel, quantity): (&Channel, &PoseQuantity)| {
        let unit = if quantity.is_angle() { loaded.size } else { 1.0 };
        own(&channel.name).unwrap_or(if largest > 0.0 { largest } else { unit })
    };
    let unit_of_column = system
        .coordinates()
        .iter()
        .map(|c| if c.kind == CoordinateKind::Length { loaded.size } else { 1.0 });
    let prescribed = channels.iter().zip(quantities).filter(|(c, _)| c.is_prescribed);
    let unit_of_motion = prescribed.map(|(_, q)| if q.unit == "m" { loaded.size } else { 1.0 });
    Actuation {
        bearing,
        acting,
        weights: actuators().map(weight).collect(),
        unit_of_column: unit_of_column.collect(),
        unit_of_motion: unit_of_motion.collect(),
    }
}

/// The efforts of the actuators, in the order of their drives.
fn efforts_of(loaded: &Loaded, channels: &[Channel], lambda: &[f64]) -> Vec<f64> {
    let constraints = &loaded.system().constraints;
    let effort = |drive_idx: usize| {
        let is_own = |c: &bksim_mbs::constraint::Constraint| matches!(c.source, Source::Drive(id) if id.0 == drive_idx);
        constraints.iter().position(is_own).map_or(0.0, |row| lambda[row])
    };
    channels.iter().filter_map(|c| c.drive_idx).map(effort).collect()
}
