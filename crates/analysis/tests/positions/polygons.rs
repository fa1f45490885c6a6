//! Velocity and acceleration polygons against a textbook's numbers and against what closes them.

use crate::support::geometry;
use bksim_analysis::{Drive, Polygon, Polygons, Prescribed, Range, VectorPart, polygons};

fn length(a: [f64; 2]) -> f64 {
    a[0].hypot(a[1])
}

fn vertex(polygon: &Polygon, name: &str) -> [f64; 2] {
    polygon.vertices.iter().find(|v| v.name == name).unwrap_or_else(|| panic!("no {name}")).at
}

/// Every vector begins at the pole, at a vertex, or where another one ends.
fn closes(polygon: &Polygon) {
    let near = |a: [f64; 2], b: [f64; 2]| length([a[0] - b[0], a[1] - b[1]]) < 1e-9;
    for vector in &polygon.vectors {
        let begins = near(vector.from, [0.0; 2])
            || polygon.vertices.iter().any(|v| near(v.at, vector.from))
            || polygon.vectors.iter().any(|v| near(v.to, vector.from));
        assert!(begins, "{vector:?}");
    }
    for v in polygon.vertices.iter().filter(|v| length(v.at) > 1e-9) {
        assert!(polygon.vectors.iter().any(|of| near(of.to, v.at)), "nothing leads to {v:?}");
    }
}

fn asked(text: &str, drive: (&str, &str), rate: f64, acceleration: f64) -> Polygons {
    let model = geometry(text);
    let drive =
        Drive { rate, acceleration, ..Drive::parse(&model, drive.0, drive.1).expect("a drive") };
    let drives = Prescribed::Drives { drives: vec![drive], through: false };
    polygons(model, &drives).expect("polygons")
}

/// R. L. Norton, *Design of Machinery*: links of 40, 120, 80 and 100 mm at 40°, ω 25 rad/s, α 15 rad/s²; the open
/// assembly has ω₃ −4.1209, ω₄ 6.9980 rad/s, α₃ 296.0892, α₄ 470.1335 rad/s².
const FOUR_BAR: &str = r#"
[ground]
points = { D = ["100 mm", 0] }
[bodies.crank]
points = { B = ["40 mm", 0] }
[bodies.coupler]
points = { C = ["120 mm", 0] }
[bodies.rocker]
points = { C = ["80 mm", 0] }
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "coupler"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker"] }
[initial]
A = { angle = "40 deg" }
rocker = { guess = { angle = "57 deg" } }
"#;

#[test]
fn a_four_bar_of_the_textbook() {
    let found = asked(FOUR_BAR, ("A.angle", "40 deg"), 25.0, 15.0);
    let body = |name: &str| found.bodies.iter().find(|b| b.0 == name).expect("a body");
    assert!((body("coupler").1 + 4.1209).abs() < 5e-5 && (body("rocker").1 - 6.9980).abs() < 5e-5);
    assert!((body("coupler").2 - 296.0892).abs() < 5e-5);
    assert!((body("rocker").2 - 470.1335).abs() < 5e-5);
    let (v, a) = (&found.velocity, &found.acceleration);
    assert!((length(vertex(v, "B")) - 0.04 * 25.0).abs() < 1e-12);
    assert!((length(vertex(v, "C")) - 0.08 * body("rocker").1).abs() < 1e-12);
    let normal = |point: &str| {
        let own =
            |v: &&bksim_analysis::PolygonVector| v.of.0 == point && v.part == VectorPart::Normal;
        let found: Vec<f64> = a
            .vectors
            .iter()
            .filter(own)
            .map(|v| length([v.to[0] - v.from[0], v.to[1] - v.from[1]]))
            .collect();
        found
    };
    assert_eq!(normal("B").len(), 1);
    assert!((normal("B")[0] - 0.04 * 625.0).abs() < 1e-9);
    // C from the coupler's side, and from the rocker's.
    let expected = [0.12 * body("coupler").1.powi(2), 0.08 * body("rocker").1.powi(2)];
    assert!(expected.iter().all(|x| normal("C").iter().any(|found| (found - x).abs() < 1e-9)));
    closes(v);
    closes(a);
}

#[test]
fn an_instant_of_a_drive_has_its_position_rate_and_acceleration() {
    let drive =
        "[drives.motor]\njoint = \"A\"\nmotion = \"40 deg + 25 rad/s*t + 7.5 rad/s^2*t^2\"\n";
    let model = geometry(&FOUR_BAR.replace("[initial]", &format!("{drive}[initial]")));
    let instant = Prescribed::Times(Range { from: 0.02, to: 0.02, n: 1 });
    let found = polygons(model, &instant).expect("polygons");
    let angle = (40_f64.to_radians() + 25.0 * 0.02 + 7.5 * 0.02 * 0.02).to_string();
    let expected = asked(FOUR_BAR, ("A.angle", &angle), 25.3, 15.0);
    let pairs =
        [(&found.velocity, &expected.velocity), (&found.acceleration, &expected.acceleration)];
    for (polygon, known) in pairs {
        assert!(polygon.vertices.len() >= 2);
        for v in &polygon.vertices {
            let [x, y] = vertex(known, &v.name);
            let off = length([v.at[0] - x, v.at[1] - y]);
            assert!(off < 1e-8 * length([x, y]), "{v:?}: {off}");
        }
    }
}

/// A crank whose pin slides along a bar that turns about the ground: the part of Coriolis is 2 ω v.
#[test]
fn a_slot_that_turns_has_the_part_of_coriolis() {
    let text = r#"
[ground]
points = { O = [0, 0], D = [0, -0.3] }
[bodies.crank]
points = { B = [0.1, 0] }
[bodies.bar]
[joints]
A = { type = "revolute", between = ["ground.O", "crank"] }
D = { type = "revolute", between = ["ground.D", "bar"] }
B = { type = "slot", between = ["bar", "crank.B"], axis = [1, 0] }
[initial]
A = { angle = 0.5 }
bar = { guess = { angle = 1.3 } }
"#;
    let found = asked(text, ("A.angle", "0.5"), 3.0, 0.0);
    let (v, a) = (&found.velocity, &found.acceleration);
    let bar = found.bodies.iter().find(|b| b.0 == "bar").expect("a body").1;
    let sliding = v.vectors.iter().find(|v| v.part == VectorPart::Sliding).expect("sliding");
    let slip = length([sliding.to[0] - sliding.from[0], sliding.to[1] - sliding.from[1]]);
    let coriolis = a.vectors.iter().find(|v| v.part == VectorPart::Coriolis).expect("Coriolis");
    let size = length([coriolis.to[0] - coriolis.from[0], coriolis.to[1] - coriolis.from[1]]);
    assert!((size - 2.0 * bar.abs() * slip).abs() < 1e-10, "{size}");
    // The pin turns about the crank's pivot at a constant rate.
    assert!((length(vertex(a, "B")) - 0.1 * 9.0).abs() < 1e-12);
    closes(v);
    closes(a);
}
