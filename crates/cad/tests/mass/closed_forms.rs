//! Shapes with closed forms, to 1e-12.

use super::known::{Known, assert_near};
use super::shapes::{
    arc, bar, line, polygon, polyline, properties, rectangle, rounded_rectangle, strokes,
};
use bksim_cad::geometry::{Curve, Path, Point};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

fn check(name: &str, paths: impl IntoIterator<Item = Path>, known: Known) {
    assert_near(name, &properties(&strokes(paths)), &known.properties(), 1e-12);
}

fn known_bar([x, y]: Point, length: f64, r: f64) -> Known {
    Known::rectangle([x + length / 2.0, y], length, 2.0 * r)
        .plus(Known::sector([x, y], r, FRAC_PI_2, PI))
        .plus(Known::sector([x + length, y], r, FRAC_PI_2, 0.0))
        .with_perimeter(2.0 * length + TAU * r)
}

/// The chord of the arc from `start` by `sweep`, closed by its chord.
fn chorded(centre: Point, r: f64, start: f64, sweep: f64) -> Vec<Path> {
    let arc = arc(centre, r, start, sweep);
    let (from, to) = (arc.end_point(), arc.start_point());
    let chord = line(from.expect("an end"), to.expect("an end"));
    vec![arc, chord]
}

#[test]
fn rectangles() {
    let known = Known::rectangle([3.0, -2.0], 7.0, 2.0).with_perimeter(18.0);
    check("rectangle", [rectangle([3.0, -2.0], 7.0, 2.0)], known);
    check("clockwise rectangle", [rectangle([3.0, -2.0], 7.0, 2.0).reversed()], known);
    // The reference is about the origin, so it is taken near and moved.
    let mut far = Known::rectangle([0.0, 0.0], 4.0, 2.0).with_perimeter(12.0).properties();
    far.centroid = [1e6 + 0.5, -2e6];
    let found = properties(&strokes([rectangle(far.centroid, 4.0, 2.0)]));
    assert_near("far-away rectangle", &found, &far, 1e-12);
}

#[test]
fn polygons() {
    let right = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]];
    check("right triangle", [polygon(&right)], Known::triangle(right).with_perimeter(12.0));
    let slanted = [[1.0, 1.0], [8.0, 2.0], [4.0, 9.0]];
    let perimeter = 50_f64.sqrt() + 65_f64.sqrt() + 73_f64.sqrt();
    check("triangle", [polygon(&slanted)], Known::triangle(slanted).with_perimeter(perimeter));

    let side = 1.7;
    let corners: Vec<Point> = (0..6)
        .map(|i| f64::from(i) * FRAC_PI_2 / 1.5)
        .map(|u| [0.4 + side * u.cos(), 0.2 + side * u.sin()])
        .collect();
    let root3 = 3_f64.sqrt();
    let second = 5.0 * root3 / 16.0 * side.powi(4);
    let area = 1.5 * root3 * side * side;
    let known = Known::about_centroid(area, [0.4, 0.2], [second, 0.0, second]);
    check("hexagon", [polygon(&corners)], known.with_perimeter(6.0 * side));

    let angle = [[0.0, 0.0], [60.0, 0.0], [60.0, 10.0], [10.0, 10.0], [10.0, 80.0], [0.0, 80.0]];
    let known =
        Known::rectangle([30.0, 5.0], 60.0, 10.0).plus(Known::rectangle([5.0, 45.0], 10.0, 70.0));
    check("L-shape", [polygon(&angle)], known.with_perimeter(280.0));
}

#[test]
fn circles_and_rings() {
    let disc = |r: f64| Known::disc([2.0, 5.0], r);
    check("circle", [Path::circle([2.0, 5.0], 3.0)], disc(3.0).with_perimeter(TAU * 3.0));
    let halves = [(5.0, 5.0, 1.0), (-1.0, 5.0, 1.0)];
    check("circle of two bulges", [polyline(&halves)], disc(3.0).with_perimeter(TAU * 3.0));
    let ring = disc(3.0).minus(disc(2.5)).with_perimeter(TAU * 5.5);
    let paths = [2.5, 3.0].map(|r| Path::circle([2.0, 5.0], r));
    check("annulus", paths, ring);
    let thin = disc(3.0).minus(disc(2.99)).with_perimeter(TAU * 5.99);
    // The areas of the two discs are 300 times their difference: so the reference loses digits too.
    let found = properties(&strokes([2.99, 3.0].map(|r| Path::circle([2.0, 5.0], r))));
    assert_near("thin annulus", &found, &thin.properties(), 1e-11);
}

#[test]
fn discs_cut_by_chords() {
    let half = Known::sector([0.0, 0.0], 2.0, FRAC_PI_2, FRAC_PI_2);
    let vertices = [(2.0, 0.0, 1.0), (-2.0, 0.0, 0.0)];
    check("half disc", [polyline(&vertices)], half.with_perimeter(2.0 * PI + 4.0));

    for (name, half_angle) in [("minor segment", 0.9), ("major segment", 2.6)] {
        let known = Known::segment([1.0, -1.0], 3.0, half_angle, 0.4);
        let chord = 6.0 * half_angle.sin();
        let known = known.with_perimeter(6.0 * half_angle + chord);
        let paths = chorded([1.0, -1.0], 3.0, 0.4 - half_angle, 2.0 * half_angle);
        check(name, paths, known);
    }

    // By bulge: chord 2 from (-1, 0) to (1, 0), to the right of it when drawn counter-clockwise.
    for bulge in [0.3, 1.0, 2.5, 20.0_f64] {
        let half_angle = 2.0 * bulge.atan();
        let r = (1.0 + bulge * bulge) / (2.0 * bulge);
        let centre = [0.0, (1.0 - bulge * bulge) / (2.0 * bulge)];
        let known = Known::segment(centre, r, half_angle, -FRAC_PI_2);
        let known = known.with_perimeter(2.0 + 2.0 * half_angle * r);
        check(&format!("bulge {bulge}"), [polyline(&[(-1.0, 0.0, bulge), (1.0, 0.0, 0.0)])], known);
        // The same from the other side.
        let other = [polyline(&[(1.0, 0.0, 0.0), (-1.0, 0.0, bulge)])];
        check(&format!("bulge {bulge}, second"), other, known);
        let mirrored = [polyline(&[(1.0, 0.0, -bulge), (-1.0, 0.0, 0.0)])];
        check(&format!("bulge {bulge}, backwards"), mirrored, known);
    }
}

/// A square of side 2 with one side a little round; expansions in the bulge.
#[test]
fn flat_arcs_keep_their_digits() {
    for bulge in [1e-3, 1e-4] {
        let vertices = [(-1.0, 0.0, bulge), (1.0, 0.0, 0.0), (1.0, 2.0, 0.0), (-1.0, 2.0, 0.0)];
        let found = properties(&strokes([polyline(&vertices)]));
        let b2 = bulge * bulge;
        let near = |found: f64, known: f64, what: &str| {
            let error = (found / known - 1.0).abs();
            assert!(error < 1e-12, "bulge {bulge}: {what} is {found}, not {known}: {error:.1e}");
        };
        near(found.area, 4.0 + 4.0 / 3.0 * bulge * (1.0 + b2 / 5.0), "area");
        near(found.iyy, 4.0 / 3.0 + 4.0 / 15.0 * bulge * (1.0 + 3.0 / 7.0 * b2), "iyy");
    }
}

#[test]
fn sectors() {
    let sector = |r: f64, half: f64| Known::sector([5.0, 6.0], r, half, 1.1);
    for (name, half) in [("sector", 0.6), ("major sector", 2.2)] {
        let r = 4.0;
        let arc = arc([5.0, 6.0], r, 1.1 - half, 2.0 * half);
        let (from, to) = (arc.start_point().expect("an end"), arc.end_point().expect("an end"));
        let paths = [line([5.0, 6.0], to), arc, line([5.0, 6.0], from)];
        check(name, paths, sector(r, half).with_perimeter(2.0 * r + 2.0 * half * r));
    }
    let quarter = Known::sector([0.0, 0.0], 2.0, FRAC_PI_4, FRAC_PI_4);
    let bulge = (PI / 8.0).tan();
    let vertices = [(0.0, 0.0, 0.0), (2.0, 0.0, bulge), (0.0, 2.0, 0.0)];
    check("quarter disc", [polyline(&vertices)], quarter.with_perimeter(4.0 + PI));

    let (outer, inner, half) = (4.0, 3.0, 0.7);
    let arcs = [outer, inner].map(|r| arc([5.0, 6.0], r, 1.1 - half, 2.0 * half));
    let ends =
        arcs.clone().map(|a| (a.start_point().expect("an end"), a.end_point().expect("an end")));
    let [a, b] = arcs;
    let sides = [line(ends[0].0, ends[1].0), line(ends[1].1, ends[0].1)];
    let known = sector(outer, half).minus(sector(inner, half));
    let known = known.with_perimeter(2.0 * half * (outer + inner) + 2.0 * (outer - inner));
    let [s, t] = sides;
    check("ring sector", [a, b, s, t], known);
}

#[test]
fn links() {
    let known = known_bar([10.0, 20.0], 50.0, 6.0);
    check("rounded bar", [bar([10.0, 20.0], 50.0, 6.0)], known);

    let slot = known_bar([20.0, 20.0], 25.0, 2.0);
    let slotted = known.minus(slot).with_perimeter(known.perimeter + slot.perimeter);
    check("slotted link", [bar([10.0, 20.0], 50.0, 6.0), bar([20.0, 20.0], 25.0, 2.0)], slotted);

    let holes = known
        .minus(Known::disc([10.0, 20.0], 3.0))
        .minus(Known::disc([60.0, 20.0], 3.0))
        .with_perimeter(known.perimeter + TAU * 6.0);
    let paths = [
        Path::circle([60.0, 20.0], 3.0),
        bar([10.0, 20.0], 50.0, 6.0).reversed(),
        Path::circle([10.0, 20.0], 3.0),
    ];
    check("bar with holes", paths, holes);

    let far = known_bar([1e6, 2e6], 50.0, 6.0).with_perimeter(100.0 + TAU * 6.0);
    // The reference is about the origin, so it is taken near and moved.
    let mut near = known_bar([0.0, 0.0], 50.0, 6.0).properties();
    near.centroid = [1e6 + 25.0, 2e6];
    near.perimeter = far.perimeter;
    let found = properties(&strokes([bar([1e6, 2e6], 50.0, 6.0)]));
    assert_near("far-away bar", &found, &near, 1e-12);
}

#[test]
fn plates_with_holes() {
    let known = Known::rectangle([0.0, 0.0], 100.0, 60.0)
        .minus(Known::disc([-30.0, 10.0], 8.0))
        .minus(Known::disc([25.0, -12.0], 15.0))
        .minus(Known::rectangle([35.0, 20.0], 10.0, 6.0))
        .with_perimeter(320.0 + TAU * 23.0 + 32.0);
    let paths = [
        Path::circle([-30.0, 10.0], 8.0),
        rectangle([35.0, 20.0], 10.0, 6.0),
        rectangle([0.0, 0.0], 100.0, 60.0),
        Path::circle([25.0, -12.0], 15.0),
    ];
    check("plate with eccentric holes", paths, known);

    let island = Known::disc([0.0, 0.0], 10.0)
        .minus(Known::rectangle([1.0, 0.0], 10.0, 8.0))
        .plus(Known::disc([2.0, 1.0], 2.0))
        .minus(Known::disc([2.5, 1.0], 1.0))
        .with_perimeter(TAU * 13.0 + 36.0);
    let paths = [
        Path::circle([2.5, 1.0], 1.0),
        Path::circle([2.0, 1.0], 2.0),
        rectangle([1.0, 0.0], 10.0, 8.0),
        Path::circle([0.0, 0.0], 10.0),
    ];
    check("island in a hole", paths, island);

    let two = Known::disc([0.0, 0.0], 1.0).plus(Known::disc([5.0, 1.0], 2.0));
    let paths = [Path::circle([0.0, 0.0], 1.0), Path::circle([5.0, 1.0], 2.0)];
    check("two parts", paths, two.with_perimeter(TAU * 3.0));
}

#[test]
fn chained_lines_and_arcs() {
    let (w, h, r) = (40.0, 24.0, 5.0);
    let centre = [3.0, 4.0];
    let mut known = Known::rectangle(centre, w, h - 2.0 * r);
    for side in [-1.0, 1.0] {
        let y = centre[1] + side * (h - r) / 2.0;
        known = known.plus(Known::rectangle([centre[0], y], w - 2.0 * r, r));
        for other in [-1.0, 1.0_f64] {
            let corner = [centre[0] + other * (w / 2.0 - r), centre[1] + side * (h / 2.0 - r)];
            known = known.plus(Known::sector(corner, r, FRAC_PI_4, side.atan2(other)));
        }
    }
    let known = known.with_perimeter(2.0 * (w + h) - 8.0 * r + TAU * r);
    check("rounded rectangle", rounded_rectangle(centre, w, h, r), known);

    // Two arcs over one chord of 2: each lens from its own circle.
    let flat = Known::segment([0.0, 0.75], 1.25, (0.8_f64).asin(), -FRAC_PI_2);
    let known = flat.plus(Known::sector([0.0, 0.0], 1.0, FRAC_PI_2, FRAC_PI_2));
    let known = known.with_perimeter(2.5 * (0.8_f64).asin() + PI);
    let lens = [
        arc([0.0, 0.0], 1.0, 0.0, PI),
        arc([0.0, 0.75], 1.25, -FRAC_PI_2 - (0.8_f64).asin(), 2.0 * (0.8_f64).asin()),
    ];
    check("lens of two arcs", lens, known);
}

#[test]
fn ellipses() {
    let (a, b, angle) = (5.0, 2.0, 0.5_f64);
    let (sin, cos) = angle.sin_cos();
    let ellipse = |start: f64, sweep: f64| Curve::Ellipse {
        centre: [1.0, 2.0],
        major: [a * cos, a * sin],
        minor: [-b * sin, b * cos],
        start,
        sweep,
    };
    // Perimeter 4 a E(e), by the series of Gauss and Kummer in h = ((a − b)/(a + b))².
    let h = ((a - b) / (a + b)).powi(2);
    let mut term = 1.0;
    let mut series = 1.0;
    for n in 1..60 {
        let n = f64::from(n);
        term *= (n - 1.5) / n;
        series += term * term * h.powf(n);
    }
    let perimeter = PI * (a + b) * series;
    let whole = Path { curves: vec![ellipse(0.3, TAU)], is_closed: true };
    let known = Known::ellipse([1.0, 2.0], a, b, angle).with_perimeter(perimeter);
    check("ellipse", [whole], known);

    let half = Path::of(ellipse(-FRAC_PI_2, PI));
    let chord = line(half.end_point().expect("an end"), half.start_point().expect("an end"));
    let known = Known::half_ellipse([1.0, 2.0], a, b, angle);
    check("half ellipse", [chord, half], known.with_perimeter(0.5 * perimeter + 2.0 * b));
}

#[test]
fn a_plate_of_steel() {
    let plate =
        properties(&strokes([rectangle([200.0, 0.0], 100.0, 50.0)])).plate(1e-3, 7850.0, 5e-3);
    let mass = 0.1 * 0.05 * 5e-3 * 7850.0;
    let inertia = mass * (0.1 * 0.1 + 0.05 * 0.05) / 12.0;
    assert!((plate.mass / mass - 1.0).abs() < 1e-14, "{plate:?}");
    assert!((plate.inertia / inertia - 1.0).abs() < 1e-14, "{plate:?}");
    assert!((plate.com[0] - 0.2).abs() < 1e-16 && plate.com[1].abs() < 1e-16, "{plate:?}");
}
