//! The scene for the page: shapes with their paint in both themes.

use bksim::overlay;
use bksim::playback::Playback;
use bksim::sim::redundancy::Uniqueness;
use bksim_scene::{Attached, Form, Marker, MarkerKind, Role, Scene, Shape, Span, Theme};
use serde_json::{Value, json};

use crate::curves::shared_spans;
use crate::error::PageError;
use crate::solids::{self, PageSolid};

/// Number of lengths at which a span's lines are given; between them the page interpolates.
const N_LENGTHS: u32 = 9;
/// Number of instants at which the lengths of spans are measured.
const N_INSTANTS: u32 = 200;

/// Number of instants from which the lengths of guides and slots come.
const N_POSES: usize = 100;

/// The scene of a run as JSON, with solids in at most `budget` bytes, and a remark on what they left out.
pub(crate) fn write(
    playback: &mut Playback,
    budget: usize,
    curves: &[String],
) -> Result<(Value, Option<String>), PageError> {
    let motion = playback.poses_over_run(N_POSES);
    let mechanism = playback.mechanism();
    let mut scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &motion);
    let read = || playback.log().model_with(&mechanism.parameters);
    overlay::lay_over(&mut scene, &overlay::overlays(&read, curves)?);
    let lengths = lengths(playback, &scene)?;

    // Shapes, spans and markers; roles are numbered as they occur.
    let mut roles: Vec<Role> = Vec::new();
    let (solids, remark) = solids::take(&scene, budget);
    let shapes = scene.shapes.iter().zip(&solids);
    let shapes: Vec<Value> =
        shapes.map(|(shape, solid)| drawn(shape, solid.as_ref(), &mut roles)).collect();
    let spans = scene.spans.iter().zip(lengths);
    let spans: Vec<Value> =
        spans.map(|(span, range)| spanned(span, range, scene.pin, &mut roles)).collect();
    let span = playback.span();
    let uniqueness = playback.uniqueness();
    let shared = |joint_idx: usize| {
        let is_unique =
            |uniqueness: &Uniqueness| uniqueness.reactions[joint_idx][..3].iter().all(|&it| it);
        let changes: Vec<(f64, bool)> =
            uniqueness.iter().map(|change| (change.t, is_unique(&change.uniqueness))).collect();
        shared_spans(&changes, span)
    };
    let markers: Vec<Value> = scene.markers.iter().map(|marker| marked(marker, &shared)).collect();

    // The paint of the roles in both themes.
    let paint = |theme: Theme| {
        let paints: Vec<_> = roles.iter().map(|&role| theme.paint(role)).collect();
        let sections: Vec<_> = roles.iter().map(|&role| theme.section(role)).collect();
        json!({ "colors": theme, "paints": paints, "sections": sections })
    };
    let written = json!({
        "planar": scene.is_planar,
        "bodies": scene.bodies,
        "shapes": shapes,
        "spans": spans,
        "markers": markers,
        "pin": scene.pin,
        "themes": { "light": paint(Theme::LIGHT), "dark": paint(Theme::DARK) },
    });
    Ok((written, remark))
}

/// A shape as lines in the frame of its body.
fn drawn(shape: &Shape, solid: Option<&PageSolid>, roles: &mut Vec<Role>) -> Value {
    let (kind, lines) = match &shape.form {
        Form::Region(rings) | Form::Section { rings, .. } => {
            ("region", rings.iter().map(|ring| flat(ring)).collect())
        }
        Form::Line { points, is_closed: true } => ("ring", vec![flat(points)]),
        Form::Line { points, is_closed: false } => ("line", vec![flat(points)]),
        Form::Rod { ends, .. } => ("rod", vec![flat(ends)]),
        Form::Solid(_) => ("solid", Vec::new()),
    };
    // The edges of solids follow from their faces.
    let corners = solid.map_or(&[][..], |solid| solid.corners.as_flattened());
    let faces = solid.map_or(&[][..], |solid| &solid.faces);
    let lines = if solid.is_some() { json!([corners]) } else { json!(lines) };
    let radius = if let Form::Rod { radius, .. } = shape.form { radius } else { 0.0 };
    json!({
        "body": shape.body, "role": index_of(shape.role, roles),
        "front": shape.role.is_in_front(), "kind": kind, "lines": lines, "radius": radius,
        "faces": faces, "isCurve": shape.role.is_curve(),
    })
}

/// The index of a role, which is added if it is new.
fn index_of(role: Role, roles: &mut Vec<Role>) -> usize {
    roles.iter().position(|known| *known == role).unwrap_or_else(|| {
        roles.push(role);
        roles.len() - 1
    })
}

/// Coordinates of points in one list; their seven digits resolve a micrometre in ten metres.
#[expect(clippy::cast_possible_truncation, reason = "see above")]
fn flat(points: &[[f64; 3]]) -> Vec<f32> {
    points.iter().flatten().map(|&x| x as f32).collect()
}

fn attached(at: &Attached) -> Value {
    json!({ "body": at.body, "position": at.position })
}

fn marked(marker: &Marker, shared: &dyn Fn(usize) -> Vec<[f64; 2]>) -> Value {
    let (kind, joint) = match marker.kind {
        MarkerKind::Joint(joint_idx) => ("joint", Some(joint_idx)),
        MarkerKind::Point => ("point", None),
        MarkerKind::Mass => ("mass", None),
    };
    let shared = joint.map(shared);
    json!({
        "name": marker.name, "kind": kind, "joint": joint, "at": attached(&marker.at),
        "shared": shared,
    })
}

/// A span as its lines at lengths between the shortest and the longest: along it and across it, m.
fn spanned(span: &Span, [low, high]: [f64; 2], pin: f64, roles: &mut Vec<Role>) -> Value {
    let length = |k: u32| low + (high - low) * f64::from(k) / f64::from(N_LENGTHS - 1);
    let drawn = |k: u32| span.lines([[0.0; 3], [length(k), 0.0, 0.0]], pin, [0.0, 0.0, 1.0]);
    let lines: Vec<Value> = (0..N_LENGTHS)
        .map(|k| {
            let in_plane = |points: &Vec<[f64; 3]>| {
                #[expect(clippy::cast_possible_truncation, reason = "as in `flat`")]
                points.iter().flat_map(|p| [p[0] as f32, p[1] as f32]).collect::<Vec<f32>>()
            };
            drawn(k).iter().map(|(_, points)| in_plane(points)).collect()
        })
        .collect();
    let of_lines: Vec<usize> =
        drawn(0).into_iter().map(|(role, _)| index_of(role, roles)).collect();
    json!({
        "ends": span.ends.iter().map(attached).collect::<Vec<_>>(),
        "range": [low, high],
        "roles": of_lines,
        "lines": lines,
    })
}

/// Shortest and longest distance of the ends of every span.
fn lengths(playback: &mut Playback, scene: &Scene) -> Result<Vec<[f64; 2]>, PageError> {
    let mut lengths = vec![[f64::INFINITY, 0.0]; scene.spans.len()];
    if lengths.is_empty() {
        return Ok(lengths);
    }
    let [first, last] = playback.span();
    for k in 0..=N_INSTANTS {
        playback.seek(first + (last - first) * f64::from(k) / f64::from(N_INSTANTS))?;
        let poses = playback.poses();
        let position = |at: &Attached| poses[at.body].place(at.position);
        for (range, span) in lengths.iter_mut().zip(&scene.spans) {
            let [a, b] = span.ends.each_ref().map(position);
            let length = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
            *range = [range[0].min(length), range[1].max(length)];
        }
    }
    Ok(lengths)
}
