//! [`Show`]: what is shown of a run, at any instant.

mod arrows;
mod reach;
mod solve;
mod trail;

use std::sync::Arc;

use bksim::mbs::pose::Pose;
use bksim::mbs::run::{Sample, Unreplayed};
use bksim::playback::Playback;
use bksim_scene::{Extras, Scene, Theme};

use self::arrows::Arrows;
pub use self::arrows::Scales;
pub use self::solve::{Solved, solve};
use self::trail::Past;

/// What is drawn beside the mechanism, and how.
#[derive(Clone, PartialEq, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of the view")]
pub struct ShowOptions {
    /// Names beside joints, points and centres of mass.
    pub labels: bool,
    /// Places in [`Scene::markers`] of the points that leave trails.
    pub trails: Vec<usize>,
    /// How far back trails and ghosts reach, s; to the start if infinite.
    pub past_s: f64,
    /// Arrows of joint reactions.
    pub reactions: bool,
    /// Arrows of the velocities of centres of mass and points.
    pub velocities: bool,
    /// Arrows of applied forces.
    pub forces: bool,
    /// How often the mechanism is drawn faintly at earlier instants.
    pub ghosts: usize,
    /// Light on dark.
    pub dark: bool,
}

impl Default for ShowOptions {
    fn default() -> Self {
        Self {
            labels: false,
            trails: Vec::new(),
            past_s: f64::INFINITY,
            reactions: false,
            velocities: false,
            forces: false,
            ghosts: 0,
            dark: false,
        }
    }
}

/// Instants from which the lengths of guides and slots come.
const N_POSES: usize = 100;

/// What is shown of a run.
#[derive(Debug)]
pub struct Show {
    /// What to draw; may be changed between any two frames.
    pub options: ShowOptions,
    playback: Playback,
    scene: Arc<Scene>,
    /// The instant that is shown, s.
    t: f64,
    past: Past,
    /// Found when the first arrow is asked for.
    arrows: Option<Arrows>,
    /// Found when first asked for.
    reach: Option<Vec<[f64; 3]>>,
}

impl Show {
    /// Shows a run, at its start.
    pub fn new(mut playback: Playback) -> Self {
        let motion = playback.poses_over_run(N_POSES);
        let mechanism = playback.mechanism();
        let scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &motion);
        let scene = Arc::new(scene);
        let past = Past::new(&playback.log().segments, &scene);
        let [t, _] = playback.span();
        let options = ShowOptions::default();
        Self { options, playback, scene, t, past, arrows: None, reach: None }
    }

    /// The run.
    pub fn playback(&self) -> &Playback {
        &self.playback
    }

    /// The mechanism as shapes.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The colours.
    pub fn theme(&self) -> &'static Theme {
        if self.options.dark { &Theme::DARK } else { &Theme::LIGHT }
    }

    /// First and last instant, s; the last is the earlier one in a run back in time.
    pub fn span(&self) -> [f64; 2] {
        self.playback.span()
    }

    /// The instant that is shown, s.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// Shows the instant `t`, s, or the end that is nearer.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn seek(&mut self, t: f64) -> Result<&Sample, Unreplayed> {
        self.t = self.playback.seek(t)?.t;
        Ok(self.playback.sample())
    }

    /// Where the bodies are at the instant shown, the ground first.
    pub fn poses(&self) -> &[Pose] {
        self.playback.poses()
    }

    /// What is drawn beside the mechanism at the instant shown.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn extras(&mut self) -> Result<Extras, Unreplayed> {
        let Self { options, playback, scene, t, past, .. } = self;
        let ghosts = past.ghosts(playback, *t, options.past_s, options.ghosts)?;
        let trails = past.trails(playback, scene, *t, options)?;
        let has_arrows = options.reactions || options.velocities || options.forces;
        if has_arrows && self.arrows.is_none() {
            let points = self.points_over_run()?.to_vec();
            self.arrows = Some(Arrows::over_run(&mut self.playback, &self.scene, &points)?);
        }
        self.come_back()?;
        let theme = self.theme();
        let arrows = match &mut self.arrows {
            Some(arrows) if has_arrows => {
                arrows.at(&self.playback, &self.scene, &self.options, theme)
            }
            _ => Vec::new(),
        };
        let palette = self.theme().palette;
        let coloured = |(place, points)| (palette[(place + 1) % palette.len()], points);
        let trails = trails.into_iter().enumerate().map(coloured).collect();
        Ok(Extras { trails, arrows, has_labels: self.options.labels, ghosts })
    }

    /// Returns to the instant shown from wherever something else was looked at.
    fn come_back(&mut self) -> Result<(), Unreplayed> {
        if self.playback.sample().t != self.t {
            self.playback.seek(self.t)?;
        }
        Ok(())
    }

    /// The lengths of arrows, once one was asked for.
    pub fn scales(&self) -> Option<Scales> {
        self.arrows.as_ref().map(|arrows| arrows.scales(&self.options))
    }

    /// Points that tell where the mechanism is over the whole run, for [`bksim_scene::Camera::fitted`].
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn points_over_run(&mut self) -> Result<&[[f64; 3]], Unreplayed> {
        let reach = match self.reach.take() {
            Some(points) => points,
            None => reach::over_run(&mut self.playback, &self.scene)?,
        };
        self.come_back()?;
        Ok(self.reach.insert(reach))
    }
}
