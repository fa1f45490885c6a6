//! Profiles of cams from laws of motion, against closed forms and references.

use bksim::analysis::{CamReport, CamRequest, cam};
use bksim::model::file::{Source, read};

use crate::support::elements::{column, number, reference};
use crate::support::{Measures, Within, close, derive, model, solve};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// A rise of 12 mm over 120 deg, a return over 150 deg, each followed by a dwell; twice.
const LIFT: &str = "[curves.lift]\ntype = \"cam-law\"\nturns = 2\nsegments = [\n\
    { rise = \"12 mm\", over = \"120 deg\", law = \"cycloidal\" }, { dwell = \"60 deg\" },\n\
    { return = \"12 mm\", over = \"150 deg\", law = \"cycloidal\" }, { dwell = \"30 deg\" }]\n";

/// Law of angles of 15 deg, the 4-5-6-7 law.
const SWING: &str = "[curves.swing]\ntype = \"cam-law\"\nturns = 2\nsegments = [\n\
    { rise = \"15 deg\", over = \"120 deg\", law = \"4-5-6-7\" }, { dwell = \"60 deg\" },\n\
    { return = \"15 deg\", over = \"150 deg\", law = \"4-5-6-7\" }, { dwell = \"30 deg\" }]\n";

/// The part of the full lift at an angle of the cam below 2 turns.
fn part(angle: f64, rise: impl Fn(f64) -> f64) -> f64 {
    let degrees = angle.to_degrees() % 360.0;
    if degrees < 120.0 {
        rise(degrees / 120.0)
    } else if degrees < 180.0 {
        1.0
    } else if degrees < 330.0 {
        1.0 - rise((degrees - 180.0) / 150.0)
    } else {
        0.0
    }
}

fn cycloidal(u: f64) -> f64 {
    u - (std::f64::consts::TAU * u).sin() / std::f64::consts::TAU
}

fn polynomial_4567(u: f64) -> f64 {
    u.powi(4) * (35.0 - 84.0 * u + 70.0 * u * u - 20.0 * u.powi(3))
}

/// Points of a path of the first cam at the angles of a reference, against two of its columns.
fn check_profile(text: &str, data: &str, of_pitch: bool, columns: [&str; 2]) {
    let model = model(text);
    let curve = &model.curves[0];
    let pitch = || curve.pitch(&model.pool).expect("a roller has a pitch curve");
    let path = if of_pitch { pitch() } else { curve.position };
    let reference = reference(data);
    let angle = column(&reference, "th");
    for row in reference["rows"].as_array().expect("rows") {
        let at = |symbol| (symbol == curve.parameter).then_some(number(row, angle));
        for (axis, name) in columns.into_iter().enumerate() {
            let found = model.pool.evaluate(path[axis], &at).expect("a number");
            let expected = number(row, column(&reference, name));
            let what = format!("{name} at {}", number(row, angle));
            close(&what, found, expected, within(0.05 * 1e-12));
        }
    }
}

const POINTS: &str = "[bodies.cam]\nmass = 1\ninertia = 1\n\
    [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n";

#[test]
fn profiles_are_those_of_the_references() {
    let flat = format!(
        "{POINTS}{LIFT}[curves.profile]\ntype = \"cam\"\nlaw = \"lift\"\nbase_circle = \"30 mm\"\n\
         follower = {{ kind = \"flat\" }}\n"
    );
    check_profile(&flat, "elements/cam_flat", false, ["Px", "Py"]);
    let roller = format!(
        "{POINTS}{SWING}[curves.profile]\ntype = \"cam\"\nlaw = \"swing\"\nbase_circle = \"35 mm\"\n\
         follower = {{ kind = \"roller\", radius = \"10 mm\", arm = \"70 mm\", pivot = [\"90 mm\", 0] }}\n"
    );
    check_profile(&roller, "elements/cam_swinging_roller", false, ["Px", "Py"]);
    check_profile(&roller, "elements/cam_swinging_roller", true, ["Xc", "Yc"]);
}

/// A follower pressed on its cam moves by the law: whatever it touches with, wherever its guide is, and in whichever
/// sense the cam turns.
#[test]
fn followers_move_by_their_laws() {
    // Follower, joint, the point of the follower that is joined, and its position with the lift zero.
    let on_point = "type = \"point-on-curve\"";
    let rolling = "type = \"point-on-curve\"\nradius = \"10 mm\"\nside = ";
    let straight = [
        ("kind = \"knife\"", on_point.to_owned(), 0.0, 0.03),
        ("kind = \"knife\", offset = \"18 mm\"", on_point.to_owned(), 0.018, 0.024),
        ("kind = \"roller\", radius = \"10 mm\"", on_point.to_owned(), 0.0, 0.04),
        (
            "kind = \"roller\", radius = \"10 mm\", offset = \"-24 mm\"",
            on_point.to_owned(),
            -0.024,
            0.032,
        ),
        // On the profile itself, without its pitch curve.
        (
            "kind = \"roller\", radius = \"10 mm\", offset = \"-24 mm\"",
            rolling.to_owned(),
            -0.024,
            0.032,
        ),
        ("kind = \"flat\"", "type = \"line-on-curve\"\naxis = [1, 0]".to_owned(), 0.004, 0.03),
    ];
    for ((follower, joint, across, first), sense) in
        straight.iter().flat_map(|case| [(case, 1), (case, -1)])
    {
        // Outside is on the left of a curve that goes around clockwise.
        let side = if sense > 0 { "\"left\"" } else { "\"right\"" };
        let joint = if joint.ends_with("= ") { format!("{joint}{side}") } else { joint.clone() };
        let word = if sense > 0 { "counter-clockwise" } else { "clockwise" };
        let text = format!(
            "{LIFT}[curves.profile]\ntype = \"cam\"\nlaw = \"lift\"\nbase_circle = \"30 mm\"\n\
             sense = \"{word}\"\nfollower = {{ {follower} }}\n{POINTS}\
             [bodies.follower]\nmass = 1\ninertia = 1\npoints = {{ F = [{across}, 0] }}\n\
             [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n\
             [joints.contact]\nbetween = [\"cam\", \"follower.F\"]\ncurve = \"profile\"\n{joint}\n\
             [drives.motor]\njoint = \"O\"\nmotion = \"{sense} rad/s*t\"\n\
             [initial]\nguide = {{ guess = {{ position = {first} }} }}\ncontact = {{ guess = {{ angle = 0 }} }}\n\
             [solve]\nt_end = 7\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n"
        );
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let measures = Measures::new(&mechanism, &["guide.position", "contact.angle"]);
        for sample in &motion.samples {
            let what = format!("{follower}, {word}, at {} rad", sample.t);
            let lift = 0.012 * part(sample.t, cycloidal);
            close(&what, measures.at(sample)[0], first + lift, within(1e-10));
            close(&what, measures.at(sample)[1], sample.t, within(1e-6));
        }
    }

    let swinging = [
        ("kind = \"knife\", arm = \"70 mm\"", on_point, 0.035),
        ("kind = \"roller\", radius = \"10 mm\", arm = \"70 mm\"", on_point, 0.045),
        ("kind = \"flat\"", "type = \"line-on-curve\"\naxis = [1, 0]", 0.0),
    ];
    for ((follower, joint, centre), [sense, lean]) in
        swinging.iter().flat_map(|case| [[1, -1], [1, 1], [-1, -1]].map(|senses| (case, senses)))
    {
        let word = |sense| if sense > 0 { "counter-clockwise" } else { "clockwise" };
        // A face would undercut its cam with the larger rise.
        let rise = if *centre == 0.0 { 5f64 } else { 15.0 };
        let law = SWING.replace("15 deg", &format!("{rise} deg"));
        let rise = rise.to_radians();
        let text = format!(
            "{law}[curves.profile]\ntype = \"cam\"\nlaw = \"swing\"\nbase_circle = \"35 mm\"\n\
             sense = \"{}\"\nfollower = {{ {follower}, pivot = [\"54 mm\", \"72 mm\"], sense = \"{}\" }}\n{POINTS}\
             [ground]\npoints = {{ B = [\"54 mm\", \"72 mm\"] }}\n\
             [bodies.arm]\nmass = 1\ninertia = 1\npoints = {{ R = [\"70 mm\", 0] }}\n\
             [joints.B]\ntype = \"revolute\"\nbetween = [\"ground.B\", \"arm\"]\n\
             [joints.contact]\nbetween = [\"cam\", \"arm.R\"]\ncurve = \"profile\"\n{joint}\n\
             [drives.motor]\njoint = \"O\"\nmotion = \"{sense} rad/s*t\"\n",
            word(sense),
            word(lean)
        );
        // The pivot is 90 mm from the axis, at the angle of the 3-4-5 triangle.
        let [f, l]: [f64; 2] = [0.09, 0.07];
        let first = if *centre == 0.0 {
            (0.035 / f).asin()
        } else {
            ((f * f + l * l - centre * centre) / (2.0 * f * l)).acos()
        };
        let towards = 0.8f64.atan2(0.6) - std::f64::consts::PI;
        let arm = |angle: f64| {
            let swing = rise * part(angle, polynomial_4567);
            towards + f64::from(lean) * (first + swing)
        };
        let text = format!(
            "{text}[initial]\nB = {{ guess = {{ angle = {:.3} }} }}\ncontact = {{ guess = {{ angle = 0 }} }}\n\
             [solve]\nt_end = 7\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n",
            arm(0.0)
        );
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let measures = Measures::new(&mechanism, &["B.angle"]);
        for sample in &motion.samples {
            let what = format!("{follower}, {sense} {lean}, at {} rad", sample.t);
            close(&what, measures.at(sample)[0], arm(sample.t), within(1e-9));
        }
    }
}

#[test]
fn a_profile_needs_a_law_and_a_follower_that_reaches_it() {
    let check = |law: &str, follower: &str, code: &str, message: &str| {
        let text = format!(
            "{LIFT}{SWING}[curves.profile]\ntype = \"cam\"\nlaw = \"{law}\"\nbase_circle = \"30 mm\"\n\
             follower = {{ {follower} }}\n{POINTS}"
        );
        let reading = read(&Source::new(&text, "test"));
        let fault = reading.diagnostics.first().unwrap_or_else(|| panic!("no fault: {follower}"));
        assert_eq!(fault.code.0, code, "{}", fault.message);
        assert!(fault.message.contains(message), "{}", fault.message);
        assert!(fault.help.is_some(), "{}", fault.message);
    };
    check("lif", "kind = \"flat\"", "M092", "unknown law `lif`");
    check("swing", "kind = \"flat\"", "M031", "its follower slides");
    check("lift", "kind = \"flat\", pivot = [0.1, 0]", "M031", "its follower swings");
    check("lift", "kind = \"knife\", offset = \"-31 mm\"", "M091", "`offset` is beyond");
    check("lift", "kind = \"flat\", offset = 0", "M005", "unknown key `offset`");
    let roller = "kind = \"roller\", radius = \"10 mm\"";
    check("swing", &format!("{roller}, arm = 0.07"), "M006", "has no `pivot`");
    check("swing", &format!("{roller}, pivot = [0.1, 0]"), "M006", "has no `arm`");
    let arm = |arm: &str| format!("{roller}, pivot = [\"90 mm\", 0], arm = \"{arm}\"");
    check("swing", &arm("49 mm"), "M091", "does not reach");
    check("swing", &arm("131 mm"), "M091", "does not reach");
    check("swing", "kind = \"flat\", pivot = [0, \"30 mm\"]", "M091", "`pivot` is inside");
    check("swing", "kind = \"flat\", pivot = [0, 0]", "M091", "is the axis");
    check("lift", "radius = \"10 mm\"", "M006", "has no `kind`");
    check("lift", &format!("{roller}, offset = 0, pivot = [0.1, 0]"), "M055", "both");
}

/// A report with rows at every ten degrees.
fn report(text: &str, curve: Option<&str>) -> CamReport {
    let request = CamRequest { curve: curve.map(str::to_owned), n_rows: 37, cutter: None };
    cam(&model(text), &request).expect("a cam")
}

/// Compares columns of a report with those of a reference, by size where signs are a matter of taste.
fn check_table(found: &CamReport, data: &str, columns: &[(&str, &str, f64)]) {
    let reference = reference(data);
    let rows = reference["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), found.table.rows.len());
    for (ours, theirs, factor) in columns {
        let ours = found.table.column(ours).expect("a column");
        let theirs = column(&reference, theirs);
        let largest = rows.iter().map(|row| number(row, theirs).abs()).fold(0.0, f64::max);
        for (row, value) in rows.iter().zip(ours) {
            let expected = number(row, theirs);
            let value = if *factor == 0.0 { value.to_degrees().abs() } else { factor * value };
            let expected = if *factor == 0.0 { expected.abs() } else { expected };
            close(&format!("{data}, {theirs}"), value, expected, within(1e-12 * largest));
        }
    }
}

#[test]
fn curvature_and_pressure_angles_are_those_of_the_references() {
    let of = |law: &str, name: &str, base: f64, follower: &str| {
        format!(
            "{law}[curves.profile]\ntype = \"cam\"\nlaw = \"{name}\"\nbase_circle = \"{base} mm\"\n\
             follower = {{ {follower} }}\n{POINTS}"
        )
    };
    let found = report(&of(LIFT, "lift", 30.0, "kind = \"flat\""), None);
    let columns = [("lift", "s", 1.0), ("contact", "contact_offset", 1.0), ("radius", "rho", 1.0)];
    check_table(&found, "elements/cam_flat", &columns);
    check_table(&found, "elements/cam_flat", &[("x", "Px", 1.0), ("y", "Py", 1.0)]);
    let profile = found.profile.expect("a profile");
    let values = &reference("elements/cam_flat")["values"];
    let value = |name: &str| values[name].as_f64().expect("a number");
    let least = profile.smallest_base_circle.expect("a smallest base circle");
    close("base", least.value, value("smallest_base_circle"), within(1e-14));
    close("at", least.at, value("at_th"), within(1e-7));
    let [left, right] = profile.face.expect("a face");
    close("rise", right, value("needed_half_width_rise"), within(1e-14));
    close("return", -left, value("needed_half_width_return"), within(1e-14));
    assert!(profile.is_closed && profile.undercuts.is_empty() && found.warnings.is_empty());

    let roller = "kind = \"roller\", radius = \"10 mm\", arm = \"70 mm\", pivot = [\"90 mm\", 0]";
    let found = report(&of(SWING, "swing", 35.0, roller), Some("profile"));
    let columns = [
        ("velocity", "dp", 1.0),
        ("pressure_angle", "pressure_angle_deg", 0.0),
        ("pitch_radius", "rho_pitch", 1.0),
        ("pitch_x", "Xc", 1.0),
        ("y", "Py", 1.0),
    ];
    check_table(&found, "elements/cam_swinging_roller", &columns);
    let [rise, fall] = found.profile.expect("a profile").steepest.expect("a point has one");
    assert!(rise.value > 17.7f64.to_radians() && fall.value < 0.0, "{rise:?} {fall:?}");
}

/// A face is undercut below the smallest base circle, and not above it; so is a roller on an arc of its own radius.
#[test]
fn undercuts_are_found_with_their_places() {
    let of = |base: f64, follower: &str| {
        let text = format!(
            "{LIFT}[curves.profile]\ntype = \"cam\"\nlaw = \"lift\"\nbase_circle = {base:?}\n\
             follower = {{ {follower} }}\n{POINTS}"
        );
        report(&text, None)
    };
    let flat = "kind = \"flat\"";
    let found = of(0.0063, flat);
    let [from, to] = found.profile.expect("a profile").undercuts[0];
    assert!(from < 1.529 && 1.53 < to, "{from} {to}");
    // There the radius of curvature, base + s + s″, is zero.
    let over = 120f64.to_radians();
    for at in [from, to] {
        let tau = std::f64::consts::TAU;
        let bend = tau * (tau * at / over).sin() / (over * over);
        close("radius", 0.0063 + 0.012 * (cycloidal(at / over) + bend), 0.0, within(1e-12));
    }
    let [warning] = found.warnings.as_slice() else { panic!("{:?}", found.warnings) };
    assert_eq!(warning.code.0, "Q009");
    assert!(warning.help.as_ref().is_some_and(|help| help.contains("\"6.399 mm\"")), "{warning:?}");
    assert!(of(0.006_399, flat).warnings.is_empty());

    // The path of the centre is bent most where the profile is undercut first: then as much as the roller.
    let roller = "kind = \"roller\", radius = \"25 mm\"";
    let least = of(0.03, roller).profile.expect("a profile").smallest_base_circle.expect("one");
    let there = of(least.value, roller);
    let bent = there.profile.expect("a profile").least_radius.expect("a place");
    close("sharpest", bent.value, 0.0, within(1e-12));
    assert!(there.warnings.is_empty());
    let below = of(0.999 * least.value, roller);
    assert_eq!(below.warnings.len(), 1, "{:?}", below.warnings);
}

/// Norton's table of factors, and closed forms of them.
#[test]
fn laws_have_their_peak_factors() {
    use std::f64::consts::PI;
    let expected: [(&str, [f64; 3]); 6] = [
        ("3-4-5", [1.875, 5.773_502_691_896_26, 60.0]),
        ("4-5-6-7", [2.1875, 7.513_188_404_399_29, 52.5]),
        ("cycloidal", [2.0, 2.0 * PI, 4.0 * PI * PI]),
        ("harmonic", [0.5 * PI, 0.5 * PI * PI, 0.5 * PI.powi(3)]),
        (
            "modified-sine",
            [1.759_603_385_953_77, 5.527_957_070_544_09, 16.0 * PI.powi(3) / (4.0 + PI)],
        ),
        ("modified-trapezoid", [2.0, 8.0 * PI / (2.0 + PI), 32.0 * PI * PI / (2.0 + PI)]),
    ];
    for (law, factors) in expected {
        let text = format!("{}{POINTS}", LIFT.replace("cycloidal", law));
        let found = report(&text, None);
        assert_eq!(found.peaks.len(), 2);
        for peaks in &found.peaks {
            assert_eq!(peaks.law, law);
            for (k, (found, expected)) in peaks.factors.iter().zip(factors).enumerate() {
                close(&format!("{law}, {k}"), *found, expected, within(1e-9 * expected));
            }
        }
    }
}
