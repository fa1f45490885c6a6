//! The tokens of TOML, as far as faults need them: texts and comments hide what stands in them.

/// Length of the text, comment or single character that `tail` starts with.
pub(super) fn token_length(tail: &str) -> usize {
    let to = |pattern: &str, from: usize| tail[from..].find(pattern).map(|at| from + at);
    let line = || to("\n", 0).unwrap_or(tail.len());
    if tail.starts_with("\"\"\"") || tail.starts_with("'''") {
        return to(&tail[..3], 3).map_or(tail.len(), |end| end + 3);
    }
    match tail.as_bytes()[0] {
        b'#' => line().max(1),
        b'\'' => to("'", 1).filter(|&end| end < line()).map_or_else(line, |end| end + 1),
        b'"' => {
            let mut escaped = false;
            for (at, c) in tail.char_indices().skip(1) {
                match c {
                    '\n' => return at,
                    '"' if !escaped => return at + 1,
                    _ => escaped = c == '\\' && !escaped,
                }
            }
            tail.len()
        }
        _ => 1,
    }
}
