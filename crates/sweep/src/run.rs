//! Cases on all cores.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use bksim::sim::run::ensemble_size;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::case::Worker;
use crate::error::SweepError;
use crate::row::Row;
use crate::study::Study;

/// Callbacks that stop a sweep and show how far it is; both are called from any thread.
#[derive(Clone, Copy)]
pub struct Monitor<'a> {
    /// Asked after every step of every case.
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Called after every case with the number of those that have ended.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

impl Default for Monitor<'_> {
    /// Nobody.
    fn default() -> Self {
        Self { stop: &|| false, progress: &|_| () }
    }
}

/// Cases that have ended.
struct Counter<'a> {
    monitor: Monitor<'a>,
    n_ended: AtomicU64,
}

impl<'a> Counter<'a> {
    fn new(monitor: Monitor<'a>) -> Self {
        Self { monitor, n_ended: AtomicU64::new(0) }
    }

    fn is_stopped(&self) -> bool {
        (self.monitor.stop)()
    }

    /// Does some cases together and counts them; `None` when they were stopped.
    fn counted(&self, worker: &mut Worker<'_>, cases: Range<u64>) -> Option<Vec<Row>> {
        if self.is_stopped() {
            return None;
        }
        let rows = worker.cases(cases, self.monitor.stop);
        for _ in rows.iter().flatten() {
            let n_ended = self.n_ended.fetch_add(1, Ordering::Relaxed) + 1;
            (self.monitor.progress)(n_ended);
        }
        rows.into_iter().collect()
    }
}

impl Study {
    /// The rows of some cases, in order; `None` when `monitor` stopped them. `n_jobs` threads, or one
    /// per core for 0.
    ///
    /// # Errors
    /// [`SweepError::Threads`].
    ///
    /// # Panics
    /// When there are no such cases.
    pub fn rows(
        &self,
        cases: Range<u64>,
        n_jobs: usize,
        monitor: &Monitor<'_>,
    ) -> Result<Option<Vec<Row>>, SweepError> {
        assert!(cases.end <= self.n_cases(), "cases {cases:?} of {}", self.n_cases());
        let counter = Counter::new(*monitor);
        let n_cases = cases.end - cases.start;
        Ok(threads(n_jobs, n_cases)?.install(|| self.rows_counted(cases, None, &counter)))
    }

    /// The rows of some points, each a value for every axis in its unit, in order; `None` when `monitor` stopped them.
    /// `n_jobs` threads, or one per core for 0.
    ///
    /// # Errors
    /// [`SweepError::Threads`].
    pub fn rows_at(
        &self,
        points: &[Vec<f64>],
        n_jobs: usize,
        monitor: &Monitor<'_>,
    ) -> Result<Option<Vec<Row>>, SweepError> {
        let counter = Counter::new(*monitor);
        let n = points.len() as u64;
        let run = || self.rows_counted(0..n, Some(points), &counter);
        Ok(threads(n_jobs, n)?.install(run))
    }

    /// How many parts there are: 64 to 128, or more of 8192 cases. Few enough that writing and joining
    /// them is nothing, many enough that little is lost when a sweep is interrupted.
    pub fn n_parts(&self) -> u64 {
        self.n_cases().div_ceil(self.part_size())
    }

    /// The cases of a part; the number of threads has no part in it, so that tables do not depend on
    /// them.
    pub fn cases_of(&self, part: u64) -> Range<u64> {
        let (size, n) = (self.part_size(), self.n_cases());
        part.saturating_mul(size).min(n)..part.saturating_add(1).saturating_mul(size).min(n)
    }

    fn part_size(&self) -> u64 {
        self.n_cases().div_ceil(128).next_power_of_two().min(8192)
    }

    /// Runs the cases of parts and calls `keep` with the rows of each as soon as they are there; `None`
    /// for a part that `monitor` stopped. `n_jobs` threads, or one per core for 0.
    ///
    /// # Errors
    /// [`SweepError::Threads`].
    pub fn parts<T: Send>(
        &self,
        parts: &[u64],
        n_jobs: usize,
        monitor: &Monitor<'_>,
        keep: impl Fn(u64, Vec<Row>) -> T + Sync,
    ) -> Result<Vec<Option<T>>, SweepError> {
        let counter = Counter::new(*monitor);
        // One thread does a part: several at one would begin many before the first is done.
        let part = |&part: &u64| {
            let mut worker = Worker::new(self);
            let groups = in_groups(self.cases_of(part), ensemble_size() as u64);
            let rows = groups.map(|cases| counter.counted(&mut worker, cases));
            let rows = rows.collect::<Option<Vec<Vec<Row>>>>();
            rows.map(|rows| keep(part, rows.into_iter().flatten().collect()))
        };
        let n_parts = parts.len() as u64;
        Ok(threads(n_jobs, n_parts)?.install(|| parts.par_iter().map(part).collect()))
    }

    /// Rows ([`Study::rows`]) on the threads that this is called from.
    fn rows_counted(
        &self,
        cases: Range<u64>,
        points: Option<&[Vec<f64>]>,
        counter: &Counter<'_>,
    ) -> Option<Vec<Row>> {
        // As many together as leave every thread something to do.
        let (n, n_threads) = (cases.end - cases.start, rayon::current_num_threads() as u64);
        let size = (n / n_threads).clamp(1, ensemble_size() as u64);
        let groups: Vec<Range<u64>> = in_groups(cases, size).collect();
        let rows: Option<Vec<Vec<Row>>> = groups
            .into_par_iter()
            .map_init(|| Worker::at(self, points), |worker, cases| counter.counted(worker, cases))
            .collect();
        Some(rows?.into_iter().flatten().collect())
    }
}

/// Cases in groups of `size`, the last of which may be smaller.
fn in_groups(cases: Range<u64>, size: u64) -> impl Iterator<Item = Range<u64>> {
    let starts = (0..(cases.end - cases.start).div_ceil(size)).map(move |k| cases.start + k * size);
    starts.map(move |start| start..(start + size).min(cases.end))
}

/// Most threads for each core: more would only wait for one another.
const MOST_PER_CORE: usize = 16;

/// Threads for so many tasks: as many as are asked for, one per core for 0, but no more than have something to do.
fn threads(n_jobs: usize, n_tasks: u64) -> Result<ThreadPool, SweepError> {
    let n_threads = n_threads(n_jobs, n_tasks);
    let name = |idx| format!("sweep {idx}");
    Ok(ThreadPoolBuilder::new().num_threads(n_threads).thread_name(name).build()?)
}

fn n_threads(n_jobs: usize, n_tasks: u64) -> usize {
    let n_cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let asked = if n_jobs == 0 { n_cores } else { n_jobs.min(MOST_PER_CORE * n_cores) };
    asked.min(usize::try_from(n_tasks).unwrap_or(usize::MAX)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_no_more_than_have_something_to_do() {
        assert_eq!(n_threads(100_000, 5), 5);
        assert_eq!(n_threads(1, 5), 1);
        assert_eq!(n_threads(3, 0), 1);
        assert!(n_threads(usize::MAX, u64::MAX) <= 16 * 1024, "bounded by the cores");
        assert!(n_threads(0, u64::MAX) >= 1);
    }
}
