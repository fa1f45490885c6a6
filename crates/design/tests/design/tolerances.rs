//! Tolerances against closed forms and exact moments.

use bksim_design::{Source, Tolerance, ToleranceWish, Watch, tolerance};
use serde_json::Value;

fn solved(text: &str) -> Tolerance {
    let source = Source { text: text.to_owned(), name: "model".to_owned(), ..Source::default() };
    let wish = ToleranceWish::of_model(text).expect("a question");
    tolerance(&source, &wish, Watch::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn is_close(value: f64, expected: &Value, tolerance: f64) {
    let expected = expected.as_f64().expect("a number");
    assert!((value - expected).abs() <= tolerance, "{value} for {expected}");
}

/// Within four of its own standard errors.
#[track_caller]
fn is_sampled([value, error]: [f64; 2], expected: &Value) {
    let expected = expected.as_f64().expect("a number");
    assert!((value - expected).abs() <= 4.0 * error, "{value} ± {error} for {expected}");
}

const FOUR_BAR: &str = r#"
[parameters]
a = "0.06 m"
b = "0.17 m"
c = "0.12 m"
d = "0.18 m"
[ground]
points = { A = [0, 0], D = ["d", 0] }
[bodies.crank]
points = { A = [0, 0], B = ["a", 0] }
[bodies.coupler]
points = { B = [0, 0], C = ["b", 0] }
[bodies.rocker]
points = { D = [0, 0], C = ["c", 0] }
[joints.A]
type = "revolute"
between = ["ground.A", "crank.A"]
[joints.B]
type = "revolute"
between = ["crank.B", "coupler.B"]
[joints.C]
type = "revolute"
between = ["coupler.C", "rocker.C"]
[joints.D]
type = "revolute"
between = ["ground.D", "rocker.D"]
[initial]
A = { angle = "40 deg" }
D = { guess = { angle = "85 deg" } }
[tolerance]
of = "rocker.angle"
at = { "A.angle" = "0.9 rad" }
limits = { a = "±0.1 mm", b = "±0.2 mm", c = "±0.15 mm", d = "±0.3 mm" }
distribution = "uniform"
samples = 10000
"#;

#[test]
fn a_four_bar_has_the_proved_band_and_the_exact_moments() {
    let fixture: Value =
        serde_json::from_str(include_str!("../fixtures/tol_four_bar.json")).expect("a fixture");
    let values = &fixture["values"];
    let found = solved(FOUR_BAR);
    let pose = &found.poses[0];
    assert_eq!(pose.assembles, Some(true));
    let band = &pose.bands[0];
    is_close(band.nominal, &values["nominal"], 1e-9);
    is_close(band.linear_worst, &values["linear_worst"], 1e-9);
    is_close(band.rss, &values["rss_of_limits"], 1e-9);
    assert!(band.proved && !band.linear_fails, "{band:?}");
    for side in 0..2 {
        is_close(band.exact_interval[side], &values["exact_interval"][side], 1e-9);
        let at: Vec<&str> = values["exact_interval_at"][side]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(Value::as_str)
            .collect();
        assert_eq!(band.exact_at[side], at);
    }
    is_sampled(band.mean, &values["uniform"]["mean"]);
    is_sampled(band.sigma, &values["uniform"]["sigma"]);
    is_close(band.sigma_linear, &values["uniform"]["sigma_linear"], 1e-9);
    assert!(
        band.sampled[0] >= band.exact_interval[0] && band.sampled[1] <= band.exact_interval[1],
        "{band:?}"
    );
    for (row, one) in fixture["rows"].as_array().expect("rows").iter().zip(&band.contributors) {
        is_close(one.sensitivity, &row[2], 1e-8);
        is_close(one.percent_of_worst, &row[4], 1e-7);
        is_close(one.percent_of_variance, &row[5], 1e-7);
    }
    let band = solved(&FOUR_BAR.replace("uniform", "normal")).poses.remove(0).bands.remove(0);
    is_sampled(band.mean, &values["normal_three_sigma"]["mean"]);
    is_sampled(band.sigma, &values["normal_three_sigma"]["sigma"]);
}

#[test]
fn near_a_dead_centre_the_linear_band_is_refuted() {
    let fixture: Value =
        serde_json::from_str(include_str!("../fixtures/tol_toggle_clamp.json")).expect("a fixture");
    let values = &fixture["values"];
    let text = r#"
[parameters]
l1 = "0.12 m"
l2 = "0.15 m"
X = "0.2698 m"
[ground]
points = { O = [0, 0], P = ["X", 0] }
[bodies.one]
points = { O = [0, 0], Q = ["l1", 0] }
[bodies.two]
points = { Q = [0, 0], P = ["l2", 0] }
[joints.O]
type = "revolute"
between = ["ground.O", "one.O"]
[joints.Q]
type = "revolute"
between = ["one.Q", "two.Q"]
[joints.P]
type = "revolute"
between = ["ground.P", "two.P"]
[initial]
O = { guess = { angle = "3 deg" } }
Q = { guess = { angle = "-6 deg" } }
[tolerance]
of = "one.angle"
limits = { l1 = "±0.1 mm", l2 = "±0.1 mm", X = "±0.15 mm" }
distribution = "uniform"
samples = 10000
"#;
    let found = solved(text);
    let pose = &found.poses[0];
    assert_eq!(pose.assembles, Some(false), "some parts do not assemble");
    is_sampled(pose.share_without_assembly, &values["share_without_assembly"]);
    let band = &pose.bands[0];
    assert!(band.linear_fails && !band.proved, "{band:?}");
    is_close(band.nominal, &values["nominal"], 1e-9);
    is_close(band.linear_worst, &values["linear_worst"], 1e-9);
    for side in 0..2 {
        is_close(band.exact_interval[side], &values["exact_interval"][side], 1e-9);
    }
    is_sampled(band.mean, &values["mean_of_the_rest"]);
    is_sampled(band.sigma, &values["sigma_of_the_rest"]);
}

#[test]
fn a_band_over_a_range_has_a_row_for_each_pose() {
    let found = solved(&FOUR_BAR.replace("\"0.9 rad\"", "\"0:350 deg:8\"").replace("10000", "200"));
    assert_eq!(found.poses.len(), 8);
    for pose in &found.poses {
        // Where a slope passes zero within the limits, no corner need be an end.
        let band = &pose.bands[0];
        let passes_zero = |one: &bksim_design::Contributor| one.percent_of_worst < 1.0;
        assert!(band.proved || band.contributors.iter().any(passes_zero), "{pose:?}");
        assert!(
            band.exact_interval[0] < band.sampled[0] && band.sampled[1] < band.exact_interval[1],
            "{band:?}"
        );
    }
}

#[test]
fn letters_of_fits_are_limits() {
    let text = FOUR_BAR.replace("±0.1 mm", "H7").replace("±0.3 mm", "g6");
    let found = solved(&text);
    let of = |name: &str| {
        let mut parts = found.poses[0].bands[0].contributors.iter();
        let part = parts.find(|part| part.name == name).expect("a part");
        part.limits.map(|x| (x * 1e6).round())
    };
    // 60 mm H7 and 180 mm g6, from published tables.
    assert_eq!([of("a"), of("d")], [[0.0, 30.0], [-39.0, -14.0]]);
}
