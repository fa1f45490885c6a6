//! The consistent start against linkages with all their assemblies; `tests/data/assemblies` says what
//! they are and what is right.

mod trials;

use trials::{Outcome, Trial, Verdict, trials};

/// All that was not found as it was meant, with what was written.
fn missed(outcomes: &[Outcome]) -> Vec<String> {
    let missed = outcomes.iter().filter(|outcome| outcome.verdict != Verdict::Right);
    let said = |o: &Outcome| {
        let Outcome { id, class, trial, verdict, statement, time } = o;
        format!("{id} ({class}) {trial:?} {verdict:?} after {time:?}: {statement}")
    };
    missed.map(said).collect()
}

/// Every `stride`th linkage of a file from `first` on, each with one coordinate.
fn check(text: &str, (first, stride): (usize, usize), n_linkages: usize) {
    let outcomes = trials(text, (first, stride), Some(1));
    let n_without = outcomes.iter().filter(|o| o.trial == Trial::NoGuess).count();
    assert_eq!(n_without, n_linkages);
    for trial in [Trial::Exact, Trial::Off, Trial::Stated] {
        let n = outcomes.iter().filter(|o| o.trial == trial).count();
        assert!(n > n_linkages, "{n} trials of {trial:?}");
    }
    let missed = missed(&outcomes);
    assert!(missed.is_empty(), "{} of {}:\n{}", missed.len(), outcomes.len(), missed.join("\n"));
}

const PLANAR: &str = include_str!("../data/assemblies/planar.json");
const SPATIAL: &str = include_str!("../data/assemblies/spatial.json");

#[test]
fn planar_linkages_start_in_the_assembly_that_is_meant() {
    check(PLANAR, (0, 2), 73);
}

#[test]
fn the_other_planar_linkages_start_in_the_assembly_that_is_meant() {
    check(PLANAR, (1, 2), 72);
}

#[test]
fn spatial_loops_start_in_the_assembly_that_is_meant() {
    check(SPATIAL, (0, 1), 50);
}
