//! Frames of points: where a point of a body is, and how its axes lie against those of the body.
//!
//! ```text
//! rpy = [a, b, c]        Rz(c) Ry(b) Rx(a): turns about the fixed axes x, y, z, in this order
//! quaternion = [w, x, y, z]   cos(θ/2), sin(θ/2) n: a turn by θ about n
//! x = [..], y = [..]     two axes of the frame; the third completes a right-handed one
//! ```

use bksim_expr::{Expr, Pool};

use super::bodies::Position;
use super::codes;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::FixedTurn;
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::Vector;
use crate::message::short;

/// Keys of a frame.
pub(super) const FRAME_KEYS: [&str; 6] = ["at", "rpy", "quaternion", "x", "y", "z"];

/// The frame of a point as it is written.
#[derive(Default)]
pub(super) struct WrittenFrame<'n> {
    /// Position of the frame.
    pub(super) at: Option<&'n Node>,
    /// The point of the same body that position and turns are seen from, in place of the body.
    pub(super) from: Option<&'n Node>,
    /// Turns of the frame.
    pub(super) turns: Vec<FixedTurn>,
}

/// Largest error of a unit length or of a right angle, for numbers written with seven digits.
const ROUNDING: f64 = 1e-6;

impl Reader<'_> {
    /// The position of a point and its orientation.
    pub(super) fn frame<'n>(&mut self, node: &'n Node, what: &str) -> WrittenFrame<'n> {
        let Value::Table(table) = &node.value else {
            return WrittenFrame { at: Some(node), ..WrittenFrame::default() };
        };
        let known = [FRAME_KEYS.as_slice(), &["from"]].concat();
        let fields = Fields::open(self, table, what.to_owned(), node.span.clone(), &known);
        let at = fields.require(self, "at", "write for example `at = [\"25 mm\", 0, 0]`");
        WrittenFrame { at, from: fields.get("from"), turns: self.orientation(&fields) }
    }

    /// The orientation of a frame: one of the ways of writing it, or parallel axes.
    pub(super) fn orientation(&mut self, fields: &Fields<'_>) -> Vec<FixedTurn> {
        // One way of writing the orientation.
        let axes: Vec<&str> = ["x", "y", "z"].into_iter().filter(|key| fields.has(key)).collect();
        let ways = [Some("rpy"), Some("quaternion"), axes.first().copied()];
        let ways: Vec<&str> = ways.into_iter().flatten().filter(|key| fields.has(key)).collect();
        if let [one, other, ..] = ways[..] {
            fields.conflict(self, one, other);
            return Vec::new();
        }
        let turns = match (ways.first(), fields.get("rpy"), fields.get("quaternion")) {
            (_, Some(node), _) => self.roll_pitch_yaw(node, fields),
            (_, _, Some(node)) => self.quaternion(node, fields),
            (Some(_), ..) => self.two_axes(&axes, fields),
            _ => Some(Vec::new()),
        };
        let turns = turns.unwrap_or_default();
        self.leave_plane(&turns, &fields.span);
        turns
    }

    /// Notes that turns are not those of a planar model: a turn about z alone stays in the plane.
    pub(super) fn leave_plane(&mut self, turns: &[FixedTurn], span: &Span) {
        let [zero, one] = [self.pool.zero(), self.pool.one()];
        let z = [[zero, zero, one], [zero, zero, self.pool.neg(one)]];
        if turns.iter().any(|turn| !z.contains(&turn.axis)) && self.spatial.is_none() {
            self.spatial = Some(span.clone());
        }
    }

    pub(super) fn roll_pitch_yaw(
        &mut self,
        node: &Node,
        fields: &Fields<'_>,
    ) -> Option<Vec<FixedTurn>> {
        let what = fields.what("rpy");
        let example = "[\"90 deg\", 0, 0]";
        let values = self.array(node, &what, "[roll, pitch, yaw]", example)?;
        let [roll, pitch, yaw] = values else {
            let help = format!("for example {example}");
            self.wrong_kind(node, &what, "[roll, pitch, yaw]", &node.value, &help);
            return None;
        };
        let angles = [roll, pitch, yaw]
            .map(|node| self.scalar(node, Quantity::ANGLE, &what, Scope::Constant));
        let [roll, pitch, yaw] = angles;
        Some(self.turns([roll?.expr, pitch?.expr, yaw?.expr]))
    }

    /// Rz(yaw) Ry(pitch) Rx(roll), without turns by zero.
    fn turns(&self, [roll, pitch, yaw]: [Expr; 3]) -> Vec<FixedTurn> {
        let [zero, one] = [self.pool.zero(), self.pool.one()];
        [
            FixedTurn { axis: [zero, zero, one], angle: yaw },
            FixedTurn { axis: [zero, one, zero], angle: pitch },
            FixedTurn { axis: [one, zero, zero], angle: roll },
        ]
        .into_iter()
        .filter(|turn| !self.pool.is_zero(turn.angle))
        .collect()
    }

    pub(super) fn quaternion(
        &mut self,
        node: &Node,
        fields: &Fields<'_>,
    ) -> Option<Vec<FixedTurn>> {
        let what = fields.what("quaternion");
        let example = "[1, 0, 0, 0]";
        let values = self.array(node, &what, "[w, x, y, z]", example)?;
        if values.len() != 4 {
            let help = format!("for example {example}");
            self.wrong_kind(node, &what, "[w, x, y, z]", &node.value, &help);
            return None;
        }
        // Four numbers, whose squares add up to one.
        let mut parts = Vec::new();
        let mut numbers = Vec::new();
        for node in values {
            let scalar = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
            numbers.push(self.constants.pinned(scalar.value?));
            parts.push(scalar.expr);
        }
        let norm = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > ROUNDING {
            let message = format!("{what} has the length {}, not 1", short(norm));
            let unit: Vec<String> = numbers.iter().map(|x| (x / norm).to_string()).collect();
            let help = if norm > 0.0 {
                format!("write [{}]", unit.join(", "))
            } else {
                "write [1, 0, 0, 0] for axes parallel to those of the body".to_owned()
            };
            self.report(
                Diagnostic::error(codes::BAD_FRAME, message)
                    .at(node.span.clone(), "not a rotation")
                    .help(help),
            );
            return None;
        }
        // θ = 2 atan2(|v|, w) about v/|v|.
        let [w, v @ ..] = [parts[0], parts[1], parts[2], parts[3]];
        if v.iter().all(|&part| self.pool.is_zero(part)) {
            return Some(Vec::new());
        }
        let pool = &self.pool;
        let squares: Vec<Expr> = v.iter().map(|&part| pool.powi(part, 2)).collect();
        let length = pool.sqrt(self.total(&squares));
        let angle = pool.mul(pool.int(2), pool.atan2(length, w));
        let axis = self.normalised(&v, &[numbers[1], numbers[2], numbers[3]]);
        Some(vec![FixedTurn { axis, angle }])
    }

    /// The turns that bring the axes of the body to two given ones.
    pub(super) fn two_axes(
        &mut self,
        keys: &[&str],
        fields: &Fields<'_>,
    ) -> Option<Vec<FixedTurn>> {
        let &[first, second] = keys else {
            let n = keys.len();
            let message = format!("{} has {n} axes, and two make a frame", fields.owner);
            self.report(
                Diagnostic::error(codes::BAD_FRAME, message)
                    .at(fields.span.clone(), "two of `x`, `y` and `z`")
                    .help("write two of them, for example `x = [0, 1, 0], z = [0, 0, 1]`"),
            );
            return None;
        };
        let mut vectors = Vec::new();
        for key in [first, second] {
            let node = fields.get(key)?;
            let vector = self.vector(node, Quantity::NUMBER, &fields.what(key), Scope::Constant)?;
            let value: [Constant; 3] = vector.position.as_ref().map(|at| at.value)?;
            for part in value {
                self.constants.pinned(part);
            }
            let numbers = vector.position.as_ref().map_or([0.0; 3], Position::numbers);
            vectors.push((vector.components, numbers, node.span.clone()));
        }
        self.check_right_angle([first, second], [vectors[0].1, vectors[1].1], &vectors[1].2)?;
        // x and y of the frame, of any length.
        let [a, b] = [vectors[0].0, vectors[1].0];
        let [x, y] = match (first, second) {
            ("x", "y") => [a, b],
            ("x", _) => [a, self.cross(&b, &a)],
            _ => [self.cross(&a, &b), a],
        };
        // Yaw and pitch bring x into place, and roll y.
        let pool = &self.pool;
        let angle = |up: Expr, along: Expr| {
            if pool.is_zero(up) && pool.is_zero(along) {
                pool.zero()
            } else {
                pool.atan2(up, along)
            }
        };
        let yaw = angle(x[1], x[0]);
        let level = if pool.is_zero(x[1]) {
            pool.mul(x[0], pool.cos(yaw))
        } else {
            pool.sqrt(pool.add(pool.powi(x[0], 2), pool.powi(x[1], 2)))
        };
        let pitch = angle(pool.neg(x[2]), level);
        let [sin_yaw, cos_yaw] = [pool.sin(yaw), pool.cos(yaw)];
        let ahead = pool.add(pool.mul(cos_yaw, y[0]), pool.mul(sin_yaw, y[1]));
        let aside = pool.sub(pool.mul(cos_yaw, y[1]), pool.mul(sin_yaw, y[0]));
        let up = pool.add(pool.mul(pool.sin(pitch), ahead), pool.mul(pool.cos(pitch), y[2]));
        let roll = angle(up, aside);
        Some(self.turns([roll, pitch, yaw]))
    }

    /// Two axes of a frame have directions at a right angle; reports it otherwise.
    fn check_right_angle(
        &mut self,
        keys: [&str; 2],
        [a, b]: [[f64; 3]; 2],
        span: &Span,
    ) -> Option<()> {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let lengths = (dot(a, a) * dot(b, b)).sqrt();
        if lengths > 0.0 && dot(a, b).abs() <= ROUNDING * lengths {
            return Some(());
        }
        let [one, other] = keys;
        let (message, help) = if lengths > 0.0 {
            let across = across(a, b).map(nine_decimals);
            let degrees = short((dot(a, b) / lengths).clamp(-1.0, 1.0).acos().to_degrees());
            let message = format!(
                "the axes `{one}` and `{other}` of a frame are {degrees} deg apart, not 90"
            );
            (message, format!("write for example `{other} = [{}]`", across.join(", ")))
        } else {
            let message =
                format!("one of the axes `{one}` and `{other}` of a frame has no direction");
            // The axis that has a direction stays.
            let (key, across) =
                if dot(a, a) > 0.0 { (other, across(a, b)) } else { (one, across(b, a)) };
            (
                message,
                format!("write for example `{key} = [{}]`", across.map(nine_decimals).join(", ")),
            )
        };
        self.report(
            Diagnostic::error(codes::BAD_FRAME, message)
                .at(span.clone(), "must be perpendicular")
                .help(help),
        );
        None
    }

    fn cross(&self, a: &Vector, b: &Vector) -> Vector {
        let pool = &self.pool;
        let minor = |i: usize, j: usize| pool.sub(pool.mul(a[i], b[j]), pool.mul(a[j], b[i]));
        [minor(1, 2), minor(2, 0), minor(0, 1)]
    }
}

/// A number that is as exact as a right angle asks.
fn nine_decimals(x: f64) -> String {
    format!("{}", (x * 1e9).round() / 1e9 + 0.0)
}

/// The part of b across a; where there is none, that of the axis which a is farthest from.
fn across(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    /// Parts of b of which nothing but rounding is left.
    const NOTHING: f64 = 1e-6;
    let square = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let rest = |b: [f64; 3]| {
        let dot: f64 = (0..3).map(|i| a[i] * b[i]).sum();
        let part = if square(a) > 0.0 { dot / square(a) } else { 0.0 };
        [0, 1, 2].map(|i| b[i] - part * a[i])
    };
    let own = rest(b);
    if square(own) > NOTHING * NOTHING * square(b) {
        return own;
    }
    let farthest = (0..3).fold(0, |best, k| if a[k].abs() < a[best].abs() { k } else { best });
    rest([0, 1, 2].map(|k| f64::from(u8::from(k == farthest))))
}

/// A vector of a turned frame in the frame before all turns, by Rodrigues' formula turn after turn.
pub(super) fn turned(pool: &Pool, turns: &[FixedTurn], vector: Vector) -> Vector {
    turns.iter().rev().fold(vector, |u: Vector, FixedTurn { axis: n, angle }| {
        let (c, s) = (pool.cos(*angle), pool.sin(*angle));
        let along = pool.sum((0..3).map(|i| pool.mul(n[i], u[i])).collect::<Vec<_>>());
        let along = pool.mul(pool.sub(pool.one(), c), along);
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let across = pool.sub(pool.mul(n[j], u[k]), pool.mul(n[k], u[j]));
            pool.sum([pool.mul(c, u[i]), pool.mul(s, across), pool.mul(along, n[i])])
        })
    })
}
