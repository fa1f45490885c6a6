//! Points on curves against reference motions, straight lines as slots, and curves through points.

use crate::support::elements::Quantity::{Acceleration, Measure, Position, Velocity};
use crate::support::elements::{check, column, number, reference, text};
use crate::support::{Measures, Within, at, close, coordinate, derive, model, solve};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

#[test]
fn a_bead_on_an_ellipse() {
    let columns = [
        ("p", Position("p", 1.0)),
        ("x", Measure("bead.x", 1.0)),
        ("y", Measure("bead.y", 1.0)),
        ("vx", Measure("bead.vx", 1.0)),
        ("vy", Measure("bead.vy", 1.0)),
        ("ax", Acceleration("bead_x", 1.0)),
        ("ay", Acceleration("bead_y", 1.0)),
    ];
    let bead = text("bead-ellipse").replace("t_end = \"1.5 s\"", "t_end = \"3 s\"");
    check(&bead, "elements/bead_ellipse", &columns);
    check(&format!("{bead}method = \"radau\"\n"), "elements/bead_ellipse", &columns);
}

/// The hoop turns, and drags.
#[test]
fn a_bead_on_a_hoop() {
    let columns = [
        ("th", Position("th", 1.0)),
        ("dth", Velocity("th", 1.0)),
        ("d2th", Acceleration("th", 1.0)),
    ];
    check(&text("bead-hoop"), "elements/bead_hoop", &columns);
}

#[test]
fn a_bead_on_a_cycloid() {
    let columns = [
        ("x", Measure("bead.x", 1.0)),
        ("y", Measure("bead.y", 1.0)),
        ("vx", Measure("bead.vx", 1.0)),
        ("vy", Measure("bead.vy", 1.0)),
    ];
    check(&text("bead-cycloid"), "elements/bead_cycloid", &columns);
}

/// A rod between two straight tracks, by slots and by curves, one of them turned and moving: the same motion, the
/// same reactions, a spring and friction on the way included.
#[test]
fn a_straight_curve_is_a_slot() {
    let rod = |joint: &str, rest: &str| {
        let text = format!(
            "[curves.line]\ntype = \"formula\"\nformula = [\"0.6 m*p\", \"0.8 m*p\"]\nrange = [-1, 1]\n\
             [bodies.carriage]\nmass = \"2 kg\"\ninertia = 1\npoints = {{ T = [\"0.1 m\", 0] }}\n\
             [bodies.rod]\nmass = \"1 kg\"\ninertia = \"0.1 kg m^2\"\npoints = {{ P = [0, 0], C = [\"0.2 m\", 0] }}\n\
             com = [\"0.2 m\", 0]\n\
             [joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"carriage\"]\naxis = [1, 0]\n\
             [joints.track]\nbetween = [\"carriage.T\", \"rod.P\"]\n{joint}\n\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
             [loads.tie]\ntype = \"spring\"\nbetween = [\"ground\", \"carriage\"]\nstiffness = \"50 N/m\"\n\
             length = 0\n{rest}[solve]\nt_end = 1\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n"
        );
        derive(model(&text))
    };
    let slot = rod(
        "type = \"slot\"\naxis = [0.6, 0.8]\ncut = true",
        "[initial]\ntrack = { position = \"0.3 m\", velocity = 0, angle = 0.4, rate = 0 }\nrail = { position = \"0.1 m\", velocity = 0 }\n",
    );
    let curve = rod(
        "type = \"point-on-curve\"\ncurve = \"line\"",
        "[initial]\ntrack = { angle = 0.3, rate = 0 }\nrod = { angle = 0.4, rate = 0 }\nrail = { position = \"0.1 m\", velocity = 0 }\n",
    );
    let names = ["rod.x", "rod.y", "rod.angle", "rail.position", "rail.velocity"];
    let (of_slot, of_curve) = (solve(&slot), solve(&curve));
    let (slots, curves) = (Measures::new(&slot, &names), Measures::new(&curve, &names));
    for (a, b) in of_slot.samples.iter().zip(&of_curve.samples) {
        for ((name, a), b) in names.iter().zip(slots.at(a)).zip(curves.at(b)) {
            close(name, b, a, within(1e-9));
        }
        let [a, b] = [(&slot, a), (&curve, b)]
            .map(|(m, sample)| crate::support::reaction(m, sample, "track"));
        for axis in 0..2 {
            close("reaction", b[axis], a[axis], within(1e-7));
        }
    }
}

/// The ends of a rod on two axes: its middle goes around a circle with the rate of the rod.
#[test]
fn a_trammel() {
    let text = "[curves.across]\ntype = \"formula\"\nformula = [\"1 m*p\", 0]\nrange = [-1, 1]\n\
        [curves.up]\ntype = \"points\"\npoints = [[0, \"-1 m\"], [0, 0], [0, \"1 m\"]]\n\
        [bodies.rod]\nmass = \"1 kg\"\ninertia = \"0.1 kg m^2\"\n\
        points = { A = [\"-0.5 m\", 0], B = [\"0.5 m\", 0] }\n\
        [joints.A]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"rod.A\"]\ncurve = \"across\"\n\
        [joints.B]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"rod.B\"]\ncurve = \"up\"\n\
        [initial]\nrod = { angle = \"-60 deg\", rate = \"2 rad/s\" }\n\
        [solve]\nt_end = 1\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["rod.x", "rod.y", "A.angle", "B.angle"]);
    for sample in &motion.samples {
        let angle = (-60f64).to_radians() + 2.0 * sample.t;
        let (sin, cos) = angle.sin_cos();
        // The curve through points counts them: the origin is its second.
        let expected = [-0.5 * cos, 0.5 * sin, -cos, 1.0 + sin];
        for (found, expected) in measures.at(sample).into_iter().zip(expected) {
            close(&format!("at {} s", sample.t), found, expected, within(1e-9));
        }
    }
}

/// A roller on the pitch curve of a translating follower: the force of the cam leans by the pressure angle.
#[test]
fn a_cam_with_a_translating_roller() {
    let text = "[curves.lift]\ntype = \"cam-law\"\nsegments = [{ rise = \"12 mm\", over = \"150 deg\", \
        law = \"cycloidal\" }, { return = \"12 mm\", over = \"210 deg\", law = \"cycloidal\" }]\n\
        [curves.pitch]\ntype = \"formula\"\n\
        formula = [\"(40 mm + lift(p))*sin(p)\", \"(40 mm + lift(p))*cos(p)\"]\n\
        [bodies.cam]\nmass = \"0.5 kg\"\ninertia = \"1e-3 kg m^2\"\n\
        [bodies.follower]\nmass = \"0.3 kg\"\ninertia = \"1e-4 kg m^2\"\n\
        [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n\
        [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n\
        [joints.contact]\ntype = \"point-on-curve\"\nbetween = [\"cam\", \"follower\"]\ncurve = \"pitch\"\n\
        [drives.motor]\njoint = \"O\"\nmotion = \"10 rad/s*t\"\n\
        [loads.press]\ntype = \"force\"\non = \"follower\"\nvector = [0, \"-200 N\"]\n\
        [initial]\nguide = { guess = { position = \"40 mm\" } }\n\
        [solve]\nt_end = 0.6\nevery = 0.02\nrtol = 1e-11\natol = 1e-12\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["follower.y"]);
    let tau = std::f64::consts::TAU;
    for sample in &motion.samples {
        // The cycloidal law, its slope and its curvature.
        let angle = 10.0 * sample.t;
        let over = if angle < 150f64.to_radians() { 150f64 } else { 210.0 }.to_radians();
        let rises = angle < 150f64.to_radians();
        let u = if rises { angle / over } else { (angle - 150f64.to_radians()) / over };
        let [f, slope, bend] = [
            u - (tau * u).sin() / tau,
            (1.0 - (tau * u).cos()) / over,
            tau * (tau * u).sin() / (over * over),
        ];
        let sign = if rises { 0.012 } else { -0.012 };
        let lift = if rises { 0.012 * f } else { 0.012 * (1.0 - f) };
        let what = format!("at {} s", sample.t);
        close(&what, measures.at(sample)[0], 0.04 + lift, within(1e-11));

        // Along the normal of the pitch curve, with all of the acceleration.
        let push = 200.0 + 0.3 * 100.0 * sign * bend;
        let lean = sign * slope / (0.04 + lift);
        let force = crate::support::reaction(&mechanism, sample, "contact");
        close(&what, force[1], push, within(1e-7));
        close(&what, force[0].abs(), (push * lean).abs(), within(1e-7));
    }
}

/// A roller on a swinging arm, with the reference's pitch curve: the arm swings as the law says, and the force leans
/// from the way of the roller by the pressure angle.
#[test]
fn a_cam_with_a_swinging_roller() {
    let text = "[parameters]\nf = \"90 mm\"\nl = \"70 mm\"\np0 = \"acos((l^2 + f^2 - (45 mm)^2)/(2*l*f))\"\n\
        [curves.swing]\ntype = \"cam-law\"\nturns = 2\nsegments = [\n\
        { rise = \"15 deg\", over = \"120 deg\", law = \"4-5-6-7\" }, { dwell = \"60 deg\" },\n\
        { return = \"15 deg\", over = \"150 deg\", law = \"4-5-6-7\" }, { dwell = \"30 deg\" }]\n\
        [curves.pitch]\ntype = \"formula\"\nformula = [\n\
        \"cos(p)*(f - l*cos(p0 + swing(p))) + sin(p)*l*sin(p0 + swing(p))\",\n\
        \"-sin(p)*(f - l*cos(p0 + swing(p))) + cos(p)*l*sin(p0 + swing(p))\"]\n\
        [ground]\npoints = { O = [0, 0], B = [\"f\", 0] }\n\
        [bodies.cam]\nmass = 1\ninertia = 1\n[bodies.arm]\nmass = 1\ninertia = 1\n\
        points = { B = [0, 0], R = [\"-l\", 0] }\n\
        [joints.O]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"cam\"]\n\
        [joints.B]\ntype = \"revolute\"\nbetween = [\"ground.B\", \"arm.B\"]\n\
        [joints.contact]\ntype = \"point-on-curve\"\nbetween = [\"cam\", \"arm.R\"]\ncurve = \"pitch\"\n\
        [drives.motor]\njoint = \"O\"\nmotion = \"1 rad/s*t\"\n\
        [loads.press]\ntype = \"torque\"\non = \"arm\"\nvalue = \"100 N m\"\n\
        [initial]\nB = { guess = { angle = \"-p0\" } }\ncontact = { guess = { angle = 0 } }\n\
        [solve]\nt_end = 6.2831\nrtol = 1e-11\natol = 1e-12\n";
    let data = reference("elements/cam_swinging_roller");
    let [th, p, dp, lean] = ["th", "p", "dp", "pressure_angle_deg"].map(|name| column(&data, name));
    let rows = data["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .filter(|row| number(row, th) < std::f64::consts::TAU - 1e-3);
    let rows: Vec<_> = rows.collect();
    let times: Vec<String> = rows.iter().map(|row| format!("{:?}", number(row, th))).collect();
    let mechanism = derive(model(&format!("{text}times = [{}]\n", times.join(", "))));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["B.angle", "B.rate"]);
    for row in rows {
        let sample = at(&motion, number(row, th));
        let what = format!("at {} rad", sample.t);
        let [angle, rate] = [0, 1].map(|k| measures.at(sample)[k]);
        close(&what, -angle, number(row, p), within(1e-10));
        close(&what, -rate, number(row, dp), within(1e-10));
        // The roller moves across the arm.
        let force = crate::support::reaction(&mechanism, sample, "contact");
        let (sin, cos) = angle.sin_cos();
        let (along, across) = (force[0] * cos + force[1] * sin, force[1] * cos - force[0] * sin);
        let expected = number(row, lean).abs();
        close(&what, (along / across).atan().to_degrees().abs(), expected, within(1e-6));
    }
}

/// A pitch curve may call a law that stands below it, and a run that leaves the law is told so.
#[test]
fn a_run_ends_where_the_law_of_a_curve_does() {
    let text = "[curves.pitch]\ntype = \"formula\"\n\
        formula = [\"(40 mm + lift(p))*sin(p)\", \"(40 mm + lift(p))*cos(p)\"]\n\
        [curves.lift]\ntype = \"cam-law\"\nsegments = [{ rise = \"12 mm\", over = \"90 deg\", \
        law = \"cycloidal\" }, { dwell = \"90 deg\" }]\n\
        [bodies.cam]\nmass = 1\ninertia = 1\n[bodies.follower]\nmass = 1\ninertia = 1\n\
        [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n\
        [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n\
        [joints.contact]\ntype = \"point-on-curve\"\nbetween = [\"cam\", \"follower\"]\ncurve = \"pitch\"\n\
        [drives.motor]\njoint = \"O\"\nmotion = \"1 rad/s*t\"\n\
        [initial]\nguide = { guess = { position = \"40 mm\" } }\n[solve]\nt_end = 4\n";
    let mechanism = derive(model(text));
    let start = mechanism.start().expect("a start");
    let simulation = mechanism.simulation().expect("equations");
    let mut keep = |_: &bksim::sim::run::Sample| bksim::dae::Control::Continue;
    let failure =
        simulation.run(&start, &mut keep, &|| false).expect_err("the law ends at 180 deg");
    let fault = simulation.diagnose(&failure);
    assert_eq!(fault.code.0, "R014", "{}", fault.message);
    assert!((failure.summary.t - std::f64::consts::PI).abs() < 1e-6, "{}", failure.summary.t);
}

/// A door with two rollers in a bent track: its start and its run go over the knots of the curve.
const DOOR: &str = "[curves.track]\ntype = \"points\"\npoints = [[0, \"-0.4 m\"], [0, \"0.6 m\"], [0, \"1.5 m\"],\n\
    [\"0.08 m\", \"1.95 m\"], [\"0.4 m\", \"2.25 m\"], [\"0.9 m\", \"2.35 m\"], [\"1.8 m\", \"2.38 m\"]]\n\
    [bodies.door]\nmass = \"40 kg\"\ncom = [0, \"1 m\"]\ninertia = \"14 kg m^2\"\n\
    points = { L = [0, 0], U = [0, \"2 m\"] }\n\
    [joints.lower]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"door.L\"]\ncurve = \"track\"\n\
    [joints.upper]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"door.U\"]\ncurve = \"track\"\n\
    [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
    [loads.rope]\ntype = \"force\"\non = \"door.U\"\nvector = [\"400 N\", \"300 N\"]\n\
    [initial]\nlower = { angle = 0.6, rate = 0 }\nupper = { guess = { angle = 3 } }\n\
    [solve]\nt_end = 1\nevery = 0.05\nrtol = 1e-9\natol = 1e-10\n";

#[test]
fn a_door_starts_and_runs_over_the_knots_of_its_track() {
    let mechanism = derive(model(DOOR));
    let start = mechanism.start().expect("a start");
    let lower = coordinate(&mechanism, "lower_angle");
    assert_eq!(start.q[lower], 0.6, "what is stated holds");
    assert!(start.position_residual < 1e-12, "{}", start.position_residual);
    let motion = solve(&mechanism);
    let upper = coordinate(&mechanism, "upper_angle");
    let [first, last] = [&motion.samples[0], motion.samples.last().expect("a sample")];
    assert!(last.q[upper].floor() > first.q[upper].floor(), "it passes a knot");
    // Both rollers are 2 m apart on the curve, and no energy is lost.
    let measures = Measures::new(&mechanism, &["door.L.x", "door.L.y", "door.U.x", "door.U.y"]);
    for sample in &motion.samples {
        let at = measures.at(sample);
        close("distance", (at[2] - at[0]).hypot(at[3] - at[1]), 2.0, within(1e-9));
    }
    let energy = |s: &bksim::sim::run::Sample| s.energy.kinetic + s.energy.potential;
    let work = motion.summary.energy.work;
    close("energy", energy(last) - energy(first), work, within(1e-5));
    let radau = solve(&derive(model(&format!("{DOOR}method = \"radau\"\n"))));
    let other = radau.samples.last().expect("a sample");
    close("upper, by Radau", other.q[upper], last.q[upper], within(1e-5));
}
