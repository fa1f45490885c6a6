//! Equilibria on stops that are open at the start: each such stop in turn counts as a constraint, whose multiplier must push.

use crate::balance::Balance;
use crate::equilibrium::Equilibrium;
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::open_reactions::ReactionBound;
use crate::stops::Stops;

/// Poses from which equilibria on each stop are searched.
const N_POSES: usize = 100;
/// Part of what joints and the stop bear below which what it bears is rounding.
const NO_EFFORT: f64 = 1e-9;

/// The equilibria in which one of the stops that are open in `loaded` is closed and pushes: at the positions that are `known` of
/// stops by their numbers, else where a search finds them.
pub(crate) fn on_open_stops(
    loaded: &mut Loaded,
    bounds: &[ReactionBound],
    known: Option<&[(usize, Vec<f64>)]>,
) -> Result<Vec<Equilibrium>, AnalysisError> {
    let mut found = Vec::new();
    let stops = Stops::of(loaded)?;
    for stop in 0..stops.n() {
        let own = |(of, q): &(usize, Vec<f64>)| (*of == stop).then(|| q.clone());
        let known = known.map(|known| known.iter().filter_map(own).collect::<Vec<_>>());
        if known.as_ref().is_some_and(Vec::is_empty) {
            continue;
        }
        let row = stops.row(stop);
        let closed = loaded.with_closed(row, |loaded| on_closed_stop(loaded, row, bounds, known));
        found.extend(closed?);
    }
    Ok(found)
}

/// The equilibria in which the constraint row of a stop, which `loaded` holds, pushes.
fn on_closed_stop(
    loaded: &Loaded,
    row: usize,
    bounds: &[ReactionBound],
    known: Option<Vec<Vec<f64>>>,
) -> Result<Vec<Equilibrium>, AnalysisError> {
    let mut balance = Balance::of(loaded, &[], &[])?;
    balance.bounds = bounds.to_vec();
    let is_known = known.is_some();
    let mut poses = known.unwrap_or_else(|| {
        let n_poses = balance.affordable(N_POSES);
        balance.search_many_poses(n_poses)
    });
    poses.retain(|q| balance.stops.allow(q) && (is_known || pushes(&mut balance, q, row)));
    balance.distinct(poses.iter())
}

/// True where a row that is held bears a force that pushes.
fn pushes(balance: &mut Balance<'_>, q: &[f64], row: usize) -> bool {
    let Some(lambda) = balance.balancing(q) else { return false };
    let own = balance.loaded.kept.iter().position(|&kept| kept == row);
    let effort = own.map_or(0.0, |k| lambda[k]) * balance.unit_of_row(row);
    effort > NO_EFFORT * balance.load_size(q, &lambda).max(effort.abs())
}
