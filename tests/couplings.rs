//! Gears, belts, racks, screws and relations against reference motions, statics by hand, and the same
//! mechanism in other coordinates.

mod support;

use bksim::Mechanism;
use bksim::sim::run::Sample;
use serde_json::Value;
use support::{Measures, Within, at, close, coordinate, derive, model, path, reaction, solve};

/// Largest difference over the largest value of a column, of coordinates and rates.
const WITHIN: f64 = 1e-9;
/// Of accelerations and forces.
const FORCES_WITHIN: f64 = 1e-8;

fn text(name: &str) -> String {
    let file = path("tests/fixtures/elements").join(format!("{name}.toml"));
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

fn reference(file: &str) -> Value {
    let file = path("tests/data").join(file);
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    serde_json::from_str(&text).expect("a reference is JSON")
}

/// A quantity of a sample that a column holds, with the factor that turns ours into it.
#[derive(Clone, Copy)]
enum Quantity<'a> {
    Measure(&'a str, f64),
    Acceleration(&'a str, f64),
    Coupling(&'a str, f64),
    Reaction(&'a str, usize, f64),
}

use Quantity::{Acceleration, Coupling, Measure, Reaction};

/// The multiplier of a coupling.
fn effort(mechanism: &Mechanism, sample: &Sample, name: &str) -> f64 {
    let description = format!("coupling `{name}`");
    let row = mechanism.compiled.multipliers.iter().position(|m| m.description == description);
    sample.lambda[row.unwrap_or_else(|| panic!("no {description}"))]
}

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

fn value(mechanism: &Mechanism, sample: &Sample, quantity: Quantity<'_>) -> f64 {
    match quantity {
        Measure(name, factor) => factor * Measures::new(mechanism, &[name]).at(sample)[0],
        Acceleration(name, factor) => factor * sample.a[coordinate(mechanism, name)],
        Coupling(name, factor) => factor * effort(mechanism, sample, name),
        Reaction(joint, axis, factor) => factor * reaction(mechanism, sample, joint)[axis],
    }
}

/// Runs a fixture and compares columns of its reference.
#[track_caller]
fn check(fixture: &str, data: &str, columns: &[(&str, Quantity<'_>)]) {
    check_text(&text(fixture), fixture, data, columns);
}

#[track_caller]
fn check_text(text: &str, what: &str, data: &str, columns: &[(&str, Quantity<'_>)]) {
    let data = reference(data);
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let known: Vec<&str> =
        data["columns"].as_array().expect("columns").iter().filter_map(Value::as_str).collect();
    for &(column, quantity) in columns {
        let place = known.iter().position(|name| *name == column).expect("a column of this name");
        let rows = data["rows"].as_array().expect("rows");
        let number = |row: &Value, k: usize| row[k].as_f64().expect("a number");
        let scale = rows.iter().map(|row| number(row, place).abs()).fold(0.0, f64::max);
        let within = match quantity {
            Measure(..) => WITHIN,
            _ => FORCES_WITHIN,
        };
        for row in rows {
            let (t, expected) = (number(row, 0), number(row, place));
            let found = value(&mechanism, at(&motion, t), quantity);
            assert!(
                (found - expected).abs() <= within * scale,
                "{what}, {column} at {t} s: {found:.15e} for {expected:.15e}, off by {:.1e}",
                (found - expected).abs() / scale
            );
        }
    }
}

/// Angles, rates, accelerations and the difference of the tensions of a belt drive.
const BELT: [(&str, Quantity<'static>); 7] = [
    ("phi1", Measure("A.angle", 1.0)),
    ("w1", Measure("A.rate", 1.0)),
    ("a1", Acceleration("A_angle", 1.0)),
    ("phi2", Measure("B.angle", 1.0)),
    ("w2", Measure("B.rate", 1.0)),
    ("a2", Acceleration("B_angle", 1.0)),
    ("dT", Coupling("belt", 1.0)),
];

#[test]
fn an_open_belt() {
    check("belt-open", "elements/belt_open.json", &BELT);
    // In absolute coordinates the angles are those of the bodies.
    let absolute = format!("coordinates = \"absolute\"\n{}", text("belt-open"));
    let kept = BELT.map(|(column, quantity)| match quantity {
        Acceleration("A_angle", _) => (column, Acceleration("p1_angle", 1.0)),
        Acceleration("B_angle", _) => (column, Acceleration("p2_angle", 1.0)),
        other => (column, other),
    });
    check_text(&absolute, "belt-open, absolute", "elements/belt_open.json", &kept);
}

#[test]
fn a_crossed_belt() {
    // The tight strand turns the second pulley backwards.
    let crossed = BELT.map(|(column, quantity)| match quantity {
        Coupling(name, factor) => (column, Coupling(name, -factor)),
        other => (column, other),
    });
    check("belt-crossed", "elements/belt_crossed.json", &crossed);
}

#[test]
fn an_internal_pair_of_gears() {
    let columns = [
        ("phi1", Measure("P.angle", 1.0)),
        ("w1", Measure("P.rate", 1.0)),
        ("a1", Acceleration("P_angle", 1.0)),
        ("phi2", Measure("R.angle", 1.0)),
        ("w2", Measure("R.rate", 1.0)),
        ("a2", Acceleration("R_angle", 1.0)),
        ("Ft", Coupling("mesh", 1.0)),
        // The bearings carry the tooth force, across the line of centres; on the ring it is up.
        ("Ft", Reaction("P", 1, 1.0)),
        ("Ft", Reaction("R", 1, -1.0)),
    ];
    check("internal-pair", "elements/internal_pair.json", &columns);

    // With cut bearings, their multipliers are the reactions.
    let absolute = format!("coordinates = \"absolute\"\n{}", text("internal-pair"));
    let kept = columns.map(|(column, quantity)| match quantity {
        Acceleration("P_angle", _) => (column, Acceleration("pinion_angle", 1.0)),
        Acceleration("R_angle", _) => (column, Acceleration("ring_angle", 1.0)),
        other => (column, other),
    });
    check_text(&absolute, "internal-pair, absolute", "elements/internal_pair.json", &kept);
}

#[test]
fn cardan_circles() {
    let columns = [
        ("th", Measure("O.angle", 1.0)),
        ("w", Measure("O.rate", 1.0)),
        ("alpha", Acceleration("O_angle", 1.0)),
        ("x", Measure("guide.position", 1.0)),
        ("v", Measure("guide.velocity", 1.0)),
        ("Qx", Measure("planet.Q.x", 1.0)),
        ("Qy", Measure("planet.Q.y", 1.0)),
    ];
    check("cardan-circles", "elements/cardan_circles.json", &columns);
}

#[test]
fn a_bevel_differential() {
    let columns = [
        ("phi_left", Measure("left_axis.angle", 1.0)),
        ("phi_right", Measure("right_axis.angle", 1.0)),
        ("w_left", Measure("left_axis.rate", 1.0)),
        ("w_right", Measure("right_axis.rate", 1.0)),
        ("w_carrier", Measure("carrier_axis.rate", 1.0)),
        ("w_drive", Measure("drive_axis.rate", 1.0)),
        ("w_spider", Measure("spider_axis.rate", 1.0)),
        ("a_left", Acceleration("left_axis_angle", 1.0)),
        ("a_right", Acceleration("right_axis_angle", 1.0)),
        ("T_left", Coupling("left_mesh", 1.0)),
        ("T_right", Coupling("right_mesh", 1.0)),
    ];
    check("differential", "elements/differential.json", &columns);
}

#[test]
fn a_bevel_pair() {
    let columns = [
        ("phi1", Measure("S1.angle", 1.0)),
        ("w1", Measure("S1.rate", 1.0)),
        ("phi2", Measure("S2.angle", 1.0)),
        ("w2", Measure("S2.rate", 1.0)),
        ("alpha2", Acceleration("S2_angle", 1.0)),
        ("w2x", Measure("second.wx", 1.0)),
        ("w2z", Measure("second.wz", 1.0)),
    ];
    check("bevel-pair", "elements/bevel_pair.json", &columns);
}

#[test]
fn a_chain_hoist_by_two_relations() {
    let columns = [
        ("phi", Measure("axle.angle", 1.0)),
        ("w", Measure("axle.rate", 1.0)),
        ("a", Acceleration("axle_angle", 1.0)),
        ("x", Measure("rail.position", 1.0)),
        ("v", Measure("rail.velocity", 1.0)),
        ("T_R", Coupling("large", 1.0)),
        ("T_r", Coupling("small", -1.0)),
    ];
    check("chain-hoist", "elements/chain_hoist.json", &columns);
}

#[test]
fn a_rack_and_pinion() {
    let columns = [
        ("theta", Measure("axle.angle", 1.0)),
        ("omega", Measure("axle.rate", 1.0)),
        ("alpha", Acceleration("axle_angle", 1.0)),
        ("vz", Measure("guide.velocity", 1.0)),
        ("az", Acceleration("guide_position", 1.0)),
        // On the pinion; ours is on the rack.
        ("tooth_force", Coupling("mesh", -1.0)),
    ];
    check("rack-pinion", "spatial/rack_pinion.json", &columns);
}

/// The Ravigneaux set in its five gears: every speed by the meshes of its teeth, and the torques that hold it in
/// equilibrium.
#[test]
fn a_ravigneaux_set() {
    let data = reference("elements/ravigneaux.json");
    let columns: Vec<&str> =
        data["columns"].as_array().expect("columns").iter().filter_map(Value::as_str).collect();
    let members = ["small_sun", "large_sun", "carrier", "ring", "short_planet", "long_planet"];
    for row in data["rows"].as_array().expect("rows") {
        let column = |name: &str| {
            let place = columns.iter().position(|known| *known == name).expect("a column");
            row[place].as_f64().expect("a number")
        };
        let gear = row[0].as_str().expect("a gear");
        let (input, held) = match gear {
            "1" | "3" => ("small_sun", "carrier"),
            "2" => ("small_sun", "large_sun"),
            "4" => ("carrier", "large_sun"),
            _ => ("large_sun", "carrier"),
        };
        let held_angle = match gear {
            "3" => "small_sun.angle - carrier.angle".to_owned(),
            _ => format!("{held}.angle"),
        };
        let text = text("ravigneaux")
            .replace("$INPUT", input)
            .replace("$HELD", &held_angle)
            .replace("$RING", &format!("{:?}", column("w_ring")));
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let sample = at(&motion, 1.0);
        for member in members {
            let rate = match member {
                "short_planet" => "short_wheel.rate".to_owned(),
                "long_planet" => "long_wheel.rate".to_owned(),
                _ => format!("{member}.rate"),
            };
            let found = Measures::new(&mechanism, &[&rate]).at(sample)[0];
            let expected = column(&format!("w_{member}"));
            // The data have 14 digits.
            close(&format!("gear {gear}, {member}"), found, expected, within(1e-12 * 300.0));
        }
        // With the torque 1 on the input, the drive of the ring and the held member have theirs.
        let drive = sample.lambda[mechanism.system.n_bilateral() - 1];
        close(&format!("gear {gear}, ring"), drive, column("T_ring"), within(1e-9));
        let holding = -effort(&mechanism, sample, "held");
        if gear != "3" {
            close(&format!("gear {gear}, held"), holding, column("T_held"), within(1e-9));
        }
    }
}
