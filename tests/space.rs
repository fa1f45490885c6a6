//! Mechanisms in space against closed forms: a four-bar with ball joints, and a platform on six legs.

mod support;

use serde_json::Value;
use support::{Within, at, close, coordinate, derive, model, path, solve};

const WITHIN: Within = Within { relative: 1e-9, absolute: 1e-9 };

/// The rows of a reference, by the names of its columns.
struct Reference {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Reference {
    fn new(name: &str) -> Self {
        let file = path("tests/data/spatial").join(format!("{name}.json"));
        let text = std::fs::read_to_string(file).expect("a reference");
        let data: Value = serde_json::from_str(&text).expect("a reference is JSON");
        let names = data["columns"].as_array().expect("columns").iter();
        let columns = names.map(|name| name.as_str().expect("a name").to_owned()).collect();
        let numbers = |row: &Value| {
            let row = row.as_array().expect("a row").iter();
            row.map(|x| x.as_f64().expect("a number")).collect()
        };
        let rows = data["rows"].as_array().expect("rows").iter().map(numbers).collect();
        Self { columns, rows }
    }

    fn of(&self, row: &[f64], name: &str) -> f64 {
        let place = self.columns.iter().position(|column| column == name);
        row[place.unwrap_or_else(|| panic!("no column `{name}`"))]
    }
}

/// A coupler with a mass: it spins about its line as it likes, unless one of its ends is a universal joint.
fn with_coupler(first: &str, second: &str) -> String {
    let text = include_str!("fixtures/rssr.toml");
    let (before, after) = text.split_once("[joints.coupler]").expect("the coupler");
    let rest = after.split_once("length = 0.45\n").expect("its length").1;
    format!(
        "{before}[bodies.coupler]\nmass = 0.5\ncom = [0.225, 0, 0]\ninertia = [0.001, 0.02, 0.02]\n\
         points.B = [0.45, 0, 0]\n\
         [joints.A]\nbetween = [\"crank.A\", \"coupler\"]\n{first}\n\
         [joints.B]\nbetween = [\"coupler.B\", \"rocker.B\"]\n{second}\n{rest}"
    )
}

#[test]
fn a_spatial_four_bar_follows_its_closed_form() {
    let reference = Reference::new("rssr");
    let ball = "type = \"spherical\"";
    let cross = "type = \"universal\"\naxis = [0, 0, 1]\nsecond = [0, 1, 0]";
    let variants = [
        ("a link", include_str!("fixtures/rssr.toml").to_owned()),
        ("two ball joints", with_coupler(ball, ball)),
        ("a universal and a ball joint", with_coupler(cross, ball)),
    ];
    for (variant, text) in variants {
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let [theta, phi] = ["theta", "phi"].map(|name| coordinate(&mechanism, name));
        for row in &reference.rows {
            let sample = at(&motion, reference.of(row, "theta"));
            close("theta", sample.q[theta], sample.t, WITHIN);
            let found = [sample.q[phi], sample.v[phi], sample.a[phi]];
            for (name, found) in ["phi", "dphi", "d2phi"].into_iter().zip(found) {
                let expected = reference.of(row, name);
                let what = format!("{variant}: {name} at {}", sample.t);
                close(&what, found, expected, WITHIN);
            }
        }
    }
}

#[test]
fn the_legs_of_a_platform_have_the_lengths_of_its_motion() {
    let reference = Reference::new("stewart_inverse");
    let mechanism = derive(model(include_str!("fixtures/stewart.toml")));
    let motion = solve(&mechanism);
    let within = reference.rows.iter().filter(|row| row[0] <= 2.5);
    for row in within {
        let sample = at(&motion, row[0]);
        for leg in 1..=6 {
            let idx = coordinate(&mechanism, &format!("L{leg}"));
            for (name, found) in
                [("L", sample.q[idx]), ("dL", sample.v[idx]), ("ddL", sample.a[idx])]
            {
                let name = format!("{name}{leg}");
                let what = format!("{name} at {} s", sample.t);
                close(&what, found, reference.of(row, &name), WITHIN);
            }
        }
    }
}
