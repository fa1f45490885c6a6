//! Sections that are nothing but keys and values.

use crate::compose::draft::{Draft, written};
use crate::compose::faults::Faults;
use crate::compose::source::Source;
use crate::kind::Section;

/// Name, policy of coordinates, and the units of bare numbers.
pub(in crate::compose) fn top(source: Source<'_>) -> Draft {
    let mut draft = Draft::default();
    for value in source.attached(Section::Model).flat_map(|it| &it.values) {
        let written = written("", &value.content, source.unit());
        if ["name", "coordinates"].contains(&value.key) {
            draft.document.insert(value.key, written.into());
            draft.note(vec![value.key.to_owned()], &value.location);
        } else {
            draft.put(["units", "", value.key], written, &value.location);
        }
    }
    draft
}

/// `[parameters]`; a fault for one without a name, or with that of another.
pub(in crate::compose) fn parameters(source: Source<'_>, faults: &mut Faults<'_>) -> Draft {
    const SECTION: &str = "parameters";
    let mut draft = Draft::default();
    for attachment in source.attached(Section::Parameters) {
        let Some(name) = attachment.text("name") else {
            faults.add_nameless("a parameter", attachment);
            continue;
        };
        let Some(value) = attachment.value("value") else { continue };
        if let Some(other) = draft.location_of(&[SECTION, name]) {
            let message = format!("two parameters are called `{name}`");
            let help = "give each a name of its own";
            faults.add_duplicate(&message, help, [&value.location, other]);
            continue;
        }
        let written = written("value", &value.content, source.unit());
        draft.put([SECTION, "", name], written, &value.location);
    }
    draft
}

/// `[solve]`.
pub(in crate::compose) fn solve(source: Source<'_>) -> Draft {
    keys(source, Section::Solve, "solve")
}

/// `[io]`.
pub(in crate::compose) fn io(source: Source<'_>) -> Draft {
    keys(source, Section::Io, "io")
}

fn keys(source: Source<'_>, section: Section, words: &str) -> Draft {
    let mut draft = Draft::default();
    for value in source.attached(section).flat_map(|it| &it.values) {
        let written = written(value.key, &value.content, source.unit());
        draft.put([words, "", value.key], written, &value.location);
    }
    draft
}
