//! [`OpenReactions`]: the reactions that equilibrium leaves open in a pose, as the whole set of them.
//!
//! ```text
//! R = R₀ + N s for any s, while every bounded component keeps to its bounds
//! ```
//!
//! A stop that is closed pushes, so its force has zero as a bound. What is told of a component is its own least and largest
//! value over the set; components do not take these values all at once.

use bksim_model::{Compliance, Model, MotionKind, NoCompliance};
use bksim_sim::redundancy::{Effort, SelfStress};
use nalgebra::{DMatrix, DVector};

use crate::drive::Range;
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::ranges::{Bounded, ranges};
use crate::reduced::pseudo_inverse;

/// The least and the largest value that a component of a reaction, or the effort of a drive, may have.
#[derive(Clone, PartialEq, Debug)]
pub struct ReactionBound {
    /// `A.fy` in world axes, or `A.effort` of a drive.
    pub name: String,
    /// Least and largest, SI.
    pub range: [f64; 2],
}

/// A component that equilibrium leaves open.
#[derive(Clone, PartialEq, Debug)]
pub struct OpenComponent {
    /// `A.fy` in world axes, `A.effort` of a drive, or the name of a coupling, stop or friction.
    pub name: String,
    /// Unit of the component.
    pub unit: String,
    /// The value that is shown elsewhere.
    pub value: f64,
    /// Part in each of the self-stresses.
    pub parts: Vec<f64>,
    /// The least and the largest value within the bounds; infinite where nothing bounds it.
    pub range: [f64; 2],
}

/// The set of reactions that equilibrium leaves open.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct OpenReactions {
    /// Number of self-stresses: of independent conditions that repeat others.
    pub n_self_stresses: usize,
    /// The components with a part in one; none where all reactions are unique.
    pub components: Vec<OpenComponent>,
    /// False where no reactions keep to the bounds.
    pub is_possible: bool,
}

impl ReactionBound {
    /// Reads `A.fy = -500:500 N`, or one value `500 N` for both signs.
    ///
    /// # Errors
    /// [`AnalysisError`] for an unknown name, and for what is no range.
    pub fn parse(model: &Model, name: &str, values: &str) -> Result<Self, AnalysisError> {
        let unknown = || AnalysisError::UnknownReaction { name: name.to_owned() };
        let own = name.strip_prefix("reactions.").unwrap_or(name);
        let (joint, word) = own.rsplit_once('.').ok_or_else(unknown)?;
        let named = ["fx", "fy", "fz", "mx", "my", "mz"].iter().position(|known| *known == word);
        let is_joint = model.joints.iter().any(|of| of.name == joint);
        let drive = model.drives.iter().find(|of| of.name == joint);
        let unit = match (named, drive) {
            (Some(..3), _) if is_joint => "N",
            (Some(_), _) if is_joint => "N*m",
            (None, Some(drive)) if word == "effort" => {
                let motions = model.joints[drive.joint.0].kind.motions();
                let turns = motions[drive.motion_idx] == MotionKind::Rotation;
                if turns { "N*m" } else { "N" }
            }
            _ => return Err(unknown()),
        };
        let Range { from, to, n } = Range::parse(values, unit)?;
        let range = if n == 1 { [-from.abs(), from.abs()] } else { [from.min(to), from.max(to)] };
        Ok(Self { name: own.to_owned(), range })
    }
}

/// The springs of joints that yield, each by name and stiffness.
///
/// # Errors
/// [`AnalysisError`] for an unknown name, and for what is no stiffness.
pub fn compliances(
    model: &Model,
    written: &[(String, String)],
) -> Result<Vec<Compliance>, AnalysisError> {
    let read = |(name, stiffness): &(String, String)| {
        Compliance::parse(model, name, stiffness).map_err(|fault| match fault {
            NoCompliance::Unknown(name) => AnalysisError::UnknownReaction { name },
            NoCompliance::Stiffness(text) => {
                AnalysisError::NoStiffness { name: name.clone(), text }
            }
        })
    };
    written.iter().map(read).collect()
}

/// Of the reactions that equilibrium leaves open those with the least sum of squares, forces in N and moments at the points of
/// the joints in N m, efforts among them: the same whatever coordinates the mechanism has.
///
/// ```text
/// R₀ + N s,  (Nᵀ N) s = −Nᵀ R₀
/// ```
pub(crate) fn least(
    loaded: &Loaded,
    parameters: &[f64],
    (t, q): (f64, &[f64]),
    (reactions, lambda): (&mut [[f64; 6]], &mut [f64]),
) {
    let compiled = &loaded.mechanism.compiled;
    let stresses = compiled.open_stresses(parameters, (t, q));
    if stresses.is_empty() {
        return;
    }
    let mut rows: Vec<(usize, f64)> = Vec::new();
    for &(effort, _) in stresses.iter().flat_map(|stress| &stress.efforts) {
        rows.extend(compiled.row_of(effort).filter(|(row, _)| !rows.iter().any(|(r, _)| r == row)));
    }
    let n_joints = reactions.len();
    let column = |stress: &SelfStress| -> DVector<f64> {
        let mut all = DVector::zeros(6 * n_joints + rows.len());
        for (joint, six) in &stress.reactions {
            (0..6).for_each(|k| all[6 * joint.0 + k] += six[k]);
        }
        for &(effort, part) in &stress.efforts {
            let own = compiled.row_of(effort);
            let place = own.and_then(|(row, _)| rows.iter().position(|(known, _)| *known == row));
            if let (Some(place), Some((_, sign))) = (place, own) {
                all[6 * n_joints + place] += sign * part;
            }
        }
        all
    };
    let columns: Vec<DVector<f64>> = stresses.iter().map(column).collect();
    let of_joints = reactions.iter().flatten().copied();
    let own = of_joints.chain(rows.iter().map(|(row, _)| lambda[*row]));
    let own = DVector::from_iterator(6 * n_joints + rows.len(), own);
    let open = DMatrix::from_columns(&columns);
    let change = &open * (pseudo_inverse(&open) * -own);
    for (joint, six) in reactions.iter_mut().enumerate() {
        (0..6).for_each(|k| six[k] += change[6 * joint + k]);
    }
    for (place, (row, _)) in rows.iter().enumerate() {
        lambda[*row] += change[6 * n_joints + place];
    }
}

/// The reactions that equilibrium leaves open at a position with these reactions and multipliers; `parameters` end with modes.
pub(crate) fn open_reactions(
    loaded: &Loaded,
    (parameters, bounds): (&[f64], &[ReactionBound]),
    (t, q): (f64, &[f64]),
    (reactions, lambda): (&[[f64; 6]], &[f64]),
) -> OpenReactions {
    let stresses = loaded.mechanism.compiled.open_stresses(parameters, (t, q));
    let mut components = joint_components(loaded.model(), &stresses, reactions);
    components.extend(effort_components(loaded, &stresses, lambda));
    let pushes = |name: &str| name.starts_with("stop ");
    let quantity = |component: &OpenComponent| {
        let own = bounds.iter().find(|bound| bound.name == component.name);
        let free = [if pushes(&component.name) { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY];
        Bounded {
            value: component.value,
            slopes: component.parts.clone(),
            bounds: own.map_or(free, |bound| bound.range),
        }
    };
    let quantities: Vec<Bounded> = components.iter().map(quantity).collect();
    let found = if components.is_empty() { Some(Vec::new()) } else { ranges(&quantities) };
    let is_possible = found.is_some();
    for (component, range) in components.iter_mut().zip(found.unwrap_or_default()) {
        component.range = range;
    }
    OpenReactions { n_self_stresses: stresses.len(), components, is_possible }
}

/// A component without a range.
fn component(name: String, unit: &str, value: f64, parts: Vec<f64>) -> OpenComponent {
    OpenComponent { name, unit: unit.to_owned(), value, parts, range: [f64::NAN; 2] }
}

/// The components of joints with a part in a self-stress.
fn joint_components(
    model: &Model,
    stresses: &[SelfStress],
    reactions: &[[f64; 6]],
) -> Vec<OpenComponent> {
    let words = ["fx", "fy", "fz", "mx", "my", "mz"];
    let mut found = Vec::new();
    for (joint_idx, joint) in model.joints.iter().enumerate() {
        for (k, word) in words.into_iter().enumerate() {
            let part = |stress: &SelfStress| {
                let own = stress.reactions.iter().find(|(of, _)| of.0 == joint_idx);
                own.map_or(0.0, |(_, six)| six[k])
            };
            let parts: Vec<f64> = stresses.iter().map(part).collect();
            if parts.iter().any(|part| *part != 0.0) {
                let unit = if k < 3 { "N" } else { "N*m" };
                let name = format!("{}.{word}", joint.name);
                found.push(component(name, unit, reactions[joint_idx][k], parts));
            }
        }
    }
    found
}

/// The efforts of drives, couplings, stops and friction with a part in a self-stress.
fn effort_components(
    loaded: &Loaded,
    stresses: &[SelfStress],
    lambda: &[f64],
) -> Vec<OpenComponent> {
    let (model, compiled) = (loaded.model(), &loaded.mechanism.compiled);
    let mut efforts: Vec<Effort> = Vec::new();
    for &(effort, _) in stresses.iter().flat_map(|stress| &stress.efforts) {
        if !efforts.contains(&effort) {
            efforts.push(effort);
        }
    }
    let of = |effort: Effort| {
        let (row, sign) = compiled.row_of(effort)?;
        let part = |stress: &SelfStress| {
            let own = stress.efforts.iter().find(|(of, _)| *of == effort);
            own.map_or(0.0, |(_, part)| sign * part)
        };
        let name = match effort {
            Effort::Drive(id) => format!("{}.effort", model.drives[id.0].name),
            Effort::Coupling(id) => format!("coupling {}", model.couplings[id.0].name),
            Effort::Contact(_, id) => {
                let load = &model.loads[id.0];
                let word = if load.kind.limits().is_some() { "stop" } else { "friction" };
                format!("{word} {}", load.name)
            }
        };
        let is_turn = loaded.system().constraints[row].effort == MotionKind::Rotation;
        let unit = if is_turn { "N*m" } else { "N" };
        Some(component(name, unit, lambda[row], stresses.iter().map(part).collect()))
    };
    efforts.into_iter().filter_map(of).collect()
}
