//! A model file in order: one space around `=`, one empty line before a header, none at line ends.

use serde_json::{Value, json};

use super::document::Document;

/// The edits that put a document in order: none where it is.
pub(super) fn edits(document: &Document) -> Value {
    let formatted = formatted(&document.text);
    if formatted == document.text {
        return json!([]);
    }
    json!([{ "range": document.range(&(0..document.text.len())), "newText": formatted }])
}

/// The text in order. Lines within texts and arrays of several lines stay as they are.
fn formatted(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    // Open brackets, and the three quotes of a text of several lines.
    let (mut depth, mut quotes): (i32, Option<&str>) = (0, None);
    for line in text.lines() {
        let is_inside = depth > 0 || quotes.is_some();
        let marks = ["\"\"\"", "'''"];
        let opening = marks.iter().find(|mark| line.matches(**mark).count() % 2 == 1);
        if is_inside {
            lines.push(if quotes.is_some() { line.to_owned() } else { line.trim_end().to_owned() });
        } else if is_header(line) {
            // Comments above a header belong to it.
            let n_comments = lines.iter().rev().take_while(|line| line.starts_with('#')).count();
            let at = lines.len() - n_comments;
            if at > 0 && !lines[at - 1].is_empty() {
                lines.insert(at, String::new());
            }
            lines.push(line.trim().to_owned());
        } else if line.trim().is_empty() {
            if lines.last().is_some_and(|last| !last.is_empty()) {
                lines.push(String::new());
            }
        } else {
            lines.push(spaced(line.trim()));
        }
        match (quotes, opening) {
            (Some(open), Some(mark)) if open == *mark => quotes = None,
            (None, Some(mark)) => quotes = Some(mark),
            _ => (),
        }
        if quotes.is_none() && (depth > 0 || !is_header(line)) {
            depth = (depth + brackets(line)).max(0);
        }
    }
    while lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
    lines.iter().flat_map(|line| [line.as_str(), "\n"]).collect()
}

/// True if a line is a header: `[joints.A]`, `[[rows]]`.
fn is_header(line: &str) -> bool {
    let inside = line.trim().strip_prefix('[').map(|rest| rest.trim_start_matches('['));
    let Some((inside, _)) = inside.and_then(|rest| rest.split_once(']')) else { return false };
    let is_part = |c: char| c.is_alphanumeric() || "_-{}+".contains(c);
    let is_name = |part: &str| !part.is_empty() && part.trim_matches('"').chars().all(is_part);
    inside.split('.').all(|part| is_name(part.trim()))
}

/// A line with one space on both sides of its first `=`.
fn spaced(line: &str) -> String {
    let is_key = |key: &str| {
        !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || "_-.\" ".contains(c))
    };
    match line.split_once('=') {
        Some((key, value)) if is_key(key.trim()) && !line.starts_with('#') => {
            format!("{} = {}", key.trim(), value.trim())
        }
        _ => line.to_owned(),
    }
}

/// Brackets that a line opens, less those that it closes, outside of texts and comments.
fn brackets(line: &str) -> i32 {
    let mut depth = 0;
    let mut quote: Option<char> = None;
    for c in line.chars() {
        match (quote, c) {
            (Some(open), c) if open == c => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '#') => break,
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            _ => (),
        }
    }
    depth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_in_order_stays_and_any_text_keeps_its_meaning() {
        let messy =
            "a=1\n\n\n  b  =\"x = y\"   \n# of c\n[c]\nlist = [\n    1,\n    2,\n]\n[d]\n\n\n";
        let tidy = "a = 1\n\nb = \"x = y\"\n\n# of c\n[c]\nlist = [\n    1,\n    2,\n]\n\n[d]\n";
        assert_eq!(formatted(messy), tidy);
        assert_eq!(formatted(tidy), tidy);
        let several = "s = \"\"\"\n  as=it is  \n\n\n\"\"\"\nb=2\n";
        assert_eq!(formatted(several), "s = \"\"\"\n  as=it is  \n\n\n\"\"\"\nb = 2\n");
    }
}
