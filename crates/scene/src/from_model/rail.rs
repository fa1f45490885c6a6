//! [`Rail`]: the straight path of a prismatic joint, of a cylindrical one on a body that moves, or of a pin in a slot.

use bksim_model::{GROUND, Joint, Space};

use super::looks::{Look, OnRail};
use super::numbers::{Numbers, range};
use super::sizes::SymbolSizes;
use crate::geometry::{Plane, Point, across3, cross3, direction, length3, sub3, unit3};

/// Half length and half width of a slider without an outline, radii of a pin.
const BLOCK: [f64; 2] = [4.2, 2.7];
/// Half width of a slot, radii of a pin.
pub(super) const SLOT: f64 = 1.15;

/// A guide or slot.
pub(super) struct Rail {
    /// The body that has it.
    pub(super) body: usize,
    /// In the frame of that body: the zero of positions, axes along the rail and across.
    pub(super) plane: Plane,
    /// Smallest and largest position on it, m.
    pub(super) travel: [f64; 2],
    /// Extent of the sliding part along the rail and across, relative to its position, m.
    pub(super) extent: [[f64; 2]; 2],
    /// The body that slides, if it is more than a pin.
    pub(super) slider: Option<Slider>,
}

/// The body that slides on a rail.
#[derive(Clone, Copy)]
pub(super) struct Slider {
    pub(super) body: usize,
    /// In the frame of that body: the joint's point, axes along the rail and across.
    pub(super) plane: Plane,
}

/// The rails of a model, by joint.
pub(super) fn rails(
    numbers: &Numbers,
    sizes: &SymbolSizes,
    attached: &[Vec<[f64; 3]>],
) -> Vec<Option<Rail>> {
    let joints = numbers.model.joints.iter().enumerate();
    joints.map(|(joint_idx, joint)| rail(numbers, sizes, attached, joint_idx, joint)).collect()
}

fn rail(
    numbers: &Numbers,
    sizes: &SymbolSizes,
    attached: &[Vec<[f64; 3]>],
    joint_idx: usize,
    joint: &Joint,
) -> Option<Rail> {
    let angle = match Look::of(joint.kind).rail? {
        OnRail::Pin => None,
        // A shaft in a bearing of the ground has the sign of a bearing alone.
        OnRail::Shaft if joint.predecessor.body == GROUND => return None,
        OnRail::Shaft => Some(0.0),
        OnRail::Block => Some(joint.kind.kept_angle().map_or(0.0, |angle| numbers.value(angle))),
    };
    // The guide, on the first body; at first with room for a pin alone.
    let from = numbers.attached(joint.predecessor);
    let [[along, across], second] = axes(numbers, joint, angle.unwrap_or(0.0));
    let travel = numbers.travel(joint_idx, 0.6 * sizes.length);
    let pin = SLOT * sizes.pin;
    let mut rail = Rail {
        body: from.body,
        plane: Plane { origin: from.position, u: along, v: across },
        travel,
        extent: [[-pin, pin]; 2],
        slider: None,
    };
    if angle.is_some() {
        let at = numbers.attached(joint.successor);
        let plane = Plane { origin: at.position, u: second[0], v: second[1] };
        rail.slider = Some(Slider { body: at.body, plane });

        // Room for its outline; in space without one, for a box as wide as the points on its sides.
        let reach = if numbers.model.space == Space::Planar {
            0.0
        } else {
            let points = attached[at.body].iter().map(|&p| sub3(p, at.position));
            points.map(|p| length3(cross3(plane.u, p))).fold(0.0, f64::max)
        };
        rail.extent = outlined(numbers, at.body, &plane).unwrap_or_else(|| {
            let [long, wide] = BLOCK.map(|half| half * sizes.pin);
            let fit = if reach > 0.0 { (reach / wide).clamp(0.6, 2.0) } else { 1.0 };
            [long, wide].map(|half| [-fit * half, fit * half])
        });
    }
    Some(rail)
}

/// Unit vectors along a slide and across it, in the frame of the body with the guide and in that of the other one.
fn axes(numbers: &Numbers, joint: &Joint, angle: f64) -> [[[f64; 3]; 2]; 2] {
    let along = unit3(numbers.vector(&joint.axis)).unwrap_or([1.0, 0.0, 0.0]);
    let axes = [along, across3(along, [0.0, 0.0, 1.0])];
    // The slider's frame is turned by the angle about z: its axes see the rail turned back.
    let [cos, sin] = direction(-angle);
    let turned = |[x, y, z]: [f64; 3]| [cos * x - sin * y, sin * x + cos * y, z];
    [
        axes.map(|axis| numbers.on_anchor(joint.predecessor, axis)),
        axes.map(|axis| numbers.on_anchor(joint.successor, turned(axis))),
    ]
}

impl Rail {
    /// A point of the rail.
    pub(super) fn at(&self, position: f64) -> [f64; 3] {
        self.plane.lift([position, 0.0])
    }

    /// Smallest and largest position that the sliding part covers over the motion.
    pub(super) fn covered(&self) -> [f64; 2] {
        [self.travel[0] + self.extent[0][0], self.travel[1] + self.extent[0][1]]
    }
}

/// Extent of a body's outline along the axes of a plane.
fn outlined(numbers: &Numbers, body: usize, plane: &Plane) -> Option<[[f64; 2]; 2]> {
    let rings = numbers.outline(body);
    let feet: Vec<Point> = rings.iter().flatten().map(|&[x, y]| plane.foot([x, y, 0.0])).collect();
    let reach = |axis: usize| range(feet.iter().map(|foot| foot[axis]));
    Some([reach(0)?, reach(1)?])
}
