//! Freedoms of mechanisms whose count is known, and cures counted in models that are written with them.

use std::f64::consts::PI;

use crate::support::geometry;
use bksim_analysis::{Doctor, Singularity, doctor, singular_poses};

fn examined(text: &str) -> Doctor {
    doctor(geometry(text)).expect("a mechanism that closes")
}

fn count(text: &str) -> [i64; 3] {
    let count = examined(text).count;
    [count.counted, count.mobility, count.n_redundant]
}

/// A four-bar with these joint types and axes, lengths 1, 3, 2.5 and 3.2 from A over B and C to D.
fn four_bar(space: &str, joints: [&str; 4]) -> String {
    let [a, b, c, d] = joints;
    format!(
        "space = \"{space}\"\n[ground.points]\nD = [3.2, 0, 0]\n\
         [bodies]\ncrank = {{ points = {{ B = [1, 0, 0] }} }}\n\
         coupler = {{ points = {{ C = [3, 0, 0] }} }}\nrocker = {{ points = {{ C = [2.5, 0, 0] }} }}\n\
         [joints]\nA = {{ {a}, between = [\"ground\", \"crank\"] }}\n\
         B = {{ {b}, between = [\"crank.B\", \"coupler\"] }}\n\
         C = {{ {c}, between = [\"coupler.C\", \"rocker.C\"] }}\n\
         D = {{ {d}, between = [\"ground.D\", \"rocker\"] }}\n\
         [initial]\n"
    )
}

/// The redundant conditions in words.
fn redundant(found: &Doctor) -> Vec<&str> {
    found.repeated.iter().map(|repeated| repeated.condition.words.as_str()).collect()
}

const TURN: &str = "type = \"revolute\", axis = [0, 0, 1]";

fn spatial(joints: [&str; 4]) -> String {
    four_bar("spatial", joints)
}

#[test]
fn a_planar_four_bar_in_space_repeats_three_conditions() {
    let found = examined(&spatial([TURN; 4]));
    assert_eq!(found.count.counted, -2);
    assert_eq!(found.count.mobility, 1);
    assert_eq!(found.count.n_redundant, 3);
    assert_eq!(found.repeated.len(), 3);
    assert_eq!(
        redundant(&found),
        [
            "force along the z axis of `D`",
            "moment about the x axis of `D`",
            "moment about the y axis of `D`",
        ]
    );
    assert!(found.repeated.iter().all(|repeated| !repeated.by.is_empty()));
    assert_eq!(found.motions.len(), 1);
    let motion = &found.motions[0];
    assert!(motion.is_finite);
    let names: Vec<&str> = motion.rates.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(names, ["A.angle", "B.angle", "C.angle", "D.angle"]);
    assert_eq!(motion.bodies, ["crank", "coupler", "rocker"]);
    // Axes of the four pins are parallel, none in line with another.
    assert_eq!(found.alignments.len(), 1, "{:?}", found.alignments);
    assert_eq!(found.alignments[0].joints.len(), 4);
    assert!(found.alignments[0].angle < 1e-9 && found.alignments[0].distance.is_none());

    // Each cure, written into the model, counts as the report says.
    assert!(!found.cures.is_empty());
    for cure in &found.cures {
        let mut joints = [TURN; 4];
        let mut words: Vec<String> = Vec::new();
        for (_, _, to) in &cure.changes {
            words.push(format!(
                "type = \"{to}\"{}",
                if *to == "spherical" { "" } else { ", axis = [0, 0, 1]" }
            ));
        }
        for ((joint, ..), word) in cure.changes.iter().zip(&words) {
            let place =
                ["A", "B", "C", "D"].iter().position(|name| name == joint).expect("a joint");
            joints[place] = word;
        }
        assert_eq!(count(&spatial(joints)), [1, 1, 0], "{cure:?}");
        assert_eq!(cure.count.n_redundant, 0);
    }
}

/// A direction that a joint gives up is redundant no more, and the rest still is.
#[test]
fn a_freed_direction_is_redundant_no_more() {
    let slides = "type = \"cylindrical\", axis = [0, 0, 1]";
    let found = examined(&spatial([TURN, TURN, TURN, slides]));
    let rest = ["moment about the x axis of `D`", "moment about the y axis of `D`"];
    assert_eq!(redundant(&found), rest);
    let found = examined(&spatial([TURN, TURN, TURN, "type = \"spherical\""]));
    assert_eq!(redundant(&found), ["force along the z axis of `D`"]);
}

/// The axes of a joint are those of the frame of its first point, and an oblique hinge has oblique directions.
#[test]
fn directions_are_in_the_axes_of_the_joint() {
    let door = |frame: &str, axis: &str| {
        format!(
            "space = \"spatial\"\n[ground.points]\nL = {{ at = [0, 0, 0], {frame} }}\nU = {{ at = [0, 0, 1], {frame} }}\n\
             [bodies.door]\npoints = {{ L = {{ at = [0, 0, 0], {frame} }}, U = {{ at = [0, 0, 1], {frame} }} }}\n[joints]\n\
             lower = {{ type = \"revolute\", axis = {axis}, between = [\"ground.L\", \"door.L\"] }}\n\
             upper = {{ type = \"cylindrical\", axis = {axis}, between = [\"ground.U\", \"door.U\"] }}\n"
        )
    };
    // Turned by 90° about y, the frame has the world's z along its own −x.
    let found = examined(&door("rpy = [0, \"90 deg\", 0]", "[1, 0, 0]"));
    let words = [
        "force along the y axis of `upper`",
        "force along the z axis of `upper`",
        "moment about the y axis of `upper`",
        "moment about the z axis of `upper`",
    ];
    assert_eq!(redundant(&found), words);
    // Turned by 45° about x, the hinge is oblique in its frame.
    let found = examined(&door("rpy = [\"45 deg\", 0, 0]", "[0, 1, 1]"));
    let axes: Vec<_> =
        found.repeated.iter().filter_map(|repeated| repeated.condition.axis).collect();
    assert_eq!(axes.len(), 4, "{found:?}");
    for axis in axes {
        let along = axis[1] + axis[2];
        assert!(along.abs() < 1e-9, "{axis:?} is across the hinge");
    }
}

#[test]
fn a_door_needs_one_hinge_that_slides_and_swivels() {
    let text = "space = \"spatial\"\n[ground.points]\nU = [0, 0, 1]\n\
                [bodies.door]\npoints = { U = [0, 0, 1] }\n\
                [joints]\nlower = { type = \"revolute\", axis = [0, 0, 1], between = [\"ground\", \"door\"] }\n\
                upper = { type = \"revolute\", axis = [0, 0, 1], between = [\"ground.U\", \"door.U\"] }\n";
    let found = examined(text);
    assert_eq!([found.count.counted, found.count.mobility, found.count.n_redundant], [-4, 1, 5]);
    assert!(found.repeated.iter().all(|repeated| repeated.condition.of == "upper"), "{found:?}");
    assert_eq!(found.alignments.len(), 1);
    assert!(found.alignments[0].distance.expect("in line") < 1e-12);
    let first = &found.cures[0];
    assert_eq!(first.changes.len(), 2, "a ball and a ball on a line: {:?}", found.cures);
    let words: Vec<&str> = first.changes.iter().map(|(_, _, to)| *to).collect();
    assert!(words.contains(&"spherical") && words.contains(&"point-on-line"), "{words:?}");
}

/// A rod between two balls turns about itself, whatever else moves.
#[test]
fn a_rod_between_balls_has_a_free_motion_of_its_own() {
    let found = examined(&spatial([TURN, "type = \"spherical\"", "type = \"spherical\"", TURN]));
    assert_eq!([found.count.counted, found.count.mobility, found.count.n_redundant], [2, 2, 0]);
    let alone = found.motions.iter().find(|motion| motion.bodies == ["coupler"]);
    assert!(alone.is_some(), "{:?}", found.motions);
    assert!(found.cures.is_empty() && found.repeated.is_empty());
}

/// A parallelogram with three cranks: one condition too many in its plane.
#[test]
fn a_third_crank_is_cured_by_a_slot() {
    let text = "[ground.points]\nB = [1, 0]\nC = [2, 0]\n\
                [bodies]\na = { points = { P = [0.4, 0] } }\nb = { points = { P = [0.4, 0] } }\n\
                c = { points = { P = [0.4, 0] } }\nbar = { points = { Q = [1, 0], R = [2, 0] } }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"a\"] }\n\
                B = { type = \"revolute\", between = [\"ground.B\", \"b\"] }\n\
                C = { type = \"revolute\", between = [\"ground.C\", \"c\"] }\n\
                P = { type = \"revolute\", between = [\"a.P\", \"bar\"] }\n\
                Q = { type = \"revolute\", between = [\"b.P\", \"bar.Q\"] }\n\
                R = { type = \"revolute\", between = [\"c.P\", \"bar.R\"] }\n\
                [initial]\nA = { angle = 1.1 }\nB = { guess = { angle = 1.1 } }\nC = { guess = { angle = 1.1 } }\n";
    let found = examined(text);
    assert_eq!([found.count.counted, found.count.mobility, found.count.n_redundant], [0, 1, 1]);
    assert!(found.cures.iter().all(|cure| cure.changes.len() == 1 && cure.changes[0].2 == "slot"));
    assert!(!found.cures.is_empty());
    let slotted = text.replace(
        "R = { type = \"revolute\", between",
        "R = { type = \"slot\", axis = [1, 0], between",
    );
    let after = count(&slotted);
    assert_eq!(after, [1, 1, 0], "{after:?}");
}

/// A toggle stretched out yields at right angles but goes nowhere.
#[test]
fn a_stretched_toggle_yields_without_a_motion() {
    let text = "[ground.points]\nB = [2, 0]\n[bodies]\na = { points = { P = [1, 0] } }\nb = { points = { P = [1, 0] } }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"a\"] }\n\
                P = { type = \"revolute\", between = [\"a.P\", \"b\"] }\n\
                B = { type = \"revolute\", between = [\"ground.B\", \"b.P\"] }\n";
    let found = examined(text);
    assert_eq!([found.count.counted, found.count.mobility], [0, 1]);
    assert!(!found.motions[0].is_finite, "{:?}", found.motions);
}

/// Sarrus' linkage: both chains keep the platform from turning about the vertical.
#[test]
fn a_sarrus_linkage_is_cured_by_a_universal_joint() {
    let text = include_str!("../../../../tests/fixtures/sarrus.toml");
    let found = examined(text);
    assert_eq!([found.count.counted, found.count.mobility, found.count.n_redundant], [0, 1, 1]);
    assert!(!found.cures.is_empty());
    assert!(found.cures.iter().all(|cure| cure.changes.len() == 1), "{:?}", found.cures);
    assert!(found.cures.iter().any(|cure| cure.changes[0].2 == "universal"));
    let groups: Vec<usize> = found.alignments.iter().map(|of| of.joints.len()).collect();
    assert_eq!(groups, [3, 3], "two chains of three parallel axes");
}

/// Crank 1, coupler 3, rocker 2.5, ground 3.2: the rocker's dead points by the law of cosines in the stretched and the
/// folded triangle; the crank turns round.
#[test]
fn dead_points_of_a_rocker_that_drives_are_located() {
    let text = four_bar("planar", ["type = \"revolute\""; 4]);
    let text = text.replace(", 0] }", "] }").replace("[3.2, 0, 0]", "[3.2, 0]");
    let found = singular_poses(geometry(&text), "D.angle").expect("poses");
    let dead: Vec<f64> = found
        .iter()
        .filter(|of| of.kind == Singularity::DeadPoint)
        .map(|of| of.drive.abs())
        .collect();
    let at =
        |reach: f64| PI - f64::acos((2.5 * 2.5 + 3.2 * 3.2 - reach * reach) / (2.0 * 2.5 * 3.2));
    for expected in [at(4.0), at(2.0)] {
        assert!(dead.iter().any(|angle| (angle - expected).abs() < 1e-9), "{dead:?}: {expected}");
    }
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(singular_poses(geometry(&text), "A.angle").expect("poses"), []);
}

/// A parallelogram is flat at crank angles 0 and π, where it can become an antiparallelogram.
#[test]
fn a_parallelogram_branches_where_it_is_flat() {
    let text = "[ground.points]\nD = [3, 0]\n[bodies]\ncrank = { points = { B = [1, 0] } }\n\
                coupler = { points = { C = [3, 0] } }\nrocker = { points = { C = [1, 0] } }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"crank\"] }\n\
                B = { type = \"revolute\", between = [\"crank.B\", \"coupler\"] }\n\
                C = { type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }\n\
                D = { type = \"revolute\", between = [\"ground.D\", \"rocker\"] }\n\
                [initial]\nA = { angle = 1 }\nrocker = { guess = { angle = 1 } }\n";
    let found = singular_poses(geometry(text), "A.angle").expect("poses");
    let mut branches: Vec<f64> = found
        .iter()
        .filter(|of| of.kind == Singularity::BranchPoint)
        .map(|of| of.drive.abs())
        .collect();
    branches.sort_by(f64::total_cmp);
    assert_eq!(branches.len(), 2, "{found:?}");
    assert!(branches[0] < 1e-6 && (branches[1] - PI).abs() < 1e-6, "{branches:?}");
}

#[test]
fn the_drive_that_is_too_many_is_named() {
    let text = "[ground.points]\nD = [3.2, 0]\n[bodies]\ncrank = { points = { B = [1, 0] } }\n\
                coupler = { points = { C = [3, 0] } }\nrocker = { points = { C = [2.5, 0] } }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"crank\"] }\n\
                B = { type = \"revolute\", between = [\"crank.B\", \"coupler\"] }\n\
                C = { type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }\n\
                D = { type = \"revolute\", between = [\"ground.D\", \"rocker\"] }\n\
                [drives]\nfirst = { joint = \"A\", motion = \"0.5 rad + 1 rad/s*t\" }\n\
                second = { joint = \"D\", motion = \"0.3 rad + 2 rad/s*t\" }\n";
    let found = examined(text);
    let told: Vec<_> =
        found.drives.iter().map(|d| (d.measure.as_str(), d.is_too_many, d.by.clone())).collect();
    let expected = [("A.angle", false, vec![]), ("D.angle", true, vec!["A.angle".to_owned()])];
    assert_eq!(told, expected);
    assert_eq!(found.count.mobility, 1);
}

/// A blade, and a ball on a table: what holds between rates alone repeats nothing and leaves positions free.
#[test]
fn conditions_between_rates_are_named_and_not_counted() {
    let blade = examined(
        "[bodies.skate]\nfree = true\n[joints.blade]\ntype = \"knife-edge\"\n\
         between = [\"ground\", \"skate\"]\naxis = [1, 0]\n",
    );
    assert_eq!([blade.count.counted, blade.count.mobility, blade.count.n_redundant], [3, 3, 0]);
    assert_eq!((blade.rates, blade.motions.len()), (vec!["blade".to_owned()], 3));

    let ball = examined(include_str!("../../../../tests/fixtures/touch/turntable.toml"));
    assert_eq!([ball.count.counted, ball.count.mobility, ball.count.n_redundant], [6, 6, 0]);
    assert_eq!(ball.rates, ["contact"]);
    for motion in &ball.motions {
        assert!(motion.is_finite && !motion.rates.is_empty(), "{motion:?}");
    }
}

/// A beam that bends on a hub: its own parts hold it together, and it moves by its turn and by its shapes.
#[test]
fn a_beam_moves_by_its_joint_and_its_shapes() {
    let found = examined(
        "[bodies.arm]\nflexible = { length = 1, section = [\"30 mm\", \"9 mm\"], material = \"aluminium\", modes = 2 }\n\
         points = { tip = [1, 0] }\n[bodies.load]\nmass = 1\ninertia = 1\n\
         [joints]\nhub = { type = \"revolute\", between = [\"ground\", \"arm\"] }\n\
         grip = { type = \"weld\", between = [\"arm.tip\", \"load\"] }\n",
    );
    assert_eq!([found.count.counted, found.count.mobility, found.count.n_redundant], [3, 3, 0]);
    let named = found.motions.iter().flat_map(|motion| &motion.rates).map(|(name, ..)| name);
    let named: std::collections::BTreeSet<&String> = named.collect();
    assert_eq!(
        named.into_iter().collect::<Vec<_>>(),
        ["arm_q1.angle", "arm_q2.angle", "hub.angle"]
    );
}
