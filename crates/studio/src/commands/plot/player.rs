//! [`Player`]: the motion between samples at even instants.

use bksim::sim::run::{Replay, Sample, Segment};

/// A coordinate that differs by more between two segments jumps, relative to its size.
const JUMP: f64 = 1e-6;

/// Computes samples at evenly spaced instants, from segments as they come.
pub(super) struct Player<'a, F> {
    replay: Replay<'a>,
    draw: F,
    /// From where to where.
    span: [f64; 2],
    /// In how many parts the instants cut it.
    n_instants: usize,
    /// Number of the next instant.
    next: usize,
    /// The segment before, if there is one.
    last: Option<Segment>,
    /// States at the boundary of two segments.
    states: [Vec<f64>; 2],
}

impl<'a, F: FnMut(&Sample)> Player<'a, F> {
    /// Plays at `n_instants` instants and the end of a span; the states have room for a state each.
    pub(super) fn new(
        (replay, states): (Replay<'a>, [Vec<f64>; 2]),
        span: [f64; 2],
        n_instants: usize,
        draw: F,
    ) -> Self {
        Self { replay, draw, span, n_instants, next: 0, last: None, states }
    }

    fn instant(&self, idx: usize) -> f64 {
        let part = idx as f64 / self.n_instants as f64;
        self.span[0] + part * (self.span[1] - self.span[0])
    }

    /// True where `t` lies in the span, whichever way that goes.
    fn is_inside(&self, t: f64) -> bool {
        (t - self.span[0]) * (self.span[1] - t) >= 0.0
    }

    /// Takes the next segment.
    pub(super) fn play(&mut self, segment: &bksim::log::Segment) -> Result<(), String> {
        let bksim::log::Segment { t, t_end, values, modes, dependent } = segment;
        let own = Segment {
            t0: *t,
            t1: *t_end,
            values: values.clone(),
            modes: modes.clone(),
            dependent: dependent.iter().map(|&row| row as usize).collect(),
        };
        if let Some(last) = self.last.take()
            && self.is_inside(own.t0)
            && self.jumps(&last, &own)
        {
            self.draw_at(&last, last.t1)?;
            self.draw_at(&own, own.t0)?;
        }
        let forward = (self.span[1] - self.span[0]).signum();
        while self.next <= self.n_instants && (self.instant(self.next) - own.t1) * forward < 0.0 {
            let t = self.instant(self.next);
            // What lies before the first segment has no value.
            if own.contains(t) {
                self.draw_at(&own, t)?;
            }
            self.next += 1;
        }
        self.last = Some(own);
        Ok(())
    }

    /// The end of the last segment belongs to no other.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        let Some(last) = self.last.take() else { return Ok(()) };
        let forward = (self.span[1] - self.span[0]).signum();
        let end = if (self.span[1] - last.t1) * forward < 0.0 { self.span[1] } else { last.t1 };
        if self.is_inside(end) && last.contains(end) { self.draw_at(&last, end) } else { Ok(()) }
    }

    fn jumps(&mut self, last: &Segment, own: &Segment) -> bool {
        if last.modes != own.modes || last.dependent != own.dependent || last.t1 != own.t0 {
            return true;
        }
        let n = self.states[0].len();
        let is_whole = |segment: &Segment| n > 0 && segment.values.len().is_multiple_of(n);
        if !is_whole(last) || !is_whole(own) {
            return false;
        }
        let [before, after] = &mut self.states;
        last.at(last.t1, before);
        own.at(own.t0, after);
        before.iter().zip(after).any(|(a, b)| (*a - *b).abs() > JUMP * a.abs().max(1.0))
    }

    fn draw_at(&mut self, segment: &Segment, t: f64) -> Result<(), String> {
        let sample = self.replay.at(segment, t).map_err(|e| e.to_string())?;
        (self.draw)(sample);
        Ok(())
    }
}
