//! [`Stage`]: a show before a camera at rest, shot instant by instant.

use bksim::sim::run::Unreplayed;
use bksim_scene::{Camera, Color, Extras, Picture, Theme, picture};

use super::{Clip, Colors, Palette};
use crate::offscreen::{Canvas, CanvasError, Image};
use crate::renderer::{Counts, Frame};
use crate::show::Show;

/// Margin on every side, as a fraction of the picture.
const MARGIN: f64 = 0.07;

/// Margin with arrows or names, which extend beyond the mechanism.
const WIDE_MARGIN: f64 = 0.12;

/// Number of frames of a film that its palette is made from.
const PALETTE_FRAMES: usize = 12;

/// Usual direction of view of a spatial mechanism: azimuth and elevation, degrees.
const USUAL_VIEW: [f64; 2] = [35.0, 25.0];

/// A show with the camera and the colours it is shot in.
#[derive(Debug)]
pub struct Stage {
    /// The run and its additions.
    pub show: Show,
    /// The camera, fitted to the whole motion.
    pub camera: Camera,
    /// The colours.
    pub theme: Theme,
    /// True if the background is transparent.
    pub is_transparent: bool,
}

/// Error of [`Stage::shoot`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShootError {
    /// The motion is not that of its mechanism.
    #[error(transparent)]
    Unreplayed(#[from] Unreplayed),
    /// The canvas cannot be drawn on.
    #[error(transparent)]
    Canvas(#[from] CanvasError),
}

impl Stage {
    /// A show whose whole motion fills pictures of this many points; `view` is the azimuth and
    /// elevation, degrees, of a spatial one.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn new(
        mut show: Show,
        theme: Theme,
        view: Option<[f64; 2]>,
        points: [f64; 2],
    ) -> Result<Self, Unreplayed> {
        let camera = camera(&mut show, view, points)?;
        Ok(Self { show, camera, theme, is_transparent: false })
    }

    /// The picture of an instant, from a canvas that has the scene.
    ///
    /// # Errors
    /// [`ShootError`].
    pub fn shoot(&mut self, canvas: &mut Canvas, t: f64) -> Result<(Image, Counts), ShootError> {
        let extras = self.at(t)?;
        let Self { show, camera, theme, .. } = &*self;
        canvas.scene_mut().follow(show.scene());
        let poses = show.poses();
        let frame = Frame { poses, extras: &extras, camera, theme, pixels_per_point: 1.0 };
        Ok(canvas.draw(&frame, self.background())?)
    }

    /// The picture of an instant as regions, lines and words.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn picture(&mut self, t: f64) -> Result<Picture, Unreplayed> {
        let extras = self.at(t)?;
        let Self { show, camera, theme, .. } = &*self;
        let background = self.background();
        let picture = picture(show.scene(), show.poses(), &extras, camera, theme);
        Ok(Picture { background, ..picture })
    }

    /// The best colours for a film, from some of its frames.
    ///
    /// # Errors
    /// [`ShootError`].
    pub fn palette(&mut self, canvas: &mut Canvas, clip: &Clip) -> Result<Palette, ShootError> {
        let n = clip.n_frames();
        let n_shot = n.min(PALETTE_FRAMES);
        let mut counts = Colors::default();
        for shot in 0..n_shot {
            let (image, _) = self.shoot(canvas, clip.time(shot * n / n_shot))?;
            counts.add(&image);
        }
        Ok(Palette::of(counts))
    }

    /// Brings the show to an instant; returns its additions.
    fn at(&mut self, t: f64) -> Result<Extras, Unreplayed> {
        self.show.seek(t)?;
        self.show.extras()
    }

    fn background(&self) -> Option<Color> {
        (!self.is_transparent).then_some(self.theme.background)
    }
}

/// A camera that shows the whole motion, with its arrows.
fn camera(show: &mut Show, view: Option<[f64; 2]>, points: [f64; 2]) -> Result<Camera, Unreplayed> {
    let camera = if show.scene().is_planar {
        Camera::planar(points)
    } else {
        let [azimuth, elevation] = view.unwrap_or(USUAL_VIEW).map(f64::to_radians);
        Camera::spatial(points, azimuth, elevation)
    };
    let options = &show.options;
    let has_overhang = options.labels || options.reactions || options.velocities || options.forces;
    let has_words = !options.title.is_empty() || options.time || !options.caption.is_empty();
    let margin = if has_overhang || has_words { WIDE_MARGIN } else { MARGIN };
    Ok(camera.fitted(all_points(show)?, margin))
}

/// Points of the mechanism and tips of its arrows, over the whole motion.
fn all_points(show: &mut Show) -> Result<Vec<[f64; 3]>, Unreplayed> {
    let mut points = show.arrow_tips_over_run()?;
    points.extend(show.points_over_run());
    Ok(points)
}

/// Aspect ratio of the whole motion in the camera, width over height, between 1:2 and 5:2.
///
/// # Errors
/// [`Unreplayed`] when the motion is not that of the mechanism.
pub(crate) fn aspect_ratio(show: &mut Show, view: Option<[f64; 2]>) -> Result<f64, Unreplayed> {
    let camera = camera(show, view, [1.0; 2])?;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in all_points(show)? {
        let [x, y, _] = camera.project(p);
        for (axis, x) in [x, y].into_iter().enumerate().filter(|(_, x)| x.is_finite()) {
            (low[axis], high[axis]) = (low[axis].min(x), high[axis].max(x));
        }
    }
    let ratio = (high[0] - low[0]) / (high[1] - low[1]);
    Ok(if ratio.is_nan() { 1.0 } else { ratio.clamp(0.5, 2.5) })
}

#[cfg(test)]
mod tests {
    use bksim_scene::Arrow;

    use super::*;
    use crate::show::{ShowOptions, pendulum};

    /// A pendulum that swings through, with all of its arrows.
    fn show() -> Show {
        let mut show = pendulum("160 deg", "3 s");
        show.options =
            ShowOptions { reactions: true, velocities: true, forces: true, ..show.options };
        show
    }

    #[test]
    fn arrows_stay_in_the_picture_at_every_instant() {
        let size = [320.0, 240.0];
        let mut stage = Stage::new(show(), Theme::LIGHT, None, size).expect("a camera");
        let mut longest = 0.0_f64;
        let mut outermost = f64::INFINITY;
        for k in 0..=300 {
            let extras = stage.at(0.01 * f64::from(k)).expect("an instant");
            for Arrow { from, vector, .. } in extras.arrows {
                let tip = [0, 1, 2].map(|axis| from[axis] + vector[axis]);
                let [x, y, _] = stage.camera.project(tip);
                let [x0, y0, _] = stage.camera.project(from);
                longest = longest.max((x - x0).hypot(y - y0));
                outermost = outermost.min(x.min(y).min(size[0] - x).min(size[1] - y));
            }
        }
        assert!(longest > 30.0, "the longest arrow has {longest} pixels");
        assert!(outermost > 0.0, "an arrow ends {outermost} pixels from the edge");
        // Without arrows the mechanism is larger.
        let mut bare = show();
        bare.options = ShowOptions::default();
        let bare = Stage::new(bare, Theme::LIGHT, None, size).expect("a camera");
        assert!(bare.camera.scale > 1.05 * stage.camera.scale);
    }
}
