//! Text and files from outside stay there: names that a terminal would obey, files of other folders, names that
//! promise another format.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;

use crate::common::{CRATE, Scratch, text};

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

/// A slider that follows a table of another file.
const OF_TABLE: &str = "[bodies.cart]\nmass = \"1 kg\"\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\n\
                        axis = [1, 0]\n[tables.m]\nfile = \"m.csv\"\n[drives.d]\njoint = \"S\"\nmotion = \"m(t)\"\n";

/// Message about a model with another file next to it, which is refused.
fn refused(model: &str, (file, bytes): (&str, &[u8])) -> String {
    let place = Scratch::new();
    place.write("model.toml", model);
    place.write(file, bytes);
    let output = place.run("check model.toml");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    said
}

#[test]
fn every_cell_without_a_number_is_named_in_its_file() {
    let said =
        refused(OF_TABLE, ("m.csv", b"t [s], x [m]\n0, 0\n0.1, NaN\n0.2, #DIV/0!\n1, 0.1\n"));
    for fact in ["`NaN` is no number", "m.csv:3:6", "`#DIV/0!` is no number", "m.csv:4:6"] {
        assert!(said.contains(fact), "{fact}: {said}");
    }
    assert_eq!(
        said.matches("help: write the value that was measured, or remove the row").count(),
        2
    );
}

#[test]
fn files_of_other_kinds_are_named_by_their_first_bytes() {
    let kinds: [(&[u8], &str); 3] = [
        (b"\x89MCAP0\r\n", "a log (MCAP)"),
        (b"PK\x03\x04", "an archive (ZIP)"),
        (b"%PDF-1.7", "a PDF"),
    ];
    for (bytes, kind) in kinds {
        let place = Scratch::new();
        std::fs::write(place.path().join("m.toml"), bytes).expect("a file");
        let output = place.bksim().args(["check", "m.toml"]).output().expect("bksim starts");
        let said = text(&output.stderr);
        assert!(said.contains(&format!("the file is {kind}")), "{said}");
        assert!(said.contains("help: "), "{said}");
    }
}

#[test]
fn a_table_in_utf_16_is_called_so() {
    let rows: Vec<u8> =
        "\u{FEFF}t\tx\r\n0\t0\r\n1\t0.1\r\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let said = refused(OF_TABLE, ("m.csv", &rows));
    assert!(said.contains("the file is UTF-16, not UTF-8"), "{said}");
    assert!(said.contains("help: save the file with the encoding UTF-8"), "{said}");
}

#[test]
fn a_mesh_that_ends_too_early_says_where() {
    let model = "[bodies.bob]\ndensity = \"7850 kg/m^3\"\nfree = true\n\
                 shapes = [{ type = \"mesh\", file = \"m.stl\", unit = \"mm\" }]\n";
    let mut bytes = vec![b'x'; 80];
    bytes.extend(4_000_000_000_u32.to_le_bytes());
    bytes.extend([0; 100]);
    let said = refused(model, ("m.stl", &bytes));
    assert!(said.contains("ends at byte 184"), "{said}");
    assert!(
        said.contains("the 4000000000 faces that it counts would end at byte 200000000084"),
        "{said}"
    );
}

#[test]
fn a_link_to_itself_is_called_so() {
    let place = Scratch::new();
    let model = "[use.p]\nfile = \"loop.toml\"\n[bodies.b]\nmass = 1\nfree = true\n";
    place.write("model.toml", model);
    symlink("loop.toml", place.path().join("loop.toml")).expect("a link");
    let output = place.run("check model.toml");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("it is a link that leads back to itself"), "{said}");
    assert!(said.contains("put a file in the place of the link `loop.toml`"), "{said}");
}

/// A model without masses, which no run can follow, has positions.
#[test]
fn a_model_without_masses_says_what_can_be_asked_of_it() {
    let place = Scratch::new();
    place.write(
        "model.toml",
        "[ground]\npoints = { A = [0, 0], D = [3, 0] }\n[bodies.crank]\npoints = { A = [0, 0], B = [1, 0] }\n\
         [bodies.coupler]\npoints = { B = [0, 0], C = [3, 0] }\n[bodies.rocker]\npoints = { D = [0, 0], C = [1.5, 0] }\n\
         [joints]\nA = { type = \"revolute\", between = [\"ground.A\", \"crank.A\"] }\n\
         B = { type = \"revolute\", between = [\"crank.B\", \"coupler.B\"] }\n\
         C = { type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }\n\
         D = { type = \"revolute\", between = [\"ground.D\", \"rocker.D\"] }\n",
    );
    let output = place.run("check model.toml");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("warning[S030]") && said.contains("`bksim kinematics`"), "{said}");
    assert_eq!(said.matches("warning").count(), 1, "{said}");
    // Another fault is one for every question.
    let output = place.run("check model.toml --set crank.B.1=wide");
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
}
