//! [`Show`]: what is shown of a run, at any instant.

mod arrows;
mod reach;
mod solve;
mod trail;

use std::sync::Arc;
use std::time::{Duration, Instant};

use bksim::playback::Playback;
use bksim::sim::pose::Pose;
use bksim::sim::run::{Sample, Unreplayed};
use bksim_scene::{Extras, Scene, Theme};

pub use self::arrows::Scales;
use self::arrows::{Arrow, Arrows};
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
    /// What one call of [`Show::extras`] may spend on other instants than the one shown; whatever it
    /// takes if none.
    pub patience: Option<Duration>,
    playback: Playback,
    scene: Arc<Scene>,
    /// The instant that is shown, s.
    t: f64,
    past: Past,
    /// Found when the first arrow is asked for.
    arrows: Option<Arrows>,
    /// Found when first asked for.
    reach: Option<Vec<[f64; 3]>>,
    /// Whether the last extras lack nothing.
    is_whole: bool,
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
        let (patience, arrows, reach, is_whole) = (None, None, None, true);
        Self { options, patience, playback, scene, t, past, arrows, reach, is_whole }
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

    /// What is drawn beside the mechanism at the instant shown, as far as [`Show::patience`] allows.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn extras(&mut self) -> Result<Extras, Unreplayed> {
        let deadline = self.patience.map(|patience| Instant::now() + patience);
        let Self { options, playback, scene, t, past, .. } = self;
        let ghosts = past.ghosts(playback, *t, options.past_s, options.ghosts);
        // Before the arrows, whose scale gets on however little time is left.
        let trails = past.trails(playback, scene, options, deadline);
        let arrows = self.arrows(deadline)?;
        self.is_whole = trails.is_whole && arrows.is_some();
        let palette = self.theme().palette;
        let coloured = |(place, points)| (palette[(place + 1) % palette.len()], points);
        let trails = trails.points.into_iter().enumerate().map(coloured).collect();
        let arrows = arrows.unwrap_or_default();
        Ok(Extras { trails, arrows, has_labels: self.options.labels, ghosts })
    }

    /// Whether the last extras are all there is to see; others will have more.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// The arrows that are asked for; none as long as their scale is not known.
    fn arrows(&mut self, deadline: Option<Instant>) -> Result<Option<Vec<Arrow>>, Unreplayed> {
        let Self { options, playback, scene, .. } = self;
        if !(options.reactions || options.velocities || options.forces) {
            return Ok(Some(Vec::new()));
        }
        let theme = if options.dark { &Theme::DARK } else { &Theme::LIGHT };
        let reach = self.reach.get_or_insert_with(|| reach::over_run(playback, scene));
        let arrows = self.arrows.get_or_insert_with(|| Arrows::new(playback, reach));
        if !arrows.is_known() {
            arrows.go_on(playback, scene, deadline)?;
            playback.seek(self.t)?;
        }
        Ok(arrows.is_known().then(|| arrows.at(playback, scene, options, theme)))
    }

    /// The lengths of arrows, once some were drawn.
    pub fn scales(&self) -> Option<Scales> {
        let known = self.arrows.as_ref().filter(|arrows| arrows.is_known());
        known.map(|arrows| arrows.scales(&self.options))
    }

    /// Points that tell where the mechanism is over the whole run, for [`bksim_scene::Camera::fitted`].
    pub fn points_over_run(&mut self) -> &[[f64; 3]] {
        let Self { playback, scene, .. } = self;
        self.reach.get_or_insert_with(|| reach::over_run(playback, scene))
    }

    /// Where the arrows that are asked for end over the whole run.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn arrow_tips_over_run(&mut self) -> Result<Vec<[f64; 3]>, Unreplayed> {
        let (t, options) = (self.t, &self.options);
        let mut tips = Vec::new();
        if !(options.reactions || options.velocities || options.forces) {
            return Ok(tips);
        }
        for idx in 0..reach::INSTANTS {
            self.seek(reach::instant(self.span(), idx))?;
            let arrows = self.arrows(None)?.unwrap_or_default();
            let tip =
                |(_, from, along): Arrow| std::array::from_fn(|axis| from[axis] + along[axis]);
            tips.extend(arrows.into_iter().map(tip));
        }
        self.seek(t)?;
        Ok(tips)
    }
}
