//! Entities as Foxglove's messages.

use foxglove::messages::{
    Color, LinePrimitive, PackedElementField, Point3, PointCloud, Pose, Quaternion, SceneEntity,
    SceneUpdate, Timestamp, TriangleListPrimitive, Vector3, line_primitive::Type as LineType,
    packed_element_field::NumericType,
};
use prost::Message as _;

use super::{Area, Entity, Line};
use crate::{LogError, write::check_size};

/// Scenes are written in messages of at most this size, bytes, or of one entity.
const UPDATE_SIZE: usize = 1 << 20;
/// Points are set along a line this many to its frame's size.
const POINTS_PER_SIZE: f64 = 80.0;
/// The lines of a frame together are at most about twice this many points, and one for each line.
const MOST_POINTS: f64 = 4000.0;

pub(super) fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

pub(super) fn quaternion([x, y, z, w]: [f64; 4]) -> Quaternion {
    Quaternion { x, y, z, w }
}

/// The pose of a frame in itself.
fn identity() -> Pose {
    let (position, orientation) = (vector([0.0; 3]), quaternion([0.0, 0.0, 0.0, 1.0]));
    Pose { position: Some(position), orientation: Some(orientation) }
}

/// One message of all entities.
pub(super) fn update(entities: &[Entity], now: Option<Timestamp>) -> SceneUpdate {
    let entities = entities.iter().map(|entity| scene_entity(entity, now)).collect();
    SceneUpdate { deletions: Vec::new(), entities }
}

/// Updates in the fewest messages that their size allows.
pub(super) fn updates(entities: &[Entity], now: Timestamp) -> Result<Vec<SceneUpdate>, LogError> {
    let (mut all, mut size) = (vec![SceneUpdate::default()], 0);
    for entity in entities {
        let entity = scene_entity(entity, Some(now));
        let n_bytes = entity.encoded_len();
        check_size("a shape", n_bytes)?;
        if size + n_bytes > UPDATE_SIZE && size > 0 {
            all.push(SceneUpdate::default());
            size = 0;
        }
        size += n_bytes;
        if let Some(update) = all.last_mut() {
            update.entities.push(entity);
        }
    }
    Ok(all)
}

fn scene_entity(entity: &Entity, now: Option<Timestamp>) -> SceneEntity {
    SceneEntity {
        timestamp: now,
        frame_id: entity.frame.clone(),
        id: entity.id.clone(),
        // No lifetime: for ever. It moves with its frame.
        frame_locked: true,
        triangles: entity.areas.iter().map(triangles).collect(),
        lines: entity.lines.iter().map(line).collect(),
        ..SceneEntity::default()
    }
}

fn triangles(area: &Area) -> TriangleListPrimitive {
    TriangleListPrimitive {
        pose: Some(identity()),
        points: area.points.iter().map(point).collect(),
        color: Some(color(area.color)),
        colors: Vec::new(),
        indices: area.triangles.as_flattened().to_vec(),
    }
}

fn line(line: &Line) -> LinePrimitive {
    let r#type = if line.is_closed { LineType::LineLoop } else { LineType::LineStrip };
    LinePrimitive {
        r#type: r#type.into(),
        pose: Some(identity()),
        thickness: line.width,
        scale_invariant: true,
        points: line.points.iter().map(point).collect(),
        color: Some(color(line.color)),
        colors: Vec::new(),
        indices: Vec::new(),
    }
}

fn point(&[x, y, z]: &[f64; 3]) -> Point3 {
    Point3 { x, y, z }
}

fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}

/// The lines of each frame that has some as points, in the order in which the frames appear.
pub(super) fn outlines<'e>(
    entities: impl Iterator<Item = &'e Entity>,
    now: Timestamp,
) -> Vec<PointCloud> {
    let mut frames: Vec<(&str, Vec<&Line>)> = Vec::new();
    let mut indices = std::collections::BTreeMap::new();
    for entity in entities.filter(|entity| !entity.lines.is_empty()) {
        let frame = entity.frame.as_str();
        let frame_idx = *indices.entry(frame).or_insert_with(|| {
            frames.push((frame, Vec::new()));
            frames.len() - 1
        });
        frames[frame_idx].1.extend(&entity.lines);
    }
    frames.into_iter().map(|(frame, lines)| cloud(frame, &lines, now)).collect()
}

fn cloud(frame: &str, lines: &[&Line], now: Timestamp) -> PointCloud {
    // The spacing of points, from the size and the length of all lines.
    let corners = lines.iter().flat_map(|line| &line.points);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in corners {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let size = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let length: f64 = lines.iter().flat_map(|line| edges(line)).map(|[a, b]| distance(a, b)).sum();
    let spacing = (size / POINTS_PER_SIZE).max(length / MOST_POINTS).max(f64::MIN_POSITIVE);

    // Points along every line.
    let mut data = Vec::new();
    for line in lines {
        if let Some(&first) = line.points.first() {
            put_point(&mut data, first, line.color);
        }
        let mut since = 0.0;
        for [a, b] in edges(line) {
            // Long edges in equal parts; of short ones, as in arcs, some corners are left out.
            let length = distance(a, b);
            let n_parts = (length / spacing).ceil().clamp(1.0, MOST_POINTS);
            let mut part = 1.0;
            while part <= n_parts {
                since += length / n_parts;
                if since >= 0.5 * spacing {
                    let at = |axis: usize| a[axis] + (b[axis] - a[axis]) * (part / n_parts);
                    put_point(&mut data, [at(0), at(1), at(2)], line.color);
                    since = 0.0;
                }
                part += 1.0;
            }
        }
    }

    // Three floats for the position, four bytes for the colour.
    let number = |name: &str, offset: u32, r#type: NumericType| PackedElementField {
        name: name.into(),
        offset,
        r#type: r#type.into(),
    };
    let position = ["x", "y", "z"].into_iter().zip([0, 4, 8]);
    let colors = ["red", "green", "blue", "alpha"].into_iter().zip(12..);
    let position = position.map(|(name, offset)| number(name, offset, NumericType::Float32));
    let colors = colors.map(|(name, offset)| number(name, offset, NumericType::Uint8));
    PointCloud {
        timestamp: Some(now),
        frame_id: frame.into(),
        pose: Some(identity()),
        point_stride: 16,
        fields: position.chain(colors).collect(),
        data: data.into(),
    }
}

/// The ends of the straight parts of a line.
fn edges(line: &Line) -> impl Iterator<Item = [[f64; 3]; 2]> {
    let points = &line.points;
    let closing = match (points.first(), points.last()) {
        (Some(&first), Some(&last)) if line.is_closed => Some([last, first]),
        _ => None,
    };
    points.windows(2).map(|pair| [pair[0], pair[1]]).chain(closing)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (b[axis] - a[axis]).powi(2)).sum::<f64>().sqrt()
}

/// Three floats and four bytes.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0 to 255")]
fn put_point(data: &mut Vec<u8>, point: [f64; 3], color: [f64; 4]) {
    data.extend(point.map(|x| (x as f32).to_le_bytes()).as_flattened());
    data.extend(color.map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8));
}
