//! [`Live`]: a motion without an end, which goes on while a hand pulls at a body and while values change.

use bksim_expr::Number;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::{BodyId, Initial, Measure, Model, SolveOptions, Space};
use bksim_sim::pose::{Pose, PoseRunner, Poses};
use bksim_sim::{AdvanceError, Mechanism, Stepping};

use crate::hand::{Hand, Hold};
use crate::pose::{Posed, numbers, position_of};

/// How far ahead the end of a motion is, s.
const AHEAD: f64 = 1e5;
/// Most steps of the integrator that are waited for at once.
const MOST_STEPS: u32 = 400;

/// A motion that goes on.
pub struct Live {
    stepping: Stepping,
    mechanism: Mechanism,
    poses: PoseRunner,
    hand: Option<Hand>,
    /// Where the motion is asked to get to, s.
    goal: f64,
}

/// Where a motion was left: what another one goes on from.
#[derive(Clone, PartialEq, Debug)]
pub struct Left {
    t: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    names: Vec<String>,
    /// Positions that a start can state, with their rates.
    measured: Vec<(Measure, f64, f64)>,
}

impl std::fmt::Debug for Live {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Live").field("t", &self.stepping.t()).finish_non_exhaustive()
    }
}

impl Live {
    /// Begins at the start of a model, and goes to time `t`, s.
    ///
    /// # Errors
    /// Faults of the equations, of the start, and of the motion up to there.
    pub fn begin(model: Model, t: f64) -> Result<Self, Vec<Diagnostic>> {
        let mut live = Self::of(model, None, None)?;
        if t > live.stepping.t() {
            live.goal = t;
            live.stepping.advance_to(t).map_err(|failure| vec![fault_of(failure)])?;
        }
        Ok(live)
    }

    /// Begins in a pose, at rest or with the rates of a motion that was left.
    ///
    /// # Errors
    /// Faults of the equations and of the start.
    pub fn begin_in(
        mut model: Model,
        posed: &mut Posed,
        left: Option<&Left>,
    ) -> Result<Self, Vec<Diagnostic>> {
        if let Some(initial) = initial_of(&model, posed, left) {
            model.initial = initial;
            model.orientations.clear();
        }
        if let Some(left) = left {
            model.solve.t_start = left.t;
        }
        Self::of(model, None, None)
    }

    /// Goes on from where a motion was left, with a hand that holds a body.
    ///
    /// # Errors
    /// Faults of the equations and of the start.
    pub fn held(
        mut model: Model,
        hold: Hold,
        size: f64,
        left: &Left,
    ) -> Result<Self, Vec<Diagnostic>> {
        let hand = Hand::of(&mut model, hold, size);
        Self::of(model, Some(hand), Some(left))
    }

    fn of(model: Model, hand: Option<Hand>, left: Option<&Left>) -> Result<Self, Vec<Diagnostic>> {
        let mechanism = Mechanism::derive(model, Vec::new()).map_err(|rejected| rejected.0)?;
        let mut simulation = mechanism.simulation().map_err(|rejected| rejected.0)?;
        let options = simulation.options();
        let t_end = left.map_or(options.t_start, |left| left.t) + AHEAD;
        simulation.set_options(&SolveOptions { t_end, ..options.clone() });
        let mut start = simulation.start().map_err(|rejected| rejected.0)?;
        if let Some(left) = left.filter(|left| left.names == names(&mechanism)) {
            (start.t, start.q, start.v) = (left.t, left.q.clone(), left.v.clone());
        }
        let stepping = simulation.begin_at(&start).map_err(|rejected| rejected.0)?;
        let poses = Poses::compile(&mechanism.model, &mechanism.system);
        let poses = poses.map_err(|error| vec![uncompiled(&error.to_string())])?;
        let poses = poses.runner(&mechanism.parameters);
        let goal = stepping.t();
        Ok(Self { stepping, mechanism, poses, hand, goal })
    }

    /// True if the hand holds this place already.
    pub(crate) fn holds(&self, hold: Hold) -> bool {
        self.hand.as_ref().is_some_and(|hand| hand.hold == hold)
    }

    /// Advances by `dt`, s, while the hand is at a place of the world, or open; false where that takes
    /// longer than a picture may wait, and is gone on with at the next call.
    ///
    /// # Errors
    /// Why the motion cannot go on.
    pub fn step(&mut self, dt: f64, at: Option<[f64; 3]>) -> Result<bool, Diagnostic> {
        let is_behind = self.goal > self.stepping.t();
        if !is_behind {
            self.goal += dt;
            if let Some(hand) = &self.hand {
                for (name, value) in hand.values(at) {
                    self.stepping
                        .set_input(name, value)
                        .map_err(|error| uncompiled(&error.to_string()))?;
                }
            }
        }
        let left = std::cell::Cell::new(MOST_STEPS);
        let stop = || {
            left.set(left.get().saturating_sub(1));
            left.get() == 0
        };
        self.stepping.advance_to_unless(self.goal, &stop).map_err(fault_of)
    }

    /// The time that is reached, s.
    pub fn t(&self) -> f64 {
        self.stepping.t()
    }

    /// Kinetic and potential energy there, J.
    pub fn energy(&self) -> [f64; 2] {
        let energy = &self.stepping.sample().energy;
        [energy.kinetic, energy.potential]
    }

    /// Poses of all bodies there, the ground first.
    pub fn bodies(&mut self) -> Vec<Pose> {
        let state = self.stepping.state();
        let mut found: Vec<Pose> = Vec::new();
        self.poses.at(state.q, state.v, &mut found);
        found
    }

    /// The numbers of [`Live::bodies`], as a page takes them.
    pub(crate) fn numbers(&mut self) -> Vec<f64> {
        numbers(&self.bodies())
    }

    /// True with drives: a state alone is then no beginning.
    pub(crate) fn is_driven(&self) -> bool {
        !self.mechanism.model.drives.is_empty()
    }

    /// The state that is reached.
    pub fn left(&self) -> Left {
        let state = self.stepping.state();
        let coordinates = self.mechanism.system.coordinates().iter().enumerate();
        let measured = coordinates.filter_map(|(k, coordinate)| {
            Some((position_of(coordinate.owner)?, state.q[k], state.v[k]))
        });
        Left {
            t: state.t,
            q: state.q.to_vec(),
            v: state.v.to_vec(),
            names: names(&self.mechanism),
            measured: measured.collect(),
        }
    }
}

impl Left {
    /// Time, s.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// Brings a mechanism with coordinates of these names near to where the motion was left.
    pub fn bring(&self, posed: &mut Posed) -> bool {
        posed.go_near_named(&self.names, &self.q)
    }

    fn rate(&self, measure: Measure) -> Option<f64> {
        self.measured.iter().find(|(own, ..)| *own == measure).map(|(.., rate)| *rate)
    }
}

fn names(mechanism: &Mechanism) -> Vec<String> {
    mechanism.system.coordinates().iter().map(|coordinate| coordinate.name.clone()).collect()
}

fn uncompiled(message: &str) -> Diagnostic {
    Diagnostic::error(crate::codes::MISSING, message.to_owned())
}

fn fault_of(failure: AdvanceError) -> Diagnostic {
    match failure {
        AdvanceError::Failed(fault) => *fault,
        other => uncompiled(&other.to_string()),
    }
}

/// Initial values of a pose: independent positions are stated with their rates, all others guessed. `None`
/// where the pose has coordinates that no start states.
fn initial_of(model: &Model, posed: &mut Posed, left: Option<&Left>) -> Option<Vec<Initial>> {
    let is_whole = model.space == Space::Planar || posed.is_of_joints();
    let all: Option<Vec<Measure>> = posed.measures().filter(|_| is_whole);
    let independent = posed.independent();
    let mut initial = Vec::new();
    let mut say = |measure: Measure, value: f64, is_guess: bool| {
        let value = model.pool.number(Number::float(value));
        initial.push(Initial { measure, value, is_guess, name: String::new(), span: 0..0 });
    };
    for measure in all? {
        let is_guess = !independent.contains(&measure);
        say(measure, posed.value(measure)?, is_guess);
        let rate = left.and_then(|left| left.rate(measure)).unwrap_or(0.0);
        if let Some(of_rate) = rate_of(measure).filter(|_| !is_guess) {
            say(of_rate, rate, false);
        }
    }
    Some(initial)
}

fn rate_of(position: Measure) -> Option<Measure> {
    Some(match position {
        Measure::JointPosition(joint, motion_idx) => Measure::JointVelocity(joint, motion_idx),
        Measure::PointPosition(body, point, axis) => Measure::PointVelocity(body, point, axis),
        Measure::BodyAngle(body) => Measure::BodyRate(body),
        _ => return None,
    })
}

/// Place of a hand in a model, at a point in the frame of a body, m; `None` on the ground.
pub fn hold_of(model: &Model, body: usize, point: [f64; 3]) -> Option<Hold> {
    let body = BodyId(body.min(model.bodies.len() - 1));
    (body.0 > 0).then_some(Hold { body, point })
}
