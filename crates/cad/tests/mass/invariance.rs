//! Properties of outlines that are moved, turned, mirrored, scaled and redrawn.

use super::known::{assert_near, turned};
use super::shapes::{Dice, bar, polyline, properties, rounded_rectangle, strokes};
use bksim_cad::geometry::{Affine, Bounds, Curve, Path, Spline};
use bksim_cad::mass::AreaProperties;
use bksim_cad::outline::Stroke;
use std::f64::consts::TAU;

/// Shapes of every kind of curve.
fn shapes() -> Vec<Vec<Path>> {
    let ellipse = Curve::Ellipse {
        centre: [2.0, 1.0],
        major: [3.0, 1.0],
        minor: [-0.5, 1.5],
        start: 0.4,
        sweep: TAU,
    };
    let corners = [[0.0, 0.0], [4.0, -1.0], [5.0, 3.0], [1.0, 4.0], [-2.0, 2.0], [0.0, 0.0]];
    let knots = [0, 0, 0, 0, 1, 2, 3, 3, 3, 3].map(f64::from).to_vec();
    let weights = vec![1.0, 2.0, 0.5, 1.5, 1.0, 1.0];
    let spline = Spline::new(3, knots, corners.to_vec(), weights).expect("a good spline");
    vec![
        vec![bar([1.0, 2.0], 10.0, 3.0), Path::circle([1.0, 2.0], 1.0)],
        rounded_rectangle([0.0, 1.0], 9.0, 7.0, 2.0),
        vec![Path { curves: vec![ellipse], is_closed: true }],
        vec![Path { curves: vec![Curve::Spline(spline)], is_closed: true }],
        vec![polyline(&[(0.0, 0.0, 3.0), (2.0, 0.0, -0.4), (2.0, 3.0, 0.2), (-1.0, 4.0, 0.0)])],
    ]
}

fn mapped(paths: &[Path], map: &Affine) -> AreaProperties {
    properties(&strokes(paths.iter().map(|path| path.transformed(map))))
}

/// Properties after a similarity by `scale` and `angle`; `mirror` is −1 to turn y over
/// first.
fn similar(
    of: &AreaProperties,
    map: &Affine,
    scale: f64,
    angle: f64,
    mirror: f64,
) -> AreaProperties {
    let fourth = scale.powi(4);
    let [iyy, ixy, ixx] = turned([of.iyy, mirror * of.ixy, of.ixx], angle).map(|m| m * fourth);
    AreaProperties {
        area: of.area * scale * scale,
        perimeter: of.perimeter * scale,
        centroid: map.point(of.centroid),
        ixx,
        iyy,
        ixy,
        polar: of.polar * fourth,
    }
}

#[test]
fn similarities_carry_the_properties_along() {
    let mut dice = Dice(7);
    for paths in shapes() {
        let still = mapped(&paths, &Affine::IDENTITY);
        for mirror in [1.0, -1.0, 1.0, -1.0] {
            let (scale, angle) = (0.01 + 100.0 * dice.roll(), TAU * dice.roll());
            let to = [1e3 * dice.roll(), -1e3 * dice.roll()];
            let map = Affine::scaling(scale, mirror * scale)
                .then(&Affine::rotation(angle))
                .then(&Affine::translation(to));
            let known = similar(&still, &map, scale, angle, mirror);
            assert_near("moved shape", &mapped(&paths, &map), &known, 1e-12);
        }
    }
}

#[test]
fn affine_maps_scale_the_area_by_their_determinant() {
    let map = Affine { x: [1.3, 0.4], y: [-0.9, 2.0], origin: [5.0, -3.0] };
    for paths in shapes() {
        let (still, found) = (mapped(&paths, &Affine::IDENTITY), mapped(&paths, &map));
        let known = AreaProperties {
            area: still.area * map.determinant(),
            centroid: map.point(still.centroid),
            ..found
        };
        assert_near("sheared shape", &found, &known, 1e-13);
        // Back again: arcs are ellipses now, but the same curves.
        let determinant = map.determinant();
        let inverse = Affine {
            x: [map.y[1] / determinant, -map.x[1] / determinant],
            y: [-map.y[0] / determinant, map.x[0] / determinant],
            origin: [0.0; 2],
        };
        let inverse = Affine::translation(map.origin.map(|x| -x)).then(&inverse);
        let back: Vec<Path> = paths.iter().map(|path| path.transformed(&map)).collect();
        assert_near("shape there and back", &mapped(&back, &inverse), &still, 1e-12);
    }
}

#[test]
fn order_and_direction_of_strokes_do_not_matter() {
    let mut dice = Dice(11);
    for paths in shapes() {
        let still = mapped(&paths, &Affine::IDENTITY);
        for _ in 0..10 {
            // Every curve a stroke of its own, some turned, in any order.
            let mut pieces: Vec<Path> = paths
                .iter()
                .flat_map(|path| match &path.curves[..] {
                    [_] => vec![path.clone()],
                    curves => curves.iter().cloned().map(Path::of).collect(),
                })
                .map(|path| if dice.roll() < 0.5 { path.reversed() } else { path })
                .collect();
            dice.shuffle(&mut pieces);
            let found = properties(&strokes(pieces));
            assert_near("shuffled shape", &found, &still, 1e-13);
        }
    }
}

#[test]
fn splitting_curves_changes_nothing() {
    for paths in shapes() {
        let still = mapped(&paths, &Affine::IDENTITY);
        let split = |curve: &Curve| match curve.clone() {
            Curve::Segment { from, to } => {
                let middle = curve.point(0.3);
                vec![Curve::Segment { from, to: middle }, Curve::Segment { from: middle, to }]
            }
            Curve::Arc { centre, radius, start, sweep } => [0.0, 0.6]
                .map(|t| (start + t * sweep, if t == 0.0 { 0.6 } else { 0.4 }))
                .map(|(start, t)| Curve::Arc { centre, radius, start, sweep: t * sweep })
                .to_vec(),
            other => vec![other],
        };
        let pieces = paths.iter().map(|path| Path {
            curves: path.curves.iter().flat_map(split).collect(),
            is_closed: path.is_closed,
        });
        assert_near("split shape", &properties(&strokes(pieces)), &still, 1e-13);
    }
}

#[test]
fn flattened_shapes_have_nearly_the_same_area() {
    for paths in shapes() {
        let still = mapped(&paths, &Affine::IDENTITY);
        for tolerance in [1e-2, 1e-4] {
            let polygons: Vec<Stroke> = strokes(paths.iter().map(|path| {
                let corners = path.flattened(tolerance);
                let lines =
                    corners.windows(2).map(|pair| Curve::Segment { from: pair[0], to: pair[1] });
                for corner in &corners {
                    assert!(path.distance(*corner) < 1e-9, "{corner:?} is on {path:?}");
                }
                Path { curves: lines.collect(), is_closed: path.is_closed }
            }));
            let found = properties(&polygons);
            let allowed = still.perimeter * tolerance;
            let error = (found.area - still.area).abs();
            assert!(error <= allowed, "{error} > {allowed}");
            assert!(error > 1e-6 * allowed, "{error} is too good for a polygon");
        }
    }
}

#[test]
fn bounds_hold_the_curves_and_touch_them() {
    for path in shapes().into_iter().flatten() {
        let (bounds, coarse) = (path.bounds(), path.flattened(1e-7));
        let tight = coarse.iter().copied().fold(Bounds::EMPTY, Bounds::with);
        for k in 0..2 {
            assert!((bounds.min[k] - tight.min[k]).abs() < 1e-6, "{bounds:?} {tight:?}");
            assert!((bounds.max[k] - tight.max[k]).abs() < 1e-6, "{bounds:?} {tight:?}");
            assert!(bounds.min[k] <= tight.min[k] + 1e-14, "{bounds:?} {tight:?}");
            assert!(bounds.max[k] >= tight.max[k] - 1e-14, "{bounds:?} {tight:?}");
        }
    }
}
