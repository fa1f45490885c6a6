//! Checks of a drawing before it is interpreted: ends, values, counts, sizes.

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;

use super::feed::{Record, kept};
use crate::codes;
use crate::container::Container;
use crate::tags::{Tags, ValueType};

/// Coordinates beyond this are a fault of the file: a double has no thousandth of a unit left.
const LARGEST_NUMBER: f64 = 1e15;

/// A drawing with more entities, blocks inserted, is refused.
pub(super) const MOST_ENTITIES: u64 = 500_000;

/// Groups that say how many of something follow, by the entity they stand in.
const COUNTS: &[(&str, &[i16])] = &[
    ("HATCH", &[78, 79, 91, 93, 95, 96, 97, 98, 453]),
    ("LWPOLYLINE", &[90]),
    ("SPLINE", &[72, 73, 74]),
];

/// Faults of one kind are all alike: this many are shown.
pub(super) const SHOWN: usize = 20;

/// Type and position of a record: `CIRCLE, handle 2F, layer BK_JOINTS, at (120.5, 34)`.
pub fn describe(tags: &Tags, record: Range<usize>) -> String {
    let mut words = vec![tags.text(record.start).trim().to_owned()];
    if let Some(handle) = tags.handle_of(record.clone()) {
        words.push(format!("handle {:X}", handle.0));
    }
    let own: Vec<usize> = record.take_while(|&idx| tags.code(idx) < 1000).collect();
    let first = |code: i16| own.iter().copied().find(|&idx| tags.code(idx) == code);
    if let Some(layer) = first(8) {
        words.push(format!("layer {}", tags.text(layer).trim()));
    }
    let [x, y] = [10, 20].map(|code| first(code).and_then(|idx| tags.number(idx)));
    if let (Some(x), Some(y)) = (x, y) {
        words.push(format!("at ({x}, {y})"));
    }
    words.join(", ")
}

/// Adds the span of a value to a fault, in files that have lines.
pub(super) fn at_value(fault: Diagnostic, tags: &Tags, idx: usize, words: &str) -> Diagnostic {
    match tags.container() {
        Container::Text { .. } => fault.at(tags.value_span(idx), words),
        _ => fault,
    }
}

/// The end of the file: an error where entities are missing, else a warning.
pub(super) fn ending(tags: &Tags) -> Option<Diagnostic> {
    let entities = tags.section("ENTITIES");
    let is_read = entities.is_some_and(|section| section.is_closed);
    let open = tags.sections().iter().find(|section| !section.is_closed);
    if tags.is_complete() && open.is_none() && is_read {
        return None;
    }
    let message = match tags.len().checked_sub(1).and_then(|last| tags.line(last)) {
        Some(line) => format!("the drawing ends unexpectedly at line {}", line + 1),
        None => format!("the drawing ends unexpectedly at byte {}", tags.end()),
    };
    let fault = if is_read { Diagnostic::warning } else { Diagnostic::error };
    let mut fault = fault(codes::CUT, message);
    if let Container::Text { .. } = tags.container() {
        let end =
            tags.len().checked_sub(1).map_or(tags.end()..tags.end(), |it| tags.value_span(it));
        fault = fault.at(end, "the last line that was read");
    }
    let n_entities = entities.map_or(0, |section| {
        let all = tags.records(section.tags.clone());
        let parts = ["VERTEX", "ATTRIB", "SEQEND"];
        all.filter(|record| !parts.iter().any(|part| tags.is_word(record.start, part))).count()
    });
    let missing = match open {
        Some(section) => format!("the section `{}` has no `ENDSEC`", section.name),
        None if entities.is_none() => "there is no section `ENTITIES`".to_owned(),
        None => "the last group `EOF` is missing".to_owned(),
    };
    let counted = if n_entities == 1 { "entity was" } else { "entities were" };
    Some(
        fault
            .note(format!("{n_entities} {counted} read; {missing}"))
            .help("the file was cut: copy or save it again"),
    )
}

/// Values that are no numbers, or no numbers of a drawing.
pub(super) fn values(tags: &Tags, records: &[Record]) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    for record in records {
        for idx in kept(tags, record) {
            if let Some(fault) = value_fault(tags, idx) {
                let name = describe(tags, record.tags.clone());
                faults.push(at_value(fault, tags, idx, "").note(name));
                if faults.len() == SHOWN {
                    return faults;
                }
            }
        }
    }
    faults
}

fn value_fault(tags: &Tags, idx: usize) -> Option<Diagnostic> {
    let code = tags.code(idx);
    let position = || match tags.line(idx) {
        Some(line) => format!("on line {}", line + 1),
        None => format!("at byte {}", tags.value_span(idx).start),
    };
    let damaged = |what: &str| {
        let words = tags.text(idx).chars().take(40).collect::<String>();
        let message =
            format!("group {code} {} is `{}`, not {what}", position(), words.trim().escape_debug());
        Some(Diagnostic::error(codes::DAMAGED, message).help("mend or delete the entity"))
    };
    match ValueType::of(code) {
        ValueType::Text | ValueType::Chunk => None,
        ValueType::Real => match tags.number(idx) {
            None => damaged("a number"),
            Some(number) if number.abs() <= LARGEST_NUMBER => None,
            Some(number) => {
                let message = format!("group {code} {} is {number}", position());
                let fault = Diagnostic::error(codes::ABSURD_NUMBER, message)
                    .note(format!("numbers of a drawing are finite and at most {LARGEST_NUMBER:e}"))
                    .help("mend or delete the entity");
                Some(fault)
            }
        },
        _ if tags.integer(idx).is_none() => damaged("an integer"),
        _ => None,
    }
}

/// Records that promise more than they hold.
///
/// Each counted thing takes a group at least, so that the sum of the counts is at most the number
/// of groups; a reader that believes a larger count allocates for it, or waits for what never comes.
pub(super) fn counts(tags: &Tags, records: &[Record]) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    for record in records {
        let own = COUNTS.iter().find(|(name, _)| tags.is_word(record.tags.start, name));
        let Some((_, codes)) = own else { continue };
        let mut left = i64::try_from(record.tags.len()).expect("groups are counted to 2⁶³");
        let counts = kept(tags, record).into_iter().filter(|&idx| codes.contains(&tags.code(idx)));
        for idx in counts {
            let count = tags.integer(idx).unwrap_or(0);
            left = if count < 0 { -1 } else { left.saturating_sub(count) };
            if left < 0 {
                let message = format!(
                    "group {} promises {count} items, but the entity has {} groups in all",
                    tags.code(idx),
                    record.tags.len()
                );
                let fault = Diagnostic::error(codes::DAMAGED, message)
                    .note(describe(tags, record.tags.clone()))
                    .help("mend or delete the entity");
                faults.push(at_value(fault, tags, idx, ""));
                break;
            }
        }
        if faults.len() == SHOWN {
            break;
        }
    }
    faults
}

/// Width and height of the box around the defining points of all entities.
pub(super) fn size(tags: &Tags, records: &[Record]) -> [f64; 2] {
    let mut boxes = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for idx in records.iter().flat_map(|record| kept(tags, record)) {
        let axis = match tags.code(idx) {
            10..=14 => 0,
            20..=24 => 1,
            _ => continue,
        };
        if let Some(number) = tags.number(idx) {
            boxes[axis] = [boxes[axis][0].min(number), boxes[axis][1].max(number)];
        }
    }
    boxes.map(|[low, high]| (high - low).max(0.0))
}
