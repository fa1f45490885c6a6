//! `[curves]` from geometry: what is drawn on the layer `BK_CURVE_track` is the curve `track`.
//!
//! A curve lies in the frame of the first point of a joint that follows it. Lines, circles, arcs and ellipses
//! become formulas, exactly; polylines of lines are smooth curves through their corners; all else is smooth
//! through points on it.

use bksim_model::diagnostic::Diagnostic;
use toml_edit::Value;

use super::Mechanism;
use crate::attachment::Content;
use crate::codes;
use crate::compose::draft::{Draft, array, point_value, quantity};
use crate::compose::faults::Faults;
use crate::drawing::{Location, Shape};
use crate::geometry::{Curve, Path, Point};
use crate::kind::CURVE_LAYER;

/// Points of one piece of a curve that has no formula.
const N_POINTS: u8 = 48;

/// Puts the curves that joints follow and that are drawn next to those that are stated.
pub(in crate::compose) fn put_drawn_curves(
    mechanism: &Mechanism<'_>,
    draft: &mut Draft,
    faults: &mut Faults<'_>,
) {
    for connection in mechanism.connections {
        for (end_idx, key) in ["curve", "second_curve"].into_iter().enumerate() {
            let Some(value) = connection.attachment.value(key) else { continue };
            let Content::Text(name) = &value.content else { continue };
            if draft.location_of(&["curves", name]).is_some() {
                continue;
            }
            let Some((path, location)) = drawn(mechanism, name, faults) else { continue };
            // Of a curve on a curve, the second belongs to the second body.
            let frame = mechanism.frames[connection.bodies[end_idx]];
            let origin = frame.point_inward(connection.at[end_idx]);
            let place = Place { mechanism, frame, origin };
            for (key, value) in place.curve(&path) {
                draft.put(["curves", name, key], value, location);
            }
        }
    }
}

/// The only path on the layer of a curve.
fn drawn<'a>(
    mechanism: &Mechanism<'a>,
    name: &str,
    faults: &mut Faults<'_>,
) -> Option<(Path, &'a Location)> {
    let layer = format!("{CURVE_LAYER}{name}");
    let entities = mechanism.source.drawing.entities.iter();
    let on_layer = entities.filter(|entity| entity.location.layer.eq_ignore_ascii_case(&layer));
    let mut paths = on_layer.filter_map(|entity| match &entity.shape {
        Shape::Path(path) if !path.curves.is_empty() => Some((path, &entity.location)),
        _ => None,
    });
    let (path, location) = paths.next()?;
    if let Some((_, other)) = paths.next() {
        let message = format!("two entities are the curve `{name}`");
        let help = "join them to one polyline or spline, or draw one of them on another layer";
        let fault = Diagnostic::error(codes::DUPLICATE_NAME, message).help(help);
        faults.add_pair(fault, [other, location]);
    }
    Some((path.clone(), location))
}

/// Where the frame of a curve is.
struct Place<'a> {
    mechanism: &'a Mechanism<'a>,
    frame: crate::compose::frame::Frame,
    /// The point of the joint in the frame of its body.
    origin: Point,
}

impl Place<'_> {
    /// The keys of a curve.
    fn curve(&self, path: &Path) -> Vec<(&'static str, Value)> {
        const WHOLE: [f64; 2] = [0.0, std::f64::consts::TAU];
        let ends = |start: f64, sweep: f64| {
            let is_whole = (sweep.abs() - WHOLE[1]).abs() < 1e-12;
            let end = start + sweep;
            if is_whole { WHOLE } else { [start.min(end), start.max(end)] }
        };
        match path.curves.as_slice() {
            [Curve::Arc { centre, radius, start, sweep }] => {
                self.conic(*centre, [[*radius, 0.0], [0.0, *radius]], ends(*start, *sweep))
            }
            [Curve::Ellipse { centre, major, minor, start, sweep }] => {
                self.conic(*centre, [*major, *minor], ends(*start, *sweep))
            }
            curves if curves.iter().all(|it| matches!(it, Curve::Segment { .. })) => {
                let corners = curves.iter().map(Curve::start_point);
                let last = curves.last().map(Curve::end_point);
                self.points(corners.chain(last))
            }
            curves => {
                let inner = curves.iter().flat_map(|curve| {
                    (0..N_POINTS).map(|k| curve.point(f64::from(k) / f64::from(N_POINTS)))
                });
                self.points(inner.chain(curves.last().map(Curve::end_point)))
            }
        }
    }

    /// centre + cos(p) major + sin(p) minor.
    fn conic(
        &self,
        centre: Point,
        axes: [Point; 2],
        range: [f64; 2],
    ) -> Vec<(&'static str, Value)> {
        let unit = self.mechanism.source.unit().name;
        let centre = self.inward(centre);
        let axes = axes.map(|axis| self.frame.vector_inward(axis).map(|x| self.tidy(x)));
        let component = |i: usize| {
            let [major, minor] = axes.map(|axis| axis[i]);
            Value::from(format!("({} + ({major})*cos(p) + ({minor})*sin(p))*1 {unit}", centre[i]))
        };
        let range = range.map(|end| quantity(end, "rad"));
        vec![
            ("type", Value::from("formula")),
            ("formula", array([component(0), component(1)].into_iter())),
            ("range", array(range.into_iter())),
        ]
    }

    fn points(&self, points: impl Iterator<Item = Point>) -> Vec<(&'static str, Value)> {
        let unit = self.mechanism.source.unit();
        let points = points.map(|at| point_value(self.inward(at), unit));
        vec![("type", Value::from("points")), ("points", array(points))]
    }

    /// A point of the drawing, in drawing units.
    fn inward(&self, at: Point) -> Point {
        let [x, y] = self.frame.point_inward(at);
        self.mechanism.source.scale.tidy([x - self.origin[0], y - self.origin[1]])
    }

    fn tidy(&self, length: f64) -> f64 {
        self.mechanism.source.scale.tidy_length(length)
    }
}
