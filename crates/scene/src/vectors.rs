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
    /// True if it could be no other vector: false of reactions that many solutions share.
    pub is_unique: bool,
}

/// Length of the longest arrow of a run against the extent of the mechanism.
const LONGEST: f64 = 0.25;
/// Ratio of the largest to the least vector from which lengths are logarithmic.
const SPREAD: f64 = 200.0;
/// Powers of ten that a logarithmic scale has.
const DECADES: f64 = 5.0;
/// Vectors below this part of the largest are rounding.
const ROUNDING: f64 = 1e-9;
/// Forces and velocities below this are what rounding leaves of none at all: a bacterium weighs ten thousand times as
/// much, N.
const NOTHING: f64 = 1e-18;

/// From the sizes of vectors of one kind to the lengths of their arrows.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ArrowScale {
    /// Length of the longest arrow of the run, m; zero when there is nothing to draw.
    longest: f64,
    /// The size that it stands for, N or m/s.
    largest: f64,
    /// True if a tenth of the size takes a fifth of the longest arrow off, so that sizes of many powers of ten are seen.
    pub is_logarithmic: bool,
}

/// A kind of arrow in a picture, for its legend.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ArrowKind {
    /// `reaction`, `force`, `velocity`.
    pub name: &'static str,
    /// Of the arrows.
    pub color: Color,
    /// Of the vectors.
    pub unit: &'static str,
    /// Of their lengths.
    pub scale: ArrowScale,
}

impl ArrowScale {
    /// The scale with which the largest vector of a run is drawn a quarter as long as the mechanism is large. `peaks` are
    /// the largest sizes of each vector over the run; below a part of `reference`, the largest of this unit of any
    /// kind, they are rounding.
    pub fn of(peaks: &[f64], reference: f64, extent: f64) -> Self {
        let floor = NOTHING.max(ROUNDING * reference);
        let largest = peaks.iter().copied().filter(|peak| *peak > floor).fold(0.0, f64::max);
        let least = peaks.iter().copied().filter(|peak| *peak > ROUNDING * largest);
        let least = least.fold(f64::INFINITY, f64::min);
        let longest = arrow_scale(largest, extent) * largest;
        let is_logarithmic = least.is_finite() && largest > SPREAD * least;
        Self { longest, largest, is_logarithmic }
    }

    /// The length of an arrow, m.
    pub fn length(&self, size: f64) -> f64 {
        let part = size / self.largest;
        if !(part.is_finite() && part > ROUNDING) {
            return 0.0;
        }
        let length = if self.is_logarithmic { 1.0 + part.log10() / DECADES } else { part };
        self.longest * length.max(0.0)
    }

    /// Sizes whose arrows a legend shows, with their lengths, m: a round one, and on a logarithmic scale a hundredth of it.
    pub fn samples(&self) -> Vec<(f64, f64)> {
        let power = 10f64.powf(self.largest.log10().floor());
        let first = [5.0, 2.0, 1.0].into_iter().find(|f| f * power <= self.largest);
        let Some(first) = first.filter(|_| self.longest > 0.0).map(|f| f * power) else {
            return Vec::new();
        };
        let sizes = if self.is_logarithmic { vec![first, 0.01 * first] } else { vec![first] };
        sizes.into_iter().map(|size| (size, self.length(size))).collect()
    }
}

impl VectorAt {
    /// Size of the vector, N or m/s; zero when it is no number.
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
fn arrow_scale(largest: f64, extent: f64) -> f64 {
    let scale = LONGEST * extent / largest;
    if scale.is_finite() && scale > 0.0 { scale } else { 0.0 }
}

/// Vectors as arrows for [`crate::Extras`]; hollow where they are not unique.
pub fn arrows(
    color: Color,
    scale: ArrowScale,
    vectors: impl IntoIterator<Item = VectorAt>,
) -> impl Iterator<Item = Arrow> {
    vectors.into_iter().map(move |at| {
        let size = at.size();
        let per_unit = if size > 0.0 { scale.length(size) / size } else { 0.0 };
        let vector = at.vector.map(|x| per_unit * x);
        Arrow { color, from: at.point, vector, is_hollow: !at.is_unique }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_scale_fits_eighty_kilonewtons_and_five_newtons() {
        let scale = ArrowScale::of(&[80e3, 5.0, 2e3], 80e3, 4.0);
        assert!(scale.is_logarithmic);
        assert_eq!(scale.length(80e3), 1.0);
        assert!(scale.length(5.0) > 0.15, "{}", scale.length(5.0));
        assert!(scale.length(5.0) < scale.length(2e3) && scale.length(2e3) < 1.0);
        assert_eq!(scale.length(80e3 * 1e-12), 0.0, "rounding is no result");
        let sizes: Vec<f64> = scale.samples().into_iter().map(|(size, _)| size).collect();
        assert_eq!(sizes, [50e3, 500.0]);
        // Of like vectors twice the size is twice as long.
        let scale = ArrowScale::of(&[50.0, 8.0, 1e-12], 50.0, 4.0);
        assert!(!scale.is_logarithmic);
        assert_eq!(scale.length(50.0), 2.0 * scale.length(25.0));
        assert!(ArrowScale::of(&[], 0.0, 1.0).samples().is_empty());
        // Where nothing has a mass, reactions are zero but for rounding.
        let scale = ArrowScale::of(&[3e-31, 1e-30], 1e-30, 4.0);
        assert!(scale.samples().is_empty() && scale.length(1e-30) == 0.0);
        // So are reactions that balance nothing next to weights of kilonewtons.
        let scale = ArrowScale::of(&[5e-13], 4e3, 4.0);
        assert!(scale.samples().is_empty() && scale.length(5e-13) == 0.0);
    }

    #[test]
    fn the_largest_of_a_run_is_a_quarter_of_the_mechanism() {
        assert_eq!(arrow_scale(50.0, 2.0) * 50.0, 0.5);
        for [largest, extent] in [[0.0, 1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY], [1.0, 0.0]] {
            assert_eq!(arrow_scale(largest, extent), 0.0);
        }
    }
}
