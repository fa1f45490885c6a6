//! Double points and cusps of the curves that points of planar mechanisms draw.
//!
//! ```text
//! crunode    p(s) = p(t),  s ≠ t          two poses, found as crossings of chords, then by Newton's iteration
//! cusp       p′(s) = 0,  p″ × p‴ ≠ 0      else the curve turns back on itself there
//! ```
//!
//! Source: K. H. Hunt, *Kinematic Geometry of Mechanisms* (1978), §7.

use crate::coupler_curve::{CouplerCurve, Sample, Tracer, dot, length};
use crate::curve::Curve;
use crate::extreme::Extremes;
use crate::path::Path;
use crate::rows::wrapped;

/// A pose of the mechanism on one of its branches.
#[derive(Clone, PartialEq, Debug)]
pub struct PoseOf {
    /// Number of the branch, from one.
    pub branch: usize,
    /// All joint positions and body angles there.
    pub pose: Vec<(String, f64)>,
}

/// A place that a point passes in two poses: the curve crosses itself there.
#[derive(Clone, PartialEq, Debug)]
pub struct DoublePoint {
    /// Where, m.
    pub at: [f64; 2],
    /// The two poses.
    pub poses: [PoseOf; 2],
}

/// A place at which a point comes to rest and goes on sharply aside.
#[derive(Clone, PartialEq, Debug)]
pub struct Cusp {
    /// Where, m.
    pub at: [f64; 2],
    /// The pose.
    pub pose: PoseOf,
}

/// Part by which chords are lengthened at both ends, so that none that nearly cross are missed.
const BEYOND: f64 = 0.1;
/// Sine of the angle below which two curves touch, or are the same.
const TANGENT: f64 = 1e-5;
/// Slopes below this part of the size are of a point at rest.
const AT_REST: f64 = 1e-9;
/// Distance of poses, in radians and longest links, below which they are one.
const ONE_POSE: f64 = 1e-6;
/// Part of the third power of the way round a loop up to which its ends may be apart by rounding.
const LOOP: f64 = 1e-3;

/// The curves of one point on all branches, with what locates their singular points.
pub(crate) struct Singular<'a, 'r> {
    pub(crate) curve: &'a mut Curve<Path<'r>>,
    pub(crate) tracer: &'a mut Tracer,
    pub(crate) extremes: &'a mut Extremes,
}

/// A chord: its curve, the number of its first sample, its box.
struct Chord {
    of: usize,
    k: usize,
    low: [f64; 2],
    high: [f64; 2],
}

impl Singular<'_, '_> {
    /// All crossings of the curves, each once, ordered by x.
    pub(crate) fn double_points(&mut self, curves: &[CouplerCurve]) -> Vec<DoublePoint> {
        let mut chords: Vec<Chord> = Vec::new();
        for (of, curve) in curves.iter().enumerate() {
            chords.extend((1..curve.samples.len()).map(|k| Chord::of(of, k - 1, curve)));
        }
        chords.sort_by(|a, b| a.low[0].total_cmp(&b.low[0]));
        let mut found: Vec<[(usize, Sample); 2]> = Vec::new();
        for (i, a) in chords.iter().enumerate() {
            for b in chords[i + 1..].iter().take_while(|b| b.low[0] <= a.high[0]) {
                let are_apart = b.low[1] > a.high[1] || b.high[1] < a.low[1];
                let (first, second) = if (a.of, a.k) < (b.of, b.k) { (a, b) } else { (b, a) };
                if are_apart || !cross(first.ends(curves), second.ends(curves)) {
                    continue;
                }
                let Some(pair) = self.crossing([first, second], curves) else { continue };
                let is_known = |known: &[(usize, Sample); 2]| {
                    self.is_pair(known, &pair)
                        || self.is_pair(known, &[pair[1].clone(), pair[0].clone()])
                };
                if !found.iter().any(is_known) {
                    found.push(pair);
                }
            }
        }
        found.sort_by(|a, b| a[0].1.p[0].total_cmp(&b[0].1.p[0]));
        let told = |pair: &[(usize, Sample); 2]| DoublePoint {
            at: [pair[0].1.p[0], pair[0].1.p[1]],
            poses: pair.each_ref().map(|(of, sample)| self.pose(*of, sample)),
        };
        found.iter().map(told).collect()
    }

    /// Newton's iteration from two chords on p(s) = p(t).
    fn crossing(
        &mut self,
        chords: [&Chord; 2],
        curves: &[CouplerCurve],
    ) -> Option<[(usize, Sample); 2]> {
        const MOST: usize = 12;
        let from = chords.map(|chord| &curves[chord.of].samples[chord.k]);
        let reach = [0, 1].map(|i| from[i].reach(&curves[chords[i].of].samples[chords[i].k + 1]));
        let mut s = reach.map(|reach| 0.5 * reach);
        let size = self.tracer.size;
        for _ in 0..MOST {
            let at = [
                self.tracer.beyond(self.curve, from[0], s[0])?,
                self.tracer.beyond(self.curve, from[1], s[1])?,
            ];
            // Slopes by s, along the directions of the samples.
            let slope = [0, 1].map(|i| {
                let share = at[i].pose.tangent.dot(&from[i].pose.tangent);
                [at[i].slope[0] / share, at[i].slope[1] / share]
            });
            let off = [at[1].p[0] - at[0].p[0], at[1].p[1] - at[0].p[1]];
            let across = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
            let lengths = slope[0][0].hypot(slope[0][1]) * slope[1][0].hypot(slope[1][1]);
            if across.abs() <= TANGENT * lengths {
                return None;
            }
            let step = [
                (off[0] * slope[1][1] - off[1] * slope[1][0]) / across,
                (off[0] * slope[0][1] - off[1] * slope[0][0]) / across,
            ];
            if off[0].hypot(off[1]) < 1e-12 * size || step[0].abs().max(step[1].abs()) < 1e-14 {
                let is_within = (0..2).all(|i| (-0.6..=1.6).contains(&(s[i] / reach[i])));
                let [a, b] = at;
                let gap = if chords[0].of == chords[1].of { self.apart(&a, &b) } else { 1.0 };
                // To both sides of a cusp places differ by the third power of the way.
                let is_cusp = off[0].hypot(off[1]) > LOOP * gap.powi(3) * size;
                let is_double = is_within && gap >= ONE_POSE && !is_cusp;
                return is_double.then_some([(chords[0].of, a), (chords[1].of, b)]);
            }
            for i in 0..2 {
                s[i] += step[i];
                if s[i].abs() > 4.0 * reach[i] {
                    return None;
                }
            }
        }
        None
    }

    /// All cusps of a curve.
    pub(crate) fn cusps(&mut self, of: usize, curve: &CouplerCurve) -> Vec<Cusp> {
        let mut found: Vec<Sample> = Vec::new();
        // At rest in a sample itself, or between two with slopes against each other.
        let mut at_rest: Vec<Sample> =
            curve.samples.iter().filter(|sample| self.is_at_rest(sample)).cloned().collect();
        for pair in curve.samples.windows(2) {
            if dot(&pair[0].slope, &pair[1].slope) < 0.0 {
                at_rest.extend(self.rest_between([&pair[0], &pair[1]]));
            }
        }
        for sample in at_rest {
            if !found.iter().any(|known| self.is_one(known, &sample)) && self.is_sharp(&sample) {
                found.push(sample);
            }
        }
        let told = |cusp: &Sample| Cusp { at: [cusp.p[0], cusp.p[1]], pose: self.pose(of, cusp) };
        found.iter().map(told).collect()
    }

    fn is_at_rest(&self, sample: &Sample) -> bool {
        length(&sample.slope) <= AT_REST * self.tracer.size
    }

    /// Where the point is at rest between two samples whose slopes are against each other.
    fn rest_between(&mut self, [from, to]: [&Sample; 2]) -> Option<Sample> {
        let change: [f64; 3] = std::array::from_fn(|i| to.slope[i] - from.slope[i]);
        let signs = (dot(&from.slope, &change), dot(&to.slope, &change));
        let tracer = &mut *self.tracer;
        let root = self.curve.root(&from.pose, from.reach(to), signs, &mut |curve, pose| {
            dot(&tracer.at(curve, pose.clone()).slope, &change)
        })?;
        let sample = self.tracer.at(self.curve, root);
        self.is_at_rest(&sample).then_some(sample)
    }

    /// True if a curve goes on sharply aside where its point is at rest. Where the point goes back the way that it came, both
    /// sides lie on one line; where it goes straight on, they lie opposite each other.
    fn is_sharp(&mut self, rest: &Sample) -> bool {
        const ASIDE: f64 = 0.02;
        let [before, after] = [-ASIDE, ASIDE].map(|s| self.tracer.beyond(self.curve, rest, s));
        let (Some(before), Some(after)) = (before, after) else { return false };
        if dot(&before.slope, &after.slope) >= 0.0 {
            return false;
        }
        let along: [f64; 3] = std::array::from_fn(|i| after.slope[i] - before.slope[i]);
        let apart = [after.p[0] - before.p[0], after.p[1] - before.p[1]];
        let across = (along[0] * apart[1] - along[1] * apart[0]).abs() / length(&along);
        across > 1e-4 * ASIDE.powi(3) * self.tracer.size
    }

    /// True if two samples are of one pose, whole turns apart.
    fn is_one(&self, a: &Sample, b: &Sample) -> bool {
        self.apart(a, b) < ONE_POSE
    }

    /// Distance of two poses, whole turns aside, in radians and longest links.
    fn apart(&self, a: &Sample, b: &Sample) -> f64 {
        let is_turn = &self.curve.equations.rows.is_turn;
        let off = &a.pose.z - &b.pose.z;
        let off =
            off.iter().zip(is_turn).map(|(off, turns)| if *turns { wrapped(*off) } else { *off });
        off.map(|off| off * off).sum::<f64>().sqrt()
    }

    fn is_pair(&self, a: &[(usize, Sample); 2], b: &[(usize, Sample); 2]) -> bool {
        a.iter().zip(b).all(|(a, b)| a.0 == b.0 && self.is_one(&a.1, &b.1))
    }

    fn pose(&mut self, of: usize, sample: &Sample) -> PoseOf {
        PoseOf { branch: of + 1, pose: self.extremes.pose(self.curve, &sample.pose) }
    }
}

impl Chord {
    fn of(of: usize, k: usize, curve: &CouplerCurve) -> Self {
        let mut chord = Self { of, k, low: [0.0; 2], high: [0.0; 2] };
        let [a, b] = ends(curve, k);
        for i in 0..2 {
            (chord.low[i], chord.high[i]) = (a[i].min(b[i]), a[i].max(b[i]));
        }
        chord
    }

    fn ends(&self, curves: &[CouplerCurve]) -> [[f64; 2]; 2] {
        ends(&curves[self.of], self.k)
    }
}

/// The ends of a chord, a little beyond the samples.
fn ends(curve: &CouplerCurve, k: usize) -> [[f64; 2]; 2] {
    let [a, b] = [&curve.samples[k].p, &curve.samples[k + 1].p];
    let beyond =
        |from: &[f64; 3], to: &[f64; 3]| [0, 1].map(|i| to[i] + BEYOND * (to[i] - from[i]));
    [beyond(b, a), beyond(a, b)]
}

/// True if two lines between points cross.
pub(crate) fn cross([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let turn = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    turn(a, b, c) * turn(a, b, d) <= 0.0 && turn(c, d, a) * turn(c, d, b) <= 0.0
}
