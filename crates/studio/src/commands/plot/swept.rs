//! `bksim plot sweep.parquet`: the table of a sweep as a picture, and which of its inputs matter.

mod figure;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use bksim::model::message::counted;
use bksim_cli::args::plot::Plot;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{is_of_model, stamped};
use bksim_cli::output;
use bksim_plot::{Figure, Format};
use bksim_sweep::{Influence, Table, column_named};
use serde_json::{Value, json};

use super::{drawn_as, picture, put, text_of};
use figure::{Columns, figure};

/// The first bytes of a Parquet file.
const PARQUET: &[u8] = b"PAR1";
/// Outputs that are drawn unless some are named.
const N_DRAWN: usize = 6;

/// True of tables: by their name, or by how they begin.
pub(super) fn is_table(path: &Path) -> bool {
    let mut first = [0; PARQUET.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut first));
    let is_named = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"));
    is_named || read.is_ok() && first == PARQUET
}

/// Draws the table of a sweep.
pub(super) fn run(
    args: &Plot,
    path: &Path,
    outputs: &[String],
    as_json: bool,
) -> Result<Status, Failure> {
    if args.window {
        let help = "write a picture with `-o sweep.svg`, or leave out both for text";
        return Err(Failure::usage("a sweep has no window", help));
    }
    let table = Table::read(path).map_err(|error| Failure::Input {
        path: path.to_owned(),
        what: format!("cannot be drawn: {error}"),
        help: None,
    })?;
    let (shown, n_left_out) = shown(&table, path, outputs)?;
    let across = args.x.as_ref().map(|name| input(&table, path, name)).transpose()?;
    let columns = Columns { table: &table, shown, across, log_y: args.log_y };
    let figure = figure(&columns, args.title.as_deref().unwrap_or(&table.model_name));
    let influences = influences(&columns);

    let out = args.output.as_deref().map(|out| {
        let may_replace = args.force || is_of_model(out, &table.model_file);
        picture(out, &[path.to_owned()], may_replace)
    });
    let out = out.transpose()?;
    if let Some((file, format)) = &out {
        let bytes = drawn_as(args, *format, &figure)?;
        put(file, &stamped(file.path(), bytes, &table.model_file))?;
    }
    let words = words(&columns, &influences);
    if as_json {
        let format = out.map(|(_, format)| format);
        output::json("plot", described(args, format, (path, &figure), &columns, &influences))?;
    } else if let Some(file) = &args.output {
        let panels = counted(figure.panels.len(), "panel", "panels");
        output::report(&format!("wrote {}: {panels}\n{words}", file.display()))?;
    } else {
        output::styled(&text_of(&figure))?;
        output::text(&words)?;
    }
    if n_left_out > 0 && !as_json {
        let more = counted(n_left_out, "more output was", "more outputs were");
        output::text(&format!("{more} left out: name those to see"))?;
    }
    Ok(Status::Done)
}

/// The outputs that are drawn, and how many are not.
fn shown(table: &Table, path: &Path, named: &[String]) -> Result<(Vec<usize>, usize), Failure> {
    if named.is_empty() {
        let n = table.outputs.len();
        return Ok(((0..n.min(N_DRAWN)).collect(), n.saturating_sub(N_DRAWN)));
    }
    let known: Vec<&str> = table.outputs.iter().map(|(column, _)| column.name.as_str()).collect();
    let find =
        |name: &String| column_named(&known, name).map_err(|help| unknown(path, name, &help));
    Ok((named.iter().map(find).collect::<Result<_, _>>()?, 0))
}

/// The input of this name.
fn input(table: &Table, path: &Path, name: &str) -> Result<usize, Failure> {
    let known: Vec<&str> = table.inputs.iter().map(|(column, _)| column.name.as_str()).collect();
    column_named(&known, name).map_err(|help| unknown(path, name, &help))
}

fn unknown(path: &Path, name: &str, help: &str) -> Failure {
    Failure::usage(format!("`{}` has no column `{name}`", path.display()), help)
}

/// By output that is drawn and by input, where both vary.
fn influences(columns: &Columns<'_>) -> Vec<Vec<Option<Influence>>> {
    let Columns { table, shown, .. } = columns;
    let of = |output: &usize| {
        let output = &table.outputs[*output].1;
        let found = table.inputs.iter().map(|(_, input)| Influence::of(input, output));
        // An output follows from the inputs: from the only one all of it, however few the cases are.
        let is_only = table.inputs.len() == 1;
        found
            .map(|of| of.map(|of| if is_only { Influence { share: 1.0, ..of } } else { of }))
            .collect()
    };
    shown.iter().map(of).collect()
}

/// Which inputs matter, the strongest first.
fn words(columns: &Columns<'_>, influences: &[Vec<Option<Influence>>]) -> String {
    let Columns { table, shown, .. } = columns;
    let mut lines = Vec::new();
    for (&output, found) in shown.iter().zip(influences) {
        let inputs = table.inputs.iter().zip(found);
        let mut known: Vec<(&str, Influence)> = inputs
            .filter_map(|((column, _), found)| Some((column.name.as_str(), (*found)?)))
            .collect();
        known.sort_by(|a, b| b.1.share.total_cmp(&a.1.share));
        let told = known.iter().map(|(name, Influence { share, rank })| {
            format!("{name} {:.0} % (rank correlation {rank:+.2})", 100.0 * share)
        });
        let told: Vec<String> = told.collect();
        let told = if told.is_empty() { "does not change".to_owned() } else { told.join(", ") };
        lines.push(format!("  {}: {told}", table.outputs[output].0.name));
    }
    format!("variance that each input explains alone\n{}", lines.join("\n"))
}

fn described(
    args: &Plot,
    format: Option<Format>,
    (path, figure): (&Path, &Figure),
    columns: &Columns<'_>,
    influences: &[Vec<Option<Influence>>],
) -> Value {
    let Columns { table, shown, .. } = columns;
    let of_output = |(&output, found): (&usize, &Vec<Option<Influence>>)| {
        let (column, values) = &table.outputs[output];
        let inputs = table.inputs.iter().zip(found).map(|((input, _), found)| {
            json!({
                "input": input.name,
                "share": found.map(|found| found.share),
                "rank_correlation": found.map(|found| found.rank),
            })
        });
        let numbers = || values.iter().copied().filter(|value| !value.is_nan());
        json!({
            "name": column.name,
            "unit": column.unit,
            "smallest": numbers().reduce(f64::min),
            "largest": numbers().reduce(f64::max),
            "influences": inputs.collect::<Vec<_>>(),
        })
    };
    json!({
        "output": args.output.as_ref().map(|path| path.display().to_string()),
        "format": format.map_or("text", Format::ending),
        "title": figure.title,
        "table": path.display().to_string(),
        "cases": table.inputs.first().map_or(0, |(_, values)| values.len()),
        "outputs": shown.iter().zip(influences).map(of_output).collect::<Vec<_>>(),
    })
}
