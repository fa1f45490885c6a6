//! Mechanics against closed forms and balances written by hand.

use std::f64::consts::{PI, TAU};

use crate::support::{
    Probe, Within, all_close, close, coordinate, derive, example, model, reaction, solve,
};
use bksim::Mechanism;
use bksim::sim::run::Sample;

type Point = [f64; 2];

const G: f64 = 9.81;
const ROUNDING: Within = Within { relative: 1e-9, absolute: 1e-9 };

fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn scale(s: f64, a: Point) -> Point {
    [s * a[0], s * a[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// k × a.
fn left(a: Point) -> Point {
    [-a[1], a[0]]
}

fn direction(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}

/// A body that turns: place, velocity and acceleration of one of its points at `arm` from a point
/// that moves with `base`.
fn carried(base: [Point; 3], arm: Point, rate: f64, acceleration: f64) -> [Point; 3] {
    let [p, v, a] = base;
    let centripetal = scale(-rate * rate, arm);
    let tangential = scale(acceleration, left(arm));
    [add(p, arm), add(v, scale(rate, left(arm))), add(a, add(centripetal, tangential))]
}

/// Rates x, y of two arms with r + x k×p = y k×q.
fn two_rates(p: Point, q: Point, r: Point) -> Point {
    let determinant = cross(p, q);
    [-dot(r, q) / determinant, -dot(r, p) / determinant]
}

/// Torque that turns the crank of the four-bar example at a constant rate, from the closure of the
/// loop and the balance of power τ ω = Σ m (r̈ − g)·ṙ + I θ̈ θ̇.
fn four_bar_torque(t: f64) -> (f64, [f64; 3]) {
    let (a, b, c, d, omega) = (0.1, 0.3, 0.25, 0.3, TAU);
    let crank = PI / 3.0 + omega * t;
    let still = [[0.0; 2]; 3];
    let pin_b = carried(still, scale(a, direction(crank)), omega, 0.0);

    // C lies on two circles; the loop is assembled on the left of B → D.
    let e = sub([d, 0.0], pin_b[0]);
    let length = dot(e, e).sqrt();
    let along = (b * b - c * c + length * length) / (2.0 * length);
    let across = (b * b - along * along).sqrt();
    let unit = scale(1.0 / length, e);
    let arm_b = add(scale(along, unit), scale(across, left(unit)));
    let arm_d = sub(add(pin_b[0], arm_b), [d, 0.0]);

    // Both arms give C the same velocity, then the same acceleration.
    let [coupler_rate, rocker_rate] = two_rates(arm_b, arm_d, pin_b[1]);
    let known = sub(
        add(pin_b[2], scale(-coupler_rate * coupler_rate, arm_b)),
        scale(-rocker_rate * rocker_rate, arm_d),
    );
    let [coupler_acc, rocker_acc] = two_rates(arm_b, arm_d, known);

    let pivot = [[d, 0.0], [0.0; 2], [0.0; 2]];
    let bodies = [
        (0.5, a, carried(still, scale(a / 2.0, direction(crank)), omega, 0.0), omega, 0.0),
        (
            0.8,
            b,
            carried(pin_b, scale(0.5, arm_b), coupler_rate, coupler_acc),
            coupler_rate,
            coupler_acc,
        ),
        (
            0.7,
            c,
            carried(pivot, scale(0.5, arm_d), rocker_rate, rocker_acc),
            rocker_rate,
            rocker_acc,
        ),
    ];
    let power: f64 = bodies
        .iter()
        .map(|&(mass, length, [_, v, acc], rate, rate_dot)| {
            let inertia = mass * length * length / 12.0;
            mass * dot(add(acc, [0.0, G]), v) + inertia * rate_dot * rate
        })
        .sum();
    let coupler = arm_b[1].atan2(arm_b[0]);
    let rocker = arm_d[1].atan2(arm_d[0]);
    (power / omega, [crank, coupler, rocker])
}

#[test]
fn the_drive_torque_of_the_four_bar_is_that_of_the_closed_form() {
    let mechanism = derive(example("four-bar"));
    let angles = Probe::new(&mechanism, &["A_angle", "A_angle + B_angle", "D_angle"]);
    let motion = solve(&mechanism);
    let mut most: f64 = 0.0;
    for sample in &motion.samples {
        let (torque, expected) = four_bar_torque(sample.t);
        let what = format!("t = {:.3}", sample.t);
        let [found, ..] = angles.at(sample);
        for (found, expected) in found.iter().zip(&expected) {
            close(&format!("{what}: sine of an angle"), found.sin(), expected.sin(), ROUNDING);
            close(&format!("{what}: cosine of an angle"), found.cos(), expected.cos(), ROUNDING);
        }
        let drive = *sample.lambda.last().expect("the drive's multiplier");
        close(&format!("{what}: torque"), drive, torque, ROUNDING);
        most = most.max(torque.abs());
    }
    assert!((1.0..1.4).contains(&most), "largest torque {most} N m");
}

#[test]
fn the_quick_return_moves_as_its_closed_form() {
    let mechanism = derive(example("quick-return"));
    let names = ["O_angle", "guide_position", "slot_position"];
    let known: Vec<&str> = mechanism.compiled.coordinates.iter().map(|c| c.name.as_str()).collect();
    let names = &names[..if known.contains(&"slot_position") { 3 } else { 2 }];
    let probe = Probe::new(&mechanism, names);
    let motion = solve(&mechanism);
    let (e, r, h, p, y) = (0.25, 0.1, 0.5, 0.2, 0.48);
    let mut forward = 0;
    for sample in &motion.samples {
        let (crank, omega) = (PI * sample.t, PI);
        let pin = add([0.0, e], scale(r, direction(crank)));
        let pin_rate = scale(r * omega, left(direction(crank)));
        let link = pin[1].atan2(pin[0]);
        let link_rate = cross(pin, pin_rate) / dot(pin, pin);
        let top = scale(h, direction(link));
        let top_rate = scale(link_rate, left(top));
        let reach = (p * p - (y - top[1]).powi(2)).sqrt();
        let ram = top[0] + reach;
        let ram_rate = top_rate[0] + (y - top[1]) * top_rate[1] / reach;

        let what = format!("t = {:.3}", sample.t);
        let [q, v, _] = probe.at(sample);
        all_close(&format!("{what}: link and ram"), &q[..2], &[link, ram], ROUNDING);
        all_close(&format!("{what}: their rates"), &v[..2], &[link_rate, ram_rate], ROUNDING);
        forward += usize::from(ram_rate < 0.0);
    }
    // One way takes (½ + asin(r/e)/π) of a turn.
    let share = forward as f64 / motion.samples.len() as f64;
    let expected = 0.5 + (r / e).asin() / PI;
    close("share of the slow stroke", share, expected, Within { relative: 0.0, absolute: 0.02 });
}

#[test]
fn the_spring_pendulum_loses_what_its_dampers_take() {
    let mut model = example("spring-pendulum");
    (model.solve.rtol, model.solve.atol, model.solve.every) = (1e-10, 1e-11, Some(0.002));
    let mechanism = derive(model);
    let motion = solve(&mechanism);
    let (m, l, k, c, b) = (2.0, 0.5, 80.0, 1.5, 0.05);
    // Energy and dissipated power by hand; `phi` is measured from the vertical.
    let energy_and_power = |sample: &Sample| {
        let (phi, rate) = (sample.q[0], sample.v[0]);
        let bob = scale(l, [phi.sin(), -phi.cos()]);
        let bob_rate = scale(rate, left(bob));
        let d = sub(bob, [0.8, -0.3]);
        let distance = dot(d, d).sqrt();
        let stretch_rate = dot(d, bob_rate) / distance;
        let kinetic = 0.5 * m * dot(bob_rate, bob_rate);
        let potential = m * G * bob[1] + 0.5 * k * (distance - 0.6).powi(2);
        (kinetic, potential, c * stretch_rate * stretch_rate + b * rate * rate)
    };
    // ∫ P dt by Simpson's rule over pairs of output intervals.
    let mut lost = 0.0;
    let (kinetic, potential, _) = energy_and_power(&motion.samples[0]);
    let before = kinetic + potential;
    for three in motion.samples.windows(3).step_by(2) {
        let [p0, p1, p2] = [0, 1, 2].map(|i| energy_and_power(&three[i]).2);
        lost += (three[2].t - three[0].t) / 6.0 * (p0 + 4.0 * p1 + p2);
        let (kinetic, potential, _) = energy_and_power(&three[2]);
        let what = format!("t = {:.3}", three[2].t);
        let within = Within { relative: 0.0, absolute: 1e-7 };
        close(&format!("{what}: T"), three[2].energy.kinetic, kinetic, within);
        close(&format!("{what}: T + V"), kinetic + potential, before - lost, within);
        close(&format!("{what}: work"), three[2].work, -lost, within);
    }
    assert!(lost > 5.0, "only {lost} J were lost");
}

/// Ground of a four-bar whose coupler is `coupler`.
fn four_bar(coupler: &str) -> String {
    format!(
        r#"
[ground]
points = {{ A = [0, 0], D = ["0.3 m", 0] }}

[bodies.crank]
mass = "0.5 kg"
com = ["0.05 m", "0.01 m"]
inertia = "0.002 kg m^2"
points = {{ A = [0, 0], B = ["0.1 m", 0] }}

[bodies.rocker]
mass = "0.7 kg"
com = ["0.125 m", 0]
inertia = "0.004 kg m^2"
points = {{ D = [0, 0], C = ["0.25 m", 0] }}

[joints.A]
type = "revolute"
between = ["ground.A", "crank.A"]

[joints.D]
type = "revolute"
between = ["ground.D", "rocker.D"]

{coupler}

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[initial]
A = {{ angle = "60 deg", rate = "1 rad/s" }}
D = {{ guess = {{ angle = "100 deg" }} }}

[solve]
t_end = "1 s"
every = "0.02 s"
rtol = 1e-11
atol = 1e-12
"#
    )
}

/// A coupler of a given mass, in kg; its inertia is that of a thin bar.
fn bar_coupler(mass: f64) -> String {
    let inertia = mass * 0.3 * 0.3 / 12.0;
    format!(
        r#"
[bodies.coupler]
mass = "{mass:?} kg"
com = ["0.15 m", 0]
inertia = "{inertia:?} kg m^2"
points = {{ B = [0, 0], C = ["0.3 m", 0] }}

[joints.B]
type = "revolute"
between = ["crank.B", "coupler.B"]

[joints.C]
type = "revolute"
between = ["coupler.C", "rocker.C"]
"#
    )
}

#[test]
fn a_four_bar_that_nothing_drives_keeps_its_energy() {
    let motion = solve(&derive(model(&four_bar(&bar_coupler(0.8)))));
    let energy = |sample: &Sample| sample.energy.kinetic + sample.energy.potential;
    let before = energy(&motion.samples[0]);
    let moved = motion.samples.iter().map(|s| s.energy.kinetic).fold(0.0, f64::max);
    assert!(moved > 0.2, "it hardly moves: T at most {moved} J");
    for sample in &motion.samples {
        let what = format!("T + V at t = {:.2}", sample.t);
        close(&what, energy(sample), before, Within { relative: 0.0, absolute: 1e-9 });
    }
}

#[test]
fn reactions_of_the_ground_and_gravity_change_the_momentum() {
    let mechanism = derive(example("four-bar"));
    let centres = [
        "a/2*cos(A_angle)",
        "a/2*sin(A_angle)",
        "a*cos(A_angle) + b/2*cos(A_angle + B_angle)",
        "a*sin(A_angle) + b/2*sin(A_angle + B_angle)",
        "d + c/2*cos(D_angle)",
        "c/2*sin(D_angle)",
    ];
    let centres = Probe::new(&mechanism, &centres);
    let angles = Probe::new(&mechanism, &["A_angle", "A_angle + B_angle", "D_angle"]);
    for sample in &solve(&mechanism).samples {
        let [ground_a, ground_d] = ["A", "D"].map(|joint| reaction(&mechanism, sample, joint));
        let drive = *sample.lambda.last().expect("the drive's multiplier");
        let ([place, _, acceleration], [_, _, turning]) = (centres.at(sample), angles.at(sample));
        let mut force = add([ground_a[0], ground_a[1]], [ground_d[0], ground_d[1]]);
        let mut moment = drive + cross([0.3, 0.0], [ground_d[0], ground_d[1]]);
        let (mut momentum_rate, mut spin_rate) = ([0.0; 2], 0.0);
        for (body, (mass, length)) in [(0.5, 0.1), (0.8, 0.3), (0.7, 0.25)].iter().enumerate() {
            let pair = |of: &[f64]| [of[2 * body], of[2 * body + 1]];
            let (r, a) = (pair(&place), pair(&acceleration));
            force = add(force, [0.0, -mass * G]);
            moment += cross(r, [0.0, -mass * G]);
            momentum_rate = add(momentum_rate, scale(*mass, a));
            spin_rate += mass * cross(r, a) + mass * length * length / 12.0 * turning[body];
        }
        let what = format!("t = {:.3}", sample.t);
        all_close(&format!("{what}: force"), &force, &momentum_rate, ROUNDING);
        close(&format!("{what}: moment"), moment, spin_rate, ROUNDING);
    }
}

#[test]
fn a_joint_transmits_nothing_along_its_freedom() {
    // Example, joint, component of the reaction that its freedom leaves zero.
    let free = [
        ("four-bar", "A", 5),
        ("four-bar", "B", 5),
        ("four-bar", "C", 5),
        ("four-bar", "D", 5),
        ("slider-crank", "A", 5),
        ("slider-crank", "B", 5),
        ("slider-crank", "C", 5),
        ("slider-crank", "D", 0),
        ("spring-pendulum", "O", 5),
        ("quick-return", "slot", 5),
        ("quick-return", "guide", 0),
    ];
    for name in ["four-bar", "slider-crank", "spring-pendulum", "quick-return"] {
        let mechanism = derive(example(name));
        let motion = solve(&mechanism);
        for (_, joint, component) in free.iter().filter(|(example, ..)| *example == name) {
            for sample in &motion.samples {
                let six = reaction(&mechanism, sample, joint);
                let most = six.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
                let rest = six[*component].abs();
                assert!(rest < 1e-9 * most, "{name} `{joint}` at t = {}: {six:?}", sample.t);
            }
        }
    }
}

#[test]
fn the_pin_pushes_across_its_slot() {
    let mechanism = derive(example("quick-return"));
    let link = Probe::new(&mechanism, &["O_angle"]);
    for sample in &solve(&mechanism).samples {
        let six = reaction(&mechanism, sample, "slot");
        let along = dot([six[0], six[1]], direction(link.at(sample)[0][0]));
        let most = 1.0 + dot([six[0], six[1]], [six[0], six[1]]).sqrt();
        assert!(along.abs() < 1e-9 * most, "t = {}: {along} N along the slot of {six:?}", sample.t);
    }
}

#[test]
fn a_link_is_a_bar_without_mass() {
    let link =
        "[joints.L]\ntype = \"link\"\nbetween = [\"crank.B\", \"rocker.C\"]\nlength = \"0.3 m\"\n";
    let with_link = derive(model(&four_bar(link)));
    let with_bar = derive(model(&four_bar(&bar_coupler(1e-9))));
    let angles = ["A_angle", "D_angle"];
    let probes = [Probe::new(&with_link, &angles), Probe::new(&with_bar, &angles)];
    let motions = [solve(&with_link), solve(&with_bar)];
    let within = Within { relative: 1e-7, absolute: 1e-7 };
    for (a, b) in motions[0].samples.iter().zip(&motions[1].samples) {
        let what = format!("t = {:.2}", a.t);
        let (found, expected) = (probes[0].at(a), probes[1].at(b));
        all_close(&format!("{what}: angles"), &found[0], &expected[0], within);
        all_close(&format!("{what}: rates"), &found[1], &expected[1], within);
        // The link pulls the rocker as the bar does.
        let (link, bar) = (reaction(&with_link, a, "L"), reaction(&with_bar, b, "C"));
        all_close(&format!("{what}: force"), &link, &bar, within);
        let pull = dot([link[0], link[1]], [link[0], link[1]]).sqrt();
        close(&format!("{what}: |λ|"), a.lambda[0].abs(), pull, within);
    }
}

/// A pendulum of a bar and a plate, made of one body or of two.
fn pendulum(bodies: &str, policy: &str) -> Mechanism {
    let text = format!(
        r#"
coordinates = "{policy}"

{bodies}

[joints.A]
type = "revolute"
between = ["ground", "bar.A"]

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[initial]
A = {{ angle = "10 deg", rate = 0 }}

[solve]
t_end = "2 s"
every = "0.1 s"
rtol = 1e-11
atol = 1e-12
"#
    );
    derive(model(&text))
}

#[test]
fn two_welded_bodies_are_one() {
    let welded = r#"
[bodies.bar]
mass = "2 kg"
com = ["0.5 m", 0]
inertia = "0.2 kg m^2"
points = { A = [0, 0], E = ["1 m", 0] }

[bodies.plate]
mass = "3 kg"
com = ["0.2 m", 0]
inertia = "0.1 kg m^2"
points = { E = [0, 0] }

[joints.W]
type = "weld"
between = ["bar.E", "plate.E"]
angle = "30 deg"
"#;
    // Mass, centre and inertia of the two together, about the bar's frame.
    let plate = add([1.0, 0.0], scale(0.2, direction(PI / 6.0)));
    let com = scale(1.0 / 5.0, add(scale(2.0, [0.5, 0.0]), scale(3.0, plate)));
    let steiner = |mass: f64, at: Point| mass * dot(sub(at, com), sub(at, com));
    let inertia = 0.2 + 0.1 + steiner(2.0, [0.5, 0.0]) + steiner(3.0, plate);
    let one = format!(
        "[bodies.bar]\nmass = \"5 kg\"\ncom = [\"{} m\", \"{} m\"]\ninertia = \"{inertia} kg m^2\"\n\
         points = {{ A = [0, 0] }}\n",
        com[0], com[1]
    );
    let one = pendulum(&one, "relative");
    let expected = solve(&one);
    let within = Within { relative: 1e-8, absolute: 1e-8 };
    for (policy, angle) in [("relative", "A_angle"), ("absolute", "bar_angle")] {
        let two = pendulum(welded, policy);
        let found = solve(&two);
        let angle = coordinate(&two, angle);
        for (a, b) in found.samples.iter().zip(&expected.samples) {
            let what = format!("{policy}, t = {:.1}", a.t);
            close(&format!("{what}: angle"), a.q[angle], b.q[0], within);
            close(&format!("{what}: rate"), a.v[angle], b.v[0], within);
            let [force, same] = [reaction(&two, a, "A"), reaction(&one, b, "A")];
            all_close(&format!("{what}: force"), &force, &same, within);
            // The weld carries the plate: weight and inertia of 3 kg, by its own balance.
            let weld = reaction(&two, a, "W");
            let (bar, rate, acceleration) = (a.q[angle], a.v[angle], a.a[angle]);
            let arm = add(direction(bar), scale(0.2, direction(bar + PI / 6.0)));
            let [_, _, acc] = carried([[0.0; 2]; 3], arm, rate, acceleration);
            let carrying = scale(3.0, add(acc, [0.0, G]));
            all_close(&format!("{what}: weld"), &weld[..2], &carrying, within);
            let lever = scale(0.2, direction(bar + PI / 6.0));
            let moment = 0.1 * acceleration + cross(lever, carrying);
            close(&format!("{what}: moment of the weld"), weld[5], moment, within);
        }
    }
}
