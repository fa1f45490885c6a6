//! Faults through the command itself: exit status, the whole of stderr, files untouched.
//!
//! Each `faults/*.case` says what is run and, below `--- stderr`, what is printed. Lines of the
//! upper part, in order:
//!
//! ```text
//! base: NAME            the model, from faults/models/NAME.toml, becomes `model.toml`
//! drawing: NAME         the drawing, from faults/models/NAME.dxf, becomes `model.dxf`
//! replace: OLD => NEW   a change to it
//! stop: TEXT            takes away everything from TEXT on
//! append: 63 61 66 e9   bytes after it, hexadecimal
//! nest: N               the model is `x = ` and N brackets instead
//! given: FILE           a file that is there before and must not be touched
//! absent: FILE          a file that must not be there afterwards
//! run: ARGUMENTS        runs the command; the last one counts
//! cut: FILE             cuts a log where it tells its end: no sample is lost
//! exit: STATUS          of the last run
//! ```
//!
//! With `BKSIM_BLESS=1` the expected texts are rewritten from what is printed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{CRATE, Scratch, text};

const MARK: &str = "--- stderr\n";
const GIVEN: &[u8] = b"kept\n";

fn cases() -> Vec<PathBuf> {
    let found = fs::read_dir(Path::new(CRATE).join("tests/faults")).expect("tests/faults");
    let mut found: Vec<PathBuf> = found.map(|entry| entry.expect("an entry").path()).collect();
    found.retain(|path| path.extension().is_some_and(|ending| ending == "case"));
    found.sort();
    found
}

struct Outcome {
    output: Output,
    exit: i32,
    touched: Vec<String>,
    took: Duration,
}

fn play(script: &str) -> Outcome {
    let place = Scratch::new();
    let mut model: Vec<u8> = Vec::new();
    let mut name = "model.toml";
    let (mut output, mut exit, mut took) = (None, 0, Duration::ZERO);
    let (mut given, mut absent) = (Vec::new(), Vec::new());
    for line in script.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
        let (key, value) = line.split_once(": ").expect("`key: value`");
        match key {
            "base" => {
                let path = format!("{CRATE}/tests/faults/models/{value}.toml");
                model = fs::read(path).expect("a base model");
            }
            "drawing" => {
                let path = format!("{CRATE}/tests/faults/models/{value}.dxf");
                model = fs::read(path).expect("a base drawing");
                name = "model.dxf";
            }
            "stop" => {
                let text = String::from_utf8(model).expect("text before `append`");
                let at = text.find(&value.replace("\\n", "\n")).expect("what to stop at");
                model = text.as_bytes()[..at].to_vec();
            }
            "replace" => {
                let (old, new) = value.split_once(" => ").expect("`OLD => NEW`");
                let before = String::from_utf8(model).expect("text before `append`");
                let old = &old.replace("\\n", "\n");
                assert!(before.contains(old.as_str()), "`{old}` is not in the model");
                model = before.replacen(old.as_str(), &new.replace("\\n", "\n"), 1).into_bytes();
            }
            "append" => model.extend(
                value.split(' ').map(|byte| u8::from_str_radix(byte, 16).expect("hexadecimal")),
            ),
            "nest" => model = format!("x = {}", "[".repeat(value.parse().expect("N"))).into(),
            "given" => {
                place.write(value, GIVEN);
                given.push(value);
            }
            "absent" => absent.push(value),
            "run" => {
                place.write(name, &model);
                let begun = Instant::now();
                output = Some(place.run(value));
                took = begun.elapsed();
            }
            "cut" => {
                let path = place.path().join(value);
                let bytes = fs::read(&path).expect("a file to cut");
                let end = b"bksim.end";
                let at = bytes.windows(end.len()).position(|window| window == end);
                fs::write(&path, &bytes[..at.expect("a whole log")]).expect("the cut file");
            }
            "exit" => exit = value.parse().expect("a status"),
            other => panic!("unknown key `{other}`"),
        }
    }
    let read = |name: &&str| fs::read(place.path().join(name));
    let mut touched: Vec<String> = Vec::new();
    if fs::read(place.path().join(name)).is_ok_and(|bytes| bytes != model) {
        touched.push(name.to_owned());
    }
    touched
        .extend(given.iter().filter(|n| !read(n).is_ok_and(|b| b == GIVEN)).map(|n| (*n).into()));
    touched.extend(absent.iter().filter(|n| read(n).is_ok()).map(|n| (*n).into()));
    Outcome { output: output.expect("a `run:` line"), exit, touched, took }
}

/// Dates of files change.
fn without_dates(text: &str) -> String {
    let mut parts = text.split("written ");
    let mut clean = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        clean.push_str("written DATE");
        clean.push_str(part.find([')', ',']).map_or("", |at| &part[at..]));
    }
    clean
}

#[test]
fn every_case_prints_and_exits_as_written() {
    let bless = std::env::var_os("BKSIM_BLESS").is_some();
    let mut wrong = Vec::new();
    for path in cases() {
        let case = fs::read_to_string(&path).expect("a case");
        let (script, expected) = case.split_once(MARK).unwrap_or((&case, ""));
        let outcome = play(script);
        let printed = without_dates(&text(&outcome.output.stderr));
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if outcome.output.status.code() != Some(outcome.exit) {
            wrong.push(format!(
                "{name}: {} instead of {}\n{printed}",
                outcome.output.status, outcome.exit
            ));
        }
        if !outcome.touched.is_empty() {
            wrong.push(format!("{name}: touched {}", outcome.touched.join(", ")));
        }
        if outcome.took > Duration::from_secs(2) {
            wrong.push(format!("{name}: took {:?}", outcome.took));
        }
        if bless {
            fs::write(&path, format!("{script}{MARK}{printed}")).expect("the blessed case");
        } else if printed != expected {
            wrong.push(format!("{name}: expected\n{expected}printed\n{printed}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Each diagnostic keeps to a size that can be read, and shows nothing of the program's inside.
#[test]
fn messages_are_short_and_about_the_model_alone() {
    for path in cases() {
        let case = fs::read_to_string(&path).expect("a case");
        let (_, expected) = case.split_once(MARK).expect("an expected text");
        let name = path.display();
        for message in split_messages(expected) {
            assert!(message.len() <= 12, "{name}: {} lines", message.len());
        }
        for line in expected.lines() {
            assert!(line.chars().count() <= 160, "{name}: a line too wide: {line}");
        }
        for inside in ["panicked", "unwrap", "f64", "usize", "Some(", "os error", ".rs"] {
            assert!(!expected.contains(inside), "{name}: `{inside}`");
        }
    }
}

/// JSON of a fault: one object with the code, the place and the help of the text.
#[test]
fn json_carries_what_the_text_says() {
    for path in cases() {
        let case = fs::read_to_string(&path).expect("a case");
        let (script, expected) = case.split_once(MARK).expect("an expected text");
        let is_drawing = script.contains("drawing: ");
        // `new` and `explain` take part too; only help is no result.
        let script = script.lines().map(|line| match line.strip_prefix("run: ") {
            Some(arguments) => format!("run: {arguments} --json\n"),
            None => format!("{line}\n"),
        });
        let outcome = play(&script.collect::<String>());
        let name = path.display();
        let stdout = text(&outcome.output.stdout);
        let object: serde_json::Value = match serde_json::from_str(&stdout) {
            Ok(object) => object,
            Err(error) => panic!("{name}: {error} in {stdout}"),
        };
        for diagnostic in object["diagnostics"].as_array().into_iter().flatten() {
            let code = diagnostic["code"].as_str().expect("a code");
            let message = diagnostic["message"].as_str().expect("a message");
            assert!(expected.contains(&format!("[{code}]: {message}")), "{name}: {message}");
            if let Some(help) = diagnostic["help"].as_str() {
                assert!(expected.contains(help), "{name}: {help}");
            }
            if let Some(label) = diagnostic["labels"].get(0) {
                let file = if is_drawing { "model.dxf" } else { "model.toml" };
                let place = format!("{file}:{}:{}", label["line"], label["column"]);
                assert!(expected.contains(&place), "{name}: {place}");
            }
        }
        if let Some(message) = object["message"].as_str() {
            // A list of missing arguments stands on lines of its own in the text.
            let unbroken = expected.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(unbroken.contains(&without_dates(message)), "{name}: {message}");
        }
    }
}

fn split_messages(text: &str) -> Vec<Vec<&str>> {
    let mut messages: Vec<Vec<&str>> = Vec::new();
    for line in text.lines() {
        if line.starts_with("error") || line.starts_with("warning") || messages.is_empty() {
            messages.push(Vec::new());
        }
        messages.last_mut().expect("one was pushed").push(line);
    }
    messages
}

/// Colours add nothing and take nothing away.
#[test]
fn the_text_is_the_same_with_and_without_colours() {
    let place = Scratch::new();
    let model = fs::read(format!("{CRATE}/tests/faults/models/composite.toml")).expect("a model");
    place.write("model.toml", model);
    let plain = text(&place.run("check model.toml").stderr);
    let mut command = place.bksim();
    command.args(["check", "model.toml"]).env_remove("NO_COLOR").env("CLICOLOR_FORCE", "1");
    let coloured = text(&command.output().expect("bksim starts").stderr);
    assert_ne!(coloured, plain);
    assert_eq!(anstream::adapter::strip_str(&coloured).to_string(), plain);
}

/// A reader that goes away is no fault: `bksim export … | head -1`.
#[test]
fn a_closed_pipe_ends_quietly() {
    let place = Scratch::new();
    let model = fs::read(format!("{CRATE}/tests/faults/models/four-bar.toml")).expect("a model");
    place.write("model.toml", model);
    assert!(place.run("solve model.toml").status.success());
    for arguments in
        ["export model.mcap", "check model.toml", "equations model.toml --json", "explain"]
    {
        let mut child = place
            .bksim()
            .args(arguments.split(' '))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("bksim starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("an end");
        assert_eq!(output.status.code(), Some(0), "{arguments}");
        assert_eq!(text(&output.stderr), "", "{arguments}");
    }
}
