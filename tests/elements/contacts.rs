//! Outlines that touch and rub, against reference motions: bounces, rolling, sliding, toppling, rocking, lift-off.

use bksim::sim::hybrid::ChangeKind;
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
