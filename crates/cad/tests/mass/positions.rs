//! Points in, out of and near outlines.

use super::shapes::{Dice, bar, outline, rectangle, strokes};
use bksim_cad::geometry::{Curve, Path};
use std::f64::consts::{PI, TAU};

#[test]
fn points_of_a_bar_with_a_hole() {
    let link = outline(&strokes([bar([0.0, 0.0], 10.0, 2.0), Path::circle([0.0, 0.0], 1.0)]));
    let mut dice = Dice(3);
    for _ in 0..20_000 {
        let [x, y] = [20.0 * dice.roll() - 5.0, 6.0 * dice.roll() - 3.0];
        // Distance from the middle line of the bar, and from the centre of the hole.
        let beyond = x - x.clamp(0.0, 10.0);
        let (away, out) = (beyond.hypot(y), x.hypot(y));
        assert_eq!(link.outer_contains([x, y]), away < 2.0, "({x}, {y})");
        assert_eq!(link.contains([x, y]), away < 2.0 && out > 1.0, "({x}, {y})");
        let known = (away - 2.0).abs().min((out - 1.0).abs());
        let found = link.distance([x, y]);
        assert!((found - known).abs() < 1e-14 * 20.0, "({x}, {y}): {found} {known}");
    }
}

#[test]
fn arcs_are_not_polygons() {
    // Right at the border of arcs of any direction and size.
    for (start, sweep) in [(0.0, TAU), (0.3, -TAU), (1.0, 4.0), (2.0, -5.5), (-1.0, 0.01)] {
        let arc = Curve::Arc { centre: [3.0, -1.0], radius: 5.0, start, sweep };
        let chord = Curve::Segment { from: arc.end_point(), to: arc.start_point() };
        let path = Path { curves: vec![arc, chord], is_closed: true };
        for i in 1..1000 {
            let u = start + sweep * f64::from(i) / 1000.0;
            let at = |r: f64| [3.0 + r * u.cos(), -1.0 + r * u.sin()];
            assert_eq!(path.winding(at(5.0 + 1e-13)), 0, "{start} {sweep} {i}");
            assert_eq!(path.winding(at(5.0 - 1e-13)), if sweep > 0.0 { 1 } else { -1 });
        }
    }
}

#[test]
fn ellipses_contain_what_their_equation_says() {
    let (a, b) = ([4.0, 1.0], [-0.6, 1.4]);
    let curve = Curve::Ellipse { centre: [1.0, 1.0], major: a, minor: b, start: 0.0, sweep: -TAU };
    let path = Path { curves: vec![curve], is_closed: true };
    let mut dice = Dice(5);
    for _ in 0..10_000 {
        let [u, v] = [3.0 * dice.roll() - 1.5, 3.0 * dice.roll() - 1.5];
        let point = [1.0 + u * a[0] + v * b[0], 1.0 + u * a[1] + v * b[1]];
        let expected = if u.hypot(v) < 1.0 { -1 } else { 0 };
        assert_eq!(path.winding(point), expected, "{point:?}");
    }
    // The nearest point of an ellipse on its axes: (a, 0) from outside, (0, b) from the centre.
    let upright = Curve::Ellipse {
        centre: [0.0; 2],
        major: [5.0, 0.0],
        minor: [0.0, 2.0],
        start: 0.1,
        sweep: TAU,
    };
    for (point, known) in [([7.0, 0.0], 2.0), ([0.0, 0.0], 2.0), ([0.0, -6.0], 4.0)] {
        let found = upright.distance(point);
        assert!((found - known).abs() < 1e-12, "{point:?}: {found} {known}");
    }
}

#[test]
fn the_smallest_outline_around_a_point() {
    use bksim_cad::outline::{Outline, chain};
    let plate = rectangle([0.0, 0.0], 20.0, 20.0);
    let next_to_plate = rectangle([40.0, 0.0], 10.0, 10.0);
    let hole = Path::circle([0.0, 0.0], 5.0);
    let pin = Path::circle([0.0, 0.0], 3.0);
    let chains = chain(&strokes([plate, next_to_plate, hole, pin]), 1e-6).expect("good strokes");
    let entities = |point| {
        let outline = Outline::around(&chains.closed, point, 1e-6).expect("a good outline");
        outline.map(|outline| outline.entities())
    };
    // The pin in the hole is another part.
    assert_eq!(entities([8.0, 8.0]), Some(vec![0, 2]));
    assert_eq!(entities([0.0, 1.0]), Some(vec![3]));
    assert_eq!(entities([41.0, 0.0]), Some(vec![1]));
    assert_eq!(entities([15.0, 0.0]), None);
}

#[test]
fn curves_are_measured() {
    let arc = Curve::Arc { centre: [0.0; 2], radius: 2.0, start: PI, sweep: -PI };
    assert_eq!(arc.length(), TAU);
    let bounds = arc.bounds();
    let expected = [[-2.0, 0.0], [2.0, 2.0]];
    for (found, known) in [bounds.min, bounds.max].iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - known).abs() < 1e-15, "{bounds:?}");
    }
    let [x, y] = arc.point(0.5);
    assert!(x.abs() < 1e-15 && (y - 2.0).abs() < 1e-15);
    assert_eq!(arc.reversed().reversed(), arc);
}
