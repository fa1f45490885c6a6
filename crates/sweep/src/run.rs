//! Cases on all cores.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::case::{Row, Worker};
use crate::error::SweepError;
use crate::study::Study;

/// Who may stop a sweep, and who is told how far it is; both from any thread.
#[derive(Clone, Copy)]
pub struct Monitor<'a> {
    /// Asked after every step of every case.
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Told after every case how many have ended.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

impl Default for Monitor<'_> {
    /// Nobody.
    fn default() -> Self {
        Self { stop: &|| false, progress: &|_| () }
    }
}

/// Cases that have ended.
pub(crate) struct Counter<'a> {
    monitor: Monitor<'a>,
    n_ended: AtomicU64,
}

impl<'a> Counter<'a> {
    pub(crate) fn new(monitor: Monitor<'a>, n_ended: u64) -> Self {
        Self { monitor, n_ended: AtomicU64::new(n_ended) }
    }

    pub(crate) fn is_stopped(&self) -> bool {
        (self.monitor.stop)()
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
        let counter = Counter::new(*monitor, 0);
        Ok(threads(n_jobs)?.install(|| self.rows_counted(cases, &counter)))
    }

    /// As [`Study::rows`], on the threads that this is called from.
    pub(crate) fn rows_counted(
        &self,
        cases: Range<u64>,
        counter: &Counter<'_>,
    ) -> Option<Vec<Row>> {
        let case = |worker: &mut Worker<'_>, case: u64| {
            if counter.is_stopped() {
                return None;
            }
            let row = worker.case(case, counter.monitor.stop)?;
            let n_ended = counter.n_ended.fetch_add(1, Ordering::Relaxed) + 1;
            (counter.monitor.progress)(n_ended);
            Some(row)
        };
        // Indexed by place, so that rayon keeps the order and splits evenly.
        let n = usize::try_from(cases.end - cases.start).unwrap_or(usize::MAX);
        let place = |idx: usize| cases.start + idx as u64;
        (0..n)
            .into_par_iter()
            .map_init(|| Worker::new(self), |w, idx| case(w, place(idx)))
            .collect()
    }
}

pub(crate) fn threads(n_jobs: usize) -> Result<ThreadPool, SweepError> {
    let name = |idx| format!("sweep {idx}");
    Ok(ThreadPoolBuilder::new().num_threads(n_jobs).thread_name(name).build()?)
}
