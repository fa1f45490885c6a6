//! Named points of bodies: stated ones, and those that joints and loads put there.

use crate::drawing::Location;
use crate::geometry::Point;
use crate::geometry::vector::distance;

/// A named point of a body.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct NamedPoint {
    /// Unique in its body.
    pub(super) name: String,
    /// In world axes, drawing units.
    pub(super) at: Point,
    /// Where it is stated.
    pub(super) location: Location,
}

/// The named points of every body.
#[derive(Clone, Debug)]
pub(super) struct Points {
    /// By body.
    lists: Vec<Vec<NamedPoint>>,
    /// Points nearer than this are one but for rounding, drawing units.
    rounding: f64,
}

impl Points {
    /// No points yet on any of so many bodies.
    pub(super) fn new(n_bodies: usize, rounding: f64) -> Self {
        Self { lists: vec![Vec::new(); n_bodies], rounding }
    }

    /// The points of a body.
    pub(super) fn of(&self, body_idx: usize) -> &[NamedPoint] {
        &self.lists[body_idx]
    }

    /// The point of this name on a body.
    pub(super) fn named(&self, body_idx: usize, name: &str) -> Option<&NamedPoint> {
        self.of(body_idx).iter().find(|point| point.name == name)
    }

    /// Puts a point onto a body that has none of this name.
    pub(super) fn add(&mut self, body_idx: usize, point: NamedPoint) {
        self.lists[body_idx].push(point);
    }

    /// The name of the point of a body at a position; a new one is called `name`, or `name2`, ….
    pub(super) fn name_at(
        &mut self,
        body_idx: usize,
        name: &str,
        at: Point,
        location: &Location,
    ) -> String {
        let is_here = |point: &&NamedPoint| {
            (point.at[0] - at[0]).abs() <= self.rounding
                && (point.at[1] - at[1]).abs() <= self.rounding
        };
        if let Some(known) = self.of(body_idx).iter().find(is_here) {
            return known.name.clone();
        }
        let numbered = (2..).map(|number: u64| format!("{name}{number}"));
        let mut candidates = std::iter::once(name.to_owned()).chain(numbered);
        let free = candidates.find(|name| self.named(body_idx, name).is_none());
        let name = free.expect("fewer names are taken than there are numbers");
        self.add(body_idx, NamedPoint { name: name.clone(), at, location: location.clone() });
        name
    }

    /// The name of the point of a body at a position, where one called `name` is taken first.
    pub(super) fn name_of(
        &mut self,
        body_idx: usize,
        name: &str,
        at: Point,
        location: &Location,
    ) -> String {
        match self.named(body_idx, name) {
            Some(known) if distance(known.at, at) <= self.rounding => name.to_owned(),
            _ => self.name_at(body_idx, name, at, location),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn location() -> Location {
        let (kind, layer) = ("POINT".to_owned(), "0".to_owned());
        Location { kind, handle: None, layer, at: [0.0; 2], lines: None }
    }

    #[test]
    fn a_position_has_one_name_and_a_name_one_position() {
        let mut points = Points::new(2, 1e-9);
        assert_eq!(points.name_at(1, "A", [3.0, 4.0], &location()), "A");
        // The same point but for rounding, then another that would have its name.
        assert_eq!(points.name_at(1, "B", [3.0, 4.0 + 1e-10], &location()), "A");
        assert_eq!(points.name_at(1, "A", [5.0, 4.0], &location()), "A2");
        assert_eq!(points.of(1).len(), 2, "{points:?}");
        assert_eq!(points.name_at(0, "A", [3.0, 4.0], &location()), "A", "another body");
    }

    #[test]
    fn a_load_takes_its_named_point_only_where_that_is() {
        let mut points = Points::new(1, 1e-9);
        for (name, at) in [("P", [0.0, 0.0]), ("Q", [0.0, 0.0])] {
            points.add(0, NamedPoint { name: name.to_owned(), at, location: location() });
        }
        // Of two points at one position the named one; elsewhere a new one.
        assert_eq!(points.name_of(0, "Q", [0.0, 0.0], &location()), "Q");
        assert_eq!(points.name_of(0, "R", [0.0, 0.0], &location()), "P");
        assert_eq!(points.name_of(0, "Q", [1.0, 0.0], &location()), "Q2");
    }
}
