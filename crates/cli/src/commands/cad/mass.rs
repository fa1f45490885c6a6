//! `bksim cad mass`: areas, centres of mass and moments of inertia.

use bksim::analysis::quantity;
use bksim::cad::compose::{BodyReport, MassSource};
use bksim::model::file::{Source, read};
use bksim::model::{Inertia, Model};
use serde_json::{Value, json};

use super::{Parts, parts};
use crate::args::cad::Mass;
use crate::exit::{Failure, Status};
use crate::output::{self, number, table};
use crate::render;

pub(super) fn run(args: &Mass, as_json: bool) -> Result<Status, Failure> {
    let plate = [args.density.as_deref(), args.thickness.as_deref()];
    let path = &args.drawing.drawing;
    let parts = parts(path, &args.drawing.reading, plate, super::is_missing_mass)?;
    let bodies: Vec<&BodyReport> = parts
        .composition
        .bodies
        .iter()
        .filter(|body| args.body.as_ref().is_none_or(|name| *name == body.name))
        .collect();
    if let (Some(name), true) = (&args.body, bodies.is_empty()) {
        let known: Vec<&str> =
            parts.composition.bodies.iter().map(|body| body.name.as_str()).collect();
        let what = format!("has no body `{name}`");
        let help = Some(format!("bodies are {}", known.join(", ")));
        return Err(Failure::Input { path: path.clone(), what, help });
    }
    // A drawing whose model is complete gives numbers for masses that are expressions.
    let composition = &parts.composition;
    let model = read(&Source::new(&composition.text, "drawing")).model;
    // So do the bodies by themselves, where joints are missing.
    let model = model.or_else(|| read(&Source::new(&composition.weighed, "drawing")).model);
    let is_unweighed = |body: &&&BodyReport| {
        body.source == MassSource::Computed && weight(&body.name, model.as_ref()).is_none()
    };
    if bodies.iter().any(|body| is_unweighed(&body)) {
        plate_in_units(plate)?;
    }
    if as_json {
        let rows: Vec<Value> =
            bodies.iter().map(|body| describe(body, &parts, model.as_ref())).collect();
        let body = json!({
            "unit": parts.sheet.drawing.unit.name,
            "bodies": rows,
            "diagnostics": render::json_all(&parts.source, &parts.composition.diagnostics),
        });
        output::json("cad mass", body)?;
    } else {
        parts.print_warnings();
        let reports: Vec<String> =
            bodies.iter().map(|body| report(body, &parts, model.as_ref())).collect();
        output::text(&reports.join("\n"))?;
    }
    Ok(Status::Done)
}

/// Refuses a density or a thickness of another dimension, or without unit.
fn plate_in_units(plate: [Option<&str>; 2]) -> Result<(), Failure> {
    let meant = [("--density", "kg/m^3", "7850 kg/m^3"), ("--thickness", "m", "5 mm")];
    for (text, (option, unit, example)) in plate.into_iter().zip(meant) {
        let Some(text) = text else { continue };
        let is_bare = text.trim().parse::<f64>().is_ok();
        if is_bare || quantity(text, unit).is_err() {
            let message = format!("`{option}` takes a value in {unit}, found `{text}`");
            let help = Some(format!("write for example `{option} \"{example}\"`"));
            return Err(Failure::Usage { message, help });
        }
    }
    Ok(())
}

/// Mass, kg, and moment of inertia about the centre of mass, kg m², of a body of the model.
fn weight(name: &str, model: Option<&Model>) -> Option<(f64, f64)> {
    let model = model?;
    let body = model.bodies.iter().find(|body| body.name == name)?;
    let values = |symbol| {
        model.parameters.iter().find(|p| p.symbol == symbol).map(|parameter| parameter.value)
    };
    let value = |expr| model.pool.evaluate(expr, &values).ok();
    let Inertia { moments, about, .. } = &body.inertia;
    let mass = value(body.mass)?;
    let mut moment = value(moments[2])?;
    if let Some(point) = about {
        // Steiner: from the stated point to the centre of mass.
        let position = body.points.get(point.0)?.position;
        for (com, from) in body.com.into_iter().zip(position).take(2) {
            moment -= mass * (value(com)? - value(from)?).powi(2);
        }
    }
    Some((mass, moment))
}

fn source_words(body: &BodyReport) -> &'static str {
    match body.source {
        MassSource::Stated => "stated",
        MassSource::Computed => "computed: density × thickness × area",
        MassSource::Missing => "neither stated nor density and thickness given",
    }
}

fn report(body: &BodyReport, parts: &Parts, model: Option<&Model>) -> String {
    let unit = parts.sheet.drawing.unit.name;
    let row = |what: &str, value: String| vec![what.to_owned(), value];
    let mut rows = Vec::new();
    if let Some(area) = &body.area {
        rows.push(row("area", format!("{} {unit}^2", number(area.area))));
        rows.push(row("perimeter", format!("{} {unit}", number(area.perimeter))));
        let [x, y] = area.centroid.map(number);
        rows.push(row("centroid", format!("({x}, {y}) {unit}")));
        rows.push(row("polar moment of area", format!("{} {unit}^4", number(area.polar))));
    } else {
        rows.push(row("outline", "none is closed".to_owned()));
    }
    let weight = weight(parts.composition.model_name(&body.name), model);
    let mass = match (weight, &body.mass) {
        (Some((mass, _)), _) => format!("{} kg, {}", number(mass), source_words(body)),
        (None, Some(text)) => format!("{text}, {}", source_words(body)),
        (None, None) => source_words(body).to_owned(),
    };
    rows.push(row("mass", mass));
    if body.source != MassSource::Missing {
        let [x, y] = body.centre.map(number);
        rows.push(row("centre of mass", format!("({x}, {y}) {unit}")));
    }
    if let Some((_, moment)) = weight {
        rows.push(row("moment of inertia", format!("{} kg m^2, about it", number(moment))));
    }
    format!("{}\n{}", body.name, table(&rows))
}

fn describe(body: &BodyReport, parts: &Parts, model: Option<&Model>) -> Value {
    let weight = weight(parts.composition.model_name(&body.name), model);
    json!({
        "body": body.name,
        "area": body.area.as_ref().map(|area| area.area),
        "perimeter": body.area.as_ref().map(|area| area.perimeter),
        "centroid": body.area.as_ref().map_or_else(Vec::new, |area| area.centroid.to_vec()),
        "polar_moment_of_area": body.area.as_ref().map(|area| area.polar),
        "mass_source": match body.source {
            MassSource::Stated => "stated",
            MassSource::Computed => "computed",
            MassSource::Missing => "missing",
        },
        "mass": body.mass,
        "mass_kg": weight.map(|(mass, _)| mass),
        "centre_of_mass": body.centre,
        "inertia_kg_m2": weight.map(|(_, moment)| moment),
    })
}
