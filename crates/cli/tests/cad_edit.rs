//! Bodies, joints, loads and drives are attached, changed and removed from the command line.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

const DRAWING: &str = "R2010.dxf";

/// A directory with the small drawing of the library's tests.
fn scratch() -> Scratch {
    let scratch = Scratch::new();
    let path = Path::new(CRATE).join("../cad/tests/drawings").join(DRAWING);
    scratch.write("press.dxf", fs::read(path).expect("the drawing"));
    scratch
}

fn done(output: &Output) {
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
}

/// The error of a command that is rejected, and the drawing that it leaves as it was.
fn refused(scratch: &Scratch, arguments: &str) -> String {
    let before = fs::read(scratch.path().join("press.dxf")).expect("the drawing");
    let output = scratch.run(arguments);
    assert!(!output.status.success(), "{arguments}: {}", text(&output.stdout));
    assert!(output.stdout.is_empty(), "{}", text(&output.stdout));
    let after = fs::read(scratch.path().join("press.dxf")).expect("the drawing");
    assert!(before == after, "{arguments} changed the drawing");
    text(&output.stderr)
}

/// Attachments under a name: kind, handle and values.
fn listed(scratch: &Scratch, name: &str) -> Vec<(String, String, Value)> {
    let output = scratch.run("--json cad list press.dxf");
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let all = report["attachments"].as_array().expect("attachments").iter();
    let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    all.filter(|it| it["values"]["name"] == name)
        .map(|it| (word(&it["kind"]), word(&it["handle"]), it["values"].clone()))
        .collect()
}

#[test]
fn a_joint_comes_changes_and_goes() {
    let scratch = scratch();
    let original = fs::read(scratch.path().join("press.dxf")).expect("the drawing");
    done(
        &scratch.run(
            "cad joint add press.dxf S --kind slot --entity 35 --at 1,-2 --axis 90 body1=crank",
        ),
    );
    let found = listed(&scratch, "S");
    assert_eq!(found.len(), 1);
    assert_eq!((&*found[0].0, &*found[0].1), ("slot", "35"));
    assert_eq!(found[0].2["body1"], "crank");

    done(&scratch.run("cad joint set press.dxf S body1= body2=rod --at -3,4"));
    let found = listed(&scratch, "S");
    assert_eq!((&found[0].2["body1"], &found[0].2["body2"]), (&Value::Null, &"rod".into()));

    done(&scratch.run("cad joint remove press.dxf S"));
    assert!(listed(&scratch, "S").is_empty());
    assert!(fs::read(scratch.path().join("press.dxf")).expect("the drawing") == original);
}

#[test]
fn keys_of_a_block_are_its_attributes() {
    let scratch = scratch();
    done(&scratch.run("cad body set press.dxf crank mass=2.5kg"));
    let found = listed(&scratch, "crank");
    let block = found.iter().find(|it| it.1 == "44").expect("the insert");
    assert_eq!(block.2["mass"], "2.5kg");
    let error = refused(&scratch, "cad body set press.dxf crank --at 1,2");
    assert!(error.contains("move, turn or scale the insert"), "{error}");
    done(&scratch.run("cad body remove press.dxf crank --entity 44"));
    assert!(listed(&scratch, "crank").iter().all(|it| it.1 != "44"));
}

#[test]
fn a_body_spreads_over_entities() {
    let scratch = scratch();
    done(&scratch.run("cad body add press.dxf rod --entity 35 --entity 36 density=7.8e3"));
    let handles: Vec<String> = listed(&scratch, "rod").into_iter().map(|it| it.1).collect();
    assert_eq!(handles, ["35", "36"]);
    done(&scratch.run("cad body set press.dxf rod name=bar"));
    assert_eq!(listed(&scratch, "bar").len(), 2);
    done(&scratch.run("cad body remove press.dxf bar"));
    assert!(listed(&scratch, "bar").is_empty());
}

#[test]
fn what_cannot_be_done_is_told_and_nothing_is_written() {
    let scratch = scratch();
    let cases = [
        ("cad joint set press.dxf b body1=rod", "did you mean `B`?"),
        ("cad joint add press.dxf B --entity 35", "already"),
        ("cad joint add press.dxf C", "--entity"),
        ("cad joint add press.dxf C --entity 35 --entity 36", "one entity"),
        ("cad joint add press.dxf C --entity 35 mass=1", "its keys are"),
        ("cad joint add press.dxf C --entity 35 bod1=x", "did you mean `body1`?"),
        ("cad joint add press.dxf C --entity 35 --to 1,2", "leave --to out"),
        ("cad joint add press.dxf C --entity FFF", "handle FFF"),
        ("cad load add press.dxf F --entity 35", "--kind"),
        ("cad load add press.dxf F --kind revolute --entity 35", "the kinds are"),
        ("cad drive remove press.dxf D", "nothing in the drawing is a drive"),
        ("cad joint set press.dxf B body1=rod -o other.dwg", "another kind of file"),
    ];
    for (arguments, words) in cases {
        let error = refused(&scratch, arguments);
        assert!(error.contains(words), "{arguments}: `{words}` is not in\n{error}");
    }
}

#[test]
fn a_body_of_a_layer_is_edited_on_its_entities() {
    let scratch = Scratch::new();
    let layered = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n5\n1A\n8\nBK_BODY_disk\n10\n1\n20\n2\n40\n3\n0\n\
                   ENDSEC\n0\nEOF\n";
    scratch.write("press.dxf", layered);
    let error = refused(&scratch, "cad body set press.dxf disk mass=1 --units mm");
    assert!(error.contains("D062") && error.contains("BK_BODY_disk"), "{error}");
    done(&scratch.run("cad body add press.dxf disk --entity 1a mass=1 --units mm"));
    done(&scratch.run("cad body set press.dxf disk mass=2 --units mm"));
    let file = fs::read_to_string(scratch.path().join("press.dxf")).expect("the drawing");
    assert!(file.contains("\nmass=2\n") && !file.contains("\nmass=1\n"), "{file}");
}

#[test]
fn other_files_are_overwritten_only_by_force() {
    let scratch = scratch();
    scratch.write("out.dxf", "kept");
    let error = refused(&scratch, "cad joint set press.dxf B body1=rod -o out.dxf");
    assert!(error.contains("--force"), "{error}");
    assert_eq!(fs::read(scratch.path().join("out.dxf")).expect("the other file"), b"kept");
    done(&scratch.run("cad joint set press.dxf B body1=rod -o out.dxf --force"));
    assert_eq!(listed(&scratch, "B")[0].2["body1"], Value::Null);
    let out = fs::read_to_string(scratch.path().join("out.dxf")).expect("the other file");
    assert!(out.contains("body1=rod"));
    // An earlier edit of the same drawing is replaced; one that somebody has changed since is not.
    done(&scratch.run("cad joint set press.dxf B body1=disk -o out.dxf"));
    let out = fs::read_to_string(scratch.path().join("out.dxf")).expect("the other file");
    assert!(out.contains("body1=disk") && !out.contains("body1=rod"));
    scratch.write("out.dxf", out.replace("body1=disk", "body1=rod"));
    assert!(
        refused(&scratch, "cad joint set press.dxf B body1=disk -o out.dxf").contains("--force")
    );
    // Nothing is left next to them.
    assert_eq!(fs::read_dir(scratch.path()).expect("the directory").count(), 2);
}
