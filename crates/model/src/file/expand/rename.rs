//! The names of a part, made names of the model that uses it: `rotor` of the part used as `motor` becomes
//! `motor_rotor`, wherever the part speaks of it.

use std::collections::{BTreeMap, BTreeSet};

use bksim_expr::SyntaxKind;

use super::super::quantity::syntax_of;
use super::super::tree::{Entry, Node, Table, Value};

/// Sections whose keys are not names.
const PLAIN_SECTIONS: [&str; 2] = ["ground", "units"];

/// Keys whose texts are not of names.
const PLAIN_KEYS: [&str; 8] =
    ["type", "file", "units", "interpolation", "extrapolate", "kind", "sense", "side"];

/// The body of the model that is the ground of a part, and its point where one is named.
pub(super) struct Host {
    pub(super) body: String,
    pub(super) point: Option<String>,
}

/// The new names of one part.
pub(super) struct Renaming {
    prefix: String,
    /// The part's own names.
    names: BTreeSet<String>,
    /// Names of bodies and joints for which those of the model stand.
    given: BTreeMap<String, String>,
    /// The body that the part's ground is, and its point where it is one.
    host: String,
    host_point: Option<String>,
    nesting: usize,
}

impl Renaming {
    /// The names of a part that is used under a name, in which those that are `given` stand for others.
    pub(super) fn new(
        part: &Table,
        name: &str,
        Host { body, point }: &Host,
        given: BTreeMap<String, String>,
        nesting: usize,
    ) -> Self {
        let mut names = BTreeSet::new();
        let sections = part.entries.iter().filter(|section| {
            let key = section.key.as_str();
            !PLAIN_SECTIONS.contains(&key) && key != "initial"
        });
        for section in sections {
            let Value::Table(table) = &section.node.value else { continue };
            for entry in &table.entries {
                names.insert(entry.key.clone());
                let Value::Table(keys) = &entry.node.value else { continue };
                for key in ["coordinate", "coordinates"] {
                    let Some(given) = keys.get(key) else { continue };
                    for name in texts(&given.node) {
                        names.extend([name.to_owned(), format!("{name}_dot")]);
                    }
                }
            }
        }
        Self {
            prefix: format!("{name}_"),
            names,
            given,
            host: body.clone(),
            host_point: point.clone(),
            nesting,
        }
    }

    /// The name that a name of the part, or of a point of its ground, becomes.
    pub(super) fn own_name(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// The name in the part of what has a new one.
    pub(super) fn old_name<'n>(&self, name: &'n str) -> Option<&'n str> {
        name.strip_prefix(&self.prefix)
    }

    /// True of a body or joint in whose place the model has its own.
    pub(super) fn is_given(&self, name: &str) -> bool {
        self.given.contains_key(name)
    }

    /// Gives everything in a part its new name.
    pub(super) fn rename(&self, part: &mut Table) {
        for section in &mut part.entries {
            let Value::Table(table) = &mut section.node.value else { continue };
            let has_names = !PLAIN_SECTIONS.contains(&section.key.as_str());
            for entry in &mut table.entries {
                if has_names {
                    entry.key.insert_str(0, &self.prefix);
                }
                self.rename_value(&mut entry.node);
            }
        }
    }

    fn rename_value(&self, node: &mut Node) {
        match &mut node.value {
            Value::Text(text) => {
                if let Some(renamed) = self.renamed(text) {
                    *text = renamed;
                }
            }
            Value::Array(nodes) => nodes.iter_mut().for_each(|node| self.rename_value(node)),
            Value::Table(table) => {
                for Entry { key, node, .. } in &mut table.entries {
                    if !PLAIN_KEYS.contains(&key.as_str()) {
                        self.rename_value(node);
                    }
                }
            }
            Value::Number { .. } | Value::Bool(_) | Value::Date => (),
        }
    }

    /// The new form of a name, with or without a point or measure after it; `None` where it stays.
    fn name(&self, name: &str) -> Option<String> {
        match name.split_once('.') {
            Some(("ground", point)) => Some(format!("{}.{}", self.host, self.own_name(point))),
            None if name == "ground" => Some(match &self.host_point {
                Some(point) => format!("{}.{point}", self.host),
                None => self.host.clone(),
            }),
            parts => {
                let head = parts.map_or(name, |(head, _)| head);
                if let Some(given) = self.given.get(head) {
                    return Some(format!("{given}{}", &name[head.len()..]));
                }
                self.names.contains(head).then(|| format!("{}{name}", self.prefix))
            }
        }
    }

    /// The text with the names in it renamed: a name alone, or an expression.
    fn renamed(&self, text: &str) -> Option<String> {
        let is_name = text.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '.'));
        if is_name && let Some(renamed) = self.name(text) {
            return Some(renamed);
        }
        // What cannot be read is explained where it stands.
        let syntax = syntax_of(text, self.nesting, &|name| self.names.contains(name)).ok()?;
        let names = syntax.nodes.iter().filter_map(|node| match &node.kind {
            SyntaxKind::Name(name) => Some((node.span.clone(), name)),
            SyntaxKind::Call { name, name_span, .. } => Some((name_span.clone(), name)),
            _ => None,
        });
        let mut renamed: Vec<_> =
            names.filter_map(|(span, name)| Some((span, self.name(name)?))).collect();
        renamed.sort_by_key(|(span, _)| span.start);
        let mut new = text.to_owned();
        for (span, name) in renamed.iter().rev() {
            new.replace_range(span.clone(), name);
        }
        (!renamed.is_empty()).then_some(new)
    }
}

/// The text of a node, or the texts of an array.
fn texts(node: &Node) -> Vec<&str> {
    match &node.value {
        Value::Text(text) => vec![text],
        Value::Array(nodes) => nodes.iter().flat_map(texts).collect(),
        _ => Vec::new(),
    }
}
