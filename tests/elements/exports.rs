//! Models as robot files: what is written reads back, and moves as before.

use bksim::import::{Exported, Format, export};

use crate::elements::imports::{at_start, check, text_of, without};
use crate::support::{coordinate, model};

/// The file that a model becomes.
#[track_caller]
fn written(text: &str, format: Format) -> Exported {
    export(model(text), format, &|_| String::new())
        .unwrap_or_else(|rejected| panic!("{rejected:?}"))
}

/// The text of a model after it was written as a robot file and read again.
#[track_caller]
fn there_and_back(text: &str, format: Format) -> String {
    text_of("robot", &written(text, format).text)
}

#[test]
fn mimic_joints_come_back_through_every_format() {
    let text = text_of("mimic.urdf", include_str!("../fixtures/import/mimic.urdf"));
    let knuckle = -0.231_764_767_202_34 / 0.010_968_016_939_638;
    for format in [Format::Urdf, Format::Mjcf, Format::Sdf] {
        check(
            &there_and_back(&text, format),
            "j_knuckle = { angle = 0.356011, rate = 0.717062 }\n\
             j_wheel = { angle = -0.740477, rate = 0.0985765 }",
            &[
                ("j_knuckle_angle", 0.356_011, knuckle),
                ("j_wheel_angle", -0.740_477, 0.0),
                ("j_middle_angle", 0.634_016_5, 1.5 * knuckle),
                ("j_tip_angle", 0.457_213_2, 1.2 * knuckle),
                ("j_slide_position", -0.014_240_44, -0.04 * knuckle),
            ],
        );
    }
}

#[test]
fn loops_come_back_as_equalities_and_as_second_joints() {
    let sdf = text_of("four_bar.sdf", include_str!("../fixtures/import/four_bar.sdf"));
    let expected = [
        ("A_angle", -0.05248, 56.986_695_879_147),
        ("B_angle", 0.078_341_064_899_59, -84.622_130_131_013),
        ("D_angle", 0.024_485_409_209_201, -24.654_145_269_419),
    ];
    for format in [Format::Mjcf, Format::Sdf] {
        let back = there_and_back(&sdf, format);
        let back = back.replace("[joints.C]\n", "[joints.C]\ncut = true\n");
        let back = back.replace("cut = true\ntype", "type").replace("cut = true\ncut", "cut");
        check(&back, "A = { angle = -0.05248, rate = 0.05686 }", &expected);
    }
    let mjcf = include_str!("../fixtures/import/four_bar_connect.xml");
    let mjcf = without(&text_of("four_bar.xml", mjcf), &["_damping", "_limit"]);
    check(
        &there_and_back(&mjcf, Format::Mjcf),
        "B = { angle = 0.359288, rate = -0.0869585 }",
        &[
            ("A_angle", -0.246_581_173_435_58, 73.442_149_354_603),
            ("B_angle", 0.359_288, -103.208_458_666_94),
            ("D_angle", 0.082_970_796_969_755, -12.436_736_182_46),
        ],
    );
    let urdf = written(&mjcf, Format::Urdf);
    assert!(urdf.left_out.iter().any(|(what, _)| what == "joint C, which closes a loop"));
    assert_eq!(urdf.faults[0].code.0, "I025");
}

#[test]
fn relations_come_back_as_polynomials_from_where_the_file_has_the_joints() {
    let text = text_of("gears.xml", include_str!("../fixtures/import/gears.xml"));
    check(
        &there_and_back(&without(&text, &["_spring"]), Format::Mjcf),
        "w2 = { angle = 0.40433, rate = 0.993595 }",
        &[
            ("w1_angle", -0.041_525_080_126_459, -3.558_950_455_567_8),
            ("w2_angle", 0.404_33, 9.078_960_565_085),
            ("s_position", 0.010_301_809_305_227, 0.477_422_885_247_37),
        ],
    );
}

/// Joints of several motions, frames that are turned, springs, a joint passed from its second body.
const MANY_MOTIONS: &str = r#"
name = "many"
space = "spatial"
coordinates = "relative"
[ground.points]
G = { at = [0.1, 0.2, 0.3], rpy = [0.3, -0.2, 0.5] }
[bodies.a]
mass = 2.0
com = [0.1, 0.02, -0.03]
inertia = [0.02, 0.03, 0.025, 0.001, -0.002, 0.0015]
points = { P = { at = [0.05, 0, 0.02], rpy = [0, 0.4, 0] }, Q = [0.2, 0.1, 0] }
[bodies.b]
mass = 1.5
com = [0.0, 0.1, 0.05]
inertia = [0.03, 0.01, 0.03]
points = { Q = [0.03, -0.02, 0.01], R = [0, 0.3, 0] }
[bodies.c]
mass = 1.0
com = [0.02, 0.0, 0.1]
inertia = [0.01, 0.012, 0.008]
points = { R = [0, 0, -0.05] }
[joints.J]
type = "cylindrical"
between = ["ground.G", "a.P"]
axis = [0, 0.6, 0.8]
[joints.K]
type = "universal"
between = ["a.Q", "b.Q"]
axis = [1, 0, 0]
second = [0, 1, 0]
[joints.L]
type = "revolute"
between = ["c.R", "b.R"]
axis = [0, 0.28, 0.96]
[loads.w]
type = "gravity"
acceleration = [0, 0, -9.81]
[loads.s]
type = "torsion"
joint = "L"
stiffness = 3
angle = 0.2
damping = 0.1
"#;

#[test]
fn joints_of_several_motions_become_several_joints() {
    let initial = [
        ("J", "position", 0.1, -0.3),
        ("J", "angle", 0.4, 0.7),
        ("K", "angle1", -0.3, 1.1),
        ("K", "angle2", 0.5, -0.6),
        ("L", "angle", 0.25, 0.9),
    ];
    let stated: Vec<String> = ["J", "K", "L"]
        .map(|joint| {
            let of = initial.iter().filter(|(of, ..)| *of == joint);
            let keys = of.flat_map(|(_, word, value, rate)| {
                let of_rate = word.replace("angle", "rate").replace("position", "velocity");
                [format!("{word} = {value}"), format!("{of_rate} = {rate}")]
            });
            format!("{joint} = {{ {} }}", keys.collect::<Vec<_>>().join(", "))
        })
        .to_vec();
    let (mechanism, _, accelerations) = at_start(MANY_MOTIONS, &stated.join("\n"));
    let expected =
        |joint: &str, word: &str| accelerations[coordinate(&mechanism, &format!("{joint}_{word}"))];
    for format in [Format::Mjcf, Format::Urdf] {
        let model = match format {
            // URDF has no springs.
            Format::Urdf => {
                let free = MANY_MOTIONS.replace("stiffness = 3", "stiffness = 0");
                there_and_back(&free, format)
                    + "[loads.again]\ntype = \"torsion\"\njoint = \"L\"\nstiffness = 3\nangle = 0.2\n"
            }
            _ => there_and_back(MANY_MOTIONS, format),
        };
        let named = |joint: &str, word: &str| match joint {
            "L" => ("L".to_owned(), word.to_owned()),
            _ => (format!("{joint}_{word}"), word.trim_end_matches(['1', '2']).to_owned()),
        };
        let initial_there: Vec<String> = initial
            .iter()
            .map(|(joint, word, value, rate)| {
                let (name, word) = named(joint, word);
                let of_rate = if word == "angle" { "rate" } else { "velocity" };
                format!("{name} = {{ {word} = {value}, {of_rate} = {rate} }}")
            })
            .collect();
        let wanted: Vec<(String, f64, f64)> = initial
            .iter()
            .map(|(joint, word, value, _)| {
                let (name, there) = named(joint, word);
                (format!("{name}_{there}"), *value, expected(joint, word))
            })
            .collect();
        let wanted: Vec<_> = wanted.iter().map(|(name, q, a)| (name.as_str(), *q, *a)).collect();
        check(&model, &initial_there.join("\n"), &wanted);
    }
}

#[test]
fn a_flat_model_moves_in_the_plane_of_a_robot_file() {
    let text = r#"
name = "flat"
[parameters]
drive_ctrl = 0
[bodies.crank]
mass = 1.2
com = [0.05, 0]
inertia = 0.003
points = { A = [0, 0], B = [0.1, 0] }
[bodies.rod]
mass = 0.8
com = [0.1, 0.01]
inertia = 0.004
points = { B = [0, 0], C = [0.3, 0] }
[bodies.slider]
mass = 2
inertia = 0.001
[joints.A]
type = "revolute"
between = ["ground", "crank.A"]
[joints.B]
type = "revolute"
between = ["crank.B", "rod.B"]
[joints.C]
type = "revolute"
between = ["rod.C", "slider"]
[joints.D]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
[loads.g]
type = "gravity"
acceleration = [0, -9.81]
[loads.back]
type = "spring"
between = ["ground", "rod.C"]
stiffness = 40
length = 0.1
[loads.motor]
type = "torque"
joint = "A"
value = "2.5 N m*drive_ctrl"
[io]
input = ["drive_ctrl"]
"#;
    let initial = "A = { angle = 0.7, rate = 2 }\nD = { guess = { position = 0.37 } }";
    let (mechanism, q, a) = at_start(&text.replace("ctrl = 0", "ctrl = 0.3"), initial);
    let [angle, slide] = ["A_angle", "D_position"].map(|name| coordinate(&mechanism, name));
    let at = format!("{text}[initial]\n{initial}\n");
    let back = there_and_back(&at, Format::Mjcf);
    assert!(back.contains("motor_ctrl = 0"), "{back}");
    let back = back.replace("motor_ctrl = 0", "motor_ctrl = 0.3");
    let expected = [("A_angle", q[angle], a[angle]), ("D_position", q[slide], a[slide])];
    check(&back, initial, &expected);
}

#[test]
fn what_a_format_cannot_hold_is_named() {
    let rejected = export(model(MANY_MOTIONS), Format::Sdf, &|_| String::new());
    let faults = rejected.expect_err("SDF has no cylindrical joints").0;
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(faults[0].code.0, "I024");
    assert!(faults[0].message.contains("`cylindrical`"), "{}", faults[0].message);
    assert!(faults[0].help.as_ref().is_some_and(|help| help.contains("MJCF")));
}
