//! Text from outside on its way to a terminal: names, units and paths may hold characters that no reader
//! sees, but that terminals obey.

use std::borrow::Cow;

/// Styles in a text.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Styles {
    /// Colours and weights of our own stay.
    Kept,
    /// There are none: every escape is from outside.
    None,
}

/// The text with every character that a terminal obeys written as Rust does, such as `\u{1b}`; line ends and
/// tabs stay.
pub(crate) fn visible(text: &str, styles: Styles) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let style = if styles == Styles::Kept { style_length(rest) } else { 0 };
        let (part, next) = rest.split_at(style.max(c.len_utf8()));
        if style == 0 && is_obeyed(c) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push_str(part);
        }
        rest = next;
    }
    Cow::Owned(shown)
}

/// The text of one JSON object with such characters as JSON writes them; they only stand in its strings.
pub(crate) fn visible_json(text: &str) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| match c {
        c if is_obeyed(c) => format!("\\u{:04x}", u32::from(c)),
        c => c.to_string(),
    };
    Cow::Owned(text.chars().map(shown).collect())
}

/// Bytes of the style (SGR) that a text begins with: `ESC [ 1 ; 31 m`.
fn style_length(text: &str) -> usize {
    let Some(rest) = text.strip_prefix("\u{1b}[") else { return 0 };
    let end = rest.find(|c: char| !(c.is_ascii_digit() || c == ';'));
    end.filter(|&end| rest[end..].starts_with('m')).map_or(0, |end| end + 3)
}

/// Control characters, and those that turn the direction of writing (UAX #9).
fn is_obeyed(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || c.is_control() && c != '\n' && c != '\t'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_obeyed_but_styles_of_our_own() {
        let text = "\u{1b}[1;31mred\u{1b}[0m \u{1b}]0;title\u{7} \u{1b}[2J a\u{202e}b\u{9b}c\td\n";
        let shown = visible(text, Styles::Kept);
        let expected =
            "\u{1b}[1;31mred\u{1b}[0m \\u{1b}]0;title\\u{7} \\u{1b}[2J a\\u{202e}b\\u{9b}c\td\n";
        assert_eq!(shown, expected);
        assert!(!visible(text, Styles::None).contains(is_obeyed));
        assert_eq!(visible("ω = 2°", Styles::None), "ω = 2°");
        let json = serde_json::to_string("a\u{202e}\u{7f}").expect("a text");
        let back: String = serde_json::from_str(&visible_json(&json)).expect("a text");
        assert_eq!((back.as_str(), visible_json(&json).is_ascii()), ("a\u{202e}\u{7f}", true));
    }
}
