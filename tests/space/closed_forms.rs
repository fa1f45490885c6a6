//! Mechanisms in space against closed forms: a four-bar with ball joints, and a platform on six legs; frames, and
//! faults of starts.

use crate::support::{Within, at, close, coordinate, derive, model, path, solve};
use bksim::model::file::{Source, read};
use serde_json::Value;

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
    let text = include_str!("../fixtures/rssr.toml");
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
        ("a link", include_str!("../fixtures/rssr.toml").to_owned()),
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
    let mechanism = derive(model(include_str!("../fixtures/stewart.toml")));
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

/// The code and the notes of the fault of a start.
fn fault(text: &str) -> (&'static str, String) {
    match derive(model(text)).solve() {
        Ok(_) => ("", String::from("there is a motion")),
        Err(rejected) => (rejected.0[0].code.0, rejected.0[0].notes.join("; ")),
    }
}

#[test]
fn a_rod_that_spins_between_two_balls_is_told_with_them() {
    let ball = "type = \"spherical\"";
    let text = with_coupler(ball, ball).replace("[0.001, 0.02, 0.02]", "[0, 0.02, 0.02]");
    let (code, notes) = fault(&text);
    assert_eq!(code, "S005");
    assert!(notes.contains("between the ball joints `A` and `B` it spins"), "{notes}");
    // A cross at one end holds it.
    let cross = "type = \"universal\"\naxis = [0, 0, 1]\nsecond = [0, 1, 0]";
    let held = with_coupler(cross, ball).replace("[0.001, 0.02, 0.02]", "[0, 0.02, 0.02]");
    solve(&derive(model(&held)));
}

/// A mass on a thread: no turn about the thread has inertia, and the help gives it some.
#[test]
fn a_mass_without_moments_on_a_ball_is_told_about_which_line() {
    let text = "[bodies.bob]\nmass = 1\ncom = [0, 0, -1]\ninertia = [0, 0, 0]\n\
                [joints.A]\ntype = \"spherical\"\nbetween = [\"ground\", \"bob\"]\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n[solve]\nt_end = 0.1\n";
    let rejected = derive(model(text)).solve().expect_err("no inertia");
    let help = rejected.0[0].help.clone().unwrap_or_default();
    assert_eq!(rejected.0[0].code.0, "S005");
    assert!(help.contains("the line through `A` and its centre of mass"), "{help}");
    let cure = help.split('`').find(|part| part.starts_with("inertia = ")).expect("a cure");
    solve(&derive(model(&text.replace("inertia = [0, 0, 0]", cure))));
}

/// A rod on a hinge or ball whose other end is welded to the ground in a frame turned by these angles.
fn welded_rod(hinge: &str, rpy: &str) -> String {
    format!(
        "space = \"spatial\"\n[ground.points]\nA = [0, 0, 0]\nB = {{ at = [1, 0, 0], rpy = {rpy} }}\n\
         [bodies.rod]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n\
         points = {{ A = [0, 0, 0], B = [1, 0, 0] }}\n\
         [joints.A]\ntype = \"{hinge}\"\nbetween = [\"ground.A\", \"rod.A\"]\n\
         [joints.B]\ntype = \"weld\"\nbetween = [\"ground.B\", \"rod.B\"]\ncut = true\n\
         [solve]\nt_end = 0.1\n"
    )
}

#[test]
fn a_weld_that_closes_only_turned_over_says_so() {
    let turned = ["[\"180 deg\", 0, 0]", "[0, 0, \"180 deg\"]"];
    for (hinge, rpy) in [("revolute", turned[0]), ("spherical", turned[1])] {
        let (code, notes) = fault(&welded_rod(hinge, rpy));
        assert_eq!(code, "S001", "{hinge}");
        assert!(notes.contains("turned by 180°"), "{hinge}: {notes}");
    }
    solve(&derive(model(&welded_rod("spherical", "[0, 0, 0]"))));
}

/// Hinges whose axes point opposite ways whatever the angle is, so that their rows hold by form.
#[test]
fn hinges_with_opposite_axes_do_not_close() {
    let hinged = |rpy: &str| welded_rod("revolute", rpy).replace("\"weld\"", "\"revolute\"");
    let (code, notes) = fault(&hinged("[\"180 deg\", 0, 0]"));
    assert_eq!(code, "S001");
    assert!(notes.contains("180°"), "{notes}");
    solve(&derive(model(&hinged("[0, 0, 0]"))));
}

#[test]
fn axes_that_are_not_quite_parallel_are_named_with_their_angle() {
    let bar = |name: &str, length: f64| {
        format!(
            "[bodies.{name}]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\npoints.E = [{length}, 0, 0]\n"
        )
    };
    let joint = |name: &str, from: &str, to: &str, axis: &str| {
        format!(
            "[joints.{name}]\ntype = \"revolute\"\nbetween = [\"{from}\", \"{to}\"]\naxis = {axis}\n"
        )
    };
    let text = |axis: &str| {
        "space = \"spatial\"\n[ground.points]\nD = [1, 0, 0]\n".to_owned()
            + &bar("crank", 0.3)
            + &bar("coupler", 0.9)
            + &bar("rocker", 0.7)
            + &joint("A", "ground", "crank", "[0, 0, 1]")
            + &joint("B", "crank.E", "coupler", "[0, 0, 1]")
            + &joint("C", "coupler.E", "rocker.E", axis)
            + &joint("D", "ground.D", "rocker", "[0, 0, 1]")
            + "[initial]\nA = { guess = { angle = \"60 deg\" } }\nD = { guess = { angle = \"100 deg\" } }\n\
               [solve]\nt_end = 0.1\n"
    };
    let (code, notes) = fault(&text("[0, 0.01, 1]"));
    assert_eq!(code, "S001");
    assert!(notes.contains("`B` and `C` are 0.573°") && notes.contains("`spherical`"), "{notes}");
    solve(&derive(model(&text("[0, 0, 1]"))));
}

#[test]
fn a_frame_is_the_same_in_each_way_of_writing_it() {
    // Angles, the quaternion of their rotation, two of its axes; the second at the pole of the angles.
    let (w, x) = (0.5_f64.sqrt(), 0.3_f64);
    let cases = [
        (
            "[\"90 deg\", 0, \"90 deg\"]",
            "[0.5, 0.5, 0.5, 0.5]".to_owned(),
            "x = [0, 2, 0], z = [3, 0, 0]",
        ),
        ("[0, \"90 deg\", 0]", format!("[{w:?}, 0, {w:?}, 0]"), "y = [0, 1, 0], z = [1, 0, 0]"),
        (
            "[0.6, 0, 0]",
            format!("[{:?}, {:?}, 0, 0]", x.cos(), x.sin()),
            "x = [1, 0, 0], y = [0, \"cos(0.6)\", \"sin(0.6)\"]",
        ),
    ];
    for (rpy, quaternion, axes) in &cases {
        for way in [format!("quaternion = {quaternion}"), (*axes).to_owned()] {
            let text = format!(
                "space = \"spatial\"\n[ground.points]\nA = {{ at = [0, 0, 0], rpy = {rpy} }}\n\
                 [bodies.b]\nmass = 1\ninertia = [1, 1, 1]\n\
                 points.A = {{ at = [0, 0, 0], {way} }}\n\
                 [joints.j]\ntype = \"revolute\"\nbetween = [\"ground.A\", \"b.A\"]\n\
                 [solve]\nt_end = 0.1\n"
            );
            let mechanism = derive(model(&text));
            let poses = bksim::sim::pose::Poses::compile(&mechanism.model, &mechanism.system);
            let state = [(&[0.0][..], &[0.0][..])];
            let poses = poses.expect("poses").at(&mechanism.parameters, state);
            for (i, row) in poses[0][1].r_world_from_body.iter().enumerate() {
                for (j, &entry) in row.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    let within = Within { relative: 0.0, absolute: 1e-15 };
                    close(&format!("{rpy} against {way}, [{i}][{j}]"), entry, expected, within);
                }
            }
        }
    }
}

/// A ball joint with named angles that starts at the pole of them says so, and not that a mass is missing.
#[test]
fn a_start_at_the_pole_of_named_angles_says_so() {
    let text = |names: &str| {
        format!(
            "space = \"spatial\"\n[bodies.a]\nmass = 1\ninertia = [0.1, 0.2, 0.3]\n\
             [joints.j]\ntype = \"spherical\"\nbetween = [\"ground\", \"a\"]\n{names}\n\
             [initial]\nj = {{ angle1 = 0.1, angle2 = \"90 deg\", angle3 = 0 }}\n[solve]\nt_end = 0.1\n"
        )
    };
    let (code, notes) = fault(&text("coordinate = [\"u\", \"v\", \"w\"]"));
    assert_eq!(code, "R013");
    assert!(notes.contains("`v` is 90 deg there"), "{notes}");
    // Without names it has no pole, but the angles that state the start have one; the orientation of the body has not.
    assert_eq!(fault(&text("")).0, "R013");
    let turned = text("").replace(
        "j = { angle1 = 0.1, angle2 = \"90 deg\", angle3 = 0 }",
        "a = { rpy = [0, \"90 deg\", 0], w = [0.1, 2, 0.3] }",
    );
    solve(&derive(model(&turned)));
}

/// The text that the help of a bad frame suggests is a frame.
#[test]
fn helps_of_frames_work_as_they_are_written() {
    let text = |axes: &str| {
        format!(
            "space = \"spatial\"\n[bodies.a]\nmass = 1\ninertia = [1, 1, 1]\n\
             points = {{ P = {{ at = [0, 0, 1], {axes} }} }}\n\
             [joints.j]\ntype = \"revolute\"\nbetween = [\"ground\", \"a.P\"]\n"
        )
    };
    let cases = [
        "x = [1, 2, 2], y = [1, 0, 0]",
        "x = [1, 0, 0], y = [2, 0, 0]",
        "x = [0.3, -0.7, 0.2], z = [0.3, -0.7, 0.2]",
        "y = [0, 0, 0], z = [0, 1, 0]",
        "x = [0, 0, 5], z = [0, 0, 0]",
    ];
    for axes in cases {
        let faults = read(&Source::new(&text(axes), "frame")).diagnostics;
        let help = faults[0].help.clone().unwrap_or_default();
        let written = help.split('`').nth(1).unwrap_or_else(|| panic!("{axes}: {help}"));
        let (key, _) = written.split_once(" = ").unwrap_or_else(|| panic!("{axes}: {written}"));
        let kept: Vec<&str> =
            axes.split_inclusive(']').map(|axis| axis.trim_start_matches([',', ' '])).collect();
        let cured: Vec<&str> =
            kept.iter().map(|axis| if axis.starts_with(key) { written } else { axis }).collect();
        let reading = read(&Source::new(&text(&cured.join(", ")), "frame"));
        assert!(reading.model.is_some(), "{axes}: `{written}` gives {:?}", reading.diagnostics);
    }
}
