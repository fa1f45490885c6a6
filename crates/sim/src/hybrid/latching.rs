//! Modes and latched values that agree at one instant.
//!
//! Values that a condition latches may change the forces, these the modes, and these the conditions: so modes are
//! sought again until no further condition comes to hold.

use super::consistent::{ConsistentModes, Instant, NoConsistentModes};
use crate::modes::Modes;
use crate::modes::indicators::Indicator;

/// Changes of latched values at one instant after which they are said to go on without end.
const MOST_CHANGES: usize = 100;
/// An event is located where its function has passed its band; bands this much wider hold all that is zero there.
const SLACK: f64 = 4.0;

/// A search for the modes at an instant.
pub(super) type Search = fn(Instant<'_>) -> Result<ConsistentModes, NoConsistentModes>;

/// Finds consistent modes by `search`, and the latched values that go with them; `holding` are the conditions
/// that held before the instant.
///
/// # Errors
/// [`NoConsistentModes`] says why there are none.
pub(crate) fn latched_modes(
    instant: Instant<'_>,
    mut holding: Vec<bool>,
    search: Search,
) -> Result<ConsistentModes, NoConsistentModes> {
    let Instant { compiled, parameters, t, .. } = instant;
    if compiled.latches.is_empty() {
        return search(instant);
    }
    let (mut before, bands) = (instant.before.clone(), instant.bands.clone());
    let mut fired = instant.fired.to_vec();
    let kinks = |modes: &Modes, q: &[f64], v: &[f64]| {
        let mut evaluator = compiled.indicators.at(&modes.parameters_with_modes(parameters));
        evaluator.values(t, q, v).kinks.clone()
    };
    let mut near = kinks(&before, &instant.q, &instant.v);

    let mut found = search(instant)?;
    let mut last = None;
    for _ in 0..MOST_CHANGES {
        let now = compiled.latches.holding(parameters, &found.modes);
        let state = (t, &found.q[..], &found.v[..]);
        let taken = compiled.latches.take(
            (parameters, &compiled.inputs),
            (&holding, &now),
            state,
            &mut before.held,
        )?;
        if taken.is_none() {
            return Ok(found);
        }
        (last, holding) = (taken, now);

        // A threshold that a latched value has moved away is no longer near.
        let moved = kinks(&before, &found.q, &found.v);
        fired.retain(|&indicator| match indicator {
            Indicator::Kink(k) => moved[k].abs() <= 2.0 * near[k].abs() + SLACK * bands.kinks[k],
            Indicator::Contact(_) => true,
        });
        near = moved;

        // The same instant once more, from the modes before it.
        let (q, v) = (found.q, found.v);
        let (before, fired, bands) = (&before, &fired[..], bands.clone());
        let again = search(Instant { compiled, parameters, t, q, v, before, fired, bands })?;
        let impact_work = found.impact_work + again.impact_work;
        let hits = [found.hits, again.hits.clone()].concat();
        let impacts = [found.impacts, again.impacts.clone()].concat();
        found = ConsistentModes { impact_work, hits, impacts, ..again };
    }
    Err(NoConsistentModes::Endless { signal: last.unwrap_or_default() })
}
