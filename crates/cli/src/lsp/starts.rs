//! Starts of models, looked for while an editor goes on: after a pause in writing, one at a time, and given up where
//! the text has changed meanwhile.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, after, never, unbounded};

use super::document::Document;
use super::faults::{Judged, Shown, judge};

/// Time without a change after which a start is looked for.
const PAUSE: Duration = Duration::from_millis(300);

/// The number of a text among those that a document has had, for a thread to see that it has changed.
pub(super) type Number = Arc<AtomicU64>;

/// Findings about the start of a text.
pub(super) struct Started {
    pub(super) uri: String,
    /// Number of the text.
    pub(super) number: u64,
    /// Faults and warnings; `None` where the text has changed, or no start was looked for.
    pub(super) shown: Option<Vec<Shown>>,
}

/// Texts that wait for their start.
pub(super) struct Starts {
    due: BTreeMap<String, Instant>,
    is_busy: bool,
    sender: Sender<Started>,
    /// Starts that have been found.
    pub(super) found: Receiver<Started>,
}

impl Starts {
    pub(super) fn new() -> Self {
        let (sender, found) = unbounded();
        Self { due: BTreeMap::new(), is_busy: false, sender, found }
    }

    /// Looks for the start of a text after a pause.
    pub(super) fn ask(&mut self, uri: &str) {
        self.due.insert(uri.to_owned(), Instant::now() + PAUSE);
    }

    /// A message at the time when a start is due.
    pub(super) fn timer(&self) -> Receiver<Instant> {
        match self.due.values().min() {
            Some(due) if !self.is_busy => after(due.saturating_duration_since(Instant::now())),
            _ => never(),
        }
    }

    /// The document whose start is due.
    pub(super) fn next(&mut self) -> Option<String> {
        let (uri, _) = self.due.iter().min_by_key(|(_, due)| **due)?;
        let uri = uri.clone();
        self.due.remove(&uri);
        Some(uri)
    }

    /// Looks for the start of a text on a thread of its own, which does not outlive the program.
    pub(super) fn begin(
        &mut self,
        uri: String,
        document: Document,
        number: Number,
        nesting: usize,
        pages: Option<String>,
    ) {
        let sender = self.sender.clone();
        self.is_busy = true;
        let own = number.load(Ordering::Relaxed);
        thread::spawn(move || {
            let is_current = || number.load(Ordering::Relaxed) == own;
            let started = judge(&document, nesting).started(&is_current);
            let shown = |judged: Judged| judged.shown(&document, pages.as_deref());
            // Nobody listens at the end.
            let _ = sender.send(Started { uri, number: own, shown: started.map(shown) });
        });
    }

    /// Takes note that a start has been found.
    pub(super) fn end(&mut self) {
        self.is_busy = false;
    }
}
