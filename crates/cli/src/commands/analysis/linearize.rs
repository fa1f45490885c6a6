//! `bksim linearize`: A, B, C and D.

use bksim::analysis::{About, Channels, Linear, linearize};
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked, columns_json, failed, lines, pose_json};
use super::statics::held;
use crate::args::analysis::Linearize as Args;
use crate::args::mode::About as AboutArg;
use crate::exit::{Failure, Status};
use crate::output::number;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    let name = model.name.clone();
    let channels = Channels {
        inputs: args.input.clone(),
        outputs: args.output.clone(),
        states: args.state.clone(),
    };
    let found = linearize(model, about(args.at), &channels).map_err(failed(&source))?;
    Asked::answer(&source, &warnings, file, told(&name, &found), as_json)
}

/// The answer about a model of this name.
pub fn told(name: &str, found: &Linear) -> Answer {
    let table = found.table();
    let rows = found.states.iter().map(|state| format!("d/dt {}", state.name));
    let rows = rows.chain(found.outputs.iter().map(|output| output.name.clone()));
    let line = |(head, row): (String, &Vec<f64>)| {
        std::iter::once(head).chain(row.iter().map(|value| number(*value))).collect()
    };
    let rows = rows.zip(&table.rows).map(line).collect();
    let heads: Vec<&str> =
        std::iter::once("").chain(table.columns.iter().map(|c| c.name.as_str())).collect();
    let poles: Vec<String> = found.poles.iter().map(pole).collect();
    let text = format!(
        "{name}: {} states{}\n\n{}\n\n  poles: {}",
        found.states.len(),
        held(&found.held),
        lines(&heads, rows),
        poles.join(", ")
    );
    let n = found.states.len();
    let (n_in, n_out) = (found.inputs.len(), found.outputs.len());
    let entries = |n_rows: usize, n_columns: usize, at: &dyn Fn(usize, usize) -> f64| -> Value {
        let row = |i: usize| (0..n_columns).map(|j| at(i, j)).collect::<Vec<f64>>();
        (0..n_rows).map(row).collect::<Vec<_>>().into()
    };
    let json = json!({
        "states": columns_json(&found.states),
        "inputs": found.inputs,
        "outputs": columns_json(&found.outputs),
        "A": entries(n, n, &|i, j| found.a[(i, j)]),
        "B": entries(n, n_in, &|i, j| found.b[(i, j)]),
        "C": entries(n_out, n, &|i, j| found.c[(i, j)]),
        "D": entries(n_out, n_in, &|i, j| found.d[(i, j)]),
        "poles": found.poles,
        "pose": pose_json(&found.pose),
        "held": found.held,
    });
    Answer { command: "linearize", json, text, table }
}

pub(crate) fn about(word: AboutArg) -> About {
    match word {
        AboutArg::Static => About::Static,
        AboutArg::Start => About::Start,
    }
}

/// A complex number, 1/s.
pub(super) fn pole(&[re, im]: &[f64; 2]) -> String {
    if im == 0.0 {
        return number(re);
    }
    let sign = if im < 0.0 { "-" } else { "+" };
    format!("{} {sign} {}i", number(re), number(im.abs()))
}
