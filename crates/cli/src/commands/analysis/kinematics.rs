//! `bksim kinematics`: positions with their rates over a range, limits, assemblies.

use bksim::analysis::{
    AnalysisError, Closing, Drive, Dyad, Kinematics, KinematicsOptions, Larger, LimitsRequest,
    Platform, Prescribed, Proof, Range, Root, Solution, StudyPoint, Table, Triad, assemblies,
    assembly_panels, closing, kinematics_along, limits, quantity, range_like_degrees,
};
use bksim::expr::PoolSnapshot;
use bksim::model::Model;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::ShownUnit;
use bksim::sim::fault::another_assembly;
use serde_json::{Value, json};

use super::answer::{
    Answer, Asked, Draw, asked_drawn, beyond, failed, lines, pose_json, shown, table_json,
};
use super::limits::{extreme_json, extreme_row, told_limits};
use crate::args::analysis::Kinematics as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::render;
use crate::source::load_geometry;
use crate::waiting::waiting;

const COMMAND: &str = "kinematics";

/// The search for assemblies, for those who wait.
const CLOSING: &str = "looking for assemblies";

/// Asks, writes the table or what `draw` makes of the assemblies, and prints the answer.
///
/// # Errors
/// [`Failure`] when there is no answer, or the file cannot be written.
pub fn run(
    args: &Args,
    draw: Option<Draw<'_>>,
    as_json: bool,
    nesting: usize,
) -> Result<Status, Failure> {
    let (source, model, mut warnings, file) =
        asked_drawn(&args.model, &args.table, draw.is_some(), || {
            load_geometry(&args.model, nesting)
        })?
        .parts();
    let failed = failed(&source);
    let name = model.name.clone();
    let mut picture = None;
    let answer = if let (true, Some(draw)) = (args.assemblies, draw) {
        let found = waiting(CLOSING, || assembly_panels(model));
        let (found, panels) = found.map_err(&failed)?;
        picture =
            Some((draw(&name, &panels)?, counted(panels.panels.len(), "assembly", "assemblies")));
        told_assemblies(&name, &found)
    } else if args.assemblies {
        told_assemblies(&name, &waiting(CLOSING, || assemblies(model)).map_err(&failed)?)
    } else if !args.solve.is_empty() {
        let found = waiting(CLOSING, || closing(model, &args.solve));
        told_closing(&name, &found.map_err(&failed)?)
    } else if args.limits {
        let request = LimitsRequest {
            drive: args.drive.first().map(|(name, _)| name.clone()),
            outputs: args.of.clone(),
            all_assemblies: args.all,
        };
        let found = waiting("looking for limits", || limits(model, &request));
        told_limits(&name, &found.map_err(&failed)?)
    } else {
        if let Some((name, _)) = args.drive.iter().find(|(_, values)| values.is_empty()) {
            let help = format!(
                "write where it goes, such as `--drive {name}=\"0:360 deg:361\"` or, of lengths, `=\"0:50 mm:51\"`"
            );
            return Err(Failure::usage(format!("`--drive {name}` has no values"), &help));
        }
        let rates = [args.rate.as_slice(), &args.acceleration];
        let prescribed = prescribed(&model, &args.drive, rates, args.through).map_err(&failed)?;
        let of_model = model.assembly.is_some().then(|| model.snapshot());
        let Some(prescribed) = prescribed else {
            let help = "write `--drive crank.angle=\"0:360 deg:361\"`, `--drive t=\"0:2 s:201\"` for the drives of the model, \
                 `--limits` or `--assemblies`";
            return Err(Failure::usage("nothing is asked for", help));
        };
        without_rates_of_drives(&prescribed, rates)?;
        if let Prescribed::Drives { drives, .. } = &prescribed {
            let named = drives.iter().zip(&args.drive);
            let looks = |(drive, (_, values)): (&Drive, &(String, String))| {
                range_like_degrees(drive, &model, values)
            };
            warnings.extend(named.filter_map(looks));
        }
        let options = KinematicsOptions { branch: args.branch, has_jerk: args.jerk };
        let found = || kinematics_along(model, &prescribed, options);
        let found = waiting("computing positions", found).map_err(&failed)?;
        if let Some(at) = &found.stopped {
            let values = reached(&args.drive, at);
            render::warning(&format!("the range goes no further than {values}: a dead point"));
        }
        warnings.extend(of_model.and_then(|model| passed_over(&model, &args.drive, &found)));
        told_range(&name, found, as_json)
    };
    Asked::drawn(&source, &warnings, (file, picture), answer, as_json)
}

/// Values of the drives where a range ends, each in the unit that it was asked for in.
fn reached(drive: &[(String, String)], at: &[f64]) -> String {
    let value = |((name, asked), value): (&(String, String), &f64)| {
        let own = asked.split(':').rev().find_map(|part| {
            let unit = part.trim_start_matches(|c: char| !c.is_alphabetic());
            ShownUnit::parse(unit).filter(|_| !unit.is_empty())
        });
        match own {
            Some(own) => format!("{name} = {} {}", number(own.of_si(*value)), own.unit),
            None => format!("{name} = {} (SI)", number(*value)),
        }
    };
    drive.iter().zip(at).map(value).collect::<Vec<_>>().join(", ")
}

/// The warning that a range passes over into another assembly than the one that the model holds.
fn passed_over(
    model: &Model<PoolSnapshot>,
    drive: &[(String, String)],
    found: &Kinematics,
) -> Option<Diagnostic> {
    let (name, _) = drive.first()?;
    let unit = if name.ends_with("angle") {
        "rad"
    } else if name == "t" {
        "s"
    } else {
        "m"
    };
    another_assembly(model, &found.changes, |at| format!("{name} = {}", shown(at, unit)))
}

/// Refuses rates next to the drives of the model, which have their own.
///
/// # Errors
/// [`Failure`] where there are some.
pub(super) fn without_rates_of_drives(
    prescribed: &Prescribed,
    rates: [&[String]; 2],
) -> Result<(), Failure> {
    if matches!(prescribed, Prescribed::Drives { .. }) || rates.iter().all(|it| it.is_empty()) {
        return Ok(());
    }
    let message = "the drives of the model have rates of their own";
    Err(Failure::usage(message, "leave out `--rate` and `--acceleration`"))
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

/// The answer about a model of this name: over a range. The object of `--json` repeats the whole table, and stays
/// empty unless it is asked for.
pub fn told_range(name: &str, found: Kinematics, as_json: bool) -> Answer {
    let mut text = match found.table.rows.len() {
        1 => format!("{name}: 1 position with its rates"),
        n => format!("{name}: {n} positions with their rates"),
    };
    text.push_str(&beyond(&found.beyond));
    if !found.limits.is_empty() {
        let rows = found.limits.iter().map(extreme_row).collect();
        text.extend([format!("\n\n{}", lines(&["limit position", "", "value", "where"], rows))]);
    }
    let told = || {
        json!({
            "table": table_json(&found.table),
            "limits": found.limits.iter().map(extreme_json).collect::<Vec<_>>(),
            "stopped": found.stopped,
            "beyond": found.beyond,
        })
    };
    let json = if as_json { told() } else { json!({}) };
    Answer { command: COMMAND, json, text, table: found.table }
}

/// The answer about a model of this name: the values with which its start closes.
pub fn told_closing(name: &str, found: &Closing) -> Answer {
    let rows = found.values.iter().map(|(column, value, own)| {
        // All digits: with fewer the start would not close.
        let closes = format!("{value} {}", column.unit).trim_end().to_owned();
        vec![column.name.clone(), closes, shown(*own, &column.unit)]
    });
    let text = format!(
        "{name}: closes at the values that it states\n\n{}",
        lines(&["parameter", "closes with", "has"], rows.collect())
    );
    let values = found.values.iter().map(|(column, value, own)| {
        json!({ "name": column.name, "unit": column.unit, "value": value, "own": own })
    });
    let json = json!({ "values": values.collect::<Vec<_>>(), "pose": pose_json(&found.pose) });
    Answer { command: COMMAND, json, text, table: found.table() }
}

/// The answer about a model of this name: the ways in which it closes.
pub fn told_assemblies(name: &str, found: &bksim::analysis::Assemblies) -> Answer {
    let held: Vec<String> = found
        .held
        .iter()
        .map(|(name, value, unit)| format!("{name} = {}", shown(*value, unit)))
        .collect();
    let row = |a: &bksim::analysis::Assembly| {
        let is_held = found.held_number == Some(a.number);
        let held = if is_held { "held by `[initial]`" } else { "" };
        vec![a.number.to_string(), a.name.clone(), held.to_owned()]
    };
    let rows = found.assemblies.iter().map(row).collect();
    let all = if found.assemblies.len() == 1 { ", the only one" } else { ", all there are" };
    let text = format!(
        "{name}: {}{}{}\n\n{}",
        counted(found.assemblies.len(), "assembly", "assemblies"),
        if found.proof.is_some() { all } else { " found" },
        if held.is_empty() {
            " as it stands".to_owned()
        } else {
            format!(" at {}", held.join(", "))
        },
        lines(&["number", "name", ""], rows)
    );
    let moving = match found.n_moving {
        0 => String::new(),
        _ => "\n\n  besides, there are poses in which it can still move, and ways without number with them: they are left out"
            .to_owned(),
    };
    let text = text + &moving;
    let assemblies = found
        .assemblies
        .iter()
        .map(|a| json!({ "number": a.number, "name": a.name, "pose": pose_json(&a.pose) }));
    let held = found.held.iter().map(|(name, value, _)| (name.clone(), json!(value)));
    let json = json!({
        "held": Value::Object(held.collect()),
        "assemblies": assemblies.collect::<Vec<_>>(),
        "held_number": found.held_number,
        "moving": found.n_moving,
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
    let solution = |found: &Solution| json!({ "turns": found.turns, "radius": found.radius, "assembly": found.is_assembly });
    let larger = |group: &Larger| {
        let solved = group.solved.iter().map(|all| all.iter().map(solution).collect::<Vec<_>>());
        json!({ "bodies": group.bodies, "bounds": group.bounds, "solutions": solved.collect::<Vec<_>>() })
    };
    let point = |point: &StudyPoint| json!({ "numbers": point.numbers, "radius": point.radius, "assembly": point.is_assembly });
    let platform = |platform: &Platform| {
        json!({
            "bodies": platform.bodies,
            "legs": platform.legs,
            "bound": platform.bound,
            "solutions": platform.solved.iter().map(point).collect::<Vec<_>>(),
        })
    };
    json!({
        "platform": proof.platform.as_ref().map(platform),
        "larger": proof.larger.iter().map(larger).collect::<Vec<_>>(),
        "dyads": proof.dyads.iter().map(dyad).collect::<Vec<_>>(),
        "triads": proof.triads.iter().map(triad).collect::<Vec<_>>(),
        "n": proof.n,
        "redundant": proof.n_redundant,
        "margin": if proof.margin.is_finite() { json!(proof.margin) } else { Value::Null },
        "refuted_by": proof.refuted_by,
    })
}
