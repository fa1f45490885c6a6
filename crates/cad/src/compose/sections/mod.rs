//! The sections of a model file, each from what the earlier stages found.
//!
//! | file | sections |
//! |---|---|
//! | `plain.rs` | name and units, parameters, `solve`: keys and values as they are |
//! | `bodies.rs` | `ground` and `bodies` |
//! | `joints.rs` | `joints` |
//! | `loads.rs` | `loads` and `drives` |
//! | `named.rs` | `tables`, `curves`, `couplings`, `states`, `clocks`, `signals`, `use` |
//! | `drawn_curves.rs` | `curves` of what is drawn on their layers |
//! | `starts.rs` | `initial` |
//! | `number.rs` | numbers without what rounding left of them |

mod bodies;
mod drawn_curves;
mod joints;
mod loads;
mod named;
mod number;
mod plain;
mod starts;

pub(super) use bodies::bodies;
pub(super) use drawn_curves::put_drawn_curves;
pub(super) use joints::joints;
pub(super) use loads::{drives, loads};
pub(super) use named::named;
pub(super) use plain::{io, parameters, solve, top};
pub(super) use starts::starts;

use bksim_model::diagnostic::Diagnostic;

use super::bodies::Bodies;
use super::connect::Connection;
use super::faults::Faults;
use super::frame::Frame;
use super::lengths::Lengths;
use super::source::Source;
use super::units::BareUnits;
use crate::attachment::Attachment;
use crate::codes;
use crate::excerpt::short;
use crate::geometry::Point;
use crate::geometry::vector::distance;

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

impl Mechanism<'_> {
    /// The name of the only joint at a point; `key` is what else would name it.
    fn joint_at(
        &self,
        attachment: &Attachment,
        at: Point,
        key: &str,
        faults: &mut Faults<'_>,
    ) -> Option<String> {
        let tolerance = self.source.scale.tolerance;
        let is_there = |connection: &&Connection<'_>| distance(connection.at[0], at) <= tolerance;
        let there = self.connections.iter().filter(is_there);
        let found: Vec<&str> = there.map(|connection| connection.name.as_str()).collect();
        if let [one] = found.as_slice() {
            return Some((*one).to_owned());
        }

        let [x, y] = at.map(short);
        let title = attachment.title();
        let message = match found.as_slice() {
            [] => format!("{title} at ({x}, {y}) is at no joint"),
            many => {
                format!("{title} at ({x}, {y}) is at {} joints: {}", many.len(), many.join(", "))
            }
        };
        let fault = Diagnostic::error(codes::NO_JOINT_THERE, message)
            .help(format!("move it onto its joint, or name the joint: `{key}=…`"));
        faults.add(fault, &attachment.location);
        None
    }
}
