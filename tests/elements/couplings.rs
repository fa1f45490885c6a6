//! Gears, belts, racks, screws and relations against reference motions, statics by hand, and the same
//! mechanism in other coordinates.

use serde_json::Value;

use crate::support::elements::Quantity::{Acceleration, Coupling, Measure, Reaction};
use crate::support::elements::{Quantity, check, effort, reference, text};
use crate::support::{Measures, Within, at, close, derive, model, solve};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
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
    check(&text("belt-open"), "elements/belt_open", &BELT);
    // In absolute coordinates the angles are those of the bodies.
    let absolute = format!("coordinates = \"absolute\"\n{}", text("belt-open"));
    let kept = BELT.map(|(column, quantity)| match quantity {
        Acceleration("A_angle", _) => (column, Acceleration("p1_angle", 1.0)),
        Acceleration("B_angle", _) => (column, Acceleration("p2_angle", 1.0)),
        other => (column, other),
    });
    check(&absolute, "elements/belt_open", &kept);
}

#[test]
fn a_crossed_belt() {
    // The tight strand turns the second pulley backwards.
    let crossed = BELT.map(|(column, quantity)| match quantity {
        Coupling(name, factor) => (column, Coupling(name, -factor)),
        other => (column, other),
    });
    check(&text("belt-crossed"), "elements/belt_crossed", &crossed);
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
    check(&text("internal-pair"), "elements/internal_pair", &columns);

    // With cut bearings, their multipliers are the reactions.
    let absolute = format!("coordinates = \"absolute\"\n{}", text("internal-pair"));
    let kept = columns.map(|(column, quantity)| match quantity {
        Acceleration("P_angle", _) => (column, Acceleration("pinion_angle", 1.0)),
        Acceleration("R_angle", _) => (column, Acceleration("ring_angle", 1.0)),
        other => (column, other),
    });
    check(&absolute, "elements/internal_pair", &kept);
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
    check(&text("cardan-circles"), "elements/cardan_circles", &columns);
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
    check(&text("differential"), "elements/differential", &columns);
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
    check(&text("bevel-pair"), "elements/bevel_pair", &columns);
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
    check(&text("chain-hoist"), "elements/chain_hoist", &columns);
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
    check(&text("rack-pinion"), "spatial/rack_pinion", &columns);
}

/// The Ravigneaux set in its five gears: every speed by the meshes of its teeth, and the torques that hold it in
/// equilibrium.
#[test]
fn a_ravigneaux_set() {
    let data = reference("elements/ravigneaux");
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
