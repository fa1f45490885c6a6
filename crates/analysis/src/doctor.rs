//! Faults in the freedoms of a mechanism: free motions, conditions that repeat others, and what cures
//! them.
//!
//! Everything is read off G, the slopes of all joints' rows in coordinates of the bodies, and W, the wrenches that keep
//! these rows, in the pose of the start:
//!
//! ```text
//! G δq = 0                             free motions
//! column i of W = Σ c_k column k, k < i   condition i repeats those with c_k ≠ 0
//! mobility = n − rank G,               redundant = mobility − Kutzbach's number
//! ```

mod alignment;
mod cures;
mod drives;
mod motions;
mod pose;
mod singular;

use std::collections::BTreeSet;

use bksim_model::{Coupling, CouplingKind, JointId, Model};
use bksim_sim::mobility::freedoms_of_body;
use bksim_sim::redundancy::{self, Keeper, repeated_conditions};

pub use self::alignment::Alignment;
pub use self::cures::{Count, Cure};
pub use self::drives::DriveCheck;
pub use self::motions::FreeMotion;
pub use self::singular::{SingularPose, Singularity, singular_poses};

pub(crate) use self::drives::start;
pub(crate) use self::pose::{Placed, Pose as PlacedPose};
pub(crate) use self::singular::{crossing, orientation};

use self::pose::Pose;
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
    /// Joints and conditions that hold between rates, and leave as many positions free: not counted.
    pub rates: Vec<String>,
    /// The counts.
    pub count: Count,
    /// Free motions, as many as the mobility.
    pub motions: Vec<FreeMotion>,
    /// Repeated conditions, as many as are redundant.
    pub repeated: Vec<Repeated>,
    /// Changes that leave nothing twice, the smallest first.
    pub cures: Vec<Cure>,
    /// The drives of the model, which none of the above counts.
    pub drives: Vec<DriveCheck>,
    /// The axes and points that must be parallel or in line for the mechanism to move as it does.
    pub alignments: Vec<Alignment>,
}

/// A condition of a joint that others keep already.
#[derive(Clone, PartialEq, Debug)]
pub struct Repeated {
    /// The condition.
    pub condition: Condition,
    /// Conditions that it follows from.
    pub by: Vec<Condition>,
}

/// One condition of a joint or coupling.
#[derive(Clone, PartialEq, Debug)]
pub struct Condition {
    /// Name of the joint or coupling.
    pub of: String,
    /// `force`, `moment`, `force and moment` or `coupling`.
    pub effort: &'static str,
    /// Direction of the condition: `x`, `y`, `z` or `oblique` in the axes of the joint; `length`, `normal` or `motion`.
    pub direction: &'static str,
    /// The unit vector along it, axes of the joint; none of what has one direction only.
    pub axis: Option<[f64; 3]>,
    /// All of this in words.
    pub words: String,
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
    let (repeated, shared) = repeated(&placed)?;
    let joint = |joint: &bksim_model::Joint| {
        let taken = joint.kind.n_taken(model.space) - joint.kind.n_rates();
        (joint.name.clone(), joint.kind.word(), taken)
    };
    let rolling = model.joints.iter().filter(|joint| joint.kind.n_rates() > 0);
    let (of_rates, couplings): (Vec<&Coupling>, Vec<&Coupling>) =
        model.couplings.iter().partition(|of| of.kind == CouplingKind::Rate);
    let names = |of: &[&Coupling]| of.iter().map(|of| of.name.clone()).collect::<Vec<_>>();
    Ok(Doctor {
        bodies: model.bodies.iter().skip(1).map(|body| body.name.clone()).collect(),
        freedoms_of_body: freedoms_of_body(model.space),
        joints: model.joints.iter().map(joint).collect(),
        couplings: names(&couplings),
        rates: rolling.map(|joint| joint.name.clone()).chain(names(&of_rates)).collect(),
        motions: motions::free_motions(&placed)?,
        cures: cures::cures(model, &pose, &shared, count)?,
        alignments: alignment::alignments(model, &pose, &shared),
        drives,
        repeated,
        count,
    })
}

/// Conditions that follow from those before them, and the joints that take part, in file order.
fn repeated(placed: &Placed) -> Result<(Vec<Repeated>, Vec<JointId>), AnalysisError> {
    let (model, system) = (&placed.model, &placed.system);
    let at = (placed.t, placed.q.as_slice());
    let found = repeated_conditions(model, system, &placed.parameters, at)?;
    let all = found.iter().flat_map(|repeated| repeated.by.iter().chain([&repeated.condition]));
    let joints = all.filter_map(|condition| match condition.of {
        Keeper::Joint(joint) => Some(joint.0),
        Keeper::Coupling(_) => None,
    });
    let shared: BTreeSet<usize> = joints.collect();
    let named = |condition: &redundancy::Condition| Condition {
        of: condition.name(model).to_owned(),
        effort: condition.effort(),
        direction: condition.direction_word(model),
        axis: condition.direction.axis(),
        words: condition.words(model),
    };
    let repeated = found.iter().map(|repeated| Repeated {
        condition: named(&repeated.condition),
        by: repeated.by.iter().map(named).collect(),
    });
    Ok((repeated.collect(), shared.into_iter().map(JointId).collect()))
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
