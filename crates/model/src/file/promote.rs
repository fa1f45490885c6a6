//! Values of a file that are set or varied by their path, `crank.mass`: they become parameters of that name.

use super::tree::{Entry, Node, Table, Value};

/// Takes the values at some paths out of the tree, as definitions of parameters, and leaves their names in their
/// places. A path that leads to no number or text is left alone, as is a name without a dot.
///
/// A path begins with a section, `loads.gravity.acceleration.1`, or with the name of something of a section,
/// `crank.mass`, where one section alone has such a value; entries of arrays are counted from 0.
pub(super) fn promoted<'p>(root: &mut Table, paths: impl Iterator<Item = &'p str>) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for path in paths {
        let is_known = entries.iter().any(|entry| entry.key == path);
        let Some(node) = (!is_known && path.contains('.')).then(|| value_at(root, path)).flatten()
        else {
            continue;
        };
        let value = std::mem::replace(&mut node.value, Value::Text(identifier(path)));
        let node = Node { span: node.span.clone(), value };
        entries.push(Entry { key: path.to_owned(), key_span: node.span.clone(), node });
    }
    entries
}

/// A path as expressions name it, where no part may be a number: `bob.com._1`.
pub(super) fn identifier(path: &str) -> String {
    let part = |part: &str| {
        let is_number = part.starts_with(|letter: char| letter.is_ascii_digit());
        if is_number { format!("_{part}") } else { part.to_owned() }
    };
    path.split('.').map(part).collect::<Vec<_>>().join(".")
}

/// True if a path leads to a number or text.
pub(super) fn leads_to_value(root: &mut Table, path: &str) -> bool {
    value_at(root, path).is_some()
}

/// The value at a path.
fn value_at<'t>(root: &'t mut Table, path: &str) -> Option<&'t mut Node> {
    let keys: Vec<&str> = path.split('.').collect();
    let leads = |table: &mut Table| descend(table, &keys).is_some();
    if leads(root) {
        return descend(root, &keys);
    }
    let has_it = |entry: &mut Entry| match &mut entry.node.value {
        Value::Table(section) => leads(section),
        _ => false,
    };
    let mut places = (0..root.entries.len()).filter(|&idx| has_it(&mut root.entries[idx]));
    let (place, other) = (places.next()?, places.next());
    let Value::Table(section) = &mut root.entries[place].node.value else { return None };
    if other.is_some() { None } else { descend(section, &keys) }
}

/// The number or text that these keys lead to.
fn descend<'t>(table: &'t mut Table, keys: &[&str]) -> Option<&'t mut Node> {
    let [key, rest @ ..] = keys else { return None };
    let mut node = &mut table.get_mut(key)?.node;
    for key in rest {
        node = match &mut node.value {
            Value::Table(table) => &mut table.get_mut(key)?.node,
            Value::Array(nodes) => nodes.get_mut(key.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    matches!(node.value, Value::Text(_) | Value::Number { .. }).then_some(node)
}
