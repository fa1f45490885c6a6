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

/// Three points of a platform on circles: their radii, the places of their middles on the base and the platform's triangle.
struct OnCircles {
    radii: [f64; 3],
    middles: [[f64; 3]; 3],
    triangle: [[f64; 3]; 3],
}

/// Directions in which the pins are off the middle, degrees: their axes are across.
const AROUND: [f64; 3] = [0.0, 120.0, 240.0];

impl OnCircles {
    fn new(radii: [f64; 3], heights: [f64; 3]) -> Self {
        let ring = |r: f64, heights: [f64; 3]| {
            std::array::from_fn(|k| {
                let angle = AROUND[k].to_radians();
                [r * angle.cos(), r * angle.sin(), heights[k]]
            })
        };
        Self { radii, middles: ring(1.0, heights), triangle: ring(0.6, [0.0; 3]) }
    }

    /// Place of a point on its circle.
    fn at(&self, k: usize, turn: f64) -> Vector3<f64> {
        let angle = AROUND[k].to_radians();
        let out = Vector3::new(angle.cos(), angle.sin(), 0.0) * turn.sin();
        let up = Vector3::new(0.0, 0.0, turn.cos());
        Vector3::from(self.middles[k]) + (out + up) * self.radii[k]
    }

    /// Sides of the triangle less what they are to be.
    fn open(&self, turns: [f64; 3]) -> Vector3<f64> {
        let side = |k: usize| {
            let [i, j] = [k, (k + 1) % 3];
            let own = Vector3::from(self.triangle[i]) - Vector3::from(self.triangle[j]);
            (self.at(i, turns[i]) - self.at(j, turns[j])).norm_squared() - own.norm_squared()
        };
        Vector3::from_fn(|k, _| side(k))
    }

    /// The closures that Newton's iteration finds from many turns, with slopes by differences.
    fn searched(&self) -> Vec<[f64; 3]> {
        let mut found: Vec<[f64; 3]> = Vec::new();
        let n = 9;
        let turn = |k: usize| std::f64::consts::TAU * k as f64 / n as f64 + 0.1;
        for begin in 0..n * n * n {
            let mut x = Vector3::new(turn(begin % n), turn(begin / n % n), turn(begin / n / n));
            for _ in 0..40 {
                let f = self.open(x.into());
                let slopes = nalgebra::Matrix3::from_columns(&[0, 1, 2].map(|k| {
                    let mut by = Vector3::zeros();
                    by[k] = 1e-6;
                    (self.open((x + by).into()) - self.open((x - by).into())) / 2e-6
                }));
                let Some(step) = slopes.lu().solve(&f) else { break };
                x -= step * f64::min(1.0, 0.5 / step.norm());
            }
            let is_same = |other: &[f64; 3]| {
                (0..3).all(|k| (self.at(k, other[k]) - self.at(k, x[k])).norm() < 1e-5)
            };
            if self.open(x.into()).amax() < 1e-11 && !found.iter().any(is_same) {
                found.push(x.into());
            }
        }
        found
    }

    /// Three legs of a pin, a guide and a ball, or with `is_first` of a guide, a pin and a ball; guides are driven.
    fn model(&self, is_first: bool) -> String {
        let inertia = "mass = 1\ninertia = [1, 1, 1]\n";
        let leg = |k: usize| {
            let ([.., z], r) = (self.middles[k], self.radii[k]);
            let angle = AROUND[k].to_radians();
            let pin = format!("axis = [{}, {}, 0]", -angle.sin(), angle.cos());
            let (one, two) = if is_first {
                (
                    format!(
                        "type = \"prismatic\"\nbetween = [\"ground.B{k}\", \"tube{k}\"]\naxis = [0, 0, 1]"
                    ),
                    format!("type = \"revolute\"\nbetween = [\"tube{k}\", \"rod{k}\"]\n{pin}"),
                )
            } else {
                (
                    format!("type = \"revolute\"\nbetween = [\"ground.B{k}\", \"tube{k}\"]\n{pin}"),
                    format!(
                        "type = \"prismatic\"\nbetween = [\"tube{k}\", \"rod{k}\"]\naxis = [0, 0, 1]"
                    ),
                )
            };
            let (driven, by, end) = if is_first { ("one", z, r) } else { ("two", r, 0.0) };
            format!(
                "[bodies.tube{k}]\n{inertia}[bodies.rod{k}]\n{inertia}points = {{ E = [0, 0, {end}] }}\n\
                 [joints.one{k}]\n{one}\n[joints.two{k}]\n{two}\n\
                 [joints.ball{k}]\ntype = \"spherical\"\nbetween = [\"rod{k}.E\", \"top.P{k}\"]\n\
                 [drives.d{k}]\njoint = \"{driven}{k}\"\nmotion = \"{by} + 0.1*t/s\"\n"
            )
        };
        let point = |(k, [x, y, z]): (usize, &[f64; 3])| format!("P{k} = [{x}, {y}, {z}]\n");
        let points: String = self.triangle.iter().enumerate().map(point).collect();
        let base = |(k, [x, y, z]): (usize, &[f64; 3])| {
            format!("B{k} = [{x}, {y}, {}]\n", if is_first { 0.0 } else { *z })
        };
        let base: String = self.middles.iter().enumerate().map(base).collect();
        let legs: String = (0..3).map(leg).collect();
        format!(
            "space = \"spatial\"\n[ground.points]\n{base}{legs}[bodies.top]\n{inertia}[bodies.top.points]\n{points}\
             [initial]\ntop = {{ guess = {{ x = 0.05, y = 0.02, z = 1.2 }} }}\n"
        )
    }
}

/// Legs of a pin and a ball keep three points on circles: sixteen solutions, in pairs where the circles have a common plane of
/// symmetry. All real ones are those of a search over the turns of the legs.
#[test]
fn a_platform_on_three_legs_has_sixteen_solutions() {
    let posed = [
        OnCircles::new([1.2, 1.25, 1.18], [0.0; 3]),
        OnCircles::new([0.75, 0.8, 0.7], [0.1, -0.15, 0.2]),
    ];
    for posed in posed {
        let searched = posed.searched();
        assert!(searched.len() >= 4, "{}", searched.len());
        for is_first in [false, true] {
            let found = assemblies(geometry(&posed.model(is_first))).expect("assemblies");
            let platform = platform(&found);
            assert_eq!((platform.bound, platform.solved.len()), (Some(16), 16));
            let pin = if is_first { "two0" } else { "one0" };
            assert_eq!(platform.legs[0], [pin, "ball0"].map(str::to_owned).to_vec());
            assert_eq!(found.assemblies.len(), searched.len(), "{is_first}");
            let place = |pose: &Assembly, k: usize| {
                let of = |x: &str| {
                    let name = format!("top.P{k}.{x}");
                    pose.pose.iter().find(|(known, ..)| *known == name).expect("a point").1
                };
                Vector3::from(["x", "y", "z"].map(of))
            };
            for turns in &searched {
                let is_there = |pose: &&Assembly| {
                    (0..3).all(|k| (place(pose, k) - posed.at(k, turns[k])).norm() < 1e-7)
                };
                assert_eq!(found.assemblies.iter().filter(is_there).count(), 1, "{turns:?}");
            }
        }
    }
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
