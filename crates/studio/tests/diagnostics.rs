//! The pages of the diagnostics, `docs/diagnostics/*.md`, as `bksim explain CODE` prints them.
//!
//! A page has a title, a paragraph on what is wrong and why, and three sections:
//!
//! ````text
//! # M005: unknown key
//!
//! The table has a key that means nothing there …
//!
//! ## Fault
//!
//! ```toml pendulum.toml
//! lenght = "0.3 m"
//! ```
//!
//! ## Output
//!
//! ```console
//! $ bksim check pendulum.toml
//! error[M005]: unknown key `lenght` …
//! ```
//!
//! ## Cure
//!
//! ```diff pendulum.toml
//! -lenght = "0.3 m"
//! +length = "0.3 m"
//! ```
//! ````
//!
//! - *Fault* holds files: the language and the name are the info string. A block of the language
//!   `drawing` lists the entities of a DXF drawing; see `diagnostics/drawing.rs`.
//! - *Output* holds the commands and, below each, all that it prints on stderr. The page's code must be
//!   among that, and no other error.
//! - *Cure* holds the changed files, whole or as lines to remove (`-`), to add (`+`) and to keep. They take
//!   the place of the fault in a new folder, and the commands of *Output* run again. Or it holds commands
//!   of its own, which run where the fault was. Each of them succeeds and prints the code no more.
//!
//! More sections may follow. A page whose fault no command can produce has *When*, with the reason, in
//! place of the three; there are fewer than ten.
//!
//! With `BKSIM_BLESS=1` the outputs are rewritten from what is printed.
#![cfg(unix)]

mod drawing;
mod page;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{CRATE, Scratch, text};
use bksim::explained_codes;
use page::{Block, Example, Page, Shown, patched};

fn folder() -> PathBuf {
    Path::new(CRATE).join("../../docs/diagnostics")
}

/// The pages whose codes begin with this letter, each with its code; those that keep to no template as faults.
fn pages(letter: char) -> Vec<(&'static str, Result<Page, String>)> {
    let codes = explained_codes().map(|page| page.code.0);
    let mut codes: Vec<_> = codes.filter(|code| code.starts_with(letter)).collect();
    codes.sort_unstable();
    codes.into_iter().map(|code| (code, read(code))).collect()
}

fn read(code: &str) -> Result<Page, String> {
    let text = fs::read_to_string(folder().join(format!("{code}.md")));
    Page::parse(&text.map_err(|error| error.to_string())?)
}

#[test]
fn models() {
    check('M');
}

#[test]
fn drawings() {
    check('D');
}

#[test]
fn starts() {
    check('S');
}

#[test]
fn runs() {
    check('R');
}

#[test]
fn units() {
    check('F');
}

#[test]
fn designs() {
    check('O');
}

#[test]
fn questions() {
    check('Q');
}

#[test]
fn edits() {
    check('W');
}

#[test]
fn sweeps() {
    check('P');
}

#[test]
fn imports() {
    check('I');
}

/// Checks the examples of these pages, and reports all that is wrong with them at once.
fn check(letter: char) {
    let pages = pages(letter);
    assert!(!pages.is_empty(), "no page begins with {letter}");
    let mut wrong = Vec::new();
    for (code, page) in pages {
        let page = match page {
            Ok(page) => page,
            Err(fault) => {
                wrong.push(format!("{code}: {fault}"));
                continue;
            }
        };
        let Some(example) = &page.example else { continue };
        let printed = play(&page, example, &mut wrong);
        if std::env::var_os("BKSIM_BLESS").is_some() {
            let path = folder().join(format!("{}.md", page.code));
            fs::write(path, page.with_output(&printed)).expect("the blessed page");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// Runs the fault of a page, then its cure; returns what the commands of the fault print.
fn play(page: &Page, example: &Example, wrong: &mut Vec<String>) -> Vec<Shown> {
    let code = page.code.as_str();
    let fault = Scratch::new();
    let mut files = BTreeMap::new();
    lay_out(&fault, &example.fault, &mut files).unwrap_or_else(|e| panic!("{code}: {e}"));
    let printed = run(&fault, &example.output, code, wrong);
    check_codes(&printed, code, wrong);

    let cured = Scratch::new();
    let (room, commands) = match &example.cure_commands {
        Some(commands) => (&fault, commands),
        None => (&cured, &example.output),
    };
    if example.cure_commands.is_none() {
        lay_out(room, &example.fault, &mut BTreeMap::new()).expect("the files of the fault");
    }
    lay_out(room, &example.cure, &mut files).unwrap_or_else(|e| panic!("{code}: {e}"));
    for shown in commands {
        let (status, stderr) = run_one(room, &shown.command);
        let is_shown = example.cure_commands.is_none() || stderr == shown.stderr;
        if status != Some(0) || stderr.contains(&format!("[{code}]")) || !is_shown {
            wrong.push(format!("{code}: the cure: `{}`, {status:?}:\n{stderr}", shown.command));
        }
    }
    printed
}

/// Writes the files of some blocks; `files` are the texts that changes refer to.
fn lay_out(
    room: &Scratch,
    blocks: &[Block],
    files: &mut BTreeMap<String, String>,
) -> Result<(), String> {
    for block in blocks {
        let before = files.get(&block.file);
        let (text, is_drawing) = match block.language.as_str() {
            "diff" => {
                let before = before.ok_or_else(|| format!("no `{}` to change", block.file))?;
                (patched(before, &block.text)?, before.starts_with("units "))
            }
            language => (block.text.clone(), language == "drawing"),
        };
        let bytes = if is_drawing { drawing::dxf(&text)? } else { text.clone() };
        room.write(&block.file, bytes);
        files.insert(block.file.clone(), text);
    }
    Ok(())
}

/// Runs commands one after the other and compares what they print with what is shown.
fn run(room: &Scratch, commands: &[Shown], code: &str, wrong: &mut Vec<String>) -> Vec<Shown> {
    let mut printed = Vec::new();
    for shown in commands {
        let (status, stderr) = run_one(room, &shown.command);
        if stderr != shown.stderr {
            wrong.push(format!("{code}: `{}` prints\n{stderr}", shown.command));
        }
        let is_rejected = stderr.contains(&format!("error[{code}]"));
        if (status == Some(0)) == is_rejected {
            wrong.push(format!("{code}: `{}` exits with {status:?}", shown.command));
        }
        printed.push(Shown { command: shown.command.clone(), stderr });
    }
    printed
}

fn run_one(room: &Scratch, command: &str) -> (Option<i32>, String) {
    // The studio has the whole command line: under the name of the command, it is the command.
    let binaries = room.path().join(".bin");
    let command_path = binaries.join("bksim");
    if !command_path.exists() {
        fs::create_dir_all(&binaries).expect("a directory");
        std::os::unix::fs::symlink(crate::common::PROGRAM, &command_path).expect("a link");
    }
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", command])
        .current_dir(room.path())
        .env("PATH", format!("{}:{path}", binaries.display()))
        .env("NO_COLOR", "1")
        .output()
        .expect("a shell");
    (output.status.code(), text(&output.stderr))
}

/// The page's code is printed, and no other error.
fn check_codes(printed: &[Shown], code: &str, wrong: &mut Vec<String>) {
    let lines = printed.iter().flat_map(|shown| shown.stderr.lines());
    let titles: Vec<&str> = lines.filter(|line| line.contains('[')).collect();
    let own = ["error", "warning"].map(|kind| format!("{kind}[{code}]: "));
    if !titles.iter().any(|line| own.iter().any(|own| line.starts_with(own))) {
        wrong.push(format!("{code}: the code is not printed"));
    }
    for line in titles {
        if line.starts_with("error[") && !line.starts_with(&own[0]) {
            wrong.push(format!("{code}: another error: {line}"));
        }
    }
}

#[test]
fn every_code_has_its_page_and_every_page_its_code() {
    let mut codes: Vec<String> = explained_codes().map(|page| page.code.0.to_owned()).collect();
    codes.sort_unstable();
    let files = fs::read_dir(folder()).expect("the folder of pages");
    let mut files: Vec<String> = files
        .map(|file| file.expect("a readable folder").file_name().to_string_lossy().into_owned())
        .collect();
    files.sort_unstable();
    let expected: Vec<String> = codes.iter().map(|code| format!("{code}.md")).collect();
    assert_eq!(files, expected);
    for known in explained_codes() {
        let page = Page::parse(known.text).unwrap_or_else(|e| panic!("{}: {e}", known.code.0));
        assert_eq!((page.code.as_str(), page.title.as_str()), (known.code.0, known.title));
    }
}

#[test]
fn few_pages_have_no_example() {
    let all = ['M', 'D', 'S', 'R', 'P', 'I', 'W'].map(pages);
    let without: Vec<&str> = all
        .iter()
        .flatten()
        .filter(|(_, page)| page.as_ref().is_ok_and(|page| page.example.is_none()))
        .map(|(code, _)| *code)
        .collect();
    eprintln!("{} pages have no example: {}", without.len(), without.join(", "));
    assert!(without.len() < 10, "{without:?}");
}

#[test]
fn explain_prints_the_page() {
    let room = Scratch::new();
    let output = room.run("explain m005");
    let page = fs::read_to_string(folder().join("M005.md")).expect("a page");
    assert_eq!(text(&output.stdout), page);
}

#[test]
fn explain_speaks_vietnamese_where_it_is_asked_for() {
    let room = Scratch::new();
    let asked = text(&room.run("explain m012 --lang vi").stdout);
    assert!(asked.starts_with("# M012: không có khâu này"), "{asked}");
    assert!(asked.contains("error[M012]: joint `post` refers to unknown body"), "{asked}");
    let list = text(&room.run("explain --lang vi").stdout);
    assert!(list.contains("M012  không có khâu này"), "{list}");
}

#[test]
fn a_diagnostic_is_explained_in_the_language_of_the_environment() {
    let room = Scratch::new();
    room.write("a.toml", "name = \"a\"\n");
    let said = |locale: &str, arguments: &str| {
        let mut command = room.bksim();
        command.args(arguments.split(' '));
        let output = command.env_remove("LC_ALL").env_remove("LC_MESSAGES").env("LANG", locale);
        text(&output.output().expect("the program runs").stderr)
    };
    let english = said("en_US.UTF-8", "check a.toml");
    let vietnamese = said("vi_VN.UTF-8", "check a.toml");
    assert!(!english.contains("mô hình không có khâu"), "{english}");
    assert!(vietnamese.contains("mô hình không có khâu"), "{vietnamese}");
    assert!(vietnamese.contains("lỗi[M062]: mô hình không có khâu nào"), "{vietnamese}");
    assert_eq!(said("vi_VN.UTF-8", "check a.toml --lang en"), english);
}

#[test]
fn the_checks_can_fail() {
    let example = |output: &str, cure: &str| {
        let fault = "```toml a.toml\nname = \"a\"\n```";
        let output = format!("```console\n$ bksim check a.toml\n{output}```");
        let page = format!(
            "# M062: a model without bodies\n\nText.\n\n## Fault\n\n{fault}\n\n## Output\n\n\
             {output}\n\n## Cure\n\n{cure}\n"
        );
        Page::parse(&page)
    };
    let n_wrong = |output: &str, cure: &str| {
        let page = example(output, cure).expect("a page");
        let mut wrong = Vec::new();
        play(&page, page.example.as_ref().expect("an example"), &mut wrong);
        wrong.len()
    };
    let room = Scratch::new();
    room.write("a.toml", "name = \"a\"\n");
    let printed = text(&room.run("check a.toml").stderr);
    let cure =
        "```diff a.toml\n name = \"a\"\n+[bodies.b]\n+mass = 1\n+inertia = 1\n+free = true\n```";
    assert_eq!(n_wrong(&printed, cure), 0);
    assert_eq!(n_wrong(&printed.replace("bodies", "body"), cure), 1, "{printed}");
    assert_eq!(n_wrong(&printed, &cure.replace("mass = 1", "mass = -1")), 1);
    assert!(example(&printed, "No block.").is_err());
}
