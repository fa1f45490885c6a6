//! [`Instant`] and [`ConsistentModes`]: the question of a search for modes, and its answer.

use super::bands::Bands;
use crate::compiled::CompiledSystem;
use crate::modes::Modes;
use crate::modes::indicators::Indicator;
use crate::sampled::NoSignal;

/// An instant at which modes are to be chosen.
pub(crate) struct Instant<'a> {
    pub(crate) compiled: &'a CompiledSystem,
    /// The model's own.
    pub(crate) parameters: &'a [f64],
    /// s.
    pub(crate) t: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// The modes until now.
    pub(crate) before: &'a Modes,
    /// Indicators that have just crossed zero.
    pub(crate) fired: &'a [Indicator],
    pub(crate) bands: Bands,
}

/// Consistent modes with the state they start from.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct ConsistentModes {
    pub(crate) modes: Modes,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) a: Vec<f64>,
    pub(crate) lambda: Vec<f64>,
    /// Rows of open contacts, and rows that follow from others.
    pub(crate) inactive: Vec<usize>,
    /// Change of the kinetic energy by impacts, J.
    pub(crate) impact_work: f64,
    pub(crate) hits: Vec<Hit>,
    /// The impacts, one after the other.
    pub(crate) impacts: Vec<ImpactRecord>,
}

/// An impact: velocities change at once.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct ImpactRecord {
    /// Modes in which its rows are the active ones.
    pub(crate) modes: Modes,
    /// Rows that hold throughout.
    pub(crate) held: Vec<usize>,
    /// The stops that take an impulse: the contact, and ε as it counts here.
    pub(crate) stops: Vec<(usize, f64)>,
    /// Velocities before and after it.
    pub(crate) velocities: [Vec<f64>; 2],
}

/// A stop that bodies have run into.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Hit {
    pub(crate) contact: usize,
    /// Of approach, m/s or rad/s.
    pub(crate) speed: f64,
}

/// Why no modes are consistent.
#[derive(Clone, PartialEq, Debug)]
pub enum NoConsistentModes {
    /// Whichever branch is taken leads back to the switch.
    Chatter {
        /// The switch.
        kink: usize,
    },
    /// No set of contacts is consistent.
    Contacts {
        /// The contacts in question.
        contacts: Vec<usize>,
    },
    /// Friction of a contact that slides leaves no motion, or more than one.
    Paradox {
        /// The contact.
        contact: usize,
        /// True where several motions fit, false where none does.
        has_several: bool,
    },
    /// A signal that is held takes no finite value.
    Signal {
        /// The signal.
        signal: usize,
    },
    /// Latched signals change one another without end.
    Endless {
        /// One of them.
        signal: usize,
    },
    /// A prescribed position jumps.
    Jump {
        /// The constraint row.
        row: usize,
        /// By how much, m or rad.
        by: f64,
    },
}

impl From<NoSignal> for NoConsistentModes {
    fn from(NoSignal { signal }: NoSignal) -> Self {
        Self::Signal { signal }
    }
}
