//! All that is said of a start which was found: warnings in the order in which they matter, each fault once.

use super::{corner, dead_centre, diagnose_guesses, diagnose_mobility, diagnose_turns};
use crate::codes;
use crate::compiled::CompiledSystem;
use crate::mobility::Mobility;
use crate::start::Start;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::code;

/// The warnings about a start, after those that the reading of the model gave.
pub fn diagnose_at_start(
    (model, system): (&Model, &SymbolicSystem),
    (compiled, parameters): (&CompiledSystem, &[f64]),
    start: &Start,
    found: &Mobility,
    read: Vec<Diagnostic>,
) -> Vec<Diagnostic> {
    // Where one direction has left the plane by mistake, all that repeats or locks follows from it.
    let is_left =
        read.iter().any(|of| [code::GRAVITY_ACROSS, code::AXIS_IN_PLANE].contains(&of.code));
    let follows =
        |of: &Diagnostic| is_left && [codes::REDUNDANT, codes::NO_MOBILITY].contains(&of.code);
    let mut warnings = read;
    warnings.extend(diagnose_guesses(model, system, start));
    warnings.extend(diagnose_mobility(model, found).into_iter().filter(|of| !follows(of)));
    warnings.extend(diagnose_turns(model, system));
    warnings.extend(corner::rate_jumps(model));
    warnings.extend(dead_centre::at_rest((model, system), (compiled, parameters), start));
    warnings
}
