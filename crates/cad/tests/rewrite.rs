//! Edits change what they name and nothing else: judged by an independent reader, and by bytes.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use crate::common::python::python;
use acadrust::types::DxfVersion;
use acadrust::{DwgWriter, DxfReader};
use bksim_cad::codes;
use bksim_cad::drawing::Handle;
use bksim_cad::open::{OpenOptions, check};
use bksim_cad::patch::{Edit, Entry, apply};
use bksim_cad::tags::Tags;
use bksim_model::diagnostic::Diagnostic;

const DRAWINGS: [&str; 6] =
    ["R12.dxf", "R12_binary.dxf", "R2000.dxf", "R2010.dxf", "R2010_binary.dxf", "R2018.dxf"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/drawings")
}

fn drawing(name: &str) -> Vec<u8> {
    let path = folder().join(name);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The drawing, and for text also one with comments and Windows line ends.
fn variants() -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<(String, Vec<u8>)> =
        DRAWINGS.iter().map(|name| ((*name).to_owned(), drawing(name))).collect();
    let text = String::from_utf8(drawing("R2010.dxf")).expect("UTF-8");
    let text = text.replacen("  0\nLINE\n", "999\nthe line\n  0\nLINE\n", 1);
    let text = format!("999\nby hand\n{text}").replace('\n', "\r\n") + "\r\nbehind the end\r\n";
    all.push(("commented.dxf".to_owned(), text.into_bytes()));
    all
}

fn tags(bytes: &[u8]) -> Tags {
    check(bytes.to_vec(), &OpenOptions::default()).expect("a drawing").tags
}

/// The handle of the first entity of a kind in the model space.
fn first(tags: &Tags, kind: &str) -> Handle {
    let entities = tags.section("ENTITIES").expect("entities").tags.clone();
    let record = tags.records(entities).find(|record| tags.is_word(record.start, kind));
    tags.handle_of(record.expect("such an entity")).expect("a handle")
}

fn text(key: &str, value: &str) -> Entry {
    Entry::Text { key: key.to_owned(), value: value.to_owned() }
}

fn point(key: &str, point: [f64; 2]) -> Entry {
    Entry::Point { key: key.to_owned(), point }
}

fn change(entry: Entry) -> (String, Option<Entry>) {
    (entry.key().to_owned(), Some(entry))
}

/// An edit of each kind.
fn edits(tags: &Tags) -> Vec<(&'static str, Edit)> {
    let [line, circle, insert] = ["LINE", "CIRCLE", "INSERT"].map(|kind| first(tags, kind));
    let axis = Entry::Direction { key: "axis".to_owned(), direction: [0.0, 1.0] };
    let kind = "prismatic".to_owned();
    let entries = vec![text("name", "ślizg"), point("at", [1.5, -2.0]), axis];
    let changes = vec![
        change(text("name", "C")),
        change(text("body1", "crank")),
        ("at".to_owned(), None),
        change(point("to", [0.1, 1e-7])),
    ];
    vec![
        ("add", Edit::AddRecord { entity: line, kind: kind.clone(), entries: entries.clone() }),
        ("add_second", Edit::AddRecord { entity: circle, kind, entries }),
        ("set", Edit::SetEntries { entity: circle, record_idx: 0, entries: changes }),
        ("remove", Edit::RemoveRecord { entity: circle, record_idx: 0 }),
        ("attribute", Edit::SetAttribute { insert, tag: "name".into(), value: "żółw".into() }),
        ("insert", Edit::RemoveInsert { insert }),
    ]
}

/// Differences that ezdxf finds in each pair of files: lines by the name of the second one.
fn judged(pairs: &[(String, Vec<u8>, Vec<u8>)], scratch: &str) -> Vec<(String, Vec<String>)> {
    let folder_of = Path::new(env!("CARGO_TARGET_TMPDIR")).join(scratch);
    fs::create_dir_all(&folder_of).expect("a folder for drawings");
    let mut args = Vec::new();
    for (name, before, after) in pairs {
        for (part, bytes) in [("before", before), ("after", after)] {
            let path = folder_of.join(format!("{part}_{name}"));
            fs::write(&path, bytes).expect("a drawing is written");
            args.push(path.to_string_lossy().into_owned());
        }
    }
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let output = python(&folder().join("differences.py"), &args);
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    for line in output.lines() {
        match line.strip_prefix("== after_") {
            Some(name) => found.push((name.to_owned(), Vec::new())),
            None => found.last_mut().expect("a name first").1.push(line.to_owned()),
        }
    }
    assert_eq!(found.len(), pairs.len());
    found
}

/// The first words of the lines, and our extended data.
fn gist(lines: &[String]) -> Vec<String> {
    let short = |line: &String| {
        let name = line.split(' ').take(2).collect::<Vec<_>>().join(" ");
        if line.starts_with("BKSIM") { line.clone() } else { name }
    };
    lines.iter().map(short).collect()
}

#[test]
fn each_edit_touches_its_own_entity_alone() {
    const B: &str = "BKSIM|CIRCLE|revolute|{|name=B|at|(1.0, 2.0, 0.0)|}";
    const ADDED: &str = "prismatic|{|name=ślizg|at|(1.5, -2.0, 0.0)|axis|(0.0, 1.0, 0.0)|}";
    let mut pairs = Vec::new();
    for (name, before) in variants() {
        for (edit_name, edit) in edits(&tags(&before)) {
            let after = apply(before.clone(), std::slice::from_ref(&edit)).expect("an edit").bytes;
            pairs.push((format!("{edit_name}_{name}"), before.clone(), after));
        }
    }
    for (name, lines) in judged(&pairs, "touches") {
        let swapped = |kind: &str| vec![format!("- 0:'{kind}'"), format!("+ 0:'{kind}'")];
        let mut expected = match name.split('_').next().expect("an edit") {
            "add" if name.starts_with("add_second") => swapped("CIRCLE"),
            "add" => swapped("LINE"),
            "set" | "remove" => swapped("CIRCLE"),
            "attribute" => swapped("ATTRIB"),
            _ => ["INSERT", "ATTRIB", "ATTRIB", "SEQEND"].map(|it| format!("- 0:'{it}'")).to_vec(),
        };
        let added = ADDED.to_owned();
        match name.split('.').next().expect("an edit") {
            it if it.starts_with("add_second") => expected.push(format!("{B}|{added}")),
            it if it.starts_with("add") => {
                expected.extend([B.to_owned(), format!("BKSIM|LINE|{added}")]);
            }
            it if it.starts_with("set") => expected.push(
                "BKSIM|CIRCLE|revolute|{|name=C|body1=crank|to|(0.1, 1e-07, 0.0)|}".to_owned(),
            ),
            it if it.starts_with("remove") => (),
            _ => expected.push(B.to_owned()),
        }
        assert_eq!(gist(&lines), expected, "{name}:\n{}", lines.join("\n"));
        // Records that are only added to are still there in front.
        if name.starts_with("add") {
            assert!(lines[1][1..].starts_with(&lines[0][1..]), "{name}:\n{}", lines.join("\n"));
        }
        if name.starts_with("attribute") {
            assert!(
                lines[1].contains("1:'żółw'") || lines[1].contains(r"1:'\\U+017C"),
                "{}",
                lines[1]
            );
            let n_other = |line: &str| line.split(' ').filter(|it| !it.starts_with("1:")).count();
            assert_eq!(n_other(&lines[0]), n_other(&lines[1]), "{name}");
        }
    }
}

#[test]
fn the_application_is_registered_once_with_a_fresh_handle() {
    let mut pairs = Vec::new();
    for (name, mut before) in variants() {
        // Our name becomes another program's.
        while let Some(at) = before.windows(5).position(|part| part == b"BKSIM") {
            before[at + 4] = b'N';
        }
        let circle = first(&tags(&before), "CIRCLE");
        let record = || Edit::AddRecord {
            entity: circle,
            kind: "revolute".to_owned(),
            entries: vec![text("name", "A")],
        };
        let after = apply(before.clone(), &[record(), record()]).expect("two edits").bytes;
        let scanned = tags(&after);
        let seed = scanned.header("$HANDSEED").and_then(|idx| scanned.handle(idx));
        assert!(seed > scanned.largest_handle(), "{name}: {seed:?}");
        pairs.push((name, before, after));
    }
    for (name, lines) in judged(&pairs, "registers") {
        let mut kinds = gist(&lines);
        kinds.sort();
        let expected = [
            "+ 0:'APPID'",
            "+ 0:'CIRCLE'",
            "+ 9:'$HANDSEED'",
            "- 0:'CIRCLE'",
            "- 9:'$HANDSEED'",
            "BKSIM|CIRCLE|revolute|{|name=A|}|revolute|{|name=A|}",
        ];
        assert_eq!(kinds, expected, "{name}:\n{}", lines.join("\n"));
    }
}

#[test]
fn a_drawing_by_hand_gets_the_tables_it_lacks() {
    let by_hand = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n5\n1A\n8\n0\n10\n1.0\n20\n2.0\n40\n3.0\n0\n\
                   ENDSEC\n0\nEOF\n";
    let edit = Edit::AddRecord {
        entity: Handle(0x1A),
        kind: "revolute".to_owned(),
        entries: vec![text("name", "A")],
    };
    let after = apply(by_hand.into(), &[edit]).expect("an edit").bytes;
    let judged = judged(&[("hand.dxf".to_owned(), by_hand.into(), after)], "by_hand");
    let last = judged[0].1.last().map(String::as_str);
    assert_eq!(last, Some("BKSIM|CIRCLE|revolute|{|name=A|}"), "{judged:?}");
    assert!(!judged[0].1.iter().any(|line| line.starts_with("audit")), "{judged:?}");
}

#[test]
fn bytes_outside_of_the_edit_stay() {
    for (name, before) in variants() {
        for (edit_name, edit) in edits(&tags(&before)) {
            let after = apply(before.clone(), std::slice::from_ref(&edit)).expect("an edit").bytes;
            let same = |pair: &(&u8, &u8)| pair.0 == pair.1;
            let front = before.iter().zip(&after).take_while(same).count();
            let back = before.iter().rev().zip(after.iter().rev()).take_while(same).count();
            // A removed insert is the longest change.
            let changed = before.len().saturating_sub(front + back);
            assert!(changed < 1300, "{edit_name} of {name}: {changed} bytes of {}", before.len());
            assert_ne!(before, after, "{edit_name} of {name}");
        }
    }
}

#[test]
fn an_edit_undone_leaves_the_file_as_it_was() {
    for (name, before) in variants() {
        let tags = tags(&before);
        let [line, circle] = ["LINE", "CIRCLE"].map(|kind| first(&tags, kind));
        let add = |entity| Edit::AddRecord {
            entity,
            kind: "body".to_owned(),
            entries: vec![text("name", "crank")],
        };
        let remove = |entity, record_idx| Edit::RemoveRecord { entity, record_idx };
        let edits = [add(line), add(circle), remove(circle, 1), remove(line, 0)];
        assert_eq!(apply(before.clone(), &edits).expect("edits").bytes, before, "{name}");
    }
}

#[test]
fn what_is_not_there_or_does_not_fit_is_refused() {
    let bytes = drawing("R2010.dxf");
    let [circle, insert] = ["CIRCLE", "INSERT"].map(|kind| first(&tags(&bytes), kind));
    let long = "x".repeat(256);
    let attribute = |tag: &str, value: &str| Edit::SetAttribute {
        insert,
        tag: tag.to_owned(),
        value: value.to_owned(),
    };
    let many = vec![text("name", &"y".repeat(250)); 70];
    let cases = [
        (Edit::RemoveRecord { entity: Handle(0xFFFF), record_idx: 0 }, codes::NOT_THERE),
        (Edit::RemoveRecord { entity: circle, record_idx: 1 }, codes::NOT_THERE),
        (Edit::RemoveInsert { insert: circle }, codes::NOT_THERE),
        (attribute("COLOUR", "red"), codes::NOT_THERE),
        (attribute("NAME", &long), codes::DOES_NOT_FIT),
        (attribute("NAME", "two\nlines"), codes::DOES_NOT_FIT),
        (
            Edit::AddRecord { entity: circle, kind: "body".to_owned(), entries: many },
            codes::DOES_NOT_FIT,
        ),
    ];
    for (edit, code) in cases {
        let faults: Vec<Diagnostic> =
            apply(bytes.clone(), std::slice::from_ref(&edit)).expect_err("refused");
        assert_eq!(faults[0].code, code, "{edit:?}: {faults:?}");
    }
}

#[test]
fn a_dwg_is_written_anew_with_the_same_edits() {
    let reader = DxfReader::from_reader(Cursor::new(drawing("R2010.dxf"))).expect("a reader");
    let mut document = reader.read().expect("a drawing");
    for version in [DxfVersion::AC1015, DxfVersion::AC1024, DxfVersion::AC1032] {
        document.version = version;
        let dwg = DwgWriter::write_to_vec(&document).expect("a DWG");
        let before = tags(&dwg);
        let entities = |tags: &Tags| -> Vec<String> {
            let all = tags.records(tags.section("ENTITIES").expect("entities").tags.clone());
            all.map(|record| {
                let words: Vec<String> =
                    record.map(|idx| format!("{}:{:?}", tags.code(idx), tags.text(idx))).collect();
                words.join(" ")
            })
            .collect()
        };
        let n_before = entities(&before).len();
        for (name, edit) in edits(&before) {
            let patched = apply(dwg.clone(), std::slice::from_ref(&edit)).expect(name);
            assert_eq!(patched.warnings[0].code, codes::WRITTEN_ANEW);
            let after = entities(&tags(&patched.bytes));
            let new: Vec<&String> =
                after.iter().filter(|it| !entities(&before).contains(it)).collect();
            let (n_changed, n_gone) = if name == "insert" { (0, 4) } else { (1, 0) };
            assert_eq!((new.len(), n_before - after.len()), (n_changed, n_gone), "{name}: {new:?}");
            let words = match name {
                "add" | "add_second" => "name=ślizg",
                "set" => "body1=crank",
                "attribute" => "żółw",
                _ => "",
            };
            assert!(new.iter().all(|it| it.contains(words)), "{name}: {new:?}");
        }
    }
}
