//! What is written, judged by an independent reader.

#[path = "common/python.rs"]
mod python;

use std::fs;
use std::path::PathBuf;

use bksim_cad::kind::KINDS;
use bksim_cad::write::Release;
use bksim_cad::write::template::{Template, template};

/// Writes a file for the judge.
fn saved(name: &str, bytes: &[u8]) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, bytes).expect("the directory of tests can be written");
    path
}

/// The facts about a drawing.
fn judged(name: &str, bytes: &[u8]) -> Vec<String> {
    let path = saved(name, bytes);
    let script = python::workspace().join("crates/cad/tests/judge.py");
    let facts = python::python(&script, &[path.to_str().expect("a UTF-8 path")]);
    facts.lines().map(str::to_owned).collect()
}

fn count(facts: &[String], start: &str) -> usize {
    facts.iter().filter(|fact| fact.starts_with(start)).count()
}

#[test]
fn templates_of_all_releases_have_every_block_and_no_fault() {
    for (release, name, _) in Release::ALL {
        let bytes = template(&Template { release, unit: "mm", size: None }).expect("a template");
        let facts = judged(&format!("template-{name}.dxf"), &bytes);
        let faults: Vec<&String> = facts.iter().filter(|f| f.starts_with("error")).collect();
        assert!(faults.is_empty(), "{name}: {faults:?}");
        assert_eq!(facts[0], format!("version {name}"));
        if release > Release::R12 {
            assert_eq!(facts[1], "units 4", "{name}");
        }
        for kind in KINDS {
            let tags: String = kind.keys.iter().map(|k| format!(" {}", k.to_uppercase())).collect();
            let is_block = |fact: &&String| {
                fact.starts_with(&format!("block {} ", kind.block)) && fact.ends_with(&tags)
            };
            assert_eq!(facts.iter().filter(is_block).count(), 1, "{name}: {}", kind.block);
            let insert = format!("insert|BK_LEGEND|{}", kind.block);
            assert_eq!(count(&facts, &insert), 1, "{name}: {}", kind.block);
        }
        assert_eq!(count(&facts, "layer BK_BODY_"), 3, "{name}");
        let outside = facts.iter().filter(|f| f.starts_with("entity") && !f.contains("BK_LEGEND"));
        assert_eq!(outside.count(), 0, "{name}: entities outside of the legend");
    }
}
