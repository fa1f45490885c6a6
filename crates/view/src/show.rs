//! [`Show`]: a run with its additions, at any instant.

mod arrows;
#[cfg(test)]
mod pendulum;
mod reach;
mod trail;

use std::sync::Arc;
use std::time::{Duration, Instant};

use bksim::analysis::AnalysisError;
use bksim::model::file::ShownUnits;
use bksim::overlay;
use bksim::playback::Playback;
use bksim::sim::load_forces::LoadTorques;
use bksim::sim::pose::Pose;
use bksim::sim::run::{Sample, Unreplayed};
use bksim_scene::vectors::ArrowKind;
use bksim_scene::{Arrow, Extras, Scene, Section, Theme, Words};

use self::arrows::Arrows;
#[cfg(test)]
pub(crate) use self::pendulum::pendulum;
use self::trail::Past;

/// Additions to the mechanism, and the colours.
#[derive(Clone, PartialEq, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of the view")]
pub struct ShowOptions {
    /// Names at joints, points and centres of mass.
    pub labels: bool,
    /// Indices in [`Scene::markers`] of the points that leave trails.
    pub trails: Vec<usize>,
    /// Duration of trails and ghosts, s; back to the start if infinite.
    pub past_s: f64,
    /// Arrows of joint reactions.
    pub reactions: bool,
    /// Arrows of the velocities of centres of mass and points.
    pub velocities: bool,
    /// Arrows of applied forces.
    pub forces: bool,
    /// Title in the upper left corner; may be empty.
    pub title: String,
    /// True if the instant is written below the title.
    pub time: bool,
    /// Caption below the mechanism; may be empty.
    pub caption: String,
    /// True if the scales of arrows are told in the picture.
    pub legend: bool,
    /// Number of earlier instants at which the mechanism is drawn faintly.
    pub ghosts: usize,
    /// Light on dark.
    pub dark: bool,
    /// The plane that cuts a mechanism in space.
    pub section: Option<Section>,
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
            title: String::new(),
            time: false,
            caption: String::new(),
            legend: false,
            ghosts: 0,
            dark: false,
            section: None,
        }
    }
}

/// Number of instants from which the lengths of guides and slots come.
const N_POSES: usize = 100;

/// A run with its additions, at the instant shown.
#[derive(Debug)]
pub struct Show {
    /// Additions and colours; may be changed between any two frames.
    pub options: ShowOptions,
    /// Time that one call of [`Show::extras`] may spend on other instants than the one shown;
    /// unlimited if none.
    pub patience: Option<Duration>,
    /// Units of what is told in words and curves: those of the model's `[units]` unless changed.
    pub units: ShownUnits,
    playback: Playback,
    scene: Arc<Scene>,
    /// The torques whose signs are in the scene; `None` if there are none that can be computed.
    torques: Option<LoadTorques>,
    /// The instant that is shown, s.
    t: f64,
    past: Past,
    /// Computed when the first arrow is requested.
    arrows: Option<Arrows>,
    /// Outermost points over the run, computed on the first request.
    reach: Option<Vec<[f64; 3]>>,
    /// True if the last additions are complete.
    is_whole: bool,
}

impl Show {
    /// A run at its start.
    pub fn new(mut playback: Playback) -> Self {
        let motion = playback.poses_over_run(N_POSES);
        let mechanism = playback.mechanism();
        let scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &motion);
        let torques = scene.torques(mechanism).ok().flatten();
        let scene = Arc::new(scene);
        let past = Past::new(&playback.log().segments, &scene);
        let [t, _] = playback.span();
        let options = ShowOptions::default();
        let (patience, arrows, reach, is_whole) = (None, None, None, true);
        let units = ShownUnits::of_model(&playback.log().header.model_text);
        let mut show = Self {
            options,
            patience,
            units,
            playback,
            scene,
            torques,
            t,
            past,
            arrows,
            reach,
            is_whole,
        };
        show.turn_signs();
        show
    }

    /// Lays curves of the mechanism over it, as [`bksim::overlay::overlays`] reads their texts.
    ///
    /// # Errors
    /// [`AnalysisError`] for curves that the mechanism has not.
    pub fn lay_over(&mut self, texts: &[String]) -> Result<(), AnalysisError> {
        let playback = &self.playback;
        let read = || playback.log().model_with(&playback.mechanism().parameters);
        let overlays = overlay::overlays(&read, texts)?;
        overlay::lay_over(Arc::make_mut(&mut self.scene), &overlays);
        self.reach = None;
        Ok(())
    }

    /// The run.
    pub fn playback(&self) -> &Playback {
        &self.playback
    }

    /// The mechanism as shapes, the signs of torques as they are at the instant shown.
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
        self.turn_signs();
        Ok(self.playback.sample())
    }

    /// Turns the signs of torques as these are at the playback's instant; the scene is another one only where one turns
    /// over.
    fn turn_signs(&mut self) {
        let Some(torques) = &mut self.torques else { return };
        let Sample { t, q, v, lambda, .. } = self.playback.sample();
        let torques = torques.at((*t, q, v), lambda);
        if self.scene.is_turned_by(torques) {
            Arc::make_mut(&mut self.scene).turn(torques);
        }
    }

    /// Poses of the bodies at the instant shown, the ground first.
    pub fn poses(&self) -> &[Pose] {
        self.playback.poses()
    }

    /// Additions to the mechanism at the instant shown, as far as [`Show::patience`] allows.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn extras(&mut self) -> Result<Extras, Unreplayed> {
        let deadline = self.patience.map(|patience| Instant::now() + patience);
        let Self { options, playback, scene, t, past, .. } = self;
        let ghosts = past.ghosts(playback, *t, options.past_s, options.ghosts);
        // Trails come before the arrows, whose scale makes progress without time left, too.
        let trails = past.trails(playback, scene, options, deadline);
        let arrows = self.arrows(deadline)?;
        self.is_whole = trails.is_whole && arrows.is_some();
        let palette = self.theme().palette;
        let coloured = |(idx, points)| (palette[(idx + 1) % palette.len()], points);
        let trails = trails.points.into_iter().enumerate().map(coloured).collect();
        // Arrows appear once their scale is known.
        let arrows = arrows.unwrap_or_default();
        let legend = if self.options.legend { self.arrow_kinds() } else { Vec::new() };
        let (has_labels, section) = (self.options.labels, self.options.section);
        let words = self.words();
        Ok(Extras { trails, arrows, has_labels, legend, ghosts, words, section })
    }

    /// Title, instant and caption.
    fn words(&self) -> Words {
        let ShowOptions { title, time, caption, .. } = &self.options;
        let [first, last] = self.span();
        let unit = self.units.of("s");
        // Three digits of the whole run, as many in every frame.
        let size = unit.of_si((last - first).abs()).log10().floor();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let decimals = (2.0 - size).clamp(0.0, 9.0) as usize;
        let instant = || format!("t = {:.decimals$} {}", unit.of_si(self.t), unit.unit);
        let (title, caption) = (title.clone(), caption.clone());
        Words { title, instant: time.then(instant), caption }
    }

    /// True if the last additions are complete; otherwise later calls give more.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// The requested arrows; none as long as their scale is not known.
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

    /// The kinds of arrows that are shown, with their scales, once these are known.
    pub fn arrow_kinds(&self) -> Vec<ArrowKind> {
        let known = self.arrows.as_ref().filter(|arrows| arrows.is_known());
        known.map_or_else(Vec::new, |arrows| arrows.kinds(&self.options, self.theme()))
    }

    /// Outermost points of the mechanism over the whole run, for [`bksim_scene::Camera::fitted`].
    pub fn points_over_run(&mut self) -> &[[f64; 3]] {
        let Self { playback, scene, .. } = self;
        self.reach.get_or_insert_with(|| reach::over_run(playback, scene))
    }

    /// Tips of the requested arrows over the whole run.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    #[expect(clippy::missing_panics_doc, reason = "the scale of arrows becomes known")]
    pub fn arrow_tips_over_run(&mut self) -> Result<Vec<[f64; 3]>, Unreplayed> {
        let (t, options) = (self.t, &self.options);
        let mut tips = Vec::new();
        if !(options.reactions || options.velocities || options.forces) {
            return Ok(tips);
        }
        for idx in 0..reach::INSTANTS {
            self.seek(reach::instant(self.span(), idx))?;
            let arrows = self.arrows(None)?.expect("without a deadline the scale becomes known");
            let tip =
                |arrow: Arrow| std::array::from_fn(|axis| arrow.from[axis] + arrow.vector[axis]);
            tips.extend(arrows.into_iter().map(tip));
        }
        self.seek(t)?;
        Ok(tips)
    }
}
