//! One letter, one meaning: the comments of the crates use letters as the tables of `docs/theory.md`
//! define them.
//!
//! Four rules, each on what is written beyond doubt:
//!
//! 1. `X(t, q)`: a letter with arguments of the state is in the tables, with these arguments;
//! 2. `∂X/∂…`: a letter that is differentiated is in the tables; `λ_j ∂X` is that of the constraints;
//! 3. `X = ∂…`: a letter that is defined by a derivative has the definition of the tables;
//! 4. a doc comment that opens with a letter, on an item that the tables name, has its letter.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// A line of a table.
#[derive(Clone, Debug)]
struct Row {
    /// `G`, `∂V/∂q`.
    symbol: String,
    /// The right side of `G = ∂g/∂q`, or nothing.
    definition: String,
    /// The arguments, `t, q, v`.
    arguments: String,
    /// Names in the code.
    names: Vec<String>,
}

/// Directories and the heads of the tables that hold there.
const SCOPES: [(&str, &[&str]); 4] = [
    ("crates/mbs/src", &["Mechanics"]),
    ("crates/sim/src", &["Mechanics", "Integration"]),
    ("crates/dae/src", &["Integration"]),
    ("docs/theory.md", &["Mechanics", "Integration"]),
];

#[test]
fn letters_in_comments_mean_what_the_tables_say() {
    let theory = text(&root().join("docs/theory.md"));
    let mut faults = String::new();
    let mut n_checked = 0;
    for (place, heads) in SCOPES {
        let rows: Vec<Row> = heads.iter().flat_map(|head| table(&theory, head)).collect();
        assert!(rows.len() > 3, "the tables for {place}");
        for path in files(&root().join(place)) {
            for (line, comment, item) in comments(&path) {
                let found = check(&comment, item.as_deref(), &rows);
                n_checked += found.n_checked;
                for fault in found.faults {
                    let path = path.strip_prefix(root()).expect("a path below the root");
                    writeln!(faults, "{}:{line}: {fault}", path.display()).expect("a string grows");
                }
            }
        }
    }
    assert!(
        faults.is_empty(),
        "letters that the tables of docs/theory.md do not explain:\n{faults}"
    );
    assert!(n_checked > 150, "only {n_checked} letters were found");
}

#[test]
fn a_letter_for_another_quantity_is_found() {
    let theory = text(&root().join("docs/theory.md"));
    let rows = table(&theory, "Mechanics");
    let cases: [(&str, Option<&str>, usize); 14] = [
        ("g(t, q) with multipliers", Some("constraints"), 0),
        ("f(t, q) with multipliers", Some("constraints"), 2),
        ("G = ∂g/∂q, nc × nq.", Some("constraint_jacobian"), 0),
        ("G = ∂f/∂q, nc × nq.", Some("constraint_jacobian"), 1),
        ("∂g/∂t, nc.", Some("constraint_rate"), 0),
        ("∂f/∂t, nc.", Some("constraint_rate"), 1),
        ("Q(t, q, v), nq: loads.", Some("applied_force"), 0),
        ("Q(t, q, v), nq: loads.", Some("force"), 1),
        ("N, world axes.", Some("force"), 0),
        ("d/dt ∂T/∂q̇ − ∂T/∂q = −∂V/∂q + Q − Σ λ_j ∂g_j/∂q,   g_j(t, q) = 0", None, 0),
        ("d/dt ∂T/∂q̇ − ∂T/∂q = −∂V/∂q + Q − Σ λ_j ∂f_j/∂q", None, 1),
        ("−∂Π/∂q + Q", None, 1),
        ("is written out as M(q) q̈ + h(q, q̇)", None, 0),
        ("is written out as M(q, v) q̈ + h(q)", None, 2),
    ];
    for (comment, item, n_faults) in cases {
        let found = check(comment, item, &rows).faults;
        assert_eq!(found.len(), n_faults, "{comment}: {found:?}");
    }
}

#[derive(Default)]
struct Found {
    n_checked: usize,
    faults: Vec<String>,
}

/// Checks one comment, and the item that it documents, against the rows that hold for it.
fn check(comment: &str, item: Option<&str>, rows: &[Row]) -> Found {
    let chars: Vec<char> = comment.chars().collect();
    let mut found = Found::default();
    for at in 0..chars.len() {
        let before = if at == 0 { ' ' } else { chars[at - 1] };
        if before.is_alphanumeric() || "_`'\u{307}\u{308}".contains(before) {
            continue;
        }
        let rest: String = chars[at..].iter().collect();
        check_arguments(&rest, rows, &mut found);
        check_derivative(&rest, &chars[..at], rows, &mut found);
        check_definition(&rest, rows, &mut found);
    }
    if let Some(item) = item {
        check_opening(comment, item, rows, &mut found);
    }
    found
}

/// Rule 1.
fn check_arguments(rest: &str, rows: &[Row], found: &mut Found) {
    let Some((letter, rest)) = letter(rest) else { return };
    let Some(inside) = rest.strip_prefix('(').and_then(|rest| rest.split(')').next()) else {
        return;
    };
    // Rates may be written with dots.
    let arguments = inside.replace("q̇", "v").replace("ydot", "y′");
    let is_state = |argument: &str| ["t", "q", "v", "a", "λ", "y", "y′"].contains(&argument);
    if !arguments.split(", ").all(is_state) {
        return;
    }
    found.n_checked += 1;
    let is_known = |row: &Row| row.symbol == letter && row.arguments == arguments;
    if !rows.iter().any(is_known) {
        found.faults.push(format!("`{letter}({inside})` is not in the tables"));
    }
}

/// Rule 2.
fn check_derivative(rest: &str, before: &[char], rows: &[Row], found: &mut Found) {
    let Some((letter, rest)) = rest.strip_prefix('∂').and_then(letter) else { return };
    if !rest.starts_with("/∂") {
        return;
    }
    found.n_checked += 1;
    if !rows.iter().any(|row| row.symbol == letter) {
        found.faults.push(format!("`∂{letter}/∂…`: the letter is not in the tables"));
    }
    let before: String = before.iter().collect();
    let factor = before.trim_end().rsplit(' ').next().unwrap_or_default();
    if factor.starts_with("λ_") {
        let constraints = rows.iter().find(|row| row.names.contains(&"constraints".to_owned()));
        if constraints.is_some_and(|row| row.symbol != letter) {
            found.faults.push(format!("`{factor} ∂{letter}`: constraints have another letter"));
        }
    }
}

/// Rule 3.
fn check_definition(rest: &str, rows: &[Row], found: &mut Found) {
    let Some((letter, rest)) = letter(rest) else { return };
    let Some(definition) = rest.strip_prefix(" = ").filter(|rest| rest.starts_with('∂')) else {
        return;
    };
    let ends = |c: char| c.is_whitespace() || ",;.)`".contains(c);
    let definition = definition.split(ends).next().unwrap_or_default();
    let known = rows.iter().find(|row| row.symbol == letter && row.definition.starts_with('∂'));
    if let Some(row) = known {
        found.n_checked += 1;
        if !definition.starts_with(&row.definition) {
            found.faults.push(format!("`{letter} = {definition}` is `{}`", row.definition));
        }
    }
}

/// Rule 4.
fn check_opening(comment: &str, item: &str, rows: &[Row], found: &mut Found) {
    let own: Vec<&Row> = rows.iter().filter(|row| row.names.iter().any(|n| n == item)).collect();
    let end = comment.find([':', '.', '(', '=']).unwrap_or(comment.len());
    let openings: Vec<&str> = comment[..end].split(", ").flat_map(|o| o.split(" and ")).collect();
    let opening = openings[0].trim();
    let is_word = opening.contains(' ');
    let is_symbol = opening.contains('∂') || rows.iter().any(|row| row.symbol == opening);
    if own.is_empty() || is_word || !is_symbol {
        return;
    }
    found.n_checked += 1;
    // `M, G and γ` opens the comment of several quantities.
    if !openings.iter().any(|opening| own.iter().any(|row| row.symbol == opening.trim())) {
        found.faults.push(format!("`{item}` is `{}`, not `{opening}`", own[0].symbol));
    }
}

/// A letter at the start of `text`, without its index, and the text after it.
fn letter(text: &str) -> Option<(String, &str)> {
    let first = text.chars().next().filter(|c| c.is_alphabetic())?;
    let mut rest = &text[first.len_utf8()..];
    if let Some(index) = rest.strip_prefix('_') {
        rest = index.trim_start_matches(|c: char| c.is_ascii_alphanumeric());
    }
    let is_word = rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    (!is_word).then(|| (first.to_string(), rest))
}

/// The rows of the table after the line that starts with `head`.
fn table(theory: &str, head: &str) -> Vec<Row> {
    let lines = theory.lines().skip_while(|line| !line.starts_with(head));
    let lines = lines.skip_while(|line| !line.starts_with("| ---")).skip(1);
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [symbol, arguments, code, ..] = cells[..] else {
            panic!("a row of four cells: {line}")
        };
        let (symbol, definition) = symbol.split_once(" = ").unwrap_or((symbol, ""));
        Row {
            symbol: symbol.to_owned(),
            definition: definition.to_owned(),
            arguments: arguments.to_owned(),
            names: code.split('`').skip(1).step_by(2).map(str::to_owned).collect(),
        }
    };
    lines.take_while(|line| line.starts_with('|')).map(row).collect()
}

/// The comment lines of a file, each with its number and, on the first line of a doc comment, the
/// name of the item; of a page of text, all lines.
fn comments(path: &Path) -> Vec<(usize, String, Option<String>)> {
    let text = text(path);
    if path.extension().is_some_and(|extension| extension == "md") {
        return text.lines().zip(1..).map(|(line, n)| (n, line.to_owned(), None)).collect();
    }
    let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let Some(comment) = line.strip_prefix("//") else { continue };
        let is_first = line.starts_with("///") && (at == 0 || !lines[at - 1].starts_with("///"));
        let item = if is_first { item_after(&lines[at..]) } else { None };
        found.push((at + 1, comment.trim_start_matches(['/', '!']).trim().to_owned(), item));
    }
    found
}

/// The field or function that a doc comment at the first line belongs to.
fn item_after(lines: &[&str]) -> Option<String> {
    let line = lines.iter().find(|line| !line.starts_with("///") && !line.starts_with('#'))?;
    let start =
        ["pub(crate) ", "pub(super) ", "pub ", ""].iter().find_map(|p| line.strip_prefix(p))?;
    let start = start.strip_prefix("fn ").unwrap_or(start);
    let name: String = start.chars().take_while(|&c| c.is_alphanumeric() || c == '_').collect();
    (start.len() > name.len() && start[name.len()..].starts_with([':', '('])).then_some(name)
}

/// The file itself, or all files of Rust below a directory.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).expect("a directory of the project");
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| entry.expect("an entry of the directory").path()).collect();
    paths.sort();
    let is_source = |path: &PathBuf| path.is_dir() || path.extension().is_some_and(|e| e == "rs");
    paths.into_iter().filter(is_source).flat_map(|path| files(&path)).collect()
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
