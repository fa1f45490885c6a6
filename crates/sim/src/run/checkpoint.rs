//! A run between two steps, as plain numbers: continued, it equals the undisturbed run bit for bit.
//!
//! Nothing of the model is stored but its fingerprint: the equations, parameters, start and options
//! with which a run goes on must be those with which it began.

use bksim_dae::{Checkpoint, SolveError};

use super::problem::Problem;
use bksim_model::Outputs;

/// State between two steps from which a stopped run goes on.
#[derive(Clone, PartialEq, Debug)]
pub struct RunCheckpoint {
    fingerprint: Fingerprint,
    pub(super) numbers: Checkpoint,
}

/// Why a run cannot go on from a checkpoint.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// The model is another one.
    #[error("the checkpoint was saved with other {what}")]
    Model {
        /// Which part of it.
        what: &'static str,
    },
    /// An option is another one.
    #[error("the checkpoint was saved with `{option}` = {saved}, not {given}")]
    Option {
        /// Key of the option in `[solve]`.
        option: &'static str,
        /// Value of the option when it was saved; NaN where it was not stated.
        saved: f64,
        /// Value of the option now.
        given: f64,
    },
    /// A choice among words is another one.
    #[error("the checkpoint was saved with another `{option}`")]
    Choice {
        /// Key of the option in `[solve]`.
        option: &'static str,
    },
    /// It is damaged.
    #[error(transparent)]
    Damaged(SolveError),
}

/// First bytes of a stored checkpoint, the last of them the version of its layout.
const MAGIC: [u8; 8] = *b"bkrun\0\0\x07";

impl RunCheckpoint {
    /// Numbers with the fingerprint of the run that they belong to.
    pub(super) fn new(fingerprint: Fingerprint, numbers: Checkpoint) -> Self {
        Self { fingerprint, numbers }
    }

    /// Time of the last step, s.
    pub fn t(&self) -> f64 {
        self.numbers.reals.first().copied().unwrap_or(f64::NAN)
    }

    /// Samples that had been handed out, the start included.
    pub fn n_samples(&self) -> u64 {
        self.numbers.counts.first().copied().unwrap_or_default()
    }

    /// Checkpoint as little-endian bytes, the last four of them the CRC-32 (ISO 3309) of those before.
    pub fn to_bytes(&self) -> Vec<u8> {
        let words = self.fingerprint.0.iter().flat_map(|word| word.to_le_bytes());
        let bytes = MAGIC.into_iter().chain(words).chain(self.numbers.to_bytes());
        let mut bytes: Vec<u8> = bytes.collect();
        let checksum = crc32fast::hash(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    }

    /// From the bytes of [`RunCheckpoint::to_bytes`].
    ///
    /// # Errors
    /// [`Unfit::Damaged`] when they are not such bytes, or those of another version.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Unfit> {
        let damaged = |reason| Unfit::Damaged(SolveError::Checkpoint { reason });
        let rest = bytes.strip_prefix(&MAGIC).ok_or(damaged("it has another version"))?;
        let (rest, checksum) = rest.split_last_chunk().ok_or(damaged("numbers are missing"))?;
        if u32::from_le_bytes(*checksum) != crc32fast::hash(&bytes[..bytes.len() - 4]) {
            return Err(damaged("its checksum is another one"));
        }
        let (words, numbers) =
            rest.split_at_checked(8 * TRAITS.len()).ok_or(damaged("numbers are missing"))?;
        let mut fingerprint = Fingerprint([0; TRAITS.len()]);
        let chunks = words.as_chunks::<8>().0;
        fingerprint.0.iter_mut().zip(chunks).for_each(|(w, &c)| *w = u64::from_le_bytes(c));
        let numbers = Checkpoint::from_bytes(numbers).map_err(Unfit::Damaged)?;
        Ok(Self { fingerprint, numbers })
    }

    /// Whether it belongs to the run with this fingerprint.
    pub(super) fn check(&self, given: &Fingerprint) -> Result<(), Unfit> {
        let words = self.fingerprint.0.iter().zip(&given.0);
        let mut pairs = TRAITS.iter().zip(words);
        let Some(((what, kind), (&saved, &given))) = pairs.find(|(_, (a, b))| a != b) else {
            return Ok(());
        };
        Err(match kind {
            Kind::Model => Unfit::Model { what },
            Kind::Choice => Unfit::Choice { option: what },
            Kind::Number => Unfit::Option {
                option: what,
                saved: f64::from_bits(saved),
                given: f64::from_bits(given),
            },
        })
    }
}

/// Traits that a run must have in common with the one that goes on from its checkpoint.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Fingerprint([u64; TRAITS.len()]);

/// Meaning of a word of a fingerprint.
enum Kind {
    /// A hash.
    Model,
    /// The bits of a number.
    Number,
    /// The position of a word in its list.
    Choice,
}

const TRAITS: [(&str, Kind); 13] = [
    ("coordinates", Kind::Model),
    ("parameters", Kind::Model),
    ("initial values", Kind::Model),
    ("equations", Kind::Model),
    ("t_start", Kind::Number),
    ("t_end", Kind::Number),
    ("every", Kind::Number),
    ("output times", Kind::Model),
    ("rtol", Kind::Number),
    ("atol", Kind::Number),
    ("step", Kind::Number),
    ("method", Kind::Choice),
    ("formulation", Kind::Choice),
];

impl Fingerprint {
    /// Equations are compared by their values at the start.
    pub(super) fn of(problem: Problem<'_>) -> Self {
        let Problem { compiled, start, parameters, options, outputs, .. } = problem;
        let quantities = compiled.coordinates.iter().chain(&compiled.multipliers);
        let names = quantities.flat_map(|quantity| quantity.name.bytes().chain([0]));
        let mut evaluator = compiled.evaluator(&start.modes.parameters_with_modes(parameters));
        let at = evaluator.dynamics(start.t, &start.q, &start.v);
        let values = [at.mass, at.jacobian, at.force, at.gamma].concat();
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN).to_bits();
        Self([
            hash(names),
            hash(bytes(parameters)),
            hash(bytes(&start.q).chain(bytes(&start.v))),
            hash(bytes(&values)),
            start.t.to_bits(),
            options.t_end.to_bits(),
            or_nan(options.every),
            match outputs {
                Outputs::Even => 0,
                Outputs::Steps => 1,
                Outputs::Times(times) => hash(bytes(times)),
            },
            options.rtol.to_bits(),
            options.atol.to_bits(),
            or_nan(options.step),
            options.method as u64,
            options.formulation as u64,
        ])
    }
}

fn bytes(values: &[f64]) -> impl Iterator<Item = u8> {
    values.iter().flat_map(|value| value.to_le_bytes())
}

/// FNV-1a of 64 bits (G. Fowler, L. C. Noll, K.-P. Vo).
fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    bytes.fold(OFFSET, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}
