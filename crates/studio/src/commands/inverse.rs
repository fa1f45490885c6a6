//! `bksim inverse` with a picture: efforts over speeds, with the curves of motors.

use std::path::Path;

use bksim::analysis::{Duty, Inverse, Table};
use bksim_cli::args::analysis::Inverse as Args;
use bksim_cli::commands::analysis::inverse;
use bksim_cli::exit::{Failure, Status};
use bksim_plot::{Axis, Curve, Figure, Format, Panel, Theme};

/// Draws the efforts that are asked for.
pub(crate) fn run(args: &Args, path: &Path, json: bool, nesting: usize) -> Result<Status, Failure> {
    let format = Format::of(path);
    let draw = |name: &str, found: &Inverse| {
        let drawn = figure(name, found).render(format, None, &Theme::LIGHT);
        drawn.map_err(|error| Failure::file(path, format!("cannot be drawn: {error}"), None))
    };
    inverse::run(args, Some(&draw), json, nesting)
}

/// A panel for each actuator.
fn figure(name: &str, found: &Inverse) -> Figure {
    let panel = |(actuator, speed, effort): (&str, usize, usize)| {
        let unit = |k: usize| found.table.columns[k].unit.clone();
        let points = found.table.rows.iter().map(|row| [row[speed], row[effort]]);
        let mut curves = vec![Curve::new(actuator, points.collect())];
        for duty in found.duties.iter().filter(|duty| duty.curve.name == actuator) {
            curves.extend(beside(duty));
        }
        let axis = |label: &str, k| Axis::new(label, &unit(k));
        Panel::new(axis(&format!("speed of {actuator}"), speed), axis("effort", effort), curves)
    };
    Figure::new(name, actuators(&found.table).into_iter().map(panel).collect())
}

/// Actuators with the columns of their speed and effort.
fn actuators(table: &Table) -> Vec<(&str, usize, usize)> {
    let place = |name: String| table.columns.iter().position(|column| column.name == name);
    let of = |effort: usize| {
        let own = table.columns[effort].name.strip_suffix(".effort")?;
        let speed = place(format!("{own}.rate")).or_else(|| place(format!("{own}.velocity")))?;
        Some((own, speed, effort))
    };
    (0..table.columns.len()).filter_map(of).collect()
}

/// The curve of a motor in four quadrants, and the points that lie outside of it.
fn beside(duty: &Duty) -> Vec<Curve> {
    let mut outline: Vec<[f64; 2]> = duty.curve.points().to_vec();
    let last = outline.last().map_or(0.0, |point| point[0]);
    // A table may go on beyond its rows.
    let fastest = duty.points.iter().fold(last, |most, point| most.max(point[1].abs()));
    if duty.curve.at(fastest) > 0.0 {
        outline.push([fastest, duty.curve.at(fastest)]);
    }
    outline.push([outline.last().map_or(0.0, |point| point[0]), 0.0]);
    // From the right over the top to the left, then back below.
    let mirrored =
        |sides: [f64; 2]| move |point: &[f64; 2]| [sides[0] * point[0], sides[1] * point[1]];
    let right_to_left: Vec<[f64; 2]> = outline.iter().rev().copied().collect();
    let closed = right_to_left
        .iter()
        .copied()
        .chain(outline.iter().map(mirrored([-1.0, 1.0])))
        .chain(right_to_left.iter().map(mirrored([-1.0, -1.0])))
        .chain(outline.iter().map(mirrored([1.0, -1.0])));
    let limit = Curve { color: 1, dash: 1, ..Curve::new("curve of the motor", closed.collect()) };
    let outside = duty.points.iter().map(|[_, speed, effort, limit]| {
        if effort.abs() > *limit { [*speed, *effort] } else { [f64::NAN; 2] }
    });
    let outside = Curve { color: 3, ..Curve::new("outside", outside.collect()) };
    if duty.outside().next().is_some() { vec![limit, outside] } else { vec![limit] }
}
