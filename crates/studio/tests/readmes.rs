//! READMEs show what bksim prints.
//!
//! A ```` ```console ```` block holds commands (`$ …`), each followed by what it prints on stdout; a
//! command that ends in `2>&1` shows stderr too. All blocks of a file run in one directory, in
//! which `examples` is the project's. A ```` ```toml ```` block whose first line is `# NAME.toml` is
//! a file of that name there. What is printed is compared with the block word by word:
//!
//! - a line `...` stands for any number of lines;
//! - in lines that begin with `steps`, `work`, `time` or `constraints`, numbers are not compared:
//!   times differ from run to run, counters from version to version, residuals by rounding;
//! - any other number may differ by 2e-6 of its size, or by 2e-6, where rounding shows; the size of
//!   an error (two digits and an exponent, `1.1e-6`) by a factor of 100.
//!
//! With `BKSIM_BLESS=1` the blocks are rewritten from what is printed.
#![cfg(unix)]

#[path = "../../../examples/embed/main.rs"]
#[expect(dead_code, reason = "a program of its own, whose main is not called")]
mod embed;

#[path = "../../../examples/cart-pole/main.rs"]
#[expect(dead_code, reason = "a program of its own, whose main is not called")]
mod cart_pole;

use std::fmt::Debug;
use std::fs;
use std::io::Write;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{CRATE, PROGRAM, Scratch, text};

fn root() -> PathBuf {
    Path::new(CRATE).join("../..").canonicalize().expect("the project")
}

#[test]
fn the_readme_shows_what_is_printed() {
    check(&root().join("README.md"));
}

#[test]
fn the_page_on_drawings_shows_what_is_printed() {
    check(&root().join("docs/drawings.md"));
}

#[test]
fn the_page_on_code_shows_what_is_printed() {
    check(&root().join("docs/code.md"));
}

#[test]
fn the_page_on_design_shows_what_is_printed() {
    check(&root().join("docs/design.md"));
}

#[test]
fn the_page_on_reports_shows_what_is_printed() {
    check(&root().join("docs/report.md"));
}

#[test]
fn the_page_on_sweeps_shows_what_is_printed() {
    check(&root().join("docs/sweeps.md"));
}

#[test]
fn the_pages_of_the_book_show_what_is_printed() {
    check(&root().join("docs/start.md"));
    for entry in fs::read_dir(root().join("docs/tasks")).expect("tasks") {
        check(&entry.expect("an entry").path());
    }
}

#[test]
fn the_vietnamese_pages_show_what_is_printed() {
    check(&root().join("docs/vi/README.md"));
    check(&root().join("docs/vi/bai-dau-tien.md"));
}

#[test]
fn every_example_shows_what_is_printed() {
    for entry in fs::read_dir(root().join("examples")).expect("examples") {
        let example = entry.expect("an entry").path();
        check(&example.join("README.md"));
    }
}

#[test]
fn programs_among_the_examples_show_what_is_printed() {
    shows("embed", embed::report);
    shows("cart-pole", |out| cart_pole::report(out).map(drop));
}

/// Compares what a program prints with its README.
fn shows<E: Debug>(example: &str, report: impl Fn(&mut dyn Write) -> Result<(), E>) {
    let mut printed = Vec::new();
    report(&mut printed).expect("the example runs");
    let path = root().join("examples").join(example).join("README.md");
    let readme = fs::read_to_string(&path).expect("a README");
    let shown = between(&readme, "```text\n", "```").expect("a text block");
    if is_blessing() {
        let (before, after) = (format!("```text\n{shown}```"), text(&printed));
        fs::write(&path, readme.replacen(&before, &format!("```text\n{after}```"), 1))
            .expect("the blessed README");
    } else {
        compare(shown, &text(&printed)).unwrap_or_else(|fault| panic!("{example}: {fault}"));
    }
}

fn is_blessing() -> bool {
    std::env::var_os("BKSIM_BLESS").is_some()
}

fn between<'a>(text: &'a str, from: &str, to: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(from)?;
    rest.split_once(to).map(|(inside, _)| inside)
}

/// Runs all blocks of a README and compares them.
fn check(path: &Path) {
    let place = Scratch::new();
    let link = symlink(root().join("examples"), place.path().join("examples"));
    link.expect("a link to the examples");
    let readme = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut blessed = String::new();
    let mut rest = readme.as_str();
    let mut wrong = Vec::new();
    while let Some((before, after)) = rest.split_once("```") {
        let (kind, block) = after.split_once('\n').expect("a kind of block");
        let (inside, behind) = block.split_once("```").expect("an end of the block");
        rest = behind;
        blessed.push_str(before);
        let inside = match kind {
            "toml" => {
                let first = inside.lines().next().unwrap_or_default();
                if let Some(name) = first.strip_prefix("# ").filter(|name| !name.contains(' ')) {
                    place.write(name, inside);
                }
                inside.to_owned()
            }
            "console" => run_block(&place, inside, &mut wrong),
            _ => inside.to_owned(),
        };
        blessed.push_str(&["```", kind, "\n", &inside, "```"].concat());
    }
    blessed.push_str(rest);
    if is_blessing() {
        fs::write(path, blessed).expect("the blessed README");
    } else {
        assert!(wrong.is_empty(), "{}: {}", path.display(), wrong.join("\n"));
    }
}

/// Runs the commands of a block, which must succeed; returns the block as it should be.
fn run_block(place: &Scratch, block: &str, wrong: &mut Vec<String>) -> String {
    // The studio has the whole command line: under that name it is the command of the READMEs.
    let programs = Scratch::new();
    symlink(PROGRAM, programs.path().join("bksim")).expect("a link to the program");
    let path = std::env::var("PATH").unwrap_or_default();
    let mut blessed = String::new();
    for part in block.split("$ ").filter(|part| !part.is_empty()) {
        let (command, shown) = part.split_once('\n').expect("a line end");
        let output = Command::new("sh")
            .args(["-c", command])
            .current_dir(place.path())
            .env("PATH", format!("{}:{path}", programs.path().display()))
            .env("NO_COLOR", "1")
            .output()
            .expect("a shell");
        let printed = text(&output.stdout);
        assert!(output.status.success(), "`{command}`: {}", text(&output.stderr));
        if let Err(fault) = compare(shown, &printed) {
            wrong.push(format!("`{command}`: {fault}\n{printed}\n{}", text(&output.stderr)));
        }
        blessed.push_str(&["$ ", command, "\n", &printed].concat());
    }
    blessed
}

/// Line by line, `...` for any lines.
fn compare(shown: &str, printed: &str) -> Result<(), String> {
    let mut printed = printed.lines();
    let mut shown = shown.lines();
    while let Some(expected) = shown.next() {
        if expected.trim() == "..." {
            let Some(next) = shown.next() else { return Ok(()) };
            if !printed.any(|line| lines_agree(next, line)) {
                return Err(format!("no line `{next}`"));
            }
            continue;
        }
        let Some(line) = printed.next() else {
            return Err(format!("nothing is printed for `{expected}`"));
        };
        if !lines_agree(expected, line) {
            return Err(format!("`{expected}` but printed is\n`{line}`"));
        }
    }
    match printed.next() {
        None => Ok(()),
        Some(line) => Err(format!("`{line}` is printed too")),
    }
}

fn lines_agree(expected: &str, printed: &str) -> bool {
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (expected, printed) = (words(expected), words(printed));
    let masked = ["steps", "work", "time", "constraints"];
    let is_masked = expected.first().is_some_and(|word| masked.contains(&word.as_str()));
    expected.len() == printed.len()
        && expected.iter().zip(&printed).all(|(e, p)| words_agree(e, p, is_masked))
}

fn words_agree(expected: &str, printed: &str, is_masked: bool) -> bool {
    let number = |word: &str| word.trim_matches([',', ')', '(', ';']).parse::<f64>().ok();
    let (Some(e), Some(p)) = (number(expected), number(printed)) else {
        return expected == printed;
    };
    let is_size = expected.contains("e-") && expected.trim_matches([',', ')', '(']).len() <= 7;
    if is_masked {
        true
    } else if is_size {
        p.abs() <= 100.0 * e.abs()
    } else {
        (e - p).abs() <= 2e-6 * e.abs().max(1.0)
    }
}

#[test]
fn the_comparison_can_fail() {
    assert!(compare("a 1.0\n", "a 1.000001\n").is_ok());
    assert!(compare("a 1.0\n", "a 1.00001\n").is_err());
    assert!(compare("a 1.0\n", "a 1.0\nb\n").is_err());
    assert!(compare("a\n...\nc\n", "a\nb\nc\n").is_ok());
    assert!(compare("a\n...\nc\n", "a\nb\n").is_err());
    assert!(compare("kept to 1.1e-9 J\n", "kept to 2.0e-8 J\n").is_ok());
    assert!(compare("kept to 1.1e-9 J\n", "kept to 2.0e-6 J\n").is_err());
    assert!(compare("time 3 ms\n", "time 5 ms\n").is_ok());
    assert!(compare("time 3 ms\n", "time 5 s\n").is_err());
}
