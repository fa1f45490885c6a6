//! Faults in the freedoms of a mechanism: free motions, conditions that repeat others, and what cures
//! them.
//!
//! Everything is read off G, the slopes of all joints' rows in coordinates of the bodies, in the pose of the start:
//!
//! ```text
//! G δq = 0                       free motions
//! row i = Σ c_k row k, k < i     row i repeats those with c_k ≠ 0
//! mobility = n − rank G,         redundant = mobility − Kutzbach's number
//! ```

mod alignment;
mod cures;
mod drives;
mod motions;
mod pose;
mod singular;

use bksim_mbs::constraint::Source;
use bksim_model::{JointId, Model, MotionKind};
use bksim_sim::mobility::{freedoms_of_body, taken};
use nalgebra::{DMatrix, DVector};

pub use self::alignment::Alignment;
pub use self::cures::{Count, Cure};
pub use self::drives::DriveCheck;
pub use self::motions::FreeMotion;
pub use self::singular::{SingularPose, Singularity, singular_poses};

use self::pose::{Placed, Pose};
use crate::error::AnalysisError;
use crate::table::{Column, Table};

/// The freedoms of a mechanism in its start, drives aside.
#[derive(Clone, PartialEq, Debug)]
pub struct Doctor {
    /// Names of the bodies that can move.
    pub bodies: Vec<String>,
    /// Freedoms of each of them alone: 3 in a plane, 6 in space.
    pub freedoms_of_body: i64,
    /// Joints with their types and the freedoms that each takes.
    pub joints: Vec<(String, &'static str, i64)>,
    /// Couplings, each of which takes one.
    pub couplings: Vec<String>,
    /// The counts.
    pub count: Count,
    /// As many as the mobility.
    pub motions: Vec<FreeMotion>,
    /// As many as are redundant.
    pub repeated: Vec<Repeated>,
    /// Changes that leave nothing twice, the smallest first.
    pub cures: Vec<Cure>,
    /// The drives of the model, which none of the above counts.
    pub drives: Vec<DriveCheck>,
    /// The axes and points that must be parallel or in line for the mechanism to move as it does.
    pub alignments: Vec<Alignment>,
}

/// A condition of a joint that others keep already.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Repeated {
    /// The condition.
    pub condition: Condition,
    /// Those that it follows from.
    pub by: Vec<Condition>,
}

/// One condition of a joint or coupling.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Condition {
    /// Name of the joint or coupling.
    pub of: String,
    /// Its direction: `x`, `y`, `z`, `normal`, `angle`, `length`, `motion` or `coupling`.
    pub direction: &'static str,
    /// True where a moment keeps it, else a force.
    pub is_moment: bool,
}

/// Finds the freedoms of `model`, which needs no masses.
///
/// # Errors
/// [`AnalysisError::Rejected`] when the start does not close.
pub fn doctor(model: Model) -> Result<Doctor, AnalysisError> {
    let written = model.snapshot().to_model();
    let positions = drives::start(model)?;
    let pose = Pose::of(&positions)?;
    let drives = drives::drives(&written, &positions)?;
    let model = positions.model();
    let placed = Placed::of(model, &pose)?;
    let count = cures::count(&placed);
    let (repeated, shared) = repeated(&placed);
    let joint = |joint: &bksim_model::Joint| {
        (joint.name.clone(), joint.kind.word(), taken(model.space, &joint.kind))
    };
    Ok(Doctor {
        bodies: model.bodies.iter().skip(1).map(|body| body.name.clone()).collect(),
        freedoms_of_body: freedoms_of_body(model.space),
        joints: model.joints.iter().map(joint).collect(),
        couplings: model.couplings.iter().map(|coupling| coupling.name.clone()).collect(),
        motions: motions::free_motions(&placed)?,
        cures: cures::cures(model, &pose, &shared, count)?,
        alignments: alignment::alignments(model, &pose, &shared),
        drives,
        repeated,
        count,
    })
}

/// Parts of a row of the size one below which nothing is left of it.
const NOTHING: f64 = 1e-8;

/// Rows that follow from those before them, and the joints that take part, in file order.
fn repeated(placed: &Placed) -> (Vec<Repeated>, Vec<JointId>) {
    let jacobian = placed.jacobian();
    let constraints = &placed.system.constraints;
    // Lengths of quaternions first, then joints and couplings in file order.
    let mut order: Vec<usize> = (0..jacobian.nrows()).collect();
    order.sort_by_key(|&row| match constraints[row].source {
        Source::Quaternion(body) => (0, body.0),
        Source::Joint(joint) => (1, joint.0),
        _ => (2, row),
    });
    let (mut kept, mut basis): (Vec<usize>, Vec<DVector<f64>>) = (Vec::new(), Vec::new());
    let (mut found, mut shared) = (Vec::new(), Vec::new());
    for row in order {
        let own = jacobian.row(row).transpose();
        let size = own.norm();
        let mut rest = own.clone();
        for direction in basis.iter().chain(&basis) {
            let along = direction.dot(&rest);
            rest -= direction * along;
        }
        if size > 0.0 && rest.norm() > NOTHING * size {
            kept.push(row);
            basis.push(rest.normalize());
            continue;
        }
        // The rows that it is made of.
        let mut before = DMatrix::zeros(own.len(), kept.len());
        for (k, &row) in kept.iter().enumerate() {
            before.set_column(k, &jacobian.row(row).transpose());
        }
        let shares = if kept.is_empty() {
            DVector::zeros(0)
        } else {
            before
                .clone()
                .svd(true, true)
                .solve(&own, 1e-12)
                .unwrap_or_else(|_| DVector::zeros(kept.len()))
        };
        let part =
            |k: &usize| shares[*k].abs() * before.column(*k).norm() > 1e-7 * size.max(1e-300);
        let made_of: Vec<usize> = (0..kept.len()).filter(part).map(|k| kept[k]).collect();
        for &row in made_of.iter().chain([&row]) {
            if let Source::Joint(joint) = constraints[row].source
                && !shared.contains(&joint)
            {
                shared.push(joint);
            }
        }
        let made_of = made_of.into_iter();
        let is_told = |row: &usize| !matches!(constraints[*row].source, Source::Quaternion(_));
        let mut by: Vec<Condition> =
            made_of.filter(is_told).map(|row| condition(placed, row)).collect();
        // Two rows of one direction are one in words.
        by.dedup();
        found.push(Repeated { condition: condition(placed, row), by });
    }
    shared.sort_unstable_by_key(|joint| joint.0);
    (found, shared)
}

fn condition(placed: &Placed, row: usize) -> Condition {
    let constraint = &placed.system.constraints[row];
    let of = match constraint.source {
        Source::Joint(joint) => placed.model.joints[joint.0].name.clone(),
        Source::Coupling(coupling) => placed.model.couplings[coupling.0].name.clone(),
        Source::Quaternion(body) => placed.model.bodies[body.0].name.clone(),
        Source::Drive(_) | Source::Stop(_) | Source::Friction(_) => String::new(),
    };
    let is_moment = constraint.effort == MotionKind::Rotation;
    Condition { of, direction: constraint.direction, is_moment }
}

impl Doctor {
    /// A row for each measure of each free motion: number of the motion, whether it goes on, then the rates of all
    /// measures that take part in any.
    pub fn table(&self) -> Table {
        let mut names: Vec<(String, &'static str)> = Vec::new();
        for (name, _, unit) in self.motions.iter().flat_map(|motion| &motion.rates) {
            if !names.iter().any(|(known, _)| known == name) {
                names.push((name.clone(), unit));
            }
        }
        let heads = [Column::new("motion", ""), Column::new("finite", "")];
        let row = |(number, motion): (usize, &FreeMotion)| {
            let rate = |(name, _): &(String, &str)| {
                let own = motion.rates.iter().find(|(known, ..)| known == name);
                own.map_or(0.0, |(_, rate, _)| *rate)
            };
            let first = [(number + 1) as f64, f64::from(u8::from(motion.is_finite))];
            first.into_iter().chain(names.iter().map(rate)).collect()
        };
        let rows = self.motions.iter().enumerate().map(row).collect();
        let columns = names.iter().map(|(name, unit)| Column::new(name.clone(), *unit));
        Table { columns: heads.into_iter().chain(columns).collect(), rows }
    }
}
