//! [`Primitive`]: triangles, segments and rods, and those that are fixed to bodies.

use std::ops::Range;

use bksim_scene::{Color, Form, Paint, Scene, Stroke, Theme};
use bytemuck::{Pod, Zeroable};

use super::{line, mesh};

/// A triangle, a segment of a line or a rod, as the shader reads it.
///
/// A triangle has the corners `a`, `b`, `before`. A segment goes from `a` to `b` and knows the points
/// before and behind it, so that neighbours share the pixels about their joint without painting any
/// twice. A rod goes from `a` to `b`, and `before` begins with its radius, m.
#[derive(Clone, Copy, PartialEq, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Primitive {
    /// Relative to the anchor of the body, m.
    pub(super) a: [f32; 3],
    /// Place of the body.
    pub(super) body: u32,
    pub(super) b: [f32; 3],
    /// Half of the width of a segment or rim, points.
    pub(super) half_width: f32,
    pub(super) before: [f32; 3],
    /// Red, green, blue, opacity, the red in the lowest byte.
    pub(super) color: u32,
    pub(super) behind: [f32; 3],
    /// [`TRIANGLE`], [`ROD`], [`RIM`], or which neighbours a segment has.
    pub(super) kind: u32,
}

/// Kinds of primitives, the same in `shader.wgsl`.
pub(super) const TRIANGLE: u32 = 0;
pub(super) const SEGMENT: u32 = 1;
pub(super) const HAS_BEFORE: u32 = 2;
pub(super) const HAS_BEHIND: u32 = 4;
pub(super) const ROD: u32 = 8;
/// The edge of a rod.
pub(super) const RIM: u32 = 9;

/// Width of the edge of an area that has none of its own, points: it makes the area smooth.
const HAIRLINE: f32 = 1.0;

/// The primitives on bodies, those of a shape together: first those of shapes behind the spans, then
/// those in front of them, both in the order of the scene. In a plane that is how they are painted.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Fixed {
    pub(super) primitives: Vec<Primitive>,
    /// How many of them lie behind the spans.
    pub(super) n_behind: u32,
    /// By shape.
    pub(super) ranges: Vec<Range<u32>>,
    /// By shape, the middle of its points in the frame of its body, m: where it lies in depth.
    pub(super) middles: Vec<[f64; 3]>,
    /// By body, the point of it that its primitives are relative to, m: a body may lie far from the
    /// origin of its frame.
    pub(super) anchors: Vec<[f64; 3]>,
}

impl Fixed {
    /// The primitives of a scene's shapes.
    pub(super) fn of(scene: &Scene, theme: &Theme) -> Self {
        let anchors = anchors(scene);
        let mut primitives = Vec::new();
        let mut ranges = vec![0..0; scene.shapes.len()];
        let is_in_front = |&idx: &usize| scene.shapes[idx].role.is_in_front();
        let (front, behind): (Vec<_>, Vec<_>) = (0..ranges.len()).partition(is_in_front);
        let mut n_behind = 0;
        for (place, &idx) in behind.iter().chain(&front).enumerate() {
            let (shape, first) = (&scene.shapes[idx], count(primitives.len()));
            if let Some(&anchor) = anchors.get(shape.body) {
                let paint = theme.paint(shape.role);
                let mut out = Out { primitives: &mut primitives, body: count(shape.body), anchor };
                match &shape.form {
                    Form::Region(rings) => out.region(rings, paint.fill, paint.stroke),
                    Form::Line { points, is_closed } => {
                        if let Some(stroke) = paint.stroke {
                            out.line(points, *is_closed, stroke);
                        }
                    }
                    Form::Rod { ends, radius } => out.rod(*ends, *radius, &paint),
                }
            }
            ranges[idx] = first..count(primitives.len());
            if place < behind.len() {
                n_behind = ranges[idx].end;
            }
        }
        let middles = scene.shapes.iter().map(|shape| middle(points_of(&shape.form))).collect();
        Self { primitives, n_behind, ranges, middles, anchors }
    }
}

/// Where primitives go to, and what they have in common.
pub(super) struct Out<'a> {
    pub(super) primitives: &'a mut Vec<Primitive>,
    /// Place of their body.
    pub(super) body: u32,
    /// What is subtracted from points, m.
    pub(super) anchor: [f64; 3],
}

impl Out<'_> {
    /// An area with its edges.
    pub(super) fn region(
        &mut self,
        rings: &[Vec<[f64; 3]>],
        fill: Option<Color>,
        stroke: Option<Stroke>,
    ) {
        if let Some(fill) = fill {
            for [a, b, c] in mesh::triangles(rings) {
                let [a, b, before] = [a, b, c].map(|p| self.relative(p));
                let (body, color, kind) = (self.body, packed(fill), TRIANGLE);
                let corners = Primitive { a, body, b, before, color, kind, ..Primitive::default() };
                self.primitives.push(corners);
            }
        }
        let smoothing = || fill.map(|color| Stroke { color, width: HAIRLINE });
        if let Some(stroke) = stroke.or_else(smoothing) {
            for ring in rings {
                self.line(ring, true, stroke);
            }
        }
    }

    /// A line.
    pub(super) fn line(&mut self, points: &[[f64; 3]], is_closed: bool, stroke: Stroke) {
        let points: Vec<[f32; 3]> = points.iter().map(|&p| self.relative(p)).collect();
        for segment in line::segments(&points, is_closed) {
            let half_width = 0.5 * stroke.width;
            let (body, color) = (self.body, packed(stroke.color));
            self.primitives.push(Primitive { body, half_width, color, ..segment });
        }
    }

    /// A rod of this radius, m, with its edge.
    fn rod(&mut self, ends: [[f64; 3]; 2], radius: f64, paint: &Paint) {
        let ([a, b], radius) = (ends.map(|end| self.relative(end)), single(radius));
        let is_finite = [a, b].as_flattened().iter().all(|x| x.is_finite()) && radius.is_finite();
        if !is_finite || radius < 0.0 {
            return;
        }
        let rod =
            Primitive { a, b, body: self.body, before: [radius, 0.0, 0.0], ..Primitive::default() };
        if let Some(fill) = paint.fill {
            self.primitives.push(Primitive { color: packed(fill), kind: ROD, ..rod });
        }
        if let Some(Stroke { color, width }) = paint.stroke {
            let (color, half_width) = (packed(color), 0.5 * width);
            self.primitives.push(Primitive { half_width, color, kind: RIM, ..rod });
        }
    }

    /// A line that fades towards its first point, each of its segments as one.
    pub(super) fn fading(&mut self, points: &[[f64; 3]], stroke: Stroke) {
        let first = self.primitives.len();
        self.line(points, false, stroke);
        let n = (self.primitives.len() - first) as f32;
        for (place, segment) in self.primitives[first..].iter_mut().enumerate() {
            segment.color = packed(stroke.color.faded((place + 1) as f32 / n));
        }
    }

    fn relative(&self, point: [f64; 3]) -> [f32; 3] {
        std::array::from_fn(|i| single(point[i] - self.anchor[i]))
    }
}

/// The middle of the box about the shapes of each body.
fn anchors(scene: &Scene) -> Vec<[f64; 3]> {
    let mut boxes = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; scene.bodies.len()];
    for shape in &scene.shapes {
        let Some([low, high]) = boxes.get_mut(shape.body) else { continue };
        for p in points_of(&shape.form).filter(|p| p.iter().all(|x| x.is_finite())) {
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
        }
    }
    let middle = |[low, high]: [[f64; 3]; 2]| {
        std::array::from_fn(|i| if low[i] <= high[i] { 0.5 * (low[i] + high[i]) } else { 0.0 })
    };
    boxes.into_iter().map(middle).collect()
}

/// All points of a shape.
pub(super) fn points_of(form: &Form) -> impl Iterator<Item = &[f64; 3]> {
    let rings = match form {
        Form::Region(rings) => rings.as_slice(),
        Form::Line { points, .. } => std::slice::from_ref(points),
        Form::Rod { .. } => &[],
    };
    let ends = match form {
        Form::Rod { ends, .. } => ends.as_slice(),
        _ => &[],
    };
    rings.iter().flatten().chain(ends)
}

/// The middle of points; the origin if there are none.
pub(super) fn middle<'a>(points: impl IntoIterator<Item = &'a [f64; 3]>) -> [f64; 3] {
    let (mut n, mut sum) = (0.0, [0.0; 3]);
    for p in points {
        n += 1.0;
        sum = std::array::from_fn(|i| sum[i] + p[i]);
    }
    sum.map(|x| x / f64::max(n, 1.0))
}

fn packed(Color(rgba): Color) -> u32 {
    u32::from_le_bytes(rgba)
}

/// What is left of a number in single precision.
#[expect(clippy::cast_possible_truncation, reason = "the precision of what is seen")]
pub(super) fn single(x: f64) -> f32 {
    x as f32
}

/// A count for the graphics card, which holds fewer than 2^32 of anything.
pub(super) fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}
