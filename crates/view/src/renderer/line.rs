//! Lines as segments that know their neighbours.

use super::primitive::{Kind, Primitive};

/// The segments of a line through points; repeated points are skipped, and points that are not
/// finite cut the line. A line of one point is a dot.
pub(super) fn segments(points: &[[f32; 3]], is_closed: bool) -> Vec<Primitive> {
    let is_finite = |p: &[f32; 3]| p.iter().all(|x| x.is_finite());
    let is_whole = points.iter().all(is_finite);
    let pieces = points.split(|p| !is_finite(p)).filter(|piece| !piece.is_empty());
    pieces.flat_map(|piece| piece_segments(piece, is_closed && is_whole)).collect()
}

fn piece_segments(points: &[[f32; 3]], is_closed: bool) -> Vec<Primitive> {
    let mut points = points.to_vec();
    points.dedup();
    if is_closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    let n = points.len();
    // Two points are joined only once: a closed line needs a third.
    let is_closed = is_closed && n > 2;
    let n_segments = if is_closed || n == 1 { n } else { n - 1 };
    let segment = |i: usize| {
        let (has_before, has_after) = (is_closed || i > 0, is_closed || i + 2 < n);
        let (before, after) = (points[(i + n - 1) % n], points[(i + 2) % n]);
        let (a, b) = (points[i], points[(i + 1) % n]);
        let kind = Kind::Segment { has_before, has_after }.bits();
        Primitive { a, b, before, after, kind, ..Primitive::default() }
    };
    (0..n_segments).map(segment).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_closed_line_has_a_neighbour_on_every_side_and_an_open_one_has_ends() {
        let closed = segments(&SQUARE, true);
        assert_eq!(closed.len(), 4);
        let kind = |has_before, has_after| Kind::Segment { has_before, has_after }.bits();
        assert!(closed.iter().all(|s| s.kind == kind(true, true)));
        assert_eq!((closed[3].b, closed[3].after), (SQUARE[0], SQUARE[1]));
        let open = segments(&SQUARE, false);
        let kinds: Vec<u32> = open.iter().map(|s| s.kind).collect();
        assert_eq!(kinds, [kind(false, true), kind(true, true), kind(true, false)]);
    }

    #[test]
    fn repeated_points_are_skipped_and_bad_ones_cut() {
        let [a, b, c, d] = SQUARE;
        assert_eq!(segments(&[a, a, b, b, a], true).len(), 1);
        assert_eq!(segments(&[a], true).len(), 1);
        assert_eq!(segments(&[], true).len(), 0);
        assert_eq!(segments(&[a, b, [f32::NAN; 3], c, d], true).len(), 2);
    }
}
