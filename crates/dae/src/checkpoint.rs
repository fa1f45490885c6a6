//! The state of a run as plain data: saved between two steps, it continues the run bit for bit.

use crate::error::SolveError;
use crate::stats::Stats;

/// State from which a run goes on exactly as if it had never been interrupted: time, state, step
/// size, the memory of the controllers, and for Radau the last polynomial and the Jacobian (its
/// factors are made again from it).
///
/// The numbers are ordered by the solver that saved them and mean nothing to others; they may be
/// stored in any form, or as [`Checkpoint::to_bytes`]. System, settings and `t_end` are not part of
/// it and must be the same for the run to be the same.
#[derive(Clone, PartialEq, Debug)]
pub struct Checkpoint {
    /// The solver that saved it.
    pub method: Method,
    /// Counters, flags and lengths.
    pub counts: Vec<u64>,
    /// All other numbers.
    pub reals: Vec<f64>,
}

/// A solver with state to save.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Method {
    /// [`crate::Solver`].
    Radau,
    /// [`crate::ExplicitSolver`].
    Explicit,
}

/// First bytes of a stored checkpoint, the last of them the version of its layout.
const MAGIC: [u8; 8] = *b"bkdae\0\0\x03";

impl Checkpoint {
    /// Checkpoint as little-endian bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let method = u64::from(self.method == Method::Explicit);
        let lengths = [method, self.counts.len() as u64, self.reals.len() as u64];
        let counts = lengths.iter().chain(&self.counts).flat_map(|x| x.to_le_bytes());
        let reals = self.reals.iter().flat_map(|x| x.to_le_bytes());
        MAGIC.into_iter().chain(counts).chain(reals).collect()
    }

    /// From the bytes of [`Checkpoint::to_bytes`].
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when they are not such bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SolveError> {
        let wrong = SolveError::Checkpoint { reason: "not the bytes of a checkpoint" };
        let mut words = bytes.as_chunks::<8>().0.iter().copied();
        if !bytes.len().is_multiple_of(8) || words.next() != Some(MAGIC) {
            return Err(wrong);
        }
        let mut number = || words.next().map(u64::from_le_bytes);
        let (Some(method), Some(n_counts), Some(n_reals)) = (number(), number(), number()) else {
            return Err(wrong);
        };
        let n_words = (bytes.len() / 8 - 4) as u64;
        if method > 1 || n_counts.checked_add(n_reals) != Some(n_words) {
            return Err(wrong);
        }
        let method = if method == 0 { Method::Radau } else { Method::Explicit };
        let counts = words.by_ref().map(u64::from_le_bytes);
        let n_counts = usize::try_from(n_counts).map_err(|_| wrong)?;
        let counts = counts.take(n_counts).collect();
        Ok(Self { method, counts, reals: words.map(f64::from_le_bytes).collect() })
    }

    /// Adds numbers after those of the run.
    pub(crate) fn append(&mut self, saver: Saver) {
        self.counts.extend(saver.counts);
        self.reals.extend(saver.reals);
    }
}

/// Collects the numbers of a checkpoint, of a solver or of the run around one.
///
/// ```
/// use bksim_dae::{Loader, Method, Saver};
///
/// let mut saver = Saver::default();
/// saver.count(3);
/// saver.slice(&[0.5, 0.25]);
/// let saved = saver.finish(Method::Radau);
/// let mut loader = Loader::new(&saved, Method::Radau)?;
/// assert_eq!((loader.count()?, loader.slice()?), (3, &[0.5, 0.25][..]));
/// # Ok::<(), bksim_dae::SolveError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Saver {
    counts: Vec<u64>,
    reals: Vec<f64>,
}

/// Empty, with room for the numbers of small systems.
impl Default for Saver {
    fn default() -> Self {
        const ROOM: usize = 256;
        Self { counts: Vec::with_capacity(ROOM), reals: Vec::with_capacity(ROOM) }
    }
}

impl Saver {
    /// Adds an integer.
    pub fn count(&mut self, x: usize) {
        self.counts.push(x as u64);
    }

    /// Adds a yes or no.
    pub fn flag(&mut self, x: bool) {
        self.counts.push(u64::from(x));
    }

    /// Adds a number, bit for bit.
    pub fn real(&mut self, x: f64) {
        self.reals.push(x);
    }

    /// Adds a number that may be missing.
    pub fn option(&mut self, x: Option<f64>) {
        self.flag(x.is_some());
        self.real(x.unwrap_or(0.0));
    }

    /// Adds numbers and how many they are.
    pub fn slice(&mut self, x: &[f64]) {
        self.count(x.len());
        self.reals.extend_from_slice(x);
    }

    /// Adds counters.
    pub fn stats(&mut self, stats: &Stats) {
        let mut stats = *stats;
        stats.counters().into_iter().for_each(|x| self.count(*x));
    }

    /// Adds the whole checkpoint of a solver.
    pub fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.flag(checkpoint.method == Method::Explicit);
        self.count(checkpoint.counts.len());
        self.counts.extend_from_slice(&checkpoint.counts);
        self.slice(&checkpoint.reals);
    }

    /// Adds indices and how many they are.
    pub fn indices(&mut self, x: &[usize]) {
        self.count(x.len());
        for &x in x {
            self.count(x);
        }
    }

    /// All that was added, as the checkpoint of a run by `method`.
    pub fn finish(self, method: Method) -> Checkpoint {
        Checkpoint { method, counts: self.counts, reals: self.reals }
    }
}

/// Hands the numbers of a checkpoint back in the order in which they were saved.
#[derive(Clone, Debug)]
pub struct Loader<'a> {
    counts: std::slice::Iter<'a, u64>,
    reals: &'a [f64],
}

const TOO_SHORT: SolveError = SolveError::Checkpoint { reason: "numbers are missing" };

impl<'a> Loader<'a> {
    /// From the first number on.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when the run was one by another method.
    pub fn new(checkpoint: &'a Checkpoint, method: Method) -> Result<Self, SolveError> {
        if checkpoint.method != method {
            return Err(SolveError::Checkpoint { reason: "saved by the other method" });
        }
        Ok(Self { counts: checkpoint.counts.iter(), reals: &checkpoint.reals })
    }

    /// True if all numbers have been handed out.
    pub fn is_empty(&self) -> bool {
        self.counts.len() == 0 && self.reals.is_empty()
    }

    /// The whole checkpoint of a solver.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when numbers are missing.
    pub fn checkpoint(&mut self) -> Result<Checkpoint, SolveError> {
        let method = if self.flag()? { Method::Explicit } else { Method::Radau };
        let n_counts = self.count()?;
        let (counts, rest) = self.counts.as_slice().split_at_checked(n_counts).ok_or(TOO_SHORT)?;
        self.counts = rest.iter();
        Ok(Checkpoint { method, counts: counts.to_vec(), reals: self.slice()?.to_vec() })
    }

    /// The next integer.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when there is none.
    pub fn count(&mut self) -> Result<usize, SolveError> {
        let count = self.counts.next().ok_or(TOO_SHORT)?;
        usize::try_from(*count)
            .map_err(|_| SolveError::Checkpoint { reason: "a count is too large" })
    }

    /// The next yes or no.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when there is none.
    pub fn flag(&mut self) -> Result<bool, SolveError> {
        Ok(self.count()? != 0)
    }

    /// The next number.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when there is none.
    pub fn real(&mut self) -> Result<f64, SolveError> {
        let (first, rest) = self.reals.split_first().ok_or(TOO_SHORT)?;
        self.reals = rest;
        Ok(*first)
    }

    /// The next number that may be missing.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when numbers are missing.
    pub fn option(&mut self) -> Result<Option<f64>, SolveError> {
        let (is_some, x) = (self.flag()?, self.real()?);
        Ok(is_some.then_some(x))
    }

    /// A slice of any length.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when numbers are missing.
    pub fn slice(&mut self) -> Result<&'a [f64], SolveError> {
        let n = self.count()?;
        let (slice, rest) = self.reals.split_at_checked(n).ok_or(TOO_SHORT)?;
        self.reals = rest;
        Ok(slice)
    }

    /// Indices, each below `end`.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when numbers are missing or too large.
    pub fn indices(&mut self, end: usize) -> Result<Vec<usize>, SolveError> {
        let n = self.count()?;
        if n > self.counts.len() {
            return Err(TOO_SHORT);
        }
        (0..n).map(|_| self.index(end)).collect()
    }

    /// An index below `end`.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when there is none, or it is too large.
    pub fn index(&mut self, end: usize) -> Result<usize, SolveError> {
        const TOO_LARGE: SolveError = SolveError::Checkpoint { reason: "an index is too large" };
        self.count().and_then(|i| if i < end { Ok(i) } else { Err(TOO_LARGE) })
    }

    /// Overwrites a slice whose length is known.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when it was saved with another length.
    pub fn fill(&mut self, out: &mut [f64]) -> Result<(), SolveError> {
        let slice = self.slice()?;
        if slice.len() != out.len() {
            return Err(SolveError::Checkpoint { reason: "saved for a system of another size" });
        }
        out.copy_from_slice(slice);
        Ok(())
    }

    /// The next counters.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when numbers are missing.
    pub fn stats(&mut self) -> Result<Stats, SolveError> {
        let mut stats = Stats::default();
        for counter in stats.counters() {
            *counter = self.count()?;
        }
        Ok(stats)
    }
}
