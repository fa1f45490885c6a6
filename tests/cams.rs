//! Rollers and flat faces on cams, against closed forms.

mod support;

use bksim::model::file::{Source, read};

use support::{Measures, Within, close, derive, model, reaction, solve};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// An eccentric disc of 30 mm turns at 10 rad/s about a point 8 mm from its centre, under a follower of 0.3 kg that
/// is pressed down with 200 N; the disc's centre is above the axis at first.
fn eccentric(contact: &str, rest: &str) -> String {
    format!(
        "[curves.disc]\ntype = \"formula\"\n\
         formula = [\"30 mm*cos(p)\", \"8 mm + 30 mm*sin(p)\"]\n\
         [bodies.cam]\nmass = \"0.5 kg\"\ninertia = \"1e-3 kg m^2\"\n\
         [bodies.follower]\nmass = \"0.3 kg\"\ninertia = \"1e-4 kg m^2\"\npoints = {{ F = [\"4 mm\", 0] }}\n\
         [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n\
         [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n\
         [joints.contact]\nbetween = [\"cam\", \"follower.F\"]\ncurve = \"disc\"\n{contact}\n\
         [drives.motor]\njoint = \"O\"\nmotion = \"10 rad/s*t\"\n\
         [loads.press]\ntype = \"force\"\non = \"follower\"\nvector = [0, \"-200 N\"]\n\
         [initial]\ncontact = {{ guess = {{ angle = \"90 deg\" }} }}\nguide = {{ guess = {{ position = \"40 mm\" }} }}\n\
         {rest}[solve]\nt_end = 0.6\nevery = 0.02\nrtol = 1e-11\natol = 1e-12\n"
    )
}

/// A flat face touches the disc above its centre: y = R + e cos θ, with the force there, off the follower's point.
#[test]
fn a_flat_face_on_an_eccentric_disc() {
    // Another body leaves the plane, and with it the face is a plane.
    let ball = "[bodies.ball]\nmass = 1\ninertia = [1, 2, 3]\n\
        [joints.socket]\ntype = \"spherical\"\nbetween = [\"ground\", \"ball\"]\n";
    for rest in ["", ball] {
        let mechanism = derive(model(&eccentric("type = \"line-on-curve\"\naxis = [1, 0]", rest)));
        let motion = solve(&mechanism);
        let measures = Measures::new(&mechanism, &["follower.y", "follower.vy", "contact.angle"]);
        for sample in &motion.samples {
            let angle = 10.0 * sample.t;
            let (sin, cos) = angle.sin_cos();
            let what = format!("at {} s", sample.t);
            let [y, vy, place] = [0, 1, 2].map(|k| measures.at(sample)[k]);
            close(&what, y, 0.03 + 0.008 * cos, within(1e-11));
            close(&what, vy, -0.08 * sin, within(1e-9));
            // The place of contact stays above the centre, so it goes backwards on the disc.
            close(&what, place, std::f64::consts::FRAC_PI_2 - angle, within(1e-8));
            let push = 200.0 - 0.3 * 100.0 * 0.008 * cos;
            let force = reaction(&mechanism, sample, "contact");
            close(&what, force[1], push, within(1e-7));
            close(&what, force[0], 0.0, within(1e-8));
            close(&what, force[5], (-0.008 * sin - 0.004) * push, within(1e-8));
        }
    }
}

/// A face that swings about a point: its angle is that of a tangent from the pivot to the disc.
#[test]
fn a_swinging_face_on_an_eccentric_disc() {
    let text = eccentric("type = \"line-on-curve\"\ndirection = \"180 deg\"", "")
        .replace(
            "guide = { guess = { position = \"40 mm\" } }",
            "guide = { guess = { angle = -0.3 } }",
        )
        .replace(
            "type = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]",
            "type = \"revolute\"\nbetween = [\"ground.B\", \"follower\"]",
        )
        .replace("[\"4 mm\", 0]", "[\"-50 mm\", \"5 mm\"]")
        + "[ground]\npoints = { B = [\"120 mm\", 0] }\n";
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["follower.angle"]);
    for sample in &motion.samples {
        let (sin, cos) = (10.0 * sample.t).sin_cos();
        // The centre seen from the pivot; the face is 5 mm beyond it, and touches the disc from above.
        let (x, y) = (-0.008 * sin - 0.12, 0.008 * cos);
        let expected = -(0.025 / x.hypot(y)).asin() - (y / -x).atan();
        close(&format!("at {} s", sample.t), measures.at(sample)[0], expected, within(1e-10));
    }
}

/// The centre of a roller moves on a circle about that of the disc, whichever side its parameter says is outside, and
/// the force goes through both centres.
#[test]
fn a_roller_on_either_side_of_an_eccentric_disc() {
    for (side, radius, distance) in [("right", 10.0, 0.04), ("left", 10.0, 0.02)] {
        let contact =
            format!("type = \"point-on-curve\"\nradius = \"{radius} mm\"\nside = \"{side}\"");
        let mut texts = vec![eccentric(&contact, "")];
        let other = if side == "left" { "right" } else { "left" };
        let backwards = texts[0].replace("sin(p)", "sin(-p)").replace(side, other);
        texts.push(backwards.replace("angle = \"90 deg\"", "angle = \"-90 deg\""));
        for text in texts {
            let mechanism = derive(model(&text));
            let motion = solve(&mechanism);
            let measures = Measures::new(&mechanism, &["follower.F.y"]);
            for sample in &motion.samples {
                let (sin, cos) = (10.0 * sample.t).sin_cos();
                let what = format!("{side} at {} s", sample.t);
                let (across, e): (f64, f64) = (0.004 + 0.008 * sin, 0.008);
                let height = (distance * distance - across * across).sqrt();
                close(&what, measures.at(sample)[0], e * cos + height, within(1e-11));
                let force = reaction(&mechanism, sample, "contact");
                close(&what, force[0] / force[1], across / height, within(1e-8));
                close(&what, force[5], 0.0, within(1e-9));
            }
        }
    }
}

#[test]
fn a_roller_needs_a_side_and_a_face_lies_along_z() {
    let check = |contact: &str, rest: &str, code: &str, help: &str| {
        let text = eccentric(contact, rest);
        let reading = read(&Source::new(&text, "test"));
        let fault = &reading.diagnostics[0];
        assert_eq!(fault.code.0, code, "{}", fault.message);
        let found = fault.help.as_deref().unwrap_or_default();
        assert!(found.contains(help), "{found}");
    };
    let roller = "type = \"point-on-curve\"\nradius = \"5 mm\"";
    check(roller, "", "M006", "write `side = \"left\"` or `\"right\"`");
    check("type = \"point-on-curve\"\nside = \"left\"", "", "M006", "`radius = \"10 mm\"`");
    check(&format!("{roller}\nside = \"outside\""), "", "M008", "one of `left`, `right`");
    let face = "type = \"line-on-curve\"\naxis = [2, 0, 1]";
    check(face, "", "M071", "[2, 0, 0]");
}
