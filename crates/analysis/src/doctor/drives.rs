//! Drives that ask for more than is free.

use bksim_model::{Measure, Model, motion_words};
use nalgebra::DVector;

use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::rows::Clock;

/// A drive, and those that leave it nothing to move.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DriveCheck {
    /// The measure that it moves: `A.angle`.
    pub measure: String,
    /// True where the joints and the drives before it fix that measure already: one drive too many.
    pub is_too_many: bool,
    /// The drives before that it depends on; none where the joints alone fix the measure.
    pub by: Vec<String>,
}

/// Parts of the size of a row below which nothing is left of it.
const NOTHING: f64 = 1e-8;

/// The start of a model whose drives are looked at, without them where they contradict each other there.
pub(crate) fn start(model: Model) -> Result<Positions, AnalysisError> {
    if model.drives.is_empty() {
        return Positions::of(model);
    }
    let mut without = model.snapshot().to_model();
    Positions::of(model).or_else(|_| {
        without.drives.clear();
        Positions::of(without)
    })
}

/// The drives of `model` in file order, looked at where `positions` closed.
pub(super) fn drives(
    model: &Model,
    positions: &Positions,
) -> Result<Vec<DriveCheck>, AnalysisError> {
    let measures: Vec<Measure> =
        model.drives.iter().map(|d| Measure::JointPosition(d.joint, d.motion_idx)).collect();
    let names: Vec<String> = model
        .drives
        .iter()
        .map(|drive| {
            let joint = &model.joints[drive.joint.0];
            format!("{}.{}", joint.name, motion_words(joint.kind.motions(), drive.motion_idx)[0])
        })
        .collect();
    let released: Vec<usize> = (0..positions.model().drives.len()).collect();
    let mut rows = positions.rows(&measures, &released, Clock::Held)?;
    let x = rows.scaled(&positions.q);
    let jacobian = rows.at(positions.t(), &x, &vec![0.0; measures.len()]).jacobian;
    let first = rows.first_prescribed();

    // Directions of the joints' rows, then of the drives, each with the drives that it is made of.
    let mut basis: Vec<(DVector<f64>, DVector<f64>)> = Vec::new();
    let mut found = Vec::new();
    for row in 0..jacobian.nrows() {
        let own = jacobian.row(row).transpose();
        let mut made_of = DVector::zeros(measures.len());
        if row >= first {
            made_of[row - first] = 1.0;
        }
        let mut rest = own.clone();
        for _ in 0..2 {
            for (direction, parts) in &basis {
                let along = direction.dot(&rest);
                rest -= direction * along;
                made_of -= parts * along;
            }
        }
        let is_new = rest.norm() > NOTHING * own.norm();
        if let Some(k) = row.checked_sub(first) {
            let takes_part = |&other: &usize| !is_new && made_of[other].abs() > NOTHING;
            let by = (0..k).filter(takes_part).map(|other| names[other].clone()).collect();
            found.push(DriveCheck { measure: names[k].clone(), is_too_many: !is_new, by });
        }
        if is_new {
            let size = rest.norm();
            basis.push((rest / size, made_of / size));
        }
    }
    Ok(found)
}
