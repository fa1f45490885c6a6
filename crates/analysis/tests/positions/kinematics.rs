//! Positions, velocities and accelerations over a range against references of 15 digits.

use crate::support::{Problem, compare, geometry};
use bksim_analysis::{Drive, Prescribed, kinematics};

/// Follows the crank over the angles of the reference, with its rate and acceleration.
fn follows(name: &str, tolerance: f64) {
    let problem = Problem::load(name);
    let rows = problem.rows();
    let model = problem.model();
    let values = format!("{}:{}:{}", rows[0][0], rows[rows.len() - 1][0], rows.len());
    let mut drive = Drive::parse(&model, "crank.angle", &values).expect("a drive");
    (drive.rate, drive.acceleration) = (3.7, -2.1);
    let prescribed = Prescribed::Drives { drives: vec![drive], through: false };
    let found = kinematics(model, &prescribed).expect("the range is followed");
    assert_eq!(found.stopped, None, "{name}: {} rows", found.table.rows.len());
    compare(&found.table, &problem.columns(), &rows, tolerance);
}

#[test]
fn crank_rocker() {
    follows("kin-crank-rocker", 1e-10);
}

#[test]
fn double_rocker_within_its_range() {
    follows("kin-double-rocker", 1e-10);
}

#[test]
fn drag_link() {
    follows("kin-drag-link", 1e-10);
}

#[test]
fn quick_return_with_a_slot() {
    follows("kin-whitworth", 1e-10);
}

#[test]
fn six_bar() {
    follows("kin-stephenson", 1e-10);
}

#[test]
fn crossed_parallelogram_between_its_change_points() {
    follows("kin-antiparallelogram", 1e-9);
}

/// A jack of two slides: what drives is named as among all quantities, and is told once.
#[test]
fn columns_of_a_drive_have_the_names_of_its_motion() {
    let jack = "[ground]\npoints = { H = [0.3, -0.2] }\n\
        [bodies.boom]\npoints = { K = [0.6, 0.1] }\n[bodies.cylinder]\n[bodies.rod]\n\
        [joints]\nO = { type = \"revolute\", between = [\"ground\", \"boom\"] }\n\
        H = { type = \"revolute\", between = [\"ground.H\", \"cylinder\"] }\n\
        guide = { type = \"prismatic\", between = [\"cylinder\", \"rod\"], axis = [1, 0] }\n\
        K = { type = \"revolute\", between = [\"rod\", \"boom.K\"] }\n\
        [initial]\nO = { guess = { angle = 0.5 } }\nguide = { guess = { position = 0.5 } }\n\
        H = { guess = { angle = 1.0 } }\n";
    for (drive, expected) in [
        ("guide.position", ["guide.position", "guide.velocity", "guide.acceleration"]),
        ("boom.K.y", ["boom.K.y", "boom.K.vy", "boom.K.ay"]),
        ("boom.angle", ["boom.angle", "boom.rate", "boom.acceleration"]),
    ] {
        let model = geometry(jack);
        let drive =
            Drive { rate: 0.1, ..Drive::parse(&model, drive, "0.5:0.52").expect("a drive") };
        let prescribed = Prescribed::Drives { drives: vec![drive], through: false };
        let found = kinematics(model, &prescribed).expect("the range is followed");
        let names: Vec<&str> = found.table.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names[..3], expected);
        let mut once = names.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), names.len(), "{names:?}");
    }
}

/// The rod between a crank's point at 30° and a block at 1.2 m: its length is the distance of the two.
#[test]
fn a_length_is_found_with_which_the_start_closes() {
    let text = |length: &str, stated: &str| {
        format!(
            "[parameters]\nL = {length}\nhalf = \"L/2\"\n[bodies]\ncrank = {{ points = {{ A = [0.5, 0.1] }} }}\nblock = {{}}\n\
             [joints]\nO = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
             guide = {{ type = \"prismatic\", between = [\"ground\", \"block\"], axis = [1, 0] }}\n\
             rod = {{ type = \"link\", between = [\"crank.A\", \"block\"], length = \"2*half\" }}\n\
             [initial]\nO = {{ angle = \"30 deg\" }}\n{stated}"
        )
    };
    let angle = 30.0_f64.to_radians();
    let (x, y) = (0.5 * angle.cos() - 0.1 * angle.sin(), 0.5 * angle.sin() + 0.1 * angle.cos());
    let expected = (1.2 - x).hypot(y);
    let names = ["L".to_owned()];
    for length in ["1", "0.3", "5"] {
        let model = geometry(&text(length, "guide = { position = 1.2 }\n"));
        let found = bksim_analysis::closing(model, &names).expect("a length");
        assert!((found.values[0].1 - expected).abs() < 1e-12, "{:?} from {length}", found.values);
        let place = found.pose.iter().find(|(name, ..)| name == "guide.position").expect("a place");
        assert!((place.1 - 1.2).abs() < 1e-12);
    }
    let fault = bksim_analysis::closing(geometry(&text("1", "")), &names).expect_err("open");
    assert_eq!(
        fault.to_string(),
        "the start closes with many values of `L`: 1 motion or parameter is left free"
    );
}

/// An arm about y swings through the pitch of 90°: its orientation is among the columns, with rates that stay finite, and
/// so is an output, one without a value in a pose.
#[test]
fn orientations_signals_and_outputs_are_columns() {
    let text = "space = \"spatial\"\n[bodies.arm]\npoints = { tip = [0.5, 0, 0] }\n\
        [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\naxis = [0, 1, 0]\n\
        [signals.u]\nvalue = \"2*A.angle\"\n\
        [outputs]\nheight = \"arm.tip.z\"\nspeed = \"sqrt(arm.tip.vx^2 + arm.tip.vz^2)\"\npole = \"1 m/arm.tip.z\"\n\
        force = \"reactions.A.fx\"\n[initial]\nA = { angle = 0 }\n";
    let model = geometry(text);
    let mut drive = Drive::parse(&model, "A.angle", "0:120 deg:5").expect("a drive");
    (drive.rate, drive.acceleration) = (3.0, -2.0);
    let prescribed = Prescribed::Drives { drives: vec![drive], through: false };
    let table = kinematics(model, &prescribed).expect("the range is followed").table;
    let column = |name: &str| table.columns.iter().position(|column| column.name == name);
    for (row, degrees) in table.rows.iter().zip([0.0_f64, 30.0, 60.0, 90.0, 120.0]) {
        let angle = degrees.to_radians();
        let value = |name: &str| row[column(name).unwrap_or_else(|| panic!("no column {name}"))];
        let pitch = if degrees > 90.0 { std::f64::consts::PI - angle } else { angle };
        for (name, expected) in [
            ("arm.pitch", pitch),
            ("arm.wy", 3.0),
            ("arm.aly", -2.0),
            ("arm.wx", 0.0),
            ("signals.u", 2.0 * angle),
            ("outputs.height", -0.5 * angle.sin()),
            ("outputs.speed", 1.5),
        ] {
            let found = value(name);
            assert!(
                (found - expected).abs() < 1e-12,
                "{name} at {degrees}: {found} for {expected}"
            );
        }
        assert_eq!(value("outputs.pole").is_finite(), degrees > 0.0);
    }
    assert_eq!(column("outputs.force"), None, "a force follows from no position");
}
