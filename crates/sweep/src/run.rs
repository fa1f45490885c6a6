//! Cases on all cores.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

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

    /// Does a case and counts it; `None` when it was stopped.
    fn counted(&self, worker: &mut Worker<'_>, case: u64) -> Option<Row> {
        if self.is_stopped() {
            return None;
        }
        let row = worker.case(case, self.monitor.stop)?;
        let n_ended = self.n_ended.fetch_add(1, Ordering::Relaxed) + 1;
        (self.monitor.progress)(n_ended);
        Some(row)
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
        Ok(threads(n_jobs)?.install(|| self.rows_counted(cases, &counter)))
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
            let rows = self.cases_of(part).map(|case| counter.counted(&mut worker, case));
            rows.collect::<Option<Vec<Row>>>().map(|rows| keep(part, rows))
        };
        Ok(threads(n_jobs)?.install(|| parts.par_iter().map(part).collect()))
    }

    /// As [`Study::rows`], on the threads that this is called from.
    fn rows_counted(&self, cases: Range<u64>, counter: &Counter<'_>) -> Option<Vec<Row>> {
        // Indexed, so that rayon keeps the order and splits evenly.
        let n = usize::try_from(cases.end - cases.start).expect("a plan has at most 10⁸ cases");
        let case = |idx: usize| cases.start + idx as u64;
        (0..n)
            .into_par_iter()
            .map_init(|| Worker::new(self), |w, idx| counter.counted(w, case(idx)))
            .collect()
    }
}

fn threads(n_jobs: usize) -> Result<ThreadPool, SweepError> {
    let name = |idx| format!("sweep {idx}");
    Ok(ThreadPoolBuilder::new().num_threads(n_jobs).thread_name(name).build()?)
}
