//! [`Rail`]: the straight way of a prismatic joint or of a pin in a slot.

use bksim_mbs::model::JointKind;

use super::flat;
use super::numbers::{Numbers, range};
use super::sizes::Sizes;
use crate::Attached;
use crate::geometry::{Point, add, direction, dot, left, scaled, sub, unit};

/// Half length and half width of a slider without an outline, radii of a pin.
const BLOCK: [f64; 2] = [4.2, 2.7];
/// Half width of a slot, radii of a pin.
pub(super) const SLOT: f64 = 1.15;

/// A guide or slot, in the frame of the predecessor.
pub(super) struct Rail {
    /// The body that has it.
    pub(super) body: usize,
    /// Where positions are counted from.
    pub(super) origin: Point,
    /// Unit vector along it.
    pub(super) along: Point,
    /// Smallest and largest position on it, m.
    pub(super) travel: [f64; 2],
    /// What slides on it lies within these places along and across it, against its position, m.
    pub(super) room: [[f64; 2]; 2],
    /// The joint's point on the slider; none for the pin of a slot.
    pub(super) block: Option<Attached>,
    /// Unit vector along the rail, in the frame of the slider.
    pub(super) block_along: Point,
}

/// By joint.
pub(super) fn rails(numbers: &Numbers, sizes: &Sizes) -> Vec<Option<Rail>> {
    let joints = numbers.model.joints.iter().enumerate();
    let rail = |(joint_idx, joint): (usize, &bksim_mbs::model::Joint)| {
        let angle = match joint.kind {
            JointKind::Prismatic { angle } => Some(numbers.value(angle)),
            JointKind::PinInSlot => None,
            _ => return None,
        };
        let from = numbers.attached(joint.predecessor);
        let along = unit(flat(numbers.vector(&joint.axis)));
        let mut rail = Rail {
            body: from.body,
            origin: flat(from.position),
            along,
            travel: numbers.travel(joint_idx, 0.6 * sizes.length),
            room: [[-SLOT * sizes.pin, SLOT * sizes.pin]; 2],
            block: None,
            block_along: along,
        };
        if let Some(angle) = angle {
            // The slider's frame is turned by the angle: its axes see the rail turned back.
            let [cos, sin] = direction(-angle);
            let block = numbers.attached(joint.successor);
            rail.block = Some(block);
            rail.block_along = [cos * along[0] - sin * along[1], sin * along[0] + cos * along[1]];
            rail.room = outlined(numbers, block, rail.block_along)
                .unwrap_or_else(|| BLOCK.map(|half| [-half * sizes.pin, half * sizes.pin]));
        }
        Some(rail)
    };
    joints.map(rail).collect()
}

impl Rail {
    /// A point of the rail.
    pub(super) fn at(&self, position: f64) -> Point {
        add(self.origin, scaled(position, self.along))
    }

    /// A point beside it, to the left.
    pub(super) fn beside(&self, position: f64, across: f64) -> Point {
        add(self.at(position), scaled(across, left(self.along)))
    }

    /// The positions that anything on it ever covers.
    pub(super) fn covered(&self) -> [f64; 2] {
        [self.travel[0] + self.room[0][0], self.travel[1] + self.room[0][1]]
    }
}

/// How far an outline reaches along and across, from a point of its body.
fn outlined(numbers: &Numbers, at: Attached, along: Point) -> Option<[[f64; 2]; 2]> {
    let rings = numbers.outline(at.body);
    let from_joint = |p: &Point| sub(*p, flat(at.position));
    let reach = |axis: Point| range(rings.iter().flatten().map(|p| dot(from_joint(p), axis)));
    Some([reach(along)?, reach(left(along))?])
}
