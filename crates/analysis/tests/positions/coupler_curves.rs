//! Curves of points and instant centres against references, closed forms, and what rolling means.

use crate::support::{Problem, geometry, model, number};
use bksim_analysis::{CentrePlace, Curves, CurvesRequest, curves};

fn asked(points: &[&str], centrodes: &[&str], all: bool) -> CurvesRequest {
    CurvesRequest {
        points: points.iter().map(|name| (*name).to_owned()).collect(),
        centrodes: centrodes.iter().map(|name| ((*name).to_owned(), None)).collect(),
        swept: Vec::new(),
        all_assemblies: all,
    }
}

/// A four-bar whose coupler point is at `p` in the frame of the coupler.
fn four_bar(p: [f64; 2]) -> Curves {
    let text = format!(
        r#"
[ground]
points = {{ D = [0.4, 0.05] }}
[bodies.crank]
mass = 1
points = {{ B = [0.12, 0] }}
[bodies.coupler]
mass = 1
points = {{ C = [0.35, 0], P = [{}, {}] }}
[bodies.rocker]
mass = 1
points = {{ C = [0.25, 0] }}
[joints]
A = {{ type = "revolute", between = ["ground", "crank"] }}
B = {{ type = "revolute", between = ["crank.B", "coupler"] }}
C = {{ type = "revolute", between = ["coupler.C", "rocker.C"] }}
D = {{ type = "revolute", between = ["ground.D", "rocker"] }}
[initial]
A = {{ angle = 0.9 }}
coupler = {{ guess = {{ angle = 0.6 }} }}
rocker = {{ guess = {{ angle = 1.7 }} }}
"#,
        p[0], p[1]
    );
    curves(model(&text), &asked(&["coupler.P"], &["coupler"], false)).expect("curves")
}

#[test]
fn double_points_of_a_coupler_curve_are_those_of_the_reference() {
    let problem = Problem::load("lim-crunodes-a");
    let found = curves(problem.model(), &asked(&["coupler.P"], &[], true)).expect("curves");
    let point = &found.points[0];
    let rows = problem.rows();
    assert_eq!(point.double_points.len(), rows.len());
    assert!(point.cusps.is_empty(), "{:?}", point.cusps);
    for (double, row) in point.double_points.iter().zip(&rows) {
        assert!((double.at[0] - row[0]).abs() < 1e-10 && (double.at[1] - row[1]).abs() < 1e-10);
        let angle = |k: usize| {
            let pose = &double.poses[k].pose;
            let angle = pose.iter().find(|(name, _)| name == "crank.angle").expect("an angle").1;
            angle.sin().atan2(angle.cos())
        };
        let mut angles = [angle(0), angle(1)];
        angles.sort_by(f64::total_cmp);
        assert!((angles[0] - row[2]).abs() < 1e-10 && (angles[1] - row[4]).abs() < 1e-10);
    }
}

/// Roberts' and Chebyshev's theorem: a coupler curve of a four-bar has at most three double points, and all of
/// them lie on the circle through the pivots and the third focus.
#[test]
fn double_points_lie_on_the_circle_of_foci() {
    let values = &Problem::load("lim-crunodes-a").0["values"]["circle_of_foci"];
    let centre = values["centre"].as_array().expect("a point");
    let (x, y) = (number(&centre[0]), number(&centre[1]));
    let point = &four_bar([0.3, -0.18]).points[0];
    assert!(!point.double_points.is_empty() && point.double_points.len() <= 3);
    for double in &point.double_points {
        let radius = (double.at[0] - x).hypot(double.at[1] - y);
        assert!((radius - number(&values["radius"])).abs() < 1e-10, "{double:?}");
    }
}

/// The point of a body that is its instant centre in some pose has a cusp there.
#[test]
fn a_point_on_the_moving_centrode_draws_a_cusp() {
    let centrodes = four_bar([0.1, 0.1]).centrodes.swap_remove(0);
    let (moving, fixed) = (centrodes.moving[0][40], centrodes.fixed[0][40]);
    let point = &four_bar(moving).points[0];
    let is_there = |p: [f64; 2]| (p[0] - fixed[0]).hypot(p[1] - fixed[1]) < 1e-9;
    assert!(point.cusps.iter().any(|cusp| is_there(cusp.at)), "{fixed:?}: {:?}", point.cusps);
    // A little aside there is none: a loop, or a bend.
    let aside = &four_bar([moving[0] + 1e-3, moving[1] + 1e-3]).points[0];
    assert!(aside.cusps.is_empty(), "{:?}", aside.cusps);
}

#[test]
fn a_point_that_goes_back_the_way_it_came_has_neither_cusp_nor_double_point() {
    let text_point = curves(
        Problem::load("lim-crunodes-a").model(),
        &asked(&["coupler.C", "crank.B"], &[], true),
    );
    for point in text_point.expect("curves").points {
        assert!(point.cusps.is_empty() && point.double_points.is_empty(), "{point:?}");
    }
}

#[test]
fn the_way_of_a_crank_pin_is_a_circle() {
    let found = curves(Problem::load("lim-crunodes-a").model(), &asked(&["B"], &[], false));
    let branch = &found.expect("curves").points[0].branches[0];
    assert!(branch.is_closed);
    let circle = std::f64::consts::TAU * 0.12;
    assert!((branch.length - circle).abs() < 1e-7 * circle, "{} of {circle}", branch.length);
}

#[test]
fn instant_centres_lie_on_the_links_and_three_by_three_on_lines() {
    let found = four_bar([0.3, -0.18]);
    let centre = |a: &str, b: &str| {
        let known = found.centres.iter().find(|c| c.bodies == [a.to_owned(), b.to_owned()]);
        match known.expect("a pair").place {
            CentrePlace::At(p) => p,
            other => panic!("{a} and {b}: {other:?}"),
        }
    };
    let across = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        (u[0] * v[1] - u[1] * v[0]) / (u[0].hypot(u[1]) * v[0].hypot(v[1]))
    };
    let [o, d] = [centre("ground", "crank"), centre("ground", "rocker")];
    assert!(o[0].hypot(o[1]) < 1e-12 && (d[0] - 0.4).hypot(d[1] - 0.05) < 1e-12);
    let [b, c] = [centre("crank", "coupler"), centre("coupler", "rocker")];
    // Aronhold and Kennedy: the centres of three bodies are on one line.
    let pole = centre("ground", "coupler");
    assert!(across(o, b, pole).abs() < 1e-10 && across(d, c, pole).abs() < 1e-10);
    let relative = centre("crank", "rocker");
    assert!(across(o, d, relative).abs() < 1e-10 && across(b, c, relative).abs() < 1e-10);
}

/// Centrodes roll on each other: between two poses both are equally long.
#[test]
fn the_moving_centrode_rolls_on_the_fixed_one() {
    let found = four_bar([0.3, -0.18]);
    let centrodes = &found.centrodes[0];
    assert_eq!(centrodes.bodies, ["ground", "coupler"]);
    assert!(!centrodes.fixed.is_empty());
    for (fixed, moving) in centrodes.fixed.iter().zip(&centrodes.moving) {
        for (a, b) in fixed.windows(2).zip(moving.windows(2)) {
            let length =
                |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            // Chords of the two curves differ by their curvatures, times the cube of their length.
            let [a, b] = [length(a), length(b)];
            assert!((a - b).abs() < 1e-3 * (a + b) + 1e-9, "{a} and {b}");
        }
    }
}

#[test]
fn a_crank_that_turns_round_sweeps_a_disc_and_a_rocker_a_sector() {
    let request =
        CurvesRequest { swept: vec!["crank".into(), "rocker".into()], ..CurvesRequest::default() };
    let problem = Problem::load("lim-crunodes-a");
    let found = curves(problem.model(), &request).expect("curves");
    let disc = std::f64::consts::PI * 0.12 * 0.12;
    assert!((found.swept[0].area / disc - 1.0).abs() < 1e-3, "{} of {disc}", found.swept[0].area);
    let limits = bksim_analysis::limits(problem.model(), &bksim_analysis::LimitsRequest::default());
    let ranges = &limits.expect("limits").branches[0].ranges;
    let range = ranges.iter().find(|range| range.name == "rocker.angle").expect("a range");
    let sector = 0.5 * 0.25 * 0.25 * (range.max - range.min);
    assert!(
        (found.swept[1].area / sector - 1.0).abs() < 1e-3,
        "{} of {sector}",
        found.swept[1].area
    );
}

/// Two links of 1 m and 0.6 m, with stops.
fn arm(stops: &str) -> bksim_model::Model {
    model(&format!(
        r#"
[bodies.upper]
mass = 1
points = {{ E = [1, 0] }}
[bodies.lower]
mass = 1
points = {{ P = [0.6, 0] }}
[joints]
A = {{ type = "revolute", between = ["ground", "upper"] }}
B = {{ type = "revolute", between = ["upper.E", "lower"] }}
[initial]
A = {{ angle = 0.5 }}
B = {{ angle = 1 }}
{stops}
"#
    ))
}

#[test]
fn two_links_reach_a_ring() {
    let found = bksim_analysis::workspaces(arm(""), &["lower.P".into()]).expect("a workspace");
    let ring = std::f64::consts::PI * (1.6f64.powi(2) - 0.4f64.powi(2));
    assert!((found[0].area / ring - 1.0).abs() < 1e-3, "{} of {ring}", found[0].area);
    assert!(found[0].barriers.is_empty());
    for p in found[0].boundary.iter().flatten() {
        let radius = p[0].hypot(p[1]);
        assert!((radius - 1.6).abs() < 1e-9 || (radius - 0.4).abs() < 1e-9, "{radius}");
    }
}

/// With the elbow on one side, the region is a sector of a ring, turned at each radius alike: its area is that of the
/// range of the shoulder times half the difference of the squares of the radii.
#[test]
fn stops_bound_a_workspace() {
    let stops = r#"
[loads.shoulder]
type = "stop"
joint = "A"
min = 0
max = 1.5
[loads.elbow]
type = "stop"
joint = "B"
min = 0.4
max = 2
"#;
    let found = bksim_analysis::workspaces(arm(stops), &["lower.P".into()]).expect("a workspace");
    let square = |angle: f64| 1.0 + 0.36 + 1.2 * angle.cos();
    let area = 0.5 * 1.5 * (square(0.4) - square(2.0));
    assert!((found[0].area / area - 1.0).abs() < 2e-3, "{} of {area}", found[0].area);
}

/// A cylinder of the same length could stand on the other side of its arm, too; the arm does not get there.
#[test]
fn a_workspace_is_of_the_assembly_of_the_start() {
    let text = r#"
[ground]
points = { C = [0.4, -0.3] }
[bodies.upper]
mass = 1
points = { C = [1.4, 0.1], E = [1.8, 0] }
[bodies.lower]
mass = 1
points = { P = [1, 0] }
[joints]
A = { type = "revolute", between = ["ground", "upper"] }
B = { type = "revolute", between = ["upper.E", "lower"] }
cylinder = { type = "cylinder", between = ["ground.C", "upper.C"] }
[loads]
travel = { type = "stop", joint = "cylinder", min = 1.0, max = 1.6 }
elbow = { type = "stop", joint = "B", min = -2, max = -0.4 }
[initial]
A = { angle = 0.3 }
B = { angle = -1 }
"#;
    let found = bksim_analysis::workspaces(model(text), &["lower.P".into()]).expect("a workspace");
    let (p, q) = (0.5, 1.4f64.hypot(0.1));
    let at = |length: f64| ((p * p + q * q - length * length) / (2.0 * p * q)).acos();
    let square = |angle: f64| 1.8 * 1.8 + 1.0 + 3.6 * angle.cos();
    let area = 0.5 * (at(1.6) - at(1.0)) * (square(0.4) - square(2.0));
    assert!((found[0].area / area - 1.0).abs() < 5e-3, "{} of {area}", found[0].area);
}

/// A planetary train with a fixed ring: points of the arm go round once for each of its turns, points of the planet close
/// after as many turns as the teeth need, and the whole motion comes back after those of the sun.
#[test]
fn a_way_that_repeats_itself_is_told_once() {
    let (arm, planet) = (0.25_f64, 0.15_f64);
    let text = format!(
        "[ground]\npoints = {{ O = [0, 0] }}\n[bodies.sun]\n[bodies.arm]\npoints = {{ P = [{arm}, 0] }}\n\
         [bodies.planet]\npoints = {{ Q = [{planet}, 0], S = [0.07, 0] }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"sun\"] }}\n\
         B = {{ type = \"revolute\", between = [\"ground\", \"arm\"] }}\n\
         C = {{ type = \"revolute\", between = [\"arm.P\", \"planet\"] }}\n\
         [couplings]\n\
         s = {{ type = \"gear\", between = [\"A\", \"C\"], teeth = [20, 30], carrier = \"arm\" }}\n\
         r = {{ type = \"gear\", between = [\"C\", \"ground.O\"], teeth = [30, 80], internal = true, carrier = \"arm\" }}\n"
    );
    let found =
        curves(geometry(&text), &asked(&["arm.P", "planet.S"], &[], false)).expect("curves");
    let [of_arm, of_planet] = found.points.as_slice() else { panic!("two points") };

    // Turns of the arm: the planet turns by 1 − 80/30 = −5/3 for each, the sun by 1 + 80/20 = 5.
    let circle = &of_arm.branches[0];
    assert_eq!((circle.is_closed, circle.n_laps), (true, Some(3)));
    let round = std::f64::consts::TAU * arm;
    assert!((circle.length / round - 1.0).abs() < 1e-6, "{} against {round}", circle.length);
    assert!(of_arm.double_points.is_empty());

    // p = arm e^(iφ) + 0.07 e^(−5iφ/3), over three turns.
    let way = &of_planet.branches[0];
    assert_eq!((way.is_closed, way.n_laps), (true, Some(1)));
    let n = 60_000;
    let speed = |k: i32| {
        let phi = 3.0 * std::f64::consts::TAU * f64::from(k) / f64::from(n);
        let (a, b) = (arm, -5.0 / 3.0 * 0.07);
        (a * a + b * b + 2.0 * a * b * (8.0 / 3.0 * phi).cos()).sqrt()
    };
    let sum: f64 = (0..n).map(speed).sum();
    let length = 3.0 * std::f64::consts::TAU / f64::from(n) * sum;
    assert!((way.length / length - 1.0).abs() < 1e-6, "{} against {length}", way.length);
}
