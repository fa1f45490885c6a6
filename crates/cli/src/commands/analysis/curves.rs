//! `bksim curves`: ways of points, instant centres and centrodes, swept regions, workspaces.

use bksim::analysis::{
    CentrePlace, Column, Curves, CurvesRequest, InstantCentre, PointCurves, PoseOf, Table,
    Workspace, curves, workspaces,
};
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked_geometry, beyond, failed, lines, shown};
use crate::args::analysis::Curves as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::waiting::waiting;

const COMMAND: &str = "curves";

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, model, warnings, file) =
        asked_geometry(&args.model, &args.table, nesting)?.parts();
    let failed = failed(&source);
    let name = model.name.clone();
    let answer = if args.workspace.is_empty() {
        let request = request(&args.point, &args.centrode, &args.swept, args.all);
        let found = waiting("tracing curves", || curves(model, &request));
        told(&name, &found.map_err(&failed)?)
    } else {
        let found = waiting("tracing workspaces", || workspaces(model, &args.workspace));
        told_workspaces(&name, &found.map_err(&failed)?)
    };
    Asked::answer(&source, &warnings, file, answer, as_json)
}

/// The request for these points, bodies with centrodes, `coupler` or `coupler/crank`, and bodies that sweep.
pub fn request(
    points: &[String],
    centrodes: &[String],
    swept: &[String],
    all_assemblies: bool,
) -> CurvesRequest {
    let pair = |text: &String| match text.split_once('/') {
        Some((moving, fixed)) => (moving.to_owned(), Some(fixed.to_owned())),
        None => (text.clone(), None),
    };
    CurvesRequest {
        points: points.to_vec(),
        centrodes: centrodes.iter().map(pair).collect(),
        swept: swept.to_vec(),
        all_assemblies,
    }
}

/// The answer about a model of this name.
pub fn told(name: &str, found: &Curves) -> Answer {
    let mut text = format!("{name}: curves{}", beyond(&found.beyond));
    for point in &found.points {
        text.extend([point_text(point)]);
    }
    if !found.centres.is_empty() {
        let row = |centre: &InstantCentre| {
            let place = match centre.place {
                CentrePlace::At([x, y]) => format!("{}, {}", shown(x, "m"), shown(y, "m")),
                CentrePlace::Towards([x, y]) => {
                    format!("at infinity, towards {}, {}", number(x), number(y))
                }
                CentrePlace::Everywhere => "they do not move against each other".to_owned(),
            };
            vec![centre.bodies.join(", "), place]
        };
        let rows = found.centres.iter().map(row).collect();
        text.extend([format!("\n\n{}", lines(&["bodies", "instant centre at the start"], rows))]);
    }
    for centrodes in &found.centrodes {
        let [fixed, moving] = &centrodes.bodies;
        text.extend([format!(
            "\n\n  centrodes of {moving} against {fixed}, branch {}: {}",
            centrodes.branch,
            counted(centrodes.fixed.len(), "piece", "pieces")
        )]);
    }
    for region in &found.swept {
        let area = shown(region.area, "m^2");
        text.extend([format!("\n\n  {} sweeps {area}, branch {}", region.body, region.branch)]);
    }
    let place = |centre: &InstantCentre| {
        let (at, towards) = match centre.place {
            CentrePlace::At(p) => (Some(p), None),
            CentrePlace::Towards(p) => (None, Some(p)),
            CentrePlace::Everywhere => (None, None),
        };
        json!({ "bodies": centre.bodies, "at": at, "towards": towards })
    };
    let json = json!({
        "points": found.points.iter().map(point_json).collect::<Vec<_>>(),
        "beyond": found.beyond,
        "centres": found.centres.iter().map(place).collect::<Vec<_>>(),
        "centrodes": found.centrodes.iter().map(|c| json!({
            "bodies": c.bodies, "branch": c.branch, "fixed": c.fixed, "moving": c.moving,
        })).collect::<Vec<_>>(),
        "swept": found.swept.iter().map(|s| json!({
            "body": s.body, "branch": s.branch, "rings": s.rings, "area": s.area,
        })).collect::<Vec<_>>(),
    });
    Answer { command: COMMAND, json, text, table: found.table() }
}

fn point_text(point: &PointCurves) -> String {
    let mut text = String::new();
    for branch in &point.branches {
        text.extend([format!(
            "\n\n  {}, branch {}: {} {}",
            point.name,
            branch.branch,
            shown(branch.length, "m"),
            match (branch.is_closed, branch.n_laps) {
                (false, _) => "from end to end".to_owned(),
                (true, Some(1)) => "round".to_owned(),
                (true, Some(n)) => format!("round, {n} times until the motion comes back"),
                (true, None) => "round, again and again: the motion does not come back".to_owned(),
            }
        )]);
    }
    let pose = |of: &PoseOf| {
        let first = of.pose.first().map_or(String::new(), |(name, value)| {
            format!("{name} = {}", shown(*value, if name.contains(".angle") { "rad" } else { "m" }))
        });
        if point.branches.len() > 1 { format!("{first} (branch {})", of.branch) } else { first }
    };
    let place = |at: [f64; 2]| at.map(|x| shown(x, "m")).join(", ");
    if !point.double_points.is_empty() {
        let row = |double: &bksim::analysis::DoublePoint| {
            let [a, b] = &double.poses;
            vec![place(double.at), pose(a), pose(b)]
        };
        let rows = point.double_points.iter().map(row).collect();
        text.extend([format!("\n\n{}", lines(&["double point", "at", "and at"], rows))]);
    }
    if !point.cusps.is_empty() {
        let row = |cusp: &bksim::analysis::Cusp| vec![place(cusp.at), pose(&cusp.pose)];
        let rows = point.cusps.iter().map(row).collect();
        text.extend([format!("\n\n{}", lines(&["cusp", "at"], rows))]);
    }
    text
}

fn point_json(point: &PointCurves) -> Value {
    let pose = |of: &PoseOf| {
        let pose = of.pose.iter().map(|(name, value)| (name.clone(), json!(value)));
        json!({ "branch": of.branch, "pose": Value::Object(pose.collect()) })
    };
    let doubles = point.double_points.iter().map(|double| {
        json!({ "at": double.at, "poses": double.poses.iter().map(pose).collect::<Vec<_>>() })
    });
    json!({
        "name": point.name,
        "branches": point.branches.iter().map(|branch| json!({
            "branch": branch.branch,
            "closed": branch.is_closed,
            "laps": branch.n_laps,
            "length": branch.length,
            "points": branch.points,
        })).collect::<Vec<_>>(),
        "double_points": doubles.collect::<Vec<_>>(),
        "cusps": point.cusps.iter().map(|cusp| {
            json!({ "at": cusp.at, "pose": pose(&cusp.pose) })
        }).collect::<Vec<_>>(),
    })
}

/// The answer about a model of this name: where points can be brought.
pub fn told_workspaces(name: &str, found: &[Workspace]) -> Answer {
    let row = |w: &Workspace| {
        vec![
            w.name.clone(),
            shown(w.area, "m^2"),
            w.boundary.len().to_string(),
            w.barriers.len().to_string(),
        ]
    };
    let rows = found.iter().map(row).collect();
    let heads = ["workspace", "area", "pieces of boundary", "barriers inside"];
    let text = format!("{name}: workspaces\n\n{}", lines(&heads, rows));
    let all = found.iter().map(|w| {
        json!({
            "name": w.name, "area": w.area, "boundary": w.boundary, "barriers": w.barriers,
        })
    });
    let heads = [("curve", ""), ("barrier", ""), ("x", "m"), ("y", "m")];
    let columns = heads.iter().map(|(name, unit)| Column::new(*name, *unit)).collect();
    let mut rows = Vec::new();
    let mut curve = 0.0;
    for workspace in found {
        for (barrier, pieces) in [(0.0, &workspace.boundary), (1.0, &workspace.barriers)] {
            for piece in pieces {
                curve += 1.0;
                rows.extend(piece.iter().map(|p| vec![curve, barrier, p[0], p[1]]));
            }
        }
    }
    let json = json!({ "workspaces": all.collect::<Vec<_>>() });
    Answer { command: COMMAND, json, text, table: Table { columns, rows } }
}
