//! Curves that touch, roll and slide on each other, against closed forms and other joints.

use bksim::Mechanism;
use bksim::model::file::{Source, read};

use crate::support::{Measures, Within, close, derive, model, reaction, solve};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

const SOLVE: &str = "[solve]\nt_end = 1\nevery = 0.05\nrtol = 1e-11\natol = 1e-12\n";

/// A circle by its name and radius.
fn circle(name: &str, radius: &str) -> String {
    format!(
        "[curves.{name}]\ntype = \"formula\"\nformula = [\"{radius}*cos(p)\", \"{radius}*sin(p)\"]\n"
    )
}

/// θ″ = g sin θ/((R + r)(1 + I/mr²)), N = m g cos θ − m (R + r) θ′²; the friction turns the disc.
#[test]
fn a_disc_rolls_down_a_drum() {
    let [drum, r, m, inertia, g, first]: [f64; 6] = [1.0, 0.25, 2.0, 0.1, 9.81, 0.3];
    let text = format!(
        "[parameters]\nr = \"{r} m\"\n{}{}[bodies.disc]\nmass = {m}\ninertia = {inertia}\n\
         [joints.contact]\ntype = \"curve-on-curve\"\nbetween = [\"ground\", \"disc\"]\ncurve = \"drum\"\n\
         second_curve = \"rim\"\nrolling = [\"pi/2\", \"-pi/2\"]\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -{g}]\n\
         [initial]\ncontact = {{ angle1 = {}, rate1 = 0, guess = {{ angle2 = -1.6 }} }}\n\
         disc = {{ guess = {{ x = 0.37, y = 1.19, angle = -1.5 }} }}\n{SOLVE}",
        circle("drum", "1 m"),
        circle("rim", "r"),
        std::f64::consts::FRAC_PI_2 - first
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures =
        Measures::new(&mechanism, &["disc.x", "disc.y", "disc.angle", "disc.vx", "disc.vy"]);
    let reach = drum + r;
    let pull = g / (reach * (1.0 + inertia / (m * r * r)));
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let found = measures.at(sample);
        let lean = found[0].atan2(found[1]);
        close(&what, found[0].hypot(found[1]), reach, within(1e-10));
        close(&what, found[2], -lean * reach / r, within(1e-9));
        let rate = (found[3] * lean.cos() - found[4] * lean.sin()) / reach;
        close(&what, rate * rate, 2.0 * pull * (first.cos() - lean.cos()), within(1e-8));

        let push = m * (g * lean.cos() - reach * rate * rate);
        let rub = inertia * reach / (r * r) * pull * lean.sin();
        let force = reaction(&mechanism, sample, "contact");
        let (sin, cos) = lean.sin_cos();
        close(&what, force[0] * sin + force[1] * cos, push, within(1e-6));
        close(&what, force[1] * sin - force[0] * cos, rub, within(1e-6));
        // About the centre of the disc, where the joint's point is.
        close(&what, force[5], -rub * r, within(1e-6));
    }
}

/// A wheel pressed on another, outside and in a ring: the rates of gears, the force of their teeth, and the press.
#[test]
fn wheels_pressed_on_each_other_turn_as_gears() {
    let [small, large, i1, i2, torque, press]: [f64; 6] = [0.1, 0.3, 0.02, 0.05, 3.0, 40.0];
    for (tangents, sign, at) in [("opposite", -1.0, 0.4), ("same", 1.0, 0.2)] {
        let text = format!(
            "{}{}[ground]\npoints = {{ B = [{at}, 0] }}\n\
             [bodies.wheel]\nmass = 1\ninertia = {i1}\n[bodies.slide]\nmass = 0.5\n\
             [bodies.ring]\nmass = 1\ninertia = {i2}\n\
             [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"wheel\"]\n\
             [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground.B\", \"slide\"]\naxis = [1, 0]\n\
             [joints.B]\ntype = \"revolute\"\nbetween = [\"slide\", \"ring\"]\n\
             [joints.contact]\ntype = \"curve-on-curve\"\nbetween = [\"wheel\", \"ring\"]\ncurve = \"small\"\n\
             second_curve = \"large\"\ntangents = \"{tangents}\"\nrolling = [0, {}]\n\
             [loads.motor]\ntype = \"torque\"\njoint = \"A\"\nvalue = {torque}\n\
             [loads.press]\ntype = \"force\"\non = \"slide\"\nvector = [{}, 0]\n\
             [initial]\nA = {{ angle = 0, rate = 0 }}\nB = {{ guess = {{ angle = 0 }} }}\n\
             contact = {{ guess = {{ angle1 = {}, angle2 = {} }} }}\n{SOLVE}",
            circle("small", &format!("{small} m")),
            circle("large", &format!("{large} m")),
            "\"pi\"",
            sign * press,
            if sign < 0.0 { 0.0 } else { 3.1 },
            3.1,
        );
        // In the ring the wheel touches on the far side of its own axis, where both parameters are π.
        let text =
            if sign > 0.0 { text.replace("rolling = [0,", "rolling = [\"pi\",") } else { text };
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let measures =
            Measures::new(&mechanism, &["A.angle", "B.angle", "guide.position", "contact.angle1"]);
        let speed_up = torque / (i1 + i2 * (small / large).powi(2));
        for sample in &motion.samples {
            let what = format!("{tangents}, at {} s", sample.t);
            let found = measures.at(sample);
            let turned = 0.5 * speed_up * sample.t * sample.t;
            close(&what, found[0], turned, within(1e-8));
            close(&what, found[1], sign * turned * small / large, within(1e-8));
            close(&what, found[2], 0.0, within(1e-10));
            // The place of contact rests in space.
            let place = if sign < 0.0 { 0.0 } else { std::f64::consts::PI };
            close(&what, found[3] - place, -turned, within(1e-8));
            let force = reaction(&mechanism, sample, "contact");
            close(&what, force[0].abs(), press, within(1e-7));
            let rub = i2 * speed_up * small / (large * large);
            close(&what, force[1].abs(), rub, within(1e-7));
        }
    }
}

/// Two equal ellipses, each about a focus: they roll at the distance 2a, with
/// tan(θ₂/2) = −(1 + e)/(1 − e) tan(θ₁/2). One is pressed on the other, so that its axis may leave that distance.
#[test]
fn equal_ellipses_roll_about_their_foci() {
    let text = format!(
        "[curves.ellipse]\ntype = \"formula\"\nformula = [\"0.4 m + 0.5 m*cos(p)\", \"0.3 m*sin(p)\"]\n\
         [ground]\npoints = {{ B = [1, 0] }}\n\
         [bodies.first]\nmass = 1\ninertia = 0.1\n[bodies.slide]\nmass = 0.5\n\
         [bodies.second]\nmass = 1\ninertia = 0.1\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"first\"]\n\
         [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground.B\", \"slide\"]\naxis = [1, 0]\n\
         [joints.B]\ntype = \"revolute\"\nbetween = [\"slide\", \"second\"]\n\
         [joints.contact]\ntype = \"curve-on-curve\"\nbetween = [\"first\", \"second\"]\ncurve = \"ellipse\"\n\
         second_curve = \"ellipse\"\nrolling = [0, \"pi\"]\n\
         [drives.motor]\njoint = \"A\"\nmotion = \"0.2 rad + 7 rad/s*t\"\n\
         [loads.press]\ntype = \"force\"\non = \"slide\"\nvector = [-100, 0]\n\
         [initial]\nB = {{ guess = {{ angle = -1.4 }} }}\n\
         contact = {{ guess = {{ angle1 = -0.6, angle2 = 3.7 }} }}\n{SOLVE}"
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["B.angle", "guide.position"]);
    let e = 0.8;
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let driven = 0.2 + 7.0 * sample.t;
        let expected = -2.0 * ((1.0 + e) / (1.0 - e) * (0.5 * driven).tan()).atan();
        let found = measures.at(sample);
        close(&what, (0.5 * (found[0] - expected)).sin().abs(), 0.0, within(1e-9));
        close(&what, found[1], 0.0, within(1e-9));
    }
}

/// A disc rolls to and fro in a bowl through three points, whose spline is y = h (3 x² − |x|³)/2: v² by its height, the
/// turn by the length of the bowl; with `rolling`, and by friction that suffices.
#[test]
fn a_disc_rolls_in_a_bowl_of_points() {
    let [r, m, inertia, g, h]: [f64; 5] = [0.1, 2.0, 0.01, 9.81, 0.5];
    let slope = |x: f64| h * (3.0 * x - 1.5 * x * x.abs());
    // Simpson's rule.
    let length = |to: f64| {
        let n = 400;
        let at = |k: usize| {
            let weight = if k == 0 || k == n { 1.0 } else { [2.0, 4.0][k % 2] };
            weight * slope(to * k as f64 / n as f64).hypot(1.0)
        };
        (0..=n).map(at).sum::<f64>() * to / (3 * n) as f64
    };
    let first: f64 = -0.5;
    let start = slope(first).atan() - length(first) / r;
    for (rolling, rub) in [
        ("rolling = [1, \"-pi/2\"]\n", ""),
        ("", "[loads.rub]\ntype = \"friction\"\njoint = \"contact\"\nmu = 0.5\n"),
    ] {
        let given =
            if rolling.is_empty() { format!("angle = {start}, rate = 0, ") } else { String::new() };
        let text = format!(
            "[curves.bowl]\ntype = \"points\"\npoints = [[-1, {h}], [0, 0], [1, {h}]]\n{}\
             [bodies.disc]\nmass = {m}\ninertia = {inertia}\n\
             [joints.contact]\ntype = \"curve-on-curve\"\nbetween = [\"ground\", \"disc\"]\ncurve = \"bowl\"\n\
             second_curve = \"rim\"\ntangents = \"same\"\n{rolling}{rub}\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -{g}]\n\
             [initial]\ncontact = {{ angle1 = {}, rate1 = 0, guess = {{ angle2 = {} }} }}\n\
             disc = {{ {given}guess = {{ x = -0.44, y = 0.24{} }} }}\n{}",
            circle("rim", "0.1 m"),
            first + 1.0,
            length(first) / r - std::f64::consts::FRAC_PI_2,
            if rolling.is_empty() { String::new() } else { format!(", angle = {start}") },
            SOLVE.replace("t_end = 1", "t_end = 2")
        );
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let names = ["contact.angle1", "disc.y", "disc.vx", "disc.vy", "disc.angle"];
        let measures = Measures::new(&mechanism, &names);
        let high = measures.at(&motion.samples[0])[1];
        let places = motion.samples.iter().map(|sample| measures.at(sample)[0] - 1.0);
        assert!(places.fold(first, f64::max) > 0.49, "it does not roll over to the other side");
        for sample in &motion.samples {
            let what = format!("{rolling:?}, at {} s", sample.t);
            let found = measures.at(sample);
            let square = 2.0 * g * (high - found[1]) / (1.0 + inertia / (m * r * r));
            close(&what, found[2].powi(2) + found[3].powi(2), square, within(1e-8));
            let x = found[0] - 1.0;
            close(&what, found[4], slope(x).atan() - length(x) / r, within(1e-8));
        }
    }
}

/// A disc rolls around the profile of a cam with a flat follower, whose length is ∫ (R + s + s″) dθ.
#[test]
fn a_disc_rolls_on_the_profile_of_a_cam() {
    let [base, rise, r]: [f64; 3] = [0.03, 0.01, 0.008];
    let over = 120f64.to_radians();
    let text = format!(
        "[curves.lift]\ntype = \"cam-law\"\nsegments = [{{ rise = \"{rise} m\", over = {over}, law = \"3-4-5\" }}, \
         {{ dwell = \"100 deg\" }}, {{ return = \"{rise} m\", over = \"140 deg\", law = \"3-4-5\" }}]\n\
         [curves.profile]\ntype = \"cam\"\nlaw = \"lift\"\nbase_circle = \"{base} m\"\nfollower = {{ kind = \"flat\" }}\n\
         {}[bodies.disc]\nmass = 1\ninertia = 1e-4\n\
         [joints.contact]\ntype = \"curve-on-curve\"\nbetween = [\"ground\", \"disc\"]\ncurve = \"profile\"\n\
         second_curve = \"rim\"\ntangents = \"same\"\nrolling = [0, \"-pi/2\"]\n\
         [initial]\ncontact = {{ angle1 = 0.2, rate1 = 5, guess = {{ angle2 = -0.8 }} }}\n\
         disc = {{ guess = {{ x = 0.008, y = 0.037, angle = -1 }} }}\n{SOLVE}",
        circle("rim", &format!("{r} m")),
    );
    let length = |angle: f64| {
        let u = (angle / over).min(1.0);
        let lifted = over * rise * u.powi(4) * (2.5 - 3.0 * u + u * u);
        let slope = rise * 30.0 * (u * (1.0 - u)).powi(2) / over;
        base * angle + lifted + slope + rise * (angle - over).max(0.0)
    };
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["contact.angle1", "contact.angle2"]);
    let mut furthest: f64 = 0.0;
    for sample in &motion.samples {
        let [angle, turned] = [0, 1].map(|k| measures.at(sample)[k]);
        furthest = furthest.max(angle);
        if angle < 220f64.to_radians() {
            let expected = length(angle) / r - std::f64::consts::FRAC_PI_2;
            close(&format!("at {} s", sample.t), turned, expected, within(1e-9));
        }
    }
    assert!(furthest > over + 0.5, "{furthest}");
}

/// A disc that slides on an ellipse, as a curve and as a roller about a point: the same motion, the same force.
#[test]
fn a_circle_that_slides_is_a_roller() {
    let disc = |joint: &str| {
        let text = format!(
            "[curves.track]\ntype = \"formula\"\nformula = [\"0.5 m*cos(p)\", \"0.3 m*sin(p)\"]\n{}\
             [bodies.disc]\nmass = \"200 g\"\ninertia = 1e-3\n\
             [joints.contact]\nbetween = [\"ground\", \"disc\"]\n{joint}\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n{}",
            circle("rim", "0.1 m"),
            SOLVE.replace("t_end = 1", "t_end = 0.5")
        );
        derive(model(&text))
    };
    let start = "[initial]\ndisc = { angle = 0, rate = 0, guess = { x = 0.1, y = 0.4 } }\n";
    let roller = disc(&format!(
        "type = \"point-on-curve\"\ncurve = \"track\"\nradius = \"0.1 m\"\nside = \"right\"\n{start}\
         contact = {{ angle = 1.3, rate = 0 }}\n"
    ));
    let curve = disc(&format!(
        "type = \"curve-on-curve\"\ncurve = \"track\"\nsecond_curve = \"rim\"\n{start}\
         contact = {{ angle1 = 1.3, rate1 = 0, guess = {{ angle2 = -1.6 }} }}\n"
    ));
    let names = ["disc.x", "disc.y", "disc.vx", "disc.vy"];
    let [of_roller, of_curve] = [&roller, &curve].map(solve);
    let [rollers, curves] = [&roller, &curve].map(|m| Measures::new(m, &names));
    for (a, b) in of_roller.samples.iter().zip(&of_curve.samples) {
        for ((name, a), b) in names.iter().zip(rollers.at(a)).zip(curves.at(b)) {
            close(name, b, a, within(1e-9));
        }
        let [a, b] = [(&roller, a), (&curve, b)].map(|(m, s)| reaction(m, s, "contact"));
        for axis in 0..2 {
            close("force", b[axis], a[axis], within(1e-7));
        }
    }
}

#[test]
fn curves_of_unknown_length_do_not_roll_and_curves_apart_do_not_touch() {
    let contact = "[bodies.disc]\nmass = 1\ninertia = 1\n[joints.contact]\ntype = \"curve-on-curve\"\n\
        between = [\"ground\", \"disc\"]\ncurve = \"track\"\nsecond_curve = \"rim\"\n";
    let rim = circle("rim", "0.1 m");
    for track in [
        "type = \"formula\"\nformula = [\"1 m*(p - sin(p))\", \"1 m*(1 - cos(p))\"]",
        "type = \"formula\"\nformula = [\"1 m*p\", \"1 m*p^2\"]\nrange = [-1, 1]",
    ] {
        let text = format!("[curves.track]\n{track}\n{rim}{contact}rolling = [0, 0]\n");
        let reading = read(&Source::new(&text, "test"));
        let fault = reading.diagnostics.first().unwrap_or_else(|| panic!("no fault: {track}"));
        assert_eq!(fault.code.0, "M091", "{}", fault.message);
        assert!(
            fault.message.contains("`track`, on which joint `contact` rolls"),
            "{}",
            fault.message
        );
        let slides = text.replace("rolling = [0, 0]\n", "");
        assert!(read(&Source::new(&slides, "test")).model.is_some(), "{track}");
    }

    let apart = format!(
        "{}{rim}[ground]\npoints = {{ B = [3, 0] }}\n{contact}\
         [joints.B]\ntype = \"revolute\"\nbetween = [\"ground.B\", \"disc\"]\n",
        circle("track", "1 m")
    );
    let fault = match Mechanism::derive(model(&apart), Vec::new()) {
        Ok(mechanism) => mechanism.solve().err().map(|fault| fault.to_string()),
        Err(fault) => Some(fault.to_string()),
    };
    let fault = fault.expect("curves 1.9 m apart cannot touch");
    assert!(fault.contains("contact"), "{fault}");
}
