//! Positions and orientations of elements.

use crate::codes;
use crate::spatial::{Pose, Rotation, Vector, cross, dot, scale, sub, unit};
use crate::xml::{Attribute, NodeId};

use super::Reader;
use super::defaults::ClassId;

/// The attributes that state an orientation.
const WORDS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

impl Reader<'_, '_> {
    /// The pose that an element states.
    pub(super) fn pose(&mut self, node: NodeId, class: ClassId) -> Pose {
        let at = self.vector(node, class, "pos").unwrap_or([0.0; 3]);
        Pose { at, turn: self.orientation(node, class) }
    }

    /// The orientation that an element states, or else its class.
    pub(super) fn orientation(&mut self, node: NodeId, class: ClassId) -> Rotation {
        let tag = self.tree.tag(node).to_owned();
        let of = |id: NodeId| WORDS.iter().find_map(|word| self.tree.attribute(id, word));
        let found = of(node).or_else(|| {
            let chain = self.defaults.chain(class);
            chain
                .flat_map(|class| self.defaults.own(&self.tree, class, &tag).collect::<Vec<_>>())
                .find_map(of)
        });
        match found.cloned() {
            Some(found) => self.turn(&found),
            None => Rotation::NONE,
        }
    }

    fn turn(&mut self, of: &Attribute) -> Rotation {
        let what = format!("`{}`", of.name);
        let turn = match of.name.as_str() {
            "quat" => {
                self.job.exactly::<4>(&of.value, &of.place, &what).map(Rotation::of_quaternion)
            }
            "axisangle" => {
                self.job.exactly::<4>(&of.value, &of.place, &what).map(|[x, y, z, angle]| {
                    unit([x, y, z]).map(|axis| Rotation::about(axis, self.radians(angle)))
                })
            }
            "xyaxes" => {
                self.job.exactly::<6>(&of.value, &of.place, &what).map(|[a, b, c, d, e, f]| {
                    let x = unit([a, b, c])?;
                    let y = unit(sub([d, e, f], scale(dot(x, [d, e, f]), x)))?;
                    Some(Rotation::of_axes([x, y, cross(x, y)]))
                })
            }
            "zaxis" => self
                .job
                .exactly::<3>(&of.value, &of.place, &what)
                .map(|axis| unit(axis).map(Rotation::z_to)),
            _ => self
                .job
                .exactly::<3>(&of.value, &of.place, &what)
                .map(|angles| Some(self.euler(angles))),
        };
        match turn {
            Some(Some(turn)) => turn,
            Some(None) => {
                let message = format!("{what} has no direction");
                let help = "write axes and quaternions of a length above zero";
                self.job.error(codes::NOT_A_NUMBER, message, (&of.place, ""), help);
                Rotation::NONE
            }
            None => Rotation::NONE,
        }
    }

    /// Small letters turn about axes that turn along, capitals about fixed ones.
    fn euler(&self, angles: Vector) -> Rotation {
        let axes = [('x', [1.0, 0.0, 0.0]), ('y', [0.0, 1.0, 0.0]), ('z', [0.0, 0.0, 1.0])];
        let mut turn = Rotation::NONE;
        for (letter, angle) in self.compiler.euler.iter().zip(angles) {
            let axis = axes.iter().find(|(known, _)| *known == letter.to_ascii_lowercase());
            let Some((_, axis)) = axis else { continue };
            let step = Rotation::about(*axis, self.radians(angle));
            turn = if letter.is_ascii_lowercase() { turn.then(step) } else { step.then(turn) };
        }
        turn
    }
}
