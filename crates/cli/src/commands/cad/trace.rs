//! `bksim cad trace`: what a run looks like in its drawing.

use std::fs::File;
use std::io::BufReader;

use bksim::Mechanism;
use bksim::Rejected;
use bksim::cad::codes;
use bksim::cad::compose::Composition;
use bksim::cad::open::{OpenOptions, check};
use bksim::cad::write::graft::{Ungrafted, graft};
use bksim::cad::write::trace::{
    BodyShape, Course, CurveKind, MotionCurve, Reaction, Selection, Traced, even_samples,
    nearest_sample, trace,
};
use bksim::log::Log;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Source, read};
use bksim::model::{Body, Model};
use bksim::overlay::{Overlay, OverlayKind, overlays};
use bksim::sim::pose::{Pose, Poses};

use super::{is_missing_mass, parts, written};
use crate::args::draw::Trace;
use crate::exit::{Failure, Status};
use crate::origin::file_of;
use crate::render;
use crate::source::{Text, derive, parse, read_bytes};

pub(super) fn run(args: &Trace, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    written::check(&args.written, &[&args.log, &args.drawing])?;
    let (mechanism, log) = opened(args, nesting)?;
    let mut course = course(args, &mechanism, &log)?;
    let mut parts = parts(&args.drawing, &args.reading, [None, None], is_missing_mass)?;
    let per_metre = 1.0 / parts.sheet.drawing.unit.metres;
    let composition = parts.composition.clone();
    let of_run = |name: &str| mechanism.model.bodies.iter().any(|body| body.name == name);
    if !parts.composition.bodies.iter().any(|body| of_run(composition.model_name(&body.name))) {
        let names = mechanism.model.bodies.iter().skip(1).map(|body| body.name.as_str());
        let names = names.collect::<Vec<_>>().join(", ");
        let what = format!("has none of the bodies of the run: {names}");
        let help = Some("name the drawing that was solved".to_owned());
        return Err(Failure::Input { path: args.drawing.clone(), what, help });
    }
    parts.composition.diagnostics.extend(other_drawing(&mechanism, &parts.composition, per_metre));

    // What is to be drawn.
    course.points = points(args, &course, &mechanism)?;
    course.curves = curves(args, &log, &mechanism)?;
    let selection = selection(args, &course.times);
    let number = |name: &str| mechanism.model.bodies.iter().position(|body| body.name == name);
    let shape = |body: &bksim::cad::compose::BodyReport| {
        let body_idx = number(composition.model_name(&body.name))?;
        Some(BodyShape { body_idx, paths: body.paths.clone(), frame: body.frame })
    };
    let shapes: Vec<BodyShape> = parts.composition.bodies.iter().filter_map(shape).collect();
    let addition = trace(&course, &shapes, &selection, per_metre);

    written::refuse_inputs(&args.written.output, &[&parts.source.path])?;
    let bytes = read_bytes(&parts.source.path)?;
    // A DWG is traced as the binary DXF that it is read through.
    let checked =
        check(bytes, &OpenOptions::default()).map_err(|faults| parts.source.rejected(faults))?;
    let traced = graft(&checked.tags, &addition).map_err(|ungrafted| match ungrafted {
        Ungrafted::Drawing(fault) => parts.source.rejected(vec![*fault]).into(),
        Ungrafted::Write(error) => Failure::writing(&args.written.output, &error),
    })?;
    if !as_json {
        parts.print_warnings();
    }
    let diagnostics = render::json_all(&parts.source, &parts.composition.diagnostics);
    let label = file_of(&log.header);
    let destination = (&args.written, label.as_str());
    written::write("cad trace", destination, traced, &diagnostics, as_json)
}

/// The log and the mechanism that it is a run of.
fn opened(args: &Trace, nesting: usize) -> Result<(Mechanism, Log), Failure> {
    let path = &args.log;
    let unfit = |what: String| Failure::Input { path: path.clone(), what, help: None };
    let file = File::open(path).map_err(|e| Failure::reading(path, &e))?;
    let log =
        Log::read(BufReader::new(file)).map_err(|e| unfit(format!("cannot be traced: {e}")))?;
    let header = &log.header;
    let source = Text::new(path.clone(), header.model_text.clone());
    let loaded = parse(source, &header.model_name, &[], nesting)?;
    let mut mechanism = derive(&loaded.source, loaded.model)?;
    // The run may have had other values than the file.
    for (parameter, value) in mechanism.model.parameters.iter().zip(&mut mechanism.parameters) {
        if let Some(used) = header.parameters.get(&parameter.name) {
            *value = used.value;
        }
    }
    Ok((mechanism, log))
}

/// Poses and reactions at every sample.
fn course(args: &Trace, mechanism: &Mechanism, log: &Log) -> Result<Course, Failure> {
    let unfit =
        |what: &str| Failure::Input { path: args.log.clone(), what: what.to_owned(), help: None };
    let state = log.header.topic_id("/state").map(|topic| log.series(topic));
    let state = state.ok_or_else(|| unfit("has no states"))?;
    let n = mechanism.compiled.nq();
    if state.columns.len() != 2 * n || state.t.is_empty() {
        return Err(unfit("has no states of its model"));
    }
    let row = |idx: usize| -> Vec<f64> { state.columns.iter().map(|column| column[idx]).collect() };
    let rows: Vec<Vec<f64>> = (0..state.t.len()).map(row).collect();
    let poses = Poses::compile(&mechanism.model, &mechanism.system)
        .map_err(|e| unfit(&format!("cannot be traced: {e}")))?
        .at(&mechanism.parameters, rows.iter().map(|row| row.split_at(n)));
    let poses = poses.iter().map(|of| of.iter().map(Pose::in_plane).collect()).collect();
    let model = &mechanism.model;
    let reaction = |joint: &bksim::model::Joint| {
        let series = log.series(log.header.topic_id(&format!("/reactions/{}", joint.name))?);
        let [x, y] = [series.columns.first()?, series.columns.get(1)?];
        let force: Vec<[f64; 2]> = x.iter().zip(y).map(|(&x, &y)| [x, y]).collect();
        // A run that was cut short may lack the last of them.
        if force.len() != state.t.len() {
            return None;
        }
        let body = &model.bodies[joint.successor.body.0];
        let point = joint.successor.point.map(|point| body.points[point.0].position);
        let at = point.map_or(Some([0.0; 2]), |p| place(mechanism, p))?;
        Some(Reaction { name: joint.name.clone(), body_idx: joint.successor.body.0, at, force })
    };
    let reactions = model.joints.iter().filter_map(reaction).collect();
    Ok(Course { times: state.t.clone(), poses, points: Vec::new(), reactions, curves: Vec::new() })
}

/// The numbers of a point in the frame of its body, m.
fn place(mechanism: &Mechanism, [x, y, _]: bksim::model::Vector) -> Option<[f64; 2]> {
    let value = |symbol| {
        let mut known = mechanism.model.parameters.iter().zip(&mechanism.parameters);
        known.find(|(parameter, _)| parameter.symbol == symbol).map(|(_, &value)| value)
    };
    let number = |e| mechanism.model.pool.evaluate(e, &value).ok();
    Some([number(x)?, number(y)?])
}

/// The points to follow: those named, else all that move, each place once.
fn points(args: &Trace, course: &Course, mechanism: &Mechanism) -> Result<Vec<Traced>, Failure> {
    let model = &mechanism.model;
    let traced = |body_idx: usize, name: String, at| {
        Some(Traced { name, body_idx, at: place(mechanism, at)? })
    };
    if args.points.is_empty() {
        let mut all: Vec<Traced> = Vec::new();
        for (idx, body) in model.bodies.iter().enumerate().skip(1) {
            for point in &body.points {
                let name = format!("{}.{}", body.name, point.name);
                let Some(new) = traced(idx, name, point.position) else { continue };
                if moves(course, &new) && all.iter().all(|known| !is_same(course, known, &new)) {
                    all.push(new);
                }
            }
        }
        return Ok(all);
    }
    let found = args.points.iter().map(|name| {
        let (body, point) =
            name.split_once('.').map_or((name.as_str(), None), |(b, p)| (b, Some(p)));
        let body_idx = model.bodies.iter().position(|known| known.name == body)?;
        let at = position(&model.bodies[body_idx], point)?;
        traced(body_idx, name.clone(), at)
    });
    let found = found
        .zip(&args.points)
        .map(|(found, name)| found.ok_or_else(|| no_point(args, name, model)));
    found.collect()
}

/// The curves of the whole motion that are asked for.
fn curves(args: &Trace, log: &Log, mechanism: &Mechanism) -> Result<Vec<MotionCurve>, Failure> {
    let source = Text::new(args.log.clone(), String::new());
    let read = || {
        let reading = read(&Source::new(&log.header.model_text, &log.header.model_name));
        let mut model = reading.model.ok_or(Rejected(reading.diagnostics))?;
        for (parameter, value) in model.parameters.iter_mut().zip(&mechanism.parameters) {
            parameter.value = *value;
        }
        Ok(model)
    };
    let found = overlays(&read, &args.curve).map_err(|e| source.rejected(e.diagnostics()))?;
    let curve = |overlay: Overlay| MotionCurve {
        name: overlay.name,
        kind: match overlay.kind {
            OverlayKind::Way => CurveKind::Way,
            OverlayKind::FixedCentrode | OverlayKind::MovingCentrode => CurveKind::Centrode,
            OverlayKind::Swept | OverlayKind::Workspace | OverlayKind::Barrier => CurveKind::Region,
        },
        body_idx: overlay.body,
        pieces: overlay
            .lines
            .iter()
            .map(|line| line.iter().map(|p| [p[0], p[1]]).collect())
            .collect(),
        is_closed: overlay.is_closed,
    };
    Ok(found.into_iter().map(curve).collect())
}

fn position(body: &Body, point: Option<&str>) -> Option<bksim::model::Vector> {
    match point {
        None => Some(body.com),
        Some(name) => body.points.iter().find(|p| p.name == name).map(|p| p.position),
    }
}

fn no_point(args: &Trace, name: &str, model: &Model) -> Failure {
    let all = model.bodies.iter().skip(1);
    let all = all.flat_map(|b| b.points.iter().map(move |p| format!("{}.{}", b.name, p.name)));
    let help = format!("one of {}", all.collect::<Vec<_>>().join(", "));
    let message = format!("the run has no point `{name}`");
    let fault = Diagnostic::error(codes::UNKNOWN_POINT, message).help(help);
    let source = Text::new(args.log.clone(), String::new());
    Failure::Model { source: Box::new(source), diagnostics: vec![fault] }
}

/// True if a point goes anywhere.
fn moves(course: &Course, point: &Traced) -> bool {
    let at = |idx: usize| course.poses[idx][point.body_idx].place(point.at);
    let first = at(0);
    (1..course.times.len()).any(|idx| far(at(idx), first))
}

/// True if two points are at one place throughout.
fn is_same(course: &Course, a: &Traced, b: &Traced) -> bool {
    let at = |idx: usize, point: &Traced| course.poses[idx][point.body_idx].place(point.at);
    (0..course.times.len()).all(|idx| !far(at(idx, a), at(idx, b)))
}

/// Farther than what constraints leave open.
fn far(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) > 1e-6 * (1.0 + a[0].abs().max(a[1].abs()))
}

fn selection(args: &Trace, times: &[f64]) -> Selection {
    let all = !(args.paths || args.envelope || args.hodograph || args.reactions)
        && args.ghosts.is_none()
        && args.curve.is_empty();
    let at = match args.at.as_slice() {
        // Without the last one, which in many motions is the first again.
        [] => even_samples(times, 5).into_iter().take(4).collect(),
        stated => stated.iter().map(|&t| nearest_sample(times, t)).collect(),
    };
    let n_ghosts = args.ghosts.map_or(if all { 6 } else { 0 }, usize::from);
    Selection {
        paths: all || args.paths,
        envelope: all || args.envelope,
        hodograph: all || args.hodograph,
        reactions: if all || args.reactions { at } else { Vec::new() },
        ghosts: even_samples(times, n_ghosts),
    }
}

/// A warning where joints of the drawing are not where the run had them on their bodies.
fn other_drawing(
    mechanism: &Mechanism,
    composition: &Composition,
    per_metre: f64,
) -> Option<Diagnostic> {
    let model = &mechanism.model;
    let named = |name: &str| {
        let name = composition.model_name(name);
        model.joints.iter().find(|joint| joint.name == name)
    };
    let differs = |report: &&bksim::cad::compose::JointReport| {
        let Some(joint) = named(&report.name) else { return true };
        let body = &model.bodies[joint.successor.body.0];
        let drawn =
            composition.bodies.iter().find(|b| composition.model_name(&b.name) == body.name);
        let (Some(drawn), Some(point)) = (drawn, joint.successor.point) else { return false };
        let inward = drawn.frame.point_inward(report.at[1]);
        let run = place(mechanism, body.points[point.0].position).unwrap_or_default();
        let off = (inward[0] / per_metre - run[0]).hypot(inward[1] / per_metre - run[1]);
        off * per_metre > composition.tolerance
    };
    let moved = composition.joints.iter().find(differs)?;
    let message = if named(&moved.name).is_some() {
        format!("joint `{}` is not where the run had it: the drawing has changed since", moved.name)
    } else {
        format!("the run has no joint `{}`: the drawing has changed since", moved.name)
    };
    Some(Diagnostic::warning(codes::OTHER_DRAWING, message).help("solve the drawing again"))
}
