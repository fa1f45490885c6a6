//! `bksim kinematics`: positions with their rates over a range, limits, assemblies.

use bksim::analysis::{
    AnalysisError, Drive, Dyad, Extreme, Kinematics, LimitsRequest, Prescribed, Proof, Range, Root,
    Table, Triad, assemblies, kinematics, limits, quantity,
};
use bksim::model::Model;
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked_geometry, failed, lines, pose_json, shown, table_json};
use crate::args::analysis::Kinematics as Args;
use crate::exit::{Failure, Status};
use crate::output::number;
use crate::render;

const COMMAND: &str = "kinematics";

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, model, warnings, file) =
        asked_geometry(&args.model, &args.table, nesting)?.parts();
    let failed = failed(&source);
    let name = model.name.clone();
    let answer = if args.assemblies {
        told_assemblies(&name, &assemblies(model).map_err(&failed)?)
    } else if args.limits {
        let request = LimitsRequest {
            drive: args.drive.first().map(|(name, _)| name.clone()),
            outputs: args.of.clone(),
            all_assemblies: args.all,
        };
        told_limits(&name, &limits(model, &request).map_err(&failed)?)
    } else {
        let rates = [args.rate.as_slice(), &args.acceleration];
        let prescribed = prescribed(&model, &args.drive, rates, args.through).map_err(&failed)?;
        let Some(prescribed) = prescribed else {
            let help =
                "write `--drive crank.angle=\"0:360 deg:361\"`, `--limits` or `--assemblies`";
            return Err(Failure::usage("nothing is asked for", help));
        };
        let found = kinematics(model, &prescribed).map_err(&failed)?;
        if let Some(at) = &found.stopped {
            let at: Vec<String> = at.iter().map(|value| number(*value)).collect();
            let values = at.join(", ");
            render::warning(&format!("the range goes no further than {values} (SI): a dead point"));
        }
        told_range(&name, &found)
    };
    Asked::answer(&source, &warnings, file, answer, as_json)
}

/// Reads the motion that is prescribed, if any: drives with their ranges, their rates and accelerations, and
/// whether they go on through dead points.
///
/// # Errors
/// [`AnalysisError`] for measures that the model has not, and for what are no values.
pub fn prescribed(
    model: &Model,
    drive: &[(String, String)],
    [rates, accelerations]: [&[String]; 2],
    through: bool,
) -> Result<Option<Prescribed>, AnalysisError> {
    if let [(name, times)] = drive
        && name == "t"
    {
        return Ok(Some(Prescribed::Times(Range::parse(times, "s")?)));
    }
    let mut drives = Vec::new();
    for (k, (name, values)) in drive.iter().enumerate() {
        let (rate, acceleration) = (rates.get(k), accelerations.get(k));
        let mut drive = Drive::parse(model, name, values)?;
        let unit = drive.measure.unit(model);
        if let Some(rate) = rate {
            drive.rate = quantity(rate, &format!("{unit}/s"))?;
        }
        if let Some(acceleration) = acceleration {
            drive.acceleration = quantity(acceleration, &format!("{unit}/s^2"))?;
        }
        drives.push(drive);
    }
    Ok((!drives.is_empty()).then_some(Prescribed::Drives { drives, through }))
}

fn extreme_json(extreme: &Extreme) -> Value {
    let pose = extreme.pose.iter().map(|(name, value)| (name.clone(), json!(value)));
    json!({
        "name": extreme.name,
        "kind": if extreme.is_maximum { "max" } else { "min" },
        "value": extreme.value,
        "pose": Value::Object(pose.collect()),
    })
}

fn extreme_row(extreme: &Extreme) -> Vec<String> {
    let kind = if extreme.is_maximum { "largest" } else { "smallest" };
    let unit = if is_angle(&extreme.name) { "rad" } else { "m" };
    let first = extreme.pose.first();
    let first = first.map_or(String::new(), |(name, value)| {
        format!("{name} = {}", shown(*value, if is_angle(name) { "rad" } else { "m" }))
    });
    vec![extreme.name.clone(), kind.to_owned(), shown(extreme.value, unit), first]
}

fn is_angle(name: &str) -> bool {
    name.contains(".angle") || name.starts_with("transmission")
}

/// The answer about a model of this name: over a range.
pub fn told_range(name: &str, found: &Kinematics) -> Answer {
    let n = found.table.rows.len();
    let mut text = format!("{name}: {n} positions with their rates");
    if !found.limits.is_empty() {
        let rows = found.limits.iter().map(extreme_row).collect();
        text.extend([format!("\n\n{}", lines(&["limit position", "", "value", "where"], rows))]);
    }
    let json = json!({
        "table": table_json(&found.table),
        "limits": found.limits.iter().map(extreme_json).collect::<Vec<_>>(),
        "stopped": found.stopped,
    });
    Answer { command: COMMAND, json, text, table: found.table.clone() }
}

/// The answer about a model of this name: the ways in which it closes.
pub fn told_assemblies(name: &str, found: &bksim::analysis::Assemblies) -> Answer {
    let held: Vec<String> = found
        .held
        .iter()
        .map(|(name, value, unit)| format!("{name} = {}", shown(*value, unit)))
        .collect();
    let row = |a: &bksim::analysis::Assembly| vec![a.number.to_string(), a.name.clone()];
    let rows = found.assemblies.iter().map(row).collect();
    let text = format!(
        "{name}: {} assemblies{}{}\n\n{}",
        found.assemblies.len(),
        if found.proof.is_some() { ", all there are" } else { " found" },
        if held.is_empty() {
            " as it stands".to_owned()
        } else {
            format!(" at {}", held.join(", "))
        },
        lines(&["number", "name"], rows)
    );
    let assemblies = found
        .assemblies
        .iter()
        .map(|a| json!({ "number": a.number, "name": a.name, "pose": pose_json(&a.pose) }));
    let held = found.held.iter().map(|(name, value, _)| (name.clone(), json!(value)));
    let json = json!({
        "held": Value::Object(held.collect()),
        "assemblies": assemblies.collect::<Vec<_>>(),
        "proof": found.proof.as_ref().map(proof_json),
    });
    let mut table = Table::default();
    if let Some(first) = found.assemblies.first() {
        let heads = first
            .pose
            .iter()
            .map(|(name, _, unit)| bksim::analysis::Column::new(name.clone(), *unit));
        table.columns =
            std::iter::once(bksim::analysis::Column::new("number", "")).chain(heads).collect();
    }
    #[expect(clippy::cast_precision_loss, reason = "assemblies are few")]
    let numbers = |a: &bksim::analysis::Assembly| {
        std::iter::once(a.number as f64).chain(a.pose.iter().map(|(_, value, _)| *value)).collect()
    };
    table.rows = found.assemblies.iter().map(numbers).collect();
    Answer { command: COMMAND, json, text, table }
}

/// The groups that a linkage comes apart into, and how far each is from a pose in which another number of ways closes.
fn proof_json(proof: &Proof) -> Value {
    let dyad =
        |dyad: &Dyad| json!({ "kind": dyad.kind, "bodies": dyad.bodies, "joints": dyad.joints });
    let root = |root: &Root| json!({ "root": [root.re, root.im], "radius": root.radius, "assembly": root.is_assembly });
    let triad = |triad: &Triad| {
        let solved = triad.solved.iter().map(|roots| roots.iter().map(root).collect::<Vec<_>>());
        json!({
            "platform": triad.platform,
            "legs": triad.legs,
            "kinds": triad.kinds,
            "joints": triad.joints,
            "roots": solved.collect::<Vec<_>>(),
        })
    };
    json!({
        "dyads": proof.dyads.iter().map(dyad).collect::<Vec<_>>(),
        "triads": proof.triads.iter().map(triad).collect::<Vec<_>>(),
        "n": proof.n,
        "redundant": proof.n_redundant,
        "margin": if proof.margin.is_finite() { json!(proof.margin) } else { Value::Null },
        "refuted_by": proof.refuted_by,
    })
}

/// The answer about a model of this name: its limits.
pub fn told_limits(name: &str, found: &bksim::analysis::Limits) -> Answer {
    let mut text = format!("{name}: limits");
    let mut branches = Vec::new();
    let mut table = Table::default();
    for branch in &found.branches {
        // Ranges of joints, bodies, transmission angles; then where they turn back.
        let row = |r: &bksim::analysis::RangeOf| {
            let [min, max] = [r.min, r.max].map(|value| shown(value, r.unit));
            if r.turns {
                vec![r.name.clone(), "turns round".to_owned(), String::new()]
            } else {
                vec![r.name.clone(), min, max]
            }
        };
        let rows = branch.ranges.iter().map(row).collect();
        text.extend([format!("\n\n{}", lines(&["range", "smallest", "largest"], rows))]);
        let rows = branch.extremes.iter().map(extreme_row).collect();
        text.extend([format!("\n\n{}", lines(&["limit position", "", "value", "where"], rows))]);
        for output in &branch.outputs {
            if let Some(ratio) = output.time_ratio {
                text.extend([format!("\n\n  time ratio of {}: {}", output.name, number(ratio))]);
            }
        }
        let range = |r: &bksim::analysis::RangeOf| json!({ "name": r.name, "unit": r.unit, "min": r.min, "max": r.max, "turns": r.turns });
        let output = |o: &bksim::analysis::OutputLimits| {
            let fastest = o.fastest.iter().map(|[drive, value, rate]| {
                json!({ "drive": drive, "value": value, "rate_per_drive_rate": rate })
            });
            json!({
                "name": o.name,
                "time_ratio": o.time_ratio,
                "fastest": fastest.collect::<Vec<_>>(),
            })
        };
        branches.push(json!({
            "closed": branch.is_closed,
            "ranges": branch.ranges.iter().map(range).collect::<Vec<_>>(),
            "extremes": branch.extremes.iter().map(extreme_json).collect::<Vec<_>>(),
            "outputs": branch.outputs.iter().map(output).collect::<Vec<_>>(),
        }));
        if table.columns.is_empty()
            && let Some(first) = branch.extremes.first()
        {
            let unit = |name: &str| if is_angle(name) { "rad" } else { "m" };
            let heads = first.pose.iter();
            table.columns = heads
                .map(|(name, _)| bksim::analysis::Column::new(name.clone(), unit(name)))
                .collect();
        }
        let poses =
            branch.extremes.iter().map(|e| e.pose.iter().map(|(_, value)| *value).collect());
        table.rows.extend(poses);
    }
    Answer { command: COMMAND, json: json!({ "branches": branches }), text, table }
}
