//! The past: trails of points, and ghosts of the mechanism.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

use bksim::playback::Playback;
use bksim::sim::pose::Pose;
use bksim::sim::run::Segment;
use bksim_scene::Scene;

use super::ShowOptions;

/// Points of a trail in one step of the integrator, where the motion is a polynomial.
const PARTS: usize = 8;

/// Points of a trail in one step that are enough for many trails, which are small on the screen.
const FEW_PARTS: usize = 2;

/// About the largest number of points of a trail.
const LARGEST: usize = 3000;
/// About the largest number of points of all trails together.
const LARGEST_TOGETHER: usize = 40_000;

/// Least number of points of a trail, among any number of trails.
const FEWEST: usize = 16;

/// Positions and poses at earlier instants, kept from frame to frame.
#[derive(Debug)]
pub(super) struct Past {
    /// Begin and end of every step, s.
    steps: Vec<[f64; 2]>,
    n_markers: usize,
    /// Markers that leave trails.
    chosen: Vec<usize>,
    /// By instant, their positions. Instants are numbered by step and part of the step.
    known: BTreeMap<usize, Vec<[f64; 3]>>,
    ghosts: Ghosts,
}

/// The ghosts of the last frame.
#[derive(Debug, Default)]
struct Ghosts {
    times: Vec<f64>,
    poses: Vec<Vec<Pose>>,
}

/// Paths of points.
pub(super) struct Trails {
    pub(super) points: Vec<Vec<[f64; 3]>>,
    /// True if they reach back as far as requested.
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

    /// The path of every chosen marker up to its current position, the oldest point first. Points
    /// that are not computed before the deadline are missing at the old end.
    pub(super) fn trails(
        &mut self,
        playback: &mut Playback,
        scene: &Scene,
        options: &ShowOptions,
        deadline: Option<Instant>,
    ) -> Trails {
        // Known positions are those of the chosen markers.
        let chosen = options.trails.iter().filter(|&&marker| marker < self.n_markers);
        let chosen: Vec<usize> = chosen.copied().collect();
        if chosen != self.chosen {
            self.known.clear();
            self.chosen.clone_from(&chosen);
        }
        if chosen.is_empty() {
            return Trails { points: Vec::new(), is_whole: true };
        }

        // The instants of the trails, without those that are too many at the old end.
        let t = playback.sample().t;
        let Spacing { stride, most } = self.spacing(options.past_s, chosen.len());
        let begin = self.begin(t, options.past_s);
        let instants = self.instant_after(begin)..self.instant_after(t);
        let mut instants: Vec<usize> = multiples(stride, instants).collect();
        let is_cut = instants.len() > most;
        instants.drain(..instants.len().saturating_sub(most));
        self.forget(&instants, most * stride);

        // Positions from the newest to the oldest, as far as time allows.
        let mut n_missing = 0;
        for (idx, &instant) in instants.iter().enumerate().rev() {
            if self.known.contains_key(&instant) {
                continue;
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                n_missing = idx + 1;
                break;
            }
            let poses = playback.poses_at(self.time(instant));
            self.known.insert(instant, positions(scene, &chosen, &poses));
        }

        // From the begin, unless points are missing there, through the instants to the present.
        let is_whole = n_missing == 0;
        let mut trails = vec![Vec::with_capacity(instants.len() + 2); chosen.len()];
        let mut extend = |points: &[[f64; 3]]| {
            trails.iter_mut().zip(points).for_each(|(trail, &point)| trail.push(point));
        };
        if is_whole && !is_cut {
            extend(&positions(scene, &chosen, &playback.poses_at(begin)));
        }
        instants[n_missing..].iter().for_each(|instant| extend(&self.known[instant]));
        extend(&positions(scene, &chosen, playback.poses()));
        Trails { points: trails, is_whole }
    }

    /// Drops positions at instants farther than `reach` from those of the trails.
    fn forget(&mut self, instants: &[usize], reach: usize) {
        if let (Some(first), Some(last)) = (instants.first(), instants.last()) {
            let kept = first.saturating_sub(reach)..last.saturating_add(reach);
            self.known.retain(|instant, _| kept.contains(instant));
        }
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

    /// Distance and largest number of the points of `n` trails.
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
        // A single trail gets wider steps and reaches back to the begin; many trails become shorter
        // instead.
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

    /// The time of an instant, s.
    fn time(&self, instant: usize) -> f64 {
        let [begin, end] = self.steps[instant / PARTS];
        begin + (end - begin) * (instant % PARTS) as f64 / PARTS as f64
    }
}

/// Spacing of the points of a trail.
struct Spacing {
    /// Instants from one point to the next.
    stride: usize,
    /// Largest number of points.
    most: usize,
}

/// The multiples of a number in a range.
fn multiples(stride: usize, range: Range<usize>) -> impl Iterator<Item = usize> {
    (range.start.next_multiple_of(stride)..range.end).step_by(stride)
}

/// Positions of some markers in the world.
fn positions(scene: &Scene, markers: &[usize], poses: &[Pose]) -> Vec<[f64; 3]> {
    let at = |&marker: &usize| scene.markers[marker].at;
    markers.iter().map(at).map(|at| poses[at.body].place(at.position)).collect()
}
