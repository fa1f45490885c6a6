//! `bksim cam`: its report, table and drawings.

use std::fs;

use crate::common::{Scratch, text};
use serde_json::Value;

/// A roller of 10 mm on a cam with hollow flanks.
const HOLLOW: &str = r#"
[curves.lift]
type = "cam-law"
segments = [
  { rise = "25 mm", over = "50 deg", law = "cycloidal" },
  { return = "25 mm", over = "100 deg", law = "cycloidal" },
  { dwell = "210 deg" },
]
[curves.profile]
type = "cam"
law = "lift"
base_circle = "base"
follower = { kind = "roller", radius = "10 mm" }
[parameters]
base = "40 mm"
[bodies.cam]
[joints.O]
type = "revolute"
between = ["ground", "cam"]
"#;

fn json(place: &Scratch, arguments: &str) -> Value {
    let output = place.run(&format!("{arguments} --json"));
    assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one object")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("numbers").iter().map(|n| n.as_f64().expect("a number")).collect()
}

#[test]
fn the_report_names_factors_and_places() {
    let place = Scratch::new();
    place.write("cam.toml", HOLLOW);
    let output = place.run("cam cam.toml");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report = text(&output.stdout);
    for part in [
        "profile profile of a roller follower by the law lift",
        "cycloidal  0 deg   50 deg   0.025 m   2         6.28318531    39.4784176",
        "base circle                0.04 m\n",
        "pressure angle, rise       42.9844696 deg   at 22.9512017 deg\n",
        "smallest without undercut  0.0108182983 m   at 40.8292418 deg\n",
    ] {
        assert!(report.contains(part), "{part}:\n{report}");
    }

    // The law alone, another value of a parameter, and a fault.
    let law = json(&place, "cam cam.toml lift");
    assert!(law["profile"].is_null());
    let other = json(&place, "cam cam.toml --set base=60mm");
    assert_eq!(other["profile"]["base_circle"].as_f64(), Some(0.06));
    let output = place.run("cam cam.toml profil");
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("name one of `profile`, `lift`"));
    let output = place.run("cam cam.toml -o cam.png");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains(".csv, .dxf or .svg"));
    let output = place.run("cam cam.toml lift -o lift.dxf");
    assert!(text(&output.stderr).contains("the law `lift` has no profile"));
    assert!(!place.path().join("lift.dxf").exists());
}

#[test]
fn curves_need_no_bodies() {
    let place = Scratch::new();
    let (curves, _) = HOLLOW.split_once("[bodies.cam]").expect("bodies");
    place.write("curves.toml", curves);
    let answer = json(&place, "cam curves.toml");
    assert_eq!(answer["profile"]["follower"], "roller");
    let output = place.run("check curves.toml");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("S030"), "{}", text(&output.stderr));
    // Other questions say that nothing moves.
    for question in ["--limits", "--drive t=0:1:3", "--drive O.angle=0:1:3"] {
        let output = place.run(&format!("kinematics curves.toml {question}"));
        let code = output.status.code();
        assert!(matches!(code, Some(0..=2)), "{question}: {code:?} {}", text(&output.stderr));
    }
}

#[test]
fn a_cutter_beside_the_profile_touches_it() {
    let place = Scratch::new();
    place.write("cam.toml", HOLLOW);
    let answer = json(&place, "cam cam.toml --cutter 6mm --rows 721 -o cam.csv");
    assert!(answer["diagnostics"].as_array().expect("warnings").is_empty());
    let columns: Vec<&str> = answer["table"]["columns"]
        .as_array()
        .expect("columns")
        .iter()
        .map(|column| column["name"].as_str().expect("a name"))
        .collect();
    let written = fs::read_to_string(place.path().join("cam.csv")).expect("a table");
    assert_eq!(written.lines().next(), Some(columns.join(",").as_str()));
    assert_eq!(written.lines().count(), 722);
    let at = |name: &str| columns.iter().position(|known| *known == name).expect("a column");
    let rows: Vec<Vec<f64>> =
        answer["table"]["rows"].as_array().expect("rows").iter().map(numbers).collect();
    let points = |name: &str| -> Vec<[f64; 2]> {
        let [x, y] = ["x", "y"].map(|axis| at(&format!("{name}{axis}")));
        rows.iter().map(|row| [row[x], row[y]]).collect()
    };
    // No point of the profile is nearer to a centre than the radius, and one is as near.
    for (centres, radius) in [("cutter_", 0.006), ("pitch_", 0.01)] {
        let profile = points("");
        for centre in points(centres) {
            let near = |p: &[f64; 2]| (p[0] - centre[0]).hypot(p[1] - centre[1]);
            let nearest = profile.iter().map(near).fold(f64::INFINITY, f64::min);
            assert!((nearest - radius).abs() < 1e-9, "{centres}: {nearest}");
        }
    }
    // A large one cuts into the flank.
    let output = place.run("cam cam.toml --cutter 60mm");
    assert!(text(&output.stderr).contains("Q010"), "{}", text(&output.stderr));
}

/// The drawing has arcs from corner to corner: their lengths and the area are those of the profile.
#[test]
fn the_drawing_is_the_profile_at_full_size() {
    let place = Scratch::new();
    place.write("cam.toml", HOLLOW);
    let answer = json(&place, "cam cam.toml --rows 28801 -o cam.dxf");
    assert_eq!(answer["output"], "cam.dxf");
    let drawn = fs::read_to_string(place.path().join("cam.dxf")).expect("a drawing");
    let lines: Vec<&str> = drawn.lines().map(str::trim).collect();
    let groups: Vec<(&str, &str)> = lines.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    let start = groups.iter().position(|group| *group == ("0", "LWPOLYLINE")).expect("a polyline");
    let own = groups[start + 1..].iter().take_while(|(code, _)| *code != "0");
    let own: Vec<(&str, &str)> = own.copied().collect();
    assert!(own.contains(&("8", "PROFILE")) && own.contains(&("70", "1")), "{:?}", &own[..12]);
    let mut corners: Vec<[f64; 3]> = Vec::new();
    for (code, value) in own {
        let number = || value.parse::<f64>().expect("a number");
        match code {
            "10" => corners.push([number(), 0.0, 0.0]),
            "20" => corners.last_mut().expect("a corner")[1] = number(),
            "42" => corners.last_mut().expect("a corner")[2] = number(),
            _ => {}
        }
    }
    assert_eq!(corners.len(), 720);
    // The area of the polygon, and of the segments of circles on its sides.
    let mut area = 0.0;
    for (k, [x, y, bulge]) in corners.iter().enumerate() {
        let [u, v, _] = corners[(k + 1) % corners.len()];
        area += 0.5 * (x * v - y * u);
        let angle = 4.0 * bulge.atan();
        if angle != 0.0 {
            let radius = 0.5 * (u - x).hypot(v - y) / (0.5 * angle).sin();
            area += 0.5 * radius * radius * (angle - angle.sin());
        }
    }
    let columns = answer["table"]["columns"].as_array().expect("columns");
    let at = |name: &str| columns.iter().position(|c| c["name"] == name).expect("a column");
    let rows: Vec<Vec<f64>> =
        answer["table"]["rows"].as_array().expect("rows").iter().map(numbers).collect();
    let point = |k: usize| [1e3 * rows[k][at("x")], 1e3 * rows[k][at("y")]];
    let cross = |k: usize| {
        let ([x, y], [u, v]) = (point(k), point(k + 1));
        0.5 * (x * v - y * u)
    };
    let expected: f64 = (0..rows.len() - 1).map(cross).sum();
    // mm²; the fine polygon itself is off by some 1e-5.
    assert!((area - expected).abs() < 2e-3, "{area} for {expected}");
    assert!(expected < -4000.0, "it goes around clockwise: {expected}");

    let output = place.run("cam cam.toml -o cam.svg --cutter 6mm");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let picture = fs::read_to_string(place.path().join("cam.svg")).expect("a picture");
    for part in ["id=\"PROFILE\"", "id=\"PITCH\"", "id=\"CUTTER\"", "mm\" height="] {
        assert!(picture.contains(part), "{part}");
    }
    // What is there is kept, unless it is of this model.
    assert!(place.run("cam cam.toml -o cam.svg").status.success());
    place.write("cam.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"/>");
    let output = place.run("cam cam.toml -o cam.svg");
    assert!(!output.status.success());
}
