//! [`Fixed`]: the primitives on bodies; and [`Builder`], which makes primitives of shapes.

use std::ops::Range;

use bksim_scene::{Color, Form, Paint, Scene, SectionPaint, Shape, Stroke, Theme};

use super::primitive::{Kind, Primitive, count, single};
use super::{line, mesh};

/// Width of the edge of an area without a stroke, points: it makes the area smooth.
const HAIRLINE: f32 = 1.0;

/// The primitives on bodies, those of a shape together: first those of shapes painted below the
/// spans, then those in front of them, both in the order of the scene. In a plane that is the order
/// of painting.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Fixed {
    pub(super) primitives: Vec<Primitive>,
    /// Number of those painted below the spans.
    pub(super) n_back: u32,
    /// By shape, the indices of its primitives.
    pub(super) ranges: Vec<Range<u32>>,
    /// By shape, the middle of its points in the frame of its body, m, which decides its depth.
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
        let (front, back): (Vec<_>, Vec<_>) = (0..ranges.len()).partition(is_in_front);
        let mut n_back = 0;
        for (n_done, &idx) in back.iter().chain(&front).enumerate() {
            let (shape, first) = (&scene.shapes[idx], count(primitives.len()));
            if let Some(&anchor) = anchors.get(shape.body) {
                let mut out =
                    Builder { primitives: &mut primitives, body: count(shape.body), anchor };
                out.shape(shape, theme);
            }
            ranges[idx] = first..count(primitives.len());
            if n_done < back.len() {
                n_back = ranges[idx].end;
            }
        }
        Self { primitives, n_back, ranges, middles: middles(scene), anchors }
    }
}

/// Makes primitives of areas, lines and rods of one body.
pub(super) struct Builder<'a> {
    /// Primitives so far.
    pub(super) primitives: &'a mut Vec<Primitive>,
    /// Index of the body.
    pub(super) body: u32,
    /// Point that is subtracted from all points, m.
    pub(super) anchor: [f64; 3],
}

impl Builder<'_> {
    /// Adds a shape on a body; of a solid nothing, as its faces and outline depend on the view.
    pub(super) fn shape(&mut self, shape: &Shape, theme: &Theme) {
        let paint = theme.paint(shape.role);
        match &shape.form {
            Form::Region(rings) => self.region(rings, paint.fill, paint.stroke),
            Form::Line { points, is_closed } => {
                if let Some(stroke) = paint.stroke {
                    self.line(points, *is_closed, stroke);
                }
            }
            Form::Rod { ends, radius } => self.rod(*ends, *radius, &paint),
            Form::Solid(_) => {}
            Form::Section { rings, hatching } => {
                let SectionPaint { fill, outline, hatching: stroke } = theme.section(shape.role);
                self.region(rings, Some(fill), None);
                for line in hatching {
                    self.line(line, false, stroke);
                }
                self.region(rings, None, Some(outline));
            }
        }
    }

    /// Adds an area with its edges.
    pub(super) fn region(
        &mut self,
        rings: &[Vec<[f64; 3]>],
        fill: Option<Color>,
        stroke: Option<Stroke>,
    ) {
        if let Some(fill) = fill {
            for [a, b, c] in mesh::triangles(rings) {
                let [a, b, before] = [a, b, c].map(|p| self.relative(p));
                let (body, color, kind) = (self.body, packed(fill), Kind::Triangle.bits());
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

    /// Adds a line.
    pub(super) fn line(&mut self, points: &[[f64; 3]], is_closed: bool, stroke: Stroke) {
        let points: Vec<[f32; 3]> = points.iter().map(|&p| self.relative(p)).collect();
        for segment in line::segments(&points, is_closed) {
            let half_width = 0.5 * stroke.width;
            let (body, color) = (self.body, packed(stroke.color));
            self.primitives.push(Primitive { body, half_width, color, ..segment });
        }
    }

    /// Adds a rod of this radius, m, with its edge.
    fn rod(&mut self, ends: [[f64; 3]; 2], radius: f64, paint: &Paint) {
        let ([a, b], radius) = (ends.map(|end| self.relative(end)), single(radius));
        let is_finite = [a, b].as_flattened().iter().all(|x| x.is_finite()) && radius.is_finite();
        if !is_finite || radius < 0.0 {
            return;
        }
        let rod =
            Primitive { a, b, body: self.body, before: [radius, 0.0, 0.0], ..Primitive::default() };
        if let Some(fill) = paint.fill {
            let Color([red, green, blue, _]) = paint.shaded(1.0).unwrap_or(fill);
            let after = [red, green, blue].map(|part| f32::from(part) / 255.0);
            let kind = if a == b { Kind::Ball } else { Kind::Rod }.bits();
            self.primitives.push(Primitive { color: packed(fill), after, kind, ..rod });
        }
        if let Some(Stroke { color, width }) = paint.stroke {
            let (color, half_width) = (packed(color), 0.5 * width);
            self.primitives.push(Primitive { half_width, color, kind: Kind::Rim.bits(), ..rod });
        }
    }

    /// Adds a line that fades towards its first point, segment by segment.
    pub(super) fn fading(&mut self, points: &[[f64; 3]], stroke: Stroke) {
        let first = self.primitives.len();
        self.line(points, false, stroke);
        let n = (self.primitives.len() - first) as f32;
        for (idx, segment) in self.primitives[first..].iter_mut().enumerate() {
            segment.color = packed(stroke.color.faded((idx + 1) as f32 / n));
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

/// By shape, the middle of its points in the frame of its body, m.
pub(super) fn middles(scene: &Scene) -> Vec<[f64; 3]> {
    scene.shapes.iter().map(|shape| middle(points_of(&shape.form))).collect()
}

/// All points of a shape.
fn points_of(form: &Form) -> impl Iterator<Item = &[f64; 3]> {
    let rings = match form {
        Form::Region(rings) | Form::Section { rings, .. } => rings.as_slice(),
        Form::Line { points, .. } => std::slice::from_ref(points),
        Form::Rod { .. } => &[],
        Form::Solid(solid) => std::slice::from_ref(&solid.corners),
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
