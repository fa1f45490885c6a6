//! [`Envelope`]: a curve over time in constant memory that loses no peak.
//!
//! Time is cut into buckets; of each one the first, last, lowest and highest point are kept. Drawn
//! with buckets no wider than a pixel, that is the same picture as of all points: U. Jugel, Z.
//! Jerzak, G. Hackenbroich and V. Markl, *M4: A Visualization-Oriented Time Series Data
//! Aggregation*, Proc. VLDB Endowment 7 (2014), section 4. The length of the curve is not known
//! ahead, so whenever the capacity is reached, buckets double in width, each two becoming one.

/// Abscissa and ordinate.
pub type Point = [f64; 2];

/// Largest number that is drawn; beyond are gaps, since differences of such numbers overflow.
pub const LARGEST: f64 = 1e300;

/// Largest number of points that are kept.
const CAPACITY: usize = 1 << 14;
/// Number of buckets in the span of the curve when it is first reduced.
const N_BUCKETS: f64 = 2048.0;

/// A curve over an abscissa that grows, or one that falls; gathered point by point.
///
/// ```
/// use bksim_plot::Envelope;
///
/// let mut envelope = Envelope::default();
/// for i in 0..1_000_000 {
///     let t = f64::from(i) * 1e-3;
///     envelope.push([t, if i == 123_456 { 7.0 } else { t.sin() }]);
/// }
/// let points = envelope.into_points();
/// assert!(points.len() <= 1 << 14);
/// assert!(points.contains(&[123.456, 7.0]));
/// ```
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Envelope {
    points: Vec<Point>,
    /// Width of a bucket; none as long as all points are kept.
    width: Option<f64>,
}

impl Envelope {
    /// Appends a point. An ordinate that is no number makes a gap; so does one beyond [`LARGEST`].
    pub fn push(&mut self, point: Point) {
        if !put(&mut self.points, point) || self.points.len() < CAPACITY {
            return;
        }
        let start = self.points[0][0];
        let end = self.points[self.points.len() - 1][0];
        let mut width = self.width.unwrap_or((end - start).abs() / N_BUCKETS);
        reduce(&mut self.points, |t| bucket(t, start, width));
        while self.points.len() > CAPACITY / 2 {
            width = (2.0 * width).max(f64::MIN_POSITIVE);
            reduce(&mut self.points, |t| bucket(t, start, width));
        }
        self.width = Some(width);
    }

    /// The points that are kept, in their order; a gap is a point whose ordinate is NaN.
    pub fn into_points(self) -> Vec<Point> {
        self.points
    }
}

/// Appends a point, of consecutive gaps only the first; returns whether it did.
pub(crate) fn put(points: &mut Vec<Point>, [x, y]: Point) -> bool {
    let is_drawn = x.abs() <= LARGEST && y.abs() <= LARGEST;
    let is_after_gap = points.last().is_none_or(|[_, last]| last.is_nan());
    if is_drawn {
        points.push([x, y]);
    } else if x.is_nan() || is_after_gap {
        return false;
    } else {
        points.push([x.clamp(-LARGEST, LARGEST), f64::NAN]);
    }
    true
}

/// Distance from the start in whole buckets.
fn bucket(t: f64, start: f64, width: f64) -> f64 {
    // Halves, because the distance of the largest numbers is infinite.
    ((0.5 * t - 0.5 * start).abs() / (0.5 * width)).floor()
}

/// Keeps the first, last, lowest and highest of consecutive points in one bucket.
pub(crate) fn reduce(points: &mut Vec<Point>, bucket: impl Fn(f64) -> f64) {
    let (mut n_kept, mut first) = (0, 0);
    while first < points.len() {
        let own = bucket(points[first][0]);
        let same = |[t, _]: &Point| bucket(*t) == own;
        let n = points[first..].iter().position(|point| !same(point));
        // At least one point, also where the bucket is NaN, which equals no bucket.
        let end = n.map_or(points.len(), |n| first + n.max(1));
        let mut kept = extremes(&points[first..end]);
        kept.sort_unstable();
        let mut last_kept = None;
        for idx in kept {
            if last_kept.replace(idx) != Some(idx) {
                points[n_kept] = points[first + idx];
                n_kept += 1;
            }
        }
        first = end;
    }
    points.truncate(n_kept);
}

/// Indices of the first, last, lowest and highest point. Gaps are neither low nor high; where an
/// end is a gap, the number next to it counts, too.
fn extremes(group: &[Point]) -> [usize; 6] {
    let last = group.len() - 1;
    let numbers = || group.iter().enumerate().filter(|(_, [_, y])| !y.is_nan());
    let by_height = |a: &(usize, &Point), b: &(usize, &Point)| a.1[1].total_cmp(&b.1[1]);
    let index = |found: Option<(usize, &Point)>| found.map_or(0, |(idx, _)| idx);
    [
        0,
        index(numbers().next()),
        index(numbers().min_by(by_height)),
        index(numbers().max_by(by_height)),
        index(numbers().next_back()),
        last,
    ]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    fn range(points: &[Point]) -> (f64, f64) {
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [_, y]| {
            (low.min(*y), high.max(*y))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, rng_seed: RngSeed::Fixed(1928), ..ProptestConfig::default() })]

        #[test]
        fn extremes_ends_and_order_survive_any_length(
            n in 1_usize..120_000,
            forward in any::<bool>(),
            seed in 1_u64..u64::MAX,
        ) {
            let mut random = seed;
            let mut next = || {
                random ^= random << 13;
                random ^= random >> 7;
                random ^= random << 17;
                (random >> 11) as f64 / (1_u64 << 53) as f64
            };
            let (mut t, mut all, mut envelope) = (next(), Vec::new(), Envelope::default());
            for _ in 0..n {
                t += next().powi(8) * if forward { 1.0 } else { -1.0 };
                let point = [t, next().powi(20) - next().powi(20)];
                all.push(point);
                envelope.push(point);
            }
            let width = envelope.width;
            let kept = envelope.into_points();
            prop_assert!(kept.len() <= CAPACITY);
            prop_assert_eq!(range(&kept), range(&all));
            prop_assert_eq!((kept[0], kept[kept.len() - 1]), (all[0], all[n - 1]));
            let sign = if forward { 1.0 } else { -1.0 };
            let is_in_order = kept.is_sorted_by(|a, b| sign * a[0] <= sign * b[0]);
            prop_assert!(is_in_order);
            // The same holds in each bucket.
            let Some(width) = width else { return Ok(()) };
            let of = |points: &[Point], idx: f64| {
                let inside = |p: &&Point| bucket(p[0], all[0][0], width) == idx;
                range(&points.iter().filter(inside).copied().collect::<Vec<_>>())
            };
            for point in all.iter().step_by(n / 20 + 1) {
                let idx = bucket(point[0], all[0][0], width);
                prop_assert_eq!(of(&kept, idx), of(&all, idx));
            }
        }
    }

    #[test]
    fn consecutive_points_that_are_not_finite_are_one_gap() {
        let mut envelope = Envelope::default();
        for y in [f64::NAN, 1.0, f64::NAN, f64::INFINITY, -1e301, 2.0] {
            envelope.push([0.0, y]);
        }
        envelope.push([f64::NAN, 3.0]);
        let points = envelope.into_points();
        assert_eq!(
            points.iter().map(|[_, y]| y.is_nan()).collect::<Vec<_>>(),
            [false, true, false]
        );
    }

    #[test]
    fn times_that_jump_about_stay_in_memory() {
        let mut envelope = Envelope::default();
        for i in 0..100_000 {
            let t = if i % 2 == 0 { -1e300 } else { 1e300 };
            envelope.push([t, if i == 77_777 { 9.0 } else { f64::NAN }]);
            envelope.push([t, f64::from(i % 3)]);
        }
        let points = envelope.into_points();
        assert!(points.len() <= CAPACITY, "{}", points.len());
        assert_eq!(range(&points).1, 9.0);
    }
}
