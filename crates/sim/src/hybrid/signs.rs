//! Signs of expressions of multipliers: a force in a joint that turns round is an event, so that no step contains the
//! kink of the friction or load that follows it.
//!
//! ```text
//! σ = sign u(t, q, v, λ)        f(σ) in the run, f(sign u) as it is written in the search for modes
//! ```
//!
//! λ follows from the accelerations, but its rate from nothing that is known: where u is zero the sign is the one that the
//! event has led to. What is continuous there has the same λ with either sign.

use super::bands::Bands;
use super::consistent::{ConsistentModes, Instant, NoConsistentModes};
use super::latching::{Search, latched_modes};
use crate::compiled::CompiledSystem;
use crate::modes::Modes;
use crate::modes::indicators::Indicator;

/// Finds consistent modes at an instant with the signs of all switches; `holding` are the conditions that held before.
///
/// # Errors
/// [`NoConsistentModes`] says why there are none.
pub(super) fn signed_modes(
    instant: Instant<'_>,
    holding: Vec<bool>,
    search: Search,
) -> Result<ConsistentModes, NoConsistentModes> {
    let Instant { compiled, parameters, t, before, fired, .. } = instant;
    let Some(first) = compiled.indicators.of_multipliers().next() else {
        return latched_modes(instant, holding, search);
    };
    let bands = instant.bands.clone();
    let (q, v, of_others) = (instant.q.clone(), instant.v.clone(), bands.clone());
    let found = latched_modes(instant, holding.clone(), search);
    let signs = (compiled, parameters, &bands);
    let (kink, found) = match found.map(|found| with_signs(signs, (t, before), found)) {
        Ok(Ok(found)) => return Ok(found),
        Ok(Err(kink)) => (kink, None),
        Err(fault) => (first, Some(fault)),
    };

    // Other modes have changed at the same instant, and with them the force: all is as written but what they decide.
    let is_other =
        |of: &Indicator| !compiled.indicators.of_multipliers().any(|k| *of == Indicator::Kink(k));
    let others: Vec<Indicator> = fired.iter().copied().filter(is_other).collect();
    if others.len() == fired.len() {
        return Err(found.unwrap_or(NoConsistentModes::Chatter { kink }));
    }
    let instant =
        Instant { compiled, parameters, t, q, v, before, fired: &others, bands: of_others };
    let chatters = |_| NoConsistentModes::Chatter { kink };
    let found = latched_modes(instant, holding, search).map_err(chatters)?;
    with_signs(signs, (t, before), found).map_err(|kink| NoConsistentModes::Chatter { kink })
}

/// The modes before an instant with what depends on multipliers as it is written, but where one has just passed zero.
pub(super) fn as_written(at: &Instant<'_>) -> Modes {
    let mut modes = at.before.clone();
    for k in at.compiled.indicators.of_multipliers() {
        let has_fired = at.fired.contains(&Indicator::Kink(k));
        modes.signs[k] = if has_fired { -modes.signs[k] } else { 0.0 };
    }
    modes
}

/// The signs at a state with these multipliers, on either side of which they are as before.
pub(super) fn take_signs(
    (compiled, parameters, bands): (&CompiledSystem, &[f64], &Bands),
    (t, q, v): (f64, &[f64], &[f64]),
    lambda: &[f64],
    modes: &mut Modes,
) {
    let mut indicators = compiled.indicators.at(&modes.parameters_with_modes(parameters));
    let kinks = &indicators.values_with(t, (q, v), lambda).kinks;
    for k in compiled.indicators.of_multipliers() {
        if kinks[k].abs() > bands.of_multipliers(k, lambda) {
            modes.signs[k] = kinks[k].signum();
        } else if modes.signs[k] == 0.0 {
            modes.signs[k] = 1.0;
        }
    }
}

/// Modes that were found with their signs; the first of those that were chosen and are others.
fn with_signs(
    signs: (&CompiledSystem, &[f64], &Bands),
    (t, before): (f64, &Modes),
    mut found: ConsistentModes,
) -> Result<ConsistentModes, usize> {
    let chosen = found.modes.signs.clone();
    let of_multipliers = || signs.0.indicators.of_multipliers();
    for k in of_multipliers().filter(|&k| chosen[k] == 0.0) {
        found.modes.signs[k] = before.signs[k];
    }
    let ConsistentModes { modes, q, v, lambda, .. } = &mut found;
    take_signs(signs, (t, q, v), lambda, modes);
    let is_other = |&k: &usize| chosen[k] != 0.0 && chosen[k] != found.modes.signs[k];
    match of_multipliers().find(is_other) {
        Some(kink) => Err(kink),
        None => Ok(found),
    }
}
