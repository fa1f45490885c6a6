//! One pose: slopes, ends and samples.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Band, Contributor, Job, Part, PathBand, Play, PoseTolerance};
use crate::codes;
use crate::error::DesignError;
use crate::poses::{Outputs, Pose, Solver};
use crate::sqp::Problem;

impl Job<'_> {
    pub(super) fn pose(
        &self,
        pose: &Pose,
        at: BTreeMap<String, f64>,
        n_samples: u64,
    ) -> Result<PoseTolerance, DesignError> {
        let mut solver = self.poses.solver();
        let here = solver.outputs(pose, &[]).ok_or_else(Self::singular)?;
        let by_parts = &here.by_p * self.by_parts()?;
        let sums = self.samples(pose, n_samples, &here.values);
        if (self.watch.stop)() {
            return Err(DesignError::Stopped);
        }
        let (n, n_open) = (sums.n as f64, sums.n_open as f64);
        let share = if n > 0.0 { n_open / n } else { f64::NAN };
        let mut assembles = if sums.n_open > 0 { Some(false) } else { None };
        let mut bands = Vec::new();
        for k in 0..self.n_outputs {
            let slopes: Vec<f64> = by_parts.row(k).iter().copied().collect();
            let turned = |play: &Play| [0, 1].map(|axis| here.by_p[(k, play.place + axis)]);
            let of_plays: Vec<[f64; 2]> = self.plays.iter().map(turned).collect();
            let ends = self.ends(&mut solver, pose, (k, &of_plays));
            if ends.is_open {
                assembles = Some(false);
            } else if ends.proved && assembles.is_none() {
                assembles = Some(true);
            }
            let sampled = (&sums.of[k], n - n_open);
            bands.push(self.band(here.values[k], (&slopes, &of_plays), ends, sampled));
        }
        let share_without_assembly = [share, (share * (1.0 - share) / n).sqrt()];
        let paths = self.paths.iter().map(|&k| self.path(&here, &by_parts, k)).collect();
        Ok(PoseTolerance { at, over: None, assembles, share_without_assembly, bands, paths })
    }

    pub(super) fn singular() -> DesignError {
        let message = "the nominal pose is a dead centre, in which slopes have no bound";
        DesignError::fault(
            codes::NOT_ASSEMBLED,
            message,
            "ask at another pose, or change the nominal lengths",
        )
    }

    /// The band of one result, without its name and unit.
    pub(super) fn band(
        &self,
        nominal: f64,
        (slopes, of_plays): (&[f64], &[[f64; 2]]),
        ends: Ends,
        (sums, m): (&[f64; 5], f64),
    ) -> Band {
        let mut contributors = self.contributors(slopes, of_plays);
        let worst: f64 = contributors.iter().map(|c| c.linear).sum();
        let variances: Vec<f64> = self.sigmas(&contributors).map(|sigma| sigma * sigma).collect();
        let variance: f64 = variances.iter().sum();
        for (one, own) in contributors.iter_mut().zip(&variances) {
            one.percent_of_worst = 100.0 * one.linear / worst;
            one.percent_of_variance = 100.0 * own / variance;
        }
        let shift: f64 =
            self.parts.iter().zip(slopes).map(|(p, s)| s * (p.middle() - p.nominal)).sum();
        let linear_interval = [nominal + shift - worst, nominal + shift + worst];
        let exact = ends.interval;
        let [s1, s2, s3, least, most] = *sums;
        let mean = s1 / m;
        let variance_found = (s2 / m - mean * mean).max(0.0) * m / (m - 1.0);
        let sigma = variance_found.sqrt();
        let skewness = (s3 / m - 3.0 * mean * s2 / m + 2.0 * mean.powi(3)) / sigma.powi(3);
        let ratio = (linear_interval[1] - linear_interval[0]) / (exact[1] - exact[0]);
        Band {
            of: String::new(),
            unit: String::new(),
            nominal,
            linear_worst: worst,
            linear_interval,
            rss: contributors.iter().map(|c| c.linear * c.linear).sum::<f64>().sqrt(),
            sigma_linear: variance.sqrt(),
            exact_interval: exact,
            exact_at: ends.at,
            proved: ends.proved,
            linear_fails: ends.is_open || !(0.9..1.1).contains(&ratio),
            mean: [nominal + mean, sigma / m.sqrt()],
            sigma: [sigma, sigma / (2.0 * m).sqrt()],
            skewness,
            sampled: [least, most],
            contributors,
        }
    }

    /// Parts and plays with what they do to a result of these slopes.
    fn contributors(&self, slopes: &[f64], of_plays: &[[f64; 2]]) -> Vec<Contributor> {
        let part = |(part, &slope): (&Part, &f64)| Contributor {
            name: part.name.clone(),
            unit: part.unit.clone(),
            limits: part.limits,
            distribution: part.spread.word(),
            sensitivity: slope,
            linear: (slope * part.half()).abs(),
            percent_of_worst: 0.0,
            percent_of_variance: 0.0,
        };
        let play = |(play, [x, y]): (&Play, &[f64; 2])| Contributor {
            name: format!("{} (play)", play.name),
            unit: "m".to_owned(),
            limits: [-play.reach, play.reach],
            distribution: "play",
            sensitivity: x.hypot(*y),
            linear: x.hypot(*y) * play.reach,
            percent_of_worst: 0.0,
            percent_of_variance: 0.0,
        };
        let of_parts = self.parts.iter().zip(slopes).map(part);
        of_parts.chain(self.plays.iter().zip(of_plays).map(play)).collect()
    }

    /// Standard deviations of contributors by slopes; a component of a random place in a disc has half of its radius.
    fn sigmas<'c>(&self, contributors: &'c [Contributor]) -> impl Iterator<Item = f64> + 'c {
        let of_parts = self.parts.iter().map(|part| part.spread.sigma());
        let parts: Vec<f64> = of_parts.chain(self.plays.iter().map(|_| 0.5)).collect();
        contributors.iter().zip(parts).map(|(one, part)| one.linear * part)
    }

    /// The band across the path of the point whose coordinates are two results.
    fn path(&self, here: &Outputs, by_parts: &DMatrix<f64>, k: usize) -> PathBand {
        let [dx, dy] = [0, 1].map(|axis| here.by_u[(k + axis, 0)]);
        let length = dx.hypot(dy);
        let normal = [-dy / length, dx / length];
        let across = |of: &dyn Fn(usize) -> f64| normal[0] * of(k) + normal[1] * of(k + 1);
        let slopes: Vec<f64> =
            (0..self.parts.len()).map(|part| across(&|row| by_parts[(row, part)])).collect();
        let turned =
            |play: &Play| [0, 1].map(|axis| across(&|row| here.by_p[(row, play.place + axis)]));
        let of_plays: Vec<[f64; 2]> = self.plays.iter().map(turned).collect();
        let contributors = self.contributors(&slopes, &of_plays);
        PathBand {
            of: String::new(),
            at: [here.values[k], here.values[k + 1]],
            normal,
            linear_worst: contributors.iter().map(|c| c.linear).sum(),
            sigma_linear: self.sigmas(&contributors).map(|sigma| sigma * sigma).sum::<f64>().sqrt(),
        }
    }

    /// Nominal values of the parts, and pins in the middles of their holes.
    pub(super) fn nominal(&self) -> Vec<f64> {
        let parts = self.parts.iter().map(|part| part.nominal);
        parts.chain(vec![0.0; 2 * self.plays.len()]).collect()
    }

    /// Derivatives of all parameters by the parts.
    pub(super) fn by_parts(&self) -> Result<DMatrix<f64>, DesignError> {
        let nominal = self.nominal();
        let refused = || {
            let message = "the model refuses values next to the nominal ones";
            DesignError::fault(
                codes::NO_START,
                message,
                "narrow the limits, or correct the nominal values",
            )
        };
        let n = self.poses.start.p.len();
        let mut by = DMatrix::zeros(n, self.parts.len());
        for (k, part) in self.parts.iter().enumerate() {
            let moved = |off: f64| {
                let mut point = nominal.clone();
                point[k] += off;
                (self.parameters)(&point).ok_or_else(refused)
            };
            let step = part.half();
            let (above, below) = (moved(step)?, moved(-step)?);
            for i in 0..n {
                by[(i, k)] =
                    if i == part.place { 1.0 } else { (above[i] - below[i]) / (2.0 * step) };
            }
        }
        Ok(by)
    }

    /// The corner with these ends of the limits, pins in the middles of their holes.
    pub(super) fn corner(&self, is_upper: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let end = |(k, part): (usize, &Part)| part.nominal + part.limits[usize::from(is_upper(k))];
        let parts = self.parts.iter().enumerate().map(end);
        parts.chain(vec![0.0; 2 * self.plays.len()]).collect()
    }

    pub(super) fn value(
        &self,
        solver: &mut Solver<'_>,
        pose: &Pose,
        point: &[f64],
        k: usize,
    ) -> Result<f64, Option<(f64, Pose)>> {
        let p = (self.parameters)(point).ok_or(None)?;
        let end = |solver: &mut Solver<'_>, end: &Pose| solver.raw(&end.q, &end.p, &end.u).2[k];
        match solver.follow(pose, &p, &pose.u) {
            Ok(found) => Ok(end(solver, &found)),
            Err((last, _)) => Err(Some((end(solver, &last), last))),
        }
    }

    /// The ends of a result over the box.
    fn ends(
        &self,
        solver: &mut Solver<'_>,
        pose: &Pose,
        (k, of_plays): (usize, &[[f64; 2]]),
    ) -> Ends {
        // By the signs of all slopes, where they are proved.
        if let Some(signs) = self.signs(pose, k) {
            let mut end = |turn: bool| {
                let is_upper = |part: usize| (signs[part] > 0.0) != turn;
                let side = (k, if turn { -1.0 } else { 1.0 });
                let value = self.aside(solver, pose, side, &self.corner(&is_upper))?;
                let word = |part: usize| if is_upper(part) { "+" } else { "-" };
                Some((value, (0..self.parts.len()).map(word).collect()))
            };
            if let (Some((low, low_at)), Some((high, high_at))) = (end(true), end(false)) {
                return Ends {
                    interval: [low, high],
                    at: [low_at, high_at],
                    proved: true,
                    is_open: false,
                };
            }
        }
        self.searched(solver, pose, (k, of_plays))
    }

    /// Corners and poses where the assembly ends, then a search from the best of them.
    fn searched(
        &self,
        solver: &mut Solver<'_>,
        pose: &Pose,
        (k, of_plays): (usize, &[[f64; 2]]),
    ) -> Ends {
        let mut at_corner = |point: &[f64]| -> Result<f64, Option<(f64, Pose)>> {
            self.value(solver, pose, point, k)
        };
        let (ends, is_open) = self.corners(of_plays, &mut at_corner);
        let mut interval = [ends[0].0, ends[1].0];
        let mut at = [Vec::new(), Vec::new()];
        for (side, (value, from)) in ends.into_iter().enumerate() {
            let Some((from, point, words)) = from else { continue };
            let Some(from) = from.or_else(|| {
                let p = (self.parameters)(&point)?;
                solver.follow(pose, &p, &pose.u).ok()
            }) else {
                continue;
            };
            let sign = if side == 0 { 1.0 } else { -1.0 };
            at[side] = words;
            if let Some(better) = self.refined(pose, &from, &point, k, sign)
                && sign * better < sign * value - 1e-12 * value.abs()
            {
                interval[side] = better;
                at[side] = Vec::new();
            }
        }
        Ends { interval, at, proved: false, is_open }
    }

    /// The least and largest value over the corners, pins on the sides of their holes that make it so, and whether some do not assemble.
    pub(super) fn corners(
        &self,
        of_plays: &[[f64; 2]],
        value: &mut AtCorner<'_>,
    ) -> ([Corner; 2], bool) {
        let n = self.parts.len();
        let mut ends = [(f64::INFINITY, None), (f64::NEG_INFINITY, None)];
        let mut is_open = false;
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let n_corners = if n <= 10 { 1usize << n } else { 1024 };
        // Pins on that side of their holes which makes the result small, then large.
        let n_sides = if self.plays.is_empty() { 1 } else { 2 };
        for tried in 0..(n_corners + 64) * n_sides {
            let (tried, is_large) = (tried / n_sides, tried % n_sides == 1);
            let mut point = if tried < n_corners && n <= 10 {
                self.corner(&|part| tried >> part & 1 == 1)
            } else {
                let random: Vec<bool> = (0..n).map(|_| rng.random()).collect();
                self.corner(&|part| random[part])
            };
            if (self.watch.stop)() {
                break;
            }
            for (i, (play, [x, y])) in self.plays.iter().zip(of_plays).enumerate() {
                let reach = if is_large { play.reach } else { -play.reach };
                let size = x.hypot(*y).max(f64::MIN_POSITIVE);
                point[n + 2 * i] = reach * x / size;
                point[n + 2 * i + 1] = reach * y / size;
            }
            // Where the way to a corner ends, the value there counts.
            let (value, last) = match value(&point) {
                Ok(value) => (value, None),
                Err(last) => {
                    is_open = true;
                    let Some((value, last)) = last else { continue };
                    (value, Some(last))
                }
            };
            let words: Vec<&'static str> = if last.is_none() && self.plays.is_empty() {
                (0..n).map(|i| if point[i] > self.parts[i].middle() { "+" } else { "-" }).collect()
            } else {
                Vec::new()
            };
            let found = Some((last, point, words));
            if value < ends[0].0 {
                ends[0] = (value, found.clone());
            }
            if value > ends[1].0 {
                ends[1] = (value, found);
            }
        }
        (ends, is_open)
    }

    /// The least of `sign` h over coordinates and parts, on the side of the nominal pose.
    fn refined(
        &self,
        nominal: &Pose,
        from: &Pose,
        point: &[f64],
        k: usize,
        sign: f64,
    ) -> Option<f64> {
        let poses = self.poses;
        let n = poses.n();
        let side = poses.solver().side(nominal);
        let range = 0.5;
        let unscaled = |x: &[f64]| {
            let q: Vec<f64> = (0..n)
                .map(|i| from.q[i] + (x[i] - 0.5) * 2.0 * range * poses.unit_of_q(i))
                .collect();
            let (of_parts, of_plays) = x[n..].split_at(self.parts.len());
            let parts = self.parts.iter().zip(of_parts);
            let parts =
                parts.map(|(part, x)| part.nominal + part.limits[0] + x * 2.0 * part.half());
            let aside = |(i, x): (usize, &f64)| (2.0 * x - 1.0) * self.plays[i / 2].reach;
            let plays = of_plays.iter().enumerate().map(aside);
            (q, parts.chain(plays).collect::<Vec<f64>>())
        };
        let evaluate = |points: &[Vec<f64>]| -> Vec<Option<Vec<f64>>> {
            let mut solver = poses.solver();
            let one = |x: &Vec<f64>| {
                let (q, parts) = unscaled(x);
                let p = (self.parameters)(&parts)?;
                let (rows, determinant, outputs) = solver.raw(&q, &p, &nominal.u);
                // A pin stays in its hole.
                let within = x[n + self.parts.len()..]
                    .chunks(2)
                    .map(|at| 1.0 - (2.0 * at[0] - 1.0).powi(2) - (2.0 * at[1] - 1.0).powi(2));
                let within: Vec<f64> = within.collect();
                Some([&[sign * outputs[k]][..], &rows, &[side * determinant], &within].concat())
            };
            points.iter().map(one).collect()
        };
        // Where the way to the corner ended, its parts are between nominal ones and the corner's.
        let reached = |(part, target): (&Part, &f64)| {
            let whole = target - part.nominal;
            let moved = from.p[part.place] - part.nominal;
            let share = if whole == 0.0 { 0.0 } else { (moved / whole).clamp(0.0, 1.0) };
            (part.nominal + share * whole - part.nominal - part.limits[0]) / (2.0 * part.half())
        };
        let aside = |(i, play): (usize, &Play)| {
            [0, 1].map(|axis| 0.5 + 0.5 * from.p[self.plays[i].place + axis] / play.reach)
        };
        let start: Vec<f64> = vec![0.5; n]
            .into_iter()
            .chain(self.parts.iter().zip(point).map(reached))
            .chain(self.plays.iter().enumerate().flat_map(aside))
            .collect();
        let problem = Problem {
            n: n + self.parts.len() + 2 * self.plays.len(),
            n_goals: 1,
            n_equal: n,
            evaluate: &evaluate,
            slopes: &|_| None,
            stop: self.watch.stop,
            reached: &|_, _| (),
        };
        let found = problem.minimize(start)?;
        (found.violation < 1e-9).then(|| sign * found.values[0])
    }
}

/// A value at a corner; where the way there ends before, the last value and pose of it, if there is one.
pub(super) type AtCorner<'a> = dyn FnMut(&[f64]) -> Result<f64, Option<(f64, Pose)>> + 'a;

/// A value with the last pose of its way if that ended before the corner, the corner, and its sides.
pub(super) type Corner = (f64, Option<(Option<Pose>, Vec<f64>, Vec<&'static str>)>);

/// The ends of a result over the box of limits.
pub(super) struct Ends {
    pub(super) interval: [f64; 2],
    pub(super) at: [Vec<&'static str>; 2],
    pub(super) proved: bool,
    /// True if some parts do not assemble.
    pub(super) is_open: bool,
}
