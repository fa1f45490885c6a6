//! `bksim kinematics --limits`: ranges, dead points, types of loops, transmission angles.

use bksim::analysis::{
    Extreme, FourBar, Limits, Rotatability, SliderCrank, Table, Transmission, TransmissionAt,
};
use serde_json::{Value, json};

use super::answer::{Answer, beyond, lines, shown, text_units};
use crate::output::number;

pub(super) fn extreme_json(extreme: &Extreme) -> Value {
    let pose = extreme.pose.iter().map(|(name, value)| (name.clone(), json!(value)));
    json!({
        "name": extreme.name,
        "kind": if extreme.is_maximum { "max" } else { "min" },
        "value": extreme.value,
        "pose": Value::Object(pose.collect()),
    })
}

pub(super) fn extreme_row(extreme: &Extreme) -> Vec<String> {
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

/// The answer about a model of this name: its limits.
pub fn told_limits(name: &str, found: &bksim::analysis::Limits) -> Answer {
    let mut text = format!("{name}: limits{}", beyond(&found.beyond));
    text.push_str(&loops_text(found));
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
        if !branch.transmissions.is_empty() {
            let rows = branch.transmissions.iter().map(transmission_row).collect();
            let heads = [
                "transmission angle at",
                "least",
                "where",
                "greatest",
                "where",
                "pressure angle up to",
            ];
            text.extend([format!("\n\n{}", lines(&heads, rows))]);
        }
        for output in &branch.outputs {
            if let Some(ratio) = output.time_ratio {
                text.extend([format!("\n\n  time ratio of {}: {}", output.name, number(ratio))]);
            }
            if let Some([advantage, drive]) = output.least_advantage {
                // Efforts are forces along lengths, and torques about angles.
                let unit = match output.units {
                    ["rad", "m"] => "1/m",
                    ["m", "rad"] => "m",
                    _ => "",
                };
                let advantage = shown(advantage, unit);
                let at = shown(drive, output.units[0]);
                text.extend([format!(
                    "\n\n  least mechanical advantage of {}: {advantage} at {} = {at}",
                    output.name, output.drive
                )]);
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
                "least_advantage": o.least_advantage.map(|[advantage, drive]| {
                    json!({ "advantage": advantage, "drive": drive })
                }),
                "dead_points": { "output": o.dead_points[0], "drive": o.dead_points[1] },
            })
        };
        branches.push(json!({
            "closed": branch.is_closed,
            "ranges": branch.ranges.iter().map(range).collect::<Vec<_>>(),
            "extremes": branch.extremes.iter().map(extreme_json).collect::<Vec<_>>(),
            "transmissions": branch.transmissions.iter().map(transmission_json).collect::<Vec<_>>(),
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
    Answer { command: "kinematics", json: limits_json(found, &branches), text, table }
}

fn limits_json(found: &Limits, branches: &[Value]) -> Value {
    let four_bar = |of: &FourBar| {
        json!({
            "parts": of.parts,
            "joints": of.joints,
            "lengths": of.lengths,
            "excess": of.excess,
            "grashof": word(of.rotatability),
            "barker": {
                "number": of.barker.number,
                "code": of.barker.code,
                "name": of.barker.name,
            },
        })
    };
    let slider_crank = |of: &SliderCrank| {
        json!({
            "parts": of.parts,
            "joints": of.joints,
            "lengths": of.lengths,
            "offset": of.offset,
            "excess": of.excess,
            "grashof": word(of.rotatability),
            "inversion": of.inversion,
            "turning": of.turning,
        })
    };
    json!({
        "branches": branches,
        "beyond": found.beyond,
        "four_bars": found.four_bars.iter().map(four_bar).collect::<Vec<_>>(),
        "slider_cranks": found.slider_cranks.iter().map(slider_crank).collect::<Vec<_>>(),
    })
}

fn word(rotatability: Rotatability) -> &'static str {
    match rotatability {
        Rotatability::Grashof => "grashof",
        Rotatability::ChangePoint => "change-point",
        Rotatability::NonGrashof => "non-grashof",
    }
}

fn transmission_json(of: &Transmission) -> Value {
    let at = |at: &TransmissionAt| {
        let pose = at.pose.iter().map(|(name, value)| (name.clone(), json!(value)));
        json!({
            "angle": at.angle,
            "pressure": at.pressure(),
            "pose": Value::Object(pose.collect()),
        })
    };
    json!({ "at": of.at, "least": at(&of.least), "greatest": at(&of.greatest) })
}

fn transmission_row(of: &Transmission) -> Vec<String> {
    let place = |at: &TransmissionAt| {
        let first = at.pose.first();
        first.map_or_else(String::new, |(name, value)| {
            format!("{name} = {}", shown(*value, if is_angle(name) { "rad" } else { "m" }))
        })
    };
    vec![
        of.at.clone(),
        shown(of.least.angle, "rad"),
        place(&of.least),
        shown(of.greatest.angle, "rad"),
        place(&of.greatest),
        shown(of.least.pressure(), "rad"),
    ]
}

/// Types of four-bars and slider-cranks.
fn loops_text(found: &Limits) -> String {
    let mut text = String::new();
    let unit = text_units().of("m");
    let length = |length: &f64| number(unit.of_si(*length));
    let lengths = |of: &[f64]| of.iter().map(length).collect::<Vec<_>>().join(" / ");
    let headed = |name: &str| format!("{name} ({})", unit.unit);
    let kind = |rotatability| match rotatability {
        Rotatability::Grashof => "Grashof",
        Rotatability::ChangePoint => "change point",
        Rotatability::NonGrashof => "not Grashof",
    };
    if !found.four_bars.is_empty() {
        let row = |of: &FourBar| {
            vec![
                of.joints.join("-"),
                of.parts.join(", "),
                lengths(&of.lengths),
                kind(of.rotatability).to_owned(),
                format!("{} {}", of.barker.code, of.barker.name),
            ]
        };
        let rows = found.four_bars.iter().map(row).collect();
        let heads = headed("lengths");
        let heads = ["four-bar", "frame, input, coupler, output", &heads, "", "Barker's type"];
        text.extend([format!("\n\n{}", lines(&heads, rows))]);
    }
    if !found.slider_cranks.is_empty() {
        let row = |of: &SliderCrank| {
            let turning = of.turning.as_ref();
            vec![
                of.joints.join("-"),
                of.inversion.to_owned(),
                lengths(&of.lengths),
                length(&of.offset),
                turning.map_or_else(|| "nothing turns".to_owned(), |link| format!("{link} turns")),
            ]
        };
        let rows = found.slider_cranks.iter().map(row).collect();
        let [links, offset] = ["links", "offset"].map(headed);
        let heads = ["slider-crank", "", &links, &offset, ""];
        text.extend([format!("\n\n{}", lines(&heads, rows))]);
    }
    text
}
