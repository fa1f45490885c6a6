//! Names of joints, loads and drives: stated ones, and numbers for the others.

use super::faults::Faults;
use super::source::Source;
use crate::attachment::Attachment;
use crate::kind::{NAMED, Section};

/// The attachments of a section with their names. One without a name is called as `default` says,
/// with a number unless it is the only one of its kind; joints always have a number.
pub(super) fn names<'a>(
    source: Source<'a>,
    section: Section,
    default: fn(&Attachment) -> &'static str,
    faults: &mut Faults<'_>,
) -> Vec<(&'a Attachment, String)> {
    let attached: Vec<&'a Attachment> = source.attached(section).collect();
    let stated: Vec<&str> = attached.iter().filter_map(|it| it.text("name")).collect();
    let mut named: Vec<(&'a Attachment, String)> = Vec::new();
    for &attachment in &attached {
        // A stated name, which no other may have.
        if let Some(name) = attachment.text("name") {
            if let Some((other, _)) = named.iter().find(|(_, known)| known == name) {
                if goes_on(attachment) && other.value("points").is_some() {
                    continue;
                }
                let message = format!("two {} are called `{name}`", plural(section));
                let help = "give each a name of its own";
                faults.add_duplicate(&message, help, [&attachment.location, &other.location]);
                continue;
            }
            named.push((attachment, name.to_owned()));
            continue;
        }

        // The first free one of the numbered names.
        let base = default(attachment);
        let is_single = section != Section::Joints
            && attached.iter().filter(|other| default(other) == base).count() == 1;
        let is_free = |name: &String| {
            !stated.contains(&name.as_str()) && named.iter().all(|(_, known)| known != name)
        };
        let numbered = (1..).map(|number: u64| format!("{base}{number}"));
        let candidates = is_single.then(|| base.to_owned()).into_iter().chain(numbered);
        let name = candidates.into_iter().find(is_free);
        named.push((attachment, name.expect("fewer names are taken than there are numbers")));
    }
    named
}

/// True of an attachment that may go on with the rows of another one of its name: one value holds few of a long table.
pub(super) fn goes_on(attachment: &Attachment) -> bool {
    matches!(attachment.kind.section, Section::Tables | Section::Curves)
        && attachment.value("points").is_some()
        && attachment.values.iter().all(|value| ["name", "points"].contains(&value.key))
}

/// The attachments of a section in words.
fn plural(section: Section) -> &'static str {
    match section {
        Section::Joints => "joints",
        Section::Loads => "loads",
        Section::Drives => "drives",
        Section::Parts => "parts",
        section => {
            NAMED.iter().find(|(own, _)| *own == section).map_or("things", |(_, words)| *words)
        }
    }
}
