//! Curves that are left: hills that are left, cams that are too fast, bounces, and outlines that rub.

use crate::support::{Measures, Within, at, close, derive, model, signal, solve, with_method};
use bksim::sim::hybrid::ChangeKind;
use bksim::sim::run::Sample;

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// The first instant at which something parts.
fn parted(changes: &[bksim::sim::hybrid::Change]) -> f64 {
    let part = changes.iter().find(|change| matches!(change.kind, ChangeKind::Part(_)));
    part.expect("it parts").t
}

/// A point on the hill y = −x⁴/m³, pushed off its top at 1 m/s.
fn hill(method: &str) -> String {
    let text = "[curves.hill]\ntype = \"formula\"\nformula = [\"p*1 m\", \"-1 m*p^4\"]\nrange = [-1, 1]\n\
         [bodies.ball]\nmass = 2\nfree = true\npoints = { C = [0, 0] }\n\
         [joints.slope]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"ball.C\"]\ncurve = \"hill\"\n\
         lifts = true\nside = \"left\"\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
         [initial]\nball = { x = 0, y = 0, vx = 1, vy = 0 }\n\
         [solve]\nt_end = 0.8\nevery = 0.01\nrtol = 1e-11\natol = 1e-12\n";
    with_method(text, method)
}

#[test]
fn a_point_leaves_a_hill_where_it_would_have_to_be_pulled() {
    // N = 0: g (1 + f′²) = −f″ v², v² = v₀² − 2 g f.
    let g = 9.81;
    let [f, slope, bend] = [|x: f64| -x.powi(4), |x: f64| -4.0 * x.powi(3), |x: f64| -12.0 * x * x];
    let pressed = |x: f64| g * (1.0 + slope(x).powi(2)) + bend(x) * (1.0 - 2.0 * g * f(x));
    let (mut before, mut after) = (0.0, 0.8);
    assert!(pressed(after) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (before + after);
        *if pressed(middle) > 0.0 { &mut before } else { &mut after } = middle;
    }
    let x = before;
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&hill(method)));
        let motion = solve(&mechanism);
        let off = parted(&motion.summary.changes);
        let measures = Measures::new(&mechanism, &["ball.x", "ball.y", "ball.vx", "ball.vy"]);
        // The parabola after it goes back to where it left.
        let speed = ((1.0 - 2.0 * g * f(x)) / (1.0 + slope(x).powi(2))).sqrt();
        let mut n_flying = 0;
        for sample in &motion.samples {
            let [px, py, vx, vy] = [0, 1, 2, 3].map(|k| measures.at(sample)[k]);
            if sample.t < off {
                close("on the hill", py, f(px), within(1e-10));
                let across = 1.0 + slope(px).powi(2);
                let force = 2.0 * (g + bend(px) * vx * vx) / across.sqrt();
                close("the force", signal_of(&mechanism, sample), force, within(1e-7));
            } else {
                let since = sample.t - off;
                let climb = slope(x) * speed;
                close("x", px, x + speed * since, within(1e-8));
                close("y", py, f(x) + climb * since - 0.5 * g * since * since, within(1e-8));
                close("vx", vx, speed, within(1e-8));
                close("vy", vy, climb - g * since, within(1e-8));
                n_flying += 1;
            }
        }
        assert!(n_flying > 5, "{n_flying}");
    }
}

/// The force of the one contact.
fn signal_of(mechanism: &bksim::Mechanism, sample: &Sample) -> f64 {
    let rows = mechanism.system.constraints.iter().enumerate();
    let touch = rows.filter(|(_, row)| row.direction == "touch").map(|(k, _)| sample.lambda[k]);
    touch.sum()
}

/// A follower of 0.4 kg under a spring of 500 N/m on an eccentric disc of 30 mm, 10 mm from its axis.
fn eccentric(contact: &str, rate: f64, t_end: f64, follower: [&str; 2]) -> String {
    let [point, start] = follower;
    format!(
        "[curves.disc]\ntype = \"formula\"\nformula = [\"30 mm*cos(p)\", \"30 mm*sin(p) - 10 mm\"]\n\
         [bodies.cam]\nmass = \"0.5 kg\"\ninertia = \"1e-3 kg m^2\"\n\
         [bodies.follower]\nmass = \"0.4 kg\"\npoints = {{ F = [{point}, 0] }}\n\
         [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n\
         [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"follower\"]\naxis = [0, 1]\n\
         [joints.contact]\nbetween = [\"cam\", \"follower.F\"]\ncurve = \"disc\"\n{contact}\n\
         [drives.motor]\njoint = \"O\"\nmotion = \"{rate:?} rad/s*t\"\n\
         [loads.spring]\ntype = \"force\"\non = \"follower\"\nvector = [0, \"-20 N - 500 N/m*(guide.position - 20 mm)\"]\n\
         [initial]\ncontact = {{ guess = {{ angle = \"90 deg\" }} }}\nguide = {{ {start} }}\n\
         [solve]\nt_end = {t_end:?}\nevery = 0.002\nrtol = 1e-11\natol = 1e-12\n"
    )
}

const LIFTS: &str = "lifts = true\nside = \"right\"";

#[test]
fn a_flat_follower_lifts_off_a_fast_eccentric_and_lands_again() {
    // y = R − e cos ωt: lift-off as in `a_follower_lifts_off_where_its_cam_would_have_to_pull`.
    let (m, k, e, omega) = (0.4, 500.0, 0.01, 100.0_f64);
    let off = (-(k * e + 20.0) / (m * e * omega * omega - k * e)).acos() / omega;
    let follower = ["\"4 mm\"", "position = \"20 mm\", velocity = 0"];
    let flat = format!("type = \"line-on-curve\"\naxis = [1, 0]\n{LIFTS}");
    for method in ["explicit", "radau"] {
        let mechanism =
            derive(model(&with_method(&eccentric(&flat, omega, 0.06, follower), method)));
        let motion = solve(&mechanism);
        close("the lift-off", parted(&motion.summary.changes), off, within(1e-9));
        let measures = Measures::new(&mechanism, &["follower.y"]);
        let (x, v) = (e * (1.0 - (omega * off).cos()), e * omega * (omega * off).sin());
        let (free, middle) = ((k / m).sqrt(), -20.0 / k);
        let flight = |t: f64| {
            let s = free * (t - off);
            0.02 + middle + (x - middle) * s.cos() + v / free * s.sin()
        };
        let hit = motion.summary.changes.iter().find(|c| matches!(c.kind, ChangeKind::Hit(..)));
        let landed = hit.expect("it lands").t;
        close("the landing", flight(landed), 0.03 - e * (omega * landed).cos(), within(1e-9));
        for sample in motion.samples.iter().filter(|sample| sample.t < landed) {
            let y = measures.at(sample)[0];
            let on_cam = 0.03 - e * (omega * sample.t).cos();
            let expected = if sample.t > off { flight(sample.t) } else { on_cam };
            close("y", y, expected, within(1e-9));
        }
    }
}

#[test]
fn a_roller_that_bears_moves_and_presses_as_one_that_is_held() {
    let follower = ["0", "position = \"30 mm\", velocity = 0"];
    let roller = "type = \"point-on-curve\"\nradius = \"10 mm\"\nside = \"right\"";
    let held = derive(model(&eccentric(roller, 20.0, 0.3, follower)));
    let lifting =
        derive(model(&eccentric(&format!("{roller}\nlifts = true"), 20.0, 0.3, follower)));
    let motions = [solve(&held), solve(&lifting)];
    let changes = &motions[1].summary.changes;
    assert!(changes.iter().all(|change| !matches!(change.kind, ChangeKind::Part(_))));
    let [one, other] =
        [&held, &lifting].map(|of| Measures::new(of, &["follower.y", "follower.vy"]));
    for (a, b) in motions[0].samples.iter().zip(&motions[1].samples) {
        for k in [0, 1] {
            close("as held", other.at(b)[k], one.at(a)[k], within(1e-8));
        }
        let force = crate::support::reaction(&held, a, "contact");
        close("the force", signal_of(&lifting, b), force[0].hypot(force[1]), within(1e-6));
    }
}

#[test]
fn a_point_bounces_off_a_slope_by_newtons_law() {
    // Falls 1 m onto a slope of 1:1 at x = 0, on a parabola y = x + x²/2.
    let text = "[curves.bowl]\ntype = \"formula\"\nformula = [\"p*1 m\", \"(p + 0.5*p^2)*1 m\"]\nrange = [-1, 1]\n\
         [bodies.ball]\nmass = 2\nfree = true\npoints = { C = [0, 0] }\n\
         [joints.slope]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"ball.C\"]\ncurve = \"bowl\"\n\
         lifts = true\nside = \"left\"\nrestitution = 0.6\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
         [initial]\nball = { x = 0, y = 1, vx = 0, vy = 0 }\n\
         [solve]\nt_end = 0.5\nevery = 0.01\nrtol = 1e-11\natol = 1e-12\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let hit = motion.summary.changes.iter().find(|c| matches!(c.kind, ChangeKind::Hit(..)));
    let fall = (2.0_f64 / 9.81).sqrt();
    close("the fall", hit.expect("it hits").t, fall, within(1e-9));
    // Along the slope the speed stays, across it 0.6 of it comes back.
    let (speed, part) = (9.81 * fall, std::f64::consts::FRAC_1_SQRT_2);
    let (along, across) = (-speed * part, 0.6 * speed * part);
    let [vx, vy] = [part * (along - across), part * (along + across)];
    let measures = Measures::new(&mechanism, &["ball.x", "ball.y"]);
    let end = at(&motion, 0.5);
    let since = 0.5 - fall;
    close("x", measures.at(end)[0], vx * since, within(1e-8));
    close("y", measures.at(end)[1], vy * since - 0.5 * 9.81 * since * since, within(1e-8));
}

/// A wheel on a wheel, as two curves and as two discs of a contact.
fn wheels(how: &str, mu: f64, angle: f64) -> String {
    let (sin, cos) = angle.sin_cos();
    format!(
        "[ground]\npoints = {{ O = [0, 0] }}\n\
         [bodies.wheel]\nmass = 2\ninertia = 0.01\nfree = true\npoints = {{ C = [0, 0] }}\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n{}\
         [initial]\nwheel = {{ x = {}, y = {}, angle = 0, vx = 0, vy = 0, rate = 0 }}\n\
         [outputs]\nx = \"wheel.x\"\ny = \"wheel.y\"\nturn = \"wheel.angle\"\n\
         [solve]\nt_end = 0.9\nevery = 0.01\nrtol = 1e-10\natol = 1e-12\n",
        how.replace("MU", &format!("{mu:?}")),
        0.6 * sin,
        0.6 * cos,
    )
}

const DISCS: &str = "[contacts.c]\nbetween = [{ disc = \"ground.O\", radius = 0.5 }, { disc = \"wheel.C\", radius = 0.1 }]\nmu = MU\n";
const CURVES: &str = "[curves.large]\ntype = \"formula\"\nformula = [\"0.5 m*sin(p)\", \"0.5 m*cos(p)\"]\n\
    [curves.small]\ntype = \"formula\"\nformula = [\"0.1 m*cos(p)\", \"0.1 m*sin(p)\"]\n\
    [joints.c]\ntype = \"curve-on-curve\"\nbetween = [\"ground.O\", \"wheel.C\"]\ncurve = \"large\"\nsecond_curve = \"small\"\n\
    tangents = \"same\"\nlifts = true\nside = \"left\"\nmu = MU\n";

#[test]
fn a_wheel_leaves_a_wheel_at_the_angle_of_the_textbook() {
    // Without friction cos φ = 2/3 cos φ₀ from rest.
    let start = 0.1_f64;
    let curves = CURVES.replace("mu = MU\n", "");
    let text = wheels(&curves, 0.0, start)
        .replace("[initial]\n", "[initial]\nc = { guess = { angle1 = 0.1, angle2 = -1.67 } }\n");
    let mechanism = derive(model(&text.replace("t_end = 0.9", "t_end = 1.2")));
    let motion = solve(&mechanism);
    let off = parted(&motion.summary.changes);
    let measures = Measures::new(&mechanism, &["wheel.x", "wheel.y"]);
    let last = motion.samples.iter().rev().find(|sample| sample.t <= off).expect("a sample");
    let first = motion.samples.iter().find(|sample| sample.t >= off).expect("a sample");
    let angle = |sample: &Sample| measures.at(sample)[0].atan2(measures.at(sample)[1]);
    let leaving = (2.0 / 3.0 * start.cos()).acos();
    assert!(angle(last) <= leaving + 1e-9 && angle(first) >= leaving - 1e-9);
    // On the parabola backwards from a sample after it: the speed at the angle by energy.
    let speed = (2.0 * 9.81 * 0.6 * (start.cos() - leaving.cos())).sqrt();
    let since = first.t - off;
    close(
        "x",
        measures.at(first)[0],
        0.6 * leaving.sin() + speed * leaving.cos() * since,
        within(1e-8),
    );
}

#[test]
fn curves_that_rub_move_as_discs_that_rub() {
    for mu in [0.05, 0.5] {
        let guess = "[initial]\nc = { guess = { angle1 = 0.3, angle2 = -1.87 } }\n";
        let discs = derive(model(&wheels(DISCS, mu, 0.3)));
        let curves = derive(model(&wheels(CURVES, mu, 0.3).replace("[initial]\n", guess)));
        let motions = [solve(&discs), solve(&curves)];
        for (a, b) in motions[0].samples.iter().zip(&motions[1].samples) {
            for name in ["x", "y", "turn"] {
                close(name, signal(&curves, b, name), signal(&discs, a, name), within(2e-7));
            }
        }
    }
}
