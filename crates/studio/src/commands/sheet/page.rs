//! The sheet as a document: drawing with dimensions, load cases, tables, curves and poses of the largest forces.

use bksim::answered::{Role, answered};
use bksim::model::file::ShownUnits;
use bksim::report::{pin_table, six_digits};
use bksim::sim::run::Unreplayed;
use bksim::translation::{Language, spoken};
use bksim_cli::output::number;
use bksim_plot::{Axis, Block, Curve, Document, Figure, Panel, ROOM, Size, Theme};

use super::drawing::{with_dimensions, with_forces};
use super::{CaseRun, Runs, case_table, remarks, shown};

/// Instants of a curve.
const INSTANTS: u32 = 400;
/// Joints in one figure, and poses that are drawn.
const CURVES: usize = 6;
const POSES: usize = 4;

/// A text in the language that is spoken, its places `{}` filled.
pub(super) fn said(english: &str, values: &[&str]) -> String {
    let mut parts = Vec::new();
    let words = answered(english, Role::Heading, spoken());
    let mut values = values.iter();
    for (idx, part) in words.split("{}").enumerate() {
        parts.extend((idx > 0).then(|| values.next().copied().unwrap_or_default()));
        parts.push(part);
    }
    parts.concat()
}

/// A table with its headings in the language that is spoken, their units apart.
fn headed(mut rows: Vec<Vec<String>>) -> Block {
    for head in rows.iter_mut().take(1).flatten() {
        *head = match head.split_once(" [") {
            Some((name, unit)) => format!("{} [{unit}", said(name, &[])),
            None => said(head, &[]),
        };
    }
    Block::Table(rows)
}

/// The sheet of these runs.
pub(super) fn of(runs: &mut Runs) -> Result<Document, Unreplayed> {
    let units = runs.units.clone();
    let length = units.of("m").unit;
    let first = runs.cases.first_mut().expect("there is a case");
    let (drawing, t) = with_dimensions(&mut first.show, &units)?;
    let instant = instant(first, t, &units);
    let caption = said(
        "{} at {}, scale {}, lengths in {}.",
        &[&runs.model, &instant, &drawing.scale, &length],
    );
    let picture = Block::Picture { svg: drawing.svg, size: drawing.size, caption };
    let mut blocks = vec![picture];
    let heading = |english: &str| Block::Heading(said(english, &[]));
    let cases = case_table(runs);
    let has_cases = !cases.is_empty();
    if has_cases {
        blocks.extend([heading("Load cases"), headed(cases)]);
    }
    let over = if has_cases { "Largest pin forces over all cases" } else { "Largest pin forces" };
    blocks.extend([heading(over), headed(shown(&runs.largest(), &units))]);
    blocks.extend(NOTES.map(|note| Block::Text(said(note, &[]))));
    blocks.extend(remarks(runs).into_iter().map(Block::Text));
    blocks.push(heading("Poses of the largest forces"));
    blocks.extend(poses(runs)?);
    blocks.push(heading("Pin forces over time"));
    for case in &mut runs.cases {
        let figure = figure(case, &units)?;
        let size = Size { width: ROOM, height: 300.0 };
        let is_only = case.name.is_empty();
        let caption = if is_only { String::new() } else { said("Load case {}.", &[&case.name]) };
        blocks.push(Block::Picture { svg: figure.to_svg(size, &Theme::LIGHT), size, caption });
    }
    if has_cases {
        let all = pin_table(&runs.named(), &units);
        blocks.extend([heading("Each load case"), headed(shown(&all, &units))]);
    }
    let foot = said("{}, made by bksim {}", &[&runs.model, env!("CARGO_PKG_VERSION")]);
    let title = said("Pin forces of {}", &[&runs.model]);
    let language = if spoken() == Language::Vietnamese { "vi" } else { "en" };
    Ok(Document { title, language, foot, blocks })
}

/// Notes below the table of largest forces.
const NOTES: [&str; 3] = [
    "Forces are those on the second body of a joint or a contact, along the axes of the ground; the direction is counted from x.",
    "Six digits of each force are shown, and its components to the same digit.",
    "Angles of joints that have gone beyond a turn are given within half a turn.",
];

/// A joint with its largest force, N.
type Named = (String, f64);

/// The mechanism where the largest forces act, those of one instant together.
fn poses(runs: &mut Runs) -> Result<Vec<Block>, Unreplayed> {
    let mut instants: Vec<(usize, f64, Vec<Named>)> = Vec::new();
    for (joint, case) in runs.worst().into_iter().enumerate() {
        let one = &runs.cases[case].report.reactions[joint];
        let (t, size) = (one.force.t, one.force.value);
        let span = runs.cases[case].report.span;
        let near = 1e-3 * (span[1] - span[0]).abs();
        let own = (one.name.clone(), size);
        match instants.iter_mut().find(|(at, known, _)| *at == case && (known - t).abs() <= near) {
            Some((.., joints)) => joints.push(own),
            None => instants.push((case, t, vec![own])),
        }
    }
    let largest = |joints: &[Named]| joints.iter().map(|it| it.1).fold(0.0, f64::max);
    let most = instants.iter().map(|(.., joints)| largest(joints)).fold(0.0, f64::max);
    instants.retain(|(.., joints)| largest(joints) > 1e-9 * most);
    instants.sort_by(|a, b| largest(&b.2).total_cmp(&largest(&a.2)));
    let units = runs.units.clone();
    let mut blocks = Vec::new();
    for (case, t, joints) in instants.into_iter().take(POSES) {
        let case = &mut runs.cases[case];
        let drawn = with_forces(case, t, &units, ROOM)?;
        let names: Vec<String> = joints.into_iter().map(|(name, _)| name).collect();
        let at = instant(case, t, &units);
        let caption =
            said("Largest force of {} at {}; scale {}.", &[&names.join(", "), &at, &drawn.scale]);
        blocks.push(Block::Picture { svg: drawn.svg, size: drawn.size, caption });
    }
    Ok(blocks)
}

/// An instant of a case in words.
fn instant(case: &CaseRun, t: f64, units: &ShownUnits) -> String {
    let time = units.of("s");
    let [first, last] = case.report.span.map(f64::abs);
    let shown = number(six_digits(time.of_si(t), time.of_si(first.max(last))));
    let at = format!("t = {shown} {}", time.unit);
    if case.name.is_empty() { at } else { said("{}, load case {}", &[&at, &case.name]) }
}

/// Instants of a run: even ones, and those of all peaks.
pub(super) fn instants(case: &CaseRun, n: u32) -> Vec<f64> {
    let [first, last] = case.report.span;
    let even = (0..=n).map(|k| first + (last - first) * f64::from(k) / f64::from(n));
    let peaks = case.report.reactions.iter().map(|joint| joint.force.t);
    let mut all: Vec<f64> = even.chain(peaks).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The sizes of the pin forces over time, the largest ones.
fn figure(case: &mut CaseRun, units: &ShownUnits) -> Result<Figure, Unreplayed> {
    let (force, time) = (units.of("N"), units.of("s"));
    let mut joints: Vec<usize> = (0..case.report.reactions.len()).collect();
    let peak = |joint: usize| case.report.reactions[joint].force.value;
    joints.sort_by(|&a, &b| peak(b).total_cmp(&peak(a)));
    joints.truncate(CURVES);
    joints.sort_unstable();
    let mut curves: Vec<Vec<[f64; 2]>> = vec![Vec::new(); joints.len()];
    for t in instants(case, INSTANTS) {
        let (reactions, _) = case.bearings(t)?;
        for (curve, &joint) in curves.iter_mut().zip(&joints) {
            let [fx, fy, fz, ..] = reactions[joint];
            curve.push([time.of_si(t), force.of_si(fx.hypot(fy).hypot(fz))]);
        }
    }
    let named = |(points, &joint): (Vec<[f64; 2]>, &usize)| {
        Curve::new(&case.report.reactions[joint].name, points)
    };
    let curves = curves.into_iter().zip(&joints).map(named).collect();
    let axis = |name: &str, unit: &str| Axis::new(&said(name, &[]), unit);
    let panel = Panel::new(axis("time", &time.unit), axis("pin force", &force.unit), curves);
    Ok(Figure::new("", vec![panel]))
}
