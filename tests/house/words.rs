//! The words of the field in the crates of mechanics, instead of coinages: `docs/architecture.md` and the
//! table of notation in `docs/theory.md` use them, and so does the code.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Words that the field has another one for.
const COINAGES: [(&str, &str); 14] = [
    ("blow", "impact"),
    ("blows", "impacts"),
    ("leg", "phase"),
    ("legs", "phases"),
    ("lookout", "event monitor"),
    ("settle", "find consistent modes"),
    ("settled", "consistent"),
    ("unsettled", "without consistent modes"),
    ("weakness", "rank margin"),
    ("twin", "duplicate"),
    ("behind", "after, next"),
    ("beside", "next to, with"),
    ("drawn", "input"),
    ("touches", "contact"),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// The words of a text: identifiers apart at underscores and capitals, all in small letters.
fn words(text: &str) -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    for run in text.split(|c: char| !c.is_alphabetic()) {
        let mut word = String::new();
        for c in run.chars() {
            if c.is_uppercase() && !word.is_empty() {
                words.insert(std::mem::take(&mut word));
            }
            word.extend(c.to_lowercase());
        }
        words.insert(word);
    }
    words
}

#[test]
fn the_crates_of_mechanics_use_the_words_of_the_field() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wrong = Vec::new();
    for name in ["dae", "mbs", "sim"] {
        let mut files = Vec::new();
        sources(&root.join("crates").join(name).join("src"), &mut files);
        for path in files {
            let file = path.strip_prefix(root).expect("below the root").display().to_string();
            let used = words(&fs::read_to_string(&path).expect("a readable file"));
            for (word, better) in COINAGES {
                if used.contains(word) {
                    wrong.push(format!("{file}: `{word}`; the field says {better}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn identifiers_are_taken_apart() {
    let found = words("let least_margin = MultiplierSystem::of(q2);");
    let expected = ["", "least", "let", "margin", "multiplier", "of", "q", "system"];
    assert_eq!(found.into_iter().collect::<Vec<_>>(), expected);
}

/// First words of a doc comment that say nothing where its first line is shown alone, as editors and rustdoc show it.
const LEANING: [&str; 9] =
    ["The same", "Its ", "Those ", "None ", "As ", "Not ", "So ", "What ", "None."];

/// First lines of the doc comments of a text, with their numbers.
fn first_lines(text: &str) -> Vec<(usize, &str)> {
    let doc =
        |line: &str| line.trim_start().starts_with("///") || line.trim_start().starts_with("//!");
    let lines: Vec<&str> = text.lines().collect();
    let begins = |i: usize| doc(lines[i]) && (i == 0 || !doc(lines[i - 1]));
    (0..lines.len())
        .filter(|&i| begins(i))
        .map(|i| (i + 1, lines[i].trim_start()[3..].trim()))
        .collect()
}

#[test]
fn first_lines_of_documentation_make_sense_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["src", "crates", "tests"] {
        sources(&root.join(folder), &mut files);
    }
    let mut wrong = Vec::new();
    for path in files {
        let file = path.strip_prefix(root).expect("below the root").display().to_string();
        let text = fs::read_to_string(&path).expect("a readable file");
        for (number, line) in first_lines(&text) {
            if LEANING.iter().any(|words| line.starts_with(words)) {
                wrong.push(format!("{file}:{number}: {line}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{} lines lean on others:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn first_lines_are_found() {
    let found = first_lines("//! One.\n//! Two.\n\n    /// Three.\n    fn f() {}\n");
    assert_eq!(found, [(1, "One."), (4, "Three.")]);
}
