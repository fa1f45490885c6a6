//! Starts of linkages whose assemblies are all known: how many find the one that was meant, and how
//! long they take. `tests/data/assemblies` says what is right.

mod trials;

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::json;

use crate::context::Context;
use crate::report::{Check, Report, Table, seconds};
use trials::{Outcome, Trial, Verdict, trials};

const FILES: [&str; 2] = [
    include_str!("../../../tests/data/assemblies/planar.json"),
    include_str!("../../../tests/data/assemblies/spatial.json"),
];

/// Every coordinate of every linkage in every assembly.
pub(crate) fn measure(context: &Context) -> Report {
    let some = context.effort.is_quick.then_some(1);
    let stride = if context.effort.is_quick { 10 } else { 1 };
    let outcomes: Vec<Outcome> =
        FILES.iter().flat_map(|text| trials(text, (0, stride), some)).collect();
    let mut report = Report::new("starts", "starts of linkages: right / wrong / refused");
    let words = ["exact guess", "10° off", "no guess", "stated"];
    let all = [Trial::Exact, Trial::Off, Trial::NoGuess, Trial::Stated];

    // One row per class, one for all.
    let mut classes: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
    for outcome in &outcomes {
        classes.entry(&outcome.class).or_default().push(outcome);
    }
    classes.insert("~ all", outcomes.iter().collect());
    let head = ["linkages"].into_iter().chain(words).chain(["median", "longest"]);
    let mut table = Table::new(head);
    for (class, of_class) in &classes {
        let counts = all.map(|trial| counted(of_class, trial).map(|n| n.to_string()).join(" / "));
        let (median, longest) = times(of_class);
        let times = [median, longest].map(|time| seconds(time.as_secs_f64()));
        let class = class.trim_start_matches("~ ").to_owned();
        report
            .numbers
            .insert(class.clone(), json!({ "counts": counts, "longest_s": longest.as_secs_f64() }));
        table.push([class].into_iter().chain(counts).chain(times));
    }
    report.tables.push(table);

    // Goals, and what was missed.
    let outcomes: Vec<&Outcome> = outcomes.iter().collect();
    for (trial, word) in all.into_iter().zip(words) {
        let [right, wrong, refused] = counted(&outcomes, trial);
        let missed = (wrong + refused) as f64 / (right + wrong + refused) as f64;
        let bound = if trial == Trial::Off { 0.02 } else { 0.0 };
        report.checks.push(Check::at_most(format!("part missed, {word}"), missed, bound));
    }
    for outcome in outcomes.iter().filter(|outcome| outcome.verdict != Verdict::Right) {
        let Outcome { id, trial, verdict, statement, .. } = outcome;
        report.notes.push(format!("{id}, {trial:?}: {verdict:?}, {statement}"));
    }
    report
}

/// Right, wrong, refused.
fn counted(outcomes: &[&Outcome], trial: Trial) -> [usize; 3] {
    [Verdict::Right, Verdict::Wrong, Verdict::Refused]
        .map(|verdict| outcomes.iter().filter(|o| o.trial == trial && o.verdict == verdict).count())
}

/// The median and the longest time of a start.
fn times(outcomes: &[&Outcome]) -> (Duration, Duration) {
    let mut times: Vec<Duration> = outcomes.iter().map(|outcome| outcome.time).collect();
    times.sort_unstable();
    (times[times.len() / 2], times[times.len() - 1])
}
