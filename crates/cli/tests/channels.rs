//! `bksim solve --channels own` leaves out what is there for other programs, and nothing else.

mod common;

use std::collections::BTreeSet;
use std::fs;

use common::{CRATE, Scratch, text};

/// Names of the channels of a log.
fn topics(log: &[u8]) -> BTreeSet<String> {
    let summary = mcap::Summary::read(log).expect("an MCAP file").expect("its summary");
    summary.channels.values().map(|channel| channel.topic.clone()).collect()
}

#[test]
fn a_log_without_the_channels_of_other_programs_has_all_of_its_own() {
    let place = Scratch::new();
    let example = format!("{CRATE}/../../examples/spring-pendulum/model.toml");
    for which in ["all", "own"] {
        let output = place.run(&format!("solve {example} --channels {which} -o {which}.mcap"));
        assert!(output.status.success(), "{}", text(&output.stderr));
        let output = place.run(&format!("export {which}.mcap -o {which}.csv"));
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let read = |name: &str| fs::read(place.path().join(name)).expect("a file");
    let [all, own] = ["all.mcap", "own.mcap"].map(read);
    let [all_topics, own_topics] = [topics(&all), topics(&own)];
    assert!(own_topics.is_subset(&all_topics), "{own_topics:?}");
    let left_out: Vec<&str> = all_topics.difference(&own_topics).map(String::as_str).collect();
    assert_eq!(
        left_out,
        ["/joint_states", "/outlines/bob", "/outlines/ground", "/scene", "/spans", "/tf"]
    );
    assert!(2 * own.len() < all.len(), "{} of {} bytes", own.len(), all.len());

    // Every number is there.
    assert!(read("all.csv") == read("own.csv"), "the tables differ");
    let output = place.run("info own.mcap");
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn what_is_no_choice_of_channels_is_refused() {
    let place = Scratch::new();
    let output = place.run("solve model.toml --channels some");
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("all") && said.contains("own"), "{said}");
}
