//! Linkages for a task against solutions in many digits.

use std::fmt::Write;

use bksim_design::{Candidate, Synthesis, synthesize};
use serde_json::Value;

fn fixture(text: &str) -> Value {
    serde_json::from_str(text).expect("a fixture")
}

fn solved(text: &str) -> Synthesis {
    synthesize(text).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn is_close(value: f64, expected: &Value, tolerance: f64) {
    let expected = expected.as_f64().expect("a number");
    assert!((value - expected).abs() <= tolerance, "{value} for {expected}");
}

fn named<'s>(found: &'s Synthesis, name: &str) -> &'s Candidate {
    found.candidates.iter().find(|c| c.name == name).expect("a candidate")
}

/// Every model is read, closes and runs to its end.
#[track_caller]
fn models_solve(found: &Synthesis) {
    for candidate in &found.candidates {
        let solved = bksim::Mechanism::from_toml(&candidate.model, "model").and_then(|m| m.solve());
        assert!(solved.is_ok(), "{}: {:?}\n{}", candidate.name, solved.err(), candidate.model);
    }
}

#[test]
fn three_points_give_one_function_generator() {
    let fixture = fixture(include_str!("../fixtures/syn_function_3.json"));
    let values = &fixture["values"];
    let found = solved(
        r#"[synthesize]
task = "function"
function = "ln(x)/ln(10)"
x = [1, 2]
phi = ["45 deg", "105 deg"]
psi = ["135 deg", "225 deg"]
"#,
    );
    assert_eq!(found.candidates.len(), 1);
    let numbers = &found.candidates[0].numbers;
    for (k, name) in ["K1", "K2", "K3"].into_iter().enumerate() {
        is_close(numbers[name], &values["K"][k], 1e-9);
    }
    for name in ["a", "b", "c", "structural_error_at_x"] {
        is_close(numbers[name], &values[name], 1e-9);
    }
    is_close(numbers["structural_error_max"], &values["structural_error_max"], 1e-8);
    models_solve(&found);
}

#[test]
fn five_points_with_free_offsets_have_all_their_solutions() {
    let fixture = fixture(include_str!("../fixtures/syn_function_5.json"));
    let found = solved(
        r#"[synthesize]
task = "function"
function = "sin(x)"
x = [0, 1.5707963267948966]
phi = [0, 1.8849555921538759]
psi = [0, 1.3]
points = 5
offsets = "both"
"#,
    );
    assert_eq!(found.facts["complex_solutions"], [3.0]);
    assert_eq!(found.facts["real_solutions"], [1.0]);
    let row = fixture["rows"][0].as_array().expect("a row");
    let numbers = &found.candidates[0].numbers;
    for (name, expected) in ["phi0", "psi0", "K1", "K2", "K3", "a", "b", "c"].into_iter().zip(row) {
        is_close(numbers[name], expected, 1e-9);
    }
    models_solve(&found);
}

#[test]
fn more_points_are_fitted_and_four_leave_one_offset() {
    let task = |points: usize, offsets: &str| {
        format!(
            "[synthesize]\ntask = \"function\"\nfunction = \"exp(x)\"\nx = [0, 1]\nphi = [0.5, 1.5]\npsi = [1.0, 2.2]\npoints = {points}\noffsets = \"{offsets}\"\n"
        )
    };
    let many = solved(&task(50, "none"));
    let three = solved(&task(3, "none"));
    let error = |found: &Synthesis| found.candidates[0].numbers["structural_error_max"];
    assert!(error(&many) < 2.0 * error(&three), "{} and {}", error(&many), error(&three));
    // Freudenstein's equation at each of the four points.
    let four = solved(&task(4, "phi"));
    assert_eq!(four.candidates.len(), 2);
    for candidate in &four.candidates {
        let n = |name: &str| candidate.numbers[name];
        for x in &four.facts["accuracy_points"] {
            let psi = 1.0 + 1.2 * x.exp_m1() / 1f64.exp_m1();
            let phi = 0.5 + x + n("phi0");
            let off = n("K1") * psi.cos() - n("K2") * phi.cos() + n("K3") - (phi - psi).cos();
            assert!(off.abs() < 1e-9, "{off} of {candidate:?}");
        }
    }
}

fn poses_task(fixture: &Value, more: &str) -> String {
    let mut text = String::from("[synthesize]\ntask = \"poses\"\nposes = [");
    for pose in fixture["model"]["poses_x_y_deg"].as_array().expect("poses") {
        let _ = write!(text, "[{}, {}, \"{} deg\"], ", pose[0], pose[1], pose[2]);
    }
    text + "]\n" + more
}

#[test]
fn five_poses_have_four_dyads_and_six_four_bars() {
    let fixture = fixture(include_str!("../fixtures/syn_burmester_5a.json"));
    let values = &fixture["values"];
    let found = solved(&poses_task(&fixture, ""));
    assert_eq!(found.facts["complex_dyads"], [4.0]);
    assert_eq!(found.facts["real_dyads"], [4.0]);
    assert_eq!(found.candidates.len(), 6);
    let mut number_of = Vec::new();
    for row in fixture["rows"].as_array().expect("rows") {
        let fits = |k: &usize| {
            let own = &found.facts[&format!("dyad_{k}")];
            own.iter()
                .zip(&row.as_array().expect("a row")[1..])
                .all(|(a, b)| (a - b.as_f64().unwrap_or(f64::NAN)).abs() < 1e-9)
        };
        number_of.push(
            (1..=4).find(fits).unwrap_or_else(|| panic!("no dyad {row} in {:?}", found.facts)),
        );
    }
    for pair in values["pairs"].as_array().expect("pairs") {
        let of = |k: usize| {
            number_of
                [usize::try_from(pair["dyads"][k].as_u64().expect("a number") - 1).expect("small")]
        };
        let (a, b) = (of(0), of(1));
        let is_turned = a > b;
        let candidate = named(&found, &format!("poses-{}-{}", a.min(b), a.max(b)));
        let (first, second) = if is_turned { ("rocker", "crank") } else { ("crank", "rocker") };
        let lengths = &pair["lengths_crank1_coupler_crank2_ground"];
        for (k, name) in [first, "coupler", second, "ground"].into_iter().enumerate() {
            is_close(candidate.numbers[name], &lengths[k], 1e-9);
        }
        assert_eq!(candidate.checks["grashof"], pair["grashof"], "{candidate:?}");
        let at = if is_turned { [2, 1] } else { [1, 2] };
        for (k, key) in ["one_branch_if_driven_at_first", "one_branch_if_driven_at_second"]
            .into_iter()
            .enumerate()
        {
            assert_eq!(
                candidate.checks[&format!("one_branch_if_driven_at_{}", at[k])],
                pair[key],
                "{candidate:?}"
            );
        }
    }
    models_solve(&found);
}

#[test]
fn four_poses_have_a_cubic_of_centres() {
    let fixture = fixture(include_str!("../fixtures/syn_burmester_4.json"));
    let values = &fixture["values"];
    let found = solved(&poses_task(&fixture, "lines_y = [-2, -1, 0.5, 2, 4]\n"));
    let cubic = &found.facts["cubic_x3_x2y_xy2_y3_x2_xy_y2_x_y_1"];
    for (own, expected) in
        cubic.iter().zip(values["coefficients"].as_array().expect("coefficients"))
    {
        is_close(*own, expected, 1e-8);
    }
    for pole in values["poles_i_j_x_y"].as_array().expect("poles") {
        let own = &found.facts[&format!("pole_{}_{}", pole[0], pole[1])];
        is_close(own[0], &pole[2], 1e-9);
        is_close(own[1], &pole[3], 1e-9);
    }
    let rows = fixture["rows"].as_array().expect("rows");
    assert_eq!(found.facts["real_dyads"], [rows.len() as f64]);
    for row in rows {
        let is_it = |k: &usize| {
            let own = &found.facts[&format!("dyad_{k}")];
            let expected = [&row[1], &row[0], &row[2], &row[3]];
            own.iter().zip(expected).all(|(a, b)| (a - b.as_f64().unwrap_or(f64::NAN)).abs() < 1e-8)
        };
        assert!((1..=rows.len()).any(|k| is_it(&k)), "{row} in {:?}", found.facts);
    }
}

#[test]
fn three_poses_have_a_pin_for_every_centre() {
    let found = solved(
        "[synthesize]\ntask = \"poses\"\nposes = [\n  [0, 0, 0], # \"]\"\n  [1, 1, \"30 deg\"],\n  [2, 1, \"75 deg\"],\n]\ncentres = [[0, -1], [2, -1]]\n",
    );
    let numbers = &found.candidates[0].numbers;
    // The same length in all three poses.
    for k in [1, 2] {
        let dyad = &found.facts[&format!("dyad_{k}")];
        for [x, y, deg] in [[1.0, 1.0, 30.0], [2.0, 1.0, 75.0]] {
            let (sin, cos) = f64::to_radians(deg).sin_cos();
            let at = [x + cos * dyad[4] - sin * dyad[5], y + sin * dyad[4] + cos * dyad[5]];
            let length = (at[0] - dyad[0]).hypot(at[1] - dyad[1]);
            assert!((length - dyad[6]).abs() < 1e-12, "{length} for {}", dyad[6]);
        }
    }
    assert!((numbers["ground"] - 2.0).abs() < 1e-12);
    models_solve(&found);
}

#[test]
fn cognates_draw_the_curve_of_the_four_bar() {
    let fixture = fixture(include_str!("../fixtures/syn_cognates.json"));
    let values = &fixture["values"];
    for row in fixture["rows"].as_array().expect("rows").iter().take(6) {
        let angle = row[0].as_f64().expect("an angle");
        let found = solved(&format!(
            "[synthesize]\ntask = \"cognates\"\ncrank = 2\ncoupler = 5\nrocker = 4.2\nground = 5.5\npoint = [2.1, 1.7]\nangle = {angle}\n"
        ));
        for k in 0..2 {
            is_close(found.facts["third_pivot"][k], &values["third_pivot"][k], 1e-12);
            is_close(found.facts["point"][k], &row[1 + k], 1e-10);
        }
        let lengths = ["bar_at_first_pivot", "coupler", "bar_at_third_pivot"];
        for name in ["cognate-1", "cognate-2"] {
            let candidate = named(&found, name);
            let expected = &values[&name.replace('-', "_")];
            for (own, key) in ["crank", "coupler", "rocker"].into_iter().zip(lengths) {
                is_close(candidate.numbers[own], &expected[key], 1e-10);
            }
            for (k, axis) in ["x", "y"].into_iter().enumerate() {
                let over = &expected["coupler_point_from_first_pin_over_coupler"][k];
                is_close(candidate.numbers[&format!("point_over_coupler_{axis}")], over, 1e-10);
            }
        }
        let angles = [
            ("cognate-1", "bar_1_angle", 3),
            ("cognate-2", "bar_1_angle", 4),
            ("cognate-1", "bar_2_angle", 5),
            ("cognate-2", "bar_2_angle", 6),
        ];
        for (name, key, column) in angles {
            is_close(named(&found, name).numbers[key], &row[column], 1e-10);
        }
        models_solve(&found);
    }
}

#[test]
fn quick_returns_have_their_ratio() {
    let found = solved(
        "[synthesize]\ntask = \"quick_return\"\ntime_ratio = 1.6\nground = \"300 mm\"\nstroke = \"0.25 m\"\ncrank = \"0.1 m\"\n",
    );
    let lever = &named(&found, "slotted-lever").numbers;
    assert!((lever["crank"] - 0.106381466112761).abs() < 1e-14);
    assert!((lever["lever"] - 0.352505012106632).abs() < 1e-14);
    assert!((lever["swing"].to_degrees() - 41.5384615384615).abs() < 1e-12);
    assert!((named(&found, "whitworth").numbers["ground"] - 0.0354604887042536).abs() < 1e-14);
    models_solve(&found);
}

#[test]
fn straight_lines_have_their_lengths_and_deviations() {
    let fixture = fixture(include_str!("../fixtures/syn_straight_lines.json"));
    for row in fixture["rows"].as_array().expect("rows") {
        let name = row[0].as_str().expect("a name").to_lowercase();
        let unit = if ["hoeken", "watt"].contains(&name.as_str()) { " deg" } else { "" };
        let found = solved(&format!(
            "[synthesize]\ntask = \"straight_line\"\nlinkage = \"{name}\"\nrange = \"{}{unit}\"\n",
            row[1]
        ));
        let numbers = &found.candidates[0].numbers;
        let length = row[2].as_f64().expect("a length");
        is_close(numbers["length"], &row[2], 1e-9 * length);
        // Extremes of the reference for Roberts' linkage are of a sample; those of Watt's are to the other side.
        let allowance = if name == "roberts" { 1e-7 } else { 1e-9 } * length;
        is_close(numbers["span"], &row[3], allowance);
        if name != "watt" {
            is_close(numbers["largest"], &row[4], allowance);
            is_close(numbers["least"], &row[5], allowance);
        }
        models_solve(&found);
    }
    let scaled = solved("[synthesize]\ntask = \"straight_line\"\nlength = \"200 mm\"\n");
    assert_eq!(scaled.candidates.len(), 5);
    assert!(scaled.candidates.iter().all(|c| (c.numbers["length"] - 0.2).abs() < 1e-12));
}

/// A task of a function over a range.
fn generator(function: &str, range: &str) -> String {
    format!(
        "[synthesize]\ntask = \"function\"\nfunction = \"{function}\"\nx = {range}\nphi = [\"30 deg\", \"90 deg\"]\npsi = [\"60 deg\", \"120 deg\"]\n"
    )
}

#[test]
fn angles_in_degrees_without_a_unit_are_noticed() {
    let found = solved(
        "[synthesize]\ntask = \"poses\"\nposes = [[0, 0, 0], [1, 0, 30], [1, 1, 60]]\ncentres = [[0, -1], [1, -1]]\n",
    );
    let [warning] = found.warnings.as_slice() else { panic!("{:?}", found.warnings) };
    assert_eq!(warning.code.0, "M034");
    assert_eq!(warning.help.as_deref(), Some("write \"30 deg\", or \"30 rad\" if it is right"));
    // Where nothing is found, they may be the cause.
    let text = "[synthesize]\ntask = \"function\"\nphi = [30, 60, 90]\npsi = [60, 90, 120]\n";
    let faults = synthesize(text).expect_err("no linkage").diagnostics();
    let codes: Vec<&str> = faults.iter().map(|fault| fault.code.0).collect();
    assert_eq!(codes, ["O007", "M034", "M034"]);
    let with_units = text.replace("[30, 60, 90]", "[\"30 deg\", \"60 deg\", \"90 deg\"]");
    let with_units = with_units.replace("[60, 90, 120]", "[1.1, 1.6, 2.0]");
    assert!(solved(&with_units).warnings.is_empty());
}

#[test]
fn tasks_without_a_solution_are_refused() {
    for (text, code) in [
        ("[synthesize]\ntask = \"quick_return\"\ntime_ratio = 0.9\nground = 1\n", "O007"),
        ("[synthesize]\ntask = \"dance\"\n", "O001"),
        ("[parameters]\n", "O002"),
        ("[synthesize]\ntask = \"poses\"\nposes = [[0, 0, 0], [1, 0, 1]]\n", "O001"),
        // Poles on a place that is looked at, and between two.
        (&generator("1/x", "[-1, 1]"), "O001"),
        (&generator("1/(x - 0.3217)", "[-1, 1]"), "O001"),
        (&generator("tan(x)", "[1, 2]"), "O001"),
    ] {
        let error = synthesize(text).expect_err("a fault");
        assert_eq!(error.diagnostics()[0].code.0, code, "{text}: {error}");
    }
}

/// Angle at the first of the sides x and y, across from z.
fn angle(x: f64, y: f64, z: f64) -> f64 {
    ((x * x + y * y - z * z) / (2.0 * x * y)).acos()
}

#[test]
fn crank_rockers_and_slider_cranks_return_quickly() {
    for (ratio, swing) in [(1.05, 30.0_f64), (1.2, 60.0), (1.35, 40.0)] {
        let found = solved(&format!(
            "[synthesize]\ntask = \"quick_return\"\ntime_ratio = {ratio}\nrocker = \"100 mm\"\nswing = \"{swing} deg\"\nstroke = \"80 mm\"\n"
        ));
        let turn = std::f64::consts::PI * (ratio - 1.0) / (ratio + 1.0);
        let bar = named(&found, "crank-rocker");
        assert_eq!(bar.kind.as_deref(), Some("crank-rocker"));
        let [a, b, c, d] = ["crank", "coupler", "rocker", "ground"].map(|name| bar.numbers[name]);
        let of_rocker = angle(d, c, b + a) - angle(d, c, b - a);
        assert!((of_rocker.abs().to_degrees() - swing).abs() < 1e-8, "{bar:?}");
        let of_crank = angle(d, b + a, c) - angle(d, b - a, c);
        assert!((of_crank.abs() - turn).abs() < 1e-8, "{bar:?}");
        let slider = &named(&found, "slider-crank").numbers;
        let [a, b, e] = ["crank", "coupler", "offset"].map(|name| slider[name]);
        let ends = [b + a, b - a].map(|l| (l * l - e * e).sqrt());
        assert!((ends[0] - ends[1] - 0.08).abs() < 1e-10, "{slider:?}");
        let of_crank = (e / (b - a)).asin() - (e / (b + a)).asin();
        assert!((of_crank - turn).abs() < 1e-8, "{slider:?}");
        models_solve(&found);
    }
}

#[test]
fn two_poses_have_a_centre_on_each_line_and_pins_have_centres() {
    let of = |poses: &str, more: &str| {
        solved(&format!("[synthesize]\ntask = \"poses\"\nposes = [{poses}]\n{more}\n"))
    };
    let pins = "pins = [[0.2, 0], [1, 0.5]]";
    let two = of("[0, 0, 0], [1, 0.5, \"40 deg\"]", &format!("{pins}\nlines_y = [-1, 2]"));
    let three = of("[0, 0, 0], [1, 0.5, \"40 deg\"], [1.5, 1.2, \"75 deg\"]", pins);
    let all = [[0.0, 0.0, 0.0_f64], [1.0, 0.5, 40.0], [1.5, 1.2, 75.0]];
    for (found, n_poses, n_dyads) in [(&two, 2, 4), (&three, 3, 2)] {
        assert_eq!(found.facts["real_dyads"], [f64::from(n_dyads)]);
        for k in 1..=n_dyads {
            let dyad = &found.facts[&format!("dyad_{k}")];
            for [x, y, turn] in &all[..n_poses] {
                let (sin, cos) = turn.to_radians().sin_cos();
                let (u, v) = (dyad[4], dyad[5]);
                let (px, py) = (x + cos * u - sin * v, y + sin * u + cos * v);
                let length = (px - dyad[0]).hypot(py - dyad[1]);
                assert!((length - dyad[6]).abs() < 1e-12, "{dyad:?}");
            }
        }
        models_solve(found);
    }
}

#[test]
fn four_points_leave_the_offset_of_either_angle() {
    // Angles of a four-bar, the follower's counted from elsewhere.
    let (a, b, c, d, psi0) = (0.4_f64, 1.1_f64, 0.8_f64, 1.0_f64, 0.3);
    let follower = |phi: f64| {
        let (x, y) = (a * phi.cos() - d, a * phi.sin());
        let l = x.hypot(y);
        y.atan2(x) - ((l * l + c * c - b * b) / (2.0 * l * c)).acos()
    };
    let phi = [0.4, 0.9, 1.5, 2.2];
    let psi = phi.map(|phi| follower(phi) - psi0);
    let task = format!(
        "[synthesize]\ntask = \"function\"\nphi = {phi:?}\npsi = {psi:?}\noffsets = \"psi\"\n"
    );
    let found = solved(&task);
    let is_it = |candidate: &&Candidate| {
        [("a", a), ("b", b), ("c", c), ("psi0", psi0)]
            .into_iter()
            .all(|(name, value)| (candidate.numbers[name] - value).abs() < 1e-9)
    };
    assert_eq!(found.candidates.iter().filter(is_it).count(), 1, "{found:?}");
}

#[test]
fn a_given_four_bar_has_its_line_and_evans_a_short_one() {
    let hoeken = solved(
        "[synthesize]\ntask = \"straight_line\"\nlinkage = \"hoeken\"\nrange = \"60 deg\"\n",
    );
    let given = solved(
        "[synthesize]\ntask = \"straight_line\"\nlinkage = \"given\"\ncrank = 1\ncoupler = 2.5\nrocker = 2.5\nground = 2\npoint = [5, 0]\nangles = [\"120 deg\", \"240 deg\"]\n",
    );
    for name in ["length", "span"] {
        let [a, b] = [&hoeken, &given].map(|found| found.candidates[0].numbers[name]);
        assert!((a - b).abs() < 1e-9, "{name}: {a} {b}");
    }
    let evans = solved("[synthesize]\ntask = \"straight_line\"\nlinkage = \"evans\"\n");
    let numbers = &evans.candidates[0].numbers;
    // From −30° to 30° the end of the coupler goes from −1 to 1, as Scott and Russell's does exactly.
    assert!((numbers["length"] - 2.0).abs() < 1e-2, "{numbers:?}");
    assert!(numbers["deviation_over_length"] < 1e-2, "{numbers:?}");
    models_solve(&evans);
    models_solve(&given);
}

#[test]
fn a_point_on_a_pin_has_no_cognate_without_links() {
    let found = solved(
        "[synthesize]\ntask = \"cognates\"\ncrank = 2\ncoupler = 4\nrocker = 3\nground = 3.5\npoint = [0, 0]\n",
    );
    assert_eq!(found.candidates.len(), 2);
    assert!(found.candidates.iter().all(|c| c.numbers["crank"] > 0.1 && c.numbers["rocker"] > 0.1));
}

type C = nalgebra::Complex<f64>;

#[test]
fn dwells_rest_as_long_as_they_are_to() {
    let found = solved(
        "[synthesize]\ntask = \"dwell\"\ndwell = \"100 deg\"\nswing = \"25 deg\"\nground = \"200 mm\"\nstarts = 600\ncandidates = 3\n",
    );
    assert!(!found.candidates.is_empty());
    // The point at two distances, on the side of a known one.
    let meet = |a: C, ra: f64, b: C, rb: f64, side: f64| {
        let l = (b - a).norm();
        let x = (ra * ra - rb * rb + l * l) / (2.0 * l);
        a + (b - a) / l * C::new(x, side * (ra * ra - x * x).sqrt())
    };
    for candidate in &found.candidates {
        let n = |name: &str| candidate.numbers[name];
        let z = |name: &str| C::new(n(&format!("{name}_x")), n(&format!("{name}_y")));
        let side = |a: C, b: C, p: C| ((p - a) * (b - a).conj()).im.signum();
        let [a, d, b, c, g, q] =
            ["pivot_1", "pivot_2", "pin_1", "pin_2", "pivot_3", "pin_3"].map(z);
        let w = C::new(n("point_along_coupler"), n("point_left_of_coupler"));
        let of_point = |b: C, c: C| b + w * (c - b) / (c - b).norm();
        let (first, second) = (side(b, d, c), side(of_point(b, c), g, q));
        let at = |phi: f64| {
            let pin = a + C::from_polar(n("crank"), phi);
            let c = meet(pin, n("coupler"), d, n("rocker"), first);
            let q = meet(of_point(pin, c), n("link"), g, n("output"), second);
            (q - g).arg()
        };
        let from = n("dwell_from");
        let rest: Vec<f64> =
            (0..=200).map(|k| at(from + f64::from(k) / 200.0 * n("dwell"))).collect();
        let turn: Vec<f64> = (0..=720).map(|k| at(f64::from(k).to_radians() / 2.0)).collect();
        let width = |all: &[f64]| {
            let off = all.iter().map(|x| (C::i() * (x - rest[0])).exp().arg());
            off.clone().fold(f64::MIN, f64::max) - off.fold(f64::MAX, f64::min)
        };
        assert!((width(&rest) - n("dwell_error")).abs() < 0.02 * n("dwell_error"), "{candidate:?}");
        assert!(n("dwell_error") < 0.5_f64.to_radians(), "{candidate:?}");
        assert!((width(&turn).to_degrees() - 25.0).abs() < 0.2, "{candidate:?}");
    }
    models_solve(&found);
}

/// A block in the slot of an arm, whose pivot is on the line of a nearly straight part of the curve.
#[test]
fn straight_parts_rest_an_arm_with_a_slot() {
    let found = solved(
        "[synthesize]\ntask = \"dwell\"\noutput = \"slide\"\ndwell = \"110 deg\"\nswing = \"25 deg\"\nground = \"200 mm\"\nstarts = 600\ncandidates = 3\n",
    );
    assert_eq!(found.candidates.len(), 3);
    for candidate in &found.candidates {
        let n = |name: &str| candidate.numbers[name];
        let z = |name: &str| C::new(n(&format!("{name}_x")), n(&format!("{name}_y")));
        let [a, d, b, c, g] = ["pivot_1", "pivot_2", "pin_1", "pin_2", "pivot_3"].map(z);
        let w = C::new(n("point_along_coupler"), n("point_left_of_coupler"));
        let side = ((c - b) * (d - b).conj()).im.signum();
        let at = |phi: f64| {
            let (pin, l) = (a + C::from_polar(n("crank"), phi), |pin: C| (d - pin).norm());
            let l = l(pin);
            let x = (n("coupler").powi(2) - n("rocker").powi(2) + l * l) / (2.0 * l);
            let c = pin + (d - pin) / l * C::new(x, side * (n("coupler").powi(2) - x * x).sqrt());
            pin + w * (c - pin) / (c - pin).norm() - g
        };
        let angles = |from: f64, to: f64, steps: i32| -> Vec<f64> {
            let first = at(from);
            let place = |k: i32| from + (to - from) * f64::from(k) / f64::from(steps);
            (0..=steps).map(|k| (at(place(k)) / first).arg()).collect()
        };
        let width = |all: &[f64]| {
            let fold = |f: fn(f64, f64) -> f64| all.iter().copied().reduce(f).expect("angles");
            fold(f64::max) - fold(f64::min)
        };
        let from = n("dwell_from");
        let rest = width(&angles(from, from + n("dwell"), 400));
        let turn = width(&angles(from, from + std::f64::consts::TAU, 1440)).to_degrees();
        assert!((rest - n("dwell_error")).abs() < 0.02 * n("dwell_error"), "{candidate:?}");
        assert!(n("dwell_error") < 0.5_f64.to_radians(), "{candidate:?}");
        assert!((turn - 25.0).abs() < 0.2, "{turn} in {candidate:?}");
    }
    models_solve(&found);
}
