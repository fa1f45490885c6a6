//! `[cases]`: load cases, named changes of the model.
//!
//! A case is merged over the tree of the text before anything else is read. Its values keep their own positions, so that
//! a fault in one is shown where it is written, and whatever a file can say can be changed by a case.

use super::naming::CASE_KEYS;
use super::promote::leads_to_value;
use super::reader::{Fields, Reader};
use super::tree::{Entry, Node, Table, Value};
use super::words::{cut, suggest};
use super::{CASE, SECTIONS, Source, codes, syntax};
use crate::diagnostic::{Diagnostic, Span};
use crate::load_case::LoadCase;

/// Sections that no case changes: they are read before, or are questions about all cases.
const FIXED: [&str; 7] = ["name", "drawing", "use", "units", "space", "ranges", "cases"];
/// Words of a start, which may be stated in a case alone.
const START: [&str; 12] =
    ["angle", "rate", "position", "velocity", "x", "y", "z", "vx", "vy", "vz", "guess", "w"];

/// A value by its path: where, at which positions, and what is written there.
pub(super) struct Change {
    pub(super) path: Vec<String>,
    pub(super) span: Span,
    pub(super) node: Node,
}

impl Reader<'_> {
    /// Reads the cases and merges the chosen one over the tree.
    pub(super) fn merge_case(&mut self, root: &mut Table, source: &Source<'_>) {
        let cases = self.take_cases(root);
        let has_parameter = |name: &str| {
            let parameters = root.get("parameters").map(|entry| &entry.node.value);
            matches!(parameters, Some(Value::Table(table)) if table.get(name).is_some())
        };
        // A parameter of this name is what it was before there were cases.
        let chosen = source.overrides.iter().rev().find(|(name, _)| name == CASE);
        if let Some((_, chosen)) = chosen.filter(|_| !has_parameter(CASE)) {
            self.choose_case(root, &cases, chosen);
        }
        self.cases = cases.into_iter().map(|(case, _)| case).collect();
    }

    fn choose_case(&mut self, root: &mut Table, cases: &[(LoadCase, Vec<Change>)], chosen: &str) {
        let Some((_, changes)) = cases.iter().find(|(case, _)| case.name == chosen) else {
            let names: Vec<&str> = cases.iter().map(|(case, _)| case.name.as_str()).collect();
            let help = match names.as_slice() {
                [] => format!("define it: `[cases.{}]` with `set = {{ … }}`", cut(chosen)),
                names => suggest(chosen, names),
            };
            let message = format!("the model has no load case `{}`", cut(chosen));
            self.report(Diagnostic::error(codes::UNKNOWN_CASE, message).help(help));
            return;
        };
        for change in changes {
            let placed = place(root, &change.path);
            if !placed.is_some_and(|path| put(root, &path, change)) {
                self.report(not_there(root, change));
            }
        }
    }

    fn take_cases(&mut self, root: &Table) -> Vec<(LoadCase, Vec<Change>)> {
        let Some(entry) = root.get("cases") else { return Vec::new() };
        let Some(table) = self.table(&entry.node, "`cases`") else { return Vec::new() };
        let mut cases = Vec::new();
        for Entry { key, key_span, node } in &table.entries {
            // Names of cases become parts of names of files.
            if !self.usable_name(key, key_span, "load case") {
                continue;
            }
            let what = format!("load case `{}`", cut(key));
            let Some(case) = self.table(node, &what) else { continue };
            let fields = Fields::open(self, case, what, key_span.clone(), &CASE_KEYS);
            let title = fields.get("title").and_then(|node| {
                Some(self.text_of(node, &fields.what("title"), "full load")?.text.to_owned())
            });
            let mut changes = Vec::new();
            if let Some(set) = fields.get("set")
                && let Some(set) = self.table(set, &fields.what("set"))
            {
                gather(set, &mut Vec::new(), &mut changes);
            }
            let written = |change: &Change| {
                let text = self.text.get(change.node.span.clone()).unwrap_or_default();
                (change.path.join("."), text.trim_matches('"').to_owned())
            };
            let told = changes.iter().map(written).collect();
            cases.push((LoadCase { name: key.clone(), title, changes: told }, changes));
        }
        cases
    }

    /// The faults of every case by itself, of a text that has none without them.
    pub(super) fn check_cases(&mut self, source: &Source<'_>) {
        let names: Vec<String> = self.cases.iter().map(|case| case.name.clone()).collect();
        if source.overrides.iter().any(|(name, _)| name == CASE) {
            return;
        }
        for name in names {
            let chosen = [(CASE.to_owned(), name.clone())];
            let overrides = [&chosen, source.overrides].concat();
            let source = Source { overrides: &overrides, ..*source };
            let mut other = Reader::of(&source);
            other.read(&source);
            for fault in other.faults.into_iter().filter(Diagnostic::is_error) {
                if !self.faults.contains(&fault) {
                    self.faults.push(fault.note(format!("in the load case `{}`", cut(&name))));
                }
            }
        }
    }
}

/// The values below a table with their paths: a key with dots and tables in tables are the same.
pub(super) fn gather(table: &Table, path: &mut Vec<String>, changes: &mut Vec<Change>) {
    for Entry { key, key_span, node } in &table.entries {
        let before = path.len();
        path.extend(key.split('.').map(str::to_owned));
        match &node.value {
            Value::Table(table) => gather(table, path, changes),
            _ => changes.push(Change {
                path: path.clone(),
                span: key_span.clone(),
                node: node.clone(),
            }),
        }
        path.truncate(before);
    }
}

/// The path from the top of the file to what a case names: a parameter, something of a section, or the start of a joint
/// or body.
pub(super) fn place(root: &Table, path: &[String]) -> Option<Vec<String>> {
    let section = |name: &str| match &root.get(name)?.node.value {
        Value::Table(table) => Some(table),
        _ => None,
    };
    let [first, rest @ ..] = path else { return None };
    let below = |section: &str| Some([&[section.to_owned()], path].concat());
    if rest.is_empty() {
        section("parameters")?.get(first)?;
        return below("parameters");
    }
    if SECTIONS.contains(&first.as_str()) {
        return (!FIXED.contains(&first.as_str())).then(|| path.to_vec());
    }
    let has_it = |name: &&&str| section(name).is_some_and(|table| leads(table, path));
    let open = SECTIONS.iter().filter(|name| !FIXED.contains(name));
    let places: Vec<&&str> = open.filter(has_it).collect();
    if let [one] = places.as_slice() {
        return below(one);
    }
    let is_named = ["joints", "bodies"]
        .iter()
        .any(|name| section(name).is_some_and(|t| t.get(first).is_some()));
    let is_start = path.last().is_some_and(|last| START.contains(&last.as_str()));
    (is_named && is_start).then(|| below("initial")).flatten()
}

/// Puts values from outside where their paths lead to no number or text that a parameter could stand for: to an array,
/// or to a key that a table, the start or the options of a run lack. Returns the overrides that are left.
pub(super) fn place_values(
    root: &mut Table,
    overrides: &[(String, String)],
) -> Vec<(String, String)> {
    let mut left = Vec::new();
    for (name, text) in overrides {
        let is_of_parameter = !name.contains('.') || leads_to_value(root, name);
        if is_of_parameter || !place_value(root, name, text) {
            left.push((name.clone(), text.clone()));
        }
    }
    left
}

fn place_value(root: &mut Table, name: &str, text: &str) -> bool {
    let path: Vec<String> = name.split('.').map(str::to_owned).collect();
    let Some(path) = place(root, &path) else { return false };
    let [section, .., _] = path.as_slice() else { return false };
    // No key of the file may stay without effect because its name is misspelt, and no table becomes a value.
    let is_open = ["initial", "solve"].contains(&section.as_str());
    let is_new = !leads(root, &path);
    if is_new && !is_open && !leads(root, &path[..path.len() - 1]) || is_table(root, &path) {
        return false;
    }
    let of_section = || root.get(section).map(|entry| entry.key_span.clone());
    let replaced = end(root, &path).map(|node| node.span.clone());
    let span = replaced.or_else(of_section).unwrap_or_default();
    let node = read_node(text, &span);
    let change = Change { path, span, node };
    put(root, &change.path, &change)
}

/// A value that is written outside of the file, for a place in it: as TOML writes it, or a text without quotes.
fn read_node(text: &str, place: &Span) -> Node {
    let mut faults = Vec::new();
    let parsed = syntax::parse(&format!("value = {text}"), usize::MAX, &mut faults);
    let value = match parsed.filter(|_| faults.is_empty()).map(|table| table.entries) {
        Some(mut entries) if entries.len() == 1 => entries.remove(0).node.value,
        _ => Value::Text(text.to_owned()),
    };
    let mut node = Node { span: place.clone(), value };
    node.move_to(place);
    node
}

/// True if there is something at the end of these keys.
pub(super) fn leads(table: &Table, path: &[String]) -> bool {
    end(table, path).is_some()
}

fn is_table(table: &Table, path: &[String]) -> bool {
    end(table, path).is_some_and(|node| matches!(node.value, Value::Table(_)))
}

/// The value to which these keys lead.
pub(super) fn end<'t>(table: &'t Table, path: &[String]) -> Option<&'t Node> {
    let [key, rest @ ..] = path else { return None };
    let mut node = &table.get(key)?.node;
    for key in rest {
        node = match &node.value {
            Value::Table(table) => &table.get(key)?.node,
            Value::Array(nodes) => nodes.get(key.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    Some(node)
}

/// Puts a value in the place of another one, or into a table that lacks it; false where the path goes through a value.
fn put(root: &mut Table, path: &[String], change: &Change) -> bool {
    let Some((last, keys)) = path.split_last() else { return false };
    let mut node = Node { span: change.span.clone(), value: Value::Table(std::mem::take(root)) };
    let is_done = put_into(&mut node, keys, last, change);
    if let Value::Table(table) = node.value {
        *root = table;
    }
    is_done
}

fn put_into(top: &mut Node, keys: &[String], last: &str, change: &Change) -> bool {
    let mut node = top;
    let empty = |key: &str| Entry {
        key: key.to_owned(),
        key_span: change.span.clone(),
        node: Node { span: change.node.span.clone(), value: Value::Table(Table::default()) },
    };
    for key in keys.iter().map(String::as_str).chain([last]) {
        node = match &mut node.value {
            Value::Table(table) => {
                if table.get(key).is_none() {
                    table.entries.push(empty(key));
                }
                let Some(entry) = table.get_mut(key) else { return false };
                &mut entry.node
            }
            Value::Array(nodes) => {
                let idx = key.parse::<usize>().ok();
                let Some(node) = idx.and_then(|idx| nodes.get_mut(idx)) else { return false };
                node
            }
            _ => return false,
        };
    }
    *node = change.node.clone();
    true
}

/// The fault of a change of nothing.
fn not_there(root: &Table, change: &Change) -> Diagnostic {
    let name = change.path.join(".");
    let message = format!("the load case changes `{}`, which the model does not have", cut(&name));
    let fault =
        Diagnostic::error(codes::NO_CHANGE, message).at(change.span.clone(), "no such value");
    let names = |section: &str| match root.get(section).map(|entry| &entry.node.value) {
        Some(Value::Table(table)) => {
            table.entries.iter().map(|entry| entry.key.as_str()).collect::<Vec<_>>()
        }
        _ => Vec::new(),
    };
    match change.path.as_slice() {
        [one] => fault.help(suggest(one, &names("parameters"))),
        [first, ..] if FIXED.contains(&first.as_str()) => {
            fault.help("a case changes parameters, bodies, joints, loads, drives and the start")
        }
        _ => fault.help(
            "write the path from its section, such as `loads.push.value` or `initial.A.rate`",
        ),
    }
}
