//! A scene as the JSON that the script of a page draws: shapes as lines on their bodies, and their paint in both themes.

use serde_json::{Value, json};

use crate::{Attached, Cord, Form, Marker, MarkerKind, Role, Scene, Shape, Span, Theme, TurnTimes};

/// Number of lengths at which a span's lines are given; between them the page interpolates.
const N_LENGTHS: u32 = 9;

/// Corners in the frame of the body, m, and faces of a solid, as a page has them.
pub type WrittenSolid<'a> = (&'a [[f64; 3]], &'a [Vec<usize>]);

impl Scene {
    /// The scene for a page's script. `solids` has those of the shapes that are some, `lengths` the shortest and
    /// longest distance of the ends of each span, `turned` the instants at which signs turn over, none of a pose, and
    /// `shared` the times in which the reaction of a joint is one of many solutions.
    pub fn written(
        &self,
        solids: &[Option<WrittenSolid<'_>>],
        lengths: &[[f64; 2]],
        turned: &[TurnTimes],
        shared: &dyn Fn(usize) -> Vec<[f64; 2]>,
    ) -> Value {
        // Shapes, spans and markers; roles are numbered as they occur.
        let mut roles: Vec<Role> = Vec::new();
        let shapes = self.shapes.iter().zip(solids);
        let shapes: Vec<Value> =
            shapes.map(|(shape, solid)| drawn(shape, *solid, &mut roles)).collect();
        let spans = self.spans.iter().zip(lengths);
        let spans: Vec<Value> =
            spans.map(|(span, &range)| spanned(span, range, self.pin, &mut roles)).collect();
        let cord = |cord: &Cord| {
            let role = index_of(Role::Link, &mut roles);
            json!({ "role": role, "places": cord.places, "isClosed": cord.is_closed })
        };
        let cords: Vec<Value> = self.cords.iter().map(cord).collect();
        let markers: Vec<Value> =
            self.markers.iter().map(|marker| marked(marker, shared)).collect();
        let turns: Vec<Value> = self
            .turns
            .iter()
            .zip(self.shapes_of_turns())
            .enumerate()
            .map(|(k, (turn, shapes))| {
                let held = TurnTimes { is_over: turn.is_over, times: Vec::new() };
                let TurnTimes { is_over, times } = turned.get(k).unwrap_or(&held);
                json!({
                    "shapes": shapes, "line": turn.line, "drawnOver": turn.is_over,
                    "over": is_over, "times": times,
                })
            })
            .collect();

        // The paint of the roles in both themes.
        let paint = |theme: Theme| {
            let paints: Vec<_> = roles.iter().map(|&role| theme.paint(role)).collect();
            let sections: Vec<_> = roles.iter().map(|&role| theme.section(role)).collect();
            json!({ "colors": theme, "paints": paints, "sections": sections })
        };
        json!({
            "planar": self.is_planar,
            "bodies": self.bodies,
            "shapes": shapes,
            "spans": spans,
            "cords": cords,
            "markers": markers,
            "turns": turns,
            "pin": self.pin,
            "themes": { "light": paint(Theme::LIGHT), "dark": paint(Theme::DARK) },
        })
    }
}

/// A shape as lines in the frame of its body.
fn drawn(shape: &Shape, solid: Option<WrittenSolid<'_>>, roles: &mut Vec<Role>) -> Value {
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
    let corners = solid.map_or(&[][..], |(corners, _)| corners.as_flattened());
    let faces = solid.map_or(&[][..], |(_, faces)| faces);
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
