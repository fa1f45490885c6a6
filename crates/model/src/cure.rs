//! Cures of faults: the edits of a model text that follow the help of a diagnostic to the letter.
//!
//! A help is a sentence for people; what stands in quotes, backticks or brackets in it is what to write. Helps that
//! leave the choice of words to the author have no cure here. Tests follow every help of every known fault, and expect
//! that the fault is gone.

use crate::diagnostic::{Diagnostic, Span};

/// An edit of a model text that takes a fault away.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Cure {
    /// Bytes that are replaced.
    pub span: Span,
    /// Text in their place.
    pub text: String,
}

/// Alternatives of one help are listed up to this number.
const MOST_WORDS: usize = 12;

/// The edits that the help of a fault of `text` describes, any one of which cures it; the likeliest comes first.
///
/// ```
/// use bksim_model::cure::cures;
/// use bksim_model::file::{Source, read};
///
/// let text = "[bodies.bob]\nmass = \"1 kg\"\nfree = true\n[loads.g]\ntype = \"gravty\"\n";
/// let faults = read(&Source::new(text, "model")).diagnostics;
/// let cure = &cures(text, &faults[0])[0];
/// assert_eq!((&text[cure.span.clone()], cure.text.as_str()), ("gravty", "gravity"));
/// ```
pub fn cures(text: &str, fault: &Diagnostic) -> Vec<Cure> {
    let (Some(help), Some(label)) = (fault.help.as_deref(), fault.labels.first()) else {
        return Vec::new();
    };
    let place = Place { text, label: label.span.clone() };
    let mut found = place.listed(help);
    found.extend(place.first(help));
    found.extend(place.alternatives(help));
    let mut distinct: Vec<Cure> = Vec::new();
    for cure in found {
        if text.get(cure.span.clone()).is_some_and(|old| old != cure.text)
            && !distinct.contains(&cure)
        {
            distinct.push(cure);
        }
    }
    distinct
}

/// A text with the place of a fault in it.
struct Place<'t> {
    text: &'t str,
    label: Span,
}

/// The text between two marks.
fn between<'t>(text: &'t str, start: &str, end: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(start)?;
    Some(&rest[..rest.find(end)?])
}

fn replaced(span: Span, text: impl Into<String>) -> Cure {
    Cure { span, text: text.into() }
}

/// Key and value of `key = value`, unless either is more than that.
fn assignment(written: &str) -> Option<(&str, &str)> {
    written.split_once(" = ").filter(|(key, _)| !key.contains(['(', '"', '{', ' ', '[']))
}

impl Place<'_> {
    /// Words of which any one fits the place.
    fn listed(&self, help: &str) -> Vec<Cure> {
        if let Some(rest) = help.strip_prefix("remove `")
            && let Some((first, rest)) = rest.split_once("` or `")
            && let Some((second, _)) = rest.split_once('`')
        {
            return [first, second].iter().filter_map(|name| self.without(name)).collect();
        }
        let starts = ["did you mean `", "one of `", "rename it, for example `"];
        if !starts.iter().any(|start| help.starts_with(start)) {
            return Vec::new();
        }
        let words = help.split('`').skip(1).step_by(2).take(MOST_WORDS);
        words.map(|word| replaced(self.label.clone(), self.as_key(word))).collect()
    }

    /// The cure that a help begins with.
    fn first(&self, help: &str) -> Option<Cure> {
        let (text, label) = (self.text, &self.label);
        if let Some(line) = between(help, "write the line as `", "`") {
            let at = self.line();
            let indent = text[at.clone()].len() - text[at.clone()].trim_start().len();
            return Some(replaced(at.start + indent..at.end, line));
        }
        for start in [
            "write \"",
            "write for example \"",
            "for example \"",
            "the number needs its unit: write \"",
        ] {
            let value = help.starts_with(start).then(|| between(help, start, "\"")).flatten();
            if let Some(value) = value {
                return Some(replaced(self.value(), format!("\"{value}\"")));
            }
        }
        if let Some(rest) = help.strip_prefix("write a value near ") {
            let end = rest.find([',', '('])?;
            return Some(replaced(self.value(), format!("\"{}\"", rest[..end].trim())));
        }
        for start in ["write for example `", "write `", "write [", "write for example ["] {
            let bracket = start.ends_with('[');
            let end = if bracket { "]" } else { "`" };
            let written = help.starts_with(start).then(|| between(help, start, end)).flatten();
            let Some(written) = written else { continue };
            if bracket {
                return Some(replaced(self.value(), format!("[{written}]")));
            }
            // Words in the place of an example, and helps that offer several ways.
            let after = &help[start.len() + written.len() + 1..];
            let is_of_words = written == "key = value" || after.starts_with(" before");
            if written.contains('…') || after.starts_with(" and `") || is_of_words {
                return None;
            }
            return Some(match assignment(written) {
                Some((key, value)) => self.stated(key, value),
                None => replaced(label.clone(), written),
            });
        }
        if help.starts_with("remove it") && text[label.end..].trim_start().starts_with('=') {
            return Some(self.without_key(label));
        }
        if let Some(value) = between(help, "give at least \"", "\"") {
            return Some(replaced(self.value(), format!("\"{value}\"")));
        }
        if help.starts_with("rename one of them, for example") {
            return Some(replaced(label.clone(), between(help, "to `", "`")?));
        }
        (help == "keep one of the two lines" || help.starts_with("remove the line,"))
            .then(|| replaced(self.line(), ""))
    }

    /// Cures that a help offers after the first: `…, or write X`, `…, or X in its table`.
    fn alternatives(&self, help: &str) -> Vec<Cure> {
        let mut found = Vec::new();
        if help.starts_with("remove `") && help.contains("or write it as a guess") {
            found.extend(self.guessed());
        }
        for (at, mark) in help.match_indices(" or ") {
            let rest = &help[at + mark.len()..];
            let rest = rest.strip_prefix("write ").unwrap_or(rest);
            if let Some(value) = rest.strip_prefix('"').and_then(|rest| rest.split('"').next())
                && help.starts_with("write \"")
            {
                found.push(replaced(self.value(), format!("\"{value}\"")));
            }
            let Some(written) = rest.strip_prefix('`').and_then(|rest| rest.split('`').next())
            else {
                continue;
            };
            let after = &rest[written.len() + 2..];
            let Some((key, value)) = assignment(written) else { continue };
            if after.starts_with(" at the top of the file") || key == "space" {
                found.push(self.at_top(key, value));
            } else if after.starts_with(" in its table") || key == "free" {
                found.push(self.in_table(key, value));
            }
        }
        found
    }

    /// The edits that make a stated value of `[initial]` a guess, or take it away.
    fn guessed(&self) -> Vec<Cure> {
        let value = self.value();
        let before = self.text[..value.start].trim_end();
        let Some(before) = before.strip_suffix('=').map(str::trim_end) else { return Vec::new() };
        let word = before.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_');
        let start = word.len();
        let key = start..before.len();
        let mut found = vec![self.without_key(&key)];
        // A table has one guess.
        if !self.text[self.line()].contains("guess")
            && before[..start].trim_end().ends_with(['{', ','])
        {
            let stated = &self.text[start..value.end];
            found.insert(0, replaced(start..value.end, format!("guess = {{ {stated} }}")));
        }
        found
    }

    /// The line of the place, without its end.
    fn line(&self) -> Span {
        let at = self.label.start;
        let start = self.text[..at].rfind('\n').map_or(0, |end| end + 1);
        let end = self.text[at..].find('\n').map_or(self.text.len(), |end| at + end);
        start..end
    }

    /// The value that the label is at, or in: with the quotes around it.
    fn value(&self) -> Span {
        let line = self.line();
        let mut open = None;
        for (at, c) in self.text[line.clone()].char_indices() {
            let at = line.start + at;
            if c != '"' {
                continue;
            }
            match open.take() {
                Some(from) if (from..=at).contains(&self.label.start) => return from..at + 1,
                Some(_) => (),
                None => open = Some(at),
            }
        }
        self.label.clone()
    }

    /// A word as a key, in quotes where the old one had them.
    fn as_key(&self, word: &str) -> String {
        let is_quoted = self.text[self.label.clone()].starts_with('"');
        if is_quoted { format!("\"{word}\"") } else { word.to_owned() }
    }

    /// The edit that takes a key and its value away.
    fn without_key(&self, key: &Span) -> Cure {
        let text = self.text;
        let from = key.end + text[key.end..].find('=').map_or(0, |at| at + 1);
        let from = from + (text[from..].len() - text[from..].trim_start().len());
        let end = end_of_value(text, from);
        // In a table of one line a comma goes with it.
        let rest = text[end..].trim_start_matches(' ');
        let before = &text[..key.start];
        let (start, end) = match (rest.strip_prefix(','), before.trim_end().strip_suffix(',')) {
            (Some(after), _) => (key.start, text.len() - after.trim_start_matches(' ').len()),
            (None, Some(kept)) if rest.starts_with('}') => (kept.len(), end),
            // Nothing is left of a line of its own.
            _ if before.ends_with('\n') && rest.starts_with('\n') => {
                (key.start, text.len() - rest.len() + 1)
            }
            _ => (key.start, end),
        };
        replaced(start..end, "")
    }

    /// The edit that takes away a key of the table of the place, or a table, `[drives.slow]`.
    fn without(&self, name: &str) -> Option<Cure> {
        let text = self.text;
        if name.starts_with('[') {
            let start = text.find(&format!("\n{name}")).map(|at| at + 1);
            let start = start.or_else(|| text.starts_with(name).then_some(0))?;
            let end = text[start + 1..].find("\n[").map_or(text.len(), |at| start + 1 + at + 1);
            return Some(replaced(start..end, ""));
        }
        let table = self.table();
        let is_own = |at: &usize| {
            let before = text[..*at].trim_end_matches(' ');
            let begins = before.is_empty() || before.ends_with(['\n', '{', ',']);
            begins && text[at + name.len()..].trim_start_matches(' ').starts_with('=')
        };
        let mut places = text[table.clone()].match_indices(name).map(|(at, _)| table.start + at);
        let at = places.find(is_own)?;
        Some(self.without_key(&(at..at + name.len())))
    }

    /// The edit that gives a key this value: in the place of the one that the label is at, or added to its table.
    fn stated(&self, key: &str, value: &str) -> Cure {
        let (text, label) = (self.text, &self.label);
        let line = self.line();
        let own = &text[line.clone()];
        let is_header = own.trim_start().starts_with('[');
        let last = key.rsplit('.').next().unwrap_or(key);
        let in_line = own.find(&format!("{last} = ")).map(|at| line.start + at);
        if let Some(at) = in_line.filter(|_| !is_header) {
            let from = at + last.len() + 3;
            return replaced(from..end_of_value(text, from), value);
        }
        // The key at the label has another name.
        if !is_header && text[label.end..line.end].trim_start().starts_with('=') {
            let from = label.end + text[label.end..].find('=').map_or(0, |at| at + 1);
            let from = from + (text[from..].len() - text[from..].trim_start().len());
            return replaced(label.start..end_of_value(text, from), format!("{key} = {value}"));
        }
        self.in_table(key, value)
    }

    /// The edit that adds a key to the table: before the brace of one in a line, else below the header.
    fn in_table(&self, key: &str, value: &str) -> Cure {
        let line = self.line();
        let before = &self.text[line.start..self.label.start];
        let is_inside = before.rfind('{').is_some_and(|open| !before[open..].contains('}'));
        let close = self.text[self.label.end..line.end].find('}').filter(|_| is_inside);
        if let Some(close) = close {
            let end = self.text[..self.label.end + close].trim_end().len();
            return replaced(end..end, format!(", {key} = {value}"));
        }
        let header = self.header();
        replaced(header.end..header.end, format!("\n{key} = {value}"))
    }

    /// The edit that adds a key before all tables.
    fn at_top(&self, key: &str, value: &str) -> Cure {
        let lines = self.text.split_inclusive('\n');
        let comments = lines.take_while(|line| line.starts_with('#')).map(str::len);
        let at = comments.sum();
        replaced(at..at, format!("{key} = {value}\n"))
    }

    /// The header of the table that the place is in.
    fn header(&self) -> Span {
        let line = self.line();
        let mut found = 0..0;
        let mut start = 0;
        for line in self.text[..line.end].split_inclusive('\n') {
            if line.starts_with('[') {
                // A comment stays on its line.
                found = start..start + line.trim_end().len();
            }
            start += line.len();
        }
        found
    }

    /// The table that the place is in, from its header to the next.
    fn table(&self) -> Span {
        let header = self.header();
        let next = self.text[header.end..].find("\n[");
        header.end..next.map_or(self.text.len(), |at| header.end + at)
    }
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
            ',' | '\n' | '}' | ']' | '#' if depth == 0 => {
                return from + text[from..from + at].trim_end().len();
            }
            _ => (),
        }
    }
    text.len()
}
