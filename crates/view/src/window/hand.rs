//! [`Hand`]: the mechanism under the pointer. A pose follows what is held; a live motion is pulled at.

use bksim::model::diagnostic::Diagnostic;
use bksim::playback::Playback;
use bksim::sim::pose::Pose;
use bksim_edit::{Live, Posed, hold_of, limit_words};
use bksim_scene::{Camera, Form, Scene, Shape};

use super::overlay::marker_at;

/// Largest distance of the pointer from a line of a body that it takes hold of, points.
const REACH: f64 = 8.0;
/// Longest part of a motion between two frames, s.
const LONGEST_STEP: f64 = 0.05;

/// A place of a body under the pointer.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Hit {
    body: usize,
    /// In the frame of the body, m.
    point: [f64; 3],
    /// In the world, m.
    world: [f64; 3],
}

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
    pub(super) fn grab(&mut self, playback: &Playback, hit: Hit) {
        self.held = Some(hit.world);
        self.words.clear();
        if let Some(live) = &self.live {
            let model = playback.log().model_with(&playback.mechanism().parameters).ok();
            let held = model.and_then(|model| {
                let hold = hold_of(&model, hit.body, hit.point)?;
                Some(Live::held(model, hold, self.posed.size(), &live.left()))
            });
            self.take_live(held);
            return;
        }
        self.go_to_run(playback);
        // A model that was read compiles.
        let _ = self.posed.grab(hit.body, hit.point);
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

/// The place of the world under a pixel, as far from the eye as a place of the world.
pub(super) fn world_at(camera: &Camera, pixel: [f64; 2], like: [f64; 3]) -> [f64; 3] {
    let [right, up, _] = camera.r_view_from_world;
    let at = camera.project(like);
    let (dx, dy) = ((pixel[0] - at[0]) / camera.scale, (at[1] - pixel[1]) / camera.scale);
    std::array::from_fn(|i| like[i] + dx * right[i] + dy * up[i])
}

/// The body under a pixel: a named point of it, or a line; the uppermost where several are near.
pub(super) fn hit(camera: &Camera, scene: &Scene, poses: &[Pose], at: [f64; 2]) -> Option<Hit> {
    if let Some((marker_idx, _)) = marker_at(camera, scene, poses, at) {
        let marker = scene.markers[marker_idx].at;
        let world = poses[marker.body].place(marker.position);
        return Some(Hit { body: marker.body, point: marker.position, world });
    }
    let shapes = scene.shapes.iter().rev().filter(|shape| shape.body != 0);
    shapes.into_iter().find_map(|shape| on_shape(camera, shape, poses.get(shape.body)?, at))
}

/// The place of a shape under a pixel.
fn on_shape(camera: &Camera, shape: &Shape, pose: &Pose, at: [f64; 2]) -> Option<Hit> {
    let (lines, reach): (Vec<Vec<[f64; 3]>>, f64) = match &shape.form {
        Form::Region(rings) => (rings.iter().map(|ring| closed(ring)).collect(), REACH),
        Form::Line { points, is_closed } => {
            (vec![if *is_closed { closed(points) } else { points.clone() }], REACH)
        }
        Form::Rod { ends, radius } => (vec![ends.to_vec()], REACH.max(radius * camera.scale)),
        Form::Solid(solid) => (vec![solid.corners.clone()], REACH),
        Form::Section { .. } => return None,
    };
    let projected = |line: &Vec<[f64; 3]>| -> Vec<[f64; 3]> {
        line.iter().map(|p| camera.project(pose.place(*p))).collect()
    };
    let lines: Vec<Vec<[f64; 3]>> = lines.iter().map(projected).collect();
    let is_inside = matches!(shape.form, Form::Region(_))
        && lines.iter().filter(|ring| surrounds(ring, at)).count() % 2 == 1;
    let is_near = lines.iter().any(|line| distance(line, at) <= reach);
    let middle = shape_middle(&shape.form)?;
    (is_inside || is_near).then(|| {
        let world = world_at(camera, at, pose.place(middle));
        Hit { body: shape.body, point: local(pose, world), world }
    })
}

/// A place of the world in the frame of a body.
fn local(pose: &Pose, world: [f64; 3]) -> [f64; 3] {
    let d: [f64; 3] = std::array::from_fn(|i| world[i] - pose.origin[i]);
    std::array::from_fn(|j| (0..3).map(|i| pose.r_world_from_body[i][j] * d[i]).sum())
}

/// A place of a shape, for its depth.
fn shape_middle(form: &Form) -> Option<[f64; 3]> {
    let points: &[[f64; 3]] = match form {
        Form::Region(rings) => rings.first()?,
        Form::Line { points, .. } => points,
        Form::Rod { ends, .. } => ends,
        Form::Solid(solid) => &solid.corners,
        Form::Section { .. } => return None,
    };
    let n = points.len().max(1) as f64;
    Some(std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / n))
}

fn closed(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    points.iter().chain(points.first()).copied().collect()
}

/// True if a ring of pixels goes round a pixel.
fn surrounds(ring: &[[f64; 3]], [x, y]: [f64; 2]) -> bool {
    let crosses = |pair: &&[[f64; 3]]| {
        let [[ax, ay, _], [bx, by, _]] = [pair[0], pair[1]];
        (ay > y) != (by > y) && x < (bx - ax) * (y - ay) / (by - ay) + ax
    };
    ring.windows(2).filter(crosses).count() % 2 == 1
}

/// The distance of a pixel from a line of pixels.
fn distance(line: &[[f64; 3]], [x, y]: [f64; 2]) -> f64 {
    let of_piece = |pair: &[[f64; 3]]| {
        let [[ax, ay, _], [bx, by, _]] = [pair[0], pair[1]];
        let (dx, dy) = (bx - ax, by - ay);
        let square = dx * dx + dy * dy;
        let along = if square > 0.0 { ((x - ax) * dx + (y - ay) * dy) / square } else { 0.0 };
        let part = along.clamp(0.0, 1.0);
        (x - ax - part * dx).hypot(y - ay - part * dy)
    };
    line.windows(2).map(of_piece).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::pendulum;

    #[test]
    fn a_held_body_follows_the_pointer_and_the_run_comes_back() {
        let show = pendulum("30 deg", "1 s");
        let playback = show.playback();
        let mut hand = Hand::of(playback).expect("a mechanism");
        assert!(hand.poses().is_none());
        let at = show.poses()[1].place([0.0, -1.0, 0.0]);
        hand.grab(playback, Hit { body: 1, point: [0.0, -1.0, 0.0], world: at });
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

    #[test]
    fn bodies_are_found_at_their_lines_and_in_their_regions() {
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let role = bksim_scene::Role::Body(0);
        let region = Shape { body: 1, role, form: Form::Region(vec![square.to_vec()]) };
        let rod = Form::Rod { ends: [[-1.0, 0.0, 0.0], [-1.0, 1.0, 0.0]], radius: 0.1 };
        let shapes = vec![region, Shape { body: 2, role, form: rod }];
        let scene = Scene { shapes, ..Scene::default() };
        let camera = Camera { scale: 100.0, ..Camera::planar([400.0, 400.0]) };
        let poses = [Pose::default(); 3];
        let found = |x, y| hit(&camera, &scene, &poses, [x, y]);
        let inside = found(250.0, 150.0).expect("the square");
        assert_eq!((inside.body, inside.point), (1, [0.5, 0.5, 0.0]));
        assert_eq!(found(109.0, 150.0).map(|hit| hit.body), Some(2));
        assert_eq!(found(150.0, 150.0), None);
    }
}
