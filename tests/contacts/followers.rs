//! Rollers and faces on a disc: the motion and the force of a contact, shared contacts, pictures.

use bksim::model::file::{Source, read};

use crate::support::{Measures, Within, close, derive, model, reaction, solve};

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

/// Two joints that hold the same face on the same disc: their forces, equal and opposite, are in equilibrium at the
/// place of contact, and nothing says how they share the load. One alone has all of it.
#[test]
fn two_contacts_at_one_place_share_their_force() {
    let face = "type = \"line-on-curve\"\naxis = [1, 0]\n";
    let one = derive(model(&eccentric(face, ""))).start().expect("a start");
    assert!(one.uniqueness.is_complete(), "{:?}", one.uniqueness);

    let twin =
        format!("[joints.twin]\nbetween = [\"cam\", \"follower.E\"]\ncurve = \"disc\"\n{face}");
    let text = eccentric(face, &twin)
        .replace("F = [\"4 mm\", 0]", "F = [\"4 mm\", 0], E = [\"9 mm\", 0]")
        .replace("contact = {", "twin = { guess = { angle = \"90 deg\" } }\ncontact = {");
    let mechanism = derive(model(&text));
    let both = mechanism.start().expect("a start").uniqueness;
    assert_eq!(both.n_self_stresses, 1, "{both:?}");
    let names: Vec<&str> = mechanism.model.joints.iter().map(|joint| joint.name.as_str()).collect();
    for (name, unique) in names.iter().zip(&both.reactions) {
        let is_contact = ["contact", "twin"].contains(name);
        let expected = [true, !is_contact, true, true, true, !is_contact];
        assert_eq!(*unique, expected, "{name}");
    }
}

/// A roller is a circle about its point, a face a line through its point and along its axis.
#[test]
fn followers_are_drawn_with_what_they_touch_with() {
    let lines = |contact: &str| {
        let model = model(&eccentric(contact, ""));
        let body = model.bodies.iter().position(|body| body.name == "follower").expect("it");
        let scene = bksim_scene::Scene::of(&model, &[]);
        let of_body = scene.shapes.into_iter().filter(|shape| shape.body == body);
        let lines = of_body.filter_map(|shape| match shape.form {
            bksim_scene::Form::Line { points, is_closed } => Some((points, is_closed)),
            _ => None,
        });
        lines.collect::<Vec<_>>()
    };
    let drawn = lines("type = \"point-on-curve\"\nradius = \"7 mm\"\nside = \"right\"");
    let is_roller = |(points, is_closed): &(Vec<[f64; 3]>, bool)| {
        let radius = |p: &[f64; 3]| (p[0] - 0.004).hypot(p[1]);
        *is_closed && points.iter().all(|p| (radius(p) - 0.007).abs() < 1e-12)
    };
    assert_eq!(drawn.iter().filter(|line| is_roller(line)).count(), 1, "{drawn:?}");
    let drawn = lines("type = \"line-on-curve\"\naxis = [0.6, 0.8]");
    let is_face = |(points, is_closed): &(Vec<[f64; 3]>, bool)| {
        let off = |p: &[f64; 3]| 0.8 * (p[0] - 0.004) - 0.6 * p[1];
        // As long as the disc is wide.
        let length = (points[1][0] - points[0][0]).hypot(points[1][1] - points[0][1]);
        let is_line =
            !is_closed && points.len() == 2 && points.iter().all(|p| off(p).abs() < 1e-12);
        is_line && (length - 0.06).abs() < 1e-4
    };
    assert_eq!(drawn.iter().filter(|line| is_face(line)).count(), 1, "{drawn:?}");
}
