//! Four-bars for a path: all through nine points, and the nearest to more.

use std::fmt::Write;

use bksim_design::{Candidate, synthesize};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn places(candidate: &Candidate) -> [f64; 8] {
    ["pivot_1_x", "pivot_1_y", "pivot_2_x", "pivot_2_y", "pin_1_x", "pin_1_y", "pin_2_x", "pin_2_y"]
        .map(|name| candidate.numbers[name])
}

#[test]
fn nine_points_have_all_their_four_bars() {
    let text = include_str!("../fixtures/syn_nine_point_a.json");
    let fixture: Value = serde_json::from_str(text).expect("a fixture");
    let points = &fixture["model"]["points"];
    let task = format!("[synthesize]\ntask = \"path\"\npoints = {points}\n");
    let found = synthesize(&task).unwrap_or_else(|error| panic!("{error}"));
    let fact = |name: &str| found.facts[name][0];
    for (own, given) in [
        ("triples_in_general", "triples_in_general"),
        ("triples_found", "triples_found"),
        ("real_triples", "real_triples"),
        ("real_four_bars", "real_four_bars"),
    ] {
        assert_eq!(fact(own), number(&fixture["values"][given]), "{own} in {:?}", found.facts);
    }
    assert_eq!(fact("triples_enclosed"), 1442.0);
    assert!(fact("largest_miss_in_thirty_digits") < 1e-24, "{:?}", found.facts);
    let mut n_usable = 0;
    for row in fixture["rows"].as_array().expect("rows") {
        let given: Vec<f64> = (2..10).map(|k| number(&row[k])).collect();
        let size = given.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
        let off = |own: &[f64; 8], order: [usize; 4]| {
            let part = |k: usize| (0..2).map(move |i| (2 * k + i, i));
            let both = order
                .into_iter()
                .enumerate()
                .flat_map(|(at, from)| part(from).map(move |(own, i)| (own, 2 * at + i)));
            both.map(|(i, j)| (own[i] - given[j]).abs()).fold(0.0, f64::max)
        };
        let same = |c: &&Candidate| {
            let own = places(c);
            off(&own, [0, 1, 2, 3]) < 1e-9 * size || off(&own, [1, 0, 3, 2]) < 1e-9 * size
        };
        let all: Vec<&Candidate> = found.candidates.iter().filter(same).collect();
        assert_eq!(all.len(), 1, "{row}");
        let is_turned = off(&places(all[0]), [0, 1, 2, 3]) > 1e-9 * size;
        let drives = if is_turned { [2, 1] } else { [1, 2] };
        assert_eq!(all[0].checks["one_circuit"], row[11].as_bool().expect("a fact"), "{row}");
        for (k, drive) in drives.into_iter().enumerate() {
            let own = all[0].checks[&format!("one_branch_if_driven_at_{drive}")];
            assert_eq!(own, row[12 + k].as_bool().expect("a fact"), "{row}");
        }
        let holds = |k: usize| row[k].as_bool() == Some(true);
        n_usable += usize::from(holds(11) && (holds(12) || holds(13)));
    }
    assert_eq!(n_usable as f64, number(&fixture["values"]["usable_four_bars"]));
}

/// Points of a coupler curve: pivots in the origin and (1, 0.2), links 0.4, 1.1, 0.8, the point (0.6, 0.5).
fn curve(phi: f64) -> [f64; 2] {
    let (bx, by) = (0.4 * phi.cos(), 0.4 * phi.sin());
    let (dx, dy) = (1.0 - bx, 0.2 - by);
    let l = dx.hypot(dy);
    let turn = dy.atan2(dx) + ((1.21 + l * l - 0.64) / (2.2 * l)).acos();
    let (cos, sin) = (turn.cos(), turn.sin());
    [bx + 0.6 * cos - 0.5 * sin, by + 0.6 * sin + 0.5 * cos]
}

#[test]
fn points_of_a_coupler_curve_have_its_four_bar_again() {
    let angles: Vec<f64> = (0..14).map(|k| 0.3 + 0.4 * f64::from(k)).collect();
    let points: Vec<[f64; 2]> = angles.iter().map(|&phi| curve(phi)).collect();
    for timing in ["", "angles"] {
        let mut task =
            format!("[synthesize]\ntask = \"path\"\npoints = {points:?}\nstarts = 1500\n");
        if !timing.is_empty() {
            let counted: Vec<f64> = angles.iter().map(|phi| phi - 2.0).collect();
            let _ = writeln!(task, "angles = {counted:?}");
        }
        let found = synthesize(&task).unwrap_or_else(|error| panic!("{error}"));
        let best = found
            .candidates
            .iter()
            .min_by(|a, b| a.numbers["rms_error"].total_cmp(&b.numbers["rms_error"]))
            .expect("a four-bar");
        assert!(best.numbers["rms_error"] < 1e-8, "{timing} {best:?}");
        assert!(
            found.candidates[0].checks["one_branch_if_driven_at_1"],
            "{timing} {:?}",
            found.candidates[0]
        );
        if !timing.is_empty() {
            // With the crank's angles it is that four-bar, or the one of its cognates whose crank turns alike.
            let other = 0.4 * f64::hypot(0.5, 0.5) / 1.1;
            let crank = best.numbers["crank"];
            assert!((crank - 0.4).abs().min((crank - other).abs()) < 1e-6, "{best:?}");
        }
    }
}

#[test]
fn tasks_of_a_path_that_cannot_be_read_are_refused() {
    for (rest, code) in [
        ("points = [[0, 0], [1, 0]]", "O001"),
        ("points = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0.5]]\nangles = [0, 1]", "O001"),
        ("points = [[0, 0], [0, 0], [1, 1], [0, 1], [0, 0.5]]", "O001"),
        (
            "points = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0.5]]\nregion = [[50, 50], [51, 51]]\nstarts = 20",
            "O007",
        ),
    ] {
        let task = format!("[synthesize]\ntask = \"path\"\n{rest}\n");
        let error = synthesize(&task).expect_err("a fault");
        assert_eq!(error.diagnostics()[0].code.0, code, "{rest}: {error}");
    }
}
