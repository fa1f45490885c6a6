//! Commands that are given again: what bksim made from the same model is replaced, and nothing else is.

mod common;

use std::fs;

use common::{Scratch, text};

/// A pendulum of this length, m.
fn pendulum(length: &str) -> String {
    include_str!("../../../tests/fixtures/long-pendulum.toml").replace("1e6 s", length)
}

#[track_caller]
fn done(place: &Scratch, arguments: &str) {
    let output = place.run(arguments);
    assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
}

#[track_caller]
fn refused(place: &Scratch, arguments: &str, file: &str) {
    let before = fs::read(place.path().join(file)).expect("a file");
    let output = place.run(arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{arguments}: {said}");
    assert!(said.contains(&format!("`{file}` exists (")) && said.contains("--force"), "{said}");
    assert!(fs::read(place.path().join(file)).expect("a file") == before, "{arguments}");
}

#[test]
fn a_log_of_the_same_model_is_replaced_and_no_other_file() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    place.write("two.toml", pendulum("3 s"));
    done(&place, "solve one.toml");
    done(&place, "solve one.toml --t-end 1");
    let table = text(&place.run("export one.mcap state.A_angle").stdout);
    assert!(table.lines().last().expect("a row").starts_with("1.0,"), "the log is the second one");
    refused(&place, "solve two.toml -o one.mcap", "one.mcap");
    place.write("notes.mcap", "not a log at all\n");
    refused(&place, "solve one.toml -o notes.mcap", "notes.mcap");
    // One that was cut off may be all that is left of a long run.
    let bytes = fs::read(place.path().join("one.mcap")).expect("the log");
    place.write("cut.mcap", &bytes[..bytes.len() - 9]);
    refused(&place, "solve one.toml -o cut.mcap", "cut.mcap");
}

#[test]
fn a_table_with_the_columns_of_its_log_is_replaced() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    done(&place, "solve one.toml");
    done(&place, "export one.mcap -o t.csv state.A_angle");
    done(&place, "export one.mcap -o t.csv");
    done(&place, "export one.mcap -o t.csv energy");
    let table = fs::read_to_string(place.path().join("t.csv")).expect("a table");
    assert!(table.starts_with("t,energy."), "{table}");
    for content in ["t,height\n0,1\n", "name,price\n", "notes", ""] {
        place.write("mine.csv", content);
        refused(&place, "export one.mcap -o mine.csv", "mine.csv");
    }
}

#[test]
fn code_is_replaced_unless_somebody_has_edited_it() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    for language in ["c", "rust", "python"] {
        let command = format!("code one.toml -o {language} --lang {language}");
        done(&place, &command);
        done(&place, &command);
        let folder = fs::read_dir(place.path().join(language)).expect("a folder");
        let file = folder.map(|entry| entry.expect("a file").file_name()).min().expect("a file");
        let name = format!("{language}/{}", file.to_str().expect("text"));
        let path = place.path().join(&name);
        let code = fs::read_to_string(&path).expect("code").replacen('\n', "\n\n", 1);
        fs::write(&path, code).expect("written");
        refused(&place, &command, &name);
    }
}
