//! Outlines that touch and rub, against reference motions: bounces, rolling, sliding, toppling, rocking, lift-off.

use std::fmt::Write as _;

use bksim::sim::hybrid::ChangeKind;
use bksim::sim::observable::Observables;
use serde_json::Value;

use crate::support::elements::{check_outputs, reference, touch_text};
use crate::support::{Within, at, close, derive, model, signal, solve, with_method};

/// Compares all rows of a reference.
#[track_caller]
fn check(fixture: &str, data: &str, columns: &[&str]) {
    check_outputs(&touch_text(fixture), data, &|_| true, columns);
}

/// The instants of some changes.
fn instants(text: &str, is_meant: impl Fn(ChangeKind) -> bool) -> Vec<f64> {
    let motion = solve(&derive(model(text)));
    motion
        .summary
        .changes
        .iter()
        .filter(|change| is_meant(change.kind))
        .map(|change| change.t)
        .collect()
}

#[test]
fn a_ball_bounces_down_a_staircase_with_friction_and_spin() {
    let mechanism = derive(model(&touch_text("stairs")));
    let motion = solve(&mechanism);
    let hits: Vec<f64> = (motion.summary.changes.iter())
        .filter(|change| matches!(change.kind, ChangeKind::Hit(..)))
        .map(|change| change.t)
        .collect();
    let rows = reference("touch/ball_stairs");
    let rows = rows["rows"].as_array().expect("rows");
    assert_eq!(hits.len(), rows.len(), "{hits:?}");
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    for (k, row) in rows.iter().enumerate() {
        let number = |place: usize| row[place].as_f64().expect("a number");
        close("bounce", hits[k], number(1), within);
        // In the flight that follows.
        let sample = &motion.samples[k + 1];
        close("vx", signal(&mechanism, sample, "vx"), number(7), within);
        close("w", signal(&mechanism, sample, "w"), number(9), within);
        let rise = number(8) - 9.81 * (sample.t - hits[k]);
        close("vy", signal(&mechanism, sample, "vy"), rise, within);
    }
}

#[test]
fn a_spinning_disc_climbs_in_a_ring_until_it_rolls() {
    check("ring", "disc_in_ring", &["theta", "w_centre", "spin", "N", "F", "slip"]);
    let sticks = instants(&touch_text("ring"), |kind| matches!(kind, ChangeKind::Stick(_)));
    close("rolls", sticks[0], 0.307_468_383_513_035, Within { relative: 1e-9, absolute: 0.0 });
}

#[test]
fn a_rod_slides_sticks_and_slides_on_a_rough_floor() {
    let columns = ["theta", "w", "x_contact", "v_contact", "N", "F"];
    check("rod", "painleve_rod", &columns);
}

#[test]
fn a_rod_with_more_than_the_critical_friction_has_no_unique_motion() {
    for angle in ["50 deg", "70 deg"] {
        let text = touch_text("rod").replace("mu = 0.9", "mu = 1.6").replace("50 deg", angle);
        let error = derive(model(&text)).solve().expect_err("no unique motion").to_string();
        assert!(error.contains("no unique motion"), "{error}");
    }
    // Outside of the range that the determinant tells, there is one.
    let text = touch_text("rod").replace("mu = 0.9", "mu = 1.6").replace("50 deg", "80 deg");
    let text = text.replace("t_end = \"0.7 s\"", "t_end = \"1 ms\"");
    derive(model(&text)).solve().expect("a motion");
}

#[test]
fn blocks_on_an_incline_slide_topple_and_stay() {
    for case in 1..=4_u8 {
        let is_meant = |row: &Value| row[0].as_u64() == Some(u64::from(case));
        let text = touch_text(&format!("block-{case}"));
        check_outputs(&text, "incline_block", &is_meant, &["N", "F"]);
        // What stays where it is has no size to compare with.
        let moving: &[&str] = match case {
            1 => &["s", "v"],
            4 => continue,
            _ => &["s", "v", "theta", "w"],
        };
        check_outputs(&text, "incline_block", &is_meant, moving);
    }
}

#[test]
fn a_block_rocks_from_corner_to_corner() {
    check("rocking-block", "rocking_block", &["theta", "w", "x", "y"]);
}

#[test]
fn a_walking_beam_carries_a_box() {
    check("walking-beam", "walking_beam", &["x", "v", "y"]);
    // Forces jump where it is picked up and set down.
    let is_meant = |row: &Value| row[0].as_f64() != Some(0.0);
    check_outputs(&touch_text("walking-beam"), "walking_beam", &is_meant, &["N_beam", "N_rail"]);
}

#[test]
fn a_cam_throws_its_follower_and_catches_it() {
    check("thrown-follower", "cam_friction", &["x", "v"]);
    // The force jumps where the follower turns back.
    let is_meant = |row: &Value| {
        let turns = row[0].as_f64().expect("a time") * 230.0 / std::f64::consts::PI + 0.5;
        (turns - turns.round()).abs() > 1e-6
    };
    let columns = ["N", "gap", "guide_force", "motor"];
    check_outputs(&touch_text("thrown-follower"), "cam_friction", &is_meant, &columns);
}

/// Boxes of 2 kg on a floor, the upper ones a little to the side.
fn stack(mu: f64) -> String {
    let corners = |k: usize| {
        let names = ["a", "b", "c", "d"].map(|corner| format!("\"box{k}.{corner}\""));
        format!("{{ outline = [{}] }}", names.join(", "))
    };
    let mut text = String::from(
        "[ground]\npoints = { A = [\"-1 m\", 0], B = [\"1 m\", 0] }\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n",
    );
    for (k, x) in [0.0, 0.0, 0.02, -0.01].into_iter().enumerate() {
        let below = match k {
            0 => "{ line = [\"ground.A\", \"ground.B\"] }".to_owned(),
            _ => corners(k - 1),
        };
        let y = 0.1 + 0.2 * f64::from(u8::try_from(k).expect("few"));
        let _ = write!(
            text,
            "[bodies.box{k}]\nmass = \"2 kg\"\ninertia = \"0.0133 kg m^2\"\nfree = true\n\
             points = {{ a = [\"-0.1 m\", \"-0.1 m\"], b = [\"0.1 m\", \"-0.1 m\"], \
             c = [\"0.1 m\", \"0.1 m\"], d = [\"-0.1 m\", \"0.1 m\"] }}\n\
             [contacts.under{k}]\nbetween = [{below}, {}]\nmu = {mu}\n\
             [initial.box{k}]\nx = \"{x} m\"\ny = \"{y} m\"\nangle = 0\nvx = 0\nvy = 0\nrate = 0\n",
            corners(k)
        );
    }
    text + "[outputs]\nforce = \"contacts.under0.force\"\n\
            [solve]\nt_end = \"2 s\"\nevery = \"1 s\"\n"
}

#[test]
fn a_stack_of_boxes_rests_without_creeping() {
    let mechanism = derive(model(&stack(0.5)));
    let motion = solve(&mechanism);
    let [first, last] = [&motion.samples[0], at(&motion, 2.0)];
    let weight = 4.0 * 2.0 * 9.81;
    close(
        "force",
        signal(&mechanism, last, "force"),
        weight,
        Within { relative: 1e-9, absolute: 0.0 },
    );
    for (before, after) in first.q.iter().zip(&last.q) {
        assert!((before - after).abs() < 1e-12, "{before} became {after}");
    }
}

/// The upper box slides on a corner of its own and on one of the box below: its slip is its speed, not twice that.
#[test]
fn the_slip_of_two_places_is_the_speed_of_sliding() {
    let text = stack(0.1)
        .replace("[outputs]\n", "[outputs]\nslip = \"contacts.under3.slip\"\n")
        .replace("\"2 s\"", "\"0.05 s\"")
        .replace("\"1 s\"", "\"0.05 s\"");
    let (before, after) = text.split_once("[initial.box3]").expect("the upper box");
    let after = after.replacen("vx = 0", "vx = \"0.1 m/s\"", 1);
    let mechanism = derive(model(&format!("{before}[initial.box3]{after}")));
    let motion = solve(&mechanism);
    let slip = signal(&mechanism, at(&motion, 0.05), "slip");
    close("slip", slip, 0.1 - 0.1 * 9.81 * 0.05, Within { relative: 1e-8, absolute: 0.0 });
}

#[test]
fn outlines_that_overlap_at_the_start_are_refused_with_their_depth() {
    let text = stack(0.5).replace("y = \"0.1 m\"", "y = \"0.09 m\"");
    let error = derive(model(&text)).solve().expect_err("they overlap").to_string();
    assert!(error.contains("overlap by 0.01 m"), "{error}");

    // Of circles, the distance between them and not the difference of squares that the motion is found with.
    for (shape, radius, x, depth) in [("disc", 0.1, 0.15, 0.05), ("ring", 0.1001, 0.25, 0.2499)] {
        let text = format!(
            "[ground]\npoints = {{ O = [0, 0] }}\n[bodies.d]\nmass = 1\ninertia = 0.01\nfree = true\n\
             points = {{ C = [0, 0] }}\n[initial.d]\nx = {x}\ny = 0\nangle = 0\n[contacts.touch]\n\
             between = [{{ {shape} = \"ground.O\", radius = {radius} }}, {{ disc = \"d.C\", radius = 0.1 }}]\n"
        );
        let error = derive(model(&text)).solve().expect_err("they overlap").to_string();
        assert!(error.contains(&format!("overlap by {depth} m")), "{error}");
    }
}

#[test]
fn energy_lost_at_contacts_is_in_the_balance_and_never_gained() {
    // A square is thrown on a floor at many angles and speeds of turning.
    for k in 0..8_u8 {
        let turn = f64::from(k);
        let text = format!(
            "[ground]\npoints = {{ A = [0, 0], B = [\"1 m\", 0] }}\n\
             [bodies.box]\nmass = \"2 kg\"\ninertia = \"0.0133 kg m^2\"\nfree = true\n\
             points = {{ a = [\"-0.1 m\", \"-0.1 m\"], b = [\"0.1 m\", \"-0.1 m\"], \
             c = [\"0.1 m\", \"0.1 m\"], d = [\"-0.1 m\", \"0.1 m\"] }}\n\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
             [contacts.floor]\nbetween = [{{ line = [\"ground.A\", \"ground.B\"] }}, \
             {{ outline = [\"box.a\", \"box.b\", \"box.c\", \"box.d\"] }}]\nmu = 0.4\nrestitution = 0.6\n\
             [initial]\nbox = {{ x = 0, y = \"0.5 m\", angle = \"{} deg\", vx = \"2 m/s\", vy = 0, rate = \"{} rad/s\" }}\n\
             [solve]\nt_end = \"1 s\"\nevery = \"0.01 s\"\nrtol = 1e-9\natol = 1e-11\n",
            11.0 * turn,
            3.0 * turn - 12.0
        );
        let motion = solve(&derive(model(&text)));
        let mut before = f64::INFINITY;
        for sample in &motion.samples {
            let total = sample.energy.kinetic + sample.energy.potential;
            assert!(
                total <= before + 1e-7,
                "case {k} at {} s: {total} J after {before} J",
                sample.t
            );
            before = total;
        }
        let energy = &motion.summary.energy;
        assert!(
            energy.worst_error <= 1e-7 * energy.scale,
            "case {k}: off by {}",
            energy.worst_error
        );
    }
}

#[test]
fn both_integrators_find_the_same_motion() {
    let text = touch_text("ring");
    let ends = ["explicit", "radau"].map(|method| {
        let mechanism = derive(model(&with_method(&text, method)));
        let motion = solve(&mechanism);
        signal(&mechanism, at(&motion, 2.0), "theta")
    });
    close("theta", ends[0], ends[1], Within { relative: 1e-8, absolute: 1e-10 });
}

/// A box whose angle a guide keeps: on two corners the guide's moment is any, on one it is not.
#[test]
fn what_two_corners_share_with_a_guide_is_not_unique() {
    for (degrees, is_unique) in [(0.0_f64, false), (10.0, true)] {
        let angle = degrees.to_radians();
        let low = 0.1 * (angle.cos() + angle.sin());
        let text = format!(
            "[ground]\npoints = {{ A = [-1, 0], B = [1, 0] }}\n[bodies]\nguide = {{ mass = 0 }}\n\
             box = {{ mass = 5, inertia = 0.1, points = {{ a = [-0.1, -0.1], b = [0.1, -0.1], c = [0.1, 0.1], d = [-0.1, 0.1] }} }}\n\
             [joints]\nbx = {{ type = \"prismatic\", between = [\"ground\", \"guide\"], axis = [1, 0] }}\n\
             by = {{ type = \"prismatic\", between = [\"guide\", \"box\"], axis = [0, 1], angle = \"{degrees} deg\" }}\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             [contacts.floor]\nmu = 0.3\n\
             between = [{{ line = [\"ground.A\", \"ground.B\"] }}, {{ outline = [\"box.a\", \"box.b\", \"box.c\", \"box.d\"] }}]\n\
             [initial]\nby = {{ position = {low} }}\nbx = {{ position = 0 }}\n[solve]\nt_end = 0.1\n"
        );
        let start = derive(model(&text)).start().expect("a start");
        let joints = &start.uniqueness.reactions;
        assert_eq!(joints[1][5], is_unique, "moment of the guide at {degrees}°");
    }
}

/// A disc that slides to the right on a floor, pulled by a spring: names of contacts and of loads between points.
#[test]
fn what_outputs_may_use_has_its_name_in_results_too() {
    let text = r#"
[ground]
points = { A = [-1, 0], B = [1, 0] }
[bodies.ball]
mass = 2
inertia = 0.01
free = true
points = { C = [0, 0] }
[contacts.floor]
between = [{ line = ["ground.A", "ground.B"] }, { disc = "ball.C", radius = 0.1 }]
mu = 0.3
[loads.spring]
type = "spring"
between = ["ground.B", "ball.C"]
stiffness = 5
length = 0.2
damping = 0.1
[loads.gravity]
type = "gravity"
acceleration = [0, -9.81]
[initial]
ball = { x = 0, y = 0.1, vx = 1, vy = 0, angle = 0, rate = 0 }
[solve]
t_end = 0.05
every = 0.01
"#;
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let names = [
        "contacts.floor.force",
        "contacts.floor.friction",
        "contacts.floor.slip",
        "contacts.floor.gap",
    ];
    let names =
        names.into_iter().chain(["loads.spring.force", "loads.spring.length", "loads.spring.rate"]);
    let measures: Vec<_> =
        names.map(|name| Observables::named(&mechanism.model, name).expect("a name")).collect();
    let mut observables =
        Observables::compile(&mechanism.model, &mechanism.system, &measures, &mechanism.parameters)
            .expect("functions");
    for sample in &motion.samples {
        let mut values = [0.0; 7];
        let state = [&sample.q[..], &sample.v, &sample.a, &sample.lambda];
        observables.at(state, &|joint| sample.reactions[joint.0], &mut values);
        let [x, vx, vy] = [sample.q[0], sample.v[0], sample.v[1]];
        let length = (1.0 - x).hypot(0.1);
        let rate = (-(1.0 - x) * vx + 0.1 * vy) / length;
        let spring = 5.0 * (length - 0.2) + 0.1 * rate;
        // The spring pulls it down to the floor, too.
        let force = 2.0 * 9.81 + spring * 0.1 / length;
        let expected = [force, -0.3 * force, vx + 0.1 * sample.v[2], 0.0, spring, length, rate];
        for (k, (found, expected)) in values.iter().zip(expected).enumerate() {
            assert!((found - expected).abs() < 1e-9, "{k}: {found} for {expected}");
        }
    }
}
