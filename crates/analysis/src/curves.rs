//! Curves of a mechanism with one free motion: the ways of points with their double points and cusps, instant
//! centres and centrodes.

use bksim_expr::Expr;
use bksim_model::{Anchor, BodyId, GROUND, Model, Space};

use crate::assemblies::closed_poses;
use crate::beyond::Beyond;
use crate::centrodes::{BodyRates, Centrodes, InstantCentre};
use crate::coupler_curve::{CouplerCurve, Tracer};
use crate::double_points::{Cusp, DoublePoint, Singular};
use crate::error::AnalysisError;
use crate::extreme::Extremes;
use crate::limits::free_curve;
use crate::positions::Positions;
use crate::rows::Clock;
use crate::swept::{Swept, swept};
use crate::table::{Column, Table};
use crate::trace::Trace;

/// The curves that are asked for.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct CurvesRequest {
    /// Points: `coupler.P`, a joint `B`, or a body for its centre of mass. Where nothing at all is named, all
    /// points of bodies that no joint connects, or else all joints between moving bodies.
    pub points: Vec<String>,
    /// Bodies whose centrodes are wanted, each with the body that is taken as fixed: the ground unless given.
    pub centrodes: Vec<(String, Option<String>)>,
    /// Bodies whose swept regions are wanted.
    pub swept: Vec<String>,
    /// True if all assemblies count, not that of the start alone.
    pub all_assemblies: bool,
}

/// Curves of all assemblies that were asked for.
#[derive(Clone, PartialEq, Debug)]
pub struct Curves {
    /// Of each point.
    pub points: Vec<PointCurves>,
    /// Of each pair of bodies, one for each assembly.
    pub centrodes: Vec<Centrodes>,
    /// Instant centres of all pairs of bodies at the start; none in space.
    pub centres: Vec<InstantCentre>,
    /// Of each body whose swept region was asked for, one for each assembly.
    pub swept: Vec<Swept>,
    /// Stops that poses lie beyond and contacts, which curves do not keep to: `stop `NAME``.
    pub beyond: Vec<String>,
}

/// The curves of one point.
#[derive(Clone, PartialEq, Debug)]
pub struct PointCurves {
    /// The point.
    pub name: String,
    /// One for each assembly.
    pub branches: Vec<PointCurve>,
    /// Places that the point passes in two poses, over all assemblies asked for, ordered by x; none in space.
    pub double_points: Vec<DoublePoint>,
    /// Places where it comes to rest and goes on sharply aside; none in space.
    pub cusps: Vec<Cusp>,
}

/// The way of a point on one branch.
#[derive(Clone, PartialEq, Debug)]
pub struct PointCurve {
    /// Number of the branch, from one.
    pub branch: usize,
    /// True where the point comes back to where it began, and goes on as before.
    pub is_closed: bool,
    /// How often it goes along this way until the whole motion comes back, as of a wheel in a train; `None` where the
    /// motion does not come back.
    pub n_laps: Option<usize>,
    /// Length of the way, once, m.
    pub length: f64,
    /// Points along it, as near to each other as it bends, m.
    pub points: Vec<[f64; 3]>,
}

/// Finds the curves of `model`, whose drives are released.
///
/// # Errors
/// [`AnalysisError`] when the start does not close, more than one motion is free, or a name is not known.
pub fn curves(model: Model, request: &CurvesRequest) -> Result<Curves, AnalysisError> {
    let positions = Positions::of(model)?;
    let released: Vec<usize> = (0..positions.model().drives.len()).collect();
    let mut rows = positions.rows(&[], &released, Clock::Held)?;
    let names = names(positions.model(), request);
    let mut tracers = Vec::new();
    for name in &names {
        tracers.push(Tracer::of(&positions, point(&positions, name)?)?);
    }
    let pairs = pairs(positions.model(), request)?;
    let sweeping = sweeping(positions.model(), request)?;
    let mut extremes = Extremes::of(&positions, &[])?;
    let is_planar = positions.model().space == Space::Planar;

    // The branch of the start, then those of other assemblies.
    let x = rows.scaled(&positions.q);
    let others =
        if request.all_assemblies { closed_poses(&positions, &mut rows) } else { Vec::new() };
    let mut curve = free_curve(&mut rows, &positions, &x)?;
    let traces = Trace::all(&mut curve, &x, &others);

    let mut beyond = Beyond::of(&positions)?;
    beyond.along(&curve, &traces);

    // Points.
    let mut points = Vec::new();
    for (name, tracer) in names.into_iter().zip(&mut tracers) {
        let ways: Vec<CouplerCurve> =
            traces.iter().map(|trace| tracer.along(&mut curve, trace)).collect();
        let mut singular = Singular { curve: &mut curve, tracer, extremes: &mut extremes };
        let (mut double_points, mut cusps) = (Vec::new(), Vec::new());
        if is_planar {
            double_points = singular.double_points(&ways);
            for (of, way) in ways.iter().enumerate() {
                cusps.extend(singular.cusps(of, way));
            }
        }
        let branch = |(of, way): (usize, &CouplerCurve)| PointCurve {
            branch: of + 1,
            is_closed: way.is_closed,
            n_laps: way.n_laps,
            length: way.length(),
            points: way.points(),
        };
        let branches = ways.iter().enumerate().map(branch).collect();
        points.push(PointCurves { name, branches, double_points, cusps });
    }

    // Instant centres and regions.
    let (mut centres, mut centrodes, mut regions) = (Vec::new(), Vec::new(), Vec::new());
    if is_planar {
        let mut rates = BodyRates::of(&positions)?;
        if let Some(start) = curve.first_point(curve.equations.unknowns(&x)) {
            centres = rates.centres(&curve, &start);
        }
        for pair in pairs {
            for (of, trace) in traces.iter().enumerate() {
                centrodes.push(rates.centrodes(&curve, (of + 1, trace), pair));
            }
        }
        for body in sweeping {
            for (of, trace) in traces.iter().enumerate() {
                regions.push(swept((&positions, &mut rates), &curve, (of + 1, trace), body));
            }
        }
    }
    let beyond = beyond.names(positions.model());
    Ok(Curves { points, centrodes, centres, swept: regions, beyond })
}

/// The points that are asked for.
fn names(model: &Model, request: &CurvesRequest) -> Vec<String> {
    let is_other = !(request.centrodes.is_empty() && request.swept.is_empty());
    if is_other || !request.points.is_empty() {
        return request.points.clone();
    }
    free_points(model)
}

/// The points of bodies that no joint connects, or else the joints between moving bodies.
fn free_points(model: &Model) -> Vec<String> {
    let is_joined = |body: usize, point: usize| {
        let ends = model.joints.iter().flat_map(|joint| [joint.predecessor, joint.successor]);
        ends.into_iter().any(|end| end.body.0 == body && end.point.is_some_and(|p| p.0 == point))
    };
    let of_body = |body: usize| {
        let own = &model.bodies[body];
        let free = (0..own.points.len()).filter(move |&point| !is_joined(body, point));
        free.map(move |point| format!("{}.{}", own.name, own.points[point].name))
    };
    let free: Vec<String> = (1..model.bodies.len()).flat_map(of_body).collect();
    if !free.is_empty() {
        return free;
    }
    let joints = model.joints.iter();
    let moving = joints.filter(|j| j.predecessor.body != GROUND && j.successor.body != GROUND);
    moving.map(|joint| joint.name.clone()).collect()
}

/// The coordinates of a point: a joint's, that of a body, or a centre of mass.
pub(crate) fn point(positions: &Positions, name: &str) -> Result<[Expr; 3], AnalysisError> {
    let model = positions.model();
    let kinematics = &positions.system().kinematics;
    if let Some(joint) = model.joints.iter().find(|joint| joint.name == name) {
        return Ok(kinematics.anchor(model, joint.successor));
    }
    for (idx, body) in model.bodies.iter().enumerate() {
        if body.name == name {
            return Ok(kinematics.position(model, BodyId(idx), None));
        }
        let rest = name.strip_prefix(&body.name).and_then(|rest| rest.strip_prefix('.'));
        let point = rest.and_then(|rest| body.points.iter().position(|point| point.name == rest));
        if let Some(point) = point {
            let point = Some(bksim_model::PointId(point));
            return Ok(kinematics.anchor(model, Anchor { body: BodyId(idx), point }));
        }
    }
    Err(AnalysisError::UnknownPoint { name: name.to_owned() })
}

/// The bodies of the centrodes that are asked for: fixed, then moving.
fn pairs(model: &Model, request: &CurvesRequest) -> Result<Vec<[BodyId; 2]>, AnalysisError> {
    let pair = |(moving, fixed): &(String, Option<String>)| {
        let fixed = fixed.as_deref().map_or(Ok(GROUND), |fixed| body(model, fixed))?;
        Ok([fixed, body(model, moving)?])
    };
    if model.space != Space::Planar && !request.centrodes.is_empty() {
        return Err(AnalysisError::NotPlanar { what: "centrodes" });
    }
    request.centrodes.iter().map(pair).collect()
}

/// The bodies whose swept regions are asked for.
fn sweeping(model: &Model, request: &CurvesRequest) -> Result<Vec<BodyId>, AnalysisError> {
    if model.space != Space::Planar && !request.swept.is_empty() {
        return Err(AnalysisError::NotPlanar { what: "swept regions" });
    }
    request.swept.iter().map(|name| body(model, name)).collect()
}

fn body(model: &Model, name: &str) -> Result<BodyId, AnalysisError> {
    let found = model.bodies.iter().position(|body| body.name == name).map(BodyId);
    found.ok_or_else(|| AnalysisError::UnknownBody { name: name.to_owned() })
}

impl Curves {
    /// A row for each point of each curve: the number of the curve from one, in the order of the answer, the branch,
    /// the piece of the curve, x, y and z. The curves of points come first; of each pair of centrodes the fixed one, then
    /// the moving one in the frame of its body; last the boundaries of swept regions.
    pub fn table(&self) -> Table {
        let heads =
            [("curve", ""), ("branch", ""), ("piece", ""), ("x", "m"), ("y", "m"), ("z", "m")];
        let columns = heads.iter().map(|(name, unit)| Column::new(*name, *unit)).collect();
        let mut rows = Vec::new();
        let mut curve = 0;
        let mut add = |curve: usize, branch: usize, piece: usize, p: [f64; 3]| {
            let [curve, branch, piece] = [curve, branch, piece].map(|n| n as f64);
            rows.push(vec![curve, branch, piece, p[0], p[1], p[2]]);
        };
        for point in &self.points {
            curve += 1;
            for branch in &point.branches {
                branch.points.iter().for_each(|p| add(curve, branch.branch, 1, *p));
            }
        }
        for centrodes in &self.centrodes {
            for pieces in [&centrodes.fixed, &centrodes.moving] {
                curve += 1;
                for (piece, points) in pieces.iter().enumerate() {
                    for p in points {
                        add(curve, centrodes.branch, piece + 1, [p[0], p[1], 0.0]);
                    }
                }
            }
        }
        for region in &self.swept {
            curve += 1;
            for (piece, ring) in region.rings.iter().enumerate() {
                for p in ring {
                    add(curve, region.branch, piece + 1, [p[0], p[1], 0.0]);
                }
            }
        }
        Table { columns, rows }
    }
}
