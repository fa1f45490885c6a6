//! The tables of a part, put into those of the model that uses it.

use std::collections::BTreeMap;

use super::super::codes;
use super::super::tree::{Entry, Node, Table, Value};
use super::Expander;
use super::rename::{Host, Renaming};
use crate::diagnostic::{Diagnostic, Span};

impl Expander<'_> {
    /// Gives parameters and signals of a part the values that the model says.
    pub(super) fn set_values(
        &mut self,
        part: &mut Table,
        name: &str,
        with: &Table,
        renaming: &Renaming,
    ) {
        for Entry { key, key_span, node } in &with.entries {
            let own = renaming.own_name(key);
            let parameter = section_of(part, "parameters").and_then(|known| known.get_mut(&own));
            if let Some(parameter) = parameter {
                parameter.node = node.clone();
                continue;
            }
            let signal = section_of(part, "signals").and_then(|signals| section_of(signals, &own));
            if let Some(value) = signal.and_then(|signal| signal.get_mut("value")) {
                value.node = node.clone();
                continue;
            }
            if renaming.is_given(key) {
                continue;
            }
            let sections = ["parameters", "signals", "bodies", "joints"];
            let tables = sections.iter().filter_map(|section| part.get(section)?.node.table());
            let own = tables.flat_map(|table| &table.entries);
            let known: Vec<&str> = own.filter_map(|entry| renaming.old_name(&entry.key)).collect();
            let message = format!("the part of use `{name}` has no `{key}`");
            let label = (key_span.clone(), "no parameter, signal, body or joint has this name");
            self.unknown(codes::UNKNOWN_NAME, message, label, (key, &known));
        }
    }

    /// Adds the sections of a part to those of the model.
    pub(super) fn merge(&mut self, root: &mut Table, part: Table, name: &str, span: &Span) {
        for section in part.entries {
            let Value::Table(table) = section.node.value else { continue };
            let into = section_or_new(root, &section.key, &section.key_span);
            for entry in table.entries {
                if let Some(known) = into.get(&entry.key) {
                    let message = format!("`{}` of use `{name}` is there already", entry.key);
                    let fault = Diagnostic::error(codes::DUPLICATE, message)
                        .at(known.key_span.clone(), "has this name")
                        .at(span.clone(), "its names begin with this one")
                        .help(format!("rename the use, for example to `{name}_1`"));
                    self.report(fault);
                    continue;
                }
                into.entries.push(entry);
            }
        }
    }
}

/// Takes bodies and joints out of a part in whose place the model has its own: the names there by those in
/// the part.
pub(super) fn given_in_place(part: &mut Table, with: &Table) -> BTreeMap<String, String> {
    let mut given = BTreeMap::new();
    for Entry { key, node, .. } in &with.entries {
        let is_there = ["bodies", "joints"]
            .into_iter()
            .any(|section| section_of(part, section).is_some_and(|table| table.get(key).is_some()));
        let Value::Text(own) = &node.value else { continue };
        if is_there {
            given.insert(key.clone(), own.clone());
            for section in ["bodies", "joints", "initial"] {
                if let Some(table) = section_of(part, section) {
                    table.entries.retain(|entry| entry.key != *key);
                }
            }
        }
    }
    given
}

/// Makes the points of a part's ground points of the body that its ground is.
pub(super) fn put_ground_points(
    root: &mut Table,
    part: &mut Table,
    renaming: &Renaming,
    host: &Host,
) {
    let Some(place) = part.entries.iter().position(|section| section.key == "ground") else {
        return;
    };
    let ground = part.entries.remove(place);
    let Value::Table(ground) = ground.node.value else { return };
    let Some(points) = ground.entries.into_iter().find(|entry| entry.key == "points") else {
        return;
    };
    let (key_span, span) = (points.key_span, points.node.span);
    let Value::Table(points) = points.node.value else { return };
    let host_table = match host.body.as_str() {
        "ground" => Some(section_or_new(root, "ground", &key_span)),
        body => section_of(root, "bodies").and_then(|bodies| section_of(bodies, body)),
    };
    // A body that is no table is told as such where it stands.
    let Some(host_table) = host_table else { return };
    let place = section_or_new(host_table, "points", &key_span);
    for Entry { key, key_span, node } in points.entries {
        let node = match &host.point {
            None => node,
            Some(point) => from_point(node, point, &span),
        };
        place.entries.push(Entry { key: renaming.own_name(&key), key_span, node });
    }
}

/// A point of a frame at a point of the body: `{ at = [..], from = "mount" }`.
fn from_point(node: Node, point: &str, span: &Span) -> Node {
    let mut frame = match node.value {
        Value::Table(frame) => frame,
        value => {
            let at = Node { span: node.span.clone(), value };
            let entry = Entry { key: "at".to_owned(), key_span: node.span.clone(), node: at };
            Table { entries: vec![entry] }
        }
    };
    let from = Node { span: span.clone(), value: Value::Text(point.to_owned()) };
    if frame.get("from").is_none() {
        frame.entries.push(Entry { key: "from".to_owned(), key_span: span.clone(), node: from });
    }
    Node { span: node.span, value: Value::Table(frame) }
}

/// The table of a section.
pub(super) fn section_of<'t>(root: &'t mut Table, key: &str) -> Option<&'t mut Table> {
    let entry = root.entries.iter_mut().find(|entry| entry.key == key)?;
    match &mut entry.node.value {
        Value::Table(table) => Some(table),
        _ => None,
    }
}

/// The table of a section, an empty one where there is none.
fn section_or_new<'t>(root: &'t mut Table, key: &str, span: &Span) -> &'t mut Table {
    let is_table = |entry: &Entry| entry.key == key && entry.node.table().is_some();
    let place = root.entries.iter().position(is_table).unwrap_or_else(|| {
        root.entries.retain(|entry| entry.key != key);
        let node = Node { span: span.clone(), value: Value::Table(Table::default()) };
        root.entries.push(Entry { key: key.to_owned(), key_span: span.clone(), node });
        root.entries.len() - 1
    });
    match &mut root.entries[place].node.value {
        Value::Table(table) => table,
        _ => unreachable!("it was made one"),
    }
}
