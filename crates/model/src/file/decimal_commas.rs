//! Commas that divide entries or arguments where they look like those of decimals: `[0,5, 0]` is a list of three.
//!
//! A comma right between two digits is doubtful only next to commas that a space follows: who writes lists
//! without spaces, `[1,0,0]`, or with one after each comma, means lists.

use bksim_expr::{COMPOSED, Function, Syntax, SyntaxKind};

use super::codes;
use super::reader::Reader;
use super::tree::{Node, Quoted, Value};
use crate::diagnostic::{Diagnostic, Span};

/// The text of what stands in parentheses or brackets, with points for the commas right between digits, and
/// their number; `None` where there are no such commas, or no others, all of which a space follows.
fn mixed(text: &str, entries: &[Span]) -> Option<(String, usize)> {
    let bytes = text.as_bytes();
    let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
    let whole = entries.first()?.start..entries.last()?.end;
    let mut written = text.get(whole.clone())?.to_owned();
    let mut n_tight = 0;
    // The last number has its point already.
    let mut has_point = false;
    for pair in entries.windows(2) {
        let between = pair[0].end..pair[1].start;
        let gap = text.get(between.clone())?;
        if gap == "," && is_digit(between.start.checked_sub(1)?) && is_digit(between.end) {
            let number = text[..between.start].trim_end_matches(|c: char| c.is_ascii_digit());
            if has_point || number.ends_with(['.', 'e', 'E']) {
                return None;
            }
            let at = between.start - whole.start;
            written.replace_range(at..=at, ".");
            n_tight += 1;
            has_point = true;
        } else {
            let after = gap.trim_start().strip_prefix(',')?;
            if !after.starts_with(char::is_whitespace) {
                return None;
            }
            has_point = false;
        }
    }
    (1..entries.len() - 1).contains(&n_tight).then_some((written, n_tight))
}

impl Reader<'_> {
    /// Warns of a vector that has one entry more than it shows at first sight.
    pub(super) fn check_commas_of_vector(&mut self, node: &Node, entries: &[Node], what: &str) {
        let spans: Vec<Span> = entries.iter().map(|entry| entry.span.clone()).collect();
        let Some((written, n_tight)) = mixed(self.text, &spans) else { return };
        let are_numbers =
            entries.iter().all(|e| matches!(e.value, Value::Number { .. } | Value::Text(_)));
        if are_numbers && (2..=3).contains(&(entries.len() - n_tight)) {
            let message = format!("{what} is a list of {} entries", entries.len());
            self.doubt(message, node.span.clone(), &format!("[{written}]"), "entries");
        }
    }

    /// Warns of calls that have one argument more than they show at first sight.
    pub(super) fn check_commas_of_calls(&mut self, syntax: &Syntax, quoted: &Quoted<'_>) {
        for node in &syntax.nodes {
            let SyntaxKind::Call { name, arguments, .. } = &node.kind else { continue };
            let composed = COMPOSED.iter().find(|composed| composed.name == *name);
            let fixed = match (Function::from_name(name), composed) {
                (_, Some(composed)) if composed.takes[0] == composed.takes[1] => composed.takes[0],
                (Some(function), None) => function.arity(),
                _ => 0,
            };
            // As many as the function takes, so no comma can be a point.
            if arguments.len() == fixed {
                continue;
            }
            let spans: Vec<Span> =
                arguments.iter().map(|&at| syntax.nodes[at].span.clone()).collect();
            let Some((written, _)) = mixed(quoted.text, &spans) else { continue };
            let message = format!("`{name}` has {} arguments", arguments.len());
            let location = quoted.span_of(&node.span);
            self.doubt(message, location, &format!("{name}({written})"), "arguments");
        }
    }

    fn doubt(&mut self, message: String, location: Span, written: &str, entries: &str) {
        // A text may be read more than once.
        if self.faults.iter().any(|fault| {
            fault.code == codes::DECIMAL_COMMA
                && fault.message == message
                && fault.labels.iter().any(|label| label.span == location)
        }) {
            return;
        }
        self.report(
            Diagnostic::warning(codes::DECIMAL_COMMA, message)
                .at(location, "a comma between digits divides, too")
                .help(format!(
                    "write `{written}` if it is a decimal comma, or a space after every comma between {entries}"
                )),
        );
    }
}
