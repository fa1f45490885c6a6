//! Text and files from outside stay there: names that a terminal would obey, files of other folders, names that
//! promise another format.
#![cfg(unix)]

mod common;

use std::fs;
use std::os::unix::fs::symlink;

use common::{CRATE, Scratch, text};

/// The first bytes of what a terminal would obey.
fn is_obeyed(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
        || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[test]
fn names_of_other_programs_reach_no_terminal_raw() {
    let place = Scratch::new();
    let hostile = "a\u{1b}]0;title\u{7}\u{9b}2J\u{202e}b";
    place.write(&format!("{hostile}.toml"), "[bodies.\"\u{1b}[31m\u{202e}x\"]\nmass = 1\n");
    place.write("other.mcap", hostile_mcap(hostile));
    for (arguments, status) in [
        (vec!["info".to_owned(), "other.mcap".to_owned()], 0),
        (vec!["check".to_owned(), format!("{hostile}.toml")], 1),
        (vec!["export".to_owned(), format!("{hostile}.mcap")], 4),
        (vec!["solve".to_owned(), format!("{hostile}-there-is-none.toml")], 4),
    ] {
        for json in [false, true] {
            let output = place.bksim().args(&arguments).args(json.then_some("--json")).output();
            let output = output.expect("bksim starts");
            let said = text(&output.stdout) + &text(&output.stderr);
            assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said:?}");
            let at = said.find(is_obeyed);
            assert_eq!(at, None, "{arguments:?}: {:?}", &said[at.unwrap_or(0)..]);
            assert!(said.contains("title"), "{arguments:?}: {said}");
            if json && !output.stdout.is_empty() {
                let object: Result<serde_json::Value, _> = serde_json::from_slice(&output.stdout);
                assert!(object.is_ok(), "{said}");
            }
        }
    }
}

fn hostile_mcap(name: &str) -> Vec<u8> {
    let options = mcap::WriteOptions::new().profile(name).library(name);
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).expect("a writer");
    let channel = writer.add_channel(0, name, "json", &std::collections::BTreeMap::new());
    let header = mcap::records::MessageHeader {
        channel_id: channel.expect("a channel"),
        sequence: 0,
        log_time: 0,
        publish_time: 0,
    };
    writer.write_to_known_channel(&header, b"{}").expect("a message");
    writer.finish().expect("an end");
    writer.into_inner().into_inner()
}

#[test]
fn a_model_opens_files_of_its_own_folder_alone() {
    let place = Scratch::new();
    let at = |name: &str| place.path().join(name);
    let folder = format!("{CRATE}/../../examples/four-bar");
    let drawing = fs::read(format!("{folder}/drawing.dxf")).expect("a drawing");
    let model = fs::read_to_string(format!("{folder}/drawing.toml")).expect("a model");
    for name in ["own", "own/deeper", "other"] {
        fs::create_dir(at(name)).expect("a folder");
        place.write(&format!("{name}/drawing.dxf"), &drawing);
    }
    symlink(at("other/drawing.dxf"), at("own/link.dxf")).expect("a link");
    symlink(at("own/drawing.dxf"), at("own/near.dxf")).expect("a link");
    for (name, is_inside) in [
        ("drawing.dxf", true),
        ("deeper/drawing.dxf", true),
        ("near.dxf", true),
        ("link.dxf", false),
        ("../other/drawing.dxf", false),
        (at("other/drawing.dxf").to_str().expect("a path"), false),
    ] {
        let named = model.replace("drawing = \"drawing.dxf\"", &format!("drawing = \"{name}\""));
        place.write("own/model.toml", named);
        let output = place.run("check own/model.toml");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(if is_inside { 0 } else { 4 }), "{name}: {said}");
        assert_eq!(said.contains("lies outside of the folder of"), !is_inside, "{name}: {said}");
    }
}

#[test]
fn a_name_that_promises_another_format_is_refused() {
    let place = Scratch::new();
    let folder = format!("{CRATE}/../../examples/four-bar");
    for (arguments, format) in [
        (format!("solve {folder}/model.toml -o run.csv"), "CSV"),
        (format!("solve {folder}/model.toml -o run.PDF"), "PDF"),
        (format!("cad to-toml {folder}/drawing.dxf -o model.dxf"), "DXF"),
        ("cad template -o empty.csv".to_owned(), "CSV"),
        (format!("cad doctor {folder}/drawing.dxf -o marked.pdf"), "PDF"),
    ] {
        let output = place.run(&arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        assert!(said.contains(&format!("would be no {format}")), "{arguments}: {said}");
    }
    assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 0, "nothing is written");
}

#[test]
fn a_link_that_leads_nowhere_is_called_one() {
    let place = Scratch::new();
    let model = format!("{CRATE}/../../examples/four-bar/model.toml");
    symlink("nowhere", place.path().join("run.mcap")).expect("a link");
    let output = place.run(&format!("solve {model} -o run.mcap"));
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("is a link to `nowhere`, which does not exist"), "{said}");
}

#[test]
fn times_of_options_have_units_as_in_a_model() {
    let place = Scratch::new();
    place.write("long.toml", include_str!("../../../tests/fixtures/long-pendulum.toml"));
    for (options, last) in [
        ("--t-end=2", "2.0,"),
        ("--t-end=2s", "2.0,"),
        ("--t-end=1500ms --every=500ms", "1.5,"),
        ("--t-end=0.5s --step=1ms", "0.5,"),
    ] {
        let output = place.run(&format!("solve long.toml {options}"));
        assert!(output.status.success(), "{options}: {}", text(&output.stderr));
        let table = text(&place.run("export long.mcap state.A_angle").stdout);
        assert!(table.lines().last().expect("a row").starts_with(last), "{options}");
    }
    let output = place.run("solve long.toml --t-end=2m");
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("`500 ms`"), "{}", text(&output.stderr));
}
