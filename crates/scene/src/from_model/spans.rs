//! Springs, dampers and massless links.

use bksim_model::{Anchor, JointKind, LoadKind};

use super::Sketch;
use crate::{Span, SpanKind};

impl Sketch<'_> {
    /// The springs, dampers and links between two bodies.
    pub(super) fn spans(&self) -> Vec<Span> {
        let mut spans = Vec::new();
        let mut span = |name: &str, ends: [Anchor; 2], kind| {
            let ends = ends.map(|anchor| self.numbers.attached(anchor));
            spans.push(Span { name: name.to_owned(), ends, kind });
        };
        for joint in &self.model().joints {
            if let JointKind::Link { .. } = joint.kind {
                span(&joint.name, [joint.predecessor, joint.successor], SpanKind::Link);
            }
        }
        let pool = &self.model().pool;
        for load in &self.model().loads {
            let LoadKind::Spring { a, b, stiffness, length, damping } = load.kind else { continue };
            let kind = if pool.is_zero(stiffness) {
                SpanKind::Damper { length: self.first_distance([a, b]) }
            } else {
                let length = self.numbers.value(length);
                SpanKind::Spring { length, is_damped: !pool.is_zero(damping) }
            };
            span(&load.name, [a, b], kind);
        }
        spans
    }

    /// Distance of two points at the start; 15 pin radii when the motion is not known.
    fn first_distance(&self, ends: [Anchor; 2]) -> f64 {
        let [a, b] = ends.map(|anchor| self.numbers.attached(anchor));
        let first = self.numbers.vectors(a, b).next().map(|[x, y, z]| x.hypot(y).hypot(z));
        first.unwrap_or(15.0 * self.pin)
    }
}
