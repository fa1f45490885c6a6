//! `bksim doctor`: free motions, conditions that repeat others, changes that cure them.

use bksim::analysis::{
    Condition, Count, Cure, Doctor, DriveCheck, FreeMotion, Repeated, SingularPose, Singularity,
    doctor, doctor_panels, singular_poses,
};
use serde_json::{Value, json};

use super::answer::{Answer, Asked, Draw, asked_drawn, failed, lines, shown};
use crate::args::analysis::Doctor as Args;
use crate::exit::{Failure, Status};
use crate::output::counted;
use crate::source::load_geometry;
use crate::waiting::waiting;

/// The work of this command, for those who wait.
const COUNTING: &str = "looking for free motions";

/// Asks, writes the table or what `draw` makes of the motions and conditions, and prints the answer.
///
/// # Errors
/// [`Failure`] when there is no answer, or the file cannot be written.
pub fn run(
    args: &Args,
    draw: Option<Draw<'_>>,
    as_json: bool,
    nesting: usize,
) -> Result<Status, Failure> {
    let (source, model, warnings, file) =
        asked_drawn(&args.model, &args.table, draw.is_some(), || {
            load_geometry(&args.model, nesting)
        })?
        .parts();
    let name = model.name.clone();
    let failed = failed(&source);
    let singular = match &args.drive {
        Some(drive) => {
            let poses = || singular_poses(model.snapshot().to_model(), drive);
            let poses = waiting("looking for singular poses", poses).map_err(&failed)?;
            Some((drive.as_str(), poses))
        }
        None => None,
    };
    let (found, picture) = match draw {
        Some(draw) => {
            let found = waiting(COUNTING, || doctor_panels(model));
            let (found, panels) = found.map_err(&failed)?;
            let n = panels.panels.len();
            (found, Some((draw(&name, &panels)?, counted(n, "picture", "pictures"))))
        }
        None => (waiting(COUNTING, || doctor(model)).map_err(&failed)?, None),
    };
    let singular = singular.as_ref().map(|(drive, poses)| (*drive, poses.as_slice()));
    Asked::drawn(&source, &warnings, (file, picture), told(&name, &found, singular), as_json)
}

/// A drive with the singular poses along it.
pub type AlongDrive<'a> = (&'a str, &'a [SingularPose]);

/// The answer about a model of this name.
pub fn told(name: &str, found: &Doctor, singular: Option<AlongDrive<'_>>) -> Answer {
    let mut json = told_json(found);
    json["singular"] = singular.map(|(_, poses)| singular_json(poses)).into();
    let mut text = text(name, found);
    if let Some(singular) = singular {
        text.push_str(&singular_text(singular));
    }
    Answer { command: "doctor", json, text, table: found.table() }
}

/// Singular poses in words.
fn singular_text((drive, poses): AlongDrive<'_>) -> String {
    if poses.is_empty() {
        return format!("\n\n  no pose is singular for `{drive}`");
    }
    let unit = if drive.ends_with("angle") { "rad" } else { "m" };
    let row = |of: &SingularPose| {
        let kind = match of.kind {
            Singularity::DeadPoint => "it turns back: a dead point",
            Singularity::BranchPoint => "the mechanism can go on in two ways",
        };
        vec![shown(of.drive, unit), kind.to_owned()]
    };
    format!("\n\n{}", lines(&[drive, "singular there"], poses.iter().map(row).collect()))
}

fn singular_json(poses: &[SingularPose]) -> Value {
    let pose = |of: &SingularPose| {
        let kind = match of.kind {
            Singularity::DeadPoint => "dead-point",
            Singularity::BranchPoint => "branch-point",
        };
        let pose = of.pose.iter().map(|(name, value)| (name.clone(), json!(value)));
        json!({ "drive": of.drive, "kind": kind, "pose": Value::Object(pose.collect()) })
    };
    poses.iter().map(pose).collect::<Vec<_>>().into()
}

fn changes(cure: &Cure) -> String {
    let change = |(joint, from, to): &(String, &str, &str)| format!("`{joint}`: {from} -> {to}");
    cure.changes.iter().map(change).collect::<Vec<_>>().join(", ")
}

fn text(name: &str, found: &Doctor) -> String {
    let Count { counted: by_kutzbach, mobility, n_redundant } = found.count;
    // Kutzbach's count, line by line.
    let n_bodies = found.bodies.len();
    let whole = found.freedoms_of_body * i64::try_from(n_bodies).unwrap_or(i64::MAX);
    let bodies = found.bodies.iter().map(|body| format!("`{body}`")).collect::<Vec<_>>().join(", ");
    let mut rows = vec![vec![whole.to_string(), counted(n_bodies, "body", "bodies"), bodies]];
    for (joint, kind, taken) in &found.joints {
        rows.push(vec![format!("-{taken}"), format!("`{joint}`"), (*kind).to_owned()]);
    }
    for coupling in &found.couplings {
        rows.push(vec!["-1".to_owned(), format!("`{coupling}`"), "coupling".to_owned()]);
    }
    let taken: i64 = found.joints.iter().map(|(_, _, taken)| taken).sum();
    let coupled = i64::try_from(found.couplings.len()).unwrap_or_default();
    let turns = whole - taken - coupled - by_kutzbach;
    if turns != 0 {
        rows.push(vec![format!("-{turns}"), "turns".to_owned(), "of particles".to_owned()]);
    }
    rows.push(vec![by_kutzbach.to_string(), "counted".to_owned(), String::new()]);
    rows.push(vec![mobility.to_string(), "true".to_owned(), "free motions".to_owned()]);
    rows.push(vec![
        n_redundant.to_string(),
        "redundant".to_owned(),
        "true less counted".to_owned(),
    ]);
    let mut text = format!(
        "{name}: {}, {}\n\n{}",
        counted(mobility, "free motion", "free motions"),
        counted(n_redundant, "redundant condition", "redundant conditions"),
        lines(&["freedoms", "of", ""], rows)
    );
    if !found.rates.is_empty() {
        let rates = found.rates.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>();
        let note = "\n\n  not counted: what holds between rates alone and leaves positions free: ";
        text.extend([note, &rates.join(", ")]);
    }
    for (k, motion) in found.motions.iter().enumerate() {
        let rate = |(name, rate, unit): &(String, f64, &'static str)| {
            let unit =
                if *unit == "rad" || unit.is_empty() { String::new() } else { format!(" {unit}") };
            vec![name.clone(), format!("{}{unit}", crate::output::number(*rate))]
        };
        let rows = motion.rates.iter().map(rate).collect();
        let end =
            if motion.is_finite { "" } else { ", in this pose alone: it yields but goes nowhere" };
        let heads = ["motion", "rate"];
        text.extend([format!("\n\nfree motion {}{end}\n{}", k + 1, lines(&heads, rows))]);
    }
    if !found.repeated.is_empty() {
        let row = |repeated: &Repeated| {
            let by = repeated.by.iter().enumerate().map(|(k, by)| {
                let first = if k == 0 { repeated.condition.words.clone() } else { String::new() };
                vec![first, by.words.clone()]
            });
            by.collect::<Vec<_>>()
        };
        let rows = found.repeated.iter().flat_map(row).collect();
        text.extend([format!("\n\n{}", lines(&["redundant", "follows from"], rows))]);
    }
    if !found.cures.is_empty() {
        let row = |cure: &Cure| {
            vec![changes(cure), cure.count.mobility.to_string(), cure.count.n_redundant.to_string()]
        };
        let rows = found.cures.iter().map(row).collect();
        text.extend([format!("\n\n{}", lines(&["cure", "free motions", "redundant"], rows))]);
    } else if n_redundant > 0 {
        text.push_str("\n\n  no change of a few joints leaves nothing twice");
    }
    let too_many = found.drives.iter().filter(|drive| drive.is_too_many);
    let row = |drive: &DriveCheck| {
        let by = drive.by.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let by = if by.is_empty() { "the joints alone".to_owned() } else { by };
        vec![format!("`{}`", drive.measure), by]
    };
    let rows: Vec<_> = too_many.map(row).collect();
    if !rows.is_empty() {
        text.extend([format!("\n\n{}", lines(&["drive too many", "fixed by"], rows))]);
    }
    if !found.alignments.is_empty() {
        let row = |of: &bksim::analysis::Alignment| {
            let joints: Vec<String> = of.joints.iter().map(|joint| format!("`{joint}`")).collect();
            let word = if of.distance.is_some() { "in line" } else { "parallel" };
            let distance = of.distance.map_or_else(String::new, |off| shown(off, "m"));
            vec![joints.join(", "), word.to_owned(), shown(of.angle, "rad"), distance]
        };
        let rows = found.alignments.iter().map(row).collect();
        text.extend([format!("\n\n{}", lines(&["axes that must be", "", "off by", ""], rows))]);
    }
    text
}

fn count_json(count: Count) -> Value {
    json!({ "counted": count.counted, "mobility": count.mobility, "redundant": count.n_redundant })
}

fn condition_json(of: &Condition) -> Value {
    json!({
        "of": of.of,
        "direction": of.direction,
        "effort": of.effort,
        "axis": of.axis.map_or(Vec::new(), Vec::from),
        "text": of.words,
    })
}

fn told_json(found: &Doctor) -> Value {
    let motion = |motion: &FreeMotion| {
        let rates = motion.rates.iter().map(|(name, rate, _)| (name.clone(), json!(rate)));
        json!({
            "rates": Value::Object(rates.collect()),
            "bodies": motion.bodies,
            "finite": motion.is_finite,
        })
    };
    let repeated = |of: &Repeated| {
        json!({
            "condition": condition_json(&of.condition),
            "repeats": of.by.iter().map(condition_json).collect::<Vec<_>>(),
        })
    };
    let cure = |cure: &Cure| {
        let change = |(joint, from, to): &(String, &str, &str)| json!({ "joint": joint, "from": from, "to": to });
        json!({
            "changes": cure.changes.iter().map(change).collect::<Vec<_>>(),
            "count": count_json(cure.count),
        })
    };
    let drive = |of: &DriveCheck| json!({ "measure": of.measure, "too_many": of.is_too_many, "fixed_by": of.by });
    let joint = |(name, kind, taken): &(String, &str, i64)| json!({ "name": name, "type": kind, "taken": taken });
    let alignment = |of: &bksim::analysis::Alignment| json!({ "joints": of.joints, "angle": of.angle, "distance": of.distance });
    json!({
        "bodies": found.bodies,
        "freedoms_of_body": found.freedoms_of_body,
        "joints": found.joints.iter().map(joint).collect::<Vec<_>>(),
        "couplings": found.couplings,
        "rates": found.rates,
        "count": count_json(found.count),
        "motions": found.motions.iter().map(motion).collect::<Vec<_>>(),
        "redundant": found.repeated.iter().map(repeated).collect::<Vec<_>>(),
        "cures": found.cures.iter().map(cure).collect::<Vec<_>>(),
        "drives": found.drives.iter().map(drive).collect::<Vec<_>>(),
        "alignments": found.alignments.iter().map(alignment).collect::<Vec<_>>(),
    })
}
