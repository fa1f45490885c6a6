//! Regions that points reach and bodies sweep, against closed forms.

use std::f64::consts::PI;

use crate::support::model;
use bksim_analysis::{CurvesRequest, LimitsRequest, curves, limits, workspaces};

/// The area that the point of an arm of 1 m and 0.6 m reaches, with stops, from angles of the start in degrees.
fn arm(stops: &str, [shoulder, elbow]: [f64; 2]) -> f64 {
    let text = format!(
        "[bodies]\na = {{ mass = 1, inertia = 1, points = {{ e = [1, 0] }} }}\nb = {{ mass = 1, inertia = 1, points = {{ P = [0.6, 0] }} }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"a\"] }}\n\
         B = {{ type = \"revolute\", between = [\"a.e\", \"b\"] }}\n\
         [initial]\nA = {{ angle = \"{shoulder} deg\" }}\nB = {{ angle = \"{elbow} deg\" }}\n[loads]\n{stops}"
    );
    area(&text)
}

fn area(text: &str) -> f64 {
    let found = workspaces(model(text), &["b.P".into()]).expect("a workspace");
    found[0].area
}

fn stop(name: &str, joint: &str, [min, max]: [f64; 2]) -> String {
    format!(
        "{name} = {{ type = \"stop\", joint = \"{joint}\", min = \"{min} deg\", max = \"{max} deg\" }}\n"
    )
}

fn near(found: f64, right: f64) {
    assert!((found / right - 1.0).abs() < 2e-4, "{found} of {right}");
}

/// Between stops of the elbow the region is a ring by the law of cosines, with those of the shoulder a part of it that is turned
/// at each radius alike; with the elbow free, discs about all that the elbow passes.
#[test]
fn stops_at_the_stretched_pose_and_across_it_bound_what_an_arm_reaches() {
    let square = |degrees: f64| 1.36 + 1.2 * degrees.to_radians().cos();
    for start in [[45.0, 45.0], [75.0, 20.0], [10.0, 5.0]] {
        near(arm(&stop("s", "A", [0.0, 90.0]), start), 0.96 * PI);
        for (limits, inner) in [([-90.0, 90.0], 90.0), ([0.0, 180.0], 180.0), ([0.0, 120.0], 120.0)]
        {
            near(arm(&stop("s", "B", limits), start), PI * (square(0.0) - square(inner)));
        }
        for (elbow, shoulder) in [(150.0, 90.0), (90.0, 90.0), (60.0, 90.0)] {
            let stops = stop("s", "B", [0.0, elbow]) + &stop("t", "A", [0.0, shoulder]);
            near(arm(&stops, start), 0.25 * PI * (square(0.0) - square(elbow)));
        }
    }
}

#[test]
fn slides_between_stops_reach_a_rectangle_and_a_sector() {
    let rectangle = "[bodies]\na = { mass = 1, inertia = 1 }\nb = { mass = 1, inertia = 1, points = { P = [0, 0] } }\n\
        [joints]\nA = { type = \"prismatic\", between = [\"ground\", \"a\"], axis = [1, 0] }\n\
        B = { type = \"prismatic\", between = [\"a\", \"b\"], axis = [0, 1] }\n\
        [loads]\ns = { type = \"stop\", joint = \"B\", min = 0, max = 0.7 }\n\
        r = { type = \"stop\", joint = \"A\", min = 0, max = 2 }\n\
        [initial]\nA = { position = 0.5 }\nB = { position = 0.2 }\n";
    near(area(rectangle), 1.4);
    let sector = "[bodies]\na = { mass = 1, inertia = 1 }\nb = { mass = 1, inertia = 1, points = { P = [0.5, 0] } }\n\
        [joints]\nA = { type = \"revolute\", between = [\"ground\", \"a\"] }\n\
        B = { type = \"prismatic\", between = [\"a\", \"b\"], axis = [1, 0] }\n\
        [loads]\ns = { type = \"stop\", joint = \"B\", min = 0, max = 0.7 }\n\
        r = { type = \"stop\", joint = \"A\", min = \"-60 deg\", max = \"60 deg\" }\n\
        [initial]\nA = { angle = 0 }\nB = { position = 0.2 }\n";
    near(area(sector), PI / 3.0 * (1.2 * 1.2 - 0.5 * 0.5));
}

fn swept(text: &str, body: &str) -> f64 {
    let request = CurvesRequest { swept: vec![body.into()], ..CurvesRequest::default() };
    curves(model(text), &request).expect("curves").swept[0].area
}

#[test]
fn bodies_sweep_a_ring_and_an_astroid() {
    let ring = "[bodies]\na = { mass = 1, inertia = 1, outline = [[0.5, -0.1], [1, -0.1], [1, 0.1], [0.5, 0.1]] }\n\
        [joints]\nA = { type = \"revolute\", between = [\"ground\", \"a\"] }\n";
    near(swept(ring, "a"), PI * (1.01 - 0.25));
    // A ladder of 0.8 m between two walls across each other, all round.
    let ladder = "[ground]\npoints = { O = [0, 0] }\n\
        [bodies]\nrod = { mass = 1, inertia = 1, points = { A = [0, 0], B = [0.8, 0] } }\n\
        [joints]\na = { type = \"slot\", between = [\"ground.O\", \"rod.A\"], axis = [1, 0] }\n\
        b = { type = \"slot\", between = [\"ground.O\", \"rod.B\"], axis = [0, 1] }\n\
        [initial]\nrod = { guess = { angle = \"120 deg\", x = 0.4, y = 0.3 } }\n";
    near(swept(ladder, "rod"), 3.0 * PI * 0.64 / 8.0);
}

/// A wheel that rolls in a ring three and four times as large, and on one as large: a deltoid, an astroid, a cardioid.
#[test]
fn a_curve_with_cusps_alone_has_no_double_points() {
    for (arm, ring, is_inside, n_cusps) in
        [(0.2, 0.3, true, 3), (0.3, 0.4, true, 4), (0.2, 0.1, false, 1)]
    {
        let text = format!(
            "[bodies]\narm = {{ mass = 1, inertia = 1, points = {{ T = [{arm}, 0] }} }}\npl = {{ mass = 1, inertia = 1, points = {{ P = [0.1, 0] }} }}\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"arm\"] }}\n\
             B = {{ type = \"revolute\", between = [\"arm.T\", \"pl\"] }}\n\
             [couplings.r]\ntype = \"gear\"\nbetween = [\"B\", \"ground\"]\nradii = [0.1, {ring}]\n\
             internal = {is_inside}\ncarrier = \"arm\"\n"
        );
        let request = CurvesRequest { points: vec!["pl.P".into()], ..CurvesRequest::default() };
        let found = curves(model(&text), &request).expect("curves");
        let point = &found.points[0];
        assert_eq!(point.cusps.len(), n_cusps, "{:?}", point.cusps);
        assert!(point.double_points.is_empty(), "{:?}", point.double_points);
    }
}

/// A crank that turns back goes no whole turn, so that there and back have no times to compare.
#[test]
fn a_crank_that_cannot_turn_round_has_no_time_ratio() {
    let text = "[ground]\npoints = { A = [0, 0], D = [0.2, 0], G = [0.45, 0.05] }\n\
        [bodies]\na = { mass = 1, inertia = 1, points = { B = [0.06, 0] } }\nb = { mass = 1, inertia = 1, points = { C = [0.18, 0] } }\n\
        c = { mass = 1, inertia = 1, points = { C = [0.14, 0], E = [0.16, 0.06] } }\nd = { mass = 1, inertia = 1, points = { F = [0.2, 0] } }\n\
        e = { mass = 1, inertia = 1, points = { F = [0.17, 0] } }\n\
        [joints]\nA = { type = \"revolute\", between = [\"ground.A\", \"a\"] }\n\
        B = { type = \"revolute\", between = [\"a.B\", \"b\"] }\nC = { type = \"revolute\", between = [\"b.C\", \"c.C\"] }\n\
        D = { type = \"revolute\", between = [\"ground.D\", \"c\"] }\nE = { type = \"revolute\", between = [\"c.E\", \"d\"] }\n\
        F = { type = \"revolute\", between = [\"d.F\", \"e.F\"] }\nG = { type = \"revolute\", between = [\"ground.G\", \"e\"] }\n\
        [initial]\nA = { angle = \"40 deg\" }\nD = { guess = { angle = \"80 deg\" } }\nG = { guess = { angle = \"90 deg\" } }\n";
    let request = LimitsRequest {
        drive: Some("A.angle".into()),
        outputs: vec!["G.angle".into()],
        ..LimitsRequest::default()
    };
    let found = limits(model(text), &request).expect("limits");
    for output in found.branches.iter().flat_map(|branch| &branch.outputs) {
        assert_eq!(output.time_ratio, None, "{output:?}");
    }
}
