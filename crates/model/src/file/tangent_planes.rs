//! Contacts in space: planes, and the rows of places that rub in every direction of a tangent plane.

use bksim_expr::Expr;

use super::reader::{Fields, Reader};
use super::tree::Node;
use crate::contact::{ContactPair, Flat, Shape};
use crate::ids::ContactId;
use crate::load::{Load, LoadKind, Opposed};

impl Reader<'_> {
    /// A plane through a point, across the z axis of its frame where no `normal` is given.
    pub(super) fn flat(&mut self, node: &Node, own: &Fields<'_>) -> Option<Shape> {
        let anchor = self.point_of_shape(node, &own.what("plane"), own);
        let [zero, one] = [self.pool.zero(), self.pool.one()];
        let normal = match own.get("normal") {
            Some(node) => {
                let example = "[0, 0, 1] for the direction of z";
                self.unit_vector(node, "normal", own, false, example)?.0
            }
            None => [zero, zero, one],
        };
        Some(Shape::Plane(Flat { anchor: anchor?, normal }))
    }
}

/// The rows of a contact in space: of each place its force, then of each its friction in two directions.
pub(super) fn rows_in_space(
    pair: &ContactPair,
    contact: ContactId,
    restitution: Expr,
    friction: Option<[Expr; 2]>,
) -> Vec<Load> {
    let load = |kind| Load { name: pair.name.clone(), kind, span: pair.span.clone() };
    let touches =
        (0..pair.places.len()).map(|place| load(LoadKind::Touch { contact, place, restitution }));
    let mut rows: Vec<Load> = touches.collect();
    if let Some([sliding, sticking]) = friction {
        let both = (0..pair.tracks.len())
            .flat_map(|track| [Opposed::Slip, Opposed::Across].map(|opposed| (track, opposed)));
        rows.extend(both.map(|(track, opposed)| {
            load(LoadKind::Rub { contact, track, opposed, sliding, sticking })
        }));
    }
    rows
}
