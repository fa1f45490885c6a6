//! `bksim modes`: frequencies, damping, shapes.

use bksim::analysis::{Mode, Modes, modes};
use bksim::model::file::ShownUnits;
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked, failed, lines, text_units};
use super::linearize::pole;
use super::state::{self, besides, branches, branches_json, word};
use super::statics::{held, with_held};
use crate::args::analysis::Modes as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::waiting::waiting;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    let name = model.name.clone();
    let found = waiting("computing modes", || modes(model, args.at)).map_err(failed(&source))?;
    let units = text_units();
    Asked::answer(&source, &warnings, file, told(&name, &units, &found), as_json)
}

/// The answer about a model of this name, its state in these units.
pub fn told(name: &str, units: &ShownUnits, found: &Modes) -> Answer {
    let row = |mode: &Mode| {
        let shares = found.bodies.iter().zip(&mode.shares).filter(|(_, share)| **share > 0.005);
        let shares = shares.map(|(body, share)| format!("{body} {:.0} %", 100.0 * share));
        let mut row = vec![
            number(mode.omega / std::f64::consts::TAU),
            number(mode.omega),
            number(mode.damping),
            pole(&mode.s),
            shares.collect::<Vec<_>>().join(", "),
        ];
        row.extend(mode.branch.map(|number| number.to_string()));
        row
    };
    let mut heads = vec!["Hz", "rad/s", "damping", "s", "energy"];
    if !found.branches.is_empty() {
        heads.push("branch");
    }
    let rows = found.modes.iter().map(row).collect();
    let infinite = match found.n_infinite {
        0 => String::new(),
        n => format!(", {n} more without inertia: infinite"),
    };
    let text = format!(
        "{name}: {}{infinite}, {}{}{}{}\n\n{}",
        counted(found.modes.len(), "mode", "modes"),
        state::about(&found.state, units),
        besides(&found.state, units),
        branches(&found.branches),
        held(&found.held),
        lines(&heads, rows)
    );
    let mode = |mode: &Mode| {
        let shape = found.quantities.iter().zip(&mode.shape);
        let shape = shape.map(|(quantity, value)| (quantity.name.clone(), json!(value)));
        let shares = found.bodies.iter().zip(&mode.shares);
        let shares = shares.map(|(body, share)| (body.clone(), json!(share)));
        json!({
            "s": mode.s,
            "omega": mode.omega,
            "frequency": mode.omega / std::f64::consts::TAU,
            "damping": mode.damping,
            "shape": Value::Object(shape.collect()),
            "shares": Value::Object(shares.collect()),
            "branch": mode.branch,
        })
    };
    let json = json!({
        "modes": found.modes.iter().map(mode).collect::<Vec<_>>(),
        "infinite": found.n_infinite,
        "stability": word(found.stability),
        "state": state::json(&found.state, units),
        "branches": branches_json(&found.branches),
    });
    Answer { command: "modes", json: with_held(json, &found.held), text, table: found.table() }
}
