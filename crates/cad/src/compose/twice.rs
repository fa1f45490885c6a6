//! Things that a drawing may state once, stated twice: the last would win, or both would count.

use bksim_model::diagnostic::Diagnostic;

use super::faults::Faults;
use super::names::names;
use super::sidecar::Sidecar;
use super::source::Source;
use crate::attachment::Attachment;
use crate::codes;
use crate::drawing::Location;
use crate::geometry::Point;
use crate::geometry::vector::distance;
use crate::kind::Section;

/// Keys of joints that say how the motion starts.
const STARTS: [&str; 4] = ["angle", "rate", "position", "velocity"];

/// Reports gravity, `solve` and `model` that are stated twice, and starts with two values.
pub(super) fn stated_twice(source: Source<'_>, sidecar: &Sidecar, faults: &mut Faults<'_>) {
    for (section, help) in [
        (Section::Model, "keep one, with the keys of both"),
        (Section::Solve, "keep one, with the keys of both"),
        (Section::Io, "keep one, with the keys of both"),
    ] {
        let all: Vec<&Attachment> = source.attached(section).collect();
        if let [first, others @ ..] = all.as_slice() {
            for other in others {
                let message = format!("`{}` is stated twice", first.kind.name);
                add(&message, help, [&other.location, &first.location], faults);
            }
        }
    }
    gravities(source, sidecar, faults);
    copies(source, faults);
    starts(source, faults);
}

fn add(message: &str, help: &str, [here, there]: [&Location; 2], faults: &mut Faults<'_>) {
    let fault = Diagnostic::error(codes::STATED_TWICE, message).help(help);
    faults.add_pair(fault, [here, there]);
}

/// Joints, loads and drives without a name that are the same to the last word: what copying leaves.
fn copies(source: Source<'_>, faults: &mut Faults<'_>) {
    let is_copied = |it: &&Attachment| {
        matches!(
            it.kind.section,
            Section::Joints | Section::Loads | Section::Drives | Section::Couplings
        ) && it.kind.name != "gravity"
            && it.text("name").is_none()
            && it.at.is_some()
    };
    let all: Vec<&Attachment> = source.attachments.iter().filter(is_copied).collect();
    for (idx, copy) in all.iter().enumerate() {
        if let Some(first) = all[..idx].iter().find(|it| says_the_same(it, copy, source)) {
            let message = format!("a {} is stated twice at one place", copy.kind.name);
            let help = "remove one of them, or give each a name if both are meant";
            add(&message, help, [&copy.location, &first.location], faults);
        }
    }
}

fn says_the_same(a: &Attachment, b: &Attachment, source: Source<'_>) -> bool {
    let is_one = |p: Option<Point>, q: Option<Point>| match (p, q) {
        (Some(p), Some(q)) => distance(p, q) <= source.scale.rounding,
        (p, q) => p == q,
    };
    let values = |it: &Attachment| -> Vec<_> {
        it.values.iter().map(|value| (value.key, value.content.clone())).collect()
    };
    a.kind == b.kind
        && is_one(a.at, b.at)
        && is_one(a.to, b.to)
        && is_one(a.axis, b.axis)
        && values(a) == values(b)
}

/// Gravity pulls at everything: a second one adds to the first.
fn gravities(source: Source<'_>, sidecar: &Sidecar, faults: &mut Faults<'_>) {
    let is_gravity = |it: &&Attachment| it.kind.name == "gravity";
    let drawn: Vec<&Attachment> = source.attached(Section::Loads).filter(is_gravity).collect();
    let [first, others @ ..] = drawn.as_slice() else { return };
    for other in others {
        // Equal names are a fault of their own.
        if first.text("name").is_none() || first.text("name") != other.text("name") {
            let help = "keep one: the accelerations of both would add up";
            add("gravity is stated twice", help, [&other.location, &first.location], faults);
        }
    }

    // One of the model file next to the drawing takes the place of the drawn one where it has its name.
    let named = names(source, Section::Loads, |it| it.kind.name, &mut faults.unheard());
    let own = named.iter().find(|(it, _)| std::ptr::eq(*it, *first)).map(|(_, name)| name.as_str());
    for beside in sidecar.gravities().iter().filter(|name| Some(name.as_str()) != own) {
        let message = format!("gravity is stated here and as `{beside}` in the model file beside");
        let help = "keep one: the accelerations of both would add up";
        let fault = Diagnostic::error(codes::STATED_TWICE, message).help(help);
        faults.add(fault, &first.location);
    }
}

/// The start of a joint, a body or a coordinate has one value for each of its keys.
fn starts(source: Source<'_>, faults: &mut Faults<'_>) {
    let mut known: Vec<([&str; 2], &Location)> = Vec::new();
    for attachment in source.attachments {
        let is_start = |key: &str| match attachment.kind.section {
            Section::Initial => !["name", "guess"].contains(&key),
            Section::Joints => STARTS.contains(&key),
            _ => false,
        };
        let Some(name) = attachment.text("name") else { continue };
        for value in attachment.values.iter().filter(|value| is_start(value.key)) {
            let path = [name, value.key];
            match known.iter().find(|(other, _)| *other == path) {
                Some((_, first)) => {
                    let message = format!("`{}` of `{name}` has two starts", value.key);
                    add(&message, "state it once", [&value.location, first], faults);
                }
                None => known.push((path, &value.location)),
            }
        }
    }
}
