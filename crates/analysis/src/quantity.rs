//! The quantities of a mechanism at a pose: every coordinate, joint value, body and named point, with names
//! for its value, rate and acceleration.

use bksim_expr::Expr;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::quantity::rate_unit;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Axis, BodyId, Joint, JointId, Measure, Model, PointId, Space};

/// One number of a pose with its derivatives by time.
#[derive(Clone, Debug)]
pub struct PoseQuantity {
    /// Names of value, rate and acceleration: `crank.angle`, `crank.rate`, `crank.acceleration`.
    pub names: [String; 3],
    /// Unit of the value, `rad` or `m`; rates append `/s`, accelerations `/s^2`.
    pub unit: &'static str,
    /// The value, an expression of the coordinates.
    pub value: Expr,
}

impl PoseQuantity {
    /// True if values one turn apart mean the same.
    pub fn is_angle(&self) -> bool {
        self.unit == "rad"
    }

    /// Name of the third rate, after that of the acceleration: `crank.jerk`, `rod.P.jx`.
    pub fn jerk_name(&self) -> String {
        let [value, _, acceleration] = &self.names;
        let (owner, word) =
            acceleration.rsplit_once('.').map_or(("", acceleration.as_str()), |it| it);
        let jerk = match word.strip_prefix('a') {
            Some(axis @ ("x" | "y" | "z")) => format!("j{axis}"),
            _ if word.contains("acceleration") => word.replace("acceleration", "jerk"),
            _ => return format!("{value}_jerk"),
        };
        if owner.is_empty() { jerk } else { format!("{owner}.{jerk}") }
    }

    /// Units of value, rate and acceleration.
    pub fn units(&self) -> [String; 3] {
        [self.unit.to_owned(), rate_unit(self.unit, 1), rate_unit(self.unit, 2)]
    }
}

/// All quantities: joints, then bodies with their centres of mass and points, then coordinates.
pub fn pose_quantities(model: &Model, system: &SymbolicSystem) -> Vec<PoseQuantity> {
    let of_measure = |measure: Measure| {
        let names = measure.motion_names(model)?;
        let value = system.kinematics.measure(model, measure);
        Some(PoseQuantity { names, unit: measure.fixed_unit(model), value })
    };
    let of_joint = |(k, joint): (usize, &Joint)| {
        (0..joint.kind.motions().len()).map(move |idx| Measure::JointPosition(JointId(k), idx))
    };
    let of_joints = model.joints.iter().enumerate().flat_map(of_joint);
    let of_bodies = (1..model.bodies.len()).flat_map(|body| of_body(model, BodyId(body)));
    let mut all: Vec<PoseQuantity> = of_joints.chain(of_bodies).filter_map(of_measure).collect();
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
fn of_body(model: &Model, id: BodyId) -> Vec<Measure> {
    let (angle, axes) = match model.space {
        Space::Planar => (Some(Measure::BodyAngle(id)), &[Axis::X, Axis::Y][..]),
        Space::Spatial => (None, &[Axis::X, Axis::Y, Axis::Z][..]),
    };
    let points = (0..model.bodies[id.0].points.len()).map(|point| Some(PointId(point)));
    let points = std::iter::once(None).chain(points);
    let places = points
        .flat_map(|point| axes.iter().map(move |&axis| Measure::PointPosition(id, point, axis)));
    angle.into_iter().chain(places).collect()
}
