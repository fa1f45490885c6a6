//! Arrows of reactions, velocities and forces, with one scale for the whole run.

use std::time::Instant;

use bksim::playback::Playback;
use bksim::sim::load_forces::LoadForces;
use bksim::sim::run::Unreplayed;
use bksim_scene::vectors::{VectorAt, applied_forces, arrow_scale, arrows, reactions, velocities};
use bksim_scene::{Arrow, Scene, Theme};

use super::ShowOptions;
use super::reach::{INSTANTS, instant};

/// Scales of arrows.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Scales {
    /// Metres per newton.
    pub force: f64,
    /// Metres per metre a second.
    pub velocity: f64,
}

/// The largest vectors of a run, which decide the scales of its arrows.
#[derive(Debug)]
pub(super) struct Arrows {
    /// The forces of the loads; `None` if they have none that can be computed.
    loads: Option<LoadForces>,
    /// Largest reaction over the run, N.
    reaction: f64,
    /// Largest applied force over the run, N.
    applied: f64,
    /// Largest velocity over the run, m/s.
    velocity: f64,
    /// Diagonal of the box that the mechanism moves in, m.
    extent: f64,
    /// Number of instants that the largest vectors are from so far.
    n_seen: usize,
}

impl Arrows {
    /// No vectors yet; `reach` are the outermost points of the mechanism over the run.
    pub(super) fn new(playback: &Playback, reach: &[[f64; 3]]) -> Self {
        let mechanism = playback.mechanism();
        let (model, parameters) = (&mechanism.model, &mechanism.parameters);
        let loads =
            LoadForces::compile(model, &mechanism.system, &mechanism.compiled, parameters).ok();
        let extent = extent(reach);
        Self { loads, reaction: 0.0, applied: 0.0, velocity: 0.0, extent, n_seen: 0 }
    }

    /// Whether the largest vectors of the run are known, and with them the scales.
    pub(super) fn is_known(&self) -> bool {
        self.n_seen == INSTANTS
    }

    /// Looks for the largest vectors of the run until the deadline, at one more instant in any
    /// case. The playback is at another instant afterwards.
    pub(super) fn go_on(
        &mut self,
        playback: &mut Playback,
        scene: &Scene,
        deadline: Option<Instant>,
    ) -> Result<(), Unreplayed> {
        while !self.is_known() {
            playback.seek(instant(playback.span(), self.n_seen))?;
            let (sample, poses) = (playback.sample(), playback.poses());
            let uniqueness = playback.uniqueness_at(sample.t);
            self.reaction = largest(reactions(scene, poses, sample, uniqueness), self.reaction);
            self.velocity = largest(velocities(scene, poses), self.velocity);
            if let Some(loads) = &mut self.loads {
                self.applied = largest(applied_forces(loads, sample), self.applied);
            }
            self.n_seen += 1;
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                break;
            }
        }
        Ok(())
    }

    /// Scales for the arrows shown: reactions and forces share one, so that they can be compared.
    pub(super) fn scales(&self, options: &ShowOptions) -> Scales {
        let if_shown = |is_shown: bool, largest: f64| if is_shown { largest } else { 0.0 };
        let reaction = if_shown(options.reactions, self.reaction);
        let force = reaction.max(if_shown(options.forces, self.applied));
        Scales {
            force: arrow_scale(force, self.extent),
            velocity: arrow_scale(self.velocity, self.extent),
        }
    }

    /// The requested arrows at the playback's instant.
    pub(super) fn at(
        &mut self,
        playback: &Playback,
        scene: &Scene,
        options: &ShowOptions,
        theme: &Theme,
    ) -> Vec<Arrow> {
        let scales = self.scales(options);
        let (sample, poses) = (playback.sample(), playback.poses());
        let mut all = Vec::new();
        if options.velocities {
            all.extend(arrows(theme.velocity, scales.velocity, velocities(scene, poses)));
        }
        if let (true, Some(loads)) = (options.forces, &mut self.loads) {
            all.extend(arrows(theme.force, scales.force, applied_forces(loads, sample)));
        }
        if options.reactions {
            let uniqueness = playback.uniqueness_at(sample.t);
            let reactions = reactions(scene, poses, sample, uniqueness);
            all.extend(arrows(theme.force, scales.force, reactions));
        }
        all
    }
}

/// The largest magnitude of some vectors, or `so_far` if that is larger.
fn largest(vectors: impl IntoIterator<Item = VectorAt>, so_far: f64) -> f64 {
    vectors.into_iter().map(|at| at.size()).fold(so_far, f64::max)
}

/// Diagonal of the box about points, m.
fn extent(points: &[[f64; 3]]) -> f64 {
    let range = |axis: usize| {
        let of = |p: &[f64; 3]| p[axis];
        let low = points.iter().map(of).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        if low <= high { high - low } else { 0.0 }
    };
    (0..3).map(|axis| range(axis).powi(2)).sum::<f64>().sqrt()
}
