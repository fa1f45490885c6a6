//! `bksim info`, and what `info` and `export` refuse.

use std::fs;

use crate::common::{CRATE, Scratch, other_mcap, text};
use serde_json::Value;

fn run(place: &Scratch, arguments: &str) -> String {
    let output = place.run(arguments);
    assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn json(place: &Scratch, arguments: &str) -> Value {
    serde_json::from_str(&run(place, &format!("{arguments} --json"))).expect("one object")
}

/// A place with the log of an example.
fn solved(options: &str) -> Scratch {
    let place = Scratch::new();
    let model = fs::read(format!("{CRATE}/../../examples/spring-pendulum/model.toml"));
    place.write("spring-pendulum.toml", model.expect("an example"));
    run(&place, &format!("solve spring-pendulum.toml {options}"));
    place
}

#[test]
fn information_tells_what_is_there() {
    let place = solved("--t-end 0.5 --set k=90");
    let words = run(&place, "info spring-pendulum.mcap");
    for expected in [
        "spring-pendulum",
        "energy.kinetic",
        "51 from t = 0 s to 0.5 s",
        "set.k",
        "1.5 N s/m",
        "steps,",
    ] {
        assert!(words.contains(expected), "`{expected}` in\n{words}");
    }
    let object = json(&place, "info spring-pendulum.mcap");
    assert_eq!((&object["complete"], &object["reached_end"]), (&true.into(), &true.into()));
    assert_eq!(object["channels"][0]["samples"], 51);
    assert!(object["motion"]["steps"].as_u64() > Some(0));

    place.write("other.mcap", other_mcap());
    let words = run(&place, "info other.mcap");
    for expected in
        ["holds no run of bksim", "ros2", "some writer", "/chatter", "demo.Chatter", "json"]
    {
        assert!(words.contains(expected), "`{expected}` in\n{words}");
    }
}

#[test]
fn what_is_no_log_or_table_is_refused() {
    let place = solved("--t-end 0.1");
    place.write("notes.txt", "neither a log = nor a model");
    let cases = [
        ("info missing.mcap", 4, "there is no such file"),
        ("info notes.txt", 1, "notes.txt:1"),
        ("export spring-pendulum.mcap -o a.xlsx", 2, ".csv or .parquet"),
    ];
    for (arguments, status, words) in cases {
        let output = place.run(arguments);
        let message = text(&output.stderr);
        let found = output.status.code();
        assert!(
            found == Some(status) && message.contains(words),
            "{arguments}: {found:?} {message}"
        );
    }
}
