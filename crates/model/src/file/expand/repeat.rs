//! Elements that repeat: `count = 3` makes `link1`, `link2` and `link3` of `link`, and `{i}` in their texts is
//! the number of each.

use super::super::codes;
use super::super::tree::{Entry, Node, Table, Value};
use super::Expander;
use crate::diagnostic::{Diagnostic, Span};

/// The largest number that an element gets.
const LARGEST: usize = 1_000_000;

impl Expander<'_> {
    /// Replaces every element with a count by as many.
    pub(super) fn repeat(&mut self, root: &mut Table) {
        for section in &mut root.entries {
            let Value::Table(table) = &mut section.node.value else { continue };
            let has_count = |entry: &Entry| match &entry.node.value {
                Value::Table(keys) => keys.get("count").is_some(),
                _ => false,
            };
            if !table.entries.iter().any(has_count) {
                continue;
            }
            for entry in std::mem::take(&mut table.entries) {
                if has_count(&entry) {
                    let repeated = self.repeated(entry);
                    table.entries.extend(repeated);
                } else {
                    table.entries.push(entry);
                }
            }
        }
    }

    /// The elements that an entry with a count stands for; none where the count is none.
    fn repeated(&mut self, mut entry: Entry) -> Vec<Entry> {
        let Value::Table(keys) = &mut entry.node.value else { return Vec::new() };
        let number =
            |key: &str| keys.get(key).map(|entry| (&entry.node.value, entry.node.span.clone()));
        let whole = |value: &Value| match value {
            Value::Number { value, digits } if !value.is_sign_negative() => {
                digits.parse().ok().filter(|number| *number <= LARGEST)
            }
            _ => None,
        };
        let (count, span) = number("count").expect("an entry with a count");
        let first = number("first").map_or(Some(1), |(value, _)| whole(value));
        let (Some(count @ 1..), Some(first)) = (whole(count), first) else {
            let (message, span) = match first {
                None => {
                    ("`first` is no whole number", number("first").map_or(span, |(_, span)| span))
                }
                Some(_) => ("`count` is no whole number above 0", span),
            };
            self.report(
                Diagnostic::error(codes::BAD_COUNT, format!("{message} in `{}`", entry.key))
                    .at(span, "a number without unit, such as 3")
                    .help("write for example `count = 3`; `first = 0` begins at another number than 1"),
            );
            return Vec::new();
        };
        keys.entries.retain(|entry| entry.key != "count" && entry.key != "first");
        if !self.pays_for(count.saturating_mul(entry.node.weight()), &entry.key, span) {
            return Vec::new();
        }
        (first..first + count).map(|i| self.numbered(&entry, i)).collect()
    }

    /// Takes so many nodes off those that may still be made; false, and reported once, where they are too few.
    pub(super) fn pays_for(&mut self, n_nodes: usize, name: &str, span: Span) -> bool {
        if let Some(left) = self.left.checked_sub(n_nodes) {
            self.left = left;
            return true;
        }
        if std::mem::replace(&mut self.is_full, true) {
            return false;
        }
        self.report(
            Diagnostic::error(codes::BAD_COUNT, format!("`{name}` makes the model too large"))
                .at(span, "more than there is room for")
                .help("use fewer elements: all together may have a million values"),
        );
        false
    }

    /// The element of this number.
    fn numbered(&mut self, entry: &Entry, i: usize) -> Entry {
        let mut node = entry.node.clone();
        self.number_node(&mut node, i);
        let key = match self.number_text(&entry.key, &entry.key_span, i) {
            key if key == entry.key => format!("{key}{i}"),
            key => key,
        };
        Entry { key, key_span: entry.key_span.clone(), node }
    }

    fn number_node(&mut self, node: &mut Node, i: usize) {
        match &mut node.value {
            Value::Text(text) => {
                let numbered = self.number_text(text, &node.span, i);
                *text = numbered;
            }
            Value::Array(nodes) => nodes.iter_mut().for_each(|node| self.number_node(node, i)),
            Value::Table(table) => {
                for Entry { key, key_span, node } in &mut table.entries {
                    *key = self.number_text(key, key_span, i);
                    self.number_node(node, i);
                }
            }
            Value::Number { .. } | Value::Bool(_) | Value::Date => (),
        }
    }

    /// The text with the numbers in place of `{i}`, `{i+1}`, `{i-1}`.
    fn number_text(&mut self, text: &str, span: &Span, i: usize) -> String {
        let mut numbered = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            numbered.push_str(before);
            let Some((inside, after)) = after.split_once('}') else {
                self.not_a_number("{", span);
                return text.to_owned();
            };
            let Some(number) = number_of(inside, i) else {
                self.not_a_number(&format!("{{{inside}}}"), span);
                return text.to_owned();
            };
            numbered.push_str(&number.to_string());
            rest = after;
        }
        numbered.push_str(rest);
        numbered
    }

    fn not_a_number(&mut self, written: &str, span: &Span) {
        let fault = Diagnostic::error(
            codes::BAD_COUNT,
            format!("`{written}` is no number of an element"),
        )
        .at(span.clone(), "repeats")
        .help("write `{i}` for the number of the element, `{i+1}` and `{i-1}` for those beside it");
        // Each copy would say the same.
        if self.faults.last() != Some(&fault) {
            self.report(fault);
        }
    }
}

/// The value of `i`, `i+2` or `i - 1`; `None` for anything else, and below zero.
fn number_of(inside: &str, i: usize) -> Option<usize> {
    let offset = inside.trim().strip_prefix('i')?.trim_start();
    let by = |digits: &str| digits.trim().parse::<usize>().ok();
    match offset.split_at_checked(1) {
        None => Some(i),
        Some(("+", digits)) => i.checked_add(by(digits)?),
        Some(("-", digits)) => i.checked_sub(by(digits)?),
        Some(_) => None,
    }
}
