//! `bksim assemble`: the consistent start, and how far each stated value was moved.

use bksim::Mechanism;
use bksim::analysis::diagnose_singular_start;
use bksim::describe;
use bksim::mbs::quantity::Quantity;
use bksim::sim::mobility::mobility;
use bksim::sim::start::{Moved, Start};

use crate::args::ModelArgs;
use crate::exit::{Failure, Status};
use crate::output::{self, column, number, rows_of, size, table};
use crate::render;
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
        output::text(&report(&mechanism, &start))?;
    }
    Ok(Status::Done)
}

/// Units of a coordinate, its rate and its second rate.
fn units(coordinate: &Quantity) -> String {
    let rates = coordinate.rates.iter().map(|[_, unit]| unit);
    let all = [&coordinate.unit].into_iter().chain(rates);
    let all =
        all.map(|unit| if unit.is_empty() { "1".to_owned() } else { unit.replace("^2", "²") });
    all.collect::<Vec<_>>().join(", ")
}

fn report(mechanism: &Mechanism, start: &Start) -> String {
    let compiled = &mechanism.compiled;
    let coordinates = &compiled.coordinates;
    let columns = [
        headed("coordinate", coordinates.iter().map(|c| c.name.clone()).collect()),
        headed("value", column(&start.q)),
        headed("velocity", column(&start.v)),
        headed("acceleration", column(&start.a)),
        headed("unit", coordinates.iter().map(units).collect()),
    ];
    let title = format!("{}: consistent at t = {} s", mechanism.model.name, number(start.t));
    let mut lines = vec![title, table(&rows_of(&columns))];
    if !start.lambda.is_empty() {
        let multipliers = &compiled.multipliers;
        let columns = [
            headed("multiplier", multipliers.iter().map(|m| m.name.clone()).collect()),
            headed("value", column(&start.sampled_multipliers(compiled, &mechanism.parameters))),
            headed("unit", multipliers.iter().map(|m| m.unit.clone()).collect()),
            headed("of", multipliers.iter().map(|m| m.description.clone()).collect()),
        ];
        lines.extend([String::new(), table(&rows_of(&columns))]);
    }
    if !start.moved.is_empty() {
        lines.extend([String::new(), table(&rows_of(&initial_columns(mechanism, start)))]);
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
fn initial_columns(mechanism: &Mechanism, start: &Start) -> [Vec<String>; 6] {
    let moved = &start.moved;
    let numbers = |of: &dyn Fn(&Moved) -> f64| column(&moved.iter().map(of).collect::<Vec<_>>());
    let unit = |m: &Moved| {
        let initial = mechanism.model.initial.iter().find(|i| i.name == m.name);
        initial.map_or("", |i| i.unit(&mechanism.model)).to_owned()
    };
    let kind = |m: &Moved| if m.is_guess { "guess" } else { "held" }.to_owned();
    [
        headed("initial", moved.iter().map(|m| m.name.clone()).collect()),
        headed("given", numbers(&|m| m.stated)),
        headed("found", numbers(&|m| m.found)),
        headed("moved by", numbers(&|m| m.found - m.stated)),
        headed("unit", moved.iter().map(unit).collect()),
        headed("", moved.iter().map(kind).collect()),
    ]
}
