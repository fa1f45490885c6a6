//! The past: trails of points, and ghosts of the mechanism.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

use bksim::playback::Playback;
use bksim::sim::pose::Pose;
use bksim::sim::run::Segment;
use bksim_scene::Scene;

use super::ShowOptions;

/// Points of a trail in one step of the integrator, which goes over it by a polynomial …
const PARTS: usize = 8;

/// … and those that are enough where there are many trails, which are small then.
const FEW_PARTS: usize = 2;

/// About the largest number of points of a trail, and of all trails together.
const LARGEST: usize = 3000;
const LARGEST_TOGETHER: usize = 40_000;

/// Points that a trail has among however many.
const FEWEST: usize = 16;

/// Earlier instants that were computed already.
#[derive(Debug)]
pub(super) struct Past {
    /// Begin and end of every step, s.
    steps: Vec<[f64; 2]>,
    n_markers: usize,
    /// Markers that leave trails.
    chosen: Vec<usize>,
    /// By instant, where they are. An instant is a step and one of its parts.
    known: BTreeMap<usize, Vec<[f64; 3]>>,
    ghosts: Ghosts,
}

/// The last ghosts.
#[derive(Debug, Default)]
struct Ghosts {
    times: Vec<f64>,
    poses: Vec<Vec<Pose>>,
}

/// Ways of points, and whether they are as long as they are to be.
pub(super) struct Trails {
    pub(super) points: Vec<Vec<[f64; 3]>>,
    pub(super) is_whole: bool,
}

impl Past {
    pub(super) fn new(segments: &[Segment], scene: &Scene) -> Self {
        let steps = segments.iter().map(|s| [s.t0, s.t1]).collect();
        let (n_markers, chosen) = (scene.markers.len(), Vec::new());
        Self { steps, n_markers, chosen, known: BTreeMap::new(), ghosts: Ghosts::default() }
    }

    /// First instant of the run that is at most `past_s` before `t`.
    fn begin(&self, t: f64, past_s: f64) -> f64 {
        let (Some(first), Some(last)) = (self.steps.first(), self.steps.last()) else { return t };
        let (first, last) = (first[0], last[1]);
        if last < first { (t + past_s).min(first) } else { (t - past_s).max(first) }
    }

    /// The way of every chosen marker up to where it is now, the oldest point first. What cannot be
    /// computed before the deadline is missing at the old end.
    pub(super) fn trails(
        &mut self,
        playback: &mut Playback,
        scene: &Scene,
        options: &ShowOptions,
        deadline: Option<Instant>,
    ) -> Trails {
        let chosen = options.trails.iter().filter(|&&marker| marker < self.n_markers);
        let chosen: Vec<usize> = chosen.copied().collect();
        if chosen != self.chosen {
            self.known.clear();
            self.chosen.clone_from(&chosen);
        }
        if chosen.is_empty() {
            return Trails { points: Vec::new(), is_whole: true };
        }
        let t = playback.sample().t;
        let Spacing { stride, most } = self.spacing(options.past_s, chosen.len());
        let begin = self.begin(t, options.past_s);
        let wanted = self.instant_after(begin)..self.instant_after(t);
        let mut wanted: Vec<usize> = multiples(stride, wanted).collect();
        let is_cut = wanted.len() > most;
        wanted.drain(..wanted.len().saturating_sub(most));
        // What lies far off is forgotten.
        if let (Some(first), Some(last)) = (wanted.first(), wanted.last()) {
            let kept = most * stride;
            let reach = first.saturating_sub(kept)..last.saturating_add(kept);
            self.known.retain(|instant, _| reach.contains(instant));
        }

        // From the newest to the oldest, as far as time allows.
        let mut n_missing = 0;
        for (place, &instant) in wanted.iter().enumerate().rev() {
            if self.known.contains_key(&instant) {
                continue;
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                n_missing = place + 1;
                break;
            }
            let poses = playback.poses_at(self.time(instant));
            self.known.insert(instant, places(scene, &chosen, &poses));
        }
        let is_whole = n_missing == 0;
        let mut trails = vec![Vec::with_capacity(wanted.len() + 2); chosen.len()];
        let mut extend = |points: &[[f64; 3]]| {
            trails.iter_mut().zip(points).for_each(|(trail, &point)| trail.push(point));
        };
        if is_whole && !is_cut {
            extend(&places(scene, &chosen, &playback.poses_at(begin)));
        }
        wanted[n_missing..].iter().for_each(|instant| extend(&self.known[instant]));
        extend(&places(scene, &chosen, playback.poses()));
        Trails { points: trails, is_whole }
    }

    /// The poses at `n` instants before `t`, evenly spaced, the oldest first.
    pub(super) fn ghosts(
        &mut self,
        playback: &mut Playback,
        t: f64,
        past_s: f64,
        n: usize,
    ) -> Vec<Vec<Pose>> {
        let begin = self.begin(t, past_s);
        let time = |k: usize| begin + (t - begin) * k as f64 / n as f64;
        let times: Vec<f64> = (0..n).map(time).collect();
        if times != self.ghosts.times {
            let poses = times.iter().map(|&t| playback.poses_at(t)).collect();
            self.ghosts = Ghosts { times, poses };
        }
        self.ghosts.poses.clone()
    }

    /// How far apart the points of `n` trails are, and how many, so that there are not too many.
    fn spacing(&self, past_s: f64, n: usize) -> Spacing {
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
        let most = (LARGEST_TOGETHER / n).clamp(FEWEST, LARGEST);
        // One trail reaches back however far, with wider steps; many rather become shorter.
        let widest = n_points.div_ceil(LARGEST).max(PARTS / FEW_PARTS);
        Spacing { stride: n_points.div_ceil(most).clamp(1, widest), most: most + 1 }
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

/// Instants from one point of a trail to the next, and how many points it has at most.
struct Spacing {
    stride: usize,
    most: usize,
}

fn multiples(stride: usize, range: Range<usize>) -> impl Iterator<Item = usize> {
    (range.start.next_multiple_of(stride)..range.end).step_by(stride)
}

/// Where these markers are.
fn places(scene: &Scene, markers: &[usize], poses: &[Pose]) -> Vec<[f64; 3]> {
    let place = |body: usize, p| poses.get(body).copied().unwrap_or_default().place(p);
    let at = |&marker: &usize| scene.markers[marker].at;
    markers.iter().map(at).map(|at| place(at.body, at.position)).collect()
}
