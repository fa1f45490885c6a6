//! Takes: from the samples of a quantity over time to one number.

use super::Take;

/// One number of a run as it goes on.
#[derive(Clone, Debug)]
pub(super) struct Reduced {
    take: Take,
    /// The value so far, or the integral.
    value: f64,
    /// The smallest so far, for a peak to peak.
    least: f64,
    /// The sample before.
    before: f64,
    t_start: f64,
    t: f64,
    is_empty: bool,
    /// Samples and the time that each stands for, for a quantile.
    samples: Vec<(f64, f64)>,
}

impl Reduced {
    pub(super) fn new(take: Take) -> Self {
        Self {
            take,
            value: 0.0,
            least: 0.0,
            before: 0.0,
            t_start: 0.0,
            t: 0.0,
            is_empty: true,
            samples: Vec::new(),
        }
    }

    pub(super) fn clear(&mut self) {
        self.is_empty = true;
        self.samples.clear();
    }

    /// Takes the value at a time; times of a run come in their order.
    pub(super) fn take(&mut self, t: f64, value: f64) {
        let is_first = self.is_empty;
        if is_first {
            (self.t_start, self.least) = (t, value);
        }
        let (dt, before, kept) = (t - self.t, self.before, self.value);
        self.value = match self.take {
            Take::At(at) if t == at => value,
            Take::Final => value,
            Take::Mean | Take::Rms if is_first => 0.0,
            Take::First if is_first && value >= 0.0 => t,
            Take::First | Take::At(_) if is_first => f64::NAN,
            Take::First if kept.is_nan() && value >= 0.0 => t - dt * value / (value - before),
            _ if is_first => value,
            Take::Min => lesser(kept, value),
            Take::Max | Take::PeakToPeak => -lesser(-kept, -value),
            Take::Mean => kept + 0.5 * dt * (before + value),
            Take::Rms => kept + 0.5 * dt * (before * before + value * value),
            Take::At(_) | Take::First | Take::Quantile(_) => kept,
        };
        if self.take == Take::PeakToPeak {
            self.least = lesser(self.least, value);
        }
        if matches!(self.take, Take::Quantile(_)) {
            self.weigh(value, if is_first { 0.0 } else { dt });
        }
        (self.before, self.t, self.is_empty) = (value, t, false);
    }

    /// Takes an extreme between two samples.
    pub(super) fn rise(&mut self, value: f64) {
        match self.take {
            Take::Min => self.value = lesser(self.value, value),
            Take::Max => self.value = -lesser(-self.value, -value),
            Take::PeakToPeak => {
                self.value = -lesser(-self.value, -value);
                self.least = lesser(self.least, value);
            }
            _ => (),
        }
    }

    /// The signs with which extremes are largest, each with the extreme so far.
    pub(super) fn sides(&self) -> [Option<(f64, f64)>; 2] {
        let [most, least] = [(1.0, self.value), (-1.0, self.value)];
        match self.take {
            Take::Max => [Some(most), None],
            Take::Min => [None, Some(least)],
            Take::PeakToPeak => [Some(most), Some((-1.0, self.least))],
            _ => [None, None],
        }
    }

    /// Adds a sample; half of the time since the one before goes to each of both.
    fn weigh(&mut self, value: f64, dt: f64) {
        if let Some((_, time)) = self.samples.last_mut() {
            *time += 0.5 * dt.abs();
        }
        self.samples.push((value, 0.5 * dt.abs()));
    }

    /// The number of the run that has ended.
    pub(super) fn finish(&mut self) -> f64 {
        let (value, span) = (self.value, self.t - self.t_start);
        match self.take {
            Take::Mean if span == 0.0 => self.before,
            Take::Rms if span == 0.0 => self.before.abs(),
            Take::Mean => value / span,
            Take::Rms => (value / span).sqrt(),
            // The largest of nothing is below everything.
            Take::Max | Take::PeakToPeak if self.is_empty => f64::NEG_INFINITY,
            Take::Min if self.is_empty => f64::INFINITY,
            Take::PeakToPeak => value - self.least,
            Take::Quantile(part) => quantile(&mut self.samples, part),
            _ => value,
        }
    }
}

/// The value that samples with weights are below for `part` of their weight: between the middles of
/// their weights by straight lines, so that samples at even times give the usual quantile.
fn quantile(samples: &mut [(f64, f64)], part: f64) -> f64 {
    if samples.iter().any(|(value, _)| value.is_nan()) {
        return f64::NAN;
    }
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = samples.iter().map(|(_, time)| time).sum();
    let (mut below, mut last) = (0.0, None::<(f64, f64)>);
    for &(value, time) in &*samples {
        let middle = below + 0.5 * time;
        below += time;
        if middle >= part * whole {
            let Some((at, other)) = last else { return value };
            let share = if middle > at { (part * whole - at) / (middle - at) } else { 1.0 };
            return other + share * (value - other);
        }
        last = Some((middle, value));
    }
    last.map_or(f64::NAN, |(_, value)| value)
}

/// The smaller one; NaN where either is NaN, so that nothing undefined is lost.
fn lesser(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(take: Take, samples: &[(f64, f64)]) -> f64 {
        let mut reduced = Reduced::new(take);
        for &(t, value) in samples {
            reduced.take(t, value);
        }
        reduced.finish()
    }

    /// x = t² from −1 to 2, at even times.
    fn parabola() -> Vec<(f64, f64)> {
        (0..=3000).map(|idx| f64::from(idx) * 1e-3 - 1.0).map(|t| (t, t * t)).collect()
    }

    #[test]
    fn takes_are_those_of_calculus() {
        let x = parabola();
        let near = |take, expected: f64, room: f64| {
            let found = taken(take, &x);
            assert!((found - expected).abs() < room, "{take:?}: {found} for {expected}");
        };
        near(Take::Final, 4.0, 1e-12);
        near(Take::Min, 0.0, 1e-12);
        near(Take::Max, 4.0, 1e-12);
        near(Take::PeakToPeak, 4.0, 1e-12);
        near(Take::Mean, 1.0, 1e-6);
        near(Take::Rms, (33.0f64 / 5.0 / 3.0).sqrt(), 1e-6);
        near(Take::At(1.5), 2.25, 1e-12);
        // Below 1 from −1 to 1, two thirds of the time; below 2.25 for five sixths.
        near(Take::Quantile(2.0 / 3.0), 1.0, 2e-3);
        near(Take::Quantile(5.0 / 6.0), 2.25, 2e-3);
        near(Take::Quantile(0.0), 0.0, 1e-12);
        near(Take::Quantile(1.0), 4.0, 1e-12);
    }

    #[test]
    fn the_first_crossing_lies_between_samples() {
        let line = [(0.0, -3.0), (1.0, -1.0), (2.0, 3.0), (3.0, -1.0), (4.0, 1.0)];
        assert_eq!(taken(Take::First, &line), 1.25);
        assert_eq!(taken(Take::First, &[(2.0, 0.0), (3.0, -1.0)]), 2.0);
        assert!(taken(Take::First, &[(0.0, -2.0), (1.0, -1.0)]).is_nan());
    }

    #[test]
    fn quantiles_weigh_samples_by_time() {
        // 0 for one second, then 10 for nine seconds, sampled unevenly.
        let uneven = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 10.0), (9.0, 10.0), (10.0, 10.0)];
        assert_eq!(taken(Take::Quantile(0.5), &uneven), 10.0);
        assert_eq!(taken(Take::Quantile(0.05), &uneven), 0.0);
        assert_eq!(taken(Take::Quantile(0.5), &[(1.0, 7.0)]), 7.0);
    }
}
