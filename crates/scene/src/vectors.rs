//! Forces and velocities as arrows, and the scale of their lengths.

use std::collections::HashSet;

use bksim_sim::load_forces::LoadForces;
use bksim_sim::pose::Pose;
use bksim_sim::redundancy::Uniqueness;
use bksim_sim::run::Sample;

use crate::{Arrow, Color, MarkerKind, Scene};

/// A vector at a point of the world, m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VectorAt {
    /// Where it acts.
    pub point: [f64; 3],
    /// Components in world axes, N or m/s.
    pub vector: [f64; 3],
    /// Whether it could be no other vector: false of reactions that many solutions share.
    pub is_unique: bool,
}

/// Length of the longest arrow of a run against the extent of the mechanism.
const LONGEST: f64 = 0.25;

impl VectorAt {
    /// Its size, N or m/s; zero when it is no number.
    pub fn size(&self) -> f64 {
        let [x, y, z] = self.vector;
        let size = x.hypot(y).hypot(z);
        if size.is_finite() { size } else { 0.0 }
    }
}

/// The reactions: the force on the second body of every joint, N, in the order of the joints.
pub fn reactions<'a>(
    scene: &'a Scene,
    poses: &'a [Pose],
    sample: &'a Sample,
    uniqueness: &'a Uniqueness,
) -> impl Iterator<Item = VectorAt> + 'a {
    scene.markers.iter().filter_map(|marker| {
        let MarkerKind::Joint(joint) = marker.kind else { return None };
        let &[x, y, z, ..] = sample.reactions.get(joint)?;
        let point = poses.get(marker.at.body)?.place(marker.at.position);
        let is_unique =
            uniqueness.reactions.get(joint).is_none_or(|six| !six[..3].contains(&false));
        Some(VectorAt { point, vector: [x, y, z], is_unique })
    })
}

/// The velocities of the markers on bodies that move, m/s, in the order of the scene; those of
/// markers that move together once.
pub fn velocities(scene: &Scene, poses: &[Pose]) -> Vec<VectorAt> {
    let mut found: Vec<VectorAt> = Vec::new();
    let mut known = HashSet::new();
    for marker in scene.markers.iter().filter(|marker| marker.at.body != 0) {
        let Some(pose) = poses.get(marker.at.body) else { continue };
        let point = pose.place(marker.at.position);
        // Within a fraction of a pin.
        #[expect(clippy::cast_possible_truncation, reason = "saturates, which is as good")]
        let cell = point.map(|x| (5.0 * x / scene.pin).round() as i64);
        if known.insert(cell) {
            let vector = pose.velocity_of(marker.at.position);
            found.push(VectorAt { point, vector, is_unique: true });
        }
    }
    found
}

/// The applied forces, N: gravity at the centres of mass, forces at their points, springs and
/// dampers at their ends; in the order of the loads.
pub fn applied_forces(loads: &mut LoadForces, sample: &Sample) -> impl Iterator<Item = VectorAt> {
    let forces = loads.at((sample.t, &sample.q, &sample.v), &sample.lambda);
    forces.map(|at| VectorAt { point: at.point, vector: at.force, is_unique: true })
}

/// Metres per newton, or per metre a second, with which the largest of a run is drawn a quarter as
/// long as the mechanism is large; zero when there is nothing to draw.
pub fn arrow_scale(largest: f64, extent: f64) -> f64 {
    let scale = LONGEST * extent / largest;
    if scale.is_finite() && scale > 0.0 { scale } else { 0.0 }
}

/// Vectors as arrows for [`crate::Extras`], `scale` metres long per unit; hollow where they are not unique.
pub fn arrows(
    color: Color,
    scale: f64,
    vectors: impl IntoIterator<Item = VectorAt>,
) -> impl Iterator<Item = Arrow> {
    vectors.into_iter().map(move |at| Arrow {
        color,
        from: at.point,
        vector: at.vector.map(|x| scale * x),
        is_hollow: !at.is_unique,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_of_a_run_is_a_quarter_of_the_mechanism() {
        assert_eq!(arrow_scale(50.0, 2.0) * 50.0, 0.5);
        for [largest, extent] in [[0.0, 1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY], [1.0, 0.0]] {
            assert_eq!(arrow_scale(largest, extent), 0.0);
        }
    }
}
