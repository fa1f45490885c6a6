//! `bksim bode`: frequency response, poles and zeros.

use bksim::analysis::{AnalysisError, Channels, Frequencies, Range, Response, Transfer, bode};
use bksim::model::file::ShownUnits;
use serde_json::{Value, json};

use super::answer::{
    Answer, Asked, Draw, asked_drawn, columns_json, failed, lines, pose_json, text_units,
};
use super::linearize::pole;
use super::state::{self, besides};
use super::statics::{held, with_held};
use crate::args::analysis::Bode as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::source::load;
use crate::waiting::waiting;

/// Asks, writes the table or what `draw` makes of the response, and prints the answer.
///
/// # Errors
/// [`Failure`] when there is no answer, or the file cannot be written.
pub fn run(
    args: &Args,
    draw: Option<Draw<'_, Response>>,
    as_json: bool,
    nesting: usize,
) -> Result<Status, Failure> {
    let (source, model, warnings, file) =
        asked_drawn(&args.model, &args.table, draw.is_some(), || load(&args.model, nesting))?
            .parts();
    let name = model.name.clone();
    let failed = failed(&source);
    let channels =
        Channels { inputs: args.input.clone(), outputs: args.output.clone(), states: Vec::new() };
    let frequencies = args.omega.as_deref().map(frequencies).transpose().map_err(&failed)?;
    let found = || bode(model, args.at, &channels, frequencies);
    let found = waiting("computing responses", found).map_err(&failed)?;
    let n_curves = counted(2 * found.transfers.len(), "curve", "curves");
    let picture =
        draw.map(|draw| Ok::<_, Failure>((draw(&name, &found)?, n_curves))).transpose()?;
    let answer = told(&name, &text_units(), &found);
    Asked::drawn(&source, &warnings, (file, picture), answer, as_json)
}

/// The answer about a model of this name, its state in these units.
pub fn told(name: &str, units: &ShownUnits, found: &Response) -> Answer {
    Answer {
        command: "bode",
        json: told_json(units, found),
        text: text(name, units, found),
        table: found.table(),
    }
}

/// Reads frequencies in even steps of their logarithm, `0.1:100 rad/s:201` or `0.1:10 Hz:201`.
///
/// # Errors
/// [`AnalysisError::BadRange`] for what is no range, [`AnalysisError::NoFrequencies`] for one that is not above zero.
pub fn frequencies(values: &str) -> Result<Frequencies, AnalysisError> {
    let Range { from, to, n } = Range::parse(values, "rad/s")?;
    if from <= 0.0 || to <= 0.0 {
        return Err(AnalysisError::NoFrequencies { text: values.to_owned() });
    }
    // Hertz are cycles here; as a unit of models they are 1/s.
    let cycle = if values.contains("Hz") { std::f64::consts::TAU } else { 1.0 };
    Ok(Frequencies { from: cycle * from, to: cycle * to, n })
}

fn roots(all: &[[f64; 2]]) -> String {
    if all.is_empty() {
        return "none".to_owned();
    }
    all.iter().map(pole).collect::<Vec<_>>().join(", ")
}

fn text(name: &str, units: &ShownUnits, found: &Response) -> String {
    let rows = |transfer: &Transfer| -> Vec<Vec<String>> {
        let n = found.omega.len();
        // Some frequencies among all.
        let shown = n.min(13);
        let at = |k: usize| k * (n - 1) / (shown - 1).max(1);
        let row = |k: usize| {
            vec![
                number(found.omega[k]),
                number(transfer.gain[k]),
                number(20.0 * transfer.gain[k].log10()),
                number(transfer.phase[k].to_degrees()),
            ]
        };
        (0..shown).map(|k| row(at(k))).collect()
    };
    let mut text = format!(
        "{name}: {}, {}{}{}\n\n  poles: {}",
        counted(found.omega.len(), "frequency", "frequencies"),
        state::about(&found.linear.state, units),
        besides(&found.linear.state, units),
        held(&found.linear.held),
        roots(&found.linear.poles)
    );
    for transfer in &found.transfers {
        let heads = ["rad/s", "gain", "dB", "phase, deg"];
        text.extend([format!(
            "\n\n{} by {}\n  zeros: {}\n{}",
            transfer.output,
            transfer.input,
            roots(&transfer.zeros),
            lines(&heads, rows(transfer))
        )]);
    }
    text
}

fn told_json(units: &ShownUnits, found: &Response) -> Value {
    let transfer = |transfer: &Transfer| {
        json!({
            "input": transfer.input,
            "output": transfer.output,
            "gain": transfer.gain,
            "phase": transfer.phase,
            "zeros": transfer.zeros,
        })
    };
    let json = json!({
        "omega": found.omega,
        "poles": found.linear.poles,
        "outputs": columns_json(&found.linear.outputs),
        "transfers": found.transfers.iter().map(transfer).collect::<Vec<_>>(),
        "state": state::json(&found.linear.state, units),
        "pose": pose_json(&found.linear.pose),
    });
    with_held(json, &found.linear.held)
}
