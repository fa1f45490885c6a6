//! Springs, dampers and links between two points, as lines.

use crate::{Role, Span, SpanKind};

impl Span {
    /// Its lines when its ends are at these points of the world, and what they stand for.
    pub fn lines(&self, ends: [[f64; 3]; 2], _pin: f64) -> Vec<(Role, Vec<[f64; 3]>)> {
        let role = match self.kind {
            SpanKind::Spring { .. } => Role::Spring,
            SpanKind::Damper { .. } => Role::Damper,
            SpanKind::Link => Role::Link,
        };
        vec![(role, ends.to_vec())]
    }
}
