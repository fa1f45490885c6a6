//! Helps followed to the letter: what they say to write is written, and the fault must be gone.

use bksim_model::diagnostic::{Diagnostic, Span};

/// A model text after what the help of a fault says to write; `None` where the help leaves it to the author.
pub(super) fn followed(text: &str, fault: &Diagnostic) -> Option<String> {
    let help = fault.help.as_deref()?;
    let label = fault.labels.first()?.span.clone();
    if let Some(line) = between(help, "write the line as `", "`") {
        let at = line_of(text, label.start);
        let indent = text[at.clone()].len() - text[at.clone()].trim_start().len();
        return Some(replaced(text, &(at.start + indent..at.end), line));
    }
    for start in ["write \"", "write for example \"", "the number needs its unit: write \""] {
        let Some(value) = help.starts_with(start).then(|| between(help, start, "\"")).flatten()
        else {
            continue;
        };
        // A sentence about words inside of a text, not a value for it.
        return Some(replaced(text, &value_at(text, &label), &format!("\"{value}\"")));
    }
    for start in ["write for example `", "write `", "write [", "write for example ["] {
        let bracket = start.ends_with('[');
        let end = if bracket { "]" } else { "`" };
        let Some(written) = help.starts_with(start).then(|| between(help, start, end)).flatten()
        else {
            continue;
        };
        if bracket {
            return Some(replaced(text, &value_at(text, &label), &format!("[{written}]")));
        }
        // Words in the place of an example, and helps that offer several ways.
        let after = &help[start.len() + written.len() + 1..];
        let is_of_words = written == "key = value" || after.starts_with(" before");
        if written.contains('…') || after.starts_with(" and `") || is_of_words {
            return None;
        }
        return Some(match written.split_once(" = ") {
            Some((key, value)) if !key.contains(['(', '"', '{']) => {
                stated(text, &label, key, value)
            }
            _ => replaced(text, &label, written),
        });
    }
    if help.starts_with("remove it") && text[label.end..].trim_start().starts_with('=') {
        return Some(without_key(text, &label));
    }
    for start in ["did you mean `", "one of `", "rename it, for example `"] {
        if help.starts_with(start) {
            let word = between(help, start, "`")?;
            return Some(replaced(text, &label, &as_key(text, &label, word)));
        }
    }
    if help.starts_with("rename one of them, for example") {
        return Some(replaced(text, &label, between(help, "to `", "`")?));
    }
    if help == "keep one of the two lines" {
        let at = line_of(text, label.start);
        return Some(replaced(text, &at, ""));
    }
    None
}

/// The text between two marks.
fn between<'t>(text: &'t str, start: &str, end: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(start)?;
    Some(&rest[..rest.find(end)?])
}

fn replaced(text: &str, at: &Span, with: &str) -> String {
    format!("{}{with}{}", &text[..at.start], &text[at.end..])
}

/// The line around a place, without its end.
fn line_of(text: &str, at: usize) -> Span {
    let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    let end = text[at..].find('\n').map_or(text.len(), |end| at + end);
    start..end
}

/// The value that a label is at, or in: with the quotes around it.
fn value_at(text: &str, label: &Span) -> Span {
    let line = line_of(text, label.start);
    let mut open = None;
    for (at, c) in text[line.clone()].char_indices() {
        let at = line.start + at;
        if c != '"' {
            continue;
        }
        match open.take() {
            Some(from) if (from..=at).contains(&label.start) => return from..at + 1,
            Some(_) => (),
            None => open = Some(at),
        }
    }
    label.clone()
}

/// A word as a key, in quotes where the old one had them.
fn as_key(text: &str, label: &Span, word: &str) -> String {
    if text[label.clone()].starts_with('"') { format!("\"{word}\"") } else { word.to_owned() }
}

/// The text without a key and its value.
fn without_key(text: &str, key: &Span) -> String {
    let from = key.end + text[key.end..].find('=').map_or(0, |at| at + 1);
    let from = from + (text[from..].len() - text[from..].trim_start().len());
    let end = end_of_value(text, from);
    // In a table of one line a comma goes with it.
    let rest = text[end..].trim_start_matches(' ');
    let before = &text[..key.start];
    let (start, end) = match (rest.strip_prefix(','), before.trim_end().strip_suffix(',')) {
        (Some(after), _) => (key.start, text.len() - after.len()),
        (None, Some(kept)) if rest.starts_with('}') => (kept.len(), end),
        _ => (key.start, end),
    };
    replaced(text, &(start..end), "")
}

/// The text with a key of this value: in the place of the one that the label is at, or added to its table.
fn stated(text: &str, label: &Span, key: &str, value: &str) -> String {
    let line = line_of(text, label.start);
    let own = &text[line.clone()];
    let is_header = own.trim_start().starts_with('[');
    let last = key.rsplit('.').next().unwrap_or(key);
    let in_line = own.find(&format!("{last} = ")).map(|at| line.start + at);
    if let Some(at) = in_line.filter(|_| !is_header) {
        let from = at + last.len() + 3;
        return replaced(text, &(from..end_of_value(text, from)), value);
    }
    // The key at the label has another name.
    if !is_header && text[label.end..line.end].trim_start().starts_with('=') {
        let from = label.end + text[label.end..].find('=').map_or(0, |at| at + 1);
        let from = from + (text[from..].len() - text[from..].trim_start().len());
        let without =
            replaced(text, &(label.start..end_of_value(text, from)), &format!("{key} = {value}"));
        return without;
    }
    let header = if is_header { line } else { header_above(text, label.start) };
    replaced(text, &(header.end..header.end), &format!("\n{key} = {value}"))
}

/// The header of the table that a place is in.
fn header_above(text: &str, at: usize) -> Span {
    let mut found = 0..0;
    let mut start = 0;
    for line in text[..at].split_inclusive('\n') {
        if line.starts_with('[') {
            found = start..start + line.trim_end().len();
        }
        start += line.len();
    }
    found
}

/// The end of the value that begins at a place: of a text, a list, a table or a number.
fn end_of_value(text: &str, from: usize) -> usize {
    let (mut depth, mut is_quoted) = (0_i32, false);
    for (at, c) in text[from..].char_indices() {
        match c {
            '"' => is_quoted = !is_quoted,
            _ if is_quoted => (),
            '[' | '{' => depth += 1,
            ']' | '}' if depth > 0 => depth -= 1,
            ',' | '\n' | '}' | ']' if depth == 0 => {
                return from + text[from..from + at].trim_end().len();
            }
            _ => (),
        }
    }
    text.len()
}
