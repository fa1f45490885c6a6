//! `[ground]` and `[bodies]`: masses, points and outlines in the frames of the bodies.

use toml_edit::{InlineTable, Value};

use super::Mechanism;
use crate::attachment::Content;
use crate::compose::bodies::{Body, GROUND};
use crate::compose::draft::{Draft, array, point_value, written};
use crate::compose::frame::Frame;
use crate::compose::lengths::coordinate;
use crate::compose::points::Points;
use crate::compose::report::BodyReport;
use crate::compose::source::Source;
use crate::compose::weigh::Weight;
use crate::drawing::Location;
use crate::geometry::Point;

/// The points of the ground, then every body; `weights` are those of all bodies but the ground.
pub(in crate::compose) fn bodies(
    mechanism: &Mechanism<'_>,
    points: &Points,
    weights: Vec<Weight>,
) -> (Draft, Vec<BodyReport>) {
    let mut draft = Draft::default();
    put_points(&mut draft, mechanism, points, GROUND, ["ground", ""]);
    let mut reports = Vec::with_capacity(weights.len());
    let bodies = mechanism.bodies.list.iter().enumerate().skip(1);
    for ((body_idx, body), weight) in bodies.zip(weights) {
        let frame = mechanism.frames[body_idx];
        put_mass(&mut draft, mechanism.source, body, &frame, &weight);
        put_points(&mut draft, mechanism, points, body_idx, ["bodies", &body.name]);
        put_outline(&mut draft, mechanism.source, body, &frame);
        reports.push(BodyReport {
            name: body.name.clone(),
            source: weight.source,
            mass: weight.mass,
            centre: weight.centre,
            area: weight.area,
            frame,
            paths: body.paths.iter().map(|(path, _)| path.clone()).collect(),
            location: body.location().clone(),
        });
    }
    (draft, reports)
}

/// Mass, centre of mass and inertia, and the other keys that are stated.
fn put_mass(draft: &mut Draft, source: Source<'_>, body: &Body, frame: &Frame, weight: &Weight) {
    let (unit, location) = (source.unit(), body.location());
    let mut put = |key: &str, value: Value, location: &Location| {
        draft.put(["bodies", &body.name, key], value, location);
    };
    let mass_key = if body.value("mass").is_some() { "mass" } else { "density" };
    let mass_location = body.value(mass_key).map_or(location, |value| &value.location);

    // A body without a mass has a fault, and the drawing no text.
    let stated = body.value("mass").map(|value| written("mass", &value.content, unit));
    if let Some(mass) = stated.or(weight.mass.as_deref().map(Value::from)) {
        put("mass", mass, mass_location);
    }
    let com = source.scale.tidy(frame.point_inward(weight.centre));
    if com != [0.0; 2] {
        put("com", point_value(com, unit), location);
    }

    if let Some(value) = body.value("inertia") {
        let inertia = written("inertia", &value.content, unit);
        let inertia = match body.value("about").map(|about| &about.content) {
            Some(Content::Text(point)) => {
                let pairs = [("value", inertia), ("about", Value::from(point.as_str()))];
                Value::from(pairs.into_iter().collect::<InlineTable>())
            }
            _ => inertia,
        };
        put("inertia", inertia, &value.location);
    } else if let Some(inertia) = &weight.inertia {
        put("inertia", Value::from(inertia.as_str()), mass_location);
    }

    for key in ["coordinates", "free"] {
        if let Some(value) = body.value(key) {
            put(key, written(key, &value.content, unit), &value.location);
        }
    }
}

/// The named points of a body, in its frame.
fn put_points(
    draft: &mut Draft,
    mechanism: &Mechanism<'_>,
    points: &Points,
    body_idx: usize,
    owner: [&str; 2],
) {
    let (source, frame) = (mechanism.source, mechanism.frames[body_idx]);
    for point in points.of(body_idx) {
        let at = source.scale.tidy(frame.point_inward(point.at));
        let unit = source.unit().name;
        let along = |axis: usize| {
            coordinate(mechanism.lengths.position(body_idx, &point.name, axis), at[axis], unit)
        };
        draft.point(owner, &point.name, array([0, 1].map(along).into_iter()), &point.location);
    }
}

/// The outer outlines as polygons: for pictures only, what they weigh is stated.
fn put_outline(draft: &mut Draft, source: Source<'_>, body: &Body, frame: &Frame) {
    let Some(outline) = &body.outline else { return };
    let (scale, unit) = (source.scale, source.unit());
    let inward = |corner: &Point| point_value(scale.coarse(frame.point_inward(*corner)), unit);
    let polygons: Vec<Value> = outline
        .loops
        .iter()
        .filter(|part| !part.is_hole)
        .map(|part| part.path.flattened(scale.picture_tolerance))
        .filter(|corners| corners.len() > 3)
        // The first corner comes again as the last.
        .map(|corners| array(corners[1..].iter().map(inward)))
        .collect();
    if !polygons.is_empty() {
        let value = array(polygons.into_iter());
        draft.put(["bodies", &body.name, "outline"], value, body.location());
    }
}
