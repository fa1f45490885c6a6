//! Limit positions and assemblies against references of 15 digits.

mod support;

use std::f64::consts::TAU;

use bksim_analysis::{Branch, Limits, LimitsRequest, assemblies, limits};
use support::{Problem, model, number};

fn value(pose: &[(String, f64)], name: &str) -> f64 {
    pose.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no {name}")).1
}

fn off(a: f64, b: f64) -> f64 {
    let off = a - b;
    (off - TAU * (off / TAU).round()).abs()
}

fn of(branch: &Branch, name: &str) -> Vec<Vec<(String, f64)>> {
    let own = branch.extremes.iter().filter(|extreme| extreme.name == name);
    own.map(|extreme| extreme.pose.clone()).collect()
}

fn found(name: &str, drive: Option<&str>, outputs: &[&str], all: bool) -> (Problem, Limits) {
    let problem = Problem::load(name);
    let request = LimitsRequest {
        drive: drive.map(str::to_owned),
        outputs: outputs.iter().map(|name| (*name).to_owned()).collect(),
        all_assemblies: all,
    };
    let limits = limits(problem.model(), &request).expect("limits");
    (problem, limits)
}

#[test]
fn crank_rocker() {
    let (problem, limits) =
        found("lim-crank-rocker", Some("crank.angle"), &["rocker.angle"], false);
    let values = &problem.0["values"];
    let [branch] = limits.branches.as_slice() else { panic!("one branch") };
    let poses = of(branch, "rocker.angle");
    assert_eq!(poses.len(), 2);
    for limit in values["limits"].as_array().expect("limits") {
        let meets = |pose: &Vec<(String, f64)>| {
            ["crank", "coupler", "rocker"].iter().all(|body| {
                off(value(pose, &format!("{body}.angle")), number(&limit[*body])) < 1e-10
            })
        };
        assert!(poses.iter().any(meets), "{limit} is not among {poses:?}");
    }
    let ratio = branch.outputs[0].time_ratio.expect("a time ratio");
    assert!((ratio - number(&values["time_ratio"])).abs() < 1e-10);
    for expected in values["transmission"].as_array().expect("angles") {
        let meets = |pose: &Vec<(String, f64)>| {
            off(value(pose, "crank.angle"), number(&expected["crank"])) < 1e-10
                && (value(pose, "transmission C").abs() - number(&expected["angle"])).abs() < 1e-10
        };
        let poses = of(branch, "transmission C");
        assert!(poses.len() == 2 && poses.iter().any(meets), "{expected}: {poses:?}");
    }
}

#[test]
fn quick_return() {
    let (problem, limits) = found("lim-whitworth", Some("crank.angle"), &["ram.x"], false);
    let values = &problem.0["values"];
    let branch = &limits.branches[0];
    let poses = of(branch, "ram.x");
    assert_eq!(poses.len(), 2);
    for limit in values["limits"].as_array().expect("limits") {
        let meets = |pose: &Vec<(String, f64)>| {
            off(value(pose, "crank.angle"), number(&limit["crank"])) < 1e-10
                && (value(pose, "ram.x") - number(&limit["position"])).abs() < 1e-10
        };
        assert!(poses.iter().any(meets), "{limit} is not among {poses:?}");
    }
    let output = &branch.outputs[0];
    let ratio = output.time_ratio.expect("a time ratio");
    assert!((ratio - number(&values["time_ratio"])).abs() < 1e-10);
    for speed in values["largest_speed"].as_array().expect("speeds") {
        let meets = |[crank, _, rate]: &[f64; 3]| {
            off(*crank, number(&speed["crank"])) < 1e-10
                && (rate - number(&speed["velocity_per_crank_rate"])).abs() < 1e-10
        };
        assert!(output.fastest.iter().any(meets), "{speed} is not among {:?}", output.fastest);
    }
}

#[test]
fn rockers_on_both_sides() {
    let (problem, limits) = found("lim-triple-rocker", None, &[], true);
    assert_eq!(limits.branches.len(), 1, "both assemblies are one branch");
    let branch = &limits.branches[0];
    let rows = problem.rows();
    for (input, name) in [(0.0, "crank.angle"), (1.0, "rocker.angle")] {
        let poses = of(branch, name);
        let own: Vec<_> = rows.iter().filter(|row| row[0] == input).collect();
        assert_eq!(poses.len(), own.len(), "{name}");
        for row in own {
            let meets = |pose: &Vec<(String, f64)>| {
                ["crank", "coupler", "rocker"].iter().zip(&row[1..]).all(|(body, expected)| {
                    off(value(pose, &format!("{body}.angle")), *expected) < 1e-10
                })
            };
            assert!(poses.iter().any(meets), "{row:?} is not among {poses:?}");
        }
    }
}

/// R. L. Norton, *Design of Machinery*: links of 40, 120, 80 and 100 mm at 40°.
const NORTON: &str = r#"
[ground]
points = { D = ["100 mm", 0] }
[bodies.crank]
mass = 1
points = { B = ["40 mm", 0] }
[bodies.coupler]
mass = 1
points = { C = ["120 mm", 0] }
[bodies.rocker]
mass = 1
points = { C = ["80 mm", 0] }
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "coupler"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker"] }
[initial]
A = { angle = "40 deg" }
coupler = { guess = { angle = "20 deg" } }
"#;

#[test]
fn four_bar_open_and_crossed() {
    let found = assemblies(model(NORTON)).expect("assemblies");
    let names: Vec<&str> = found.assemblies.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["A-B-C-D open", "A-B-C-D crossed"]);
    let expected = [[20.2979, 57.3249], [-60.9780, -98.0050]];
    for (assembly, angles) in found.assemblies.iter().zip(expected) {
        for (body, angle) in ["coupler.angle", "rocker.angle"].iter().zip(angles) {
            let (_, value, _) =
                assembly.pose.iter().find(|(name, ..)| name == body).expect("an angle");
            assert!(off(*value, f64::to_radians(angle)) < 1e-6, "{body}: {}", value.to_degrees());
        }
    }
}

#[test]
fn rocker_and_transmission_angle_of_the_four_bar() {
    let limits = limits(model(NORTON), &LimitsRequest::default()).expect("limits");
    let branch = &limits.branches[0];
    let range = |name: &str| {
        let range = branch.ranges.iter().find(|range| range.name == name).expect("a range");
        [range.min, range.max].map(f64::to_degrees)
    };
    let close = |found: [f64; 2], expected: [f64; 2]| {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-4, "{found:?} instead of {expected:?}");
        }
    };
    close(range("rocker.angle"), [54.9004, 128.6822]);
    // From the rocker to the coupler; Norton's angle is the acute one.
    let cranks: Vec<f64> =
        of(branch, "rocker.angle").iter().map(|p| value(p, "crank.angle")).collect();
    for crank in [24.1468, 231.3178_f64] {
        assert!(cranks.iter().any(|c| off(*c, crank.to_radians()) < 2e-6), "{cranks:?}");
    }
}
