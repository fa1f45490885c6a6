//! Platforms in space on six legs: all poses in which the legs have their lengths.
//!
//! ```text
//! |R pᵢ + t − bᵢ|² = Lᵢ²,  i = 1 … 6        leg i from bᵢ on the base to pᵢ on the platform
//! ```
//!
//! In numbers of E. Study these are six quadratic forms next to his own, which forty points satisfy where the platform is in
//! general position: each of them is followed to the platform that is asked for. A ball around each end holds one solution; as
//! many balls as ranks allow solutions are all. Every real one is a pose.
//!
//! Source: M. L. Husty, *An algorithm for solving the direct kinematics of general Stewart–Gough platforms*, Mech. Mach. Theory 31
//! (1996) 365; the number forty: F. Ronga and T. Vust (1992), M. Raghavan, J. Mech. Des. 115 (1993) 277.

mod legs;
mod reach;
mod study;

use bksim_model::Measure;

use self::legs::Legs;
pub(crate) use self::reach::Reach;
pub(crate) use self::study::Displacement;
use crate::error::AnalysisError;
use crate::positions::Positions;

pub use self::study::{StudyPoint, general_points};

/// A platform on six legs, with all its poses in complex numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct Platform {
    /// Names of the base and of the platform.
    pub bodies: [String; 2],
    /// Of each leg the names of its joints, from the base on. A cross that is turned over leads to the same pose.
    pub legs: Vec<Vec<String>>,
    /// Largest number of solutions; none where a rank is not certain.
    pub bound: Option<usize>,
    /// All that were found.
    pub solved: Vec<StudyPoint>,
}

impl Platform {
    /// True if there can be no more solutions.
    pub(crate) fn is_complete(&self) -> bool {
        self.bound == Some(self.solved.len())
    }
}

/// A platform with the ways to its poses.
pub(crate) struct Reached {
    /// All that is known of the platform.
    pub(crate) platform: Platform,
    /// Displacements of all real solutions.
    pub(crate) real: Vec<Displacement>,
    /// Coordinates of displacements.
    pub(crate) reach: Reach,
}

impl Reached {
    /// The platform of `positions` where `held` measures with values `u` and the drives do not move; none if its mechanism is
    /// not one, or rounding could decide.
    pub(crate) fn of(
        positions: &Positions,
        held: &[Measure],
        u: &[f64],
    ) -> Result<Option<Self>, AnalysisError> {
        let Some(legs) = Legs::of(positions, held)? else { return Ok(None) };
        let Some(solved) = study::solved(&legs) else { return Ok(None) };
        let model = positions.model();
        let joint_name = |joint: &usize| model.joints[*joint].name.clone();
        let platform = Platform {
            bodies: legs.bodies.map(|body| model.bodies[body].name.clone()),
            legs: legs.six.iter().map(|leg| leg.joints.iter().map(joint_name).collect()).collect(),
            bound: solved.bound,
            solved: solved.points,
        };
        let reach = Reach::of(positions, &legs, held, u)?;
        Ok(Some(Self { platform, real: solved.real, reach }))
    }
}
