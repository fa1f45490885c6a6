//! The text of a model.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::draft::{Axes, Body, Draft, Point, Table, list, number, quoted, vector};
use crate::job::{LeftOut, Source};
use crate::names::Renamed;

/// The whole text.
pub(crate) fn text(
    draft: &Draft,
    sources: &[Source],
    left_out: &[LeftOut],
    renamed: &[Renamed],
) -> String {
    let mut out = String::new();
    for line in &draft.heading {
        comment(&mut out, line);
    }
    if !renamed.is_empty() {
        comment(&mut out, "");
        comment(&mut out, "Names that had to change, as the file has them and as they are here:");
        for Renamed { kind, from, to } in renamed {
            comment(&mut out, &format!("  {kind} {} is {to}", quoted(from)));
        }
    }
    let _ = writeln!(out, "\nname = {}", quoted(&draft.name));
    let _ = writeln!(out, "space = \"{}\"", if draft.is_planar { "planar" } else { "spatial" });
    if draft.is_relative {
        let _ = writeln!(out, "coordinates = \"relative\"");
    }
    if !draft.parameters.is_empty() {
        let _ = writeln!(out, "\n[parameters]");
        for parameter in &draft.parameters {
            let _ = writeln!(out, "{} = {} # {}", parameter.name, parameter.value, parameter.note);
        }
    }
    if !draft.ground.is_empty() {
        let _ = writeln!(out, "\n[ground.points]");
        points(&mut out, &draft.ground, draft.is_planar);
    }
    for curve in &draft.curves {
        table(&mut out, "curves", curve);
    }
    for of in &draft.bodies {
        body(&mut out, of, draft.is_planar);
    }
    let sections = [
        ("joints", &draft.joints),
        ("couplings", &draft.couplings),
        ("loads", &draft.loads),
        ("drives", &draft.drives),
    ];
    for (section, tables) in sections {
        for of in tables {
            table(&mut out, section, of);
        }
    }
    if let Some(gravity) = draft.gravity {
        let _ = writeln!(out, "\n[loads.gravity]\ntype = \"gravity\"");
        let shown = if draft.is_planar { list(&gravity[..2]) } else { vector(gravity) };
        let _ = writeln!(out, "acceleration = {shown}");
    }
    if !draft.initial.is_empty() {
        let _ = writeln!(out, "\n[initial]");
        for (name, value) in &draft.initial {
            let _ = writeln!(out, "{name} = {value}");
        }
    }
    if !draft.inputs.is_empty() {
        let inputs: Vec<String> = draft.inputs.iter().map(|name| quoted(name)).collect();
        let _ = writeln!(out, "\n[io]\ninput = [{}]", inputs.join(", "));
    }
    left(&mut out, sources, left_out);
    out
}

fn comment(out: &mut String, line: &str) {
    let clean: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let _ = writeln!(out, "{}", format!("# {clean}").trim_end());
}

fn table(out: &mut String, section: &str, of: &Table) {
    let _ = writeln!(out);
    of.notes.iter().for_each(|note| comment(out, note));
    let _ = writeln!(out, "[{section}.{}]", of.name);
    for (key, value) in &of.keys {
        let _ = writeln!(out, "{key} = {value}");
    }
}

fn body(out: &mut String, of: &Body, is_planar: bool) {
    let _ = writeln!(out);
    of.notes.iter().for_each(|note| comment(out, note));
    let _ = writeln!(out, "[bodies.{}]", of.name);
    let inertia = &of.inertia;
    for (key, value) in &of.keys {
        let _ = writeln!(out, "{key} = {value}");
    }
    if !of.keys.iter().any(|(key, _)| matches!(*key, "mass" | "density")) {
        let _ = writeln!(out, "mass = {}", number(inertia.mass));
    }
    if inertia.com != [0.0; 3] {
        let com = if is_planar { list(&inertia.com[..2]) } else { vector(inertia.com) };
        let _ = writeln!(out, "com = {com}");
    }
    if inertia.tensor != [0.0; 6] {
        let has_products = inertia.tensor[3..].iter().any(|entry| *entry != 0.0);
        let shown = match (is_planar, has_products) {
            (true, _) => number(inertia.tensor[2]),
            (false, true) => list(&inertia.tensor),
            (false, false) => list(&inertia.tensor[..3]),
        };
        let _ = writeln!(out, "inertia = {shown}");
    }
    if !is_planar && inertia.fault().is_some() {
        let _ = writeln!(out, "as_stated = true");
    }
    if !of.shapes.is_empty() {
        let _ = writeln!(out, "shapes = [");
        of.shapes.iter().for_each(|shape| {
            let _ = writeln!(out, "  {shape},");
        });
        let _ = writeln!(out, "]");
    }
    if !of.points.is_empty() {
        let _ = writeln!(out, "[bodies.{}.points]", of.name);
        points(out, &of.points, is_planar);
    }
}

fn points(out: &mut String, points: &[Point], is_planar: bool) {
    for point in points {
        let at = if is_planar { list(&point.at[..2]) } else { vector(point.at) };
        let _ = match point.axes {
            Axes::Own => writeln!(out, "{} = {at}", point.name),
            Axes::Rpy(rpy) => {
                writeln!(out, "{} = {{ at = {at}, rpy = {} }}", point.name, vector(rpy))
            }
            Axes::Turned(turn) => {
                writeln!(out, "{} = {{ at = {at}, quaternion = {} }}", point.name, list(&turn.0))
            }
        };
    }
}

/// The parts that are left out with their lines, those of one kind together: file, kind, lines.
pub(crate) fn left_out_by_kind(
    sources: &[Source],
    left_out: &[LeftOut],
) -> Vec<(usize, String, Vec<String>)> {
    let mut grouped: BTreeMap<(usize, &str), Vec<usize>> = BTreeMap::new();
    for part in left_out {
        let line = crate::line_of(&sources[part.place.file].text, part.place.span.start);
        grouped.entry((part.place.file, part.what.as_str())).or_default().push(line);
    }
    let shown = |lines: Vec<usize>| lines.iter().map(usize::to_string).collect();
    let rows = grouped.into_iter();
    rows.map(|((file, what), lines)| (file, what.to_owned(), shown(lines))).collect()
}

/// Everything that is not in the model, with its lines, at the end.
fn left(out: &mut String, sources: &[Source], left_out: &[LeftOut]) {
    if left_out.is_empty() {
        return;
    }
    let _ = writeln!(out);
    comment(out, "In the file, and not in this model:");
    for (file, what, lines) in left_out_by_kind(sources, left_out) {
        comment(out, &format!("- {what} ({}:{})", sources[file].name, lines.join(", ")));
    }
}
