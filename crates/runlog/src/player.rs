//! The motion of a run at any instant: the segment it lies in, completed by the equations.

use std::sync::Arc;

use bksim_sim::compiled::CompiledSystem;
use bksim_sim::redundancy::UniquenessChange;
use bksim_sim::run::{Replay, Sample, Segment, Unreplayed};
use self_cell::self_cell;

/// Completes what segments hold; keeps the equations it does so with.
#[derive(Debug)]
pub struct Player {
    replay: OwnedReplay,
    /// The segment used last: instants that follow each other are near each other.
    last_idx: usize,
}

/// Part of an instant that is rounding: those of samples and of ticks are products of different numbers.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Part of the largest velocity below which a change of velocities is that of a projection.
const GOES_ON: f64 = 1e-9;

self_cell!(
    struct OwnedReplay {
        owner: Arc<CompiledSystem>,
        #[covariant]
        dependent: Replay,
    }
    impl {Debug}
);

/// First and last instant of a motion, s; the last is the earlier one in a run back in time.
pub fn span(segments: &[Segment]) -> Option<[f64; 2]> {
    Some([segments.first()?.t0, segments.last()?.t1])
}

/// `t`, or the end of a motion that is nearer when it lies outside of the span.
fn within(segments: &[Segment], t: f64) -> Option<f64> {
    let [first, last] = span(segments)?;
    Some(if t.is_nan() { first } else { t.clamp(first.min(last), first.max(last)) })
}

/// Which components of the reactions are unique in a motion, from its first instant on and wherever that
/// changes.
///
/// # Errors
/// [`Unreplayed`] when the motion is not that of the mechanism.
pub fn uniqueness(
    segments: &[Segment],
    compiled: &CompiledSystem,
    parameters: &[f64],
) -> Result<Vec<UniquenessChange>, Unreplayed> {
    let mut replay = Replay::new(compiled, parameters);
    let mut changes: Vec<UniquenessChange> = Vec::new();
    let mut modes: Option<&[f64]> = None;
    for segment in segments {
        // Nothing changes within a mode, and nothing at all where nothing can be shared.
        let may_change = modes.is_none() || compiled.may_share_reactions();
        if may_change && modes.replace(&segment.modes) != Some(&segment.modes) {
            replay.at(segment, segment.t0)?;
            let uniqueness = replay.uniqueness();
            if changes.last().is_none_or(|last| last.uniqueness != uniqueness) {
                changes.push(UniquenessChange { t: segment.t0, uniqueness });
            }
        }
    }
    Ok(changes)
}

impl Player {
    /// A player for runs with these values of the model's parameters.
    pub fn new(compiled: Arc<CompiledSystem>, parameters: &[f64]) -> Self {
        let replay = OwnedReplay::new(compiled, |compiled| Replay::new(compiled, parameters));
        Self { replay, last_idx: 0 }
    }

    /// The sample at `t`, s, or at the end that is nearer when it lies outside of the span. At an
    /// event, what follows it is shown. Without segments, what was shown last.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn at(&mut self, segments: &[Segment], t: f64) -> Result<&Sample, Unreplayed> {
        if let Some(t) = within(segments, t) {
            self.last_idx = self.segment_at(segments, t);
            let segment = &segments[self.last_idx];
            self.replay.with_dependent_mut(|_, replay| replay.at(segment, t).map(drop))?;
        }
        Ok(self.sample())
    }

    /// The sample that [`Player::at`] made last; work, step size and counters are zero.
    pub fn sample(&self) -> &Sample {
        self.replay.borrow_dependent().sample()
    }

    /// The kinetic energy that a motion has more at the start of a segment than at the end of the one before it, J: what
    /// impacts between them have done. Zero where velocities go on, and before the first segment.
    ///
    /// The sample is that of the start afterwards.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn impact_at(&mut self, segments: &[Segment], idx: usize) -> Result<f64, Unreplayed> {
        let Some([before, after]) =
            idx.checked_sub(1).and_then(|k| segments.get(k..=idx)?.as_array())
        else {
            return Ok(0.0);
        };
        self.last_idx = idx;
        self.replay.with_dependent_mut(|_, replay| {
            let ended = replay.at(before, before.t1)?;
            let (velocities, kinetic) = (ended.v.clone(), ended.energy.kinetic);
            let begun = replay.at(after, after.t0)?;
            let fastest = velocities.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            let goes_on = |(v, before): (&f64, &f64)| (v - before).abs() <= GOES_ON * fastest;
            let has_jump = !begun.v.iter().zip(&velocities).all(goes_on);
            Ok(if has_jump { begun.energy.kinetic - kinetic } else { 0.0 })
        })
    }

    /// The modes that hold at that sample, as parameters after those of the model; none without segments.
    pub fn modes<'s>(&self, segments: &'s [Segment]) -> &'s [f64] {
        segments.get(self.last_idx).map_or(&[], |segment| &segment.modes)
    }

    /// The distance of that sample from a singular pose: [`Replay::rank_margin`].
    pub fn rank_margin(&mut self) -> f64 {
        self.replay.with_dependent_mut(|_, replay| replay.rank_margin())
    }

    /// Writes q and v at `t`, s, or at the end that is nearer when it lies outside of the span, as the
    /// integrator has them, without projection: 2 nq numbers.
    ///
    /// # Panics
    /// If `state` has not as many numbers as there are at each point of the segments.
    pub fn state_at(&self, segments: &[Segment], t: f64, state: &mut [f64]) {
        if let Some(t) = within(segments, t) {
            segments[self.segment_at(segments, t)].at(t, state);
        }
    }

    fn segment_at(&self, segments: &[Segment], t: f64) -> usize {
        let [first, last] = span(segments).unwrap_or_default();
        let forward = if last < first { -1.0 } else { 1.0 };
        // At the end of a segment the next one is shown.
        let is_over = |s: &Segment| (s.t1 - t) * forward <= ROUNDING * t.abs();
        let is_in = |idx: usize| segments.get(idx).is_some_and(|s| s.contains(t) && !is_over(s));
        if is_in(self.last_idx) {
            return self.last_idx;
        }
        if is_in(self.last_idx + 1) {
            return self.last_idx + 1;
        }
        let n_before = segments.partition_point(is_over);
        n_before.min(segments.len().saturating_sub(1))
    }
}
