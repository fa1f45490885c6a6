//! Shapes as triangles and lines.

use bksim_log::{Area, Entity, Line};
use bksim_scene::{Color, Edge, Form, Role, Scene, Shape, Theme, sheets};
use lyon_tessellation::math::{Point, point};
use lyon_tessellation::path::Path;
use lyon_tessellation::{
    BuffersBuilder, FillOptions, FillRule, FillTessellator, FillVertex, VertexBuffers,
};

/// Layers of a planar scene lie this part of a pin's radius apart: near enough to look flat, and far
/// enough that what is painted later covers what is below it.
const LAYER: f64 = 0.02;
/// All layers together are at most as thick as this many pins' radii.
const THICKNESS: f64 = 1.0;
/// Outlines are tessellated at this size: the tessellator's tolerances are those of pixels.
const GRID: f64 = 4096.0;

/// The shapes of a scene: one entity per body that has some, with the name and in the frame of it.
pub(super) fn entities(scene: &Scene) -> Vec<Entity> {
    let entity =
        |name: &String| Entity { id: name.clone(), frame: name.clone(), ..Entity::default() };
    let mut entities: Vec<Entity> = scene.bodies.iter().map(entity).collect();
    let n_layers = scene.shapes.len().max(1) as f64;
    let layer = if scene.is_planar { LAYER.min(THICKNESS / n_layers) * scene.pin } else { 0.0 };
    for (place, Shape { body, role, form }) in scene.shapes.iter().enumerate() {
        let z = layer * place as f64;
        let lifted = |points: &[[f64; 3]]| points.iter().map(|p| [p[0], p[1], p[2] + z]).collect();
        let entity = &mut entities[*body];
        match form {
            Form::Region(rings) | Form::Section { rings, .. } => {
                let rings: Vec<Vec<[f64; 3]>> = rings.iter().map(|ring| lifted(ring)).collect();
                let fill = Theme::LIGHT.paint(*role).fill;
                entity.areas.extend(fill.and_then(|color| area(&rings, color)));
                entity.lines.extend(rings.into_iter().filter_map(|ring| line(*role, ring, true)));
            }
            Form::Line { points, is_closed } => {
                entity.lines.extend(line(*role, lifted(points), *is_closed));
            }
            Form::Rod { ends, radius } => {
                let rings = sheets(*ends, *radius);
                let fill = Theme::LIGHT.paint(*role).fill;
                let sheet = |ring: &Vec<[f64; 3]>| area(std::slice::from_ref(ring), fill?);
                entity.areas.extend(rings.iter().filter_map(sheet));
                entity.lines.extend(rings.into_iter().filter_map(|ring| line(*role, ring, true)));
            }
            Form::Solid(solid) => {
                let fill = Theme::LIGHT.paint(*role).fill;
                let corner = |&corner: &usize| solid.corners[corner];
                let face = |face: &Vec<usize>| area(&[face.iter().map(corner).collect()], fill?);
                entity.areas.extend(solid.faces.iter().filter_map(face));
                let edges = solid.edges.iter().filter(|edge| edge.is_sharp);
                let edge = |edge: &Edge| {
                    line(*role, edge.corners.map(|c| solid.corners[c]).to_vec(), false)
                };
                entity.lines.extend(edges.filter_map(edge));
            }
        }
    }
    entities.retain(|entity| !(entity.areas.is_empty() && entity.lines.is_empty()));
    entities
}

/// A line as its role is painted; `None` when it is not.
pub(super) fn line(role: Role, points: Vec<[f64; 3]>, is_closed: bool) -> Option<Line> {
    let stroke = Theme::LIGHT.paint(role).stroke?;
    let (width, color) = (f64::from(stroke.width), parts(stroke.color));
    (points.len() > 1).then_some(Line { points, is_closed, width, color })
}

/// The inside of plane rings as triangles; `None` when there is none.
fn area(rings: &[Vec<[f64; 3]>], color: Color) -> Option<Area> {
    let plane = Plane::through(rings)?;
    let mut path = Path::builder();
    for ring in rings {
        let mut corners = ring.iter().map(|&corner| plane.flat(corner));
        let Some(first) = corners.next() else { continue };
        path.begin(first);
        for corner in corners {
            path.line_to(corner);
        }
        path.end(true);
    }
    // Large mechanisms keep thousands of them: not with the room that the library makes for a drawing.
    let n_corners = rings.iter().map(Vec::len).sum();
    let mut buffers: VertexBuffers<[f64; 3], u32> =
        VertexBuffers::with_capacity(n_corners, 3 * n_corners);
    let place = |vertex: FillVertex<'_>| plane.place(vertex.position());
    let options = FillOptions::default().with_fill_rule(FillRule::EvenOdd);
    // An outline that is no area to the tessellator keeps its edges.
    FillTessellator::new()
        .tessellate_path(&path.build(), &options, &mut BuffersBuilder::new(&mut buffers, place))
        .ok()?;
    let (triangles, _) = buffers.indices.as_chunks::<3>();
    let triangles = triangles.to_vec();
    let color = parts(color);
    (!triangles.is_empty()).then_some(Area { points: buffers.vertices, triangles, color })
}

/// The plane of an outline, with coordinates of the tessellator's size.
struct Plane {
    origin: [f64; 3],
    /// Two unit vectors.
    axes: [[f64; 3]; 2],
    /// Metres to the tessellator's unit.
    scale: f64,
}

impl Plane {
    /// `None` when the rings have no area.
    fn through(rings: &[Vec<[f64; 3]>]) -> Option<Self> {
        let (&origin, corners) = rings.first()?.split_first()?;
        let arms = || rings.iter().flatten().map(|&corner| minus(corner, origin));
        let size = arms().map(|arm| dot(arm, arm)).fold(0.0, f64::max).sqrt();
        // Twice the area of the first ring as a vector: fans about its first corner add up.
        let fans = corners.windows(2).map(|p| cross(minus(p[0], origin), minus(p[1], origin)));
        let normal = fans.fold([0.0; 3], plus);
        let normal = unit(normal)?;
        // The axis of the world that the normal is farthest from.
        let nearer = |a: usize, b: usize| if normal[b].abs() < normal[a].abs() { b } else { a };
        let farthest = (1..3).fold(0, nearer);
        let mut other = [0.0; 3];
        other[farthest] = 1.0;
        let first = unit(cross(other, normal))?;
        let scale = GRID / size;
        let axes = [first, cross(normal, first)];
        (scale.is_finite() && scale > 0.0).then_some(Self { origin, axes, scale })
    }

    #[expect(clippy::cast_possible_truncation, reason = "single precision is the tessellator's")]
    fn flat(&self, corner: [f64; 3]) -> Point {
        let arm = minus(corner, self.origin);
        let [x, y] = self.axes.map(|axis| (dot(axis, arm) * self.scale) as f32);
        point(x, y)
    }

    fn place(&self, at: Point) -> [f64; 3] {
        let [x, y] = [at.x, at.y].map(|part| f64::from(part) / self.scale);
        let [a, b] = self.axes;
        std::array::from_fn(|i| self.origin[i] + x * a[i] + y * b[i])
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `None` when there is no direction.
fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let norm = dot(a, a).sqrt();
    (norm > 0.0 && norm.is_finite()).then(|| a.map(|part| part / norm))
}

/// Red, green, blue, opacity, 0 to 1.
fn parts(color: Color) -> [f64; 4] {
    color.0.map(|part| f64::from(part) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of the triangles.
    fn measure(area: &Area) -> f64 {
        let corner = |i: u32| area.points[i as usize];
        let triangle = |&[a, b, c]: &[u32; 3]| {
            let normal = cross(minus(corner(b), corner(a)), minus(corner(c), corner(a)));
            0.5 * dot(normal, normal).sqrt()
        };
        area.triangles.iter().map(triangle).sum()
    }

    #[test]
    fn a_concave_outline_with_a_hole_keeps_its_area_in_any_plane() {
        // A C of 3 by 4 with an arm of 1, and a hole of a half squared in its back.
        let c = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (3, 3), (3, 4), (0, 4)];
        let hole = [(0.25, 0.25), (0.75, 0.25), (0.75, 0.75), (0.25, 0.75)];
        let flat: [Vec<[f64; 2]>; 2] = [
            c.iter().map(|&(x, y)| [f64::from(x), f64::from(y)]).collect(),
            hole.iter().map(|&(x, y)| [x, y]).collect(),
        ];
        let expected = 12.0 - 4.0 - 0.25;
        let tilted = |[x, y]: [f64; 2]| [7.0 + x * 0.6, 0.8 * x, y - 5.0];
        let level = |[x, y]: [f64; 2]| [x, y, 0.25];
        for place in [&tilted as &dyn Fn([f64; 2]) -> [f64; 3], &level] {
            let rings = flat.each_ref().map(|ring| ring.iter().map(|&p| place(p)).collect());
            let area = area(&rings, Color::opaque(0)).expect("an area");
            let found = measure(&area);
            assert!((found - expected).abs() < 1e-5, "{found} is not {expected}");
        }
        assert_eq!(area(&[vec![[0.0; 3], [1.0; 3], [2.0; 3]]], Color::opaque(0)), None);
    }
}
