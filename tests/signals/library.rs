//! The parts that come with bksim, against reference motions and closed forms.

use crate::support::elements::Quantity::{Acceleration, Measure, Signal, Velocity};
use crate::support::elements::{Quantity, check};
use crate::support::{Within, at, close, coordinate, derive, model, path, solve};
use bksim::model::file::{Limits, expand};
use bksim::model::library::{LIBRARY, LibraryPart};

/// The text of a model with the parts that it uses.
fn whole(text: &str) -> String {
    let mut none = |file: &str| -> Result<Vec<u8>, String> { panic!("no file `{file}` is needed") };
    let expansion = expand("model.toml", text, Limits::default(), &mut none).expect("it has parts");
    assert!(expansion.faults.is_empty(), "{:?}", expansion.faults);
    expansion.text
}

/// The text of a part with the tolerances of a test.
fn alone(name: &str, t_end: &str) -> String {
    let part = LibraryPart::named(name).expect("a part");
    let (before, _) = part.text.split_once("[solve]").expect("a run of its own");
    format!("{before}[solve]\nt_end = \"{t_end}\"\nrtol = 1e-12\natol = 1e-12\n")
}

#[test]
fn every_part_solves_by_itself_and_says_what_it_is() {
    let names: Vec<&str> = LIBRARY.iter().map(|part| part.name).collect();
    assert!(names.is_sorted(), "{names:?}");
    for part in LIBRARY {
        assert!(part.about().contains('.'), "{}", part.name);
        let motion = solve(&derive(model(part.text)));
        assert!(motion.summary.t > 0.0, "{}", part.name);
    }
}

/// The units of a file are no matter of its parts.
#[test]
fn every_part_is_the_same_in_a_file_with_units() {
    for part in LIBRARY {
        let with = |units: &str| {
            let text =
                format!("{units}[use.it]\npart = \"{}\"\n[solve]\nt_end = \"1 s\"\n", part.name);
            let mechanism = derive(model(&whole(&text)));
            mechanism.model.parameters.iter().map(|p| (p.value, p.unit.clone())).collect::<Vec<_>>()
        };
        let [si, own] =
            [with(""), with("[units]\nlength = \"mm\"\nforce = \"kN\"\nangle = \"deg\"\n")];
        assert_eq!(si, own, "{}", part.name);
    }
}

const HATCH: &str = r#"
[bodies.hatch]
mass = "15 kg"
inertia = "1.2 kg m^2"
com = ["450 mm", 0]
points = { P = ["300 mm", 0] }

[joints.A]
type = "revolute"
between = ["ground", "hatch"]

[use.gas]
part = "gas-spring"
with = { lid = "hatch", hinge = "A" }

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[initial]
A = { angle = "0.9 rad", rate = 0 }

[solve]
t_end = "3 s"
every = "0.1 s"
rtol = 1e-12
atol = 1e-14
"#;

#[test]
fn a_hatch_with_a_gas_spring() {
    let columns: [(&str, Quantity<'_>); 5] = [
        ("q", Measure("A.angle", 1.0)),
        ("w", Velocity("A_angle", 1.0)),
        ("alpha", Acceleration("A_angle", 1.0)),
        ("L", Signal(0)),
        ("F", Signal(2)),
    ];
    check(&whole(HATCH), "elements/gas_spring_hatch", &columns);
}

#[test]
fn a_motor_for_direct_current_at_a_step_of_the_voltage() {
    let columns: [(&str, Quantity<'_>); 3] = [
        ("i", Velocity("current_integral", 1.0)),
        ("w", Velocity("shaft_angle", 1.0)),
        ("phi", Measure("shaft.angle", 1.0)),
    ];
    let text = alone("dc-motor", "0.3 s") + "every = \"0.01 s\"\n";
    check(&text, "elements/dc_motor", &columns);
}

/// J ω' = 2 M s s_k/(s² + s_k²) from rest: (1 − s²)/(2 s_k) − s_k ln s = 2 M t/(J ω₀).
#[test]
fn an_induction_motor_runs_up_in_the_time_of_the_closed_form() {
    let mechanism = derive(model(&alone("induction-motor", "0.15 s")));
    let motion = solve(&mechanism);
    let shaft = coordinate(&mechanism, "shaft_angle");
    let (synchronous, breakdown, torque, inertia) =
        (1500.0 * std::f64::consts::TAU / 60.0, 0.18, 120.0, 0.08);
    for t in [0.03, 0.06, 0.09, 0.12, 0.15] {
        let s: f64 = 1.0 - at(&motion, t).v[shaft] / synchronous;
        let time = inertia * synchronous / (2.0 * torque)
            * ((1.0 - s * s) / (2.0 * breakdown) - breakdown * s.ln());
        close("time to this slip", time, t, Within { relative: 1e-9, absolute: 0.0 });
    }
}

/// The brake holds the shaft; the clutch then takes both to the speed that keeps the angular momentum; the wheel
/// loses nothing where the clutch is open.
#[test]
fn a_clutch_brings_wheel_and_shaft_to_one_speed() {
    let mechanism = derive(model(&alone("clutch-brake", "1 s")));
    let motion = solve(&mechanism);
    let [support, bearing] =
        ["support_angle", "bearing_angle"].map(|name| coordinate(&mechanism, name));
    let rates = |t: f64| [support, bearing].map(|place| at(&motion, t).v[place]);
    let exact = Within { relative: 1e-10, absolute: 1e-10 };
    for (t, expected) in [(0.4, [0.0, 20.0]), (0.7, [80.0 / 4.5, 0.0]), (1.0, [0.0, 80.0 / 4.5])] {
        for (found, expected) in rates(t).into_iter().zip(expected) {
            close(&format!("rate at {t} s"), found, expected, exact);
        }
    }
    // All that is left of the energy is that of the wheel.
    let left = 0.5 * 4.0 * (80.0_f64 / 4.5).powi(2);
    let found = at(&motion, 1.0).energy.kinetic;
    close("energy", found, left, Within { relative: 1e-9, absolute: 0.0 });
}

#[test]
fn a_buffer_pushes_with_its_power_law() {
    for (position, expected) in [("0.09 m", 0.0), ("0.11 m", -250.0), ("0.14 m", -2000.0)] {
        let text = alone("bump-stop", "0.1 s");
        let initial = format!("slide = {{ position = \"{position}\", velocity = 0 }}");
        let text = text.replace("slide = { velocity = \"0.5 m/s\" }", &initial);
        let start = derive(model(&text)).start().unwrap_or_else(|e| panic!("{e}"));
        close(position, start.a[0], expected, Within { relative: 1e-12, absolute: 0.0 });
    }
}

/// A load turns the rotor out of the position that holds, by asin(M/M_h)/p.
#[test]
fn a_stepper_holds_its_load_and_takes_a_step() {
    let text = alone("stepper-motor", "0.5 s")
        .replace("\"if(t > 10 ms, 1.8 deg, 0)\"", "\"1.8 deg\"")
        + "[loads.weight]\ntype = \"torque\"\njoint = \"shaft\"\nvalue = \"-1 N m\"\n";
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let expected = 1.8_f64.to_radians() - 0.5_f64.asin() / 50.0;
    let found = at(&motion, 0.5).q[coordinate(&mechanism, "shaft_angle")];
    close("angle", found, expected, Within { relative: 1e-9, absolute: 0.0 });
}

/// The output is limited, the target is reached without the overshoot of an integral that winds up.
#[test]
fn a_pid_reaches_its_target_within_its_limits() {
    let overshoot = |tracking: &str| {
        let text = alone("pid", "30 s")
            .replace("\"5 s^-1\"", tracking)
            .replace("\"3 N m\"", "\"0.05 N m\"");
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let output =
            mechanism.model.named_signals.iter().position(|signal| signal.name == "output");
        let output = output.expect("the signal");
        assert!(motion.samples.iter().all(|sample| sample.signals[output].abs() <= 0.05 + 1e-12));
        let shaft = coordinate(&mechanism, "shaft_angle");
        motion.samples.iter().map(|sample| sample.q[shaft]).fold(0.0, f64::max) - 1.0
    };
    let (with, without) = (overshoot("\"5 s^-1\""), overshoot("\"0 s^-1\""));
    assert!(with < 0.4 * without, "{with} rad, without tracking {without} rad");
}

/// v = o Q/√(…) of a cylinder that moves nothing but itself: both flows through the open valve, forces in balance.
#[test]
fn a_cylinder_moves_at_the_speed_of_its_valve() {
    let text = alone("hydraulic-cylinder", "4 s")
        .replace("0.5*sin(2 rad/s*t)", "0.4")
        .replace("leakage = \"1e-12 m^3/s/Pa\"", "leakage = 0")
        .replace("mass = \"20 kg\"", "mass = \"0.2 kg\"")
        .replace("inertia = \"1.7 kg m^2\"", "inertia = \"0.017 kg m^2\"")
        .replace("1e-12", "1e-8");
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let signals = &mechanism.model.named_signals;
    let reach = signals.iter().position(|signal| signal.name == "reach").expect("the signal");
    let reach = |t: f64| at(&motion, t).signals[reach];
    // (A v/(o Q))² and (B v/(o Q))² are the drops of pressure over that of the supply, and A p = B r.
    let (a, b, flow, supply, tank) = (12e-4_f64, 8e-4_f64, 0.4 * 40e-6_f64, 16e6, 0.1e6);
    let v = flow * ((a * supply - b * tank) / (supply * (a.powi(3) + b.powi(3)))).sqrt();
    // It swings on its oil for long.
    close("speed", reach(4.0) - reach(3.0), v, Within { relative: 1e-3, absolute: 0.0 });
}

/// Whoever reads the table of parts can use what it names.
#[test]
fn the_reference_names_parts_and_what_they_have() {
    let reference = std::fs::read_to_string(path("docs/model-reference.md")).expect("a reference");
    let (_, section) = reference.split_once("### Parts that come with bksim").expect("a section");
    let (section, _) = section.split_once("```toml").expect("an example after the table");
    for part in LIBRARY {
        let row = section.lines().find(|line| line.starts_with(&format!("| `{}` |", part.name)));
        let row = row.unwrap_or_else(|| panic!("no row of {}", part.name));
        for name in row.split('`').skip(3).step_by(2) {
            let defined = [format!(".{name}]"), format!("\n{name} = "), format!(" {name} = [")];
            assert!(defined.iter().any(|form| part.text.contains(form)), "{}: {name}", part.name);
        }
    }
}

const FREEWHEEL: &str = r#"
[bodies.axle]
mass = "1 kg"
inertia = "0.02 kg m^2"
[bodies.drum]
mass = "3 kg"
inertia = "0.05 kg m^2"
[joints.A]
type = "revolute"
between = ["ground", "axle"]
[joints.B]
type = "revolute"
between = ["axle", "drum"]
[use.free]
part = "one-way-clutch"
with = { shaft = "axle", wheel = "drum", support = "A", bearing = "B" }
[loads.motor]
type = "torque"
on = "axle"
value = "if(t > 1 s and t < 2 s, -2 N m, 2 N m)"
[solve]
t_end = "4 s"
rtol = 1e-11
atol = 1e-12
"#;

#[test]
fn a_one_way_clutch_carries_forwards_and_runs_free() {
    let mechanism = derive(model(&whole(FREEWHEEL)));
    let motion = solve(&mechanism);
    let (axle, drum, torque) = (0.02, 0.05, 2.0);
    let together = torque / (axle + drum);
    let (a, b) = (coordinate(&mechanism, "A_angle"), coordinate(&mechanism, "B_angle"));
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    for sample in &motion.samples {
        let t = sample.t;
        // Together, apart while the axle is slowed down and until it has caught up, together again.
        let rates = match t {
            _ if t <= 1.0 => [together * t; 2],
            _ if t <= 2.0 => [together - torque / axle * (t - 1.0), together],
            _ if t <= 3.0 => [together - torque / axle * (3.0 - t), together],
            _ => [together * (t - 2.0); 2],
        };
        close(&format!("the axle at {t} s"), sample.v[a], rates[0], within);
        close(&format!("the drum at {t} s"), sample.v[a] + sample.v[b], rates[1], within);
        let near_switch = [1.0, 2.0, 3.0].iter().any(|s: &f64| (t - s).abs() < 1e-6);
        if !near_switch {
            let carried = if (1.0..3.0).contains(&t) { 0.0 } else { drum * together };
            let borne = sample.lambda.iter().map(|l| l.abs()).fold(0.0, f64::max);
            close(&format!("the torque at {t} s"), borne, carried, within);
        }
    }
}

const RATCHET: &str = r#"
[bodies.disc]
mass = "2 kg"
inertia = "0.01 kg m^2"
com = [0, "-0.1 m"]
[joints.A]
type = "revolute"
between = ["ground", "disc"]
[use.pawl]
part = "ratchet"
with = { wheel = "disc", bearing = "A", teeth = 20, first = "0.05 rad" }
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[initial]
A = { angle = "0.1 rad", rate = "8 rad/s" }
[solve]
t_end = "2 s"
rtol = 1e-11
atol = 1e-12
"#;

#[test]
fn a_ratchet_holds_at_the_last_tooth_that_it_has_passed() {
    let motion = solve(&derive(model(&whole(RATCHET))));
    // It rises as far as its energy lasts, and falls back to the tooth below.
    let (about_pin, weight) = (0.01 + 2.0 * 0.01, 2.0 * 9.81 * 0.1_f64);
    let energy = 0.5 * about_pin * 64.0 - weight * 0.1_f64.cos();
    let highest = (-energy / weight).acos();
    let pitch = std::f64::consts::PI / 10.0;
    let tooth = 0.05 + pitch * ((highest - 0.05) / pitch).floor();
    let hit = (2.0 * weight * (tooth.cos() - highest.cos()) / about_pin).sqrt();
    let last = motion.samples.last().expect("samples");
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    close("the angle", last.q[0], tooth, within);
    close("the rate", last.v[0], 0.0, within);
    close("the torque of the pawl", last.lambda[0].abs(), weight * tooth.sin(), within);
    let hits: Vec<f64> = motion
        .summary
        .changes
        .iter()
        .filter_map(|change| match change.kind {
            bksim::sim::hybrid::ChangeKind::Hit(_, speed) => Some(speed),
            _ => None,
        })
        .collect();
    assert_eq!(hits.len(), 1, "{hits:?}");
    close("the speed of the hit", hits[0], hit, within);
    let reached = motion.samples.iter().map(|s| s.q[0]).fold(0.0, f64::max);
    assert!(reached > tooth && reached <= highest + 1e-9, "{reached} of {highest}");
}

/// J α = M with the inertia of a ring, and of the bodies around it.
#[test]
fn a_flywheel_has_the_inertia_of_its_disc() {
    let text = alone("flywheel", "1 s")
        + "[loads.motor]\ntype = \"torque\"\non = \"shaft\"\nvalue = \"10 N m\"\n";
    let motion = solve(&derive(model(&text)));
    let disc = 0.5 * std::f64::consts::PI * 7850.0 * 0.05 * (0.3_f64.powi(4) - 0.02_f64.powi(4));
    let within = Within { relative: 1e-12, absolute: 0.0 };
    close("acceleration", motion.samples[0].a[0], 10.0 / (disc + 1e-3), within);
    close("speed", at(&motion, 1.0).v[0], 100.0 + 10.0 / (disc + 1e-3), within);
}

/// Damped oscillations along both axes and about z, each by itself, in the axes of the outer body.
#[test]
fn a_bushing_swings_along_the_axes_of_its_outer_body() {
    for outer in [0.0_f64, 0.7] {
        let (sin, cos) = outer.sin_cos();
        let place = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
        let [x, y] = place(1e-3, -2e-3);
        let text = alone("bushing", "0.2 s")
            .replace("type = \"weld\"", "type = \"revolute\"")
            .replace(
                "free = { position1 = \"1 mm\" }",
                &format!(
                    "support = {{ angle = {outer:?} }}\ninner = {{ x = {x:?}, y = {y:?}, angle = {:?} }}",
                    outer + 0.02
                ),
            )
            + "[drives.hold]\njoint = \"support\"\nmotion = OUTER\n";
        let mechanism = derive(model(&text.replace("OUTER", &format!("{outer:?}"))));
        let motion = solve(&mechanism);
        let swing = |m: f64, k: f64, c: f64, t: f64| {
            let (delta, omega) = (c / (2.0 * m), (k / m - (c / (2.0 * m)).powi(2)).sqrt());
            (-delta * t).exp() * ((omega * t).cos() + delta / omega * (omega * t).sin())
        };
        let signal = |name: &str, t: f64| {
            let signals = &mechanism.model.named_signals;
            let place = signals.iter().position(|signal| signal.name == name).expect("the signal");
            at(&motion, t).signals[place]
        };
        for t in [0.05, 0.1, 0.2] {
            let within = Within { relative: 0.0, absolute: 1e-11 };
            close("x", signal("x", t), 1e-3 * swing(10.0, 2e5, 300.0, t), within);
            close("y", signal("y", t), -2e-3 * swing(10.0, 4e5, 500.0, t), within);
            close("turn", signal("turn", t), 0.02 * swing(0.1, 50.0, 0.1, t), within);
        }
    }
}

/// ω² = n E b h³/(6 L³ m), and 4 F/k less at the end of every swing; it rests within F/k.
#[test]
fn a_leaf_spring_swings_between_the_lines_of_its_friction() {
    let mechanism = derive(model(&alone("leaf-spring", "1 s")));
    let motion = solve(&mechanism);
    let k = 5.0 * 206e9 * 0.06 * 0.007_f64.powi(3) / (6.0 * 0.6_f64.powi(3));
    let (omega, off) = ((k / 200.0).sqrt(), 40.0 / k);
    let half = std::f64::consts::PI / omega;
    let within = Within { relative: 0.0, absolute: 1e-9 };
    for sample in motion.samples.iter().filter(|sample| sample.t < 4.0 * half) {
        let swing = (sample.t / half).floor();
        let sign = if swing % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let expected = sign
            * (off
                + (0.02 - (2.0 * swing + 1.0) * off)
                    * (omega * sample.t - swing * std::f64::consts::PI).cos());
        close(&format!("place at {} s", sample.t), sample.q[0], expected, within);
    }
    let signals = &mechanism.model.named_signals;
    let stress = signals.iter().position(|signal| signal.name == "stress").expect("the signal");
    let expected = 6.0 * k * 0.02 * 0.6 / (5.0 * 0.06 * 0.007_f64.powi(2));
    close(
        "stress",
        motion.samples[0].signals[stress],
        expected,
        Within { relative: 1e-12, absolute: 0.0 },
    );
}

/// M = r F (e^{μφ} − 1) forwards and r F (1 − e^{−μφ}) backwards.
#[test]
fn a_band_brake_helps_itself_forwards_only() {
    let turn = (0.25 * 1.5 * std::f64::consts::PI).exp();
    for (rate, torque) in
        [(40.0_f64, 0.2 * 100.0 * (turn - 1.0)), (-40.0, 0.2 * 100.0 * (1.0 - 1.0 / turn))]
    {
        let text = alone("band-brake", "1 s").replace("40 rad/s", &format!("{rate} rad/s"));
        let motion = solve(&derive(model(&text)));
        let within = Within { relative: 1e-9, absolute: 1e-9 };
        for sample in &motion.samples {
            let slower = torque / 0.6 * (sample.t - 0.2).max(0.0);
            let expected = rate.signum() * (rate.abs() - slower).max(0.0);
            close(&format!("{rate} at {} s", sample.t), sample.v[0], expected, within);
        }
    }
}

/// At rest it holds r F (e^{μφ} − 1) against turning forwards, and r F (1 − e^{−μφ}) against turning backwards.
#[test]
fn a_band_brake_at_rest_holds_less_backwards() {
    let turn = (0.25 * 1.5 * std::f64::consts::PI).exp();
    let [forwards, backwards] = [20.0 * (turn - 1.0), 20.0 * (1.0 - 1.0 / turn)];
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    for (torque, rest) in [
        (0.99 * forwards, 0.0),
        (-0.99 * backwards, 0.0),
        (forwards + 6.0, 6.0),
        (-backwards - 6.0, -6.0),
        (-30.0, backwards - 30.0),
    ] {
        let text = alone("band-brake", "1 s").replace("if(t > 0.2 s, 100 N, 0 N)", "100 N");
        let text = text.replace("\"40 rad/s\"", "0")
            + &format!(
                "[loads.weight]\ntype = \"torque\"\njoint = \"bearing\"\nvalue = {torque}\n"
            );
        let motion = solve(&derive(model(&text)));
        let end = motion.samples.last().expect("a sample");
        close(&format!("{torque} N m"), end.v[0], rest / 0.6 * end.t, within);
    }
}

/// With its valve closed the air is a spring, p Vⁿ; open, it fills as its choked valve lets it.
#[test]
fn a_pneumatic_cylinder_keeps_its_gas_law_and_fills_at_the_speed_of_sound() {
    let closed = alone("pneumatic-cylinder", "2 s")
        .replace("0.5*sin(2 rad/s*t)", "0")
        .replace("1e-12", "1e-10")
        + "[initial]\npivot = { rate = \"1 rad/s\" }\n";
    let mechanism = derive(model(&closed));
    let motion = solve(&mechanism);
    let signal = |mechanism: &bksim::Mechanism, name: &str| {
        let signals = &mechanism.model.named_signals;
        signals.iter().position(|signal| signal.name == name).expect("the signal")
    };
    for (pressure, volume) in
        [("piston_pressure", "piston_volume"), ("ring_pressure", "ring_volume")]
    {
        let state = coordinate(&mechanism, &format!("{pressure}_integral"));
        let place = signal(&mechanism, volume);
        let law = |k: usize| {
            let sample = &motion.samples[k];
            sample.v[state] * sample.signals[place].powf(1.2)
        };
        for k in (0..motion.samples.len()).step_by(50) {
            close(volume, law(k), law(0), Within { relative: 1e-7, absolute: 0.0 });
        }
        let volumes = motion.samples.iter().map(|sample| sample.signals[place]);
        let range = volumes.fold([f64::MAX, 0.0], |[a, b]: [f64; 2], v| [a.min(v), b.max(v)]);
        assert!(range[1] > 1.05 * range[0], "{range:?}");
    }
    // An arm that hardly moves: p′ = n p₀ C p₁/V while p < b p₁, less the rounding of the root.
    let filling = alone("pneumatic-cylinder", "20 ms")
        .replace("0.5*sin(2 rad/s*t)", "1")
        .replace("mass = \"5 kg\"", "mass = \"5e9 kg\"")
        .replace("inertia = \"0.4 kg m^2\"", "inertia = \"1e9 kg m^2\"")
        .replace("\"0.3 MPa\"", "\"0.1 MPa\"")
        .replace("1e-12", "1e-9");
    let mechanism = derive(model(&filling));
    let motion = solve(&mechanism);
    let state = coordinate(&mechanism, "piston_pressure_integral");
    let volume = motion.samples[0].signals[signal(&mechanism, "piston_volume")];
    let rate = 1.2 * 1e5 * 2e-8 * 0.7e6 / volume / 1.0001_f64.sqrt();
    let last = motion.samples.last().expect("samples");
    assert!(last.v[state] < 0.3 * 0.7e6, "{} Pa", last.v[state]);
    close("pressure", last.v[state], 1e5 + rate * 0.02, Within { relative: 1e-6, absolute: 0.0 });
}
