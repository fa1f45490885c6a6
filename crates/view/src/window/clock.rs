//! [`Clock`]: the instant of a motion that is shown, and how it advances.

/// The speeds, ascending.
pub(super) const SPEEDS: [f64; 13] =
    [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// Frames a second of [`Clock::step_frame`].
const FRAME_RATE: f64 = 60.0;

/// The time that a window shows.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Clock {
    /// First and last instant, s; the last is the earlier one in a run back in time.
    span: [f64; 2],
    t: f64,
    /// Index in [`SPEEDS`].
    speed_idx: usize,
    is_playing: bool,
    /// True if it continues at the start after the end.
    pub(super) is_looping: bool,
}

impl Default for Clock {
    /// Paused at zero, at the speed of the motion itself, in a loop.
    fn default() -> Self {
        Self { span: [0.0; 2], t: 0.0, speed_idx: 6, is_playing: false, is_looping: true }
    }
}

impl Clock {
    /// The instant shown, s.
    pub(super) fn t(&self) -> f64 {
        self.t
    }

    /// First and last instant, s.
    pub(super) fn span(&self) -> [f64; 2] {
        self.span
    }

    /// True if time advances by itself.
    pub(super) fn is_playing(&self) -> bool {
        self.is_playing
    }

    /// Seconds of the motion in a second of the window.
    pub(super) fn speed(&self) -> f64 {
        SPEEDS[self.speed_idx]
    }

    /// Takes the span of another motion; the instant stays, or moves to the nearer end.
    pub(super) fn set_span(&mut self, span: [f64; 2]) {
        self.span = span;
        self.seek(self.t);
    }

    /// Moves to `t`, s, or to the nearer end.
    pub(super) fn seek(&mut self, t: f64) {
        let [first, last] = self.span;
        self.t = if t.is_nan() { first } else { t.clamp(first.min(last), first.max(last)) };
    }

    /// Moves to a fraction of the span, 0 to 1.
    pub(super) fn seek_part(&mut self, part: f64) {
        let [first, last] = self.span;
        self.seek(first + part * (last - first));
    }

    /// The fraction of the span that is past, 0 to 1.
    pub(super) fn part(&self) -> f64 {
        let [first, last] = self.span;
        if first == last { 0.0 } else { (self.t - first) / (last - first) }
    }

    /// Starts, or pauses; at the end it starts again.
    pub(super) fn toggle(&mut self) {
        self.is_playing = !self.is_playing && self.span[0] != self.span[1];
        if self.is_playing && self.t == self.span[1] {
            self.t = self.span[0];
        }
    }

    /// Pauses.
    pub(super) fn pause(&mut self) {
        self.is_playing = false;
    }

    /// Advances by `elapsed` seconds of the window.
    pub(super) fn advance(&mut self, elapsed: f64) {
        if !self.is_playing {
            return;
        }
        let [first, last] = self.span;
        let length = (last - first).abs();
        let part = self.part() * length + elapsed * self.speed();
        // A loop continues at the start by the rest of the step.
        let part = if part <= length {
            part
        } else if self.is_looping && length > 0.0 {
            part % length
        } else {
            self.is_playing = false;
            length
        };
        self.seek_part(if length > 0.0 { part / length } else { 0.0 });
    }

    /// Pauses, and moves by a number of frames at the present speed.
    pub(super) fn step_frame(&mut self, n: i32) {
        self.pause();
        let forward = if self.span[1] < self.span[0] { -1.0 } else { 1.0 };
        self.seek(self.t + forward * f64::from(n) * self.speed() / FRAME_RATE);
    }

    /// Pauses, and moves to the next or the previous one of some instants, which are in the order
    /// of the run.
    pub(super) fn step_to(
        &mut self,
        is_onward: bool,
        instants: impl DoubleEndedIterator<Item = f64>,
    ) {
        self.pause();
        let [first, last] = self.span;
        let forward = if last < first { -1.0 } else { 1.0 };
        // Rounding must not find the present instant again.
        let slack = 1e-12 * (last - first).abs();
        let is_later = |t: &f64| (t - self.t) * forward > slack;
        let is_earlier = |t: &f64| (self.t - t) * forward > slack;
        let mut instants = instants;
        let found = if is_onward { instants.find(is_later) } else { instants.rfind(is_earlier) };
        self.seek(found.unwrap_or(if is_onward { last } else { first }));
    }

    /// Moves by a number of steps through [`SPEEDS`].
    pub(super) fn change_speed(&mut self, steps: isize) {
        self.speed_idx = self.speed_idx.saturating_add_signed(steps).min(SPEEDS.len() - 1);
    }

    /// Takes the nearest of [`SPEEDS`].
    pub(super) fn set_speed(&mut self, speed: f64) {
        let distance = |&idx: &usize| (SPEEDS[idx] / speed).ln().abs();
        let nearest = (0..SPEEDS.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        self.speed_idx = nearest.expect("there are speeds");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(span: [f64; 2]) -> Clock {
        let mut clock = Clock::default();
        clock.set_span(span);
        clock.seek(span[0]);
        clock
    }

    #[test]
    fn it_plays_in_a_loop_or_stops_at_the_end_and_starts_again() {
        let mut clock = clock([1.0, 3.0]);
        clock.advance(0.5);
        assert_eq!(clock.t(), 1.0, "at rest");
        clock.toggle();
        clock.advance(1.5);
        assert_eq!(clock.t(), 2.5);
        clock.advance(1.0);
        assert_eq!(clock.t(), 1.5, "half a second beyond the end");

        clock.is_looping = false;
        clock.advance(100.0);
        assert_eq!((clock.t(), clock.is_playing()), (3.0, false));
        clock.toggle();
        assert_eq!((clock.t(), clock.is_playing()), (1.0, true));
    }

    #[test]
    fn a_run_back_in_time_is_played_as_it_ran() {
        let mut clock = clock([2.0, -2.0]);
        clock.toggle();
        clock.advance(1.0);
        assert_eq!((clock.t(), clock.part()), (1.0, 0.25));
        clock.step_frame(6);
        assert!((clock.t() - 0.9).abs() < 1e-12);
        clock.step_to(true, [2.0, 0.5, -1.0].into_iter());
        assert_eq!(clock.t(), 0.5);
        clock.step_to(false, [2.0, 0.5, -1.0].into_iter());
        assert_eq!(clock.t(), 2.0);
    }

    #[test]
    fn speed_is_one_of_the_list_and_scales_the_elapsed_time() {
        let mut clock = clock([0.0, 1000.0]);
        clock.change_speed(100);
        assert_eq!(clock.speed(), 100.0);
        clock.toggle();
        clock.advance(0.5);
        assert_eq!(clock.t(), 50.0);
        clock.change_speed(-100);
        assert_eq!(clock.speed(), 0.01);
        clock.set_speed(0.9);
        assert_eq!(clock.speed(), 1.0);
    }

    #[test]
    fn steps_stop_at_every_instant_and_at_the_ends() {
        let mut clock = clock([0.0, 1.0]);
        clock.toggle();
        let instants = [0.0, 0.25, 0.5];
        let forward: Vec<f64> = (0..4)
            .map(|_| {
                clock.step_to(true, instants.into_iter());
                clock.t()
            })
            .collect();
        assert_eq!(forward, [0.25, 0.5, 1.0, 1.0]);
        clock.step_to(false, instants.into_iter());
        assert_eq!((clock.t(), clock.is_playing()), (0.5, false));
    }

    #[test]
    fn another_motion_keeps_the_instant_if_it_contains_it() {
        let mut clock = clock([0.0, 10.0]);
        clock.seek(4.0);
        clock.set_span([0.0, 20.0]);
        assert_eq!(clock.t(), 4.0);
        clock.set_span([0.0, 3.0]);
        assert_eq!(clock.t(), 3.0);
        clock.seek(f64::NAN);
        assert_eq!(clock.t(), 0.0);
        // Nothing to play.
        clock.set_span([1.0, 1.0]);
        clock.toggle();
        assert!(!clock.is_playing());
    }
}
