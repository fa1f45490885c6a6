//! The text of a model as HTML, its comments, headings, strings and numbers marked.

use crate::escape;

/// Largest number of bytes of text that are shown.
const MAX_BYTES: usize = 200_000;

/// The text as HTML for a `pre`, and whether it is complete.
pub(crate) fn html(text: &str) -> (String, bool) {
    let mut end = text.len().min(MAX_BYTES);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let lines: Vec<String> = text[..end].lines().map(line).collect();
    (lines.join("\n"), end == text.len())
}

/// A line with its tokens marked.
fn line(line: &str) -> String {
    if line.trim_start().starts_with('[') && !line.contains('=') {
        let (heading, comment) = split_comment(line);
        return marked("heading", heading) + &marked("comment", comment);
    }
    let mut written = String::new();
    let mut rest = line;
    while let Some(c) = rest.chars().next() {
        let (class, length) = match c {
            '#' => ("comment", rest.len()),
            '"' | '\'' => ("string", string_length(rest, c)),
            c if c.is_ascii_digit() => ("number", number_length(rest)),
            c if is_name(c) => ("", rest.find(|c| !is_name(c)).unwrap_or(rest.len())),
            c => ("", c.len_utf8()),
        };
        let (token, after) = rest.split_at(length);
        written.push_str(&marked(class, token));
        rest = after;
    }
    written
}

/// The part of a line before its comment, and the comment.
fn split_comment(line: &str) -> (&str, &str) {
    line.split_at(line.find('#').unwrap_or(line.len()))
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '-' | '.')
}

fn number_length(text: &str) -> usize {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E' | '_');
    text.find(|c| !is_number(c)).unwrap_or(text.len())
}

/// Length of a string with its quotes; up to the end of the line if it is open.
fn string_length(text: &str, quote: char) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        if c == quote && !is_escaped {
            return at + c.len_utf8();
        }
        is_escaped = c == '\\' && !is_escaped && quote == '"';
    }
    text.len()
}

fn marked(class: &str, token: &str) -> String {
    match (class, escape::html(token)) {
        (_, token) if token.is_empty() => token,
        ("", token) => token,
        (class, token) => format!("<span class=\"{class}\">{token}</span>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text that a browser shows.
    fn shown(html: &str) -> String {
        let mut text = String::new();
        let mut is_tag = false;
        for c in html.chars() {
            match c {
                '<' => is_tag = true,
                '>' => is_tag = false,
                c if !is_tag => text.push(c),
                _ => (),
            }
        }
        let named =
            [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")];
        named.iter().fold(text, |text, (name, c)| text.replace(name, c))
    }

    #[test]
    fn the_text_stays_and_is_marked() {
        let text =
            "[bodies.b] # it's <b>\nmass = \"2 kg\"\ncom = [0, '-0.5 m', 3e4]\nz = \"a\\\"b\"";
        let (html, is_whole) = html(text);
        assert!(is_whole);
        assert_eq!(shown(&html), text);
        assert!(html.contains("<span class=\"heading\">[bodies.b] </span>"), "{html}");
        assert!(html.contains("<span class=\"comment\"># it&#39;s &lt;b&gt;</span>"), "{html}");
        assert!(html.contains("<span class=\"number\">3e4</span>"), "{html}");
        assert!(html.contains("<span class=\"string\">&quot;a\\&quot;b&quot;</span>"), "{html}");
    }

    #[test]
    fn hostile_text_is_only_text() {
        for text in ["</pre><script>alert(1)</script>", "\"</script>", "'<img onerror=x>", "é\"ü"]
        {
            let (html, _) = html(text);
            assert_eq!(shown(&html), text);
            let spans = html.replace("</span>", "");
            let tags = spans.matches('<').count();
            assert_eq!(tags, spans.matches("<span class=\"").count(), "{html}");
        }
    }
}
