//! From a scene and the poses of its bodies to a picture.

use bksim_sim::pose::Pose;

use crate::label::{Label, Labels};
use crate::{
    Camera, Color, Form, Item, Marker, MarkerKind, Paint, Picture, Scene, Shape, Stroke, Theme,
    silhouette,
};

/// What is drawn beside the mechanism.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Extras {
    /// Ways of points through the world, the oldest first, which fades.
    pub trails: Vec<(Color, Vec<[f64; 3]>)>,
    /// Arrows from a point of the world along a vector of it, both m. Those shorter than a pixel are
    /// left out.
    pub arrows: Vec<(Color, [f64; 3], [f64; 3])>,
    /// Whether markers have their names beside them.
    pub has_labels: bool,
    /// Poses at other instants, drawn faintly behind.
    pub ghosts: Vec<Vec<Pose>>,
}

/// How much of a ghost is seen.
const GHOST: f32 = 0.22;
/// Pieces of a trail, each more opaque than the one before.
const FADES: usize = 12;

/// What `camera` sees of `scene` when its bodies are at `poses`.
pub fn picture(
    scene: &Scene,
    poses: &[Pose],
    extras: &Extras,
    camera: &Camera,
    theme: &Theme,
) -> Picture {
    let mut painter = Painter { scene, camera, theme, items: Vec::new() };
    for ghost in &extras.ghosts {
        painter.mechanism(ghost, GHOST);
    }
    for (color, points) in &extras.trails {
        painter.trail(*color, points);
    }
    painter.mechanism(poses, 1.0);
    let mut along_arrows = Vec::new();
    for &(color, from, vector) in &extras.arrows {
        along_arrows.extend(painter.arrow(color, from, vector));
    }
    if extras.has_labels {
        painter.labels(poses, &along_arrows);
    }
    let size = [single(camera.size[0]), single(camera.size[1])];
    Picture { size, background: Some(theme.background), items: painter.items }
}

struct Painter<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    theme: &'a Theme,
    items: Vec<Item>,
}

/// Items of one shape, and how far towards the eye it is.
type Layer = (f64, Vec<Item>);

impl Painter<'_> {
    /// The shapes and spans, those in the back first: in the order of the scene, in space by depth.
    fn mechanism(&mut self, poses: &[Pose], opacity: f32) {
        let shapes = &self.scene.shapes;
        let drawn = |shape| self.shape(shape, poses, opacity).unwrap_or_default();
        let (own, items): (Vec<f64>, Vec<Vec<Item>>) = shapes.iter().map(drawn).unzip();
        let drawn = shapes.iter().zip(self.scene.depths(&own).into_iter().zip(items));
        let (front, back): (Vec<_>, Vec<_>) =
            drawn.partition(|(shape, _)| shape.role.is_in_front());
        let mut layers: Vec<Layer> = back.into_iter().map(|(_, layer)| layer).collect();
        self.spans(poses, opacity, &mut layers);
        layers.extend(front.into_iter().map(|(_, layer)| layer));
        if !self.scene.is_planar {
            layers.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        }
        self.items.extend(layers.into_iter().flat_map(|(_, items)| items));
    }

    fn shape(&self, shape: &Shape, poses: &[Pose], opacity: f32) -> Option<Layer> {
        let pose = poses.get(shape.body)?;
        let paint = self.theme.paint(shape.role).faded(opacity);
        if let Form::Rod { ends, radius } = shape.form {
            let ends = ends.map(|end| pose.place(end));
            let ring = silhouette(ends, radius, self.camera);
            let (_, items) = self.layer(&[ring], true, true, paint);
            return Some((ends.map(|end| 0.5 * self.camera.project(end)[2]).iter().sum(), items));
        }
        let (rings, is_closed) = match &shape.form {
            Form::Region(rings) => (rings.as_slice(), true),
            Form::Line { points, is_closed } => (std::slice::from_ref(points), *is_closed),
            Form::Rod { .. } => return None,
        };
        let placed = |ring: &Vec<[f64; 3]>| ring.iter().map(|&p| pose.place(p)).collect();
        let rings: Vec<Vec<[f64; 3]>> = rings.iter().map(placed).collect();
        let is_filled = matches!(shape.form, Form::Region(_));
        Some(self.layer(&rings, is_closed, is_filled, paint))
    }

    fn spans(&self, poses: &[Pose], opacity: f32, layers: &mut Vec<Layer>) {
        for span in &self.scene.spans {
            let [from, to] = &span.ends;
            let (Some(a), Some(b)) = (poses.get(from.body), poses.get(to.body)) else { continue };
            let ends = [a.place(from.position), b.place(to.position)];
            let [_, _, eye] = self.camera.r_view_from_world;
            for (role, points) in span.lines(ends, self.scene.pin, eye) {
                let paint = self.theme.paint(role).faded(opacity);
                layers.push(self.layer(&[points], false, false, paint));
            }
        }
    }

    /// Rings in the world, as they are painted.
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

    /// A line that fades towards its old end: glazes over each other, each from a later point to the
    /// new end. Pieces side by side would show where their round ends overlap.
    fn trail(&mut self, color: Color, points: &[[f64; 3]]) {
        let n = points.len().saturating_sub(1);
        let width = self.theme.sizes.trail;
        let points: Vec<[f32; 2]> = points.iter().map(|&p| self.pixel(p)).collect();
        let mut seen = 0.0;
        for glaze in 0..FADES {
            let first = glaze * n / FADES;
            if first >= (glaze + 1) * n / FADES {
                continue;
            }
            // What is seen through a glaze of opacity a over others of s together is s + a (1 − s).
            let wanted = color.opacity() * (glaze + 1) as f32 / FADES as f32;
            let color = color.with_opacity(((wanted - seen) / (1.0 - seen)).clamp(0.0, 1.0));
            seen = wanted;
            let stroke = Stroke { color, width };
            self.items.push(Item::Line {
                points: points[first..].to_vec(),
                is_closed: false,
                stroke,
            });
        }
    }

    /// An arrow; gives some places along it.
    fn arrow(&mut self, color: Color, from: [f64; 3], vector: [f64; 3]) -> Vec<[f32; 2]> {
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
        // The shaft ends inside the head: no gap, and nothing beside the tip.
        let inside = [neck[0] + 0.3 * head * ux, neck[1] + 0.3 * head * uy];
        let stroke = Stroke { color, width: sizes.arrow.min(0.6 * head) };
        let shaft = Item::Line { points: vec![from, inside], is_closed: false, stroke };
        let head =
            Item::Region { rings: vec![vec![tip, corner(half), corner(-half)]], fill: color };
        self.items.extend([shaft, head]);
        let at = |i: u8| [from[0] + f32::from(i) / 16.0 * dx, from[1] + f32::from(i) / 16.0 * dy];
        (1..=16).map(at).collect()
    }

    /// The names of markers.
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
        let place = |marker: &Marker| {
            let pose = poses.get(marker.at.body)?;
            Some(self.pixel(pose.place(marker.at.position)))
        };
        // The points that a joint connects have its name.
        let is_joint = |marker: &&Marker| matches!(marker.kind, MarkerKind::Joint(_));
        let joints: Vec<[f32; 2]> =
            self.scene.markers.iter().filter(is_joint).filter_map(place).collect();
        let is_named = |at: [f32; 2]| {
            joints.iter().any(|j| (j[0] - at[0]).hypot(j[1] - at[1]) < 0.5 * pin.max(1.0))
        };
        let label = |marker: &Marker| {
            let at = place(marker).filter(|at| at.iter().all(|x| x.is_finite()))?;
            let is_said = marker.kind == MarkerKind::Point && is_named(at);
            (!is_said).then(|| Label { at, text: marker.name.clone() })
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

/// What a pixel needs.
#[expect(clippy::cast_possible_truncation, reason = "pixels")]
fn single(x: f64) -> f32 {
    x as f32
}
