//! A text as words, and what is filled into them: names between backticks and numbers.

/// A part of a text.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Piece {
    /// Words.
    Words(String),
    /// Something filled in, by the sign that stands for it: `*` for names, `#` for numbers.
    Value(char, String),
}

/// The parts of a text.
pub(crate) fn pieces(text: &str) -> Vec<Piece> {
    let (mut pieces, mut words) = (Vec::new(), String::new());
    let mut rest = text;
    let mut before = None;
    while let Some(c) = rest.chars().next() {
        let is_first = !before.is_some_and(|c: char| c.is_alphanumeric() || matches!(c, '_' | '.'));
        let length = match c {
            '`' => rest[1..].find('`').map_or(0, |at| at + 2),
            _ if is_first => length_of_number(rest),
            _ => 0,
        };
        if length > 0 {
            if !words.is_empty() {
                pieces.push(Piece::Words(std::mem::take(&mut words)));
            }
            let sign = if c == '`' { '*' } else { '#' };
            pieces.push(Piece::Value(sign, rest[..length].to_owned()));
            before = Some(sign);
            rest = &rest[length..];
        } else {
            words.push(c);
            before = Some(c);
            rest = &rest[c.len_utf8()..];
        }
    }
    if !words.is_empty() {
        pieces.push(Piece::Words(words));
    }
    pieces
}

/// The words with the signs of what is filled in, and this.
pub(crate) fn key_of(pieces: &[Piece]) -> (String, Vec<&str>) {
    let (mut key, mut values) = (String::new(), Vec::new());
    for piece in pieces {
        match piece {
            Piece::Words(words) => key.push_str(words),
            Piece::Value(sign, value) => {
                key.push(*sign);
                values.push(value.as_str());
            }
        }
    }
    (key, values)
}

/// Words with values in the places of `#` and `*`; in the places of `{1}`, `{2}` and so on where the words have these.
pub(crate) fn filled(words: &str, values: &[&str]) -> String {
    if words.contains("{1}") {
        let put = |text: String, (at, value): (usize, &&str)| {
            text.replace(&format!("{{{}}}", at + 1), value)
        };
        return values.iter().enumerate().fold(words.to_owned(), put);
    }
    let mut values = values.iter();
    let put = |c: char| match c {
        '#' | '*' => values.next().map_or_else(|| c.to_string(), |value| (*value).to_owned()),
        _ => c.to_string(),
    };
    words.chars().map(put).collect()
}

/// Bytes of the number that a text begins with: `12`, `-2.5e-16`, `−3`.
fn length_of_number(text: &str) -> usize {
    let after_sign = text.strip_prefix(['-', '−', '+']).unwrap_or(text);
    let digits =
        |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let mut rest = &after_sign[digits(after_sign)..];
    if rest.len() == after_sign.len() {
        return 0;
    }
    if let Some(after) = rest.strip_prefix('.').filter(|after| digits(after) > 0) {
        rest = &after[digits(after)..];
    }
    if let Some(after) = rest.strip_prefix('e') {
        let after = after.strip_prefix(['-', '+']).unwrap_or(after);
        if digits(after) > 0 {
            rest = &after[digits(after)..];
        }
    }
    text.len() - rest.len()
}
