//! Several outputs as one: the cheapest of each by itself need not be the cheapest of all, since forms
//! that differ share less.

use super::cost::{Cost, CostModel};
use crate::pool::Expr;

/// Visits to nodes while single outputs are exchanged.
const EXCHANGE_WORK: usize = 2_000_000;

/// Each output as it was or simplified, such that all together cost no more than all as they were,
/// and no more than all simplified.
pub(super) fn cheapest_together(
    model: &CostModel<'_>,
    originals: &[Expr],
    simplified: &[Expr],
) -> Vec<Expr> {
    if originals == simplified {
        return originals.to_vec();
    }
    let (before, after) = (model.cost_of_all(originals), model.cost_of_all(simplified));
    let mut least = before.min(after);
    let mut chosen = if after <= before { simplified } else { originals }.to_vec();
    if originals.len() == 1 {
        return chosen;
    }

    // Exchanges one by one, as long as each makes the whole cheaper.
    let size = usize::try_from(before.work.saturating_add(after.work)).unwrap_or(usize::MAX);
    let mut n_left = EXCHANGE_WORK / size.max(1);
    let mut has_gained = true;
    while has_gained {
        has_gained = false;
        for (k, (&original, &simple)) in originals.iter().zip(simplified).enumerate() {
            if original == simple || n_left == 0 {
                continue;
            }
            n_left -= 1;
            let kept = chosen[k];
            chosen[k] = if kept == simple { original } else { simple };
            let cost: Cost = model.cost_of_all(&chosen);
            if cost < least {
                least = cost;
                has_gained = true;
            } else {
                chosen[k] = kept;
            }
        }
    }
    chosen
}
