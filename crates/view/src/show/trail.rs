//! The past: trails of points, and ghosts of the mechanism.

use std::collections::BTreeMap;

use bksim::mbs::pose::Pose;
use bksim::mbs::run::{Segment, Unreplayed};
use bksim::playback::Playback;
use bksim_scene::Scene;

use super::ShowOptions;

/// Points of a trail in one step of the integrator, which goes over it by a polynomial.
const PARTS: usize = 8;

/// About the largest number of points of a trail.
const LARGEST: usize = 3000;

/// Earlier instants that were computed already.
#[derive(Debug)]
pub(super) struct Past {
    /// Begin and end of every step, s.
    steps: Vec<[f64; 2]>,
    n_markers: usize,
    /// By instant, where all markers are. An instant is a step and one of its parts.
    markers: BTreeMap<usize, Vec<[f64; 3]>>,
    ghosts: Ghosts,
}

/// The last ghosts.
#[derive(Debug, Default)]
struct Ghosts {
    times: Vec<f64>,
    poses: Vec<Vec<Pose>>,
}

impl Past {
    pub(super) fn new(segments: &[Segment], scene: &Scene) -> Self {
        let steps = segments.iter().map(|s| [s.t0, s.t1]).collect();
        let n_markers = scene.markers.len();
        Self { steps, n_markers, markers: BTreeMap::new(), ghosts: Ghosts::default() }
    }

    /// First instant of the run that is at most `past_s` before `t`.
    fn begin(&self, t: f64, past_s: f64) -> f64 {
        let (Some(first), Some(last)) = (self.steps.first(), self.steps.last()) else { return t };
        let (first, last) = (first[0], last[1]);
        if last < first { (t + past_s).min(first) } else { (t - past_s).max(first) }
    }

    /// The way of every chosen marker up to `t`, the oldest point first.
    pub(super) fn trails(
        &mut self,
        playback: &mut Playback,
        scene: &Scene,
        t: f64,
        options: &ShowOptions,
    ) -> Result<Vec<Vec<[f64; 3]>>, Unreplayed> {
        let chosen = options.trails.iter().filter(|&&marker| marker < self.n_markers);
        let chosen: Vec<usize> = chosen.copied().collect();
        if chosen.is_empty() {
            return Ok(Vec::new());
        }
        let begin = self.begin(t, options.past_s);
        let stride = self.stride(options.past_s);
        let range = self.instant_after(begin)..self.instant_after(t);
        // What lies far off is forgotten.
        let kept = range.len().max(LARGEST * stride);
        let reach = range.start.saturating_sub(kept)..range.end.saturating_add(kept);
        self.markers.retain(|instant, _| reach.contains(instant));

        let mut trails = vec![Vec::with_capacity(range.len() / stride + 2); chosen.len()];
        let mut extend = |points: &[[f64; 3]]| {
            trails.iter_mut().zip(&chosen).for_each(|(trail, &marker)| trail.push(points[marker]));
        };
        extend(&markers_at(playback, scene, begin)?);
        for instant in range.filter(|instant| instant % stride == 0) {
            if !self.markers.contains_key(&instant) {
                let points = markers_at(playback, scene, self.time(instant))?;
                self.markers.insert(instant, points);
            }
            extend(&self.markers[&instant]);
        }
        extend(&markers_at(playback, scene, t)?);
        Ok(trails)
    }

    /// The poses at `n` instants before `t`, evenly spaced, the oldest first.
    pub(super) fn ghosts(
        &mut self,
        playback: &mut Playback,
        t: f64,
        past_s: f64,
        n: usize,
    ) -> Result<Vec<Vec<Pose>>, Unreplayed> {
        let begin = self.begin(t, past_s);
        let time = |k: usize| begin + (t - begin) * k as f64 / n as f64;
        let times: Vec<f64> = (0..n).map(time).collect();
        if times != self.ghosts.times {
            let mut poses = Vec::with_capacity(n);
            for &t in &times {
                playback.seek(t)?;
                poses.push(playback.poses().to_vec());
            }
            self.ghosts = Ghosts { times, poses };
        }
        Ok(self.ghosts.poses.clone())
    }

    /// Instants from one point of a trail to the next, so that it does not have too many.
    fn stride(&self, past_s: f64) -> usize {
        let n_instants = PARTS * self.steps.len();
        let run_s = match (self.steps.first(), self.steps.last()) {
            (Some(first), Some(last)) => (last[1] - first[0]).abs(),
            _ => 0.0,
        };
        let part = if past_s < run_s { past_s / run_s } else { 1.0 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0..=n_instants"
        )]
        let n_points = (part * n_instants as f64) as usize;
        n_points.div_ceil(LARGEST).max(1)
    }

    /// The first instant after `t` in the direction of the run.
    fn instant_after(&self, t: f64) -> usize {
        let is_back = self.steps.first().zip(self.steps.last()).is_some_and(|(a, b)| b[1] < a[0]);
        let is_past = |s: f64| if is_back { s >= t } else { s <= t };
        let step = self.steps.partition_point(|step| is_past(step[1]));
        let parts = (0..PARTS)
            .take_while(|part| step < self.steps.len() && is_past(self.time(PARTS * step + part)));
        PARTS * step + parts.count()
    }

    fn time(&self, instant: usize) -> f64 {
        let [begin, end] = self.steps[instant / PARTS];
        begin + (end - begin) * (instant % PARTS) as f64 / PARTS as f64
    }
}

fn markers_at(playback: &mut Playback, scene: &Scene, t: f64) -> Result<Vec<[f64; 3]>, Unreplayed> {
    playback.seek(t)?;
    let poses = playback.poses();
    let place = |body: usize, p| poses.get(body).copied().unwrap_or_default().place(p);
    Ok(scene.markers.iter().map(|marker| place(marker.at.body, marker.at.position)).collect())
}
