//! `bksim cad doctor`: everything that is wrong with a drawing, and a copy with marks.

use std::collections::BTreeMap;

use bksim::cad::doctor::{Finding, Report, examine, marks};
use bksim::cad::model::ModelOptions;
use bksim::cad::open::{OpenOptions, check};
use bksim::cad::units;
use bksim::cad::write::graft::{Ungrafted, graft};
use bksim::model::diagnostic::Severity;
use bksim::model::message::counted;
use bksim_load::InputError;
use serde_json::{Value, json};

use super::written;
use crate::args::cad::Doctor;
use crate::args::draw::Destination;
use crate::exit::{Failure, Status};
use crate::origin::label_of;
use crate::output;
use crate::render;
use crate::source::{Text, read_bytes};

pub(super) fn run(args: &Doctor, as_json: bool) -> Result<Status, Failure> {
    let written = args.output.clone().map(|output| Destination { output, force: args.force });
    if let Some(written) = &written {
        written::check(written, &[&args.drawing.drawing])?;
    }
    let (path, sidecar) = super::drawing_of(&args.drawing.drawing)?;
    let reading = &args.drawing.reading;
    let known =
        |name: &String| units::by_name(name).ok_or_else(|| InputError::Unit { name: name.clone() });
    let unit = reading.units.as_ref().map(known).transpose()?;
    let options = ModelOptions {
        unit,
        tolerance: reading.tolerance,
        sidecar: sidecar.as_deref(),
        ..ModelOptions::default()
    };
    let bytes = read_bytes(&path)?;
    let report = examine(bytes.clone(), options);
    let source = Text::new(path.clone(), report.text.clone());
    if let Some(written) = &written {
        written::refuse_inputs(&written.output, &[&path])?;
        mark(&report, bytes, written, &source)?;
    }
    print(&report, &source, written.as_ref(), as_json)?;
    Ok(if report.has_error() { Status::Rejected } else { Status::Done })
}

/// Writes the copy with the marks.
fn mark(
    report: &Report,
    bytes: Vec<u8>,
    written: &Destination,
    source: &Text,
) -> Result<(), Failure> {
    let checked =
        check(bytes, &OpenOptions::default()).map_err(|faults| source.rejected(faults))?;
    let marked = graft(&checked.tags, &marks(report)).map_err(|ungrafted| match ungrafted {
        Ungrafted::Drawing(fault) => source.rejected(vec![*fault]).into(),
        Ungrafted::Write(error) => Failure::writing(&written.output, &error),
    })?;
    written::put_own(&written.output, (written.force, &label_of(&source.path)), marked)
}

/// Findings of one code that are printed.
const MOST_SHOWN: usize = 20;

fn print(
    report: &Report,
    source: &Text,
    written: Option<&Destination>,
    as_json: bool,
) -> Result<(), Failure> {
    let faults: Vec<_> = report.findings.iter().map(|finding| finding.fault.clone()).collect();
    let n_errors = faults.iter().filter(|fault| fault.is_error()).count();
    let n_warnings = faults.len() - n_errors;
    if as_json {
        let body = json!({
            "unit": report.unit.map(|unit| unit.name),
            "errors": n_errors,
            "warnings": n_warnings,
            "findings": report.findings.iter().map(describe).collect::<Vec<_>>(),
            "output": written.map(|written| written.output.display().to_string()),
            "diagnostics": render::json_all(source, &faults),
        });
        return output::json("cad doctor", body);
    }
    // What is wrong a thousand times is shown some times.
    let mut n_of: BTreeMap<&str, usize> = BTreeMap::new();
    for fault in &faults {
        let n = n_of.entry(fault.code.0).or_default();
        *n += 1;
        if *n <= MOST_SHOWN {
            render::print_all(source, std::slice::from_ref(fault));
        }
    }
    for (code, n) in n_of.into_iter().filter(|(_, n)| *n > MOST_SHOWN) {
        let more = n - MOST_SHOWN;
        render::warning(&format!("{more} more findings of {code}; `--json` has them all"));
    }
    let head = match faults.len() {
        0 => "nothing is wrong".to_owned(),
        _ => format!(
            "{}, {}",
            counted(n_errors, "error", "errors"),
            counted(n_warnings, "warning", "warnings")
        ),
    };
    output::text(&format!("{}: {head}", source.path.display()))?;
    match written {
        Some(written) => output::report(&format!("wrote {}", written.output.display())),
        None => Ok(()),
    }
}

/// A finding with its first place by itself, then all of them.
fn describe(finding: &Finding) -> Value {
    let fault = &finding.fault;
    let places: Vec<Value> = finding
        .places
        .iter()
        .map(|place| {
            json!({
                "entity": place.kind,
                "handle": place.handle.map(|handle| format!("{:X}", handle.0)),
                "layer": place.layer,
                "at": place.at,
            })
        })
        .collect();
    let first = |key: &str| places.first().map_or(Value::Null, |place| place[key].clone());
    json!({
        "code": fault.code.0,
        "severity": if fault.severity == Severity::Error { "error" } else { "warning" },
        "message": fault.message,
        "handle": first("handle"),
        "layer": first("layer"),
        "at": finding.places.first().map_or_else(Vec::new, |place| place.at.to_vec()),
        "cure": fault.help,
        "places": places,
    })
}
