//! Platforms in space against published ones, and against their legs' lengths.

use crate::support::geometry;
use bksim_analysis::{Assemblies, Assembly, Platform, assemblies};
use nalgebra::Vector3;

/// Points on the base, points on the platform and lengths of legs.
struct Posed {
    base: [[f64; 3]; 6],
    platform: [[f64; 3]; 6],
    lengths: [f64; 6],
}

impl Posed {
    /// Two plane hexagons with pairs of points this far from their middle, degrees.
    fn hexagons(radii: [f64; 2], off: [f64; 2], lengths: [f64; 6]) -> Self {
        let ring = |r: f64, middles: [f64; 3], off: f64| {
            std::array::from_fn(|k| {
                let side = if k % 2 == 0 { -off } else { off };
                let angle = (middles[k / 2] + side).to_radians();
                [r * angle.cos(), r * angle.sin(), 0.0]
            })
        };
        // Legs of one point on the base go to different points of the platform.
        let mut platform: [[f64; 3]; 6] = ring(radii[1], [60.0, 180.0, 300.0], off[1]);
        platform.rotate_right(1);
        Self { base: ring(radii[0], [0.0, 120.0, 240.0], off[0]), platform, lengths }
    }

    /// A model with six links, guessed at a height.
    fn model(&self, height: f64) -> String {
        let points = |name: &str, all: &[[f64; 3]; 6]| -> String {
            let line =
                |(k, [x, y, z]): (usize, &[f64; 3])| format!("{name}{k} = [{x}, {y}, {z}]\n");
            all.iter().enumerate().map(line).collect::<Vec<_>>().concat()
        };
        let links = (self.lengths.iter().enumerate())
            .map(|(k, length)| {
                format!(
                    "[joints.leg{k}]\ntype = \"link\"\nbetween = [\"ground.B{k}\", \"top.P{k}\"]\nlength = {length}\n"
                )
            })
            .collect::<Vec<_>>().concat();
        format!(
            "space = \"spatial\"\n[ground.points]\n{}[bodies.top]\nmass = 1\ninertia = [1, 1, 1]\n[bodies.top.points]\n{}{links}\
             [initial]\ntop = {{ guess = {{ x = 0.1, y = 0.05, z = {height} }} }}\n",
            points("B", &self.base),
            points("P", &self.platform)
        )
    }

    /// Largest miss of a length in a pose: of a leg, or between points of the platform.
    fn miss(&self, pose: &Assembly) -> f64 {
        let ends = ends(pose);
        let off = |a: Vector3<f64>, b: Vector3<f64>, length: f64| ((a - b).norm() - length).abs();
        let leg = |k: usize| off(ends[k], Vector3::from(self.base[k]), self.lengths[k]);
        let mut worst = (0..6).map(leg).fold(0.0, f64::max);
        for i in 0..6 {
            for j in 0..i {
                let own = [i, j].map(|k| Vector3::from(self.platform[k]));
                worst = worst.max(off(ends[i], ends[j], (own[0] - own[1]).norm()));
            }
        }
        worst
    }
}

/// Ends of the legs on the platform in a pose.
fn ends(pose: &Assembly) -> [Vector3<f64>; 6] {
    let value = |name: String| {
        let of = pose.pose.iter().find(|(known, ..)| *known == name);
        of.unwrap_or_else(|| panic!("no {name} in {:?}", pose.pose)).1
    };
    std::array::from_fn(|k| Vector3::from(["x", "y", "z"].map(|x| value(format!("top.P{k}.{x}")))))
}

/// All poses have the lengths, and no two are the same.
fn check(posed: &Posed, found: &Assemblies) {
    for (k, pose) in found.assemblies.iter().enumerate() {
        let miss = posed.miss(pose);
        assert!(miss < 1e-12, "assembly {} misses a length by {miss}", pose.number);
        for other in &found.assemblies[..k] {
            let [a, b] = [pose, other].map(ends);
            let off = (0..6).map(|i| (a[i] - b[i]).norm()).fold(0.0, f64::max);
            assert!(off > 1e-4, "assemblies {} and {} are {off} apart", pose.number, other.number);
        }
    }
}

fn found(posed: &Posed, height: f64) -> Assemblies {
    assemblies(geometry(&posed.model(height))).expect("assemblies")
}

fn platform(found: &Assemblies) -> &Platform {
    found.proof.as_ref().and_then(|proof| proof.platform.as_ref()).expect("a platform with a proof")
}

/// P. Dietmaier, *The Stewart–Gough platform of general geometry can have 40 real postures*, Advances in Robot Kinematics (1998): all
/// forty are real.
#[test]
fn dietmaiers_platform_has_forty_poses() {
    let posed = Posed {
        base: [
            [0.0, 0.0, 0.0],
            [1.107_915, 0.0, 0.0],
            [0.549_094, 0.756_063, 0.0],
            [0.735_077, -0.223_935, 0.525_991],
            [0.514_188, -0.526_063, -0.368_418],
            [0.590_473, 0.094_733, -0.205_018],
        ],
        platform: [
            [0.0, 0.0, 0.0],
            [0.542_805, 0.0, 0.0],
            [0.956_919, -0.528_915, 0.0],
            [0.665_885, -0.353_482, 1.402_538],
            [0.478_359, 1.158_742, 0.107_672],
            [-0.137_087, -0.235_121, 0.353_913],
        ],
        lengths: [1.0, 0.645_275, 1.086_284, 1.503_439, 1.281_933, 0.771_071],
    };
    let found = found(&posed, 0.5);
    let platform = platform(&found);
    assert_eq!((platform.bound, platform.solved.len()), (Some(40), 40));
    assert_eq!(found.assemblies.len(), 40);
    check(&posed, &found);
}

/// Plane hexagons on circles lose twelve of the forty, octahedra all but sixteen: the bound follows the geometry.
#[test]
fn the_number_of_solutions_follows_the_geometry() {
    let lengths = [1.32, 1.35, 1.29, 1.34, 1.31, 1.37];
    for (off, n) in [([8.0, 10.0], 28), ([8.0, 0.0], 16), ([0.0, 0.0], 16)] {
        let posed = Posed::hexagons([1.0, 0.6], off, lengths);
        let found = found(&posed, 1.2);
        let platform = platform(&found);
        assert_eq!((platform.bound, platform.solved.len()), (Some(n), n), "{off:?}");
        let n_real = platform.solved.iter().filter(|point| point.is_assembly).count();
        assert_eq!(found.assemblies.len(), n_real, "{off:?}");
        // Mirror images in the plane of the base, in pairs.
        assert!(n_real >= 2 && n_real % 2 == 0, "{off:?}: {n_real}");
        check(&posed, &found);
    }
}

/// Crosses, cylinders and balls, driven: as many poses as links of their lengths have.
#[test]
fn a_platform_on_driven_cylinders_has_the_poses_of_its_lengths() {
    let posed = Posed::hexagons([1.0, 0.6], [8.0, 10.0], [1.32, 1.35, 1.29, 1.34, 1.31, 1.37]);
    let links = posed.model(1.2);
    let (before, rest) = links.split_once("[joints.leg0]").expect("links");
    let (_, initial) = rest.split_once("[initial]").expect("a start");
    let leg = |(k, length): (usize, &f64)| {
        format!(
            "[bodies.tube{k}]\nmass = 1\ninertia = [1, 1, 1]\n[bodies.rod{k}]\nmass = 1\ninertia = [1, 1, 1]\n\
             [joints.cross{k}]\ntype = \"universal\"\nbetween = [\"ground.B{k}\", \"tube{k}\"]\naxis = [1, 0, 0]\nsecond = [0, 1, 0]\n\
             [joints.leg{k}]\ntype = \"prismatic\"\nbetween = [\"tube{k}\", \"rod{k}\"]\naxis = [0, 0, 1]\n\
             [joints.ball{k}]\ntype = \"spherical\"\nbetween = [\"rod{k}\", \"top.P{k}\"]\n\
             [drives.leg{k}]\njoint = \"leg{k}\"\nmotion = \"{length} + 0.1*t/s\"\n"
        )
    };
    let legs: String = posed.lengths.iter().enumerate().map(leg).collect();
    let driven = assemblies(geometry(&format!("{before}{legs}[initial]{initial}")));
    let driven = driven.expect("assemblies");
    let of_driven = platform(&driven);
    assert_eq!(of_driven.bodies, ["ground", "top"].map(str::to_owned));
    assert_eq!(of_driven.legs[2], ["cross2", "ball2"].map(str::to_owned));
    assert_eq!((of_driven.bound, of_driven.solved.len()), (Some(28), 28));
    let of_links = found(&posed, 1.2);
    assert_eq!(driven.assemblies.len(), of_links.assemblies.len());
    check(&posed, &driven);
}

/// A body whose orientation is a quaternion: both signs are one pose.
#[test]
fn a_quaternion_and_its_negative_are_one_assembly() {
    const TRIPOD: &str = r#"
space = "spatial"
[ground.points]
B0 = [1, 0, 0]
B1 = [-0.5, 0.8, 0]
B2 = [-0.5, -0.8, 0.1]
B3 = [0.6, 0.7, 0]
B4 = [-0.9, 0.1, 0]
O = [0.1, 0, 1.0]
[bodies.top]
mass = 1
inertia = [1, 1, 1]
[bodies.top.points]
P0 = [0.4, 0, 0]
P1 = [-0.2, 0.3, 0]
P2 = [-0.2, -0.3, 0.05]
[joints.pivot]
type = "spherical"
cut = true
between = ["ground.O", "top"]
[joints.leg0]
type = "link"
between = ["ground.B0", "top.P0"]
length = 1.12
[joints.leg1]
type = "link"
between = ["ground.B1", "top.P1"]
length = 1.187
[joints.leg2]
type = "link"
between = ["ground.B2", "top.P2"]
length = 1.146
[initial]
top = { guess = { x = 0.1, y = 0.05, z = 1.0 } }
"#;
    let found = assemblies(geometry(TRIPOD)).expect("assemblies");
    assert_eq!(found.assemblies.len(), 2);
    let ways: Vec<f64> = (found.assemblies.iter())
        .map(|pose| pose.pose.iter().find(|(name, ..)| name == "top.P1.x").expect("a point").1)
        .collect();
    assert!((ways[0] - ways[1]).abs() > 1e-3, "{ways:?}");
}
