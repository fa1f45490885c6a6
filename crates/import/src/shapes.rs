//! Solids of other formats: their inertia at density one, and how a model file draws them.

use std::f64::consts::PI;

use crate::draft::{list, number, vector};
use crate::spatial::{Inertia, Pose, Vector};

/// A solid about the origin of its frame, round about z.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Solid {
    Sphere { radius: f64 },
    Box { half: Vector },
    Cylinder { radius: f64, half: f64 },
    Capsule { radius: f64, half: f64 },
    Ellipsoid { radii: Vector },
}

impl Solid {
    /// Volume, m³.
    pub(crate) fn volume(self) -> f64 {
        match self {
            Self::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Self::Box { half: [x, y, z] } => 8.0 * x * y * z,
            Self::Cylinder { radius, half } => 2.0 * PI * radius * radius * half,
            Self::Capsule { radius, half } => {
                2.0 * PI * radius * radius * half + 4.0 / 3.0 * PI * radius.powi(3)
            }
            Self::Ellipsoid { radii: [x, y, z] } => 4.0 / 3.0 * PI * x * y * z,
        }
    }

    /// Central moments of inertia of a mass that fills it evenly.
    pub(crate) fn inertia(self, mass: f64) -> Inertia {
        let [xx, yy, zz] = match self {
            Self::Sphere { radius } => [0.4 * mass * radius * radius; 3],
            Self::Box { half: [x, y, z] } => {
                [y * y + z * z, x * x + z * z, x * x + y * y].map(|square| mass * square / 3.0)
            }
            Self::Cylinder { radius, half } => {
                let across = mass * (3.0 * radius * radius + 4.0 * half * half) / 12.0;
                [across, across, mass * radius * radius / 2.0]
            }
            Self::Capsule { radius, half } => capsule(mass, radius, half),
            Self::Ellipsoid { radii: [x, y, z] } => {
                [y * y + z * z, x * x + z * z, x * x + y * y].map(|square| mass * square / 5.0)
            }
        };
        Inertia { mass, com: [0.0; 3], tensor: [xx, yy, zz, 0.0, 0.0, 0.0] }
    }

    /// Entries of `shapes` that draw it.
    pub(crate) fn drawn(self, pose: Pose) -> Vec<String> {
        match self {
            Self::Sphere { radius } => {
                vec![format!(
                    "{{ type = \"sphere\", radius = {}{} }}",
                    number(radius),
                    placed(pose)
                )]
            }
            Self::Box { half } => {
                let size = list(&half.map(|part| 2.0 * part));
                vec![format!("{{ type = \"box\", size = {size}{} }}", placed(pose))]
            }
            Self::Cylinder { radius, half } => vec![cylinder(radius, half, pose)],
            Self::Capsule { radius, half } => {
                let ball = |z: f64| {
                    let at = pose.then(Pose::at([0.0, 0.0, z])).at;
                    Self::Sphere { radius }.drawn(Pose::at(at)).concat()
                };
                vec![cylinder(radius, half, pose), ball(-half), ball(half)]
            }
            // The nearest that a model file has.
            Self::Ellipsoid { radii } => {
                let largest = radii.into_iter().fold(0.0, f64::max);
                Self::Sphere { radius: largest }
                    .drawn(Pose { turn: crate::spatial::Rotation::NONE, ..pose })
            }
        }
    }

    /// True where it has a size in all directions.
    pub(crate) fn is_solid(self) -> bool {
        self.volume() > 0.0 && self.volume().is_finite()
    }
}

fn cylinder(radius: f64, half: f64, pose: Pose) -> String {
    let (radius, length) = (number(radius), number(2.0 * half));
    format!("{{ type = \"cylinder\", radius = {radius}, length = {length}{} }}", placed(pose))
}

/// A cylinder of mass m_c with two half balls of mass m_b together: their centres are 3 r/8 beyond its ends.
fn capsule(mass: f64, radius: f64, half: f64) -> [f64; 3] {
    let length = 2.0 * half;
    let density = mass / Solid::Capsule { radius, half }.volume();
    let of_cylinder = density * PI * radius * radius * length;
    let of_ball = mass - of_cylinder;
    let across = of_cylinder * (3.0 * radius * radius + length * length) / 12.0
        + of_ball * (0.4 * radius * radius + 0.375 * radius * length + 0.25 * length * length);
    let along = of_cylinder * radius * radius / 2.0 + 0.4 * of_ball * radius * radius;
    [across, across, along]
}

/// The place of a shape, after its other keys.
fn placed(pose: Pose) -> String {
    let is_turned = !pose.turn.is_none();
    let at = if pose.at != [0.0; 3] || is_turned {
        format!(", at = {}", vector(pose.at))
    } else {
        String::new()
    };
    let turn =
        if is_turned { format!(", quaternion = {}", list(&pose.turn.0)) } else { String::new() };
    at + &turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_capsule_is_a_ball_and_a_long_one_a_rod() {
        let ball = Solid::Sphere { radius: 0.3 }.inertia(2.0).tensor;
        let capsule = Solid::Capsule { radius: 0.3, half: 0.0 }.inertia(2.0).tensor;
        assert!(ball.iter().zip(capsule).all(|(a, b)| (a - b).abs() < 1e-15), "{capsule:?}");
        let rod = Solid::Capsule { radius: 1e-6, half: 0.5 }.inertia(3.0).tensor;
        assert!((rod[0] - 3.0 / 12.0).abs() < 1e-5, "{rod:?}");
    }

    #[test]
    fn a_box_of_equal_sides_and_an_ellipsoid_of_equal_radii_turn_alike_about_all_axes() {
        let cube = Solid::Box { half: [0.5; 3] }.inertia(6.0).tensor;
        assert_eq!(cube, [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let round = Solid::Ellipsoid { radii: [0.2; 3] };
        let ball = Solid::Sphere { radius: 0.2 };
        assert!((round.volume() - ball.volume()).abs() < 1e-16);
        assert!((round.inertia(1.0).tensor[0] - ball.inertia(1.0).tensor[0]).abs() < 1e-16);
    }
}
