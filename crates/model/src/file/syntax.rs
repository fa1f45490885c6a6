//! TOML in, tree out: encoding, nesting, syntax errors and duplicate keys in plain words.

use toml::de::{DeTable, DeValue, Error};

use super::codes;
use super::letters::{foreign_letters, spelled};
use super::marks::{decimal_comma, typographic_quotes};
use super::other_forms::{
    crossed_brackets, encoding_of, known_kind, nearly, old_line_ends, other_language, repaired,
};
use super::token::token_length;
use super::tree::Table;
use crate::diagnostic::{Diagnostic, Span};

/// The deepest nesting the TOML reader itself allows.
const TOML_NESTING: usize = 80;

/// More repeated names than this are not looked up: each costs a reading of the text above it.
const MAX_DUPLICATES: usize = 20;

/// Checks that the file is UTF-8.
///
/// # Errors
/// [`codes::NOT_UTF8`] with the line, the column (in characters) and the offset of the first bad
/// byte.
pub fn decode(bytes: &[u8]) -> Result<&str, Diagnostic> {
    if let Some((kind, help)) = known_kind(bytes) {
        let message = format!("the file is {kind}, and a model is TOML");
        let fault = Diagnostic::error(codes::NOT_UTF8, message).at(0..0, "its first bytes show it");
        return Err(fault.help(help));
    }
    if let Some(encoding) = encoding_of(bytes) {
        let message = format!("the file is {encoding}, not UTF-8");
        return Err(Diagnostic::error(codes::NOT_UTF8, message)
            .at(0..0, "its first bytes show it")
            .help("save the file with the encoding UTF-8"));
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let offset = error.valid_up_to();
        let good = String::from_utf8_lossy(&bytes[..offset]);
        let line = good.matches('\n').count() + 1;
        let column = good.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        let message = format!(
            "the file is not UTF-8: byte 0x{:02X} at line {line}, column {column} (byte offset {offset})",
            bytes[offset]
        );
        Diagnostic::error(codes::NOT_UTF8, message)
            .at(offset..offset, "not a UTF-8 character")
            .help("save the file with the encoding UTF-8")
    })
}

/// Reads the text into a tree.
///
/// Duplicate keys are reported and the first value counts; any other fault of syntax ends the
/// reading, because what follows it would be guesswork.
pub(super) fn parse(text: &str, nesting: usize, faults: &mut Vec<Diagnostic>) -> Option<Table> {
    if let Some(offset) = too_deep(text, nesting.min(TOML_NESTING)) {
        faults.push(nesting_fault(offset, nesting));
        return None;
    }
    let (document, errors) = DeTable::parse_recoverable(text);
    let (duplicates, broken): (Vec<_>, Vec<_>) =
        errors.into_iter().partition(|error| error.message().contains("duplicate key"));
    if let Some(first) = broken.into_iter().min_by_key(|error| start(text, error)) {
        if let Some(fault) = other_language(text).or_else(|| old_line_ends(text)) {
            faults.push(fault);
            return None;
        }
        let line = line_of(text, start(text, &first));
        // Only such quotes and letters in the line of the fault explain it.
        let explains =
            |fault: &Diagnostic| fault.labels.iter().any(|label| line.contains(&label.span.start));
        let marks = [typographic_quotes(text), foreign_letters(text)];
        match marks.into_iter().find(|marks| marks.iter().any(explains)) {
            Some(marks) => faults.extend(marks),
            None => faults
                .push(decimal_comma(text, line).unwrap_or_else(|| explain_syntax(text, &first))),
        }
        return None;
    }
    report_duplicates(text, &duplicates, faults);
    Some(Table::from_toml(document.get_ref()))
}

fn start(text: &str, error: &Error) -> usize {
    error.span().map_or(text.len(), |span| span.start)
}

/// Position of the first bracket that is nested deeper than allowed; brackets in texts and comments
/// do not count.
fn too_deep(text: &str, limit: usize) -> Option<usize> {
    let mut depth = 0_usize;
    let mut rest = text;
    while let Some(at) = rest.find(['[', ']', '{', '}', '"', '\'', '#', '\n']) {
        let offset = text.len() - rest.len() + at;
        let tail = &rest[at..];
        match tail.as_bytes()[0] {
            b'[' | b'{' => {
                depth += 1;
                if depth > limit {
                    return Some(offset);
                }
            }
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => (),
        }
        rest = &tail[token_length(tail)..];
    }
    None
}

fn nesting_fault(offset: usize, asked: usize) -> Diagnostic {
    let limit = asked.min(TOML_NESTING);
    let fault = Diagnostic::error(codes::NESTING, format!("nested deeper than {limit} brackets"))
        .at(offset..offset + 1, "the first bracket too deep");
    if limit < TOML_NESTING {
        fault.help(format!(
            "close the brackets before this one, or allow more with `--max-nesting` (at most {TOML_NESTING})"
        ))
    } else {
        fault
            .help("close the brackets before this one; `--max-nesting` cannot allow more in a file")
    }
}

/// Characters of a long name that are marked.
const SHOWN: usize = 40;

/// The beginning of the first name with more parts than the TOML reader allows; `place` if none is
/// seen.
fn longest_name(text: &str, place: usize) -> Span {
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let name = line.split('=').next().unwrap_or_default().trim_end();
        if name.matches('.').count() >= TOML_NESTING {
            return start..start + name.len().min(SHOWN);
        }
        start += line.len();
    }
    place..place
}

/// Puts a syntax error of the TOML reader into the words of a model's author.
fn explain_syntax(text: &str, error: &Error) -> Diagnostic {
    let span = error.span().unwrap_or(text.len()..text.len());
    let said = error.message();
    let line = line_of(text, span.start);
    // Faults about which the message is enough.
    if said.contains("string, expected `") && said.starts_with("invalid") && span.is_empty() {
        return unclosed_text(text, &span, said);
    }
    if said.starts_with("recursion limit") {
        let message = format!("a name has more than {TOML_NESTING} parts");
        return Diagnostic::error(codes::NESTING, message)
            .at(longest_name(text, line.start), "this name")
            .help("names of this model have at most three parts, such as `bodies.crank.mass`");
    }
    if let Some(fault) = repaired(text, &line) {
        return fault;
    }
    // Values and keys.
    let token = text.get(span.clone()).unwrap_or_default();
    let fault = |message: &str| Diagnostic::error(codes::SYNTAX, message);
    if said.starts_with("string values must be quoted") {
        if token.trim().is_empty() {
            return fault("a value is missing after `=`")
                .at(span, "nothing here")
                .help("write a number, or a quantity in quotes such as \"25 mm\"");
        }
        return fault("a quantity or an expression must stand in quotes")
            .at(span, "not in quotes")
            .help(format!("write \"{}\"", token.trim()));
    }
    if let Some(nearly) = nearly(text, &line) {
        return nearly;
    }
    if said.starts_with("key with no value") {
        return fault("`=` is missing after a key")
            .at(line.start..line.end, "a key and its value are joined by `=`")
            .help("write `key = value`, a table as `[bodies.name]`, or a comment after `#`");
    }
    // Brackets and commas.
    if said.starts_with("unclosed table") {
        return fault("`[` of the table is not closed")
            .at(line.clone(), "no `]` in this line")
            .help(format!("write the line as `{}]`", text[line].trim()));
    }
    if let Some(places) = crossed_brackets(text, &line) {
        return crossed(text, &line, places);
    }
    if let Some(offset) = unclosed_bracket(text, said, &span) {
        let bracket = &text[offset..=offset];
        let close = if bracket == "[" { "]" } else { "}" };
        let own_line = &text[line_of(text, offset)];
        // A line that goes on in the next one ends where nobody can know.
        let goes_on = own_line.trim_end().ends_with(['[', '{', ',']) || own_line.contains('#');
        let blank = if close == "}" { " " } else { "" };
        let help = if goes_on {
            format!("add `{close}` where it ends")
        } else {
            format!("write the line as `{}{blank}{close}`", own_line.trim())
        };
        return fault(&format!("`{bracket}` is not closed"))
            .at(offset..offset + 1, "opened here")
            .help(help);
    }
    if said.starts_with("missing comma") {
        return fault("a comma is missing").at(span, "before this").help("add `,` here");
    }
    // Tokens that are no value, number or name.
    if said.starts_with("cannot extend value") {
        return fault(&format!("`{token}` already has a value and cannot be a table"))
            .at(span, "used as a table here")
            .help("remove the line that gives it a value");
    }
    if said.starts_with("invalid boolean") {
        let help = "write `true` or `false` in lower case, and texts in quotes";
        return fault(&format!("`{token}` is no value")).at(span, "").help(help);
    }
    let number = ["invalid float", "invalid fraction", "invalid mantissa", "invalid exponent"];
    if number.iter().any(|start| said.starts_with(start)) || said.contains("leading zero") {
        return fault("this is no number")
            .at(span, "")
            .help("write digits on both sides of the point and no zero in front, such as 0.5");
    }
    if said.starts_with("invalid unquoted key") {
        let better = spelled(token, 'p');
        return fault(&format!("`{token}` cannot be a name"))
            .at(span, "only the letters a–z and A–Z, digits and `_`")
            .help(format!("rename it, for example `{better}`"));
    }
    let plain = said.split(", expected").next().unwrap_or(said);
    fault(&format!("the file is not TOML: {plain}"))
        .at(span, "")
        .help("every line is `key = value`, `[table]`, a comment after `#`, or empty")
}

/// A bracket that one of the other kind closes.
fn crossed(text: &str, line: &Span, [open, close]: [usize; 2]) -> Diagnostic {
    let bracket = &text[open..=open];
    let missing = if bracket == "[" { "]" } else { "}" };
    let column = text[line.start..open].chars().count() + 1;
    let message = format!("`{bracket}` at column {column} is not closed");
    let before = text[line.start..close].trim();
    let blank = if missing == "]" { "" } else { " " };
    let after = &text[close..line.end];
    // A blank that stood before the other bracket stays before it.
    let gap = if text[..close].ends_with(' ') { " " } else { "" };
    Diagnostic::error(codes::SYNTAX, message)
        .at(open..open + 1, "opened here")
        .at(close..close + 1, "closes another kind of bracket")
        .help(format!("write the line as `{before}{blank}{missing}{gap}{}`", after.trim_end()))
}

/// The opening quote of a text that does not end in its line, or in the file.
fn unclosed_text(text: &str, end: &Span, said: &str) -> Diagnostic {
    let many = said.contains("multi-line");
    let mark = if said.contains("literal") { '\'' } else { '"' };
    let line = line_of(text, end.start);
    // The opening quote: the first token of the line that runs to its end; for a long text, the
    // first such token of the file.
    let from = if many { 0 } else { line.start };
    let mut open = end.start;
    let mut rest = &text[from..end.start];
    while let Some(at) = rest.find(['"', '\'', '#']) {
        let offset = end.start - rest.len() + at;
        let length = token_length(&text[offset..end.start]);
        if offset + length >= end.start {
            open = offset;
            break;
        }
        rest = &text[offset + length..end.start];
    }
    let quotes = mark.to_string().repeat(if many { 3 } else { 1 });
    let help = match with_quote(&text[line], mark).filter(|_| !many) {
        Some(whole) => format!("write the line as `{whole}`"),
        None if many => format!("add `{quotes}` where the text ends"),
        None => format!("add `{quotes}` at the end of the line"),
    };
    let width = if open == end.start { 0 } else { quotes.len() };
    Diagnostic::error(codes::SYNTAX, "string is not closed")
        .at(open..open + width, "opened here")
        .help(help)
}

/// The line with one more quote, where that makes it TOML: before a comma, a bracket or a comment, or at its end.
fn with_quote(line: &str, mark: char) -> Option<String> {
    /// Longer lines have too many places.
    const LONGEST: usize = 400;
    let line = line.trim();
    if line.len() > LONGEST {
        return None;
    }
    let places = line.char_indices().filter(|(_, c)| matches!(c, ',' | ']' | '}' | '#'));
    let places = places.map(|(at, _)| line[..at].trim_end().len()).chain([line.len()]);
    let mut written = places.map(|at| format!("{}{mark}{}", &line[..at], &line[at..]));
    written.find(|whole| DeTable::parse(whole).is_ok())
}

/// The innermost bracket still open where an array or inline table went wrong, when the fault is
/// that the next line of the file already starts.
fn unclosed_bracket(text: &str, said: &str, span: &Span) -> Option<usize> {
    let at_end = said.starts_with("unclosed");
    let line = text[line_of(text, span.start)].trim();
    let is_header = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    let is_header = is_header.is_some_and(|name| {
        let is_part = |c: char| c.is_alphanumeric() || "_.- []".contains(c);
        name.starts_with(|c: char| c.is_alphabetic() || c == '[') && name.chars().all(is_part)
    });
    let is_inside = said.starts_with("missing comma")
        || ["in array", "inline table"].iter().any(|place| said.contains(place));
    let next_line = (is_header || line.contains('=')) && is_inside;
    if !at_end && !next_line {
        return None;
    }
    let mut open = Vec::new();
    let mut rest = &text[..span.start];
    while let Some(at) = rest.find(['[', ']', '{', '}', '"', '\'', '#']) {
        let offset = span.start - rest.len() + at;
        match text.as_bytes()[offset] {
            b'[' | b'{' => open.push(offset),
            b']' | b'}' => drop(open.pop()),
            _ => (),
        }
        rest = &text[offset + token_length(&text[offset..span.start])..span.start];
    }
    let innermost = open.pop()?;
    (at_end || line_of(text, innermost) != line_of(text, span.start)).then_some(innermost)
}

/// The line around a position, without its end.
fn line_of(text: &str, offset: usize) -> Span {
    let offset = offset.min(text.len());
    let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    let end = text[offset..].find('\n').map_or(text.len(), |at| offset + at);
    start..end
}

/// Reports each name that is defined again, with the position of the first definition.
fn report_duplicates(text: &str, errors: &[Error], faults: &mut Vec<Diagnostic>) {
    let mut repeated_table: Option<Span> = None;
    for span in errors.iter().filter_map(Error::span).take(MAX_DUPLICATES) {
        let line = line_of(text, span.start);
        // A repeated table repeats its keys too: one message is enough.
        if repeated_table.as_ref().is_some_and(|table| table.contains(&span.start)) {
            continue;
        }
        if text[line.clone()].trim_start().starts_with('[') {
            let end = text[line.end..].find("\n[").map_or(text.len(), |at| line.end + at);
            repeated_table = Some(line.start..end);
        }
        let name = text.get(span.clone()).unwrap_or_default();
        let fault = Diagnostic::error(codes::DUPLICATE, format!("`{name}` is defined twice"))
            .at(span.clone(), "again here");
        let fault = match first_definition(text, &span) {
            Some(first) => fault.at(first, "first defined here"),
            None => fault,
        };
        faults.push(fault.help(if repeated_table.is_some() {
            "names must be unique: rename one of the two or remove it"
        } else {
            "keep one of the two lines"
        }));
    }
}

/// Earlier definition of the key at `span`: the same path in the text above it.
fn first_definition(text: &str, span: &Span) -> Option<Span> {
    let line = line_of(text, span.start);
    let is_header = text[line.clone()].trim_start().starts_with('[');
    // The table this line belongs to, then the path of the key within the file.
    let header = if is_header {
        line.clone()
    } else {
        text[..line.start]
            .match_indices('\n')
            .map(|(at, _)| at + 1)
            .chain([0])
            .filter(|&at| text[at..].starts_with('['))
            .max()
            .map_or(0..0, |at| line_of(text, at))
    };
    let key_start = if is_header { line.start } else { span.start };
    let alone = DeTable::parse_recoverable(text.get(header)?).0;
    let mut path = single_path(alone.get_ref());
    let key = text.get(span.clone())?.trim_matches(['"', '\'']);
    if !is_header {
        path.push(key.to_owned());
    }
    let above = DeTable::parse_recoverable(text.get(..key_start)?).0;
    if let Some(offset) = look_up(above.get_ref(), &path) {
        return Some(offset);
    }
    // Within one line, such as an inline table: the same word before.
    let before = text.get(line.start..span.start)?;
    let at = before.rfind(key)?;
    Some(line.start + at..line.start + at + key.len())
}

/// The keys of a document that holds one empty table: `[a.b]` gives `a`, `b`.
fn single_path(table: &DeTable<'_>) -> Vec<String> {
    let mut path = Vec::new();
    let mut here = table;
    while let Some((key, value)) = here.iter().next() {
        path.push(key.get_ref().to_string());
        match value.get_ref() {
            DeValue::Table(inner) => here = inner,
            _ => break,
        }
    }
    path
}

fn look_up(table: &DeTable<'_>, path: &[String]) -> Option<Span> {
    let (last, parents) = path.split_last()?;
    let mut here = table;
    for name in parents {
        let (_, value) = here.iter().find(|(key, _)| key.get_ref() == name)?;
        here = match value.get_ref() {
            DeValue::Table(inner) => inner,
            _ => return None,
        };
    }
    here.iter().find(|(key, _)| key.get_ref() == last).map(|(key, _)| key.span())
}
