//! `[initial]`: stated starts, and the drawn pose as the guess of every body.

use super::Mechanism;
use super::number::clean_angle;
use crate::attachment::Content;
use crate::compose::draft::{Draft, quantity, written};
use crate::compose::faults::Faults;
use crate::compose::report::BodyReport;
use crate::kind::Section;

/// Keys of joints that say how the motion starts.
const JOINT_KEYS: [&str; 4] = ["angle", "rate", "position", "velocity"];

/// The starts of joints, then those that are attached by themselves, then the guesses.
pub(in crate::compose) fn starts(
    mechanism: &Mechanism<'_>,
    bodies: &[BodyReport],
    faults: &mut Faults<'_>,
) -> Draft {
    let (source, unit) = (mechanism.source, mechanism.source.unit());
    let mut draft = Draft::default();
    for connection in mechanism.connections {
        let values = connection.attachment.values.iter();
        for value in values.filter(|value| JOINT_KEYS.contains(&value.key)) {
            let written = written(value.key, &value.content, unit);
            draft.start(&connection.name, value.key, written, false, &value.location);
        }
    }

    for attachment in source.attached(Section::Initial) {
        let Some(name) = attachment.text("name") else {
            faults.add_nameless("a start", attachment);
            continue;
        };
        let guess = attachment.text("guess").unwrap_or_default().to_owned();
        let is_guess = written("guess", &Content::Text(guess), unit).as_bool() == Some(true);
        let values = attachment.values.iter();
        for value in values.filter(|value| !["name", "guess"].contains(&value.key)) {
            let written = written(value.key, &value.content, unit);
            draft.start(name, value.key, written, is_guess, &value.location);
        }
    }

    for body in bodies {
        let [x, y] = source.scale.tidy(body.centre);
        let angle = clean_angle(body.frame.angle);
        let pose = [
            ("x", quantity(x, unit.name)),
            ("y", quantity(y, unit.name)),
            ("angle", quantity(angle, "rad")),
        ];
        for (key, value) in pose {
            if !draft.has_start(&body.name, key) {
                draft.start(&body.name, key, value, true, &body.location);
            }
        }
    }
    draft
}
