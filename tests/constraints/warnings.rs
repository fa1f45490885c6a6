//! Warnings about starts and about models that are hardly meant; and none about sound ones.

use std::fs;
use std::path::Path;

use bksim::Mechanism;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, expand};
use bksim::sim::mobility::mobility;

/// The text of a model with its elements that repeat.
fn whole(text: &str) -> String {
    let mut none = |file: &str| Err(format!("there is no {file}"));
    expand("model.toml", text, Limits::default(), &mut none)
        .map_or_else(|| text.to_owned(), |expansion| expansion.text)
}

/// All warnings about the start of a model.
fn warnings_of(text: &str) -> Vec<Diagnostic> {
    let mechanism = Mechanism::from_toml(&whole(text), "model").expect("a model");
    let start = mechanism.start().expect("a start");
    let found = mobility(&mechanism.model, &mechanism.system, &start);
    mechanism.warnings_of(&start, &found, mechanism.warnings.clone())
}

fn codes_of(text: &str) -> Vec<&'static str> {
    warnings_of(text).iter().map(|warning| warning.code.0).collect()
}

/// The fault of a start.
fn refused(text: &str) -> Diagnostic {
    let mechanism = Mechanism::from_toml(text, "model").expect("a model");
    let mut faults = mechanism.start().expect_err("no start").0;
    assert_eq!(faults.len(), 1, "{faults:?}");
    faults.remove(0)
}

const CRANK: &str = "[bodies.crank]\nmass = 1\ninertia = 0.1\n[joints.A]\ntype = \"revolute\"\n\
                     between = [\"ground\", \"crank\"]\n";

#[test]
fn a_drive_that_holds_a_stated_value_is_named() {
    let text = format!(
        "{CRANK}[drives.motor]\njoint = \"A\"\nmotion = \"60 rpm*t\"\n[initial]\nA = {{ angle = \"60 deg\" }}\n"
    );
    let fault = refused(&text);
    assert_eq!(fault.code.0, "S002");
    assert_eq!(
        fault.message,
        "drive `motor` holds `A.angle` at 0 deg (0 rad) at the start, and it is stated as 60 deg (1.0472 rad)"
    );
    assert_eq!(fault.labels.len(), 2);
    assert_eq!(&text[fault.labels[1].span.clone()], "60 rpm*t");
    // The help, followed: the value goes, or the drive begins there.
    let removed = text.replace("A = { angle = \"60 deg\" }", "");
    assert!(Mechanism::from_toml(&removed, "model").expect("a model").start().is_ok());
    let added = text.replace("60 rpm*t", "60 deg + 60 rpm*t");
    assert!(Mechanism::from_toml(&added, "model").expect("a model").start().is_ok());
}

/// A four-bar with two drives.
fn two_drives(motions: [&str; 2]) -> String {
    let [a, d] = motions;
    format!(
        "[ground]\npoints = {{ A = [0, 0], D = [3, 0] }}\n[bodies]\n\
         crank = {{ mass = 1, inertia = 0.1, points = {{ B = [1, 0] }} }}\n\
         coupler = {{ mass = 1, inertia = 0.1, points = {{ C = [3, 0] }} }}\n\
         rocker = {{ mass = 1, inertia = 0.1, points = {{ C = [2, 0] }} }}\n[joints]\n\
         A = {{ type = \"revolute\", between = [\"ground.A\", \"crank\"] }}\n\
         B = {{ type = \"revolute\", between = [\"crank.B\", \"coupler\"] }}\n\
         C = {{ type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }}\n\
         D = {{ type = \"revolute\", between = [\"ground.D\", \"rocker\"] }}\n[drives]\n\
         left = {{ joint = \"A\", motion = \"{a}\" }}\nright = {{ joint = \"D\", motion = \"{d}\" }}\n\
         [initial]\nD = {{ guess = {{ angle = \"100 deg\" }} }}\n"
    )
}

#[test]
fn two_drives_of_one_freedom_name_each_other() {
    let fault = refused(&two_drives(["60 deg + 1 rad/s*t", "10 deg + 2 rad/s*t"]));
    assert!(fault.message.contains("`left`") && fault.message.contains("`right`"), "{fault:?}");
    assert!(fault.message.contains("the one freedom"), "{fault:?}");
    let help = fault.help.expect("a help");
    assert!(help.starts_with("remove `[drives."), "{help}");
}

/// A crank in line with its rod, and a force on the ram.
fn press(angle: &str, force: &str) -> String {
    format!(
        "[bodies]\ncrank = {{ mass = 2, inertia = 0.01, points = {{ A = [0.1, 0] }} }}\n\
         rod = {{ mass = 1, inertia = 0.015, com = [0.2, 0], points = {{ B = [0.4, 0] }} }}\nram = {{ mass = 5 }}\n[joints]\n\
         O = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
         A = {{ type = \"revolute\", between = [\"crank.A\", \"rod\"] }}\n\
         B = {{ type = \"revolute\", between = [\"rod.B\", \"ram\"] }}\n\
         guide = {{ type = \"prismatic\", between = [\"ground\", \"ram\"], axis = [1, 0] }}\n[loads]\n\
         pressing = {{ type = \"force\", on = \"ram\", vector = [\"{force}\", 0] }}\n[initial]\n\
         O = {{ angle = \"{angle}\", rate = 0 }}\n"
    )
}

#[test]
fn a_dead_centre_at_rest_is_told_where_the_loads_would_leave_it() {
    assert_eq!(codes_of(&press("0 deg", "-500 N")), ["S028"]);
    // Pulled outwards the same pose is stable, and off the dead centre there is motion.
    assert_eq!(codes_of(&press("0 deg", "500 N")), [""; 0]);
    assert_eq!(codes_of(&press("1 deg", "-500 N")), [""; 0]);
}

#[test]
fn a_rate_that_jumps_is_told_with_its_instant_and_rates() {
    let drive = |motion: &str| {
        format!(
            "[bodies.cart]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\naxis = [1, 0]\n\
             [drives.d]\njoint = \"S\"\nmotion = \"{motion}\"\n[solve]\nt_end = 2\n"
        )
    };
    let found = warnings_of(&drive("min(0.08 m/s*t, 0.04 m)"));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].message, "the rate of drive `d` jumps from 0.08 m/s to 0 m/s at t = 0.5 s");
    for smooth in [
        "0.1 m*sin(3 rad/s*t)",
        "max(0 m, 0.1 m/s^2*(t - 1 s)*abs(t - 1 s))",
        "0.1 m*abs(sin(3 rad/s*t))^3",
    ] {
        assert_eq!(codes_of(&drive(smooth)), [""; 0], "{smooth}");
    }
}

/// A corner exactly at the start is none of the motion, and hides no later one.
#[test]
fn a_corner_at_the_start_is_no_jump() {
    let jumps = |t_end: &str| -> Vec<String> {
        let text = format!(
            "[bodies.cart]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\naxis = [1, 0]\n\
             [drives.d]\njoint = \"S\"\nmotion = \"0.1 m*abs(sin(2 rad/s*t))\"\n[solve]\nt_end = {t_end}\n"
        );
        let found = warnings_of(&text).into_iter().filter(|warning| warning.code.0 == "S029");
        found.map(|warning| warning.message).collect()
    };
    assert_eq!(jumps("1"), [""; 0]);
    let later = jumps("2");
    assert_eq!(later.len(), 1, "{later:?}");
    assert!(later[0].contains("from -0.2 m/s to 0.2 m/s at t = 1.57"), "{later:?}");
}

#[test]
fn lengths_in_time_move_what_has_no_freedom_left() {
    let text = "[ground]\npoints = { A = [0, 0] }\n[bodies.cart]\nmass = 1\n[joints]\n\
                S = { type = \"prismatic\", between = [\"ground\", \"cart\"], axis = [1, 0] }\n\
                ram = { type = \"link\", between = [\"ground.A\", \"cart\"], length = \"0.2 m + 0.1 m/s*t\" }\n\
                [initial]\nS = { guess = { position = 0.2 } }\n";
    assert_eq!(codes_of(text), [""; 0]);
}

/// Three arms with rods of their own: guesses that no assembly meets exactly are as near in many places of one motion.
#[test]
fn a_neighbour_on_the_same_motion_is_no_other_assembly() {
    let text = include_str!("../fixtures/starts/neighbours.toml");
    assert!(!codes_of(text).contains(&"S015"), "{:?}", warnings_of(text));
}

#[test]
fn sound_models_start_without_a_word() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let new = ["M034", "M102", "M103", "M104", "M105", "S028", "S029"];
    let mut n_models = 0;
    for name in crate::support::example_names() {
        let _ = fs::metadata(folder.join(&name)).expect("an example");
        let text = crate::support::example_text(&name);
        let found = codes_of(&text);
        assert!(!found.iter().any(|code| new.contains(code)), "{name}: {found:?}");
        n_models += 1;
    }
    assert!(n_models > 25, "{n_models}");
}
