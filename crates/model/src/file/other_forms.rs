//! Files in another encoding or language, and lines that are nearly TOML: what they are, and how the line is written.

use toml::de::DeTable;

use super::codes;
use super::letters::{bare_parts, spelled};
use super::token::token_length;
use crate::diagnostic::{Diagnostic, Span};

/// The encoding of a file that is not UTF-8, where its first bytes show it.
pub(super) fn encoding_of(bytes: &[u8]) -> Option<&'static str> {
    /// Bytes that are looked at.
    const LOOKED_AT: usize = 256;
    let has_zeros = |from: usize| {
        let pairs = bytes[..bytes.len().min(LOOKED_AT)].chunks_exact(2);
        let n = pairs.len();
        let n_zeros = pairs.filter(|pair| pair[from] == 0 && pair[1 - from] != 0).count();
        n > 1 && 10 * n_zeros > 9 * n
    };
    match bytes {
        [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..] => Some("UTF-32"),
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Some("UTF-16"),
        _ if has_zeros(0) || has_zeros(1) => Some("UTF-16"),
        _ => None,
    }
}

/// The kind of a file that is no text, where its first bytes show it, and a help.
pub(super) fn known_kind(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    const KINDS: [(&[u8], &str, &str); 4] = [
        (
            b"\x89MCAP0\r\n",
            "a log (MCAP)",
            "`bksim info`, `report`, `plot`, `export` and `view` read logs",
        ),
        (
            b"PK\x03\x04",
            "an archive (ZIP), as Excel's and units (FMU) are",
            "save a table as CSV; `bksim import` reads robots and drawings",
        ),
        (b"%PDF-", "a PDF", "write the model as text, or begin with `bksim new NAME`"),
        (b"\x89PNG", "a picture (PNG)", "draw over it in `bksim page MODEL --live`, under Picture"),
    ];
    KINDS.iter().find(|(first, ..)| bytes.starts_with(first)).map(|(_, kind, help)| (*kind, *help))
}

/// The fault of a whole file that is no TOML but something known.
pub(super) fn other_language(text: &str) -> Option<Diagnostic> {
    let fault = |what: &str, at: Span, help: &str| {
        let message = format!("the file is {what}, and a model is TOML");
        Some(Diagnostic::error(codes::SYNTAX, message).at(at, "it begins so").help(help))
    };
    let start = text.len() - text.trim_start_matches(['\u{FEFF}', ' ', '\t', '\r', '\n']).len();
    let first = text[start..].chars().next()?;
    let line = text[start..].lines().next().unwrap_or_default();
    let at = start..start + first.len_utf8();
    let is_json = first == '{' || first == '[' && text[start + 1..].trim_start().starts_with('{');
    if is_json {
        let help = "write `[bodies.crank]` for `\"bodies\": { \"crank\": { … } }`, and `mass = \"1 kg\"` for `\"mass\": \"1 kg\"`";
        return fault("JSON", at, help);
    }
    if first == '<' {
        let what = if text.contains("<robot") { "XML, a robot of URDF" } else { "XML" };
        let help = "write each body as `[bodies.NAME]` with `mass = \"1 kg\"`; `bksim new NAME` writes a model to start from";
        return fault(what, at, help);
    }
    if line.trim_end() == "---" || line.starts_with("%YAML") {
        let help = "write `[bodies.crank]` for `crank:` below `bodies:`, and `mass = \"1 kg\"` for `mass: 1 kg`";
        return fault("YAML", start..start + line.trim_end().len(), help);
    }
    None
}

/// The fault of a file whose lines end with a carriage return alone.
pub(super) fn old_line_ends(text: &str) -> Option<Diagnostic> {
    let alone = |(at, _): &(usize, &str)| !text[at + 1..].starts_with('\n');
    let (at, _) = text.match_indices('\r').find(alone)?;
    let n = text.match_indices('\r').filter(alone).count();
    let message = match n {
        1 => "a line ends with a carriage return (U+000D) alone".to_owned(),
        n => format!("{n} lines end with a carriage return (U+000D) alone"),
    };
    Some(
        Diagnostic::error(codes::SYNTAX, message)
            .at(at..at, "the first of them ends here")
            .note("old programs of the Macintosh end lines so")
            .help("save the file with line ends LF, or CR LF"),
    )
}

/// The fault of a line that is nearly a table or a key with its value; `line` is its place.
pub(super) fn nearly(text: &str, line: &Span) -> Option<Diagnostic> {
    let whole = &text[line.clone()];
    let indent = whole.len() - whole.trim_start().len();
    let start = line.start + indent;
    if whole.trim_start().starts_with('[') {
        return header_with_blanks(whole.trim(), start);
    }
    let (bare_end, key) = match bare_parts(whole).next() {
        Some((0, part)) => (part.find(['=', ':']).unwrap_or(part.len()), part),
        _ => return None,
    };
    let name = key[..bare_end].trim();
    let rest = &whole[bare_end..];
    let sign = rest.chars().next()?;
    let value = rest[1..].trim();
    let at = start..start + name.len();
    let is_plain = |part: &str| {
        part.trim().chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
            && !part.trim().is_empty()
    };
    if sign == ':' && name.split('.').all(is_plain) {
        let fault = Diagnostic::error(codes::SYNTAX, format!("`:` after `{name}`, not `=`"));
        let colon = line.start + bare_end;
        let fault = fault.at(colon..colon + 1, "a key and its value are joined by `=`");
        return Some(match value {
            "" => fault.help(format!("write the line as `[{name}]`")),
            value => fault.help(format!("write the line as `{name} = {}`", quoted(value))),
        });
    }
    if sign != '=' || name.is_empty() || name.starts_with(['"', '\'']) || name.len() > 80 {
        return None;
    }
    let is_of_words = name.contains(char::is_whitespace) || !name.is_ascii();
    let letters =
        |c: char| c.is_alphanumeric() || c.is_whitespace() || matches!(c, '_' | '-' | '.');
    if !is_of_words || !name.chars().all(letters) {
        return None;
    }
    let written = path(name);
    Some(
        Diagnostic::error(codes::SYNTAX, format!("`{name}` cannot be a name"))
            .at(at, "names have the letters a–z and A–Z, digits and `_`, no blanks")
            .help(format!("write the line as `{written} = {value}`")),
    )
}

/// The fault of a line that one small change makes TOML: signs of other languages, a sign that is missing, brackets of
/// another kind.
pub(super) fn repaired(text: &str, line: &Span) -> Option<Diagnostic> {
    let whole = text[line.clone()].trim();
    let start = line.start + (text[line.clone()].len() - text[line.clone()].trim_start().len());
    if whole.len() > LONGEST {
        return None;
    }
    let is_toml = |written: &str| DeTable::parse(written).is_ok();
    let fault = |message: &str, at: usize, length: usize, label: &str, written: &str| {
        Diagnostic::error(codes::SYNTAX, message)
            .at(start + at..start + at + length, label)
            .help(format!("write the line as `{written}`"))
    };
    // The signs that are in no text and no comment.
    let bare = |signs: &[char]| {
        bare_parts(whole).find_map(|(from, part)| part.find(signs).map(|at| from + at))
    };
    if let Some(kept) = whole.strip_suffix(';').filter(|kept| is_toml(kept)) {
        return Some(fault(
            "a line ends with `;`",
            kept.len(),
            1,
            "lines need no sign at their end",
            kept,
        ));
    }
    // What is copied along with a text: signs of Markdown, numbers of lines.
    if whole.starts_with("```") {
        return Some(
            Diagnostic::error(codes::SYNTAX, "a line of Markdown")
                .at(start..start + whole.len(), "it is around the text, not part of it")
                .help("remove the line, and the one that closes it"),
        );
    }
    for mark in ["- ", "* "] {
        if let Some(kept) = whole.strip_prefix(mark).map(str::trim).filter(|kept| is_toml(kept)) {
            return Some(fault("a line begins with a mark of lists", 0, 1, "not needed", kept));
        }
    }
    if let Some((number, kept)) = whole.split_once(['|', ':'])
        && number.trim().parse::<u32>().is_ok()
        && is_toml(kept.trim())
    {
        let length = number.len() + 1;
        return Some(fault(
            "a line begins with its number",
            0,
            length,
            "not part of it",
            kept.trim(),
        ));
    }
    if let Some(inside) = whole.strip_prefix("\"\"\"").and_then(|rest| rest.strip_suffix("\"\"\""))
    {
        let written = format!("# {inside}");
        return Some(fault("a text that is no value", 0, 3, "comments follow `#`", &written));
    }
    if let Some(at) = bare(&[':']) {
        let written = changed_outside_texts(whole, |part| part.replace(':', " ="));
        if whole[..at].contains('=') && is_toml(&written) {
            return Some(fault(
                "`:` after a key, not `=`",
                at,
                1,
                "a key and its value are joined by `=`",
                &written,
            ));
        }
    }
    if let Some(at) = bare(&['/']).filter(|at| whole[*at..].starts_with("//")) {
        let written = format!("{}# {}", &whole[..at], whole[at..].trim_start_matches(['/', ' ']));
        if is_toml(&written) {
            return Some(fault("a comment after `//`", at, 2, "comments follow `#`", &written));
        }
    }
    if whole.ends_with(']') && !whole.contains(['[', '=', '"']) {
        let written = format!("[{whole}");
        if is_toml(&written) {
            return Some(fault(
                "`]` of the table was not opened",
                0,
                1,
                "no `[` before this",
                &written,
            ));
        }
    }
    if let Some(at) =
        whole.find(['"', '[', '{']).filter(|at| *at > 0 && !whole[..*at].contains('='))
    {
        let key = whole[..at].trim();
        let written = format!("{key} = {}", &whole[at..]);
        if !key.contains(char::is_whitespace) && is_toml(&written) {
            return Some(fault("`=` is missing after a key", 0, key.len(), "this key", &written));
        }
    }
    if let Some(at) = bare(&['(', ')']) {
        let plain = |part: &str| part.replace('(', "[").replace(')', "]");
        let written = changed_outside_texts(whole, plain);
        if is_toml(&written) {
            return Some(fault("a round bracket", at, 1, "lists have square brackets", &written));
        }
    }
    let [open, close] = [whole.find("= [")? + 2, whole.rfind(']')?];
    let inside = whole.get(open + 1..close)?;
    let written = format!("{}{{{inside}}}{}", &whole[..open], &whole[close + 1..]);
    (inside.contains('=') && is_toml(&written)).then(|| {
        fault("keys and values in square brackets", open, 1, "tables have braces", &written)
    })
}

/// Longer lines are not tried in other forms.
const LONGEST: usize = 400;

/// A line with the parts that are no texts and no comments changed.
fn changed_outside_texts(line: &str, change: impl Fn(&str) -> String) -> String {
    let mut written = String::new();
    let mut end = 0;
    for (start, part) in bare_parts(line) {
        written.push_str(&line[end..start]);
        written.push_str(&change(part));
        end = start + part.len();
    }
    written + &line[end..]
}

/// A header whose names have blanks or letters of other alphabets: `[bodies.left arm]`.
fn header_with_blanks(header: &str, start: usize) -> Option<Diagnostic> {
    let n_open = if header.starts_with("[[") { 2 } else { 1 };
    let end = header.find(']')?;
    let inside = header.get(n_open..end)?;
    let is_good = |part: &str| {
        let part = part.trim();
        let is_plain = part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        is_plain && !part.is_empty()
    };
    if inside.contains(['"', '\'', '=', '[', '{', '#', ',']) || inside.split('.').all(is_good) {
        return None;
    }
    // The part at fault.
    let mut at = n_open;
    let part = inside.split('.').find(|part| {
        let is_it = !is_good(part);
        if !is_it {
            at += part.len() + 1;
        }
        is_it
    })?;
    let name = part.trim();
    if name.is_empty() {
        return None;
    }
    let at = start + at + (part.len() - part.trim_start().len());
    let (open, close) = ("[".repeat(n_open), "]".repeat(n_open));
    Some(
        Diagnostic::error(codes::SYNTAX, format!("`{name}` cannot be a name"))
            .at(
                at..at + name.len(),
                "names have the letters a–z and A–Z, digits and `_`, no blanks",
            )
            .help(format!("write the line as `{open}{}{close}`", path(inside))),
    )
}

/// Names divided by dots, each in the letters that names have.
fn path(names: &str) -> String {
    let parts = names.split('.').map(|part| spelled(part, 'b'));
    parts.collect::<Vec<_>>().join(".")
}

/// A value as TOML has it: numbers, lists and quoted texts as they are, all else in quotes.
fn quoted(value: &str) -> String {
    let is_value = value.parse::<f64>().is_ok()
        || value.starts_with(['"', '\'', '[', '{'])
        || matches!(value, "true" | "false");
    if is_value { value.to_owned() } else { format!("\"{value}\"") }
}

/// The first bracket in a line that another kind of bracket closes: its place, and that of the other.
pub(super) fn crossed_brackets(text: &str, line: &Span) -> Option<[usize; 2]> {
    let mut open: Vec<usize> = Vec::new();
    let mut rest = &text[line.clone()];
    while let Some(found) = rest.find(['[', ']', '{', '}', '"', '\'', '#']) {
        let at = line.end - rest.len() + found;
        match text.as_bytes()[at] {
            b'[' | b'{' => open.push(at),
            close @ (b']' | b'}') => {
                let opening = open.pop()?;
                if (text.as_bytes()[opening] == b'[') != (close == b']') {
                    return Some([opening, at]);
                }
            }
            _ => (),
        }
        let tail = &rest[found..];
        rest = &tail[token_length(tail).clamp(1, tail.len())..];
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_show_in_the_first_bytes() {
        let wide: Vec<u8> = "mass = 1".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(encoding_of(&wide), Some("UTF-16"), "without a mark");
        assert_eq!(encoding_of(&[&[0xFF, 0xFE], wide.as_slice()].concat()), Some("UTF-16"));
        assert_eq!(encoding_of(b"mass = 1"), None);
        assert_eq!(encoding_of(b""), None);
    }
}
