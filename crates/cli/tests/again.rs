//! Commands that are given again: what bksim made from the same model is replaced, and nothing else is.

use std::fs;

use crate::common::{Scratch, text};

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

#[test]
fn matrices_of_other_programs_are_replaced_unless_somebody_else_wrote_them() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    place.write("two.toml", pendulum("3 s"));
    for file in ["l.npz", "l.mat"] {
        for _ in 0..2 {
            done(&place, &format!("linearize one.toml -o {file}"));
        }
        refused(&place, &format!("linearize two.toml -o {file}"), file);
        let mut bytes = fs::read(place.path().join(file)).expect("matrices");
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(place.path().join(file), bytes).expect("edited");
        refused(&place, &format!("linearize one.toml -o {file}"), file);
    }
}

#[test]
fn tables_of_answers_are_replaced_unless_somebody_else_wrote_them() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    done(&place, "kinematics one.toml --drive A.angle=0:90deg:5 -o t.csv");
    done(&place, "kinematics one.toml --drive A.angle=0:45deg:7 -o t.csv");
    let table = fs::read_to_string(place.path().join("t.csv")).expect("a table");
    assert_eq!(table.lines().count(), 8, "{table}");
    // Somebody's measurements with the same headings, to two digits.
    let heading = table.lines().next().expect("a heading");
    let cells = vec!["0.10"; heading.split(',').count()].join(",");
    place.write("mine.csv", format!("{heading}\n{cells}\n"));
    refused(&place, "kinematics one.toml --drive A.angle=0:90deg:5 -o mine.csv", "mine.csv");
    // A name that promises another format.
    let output = place.run("kinematics one.toml --drive A.angle=0:90deg:5 -o t.parquet");
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(!place.path().join("t.parquet").exists());
}

#[test]
fn drawings_reports_and_models_of_drawings_are_replaced_unless_edited() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    for (command, file, from, to) in [
        ("cad from-toml one.toml -o one.dxf", "one.dxf", "ENDSEC", "ENDSEC "),
        ("cad to-toml one.dxf -o drawn.toml", "drawn.toml", "[", " ["),
        ("report one.toml -o one.md", "one.md", "#", "##"),
        ("report one.toml -o one.txt", "one.txt", "t =", "T ="),
        ("report one.toml -o one.json", "one.json", "0", "1"),
        ("code one.toml -o json --lang json", "json/one_terms.json", "0", "1"),
    ] {
        done(&place, command);
        done(&place, command);
        let path = place.path().join(file);
        let whole = fs::read_to_string(&path).expect("text");
        assert!(whole.contains("made by bksim from the model"), "{file}");
        fs::write(&path, whole.replacen(from, to, 1)).expect("written");
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(4), "{command}: {}", text(&output.stderr));
        fs::write(&path, whole).expect("written");
    }
    let json = fs::read_to_string(place.path().join("one.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&json).expect("an object");
    assert_eq!(report["model"], "one");
    let bad = place.run("report one.toml -o one.docx");
    assert_eq!(bad.status.code(), Some(2), "{}", text(&bad.stderr));
}

#[test]
fn a_model_stands_for_its_log_and_for_a_file() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    done(&place, "solve one.toml");
    let of_log = place.run("export one.mcap state.A_angle A.rate:rpm");
    let of_model = place.run("export one.toml state.A_angle A.rate:rpm");
    assert!(of_log.status.success(), "{}", text(&of_log.stderr));
    assert_eq!(text(&of_log.stdout), text(&of_model.stdout));
    assert!(text(&of_model.stdout).starts_with("t,state.A_angle,A.rate [rpm]\n"));
    let in_units = text(&place.run("export one.toml state --units deg,ms").stdout);
    assert!(in_units.starts_with("t [ms],state.A_angle [deg],"), "{in_units}");
    let said = text(&place.run("info one.toml").stdout);
    assert!(said.contains("one.toml") && said.contains("end time reached"), "{said}");

    // A model from standard input.
    let mut command = place.bksim();
    let text_of = std::fs::File::open(place.path().join("one.toml")).expect("the model");
    let piped = command.args(["export", "-", "state.A_angle", "A.rate:rpm"]).stdin(text_of);
    let piped = piped.output().expect("bksim starts");
    assert_eq!(text(&piped.stdout), text(&of_model.stdout), "{}", text(&piped.stderr));
    let mut command = place.bksim();
    place.write("bad.toml", "[bodies.b]\nmas = 1\n");
    let text_of = std::fs::File::open(place.path().join("bad.toml")).expect("the model");
    let bad = command.args(["check", "-"]).stdin(text_of).output().expect("bksim starts");
    assert!(text(&bad.stderr).contains("<stdin>:"), "{}", text(&bad.stderr));
}

#[test]
fn quiet_commands_say_what_is_wrong_and_nothing_else() {
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    for command in ["solve one.toml", "export one.mcap -o one.csv", "report one.toml -o one.md"] {
        let output = place.run(&format!("{command} --quiet"));
        assert!(output.status.success(), "{command}");
        assert_eq!(text(&output.stdout) + &text(&output.stderr), "", "{command}");
    }
    let table = place.run("export one.mcap state.A_angle --quiet");
    assert!(text(&table.stdout).lines().count() > 2, "what is asked for is printed");
    assert_ne!(text(&place.run("solve none.toml --quiet").stderr), "");
}

#[cfg(unix)]
#[test]
fn a_watched_model_is_solved_again_when_it_or_a_part_changes() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;
    let place = Scratch::new();
    place.write("one.toml", pendulum("2 s"));
    let mut command = place.bksim();
    command.args(["solve", "one.toml", "--watch"]).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("bksim starts");
    let mut said = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let mut watching = || {
        let is_watching = |line: &std::io::Result<String>| {
            line.as_ref().is_ok_and(|line| line.starts_with("watching one.toml"))
        };
        assert!(said.any(|line| is_watching(&line)), "it waits for changes");
    };
    watching();
    place.write("one.toml", pendulum("3 s"));
    watching();
    let table = text(&place.run("export one.mcap state.A_angle").stdout);
    assert!(table.lines().last().expect("a row").starts_with("3.0,"), "{table}");
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().is_ok());
    let _ = child.wait().expect("an end");
    let nothing = place.run("explain M012 --watch");
    assert_eq!(nothing.status.code(), Some(2), "{}", text(&nothing.stderr));
}

#[test]
fn models_of_one_name_have_logs_of_their_own() {
    let place = Scratch::new();
    let named = |length: &str| format!("name = \"arm\"\n{}", pendulum(length));
    for folder in ["x", "y", "arm"] {
        fs::create_dir(place.path().join(folder)).expect("a folder");
    }
    for (file, length) in
        [("one.toml", "2 s"), ("two.toml", "3 s"), ("x/one.toml", "4 s"), ("arm/model.toml", "5 s")]
    {
        place.write(file, named(length));
    }
    done(&place, "solve one.toml");
    done(&place, "solve two.toml");
    done(&place, "solve arm/model.toml");
    for (log, end) in [("one.mcap", "2.0,"), ("two.mcap", "3.0,"), ("arm.mcap", "5.0,")] {
        let table = text(&place.run(&format!("export {log} state.A_angle")).stdout);
        assert!(table.lines().last().expect("a row").starts_with(end), "{log}");
    }

    // Another file of the same name in another folder is another model.
    refused(&place, "solve x/one.toml", "one.mcap");
    refused(&place, "solve two.toml -o one.mcap", "one.mcap");
    done(&place, "report one.toml -o r.md");
    refused(&place, "report two.toml -o r.md", "r.md");
    done(&place, "report one.mcap -o r.md");

    // The same text is the same model, wherever it is.
    place.write("y/copy.toml", named("2 s"));
    done(&place, "solve y/copy.toml -o one.mcap");
    refused(&place, "solve one.toml --t-end 1 -o two.mcap", "two.mcap");
    done(&place, "solve two.toml -o one.mcap --force");
}

#[test]
fn a_model_with_line_ends_of_old_programs_is_read() {
    let place = Scratch::new();
    let old = pendulum("2 s").replace('\n', "\r");
    place.write("old.toml", &old);
    done(&place, "check old.toml");
    place.write("old.toml", old.replace("[solve]", "[solv]"));
    let output = place.run("check old.toml");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    // In its own line, not in the only one.
    assert!(said.contains("old.toml:") && !said.contains("old.toml:1:"), "{said}");
}
