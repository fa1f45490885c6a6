//! Numbers that a damaged file may bring: answered, never followed by a panic.

use super::shapes::{Dice, TOLERANCE, rectangle, strokes};
use bksim_cad::codes;
use bksim_cad::geometry::{Affine, Curve, Path, Point, Spline, Vertex, signed_area};
use bksim_cad::mass::AreaProperties;
use bksim_cad::outline::{Chain, Loop, Outline, nest};

const NUMBERS: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    1e-320,
    -1e-17,
    1e17,
    1e150,
    -1e308,
    f64::MAX,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Mostly plain numbers, so that the strange ones meet good company.
fn number(dice: &mut Dice) -> f64 {
    if dice.roll() < 0.7 { 6.0 * dice.roll() - 3.0 } else { NUMBERS[dice.below(NUMBERS.len())] }
}

fn point(dice: &mut Dice) -> Point {
    [number(dice), number(dice)]
}

fn curve(dice: &mut Dice) -> Curve {
    match dice.below(4) {
        0 => Curve::Segment { from: point(dice), to: point(dice) },
        1 => Curve::Arc {
            centre: point(dice),
            radius: number(dice),
            start: number(dice),
            sweep: number(dice),
        },
        2 => Curve::Ellipse {
            centre: point(dice),
            major: point(dice),
            minor: point(dice),
            start: number(dice),
            sweep: number(dice),
        },
        _ => {
            let (degree, n) = (dice.below(6), dice.below(9));
            // Now and then one too many or too few.
            let mut count = |n: usize| n.saturating_sub(1) + [1, 1, 1, 0, 2][dice.below(5)];
            let (n_knots, n_weights) = (count(n + degree + 1), count(n));
            let mut knots: Vec<f64> = (0..n_knots).map(|_| number(dice)).collect();
            if dice.roll() < 0.8 {
                knots.sort_by(f64::total_cmp);
            }
            Curve::Spline(Spline {
                degree,
                knots,
                control: (0..n).map(|_| point(dice)).collect(),
                weights: (0..n_weights).map(|_| number(dice).abs()).collect(),
            })
        }
    }
}

/// Asks everything; the answers may be anything.
fn ask(path: &Path, dice: &mut Dice) {
    let (p, tolerance) = (point(dice), number(dice));
    let map = Affine { x: point(dice), y: point(dice), origin: point(dice) };
    let mut sum = path.length() + path.distance(p) + signed_area(path) + path.bounds().diagonal();
    sum += f64::from(path.winding(p)) + path.flattened(tolerance).len() as f64;
    sum += path.transformed(&map).reversed().bounds().magnitude();
    std::hint::black_box(sum);

    let closed = Path { is_closed: true, ..path.clone() };
    let part = Loop { path: closed.clone(), is_hole: false, entities: vec![0] };
    let outline = Outline { loops: vec![part] };
    let _ = AreaProperties::of(&outline);
    let chain = Chain { path: closed.clone(), entities: vec![0] };
    let _ = nest(std::slice::from_ref(&chain), tolerance);
    let _ = Outline::around(&[chain], p, tolerance);
    if path.check().is_err() {
        let error = Outline::of(&strokes([closed]), TOLERANCE).expect_err("no curve");
        assert_eq!(error.code(), codes::NO_CURVE);
    }
}

#[test]
fn any_numbers_are_answered() {
    let mut dice = Dice(2);
    for _ in 0..1000 {
        let path = Path {
            curves: (0..dice.below(4)).map(|_| curve(&mut dice)).collect(),
            is_closed: dice.roll() < 0.5,
        };
        ask(&path, &mut dice);
    }
}

#[test]
fn any_bulges_and_fit_points_are_answered() {
    let mut dice = Dice(4);
    let mut n_good = 0;
    for _ in 0..3000 {
        let n = dice.below(6);
        let vertices: Vec<Vertex> =
            (0..n).map(|_| Vertex { at: point(&mut dice), bulge: number(&mut dice) }).collect();
        if let Ok(path) = Path::from_bulges(&vertices, dice.roll() < 0.5) {
            n_good += 1;
            assert!(path.check().is_ok() && path.length() > 0.0, "{path:?}");
            ask(&path, &mut dice);
        }
        let points: Vec<Point> = vertices.iter().map(|vertex| vertex.at).collect();
        let tangent = Some(point(&mut dice));
        if let Ok(spline) = Spline::through(&points, [tangent, None]) {
            assert!(spline.check().is_ok(), "{spline:?}");
            ask(&Path::of(Curve::Spline(spline)), &mut dice);
        }
    }
    assert!(n_good > 300, "{n_good}");
}

#[test]
fn outlines_with_any_tolerance_are_answered() {
    let mut dice = Dice(6);
    for tolerance in NUMBERS {
        for size in [1e-160, 1e-30, 1.0, 1e25] {
            let paths = [rectangle([0.0, 0.0], size, size), Path::circle([0.0, 0.0], 0.3 * size)];
            if let Ok((outline, _)) = Outline::of(&strokes(paths), tolerance) {
                let _ = AreaProperties::of(&outline);
                let _ = outline.contains(point(&mut dice));
            }
        }
    }
}

#[test]
fn very_large_and_very_small_drawings_have_areas() {
    for size in [1e-60, 1e-9, 1e12, 1e29] {
        let path = rectangle([0.3 * size, 0.1 * size], size, 2.0 * size);
        let (outline, _) = Outline::of(&strokes([path]), 0.0).expect("a good outline");
        let area = AreaProperties::of(&outline).expect("an area");
        assert!((area.area / size / size - 2.0).abs() < 1e-14, "{area:?}");
        assert!((area.ixx / size.powi(4) - 8.0 / 12.0).abs() < 1e-14, "{area:?}");
    }
}
