//! `bksim assemble`: the consistent start, and how far each stated value was moved.

use bksim::Mechanism;
use bksim::analysis::diagnose_singular_start;
use bksim::describe;
use bksim::mbs::quantity::Quantity;
use bksim::model::file::ShownUnits;
use bksim::sim::mobility::mobility;
use bksim::sim::start::{Moved, Start};

use crate::args::ModelArgs;
use crate::exit::{Failure, Status};
use crate::output::{self, column, number, rows_of, size, table};
use crate::render;
use crate::source::shown::shown_units;
use crate::source::{derive, load};
use crate::waiting::waiting;

pub(crate) fn run(args: &ModelArgs, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let loaded = load(args, nesting)?;
    let mechanism = derive(&loaded.source, loaded.model)?;
    let start = waiting("looking for the start", || mechanism.start());
    let start = start.map_err(|rejected| loaded.source.rejected(rejected.0))?;
    let found = mobility(&mechanism.model, &mechanism.system, &start);
    let mut warnings = mechanism.warnings_of(&start, &found, loaded.warnings);
    warnings.extend(diagnose_singular_start(&mechanism, &start));
    if as_json {
        let mut body = describe::start(&mechanism, &start);
        body["diagnostics"] = render::json_all(&loaded.source, &warnings);
        output::json("assemble", body)?;
    } else {
        render::print_all(&loaded.source, &warnings);
        let (asked, text) = (args.drawing.shown(&args.model), &loaded.source.text);
        let units = shown_units(asked, text, ShownUnits::of_model(text))?;
        output::text(&report(&mechanism, &start, &units))?;
    }
    Ok(Status::Done)
}

/// SI units of a coordinate, its rate and its second rate.
fn si_units(coordinate: &Quantity) -> Vec<&str> {
    let rates = coordinate.rates.iter().map(|[_, unit]| unit.as_str());
    [coordinate.unit.as_str()].into_iter().chain(rates).collect()
}

/// Values in these SI units, in the units that are shown.
fn shown(values: &[f64], si: &[&str], units: &ShownUnits) -> Vec<String> {
    let values = values.iter().zip(si).map(|(&value, si)| units.of(si).of_si(value));
    column(&values.collect::<Vec<_>>())
}

fn report(mechanism: &Mechanism, start: &Start, units: &ShownUnits) -> String {
    let compiled = &mechanism.compiled;
    let coordinates = &compiled.coordinates;
    let all_units: Vec<Vec<&str>> = coordinates.iter().map(si_units).collect();
    let rates = |values: &[f64], k: usize| {
        let si: Vec<&str> =
            all_units.iter().map(|of| of.get(k).copied().unwrap_or_default()).collect();
        shown(values, &si, units)
    };
    let named = |of: &Vec<&str>| {
        let words = of.iter().map(|si| match units.of(si).unit {
            unit if unit.is_empty() => "1".to_owned(),
            unit => unit.replace("^2", "²"),
        });
        words.collect::<Vec<_>>().join(", ")
    };
    let columns = [
        headed("coordinate", coordinates.iter().map(|c| c.name.clone()).collect()),
        headed("value", rates(&start.q, 0)),
        headed("velocity", rates(&start.v, 1)),
        headed("acceleration", rates(&start.a, 2)),
        headed("unit", all_units.iter().map(named).collect()),
    ];
    let title = format!("{}: consistent at t = {} s", mechanism.model.name, number(start.t));
    let mut lines = vec![title, table(&rows_of(&columns))];
    if !start.lambda.is_empty() {
        let multipliers = &compiled.multipliers;
        let si: Vec<&str> = multipliers.iter().map(|m| m.unit.as_str()).collect();
        let values = start.sampled_multipliers(compiled, &mechanism.parameters);
        let columns = [
            headed("multiplier", multipliers.iter().map(|m| m.name.clone()).collect()),
            headed("value", shown(&values, &si, units)),
            headed("unit", si.iter().map(|si| units.of(si).unit).collect()),
            headed("of", multipliers.iter().map(|m| m.description.clone()).collect()),
        ];
        lines.extend([String::new(), table(&rows_of(&columns))]);
    }
    if !start.moved.is_empty() {
        lines.extend([String::new(), table(&rows_of(&initial_columns(mechanism, start, units)))]);
    }
    if !start.lambda.is_empty() {
        lines.push(format!(
            "\n  constraints closed to {} in position, {} in velocity",
            size(start.position_residual),
            size(start.velocity_residual)
        ));
    }
    lines.join("\n")
}

fn headed(heading: &str, cells: Vec<String>) -> Vec<String> {
    [vec![heading.to_owned()], cells].concat()
}

/// Values that were stated or guessed, and those of the start.
fn initial_columns(mechanism: &Mechanism, start: &Start, units: &ShownUnits) -> [Vec<String>; 6] {
    let moved = &start.moved;
    let unit = |m: &Moved| {
        let initial = mechanism.model.initial.iter().find(|i| i.name == m.name);
        initial.map_or("", |i| i.unit(&mechanism.model)).to_owned()
    };
    let si: Vec<String> = moved.iter().map(unit).collect();
    let si: Vec<&str> = si.iter().map(String::as_str).collect();
    let numbers =
        |of: &dyn Fn(&Moved) -> f64| shown(&moved.iter().map(of).collect::<Vec<_>>(), &si, units);
    let kind = |m: &Moved| if m.is_guess { "guess" } else { "held" }.to_owned();
    [
        headed("initial", moved.iter().map(|m| m.name.clone()).collect()),
        headed("given", numbers(&|m| m.stated)),
        headed("found", numbers(&|m| m.found)),
        headed("moved by", numbers(&|m| m.found - m.stated)),
        headed("unit", si.iter().map(|si| units.of(si).unit).collect()),
        headed("", moved.iter().map(kind).collect()),
    ]
}
