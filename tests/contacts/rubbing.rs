//! Friction of teeth, of faces on curves and of curves on each other, against closed forms.

use std::f64::consts::PI;

use crate::support::{
    Measures, Within, close, derive, messages, model, reaction, solve, with_method,
};
use bksim::mbs::constraint::Source;
use bksim::model::file::{Source as Text, read};
use bksim::sim::hybrid::ChangeKind;

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// The loss factor of teeth of 20° on `w` others, below zero of a ring: the mean of the sliding over one base pitch,
/// pair by pair, each with an equal share of the load.
fn loss(z: f64, w: f64) -> f64 {
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let tip = |z: f64, add: f64| {
        let way = ((z / 2.0 + add).powi(2) - (z / 2.0 * cos).powi(2)).sqrt() - z / 2.0 * sin;
        (way * add / (PI * cos)).abs()
    };
    let reach = z / 2.0 * sin / (PI * cos);
    let [own, other] = [tip(z, 1.0), tip(w.abs(), w.signum()).min(reach)];
    PI * (1.0 / z + 1.0 / w) * 2.0 * mean_sliding(own, other)
}

/// ∫ |s| over the base pitch from where a pair comes into touch, `other` before the pitch point, up to `own` beyond it:
/// the sum of trapezia between the places where a pair comes, goes or passes the pitch point is exact.
fn mean_sliding(own: f64, other: f64) -> f64 {
    let mut borders = [0.0, 1.0, other % 1.0, (own + other) % 1.0];
    borders.sort_by(f64::total_cmp);
    let mean = |first: f64| {
        let pairs = (0..3).map(|k| first - other + f64::from(k)).filter(|&s| s < own);
        let pairs: Vec<f64> = pairs.map(f64::abs).collect();
        pairs.iter().sum::<f64>() / pairs.len() as f64
    };
    let parts =
        borders.windows(2).map(|ends| (ends[1] - ends[0]) * mean(f64::midpoint(ends[0], ends[1])));
    parts.sum()
}

/// The effort of the only drive of a model at its end.
fn effort(text: &str) -> f64 {
    let mechanism = derive(model(text));
    let is_drive = |source: &Source| matches!(source, Source::Drive(_));
    let row = mechanism.compiled.sources.iter().position(is_drive).expect("a drive");
    let motion = solve(&mechanism);
    motion.samples.last().expect("a sample").lambda[row]
}

/// Twenty teeth on forty-five, either driving.
#[test]
fn a_pair_of_gears_has_the_efficiency_of_its_loss_factor() {
    let pair = |coupling: &str, rub: &str, drive: &str, brake: &str| {
        format!(
            "[bodies.a]\nmass = 1\ninertia = 1e-3\n[bodies.b]\nmass = 1\ninertia = 4e-3\n\
             [ground]\npoints = {{ A = [0, 0], B = [\"65 mm\", 0] }}\n\
             [joints.A]\ntype = \"revolute\"\nbetween = [\"ground.A\", \"a\"]\n\
             [joints.B]\ntype = \"revolute\"\nbetween = [\"ground.B\", \"b\"]\n\
             [couplings.pair]\ntype = \"gear\"\nbetween = [\"A\", \"B\"]\n{coupling}\n\
             [loads.rub]\ntype = \"friction\"\ncoupling = \"pair\"\nmu = 0.08\n{rub}\n\
             [drives.motor]\njoint = \"{drive}\"\nmotion = \"50*t\"\n\
             [loads.brake]\ntype = \"torque\"\non = \"{brake}\"\nvalue = \"6 N m\"\n\
             [solve]\nt_end = 0.1\n"
        )
    };
    let teeth = "teeth = [20, 45]\nmodule = \"2 mm\"";
    let halves = |h: f64| (1.0 - 0.04 * h) / (1.0 + 0.04 * h);
    // The brake turns against its wheel, which goes backwards.
    let forwards = effort(&pair(teeth, "", "A", "b")) * 45.0 / 20.0;
    close("forwards", 6.0 / forwards, halves(loss(20.0, 45.0)), within(1e-9));
    let backwards = effort(&pair(teeth, "", "B", "a")) * 20.0 / 45.0;
    close("backwards", 6.0 / backwards, halves(loss(20.0, 45.0)), within(1e-9));
    // Without a module the force is a moment; a stated factor; another angle.
    let plain = effort(&pair("teeth = [20, 45]", "", "A", "b")) * 45.0 / 20.0;
    close("without a module", 6.0 / plain, halves(loss(20.0, 45.0)), within(1e-9));
    let stated = effort(&pair("ratio = -0.5", "loss = 0.3", "A", "b")) * 2.0;
    close("stated", 6.0 / stated, halves(0.3), within(1e-9));
    let steep = effort(&pair(teeth, "pressure_angle = \"25 deg\"", "A", "b"));
    assert!(steep * 45.0 / 20.0 < forwards - 1e-4, "steeper teeth are fewer in touch");

    for (text, code, help) in [
        (pair("ratio = -0.5", "", "A", "b"), "M090", "`loss = 0.1`"),
        (pair(teeth, "loss = 0", "A", "b"), "M044", ""),
        (pair(teeth, "joint = \"A\"", "A", "b"), "M055", ""),
        (
            pair(teeth, "", "A", "b").replace("coupling = \"pair\"", "coupling = \"par\""),
            "M090",
            "write one of `pair`",
        ),
        (
            pair(teeth, "", "A", "b").replace("coupling = \"pair\"", "joint = \"A\"\nloss = 1"),
            "M090",
            "`coupling = ",
        ),
    ] {
        let faults = read(&Text::new(&text, "test")).diagnostics;
        let found = faults.iter().find(|fault| fault.code.0 == code);
        let found = found.unwrap_or_else(|| panic!("{code}: {}", messages(&faults)));
        assert!(found.help.as_deref().unwrap_or("").contains(help), "{found:?}");
    }
}

/// Sun, planet and a fixed ring: torques in the frame of the arm are those of the train at rest, with η₀ = η₁ η₂, so that
/// η = (1 − i₀ η₀)/(1 − i₀), H. W. Müller, *Die Umlaufgetriebe*.
#[test]
fn a_planetary_train_loses_what_rolls_against_its_arm() {
    let text = "[bodies.sun]\nmass = 1\ninertia = 1e-3\n[bodies.planet]\nmass = 0.2\ninertia = 1e-4\n\
         [bodies.arm]\nmass = 1\ninertia = 1e-3\npoints = { P = [\"40 mm\", 0] }\n\
         [ground]\npoints = { O = [0, 0] }\n\
         [joints.S]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"sun\"]\n\
         [joints.C]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"arm\"]\n\
         [joints.P]\ntype = \"revolute\"\nbetween = [\"arm.P\", \"planet\"]\n\
         [couplings.inner]\ntype = \"gear\"\nbetween = [\"S\", \"P\"]\nteeth = [20, 20]\nmodule = \"2 mm\"\ncarrier = \"arm\"\n\
         [couplings.outer]\ntype = \"gear\"\nbetween = [\"P\", \"ground.O\"]\nteeth = [20, 60]\nmodule = \"2 mm\"\n\
         internal = true\ncarrier = \"arm\"\n\
         [loads.inner]\ntype = \"friction\"\ncoupling = \"inner\"\nmu = 0.1\n\
         [loads.outer]\ntype = \"friction\"\ncoupling = \"outer\"\nmu = 0.1\n\
         [drives.motor]\njoint = \"S\"\nmotion = \"40*t\"\n\
         [loads.brake]\ntype = \"torque\"\non = \"arm\"\nvalue = \"-8 N m\"\n\
         [solve]\nt_end = 0.1\n";
    let half = |h: f64| (1.0 - 0.05 * h) / (1.0 + 0.05 * h);
    let still = half(loss(20.0, 20.0)) * half(loss(20.0, -60.0));
    let expected = (1.0 + 3.0 * still) / 4.0;
    // The arm goes at a quarter of the sun's speed.
    close("efficiency", 8.0 / (4.0 * effort(text)), expected, within(1e-9));
}

/// A pinion of twenty teeth drives a rack against a force.
#[test]
fn a_rack_has_the_loss_of_an_endless_wheel() {
    let text = "[bodies.pinion]\nmass = 1\ninertia = 1e-3\n[bodies.rack]\nmass = 2\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"pinion\"]\n\
         [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"rack\"]\naxis = [1, 0]\n\
         [couplings.mesh]\ntype = \"rack\"\nbetween = [\"A\", \"S\"]\nteeth = 20\nmodule = \"2 mm\"\n\
         [loads.rub]\ntype = \"friction\"\ncoupling = \"mesh\"\nmu = 0.08\n\
         [loads.push]\ntype = \"force\"\non = \"rack\"\nvector = [\"-300 N\", 0]\n\
         [drives.motor]\njoint = \"A\"\nmotion = \"5*t\"\n[solve]\nt_end = 0.1\n";
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let own = ((11.0_f64.powi(2) - (10.0 * cos).powi(2)).sqrt() - 10.0 * sin) / (PI * cos);
    let other = (1.0 / (PI * sin * cos)).min(10.0 * sin / (PI * cos));
    let h = PI / 20.0 * 2.0 * mean_sliding(own, other);
    let expected = (1.0 - 0.04 * h) / (1.0 + 0.04 * h);
    close("efficiency", 300.0 * 0.02 / effort(text), expected, within(1e-9));
}

/// A cam with a flat follower, over a turn and a half: the face rubs at the height of the lift, with μ N along itself.
#[test]
fn a_flat_follower_rubs_on_the_profile_of_its_cam() {
    let text = "[curves.lift]\ntype = \"cam-law\"\nturns = 2\nsegments = [\
         { rise = \"10 mm\", over = \"120 deg\", law = \"3-4-5\" }, { dwell = \"100 deg\" }, \
         { return = \"10 mm\", over = \"140 deg\", law = \"3-4-5\" }]\n\
         [parameters]\nbase = \"30 mm\"\n\
         [curves.profile]\ntype = \"cam\"\nlaw = \"lift\"\nbase_circle = \"base\"\nfollower = { kind = \"flat\" }\n\
         [bodies.cam]\nmass = \"0.5 kg\"\ninertia = \"1e-3 kg m^2\"\n\
         [bodies.follower]\nmass = \"0.3 kg\"\npoints = { F = [\"4 mm\", 0] }\n\
         [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n\
         [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n\
         [joints.contact]\ntype = \"line-on-curve\"\nbetween = [\"cam\", \"follower.F\"]\ncurve = \"profile\"\n\
         axis = [1, 0]\n\
         [loads.rub]\ntype = \"friction\"\njoint = \"contact\"\nmu = 0.12\n\
         [drives.motor]\njoint = \"O\"\nmotion = \"0.1 rad + 10 rad/s*t\"\n\
         [loads.press]\ntype = \"force\"\non = \"follower\"\nvector = [0, \"-200 N\"]\n\
         [initial]\ncontact = { guess = { angle = 0.1 } }\nguide = { guess = { position = \"30 mm\" } }\n\
         [solve]\nt_end = 0.96\nevery = 0.02\nrtol = 1e-11\natol = 1e-12\n";
    // Lift, slope and curvature of the law at an angle of the cam.
    let lift = |angle: f64| {
        let angle = angle.to_degrees().rem_euclid(360.0);
        let (u, over, sign) = match angle {
            ..120.0 => (angle / 120.0, 120.0, 1.0),
            ..220.0 => return [0.01, 0.0, 0.0],
            _ => ((angle - 220.0) / 140.0, 140.0, -1.0),
        };
        let over = f64::to_radians(over);
        let first = u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
        let slope = 30.0 * (u * (1.0 - u)).powi(2) / over;
        let bend = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (over * over);
        [(0.5 + sign * (first - 0.5)) * 0.01, sign * slope * 0.01, sign * bend * 0.01]
    };
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(text, method)));
        let is_drive = |source: &Source| matches!(source, Source::Drive(_));
        let drive = mechanism.compiled.sources.iter().position(is_drive).expect("a drive");
        let motion = solve(&mechanism);
        for sample in &motion.samples {
            let what = format!("{method} at {} s", sample.t);
            let [lift, slope, bend] = lift(0.1 + 10.0 * sample.t);
            let normal = 200.0 + 0.3 * 100.0 * bend;
            let torque = normal * (slope + 0.12 * (0.03 + lift));
            close(&what, sample.lambda[drive], torque, within(1e-6));
            let side = reaction(&mechanism, sample, "guide");
            close(&what, side[0], 0.12 * normal, within(1e-6));
        }
    }
}

/// A disc begins to slide and to turn in a bowl through three points, y = h (3 x² − |x|³)/2, whose spline is that very
/// curve: its motion against one that is integrated in the place of contact, its speed and its rate alone.
#[test]
fn a_disc_slides_down_a_bowl_of_points() {
    let [r, m, inertia, mu, g, h]: [f64; 6] = [0.1, 2.0, 0.01, 0.08, 9.81, 0.5];
    let text = format!(
        "[curves.bowl]\ntype = \"points\"\npoints = [[-1, {h}], [0, 0], [1, {h}]]\n\
         [curves.rim]\ntype = \"formula\"\nformula = [\"{r} m*cos(p)\", \"{r} m*sin(p)\"]\n\
         [bodies.disc]\nmass = {m}\ninertia = {inertia}\n\
         [joints.contact]\ntype = \"curve-on-curve\"\nbetween = [\"ground\", \"disc\"]\ncurve = \"bowl\"\n\
         second_curve = \"rim\"\ntangents = \"same\"\n\
         [loads.rub]\ntype = \"friction\"\njoint = \"contact\"\nmu = {mu}\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -{g}]\n\
         [initial]\ncontact = {{ angle1 = 0.1, rate1 = 0, guess = {{ angle2 = -2.2 }} }}\n\
         disc = {{ angle = 0, rate = 0, guess = {{ x = -0.84, y = 0.5 }} }}\n\
         [solve]\nt_end = 0.35\nevery = 0.05\nrtol = 1e-11\natol = 1e-12\n"
    );
    // Rates of the place x, of the speed v of the centre along the curve, and of the rate w, which turns to the left.
    let rates = |[x, v, w]: [f64; 3]| {
        let slope = h * (3.0 * x - 1.5 * x * x.abs());
        let steep = slope.hypot(1.0);
        let bend = 3.0 * h * (1.0 - x.abs()) / steep.powi(3);
        let turning = v * bend / (1.0 - bend * r);
        let normal = m * (g / steep + v * turning);
        let rub = -mu * normal * (v + r * w).signum();
        let speed_up = -g * slope / steep + rub / m;
        [v / ((1.0 - bend * r) * steep), speed_up, rub * r / inertia]
    };
    // Runge and Kutta's steps of order four.
    let step = |y: [f64; 3], dt: f64| {
        let ahead = |k: [f64; 3], by: f64| [0, 1, 2].map(|i| y[i] + by * k[i]);
        let first = rates(y);
        let second = rates(ahead(first, 0.5 * dt));
        let third = rates(ahead(second, 0.5 * dt));
        let last = rates(ahead(third, dt));
        [0, 1, 2].map(|i| y[i] + dt / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + last[i]))
    };
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(&text, method)));
        let measures = Measures::new(&mechanism, &["contact.angle1", "disc.rate"]);
        // On its way down it goes to the right, and slips forwards.
        let mut state = [-0.9, 1e-300, 0.0];
        for (k, sample) in solve(&mechanism).samples.iter().enumerate() {
            if k > 0 {
                state = (0..2000).fold(state, |state, _| step(state, 0.05 / 2000.0));
            }
            let what = format!("{method} at {} s", sample.t);
            assert!(state[1] + r * state[2] >= 0.0, "{what}: it slips");
            let found = measures.at(sample);
            close(&what, found[0] - 1.0, state[0], within(1e-9));
            close(&what, found[1], state[2], within(1e-7));
        }
    }
}

/// An eccentric disc turns under a flat face: the face rubs with μ N along itself, at the height R + e cos θ.
#[test]
fn a_flat_follower_rubs_on_its_disc() {
    for direction in ["0 deg", "180 deg"] {
        let text = format!(
            "[curves.disc]\ntype = \"formula\"\nformula = [\"30 mm*cos(p)\", \"8 mm + 30 mm*sin(p)\"]\n\
             [bodies.cam]\nmass = \"0.5 kg\"\ninertia = \"1e-3 kg m^2\"\n\
             [bodies.follower]\nmass = \"0.3 kg\"\npoints = {{ F = [\"4 mm\", 0] }}\n\
             [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n\
             [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n\
             [joints.contact]\ntype = \"line-on-curve\"\nbetween = [\"cam\", \"follower.F\"]\ncurve = \"disc\"\n\
             direction = \"{direction}\"\n\
             [loads.rub]\ntype = \"friction\"\njoint = \"contact\"\nmu = 0.12\n\
             [drives.motor]\njoint = \"O\"\nmotion = \"10 rad/s*t\"\n\
             [loads.press]\ntype = \"force\"\non = \"follower\"\nvector = [0, \"-200 N\"]\n\
             [initial]\ncontact = {{ guess = {{ angle = \"90 deg\" }} }}\n\
             guide = {{ guess = {{ position = \"40 mm\" }} }}\n\
             [solve]\nt_end = 0.6\nevery = 0.02\nrtol = 1e-11\natol = 1e-12\n"
        );
        for method in ["explicit", "radau"] {
            let mechanism = derive(model(&with_method(&text, method)));
            let is_drive = |source: &Source| matches!(source, Source::Drive(_));
            let drive = mechanism.compiled.sources.iter().position(is_drive).expect("a drive");
            for sample in &solve(&mechanism).samples {
                let what = format!("{direction}, {method} at {} s", sample.t);
                let (sin, cos) = (10.0 * sample.t).sin_cos();
                let normal = 200.0 - 0.3 * 100.0 * 0.008 * cos;
                let torque = normal * (-0.008 * sin + 0.12 * (0.03 + 0.008 * cos));
                close(&what, sample.lambda[drive], torque, within(1e-6));
                // The guide holds the follower where the disc drags it to.
                let side = reaction(&mechanism, sample, "guide");
                close(&what, side[0], 0.12 * normal, within(1e-6));
            }
        }
    }
}

/// A disc on a slider is pressed on a plate that slides: it is spun up to the plate's speed, then rolls.
#[test]
fn a_plate_spins_a_disc_up_until_it_rolls() {
    let text = "[curves.rim]\ntype = \"formula\"\nformula = [\"50 mm*cos(p)\", \"50 mm*sin(p)\"]\n\
         [bodies.plate]\nmass = \"4 kg\"\n[bodies.slider]\nmass = \"0.5 kg\"\n\
         [bodies.disc]\nmass = \"1 kg\"\ninertia = \"2e-3 kg m^2\"\n\
         [ground]\npoints = { O = [0, 0], top = [0, \"50 mm\"] }\n\
         [joints.way]\ntype = \"prismatic\"\nbetween = [\"ground.top\", \"plate\"]\naxis = [1, 0]\n\
         [joints.lift]\ntype = \"prismatic\"\nbetween = [\"ground.O\", \"slider\"]\naxis = [0, 1]\n\
         [joints.pin]\ntype = \"revolute\"\nbetween = [\"slider\", \"disc\"]\n\
         [joints.contact]\ntype = \"line-on-curve\"\nbetween = [\"disc\", \"plate\"]\ncurve = \"rim\"\naxis = [1, 0]\n\
         [loads.rub]\ntype = \"friction\"\njoint = \"contact\"\nmu = 0.2\n\
         [loads.press]\ntype = \"force\"\non = \"slider\"\nvector = [0, \"30 N\"]\n\
         [initial]\nway = { position = 0, velocity = 1.5 }\npin = { angle = 0, rate = 0 }\n\
         contact = { guess = { angle = \"90 deg\" } }\nlift = { guess = { position = 0 } }\n\
         [solve]\nt_end = 0.6\nevery = 0.02\nrtol = 1e-11\natol = 1e-12\n";
    let friction = 0.2 * 30.0;
    let (slowing, spinning) = (friction / 4.0, friction * 0.05 / 2e-3);
    let rolls = 1.5 / (slowing + spinning * 0.05);
    assert!(rolls < 0.5, "{rolls}");
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(text, method)));
        let measures = Measures::new(&mechanism, &["way.velocity", "pin.rate"]);
        let motion = solve(&mechanism);
        let stuck = motion.summary.changes.iter().find(|c| matches!(c.kind, ChangeKind::Stick(_)));
        close(method, stuck.expect("it rolls").t, rolls, within(1e-9));
        for sample in &motion.samples {
            let what = format!("{method} at {} s", sample.t);
            let t = sample.t.min(rolls);
            let found = measures.at(sample);
            close(&what, found[0], 1.5 - slowing * t, within(1e-9));
            // The plate above the disc drags it backwards.
            close(&what, found[1], -spinning * t, within(1e-7));
        }
    }
}

/// Two discs, one of them on a slider, are pressed together: friction μ P until their rims go at one speed.
#[test]
fn two_discs_rub_until_they_roll() {
    let text = "[curves.one]\ntype = \"formula\"\nformula = [\"60 mm*cos(p)\", \"60 mm*sin(p)\"]\n\
         [curves.two]\ntype = \"formula\"\nformula = [\"40 mm*cos(p)\", \"40 mm*sin(p)\"]\n\
         [ground]\npoints = { O = [0, 0], Q = [\"100 mm\", 0] }\n\
         [bodies.one]\nmass = 1\ninertia = 4e-3\n[bodies.slider]\nmass = 0.5\n[bodies.two]\nmass = 1\ninertia = 1e-3\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"one\"]\n\
         [joints.way]\ntype = \"prismatic\"\nbetween = [\"ground.Q\", \"slider\"]\naxis = [1, 0]\n\
         [joints.B]\ntype = \"revolute\"\nbetween = [\"slider\", \"two\"]\n\
         [joints.contact]\ntype = \"curve-on-curve\"\nbetween = [\"one\", \"two\"]\ncurve = \"one\"\nsecond_curve = \"two\"\n\
         [loads.rub]\ntype = \"friction\"\njoint = \"contact\"\nmu = 0.25\n\
         [loads.press]\ntype = \"force\"\non = \"slider\"\nvector = [\"-20 N\", 0]\n\
         [initial]\nA = { angle = 0, rate = 30 }\nB = { angle = 0, rate = 0 }\n\
         contact = { guess = { angle1 = 0, angle2 = \"180 deg\" } }\nway = { guess = { position = 0 } }\n\
         [solve]\nt_end = 0.6\nevery = 0.02\nrtol = 1e-11\natol = 1e-12\n";
    let friction = 0.25 * 20.0;
    let [slowing, spinning] = [friction * 0.06 / 4e-3, friction * 0.04 / 1e-3];
    let rolls = 30.0 * 0.06 / (slowing * 0.06 + spinning * 0.04);
    assert!(rolls < 0.5, "{rolls}");
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(text, method)));
        let measures = Measures::new(&mechanism, &["A.rate", "B.rate"]);
        let motion = solve(&mechanism);
        let stuck = motion.summary.changes.iter().find(|c| matches!(c.kind, ChangeKind::Stick(_)));
        close(method, stuck.expect("they roll").t, rolls, within(1e-9));
        for sample in &motion.samples {
            let what = format!("{method} at {} s", sample.t);
            let (t, found) = (sample.t.min(rolls), measures.at(sample));
            close(&what, found[0], 30.0 - slowing * t, within(1e-8));
            close(&what, found[1], -spinning * t, within(1e-8));
            let force = reaction(&mechanism, sample, "contact");
            close(&what, force[0].abs(), 20.0, within(1e-7));
        }
    }
    // Curves that roll take the friction that they need.
    let rolling =
        text.replace("second_curve = \"two\"\n", "second_curve = \"two\"\nrolling = [0, \"pi\"]\n");
    let faults = read(&Text::new(&rolling, "test")).diagnostics;
    assert_eq!(faults[0].code.0, "M090", "{}", messages(&faults));
}
