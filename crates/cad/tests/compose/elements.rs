//! Couplings, curves, tables and controllers of drawings.

use bksim_cad::compose::ComposeOptions;

use super::sheet::Sheet;
use super::{assert_close, codes, model_of};

/// Two wheels on pins that are one unit apart.
fn two_wheels() -> Sheet {
    let mut sheet = Sheet::default();
    for (layer, x, radius) in [("BK_BODY_pinion", 0.0, 0.4), ("BK_BODY_wheel", 1.0, 0.6)] {
        sheet.circle(layer, [x, 0.0], radius);
    }
    for (name, x) in [("A", 0.0), ("B", 1.0)] {
        sheet.insert("BK_REVOLUTE", [x, 0.0], 0.0, &[("NAME", name)]);
    }
    for name in ["pinion", "wheel"] {
        sheet.insert(
            "BK_BODY",
            [9.0, 9.0],
            0.0,
            &[("NAME", name), ("MASS", "1 kg"), ("INERTIA", "1")],
        );
    }
    sheet
}

#[test]
fn gears_are_at_the_pins_that_they_are_drawn_between_and_lists_are_as_people_type_them() {
    let mut sheet = two_wheels();
    let sheets = [3.0, 3.0];
    sheet.insert(
        "BK_GEAR",
        [0.0, 0.0],
        0.0,
        &[("NAME", "mesh"), ("TEETH", "20, 30"), ("INTERNAL", "no")],
    );
    sheet.insert(
        "BK_TABLE",
        sheets,
        0.0,
        &[
            ("NAME", "drag"),
            ("POINTS", "0, 0; 1 rad/s, 2 N m; 5 rad/s, 3 N m"),
            ("EXTRAPOLATE", "linear"),
        ],
    );
    let formula = [("NAME", "track"), ("FORMULA", "0.5 m*max(p, 1), 0"), ("RANGE", "0, 1")];
    sheet.insert("BK_CURVE", sheets, 0.0, &formula);
    sheet.insert(
        "BK_STATE",
        sheets,
        0.0,
        &[("NAME", "e"), ("RATE", "1 - A.angle"), ("START", "0.5 s")],
    );
    sheet.insert("BK_CLOCK", sheets, 0.0, &[("NAME", "tick"), ("EVERY", "10 ms")]);
    sheet.insert("BK_SIGNAL", sheets, 0.0, &[("NAME", "u"), ("VALUE", "2 N m/s*e")]);
    let motor = [("NAME", "motor"), ("JOINT", "A"), ("VALUE", "u - drag(abs(A.rate))")];
    sheet.insert("BK_TORQUE", sheets, 0.0, &motor);
    sheet.insert(
        "BK_PART",
        sheets,
        0.0,
        &[("NAME", "dc"), ("PART", "dc-motor"), ("WITH", "R = 2 ohm; n = 3")],
    );
    let composition = sheet.compose(ComposeOptions::default());
    for line in [
        "between = [\"A\", \"B\"]",
        "teeth = [20, 30]",
        "internal = false",
        "points = [[0, 0], [\"1 rad/s\", \"2 N m\"], [\"5 rad/s\", \"3 N m\"]]",
        "type = \"formula\"\nformula = [\"0.5 m*max(p, 1)\", 0]",
        "[states.e]",
        "every = \"10 ms\"",
        "[use.dc]\npart = \"dc-motor\"\nwith = { R = \"2 ohm\", n = 3 }",
    ] {
        assert!(
            composition.text.contains(line),
            "{line} in\n{}\n{:?}",
            composition.text,
            composition.diagnostics
        );
    }
}

#[test]
fn rows_of_a_long_table_go_on_in_blocks_of_its_name() {
    let drawn = |further: &[&[(&str, &str)]]| {
        let mut sheet = two_wheels();
        let places = [3.0, 3.0];
        sheet.insert("BK_GEAR", [0.0, 0.0], 0.0, &[("NAME", "mesh"), ("TEETH", "20, 30")]);
        let head = [("NAME", "drag"), ("POINTS", "0, 0; 1, 2"), ("UNITS", "rad/s, N m")];
        sheet.insert("BK_TABLE", places, 0.0, &head);
        for values in further {
            sheet.insert("BK_TABLE", places, 0.0, values);
        }
        sheet.compose(ComposeOptions::default())
    };
    let rows = ["2, 3; 3, 5", "[[4, 6]]"].map(|rows| [("NAME", "drag"), ("POINTS", rows)]);
    let composition = drawn(&[&rows[0], &rows[1]]);
    let expected = "points = [[0, 0], [1, 2], [2, 3], [3, 5], [4, 6]]";
    assert!(composition.text.contains(expected), "{}", composition.text);
    assert!(codes(&composition).is_empty(), "{:?}", composition.diagnostics);
    // One that says more is another table.
    let other = [("NAME", "drag"), ("POINTS", "2, 3"), ("EXTRAPOLATE", "linear")];
    assert_eq!(codes(&drawn(&[&other])), ["D034"]);
}

/// The teeth of a drawn pair rub, whatever joint is near.
#[test]
fn friction_of_teeth_names_its_coupling() {
    let mut sheet = two_wheels();
    sheet.insert("BK_GEAR", [0.0, 0.0], 0.0, &[("NAME", "mesh"), ("TEETH", "20, 30")]);
    let rub = [("NAME", "rub"), ("COUPLING", "mesh"), ("MU", "0.06"), ("PRESSURE_ANGLE", "20 deg")];
    sheet.insert("BK_FRICTION", [0.0, 0.0], 0.0, &rub);
    let composition = sheet.compose(ComposeOptions::default());
    let model = model_of(&composition);
    let rubs =
        |load: &bksim_model::Load| matches!(load.kind, bksim_model::LoadKind::Friction { .. });
    assert!(model.loads.iter().any(rubs), "{}", composition.text);
    assert!(!composition.text.contains("joint ="), "{}", composition.text);
}

#[test]
fn a_gear_that_ends_at_no_pin_asks_for_its_joints() {
    let mut sheet = two_wheels();
    sheet.insert("BK_GEAR", [0.0, 0.5], 0.0, &[("TEETH", "20, 30")]);
    sheet.insert("BK_STATE", [3.0, 3.0], 0.0, &[("RATE", "1")]);
    let composition = sheet.compose(ComposeOptions::default());
    assert_eq!(codes(&composition), ["D039", "D039", "D033"]);
    let help = composition.diagnostics[0].help.as_deref().unwrap_or_default();
    assert!(help.contains("`between=…`"), "{help}");
}

/// A curve is drawn where its body is: on the arm, which leans by 90°, and seen from the point of the joint.
#[test]
fn geometry_on_the_layer_of_a_curve_is_what_a_joint_follows() {
    let mut sheet = Sheet::default();
    sheet.bar("BK_BODY_arm", [0.0, 0.0], [0.0, 100.0], 5.0);
    sheet.insert("BK_REVOLUTE", [0.0, 0.0], 0.0, &[("NAME", "A")]);
    sheet.insert("BK_FRAME", [0.0, 0.0], std::f64::consts::FRAC_PI_2, &[("BODY", "arm")]);
    sheet.circle("BK_BODY_bead", [30.0, 60.0], 2.0);
    for body in ["arm", "bead"] {
        sheet.insert(
            "BK_BODY",
            [900.0, 900.0],
            0.0,
            &[("NAME", body), ("MASS", "1 kg"), ("INERTIA", "1")],
        );
    }
    sheet.circle("BK_CURVE_ring", [0.0, 60.0], 30.0);
    sheet.insert(
        "BK_POINT_ON_CURVE",
        [0.0, 0.0],
        0.0,
        &[
            ("NAME", "slide"),
            ("CURVE", "ring"),
            ("BODY1", "arm"),
            ("POINT1", "A"),
            ("BODY2", "bead"),
        ],
    );
    let composition = sheet.compose(ComposeOptions::default());
    let model = model_of(&composition);
    let curve = &model.curves[0];
    assert_eq!(curve.name, "ring");
    let at = |p: f64| {
        let value = |symbol| (symbol == curve.parameter).then_some(p);
        curve.position.map(|e| model.pool.evaluate(e, &value).expect("a number"))
    };
    // The frame of the arm points up the arm: the centre is on its x axis.
    for p in [0.0, 1.0, 4.0] {
        let [x, y, _] = at(p);
        assert_close((x - 0.06).hypot(y), 0.03, 1e-9);
    }
    let [before, after] = [at(0.0), at(0.1)];
    let turn = (before[0] - 0.06) * after[1] - before[1] * (after[0] - 0.06);
    assert!(turn > 0.0, "it goes around as it is drawn");
}
