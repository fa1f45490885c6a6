//! Warnings about a start that is not what the guesses ask for, or hardly so.

use super::words::unit_of;
use crate::codes;
use crate::start::{Moved, Rival, Start};
use bksim_mbs::coordinate::Owner;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{Initial, Joint, JointId, Measure, Model, motion_words};

/// A guess that was moved by more than this has been guessed far off: 20 degrees, or this part of the
/// longest link. Guesses read off a sketch are nearer.
const FAR_DEGREES: f64 = 20.0;
const FAR_PART: f64 = 0.2;

/// Warnings about guesses that were moved far, and about another assembly nearly as near to them.
pub fn diagnose_guesses(model: &Model, system: &SymbolicSystem, start: &Start) -> Vec<Diagnostic> {
    let initial = |moved: &Moved| model.initial.iter().find(|i| i.name == moved.name);
    let guesses = start.moved.iter().filter(|moved| moved.is_guess);
    let far = guesses.filter_map(|moved| far_off(model, start, initial(moved)?, moved));
    let rivals = start.rivals.iter().filter_map(|rival| match *rival {
        Rival::Guessed { initial_idx, found, ratio } => {
            Some(ambiguous(model, start, (initial_idx, found, ratio)))
        }
        Rival::Unguessed { column, found } => unguessed(model, system, start, (column, found)),
    });
    far.chain(rivals).collect()
}

fn far_off(model: &Model, start: &Start, initial: &Initial, moved: &Moved) -> Option<Diagnostic> {
    let unit = unit_of(model, initial.measure);
    let by = (moved.found - moved.stated).abs();
    let far = match unit {
        "rad" => FAR_DEGREES.to_radians(),
        "m" => FAR_PART * start.longest_link,
        _ => return None,
    };
    if by <= far {
        return None;
    }
    let message = format!(
        "the guess `{}` = {} was moved by {}",
        moved.name,
        written(moved.stated, unit),
        written(by, unit)
    );
    // Half a turn of the parameter of a curve is the other side of it.
    let side = match initial.measure {
        Measure::JointPosition(JointId(joint), _) => {
            let Joint { name, kind, .. } = &model.joints[joint];
            kind.is_same_way().map(|is_same_way| (name, is_same_way))
        }
        _ => None,
    };
    let side = match side {
        Some((name, is_same_way)) => {
            let tangents = if is_same_way { "opposite" } else { "same" };
            format!(
                "`tangents = \"{tangents}\"` in `[joints.{name}]` if the curves touch on the other side, "
            )
        }
        _ => String::new(),
    };
    let fault = Diagnostic::warning(codes::GUESS_MOVED, message)
        .at(initial.span.clone(), format!("the start has {}", written(moved.found, unit)))
        .note("of the positions found that close, the start is the nearest to all guesses together")
        .help(format!(
            "write a value near {}, {side}or look whether lengths and stated values are meant so",
            written(moved.found, unit)
        ));
    Some(fault)
}

/// The warning of two mirror images of which none was guessed.
fn unguessed(
    model: &Model,
    system: &SymbolicSystem,
    start: &Start,
    (column, found): (usize, f64),
) -> Option<Diagnostic> {
    let coordinate = &system.coordinates()[column];
    let unit = coordinate.kind.unit();
    let Owner::Joint(joint, motion_idx) = coordinate.owner else { return None };
    let joint = &model.joints[joint.0];
    let [word, ..] = motion_words(joint.kind.motions(), motion_idx);
    let here = start.q[column];
    let message = format!(
        "the joints close in two ways, and nothing tells which is meant: `{}` is {}, and could be {}",
        coordinate.name,
        written(here, unit),
        written(found, unit)
    );
    let example = match unit {
        "rad" => format!("{} deg", short(found.to_degrees())),
        unit => format!("{} {unit}", short(found)),
    };
    let fault = Diagnostic::warning(codes::AMBIGUOUS, message)
        .at(joint.span.clone(), "this joint tells them apart")
        .note("they are as near to the shape with all coordinates zero")
        .help(format!(
            "guess one, for example `{} = {{ guess = {{ {word} = \"{example}\" }} }}` in `[initial]`",
            joint.name
        ));
    Some(fault)
}

/// The warning of another assembly that is nearly as near to the guesses.
fn ambiguous(
    model: &Model,
    start: &Start,
    (initial_idx, found, ratio): (usize, f64, f64),
) -> Diagnostic {
    let initial = &model.initial[initial_idx];
    let unit = unit_of(model, initial.measure);
    let here = start.moved[initial_idx].found;
    let message = format!(
        "another assembly is nearly as near to the guesses: `{}` could be {} in place of {}",
        initial.name,
        written(found, unit),
        written(here, unit)
    );
    Diagnostic::warning(codes::AMBIGUOUS, message)
        .at(
            initial.span.clone(),
            format!("{} guessed", { written(start.moved[initial_idx].stated, unit) }),
        )
        .note(format!("its distance from the guesses is {} times that of the start", short(ratio)))
        .help("guess nearer to the assembly that is meant, or guess another coordinate")
}

/// A value with its unit; an angle in degrees, too.
pub(super) fn written(value: f64, unit: &str) -> String {
    match unit {
        "rad" => format!("{} rad ({}°)", short(value), short(value.to_degrees())),
        "" => short(value),
        unit => format!("{} {unit}", short(value)),
    }
}
