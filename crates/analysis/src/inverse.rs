//! Inverse dynamics: a motion gives the efforts of the actuators, all reactions, and the power.
//!
//! ```text
//! positions, velocities and accelerations from the constraints and the prescribed motions
//! Gᵀ λ = f − M a        the efforts of the actuators are the multipliers of their rows
//! ```
//!
//! Friction acts as in a run, and stops bear: see [`crate::effort_contacts`]. More actuators than free motions share the load by
//! the smallest efforts, and a motion that none of them can meet is refused: see [`crate::actuation`]. States of controllers follow the motion by their own rates: see [`crate::controllers`].

use bksim_expr::PoolSnapshot;
use bksim_mbs::constraint::Source;
use bksim_mbs::contact::Penetration;
use bksim_model::{Drive as ModelDrive, Initial, Measure, Model};
use bksim_sim::state::{AccelerationRef, StateRef};

use crate::actuation::EffortLimit;
use crate::controllers::{ControllerState, controller_states, with_held};
use crate::curve::independent_rows;
use crate::drive::Range;
use crate::duty::MotorCurve;
use crate::effort_channels::{Channel, act, channels, quantities};
use crate::effort_faults::stop_lets_go;
use crate::effort_record::{Inverse, Record};
use crate::effort_solver::{EffortSolver, InstantState, SolvedEfforts, all_rows};
use crate::effort_stops::{MotionState, N_PARTS, StopWatch};
use crate::error::AnalysisError;
use crate::loaded::{Loaded, known_along_a_motion, without_free_shapes, without_rates};
use crate::motion::Motion;
use crate::positions::Positions;
use crate::rows::{Clock, Rows};
use crate::table::Column;
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
    model.forget_turns();
    motions.iter().try_for_each(|motion| motion.check_times(times))?;
    without_rates(&model)?;
    let mut channels = channels(&mut model, motions, &actuators.named)?;
    check_named(&model, &channels, actuators)?;
    let forced = model.snapshot();
    let mut path = GivenPath::of(model, &forced, motions, times.from)?;
    let begin = |rows: &Rows, positions: &Positions| Walk {
        x: rows.scaled(&positions.q),
        t: positions.t(),
        motions,
    };
    let [mut walk, mut first_walk] = [(); 2].map(|()| begin(&path.rows, &path.positions));

    // Forces of the same mechanism, masses and loads included, with a drive for each actuator.
    let mut forced = forced.to_model();
    act(&mut forced, &mut channels);
    (forced.solve.t_start, forced.solve.t_end) = (times.from, times.to);
    let mechanism = bksim_sim::Mechanism::derive(forced, Vec::new())?;
    let mut loaded = Loaded::at_position(mechanism, &path.positions);
    loaded.kept = (0..loaded.system().constraints.len()).collect();
    let quantities = quantities(&loaded, &channels);
    let mut rates = loaded.rates(&quantities)?;
    let bearing = path.bearing_rows(&loaded);
    let mut solver =
        EffortSolver::of(&loaded, (&channels, &quantities), &actuators.limits, bearing)?;

    // The motion and the states of controllers first, then what all forces need.
    let times = times.values();
    let states = path.follow(&mut walk, &times)?;
    solver.measure(&states);
    let rows = &mut path.rows;
    let controllers = controller_states(&loaded, &mut |t| first_walk.to(rows, t), &times)?;
    let mut record = Record::default();
    for ((&t, [q, v, a]), controllers) in times.iter().zip(states).zip(controllers) {
        let n_moving = q.len();
        let [q, v, a] = with_states([q, v, a], &controllers);
        let parameters = with_held(&loaded.parameters, &controllers.held);
        let instant = InstantState { t, state: [&q, &v, &a], n_moving, parameters: &parameters };
        let first = times.first().copied().unwrap_or(t);
        let last = record.times.last().copied().unwrap_or(t);
        let n_parts = N_PARTS.div_ceil(times.len());
        let pull = path.pull_between((&mut walk, &loaded, &mut solver), (last, t), n_parts);
        if let Some((stop, at)) = pull {
            return Err(stop_lets_go(solver.contact(stop), at, first));
        }
        let solved = solver.at(instant)?;
        if let Some(stop) = solver.pulling(&solved) {
            let at = path.let_go((&mut walk, &loaded, &mut solver), (last, t));
            return Err(stop_lets_go(solver.contact(stop), at, first));
        }
        let (ranges, open) = solver.ranges(instant, &solved);
        let SolvedEfforts { found, equations, parameters, .. } = solved;
        let parts = solver.missing_parts(&found);
        record.note_missing(t, (&q, &equations.free), (&parts, found.size));
        let mut lambda = all_rows(loaded.system().constraints.len(), &found.efforts.lambda);
        let reactions = loaded.reactions(t, &parameters, [&q, &v, &a], &mut lambda);
        let mut evaluator = loaded.mechanism.compiled.evaluator(&parameters);
        let (state, rates_there) =
            (StateRef { t, q: &q, v: &v }, AccelerationRef { a: &a, lambda: &lambda });
        record.signals.push(evaluator.signals(state, rates_there).to_vec());
        record.controllers.push(controllers);
        record.shown.push(rates.at(t, [&q, &v, &a]));
        record.efforts.push(efforts_of(&loaded, &channels, &lambda));
        record.missing.push(found.efforts.missing[..parts.len()].to_vec());
        record.note_ranges(ranges, equations.n_inner(), open);
        record.reactions.push(reactions.concat());
        record.times.push(t);
    }
    record.check_met(&loaded, &channels)?;
    let bounds = (actuators.limits.as_slice(), actuators.curves.as_slice());
    let found = record.told(&loaded, (&channels, &quantities), bounds);
    // Ranges of efforts may have no bound.
    let is_range = |column: &Column| {
        column.name.ends_with(".effort_min") || column.name.ends_with(".effort_max")
    };
    found.table.check_numbers(is_range)?;
    Ok(found)
}

/// Positions, velocities and accelerations of all coordinates: integrals of states are the last ones, and nothing
/// depends on them.
fn with_states([mut q, mut v, mut a]: MotionState, controllers: &ControllerState) -> MotionState {
    q.resize(q.len() + controllers.z.len(), 0.0);
    v.extend_from_slice(&controllers.z);
    a.extend_from_slice(&controllers.rates);
    [q, v, a]
}

/// The positions that motions and drives prescribe.
struct GivenPath {
    positions: Positions,
    rows: Rows,
    stops: StopWatch,
}

impl GivenPath {
    /// Positions of `model` from a time on. Stops that the motion needs are closed at the start of the model; where they are not at
    /// that time, the motion is followed from there.
    fn of(
        model: Model,
        written: &Model<PoolSnapshot>,
        motions: &[Motion],
        from: f64,
    ) -> Result<Self, AnalysisError> {
        let is_stop = |load: &bksim_model::Load| load.kind.limits().is_some();
        let has_stops = written.loads.iter().any(is_stop);
        let t_start = written.solve.t_start;
        match Self::begin(model, motions, from) {
            Err(AnalysisError::NMotions { .. }) if has_stops && t_start != from => {
                Self::begin(written.to_model(), motions, t_start)
            }
            found => found,
        }
    }

    fn begin(mut model: Model, motions: &[Motion], from: f64) -> Result<Self, AnalysisError> {
        // Each motion of a joint is a drive of the start.
        let n_own = model.drives.len();
        prescribe_start(&mut model, motions, from);
        let positions = Positions::of(model)?;
        positions.leads_on()?;
        let measures: Vec<Measure> = motions.iter().map(|m| m.measure).collect();
        let n_driven = positions.model().drives.len();
        let added: Vec<usize> = (n_own..n_driven).collect();
        let mut stops = StopWatch::of(&positions)?;
        let n_left = |rows: &mut Rows| {
            let x = rows.scaled(&positions.q);
            let jacobian = rows.at(from, &x, &[]).jacobian;
            jacobian.ncols() - independent_rows(&jacobian).len()
        };
        let mut rows = stops.hold(&positions, (&measures, &added), &n_left)?;
        match n_left(&mut rows) {
            0 => Ok(Self { positions, rows, stops }),
            n => {
                let open = stops.open_ones(&positions, (&measures, &added), (&n_left, n))?;
                let left = left_free(&positions, measures, (&stops, &added), (&n_left, n));
                without_free_shapes(positions.model(), &left)?;
                let (n_free, n_prescribed) = (n_driven + n, n_driven);
                Err(AnalysisError::NMotions { n_free, n_prescribed, left, open })
            }
        }
    }

    fn follow(
        &mut self,
        walk: &mut Walk<'_>,
        times: &[f64],
    ) -> Result<Vec<MotionState>, AnalysisError> {
        self.stops.follow(&self.positions, (walk, &mut self.rows), times)
    }

    /// The constraint rows of stops that bear throughout.
    fn bearing_rows(&self, loaded: &Loaded) -> Vec<usize> {
        let rows = &loaded.system().constraints;
        let row = |limit: &Penetration| {
            rows.iter().position(|row| {
                row.source == Source::Stop(limit.load) && row.direction == limit.direction
            })
        };
        self.stops.bearing().filter_map(row).collect()
    }

    /// A stop that bears throughout and would have to pull between two times, though at neither of them, and when first; `None` of
    /// a mechanism with controllers, whose states are known at the times alone.
    fn pull_between(
        &mut self,
        (walk, loaded, solver): PullingAlong<'_, '_, '_>,
        (from, to): (f64, f64),
        n_parts: usize,
    ) -> Option<(usize, f64)> {
        if self.stops.bearing.is_empty() || from == to || has_controllers(loaded) {
            return None;
        }
        let mut before = from;
        for part in 1..n_parts {
            #[expect(clippy::cast_precision_loss, reason = "a few parts")]
            let at = from + (to - from) * part as f64 / n_parts as f64;
            if let Some(stop) = self.pulling_at((&mut *walk, loaded, &mut *solver), at).ok()? {
                return Some((stop, self.let_go((walk, loaded, solver), (before, at))));
            }
            before = at;
        }
        None
    }

    /// The stop that would have to pull at a time.
    fn pulling_at(
        &mut self,
        (walk, loaded, solver): PullingAlong<'_, '_, '_>,
        t: f64,
    ) -> Result<Option<usize>, AnalysisError> {
        let [q, v, a] = walk.to(&mut self.rows, t).ok_or(AnalysisError::Lost { t })?;
        let (state, parameters) = ([&q[..], &v, &a], &loaded.parameters);
        let at = InstantState { t, state, n_moving: q.len(), parameters };
        let solved = solver.at(at)?;
        Ok(solver.pulling(&solved))
    }

    /// The instant at which a stop would have to pull first, between two times; the later one for a mechanism with
    /// controllers.
    fn let_go(
        &mut self,
        (walk, loaded, solver): PullingAlong<'_, '_, '_>,
        (mut from, mut to): (f64, f64),
    ) -> f64 {
        if has_controllers(loaded) {
            return to;
        }
        for _ in 0..50 {
            let t = 0.5 * (from + to);
            match self.pulling_at((&mut *walk, loaded, &mut *solver), t) {
                Ok(Some(_)) => to = t,
                Ok(None) => from = t,
                Err(_) => break,
            }
        }
        to
    }
}

/// The motion that is followed, its mechanism, and what finds its efforts.
type PullingAlong<'p, 'w, 's> = (&'p mut Walk<'w>, &'p Loaded, &'p mut EffortSolver<'s>);

fn has_controllers(loaded: &Loaded) -> bool {
    let model = loaded.model();
    !(model.states.is_empty() && model.held.is_empty())
}

/// Positions of joints that, prescribed beside `measures`, leave none of `n` motions free, or as few as they can.
fn left_free(
    positions: &Positions,
    mut measures: Vec<Measure>,
    (stops, added): (&StopWatch, &[usize]),
    (n_left, mut n): (&dyn Fn(&mut Rows) -> usize, usize),
) -> Vec<String> {
    let bearing: Vec<Penetration> = stops.bearing().cloned().collect();
    let mut names = Vec::new();
    for quantity in &positions.quantities {
        let Some(measure @ Measure::JointPosition(..)) =
            Measure::named(positions.model(), &quantity.names[0])
        else {
            continue;
        };
        measures.push(measure);
        let with = positions.rows_with_stops((&measures, &bearing), added, Clock::Running);
        let left = with.map_or(n, |mut rows| n_left(&mut rows));
        if left < n {
            n = left;
            names.push(quantity.names[0].clone());
        } else {
            measures.pop();
        }
        if n == 0 {
            break;
        }
    }
    names
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

/// The efforts of the actuators, in the order of their drives.
fn efforts_of(loaded: &Loaded, channels: &[Channel], lambda: &[f64]) -> Vec<f64> {
    let constraints = &loaded.system().constraints;
    let effort = |drive_idx: usize| {
        let is_own = |c: &bksim_mbs::constraint::Constraint| matches!(c.source, Source::Drive(id) if id.0 == drive_idx);
        constraints.iter().position(is_own).map_or(0.0, |row| lambda[row])
    };
    channels.iter().filter_map(|c| c.drive_idx).map(effort).collect()
}
