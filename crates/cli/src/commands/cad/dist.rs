//! `bksim cad dist`: distances of the joints of each body.

use bksim::cad::compose::JointReport;
use bksim::cad::geometry::Point;
use serde_json::json;

use super::{Parts, parts};
use crate::args::cad::Drawing;
use crate::exit::{Failure, Status};
use crate::output::{self, number, table};
use crate::render;

/// Two joints of one body and their distance.
struct Link<'a> {
    body: &'a str,
    joints: [&'a str; 2],
    length: f64,
}

pub(super) fn run(args: &Drawing, as_json: bool) -> Result<Status, Failure> {
    // Lengths need no mass.
    let is_harmless = |fault: &_| super::is_missing_mass(fault);
    let parts = parts(&args.drawing, &args.reading, [None; 2], is_harmless)?;
    let links = links(&parts);
    let unit = parts.sheet.drawing.unit.name;
    if as_json {
        let rows = links
            .iter()
            .map(|link| json!({ "body": link.body, "joints": link.joints, "length": link.length }));
        let body = json!({
            "unit": unit,
            "links": rows.collect::<Vec<_>>(),
            "diagnostics": render::json_all(&parts.source, &parts.composition.diagnostics),
        });
        output::json("cad dist", body)?;
        return Ok(Status::Done);
    }
    parts.print_warnings();
    let mut rows =
        vec![["body", "joints", "", &format!("length, {unit}")].map(str::to_owned).to_vec()];
    rows.extend(links.iter().map(|link| {
        let [a, b] = link.joints.map(str::to_owned);
        vec![link.body.to_owned(), a, b, number(link.length)]
    }));
    output::text(&table(&rows))?;
    Ok(Status::Done)
}

/// Each pair of joints at different points of one body, the ground included.
fn links(parts: &Parts) -> Vec<Link<'_>> {
    let joints = &parts.composition.joints;
    let bodies = parts.composition.bodies.iter().map(|body| body.name.as_str());
    let mut links = Vec::new();
    for body in std::iter::once("ground").chain(bodies) {
        let on_body: Vec<(&str, Point)> = joints
            .iter()
            .filter_map(|joint| Some((joint.name.as_str(), end(joint, body)?)))
            .collect();
        for (first_idx, (first, a)) in on_body.iter().enumerate() {
            for (second, b) in &on_body[first_idx + 1..] {
                let length = (a[0] - b[0]).hypot(a[1] - b[1]);
                if length > 0.0 {
                    links.push(Link { body, joints: [first, second], length });
                }
            }
        }
    }
    links
}

fn end(joint: &JointReport, body: &str) -> Option<Point> {
    let end_idx = joint.bodies.iter().position(|name| name == body)?;
    Some(joint.at[end_idx])
}
