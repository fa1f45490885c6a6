//! The quantities of a mechanism at a pose: every coordinate, joint value, body and named point, with names
//! for its value, rate and acceleration.

use bksim_expr::Expr;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::quantity::rate_unit;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{
    Axis, BodyId, JointId, Measure, Model, MotionKind, PointId, Space, motion_words,
};

/// One number of a pose with its derivatives by time.
#[derive(Clone, Debug)]
pub struct PoseQuantity {
    /// Names of value, rate and acceleration: `crank.angle`, `crank.rate`, `crank.acceleration`.
    pub names: [String; 3],
    /// Unit of the value, `rad` or `m`; rates append `/s`, accelerations `/s^2`.
    pub unit: &'static str,
    /// The value, an expression of the coordinates.
    pub(crate) value: Expr,
}

impl PoseQuantity {
    /// Whether values one turn apart mean the same.
    pub fn is_angle(&self) -> bool {
        self.unit == "rad"
    }

    /// Units of value, rate and acceleration.
    pub fn units(&self) -> [String; 3] {
        [self.unit.to_owned(), rate_unit(self.unit, 1), rate_unit(self.unit, 2)]
    }
}

/// All quantities: joints, then bodies with their centres of mass and points, then coordinates.
pub(crate) fn pose_quantities(model: &Model, system: &SymbolicSystem) -> Vec<PoseQuantity> {
    let kinematics = &system.kinematics;
    let mut all = Vec::new();
    for (joint_idx, joint) in model.joints.iter().enumerate() {
        let motions = joint.kind.motions();
        for (motion_idx, motion) in motions.iter().enumerate() {
            let unit = match motion {
                MotionKind::Rotation => "rad",
                MotionKind::Translation => "m",
            };
            let words = motion_words(motions, motion_idx);
            let names = words.map(|word| format!("{}.{word}", joint.name));
            let value =
                kinematics.measure(model, Measure::JointPosition(JointId(joint_idx), motion_idx));
            all.push(PoseQuantity { names, unit, value });
        }
    }
    for body_idx in 1..model.bodies.len() {
        all.extend(of_body(model, system, BodyId(body_idx)));
    }
    // The integral of a state is nothing of a pose.
    let coordinates = system.coordinates().iter();
    for coordinate in coordinates.filter(|c| c.kind != CoordinateKind::Integral) {
        let name = &coordinate.name;
        let names =
            [name.clone(), coordinate.rate_name.clone(), coordinate.second_rate_name.clone()];
        let unit = coordinate.kind.unit();
        let value = model.pool.symbol_expr(coordinate.q);
        all.push(PoseQuantity { names, unit, value });
    }
    // The first of a name has it: a coordinate may be called after its joint.
    let mut known = std::collections::HashSet::new();
    all.retain(|quantity| known.insert(quantity.names[0].clone()));
    all
}

/// Angle, centre of mass and points of a body.
fn of_body(model: &Model, system: &SymbolicSystem, id: BodyId) -> Vec<PoseQuantity> {
    let kinematics = &system.kinematics;
    let body = &model.bodies[id.0];
    let mut all = Vec::new();
    if model.space == Space::Planar {
        let names = ["angle", "rate", "acceleration"].map(|word| format!("{}.{word}", body.name));
        let value = kinematics.measure(model, Measure::BodyAngle(id));
        all.push(PoseQuantity { names, unit: "rad", value });
    }
    let axes: &[(Axis, &str)] = match model.space {
        Space::Planar => &[(Axis::X, "x"), (Axis::Y, "y")],
        Space::Spatial => &[(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")],
    };
    let points = (0..body.points.len()).map(|point| Some(PointId(point)));
    for point in std::iter::once(None).chain(points) {
        let owner = match point {
            None => body.name.clone(),
            Some(PointId(idx)) => format!("{}.{}", body.name, body.points[idx].name),
        };
        for &(axis, word) in axes {
            let names = ["", "v", "a"].map(|level| format!("{owner}.{level}{word}"));
            let value = kinematics.measure(model, Measure::PointPosition(id, point, axis));
            all.push(PoseQuantity { names, unit: "m", value });
        }
    }
    all
}
