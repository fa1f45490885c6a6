//! The sections of a model file, each from what the earlier stages found.
//!
//! | file | sections |
//! |---|---|
//! | `plain.rs` | name and units, parameters, `solve`: keys and values as they are |
//! | `bodies.rs` | `ground` and `bodies` |
//! | `joints.rs` | `joints` |
//! | `loads.rs` | `loads` and `drives` |
//! | `starts.rs` | `initial` |
//! | `number.rs` | numbers without what rounding left of them |

mod bodies;
mod joints;
mod loads;
mod number;
mod plain;
mod starts;

pub(super) use bodies::bodies;
pub(super) use joints::joints;
pub(super) use loads::{drives, loads};
pub(super) use plain::{parameters, solve, top};
pub(super) use starts::starts;

use super::bodies::Bodies;
use super::connect::Connection;
use super::frame::Frame;
use super::lengths::Lengths;
use super::source::Source;
use super::units::BareUnits;

/// The mechanism of a drawing, as the sections describe it.
pub(super) struct Mechanism<'a> {
    pub(super) source: Source<'a>,
    pub(super) bodies: &'a Bodies,
    pub(super) connections: &'a [Connection<'a>],
    /// By body.
    pub(super) frames: &'a [Frame],
    pub(super) units: &'a BareUnits,
    /// Positions and lengths that follow from named lengths.
    pub(super) lengths: &'a Lengths,
}
