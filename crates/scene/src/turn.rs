//! [`Turn`]: the sign of a torque, which turns over with the torque during a motion.

use bksim_expr::TapeError;
use bksim_sim::Mechanism;
use bksim_sim::load_forces::{LoadTorques, TorqueAxis};

use crate::geometry::{along3, dot3, sub3};
use crate::{Form, Role, Scene};

/// Shapes of the sign of a torque: the shaft and the head of its arrow.
const SHAPES: usize = 2;

/// Half turn about a line through the middle of its arrow by which the sign of a torque turns over.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Turn {
    /// Load, body and axis: about it the arrow turns to the left, unless it is turned over.
    pub about: TorqueAxis,
    /// A point of the line and its direction, a unit vector, in the frame of the body, m.
    pub line: [[f64; 3]; 2],
    /// True if the arrow turns to the right about the axis.
    pub is_over: bool,
}

impl Turn {
    /// A point after the half turn, in the frame of the body.
    fn turned(&self, p: [f64; 3]) -> [f64; 3] {
        let [origin, along] = self.line;
        let arm = sub3(p, origin);
        let foot = along3(origin, dot3(arm, along), along);
        along3(foot, -1.0, sub3(p, foot))
    }
}

impl Scene {
    /// Indices of the shapes of each sign of a torque, in the order of [`Scene::turns`].
    pub fn shapes_of_turns(&self) -> Vec<Vec<usize>> {
        let shapes = self.shapes.iter().enumerate();
        let signs: Vec<usize> =
            shapes.filter(|(_, shape)| shape.role == Role::Torque).map(|(idx, _)| idx).collect();
        signs.chunks(SHAPES).map(<[usize]>::to_vec).collect()
    }

    /// True if a sign points against its torque, one torque for each of [`Scene::turns`].
    pub fn is_turned_by(&self, torques: &[f64]) -> bool {
        self.turns.iter().zip(torques).any(|(turn, &torque)| turn.is_over != (torque < 0.0))
    }

    /// Turns signs over that point against their torques.
    pub fn turn(&mut self, torques: &[f64]) {
        let shapes = self.shapes_of_turns();
        for ((turn, own), &torque) in self.turns.iter_mut().zip(shapes).zip(torques) {
            if turn.is_over == (torque < 0.0) {
                continue;
            }
            turn.is_over = !turn.is_over;
            for idx in own {
                let points = match &mut self.shapes[idx].form {
                    Form::Region(rings) => rings.as_mut_slice(),
                    Form::Line { points, .. } => std::slice::from_mut(points),
                    _ => &mut [],
                };
                for p in points.iter_mut().flatten() {
                    *p = turn.turned(*p);
                }
            }
        }
    }

    /// The torques of the signs as functions of the state; `None` if there are no signs.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub fn torques(&self, mechanism: &Mechanism) -> Result<Option<LoadTorques>, TapeError> {
        if self.turns.is_empty() {
            return Ok(None);
        }
        let Mechanism { model, system, compiled, parameters, .. } = mechanism;
        let axes: Vec<TorqueAxis> = self.turns.iter().map(|turn| turn.about).collect();
        LoadTorques::compile(model, system, compiled, parameters, &axes).map(Some)
    }

    /// When each sign turns over, from the torques at some instants, s, in rising or falling order. Between two of them a
    /// torque is taken for linear.
    pub fn turn_times(&self, instants: &[(f64, Vec<f64>)]) -> Vec<TurnTimes> {
        let of_sign = |k: usize| {
            let is_over = |(_, torques): &(f64, Vec<f64>)| torques[k] < 0.0;
            let crossing = |pair: &[(f64, Vec<f64>)]| {
                let [(t0, a), (t1, b)] = pair else { return None };
                let part = a[k] / (a[k] - b[k]);
                let t = t0 + (t1 - t0) * if part.is_finite() { part } else { 1.0 };
                (is_over(&pair[0]) != is_over(&pair[1])).then_some(t)
            };
            let mut times: Vec<f64> = instants.windows(2).filter_map(crossing).collect();
            let is_back = instants.first().map(|(t, _)| t) > instants.last().map(|(t, _)| t);
            let earliest = if is_back { instants.last() } else { instants.first() };
            times.sort_by(f64::total_cmp);
            TurnTimes { is_over: earliest.map_or(self.turns[k].is_over, is_over), times }
        };
        (0..self.turns.len()).map(of_sign).collect()
    }
}

/// When the sign of a torque turns over.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct TurnTimes {
    /// True if it is turned over before the first of the instants.
    pub is_over: bool,
    /// Instants at which it turns over, s, rising.
    pub times: Vec<f64>,
}
