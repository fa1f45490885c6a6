//! Strokes of shapes, as programs draw them.

use bksim_cad::geometry::{Curve, Path, Point, Vertex};
use bksim_cad::mass::AreaProperties;
use bksim_cad::outline::{Outline, Stroke};
use std::f64::consts::{FRAC_PI_2, PI};

pub(crate) const TOLERANCE: f64 = 1e-6;

pub(crate) fn outline(strokes: &[Stroke]) -> Outline {
    Outline::of(strokes, TOLERANCE).expect("a good outline").0
}

pub(crate) fn properties(strokes: &[Stroke]) -> AreaProperties {
    AreaProperties::of(&outline(strokes)).expect("an area")
}

/// Numbers the paths.
pub(crate) fn strokes(paths: impl IntoIterator<Item = Path>) -> Vec<Stroke> {
    let numbered = paths.into_iter().enumerate();
    numbered.map(|(entity, path)| Stroke { path, entity }).collect()
}

pub(crate) fn polyline(vertices: &[(f64, f64, f64)]) -> Path {
    let vertices: Vec<Vertex> =
        vertices.iter().map(|&(x, y, bulge)| Vertex { at: [x, y], bulge }).collect();
    Path::from_bulges(&vertices, true).expect("a good polyline")
}

pub(crate) fn polygon(corners: &[Point]) -> Path {
    let vertices: Vec<(f64, f64, f64)> = corners.iter().map(|[x, y]| (*x, *y, 0.0)).collect();
    polyline(&vertices)
}

pub(crate) fn rectangle([x, y]: Point, w: f64, h: f64) -> Path {
    let (a, b) = (0.5 * w, 0.5 * h);
    polygon(&[[x - a, y - b], [x + a, y - b], [x + a, y + b], [x - a, y + b]])
}

/// A bar from `left` to `left + (length, 0)` with round ends, as a polyline.
pub(crate) fn bar([x, y]: Point, length: f64, r: f64) -> Path {
    polyline(&[
        (x, y - r, 0.0),
        (x + length, y - r, 1.0),
        (x + length, y + r, 0.0),
        (x, y + r, 1.0),
    ])
}

pub(crate) fn line(from: Point, to: Point) -> Path {
    Path::of(Curve::Segment { from, to })
}

pub(crate) fn arc(centre: Point, radius: f64, start: f64, sweep: f64) -> Path {
    Path::of(Curve::Arc { centre, radius, start, sweep })
}

/// A rectangle with round corners in eight entities, shuffled, some drawn backwards.
pub(crate) fn rounded_rectangle([x, y]: Point, w: f64, h: f64, r: f64) -> Vec<Path> {
    let (a, b) = (0.5 * w, 0.5 * h);
    vec![
        arc([x + a - r, y + b - r], r, 0.0, FRAC_PI_2),
        line([x - a + r, y - b], [x + a - r, y - b]),
        line([x + a - r, y + b], [x - a + r, y + b]).reversed(),
        arc([x - a + r, y - b + r], r, PI, FRAC_PI_2),
        line([x + a, y - b + r], [x + a, y + b - r]),
        arc([x + a - r, y - b + r], r, -FRAC_PI_2, FRAC_PI_2).reversed(),
        line([x - a, y + b - r], [x - a, y - b + r]).reversed(),
        arc([x - a + r, y + b - r], r, FRAC_PI_2, FRAC_PI_2),
    ]
}

/// A fixed pseudo-random sequence in 0 to 1.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below n")]
        let i = (self.roll() * n as f64) as usize;
        i.min(n - 1)
    }

    pub(crate) fn shuffle<T>(&mut self, list: &mut [T]) {
        for i in (1..list.len()).rev() {
            list.swap(i, self.below(i + 1));
        }
    }
}
