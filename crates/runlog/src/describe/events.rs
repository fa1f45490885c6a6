//! The switching events of a run.

use bksim_model::LoadId;
use bksim_sim::hybrid::{Change, ChangeKind};
use serde_json::{Value, json};

use bksim_sim::Mechanism;

/// Every change, in order.
pub fn events(mechanism: &Mechanism, changes: &[Change]) -> Vec<Value> {
    let event = |change: &Change| {
        let (load, word) = event_words(change.kind);
        let name = load.map(|load| mechanism.model.loads[load.0].name.as_str());
        match change.kind {
            ChangeKind::Kink(switch) => {
                let function = mechanism.system.switches[switch].function;
                let function = mechanism.model.pool.to_text(function);
                json!({ "t": change.t, "event": word, "where_zero": function })
            }
            ChangeKind::Hit(_, speed) => {
                json!({ "t": change.t, "event": word, "load": name, "speed": speed })
            }
            _ => json!({ "t": change.t, "event": word, "load": name }),
        }
    };
    changes.iter().map(event).collect()
}

/// The load that a change is about, and what happened, in a word.
pub fn event_words(kind: ChangeKind) -> (Option<LoadId>, &'static str) {
    match kind {
        ChangeKind::Kink(_) => (None, "kinks"),
        ChangeKind::Hit(load, _) => (Some(load), "hit"),
        ChangeKind::Rest(load) => (Some(load), "rested on"),
        ChangeKind::Part(load) => (Some(load), "left"),
        ChangeKind::Stick(load) => (Some(load), "sticks"),
        ChangeKind::Slide(load) => (Some(load), "slides"),
    }
}
