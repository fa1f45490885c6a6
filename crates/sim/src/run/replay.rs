//! A run again, at any instant, from its segments: the samples that the run itself would have handed
//! out there.

use super::completion::{complete_state, measure_contacts};
use super::observer::Segment;
use super::sample::{Energy, Sample};
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::hybrid::Passage;
use crate::modes::Modes;
use crate::modes::indicators::IndicatorEvaluator;
use crate::multiplier::MultiplierSystem;
use crate::redundancy::{MovingInstant, Uniqueness};

/// Completes states of segments: projection, accelerations, multipliers, reactions, energies.
///
/// Sums over a run are not in a segment: work, step sizes and counters stay zero.
#[derive(Clone, Debug)]
pub struct Replay<'a> {
    compiled: &'a CompiledSystem,
    /// The model's own parameters.
    own: Vec<f64>,
    /// Modes and dependent rows that the rest is for.
    numbers: Vec<f64>,
    dependent: Vec<usize>,
    modes: Modes,
    evaluator: Evaluator<'a>,
    watcher: IndicatorEvaluator<'a>,
    multipliers: MultiplierSystem,
    state: Vec<f64>,
    sample: Sample,
}

/// Why a segment has no sample at some instant.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Unreplayed {
    /// Motion whose sizes are not those of the mechanism.
    #[error("the motion is that of another mechanism")]
    OtherMechanism,
}

impl<'a> Replay<'a> {
    /// A replay of runs with these values of the model's parameters.
    pub fn new(compiled: &'a CompiledSystem, parameters: &[f64]) -> Self {
        let modes = compiled.indicators.idle();
        let all = modes.parameters_with_modes(parameters);
        let (nq, nc) = (compiled.nq(), compiled.nc());
        let (zeros, n_joints) = (vec![0.0; nq], compiled.joints.len());
        Self {
            compiled,
            own: parameters.to_vec(),
            numbers: all[parameters.len()..].to_vec(),
            dependent: Vec::new(),
            modes,
            evaluator: compiled.evaluator(&all),
            watcher: compiled.indicators.at(&all),
            multipliers: compiled.multiplier_system(&[]),
            state: vec![0.0; 2 * nq],
            sample: Sample {
                q: zeros.clone(),
                v: zeros.clone(),
                a: zeros,
                lambda: vec![0.0; nc],
                reactions: vec![[0.0; 6]; n_joints],
                energy: Energy::default(),
                ..Sample::default()
            },
        }
    }

    /// The sample at `t`, s; extrapolated outside of the segment. Accelerations, multipliers and what
    /// follows from them are NaN where the equations have no value.
    ///
    /// # Errors
    /// [`Unreplayed`] when the segment is not one of this mechanism.
    pub fn at(&mut self, segment: &Segment, t: f64) -> Result<&Sample, Unreplayed> {
        self.check(segment)?;
        self.take_modes(segment)?;
        segment.at(t, &mut self.state);
        let Self { evaluator, multipliers, sample, state, .. } = self;
        let (q, v) = state.split_at(sample.q.len());
        sample.t = t;
        sample.q.copy_from_slice(q);
        sample.v.copy_from_slice(v);
        // Numbers without a value are NaN, and show as such.
        let _ = complete_state(evaluator, multipliers, sample);
        let Sample { q, v, lambda, .. } = sample;
        self.watcher.fill_slip_friction(&self.modes, (t, q, v), lambda, 0.0);
        measure_contacts(self.compiled, evaluator, sample);
        if self.compiled.yields() {
            let parameters = self.modes.parameters_with_modes(&self.own);
            let Sample { q, lambda, reactions, .. } = sample;
            self.compiled.share(&parameters, (t, q), &|_| true, (reactions, lambda));
        }
        Ok(sample)
    }

    /// The samples at an event: the last instant before it, and the first one after it.
    ///
    /// # Errors
    /// [`Unreplayed`] when the event is not one of this mechanism.
    pub fn around(&mut self, passage: &Passage) -> Result<[Sample; 2], Unreplayed> {
        let Passage { state, before, inactive, after, .. } = passage;
        let mut side = |q: &[f64], v: &[f64], modes: &Modes, dependent: &[usize]| {
            let segment = Segment {
                t0: state.t,
                t1: state.t,
                values: [q, v].concat(),
                modes: modes.parameters_with_modes(&[]),
                dependent: dependent.to_vec(),
            };
            self.at(&segment, state.t).cloned()
        };
        let first = side(&state.q, &state.v, before, inactive)?;
        Ok([first, side(&after.q, &after.v, &after.modes, &after.inactive)?])
    }

    /// The sample that [`Replay::at`] has made last.
    pub fn sample(&self) -> &Sample {
        &self.sample
    }

    /// Distance of the sample that [`Replay::at`] has made last from a singular pose: about the square of the
    /// smallest singular value of the constraint Jacobian, as a part of the largest met so far; 1 without
    /// constraints. Reactions lose as many digits as its root has zeros.
    pub fn rank_margin(&mut self) -> f64 {
        let Sample { t, q, v, .. } = &self.sample;
        self.multipliers.rank_margin_at(&self.evaluator.dynamics(*t, q, v))
    }

    /// Which components of the reactions are unique in the motion from the sample on that
    /// [`Replay::at`] has made last.
    pub fn uniqueness(&self) -> Uniqueness {
        let Sample { t, q, v, a, .. } = &self.sample;
        self.compiled.uniqueness(&self.own, MovingInstant { t: *t, q, v, a }, &self.modes)
    }

    fn check(&self, segment: &Segment) -> Result<(), Unreplayed> {
        let n = self.state.len();
        let is_whole = n == 0 || segment.values.len().is_multiple_of(n);
        let are_rows = segment.dependent.iter().all(|&row| row < self.compiled.nc());
        let are_rows = are_rows && segment.dependent.is_sorted_by(|a, b| a < b);
        let is_there = n == 0 || !segment.values.is_empty();
        if is_whole && is_there && are_rows { Ok(()) } else { Err(Unreplayed::OtherMechanism) }
    }

    fn take_modes(&mut self, segment: &Segment) -> Result<(), Unreplayed> {
        let are_same = self.numbers == segment.modes && self.dependent == segment.dependent;
        if are_same {
            return Ok(());
        }
        let watch = &self.compiled.indicators;
        let modes = watch.modes_from_numbers(&segment.modes).ok_or(Unreplayed::OtherMechanism)?;
        let all = modes.parameters_with_modes(&self.own);
        self.modes = modes;
        self.numbers.clone_from(&segment.modes);
        self.dependent.clone_from(&segment.dependent);
        self.evaluator = self.compiled.evaluator(&all);
        self.watcher = watch.at(&all);
        self.multipliers = self.compiled.multiplier_system(&segment.dependent);
        Ok(())
    }
}
