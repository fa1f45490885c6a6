//! Arrows of reactions, velocities and forces, with one scale for the whole run.

use std::time::Instant;

use bksim::playback::Playback;
use bksim::sim::load_forces::LoadForces;
use bksim::sim::run::Unreplayed;
use bksim::sim::wrenches::{ContactForces, WrenchAt};
use bksim_scene::vectors::{
    ArrowKind, ArrowScale, VectorAt, applied_forces, arrows, reactions, velocities,
};
use bksim_scene::{Arrow, Scene, Theme};

use super::ShowOptions;
use super::reach::{INSTANTS, instant};

/// The largest vectors of a run, which decide the scales of its arrows.
#[derive(Debug)]
pub(super) struct Arrows {
    /// The forces of the loads; `None` if they have none that can be computed.
    loads: Option<LoadForces>,
    /// The forces of the contacts; `None` of a model without contacts.
    contacts: Option<ContactForces>,
    /// Largest size of each reaction and of the force of each contact over the run, N.
    reactions: Vec<f64>,
    /// Largest size of each applied force over the run, N.
    applied: Vec<f64>,
    /// Largest size of each velocity over the run, m/s.
    velocities: Vec<f64>,
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
        let contacts = ContactForces::compile(mechanism).ok().flatten();
        let extent = extent(reach);
        let (reactions, applied, velocities) = (Vec::new(), Vec::new(), Vec::new());
        Self { loads, contacts, reactions, applied, velocities, extent, n_seen: 0 }
    }

    /// True if the largest vectors of the run are known, and with them the scales.
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
            let reactions = self.reactions_at(playback, scene);
            raise(&mut self.reactions, reactions);
            raise(&mut self.velocities, velocities(scene, poses));
            if let Some(loads) = &mut self.loads {
                raise(&mut self.applied, applied_forces(loads, sample));
            }
            self.n_seen += 1;
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                break;
            }
        }
        Ok(())
    }

    /// The reactions of joints, then the forces of contacts on their second bodies, at the playback's instant.
    fn reactions_at(&mut self, playback: &Playback, scene: &Scene) -> Vec<VectorAt> {
        let (sample, poses) = (playback.sample(), playback.poses());
        let uniqueness = playback.uniqueness_at(sample.t);
        let contacts = self.contacts.as_mut();
        let contacts = contacts.map(|contacts| contacts.at(sample, playback.modes()));
        let of_contact =
            |w: &WrenchAt| VectorAt { point: w.point, vector: w.force, is_unique: true };
        let mut all: Vec<VectorAt> = reactions(scene, poses, sample, uniqueness).collect();
        all.extend(contacts.iter().flatten().map(of_contact));
        all
    }

    /// The kinds of arrows that are shown, each to a scale of its own.
    pub(super) fn kinds(&self, options: &ShowOptions, theme: &Theme) -> Vec<ArrowKind> {
        let largest = |peaks: &[f64]| peaks.iter().copied().fold(0.0, f64::max);
        let force = largest(&self.reactions).max(largest(&self.applied));
        let kind = |is_shown: bool, name, color, unit, peaks: &[f64]| {
            let reference = if unit == "N" { force } else { largest(peaks) };
            let scale = ArrowScale::of(peaks, reference, self.extent);
            is_shown.then_some(ArrowKind { name, color, unit, scale })
        };
        let all = [
            kind(options.reactions, "reaction", theme.force, "N", &self.reactions),
            kind(options.forces, "force", theme.load, "N", &self.applied),
            kind(options.velocities, "velocity", theme.velocity, "m/s", &self.velocities),
        ];
        all.into_iter().flatten().collect()
    }

    /// The requested arrows at the playback's instant.
    pub(super) fn at(
        &mut self,
        playback: &Playback,
        scene: &Scene,
        options: &ShowOptions,
        theme: &Theme,
    ) -> Vec<Arrow> {
        let (sample, poses) = (playback.sample(), playback.poses());
        let mut all = Vec::new();
        for kind in self.kinds(options, theme) {
            match (kind.name, &mut self.loads) {
                ("velocity", _) => {
                    all.extend(arrows(kind.color, kind.scale, velocities(scene, poses)));
                }
                ("force", Some(loads)) => {
                    all.extend(arrows(kind.color, kind.scale, applied_forces(loads, sample)));
                }
                ("reaction", _) => {
                    let reactions = self.reactions_at(playback, scene);
                    all.extend(arrows(kind.color, kind.scale, reactions));
                }
                _ => (),
            }
        }
        all
    }
}

/// Raises the largest sizes of vectors, one by one, to those of other ones.
fn raise(peaks: &mut Vec<f64>, vectors: impl IntoIterator<Item = VectorAt>) {
    for (idx, at) in vectors.into_iter().enumerate() {
        match peaks.get_mut(idx) {
            Some(peak) => *peak = peak.max(at.size()),
            None => peaks.push(at.size()),
        }
    }
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
