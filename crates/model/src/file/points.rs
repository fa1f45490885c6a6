//! Named points of bodies, as the body sees them or as a point above them does.

use super::bodies::{BodyFacts, Position};
use super::codes;
use super::frames::{WrittenFrame, turned};
use super::reader::{Fields, Reader};
use super::tree::Node;
use super::units::Quantity;
use super::value::Scope;
use crate::body::Point;

impl Reader<'_> {
    /// The points of a body, in file order.
    pub(super) fn read_points(&mut self, fields: &Fields<'_>, facts: &mut BodyFacts) -> Vec<Point> {
        let Some(node) = fields.get("points") else { return Vec::new() };
        let Some(table) = self.table(node, &fields.what("points")) else { return Vec::new() };
        let mut points = Vec::new();
        for entry in &table.entries {
            let what = format!("point `{}` of {}", entry.key, fields.owner);
            let WrittenFrame { at, from, turns } = self.frame(&entry.node, &what);
            let vector =
                at.and_then(|at| self.vector(at, Quantity::LENGTH, &what, Scope::Constant));
            let position = vector.as_ref().and_then(|vector| vector.position.clone());
            let mut numbers = position.as_ref().map(Position::numbers);
            facts.positions.extend(position);
            let position = vector.map_or([self.pool.zero(); 3], |vector| vector.components);
            let mut point = Point { name: entry.key.clone(), position, orientation: turns };
            if let Some(base) = from.and_then(|from| self.earlier_point(from, &what, &points)) {
                let of_base = facts.points[base].filter(|_| points[base].orientation.is_empty());
                numbers =
                    numbers.zip(of_base).map(|(a, b)| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
                point = self.seen_from(&points[base], point);
            }
            facts.points.push(numbers);
            points.push(point);
        }
        points
    }

    /// The place of the point, among those above it, that a point is seen from.
    fn earlier_point(&mut self, from: &Node, what: &str, points: &[Point]) -> Option<usize> {
        let quoted = self.text_of(from, &format!("`from` of {what}"), "mount")?;
        let names: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
        let found = names.iter().position(|name| *name == quoted.text);
        if found.is_none() {
            let location = quoted.span_of(&(0..quoted.text.len()));
            let message = format!("{what} is seen from unknown point `{}`", quoted.text);
            let label = (location, "no point above it has this name");
            self.unknown(codes::UNKNOWN_POINT, message, label, (quoted.text, &names));
        }
        found
    }

    /// A point of a frame as a point of the frame's body.
    fn seen_from(&self, base: &Point, point: Point) -> Point {
        let offset = turned(&self.pool, &base.orientation, point.position);
        let position = std::array::from_fn(|i| self.pool.add(base.position[i], offset[i]));
        let orientation = base.orientation.iter().copied().chain(point.orientation).collect();
        Point { name: point.name, position, orientation }
    }
}
