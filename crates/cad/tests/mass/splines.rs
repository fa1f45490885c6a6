//! Splines: against points by the definition of B-splines, and against the circle.

use super::known::assert_near;
use super::shapes::{line, outline, properties, strokes};
use bksim_cad::geometry::{Curve, Path, Point, Spline};
use bksim_cad::mass::AreaProperties;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Basis function by the recursion of Cox and de Boor.
fn basis(i: usize, p: usize, u: f64, knots: &[f64]) -> f64 {
    if p == 0 {
        return f64::from(u8::from(knots[i] <= u && u < knots[i + 1]));
    }
    let share = |from: usize, to: usize, value: f64| {
        if knots[to] > knots[from] { value / (knots[to] - knots[from]) } else { 0.0 }
    };
    share(i, i + p, u - knots[i]) * basis(i, p - 1, u, knots)
        + share(i + 1, i + p + 1, knots[i + p + 1] - u) * basis(i + 1, p - 1, u, knots)
}

/// Area, ∫x, ∫y, ∫x², ∫xy, ∫y² and length of the polygon of the corners.
fn of_polygon(corners: &[Point]) -> [f64; 7] {
    let mut sums = [0.0; 7];
    for (p, q) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let c = p[0] * q[1] - p[1] * q[0];
        let square = |i: usize, k: usize| {
            (2.0 * (p[i] * p[k] + q[i] * q[k]) + p[i] * q[k] + q[i] * p[k]) * c / 24.0
        };
        let length = (p[0] - q[0]).hypot(p[1] - q[1]);
        let shares = [
            c / 2.0,
            (p[0] + q[0]) * c / 6.0,
            (p[1] + q[1]) * c / 6.0,
            square(0, 0),
            square(0, 1),
            square(1, 1),
            length,
        ];
        (0..7).for_each(|k| sums[k] += shares[k]);
    }
    sums
}

/// Polygons of finer and finer steps, extrapolated to no step (Richardson): the error is even in
/// the step.
fn refined(spline: &Spline) -> AreaProperties {
    let corners = |per_span: u32| -> Vec<Point> {
        let (p, n) = (spline.degree, spline.control.len());
        let spans = spline.knots[p..=n].windows(2).filter(|span| span[0] < span[1]);
        let us = spans.flat_map(|span| {
            let step = (span[1] - span[0]) / f64::from(per_span);
            (0..per_span).map(move |i| span[0] + f64::from(i) * step)
        });
        let point = |u: f64| {
            let mut sums = [0.0; 3];
            for i in 0..n {
                let w = spline.weights[i] * basis(i, p, u, &spline.knots);
                let [x, y] = spline.control[i];
                sums = [sums[0] + w * x, sums[1] + w * y, sums[2] + w];
            }
            [sums[0] / sums[2], sums[1] / sums[2]]
        };
        let mut corners: Vec<Point> = us.map(point).collect();
        corners.push(Curve::Spline(spline.clone()).end_point());
        corners
    };
    let mut rows = [64, 128, 256, 512].map(|n| of_polygon(&corners(n)));
    for (level, gain) in [(1, 3.0), (2, 15.0), (3, 63.0)] {
        for i in (level..4).rev() {
            rows[i] = std::array::from_fn(|k| rows[i][k] + (rows[i][k] - rows[i - 1][k]) / gain);
        }
    }
    let [area, x, y, xx, xy, yy, perimeter] = rows[3];
    let sign = area.signum();
    let [area, x, y, xx, xy, yy] = [area, x, y, xx, xy, yy].map(|m| sign * m);
    let (ixx, iyy) = (yy - y * y / area, xx - x * x / area);
    let ixy = xy - x * y / area;
    let centroid = [x / area, y / area];
    AreaProperties { area, perimeter, centroid, ixx, iyy, ixy, polar: ixx + iyy }
}

fn blob(n: u32) -> Vec<Point> {
    let corner = |i: u32| {
        let u = TAU * f64::from(i) / f64::from(n);
        let r = 3.0 + (3.0 * u).sin() + 0.5 * (5.0 * u).cos();
        [r * u.cos() + 4.0, r * u.sin() - 2.0]
    };
    (0..n).map(corner).collect()
}

fn uniform(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64).collect()
}

fn clamped(n_control: usize, degree: usize) -> Vec<f64> {
    let inner = n_control - degree;
    let knot = |i: usize| i.saturating_sub(degree).min(inner) as f64;
    (0..=n_control + degree).map(knot).collect()
}

fn closed(spline: Spline) -> Path {
    Path { curves: vec![Curve::Spline(spline)], is_closed: true }
}

#[test]
fn splines_agree_with_refined_polygons() {
    let mut cases = Vec::new();
    for degree in [2, 3, 5] {
        // Unclamped and periodic: the first control points come again at the end.
        let mut control = blob(12);
        control.extend_from_within(0..degree);
        let knots = uniform(control.len() + degree + 1);
        let waves = |i: usize| 1.0 + 0.5 * (TAU * i as f64 / 12.0).sin();
        let weights: Vec<f64> = (0..control.len()).map(|i| waves(i % 12)).collect();
        cases.push(Spline::new(degree, knots.clone(), control.clone(), Vec::new()));
        cases.push(Spline::new(degree, knots, control, weights));
        // Clamped, and back to its first point.
        let mut control = blob(9);
        control.push(control[0]);
        let weights: Vec<f64> = (0..10).map(|i| 0.3 + f64::from(i % 4)).collect();
        cases.push(Spline::new(degree, clamped(10, degree), control, weights));
    }
    for (i, spline) in cases.into_iter().enumerate() {
        let spline = spline.expect("a good spline");
        let known = refined(&spline);
        let found = properties(&strokes([closed(spline.clone())]));
        assert_near(&format!("spline {i}"), &found, &known, 1e-9);
        let back = properties(&strokes([closed(spline.reversed())]));
        assert_near(&format!("spline {i} backwards"), &back, &found, 1e-13);
    }
}

/// Nine control points with weights 1 and √½ (Piegl & Tiller, section 7.5).
fn circle(r: f64) -> Spline {
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let control = corners.map(|(x, y)| [r * f64::from(x) + 1.0, r * f64::from(y) + 2.0]).to_vec();
    let knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
    let weights = (0..9).map(|i| if i % 2 == 0 { 1.0 } else { FRAC_1_SQRT_2 }).collect();
    Spline::new(2, knots, control, weights).expect("a good spline")
}

#[test]
fn a_rational_quadratic_spline_is_a_circle() {
    let r = 2.5;
    let found = properties(&strokes([closed(circle(r))]));
    let second = PI / 4.0 * r.powi(4);
    let known = AreaProperties {
        area: PI * r * r,
        perimeter: TAU * r,
        centroid: [1.0, 2.0],
        ixx: second,
        iyy: second,
        ixy: 0.0,
        polar: 2.0 * second,
    };
    assert_near("circle", &found, &known, 1e-12);

    let bounds = Curve::Spline(circle(r)).bounds();
    for (found, known) in bounds.min.into_iter().chain(bounds.max).zip([-1.5, -0.5, 3.5, 4.5]) {
        assert!((found - known).abs() < 1e-13, "{found} {known}");
    }
    // In and out up to rounding, all around.
    let outline = outline(&strokes([closed(circle(r))]));
    for i in 0..1000 {
        let u = TAU * f64::from(i) / 1000.0;
        for (radius, is_inside) in [(r - 1e-12, true), (r + 1e-12, false)] {
            let point = [1.0 + radius * u.cos(), 2.0 + radius * u.sin()];
            assert_eq!(outline.contains(point), is_inside, "{point:?}");
        }
    }
    for (point, known) in [([1.0, 2.0], 2.5), ([1.0, 8.0], 3.5), ([2.2, 3.6], 0.5)] {
        let found = outline.distance(point);
        assert!((found - known).abs() < 1e-12, "{point:?}: {found} {known}");
    }
}

#[test]
fn splines_chain_with_lines() {
    // y = x (2 − x) as a spline of degree two: the area under it is 4/3.
    let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0].to_vec();
    let parabola = Spline::new(2, knots, vec![[0.0, 0.0], [1.0, 2.0], [2.0, 0.0]], Vec::new());
    let parabola = Path::of(Curve::Spline(parabola.expect("a good spline")));
    let found = properties(&strokes([line([0.0, 0.0], [2.0, 0.0]), parabola]));
    // Length of the arc: √5 + asinh(2)/2.
    let known = AreaProperties {
        area: 4.0 / 3.0,
        perimeter: 2.0 + 5_f64.sqrt() + 2_f64.asinh() / 2.0,
        centroid: [1.0, 0.4],
        ixx: 32.0 / 105.0 - 4.0 / 3.0 * 0.16,
        iyy: 4.0 / 15.0,
        ixy: 0.0,
        polar: 32.0 / 105.0 - 4.0 / 3.0 * 0.16 + 4.0 / 15.0,
    };
    assert_near("parabola", &found, &known, 1e-13);
}

#[test]
fn fit_points_give_the_natural_spline() {
    let spline = Spline::through(&[[0.0, 0.0], [3.0, 4.0], [6.0, 0.0]], [None, None]);
    let spline = spline.expect("a good spline");
    // Chords of 5: x is linear, y(s) = s (75 − s²) · 4/250 up to the middle (y'' = 0 at 0).
    for s in [0.0, 1.0, 2.5, 5.0_f64] {
        let [x, y] = spline.point(s / 10.0);
        let known = [0.6 * s, s * (75.0 - s * s) * 4.0 / 250.0];
        assert!((x - known[0]).abs() < 1e-14 && (y - known[1]).abs() < 1e-14, "{s}: {x} {y}");
    }
    // A stated tangent is kept.
    let clamped = Spline::through(&[[0.0, 0.0], [3.0, 4.0]], [Some([0.0, 2.0]), None]);
    let clamped = clamped.expect("a good spline");
    let [x, y] = clamped.point(1e-6);
    assert!(x.abs() < 1e-10 && (y - 5e-6).abs() < 1e-10, "{x} {y}");
}

#[test]
fn bad_splines_are_refused() {
    let good = circle(1.0);
    let refused = |change: fn(&mut Spline)| {
        let mut bad = good.clone();
        change(&mut bad);
        let Spline { degree, knots, control, weights } = bad;
        assert!(Spline::new(degree, knots, control, weights).is_err());
    };
    refused(|s| s.degree = 0);
    refused(|s| s.degree = 4000);
    refused(|s| s.degree = 8);
    refused(|s| s.knots[4] = 0.5);
    refused(|s| s.knots[3] = f64::NAN);
    refused(|s| s.knots.fill(1.0));
    refused(|s| s.knots[5] = 1.0);
    refused(|s| s.control[2][0] = f64::INFINITY);
    refused(|s| s.weights[2] = 0.0);
    refused(|s| s.weights[2] = f64::NAN);
    refused(|s| s.weights.truncate(3));
    refused(|s| s.control.clear());
    assert!(Spline::through(&[[1.0, 1.0], [1.0, 1.0]], [None, None]).is_err());
    assert!(Spline::through(&[[1.0, 1.0], [f64::NAN, 1.0]], [None, None]).is_err());
}

/// Distance from a point to a segment.
fn to_segment([x, y]: Point, [[ax, ay], [bx, by]]: [Point; 2]) -> f64 {
    let [ux, uy] = [bx - ax, by - ay];
    let share = ((x - ax) * ux + (y - ay) * uy) / (ux * ux + uy * uy);
    let share = share.clamp(0.0, 1.0);
    (x - ax - share * ux).hypot(y - ay - share * uy)
}

#[test]
fn the_distance_to_a_spline_is_that_to_the_nearest_of_many_points() {
    for n in [4, 9, 17] {
        let control = blob(n);
        let spline = Spline::new(3, clamped(control.len(), 3), control, Vec::new());
        let path = Path::of(Curve::Spline(spline.expect("a good spline")));
        let drawn = path.flattened(1e-5);
        for i in 0..40 {
            let angle = 0.7 * f64::from(i);
            let at = [0.1 * angle * angle.cos(), 0.1 * angle * angle.sin()];
            // To the segments of a polygon that is within 1e-5 of the spline.
            let edges = drawn.windows(2).map(|ends| to_segment(at, [ends[0], ends[1]]));
            let expected = edges.fold(f64::INFINITY, f64::min);
            let found = path.distance(at);
            assert!((found - expected).abs() < 1e-5, "{n} {at:?}: {found} {expected}");
            for reach in [0.5 * expected, 2.0 * expected] {
                let within = path.distance_within(at, reach);
                assert!((within - found.min(reach)).abs() < 1e-12, "{within} {found} {reach}");
            }
        }
    }
}
