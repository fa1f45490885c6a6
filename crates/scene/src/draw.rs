//! [`picture`]: a scene, with its bodies at given poses, as a camera sees it.

use bksim_sim::pose::Pose;

use crate::label::{Label, Labels};
use crate::rod::{DUSK, lit_caps};
use crate::rule::{arrow_legend, written};
use crate::vectors::ArrowKind;
use crate::{
    Camera, Color, Form, HalfSpace, Item, Marker, MarkerKind, Paint, Picture, Role, Scene, Section,
    SeenFace, Shape, Span, SpanKind, Stroke, Theme, silhouette,
};

/// Additions to the picture of a mechanism: trails, arrows, names, ghosts.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Extras {
    /// Paths of points through the world, oldest point first; the old end fades.
    pub trails: Vec<(Color, Vec<[f64; 3]>)>,
    /// Arrows; those shorter than a pixel are left out.
    pub arrows: Vec<Arrow>,
    /// True if markers are labelled with their names.
    pub has_labels: bool,
    /// Kinds of arrows whose scales are told in the lower left corner.
    pub legend: Vec<ArrowKind>,
    /// Poses at other instants, drawn faintly under the mechanism.
    pub ghosts: Vec<Vec<Pose>>,
    /// Lines of words in the upper left corner, the first one larger, and a line below the mechanism.
    pub words: Words,
    /// The plane that cuts a mechanism in space, with trails, and arrows and names on the side that is left out.
    pub section: Option<Section>,
}

impl Extras {
    /// The trails in a half of space, and the arrows that begin there.
    #[must_use]
    pub fn cut(&self, half: &HalfSpace) -> Self {
        let pieces = |(color, points): &(_, Vec<[f64; 3]>)| {
            let color = *color;
            half.pieces(points).into_iter().map(move |points| (color, points))
        };
        Self {
            trails: self.trails.iter().flat_map(pieces).collect(),
            arrows: self.arrows.iter().filter(|it| half.height(it.from) <= 0.0).copied().collect(),
            ..self.clone()
        }
    }
}

/// Words around a mechanism.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Words {
    /// Title in the upper left corner; may be empty.
    pub title: String,
    /// The instant below it, if it is shown.
    pub instant: Option<String>,
    /// Caption in the middle below the mechanism; may be empty.
    pub caption: String,
}

impl Words {
    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.title.is_empty() && self.instant.is_none() && self.caption.is_empty()
    }
}

/// An arrow in the world.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Arrow {
    /// Of shaft and head.
    pub color: Color,
    /// Tail of the arrow, m.
    pub from: [f64; 3],
    /// From tail to tip, m.
    pub vector: [f64; 3],
    /// Drawn with a dashed shaft and an empty head: one of many values that the vector may have.
    pub is_hollow: bool,
}

/// Opacity of a ghost.
const GHOST: f32 = 0.22;
/// Number of pieces of a trail, each more opaque than the one before.
const FADES: usize = 12;

/// The picture that `camera` gives of `scene` with its bodies at `poses`.
pub fn picture(
    scene: &Scene,
    poses: &[Pose],
    extras: &Extras,
    camera: &Camera,
    theme: &Theme,
) -> Picture {
    let [_, _, eye] = camera.r_view_from_world;
    let half = scene.half(extras.section, eye);
    let cut = half.map(|half| extras.cut(&half));
    let extras = cut.as_ref().unwrap_or(extras);
    let mut painter = Painter { scene, half, camera, theme, items: Vec::new() };
    for ghost in &extras.ghosts {
        painter.mechanism(ghost, GHOST);
    }
    for (color, points) in &extras.trails {
        painter.trail(*color, points);
    }
    painter.mechanism(poses, 1.0);
    let mut along_arrows = Vec::new();
    for arrow in &extras.arrows {
        along_arrows.extend(painter.arrow(arrow));
    }
    if extras.has_labels {
        painter.labels(poses, &along_arrows);
    }
    painter.items.extend(arrow_legend(&extras.legend, camera, theme));
    painter.items.extend(written(&extras.words, camera, theme));
    let size = [single(camera.size[0]), single(camera.size[1])];
    Picture { size, background: Some(theme.background), items: painter.items }
}

struct Painter<'a> {
    scene: &'a Scene,
    /// The half of space that is drawn; all if none.
    half: Option<HalfSpace>,
    camera: &'a Camera,
    theme: &'a Theme,
    items: Vec<Item>,
}

/// Depth of a shape, m towards the eye, and its items.
type Layer = (f64, Vec<Item>);

impl Painter<'_> {
    /// Paints shapes and spans from back to front: in the order of the scene, in space by depth.
    fn mechanism(&mut self, poses: &[Pose], opacity: f32) {
        let [_, _, eye] = self.camera.r_view_from_world;
        let cut = self.half.map(|half| self.scene.cut(&half, poses, eye));
        let scene = cut.as_ref().unwrap_or(self.scene);
        let shapes = &scene.shapes;
        let drawn = |shape| self.shape(shape, poses, opacity).unwrap_or_default();
        let (own, items): (Vec<f64>, Vec<Vec<Item>>) = shapes.iter().map(drawn).unzip();
        let drawn = shapes
            .iter()
            .zip(scene.depths(&own, poses, &self.camera.r_view_from_world).into_iter().zip(items));
        let (front, back): (Vec<_>, Vec<_>) =
            drawn.partition(|(shape, _)| shape.role.is_in_front());
        let mut layers: Vec<Layer> = back.into_iter().map(|(_, layer)| layer).collect();
        for (role, points) in scene.stretched(poses, eye).into_iter().flat_map(|it| it.lines) {
            let paint = self.theme.paint(role).faded(opacity);
            layers.push(self.layer(&[points], false, false, paint));
        }
        layers.extend(front.into_iter().map(|(_, layer)| layer));
        if !scene.is_planar {
            layers.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        }
        self.items.extend(layers.into_iter().flat_map(|(_, items)| items));
    }

    fn shape(&self, shape: &Shape, poses: &[Pose], opacity: f32) -> Option<Layer> {
        let pose = poses.get(shape.body)?;
        let paint = self.theme.paint(shape.role).faded(opacity);
        let in_world = |ring: &Vec<[f64; 3]>| ring.iter().map(|&p| pose.place(p)).collect();
        let layer = match &shape.form {
            Form::Region(rings) => {
                let rings: Vec<Vec<[f64; 3]>> = rings.iter().map(in_world).collect();
                self.layer(&rings, true, true, paint)
            }
            Form::Line { points, is_closed } => {
                self.layer(&[in_world(points)], *is_closed, false, paint)
            }
            Form::Rod { ends, radius } => {
                let ends = ends.map(|end| pose.place(end));
                let ring = silhouette(ends, *radius, self.camera);
                let items = if ends[0] == ends[1] {
                    self.ball(ends[0], *radius, &ring, paint)
                } else {
                    self.layer(&[ring], true, true, paint).1
                };
                // The outline lies in a plane across the view: the depth comes from the ends.
                (ends.map(|end| 0.5 * self.camera.project(end)[2]).iter().sum(), items)
            }
            Form::Solid(solid) => {
                let place = |p| pose.place(p);
                let depth = self.camera.project(place(solid.middle()))[2];
                (depth, self.solid(&solid.seen(place, self.camera), shape.role, opacity))
            }
            Form::Section { rings, hatching } => {
                let rings: Vec<Vec<[f64; 3]>> = rings.iter().map(in_world).collect();
                let lines = hatching.iter().map(|line| line.map(|p| pose.place(p)));
                let paint = self.theme.section(shape.role).faded(opacity);
                let area = Paint { fill: Some(paint.fill), stroke: Some(paint.outline) };
                let (depth, mut items) = self.layer(&rings, true, true, area);
                let line = |points: [[f64; 3]; 2]| Item::Line {
                    points: points.map(|p| self.pixel(p)).to_vec(),
                    is_closed: false,
                    stroke: paint.hatching,
                };
                // The hatching lies under the outline.
                items.splice(1..1, lines.map(line));
                (depth, items)
            }
        };
        Some(layer)
    }

    /// A ball in the light, with its outline.
    fn ball(&self, centre: [f64; 3], radius: f64, outline: &[[f64; 3]], paint: Paint) -> Vec<Item> {
        let pixels = |ring: &[[f64; 3]]| ring.iter().map(|&p| self.pixel(p)).collect::<Vec<_>>();
        let region = |ring: &[[f64; 3]], shade| {
            let fill = paint.shaded(shade)?;
            Some(Item::Region { rings: vec![pixels(ring)], fill })
        };
        let mut items: Vec<Item> = region(outline, DUSK).into_iter().collect();
        let caps = lit_caps(centre, radius, self.camera);
        items.extend(caps.iter().filter_map(|(ring, shade)| region(ring, *shade)));
        let line = |stroke| Item::Line { points: pixels(outline), is_closed: true, stroke };
        items.extend(paint.stroke.map(line));
        items
    }

    /// The faces of a solid, each in a colour of its own, with their edges.
    fn solid(&self, faces: &[SeenFace], role: Role, opacity: f32) -> Vec<Item> {
        let paint = self.theme.paint(role);
        let pixels = |ring: &[[f64; 3]]| ring.iter().map(|&p| self.pixel(p)).collect::<Vec<_>>();
        let mut items = Vec::new();
        for face in faces {
            if let Some(fill) = paint.shaded(face.shade).map(|fill| fill.faded(opacity)) {
                // A line of the same colour closes the gap that smooth edges leave to the next face.
                let (points, stroke) = (pixels(&face.ring), Stroke { color: fill, width: 0.6 });
                items.push(Item::Region { rings: vec![points.clone()], fill });
                items.push(Item::Line { points, is_closed: true, stroke });
            }
            if let Some(stroke) = paint.faded(opacity).stroke {
                let line = |edge: &[[f64; 3]; 2]| Item::Line {
                    points: pixels(edge),
                    is_closed: false,
                    stroke,
                };
                items.extend(face.edges.iter().map(line));
            }
        }
        items
    }

    /// Items and mean depth of rings in the world.
    fn layer(&self, rings: &[Vec<[f64; 3]>], is_closed: bool, fill: bool, paint: Paint) -> Layer {
        let n = rings.iter().map(Vec::len).sum::<usize>().max(1) as f64;
        let depth = rings.iter().flatten().map(|&p| self.camera.project(p)[2] / n).sum();
        let seen: Vec<Vec<[f32; 2]>> =
            rings.iter().map(|ring| ring.iter().map(|&p| self.pixel(p)).collect()).collect();
        let mut items = Vec::new();
        if let Some(fill) = paint.fill.filter(|_| fill) {
            items.push(Item::Region { rings: seen.clone(), fill });
        }
        if let Some(stroke) = paint.stroke {
            let line = |points| Item::Line { points, is_closed, stroke };
            items.extend(seen.into_iter().map(line));
        }
        (depth, items)
    }

    /// Paints a line that fades towards its old end: glazes over each other, each from a later
    /// point to the new end. Separate pieces would show where their round ends overlap.
    fn trail(&mut self, color: Color, points: &[[f64; 3]]) {
        let n = points.len().saturating_sub(1);
        let width = self.theme.sizes.trail;
        let points: Vec<[f32; 2]> = points.iter().map(|&p| self.pixel(p)).collect();
        let mut reached = 0.0;
        for glaze in 0..FADES {
            let first = glaze * n / FADES;
            if first >= (glaze + 1) * n / FADES {
                continue;
            }
            // A glaze of opacity a over others of opacity s gives s + a (1 − s).
            let target = color.opacity() * (glaze + 1) as f32 / FADES as f32;
            let color = color.with_opacity(((target - reached) / (1.0 - reached)).clamp(0.0, 1.0));
            reached = target;
            let stroke = Stroke { color, width };
            self.items.push(Item::Line {
                points: points[first..].to_vec(),
                is_closed: false,
                stroke,
            });
        }
    }

    /// Paints an arrow; returns some points along it, which names should leave free.
    fn arrow(&mut self, arrow: &Arrow) -> Vec<[f32; 2]> {
        let Arrow { color, from, vector, is_hollow } = *arrow;
        let tip = self.pixel(std::array::from_fn(|i| from[i] + vector[i]));
        let from = self.pixel(from);
        let [dx, dy] = [tip[0] - from[0], tip[1] - from[1]];
        let length = dx.hypot(dy);
        if !(1.0..1e6).contains(&length) {
            return Vec::new();
        }
        let [ux, uy] = [dx / length, dy / length];
        let sizes = &self.theme.sizes;
        // A short arrow is nearly all head.
        let head = sizes.head.min(0.7 * length);
        let half = 0.36 * head;
        let neck = [tip[0] - head * ux, tip[1] - head * uy];
        let corner = |side: f32| [neck[0] - side * uy, neck[1] + side * ux];
        let stroke = Stroke { color, width: sizes.arrow.min(0.6 * head) };
        let line = |points, is_closed, stroke| Item::Line { points, is_closed, stroke };
        let triangle = vec![tip, corner(half), corner(-half)];
        if is_hollow {
            // Dashes as long as the head is wide, the last one up to it; lines a little thinner.
            let stroke = Stroke { width: 0.7 * stroke.width, ..stroke };
            let (shaft, dash) = (length - head, 1.2 * half);
            let on_shaft = |at: f32| [from[0] + at * ux, from[1] + at * uy];
            let mut end = shaft;
            while end > 0.0 {
                let points = vec![on_shaft((end - dash).max(0.0)), on_shaft(end)];
                self.items.push(line(points, false, stroke));
                end -= 1.8 * dash;
            }
            self.items.push(line(triangle, true, stroke));
        } else {
            // The shaft ends inside the head: no gap, and nothing sticks out at the tip.
            let inside = [neck[0] + 0.3 * head * ux, neck[1] + 0.3 * head * uy];
            let head = Item::Region { rings: vec![triangle], fill: color };
            self.items.extend([line(vec![from, inside], false, stroke), head]);
        }
        let at = |i: u8| [from[0] + f32::from(i) / 16.0 * dx, from[1] + f32::from(i) / 16.0 * dy];
        (1..=16).map(at).collect()
    }

    /// Paints the names of markers, where they hide neither each other nor the arrows.
    fn labels(&mut self, poses: &[Pose], arrows: &[[f32; 2]]) {
        let sizes = &self.theme.sizes;
        let pin = single(self.scene.pin * self.camera.scale);
        let labels = Labels {
            size: self.camera.size.map(single),
            text: sizes.text,
            color: self.theme.text,
            gap: (1.5 * pin).min(2.0 * sizes.text) + 0.3 * sizes.text,
            taken: arrows,
        };
        let position = |marker: &Marker| {
            let at = poses.get(marker.at.body)?.place(marker.at.position);
            let is_left_out = self.half.is_some_and(|half| half.height(at) > 0.0);
            (!is_left_out).then(|| self.pixel(at))
        };
        // A point that a joint connects goes by the name of the joint.
        let is_joint = |marker: &&Marker| matches!(marker.kind, MarkerKind::Joint(_));
        let joints: Vec<[f32; 2]> =
            self.scene.markers.iter().filter(is_joint).filter_map(position).collect();
        let is_at_joint = |at: [f32; 2]| {
            joints.iter().any(|j| (j[0] - at[0]).hypot(j[1] - at[1]) < 0.5 * pin.max(1.0))
        };
        // A massless link goes by its name at its middle.
        let middle = |marker: &Marker| {
            let is_own = |span: &&Span| span.kind == SpanKind::Link && span.name == marker.name;
            let span = self.scene.spans.iter().find(is_own)?;
            let ends = span
                .ends
                .each_ref()
                .map(|end| Some(self.pixel(poses.get(end.body)?.place(end.position))));
            let [Some(a), Some(b)] = ends else { return None };
            Some([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])])
        };
        let label = |marker: &Marker| {
            let own = position(marker)?;
            let at = middle(marker).unwrap_or(own);
            if at.iter().any(|x| !x.is_finite()) {
                return None;
            }
            let is_redundant = marker.kind == MarkerKind::Point && is_at_joint(at);
            (!is_redundant).then(|| Label { at, text: marker.name.clone() })
        };
        let names = self.scene.markers.iter().filter_map(label).collect();
        let items = labels.place(names);
        self.items.extend(items);
    }

    fn pixel(&self, p: [f64; 3]) -> [f32; 2] {
        let [x, y, _] = self.camera.project(p);
        [single(x), single(y)]
    }
}

/// Single precision, which is enough for pixels.
#[expect(clippy::cast_possible_truncation, reason = "pixels")]
fn single(x: f64) -> f32 {
    x as f32
}
