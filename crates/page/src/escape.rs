//! Text that stays text within HTML, and JSON that stays within its script element.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Text as content or attribute of an element.
pub(crate) fn html(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            // HTML does not allow other control characters.
            c if c.is_control() && !matches!(c, '\n' | '\t') => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// JSON in which no `<` is left, so that nothing in it ends its element or opens a comment.
pub(crate) fn json(json: &str) -> String {
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// Little-endian doubles in base64.
pub(crate) fn doubles(values: impl IntoIterator<Item = f64>) -> String {
    STANDARD.encode(values.into_iter().flat_map(f64::to_le_bytes).collect::<Vec<_>>())
}

/// Little-endian singles in base64.
#[expect(clippy::cast_possible_truncation, reason = "seven digits are enough for a curve")]
pub(crate) fn singles(values: impl IntoIterator<Item = f64>) -> String {
    let bytes = values.into_iter().flat_map(|value| (value as f32).to_le_bytes());
    STANDARD.encode(bytes.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_ends_its_element() {
        let hostile = "</script><script>alert('x')</script><!-- \"&\u{1}";
        let written = html(hostile);
        assert!(!written.contains(['<', '>', '"', '\'', '\u{1}']), "{written}");
        let embedded = json(&serde_json::to_string(hostile).expect("a string"));
        assert!(!embedded.contains('<'), "{embedded}");
        let back: String = serde_json::from_str(&embedded).expect("valid JSON");
        assert_eq!(back, hostile);
    }

    #[test]
    fn numbers_are_little_endian() {
        assert_eq!(doubles([1.0]), "AAAAAAAA8D8=");
        assert_eq!(singles([1.0, -2.0]), "AACAPwAAAMA=");
    }
}
