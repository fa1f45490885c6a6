//! [`Bounds`]: boxes with sides along the axes.

use super::Point;

/// A box with sides along the axes; empty when a corner `min` exceeds `max`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Bounds {
    /// Lower left corner.
    pub min: Point,
    /// Upper right corner.
    pub max: Point,
}

impl Bounds {
    /// The box without points.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };

    /// The smallest box around the points.
    pub fn of(points: impl IntoIterator<Item = Point>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// The smallest box that holds `point` too.
    #[must_use]
    pub fn with(self, point: Point) -> Self {
        self.union(Self { min: point, max: point })
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            min: [self.min[0].min(other.min[0]), self.min[1].min(other.min[1])],
            max: [self.max[0].max(other.max[0]), self.max[1].max(other.max[1])],
        }
    }

    /// Larger by `margin` on every side.
    #[must_use]
    pub fn grown(self, margin: f64) -> Self {
        Self {
            min: [self.min[0] - margin, self.min[1] - margin],
            max: [self.max[0] + margin, self.max[1] + margin],
        }
    }

    /// True if it has no points.
    pub fn is_empty(&self) -> bool {
        self.min[0] > self.max[0] || self.min[1] > self.max[1]
    }

    /// Whether the point is inside or on the border.
    pub fn contains(&self, point: Point) -> bool {
        (0..2).all(|k| self.min[k] <= point[k] && point[k] <= self.max[k])
    }

    /// True if the two have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// Distance of a point from the box, zero inside.
    pub fn distance(&self, point: Point) -> f64 {
        let beyond = |k: usize| (self.min[k] - point[k]).max(point[k] - self.max[k]).max(0.0);
        beyond(0).hypot(beyond(1))
    }

    /// The middle.
    pub fn centre(&self) -> Point {
        [0, 1].map(|k| 0.5 * self.min[k] + 0.5 * self.max[k])
    }

    /// Length of the diagonal; zero when empty.
    pub fn diagonal(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        (self.max[0] - self.min[0]).hypot(self.max[1] - self.min[1])
    }

    /// The largest absolute coordinate; zero when empty.
    pub fn magnitude(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        self.min.iter().chain(&self.max).fold(0.0, |largest: f64, x| largest.max(x.abs()))
    }
}
