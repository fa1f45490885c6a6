//! Examples with machine elements: the time of a step, and how many events a second has room for.
//!
//! A run is timed from the compiled equations to its last sample. Events are the changes of modes: kinks of tables, laws
//! and conditions, hits, and friction that sticks or slides. Each run has to be faster than the machine.

use bksim::Mechanism;
use bksim::model::file::{Limits, expand};
use serde_json::json;

use crate::context::Context;
use crate::error::BenchError;
use crate::models;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::repeat;

/// Examples, with their elements.
const EXAMPLES: [(&str, &str); 10] = [
    ("four-bar", "none"),
    ("differential", "bevel gears"),
    ("belt-drive", "belt with an idler"),
    ("pump-jack", "gear"),
    ("screw-jack", "thread with friction"),
    ("cam", "profile, friction"),
    ("engine", "tables of the gas"),
    ("valve-train", "law of a cam, contact that lifts off"),
    ("winch", "motor, sampled controller, gear"),
    ("eccentric-press", "induction motor, clutch, brake"),
];

/// Measures all examples.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("elements", "Machine elements: steps and events");
    let mut table =
        Table::new(["example", "elements", "steps", "events", "run", "a step", "events a second"]);
    for (name, elements) in EXAMPLES {
        let mechanism = derived(name)?;
        let refused = |e: String| BenchError::Model { name: name.to_owned(), message: e };
        let motion = mechanism.solve().map_err(|e| refused(e.to_string()))?;
        let (n_step, n_events) = (motion.summary.stats.n_step, motion.summary.changes.len());
        let run = repeat(context.effort, || (), |()| mechanism.solve()).minimum();
        let (step, rate) = (run / n_step as f64, n_events as f64 / run);
        let span = mechanism.model.solve.t_end - mechanism.model.solve.t_start;
        table.push([
            name.to_owned(),
            elements.to_owned(),
            n_step.to_string(),
            n_events.to_string(),
            seconds(run),
            seconds(step),
            if n_events == 0 { "-".to_owned() } else { ratio(rate) },
        ]);
        report.checks.push(Check::at_most(
            format!("{name}, time over that of the machine"),
            run / span,
            1.0,
        ));
        report.numbers.insert(
            name.to_owned(),
            json!({ "n_step": n_step, "n_events": n_events, "run_s": run, "step_s": step }),
        );
    }
    report.tables.push(table);
    Ok(report)
}

/// An example with the parts that it uses.
fn derived(name: &str) -> Result<Mechanism, BenchError> {
    let folder = format!("{}/../../examples/{name}", env!("CARGO_MANIFEST_DIR"));
    let path = format!("{folder}/model.toml");
    let text = std::fs::read_to_string(&path);
    let text = text.map_err(|source| BenchError::io(path.as_ref(), source))?;
    let mut open =
        |file: &str| std::fs::read(format!("{folder}/{file}")).map_err(|e| e.to_string());
    let whole = expand("model.toml", &text, Limits::default(), &mut open);
    let model = models::model(whole.as_ref().map_or(&text, |whole| &whole.text), name)?;
    let refused = |message: String| BenchError::Model { name: name.to_owned(), message };
    Mechanism::derive(model, Vec::new()).map_err(|e| refused(e.to_string()))
}
