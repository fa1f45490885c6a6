//! `bksim linearize`: A, B, C and D.

use bksim::analysis::{Channels, Letters, Linear, letters, linearize};
use bksim::model::file::ShownUnits;
use serde_json::{Value, json};

use super::answer::{
    Answer, Asked, asked_drawn, columns_json, failed, lines, pose_json, text_units,
};
use super::state::{self, besides};
use super::statics::{held, with_held};
use crate::args::analysis::Linearize as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::output_file::check_ending;
use crate::source::load;
use crate::waiting::waiting;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    // Matrices of NumPy and MATLAB, or the table.
    let file = args.table.file.as_deref();
    file.map_or(Ok(()), |path| check_ending(path, &["csv", "npz", "mat"]))?;
    let (source, model, warnings, file) =
        asked_drawn(&args.model, &args.table, true, || load(&args.model, nesting))?.parts();
    let name = model.name.clone();
    let channels = Channels {
        inputs: args.input.clone(),
        outputs: args.output.clone(),
        states: args.state.clone(),
    };
    let twin = args.letters.then(|| model.snapshot());
    let found = waiting("linearizing", || linearize(model, args.at, &channels));
    let found = found.map_err(failed(&source))?;
    let mut answer = told(&name, &text_units(), &found);
    if let Some(twin) = twin {
        let written = || letters(twin.to_model(), &channels);
        let written = waiting("linearizing in letters", written).map_err(failed(&source))?;
        add_letters(&mut answer, written.as_ref());
    }
    let ending = file.as_ref().and_then(|file| file.path().extension()?.to_str());
    let matrices = match ending {
        Some("npz") => Some((found.npz(), "A, B, C, D for NumPy".to_owned())),
        Some("mat") => Some((found.mat(), "A, B, C, D for MATLAB".to_owned())),
        _ => None,
    };
    Asked::drawn(&source, &warnings, (file, matrices), answer, as_json)
}

/// Adds the matrices in letters to an answer; `None` of a mechanism that is too large.
pub fn add_letters(answer: &mut Answer, written: Option<&Letters>) {
    answer.json["letters"] = written.map_or(Value::Null, letters_json);
    answer.text.extend([letters_text(written)]);
}

/// The matrices in letters, entry by entry where one is not zero.
fn letters_text(written: Option<&Letters>) -> String {
    let Some(found) = written else {
        return "\n\n  too large for letters: more than four free motions, or four dependent coordinates".to_owned();
    };
    let mut text = String::from("\n\nin letters, at rest\n");
    for (name, definition) in &found.blocks {
        text.extend([format!("\n  {name} = {definition}")]);
    }
    for (state, (a, b)) in found.states.iter().zip(found.a.iter().zip(&found.b)) {
        let names = found.states.iter().map(|state| &state.name).chain(&found.inputs);
        for (name, entry) in names.zip(a.iter().chain(b)).filter(|(_, entry)| *entry != "0") {
            text.extend([format!("\n  d/dt {} by {name}: {entry}", state.name)]);
        }
    }
    for (output, (c, d)) in found.outputs.iter().zip(found.c.iter().zip(&found.d)) {
        let names = found.states.iter().map(|state| &state.name).chain(&found.inputs);
        for (name, entry) in names.zip(c.iter().chain(d)).filter(|(_, entry)| *entry != "0") {
            text.extend([format!("\n  {} by {name}: {entry}", output.name)]);
        }
    }
    for (letter, value) in &found.pose {
        text.extend([format!("\n  with {letter} = {}", number(*value))]);
    }
    let (n, off) = (found.n_points, number(found.largest_difference));
    text + &format!(
        "\n\n  checked against numbers at {n} random points: largest difference {off} of the largest entry"
    )
}

fn letters_json(found: &Letters) -> Value {
    let pose = found.pose.iter().map(|(letter, value)| (letter.clone(), json!(value)));
    let blocks = found.blocks.iter();
    let blocks = blocks.map(|(name, definition)| json!({ "name": name, "definition": definition }));
    json!({
        "blocks": blocks.collect::<Vec<_>>(),
        "A": found.a,
        "B": found.b,
        "C": found.c,
        "D": found.d,
        "pose": Value::Object(pose.collect()),
        "certificate": { "points": found.n_points, "largest_difference": found.largest_difference },
    })
}

/// The answer about a model of this name, its state in these units.
pub fn told(name: &str, units: &ShownUnits, found: &Linear) -> Answer {
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
        "{name}: {}, {}{}{}\n\n{}\n\n  poles: {}",
        counted(found.states.len(), "state", "states"),
        state::about(&found.state, units),
        besides(&found.state, units),
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
        "state": state::json(&found.state, units),
        "pose": pose_json(&found.pose),
    });
    Answer { command: "linearize", json: with_held(json, &found.held), text, table }
}

/// A complex number, 1/s.
pub(super) fn pole(&[re, im]: &[f64; 2]) -> String {
    if im == 0.0 {
        return number(re);
    }
    let sign = if im < 0.0 { "-" } else { "+" };
    format!("{} {sign} {}i", number(re), number(im.abs()))
}
