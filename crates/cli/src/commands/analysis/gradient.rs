//! `bksim gradient`: one number of a run by many parameters and initial values.

use bksim::analysis::{Derivative, GradientRequest, LeftOut, MotionGradient, Watch, gradient};
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked, failed, lines, text_units};
use crate::args::analysis::Gradient as Args;
use crate::commands::solve::changes;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::progress::StopWish;
use crate::waiting::searching;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, mut model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    let solve = &mut model.solve;
    changes(&args.tuning, solve.t_start)?.apply(solve);
    let [t_start, t_end] = [solve.t_start, solve.t_end];
    let stop = StopWish::watch().map_err(|e| Failure::reading(&args.model.model, &e))?;
    let request =
        GradientRequest { of: args.of.clone(), take: args.value.into(), by: args.by.clone() };
    let name = model.name.clone();
    let found = searching("differentiating", |word| {
        let reached = |run: &str, t: f64| {
            word.reached(&format!("{run}, t = {t:.4} s"), (t - t_start) / (t_end - t_start));
        };
        let watch = Watch { reached: &reached, stop: &|| stop.status().is_some() };
        gradient(model, &request, watch).map_err(failed(&source))
    });
    let Some(found) = found? else { return Ok(stop.status().unwrap_or(Status::Interrupted)) };
    let Answer { command, json, text, .. } = told(&name, &found);
    let content = file.map(|file| {
        let summary = counted(found.by.len(), "row", "rows");
        (file, found.csv().into_bytes(), summary)
    });
    Asked::told(&source, &warnings, content, (command, json, text), as_json)
}

/// The answer about a model of this name.
pub fn told(name: &str, found: &MotionGradient) -> Answer {
    Answer {
        command: "gradient",
        json: told_json(found),
        text: text(name, found),
        table: found.table(),
    }
}

fn text(name: &str, found: &MotionGradient) -> String {
    let goal = &found.of;
    let row = |one: &&Derivative| {
        vec![
            one.by.name.clone(),
            in_unit(one.value, &one.by.unit),
            derivative(one, &goal.unit),
            in_unit(one.by_percent(), &goal.unit),
        ]
    };
    let rows = found.by_weight().iter().map(row).collect();
    let left_out = |one: &LeftOut| format!("  left out: `{}`, as {}\n", one.name, one.why);
    let left_out = found.left_out.iter().map(left_out).collect::<Vec<_>>().concat();
    format!(
        "{name}: {} of {} = {}\n\n{}\n\n{left_out}  steps: {} forward, {} back",
        found.take.word(),
        goal.name,
        in_unit(found.value, &goal.unit),
        lines(&["by", "value", "derivative", "by 1 %"], rows),
        found.n_steps,
        found.n_steps_back
    )
}

/// A number in the units of the text; radians, where no other unit of angles is asked for, as they are: derivatives are
/// by them.
fn in_unit(value: f64, unit: &str) -> String {
    let own = text_units().of(unit);
    let value = number(own.of_si(value));
    if own.unit.is_empty() { value } else { format!("{value} {}", own.unit) }
}

/// A derivative in the units of the text, of the goal and of what it is by.
fn derivative(one: &Derivative, goal: &str) -> String {
    let units = text_units();
    let (of, by) = (units.of(goal), units.of(&one.by.unit));
    if (of.unit.as_str(), by.unit.as_str()) == (goal, one.by.unit.as_str()) {
        return in_unit(one.derivative, &one.unit);
    }
    let unit = match (of.unit.as_str(), by.unit.as_str()) {
        (of, "") => of.to_owned(),
        ("", by) => format!("1/({by})"),
        (of, by) if by.contains(['/', '*', ' ']) => format!("{of}/({by})"),
        (of, by) => format!("{of}/{by}"),
    };
    format!("{} {unit}", number(one.derivative * of.of_si(1.0) / by.of_si(1.0)))
}

fn told_json(found: &MotionGradient) -> Value {
    let derivative = |one: &Derivative| {
        json!({
            "name": one.by.name,
            "value": one.value,
            "unit": one.by.unit,
            "derivative": one.derivative,
            "derivative_unit": one.unit,
            "by_percent": one.by_percent(),
        })
    };
    let left_out = |one: &LeftOut| json!({ "name": one.name, "why": one.why });
    json!({
        "goal": {
            "name": found.of.name,
            "unit": found.of.unit,
            "take": found.take.word(),
            "value": found.value,
        },
        "gradient": found.by.iter().map(derivative).collect::<Vec<_>>(),
        "left_out": found.left_out.iter().map(left_out).collect::<Vec<_>>(),
        "steps": { "forward": found.n_steps, "back": found.n_steps_back },
    })
}
