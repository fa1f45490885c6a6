//! Circles on the layer of joints, named by the texts next to them.

use super::Gathering;
use crate::attachment::{Attachment, Content, Value, Way};
use crate::drawing::{Drawing, Entity, Shape};
use crate::geometry::vector::distance;
use crate::geometry::{Curve, Point};
use crate::kind::{self, JOINT_LAYER};

/// A text further away from the centre than this many radii names nothing.
const REACH: f64 = 4.0;

impl Gathering<'_> {
    /// Every circle of the layer is a revolute. Circles with extended data say themselves what they
    /// are.
    pub(super) fn read_joint_layer(&mut self, drawing: &Drawing) {
        let revolute = kind::by_name("revolute").expect("revolutes are a kind of attachment");

        // Entities of the layer, and the texts among them.
        let on_layer: Vec<(usize, &Entity)> = drawing
            .entities
            .iter()
            .enumerate()
            .filter(|(_, entity)| entity.location.layer.eq_ignore_ascii_case(JOINT_LAYER))
            .collect();
        let texts: Vec<(&Entity, Point, &str)> = on_layer
            .iter()
            .filter_map(|(_, entity)| match &entity.shape {
                Shape::Text { at, text } => Some((*entity, *at, text.trim())),
                _ => None,
            })
            .filter(|(_, _, text)| !text.is_empty())
            .collect();

        // Circles, each with the nearest text for its name.
        for (entity_idx, entity) in on_layer {
            let (Some((centre, radius)), true) = (circle(entity), entity.xdata.is_empty()) else {
                continue;
            };
            let named = texts
                .iter()
                .map(|(label, at, text)| (distance(*at, centre), label, text))
                .filter(|(away, ..)| *away <= REACH * radius)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let name = named.map(|(_, label, text)| Value {
                key: "name",
                content: Content::Text((*text).to_owned()),
                location: label.location.clone(),
            });
            self.attachments.push(Attachment {
                kind: revolute,
                entity_idx,
                location: entity.location.clone(),
                way: Way::Layer,
                values: name.into_iter().collect(),
                at: Some(centre),
                axis: None,
                to: None,
            });
        }
    }
}

/// Centre and radius of a whole circle.
fn circle(entity: &Entity) -> Option<(Point, f64)> {
    let Shape::Path(path) = &entity.shape else { return None };
    match path.curves.as_slice() {
        [Curve::Arc { centre, radius, .. }] if path.is_closed => Some((*centre, *radius)),
        _ => None,
    }
}
