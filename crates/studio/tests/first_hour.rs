//! The first hour of a new user: what the README and the first page of the book say, in both languages, typed in the
//! order of the page into an empty directory.
//!
//! A page's files are its blocks of TOML that begin with `# NAME.toml`. Its commands are the lines after `$ `, the
//! lines of any block that begin with `bksim`, and what stands as `bksim …` in its text, but for the words of a
//! reference (`bksim solve MODEL`). What they print is compared by the test of READMEs.
#![cfg(unix)]

#[path = "../../cli/tests/common/mod.rs"]
mod common;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{CRATE, PROGRAM, Scratch, text};

/// Something that the reader of a page does.
#[derive(Debug, PartialEq)]
enum Deed {
    /// Writes this file.
    Write(String, String),
    /// Types this command.
    Type(String),
}

/// The deeds that a page asks for, in its order.
fn deeds(page: &str) -> Vec<Deed> {
    let mut deeds = Vec::new();
    for (idx, part) in page.split("```").enumerate() {
        if idx % 2 == 0 {
            let spans = part.lines().filter(|line| !line.starts_with('|'));
            let spans = spans.collect::<Vec<_>>().join("\n");
            let code =
                spans.split('`').skip(1).step_by(2).filter(|code| code.starts_with("bksim "));
            let is_example = |code: &&str| !code.split_whitespace().skip(1).any(is_placeholder);
            deeds.extend(code.filter(is_example).map(|code| Deed::Type(code.replace('\n', " "))));
            continue;
        }
        let (kind, block) = part.split_once('\n').expect("a kind of block");
        let first = block.lines().next().unwrap_or_default();
        if let Some(name) =
            first.strip_prefix("# ").filter(|name| kind == "toml" && !name.contains(' '))
        {
            deeds.push(Deed::Write(name.to_owned(), block.to_owned()));
        }
        let typed = block.lines().filter_map(|line| {
            let line = line.strip_prefix("$ ").unwrap_or(line);
            let line = line
                .strip_prefix("cargo run -- ")
                .map_or(line.to_owned(), |rest| format!("bksim {rest}"));
            // Some have a remark next to them.
            let command = line.split("   ").next().unwrap_or_default();
            command.starts_with("bksim ").then(|| command.to_owned())
        });
        deeds.extend(typed.map(Deed::Type));
    }
    deeds
}

/// A word that stands for others: `MODEL`, `NAME=VALUE`, `[CODE]`, `…`.
fn is_placeholder(word: &str) -> bool {
    let letters: String = word.chars().filter(|c| c.is_alphabetic()).collect();
    let is_code = letters.len() == 1 && word.chars().any(|c| c.is_ascii_digit());
    word.contains('…') || letters.len() > 1 && !is_code && letters.chars().all(char::is_uppercase)
}

/// Does all that a page says. Whatever fails is returned with what was printed.
fn follow(page: &str, examples: bool) -> Vec<String> {
    let (place, programs) = (Scratch::new(), Scratch::new());
    symlink(PROGRAM, programs.path().join("bksim")).expect("a link to the program");
    let root = Path::new(CRATE).join("../..").canonicalize().expect("the project");
    if examples {
        symlink(root.join("examples"), place.path().join("examples")).expect("a link");
    }
    let path = std::env::var("PATH").unwrap_or_default();
    let text_of_page = fs::read_to_string(root.join(page)).expect("the page");
    let deeds = deeds(&text_of_page);
    let n_typed = deeds.iter().filter(|deed| matches!(deed, Deed::Type(_))).count();
    assert!(n_typed >= 3, "{page}: {deeds:?}");
    let mut failed = Vec::new();
    for deed in deeds {
        let command = match deed {
            Deed::Write(name, content) => {
                place.write(&name, content);
                continue;
            }
            Deed::Type(command) => command,
        };
        let mut shell = Command::new("sh");
        shell.args(["-c", &command]).current_dir(place.path()).stdin(Stdio::null());
        shell.env("PATH", format!("{}:{path}", programs.path().display()));
        // Nobody looks: a window cannot open, and says so.
        shell.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env("NO_COLOR", "1");
        let output = shell.output().expect("a shell");
        let is_window = command.starts_with("bksim view");
        let words = text(&output.stderr);
        let is_right = if is_window {
            output.status.code() == Some(4) && words.contains("display")
        } else {
            output.status.success()
        };
        if !is_right {
            failed.push(format!("{page}: `{command}`: {}\n{words}", output.status));
        }
    }
    failed
}

#[test]
fn what_the_first_page_says_works_in_an_empty_directory() {
    let failed = follow("docs/start.md", false);
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn what_the_readme_says_works_beside_the_examples() {
    let failed = follow("README.md", true);
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn what_the_vietnamese_pages_say_works() {
    let failed =
        [follow("docs/vi/README.md", true), follow("docs/vi/bai-dau-tien.md", false)].concat();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn pages_are_read_as_people_read_them() {
    let page = "Type `bksim new first`, or\n`bksim view\nfirst.toml`; see `bksim solve MODEL`.\n\
                | `bksim man` | a row |\n```toml\n# a.toml\nx = 1\n```\n\
                ```sh\ncargo run -- solve a.toml\nbksim page a.mcap     one page\ntests/setup.sh\n```\n\
                ```console\n$ bksim explain M012\nwhat is printed\n```\n";
    let expected = [
        "bksim new first",
        "bksim view first.toml",
        "bksim solve a.toml",
        "bksim page a.mcap",
        "bksim explain M012",
    ];
    let mut found = deeds(page);
    assert_eq!(found.remove(2), Deed::Write("a.toml".to_owned(), "# a.toml\nx = 1\n".to_owned()));
    assert_eq!(found, expected.map(|command| Deed::Type(command.to_owned())));
}
