//! Curves of a mechanism, to be laid over its pictures and drawings.

use bksim_analysis::{AnalysisError, CurvesRequest, curves, workspaces};
use bksim_model::Model;
use bksim_model::diagnostic::Rejected;
use bksim_scene::{Form, Role, Scene, Shape};

/// A curve on a body of the mechanism.
#[derive(Clone, PartialEq, Debug)]
pub struct Overlay {
    /// The curve, as it was asked for.
    pub name: String,
    /// Kind of the overlay.
    pub kind: OverlayKind,
    /// Number of the body in whose frame it stands, the ground 0.
    pub body: usize,
    /// Pieces of the overlay, m.
    pub lines: Vec<Vec<[f64; 3]>>,
    /// True if each piece comes back to where it began.
    pub is_closed: bool,
}

/// Kind of an overlay.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum OverlayKind {
    /// The way of a point.
    Way,
    /// Where an instant centre goes on the body taken as fixed.
    FixedCentrode,
    /// Where it goes on the moving body.
    MovingCentrode,
    /// The boundary of what a body sweeps.
    Swept,
    /// The boundary of a workspace.
    Workspace,
    /// A curve inside of a workspace.
    Barrier,
}

/// The curves of a model, which `read` reads again for each, that texts ask for: `coupler.P` the way of a point, `centrode:coupler` and
/// `centrode:coupler/crank`, `swept:rocker`, `workspace:arm.P`.
///
/// # Errors
/// [`AnalysisError`] as of [`curves`] and [`workspaces`].
pub fn overlays(
    read: &dyn Fn() -> Result<Model, Rejected>,
    texts: &[String],
) -> Result<Vec<Overlay>, AnalysisError> {
    let mut all = Vec::new();
    for text in texts {
        let model = read()?;
        all.extend(match text.split_once(':') {
            Some(("workspace", point)) => of_workspace(text, model, point)?,
            _ => of_curves(text, model)?,
        });
    }
    Ok(all)
}

fn of_workspace(text: &str, model: Model, point: &str) -> Result<Vec<Overlay>, AnalysisError> {
    let found = workspaces(model, &[point.to_owned()])?;
    let overlay = |kind, pieces: &[Vec<[f64; 2]>]| {
        let lines = pieces.iter().map(|piece| lifted(piece)).collect();
        Overlay { name: text.to_owned(), kind, body: 0, lines, is_closed: false }
    };
    let both = found.iter().flat_map(|w| {
        [overlay(OverlayKind::Workspace, &w.boundary), overlay(OverlayKind::Barrier, &w.barriers)]
    });
    Ok(both.collect())
}

fn of_curves(text: &str, model: Model) -> Result<Vec<Overlay>, AnalysisError> {
    let request = match text.split_once(':') {
        Some(("centrode", bodies)) => {
            let (moving, fixed) = bodies
                .split_once('/')
                .map_or((bodies, None), |(moving, fixed)| (moving, Some(fixed.to_owned())));
            CurvesRequest {
                centrodes: vec![(moving.to_owned(), fixed)],
                ..CurvesRequest::default()
            }
        }
        Some(("swept", body)) => {
            CurvesRequest { swept: vec![body.to_owned()], ..CurvesRequest::default() }
        }
        _ => CurvesRequest { points: vec![text.to_owned()], ..CurvesRequest::default() },
    };
    let names: Vec<String> = model.bodies.iter().map(|body| body.name.clone()).collect();
    let number = |name: &str| names.iter().position(|known| known == name).unwrap_or(0);
    let found = curves(model, &request)?;
    let overlay = |kind, body, lines, is_closed| Overlay {
        name: text.to_owned(),
        kind,
        body,
        lines,
        is_closed,
    };
    let flat = |pieces: &[Vec<[f64; 2]>]| pieces.iter().map(|piece| lifted(piece)).collect();
    let mut all = Vec::new();
    for branch in found.points.iter().flat_map(|point| &point.branches) {
        all.push(overlay(OverlayKind::Way, 0, vec![branch.points.clone()], branch.is_closed));
    }
    for centrodes in &found.centrodes {
        let [fixed, moving] = centrodes.bodies.each_ref().map(|name| number(name));
        all.push(overlay(OverlayKind::FixedCentrode, fixed, flat(&centrodes.fixed), false));
        all.push(overlay(OverlayKind::MovingCentrode, moving, flat(&centrodes.moving), false));
    }
    for region in &found.swept {
        all.push(overlay(OverlayKind::Swept, 0, flat(&region.rings), true));
    }
    Ok(all)
}

fn lifted(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
    points.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

/// Lays curves over a scene: lines on their bodies, swept regions under everything, each with a colour of its own.
pub fn lay_over(scene: &mut Scene, overlays: &[Overlay]) {
    let mut names: Vec<&str> = overlays.iter().map(|overlay| overlay.name.as_str()).collect();
    names.dedup();
    for overlay in overlays {
        let of_name = names.iter().position(|name| *name == overlay.name).unwrap_or(0);
        // Both centrodes of a pair differ in colour.
        let more = usize::from(overlay.kind == OverlayKind::MovingCentrode);
        let colour = u8::try_from((of_name + more) % 6).unwrap_or(0);
        if overlay.kind == OverlayKind::Swept {
            let form = Form::Region(overlay.lines.clone());
            scene.shapes.insert(0, Shape { body: overlay.body, role: Role::Swept(colour), form });
            continue;
        }
        let role = match overlay.kind {
            OverlayKind::Barrier => Role::FaintCurve(colour),
            _ => Role::Curve(colour),
        };
        for line in &overlay.lines {
            let points = line.clone();
            let form = Form::Line { points, is_closed: overlay.is_closed };
            scene.shapes.push(Shape { body: overlay.body, role, form });
        }
    }
}
