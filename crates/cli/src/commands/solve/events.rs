//! The switches of a run, in words.

use bksim::Mechanism;
use bksim::describe::event_words as words;
use bksim::model::LoadId;
use bksim::model::message::counted;
use bksim::sim::hybrid::Change;

use crate::output::number;

/// Loads that are told one by one; more are counted.
const LOADS_TOLD: usize = 6;

/// How often what happened; `None` when nothing switched.
pub(super) fn told(mechanism: &Mechanism, changes: &[Change], impacts: f64) -> Option<String> {
    // The rows of a contact have its name.
    let mut counts: Vec<(Option<&str>, &str, usize)> = Vec::new();
    for change in changes {
        let (load, word) = words(change.kind);
        let load = load.map(|LoadId(load)| mechanism.model.loads[load].name.as_str());
        match counts.iter_mut().find(|(l, w, _)| (*l, *w) == (load, word)) {
            Some((.., n)) => *n += 1,
            None => counts.push((load, word, 1)),
        }
    }
    if counts.is_empty() {
        return None;
    }
    let part = |&(load, word, n): &(Option<&str>, &str, usize)| {
        let name = load.map(|load| format!("`{load}` "));
        format!("{}{word} {n}×", name.unwrap_or_default())
    };
    let mut parts: Vec<String> = counts.iter().take(LOADS_TOLD).map(part).collect();
    if counts.len() > LOADS_TOLD {
        let n = counts.len() - LOADS_TOLD;
        parts.push(format!("and {}", counted(n, "more kind", "more kinds")));
    }
    if impacts != 0.0 {
        parts.push(format!("work of impacts {} J", number(impacts)));
    }
    Some(parts.join(", "))
}
