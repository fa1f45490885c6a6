//! One pose: slopes, ends and samples.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::{Band, Contributor, Job, Part, PoseTolerance};
use crate::codes;
use crate::error::DesignError;
use crate::poses::{Pose, Solver};
use crate::sqp::Problem;

/// Samples with generators of their own.
const CHUNK: u64 = 1000;

/// Sums over samples.
#[derive(Clone)]
struct Sums {
    n: u64,
    n_open: u64,
    /// By output: offsets from the nominal value to the powers 1, 2, 3; least and largest value.
    of: Vec<[f64; 5]>,
}

impl Job<'_> {
    pub(super) fn pose(
        &self,
        pose: &Pose,
        at: BTreeMap<String, f64>,
        n_samples: u64,
    ) -> Result<PoseTolerance, DesignError> {
        let mut solver = self.poses.solver();
        let singular = || {
            let message = "the nominal pose is a dead centre, in which slopes have no bound";
            DesignError::fault(
                codes::NOT_ASSEMBLED,
                message,
                "ask at another pose, or change the nominal lengths",
            )
        };
        let here = solver.outputs(pose, &[]).ok_or_else(singular)?;
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
            let nominal = here.values[k];
            let slopes: Vec<f64> = by_parts.row(k).iter().copied().collect();
            let linear: Vec<f64> =
                self.parts.iter().zip(&slopes).map(|(p, s)| (s * p.half()).abs()).collect();
            let sigma_of = |part: &Part, linear: f64| linear * part.spread.sigma();
            let worst: f64 = linear.iter().sum();
            let variance: f64 =
                self.parts.iter().zip(&linear).map(|(p, l)| sigma_of(p, *l).powi(2)).sum();
            let shift: f64 =
                self.parts.iter().zip(&slopes).map(|(p, s)| s * (p.middle() - p.nominal)).sum();
            let linear_interval = [nominal + shift - worst, nominal + shift + worst];
            let ends = self.ends(&mut solver, pose, k);
            if ends.is_open {
                assembles = Some(false);
            } else if ends.proved && assembles.is_none() {
                assembles = Some(true);
            }
            let exact = ends.interval;
            let [s1, s2, s3, least, most] = sums.of[k];
            let m = n - n_open;
            let mean = s1 / m;
            let variance_found = (s2 / m - mean * mean).max(0.0) * m / (m - 1.0);
            let sigma = variance_found.sqrt();
            let skewness = (s3 / m - 3.0 * mean * s2 / m + 2.0 * mean.powi(3)) / sigma.powi(3);
            let ratio = (linear_interval[1] - linear_interval[0]) / (exact[1] - exact[0]);
            let contributors = self.parts.iter().enumerate().map(|(i, part)| Contributor {
                name: part.name.clone(),
                unit: part.unit.clone(),
                limits: part.limits,
                distribution: part.spread.word(),
                sensitivity: slopes[i],
                linear: linear[i],
                percent_of_worst: 100.0 * linear[i] / worst,
                percent_of_variance: 100.0 * sigma_of(part, linear[i]).powi(2) / variance,
            });
            bands.push(Band {
                of: String::new(),
                unit: String::new(),
                nominal,
                linear_worst: worst,
                linear_interval,
                rss: linear.iter().map(|l| l * l).sum::<f64>().sqrt(),
                sigma_linear: variance.sqrt(),
                exact_interval: exact,
                exact_at: ends.at,
                proved: ends.proved,
                linear_fails: ends.is_open || !(0.9..1.1).contains(&ratio),
                mean: [nominal + mean, sigma / m.sqrt()],
                sigma: [sigma, sigma / (2.0 * m).sqrt()],
                skewness,
                sampled: [least, most],
                contributors: contributors.collect(),
            });
        }
        let share_without_assembly = [share, (share * (1.0 - share) / n).sqrt()];
        Ok(PoseTolerance { at, assembles, share_without_assembly, bands })
    }

    pub(super) fn nominal(&self) -> Vec<f64> {
        self.parts.iter().map(|part| part.nominal).collect()
    }

    /// Derivatives of all parameters by the parts.
    fn by_parts(&self) -> Result<DMatrix<f64>, DesignError> {
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

    /// The corner with these ends of the limits.
    pub(super) fn corner(&self, is_upper: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let end = |(k, part): (usize, &Part)| part.nominal + part.limits[usize::from(is_upper(k))];
        self.parts.iter().enumerate().map(end).collect()
    }

    fn value(
        &self,
        solver: &mut Solver<'_>,
        pose: &Pose,
        point: &[f64],
        k: usize,
    ) -> Result<f64, Option<Pose>> {
        let p = (self.parameters)(point).ok_or(None)?;
        let found = solver.follow(pose, &p, &pose.u).map_err(|(last, _)| Some(last))?;
        Ok(solver.raw(&found.q, &found.p, &found.u).2[k])
    }

    /// The ends of a result over the box.
    fn ends(&self, solver: &mut Solver<'_>, pose: &Pose, k: usize) -> Ends {
        // By the signs of all slopes, where they are proved.
        if let Some(signs) = self.signs(pose, k) {
            let of = |turn: bool| {
                let is_upper = |part: usize| (signs[part] > 0.0) != turn;
                let point = self.corner(&is_upper);
                let words = (0..self.parts.len())
                    .map(|part| if is_upper(part) { "+" } else { "-" })
                    .collect();
                (point, words)
            };
            let ((low, low_at), (high, high_at)) = (of(true), of(false));
            let low = self.value(solver, pose, &low, k);
            let high = self.value(solver, pose, &high, k);
            if let (Ok(low), Ok(high)) = (low, high) {
                return Ends {
                    interval: [low, high],
                    at: [low_at, high_at],
                    proved: true,
                    is_open: false,
                };
            }
        }
        self.searched(solver, pose, k)
    }

    /// Corners and poses where the assembly ends, then a search from the best of them.
    fn searched(&self, solver: &mut Solver<'_>, pose: &Pose, k: usize) -> Ends {
        let n = self.parts.len();
        let mut ends = [(f64::INFINITY, None), (f64::NEG_INFINITY, None)];
        let mut is_open = false;
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let n_corners = if n <= 10 { 1usize << n } else { 1024 };
        for tried in 0..n_corners + 64 {
            let point = if tried < n_corners && n <= 10 {
                self.corner(&|part| tried >> part & 1 == 1)
            } else {
                let random: Vec<bool> = (0..n).map(|_| rng.random()).collect();
                self.corner(&|part| random[part])
            };
            if (self.watch.stop)() {
                break;
            }
            let Some(p) = (self.parameters)(&point) else { continue };
            let end = match solver.follow(pose, &p, &pose.u) {
                Ok(found) => found,
                Err((last, _)) => {
                    is_open = true;
                    last
                }
            };
            let value = solver.raw(&end.q, &end.p, &end.u).2[k];
            let words: Vec<&'static str> = if end.p == p {
                (0..n).map(|i| if point[i] > self.parts[i].middle() { "+" } else { "-" }).collect()
            } else {
                Vec::new()
            };
            let found = Some((end, point, words));
            if value < ends[0].0 {
                ends[0] = (value, found.clone());
            }
            if value > ends[1].0 {
                ends[1] = (value, found);
            }
        }
        let mut interval = [ends[0].0, ends[1].0];
        let mut at = [Vec::new(), Vec::new()];
        for (side, (value, from)) in ends.into_iter().enumerate() {
            let Some((from, point, words)) = from else { continue };
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
            let parts = self.parts.iter().zip(&x[n..]);
            let parts: Vec<f64> = parts
                .map(|(part, x)| part.nominal + part.limits[0] + x * 2.0 * part.half())
                .collect();
            (q, parts)
        };
        let evaluate = |points: &[Vec<f64>]| -> Vec<Option<Vec<f64>>> {
            let mut solver = poses.solver();
            let one = |x: &Vec<f64>| {
                let (q, parts) = unscaled(x);
                let p = (self.parameters)(&parts)?;
                let (rows, determinant, outputs) = solver.raw(&q, &p, &nominal.u);
                Some([&[sign * outputs[k]][..], &rows, &[side * determinant]].concat())
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
        let start: Vec<f64> =
            vec![0.5; n].into_iter().chain(self.parts.iter().zip(point).map(reached)).collect();
        let problem = Problem {
            n: n + self.parts.len(),
            n_goals: 1,
            n_equal: n,
            evaluate: &evaluate,
            stop: self.watch.stop,
            reached: &|_, _| (),
        };
        let found = problem.minimize(start)?;
        (found.violation < 1e-9).then(|| sign * found.values[0])
    }

    /// Samples on all cores; the same for any number of them.
    fn samples(&self, pose: &Pose, n_samples: u64, nominal: &[f64]) -> Sums {
        let none = Sums {
            n: 0,
            n_open: 0,
            of: vec![[0.0, 0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY]; self.n_outputs],
        };
        let n_done = AtomicU64::new(0);
        let chunk = |number: u64| {
            let mut sums = none.clone();
            if (self.watch.stop)() {
                return sums;
            }
            let mut rng =
                Pcg64Mcg::seed_from_u64(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number);
            let mut solver = self.poses.solver();
            for _ in 0..CHUNK.min(n_samples - number * CHUNK) {
                if (self.watch.stop)() {
                    return sums;
                }
                let point: Vec<f64> = self
                    .parts
                    .iter()
                    .map(|part| part.middle() + part.half() * part.spread.sample(&mut rng))
                    .collect();
                sums.n += 1;
                let p = (self.parameters)(&point);
                let found = p.and_then(|p| solver.follow(pose, &p, &pose.u).ok());
                let Some(found) = found else {
                    sums.n_open += 1;
                    continue;
                };
                let values = solver.raw(&found.q, &found.p, &found.u).2;
                for ((sums, value), nominal) in sums.of.iter_mut().zip(&values).zip(nominal) {
                    let off = value - nominal;
                    sums[0] += off;
                    sums[1] += off * off;
                    sums[2] += off * off * off;
                    sums[3] = sums[3].min(*value);
                    sums[4] = sums[4].max(*value);
                }
            }
            let done = n_done.fetch_add(sums.n, Ordering::Relaxed) + sums.n;
            let [first, poses] = self.progress;
            let share = (first + done as f64 / n_samples as f64) / poses;
            let words = format!("pose {} of {poses}", first + 1.0);
            (self.watch.reached)(&words, share);
            sums
        };
        let chunks: Vec<Sums> = (0..n_samples.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
        chunks.into_iter().fold(none.clone(), |mut all, chunk| {
            all.n += chunk.n;
            all.n_open += chunk.n_open;
            for (all, own) in all.of.iter_mut().zip(&chunk.of) {
                for power in 0..3 {
                    all[power] += own[power];
                }
                all[3] = all[3].min(own[3]);
                all[4] = all[4].max(own[4]);
            }
            all
        })
    }
}

/// The ends of a result over the box of limits.
struct Ends {
    interval: [f64; 2],
    at: [Vec<&'static str>; 2],
    proved: bool,
    /// True if some parts do not assemble.
    is_open: bool,
}
