//! Linkages from what they are to do: functions, poses, paths, cognates, quick returns, straight lines, dwells.
//!
//! Each task is a table `[synthesize]`; each linkage that is found is checked and is the text of a model that solves.

mod curves;
mod dwell;
mod four_bar;
mod function;
mod lines;
mod nine_points;
mod path;
mod polynomial;
mod poses;
mod quick_return;
mod slide;

use std::collections::BTreeMap;
use std::ops::Range;

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{code, looks_like_degrees};
use bksim::model::message::short;
use serde::{Deserialize, Serialize};
use serde_spanned::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use crate::base::Quantity;
use crate::codes;
use crate::error::DesignError;
use crate::spec::{Written, section};

pub use nine_points::general_solutions;

/// A linkage that does a task.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Candidate {
    /// The name of its model.
    pub name: String,
    /// Lengths, angles and places, SI.
    pub numbers: BTreeMap<String, f64>,
    /// Grashof's type of a four-bar, as Barker names it.
    pub kind: Option<String>,
    /// Facts that hold or do not: order, branch.
    pub checks: BTreeMap<String, bool>,
    /// The text of its model.
    #[serde(skip)]
    pub model: String,
}

/// The answer.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Synthesis {
    /// The task.
    pub task: String,
    /// Numbers of the task as a whole, by name.
    pub facts: BTreeMap<String, Vec<f64>>,
    /// The linkages, the best first where they are ranked.
    pub candidates: Vec<Candidate>,
    /// Angles that look like degrees.
    #[serde(skip)]
    pub warnings: Vec<Diagnostic>,
}

/// A point.
type Point = [f64; 2];

/// One task with its numbers.
#[derive(Deserialize, Debug)]
#[serde(tag = "task", rename_all = "snake_case", deny_unknown_fields)]
enum Task {
    Function(function::Wish),
    Poses(poses::Wish),
    Path(path::Wish),
    Cognates(four_bar::CognateWish),
    QuickReturn(quick_return::Wish),
    StraightLine(lines::Wish),
    Dwell(dwell::Wish),
}

const EXAMPLE: &str = "write a table `[synthesize]` with `task = \"function\"`, `\"poses\"`, `\"path\"`, `\"cognates\"`, `\"quick_return\"`, `\"straight_line\"` or `\"dwell\"`; docs/design.md has the keys of each";

/// Does the task of a text.
///
/// # Errors
/// [`codes::BAD_QUESTION`] for what cannot be read, [`codes::NO_LINKAGE`] where there is no solution.
pub fn synthesize(text: &str) -> Result<Synthesis, DesignError> {
    let task: Option<Task> = section(text, "synthesize", EXAMPLE)?;
    let Some(task) = task else {
        return Err(DesignError::fault(
            codes::NOTHING_ASKED,
            "the file has no table `[synthesize]`",
            EXAMPLE,
        ));
    };
    let warnings = like_degrees(text);
    let found = match task {
        Task::Function(wish) => function::solve(&wish),
        Task::Poses(wish) => poses::solve(&wish),
        Task::Path(wish) => path::solve(&wish),
        Task::Cognates(wish) => four_bar::cognates(&wish),
        Task::QuickReturn(wish) => quick_return::solve(&wish),
        Task::StraightLine(wish) => lines::solve(&wish),
        Task::Dwell(wish) => dwell::solve(&wish),
    };
    // Where nothing is found, angles may be the cause.
    match found {
        Ok(found) => Ok(Synthesis { warnings, ..found }),
        Err(DesignError::Rejected(bksim::Rejected(mut faults))) => {
            faults.extend(warnings);
            Err(bksim::Rejected(faults).into())
        }
        Err(error) => Err(error),
    }
}

/// Keys of tasks that hold angles.
const ANGLES: [&str; 6] = ["phi", "psi", "angle", "angles", "dwell", "swing"];

/// Warnings of angles without a unit whose numbers are degrees: the first of each key.
fn like_degrees(text: &str) -> Vec<Diagnostic> {
    let Ok(root) = DeTable::parse(text) else { return Vec::new() };
    let task = root.get_ref().get("synthesize").and_then(|task| task.get_ref().as_table());
    let warning = |(key, value): (&Spanned<DeString<'_>>, &Spanned<DeValue<'_>>)| {
        let key: &str = key.get_ref();
        let mut found = Vec::new();
        match value.get_ref() {
            // The third number of a pose.
            DeValue::Array(poses) if key == "poses" => {
                let last =
                    |pose: &Spanned<DeValue<'_>>| Some(pose.get_ref().as_array()?.get(2)?.span());
                found.extend(poses.iter().filter_map(last));
            }
            DeValue::Array(all) if ANGLES.contains(&key) => {
                found.extend(all.iter().map(Spanned::span));
            }
            _ if ANGLES.contains(&key) => found.push(value.span()),
            _ => (),
        }
        let like = |span: &Range<usize>| {
            let value: f64 = text[span.clone()].trim_matches(['"', '\'']).trim().parse().ok()?;
            looks_like_degrees(value).then_some(value)
        };
        let (span, value) =
            found.into_iter().find_map(|span| Some((span.clone(), like(&span)?)))?;
        let (shown, turns) = (short(value), value / std::f64::consts::TAU);
        let message = format!("{shown} in `{key}` is {shown} rad = {turns:.1} turns");
        Some(
            Diagnostic::warning(code::LOOKS_LIKE_DEGREES, message)
                .at(span, "a number without unit is in radians")
                .help(format!("write \"{shown} deg\", or \"{shown} rad\" if it is right")),
        )
    };
    task.into_iter().flatten().filter_map(warning).collect()
}

/// A value in SI.
fn si(value: &Written) -> Result<f64, DesignError> {
    let text = value.text();
    Quantity::read(&text).map(|quantity| quantity.value).ok_or_else(|| {
        let message = format!("`{text}` is no value");
        DesignError::fault(
            codes::BAD_QUESTION,
            message,
            "write a number with its unit, as in `\"120 mm\"` or `\"30 deg\"`",
        )
    })
}

fn all_si(values: &[Written]) -> Result<Vec<f64>, DesignError> {
    values.iter().map(si).collect()
}

fn optional(value: Option<&Written>) -> Result<Option<f64>, DesignError> {
    value.map(si).transpose()
}

/// No linkage does the task.
fn none(why: &str, help: &str) -> DesignError {
    DesignError::fault(codes::NO_LINKAGE, why, help)
}
