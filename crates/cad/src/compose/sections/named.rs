//! Elements that are called by their names and hold the keys of a model file as they are: couplings, tables, curves,
//! states, clocks, signals and parts.

use toml_edit::Value;

use super::Mechanism;
use crate::attachment::Attachment;
use crate::compose::draft::{Draft, array, written};
use crate::compose::faults::Faults;
use crate::compose::names::{goes_on, names};
use crate::kind::{NAMED, Placement, Section};

/// Every section of [`NAMED`].
pub(in crate::compose) fn named(mechanism: &Mechanism<'_>, faults: &mut Faults<'_>) -> Draft {
    let sections = NAMED.map(|(section, words)| {
        let mut draft = Draft::default();
        for (attachment, name) in names(mechanism.source, section, |it| it.kind.name, faults) {
            // Only couplings are never called by their name in an expression.
            if section != Section::Couplings && attachment.text("name").is_none() {
                faults.add_nameless(&format!("a {}", attachment.kind.name), attachment);
                continue;
            }
            put(&mut draft, mechanism, (words, &name), attachment, faults);
        }
        draft
    });
    Draft::joined(sections)
}

fn put(
    draft: &mut Draft,
    mechanism: &Mechanism<'_>,
    (section, name): (&str, &str),
    attachment: &Attachment,
    faults: &mut Faults<'_>,
) {
    let location = &attachment.location;
    if let Some(word) = word(attachment) {
        draft.put([section, name, "type"], Value::from(word), location);
    }
    // Wheels are at the ends of what is drawn from one to the other.
    let is_drawn = attachment.kind.placement == Placement::Line;
    if is_drawn && attachment.value("between").is_none() {
        let ends = [attachment.at, attachment.to.or(attachment.at)];
        let joints = ends.map(|at| mechanism.joint_at(attachment, at?, "between", faults));
        let [Some(first), Some(second)] = joints else { return };
        let joints = [first, second].map(Value::from);
        draft.put([section, name, "between"], array(joints.into_iter()), location);
    }
    for value in attachment.values.iter().filter(|value| value.key != "name") {
        let mut written = written(value.key, &value.content, mechanism.source.unit());
        if value.key == "points"
            && let Value::Array(rows) = &mut written
        {
            for row in further_rows(mechanism, attachment) {
                rows.push_formatted(row.decorated(" ", ""));
            }
        }
        draft.put([section, name, value.key], written, &value.location);
    }
}

/// The rows of the attachments that go on with those of a long table or curve, in the order of the drawing.
fn further_rows(mechanism: &Mechanism<'_>, first: &Attachment) -> Vec<Value> {
    let source = mechanism.source;
    let is_further = |it: &&Attachment| {
        !std::ptr::eq(*it, first) && goes_on(it) && it.text("name") == first.text("name")
    };
    let further = source.attached(first.kind.section).filter(is_further);
    let rows = |it: &Attachment| match it.value("points").map(|value| &value.content) {
        Some(content) => match written("points", content, source.unit()) {
            Value::Array(rows) => rows.into_iter().collect(),
            other => vec![other],
        },
        None => Vec::new(),
    };
    further.flat_map(rows).collect()
}

/// Word of `type` in a model file, if the attachment has one there.
fn word(attachment: &Attachment) -> Option<&'static str> {
    match (attachment.kind.section, attachment.kind.name) {
        (Section::Curves, "curve") if attachment.value("points").is_some() => Some("points"),
        (Section::Curves, "curve") => Some("formula"),
        (Section::Curves | Section::Couplings, name) => Some(name),
        _ => None,
    }
}
