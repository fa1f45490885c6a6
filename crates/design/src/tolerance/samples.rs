//! Samples of parts within their limits, on all cores.

use std::sync::atomic::{AtomicU64, Ordering};

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::{Job, Play};
use crate::poses::{Pose, Solver};

/// Results at values of parts and plays; none where these do not assemble.
type Values<'a> = dyn Fn(&mut Solver<'_>, &[f64]) -> Option<Vec<f64>> + Sync + 'a;

/// Samples with generators of their own.
const CHUNK: u64 = 1000;

/// Sums over samples.
#[derive(Clone)]
pub(super) struct Sums {
    pub(super) n: u64,
    pub(super) n_open: u64,
    /// By output: offsets from the nominal value to the powers 1, 2, 3; least and largest value.
    pub(super) of: Vec<[f64; 5]>,
}

impl Job<'_> {
    /// Samples on all cores; the same for any number of them.
    pub(super) fn samples(&self, pose: &Pose, n_samples: u64, nominal: &[f64]) -> Sums {
        self.samples_of(n_samples, nominal, &|solver, point| {
            let p = (self.parameters)(point)?;
            let found = solver.follow(pose, &p, &pose.u).ok()?;
            Some(solver.raw(&found.q, &found.p, &found.u).2)
        })
    }

    pub(super) fn samples_of(&self, n_samples: u64, nominal: &[f64], values: &Values<'_>) -> Sums {
        let none = Sums {
            n: 0,
            n_open: 0,
            of: vec![[0.0, 0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY]; nominal.len()],
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
                let mut point: Vec<f64> = self
                    .parts
                    .iter()
                    .map(|part| part.middle() + part.half() * part.spread.sample(&mut rng))
                    .collect();
                for play in self.plays {
                    point.extend(Play::sample(&mut rng).map(|part| part * play.reach));
                }
                sums.n += 1;
                let Some(values) = values(&mut solver, &point) else {
                    sums.n_open += 1;
                    continue;
                };
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
