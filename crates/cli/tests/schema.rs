//! `bksim schema`: judged by a validator of JSON Schema from elsewhere, over the examples and over models with a
//! fault in one line each.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

/// The interpreter: `BKSIM_PYTHON`, the one of `target/venv`, or the system's; `None`, with a message, where none
/// has the validator.
fn python() -> Option<PathBuf> {
    let own = Path::new(CRATE).join("../../target/venv/bin/python");
    let named = std::env::var_os("BKSIM_PYTHON").map(PathBuf::from);
    let candidates = named.into_iter().chain([own, PathBuf::from("python3")]);
    let has_validator = |python: &PathBuf| {
        let mut command = Command::new(python);
        let output = command.args(["-c", "import jsonschema"]).stderr(Stdio::null()).status();
        output.is_ok_and(|status| status.success())
    };
    let found = candidates.into_iter().find(has_validator);
    if found.is_none() {
        eprintln!("skipped: no python with jsonschema, see tests/setup.sh");
    }
    found
}

/// Models that are right: the examples, the parts of the library, and those of the reader's own tests.
fn right() -> Vec<(String, String)> {
    let root = Path::new(CRATE).join("../..");
    let mut models = Vec::new();
    let mut folders: Vec<PathBuf> =
        vec![root.join("crates/model/parts"), root.join("tests/fixtures"), root.join("crates/cli")];
    let examples = fs::read_dir(root.join("examples")).expect("examples");
    folders.extend(examples.map(|entry| entry.expect("an entry").path()));
    for folder in folders.iter().filter(|folder| folder.is_dir()) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let is_model = path.extension().is_some_and(|ending| ending == "toml")
                && path.file_name().is_some_and(|name| name != "Cargo.toml");
            if is_model {
                let name = path.strip_prefix(&root).unwrap_or(&path).display().to_string();
                models.push((name, fs::read_to_string(&path).expect("a model")));
            }
        }
    }
    models.sort();
    models
}

/// Keys whose sections have names of the author's: a wrong one is none of the schema's.
fn is_open(section: &str) -> bool {
    let parts: Vec<&str> = section.split('.').collect();
    let has_keys = ["solve", "units", "ground", "io"].contains(&parts[0]);
    let has_names = parts.len() == 1 && !has_keys;
    has_names || parts[0] == "initial" || parts.len() > 2 || parts.ends_with(&["points"])
}

/// Texts with one fault each, made from a right one: a key that nobody knows, an unknown type, a flag as text.
fn wrong(model: &str, most: usize) -> Vec<String> {
    let mut found = Vec::new();
    let mut section = String::new();
    let mut offset = 0;
    for line in model.split_inclusive('\n') {
        let (start, end) = (offset, offset + line.len());
        offset = end;
        if let Some(title) = line.trim().strip_prefix('[').and_then(|rest| rest.split(']').next()) {
            title.clone_into(&mut section);
            continue;
        }
        let Some((key, value)) = line.split_once(" = ") else { continue };
        let is_key = key.chars().all(|c| c.is_ascii_lowercase() || c == '_');
        if section.is_empty() || is_open(&section) || !is_key {
            continue;
        }
        let with = |line: &str| format!("{}{line}{}", &model[..start], &model[end..]);
        if found.len() < most {
            found.push(with(&format!("{key}x = {value}")));
        }
        if key == "type" {
            found.push(with("type = \"nothing\"\n"));
        }
        if value.trim() == "true" {
            found.push(with(&format!("{key} = \"yes\"\n")));
        }
        if key == "between" {
            found.push(with("between = \"A\"\n"));
        }
    }
    found
}

#[test]
fn models_are_judged_as_the_reader_judges_them() {
    let Some(python) = python() else { return };
    let place = Scratch::new();
    let schema = place.run("schema");
    assert!(schema.status.success(), "{}", text(&schema.stderr));
    place.write("schema.json", &schema.stdout);
    let models = right();
    assert!(models.len() > 30, "{}", models.len());
    let mut paths = Vec::new();
    for (idx, (_, model)) in models.iter().enumerate() {
        let path = format!("right{idx}.toml");
        place.write(&path, model);
        paths.push(path);
    }
    let n_right = paths.len();
    // One next to a drawing is refused without it, whatever it says.
    let is_alone = |(name, model): &&(String, String)| {
        name.starts_with("examples") && !model.contains("drawing = ")
    };
    let mut n_refused = 0;
    for (name, model) in models.iter().filter(is_alone) {
        for fault in wrong(model, 9) {
            let path = format!("wrong{}.toml", paths.len());
            place.write(&path, &fault);
            // A part of what is refused here is compared with the reader, which takes its time.
            if paths.len().is_multiple_of(8) {
                let checked = place.run(&format!("check {path}"));
                assert_eq!(checked.status.code(), Some(1), "{name}\n{fault}");
                n_refused += 1;
            }
            paths.push(path);
        }
    }
    let n_wrong = paths.len() - n_right;
    assert!(n_wrong >= 200 && n_refused >= 20, "{n_wrong}, {n_refused}");

    let script = Path::new(CRATE).join("tests/schema.py");
    let mut command = Command::new(python);
    command.arg(script).arg("schema.json").args(&paths).current_dir(place.path());
    let output = command.output().expect("the interpreter ran before");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    let judged: Vec<Value> =
        printed.lines().map(|line| serde_json::from_str(line).expect("an object")).collect();
    assert_eq!(judged.len(), paths.len());
    for (idx, judged) in judged.iter().enumerate() {
        let faults = judged["faults"].as_array().expect("faults");
        if idx < n_right {
            assert!(faults.is_empty(), "{}: {faults:?}", models[idx].0);
        } else {
            let model = fs::read_to_string(place.path().join(&paths[idx])).expect("a model");
            assert!(!faults.is_empty(), "passes the schema:\n{model}");
        }
    }
}

#[test]
fn keys_are_described_by_the_reference() {
    let place = Scratch::new();
    let schema: Value = serde_json::from_slice(&place.run("schema").stdout).expect("an object");
    let mut n = [0, 0];
    let mut pending = vec![&schema["properties"]];
    while let Some(value) = pending.pop() {
        let Some(object) = value.as_object() else { continue };
        if let Some(properties) = object.get("properties").and_then(Value::as_object) {
            for own in properties.values() {
                n[usize::from(own["description"].is_string())] += 1;
            }
        }
        pending.extend(object.values());
    }
    assert!(n[1] > 80 && n[1] > 2 * n[0], "{n:?} keys without and with a description");
}
