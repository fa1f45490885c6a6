//! Many bodies in touch, disks that roll with resistance, and pins with play.

use std::fmt::Write as _;

use bksim::model::LoadId;
use bksim::sim::hybrid::ChangeKind;
use bksim::{Mechanism, Motion};

use crate::support::{Within, at, close, coordinate, derive, model, signal, solve};

const FLOOR: &str = "[ground]\npoints = { O = [0, 0], A = [\"-1 m\", 0], B = [\"9 m\", 0] }\n\
                     [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n";

/// Dominoes of 50 mm in a row, the first let go tilted.
fn dominoes(n: usize, solve: &str) -> String {
    let outline = |k: usize| {
        let names = ["a", "b", "c", "d"].map(|corner| format!("\"d{k}.{corner}\""));
        format!("{{ outline = [{}] }}", names.join(", "))
    };
    let (width, height, tilt): (f64, f64, f64) = (0.008, 0.05, 0.25);
    let mut text = String::from(FLOOR);
    for k in 0..n {
        let (sin, cos) = if k == 0 { tilt.sin_cos() } else { (0.0, 1.0) };
        let place = 0.025 * f64::from(u8::try_from(k).expect("few"));
        let x = place + width / 2.0 * (1.0 - cos) + height / 2.0 * sin;
        let y = height / 2.0 * cos + width / 2.0 * sin;
        let own = outline(k);
        let _ = write!(
            text,
            "[bodies.d{k}]\nmass = \"20 g\"\ninertia = \"4.27e-6 kg m^2\"\nfree = true\n\
             points = {{ a = [\"-4 mm\", \"-25 mm\"], b = [\"4 mm\", \"-25 mm\"], \
             c = [\"4 mm\", \"25 mm\"], d = [\"-4 mm\", \"25 mm\"] }}\n\
             [contacts.floor{k}]\nbetween = [{{ line = [\"ground.A\", \"ground.B\"] }}, {own}]\nmu = 0.3\n\
             [initial.d{k}]\nx = {x}\ny = {y}\nangle = {}\nvx = 0\nvy = 0\nrate = 0\n",
            -sin.asin()
        );
        if k > 0 {
            let before = outline(k - 1);
            let _ = write!(text, "[contacts.c{k}]\nbetween = [{before}, {own}]\nmu = 0.3\n");
        }
    }
    text + "[outputs]\nforce = \"contacts.floor0.force + contacts.floor1.force + contacts.floor2.force + contacts.floor3.force\"\n"
        + solve
}

/// The first hit of each contact between dominoes, in order.
fn first_hits(mechanism: &Mechanism, motion: &Motion) -> Vec<(String, f64)> {
    let mut found: Vec<(String, f64)> = Vec::new();
    for change in &motion.summary.changes {
        let ChangeKind::Hit(LoadId(load), _) = change.kind else { continue };
        let name = &mechanism.model.loads[load].name;
        if name.starts_with('c') && found.iter().all(|(known, _)| known != name) {
            found.push((name.clone(), change.t));
        }
    }
    found
}

#[test]
fn dominoes_fall_one_after_the_other_and_come_to_rest() {
    let mechanism = derive(model(&dominoes(4, "[solve]\nt_end = 1\nevery = 0.01\n")));
    let motion = solve(&mechanism);
    let hits = first_hits(&mechanism, &motion);
    let order: Vec<&str> = hits.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(order, ["c1", "c2", "c3"], "{hits:?}");
    let last = motion.samples.last().expect("a sample");
    assert!(last.v.iter().all(|v| v.abs() < 1e-9), "{:?}", last.v);
    let weight = 4.0 * 0.02 * 9.81;
    let within = |relative| Within { relative, absolute: 0.0 };
    close("force", signal(&mechanism, last, "force"), weight, within(1e-7));
    // The last is flat on the floor, each other one leans on the next.
    for k in 0..4 {
        let angle = last.q[coordinate(&mechanism, &format!("d{k}_angle"))];
        assert!((-1.6..-1.2).contains(&angle), "domino {k} at {angle}");
    }
    let energy = &motion.summary.energy;
    assert!(energy.worst_error <= 1e-6 * energy.scale, "{}", energy.worst_error);
    // The same order at another tolerance, at the same instants.
    let finer = derive(model(&dominoes(
        4,
        "[solve]\nt_end = 0.3\nevery = 0.1\nrtol = 1e-10\natol = 1e-12\n",
    )));
    let same = first_hits(&finer, &solve(&finer));
    for ((name, t), (other, finer)) in hits.iter().zip(&same) {
        assert_eq!(name, other);
        close(name, *t, *finer, within(1e-4));
    }
}

#[test]
fn a_ball_that_runs_into_two_in_touch_goes_back_with_a_third_of_its_speed() {
    let mut text = String::new();
    for (k, (x, v)) in [(-0.1, 1.0), (0.0, 0.0), (0.04, 0.0)].into_iter().enumerate() {
        let _ = write!(
            text,
            "[bodies.b{k}]\nmass = \"0.1 kg\"\ninertia = \"1e-5 kg m^2\"\nfree = true\npoints = {{ C = [0, 0] }}\n\
             [initial.b{k}]\nx = {x}\ny = 0\nangle = 0\nvx = {v}\nvy = 0\nrate = 0\n"
        );
        if k > 0 {
            let _ = write!(
                text,
                "[contacts.c{k}]\nrestitution = 1\nbetween = [{{ disc = \"b{}.C\", radius = \"20 mm\" }}, \
                 {{ disc = \"b{k}.C\", radius = \"20 mm\" }}]\n",
                k - 1
            );
        }
    }
    let mechanism = derive(model(&(text + "[solve]\nt_end = 0.2\n")));
    let motion = solve(&mechanism);
    let last = motion.samples.last().expect("a sample");
    for (k, speed) in [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0].into_iter().enumerate() {
        let found = last.v[coordinate(&mechanism, &format!("b{k}_x"))];
        close("speed", found, speed, Within { relative: 1e-12, absolute: 0.0 });
    }
}

/// A disc of 1 kg and 0.1 m that rolls on a floor of this slope with an arm of 2 mm.
fn rolling(slope: f64, speed: f64, t_end: f64) -> String {
    let (sin, cos) = slope.atan().sin_cos();
    FLOOR.replace("[0, \"-9.81 m/s^2\"]", &format!("[{}, {}]", 9.81 * sin, -9.81 * cos))
        + &format!(
            "[bodies.disc]\nmass = 1\ninertia = 0.005\nfree = true\npoints = {{ C = [0, 0] }}\n\
             [contacts.floor]\nbetween = [{{ line = [\"ground.A\", \"ground.B\"] }}, \
             {{ disc = \"disc.C\", radius = \"0.1 m\" }}]\nmu = 0.3\nrolling = \"2 mm\"\n\
             [initial]\ndisc = {{ x = 0, y = \"0.1 m\", angle = 0, vx = {speed}, vy = 0, rate = {} }}\n\
             [outputs]\ntorque = \"contacts.floor.rolling\"\nfriction = \"contacts.floor.friction\"\n\
             [solve]\nt_end = {t_end}\nevery = 0.5\nrtol = 1e-9\natol = 1e-11\n",
            -speed / 0.1
        )
}

#[test]
fn rolling_resistance_brakes_a_disc_by_its_arm_and_holds_it_on_a_small_slope() {
    let within = Within { relative: 1e-9, absolute: 1e-11 };
    // (I + m r²) ω′ = −b m g.
    let brake = 0.002 * 9.81 / 0.15;
    let mechanism = derive(model(&rolling(0.0, 1.0, 8.0)));
    let motion = solve(&mechanism);
    let sample = at(&motion, 2.0);
    let x = coordinate(&mechanism, "disc_x");
    close("x", sample.q[x], 2.0 - brake * 2.0, within);
    close("torque", signal(&mechanism, sample, "torque"), 0.002 * 9.81, within);
    close("friction", signal(&mechanism, sample, "friction"), -brake, within);
    close("end", at(&motion, 8.0).q[x], 0.5 / brake, within);
    let mut stops =
        motion.summary.changes.iter().filter(|c| matches!(c.kind, ChangeKind::Stick(_)));
    close("stops", stops.next_back().expect("it stops").t, 1.0 / brake, within);
    let energy = &motion.summary.energy;
    assert!(energy.worst_error <= 1e-8 * energy.scale, "{}", energy.worst_error);
    // tan α below and above b/r.
    let mechanism = derive(model(&rolling(0.019, 0.0, 1.0)));
    close("stays", at(&solve(&mechanism), 1.0).q[x], 0.0, within);
    let mechanism = derive(model(&rolling(0.05, 0.0, 1.0)));
    let rate = 9.81 * (0.05 - 0.02) / f64::hypot(1.0, 0.05) / 1.5;
    close("rolls", at(&solve(&mechanism), 1.0).q[x], 0.5 * rate, within);
}

#[test]
fn a_journal_pressed_in_its_bush_moves_as_on_a_link_of_the_play() {
    let common = "[ground]\npoints = { O = [0, 0] }\n\
                  [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
                  [bodies.rod]\nmass = 2\ninertia = 0.05\nfree = true\npoints = { A = [0, \"0.25 m\"] }\n\
                  [initial]\nrod = { x = \"0.25 m*sin(0.3)\", y = \"-2 mm - 0.25 m*cos(0.3)\", angle = 0.3, vx = 0, vy = 0, rate = 0 }\n\
                  [solve]\nt_end = 0.5\nevery = 0.1\nrtol = 1e-10\natol = 1e-12\n";
    let bush = "[contacts.pin]\nbetween = [{ ring = \"ground.O\", radius = \"12 mm\" }, \
                { disc = \"rod.A\", radius = \"10 mm\" }]\n";
    let link =
        "[joints.pin]\ntype = \"link\"\nbetween = [\"ground.O\", \"rod.A\"]\nlength = \"2 mm\"\n";
    let ends = [bush, link].map(|pin| {
        let mechanism = derive(model(&format!("{common}{pin}")));
        let q = at(&solve(&mechanism), 0.5).q.clone();
        ["rod_x", "rod_y", "rod_angle"].map(|name| q[coordinate(&mechanism, name)])
    });
    for (bush, link) in ends[0].iter().zip(&ends[1]) {
        close("end", *bush, *link, Within { relative: 0.0, absolute: 1e-8 });
    }
}

/// The pendulum of a bob on a rod, or a block on a guide, whose joint is one of these elements.
fn with_play(free: &str, element: &str, initial: &str) -> String {
    format!(
        "[ground]\npoints = {{ O = [0, 0], a = [\"1 m\", \"22 mm\"], b = [0, \"22 mm\"], c = [0, \"-22 mm\"], d = [\"1 m\", \"-22 mm\"] }}\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
         [loads.push]\ntype = \"force\"\non = \"part.A\"\nvector = [\"30 N\", 0]\n\
         [bodies.part]\nmass = 2\ninertia = 0.05\n{free}\
         points = {{ A = [0, \"0.1 m\"], C = [0, 0], p = [\"50 mm\", \"20 mm\"], q = [\"-50 mm\", \"20 mm\"], \
         r = [\"-50 mm\", \"-20 mm\"], s = [\"50 mm\", \"-20 mm\"] }}\n{element}\
         [initial]\n{initial}\n[solve]\nt_end = 0.2\nevery = 0.02\nrtol = 1e-9\natol = 1e-11\n"
    )
}

#[test]
fn a_clearance_says_the_same_as_contacts_written_out() {
    let pin = "[joints.J]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"part.A\"]\nclearance = \"2 mm\"\n\
               radius = \"10 mm\"\nmu = 0.2\nrestitution = 0.4\n";
    let of_pin = "[contacts.J]\nbetween = [{ ring = \"ground.O\", radius = \"12 mm\" }, { disc = \"part.A\", radius = \"10 mm\" }]\n\
                  mu = 0.2\nrestitution = 0.4\n";
    let slide = "[joints.J]\ntype = \"prismatic\"\nbetween = [\"ground.O\", \"part.C\"]\naxis = [1, 0]\nclearance = \"2 mm\"\n\
                 length = \"100 mm\"\nwidth = \"40 mm\"\nmu = 0.2\nrestitution = 0.4\n";
    let of_slide = "[contacts.J_left]\nbetween = [{ line = [\"ground.a\", \"ground.b\"] }, { edges = [\"part.p\", \"part.q\"] }]\n\
                    mu = 0.2\nrestitution = 0.4\n\
                    [contacts.J_right]\nbetween = [{ line = [\"ground.c\", \"ground.d\"] }, { edges = [\"part.r\", \"part.s\"] }]\n\
                    mu = 0.2\nrestitution = 0.4\n";
    let hanging = "part = { x = 0, y = \"-0.1 m\", angle = 0, vx = 0.1, vy = 0, rate = 0 }";
    let sliding = "part = { x = 0, y = 0, angle = 0, vx = 0.1, vy = 0, rate = 0 }";
    for (short, long, initial) in [(pin, of_pin, hanging), (slide, of_slide, sliding)] {
        let ends = [("", short), ("free = true\n", long)].map(|(free, element)| {
            let mechanism = derive(model(&with_play(free, element, initial)));
            let motion = solve(&mechanism);
            assert!(motion.summary.changes.len() > 3, "it hits: {:?}", motion.summary.changes);
            let energy = &motion.summary.energy;
            assert!(energy.worst_error <= 1e-6 * energy.scale, "{}", energy.worst_error);
            let q = at(&motion, 0.2).q.clone();
            ["part_x", "part_y", "part_angle"].map(|name| q[coordinate(&mechanism, name)])
        });
        for (short, long) in ends[0].iter().zip(&ends[1]) {
            close("end", *short, *long, Within { relative: 1e-9, absolute: 1e-11 });
        }
    }
}

/// A slider-crank with play in a pin or in its guide begins where it closes without play, and stays within it.
#[test]
fn a_linkage_with_play_begins_closed_and_keeps_near_to_the_one_without() {
    let text = |pin: &str, guide: &str| {
        format!(
            "[bodies]\ncrank = {{ mass = 1, inertia = 0.01, points = {{ A = [0, 0], B = [0.1, 0] }} }}\n\
             rod = {{ mass = 1, inertia = 0.02, com = [0.15, 0], points = {{ B = [0, 0], C = [0.3, 0] }} }}\n\
             slider = {{ mass = 2, inertia = 0.01, points = {{ C = [0, 0] }} }}\n[joints]\n\
             A = {{ type = \"revolute\", between = [\"ground\", \"crank.A\"] }}\n\
             B = {{ type = \"revolute\", between = [\"crank.B\", \"rod.B\"]{pin} }}\n\
             C = {{ type = \"revolute\", between = [\"rod.C\", \"slider.C\"] }}\n\
             D = {{ type = \"prismatic\", between = [\"ground\", \"slider.C\"], axis = [1, 0]{guide} }}\n\
             [drives]\nm = {{ joint = \"A\", motion = \"40 deg + 10 rad/s*t\" }}\n\
             [initial]\nC = {{ guess = {{ angle = \"-20 deg\" }} }}\n\
             [outputs]\nx = \"slider.x\"\n[solve]\nt_end = 0.3\nevery = 0.02\n"
        )
    };
    let place = |pin: &str, guide: &str, along: &str| {
        let text = text(pin, guide).replace("axis = [1, 0]", along);
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let times = (0..16).map(|k| 0.02 * f64::from(k));
        times.map(|t| signal(&mechanism, at(&motion, t), "x")).collect::<Vec<f64>>()
    };
    let loose_guide = ", clearance = \"0.2 mm\", length = \"60 mm\", width = \"20 mm\"";
    for (pin, guide, along) in [
        (", clearance = \"0.2 mm\"", "", "axis = [1, 0]"),
        ("", loose_guide, "axis = [1, 0]"),
        ("", loose_guide, "direction = \"10 deg\""),
    ] {
        let rigid = place("", "", along);
        let loose = place(pin, guide, along);
        close("start", loose[0], rigid[0], Within { relative: 1e-12, absolute: 1e-12 });
        let apart = loose.iter().zip(&rigid).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(1e-6 < apart && apart < 5e-4, "{apart} m with{pin}{guide}");
    }
}

/// A slide of 100 mm at rest in a guide at a slope is 2 mm below its axis, whatever the frames of its points.
#[test]
fn a_slide_with_play_rests_on_its_guide_at_any_slope() {
    let element = "[joints.J]\ntype = \"prismatic\"\nbetween = [\"ground.F\", \"part.G\"]\ndirection = \"10 deg\"\nangle = \"40 deg\"\n\
                   clearance = \"2 mm\"\nlength = \"100 mm\"\nmu = 1\n";
    let text = with_play(
        "",
        element,
        "J = { position1 = 0, position2 = \"-0.002 m\", angle = \"40 deg\" }\n\
                                       part = { vx = 0, vy = 0, rate = 0 }",
    )
    .replace("points = { O", "points = { F = { at = [0, 0], rpy = [0, 0, \"20 deg\"] }, O")
    .replace("points = { A", "points = { G = { at = [0, 0], rpy = [0, 0, \"-30 deg\"] }, A")
    .replace("30 N", "0 N")
        + "[outputs]\npress = \"contacts.J_right.force\"\nrub = \"contacts.J_right.friction\"\nleft = \"contacts.J_left.gap\"\n";
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let last = at(&motion, 0.2);
    let slope = 30_f64.to_radians();
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    close("press", signal(&mechanism, last, "press"), 2.0 * 9.81 * slope.cos(), within);
    close("rub", signal(&mechanism, last, "rub").abs(), 2.0 * 9.81 * slope.sin(), within);
    close("left", signal(&mechanism, last, "left"), 0.004, within);
    close("x", last.q[coordinate(&mechanism, "part_x")], 0.002 * slope.sin(), within);
    close("y", last.q[coordinate(&mechanism, "part_y")], -0.002 * slope.cos(), within);
}

/// Discs in columns above a floor between two walls, every second row aside.
fn discs(n: usize, t_end: f64) -> String {
    let mut text = FLOOR.replace("A = [", "C = [\"-0.3 m\", \"3 m\"], D = [\"-0.3 m\", 0], E = [\"0.3 m\", 0], F = [\"0.3 m\", \"3 m\"], A = [");
    let disc = |k: usize| format!("{{ disc = \"d{k}.C\", radius = \"50 mm\" }}");
    let law = "mu = 0.3\nrestitution = 0.1\n";
    for k in 0..n {
        let [row, column] = [k / 4, k % 4].map(|of| f64::from(u8::try_from(of).expect("few")));
        let x = -0.23 + 0.115 * column + 0.02 * (row % 2.0);
        let y = 0.06 + 0.115 * row;
        let _ = write!(
            text,
            "[bodies.d{k}]\nmass = 1\ninertia = 0.00125\nfree = true\npoints = {{ C = [0, 0] }}\n\
             [initial.d{k}]\nx = {x}\ny = {y}\nangle = 0\nvx = 0\nvy = 0\nrate = 0\n\
             [contacts.w{k}]\nbetween = [{{ edges = [\"ground.C\", \"ground.D\", \"ground.E\", \"ground.F\"] }}, {}]\n{law}",
            disc(k)
        );
        for other in 0..k {
            let (first, second) = (disc(other), disc(k));
            let _ = write!(text, "[contacts.c{other}_{k}]\nbetween = [{first}, {second}]\n{law}");
        }
    }
    text + &format!("[solve]\nt_end = {t_end}\nevery = 0.1\n")
}

/// A disc on two others is let go by each hit for flights of rounding, and falls back onto those that the floor bears.
#[test]
fn discs_of_a_pile_do_not_bounce_without_end() {
    let mechanism = derive(model(&discs(6, 0.5)));
    let motion = solve(&mechanism);
    let changes = &motion.summary.changes;
    assert!(changes.len() < 1500, "{} changes", changes.len());
    let energy = &motion.summary.energy;
    assert!(energy.worst_error <= 1e-6 * energy.scale, "{}", energy.worst_error);
    for pair in 0..6 {
        let other = (0..pair).map(|other| (other, pair));
        let last = motion.samples.last().expect("a sample");
        let place = |k: usize, axis: &str| last.q[coordinate(&mechanism, &format!("d{k}_{axis}"))];
        for (a, b) in other {
            let distance = f64::hypot(place(a, "x") - place(b, "x"), place(a, "y") - place(b, "y"));
            assert!(distance > 0.1 - 1e-9, "d{a} and d{b} overlap: {distance}");
        }
    }
}
