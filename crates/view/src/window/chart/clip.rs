//! The visible part of a curve, no finer than pixels.

use egui_plot::PlotPoint;

/// A rectangle in the coordinates of a panel's axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Bounds {
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
}

/// Points of a piece over time within a range, with a neighbour at each side.
pub(super) fn between(piece: &[PlotPoint], [low, high]: [f64; 2]) -> &[PlotPoint] {
    let first = piece.partition_point(|point| point.x < low).saturating_sub(1);
    let end = piece.partition_point(|point| point.x <= high).saturating_add(1);
    &piece[first..end.min(piece.len()).max(first)]
}

/// The first, lowest, highest and last point of each of `n` columns: in columns no wider than a
/// pixel, they look like all points.
pub(super) fn thinned(piece: &[PlotPoint], [low, high]: [f64; 2], n: usize) -> Vec<PlotPoint> {
    if piece.len() <= 4 * n.max(1) {
        return piece.to_vec();
    }
    let width = (high - low) / n.max(1) as f64;
    let column = |point: &PlotPoint| ((point.x - low) / width).floor();
    let mut kept = Vec::with_capacity(4 * n + 8);
    for chunk in piece.chunk_by(|a, b| column(a) == column(b)) {
        let (mut lowest, mut highest) = (0, 0);
        for (idx, point) in chunk.iter().enumerate() {
            if point.y < chunk[lowest].y {
                lowest = idx;
            }
            if point.y > chunk[highest].y {
                highest = idx;
            }
        }
        let mut kept_idx = [0, lowest, highest, chunk.len() - 1];
        kept_idx.sort_unstable();
        kept.extend(kept_idx.iter().enumerate().filter_map(|(k, &idx)| {
            let is_new = k == 0 || kept_idx[k - 1] != idx;
            is_new.then(|| chunk[idx])
        }));
    }
    kept
}

/// The parts of a line in a rectangle. The rest is cut off, since a dashed line a million pixels
/// long would have as many dashes.
pub(super) fn clipped(line: &[PlotPoint], bounds: Bounds) -> Vec<Vec<PlotPoint>> {
    if let [point] = line {
        let is_in = |x: f64, [low, high]: [f64; 2]| (low..=high).contains(&x);
        let is_seen = is_in(point.x, bounds.x) && is_in(point.y, bounds.y);
        return if is_seen { vec![vec![*point]] } else { Vec::new() };
    }
    let mut parts: Vec<Vec<PlotPoint>> = Vec::new();
    let mut end = None;
    for pair in line.windows(2) {
        let Some([a, b]) = clipped_segment(pair[0], pair[1], bounds) else {
            end = None;
            continue;
        };
        match parts.last_mut() {
            Some(part) if end == Some(a) => part.push(b),
            _ => parts.push(vec![a, b]),
        }
        end = Some(b);
    }
    parts
}

/// The part of a segment in a rectangle, by the parameters at which it crosses the edges: Y.-D.
/// Liang and B. A. Barsky, *A new concept and method for line clipping*, ACM TOG 3 (1984) 1–22.
fn clipped_segment(a: PlotPoint, b: PlotPoint, bounds: Bounds) -> Option<[PlotPoint; 2]> {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let [left, right] = bounds.x;
    let [bottom, top] = bounds.y;
    for (along, distance) in
        [(-dx, a.x - left), (dx, right - a.x), (-dy, a.y - bottom), (dy, top - a.y)]
    {
        if along == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if along < 0.0 {
            enter = enter.max(distance / along);
        } else {
            leave = leave.min(distance / along);
        }
    }
    if enter > leave {
        return None;
    }
    let at = |part: f64, whole: PlotPoint| {
        if part == 0.0 || part == 1.0 {
            return whole;
        }
        PlotPoint::new(a.x + part * dx, a.y + part * dy)
    };
    Some([at(enter, a), at(leave, b)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(xy: &[[f64; 2]]) -> Vec<PlotPoint> {
        xy.iter().map(|&[x, y]| PlotPoint::new(x, y)).collect()
    }

    const SQUARE: Bounds = Bounds { x: [0.0, 1.0], y: [0.0, 1.0] };

    #[test]
    fn a_line_is_cut_where_it_leaves_and_comes_back() {
        let line = points(&[[-1.0, 0.5], [0.5, 0.5], [0.5, 3.0], [0.75, 3.0], [0.75, 0.5]]);
        let parts = clipped(&line, SQUARE);
        let first = points(&[[0.0, 0.5], [0.5, 0.5], [0.5, 1.0]]);
        assert_eq!(parts, [first, points(&[[0.75, 1.0], [0.75, 0.5]])]);
        assert!(clipped(&points(&[[2.0, 0.0], [2.0, 1.0]]), SQUARE).is_empty());
        assert!(clipped(&points(&[[-0.5, 0.9], [0.9, 2.5]]), SQUARE).is_empty(), "a corner");
        assert_eq!(clipped(&points(&[[0.5, 0.5]]), SQUARE).len(), 1);
        assert!(clipped(&[], SQUARE).is_empty());
    }

    #[test]
    fn visible_points_come_with_their_neighbours() {
        let line = points(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0], [4.0, 4.0]]);
        let xs = |range| between(&line, range).iter().map(|p| p.x).collect::<Vec<_>>();
        assert_eq!(xs([1.5, 2.5]), [1.0, 2.0, 3.0]);
        assert_eq!(xs([1.2, 1.4]), [1.0, 2.0]);
        assert_eq!(xs([-5.0, 9.0]).len(), 5);
        assert_eq!(xs([7.0, 9.0]), [4.0]);
        assert!(between(&[], [0.0, 1.0]).is_empty());
    }

    #[test]
    fn thinning_keeps_peaks_and_ends() {
        let mut line: Vec<PlotPoint> =
            (0..10_000).map(|i| PlotPoint::new(f64::from(i), (f64::from(i) * 0.3).sin())).collect();
        line[1234].y = 7.0;
        line[8765].y = -7.0;
        let kept = thinned(&line, [0.0, 9_999.0], 100);
        assert!(kept.len() <= 4 * 101, "{}", kept.len());
        for idx in [0, 1234, 8765, 9_999] {
            assert!(kept.contains(&line[idx]), "{idx}");
        }
        assert!(kept.is_sorted_by(|a, b| a.x <= b.x));
        assert_eq!(thinned(&line[..50], [0.0, 50.0], 100), line[..50]);
    }
}
