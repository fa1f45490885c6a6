//! [`Trace`]: a curve in the plane in constant memory that keeps its shape.
//!
//! A point is dropped when the chord between the neighbours that stay passes it within a tolerance.
//! One sweep finds those: all directions from the last point kept that pass each point since within
//! the tolerance are a sector, which shrinks with every point; a point outside of it ends the chord
//! at the one before. Lines over earlier lines, as a periodic motion draws them, are dropped, too.
//! J. Sklansky and V. Gonzalez, *Fast polygonal approximation of digitized curves*, Pattern
//! Recognition 12 (1980) 327–331.

use crate::decimate::{Point, put};

/// Largest number of points that are kept.
const CAPACITY: usize = 1 << 16;
/// The first tolerance, relative to the curve's width and height: a fraction of a pixel.
const TOLERANCE: f64 = 1.0 / 8192.0;

/// A curve in the plane, gathered point by point, such as a phase portrait.
///
/// Dropped points lie within a fraction of a pixel of the lines that are kept. A curve of more
/// detail than the capacity allows, which would fill the picture, loses the finest.
#[derive(Clone, PartialEq, Debug)]
pub struct Trace {
    points: Vec<Point>,
    tolerance: f64,
}

impl Default for Trace {
    fn default() -> Self {
        Self { points: Vec::new(), tolerance: TOLERANCE }
    }
}

impl Trace {
    /// Appends a point. Coordinates that are not finite make a gap.
    pub fn push(&mut self, point: Point) {
        if !put(&mut self.points, point) || self.points.len() < CAPACITY {
            return;
        }
        let scale = unit_scale(&self.points);
        thin(&mut self.points, scale, self.tolerance);
        drop_covered(&mut self.points, scale);
        while self.points.len() > CAPACITY / 2 && self.tolerance < 1.0 {
            self.tolerance *= 2.0;
            thin(&mut self.points, scale, self.tolerance);
        }
        if self.points.len() > CAPACITY / 2 {
            // Only gaps are left to drop: a curve of single points, of which every second is
            // enough.
            let mut idx = 0;
            self.points.retain(|_| {
                idx += 1;
                idx % 4 < 2
            });
        }
    }

    /// The points that are kept, in their order; a gap is a point whose ordinate is NaN.
    pub fn into_points(self) -> Vec<Point> {
        self.points
    }
}

/// Factors that make the curve one wide and one high.
fn unit_scale(points: &[Point]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let values = points.iter().map(|point| point[axis]).filter(|value| !value.is_nan());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let scale = 1.0 / (high - low);
        if scale.is_finite() { scale } else { 0.0 }
    })
}

/// Cells along each side of the grid of drawn lines: about one to a pixel.
const N_CELLS: usize = 1024;
/// Number of following lines that a line does not cover: neighbours always touch.
const N_NEIGHBOURS: usize = 16;

/// Drops lines that run within a cell of the grid of earlier lines.
fn drop_covered(points: &mut Vec<Point>, scale: [f64; 2]) {
    let is_new = new_lines(points, scale);
    let last = points.len() - 1;
    let outermost = outermost(points);
    let mut kept = Vec::with_capacity(points.len());
    for (idx, &[x, y]) in points.iter().enumerate() {
        let goes_on = idx == last || is_new[idx];
        let is_kept = goes_on || (idx > 0 && is_new[idx - 1]) || outermost.contains(&idx);
        if is_kept {
            put(&mut kept, [x, y]);
        }
        if !goes_on {
            put(&mut kept, [x, f64::NAN]);
        }
    }
    *points = kept;
}

/// For each line between neighbours, whether it enters a cell without earlier lines; lines to gaps
/// are new.
fn new_lines(points: &[Point], scale: [f64; 2]) -> Vec<bool> {
    let corner = [0, 1].map(|axis| {
        let values = points.iter().filter(|point| !point[1].is_nan()).map(|point| point[axis]);
        values.fold(f64::INFINITY, f64::min)
    });
    // A rim around the grid spares a test of the neighbours for cells at its edge.
    let width = N_CELLS + 4;
    let mut drawn_by = vec![usize::MAX; width * width];
    let in_grid = |point: Point| {
        [0, 1].map(|axis| 2.0 + (point[axis] - corner[axis]) * scale[axis] * N_CELLS as f64)
    };
    let is_new = |(number, pair): (usize, &[Point])| {
        let [from, to] = [pair[0], pair[1]];
        if from[1].is_nan() || to[1].is_nan() {
            return true;
        }
        let mut is_new = false;
        for cell in cells(in_grid(from), in_grid(to), width) {
            let mut around = [0, 1, 2].into_iter().flat_map(|row| {
                let first = cell + row * width - width - 1;
                &drawn_by[first..first + 3]
            });
            is_new |= !around.any(|&by| by.saturating_add(N_NEIGHBOURS) < number);
            // The first line in a cell is the one that stays.
            drawn_by[cell] = drawn_by[cell].min(number);
        }
        is_new
    };
    points.windows(2).enumerate().map(is_new).collect()
}

/// Cells of a grid, numbered row by row, that a line goes through.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside of the grid")]
fn cells(from: Point, to: Point, width: usize) -> impl Iterator<Item = usize> {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let n = dx.abs().max(dy.abs()).ceil().clamp(1.0, width as f64) as usize;
    (0..=n).map(move |k| {
        let part = k as f64 / n as f64;
        let [column, row] = [from[0] + part * dx, from[1] + part * dy]
            .map(|position| position.clamp(1.0, (width - 2) as f64) as usize);
        row * width + column
    })
}

/// Drops the points that, times `scale`, are within `tolerance` of the chord between those that
/// stay. The ends and the outermost points in all four directions stay.
pub(crate) fn thin(points: &mut Vec<Point>, scale: [f64; 2], tolerance: f64) {
    let outermost = outermost(points);
    let mut n_kept = 0;
    let mut chord: Option<Chord> = None;
    for idx in 0..points.len() {
        let point = points[idx];
        if point[1].is_nan() {
            // A gap ends the piece before it.
            if let Some(chord) = chord.take()
                && idx > 0
            {
                keep(points, &mut n_kept, chord.last);
            }
            keep(points, &mut n_kept, point);
            continue;
        }
        let Some(current) = &mut chord else {
            keep(points, &mut n_kept, point);
            chord = Some(Chord::new(point));
            continue;
        };
        if !current.passes(point, scale, tolerance) {
            let last = current.last;
            keep(points, &mut n_kept, last);
            *current = Chord::new(last);
            current.passes(point, scale, tolerance);
        }
        current.last = point;
        if outermost.contains(&idx) {
            keep(points, &mut n_kept, point);
            *current = Chord::new(point);
        }
    }
    if let Some(chord) = chord {
        keep(points, &mut n_kept, chord.last);
    }
    points.truncate(n_kept);
}

/// Appends a point to those kept at the front, unless it is the last of them.
fn keep(points: &mut [Point], n_kept: &mut usize, point: Point) {
    let is_kept = n_kept.checked_sub(1).is_some_and(|last| points[last] == point);
    if !is_kept && *n_kept < points.len() {
        points[*n_kept] = point;
        *n_kept += 1;
    }
}

/// Indices of the outermost points along x and y, on either side.
fn outermost(points: &[Point]) -> [usize; 4] {
    let mut found = [0; 4];
    for (idx, point) in points.iter().enumerate().filter(|(_, point)| !point[1].is_nan()) {
        for (direction, best) in found.iter_mut().enumerate() {
            let sign = if direction % 2 == 0 { 1.0 } else { -1.0 };
            let height = |point: &Point| sign * point[direction / 2];
            if points[*best][1].is_nan() || height(point) > height(&points[*best]) {
                *best = idx;
            }
        }
    }
    found
}

/// A chord that begins at a point that is kept.
struct Chord {
    start: Point,
    last: Point,
    /// Farthest distance from the start so far.
    reach: f64,
    /// Directions at the right and left edge of the sector.
    sector: Option<[Point; 2]>,
}

impl Chord {
    fn new(start: Point) -> Self {
        Self { start, last: start, reach: 0.0, sector: None }
    }

    /// True if the chord may go on to `point`; the sector shrinks if so.
    fn passes(&mut self, point: Point, scale: [f64; 2], tolerance: f64) -> bool {
        let [x, y] = [0, 1].map(|axis| (point[axis] - self.start[axis]) * scale[axis]);
        let distance = x.hypot(y);
        // A chord to a point that is back again would leave out the farthest one.
        if distance < self.reach - tolerance {
            return false;
        }
        self.reach = self.reach.max(distance);
        if distance <= tolerance {
            return self.sector.is_none();
        }
        let direction = [x / distance, y / distance];
        if let Some([right, left]) = self.sector
            && (cross(right, direction) < 0.0 || cross(direction, left) < 0.0)
        {
            return false;
        }
        let sine = tolerance / distance;
        let cosine = (1.0 - sine * sine).sqrt();
        let turned = |sine: f64| {
            let [x, y] = direction;
            [cosine * x - sine * y, sine * x + cosine * y]
        };
        let [mut right, mut left] = [turned(-sine), turned(sine)];
        if let Some([old_right, old_left]) = self.sector {
            right = if cross(old_right, right) < 0.0 { old_right } else { right };
            left = if cross(left, old_left) < 0.0 { old_left } else { left };
        }
        self.sector = Some([right, left]);
        true
    }
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    /// Distance of `p` from the segment between `a` and `b`.
    fn distance(p: Point, a: Point, b: Point) -> f64 {
        let [d, r] = [[b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]];
        let length = d[0] * d[0] + d[1] * d[1];
        let part = if length == 0.0 { 0.0 } else { (d[0] * r[0] + d[1] * r[1]) / length };
        let part = part.clamp(0.0, 1.0);
        (r[0] - part * d[0]).hypot(r[1] - part * d[1])
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, rng_seed: RngSeed::Fixed(1973), ..ProptestConfig::default() })]

        #[test]
        fn dropped_points_lie_near_the_chords(
            steps in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 1..400),
            tolerance in 0.01..2.0_f64,
        ) {
            let mut at = [0.0, 0.0];
            let all: Vec<Point> = steps.iter().map(|(dx, dy)| {
                at = [at[0] + dx, at[1] + dy];
                at
            }).collect();
            let mut kept = all.clone();
            thin(&mut kept, [1.0; 2], tolerance);
            prop_assert_eq!((kept[0], kept[kept.len() - 1]), (all[0], all[all.len() - 1]));
            for axis in [0, 1] {
                let largest = |points: &[Point]| points.iter().map(|p| p[axis]).fold(f64::MIN, f64::max);
                prop_assert_eq!(largest(&kept), largest(&all));
            }
            for point in all {
                let chords = kept.windows(2).map(|pair| distance(point, pair[0], pair[1]));
                let nearest = chords.fold(distance(point, kept[0], kept[0]), f64::min);
                // A tolerance back along the chord, and one across it.
                prop_assert!(nearest <= 1.5 * tolerance, "{nearest} > {tolerance}");
            }
        }
    }

    #[test]
    fn a_circle_run_through_for_hours_stays_a_circle() {
        let mut trace = Trace::default();
        for i in 0..1_000_000 {
            let angle = f64::from(i) * 0.0123;
            trace.push([3.0 * angle.cos(), angle.sin()]);
        }
        let points = trace.into_points();
        assert!(points.len() <= CAPACITY);
        let lines = || points.windows(2).filter(|pair| pair.iter().all(|point| !point[1].is_nan()));
        for pair in lines() {
            let middle = [(pair[0][0] + pair[1][0]) / 6.0, f64::midpoint(pair[0][1], pair[1][1])];
            let radius = middle[0].hypot(middle[1]);
            assert!((radius - 1.0).abs() < 1e-3, "{radius} between {pair:?}");
        }
        // No part of it is missing.
        for degree in 0..360 {
            let angle = f64::from(degree).to_radians();
            let at = [3.0 * angle.cos(), angle.sin()];
            let nearest = lines().map(|pair| distance(at, pair[0], pair[1])).fold(9.0, f64::min);
            assert!(nearest < 6e-3, "{nearest} at {degree}");
        }
    }

    #[test]
    fn gaps_stay_and_memory_is_bounded() {
        let mut points = vec![
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.5, f64::NAN],
            [3.0, 0.0],
            [4.0, 0.0],
            [5.0, 0.0],
        ];
        thin(&mut points, [1.0; 2], 0.1);
        assert_eq!(points.len(), 5, "{points:?}");
        let mut trace = Trace::default();
        for i in 0..500_000 {
            trace.push([f64::from(i % 97), if i % 2 == 0 { f64::NAN } else { f64::from(i % 89) }]);
        }
        assert!(trace.into_points().len() <= CAPACITY);
    }
}
