//! Extremes and signs of functions that are smooth between borders.

/// Samples in a full turn.
const PER_TURN: f64 = 1440.0;
/// Fewest samples of an interval.
const FEWEST: f64 = 24.0;
/// Steps of a golden section, after which nothing is left of an interval.
const N_GOLDEN: usize = 80;

/// A part of a turn in which one formula holds, its right border without the value there.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Interval {
    /// rad.
    pub(super) from: f64,
    /// rad.
    pub(super) to: f64,
}

/// A value, and the angle of the cam where it is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Located {
    /// The value.
    pub value: f64,
    /// rad.
    pub at: f64,
}

/// The intervals between borders, which ascend, no further than `end`.
pub(super) fn intervals(borders: &[f64], end: f64) -> Vec<Interval> {
    let pairs = borders.windows(2).map(|pair| Interval { from: pair[0], to: pair[1].min(end) });
    // What rounding leaves of an interval is none.
    pairs.filter(|interval| interval.to - interval.from > 1e-12).collect()
}

impl Interval {
    /// Angles from border to border, the right one from within.
    fn samples(self) -> Vec<f64> {
        let length = self.to - self.from;
        let n = (PER_TURN * length / std::f64::consts::TAU).max(FEWEST).ceil();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small number"
        )]
        let inner = (0..n as usize).map(|k| self.from + length * k as f64 / n);
        inner.chain([self.to.next_down()]).collect()
    }
}

/// The least value; none where the function has none.
pub(super) fn least(turn: &[Interval], value: &dyn Fn(f64) -> f64) -> Option<Located> {
    let mut best: Option<Located> = None;
    let mut offer = |found: Located| {
        if found.value < best.map_or(f64::INFINITY, |best| best.value) {
            best = Some(found);
        }
    };
    for interval in turn {
        let samples = interval.samples();
        let values: Vec<f64> = samples.iter().map(|&at| value(at)).collect();
        // A function that has no value somewhere has no least one.
        if values.iter().any(|value| value.is_nan()) {
            return None;
        }
        let idx = (0..samples.len()).min_by(|&i, &j| values[i].total_cmp(&values[j]))?;
        offer(Located { value: values[idx], at: samples[idx] });
        let from = samples[idx.saturating_sub(1)];
        let to = samples[(idx + 1).min(samples.len() - 1)];
        let at = golden(value, from, to);
        offer(Located { value: value(at), at });
    }
    best
}

/// The place of a minimum by the golden section.
fn golden(value: &dyn Fn(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let [mut a, mut b] = [to - share * (to - from), from + share * (to - from)];
    let [mut of_a, mut of_b] = [value(a), value(b)];
    for _ in 0..N_GOLDEN {
        if of_a <= of_b {
            (to, b, of_b) = (b, a, of_a);
            a = to - share * (to - from);
            of_a = value(a);
        } else {
            (from, a, of_a) = (a, b, of_b);
            b = from + share * (to - from);
            of_b = value(b);
        }
    }
    if of_a <= of_b { a } else { b }
}

/// The stretches in which a function is below zero.
pub(super) fn stretches(turn: &[Interval], value: &dyn Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    let is_below = |at: f64| value(at) < 0.0;
    for interval in turn {
        let samples = interval.samples();
        for pair in samples.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let stretch = match (is_below(from), is_below(to)) {
                (false, false) => continue,
                (true, true) => [from, to],
                (true, false) => [from, change(&is_below, from, to)],
                (false, true) => [change(&is_below, from, to), to],
            };
            match found.last_mut() {
                // The next formula goes on where this one ended.
                Some(last) if stretch[0] - last[1] < 1e-9 => last[1] = stretch[1],
                _ => found.push(stretch),
            }
        }
    }
    found
}

/// The place between two points where a condition changes.
fn change(holds: &dyn Fn(f64) -> bool, mut from: f64, mut to: f64) -> f64 {
    let at_start = holds(from);
    for _ in 0..60 {
        let middle = f64::midpoint(from, to);
        *(if holds(middle) == at_start { &mut from } else { &mut to }) = middle;
    }
    to
}
