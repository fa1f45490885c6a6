//! Arrows of reactions, velocities and forces, to scale over the whole run.

use bksim::mbs::run::Unreplayed;
use bksim::playback::Playback;
use bksim_scene::{Color, MarkerKind, Scene, Theme};

use super::ShowOptions;
use super::reach::instants;

/// Length of the longest arrow of a run as a part of the mechanism's extent.
const LONGEST: f64 = 0.25;

/// Lengths of arrows: metres per newton and per metre a second.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Scales {
    /// Metres per newton.
    pub force: f64,
    /// Metres per metre a second.
    pub velocity: f64,
}

/// A point of the world and a vector there.
type Arrow = ([f64; 3], [f64; 3]);

impl Scales {
    /// The scales by which the largest vectors of a run have the length of [`LONGEST`]; `reach` are the
    /// points it gets to.
    pub(super) fn over_run(
        playback: &mut Playback,
        scene: &Scene,
        reach: &[[f64; 3]],
    ) -> Result<Self, Unreplayed> {
        let (mut force, mut velocity) = (0.0, 0.0);
        for t in instants(playback.span()) {
            playback.seek(t)?;
            force = longest(reactions(playback, scene), force);
            velocity = longest(velocities(playback, scene), velocity);
        }
        let length = LONGEST * extent(reach);
        let scale = |largest: f64| if largest > 0.0 { length / largest } else { 0.0 };
        Ok(Self { force: scale(force), velocity: scale(velocity) })
    }

    /// The arrows that are asked for, where the playback is.
    pub(super) fn arrows(
        &self,
        playback: &Playback,
        scene: &Scene,
        options: &ShowOptions,
        theme: &Theme,
    ) -> Vec<(Color, [f64; 3], [f64; 3])> {
        let mut arrows = Vec::new();
        let mut add = |color: Color, scale: f64, found: Vec<Arrow>| {
            arrows.extend(found.into_iter().map(|(at, v)| (color, at, v.map(|x| scale * x))));
        };
        if options.velocities {
            add(theme.velocity, self.velocity, velocities(playback, scene));
        }
        if options.reactions {
            add(theme.force, self.force, reactions(playback, scene));
        }
        arrows
    }
}

/// Reactions at joints, on their second bodies, N.
fn reactions(playback: &Playback, scene: &Scene) -> Vec<Arrow> {
    let (sample, poses) = (playback.sample(), playback.poses());
    let arrow = |marker: &bksim_scene::Marker| {
        let MarkerKind::Joint(joint) = marker.kind else { return None };
        let [x, y, z, ..] = *sample.reactions.get(joint)?;
        Some((poses.get(marker.at.body)?.place(marker.at.position), [x, y, z]))
    };
    scene.markers.iter().filter_map(arrow).collect()
}

/// Velocities of points and centres of mass, m/s.
fn velocities(playback: &Playback, scene: &Scene) -> Vec<Arrow> {
    let poses = playback.poses();
    let moving = |marker: &&bksim_scene::Marker| {
        !matches!(marker.kind, MarkerKind::Joint(_)) && marker.at.body != 0
    };
    let arrow = |marker: &bksim_scene::Marker| {
        let pose = poses.get(marker.at.body)?;
        Some((pose.place(marker.at.position), pose.velocity_of(marker.at.position)))
    };
    scene.markers.iter().filter(moving).filter_map(arrow).collect()
}

fn longest(arrows: Vec<Arrow>, so_far: f64) -> f64 {
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let finite = arrows.into_iter().map(|(_, v)| length(v)).filter(|x| x.is_finite());
    finite.fold(so_far, f64::max)
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
