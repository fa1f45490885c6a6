//! A report as an object of JSON.

use serde_json::{Value, json};

use super::{Extreme, Report};

/// The numbers of a report in SI, as `bksim report --json` prints them; the keys are those of `docs/json.md`.
pub fn json_of(report: &Report) -> Value {
    let at = |extreme: Extreme| json!({ "value": extreme.value, "t": extreme.t });
    let motions = report.motions.iter().map(|motion| {
        json!({
            "name": motion.name,
            "unit": motion.unit,
            "least": at(motion.limits[0]),
            "largest": at(motion.limits[1]),
            "stroke": motion.stroke(),
            "rate": at(motion.rate),
            "acceleration": at(motion.acceleration),
            "time_ratio": motion.time_ratio.map(|ratio| {
                json!({ "forward": ratio.forward, "back": ratio.back, "value": ratio.value() })
            }),
        })
    });
    let points = report.points.iter().map(|point| {
        json!({
            "name": point.name,
            "speed": at(point.speed),
            "acceleration": at(point.acceleration),
        })
    });
    let drives = report.drives.iter().map(|drive| {
        json!({
            "name": drive.name,
            "unit": drive.unit,
            "peak": at(drive.peak),
            "rms": drive.rms,
            "power": at(drive.power),
            "mean_power": drive.mean_power,
        })
    });
    let reactions = report.reactions.iter().map(|reaction| {
        json!({
            "joint": reaction.name,
            "force": at(reaction.force),
            "largest": {
                "reaction": reaction.largest.reaction,
                "direction": reaction.largest.direction(),
                "pose": reaction.largest.pose.iter().map(|(name, value, unit)| {
                    json!({ "name": name, "value": value, "unit": unit })
                }).collect::<Vec<_>>(),
            },
            "force_rms": reaction.force_rms,
            "moment": at(reaction.moment),
            "moment_rms": reaction.moment_rms,
            "unique": reaction.is_unique,
        })
    });
    let outputs = report.outputs.iter().map(|output| {
        json!({
            "name": output.name,
            "unit": output.unit,
            "least": at(output.limits[0]),
            "largest": at(output.limits[1]),
            "mean": output.mean,
            "rms": output.rms,
        })
    });
    let work = report.work.iter().map(|part| {
        json!({ "name": part.name, "kind": part.kind, "work": part.work, "stored": part.stored })
    });
    let energy = &report.energy;
    json!({
        "t_start": report.span[0],
        "t_end": report.span[1],
        "motions": motions.collect::<Vec<_>>(),
        "points": points.collect::<Vec<_>>(),
        "drives": drives.collect::<Vec<_>>(),
        "reactions": reactions.collect::<Vec<_>>(),
        "outputs": outputs.collect::<Vec<_>>(),
        "work": work.collect::<Vec<_>>(),
        "energy": {
            "kinetic": at(energy.kinetic),
            "potential_least": at(energy.potential[0]),
            "potential_largest": at(energy.potential[1]),
            "total_start": energy.total[0],
            "total_end": energy.total[1],
            "work": energy.work,
            "power": at(energy.power),
        },
    })
}
