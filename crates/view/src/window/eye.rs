//! [`Eye`]: the camera of the window, moved by fits, drags and turns of the wheel.

use bksim_scene::{Camera, StandardView};

/// Margin on each side of a fitted motion, as a fraction of the picture.
const MARGIN: f64 = 0.1;

/// First azimuth of the view of a spatial mechanism, rad.
const AZIMUTH: f64 = -0.6;
/// First elevation of the view of a spatial mechanism, rad.
const ELEVATION: f64 = 0.45;

/// The camera of the window; the size of the picture may change at any time.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Eye {
    is_planar: bool,
    azimuth: f64,
    elevation: f64,
    camera: Camera,
    /// True if it was not moved since it was fitted: then it is fitted to every new size.
    is_fitted: bool,
}

impl Eye {
    /// A camera that is not fitted yet.
    pub(super) fn new(is_planar: bool) -> Self {
        let camera = Camera::planar([1.0; 2]);
        Self { is_planar, azimuth: AZIMUTH, elevation: ELEVATION, camera, is_fitted: true }
    }

    /// The camera for the renderer.
    pub(super) fn camera(&self) -> &Camera {
        &self.camera
    }

    /// True if it should be fitted to a picture of this size.
    pub(super) fn needs_fit(&self, size: [f64; 2]) -> bool {
        self.is_fitted && self.camera.size != size
    }

    /// Fits all points into a picture of this size.
    pub(super) fn fit(&mut self, size: [f64; 2], points: &[[f64; 3]]) {
        self.resize(size);
        self.turn();
        self.camera = self.camera.fitted(points.iter().copied(), MARGIN);
        self.is_fitted = true;
    }

    /// Takes another size of the picture; the point in its middle stays there.
    pub(super) fn resize(&mut self, size: [f64; 2]) {
        self.camera.size = size;
    }

    /// Moves the picture by pixels.
    pub(super) fn pan(&mut self, [dx, dy]: [f64; 2]) {
        let [width, height] = self.camera.size;
        self.camera.centre = self.camera.unproject([0.5 * width - dx, 0.5 * height - dy]);
        self.is_fitted = false;
    }

    /// Enlarges the picture; the point at the pixel `at` stays there.
    pub(super) fn zoom(&mut self, factor: f64, at: [f64; 2]) {
        let scale = self.camera.scale * factor;
        if !(scale.is_normal() && (1e-9..1e12).contains(&scale)) {
            return;
        }
        let before = self.camera.unproject(at);
        self.camera.scale = scale;
        let after = self.camera.unproject(at);
        for axis in 0..3 {
            self.camera.centre[axis] += before[axis] - after[axis];
        }
        self.is_fitted = false;
    }

    /// Turns about the point in the middle by these angles, rad. The view of a planar mechanism
    /// does not turn.
    pub(super) fn orbit(&mut self, right: f64, up: f64) {
        if self.is_planar {
            return;
        }
        let quarter = std::f64::consts::FRAC_PI_2;
        self.azimuth += right;
        self.elevation = (self.elevation + up).clamp(-quarter, quarter);
        self.turn();
        self.is_fitted = false;
    }

    /// Looks from a standard direction; the middle and the enlargement stay.
    pub(super) fn look(&mut self, view: StandardView) {
        if self.is_planar {
            return;
        }
        [self.azimuth, self.elevation] = view.angles_deg().map(f64::to_radians);
        self.turn();
    }

    /// Sets the direction of the camera to the angles.
    fn turn(&mut self) {
        let Camera { centre, scale, size, .. } = self.camera;
        let camera = if self.is_planar {
            Camera::planar(size)
        } else {
            Camera::spatial(size, self.azimuth, self.elevation)
        };
        self.camera = Camera { centre, scale, ..camera };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: [[f64; 3]; 2] = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]];

    #[test]
    fn zoom_keeps_the_point_under_the_pointer() {
        for is_planar in [true, false] {
            let mut eye = Eye::new(is_planar);
            eye.fit([400.0, 300.0], &CUBE);
            let at = [350.0, 20.0];
            let point = eye.camera().unproject(at);
            eye.zoom(2.5, at);
            let [x, y, _] = eye.camera().project(point);
            assert!((x - at[0]).abs() < 1e-9 && (y - at[1]).abs() < 1e-9, "{x} {y}");
            let scale = eye.camera().scale;
            eye.zoom(f64::NAN, at);
            eye.zoom(0.0, at);
            assert_eq!(eye.camera().scale, scale);
        }
    }

    #[test]
    fn pan_moves_the_picture_with_the_pointer() {
        let mut eye = Eye::new(false);
        eye.fit([400.0, 300.0], &CUBE);
        let before = eye.camera().project([0.3, 0.2, 0.1]);
        eye.pan([17.0, -5.0]);
        let after = eye.camera().project([0.3, 0.2, 0.1]);
        assert!((after[0] - before[0] - 17.0).abs() < 1e-9);
        assert!((after[1] - before[1] + 5.0).abs() < 1e-9);
    }

    #[test]
    fn it_is_fitted_to_new_sizes_until_it_is_moved() {
        let mut eye = Eye::new(true);
        assert!(eye.needs_fit([400.0, 300.0]));
        eye.fit([400.0, 300.0], &CUBE);
        assert!(!eye.needs_fit([400.0, 300.0]) && eye.needs_fit([500.0, 300.0]));
        eye.pan([1.0, 0.0]);
        assert!(!eye.needs_fit([500.0, 300.0]));
    }

    #[test]
    fn orbits_turn_about_the_middle_and_stop_at_the_poles() {
        let mut eye = Eye::new(false);
        eye.fit([400.0, 300.0], &CUBE);
        let centre = eye.camera().centre;
        eye.orbit(1.0, 100.0);
        assert_eq!(eye.camera().centre, centre);
        let [x, y, _] = eye.camera().project(centre);
        assert_eq!([x, y], [200.0, 150.0]);
        // From above, the vertical is seen end on.
        let [_, up, towards] = eye.camera().r_view_from_world;
        assert!(up[2].abs() < 1e-12 && (towards[2] - 1.0).abs() < 1e-12);

        eye.look(StandardView::Front);
        assert_eq!(eye.camera().centre, centre);
        let [right, up, _] = eye.camera().r_view_from_world;
        assert_eq!((right, up), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]));

        let mut flat = Eye::new(true);
        flat.fit([400.0, 300.0], &CUBE);
        let before = flat.clone();
        flat.orbit(1.0, 1.0);
        flat.look(StandardView::Right);
        assert_eq!(flat, before);
    }
}
