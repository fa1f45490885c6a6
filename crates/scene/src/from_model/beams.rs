//! Bodies that bend, as lines through the places of their mass.

use bksim_model::flexible::Flexible;
use bksim_model::{BodyId, JointId, Model};

use super::Sketch;
use crate::{Attached, Span, SpanKind};

/// A model without the parts of which its beams are put together; their bodies stay, without mass.
/// `None` where there are no beams.
pub(super) fn without_parts(model: &Model) -> Option<Model> {
    let beams: Vec<&Flexible> = model.bodies.iter().filter_map(|b| b.flexible.as_ref()).collect();
    if beams.is_empty() {
        return None;
    }
    let shapes: Vec<JointId> = beams.iter().flat_map(|beam| beam.shapes()).collect();
    let names: Vec<&str> = shapes.iter().map(|id| model.joints[id.0].name.as_str()).collect();
    // Parts come after all that the author wrote.
    let is_part = |body: BodyId| {
        let is_held = |beam: &&Flexible| {
            [&beam.masses, &beam.sections].iter().any(|held| held.contains(&body))
                || beam.end == body
        };
        beams.iter().any(is_held)
            || shapes.iter().any(|id| model.joints[id.0].successor.body == body)
    };
    let first = model.joints.iter().position(|joint| is_part(joint.successor.body));
    let mut shown = model.snapshot().to_model();
    shown.joints.truncate(first.unwrap_or(model.joints.len()));
    shown.loads.retain(|load| !names.contains(&load.name.as_str()));
    for (idx, body) in shown.bodies.iter_mut().enumerate() {
        if is_part(BodyId(idx)) {
            body.mass = shown.pool.zero();
        }
        if let Some(beam) = &body.flexible {
            body.points.truncate(beam.n_points);
        }
    }
    Some(shown)
}

impl Sketch<'_> {
    /// Lines along beams.
    pub(super) fn beams(&self) -> Vec<Span> {
        let mut spans = Vec::new();
        for (idx, body) in self.model().bodies.iter().enumerate() {
            let Some(beam) = &body.flexible else { continue };
            let places = beam.masses.iter().chain([&beam.end]).map(|id| id.0);
            let places: Vec<usize> = std::iter::once(idx).chain(places).collect();
            let at = |body: usize| Attached { body, position: [0.0; 3] };
            spans.extend(places.windows(2).map(|pair| Span {
                name: body.name.clone(),
                ends: [at(pair[0]), at(pair[1])],
                kind: SpanKind::Link,
            }));
        }
        spans
    }
}
