//! `bksim cad list`: everything that is attached to a drawing.

use bksim::cad::attachment::{Attachment, Content, Value, Way};
use bksim::cad::excerpt::describe;
use bksim::cad::geometry::Point;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::message::counted;
use serde_json::json;

use crate::args::cad::Drawing;
use crate::exit::{Failure, Status};
use crate::output::{self, number, table};
use crate::render;
use crate::source::{Text, read_bytes, read_sheet};

pub(super) fn run(args: &Drawing, as_json: bool) -> Result<Status, Failure> {
    let (path, _) = super::drawing_of(&args.drawing)?;
    let path = &path;
    let sheet = read_sheet(path, read_bytes(path)?, &args.reading)?;
    let unit = sheet.drawing.unit.name;
    let source = Text::new(path.clone(), sheet.text);
    if as_json {
        let rows = sheet.attachments.iter().map(|attachment| {
            let location = &attachment.location;
            let values =
                attachment.values.iter().map(|v| (v.key.to_owned(), words(v, unit).into()));
            json!({
                "kind": attachment.kind.name,
                "way": way(attachment),
                "entity": location.kind,
                "handle": location.handle.map(|handle| format!("{:X}", handle.0)),
                "layer": location.layer,
                "at": coordinates(attachment.at),
                "to": coordinates(attachment.to),
                "axis": coordinates(attachment.axis),
                "values": values.collect::<serde_json::Map<_, serde_json::Value>>(),
            })
        });
        let body = json!({
            "unit": unit,
            "entities": sheet.drawing.entities.len(),
            "attachments": rows.collect::<Vec<_>>(),
            "diagnostics": render::json_all(&source, &sheet.diagnostics),
        });
        output::json("cad list", body)?;
    } else {
        render::print_all(&source, &sheet.diagnostics);
        let rows: Vec<Vec<String>> = sheet
            .attachments
            .iter()
            .map(|attachment| {
                let values = attachment.values.iter().filter(|value| value.key != "name");
                let values: Vec<String> =
                    values.map(|value| format!("{}={}", value.key, words(value, unit))).collect();
                vec![
                    attachment.kind.name.to_owned(),
                    name(attachment),
                    attachment.at.map_or_else(String::new, |[x, y]| {
                        format!("({}, {})", number(x), number(y))
                    }),
                    way(attachment).to_owned(),
                    describe(&attachment.location),
                    values.join(" "),
                ]
            })
            .collect();
        let n_entities = sheet.drawing.entities.len();
        let head = format!(
            "{}: {}, {} attached, in {unit}",
            path.display(),
            counted(n_entities, "entity", "entities"),
            rows.len()
        );
        output::text(&if rows.is_empty() { head } else { format!("{head}\n{}", table(&rows)) })?;
    }
    let is_good = sheet.diagnostics.iter().all(|fault: &Diagnostic| !fault.is_error());
    Ok(if is_good { Status::Done } else { Status::Rejected })
}

/// A point, or nothing.
fn coordinates(point: Option<Point>) -> Vec<f64> {
    point.map_or_else(Vec::new, |point| point.to_vec())
}

fn way(attachment: &Attachment) -> &'static str {
    match attachment.way {
        Way::Xdata(_) => "record",
        Way::Block => "block",
        Way::Layer => "layer",
    }
}

fn name(attachment: &Attachment) -> String {
    let name = attachment.values.iter().find(|value| value.key == "name");
    name.map_or_else(String::new, |value| words(value, ""))
}

fn words(value: &Value, unit: &str) -> String {
    match &value.content {
        Content::Text(text) => text.clone(),
        Content::Number(number) => number.to_string(),
        Content::Length(length) => format!("{length} {unit}"),
        Content::Entity(handle) => format!("entity {:X}", handle.0),
    }
}
