//! [`Camera`]: from the world to pixels, without perspective.

use serde::Serialize;

/// A view of a point along a direction, without perspective: equal lengths stay equal.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Camera {
    /// Point of the world in the middle of the picture, m.
    pub centre: [f64; 3],
    /// Pixels per metre.
    pub scale: f64,
    /// Rotation from the world to the view, its rows: right, up, towards the eye.
    pub r_view_from_world: [[f64; 3]; 3],
    /// Width and height of the picture, pixels.
    pub size: [f64; 2],
}

/// A direction from which drawings show a mechanism whose z is up.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StandardView {
    /// Along y: x to the right, z up.
    Front,
    /// From the right, against x: y to the right, z up.
    Right,
    /// From above: x to the right, y up.
    Top,
    /// All three axes equally short, z up.
    Isometric,
}

impl StandardView {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Front, Self::Right, Self::Top, Self::Isometric];

    /// Word for the view: `front`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Right => "right",
            Self::Top => "top",
            Self::Isometric => "isometric",
        }
    }

    /// The view of this word.
    pub fn named(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|view| view.word() == word)
    }

    /// Azimuth and elevation, degrees, as [`Camera::spatial`] takes them in radians.
    pub fn angles_deg(self) -> [f64; 2] {
        match self {
            Self::Front => [0.0, 0.0],
            Self::Right => [90.0, 0.0],
            Self::Top => [0.0, 90.0],
            // The eye on the diagonal of a cube: tan e = 1/√2.
            Self::Isometric => [45.0, std::f64::consts::FRAC_1_SQRT_2.atan().to_degrees()],
        }
    }
}

/// Rotation of the view along −z, with x to the right.
const FROM_ABOVE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Camera {
    /// The view of a planar mechanism: along −z.
    pub fn planar(size: [f64; 2]) -> Self {
        Self { centre: [0.0; 3], scale: 1.0, r_view_from_world: FROM_ABOVE, size }
    }

    /// A view of a spatial mechanism with z up: `azimuth` about z from the view along +y,
    /// `elevation` above the horizon, rad.
    pub fn spatial(size: [f64; 2], azimuth: f64, elevation: f64) -> Self {
        let ((sin_a, cos_a), (sin_e, cos_e)) = (azimuth.sin_cos(), elevation.sin_cos());
        let r_view_from_world = [
            [cos_a, sin_a, 0.0],
            [-sin_a * sin_e, cos_a * sin_e, cos_e],
            [sin_a * cos_e, -cos_a * cos_e, sin_e],
        ];
        Self { centre: [0.0; 3], scale: 1.0, r_view_from_world, size }
    }

    /// A point of the world: pixels from the upper left corner, then metres towards the eye.
    pub fn project(&self, p: [f64; 3]) -> [f64; 3] {
        let d: [f64; 3] = std::array::from_fn(|i| p[i] - self.centre[i]);
        let [x, y, z] =
            self.r_view_from_world.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
        let [width, height] = self.size;
        [0.5 * width + self.scale * x, 0.5 * height - self.scale * y, z]
    }

    /// The point of the plane through the centre that is seen at a pixel.
    pub fn unproject(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let right = (x - 0.5 * self.size[0]) / self.scale;
        let up = (0.5 * self.size[1] - y) / self.scale;
        let [rows_x, rows_y, _] = self.r_view_from_world;
        std::array::from_fn(|i| self.centre[i] + right * rows_x[i] + up * rows_y[i])
    }

    /// The point seen at a pixel that is as far from the eye as another one.
    pub fn unproject_like(&self, pixel: [f64; 2], like: [f64; 3]) -> [f64; 3] {
        let (seen, [.., near]) = (self.unproject(pixel), self.project(like));
        let [.., towards_eye] = self.r_view_from_world;
        std::array::from_fn(|i| seen[i] + near * towards_eye[i])
    }

    /// Puts all points into the picture, with a margin of this part of its size on every side.
    #[must_use]
    pub fn fitted(mut self, points: impl IntoIterator<Item = [f64; 3]>, margin: f64) -> Self {
        self.centre = [0.0; 3];
        let rows = self.r_view_from_world;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points.into_iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            for (axis, row) in rows.iter().enumerate() {
                let x = row[0] * p[0] + row[1] * p[1] + row[2] * p[2];
                (low[axis], high[axis]) = (low[axis].min(x), high[axis].max(x));
            }
        }
        if low[0] > high[0] {
            return self;
        }
        let middle: [f64; 3] = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        self.centre =
            std::array::from_fn(|i| (0..3).map(|axis| middle[axis] * rows[axis][i]).sum());
        let scale_of = |axis: usize| {
            let extent = high[axis] - low[axis];
            self.size[axis] * (1.0 - 2.0 * margin) / extent.max(f64::MIN_POSITIVE)
        };
        let scale = scale_of(0).min(scale_of(1));
        self.scale = if scale.is_finite() { scale } else { 1.0 };
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_views_show_the_axes_of_the_world_as_drawings_do() {
        let right_and_up = |view: StandardView, axis: usize| {
            let [azimuth, elevation] = view.angles_deg().map(f64::to_radians);
            let rows = Camera::spatial([400.0; 2], azimuth, elevation).r_view_from_world;
            [rows[0][axis], rows[1][axis], rows[2][axis]]
        };
        let axes = [("front", 0, 2), ("right", 1, 2), ("top", 0, 1)];
        for (word, to_the_right, up) in axes {
            let view = StandardView::named(word).expect("a standard view");
            for (axis, expected) in [(to_the_right, [1.0, 0.0]), (up, [0.0, 1.0])] {
                let [x, y, _] = right_and_up(view, axis);
                assert!((x - expected[0]).hypot(y - expected[1]) < 1e-15, "{word}, axis {axis}");
            }
        }
        // Seen along the diagonal, all axes are √(2/3) long, and z is upright.
        for axis in 0..3 {
            let [x, y, near] = right_and_up(StandardView::Isometric, axis);
            assert!((x.hypot(y) - (2.0f64 / 3.0).sqrt()).abs() < 1e-15);
            assert!((near.abs() - (1.0f64 / 3.0).sqrt()).abs() < 1e-15);
        }
        let [x, y, _] = right_and_up(StandardView::Isometric, 2);
        assert!(x.abs() < 1e-15 && y > 0.0);
        assert_eq!(StandardView::named("behind"), None);
    }

    #[test]
    fn what_is_fitted_lies_within_the_margin_and_unprojects_to_itself() {
        for camera in [Camera::planar([400.0, 300.0]), Camera::spatial([400.0, 300.0], 0.6, 0.4)] {
            let points = [[0.0, 1.0, 0.0], [2.0, -1.0, 0.5], [-1.0, 0.5, -0.5]];
            let camera = camera.fitted(points, 0.1);
            let seen = points.map(|p| camera.project(p));
            let low = [0, 1].map(|i| seen.iter().fold(f64::INFINITY, |a, p| a.min(p[i])));
            let high = [0, 1].map(|i| seen.iter().fold(f64::NEG_INFINITY, |a, p| a.max(p[i])));
            assert!(low[0] > 39.9 && low[1] > 29.9 && high[0] < 360.1 && high[1] < 270.1);
            // One of the two directions is filled.
            assert!(
                (high[0] - low[0] - 320.0).abs() < 1e-9 || (high[1] - low[1] - 240.0).abs() < 1e-9
            );
            let back = camera.project(camera.unproject([17.0, 250.0]));
            assert!(
                (back[0] - 17.0).abs() < 1e-9
                    && (back[1] - 250.0).abs() < 1e-9
                    && back[2].abs() < 1e-12
            );
        }
    }
}
