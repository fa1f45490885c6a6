//! The motion of a run as polynomials that the page evaluates at the instant of each frame.
//!
//! The log has q and v over every step as the integrator left them. The page has no projection onto
//! the constraints; so its polynomials go through projected values, together with the reactions
//! there, at the Chebyshev points of [`Segment`]. Between the points they are compared with the
//! equations' own motion, and take more points until they agree to [`CLOSE`].
//!
//! A run of many steps has one polynomial, of degree [`THINNED_DEGREE`] or more, for two, four,
//! eight … steps, never across an event. Its deviation from the motion is measured, and stated on
//! the page where it is more than [`NOTICED`].

use bksim::model::Space;
use bksim::playback::Playback;
use bksim::sim::run::{Sample, Segment, Unreplayed};
use serde_json::{Value, json};

use crate::budget::n_numbers;
use crate::escape::doubles;

/// Largest difference between polynomials and motion that needs no more points, of coordinates and
/// rates, in their units or relative to their size: poses are then right to 1e-9 for any sensible
/// lengths.
const CLOSE: f64 = 1e-10;
/// Difference above which it is stated on the page.
const NOTICED: f64 = 1e-9;
/// The highest degree that is tried.
const MAX_DEGREE: usize = 16;
/// Degree of a polynomial over several steps.
const THINNED_DEGREE: usize = 8;
/// Relative jump of the coordinates or rates that is an event and not rounding.
const JUMP: f64 = 1e-4;
/// Positions at which polynomials are compared, in the interval from −1 to 1: between the points.
const COMPARED: [f64; 3] = [-0.83, 0.21, 0.64];

/// The motion of a run.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Motion {
    /// Polynomials one after the other, without gaps; without modes.
    pub pieces: Vec<Segment>,
    /// Numbers at each point: q, v, the forces of joints.
    pub n_columns: usize,
    /// Components of a force.
    pub n_axes: usize,
    /// Largest difference found of q and v.
    pub deviation: f64,
    /// Instants of events, each of which begins a piece.
    pub events: Vec<f64>,
    /// The loss by a lack of space, if there is one.
    pub thinning: Option<Thinning>,
}

/// The loss of a motion that does not fit into its budget.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Thinning {
    /// Number of steps that became one polynomial.
    pub n_together: usize,
    /// Number of steps of the run.
    pub n_steps: usize,
    /// Largest difference found.
    pub deviation: f64,
    /// The page ends here, before the run does, s.
    pub cut_at: Option<f64>,
}

impl Thinning {
    /// A sentence on the loss.
    pub(crate) fn words(&self) -> String {
        let Self { n_together, n_steps, deviation, cut_at } = self;
        let words = format!(
            "The run has {n_steps} steps, too many for one page: every {n_together} of them between \
             events are drawn as one polynomial, at most {deviation:.1e} (m, rad, m/s, rad/s, or of \
             the size of the value where that is larger) from the motion in the log where compared."
        );
        match cut_at {
            Some(t) => format!("{words} What follows t = {t} s is left out."),
            None => words,
        }
    }
}

/// The interval and degree of one polynomial.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Plan {
    t0: f64,
    t1: f64,
    degree: usize,
}

/// The motion of `playback` in at most `bytes` bytes.
pub(crate) fn take(playback: &mut Playback, bytes: usize) -> Result<Motion, Unreplayed> {
    // The columns of the polynomials: q, v and the forces of the joints.
    let model = &playback.mechanism().model;
    let n_axes = if model.space == Space::Planar { 2 } else { 3 };
    let sample = playback.sample();
    let n_columns = 2 * sample.q.len() + n_axes * sample.reactions.len();
    let mut motion = Motion {
        pieces: Vec::new(),
        n_columns,
        n_axes,
        deviation: 0.0,
        events: Vec::new(),
        thinning: None,
    };

    // Enough steps in one polynomial that all fit, or as many as there are between events.
    let capacity = n_numbers(bytes, size_of::<f64>()) / n_columns.max(1);
    let n_points = |plans: &[Plan]| plans.iter().map(|plan| plan.degree + 1).sum::<usize>();
    let n_state = 2 * sample.q.len();
    let phases = phases(&playback.log().segments, n_state);
    motion.events = phases.iter().skip(1).filter_map(|s| Some(s.first()?.t0)).collect();
    let longest = phases.iter().map(Vec::len).max().unwrap_or(0);
    let mut n_together = 1;
    let mut plans = together(&phases, n_together, n_state);
    while n_points(&plans) > capacity && n_together < longest {
        n_together *= 2;
        plans = together(&phases, n_together, n_state);
    }

    // A run that ended at its start is one instant; the end of one that does not fit is cut off.
    if plans.is_empty() {
        let [t0, t1] = playback.span();
        plans.push(Plan { t0, t1, degree: 0 });
    }
    let n_steps = phases.iter().map(Vec::len).sum();
    let mut cut_at = None;
    let n_kept = capacity / (THINNED_DEGREE + 1);
    if n_points(&plans) > capacity && n_kept < plans.len() {
        plans.truncate(n_kept.max(1));
        cut_at = plans.last().map(|plan| plan.t1);
    }

    // Polynomials through the equations' own motion; spare points go to those that differ from it.
    let mut spare = capacity.saturating_sub(n_points(&plans));
    for plan in &plans {
        motion.add(playback, *plan, &mut spare)?;
    }
    if motion.deviation > NOTICED || cut_at.is_some() {
        let deviation = motion.deviation;
        motion.thinning = Some(Thinning { n_together, n_steps, deviation, cut_at });
    }
    Ok(motion)
}

impl Motion {
    /// Adds a polynomial of the planned degree, or of a higher one where that is needed.
    fn add(
        &mut self,
        playback: &mut Playback,
        plan: Plan,
        spare: &mut usize,
    ) -> Result<(), Unreplayed> {
        let mut degree = plan.degree;
        loop {
            let piece = self.through(playback, plan, degree)?;
            let deviation = self.compare(playback, &piece)?;
            let more = (degree + 3).min(MAX_DEGREE);
            if deviation <= CLOSE || more == degree || more - degree > *spare {
                self.deviation = self.deviation.max(deviation);
                self.pieces.push(piece);
                return Ok(());
            }
            *spare -= more - degree;
            degree = more;
        }
    }

    /// The polynomial of this degree through projected values.
    fn through(
        &self,
        playback: &mut Playback,
        plan: Plan,
        degree: usize,
    ) -> Result<Segment, Unreplayed> {
        let Plan { t0, t1, .. } = plan;
        let mut values = Vec::with_capacity((degree + 1) * self.n_columns);
        for k in 0..=degree {
            let tau = ((2 * k + 1) as f64 * std::f64::consts::PI / (2 * degree + 2) as f64).cos();
            let sample = playback.seek(0.5 * (t0 + t1) + 0.5 * tau * (t1 - t0))?;
            values.extend(columns(sample, self.n_axes));
        }
        Ok(Segment { t0, t1, values, ..Segment::default() })
    }

    /// Largest difference of q and v between the polynomial and the motion.
    fn compare(&self, playback: &mut Playback, piece: &Segment) -> Result<f64, Unreplayed> {
        let mut state = vec![0.0; self.n_columns];
        let mut largest: f64 = 0.0;
        for tau in COMPARED {
            let t = 0.5 * (piece.t0 + piece.t1) + 0.5 * tau * (piece.t1 - piece.t0);
            piece.at(t, &mut state);
            let sample = playback.seek(t)?;
            for (found, own) in state.iter().zip(sample.q.iter().chain(&sample.v)) {
                largest = largest.max((found - own).abs() / own.abs().max(1.0));
            }
        }
        Ok(largest)
    }

    /// First and last instant, s.
    pub(crate) fn span(&self) -> [f64; 2] {
        let ends = |pieces: &[Segment]| Some([pieces.first()?.t0, pieces.last()?.t1]);
        ends(&self.pieces).expect("a motion has at least one polynomial")
    }

    /// The motion as JSON for the page.
    pub(crate) fn write(&self) -> Value {
        let ends = self.pieces.last().map(|piece| piece.t1);
        let degree = |piece: &Segment| (piece.values.len() / self.n_columns.max(1)).max(1) - 1;
        json!({
            "columns": self.n_columns,
            "axes": self.n_axes,
            "times": doubles(self.pieces.iter().map(|piece| piece.t0).chain(ends)),
            "degrees": self.pieces.iter().map(degree).collect::<Vec<_>>(),
            "values": doubles(self.pieces.iter().flat_map(|piece| piece.values.iter().copied())),
        })
    }
}

/// q, v, and the force of every joint.
fn columns(sample: &Sample, n_axes: usize) -> impl Iterator<Item = f64> {
    let forces = sample.reactions.iter().flat_map(move |reaction| &reaction[..n_axes]);
    sample.q.iter().chain(&sample.v).chain(forces).copied()
}

/// The phases of a run, each with its steps: within a phase nothing jumps and the modes stay.
fn phases(segments: &[Segment], n_state: usize) -> Vec<Vec<&Segment>> {
    let (mut before, mut after) = (vec![0.0; n_state], vec![0.0; n_state]);
    let mut jumps = |last: &Segment, next: &Segment| {
        last.at(last.t1, &mut before);
        next.at(next.t0, &mut after);
        let differ = |(a, b): (&f64, &f64)| (a - b).abs() > JUMP * a.abs().max(1.0);
        last.modes != next.modes || before.iter().zip(&after).any(differ)
    };
    let mut phases: Vec<Vec<&Segment>> = Vec::new();
    for segment in segments.iter().filter(|segment| segment.t0 != segment.t1) {
        match phases.last_mut() {
            Some(steps) if steps.last().is_some_and(|last| !jumps(last, segment)) => {
                steps.push(segment);
            }
            _ => phases.push(vec![segment]),
        }
    }
    phases
}

/// Plans of one polynomial for `n_together` steps each.
fn together(phases: &[Vec<&Segment>], n_together: usize, n_state: usize) -> Vec<Plan> {
    let plan = |steps: &[&Segment]| {
        let (first, last) = (steps.first()?, steps.last()?);
        let degree = match n_together {
            1 => (first.values.len() / n_state.max(1)).max(1) - 1,
            _ => THINNED_DEGREE,
        };
        Some(Plan { t0: first.t0, t1: last.t1, degree })
    };
    phases.iter().flat_map(|steps| steps.chunks(n_together)).filter_map(plan).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(t0: f64, t1: f64, values: [f64; 2]) -> Segment {
        Segment { t0, t1, values: values.to_vec(), ..Segment::default() }
    }

    #[test]
    fn steps_are_combined_up_to_an_event() {
        // Rest, three steps of which the second has another mode, and a jump of the velocity.
        let mut steps: Vec<Segment> =
            (0..6).map(|k| step(f64::from(k), f64::from(k + 1), [1.0, 0.0])).collect();
        steps[3].modes = vec![1.0];
        steps[5].values[1] = 0.5;
        let parts = phases(&steps, 2);
        assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [3, 1, 1, 1]);
        let plans = together(&parts, 2, 2);
        let times: Vec<[f64; 2]> = plans.iter().map(|plan| [plan.t0, plan.t1]).collect();
        assert_eq!(times, [[0.0, 2.0], [2.0, 3.0], [3.0, 4.0], [4.0, 5.0], [5.0, 6.0]]);
        // One by one they keep their degree, which is 0 here.
        assert!(together(&parts, 1, 2).iter().all(|plan| plan.degree == 0));
        assert!(plans.iter().all(|plan| plan.degree == THINNED_DEGREE));
    }

    #[test]
    fn rounding_is_no_event() {
        let steps = [step(0.0, 1.0, [1.0, 2.0]), step(1.0, 2.0, [1.0 + 1e-9, 2.0 - 1e-9])];
        assert_eq!(phases(&steps, 2).len(), 1);
    }
}
