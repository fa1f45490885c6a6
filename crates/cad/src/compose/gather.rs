//! Which entities belong to which body: by layer, by extended data, or by an insert inside of an
//! outline.

use std::collections::{BTreeMap, BTreeSet};

use bksim_model::diagnostic::Diagnostic;

use super::bodies::{Bodies, Body, GROUND};
use super::enclosed::take_enclosing_outlines;
use super::faults::Faults;
use super::frame::Frame;
use super::marks::marks;
use super::outlines::close_outlines;
use super::points::Points;
use super::sidecar::Sidecar;
use super::source::Source;
use crate::attachment::{Attachment, Value, Way, find};
use crate::codes;
use crate::drawing::{Location, Shape};
use crate::geometry::Point;
use crate::kind::{BODY_LAYER, GROUND_LAYER, Section};

/// The bodies of a drawing before anything joins them.
pub(super) struct Gathered {
    /// With geometry, values, outlines, and what is marked on them.
    pub(super) bodies: Bodies,
    /// The points that are named on them.
    pub(super) points: Points,
}

/// Gathers bodies and the ground from layers, records and inserts.
pub(super) fn gather(source: Source<'_>, sidecar: &Sidecar, faults: &mut Faults<'_>) -> Gathered {
    let mut bodies = Bodies::new(source.drawing.entities.len());
    take_layers(source, &mut bodies);
    let inserts = take_attached(source, &mut bodies, faults);
    for body in bodies.list.iter_mut().skip(1) {
        override_values(body, sidecar);
    }
    take_enclosing_outlines(source, &mut bodies, &inserts, faults);
    close_outlines(source, &mut bodies, faults);
    let points = marks(source, &mut bodies, faults);
    Gathered { bodies, points }
}

/// Gives the entities on layers of bodies and of the ground to these.
fn take_layers(source: Source<'_>, bodies: &mut Bodies) {
    // What an entity says itself comes before its layer.
    let says_body = |attachment: &&Attachment| {
        let section = attachment.kind.section;
        matches!(attachment.way, Way::Xdata(_))
            && matches!(section, Section::Bodies | Section::Ground)
    };
    let with_record: BTreeSet<usize> =
        source.attachments.iter().filter(says_body).map(|it| it.entity_idx).collect();

    for (entity_idx, entity) in source.drawing.entities.iter().enumerate() {
        let layer = entity.location.layer.as_str();
        let head = layer.get(..BODY_LAYER.len()).unwrap_or_default();
        if matches!(entity.shape, Shape::Insert(_)) || with_record.contains(&entity_idx) {
            continue;
        }
        if layer.eq_ignore_ascii_case(GROUND_LAYER) {
            bodies.own(GROUND, entity_idx, source.drawing);
        } else if head.eq_ignore_ascii_case(BODY_LAYER) && layer.len() > head.len() {
            // Layers that differ in case alone are one layer.
            let name = &layer[head.len()..];
            let known = bodies.list.iter().find(|body| body.name.eq_ignore_ascii_case(name));
            let name = known.map_or(name, |body| &body.name).to_owned();
            let body_idx = bodies.named_or_new(&name, &entity.location);
            bodies.own(body_idx, entity_idx, source.drawing);
        }
    }
}

/// Takes records of bodies and of the ground, and inserts of `BK_BODY`; returns where the inserts
/// are, by body.
fn take_attached(
    source: Source<'_>,
    bodies: &mut Bodies,
    faults: &mut Faults<'_>,
) -> BTreeMap<usize, Point> {
    let mut inserts = Inserts::default();
    for attachment in source.attachments {
        match attachment.kind.section {
            Section::Bodies => take_body(source, bodies, &mut inserts, attachment, faults),
            Section::Ground => {
                if let Way::Xdata(_) = attachment.way {
                    bodies.own(GROUND, attachment.entity_idx, source.drawing);
                }
                bodies.list[GROUND].features.extend(attachment.at);
                bodies.list[GROUND].marks.extend(attachment.at);
            }
            _ => (),
        }
    }
    inserts.points
}

/// The inserts of `BK_BODY`, by body.
#[derive(Default)]
struct Inserts {
    /// The last one met.
    locations: BTreeMap<usize, Location>,
    /// Where the first one is.
    points: BTreeMap<usize, Point>,
}

/// Takes a record or an insert that names a body.
fn take_body(
    source: Source<'_>,
    bodies: &mut Bodies,
    inserts: &mut Inserts,
    attachment: &Attachment,
    faults: &mut Faults<'_>,
) {
    let name = match attachment.text("name") {
        Some("ground") => {
            let message = "a body cannot be called `ground`";
            let help = "what does not move is on the layer BK_GROUND, or BK_GROUND stands there";
            let fault = Diagnostic::error(codes::NO_NAME, message).help(help);
            return faults.add(fault, &attachment.location);
        }
        Some(name) => name,
        None => return faults.add_nameless("a body", attachment),
    };
    let body_idx = bodies.named_or_new(name, &attachment.location);

    // An insert marks a body, of which there is one; a record stands on any number of its entities.
    if attachment.way == Way::Block {
        let location = attachment.location.clone();
        if let Some(other) = inserts.locations.insert(body_idx, location) {
            let message = format!("two bodies are called `{name}`");
            let help = "give each BK_BODY a name of its own";
            return faults.add_duplicate(&message, help, [&attachment.location, &other]);
        }
    } else {
        bodies.own(body_idx, attachment.entity_idx, source.drawing);
    }

    let body = &mut bodies.list[body_idx];
    for value in attachment.values.iter().filter(|value| value.key != "name") {
        state(body, value, faults);
    }
    match (attachment.way, attachment.at, attachment.axis) {
        (Way::Block, Some(at), _) => {
            inserts.points.insert(body_idx, at);
        }
        // The natural point of an outline alone says nothing of a frame.
        (_, Some(at), Some(axis)) => body.frame = Some(Frame::along(at, axis)),
        _ => (),
    }
}

/// Adds a stated value to a body, unless it states another one already.
fn state(body: &mut Body, value: &Value, faults: &mut Faults<'_>) {
    let Some(known) = body.value(value.key) else {
        body.values.push(value.clone());
        return;
    };
    if known.content != value.content {
        let message = format!("body `{}` has two values of `{}`", body.name, value.key);
        let help = "state it once; `bksim cad list` shows where everything is attached";
        faults.add_duplicate(&message, help, [&value.location, &known.location]);
    }
}

/// Puts the keys of a body in the sidecar before those in the drawing.
fn override_values(body: &mut Body, sidecar: &Sidecar) {
    let mut stated = sidecar.body_values(&body.name, body.location());
    // A mass there is meant instead of a density here, and the other way round.
    let [by_mass, by_density] = ["mass", "density"].map(|key| find(&stated, key).is_some());
    let is_replaced = |key: &str| match key {
        "mass" => by_density,
        "density" | "thickness" => by_mass && !by_density,
        _ => false,
    };
    let mut kept = std::mem::take(&mut body.values);
    kept.retain(|value| find(&stated, value.key).is_none() && !is_replaced(value.key));
    stated.extend(kept);
    body.values = stated;
}
