//! [`Recording`]: everything of a run that the way back needs.

use bksim_dae::Control;

use crate::hybrid::Passage;
use crate::redundancy::UniquenessChange;
use crate::run::{Observer, Sample, Segment, Slowness, StateSensitivity};

/// A part of a run, in the order in which it came.
pub(super) enum Piece {
    Segment(Segment),
    /// By its index.
    Sample(usize),
    Passage(Box<Passage>),
}

/// An observer that keeps the motion and its samples and hands them on.
pub(super) struct Recording<'o> {
    pub(super) pieces: Vec<Piece>,
    pub(super) samples: Vec<Sample>,
    /// True where the run was stopped because it takes too much room.
    pub(super) is_full: bool,
    n_bytes: usize,
    observer: &'o mut dyn Observer,
}

/// Most bytes that a recording takes.
const MOST_BYTES: usize = 1 << 31;

impl<'o> Recording<'o> {
    pub(super) fn new(observer: &'o mut dyn Observer) -> Self {
        Self { pieces: Vec::new(), samples: Vec::new(), is_full: false, n_bytes: 0, observer }
    }

    fn keep(&mut self, piece: Piece, n_numbers: usize) {
        if !self.is_full {
            self.n_bytes += size_of::<Piece>() + n_numbers * size_of::<f64>();
            self.is_full = self.n_bytes > MOST_BYTES;
            self.pieces.push(piece);
        }
    }
}

impl Observer for Recording<'_> {
    fn sample(&mut self, sample: &Sample, by: &[StateSensitivity]) -> Control {
        let Sample { q, lambda, reactions, signals, .. } = sample;
        let own = size_of::<Sample>() / size_of::<f64>();
        let n_numbers =
            own + 3 * q.len() + lambda.len() + reactions.as_flattened().len() + signals.len();
        self.keep(Piece::Sample(self.samples.len()), n_numbers);
        if self.is_full {
            return Control::Stop;
        }
        self.samples.push(sample.clone());
        self.observer.sample(sample, by)
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        let n_numbers = segment.values.len() + segment.modes.len() + segment.dependent.len();
        self.keep(Piece::Segment(segment.clone()), n_numbers);
        if self.observer.wants_segments() {
            self.observer.segment(segment);
        }
    }

    fn passage(&mut self, passage: &Passage) {
        self.keep(Piece::Passage(Box::new(passage.clone())), 6 * passage.after.q.len());
        self.observer.passage(passage);
    }

    fn uniqueness(&mut self, change: &UniquenessChange) {
        self.observer.uniqueness(change);
    }

    fn slow(&mut self, slowness: &Slowness) {
        self.observer.slow(slowness);
    }

    fn stops_hopeless_runs(&self) -> bool {
        self.observer.stops_hopeless_runs()
    }
}
