//! The sections of a model file with their tables and keys, as editors need them: the tables of the reader
//! itself, so that what it knows and what an editor offers are one.

use super::bodies::{BODY_KEYS, GROUND_KEYS};
use super::couplings::{CONDITION_KEYS, COUPLINGS};
use super::curves::CURVES;
use super::io::IO_KEYS;
use super::joint_types::{DISTANCE, DISTANCE_KEYS};
use super::loads::{DRIVE_KEYS, LOADS};
use super::naming::CASE_KEYS;
use super::outlines::CONTACT_KEYS;
use super::sampled::CLOCK_KEYS;
use super::sections::SECTIONS;
use super::solve::SOLVE_KEYS;
use super::states::{SIGNAL_KEYS, STATE_KEYS};
use super::tables::TABLE_KEYS;
use super::units::{FileUnits, UNITS};
use crate::joint::JOINT_TYPES;

/// A section of a model file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SectionForm {
    /// Name of the section: `joints`.
    pub name: &'static str,
    /// Contents of the section.
    pub holds: Holds,
}

/// The contents of a section.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Holds {
    /// A text.
    Text,
    /// One of some words.
    Word(Vec<&'static str>),
    /// Values of any names.
    Values,
    /// Tables or values of any names, whose keys depend on those.
    Open,
    /// One table, whose keys take one of some words each, where they are given.
    Table(Vec<(&'static str, Vec<&'static str>)>),
    /// Tables of any names, each of one of these forms.
    Named(Vec<TableForm>),
}

/// Tables with one set of keys.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TableForm {
    /// The word of their `type`; `None` where the section has no types.
    pub word: Option<&'static str>,
    /// Their keys, `type` among them.
    pub keys: Vec<&'static str>,
}

/// Keys of every table that may repeat.
const REPEAT_KEYS: [&str; 2] = ["count", "first"];
/// Keys of a part that is used.
const USE_KEYS: [&str; 4] = ["file", "part", "on", "with"];

fn typed(rows: &[(&'static str, impl AsRef<[&'static str]>)]) -> Holds {
    let form = |(word, keys): &(&'static str, _)| TableForm {
        word: Some(word),
        keys: [AsRef::as_ref(keys), &REPEAT_KEYS[..]].concat(),
    };
    Holds::Named(rows.iter().map(form).collect())
}

/// Keys of `[optimize]`.
const OPTIMIZE_KEYS: [&str; 10] = [
    "minimize",
    "maximize",
    "vary",
    "choose",
    "subject_to",
    "over",
    "cases",
    "from",
    "starts",
    "points",
];
/// Keys of `[fit]`.
const FIT_KEYS: [&str; 8] =
    ["vary", "unknowns", "compare", "drive", "sigma", "delay", "loss", "scale"];
/// Keys of `[tolerance]`.
const TOLERANCE_KEYS: [&str; 10] =
    ["of", "limits", "play", "at", "distribution", "samples", "seed", "keep", "weights", "by"];

fn named(keys: &[&'static str]) -> Holds {
    Holds::Named(vec![TableForm { word: None, keys: [keys, &REPEAT_KEYS[..]].concat() }])
}

fn table(keys: &[&'static str]) -> Holds {
    Holds::Table(keys.iter().map(|key| (*key, Vec::new())).collect())
}

/// The units that a key of `[units]` may name.
fn units() -> Holds {
    let names = |quantity: super::units::Quantity| {
        let fits = |unit: &&super::units::Unit| {
            unit.dimension == quantity.dimension() && unit.is_angle == quantity.is_angle()
        };
        UNITS.iter().filter(fits).map(|unit| unit.name).collect()
    };
    Holds::Table(FileUnits::KEYS.iter().map(|(key, quantity)| (*key, names(*quantity))).collect())
}

fn joints() -> Holds {
    let rows = JOINT_TYPES.iter().map(|of| (of.word, of.keys()));
    typed(&rows.chain([(DISTANCE, DISTANCE_KEYS.to_vec())]).collect::<Vec<_>>())
}

/// All sections, in the order in which they are documented.
pub fn sections() -> Vec<SectionForm> {
    let holds = |name: &str| match name {
        "name" | "drawing" => Holds::Text,
        "space" => Holds::Word(vec!["planar", "spatial"]),
        "coordinates" => Holds::Word(vec!["auto", "relative", "absolute"]),
        "units" => units(),
        "parameters" | "outputs" | "ranges" => Holds::Values,
        "use" => named(&USE_KEYS),
        // A table may stand in a file of its own.
        "tables" => named(&[&TABLE_KEYS[..], &["file"]].concat()),
        "curves" => typed(&CURVES),
        "ground" => table(&GROUND_KEYS),
        "bodies" => named(BODY_KEYS),
        "joints" => joints(),
        "couplings" => typed(&COUPLINGS),
        "conditions" => named(&CONDITION_KEYS),
        "contacts" => named(&CONTACT_KEYS),
        "states" => named(&STATE_KEYS),
        "clocks" => named(&CLOCK_KEYS),
        "signals" => named(&SIGNAL_KEYS),
        "loads" => typed(&LOADS),
        "drives" => named(&DRIVE_KEYS),
        "solve" => table(SOLVE_KEYS),
        "io" => table(IO_KEYS),
        "cases" => Holds::Named(vec![TableForm { word: None, keys: CASE_KEYS.to_vec() }]),
        // Questions of design, which `crates/design` reads.
        "optimize" => table(&OPTIMIZE_KEYS),
        "fit" => table(&FIT_KEYS),
        "tolerance" => table(&TOLERANCE_KEYS),
        _ => Holds::Open,
    };
    SECTIONS.iter().map(|name| SectionForm { name, holds: holds(name) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_section_but_the_start_has_a_form() {
        let open = sections().into_iter().filter(|section| section.holds == Holds::Open);
        assert_eq!(open.map(|section| section.name).collect::<Vec<_>>(), ["initial"]);
    }

    #[test]
    fn the_reader_knows_every_key_of_a_form() {
        use super::super::{Source, read};
        for section in sections() {
            let Holds::Named(forms) = &section.holds else { continue };
            // Parts and repeated elements are gone before the reader; so are files of tables.
            let early = ["use", "count", "first", "file"];
            if early.contains(&section.name) {
                continue;
            }
            for form in forms {
                let keys = form.keys.iter().filter(|key| !early.contains(key) && **key != "type");
                let kind = form.word.map_or(String::new(), |word| format!("type = \"{word}\"\n"));
                let keys: Vec<String> = keys.map(|key| format!("{key} = 1\n")).collect();
                let keys = keys.concat();
                let text = format!("[{}.thing]\n{kind}{keys}zzz = 1\n", section.name);
                let reading = read(&Source::new(&text, "model"));
                let unknown = reading.diagnostics.iter().filter(|fault| fault.code.0 == "M005");
                let unknown: Vec<&str> = unknown.map(|fault| fault.message.as_str()).collect();
                let is_one = |unknown: &[&str]| unknown.len() == 1 && unknown[0].contains("`zzz`");
                assert!(is_one(&unknown), "{text}{:?}", reading.diagnostics);
            }
        }
    }
}
