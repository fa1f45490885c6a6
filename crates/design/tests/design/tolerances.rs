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

/// The angle of the rocker for a crank pin aside by `d`, by the intersection of two circles.
fn rocker(phi: f64, [dx, dy]: [f64; 2]) -> f64 {
    let (b, c, ground) = (0.17_f64, 0.12_f64, 0.18_f64);
    let at = [0.06 * phi.cos() + dx - ground, 0.06 * phi.sin() + dy];
    let far = at[0].hypot(at[1]);
    at[1].atan2(at[0]) - ((far * far + c * c - b * b) / (2.0 * far * c)).acos()
}

#[test]
fn play_of_a_pin_is_a_link_in_any_direction() {
    let limits = "limits = { a = \"±0.1 mm\", b = \"±0.2 mm\", c = \"±0.15 mm\", d = \"±0.3 mm\" }";
    let text = FOUR_BAR.replace(limits, "play = { B = \"0.5 mm\" }").replace("10000", "40000");
    let found = solved(&text);
    let band = &found.poses[0].bands[0];
    let (reach, phi) = (0.5e-3, 0.9);
    let of = |d: [f64; 2]| rocker(phi, d);
    // Slopes by differences, ends by all directions, and the refinement of the best.
    let slope = |h: f64| [[h, 0.0], [0.0, h]].map(|[x, y]| (of([x, y]) - of([-x, -y])) / (2.0 * h));
    let [x, y] = slope(1e-6);
    let expected = [band.linear_worst, reach * x.hypot(y)];
    assert!((expected[0] - expected[1]).abs() < 1e-9, "{expected:?}");
    let at = |turn: f64| of([reach * turn.cos(), reach * turn.sin()]);
    let best = |sign: f64| {
        let angle = |k: i32| f64::from(k) * std::f64::consts::TAU / 20_000.0;
        (0..20_000).map(|k| sign * at(angle(k))).fold(f64::NEG_INFINITY, f64::max) * sign
    };
    for (end, exact) in band.exact_interval.into_iter().zip([best(-1.0), best(1.0)]) {
        assert!((end - exact).abs() < 1e-10, "{end} for {exact}");
    }
    assert!(band.proved && !band.linear_fails, "{band:?}");
    // A place in a disc: a quarter of the square of its radius along any line.
    let sigma = 0.5 * band.linear_worst;
    assert!((band.sigma_linear / sigma - 1.0).abs() < 1e-12, "{band:?}");
    assert!((band.sigma[0] - sigma).abs() < 4.0 * band.sigma[1] + 1e-3 * sigma, "{band:?}");
    assert!(band.exact_interval[0] < band.sampled[0] && band.sampled[1] < band.exact_interval[1]);

    // With the parts, worst cases add up; the pin's name is that of its joint.
    let both = solved(&FOUR_BAR.replace("distribution", "play = { B = \"0.5 mm\" }\ndistribution"));
    let parts = solved(FOUR_BAR);
    let [both, parts] = [&both, &parts].map(|found| &found.poses[0].bands[0]);
    assert!((both.linear_worst - parts.linear_worst - band.linear_worst).abs() < 1e-12);
    assert_eq!(both.contributors.last().map(|c| c.name.as_str()), Some("B (play)"));
    assert!(both.exact_interval[0] < parts.exact_interval[0]);
    assert!(both.proved, "{both:?}");

    // Two pins at once, each aside in any direction: by all pairs of these.
    let text = FOUR_BAR.replace(limits, "play = { B = \"0.5 mm\", A = \"0.2 mm\" }");
    let two = &solved(&text.replace("10000", "500")).poses[0].bands[0];
    assert!(two.proved, "{two:?}");
    let direction = |k: i32| f64::from(k) * std::f64::consts::TAU / 2000.0;
    let aside = |r: f64, turn: f64| [r * turn.cos(), r * turn.sin()];
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for (k, l) in (0..2000).flat_map(|k| (0..2000).step_by(20).map(move |l| (k, l))) {
        let [b, a] = [aside(reach, direction(k)), aside(0.2e-3, direction(l))];
        let value = of([b[0] + a[0], b[1] + a[1]]);
        (least, most) = (least.min(value), most.max(value));
    }
    // Both pins move the same point of the loop: together as one with the sum of both plays.
    assert!(two.exact_interval[0] <= least + 1e-12 && two.exact_interval[1] >= most - 1e-12);
    let whole = |sign: f64| {
        let value =
            |k: i32| sign * of(aside(0.7e-3, f64::from(k) * std::f64::consts::TAU / 40_000.0));
        (0..40_000).map(value).fold(f64::NEG_INFINITY, f64::max) * sign
    };
    for (end, exact) in two.exact_interval.into_iter().zip([whole(-1.0), whole(1.0)]) {
        assert!((end - exact).abs() < 1e-10, "{end} for {exact}");
    }
}

#[test]
fn play_that_is_none_is_refused() {
    for (play, words) in [
        ("X = \"0.1 mm\"", "no joint `X`"),
        ("B = \"0.1\"", "no play of `B`"),
        ("B = \"-0.1 mm\"", "no play of `B`"),
    ] {
        let text = FOUR_BAR.replace("distribution", &format!("play = {{ {play} }}\ndistribution"));
        let source = Source { text: text.clone(), name: "model".to_owned(), ..Source::default() };
        let wish = ToleranceWish::of_model(&text).expect("a question");
        let error = tolerance(&source, &wish, Watch::default()).expect_err("a fault");
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn a_path_has_a_band_across_it() {
    let text = FOUR_BAR
        .replace("of = \"rocker.angle\"", "of = [\"crank.B.x\", \"crank.B.y\"]")
        .replace("\"0.9 rad\"", "\"0:270 deg:4\"")
        .replace("10000", "50");
    let found = solved(&text);
    for pose in &found.poses {
        // The pin of the crank is on a circle: across it is along the crank.
        let band = &pose.paths[0];
        assert_eq!(band.of, "crank.B");
        assert!((band.linear_worst - 0.1e-3).abs() < 1e-12, "{band:?}");
        assert!((band.at[0].hypot(band.at[1]) - 0.06).abs() < 1e-12, "{band:?}");
    }
}

/// A question of the cheapest limits, with few samples.
fn cheapest(more: &str) -> Tolerance {
    solved(&format!("{}{more}\n", FOUR_BAR.replace("samples = 10000", "samples = 100")))
}

#[test]
fn the_cheapest_limits_are_those_of_lagrange() {
    let wanted = 0.4_f64.to_radians();
    for by in ["worst", "squares"] {
        let keep =
            "keep = { \"rocker.angle\" = \"±0.4 deg\" }\nweights = { a = 1, b = 2.5, d = 0.5 }";
        let found = cheapest(&format!("{keep}\nby = \"{by}\""));
        let answer = found.cheapest.as_ref().expect("an answer");
        let band = &found.poses[0].bands[0];
        let slope = |name: &str| {
            let own = band.contributors.iter().find(|c| c.name == name);
            own.map_or(f64::NAN, |own| own.sensitivity.abs())
        };
        // w/t² is in one ratio to |S|, or to S² t.
        let rates: Vec<f64> = answer
            .parts
            .iter()
            .map(|part| {
                let (s, t) = (slope(&part.name), part.after);
                part.weight / (t * t) / if by == "worst" { s } else { s * s * t }
            })
            .collect();
        for rate in &rates {
            assert!((rate / rates[0] - 1.0).abs() < 1e-9, "{by} {rates:?}");
        }
        let names: Vec<&str> = answer.parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "d"], "the part without a weight keeps its limit");
        let kept = answer.kept[0].reached;
        assert!(kept <= wanted * (1.0 + 1e-9) && kept > 0.9999 * wanted, "{by} {kept} {wanted}");
        let of_bands = if by == "worst" { band.exact_interval[1] - band.nominal } else { band.rss };
        assert!(of_bands <= wanted * (1.0 + 1e-9), "{by}");
        assert!(answer.cost < answer.cost_before, "{answer:?}");
        // The model with the new limits has this band.
        let model = found.model.as_deref().expect("a model");
        let plain = solved(&model.replace(keep, ""));
        assert_eq!(plain.poses[0].bands[0].exact_interval, band.exact_interval, "{by}");
    }
}

#[test]
fn no_limits_that_keep_several_poses_are_cheaper() {
    let at = "at = { \"A.angle\" = \"0:270 deg:4\" }";
    let text = FOUR_BAR.replace("at = { \"A.angle\" = \"0.9 rad\" }", at);
    let keep = "keep = { \"rocker.angle\" = \"±0.4 deg\", \"coupler.C.x\" = \"±0.4 mm\" }";
    let text = text.replace("samples = 10000", "samples = 100");
    let found = solved(&format!("{text}{keep}\nby = \"squares\"\n"));
    let answer = found.cheapest.as_ref().expect("an answer");
    let bands: Vec<_> = found.poses.iter().flat_map(|pose| &pose.bands).collect();
    let limits = |of: &str| if of == "rocker.angle" { 0.4_f64.to_radians() } else { 0.4e-3 };
    let fits = |halves: &[f64]| {
        bands.iter().all(|band| {
            let terms = band.contributors.iter().zip(halves);
            let squares: f64 = terms.map(|(c, t)| (c.sensitivity * t).powi(2)).sum();
            squares.sqrt() <= limits(&band.of) * (1.0 + 1e-9)
        })
    };
    let best: Vec<f64> = answer.parts.iter().map(|part| part.after).collect();
    assert!(fits(&best), "{answer:?}");
    // Steps in all directions, as far as they keep the results.
    let mut n_tried = 0;
    for k in 0..400_u32 {
        let part = |j: u32| f64::from((k * 7919 + 31 * (j + 1) * (k + 3)) % 1000) / 500.0 - 1.0;
        let near: Vec<f64> = (0..).zip(&best).map(|(j, t)| t * (1.0 + 0.01 * part(j))).collect();
        if fits(&near) {
            n_tried += 1;
            let cost: f64 = near.iter().map(|t| 1.0 / t).sum();
            assert!(cost > answer.cost * (1.0 - 1e-7), "{near:?} {answer:?}");
        }
    }
    assert!(n_tried > 20, "{n_tried}");
}

#[test]
fn limits_that_cannot_follow_are_refused() {
    for (more, code) in [
        ("keep = { \"rocker.angle\" = \"+0.2/-0.1 deg\" }", "O001"),
        ("keep = { \"rocker.angle\" = \"±0.2 mm\" }", "O001"),
        ("keep = { \"rocker.angle\" = \"±0.2 deg\" }\nweights = { e = 1 }", "O001"),
        ("keep = { \"rocker.angle\" = \"±0.2 deg\" }\nweights = { a = 0 }", "O001"),
        ("keep = { \"rocker.angle\" = \"±0.2 deg\" }\nby = \"luck\"", "O001"),
        ("keep = { \"rocker.angle\" = \"±0.01 deg\" }\nweights = { a = 1 }", "O008"),
    ] {
        let text = format!("{FOUR_BAR}{more}\n");
        let wish = ToleranceWish::of_model(&text).expect("a question");
        let source = Source { text, name: "model".to_owned(), ..Source::default() };
        let error = tolerance(&source, &wish, Watch::default()).expect_err("a fault");
        assert_eq!(error.diagnostics()[0].code.0, code, "{more}: {error}");
    }
}

#[test]
fn limits_as_large_as_the_length_are_noticed() {
    let own =
        FOUR_BAR.find("limits = ").map(|at| FOUR_BAR[at..].lines().next().unwrap_or_default());
    let text =
        FOUR_BAR.replace(own.expect("limits"), "limits = { a = \"±100 mm\", b = \"±0.1 mm\" }");
    let found = solved(&text);
    let [warning] = found.warnings.as_slice() else { panic!("{:?}", found.warnings) };
    assert_eq!(warning.code.0, "O013");
    assert!(warning.message.contains("from -0.04 m to 0.16 m"), "{}", warning.message);
    let place = &warning.labels[0].span;
    assert_eq!(&text[place.clone()], "a");
    assert!(text[..place.start].ends_with("limits = { "), "{}", &text[..place.start]);
    assert!(solved(FOUR_BAR).warnings.is_empty());
}

#[test]
fn faults_of_a_question_are_said_without_words_of_the_reader() {
    for (line, said) in [
        ("limits = { a = 0.1 }", "expected a limit in quotes"),
        ("at = [1, 2]", "found a list in place of a table"),
        ("of = \"rocker.angle\"\nlimit = { a = \"±0.1 mm\" }", "there is no key `limit`"),
    ] {
        let head = FOUR_BAR.split("[tolerance]").next().unwrap_or_default();
        let text = format!("{head}[tolerance]\n{line}\n");
        let error = ToleranceWish::of_model(&text).expect_err("a fault");
        let fault = &error.diagnostics()[0];
        assert!(fault.message.contains(said), "{line}: {}", fault.message);
        for word in ["enum", "sequence", "map,", "variant", "untagged"] {
            assert!(!fault.message.contains(word), "{}", fault.message);
        }
        let place = fault.labels[0].span.start;
        assert!(place > head.len(), "{line}: {place}");
    }
}

#[test]
fn a_swing_and_its_ends_have_their_bands() {
    let of = "of = [\"max(rocker.angle)\", \"min(rocker.angle)\", \"peak_to_peak(rocker.angle)\"]";
    let text = FOUR_BAR
        .replace("of = \"rocker.angle\"", of)
        .replace("\"0.9 rad\"", "\"0:360 deg:37\"")
        .replace("samples = 10000", "samples = 500");
    let found = solved(&text);
    let pose = &found.poses[0];
    assert_eq!(pose.over.as_deref(), Some("A.angle=0:360 deg:37"));
    // Crank and coupler in line: the angle at the rocker's pivot from the line of pivots.
    let at = |[_, _, c, d]: [f64; 4], l: f64| {
        std::f64::consts::PI - ((c * c + d * d - l * l) / (2.0 * c * d)).acos()
    };
    let ends = |p: [f64; 4]| {
        let (least, most) = (at(p, p[1] + p[0]), at(p, p[1] - p[0]));
        [most, least, most - least]
    };
    let (p, limits) = ([0.06, 0.17, 0.12, 0.18], [1e-4, 2e-4, 1.5e-4, 3e-4]);
    for (k, band) in pose.bands.iter().enumerate() {
        let corners = (0..16_u32).map(|corner| {
            let moved = |j: usize| if corner >> j & 1 == 1 { limits[j] } else { -limits[j] };
            ends(std::array::from_fn(|j| p[j] + moved(j)))[k]
        });
        let expected =
            corners.fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(x), high.max(x)]);
        assert!((band.nominal - ends(p)[k]).abs() < 1e-9, "{} {}", band.nominal, ends(p)[k]);
        for (found, expected) in band.exact_interval.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{k}: {found} {expected}");
        }
        for (j, part) in band.contributors.iter().enumerate() {
            let moved =
                |h: f64| ends(std::array::from_fn(|i| p[i] + if i == j { h } else { 0.0 }))[k];
            let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((part.sensitivity - slope).abs() < 1e-4, "{k} {part:?} {slope}");
        }
        assert!(
            band.exact_interval[0] <= band.sampled[0] && band.sampled[1] <= band.exact_interval[1]
        );
    }
}

#[test]
fn extremes_in_a_formula_are_asked_for_by_themselves() {
    let text = FOUR_BAR.replace("\"0.9 rad\"", "\"0:6 rad:7\"");
    for (of, help) in [
        ("max(rocker.angle)-min(rocker.angle)", "write `peak_to_peak(rocker.angle)`"),
        ("2*max(rocker.angle)", "ask for `max(rocker.angle)` by itself"),
        ("max(rocker.angle) - min(coupler.angle)", "ask for `max(rocker.angle)` by itself"),
        ("max(rocker.angle, 2", "write one as in `rocker.angle - o2`"),
    ] {
        let text = text.replace("of = \"rocker.angle\"", &format!("of = \"{of}\""));
        let source = Source { text: text.clone(), name: "bar".to_owned(), ..Source::default() };
        let wish = ToleranceWish::of_model(&text).expect("a question");
        let error = tolerance(&source, &wish, Watch::default()).expect_err("a fault");
        let fault = &error.diagnostics()[0];
        assert_eq!((fault.code.0, fault.help.as_deref()), ("O001", Some(help)), "{of}");
    }
}
