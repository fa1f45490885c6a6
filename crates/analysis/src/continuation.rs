//! Equilibria over a range of a parameter: every branch followed by arc length, with its limit points and the
//! points where branches cross.
//!
//! ```text
//! Φ(x, s) = 0,   τ tangent        limit point: τ_s = 0        branch point: det [ ∂Φ ; τᵀ ] = 0
//! ```
//!
//! Source: E. L. Allgower and K. Georg, *Introduction to Numerical Continuation Methods* (2003), chapters 8
//! and 9; H. B. Keller (1977).

use bksim_model::Model;
use nalgebra::DVector;

use crate::balance::Balance;
use crate::branches::{PointKind, Traced, apart, beside};
use crate::drive::Range;
use crate::equilibrium::{Equilibrium, Stability, cells, columns};
use crate::equilibrium_path::EquilibriumPath;
use crate::error::AnalysisError;
use crate::loaded::{HeldContacts, Loaded};
use crate::table::{Column, Table};

/// Equilibria over a range of a parameter.
#[derive(Clone, PartialEq, Debug)]
pub struct Continuation {
    /// The parameter and its unit.
    pub parameter: Column,
    /// Names of the joints, for the reactions.
    pub joints: Vec<String>,
    /// The independent quantities that the stiffness is by, with their units.
    pub by: Vec<(String, &'static str)>,
    /// Equilibria that are connected within the range, each in order along its curve.
    pub branches: Vec<EquilibriumBranch>,
    /// Stops and friction that count as constraints, and friction that is left out.
    pub held: HeldContacts,
}

/// Equilibria along one curve.
#[derive(Clone, PartialEq, Debug)]
pub struct EquilibriumBranch {
    /// In order along the curve.
    pub points: Vec<BranchPoint>,
    /// True where the curve comes back to where it began.
    pub is_closed: bool,
}

/// One equilibrium of a branch.
#[derive(Clone, PartialEq, Debug)]
pub struct BranchPoint {
    /// The reason why it is told.
    pub kind: PointKind,
    /// Name of a limit point or branch point: `L1`, `B2`; a branch point has it on every branch through it.
    pub name: Option<String>,
    /// Value of the parameter, SI.
    pub value: f64,
    /// The equilibrium.
    pub equilibrium: Equilibrium,
}

/// Most branches that are followed.
const MOST_BRANCHES: usize = 64;

/// Follows the equilibria of `model` over a `range` of the parameter `name`; the stiffness is by the measures
/// `by`, else by coordinates.
///
/// # Errors
/// [`AnalysisError`] when no parameter has this name, or no equilibrium is found at any value.
pub fn statics_over(
    model: Model,
    (name, range): (&str, Range),
    by: &[String],
) -> Result<Continuation, AnalysisError> {
    let mut loaded = Loaded::at_rest(model)?;
    let id = loaded.parameter(name)?;
    let last = (range.n - 1).max(1) as f64;
    let targets: Vec<f64> = (0..range.n).map(|k| k as f64 / last).collect();

    // Equilibria to begin with, at some of the values.
    let own = loaded.mechanism.parameters.clone();
    let mut seeds: Vec<(f64, Vec<f64>)> = Vec::new();
    let mut fault = None;
    for s in seed_values(&targets, loaded.model().joints.len()) {
        let values = loaded.parameters_with(&[id], &[range.at(s)]);
        let found = loaded
            .restart(&values[..own.len()])
            .and_then(|()| Balance::of(&loaded, &[], &[])?.isolated(name));
        match found {
            Ok(poses) => seeds.extend(poses.into_iter().map(|q| (s, q))),
            Err(error) => fault = Some(error),
        }
    }
    loaded.restart(&own)?;
    if seeds.is_empty() {
        return Err(fault.unwrap_or(AnalysisError::NoEquilibrium));
    }

    // Branches through them, and branches that cross those.
    let mut balance = Balance::of(&loaded, by, &[id])?;
    let mut found = Vec::new();
    let mut crossings: Vec<DVector<f64>> = Vec::new();
    let mut next = 0;
    while next < seeds.len() && found.len() < MOST_BRANCHES {
        let (s, q) = seeds[next].clone();
        next += 1;
        let mut curve = EquilibriumPath::about(&mut balance, range, (&q, s));
        let mut z = curve.equations.unknowns(&q, s);
        let parameter = DVector::from_fn(z.len(), |i, _| f64::from(u8::from(i + 1 == z.len())));
        if targets.contains(&s) {
            // Where the parameter cannot be held the seed is a limit point itself.
            let kept = z.clone();
            if curve.correct(&mut z, &parameter).is_none() {
                z = kept;
            }
        }
        if found.iter().any(|traced: &Traced| traced.holds(&mut curve, &z)) {
            continue;
        }
        let Some(mut traced) = Traced::through(&mut curve, z, &targets) else { continue };
        for event in traced.events.iter_mut().filter(|event| event.kind == PointKind::Crossing) {
            let is_turn = &curve.equations.is_turn;
            let known = crossings.iter().position(|z| apart(is_turn, z, &event.z) < 1e-3);
            event.crossing = Some(known.unwrap_or(crossings.len()));
            if known.is_some() {
                continue;
            }
            crossings.push(event.z.clone());
            for z in beside(&mut curve, &event.z) {
                seeds.push((z[z.len() - 1], curve.equations.position(&z)));
            }
        }
        found.push(traced);
    }
    let branches = told(&mut balance, range, &found)?;
    let first = branches.iter().flat_map(|branch: &EquilibriumBranch| &branch.points).next();
    let Some(first) = first.map(|point| (point.value, point.equilibrium.q.clone())) else {
        return Err(AnalysisError::NoEquilibrium);
    };
    balance.set(&[first.0]);
    let unit = loaded.model().parameters[id.0].unit.clone();
    Ok(Continuation {
        parameter: Column::new(name, unit),
        joints: loaded.mechanism.compiled.joints.clone(),
        by: balance.by_names(&first.1)?,
        branches,
        held: loaded.held_contacts(),
    })
}

/// The values at which equilibria are searched: of a large mechanism fewer.
fn seed_values(targets: &[f64], n_joints: usize) -> Vec<f64> {
    let most = if n_joints > 8 { 3 } else { 7 };
    let n = targets.len().min(most);
    let place = |k: usize| k * (targets.len() - 1) / (n - 1).max(1);
    (0..n).map(|k| targets[place(k)]).collect()
}

impl Continuation {
    /// A row for each point: branch, kind (0 value, 1 limit point, 2 branch point, 3 end), parameter, then as of
    /// a table of equilibria.
    pub fn table(&self) -> Table {
        let all = || self.branches.iter().flat_map(|branch| &branch.points);
        let heads = [Column::new("branch", ""), Column::new("kind", ""), self.parameter.clone()];
        let rest = columns(all().next().map(|point| &point.equilibrium), &self.joints);
        let rows = self.branches.iter().enumerate().flat_map(|(k, branch)| {
            branch.points.iter().map(move |point| {
                let kind = match point.kind {
                    PointKind::Value => 0.0,
                    PointKind::Limit => 1.0,
                    PointKind::Crossing => 2.0,
                    PointKind::End => 3.0,
                };
                [(k + 1) as f64, kind, point.value]
                    .into_iter()
                    .chain(cells(&point.equilibrium))
                    .collect()
            })
        });
        Table { rows: rows.collect(), columns: heads.into_iter().chain(rest).collect() }
    }
}

/// Branches with their equilibria; limit points and branch points get their names.
fn told(
    balance: &mut Balance<'_>,
    range: Range,
    found: &[Traced],
) -> Result<Vec<EquilibriumBranch>, AnalysisError> {
    let mut n_limits = 0;
    let mut branches = Vec::new();
    for traced in found {
        let mut points = Vec::new();
        for event in &traced.events {
            let value = range.at(event.z[event.z.len() - 1]);
            balance.set(&[value]);
            let mut equilibrium = balance.equilibrium(&event.q)?;
            let name = match event.kind {
                PointKind::Limit => {
                    n_limits += 1;
                    Some(format!("L{n_limits}"))
                }
                PointKind::Crossing => event.crossing.map(|k| format!("B{}", k + 1)),
                PointKind::Value | PointKind::End => None,
            };
            if name.is_some() {
                equilibrium.stability = Stability::Neutral;
            }
            points.push(BranchPoint { kind: event.kind, name, value, equilibrium });
        }
        if !points.is_empty() {
            branches.push(EquilibriumBranch { points, is_closed: traced.is_closed });
        }
    }
    Ok(branches)
}
