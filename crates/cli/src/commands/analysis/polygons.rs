//! `bksim polygons`: velocity and acceleration polygons of a pose.

use bksim::analysis::{Column, Polygon, PolygonVector, Polygons, Table, VectorPart, polygons};
use serde_json::{Value, json};

use super::answer::{Answer, Asked, Draw, asked_drawn, failed, lines};
use super::kinematics::{prescribed, without_rates_of_drives};
use crate::args::analysis::Polygons as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::source::load_geometry;

/// Asks, writes the table or what `draw` makes of the polygons, and prints the answer.
///
/// # Errors
/// [`Failure`] when there is no answer, or the file cannot be written.
pub fn run(
    args: &Args,
    draw: Option<Draw<'_, Polygons>>,
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
    let rates = [args.rate.as_slice(), &args.acceleration];
    let asked = prescribed(&model, &args.drive, rates, false).map_err(&failed)?;
    let Some(prescribed) = asked else {
        let help = "write `--drive crank.angle=\"40 deg\"` and `--rate 25`, or `--drive t=\"0.1 s\"` of drives of the model";
        return Err(Failure::usage("no pose is asked for", help));
    };
    without_rates_of_drives(&prescribed, rates)?;
    let found = polygons(model, &prescribed).map_err(&failed)?;
    let n = found.velocity.vectors.len() + found.acceleration.vectors.len();
    let n = counted(n, "vector", "vectors");
    let picture = draw.map(|draw| Ok::<_, Failure>((draw(&name, &found)?, n))).transpose()?;
    Asked::drawn(&source, &warnings, (file, picture), told(&name, &found), as_json)
}

/// `v_C/B`; of accelerations also `n`, `t`, `c` and `r` for normal, tangential, of Coriolis, and along a guide.
pub fn vector_name(letter: &str, vector: &PolygonVector) -> String {
    let (point, base) = &vector.of;
    let of = base.as_ref().map_or_else(|| point.clone(), |base| format!("{point}/{base}"));
    let part = match vector.part {
        VectorPart::Normal => " n",
        VectorPart::Tangential => " t",
        VectorPart::Coriolis => " c",
        VectorPart::Sliding if letter == "a" => " r",
        _ => "",
    };
    format!("{letter}_{of}{part}")
}

/// The answer about a model of this name.
pub fn told(name: &str, found: &Polygons) -> Answer {
    let both = [(&found.velocity, "v", "m/s"), (&found.acceleration, "a", "m/s^2")];
    let mut text = format!("{name}: velocity and acceleration polygon");
    let mut table = Table::default();
    let heads = [
        ("acceleration", ""),
        ("vector", ""),
        ("from_x", ""),
        ("from_y", ""),
        ("to_x", ""),
        ("to_y", ""),
    ];
    table.columns = heads.iter().map(|(name, unit)| Column::new(*name, *unit)).collect();
    for (k, (polygon, letter, unit)) in both.into_iter().enumerate() {
        let row = |vector: &PolygonVector| {
            let d = [vector.to[0] - vector.from[0], vector.to[1] - vector.from[1]];
            vec![
                vector_name(letter, vector),
                format!("{} {unit}", number(d[0].hypot(d[1]))),
                format!("{} deg", number(d[1].atan2(d[0]).to_degrees())),
            ]
        };
        let rows = polygon.vectors.iter().map(row).collect();
        text.extend([format!("\n\n{}", lines(&["vector", "size", "direction"], rows))]);
        for (number, vector) in polygon.vectors.iter().enumerate() {
            let [a, b] = [vector.from, vector.to];
            table.rows.push(vec![k as f64, number as f64 + 1.0, a[0], a[1], b[0], b[1]]);
        }
    }
    let bodies = found.bodies.iter().map(|(body, rate, acceleration)| {
        (body.clone(), json!({ "rate": rate, "acceleration": acceleration }))
    });
    let json = json!({
        "bodies": Value::Object(bodies.collect()),
        "velocity": polygon_json("v", &found.velocity),
        "acceleration": polygon_json("a", &found.acceleration),
    });
    Answer { command: "polygons", json, text, table }
}

fn polygon_json(letter: &str, polygon: &Polygon) -> Value {
    let vertices = polygon.vertices.iter().map(|v| (v.name.clone(), json!(v.at)));
    let vectors = polygon.vectors.iter().map(|vector| {
        json!({ "name": vector_name(letter, vector), "from": vector.from, "to": vector.to })
    });
    json!({
        "vertices": Value::Object(vertices.collect()),
        "vectors": vectors.collect::<Vec<_>>(),
    })
}
