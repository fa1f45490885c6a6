//! `bksim static`: equilibria, their stability, the reactions in them.

use bksim::analysis::{Equilibrium, Stability, Statics, statics};
use serde_json::json;

use super::answer::{Answer, Asked, asked, failed, lines, pose_json, shown};
use crate::args::analysis::Static as Args;
use crate::exit::{Failure, Status};
use crate::output::number;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    let name = model.name.clone();
    let found = statics(model, &args.by).map_err(failed(&source))?;
    let answer = told(&name, &found);
    Asked::answer(&source, &warnings, file, answer, as_json)
}

pub(super) fn word(stability: Stability) -> &'static str {
    match stability {
        Stability::Stable => "stable",
        Stability::Unstable => "unstable",
        Stability::Neutral => "neutral",
    }
}

/// The note about stops and friction that hold.
pub(super) fn held(names: &[String]) -> String {
    if names.is_empty() {
        return String::new();
    }
    format!("\n  counted as constraints: {}", names.join(", "))
}

fn told(name: &str, found: &Statics) -> Answer {
    let by: Vec<&str> = found.by.iter().map(|(name, _)| name.as_str()).collect();
    let position = |e: &Equilibrium| {
        let value = |name: &&str| e.pose.iter().find(|(known, ..)| known == name);
        let shown = by
            .iter()
            .filter_map(value)
            .map(|(name, value, unit)| format!("{name} = {}", shown(*value, unit)));
        shown.collect::<Vec<_>>().join(", ")
    };
    let row = |e: &Equilibrium| {
        let least = e.stiffness.first().map_or(String::new(), |k| number(*k));
        vec![word(e.stability).to_owned(), least, position(e)]
    };
    let rows = found.equilibria.iter().map(row).collect();
    let count = found.equilibria.len();
    let whether =
        if found.is_complete { "there are no others on this assembly" } else { "of a search" };
    let text = format!(
        "{name}: {count} equilibria, {whether}{}\n\n{}",
        held(&found.held),
        lines(&["", "least stiffness", "where"], rows)
    );
    let equilibria = found.equilibria.iter().map(|e| {
        let reactions = found.joints.iter().zip(&e.reactions);
        let reactions = reactions
            .map(|(joint, r)| (joint.clone(), json!({ "force": r[..3], "moment": r[3..] })));
        json!({
            "stability": word(e.stability),
            "stiffness": e.stiffness,
            "pose": pose_json(&e.pose),
            "multipliers": e.lambda,
            "reactions": serde_json::Value::Object(reactions.collect()),
        })
    });
    let json = json!({
        "by": by,
        "complete": found.is_complete,
        "held": found.held,
        "equilibria": equilibria.collect::<Vec<_>>(),
    });
    Answer { command: "static", json, text, table: found.table() }
}
