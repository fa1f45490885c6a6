//! `bksim static`: equilibria, their stability, the reactions in them.

use bksim::analysis::{
    AnalysisError, Balanced, BearingStop, BranchPoint, Continuation, CrossingBranch, DriveRate,
    Equilibrium, Family, HeldContacts, OpenReactions, PassedStop, PointKind, Range, ReactionBound,
    Statics, WayRates, balanced, compliances, in_words, statics, statics_over,
};
use bksim::model::Model;
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked, failed, lines, pose_json, shown};
use super::state::{branches, branches_json, word};
use crate::args::analysis::Static as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::waiting::waiting;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, mut model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    let name = model.name.clone();
    let failed = failed(&source);
    model.compliances = compliances(&model, &args.compliance.compliance).map_err(&failed)?;
    let answer = if let Some((parameter, values)) = &args.over {
        let range = range(&model, parameter, values).map_err(&failed)?;
        let found = || statics_over(model, (parameter, range), &args.by);
        told_over(&name, &waiting("following equilibria", found).map_err(&failed)?)
    } else if !args.solve.is_empty() {
        let found = || balanced(model, &args.solve, &args.by);
        told_balanced(&name, &waiting("balancing", found).map_err(&failed)?)
    } else {
        let bounds = bounds(&model, &args.bound).map_err(&failed)?;
        let found = || statics(model, &args.by, &bounds);
        told(&name, &waiting("looking for equilibria", found).map_err(&failed)?)
    };
    Asked::answer(&source, &warnings, file, answer, as_json)
}

/// Reads values of a parameter, in its unit.
///
/// # Errors
/// [`AnalysisError`] for an unknown parameter, and for what are no values.
pub fn range(model: &Model, parameter: &str, values: &str) -> Result<Range, AnalysisError> {
    let known = model.parameters.iter().find(|known| known.name == parameter);
    let known = known.ok_or_else(|| AnalysisError::UnknownParameter { name: parameter.into() })?;
    Range::parse(values, &known.unit)
}

/// Bounds of reactions, each by name and values.
///
/// # Errors
/// [`AnalysisError`] for an unknown name, and for what are no values.
pub fn bounds(
    model: &Model,
    written: &[(String, String)],
) -> Result<Vec<ReactionBound>, AnalysisError> {
    written.iter().map(|(name, values)| ReactionBound::parse(model, name, values)).collect()
}

/// The note about stops and friction that hold, and about friction that is left out.
pub(super) fn held(contacts: &HeldContacts) -> String {
    let mut text = String::new();
    if !contacts.rows.is_empty() {
        text.extend(["\n  counted as constraints: ", &contacts.rows.join(", ")]);
    }
    if !contacts.left_out.is_empty() {
        let names = contacts.left_out.join(", ");
        text.extend(["\n  left out, though it may hold poses nearby, too: ", &names]);
    }
    let rates = |drives: &[DriveRate]| {
        let rate = |of: &DriveRate| format!("`{}` at {} {}", of.name, number(of.rate), of.unit);
        drives.iter().map(rate).collect::<Vec<_>>().join(", ")
    };
    if !contacts.steady.is_empty() {
        text.extend([
            "\n  in steady motion with drives at constant rates: ",
            &rates(&contacts.steady),
        ]);
    }
    if !contacts.stopped.is_empty() {
        let names = rates(&contacts.stopped);
        text.extend([
            "\n  held where they are at the start, their rates left out: drives ",
            &names,
        ]);
    }
    text
}

/// The JSON of an answer about rest with contacts and drives that are held or left out.
pub(super) fn with_held(mut json: Value, contacts: &HeldContacts) -> Value {
    let rate = |of: &DriveRate| json!({ "name": of.name, "rate": of.rate, "unit": of.unit });
    let rates = |drives: &[DriveRate]| drives.iter().map(rate).collect::<Vec<_>>();
    json["held"] = json!(contacts.rows);
    json["without"] = json!(contacts.left_out);
    json["steady"] = json!(rates(&contacts.steady));
    json["stopped"] = json!(rates(&contacts.stopped));
    json
}

/// The answer about a model of this name.
pub fn told(name: &str, found: &Statics) -> Answer {
    let by = names(&found.by);
    let row = |e: &Equilibrium| {
        let least = e.stiffness.first().map_or(String::new(), |k| number(*k));
        let what = match e.branches.len() {
            0 => word(e.stability).to_owned(),
            _ => format!("{}, branch point", word(e.stability)),
        };
        // Where no motion is free, there is no position to tell.
        let place = match (found.by.is_empty(), found.is_driven) {
            (false, _) => position(&found.by, e),
            (true, true) => "held by the drives".to_owned(),
            (true, false) => "nothing can move".to_owned(),
        };
        vec![what, least, place, on_stops(e)]
    };
    let mut rows: Vec<_> = found.equilibria.iter().map(row).collect();
    let mut heads = vec!["", "least stiffness", "where", "on"];
    if found.equilibria.iter().all(|e| e.bearing.is_empty()) {
        heads.pop();
        for row in &mut rows {
            row.truncate(heads.len());
        }
    }
    let count = counted(found.equilibria.len(), "equilibrium", "equilibria");
    let whether = if found.is_complete {
        "there are no others on this assembly"
    } else {
        "found by a search, which may miss some"
    };
    let mut text = format!(
        "{name}: {count}, {whether}{}{}{}\n\n{}",
        crossing_start(&found.ways),
        left_out(&found.left_out),
        held(&found.held),
        lines(&heads, rows)
    );
    text.extend(left_out_text(&found.by, &found.left_out));
    for (k, e) in found.equilibria.iter().enumerate().filter(|(_, e)| !e.branches.is_empty()) {
        text.extend([branches_text(k + 1, &e.branches)]);
    }
    for (k, e) in found.equilibria.iter().enumerate() {
        text.extend(e.family.as_ref().map(|family| family_text(k + 1, family)));
    }
    for (k, e) in found.equilibria.iter().enumerate().filter(|(_, e)| e.open.n_self_stresses > 0) {
        text.extend([open_text(k + 1, &e.open)]);
    }
    if found.equilibria.len() <= MOST_REACTIONS {
        let tables = found.equilibria.iter().enumerate();
        text.extend(tables.map(|(k, e)| reactions_text(k + 1, &found.joints, e)));
    } else {
        text.push_str("\n\n  -o FILE.csv has the reactions in them");
    }
    let equilibria = found.equilibria.iter().map(|e| equilibrium_json(&found.joints, e));
    let left_out = found.left_out.iter().map(|e| equilibrium_json(&found.joints, e));
    let json = json!({
        "by": by,
        "complete": found.is_complete,
        "branches": branches_json(&found.ways),
        "equilibria": equilibria.collect::<Vec<_>>(),
        "left_out": left_out.collect::<Vec<_>>(),
    });
    Answer { command: "static", json: with_held(json, &found.held), text, table: found.table() }
}

/// Equilibria whose reactions are printed.
const MOST_REACTIONS: usize = 3;
/// A component below this part of the largest one is rounding, forces in N and moments in N m.
const ROUNDING: f64 = 1e-12;

/// The reactions of all joints in an equilibrium, without components that are zero throughout.
fn reactions_text(number: usize, joints: &[String], e: &Equilibrium) -> String {
    let names = ["fx", "fy", "fz", "mx", "my", "mz"];
    let size = |k: usize| e.reactions.iter().map(|r| r[k].abs()).fold(0.0, f64::max);
    let largest = (0..6).map(size).fold(0.0, f64::max);
    let is_rounding = |x: f64| x.abs() <= ROUNDING * largest;
    let kept: Vec<usize> = (0..6).filter(|&k| !is_rounding(size(k))).collect();
    if kept.is_empty() {
        return String::new();
    }
    let row = |(joint, r): (&String, &[f64; 6])| {
        let cell = |&k: &usize| {
            let value = if is_rounding(r[k]) { 0.0 } else { r[k] };
            shown(value, if k < 3 { "N" } else { "N*m" })
        };
        std::iter::once(joint.clone()).chain(kept.iter().map(cell)).collect()
    };
    let rows = joints.iter().zip(&e.reactions).map(row).collect();
    let heads: Vec<&str> = std::iter::once("").chain(kept.iter().map(|&k| names[k])).collect();
    format!(
        "\n\nreactions in equilibrium {number}, on the second bodies of joints\n{}",
        lines(&heads, rows)
    )
}

/// The note that branches cross in the start.
fn crossing_start(ways: &[WayRates]) -> String {
    if ways.is_empty() {
        return String::new();
    }
    format!("\n  the start is a branch point, and every branch is followed{}", branches(ways))
}

/// Stability by each of the branches that cross in an equilibrium.
fn branches_text(number: usize, branches: &[CrossingBranch]) -> String {
    let row = |(k, branch): (usize, &CrossingBranch)| {
        let by = branch.rates.first().map_or("", |(name, ..)| name.as_str());
        vec![
            (k + 1).to_string(),
            word(branch.stability).to_owned(),
            self::number(branch.stiffness),
            by.to_owned(),
            in_words(&branch.rates),
        ]
    };
    let rows = branches.iter().enumerate().map(row).collect();
    format!(
        "\n\nequilibrium {number} is a branch point\n{}",
        lines(&["branch", "", "stiffness", "by", "rates of joints"], rows)
    )
}

/// The stops that are closed in an equilibrium, with what they bear.
fn on_stops(e: &Equilibrium) -> String {
    let on = |stop: &BearingStop| {
        let (name, limit) = (&stop.name, stop.limit);
        match stop.effort {
            effort if effort < 0.0 => format!("stop `{name}` ({limit}), which would have to pull"),
            effort => format!("stop `{name}` ({limit}), which bears {}", shown(effort, stop.unit)),
        }
    };
    e.bearing.iter().map(on).collect::<Vec<_>>().join(", ")
}

/// The stops that a pose lies beyond.
fn beyond(e: &Equilibrium) -> String {
    let beyond = |stop: &PassedStop| format!("stop `{}` ({})", stop.name, stop.limit);
    e.beyond.iter().map(beyond).collect::<Vec<_>>().join(", ")
}

/// The note about poses in balance that are no equilibria.
fn left_out(poses: &[Equilibrium]) -> String {
    let mut stops: Vec<String> = Vec::new();
    for stop in poses.iter().flat_map(|e| &e.beyond) {
        let name = format!("`{}`", stop.name);
        if !stops.contains(&name) {
            stops.push(name);
        }
    }
    let before = match stops.as_slice() {
        [] => return String::new(),
        [stop] => format!("stop {stop} lies"),
        stops => format!("stops {} lie", stops.join(", ")),
    };
    let count = counted(poses.len(), "pose in balance is", "poses in balance are");
    format!(
        "\n  {count} left out: {before} before {}",
        if poses.len() == 1 { "it" } else { "them" }
    )
}

/// These poses in a table.
fn left_out_text(by: &[(String, &'static str)], poses: &[Equilibrium]) -> Option<String> {
    let row = |e: &Equilibrium| vec![position(by, e), beyond(e)];
    let rows = poses.iter().map(row).collect();
    (!poses.is_empty()).then(|| format!("\n\n{}", lines(&["left out", "beyond"], rows)))
}

fn names<'a>(by: &'a [(String, &'static str)]) -> Vec<&'a str> {
    by.iter().map(|(name, _)| name.as_str()).collect()
}

/// Where an equilibrium is, by its independent quantities.
fn position(by: &[(String, &'static str)], e: &Equilibrium) -> String {
    let value = |name: &str| e.pose.iter().find(|(known, ..)| known == name);
    let shown =
        by.iter().filter_map(|(name, _)| value(name)).map(|(name, value, unit)| match &e.family {
            Some(family) if family.free.contains(name) => format!("{name} free"),
            _ => format!("{name} = {}", shown(*value, unit)),
        });
    shown.collect::<Vec<_>>().join(", ")
}

fn equilibrium_json(joints: &[String], e: &Equilibrium) -> Value {
    let reactions = joints.iter().zip(&e.reactions);
    let reactions =
        reactions.map(|(joint, r)| (joint.clone(), json!({ "force": r[..3], "moment": r[3..] })));
    json!({
        "stability": word(e.stability),
        "stiffness": e.stiffness,
        "family": e.family.as_ref().map(|family| {
            json!({ "dimension": family.dimension, "moves": family.moves, "free": family.free })
        }),
        "branches": e.branches.iter().map(|branch| {
            json!({
                "stability": word(branch.stability),
                "stiffness": branch.stiffness,
                "rates": branches_json(std::slice::from_ref(&branch.rates))[0],
            })
        }).collect::<Vec<_>>(),
        "bearing": e.bearing.iter().map(|stop| {
            json!({ "stop": stop.name, "limit": stop.limit, "effort": stop.effort, "unit": stop.unit })
        }).collect::<Vec<_>>(),
        "beyond": e.beyond.iter().map(|stop| {
            json!({ "stop": stop.name, "limit": stop.limit, "depth": stop.depth, "unit": stop.unit })
        }).collect::<Vec<_>>(),
        "pose": pose_json(&e.pose),
        "multipliers": e.lambda,
        "open": open_json(&e.open),
        "reactions": Value::Object(reactions.collect()),
    })
}

/// A family of equilibria in a line.
fn family_text(number: usize, family: &Family) -> String {
    let moves: Vec<String> = family.moves.iter().map(|name| format!("`{name}`")).collect();
    let kind = match family.dimension {
        1 => "a curve of equilibria, along which".to_owned(),
        n => format!("a family of equilibria in {n} dimensions, along which"),
    };
    let change = if moves.len() == 1 { "changes" } else { "change" };
    format!("\n\nequilibrium {number} is one of {kind} {} {change}", moves.join(", "))
}

/// The reactions that equilibrium leaves open, as a table.
fn open_text(number: usize, open: &OpenReactions) -> String {
    let end = |value: f64, unit: &str| match value {
        _ if value.is_nan() => "none".to_owned(),
        f64::INFINITY | f64::NEG_INFINITY => "no bound".to_owned(),
        value => shown(value, unit),
    };
    let row = |c: &bksim::analysis::OpenComponent| {
        let [least, most] = c.range.map(|value| end(value, &c.unit));
        vec![c.name.clone(), shown(c.value, &c.unit), least, most]
    };
    let rows = open.components.iter().map(row).collect();
    let whether = if open.is_possible { "" } else { "; nothing keeps to the bounds" };
    format!(
        "\n\nequilibrium {number}: reactions that balance leaves open in {}{whether}\n{}",
        counted(open.n_self_stresses, "way", "ways"),
        lines(&["", "shown", "least", "most"], rows)
    )
}

fn open_json(open: &OpenReactions) -> Value {
    let component = |c: &bksim::analysis::OpenComponent| {
        json!({
            "name": c.name,
            "unit": c.unit,
            "value": c.value,
            "parts": c.parts,
            "least": c.range[0],
            "most": c.range[1],
        })
    };
    json!({
        "self_stresses": open.n_self_stresses,
        "possible": open.is_possible,
        "components": open.components.iter().map(component).collect::<Vec<_>>(),
    })
}

fn kind_word(kind: PointKind) -> &'static str {
    match kind {
        PointKind::Value => "value",
        PointKind::Limit => "limit",
        PointKind::Crossing => "branch-point",
        PointKind::End => "end",
    }
}

/// The answer about a model of this name, over a parameter.
pub fn told_over(name: &str, found: &Continuation) -> Answer {
    let parameter = &found.parameter;
    let points = || found.branches.iter().flat_map(|branch| &branch.points);
    let count = |kind: PointKind| {
        let mut names: Vec<_> =
            points().filter(|point| point.kind == kind).map(|point| &point.name).collect();
        names.sort_unstable();
        names.dedup();
        names.len()
    };
    let mut text = format!(
        "{name}: {} of equilibria over `{}`, {}, {}{}",
        counted(found.branches.len(), "branch", "branches"),
        parameter.name,
        counted(count(PointKind::Limit), "limit point", "limit points"),
        counted(count(PointKind::Crossing), "branch point", "branch points"),
        held(&found.held)
    );
    for (k, branch) in found.branches.iter().enumerate() {
        let row = |point: &BranchPoint| {
            let what = match (point.kind, &point.name) {
                (PointKind::Limit, Some(name)) => format!("limit point {name}"),
                (PointKind::Crossing, Some(name)) => format!("branch point {name}"),
                (PointKind::End, _) => "lost".to_owned(),
                _ => word(point.equilibrium.stability).to_owned(),
            };
            let what = match beyond(&point.equilibrium) {
                stops if stops.is_empty() => what,
                stops => format!("{what}, beyond {stops}"),
            };
            let least = point.equilibrium.stiffness.first().map_or(String::new(), |k| number(*k));
            let value = shown(point.value, &parameter.unit);
            vec![value, what, least, position(&found.by, &point.equilibrium)]
        };
        let rows = branch.points.iter().map(row).collect();
        let closed = if branch.is_closed { ", closed" } else { "" };
        let heads = [parameter.name.as_str(), "", "least stiffness", "where"];
        text.extend([format!("\n\nbranch {}{closed}\n{}", k + 1, lines(&heads, rows))]);
    }
    let branches = found.branches.iter().map(|branch| {
        let point = |point: &BranchPoint| {
            json!({
                "kind": kind_word(point.kind),
                "name": point.name,
                "value": point.value,
                "equilibrium": equilibrium_json(&found.joints, &point.equilibrium),
            })
        };
        json!({
            "closed": branch.is_closed,
            "points": branch.points.iter().map(point).collect::<Vec<_>>(),
        })
    });
    let json = json!({
        "parameter": { "name": parameter.name, "unit": parameter.unit },
        "by": names(&found.by),
        "branches": branches.collect::<Vec<_>>(),
    });
    Answer { command: "static", json: with_held(json, &found.held), text, table: found.table() }
}

/// The answer about a model of this name, balanced.
pub fn told_balanced(name: &str, found: &Balanced) -> Answer {
    let values = found.values.iter().map(|(column, value, own)| {
        vec![column.name.clone(), shown(*value, &column.unit), shown(*own, &column.unit)]
    });
    let text = format!(
        "{name}: balanced at the start, {}{}\n\n{}",
        word(found.equilibrium.stability),
        held(&found.held),
        lines(&["parameter", "balanced with", "has"], values.collect())
    );
    let values = found.values.iter().map(|(column, value, own)| {
        json!({ "name": column.name, "unit": column.unit, "value": value, "own": own })
    });
    let json = json!({
        "by": names(&found.by),
        "values": values.collect::<Vec<_>>(),
        "equilibrium": equilibrium_json(&found.joints, &found.equilibrium),
    });
    Answer { command: "static", json: with_held(json, &found.held), text, table: found.table() }
}
