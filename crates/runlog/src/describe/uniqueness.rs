//! Reactions that are not unique, by the names of their channels.

use bksim_sim::redundancy::{Uniqueness, UniquenessChange};
use serde_json::{Value, json};

use crate::channels::Channels;
use bksim_sim::Mechanism;

/// From when on which channels hold one of many solutions of the equilibrium.
pub fn uniqueness(mechanism: &Mechanism, changes: &[UniquenessChange]) -> Vec<Value> {
    let channels = Channels::new(mechanism);
    let change = |change: &UniquenessChange| {
        let Uniqueness { n_self_stresses, .. } = change.uniqueness;
        json!({
            "t": change.t,
            "self_stresses": n_self_stresses,
            "not_unique": channels.not_unique(&change.uniqueness),
        })
    };
    changes.iter().map(change).collect()
}
