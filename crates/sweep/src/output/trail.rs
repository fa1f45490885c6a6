//! Trails: the last values of a quantity, which say where a peak may be between samples.

use std::convert::Infallible;

use bksim::sim::run::peak;

/// Parts of a value below which its samples differ by rounding.
const ROUNDING: f64 = 1e-12;

/// The last values of a quantity over time, of which some bracket a peak.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    /// The last sample and the one before it.
    last: Option<(f64, f64)>,
    before: Option<(f64, f64)>,
}

impl Trail {
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Takes the next value; the last one with its neighbours.
    pub(super) fn next(&mut self, t: f64, value: f64) -> Option<[(f64, f64); 3]> {
        let around = self.last.map(|last| [self.before.unwrap_or(last), last, (t, value)]);
        (self.before, self.last) = (self.last, Some((t, value)));
        around
    }

    /// The last value with its only neighbour, at the end; nothing is left.
    pub(super) fn end(&mut self) -> Option<[(f64, f64); 3]> {
        let Self { last, before } = std::mem::take(self);
        before.zip(last).map(|(before, last)| [before, last, last])
    }

    /// The instant of the value before the last one: nothing earlier is asked for.
    pub(super) fn since(&self) -> Option<f64> {
        self.before.or(self.last).map(|(t, _)| t)
    }
}

/// The largest value next to the middle of three samples, `sign` times the quantity, if it may be above `best`.
pub(super) fn between(
    samples: [(f64, f64); 3],
    (sign, best): (f64, f64),
    at: &mut dyn FnMut(f64) -> f64,
) -> Option<(f64, f64)> {
    let [left, middle, right] = samples.map(|(t, value)| (t, sign * value));
    let drop = middle.1 - left.1.min(right.1);
    let is_peak = middle.1 >= left.1 && middle.1 >= right.1 && drop > ROUNDING * middle.1.abs();
    // Between three samples a peak rises by less than they differ.
    if !is_peak || middle.1 + drop <= sign * best || left.0 == right.0 {
        return None;
    }
    let mut value = |t: f64| Ok::<f64, Infallible>(sign * at(t));
    let Ok((t, found)) = peak(&mut value, [left, middle, right]);
    (found > middle.1).then_some((t, sign * found))
}
