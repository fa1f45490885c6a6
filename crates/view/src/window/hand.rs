//! [`Hand`]: the mechanism under the pointer. A pose follows what is held; a live motion is pulled at.

use bksim::model::diagnostic::Diagnostic;
use bksim::playback::Playback;
use bksim::sim::pose::Pose;
use bksim_edit::{Live, Posed, hold_of, limit_words};
use bksim_scene::{Camera, Picked, Scene};

use super::overlay::marker_at;

/// Largest distance of the pointer from a line of a body that it takes hold of, points.
const REACH: f64 = 8.0;
/// Longest part of a motion between two frames, s.
const LONGEST_STEP: f64 = 0.05;

/// A mechanism that is posed or pulled by the pointer.
#[derive(Debug)]
pub(super) struct Hand {
    posed: Posed,
    live: Option<Live>,
    /// The bodies where the hand has put them; none while the run is shown.
    poses: Option<Vec<Pose>>,
    /// Place of the world that is held, while something is.
    held: Option<[f64; 3]>,
    /// The limit that is met, or why the motion ended.
    words: String,
}

impl Hand {
    /// The mechanism of a run, at its start; `None` where it has no positions.
    pub(super) fn of(playback: &Playback) -> Option<Self> {
        let model = playback.log().model_with(&playback.mechanism().parameters).ok()?;
        let posed = Posed::of(model).ok()?;
        Some(Self { posed, live: None, poses: None, held: None, words: String::new() })
    }

    /// Place of the world that is held.
    pub(super) fn held(&self) -> Option<[f64; 3]> {
        self.held
    }

    /// The bodies where the hand has put them.
    pub(super) fn poses(&self) -> Option<&[Pose]> {
        self.poses.as_deref()
    }

    /// Limit that is met, or why a live motion ended.
    pub(super) fn words(&self) -> &str {
        &self.words
    }

    /// True while a live motion goes on.
    pub(super) fn is_live(&self) -> bool {
        self.live.is_some()
    }

    /// Time of the live motion, s.
    pub(super) fn t(&self) -> Option<f64> {
        self.live.as_ref().map(Live::t)
    }

    /// Takes hold of a body.
    pub(super) fn grab(&mut self, playback: &Playback, hit: Picked) {
        self.held = Some(hit.world);
        self.words.clear();
        if let Some(live) = &self.live {
            let model = playback.log().model_with(&playback.mechanism().parameters).ok();
            let held = model.and_then(|model| {
                let hold = hold_of(&model, hit.at.body, hit.at.position)?;
                Some(Live::held(model, hold, self.posed.size(), &live.left()))
            });
            self.take_live(held);
            return;
        }
        self.go_to_run(playback);
        // A model that was read compiles.
        let _ = self.posed.grab(hit.at.body, hit.at.position);
        self.poses = Some(self.posed.bodies());
    }

    /// Brings the pose to the instant of the run that is shown, unless the hand has one already.
    fn go_to_run(&mut self, playback: &Playback) {
        if self.poses.is_some() {
            return;
        }
        let coordinates = playback.mechanism().system.coordinates();
        let names: Vec<String> = coordinates.iter().map(|c| c.name.clone()).collect();
        self.posed.go_near_named(&names, &playback.sample().q);
    }

    /// Moves what is held to a place of the world.
    pub(super) fn drag(&mut self, to: [f64; 3]) {
        if self.held.is_none() {
            return;
        }
        self.held = Some(to);
        if self.live.is_some() {
            return;
        }
        let dragged = self.posed.to(to);
        self.words = dragged.limit.as_ref().map(limit_words).unwrap_or_default();
        self.poses = Some(self.posed.bodies());
    }

    /// Lets go; a pose stays.
    pub(super) fn release(&mut self) {
        self.held = None;
        self.posed.release();
    }

    /// Gives the picture back to the run.
    pub(super) fn open(&mut self) {
        self.release();
        (self.live, self.poses) = (None, None);
        self.words.clear();
    }

    /// Begins a live motion in the pose that is shown, or ends it.
    pub(super) fn toggle_live(&mut self, playback: &Playback) {
        self.release();
        if let Some(live) = self.live.take() {
            live.left().bring(&mut self.posed);
            return;
        }
        let Ok(model) = playback.log().model_with(&playback.mechanism().parameters) else { return };
        let begun = if model.drives.is_empty() && self.poses.is_some() {
            Live::begin_in(model, &mut self.posed, None)
        } else {
            Live::begin(model, playback.sample().t)
        };
        self.take_live(Some(begun));
    }

    fn take_live(&mut self, begun: Option<Result<Live, Vec<Diagnostic>>>) {
        match begun {
            Some(Ok(mut live)) => {
                self.poses = Some(live.bodies());
                self.live = Some(live);
            }
            Some(Err(faults)) => {
                let fault = faults.iter().find(|fault| fault.is_error()).or(faults.first());
                self.end_live(fault.map(|fault| fault.message.clone()).unwrap_or_default());
            }
            None => (),
        }
    }

    fn end_live(&mut self, words: String) {
        self.live = None;
        self.words = words;
    }

    /// Advances a live motion by `dt`, s.
    pub(super) fn advance(&mut self, dt: f64) {
        let Some(live) = &mut self.live else { return };
        match live.step(dt.clamp(0.0, LONGEST_STEP), self.held) {
            Ok(_) => self.poses = Some(live.bodies()),
            Err(fault) => self.end_live(fault.message),
        }
    }
}

/// The body under a pixel: a named point of it, or its shape.
pub(super) fn hit(
    camera: &Camera,
    scene: &Scene,
    poses: &[Pose],
    pixel: [f64; 2],
) -> Option<Picked> {
    let named = marker_at(camera, scene, poses, pixel).map(|(marker_idx, _)| {
        let at = scene.markers[marker_idx].at;
        Picked { at, world: poses[at.body].place(at.position) }
    });
    named.or_else(|| scene.pick(camera, poses, pixel, REACH))
}

#[cfg(test)]
mod tests {
    use bksim_scene::Attached;

    use super::*;
    use crate::show::pendulum;

    #[test]
    fn a_held_body_follows_the_pointer_and_the_run_comes_back() {
        let show = pendulum("30 deg", "1 s");
        let playback = show.playback();
        let mut hand = Hand::of(playback).expect("a mechanism");
        assert!(hand.poses().is_none());
        let at = show.poses()[1].place([0.0, -1.0, 0.0]);
        let end = Attached { body: 1, position: [0.0, -1.0, 0.0] };
        hand.grab(playback, Picked { at: end, world: at });
        let before = hand.poses().expect("a pose")[1];
        assert!((0..3).all(|i| (before.origin[i] - show.poses()[1].origin[i]).abs() < 1e-9));
        hand.drag([0.6, -0.8, 0.0]);
        let reached = hand.poses().expect("a pose")[1].place([0.0, -1.0, 0.0]);
        assert!((reached[0] - 0.6).abs() < 1e-9 && (reached[1] + 0.8).abs() < 1e-9, "{reached:?}");
        // It swings on from there, and stops when it is told to.
        hand.release();
        hand.toggle_live(playback);
        for _ in 0..10 {
            hand.advance(0.02);
        }
        assert!(hand.is_live() && hand.t().is_some_and(|t| t > 0.19), "{}", hand.words());
        let moved = hand.poses().expect("a pose")[1].place([0.0, -1.0, 0.0]);
        assert!((moved[0] - 0.6).abs() > 1e-3, "{moved:?}");
        hand.toggle_live(playback);
        assert!(!hand.is_live() && hand.poses().is_some());
        hand.open();
        assert!(hand.poses().is_none());
    }
}
