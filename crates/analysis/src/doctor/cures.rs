//! Changes of joints that leave no condition twice, each counted again in the changed model.

use bksim_model::{CouplingKind, Joint, JointId, JointKind, Measure, Model, Signal, Space, Vector};
use bksim_sim::mobility::gruebler;

use super::pose::{Placed, Pose};
use crate::error::AnalysisError;
use crate::rows::rank;

/// Degrees of freedom of a model in a pose.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Count {
    /// Grübler's or Kutzbach's number.
    pub counted: i64,
    /// Motions that the pose has.
    pub mobility: i64,
    /// Conditions that repeat others.
    pub n_redundant: i64,
}

/// A set of changes after which fewer conditions repeat others.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Cure {
    /// Joint, the type that it has, the type to write.
    pub changes: Vec<(String, &'static str, &'static str)>,
    /// The count of the changed model.
    pub count: Count,
}

/// Counts the degrees of freedom in a pose.
pub(super) fn count(placed: &Placed) -> Count {
    let n = i64::try_from(placed.q.len()).unwrap_or(i64::MAX);
    let rank = i64::try_from(rank(&placed.jacobian())).unwrap_or(0);
    // Conditions between rates leave positions free.
    let of_rates = |n: i64, joint: &Joint| n + joint.kind.n_rates();
    let of_rates = placed.model.joints.iter().fold(0, of_rates);
    let couplings = placed.model.couplings.iter().filter(|of| of.kind == CouplingKind::Rate);
    let counted = couplings.fold(gruebler(&placed.model) + of_rates, |n, _| n + 1);
    Count { counted, mobility: n - rank, n_redundant: n - rank - counted }
}

/// One change of a joint.
#[derive(Clone, Copy, Debug)]
struct Change {
    joint: JointId,
    kind: JointKind,
    /// Direction of a slot in a plane, where the joint had none.
    along: Option<[i64; 3]>,
}

/// Sets of changes of the `shared` joints that cure, the smallest first; of one size, those that leave nothing
/// twice first. The mobility stays.
pub(super) fn cures(
    model: &Model,
    pose: &Pose,
    shared: &[JointId],
    own: Count,
) -> Result<Vec<Cure>, AnalysisError> {
    /// Most sets that are counted.
    const MOST: usize = 600;
    if own.n_redundant <= 0 {
        return Ok(Vec::new());
    }
    let changes: Vec<Change> =
        shared.iter().flat_map(|&joint| replacements(model, joint)).collect();
    let mut found: Vec<Cure> = Vec::new();
    let mut n_counted = 0;
    let mut open: Vec<Vec<Change>> = vec![Vec::new()];
    // Set by set, one change more at a time; what cures is not changed further.
    while !open.is_empty() && n_counted < MOST {
        let mut next: Vec<(i64, Vec<Change>)> = Vec::new();
        for set in &open {
            let from = set.last().map_or(0, |last: &Change| last.joint.0 + 1);
            for change in changes.iter().filter(|change| change.joint.0 >= from) {
                if n_counted >= MOST {
                    break;
                }
                n_counted += 1;
                let set = [&set[..], &[*change]].concat();
                let Some(after) = recount(model, pose, &set)? else { continue };
                if after.mobility != own.mobility || after.n_redundant >= own.n_redundant {
                    continue;
                }
                if after.n_redundant == 0 {
                    found.push(Cure { changes: told(model, &set), count: after });
                } else {
                    next.push((after.n_redundant, set));
                }
            }
        }
        if !found.is_empty() {
            break;
        }
        next.sort_by_key(|(n_redundant, _)| *n_redundant);
        // The most promising ones go on.
        open = next.into_iter().map(|(_, set)| set).take(40).collect();
    }
    found.sort_by_key(|cure| n_freed(&cure.changes));
    found.dedup();
    found.truncate(12);
    Ok(found)
}

/// Number of freedoms that changes add.
fn n_freed(changes: &[(String, &'static str, &'static str)]) -> usize {
    let n = |word: &str| bksim_model::JointType::of_word(word).map_or(0, |of| of.motions.len());
    changes.iter().map(|(_, from, to)| n(to).saturating_sub(n(from))).sum()
}

fn told(model: &Model, set: &[Change]) -> Vec<(String, &'static str, &'static str)> {
    let change = |change: &Change| {
        let joint = &model.joints[change.joint.0];
        (joint.name.clone(), joint.kind.word(), change.kind.word())
    };
    set.iter().map(change).collect()
}

/// The kinds with more freedom that can stand in the place of a joint's own.
fn replacements(model: &Model, joint: JointId) -> Vec<Change> {
    let of = &model.joints[joint.0];
    let is_measured = |signal: &Signal| match signal.measure {
        Measure::JointPosition(of, _) | Measure::JointVelocity(of, _) => of == joint,
        _ => false,
    };
    let is_coupled = !model.couplings.is_empty() && model.signals.iter().any(is_measured);
    let is_driven = model.drives.iter().any(|drive| drive.joint == joint);
    if is_coupled || is_driven {
        return Vec::new();
    }
    let as_it_is = |kind| Change { joint, kind, along: None };
    let slots = || {
        [[1, 0, 0], [0, 1, 0]].map(|along| Change {
            joint,
            kind: JointKind::PinInSlot,
            along: Some(along),
        })
    };
    if model.space == Space::Planar {
        return match of.kind {
            JointKind::Revolute => slots().to_vec(),
            JointKind::Prismatic { .. } => vec![as_it_is(JointKind::PinInSlot)],
            JointKind::Weld { .. } => vec![as_it_is(JointKind::Revolute)],
            _ => Vec::new(),
        };
    }
    let mut all = Vec::new();
    if of.kind == JointKind::Revolute {
        all.extend(universals(model, &of.axis).into_iter().map(as_it_is));
    }
    let kinds: &[JointKind] = match of.kind {
        JointKind::Revolute => {
            &[JointKind::Cylindrical, JointKind::Spherical, JointKind::PointOnLine]
        }
        JointKind::Prismatic { .. } | JointKind::Screw { .. } => &[JointKind::Cylindrical],
        JointKind::Cylindrical | JointKind::Spherical => &[JointKind::PointOnLine],
        JointKind::Weld { .. } => &[JointKind::Revolute, JointKind::Spherical],
        JointKind::Universal { .. } => &[JointKind::Spherical],
        JointKind::Planar | JointKind::PointOnLine => &[JointKind::PointOnPlane],
        _ => &[],
    };
    all.extend(kinds.iter().map(|&kind| as_it_is(kind)));
    all
}

/// Universal joints about `axis` and an axis of the frame across it.
fn universals(model: &Model, axis: &Vector) -> Vec<JointKind> {
    let value = |symbol| {
        model.parameters.iter().find(|p| p.symbol == symbol).map(|parameter| parameter.value)
    };
    let across =
        |&k: &usize| model.pool.evaluate(axis[k], &value).is_ok_and(|along| along.abs() < ACROSS);
    let second = |k: usize| {
        let part = |i: usize| if i == k { model.pool.one() } else { model.pool.zero() };
        JointKind::Universal { second: std::array::from_fn(part) }
    };
    (0..3).filter(across).map(second).collect()
}

/// Cosine below which two axes are at right angles.
const ACROSS: f64 = 1e-9;

/// The count of the changed model; none where it is no model in this pose.
fn recount(model: &Model, pose: &Pose, set: &[Change]) -> Result<Option<Count>, AnalysisError> {
    let mut changed = model.snapshot().to_model();
    for change in set {
        let number = |n: i64| changed.pool.rational(n, 1);
        let along = change.along.map(|along| along.map(number));
        let joint = &mut changed.joints[change.joint.0];
        joint.kind = change.kind;
        joint.coordinate_names.clear();
        if let Some(along) = along {
            joint.axis = along;
        }
    }
    let placed = Placed::of(&changed, pose)?;
    // A slot that the pin is in, and so on: the pose must close the changed model, too.
    let is_closed = placed.at(&placed.q).0.iter().all(|value| value.abs() < 1e-6);
    Ok(is_closed.then(|| count(&placed)))
}
