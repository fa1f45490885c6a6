//! Axes of joints: directions in the frames of their two points, as unit vectors.

use bksim_expr::Expr;

use super::bodies::Position;
use super::codes;
use super::reader::{Fields, Reader};
use super::tree::Node;
use super::units::Quantity;
use super::value::Scope;
use crate::body::FixedTurn;
use crate::diagnostic::Diagnostic;
use crate::ids::Vector;
use crate::joint::JointType;
use crate::message::short;

/// The types whose `second` is an axis of its own, perpendicular to the first.
const SKEW_TYPES: [&str; 2] = ["universal", "perpendicular-axes"];

/// Largest cosine of two axes that are taken as perpendicular, and sine of two that are taken as parallel.
const SKEW: f64 = 1e-9;

impl Reader<'_> {
    /// The unit vector of the joint, in the frame of its first body.
    pub(super) fn joint_axis(&mut self, word: &str, fields: &Fields<'_>) -> Option<Vector> {
        let z = [self.pool.zero(), self.pool.zero(), self.pool.one()];
        let slides = matches!(word, "prismatic" | "slot" | "line-on-curve" | "knife-edge");
        if slides && fields.conflict(self, "axis", "direction") {
            return None;
        }
        if let Some(node) = fields.get("direction") {
            let what = fields.what("direction");
            let angle = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?.expr;
            return Some([self.pool.cos(angle), self.pool.sin(angle), self.pool.zero()]);
        }
        let Some(node) = fields.get("axis") else {
            if slides && !fields.has("direction") {
                let help = "write for example `axis = [1, 0]` or `direction = \"30 deg\"`";
                fields.require(self, "axis", help)?;
            }
            return Some(z);
        };
        let bends = !slides && JointType::of_word(word).is_some_and(|of| of.is_in_plane);
        let help = if slides {
            "[1, 0] for the direction of x"
        } else {
            "[0, 0, 1] for the direction of z"
        };
        let (unit, written) = self.unit_vector(node, "axis", fields, bends, help)?;
        if word == "line-on-curve" && !self.pool.is_zero(unit[2]) {
            let message = format!("`axis` of {} is not perpendicular to z", fields.owner);
            let across = match written {
                [0.0, 0.0, _] => "[1, 0, 0]".to_owned(),
                [x, y, _] => format!("[{}, {}, 0]", short(x), short(y)),
            };
            self.report(
                Diagnostic::error(codes::NOT_PERPENDICULAR, message)
                    .at(node.span.clone(), "must be perpendicular")
                    .note("the face that touches the curve lies along this axis and z")
                    .help(format!("write for example {across}")),
            );
            return None;
        }
        Some(unit)
    }

    /// The turns that bring the axis of the first body to the direction that `second` says in the frame of the second:
    /// one by the angle between them, about the normal of both.
    pub(super) fn alignment(&mut self, word: &str, fields: &Fields<'_>) -> Option<Vec<FixedTurn>> {
        let Some(node) = fields.get("second").filter(|_| !SKEW_TYPES.contains(&word)) else {
            return Some(Vec::new());
        };
        if fields.conflict(self, "second", "angle") {
            return None;
        }
        let bends = word == "revolute";
        let example = "[0, 0, 1] for the direction of z";
        let (to, to_value) = self.unit_vector(node, "second", fields, bends, example)?;
        let from = self.joint_axis(word, fields)?;
        let from_value = self.axis_numbers(fields)?;
        let pool = &self.pool;
        let minor = |i: usize, j: usize| {
            let [a, b] = [pool.mul(from[i], to[j]), pool.mul(from[j], to[i])];
            (pool.sub(a, b), from_value[i] * to_value[j] - from_value[j] * to_value[i])
        };
        let normal = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let (normal, value) = (normal.map(|part| part.0), normal.map(|part| part.1));
        let products = (0..3).map(|i| pool.mul(from[i], to[i]));
        let cosine = pool.sum(products.collect::<Vec<_>>());
        let along: f64 = (0..3).map(|i| from_value[i] * to_value[i]).sum();
        let size = |v: [f64; 3]| v.iter().map(|part| part * part).sum::<f64>().sqrt();
        let turn = if size(value) > SKEW * size(from_value) * size(to_value) {
            let squares: Vec<Expr> = normal.iter().map(|&part| pool.powi(part, 2)).collect();
            let sine = pool.sqrt(self.total(&squares));
            FixedTurn { axis: self.normalised(&normal, &value), angle: pool.atan2(sine, cosine) }
        } else if along < 0.0 {
            // Opposite directions: half a turn about any normal, that of the largest right angle.
            let least =
                (0..3).min_by(|&i, &j| from_value[i].abs().total_cmp(&from_value[j].abs()))?;
            let (i, j) = ((least + 1) % 3, (least + 2) % 3);
            let mut across = [pool.zero(); 3];
            let mut value = [0.0; 3];
            (across[i], across[j]) = (from[j], pool.neg(from[i]));
            (value[i], value[j]) = (from_value[j], -from_value[i]);
            FixedTurn { axis: self.normalised(&across, &value), angle: pool.pi() }
        } else {
            return Some(Vec::new());
        };
        self.leave_plane(&[turn], &node.span);
        Some(vec![turn])
    }

    /// The direction of the axis on the first body as numbers.
    fn axis_numbers(&mut self, fields: &Fields<'_>) -> Option<[f64; 3]> {
        if let Some(node) = fields.get("direction") {
            let what = fields.what("direction");
            let angle = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?.value?;
            let (sin, cos) = self.constants.pinned(angle).sin_cos();
            return Some([cos, sin, 0.0]);
        }
        let Some(node) = fields.get("axis") else { return Some([0.0, 0.0, 1.0]) };
        let vector = self.vector(node, Quantity::NUMBER, &fields.what("axis"), Scope::Constant)?;
        Some(vector.position.as_ref().map_or([0.0; 3], Position::numbers))
    }

    /// The unit vector of the second body, perpendicular to the axis of the first one; both have their
    /// components in the frames of the two points, which coincide before any motion.
    pub(super) fn second_axis(&mut self, fields: &Fields<'_>) -> Option<Vector> {
        let help = "write for example `axis = [1, 0, 0]` and `second = [0, 1, 0]`";
        let node = fields.require(self, "second", help)?;
        let example = "[0, 1, 0] for the direction of y";
        let (unit, second) = self.unit_vector(node, "second", fields, false, example)?;
        let first = match fields.get("axis") {
            Some(node) => {
                let example = "[0, 0, 1] for the direction of z";
                self.unit_vector(node, "axis", fields, false, example)?.1
            }
            None => [0.0, 0.0, 1.0],
        };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cosine = dot(first, second) / (dot(first, first) * dot(second, second)).sqrt();
        if cosine.abs() > SKEW {
            let degrees = cosine.clamp(-1.0, 1.0).acos().to_degrees();
            let message = format!(
                "`second` of {} is not perpendicular to its `axis`: the angle is {} deg",
                fields.owner,
                short(degrees)
            );
            // The part of the second axis across the first one.
            let part = dot(first, second) / dot(first, first);
            let across = [0, 1, 2].map(|i| short(second[i] - part * first[i]));
            let help = if cosine.abs() > 1.0 - SKEW {
                "write a direction across the axis".to_owned()
            } else {
                format!("write for example [{}]", across.join(", "))
            };
            self.report(
                Diagnostic::error(codes::NOT_PERPENDICULAR, message)
                    .at(node.span.clone(), "must be perpendicular")
                    .help(help),
            );
            return None;
        }
        Some(unit)
    }

    /// A vector of length one, and the vector as written; `bends` says that it leaves the plane unless
    /// it is along z.
    pub(super) fn unit_vector(
        &mut self,
        node: &Node,
        key: &str,
        fields: &Fields<'_>,
        bends: bool,
        example: &str,
    ) -> Option<(Vector, [f64; 3])> {
        // A rotation axis along z is planar, whatever the length of its z part.
        let spatial = self.spatial.clone();
        let vector = self.vector(node, Quantity::NUMBER, &fields.what(key), Scope::Constant)?;
        if bends {
            let [x, y, _] = vector.components;
            let leaves_plane = !self.pool.is_zero(x) || !self.pool.is_zero(y);
            self.spatial = spatial.or(leaves_plane.then(|| vector.span.clone()));
        }
        let value = vector.position.as_ref().map_or([0.0; 3], Position::numbers);
        // Its sign, or length, is in the equations.
        for &part in vector.position.iter().flat_map(|position| &position.value) {
            self.constants.pinned_sign(part);
        }
        if value == [0.0; 3] {
            let message =
                format!("`{key}` of {} has no direction: all its parts are 0", fields.owner);
            self.report(
                Diagnostic::error(codes::NO_DIRECTION, message)
                    .at(node.span.clone(), "no direction")
                    .help(format!("write for example {example}")),
            );
            return None;
        }
        Some((self.normalised(&vector.components, &value), value))
    }

    /// The vector divided by its length; exact where it lies along an axis of the frame.
    pub(super) fn normalised(&self, components: &Vector, value: &[f64; 3]) -> Vector {
        let pool = &self.pool;
        let along: Vec<usize> = (0..3).filter(|&i| !pool.is_zero(components[i])).collect();
        if let [axis] = along.as_slice() {
            let mut unit = [pool.zero(); 3];
            unit[*axis] = pool.int(if value[*axis] < 0.0 { -1 } else { 1 });
            return unit;
        }
        let squares: Vec<Expr> = components.iter().map(|&c| pool.powi(c, 2)).collect();
        let length = pool.sqrt(self.total(&squares));
        components.map(|c| pool.div(c, length))
    }
}
