//! Orientation and spin of a body at the start, as `[initial]` states or guesses them.
//!
//! ```text
//! rod = { rpy = [..] }  |  { quaternion = [w, x, y, z] }  |  { axes = { x = [..], z = [..] } }
//! rod = { w = [..], frame = "body" }
//! ```
//!
//! An orientation becomes the nine direction cosines of the body, which are smooth and the same for both of
//! its quaternions.

use bksim_expr::Expr;

use super::codes;
use super::frames::turned;
use super::reader::{Fields, Reader};
use super::stated::Stated;
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::FixedTurn;
use crate::diagnostic::Diagnostic;
use crate::ids::BodyId;
use crate::measure::{Axis, Frame, Initial, Measure, Orientation};

/// Keys of a body's start besides its measures.
pub(super) const ORIENTATION_KEYS: [&str; 5] = ["rpy", "quaternion", "axes", "w", "frame"];

const AXES: [(Axis, &str); 3] = [(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")];

impl Reader<'_> {
    /// Reads the orientation and the spin of `body`, whose name is `name`.
    pub(super) fn read_orientation(
        &mut self,
        (name, body): (&str, BodyId),
        fields: &Fields<'_>,
        is_guess: bool,
        initial: &mut Stated,
    ) {
        let mut state = |reader: &mut Self, word: String, measure, value, span| {
            let name = format!("{name}.{word}");
            reader.push_initial(Initial { measure, value, is_guess, name, span }, initial);
        };
        self.read_spin(body, fields, &mut state);
        // One way of writing the orientation.
        let ways = ["rpy", "quaternion", "axes"];
        let mut stated = ways.into_iter().filter_map(|key| Some((key, fields.get(key)?)));
        let Some((key, node)) = stated.next() else { return };
        if let Some((other, _)) = stated.next() {
            fields.conflict(self, key, other);
            return;
        }
        let turns = match key {
            "rpy" => self.roll_pitch_yaw(node, fields),
            "quaternion" => self.quaternion(node, fields),
            _ => self.axes(node, fields),
        };
        let Some(turns) = turns else { return };
        self.leave_plane(&turns, &node.span);
        // Its direction cosines, column by column.
        for (column, (of_body, own)) in AXES.into_iter().enumerate() {
            let mut unit = [self.pool.zero(); 3];
            unit[column] = self.pool.one();
            let image = turned(&self.pool, &turns, unit);
            for ((of_ground, axis), value) in AXES.into_iter().zip(image) {
                let measure = Measure::DirectionCosine(body, of_ground, of_body);
                state(self, format!("c{axis}{own}"), measure, value, node.span.clone());
            }
        }
        initial.orientations.push(Orientation { body, turns });
    }

    /// `axes = { x = [..], z = [..] }`.
    fn axes(&mut self, node: &Node, fields: &Fields<'_>) -> Option<Vec<FixedTurn>> {
        let what = fields.what("axes");
        let Value::Table(table) = &node.value else {
            let help = "write for example `axes = { x = [0, 1, 0], z = [1, 0, 0] }`";
            self.wrong_kind(node, &what, "a table", &node.value, help);
            return None;
        };
        let inner = Fields::open(self, table, what, node.span.clone(), &["x", "y", "z"]);
        let keys: Vec<&str> = ["x", "y", "z"].into_iter().filter(|key| inner.has(key)).collect();
        self.two_axes(&keys, &inner)
    }

    /// `w = [..]` in the axes that `frame` says, else in those of the ground.
    fn read_spin(
        &mut self,
        body: BodyId,
        fields: &Fields<'_>,
        state: &mut dyn FnMut(&mut Self, String, Measure, Expr, crate::diagnostic::Span),
    ) {
        let Some(node) = fields.get("w") else {
            if let Some(frame) = fields.entry("frame") {
                let message = format!("{} has `frame` without `w`", fields.owner);
                self.report(
                    Diagnostic::error(codes::MISSING_KEY, message)
                        .at(frame.key_span.clone(), "the axes of which vector?")
                        .help("write for example `w = [0, 0, \"3 rad/s\"]`"),
                );
            }
            return;
        };
        let frames = [("world", Frame::World), ("body", Frame::Body)];
        let frame = match fields.get("frame") {
            Some(node) => self.choice(node, &fields.what("frame"), &frames),
            None => Some(Frame::World),
        };
        // A spin about z stays in the plane.
        let spatial = self.spatial.clone();
        let vector = self.vector(node, Quantity::RATE, &fields.what("w"), Scope::Constant);
        self.spatial = spatial;
        let (Some(frame), Some(vector)) = (frame, vector) else { return };
        let [x, y, _] = vector.components;
        if self.spatial.is_none() && !(self.pool.is_zero(x) && self.pool.is_zero(y)) {
            self.spatial = Some(node.span.clone());
        }
        for ((axis, word), value) in AXES.into_iter().zip(vector.components) {
            let rest = if frame == Frame::Body { "_body" } else { "" };
            let measure = Measure::AngularVelocity(body, frame, axis);
            state(self, format!("w{word}{rest}"), measure, value, node.span.clone());
        }
    }
}
