//! Names, units and descriptions of the numbers of a state.

use bksim_model::{
    BodyId, Coupling, CouplingId, CouplingKind, Drive, DriveId, JointId, LoadId, Model, MotionKind,
    StateId,
};

use crate::constraint::{Constraint, Source};
use crate::coordinate::{Coordinate, CoordinateKind, Owner};
use crate::system::SymbolicSystem;

/// Name and unit of one number of the state.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Quantity {
    /// Identifier.
    pub name: String,
    /// SI unit of the value, empty of a pure number.
    pub unit: String,
    /// Names and units of the rate and of the second rate, of a coordinate.
    pub rates: Vec<[String; 2]>,
    /// Meaning in a few words.
    pub description: String,
}

/// SI unit of the rate of what has this unit, or with 2 of its second rate.
pub fn rate_unit(unit: &str, order: usize) -> String {
    let unit = if unit.is_empty() { "1" } else { unit };
    let per = if order == 1 { "s".to_owned() } else { format!("s^{order}") };
    format!("{unit}/{per}")
}

/// SI units of a coordinate, its velocity and its acceleration, empty of a pure number.
pub fn coordinate_units(model: &Model, coordinate: &Coordinate) -> [String; 3] {
    // A state is the rate of its integral.
    if let Owner::State(StateId(state)) = coordinate.owner {
        return model.states[state].units.clone().map(|unit| unit.replace(' ', "*"));
    }
    let unit = coordinate.kind.unit();
    [unit.to_owned(), rate_unit(unit, 1), rate_unit(unit, 2)]
}

/// The generalised coordinates.
pub fn coordinate_quantities(model: &Model, system: &SymbolicSystem) -> Vec<Quantity> {
    let quantity = |coordinate: &Coordinate| {
        let [unit, rate, second] = coordinate_units(model, coordinate);
        let rates = vec![
            [coordinate.rate_name.clone(), rate],
            [coordinate.second_rate_name.clone(), second],
        ];
        let description = match coordinate.kind {
            CoordinateKind::Angle => "angle",
            CoordinateKind::Length => "position",
            CoordinateKind::Quaternion => "part of a quaternion",
            CoordinateKind::Integral => "integral of the state",
        };
        let name = coordinate.name.clone();
        Quantity { name, unit, rates, description: description.into() }
    };
    system.coordinates().iter().map(quantity).collect()
}

/// The multipliers, each with the joint, drive or load that it belongs to.
pub fn multiplier_quantities(model: &Model, system: &SymbolicSystem) -> Vec<Quantity> {
    let quantity = |c: &Constraint| {
        let owner = match c.source {
            Source::Joint(JointId(j)) => format!("joint `{}`", model.joints[j].name),
            Source::Quaternion(BodyId(b)) => format!("quaternion of `{}`", model.bodies[b].name),
            Source::Coupling(CouplingId(k)) => {
                let coupling = &model.couplings[k];
                let word =
                    if coupling.kind == CouplingKind::Rate { "condition" } else { "coupling" };
                format!("{word} `{}`", coupling.name)
            }
            Source::Drive(DriveId(d)) => format!("drive `{}`", model.drives[d].name),
            Source::Stop(LoadId(l)) => format!("stop `{}`", model.loads[l].name),
            Source::Friction(LoadId(l)) => format!("friction `{}`", model.loads[l].name),
        };
        Quantity {
            name: model.pool.symbol_name(c.lambda),
            unit: effort_unit(c.effort).to_owned(),
            rates: Vec::new(),
            description: match c.source {
                Source::Friction(_) | Source::Coupling(_) => owner,
                _ => format!("{owner}, {}", c.direction),
            },
        }
    };
    system.constraints.iter().map(quantity).collect()
}

/// SI unit of the effort along a motion.
fn effort_unit(motion: MotionKind) -> &'static str {
    match motion {
        MotionKind::Translation => "N",
        MotionKind::Rotation => "N*m",
    }
}

/// The forces or moments of the couplings.
pub fn coupling_quantities(model: &Model) -> Vec<Quantity> {
    let quantity = |coupling: &Coupling| {
        let description = match coupling.kind {
            CouplingKind::Relation => "multiplier of the relation",
            CouplingKind::Rate => "multiplier of the condition on rates",
            CouplingKind::Screw => "force on the second joint along its axis",
            CouplingKind::Strand(..) => "tension of the strand",
            CouplingKind::Rope(..) => "pull of the rope",
            CouplingKind::Rack(_) => "tooth force on the rack along its axis",
            CouplingKind::Gear(_) => match coupling.effort {
                MotionKind::Translation => {
                    "tangential tooth force, positive if it turns the second gear forward"
                }
                MotionKind::Rotation => "torque of the teeth on the second gear",
            },
            CouplingKind::Belt(_) => match coupling.effort {
                MotionKind::Translation => {
                    "difference of the tensions, positive if it turns the second wheel forward"
                }
                MotionKind::Rotation => "torque of the belt on the second wheel",
            },
        };
        Quantity {
            name: coupling.name.clone(),
            unit: effort_unit(coupling.effort).to_owned(),
            rates: Vec::new(),
            description: description.into(),
        }
    };
    model.couplings.iter().map(quantity).collect()
}

/// The efforts of the drives.
pub fn drive_quantities(model: &Model) -> Vec<Quantity> {
    let quantity = |drive: &Drive| {
        let joint = &model.joints[drive.joint.0];
        Quantity {
            name: drive.name.clone(),
            unit: effort_unit(joint.kind.motions()[drive.motion_idx]).to_owned(),
            rates: Vec::new(),
            description: format!("effort on joint `{}`", joint.name),
        }
    };
    model.drives.iter().map(quantity).collect()
}
