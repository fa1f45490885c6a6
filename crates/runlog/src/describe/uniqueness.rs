//! Reactions that are not unique, by the names of their channels.

use bksim_log::NotUnique;
use bksim_sim::Mechanism;
use bksim_sim::redundancy::UniquenessChange;
use serde_json::{Value, json};

use crate::channels::Channels;

/// From when on which channels hold one of many solutions of the equilibrium.
pub fn uniqueness(mechanism: &Mechanism, changes: &[UniquenessChange]) -> Vec<Value> {
    let channels = Channels::new(mechanism);
    let change = |change: &UniquenessChange| NotUnique {
        t: change.t,
        n_self_stresses: change.uniqueness.n_self_stresses,
        channels: channels.not_unique(&change.uniqueness),
    };
    logged_uniqueness(&changes.iter().map(change).collect::<Vec<_>>())
}

/// Uniqueness ([`uniqueness`]) of what a log holds, also one that was cut.
pub fn logged_uniqueness(changes: &[NotUnique]) -> Vec<Value> {
    let change = |NotUnique { t, n_self_stresses, channels }: &NotUnique| json!({ "t": t, "self_stresses": n_self_stresses, "not_unique": channels });
    changes.iter().map(change).collect()
}
