//! [`Place`]: a displacement in the plane.

/// A turn about the origin, then a shift; as the pose of a body its centre of mass and its angle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Place {
    pub(crate) at: [f64; 2],
    pub(crate) angle: f64,
}

impl Place {
    /// No displacement.
    pub(crate) const START: Self = Self { at: [0.0, 0.0], angle: 0.0 };

    /// The displacement at an angle that brings a point to another one.
    pub(crate) fn bringing(point: [f64; 2], to: [f64; 2], angle: f64) -> Self {
        let [x, y] = turned(point, angle);
        Self { at: [to[0] - x, to[1] - y], angle }
    }

    /// The place of a point.
    pub(crate) fn apply(&self, point: [f64; 2]) -> [f64; 2] {
        let [x, y] = turned(point, self.angle);
        [self.at[0] + x, self.at[1] + y]
    }

    /// This displacement after another one.
    pub(crate) fn of(&self, first: &Self) -> Self {
        Self { at: self.apply(first.at), angle: self.angle + first.angle }
    }

    /// The displacement back.
    pub(crate) fn inverse(&self) -> Self {
        let [x, y] = turned(self.at, -self.angle);
        Self { at: [-x, -y], angle: -self.angle }
    }

    /// Poses from their numbers: x, y and angle of each.
    pub(crate) fn all(values: &[f64]) -> Vec<Self> {
        values.chunks(3).map(|v| Self { at: [v[0], v[1]], angle: v[2] }).collect()
    }
}

pub(crate) fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

pub(super) fn less(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn length(v: [f64; 2]) -> f64 {
    v[0].hypot(v[1])
}

pub(super) fn heading(v: [f64; 2]) -> f64 {
    v[1].atan2(v[0])
}

/// A direction turned to the left by a right angle.
pub(super) fn left(v: [f64; 2]) -> [f64; 2] {
    [-v[1], v[0]]
}
