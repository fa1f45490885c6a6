//! States and signals of controllers and motors against reference motions, and what must not see them.

use bksim::model::file::{Source, read};

use crate::support::elements::Quantity::{Measure, Position, Signal, Velocity};
use crate::support::elements::{Quantity, check, check_rows, number, text};
use crate::support::{Within, close, derive, model, solve};

#[test]
fn a_continuous_pid() {
    let columns: [(&str, Quantity<'_>); 4] = [
        ("x", Measure("S.position", 1.0)),
        ("v", Velocity("S_position", 1.0)),
        ("e", Velocity("e_integral", 1.0)),
        ("u", Signal(0)),
    ];
    check(&text("pid-continuous"), "elements/pid_continuous", &columns);
}

#[test]
fn a_motor_with_inductance() {
    let columns: [(&str, Quantity<'_>); 3] = [
        ("i", Velocity("i_integral", 1.0)),
        ("w", Velocity("A_angle", 1.0)),
        ("phi", Measure("A.angle", 1.0)),
    ];
    let motor = text("dc-motor");
    check(&motor, "elements/dc_motor", &columns);
    // The implicit method integrates states as well.
    check(&format!("{motor}method = \"radau\"\n"), "elements/dc_motor", &columns);
    // As the reference of the model file says it.
    let page = include_str!("../../docs/model-reference.md");
    let recipe =
        page.split("```toml\n# A DC motor").nth(1).and_then(|rest| rest.split("```").next());
    let solve = "[solve]\nt_end = 0.3\nevery = 0.01\nrtol = 1e-12\natol = 1e-12\n";
    check(&format!("#{}\n{solve}", recipe.expect("a recipe")), "elements/dc_motor", &columns);
    // No unit of the file enters a volt.
    let units = "[units]\nlength = \"mm\"\nmass = \"g\"\ntime = \"ms\"\nforce = \"kN\"\n";
    check(&format!("{units}{motor}"), "elements/dc_motor", &columns);
}

#[test]
fn the_energy_of_a_motor_goes_into_its_rotor_its_coil_and_heat() {
    let motor = text("dc-motor").replace(
        "[loads.motor]",
        "[states.taken]\nrate = \"U*i\"\nstart = \"0 J\"\n\n\
         [states.heat]\nrate = \"R*i^2 + b*A.rate^2\"\nstart = \"0 J\"\n\n[loads.motor]",
    );
    let mechanism = derive(model(&motor));
    let motion = solve(&mechanism);
    let [i, taken, heat] = ["i_integral", "taken_integral", "heat_integral"]
        .map(|name| crate::support::coordinate(&mechanism, name));
    for sample in &motion.samples {
        let coil = 0.5 * 2e-3 * sample.v[i] * sample.v[i];
        let kept = sample.energy.kinetic + coil + sample.v[heat];
        close("energy", kept, sample.v[taken], Within { relative: 1e-10, absolute: 1e-12 });
    }
    let last = motion.samples.last().expect("samples");
    assert!(last.v[taken] > 10.0, "{} J", last.v[taken]);
}

#[test]
fn a_limited_torque_without_and_with_anti_windup() {
    let columns: [(&str, Quantity<'_>); 4] = [
        ("w", Velocity("A_angle", 1.0)),
        ("I", Velocity("I_integral", 1.0)),
        ("v", Signal(0)),
        ("u", Signal(1)),
    ];
    let plain = text("antiwindup");
    check_rows(&plain, "elements/antiwindup", &|row| number(row, 0) == 0.0, &columns);
    check_rows(
        &plain.replace("kb = 0", "kb = 4"),
        "elements/antiwindup",
        &|row| number(row, 0) == 1.0,
        &columns,
    );
}

#[test]
fn a_cart_and_pole_with_an_integral() {
    let columns: [(&str, Quantity<'_>); 5] = [
        ("x", Position("x", 1.0)),
        ("v", Velocity("x", 1.0)),
        ("th", Position("th", 1.0)),
        ("w", Velocity("th", 1.0)),
        ("e", Velocity("e_integral", 1.0)),
    ];
    check(&text("cartpole-lqi"), "elements/cartpole_lqi", &columns);
}

#[test]
fn a_state_is_neither_a_freedom_nor_energy() {
    let mechanism = derive(model(&text("pid-continuous")));
    let start = mechanism.start().expect("a start");
    assert_eq!(start.mobility, 1);
    let motion = solve(&mechanism);
    for sample in &motion.samples {
        // Of the mass alone; the power is that of the force.
        let speed = sample.v[0];
        close(
            "kinetic",
            sample.energy.kinetic,
            speed * speed,
            Within { relative: 1e-12, absolute: 1e-15 },
        );
    }
}

#[test]
fn units_of_a_motor_reach_written_code() {
    use bksim::analysis::{Part, exported};
    let mechanism = derive(model(&text("dc-motor")));
    let functions = exported(&mechanism, Part::Dynamics, &["U".to_owned()]).expect("functions");
    let terms = &functions[0].signature;
    let pairs = |of: &[bksim::expr::Quantity]| -> Vec<(String, String)> {
        of.iter().map(|known| (known.name.clone(), known.unit.clone())).collect()
    };
    let own = |all: &[(&str, &str)]| -> Vec<(String, String)> {
        all.iter().map(|(name, unit)| ((*name).to_owned(), (*unit).to_owned())).collect()
    };
    let inputs = [
        ("t", "s"),
        ("A_angle", "rad"),
        ("i_integral", "C"),
        ("A_angle_dot", "rad/s"),
        ("i", "A"),
        ("U", "V"),
    ];
    assert_eq!(pairs(&terms.inputs), own(&inputs));
    let parameters = [("R", "ohm"), ("L", "H"), ("k", "N m/A"), ("b", "N m s")];
    assert_eq!(pairs(&terms.parameters), own(&parameters));
    let outputs = [
        ("M[0,0]", "kg*m^2"),
        ("M[0,1]", ""),
        ("M[1,0]", ""),
        ("M[1,1]", ""),
        ("f[0]", "N*m"),
        ("f[1]", "A/s"),
    ];
    assert_eq!(pairs(&terms.outputs), own(&outputs));
    let accelerations = &functions[1].signature;
    let outputs = [("A_angle_ddot", "rad/s^2"), ("i_dot", "A/s")];
    assert_eq!(pairs(&accelerations.outputs), own(&outputs));
}

#[test]
fn named_constants_of_a_motor_have_its_units() {
    // Two coils in series, and a torque constant of two magnets.
    let motor = text("dc-motor")
        .replace("k = \"0.05 N m/A\"", "k = \"0.02 N m/A\"\nm = \"0.03 N m/A\"\nR2 = \"0.2 ohm\"")
        .replace("R*i - k*A.rate)/L", "(R + R2*sqrt(k/m))*i - (k + m*k/(k + m))*A.rate)/(1 H)")
        .replace("value = \"k*i", "value = \"(k + m*k/(k + m))*i");
    let mechanism = derive(model(&motor));
    let form = bksim::mbs::equations::ReadingForm::grouped(&mechanism.model, &mechanism.system);
    let units: Vec<&str> = form.groups.iter().map(|group| group.unit.as_str()).collect();
    assert_eq!(units, ["N m/A", "s^-1"], "{:?}", form.groups);
}

/// A sampled controller of the current, a measured torque, limits of the voltage: with units, in a file in
/// millimetres, as in bare numbers.
#[test]
fn a_sampled_motor_in_units_is_that_of_bare_numbers() {
    let parts = |file: &str, numbers: [&str; 9], units: &str| {
        let [resistance, inductance, constant, most, wanted, gain, start, every, zero] = numbers;
        format!(
            r#"{file}
[parameters]
R = {resistance}
L = {inductance}
k = {constant}
U_max = {most}
wanted = {wanted}
gain = {gain}

[tables.torque]
points = [[-4, -0.21], [0, 0], [2, 0.1], [4, 0.17]]
extrapolate = "linear"
{units}

[bodies.rotor]
mass = "1 kg"
inertia = "2e-4 kg m^2"

[joints.A]
type = "revolute"
between = ["ground", "rotor"]

[clocks.control]
every = {every}

[signals.error]
clock = "control"
value = "wanted - i"

[signals.U]
clock = "control"
value = "min(U_max, max(-U_max, previous(U) + gain*(1.4*error - previous(error))))"
start = {zero}

[states.i]
rate = "(U - R*i - k*A.rate)/L"
start = {start}

[loads.motor]
type = "torque"
on = "rotor"
value = "torque(i)"

[solve]
t_end = "50 ms"
every = "1 ms"
"#
        )
    };
    let written = [
        r#""800 mohm""#,
        r#""2 mH""#,
        r#""0.05 V s/rad""#,
        r#""0.024 kV""#,
        r#""1500 mA""#,
        r#""2 V/A""#,
        r#""0.2 A""#,
        r#""1 ms""#,
        r#""0 V""#,
    ];
    let bare = ["0.8", "0.002", "0.05", "24", "1.5", "2", "0.2", "0.001", "0"];
    let with_units = parts("[units]\nlength = \"mm\"\n", written, "units = [\"A\", \"N m\"]");
    let [with_units, bare] = [with_units, parts("", bare, "")].map(|text| derive(model(&text)));
    let unit = |name: &str| {
        let signals = with_units.model.named_signals.iter();
        signals.filter(|s| s.name == name).map(|s| s.unit.clone()).collect::<String>()
    };
    assert_eq!([unit("error"), unit("U")], ["A", "V"]);
    let [found, expected] = [&with_units, &bare].map(solve);
    assert_eq!(found.samples.len(), 51);
    for (found, expected) in found.samples.iter().zip(&expected.samples) {
        assert_eq!((&found.q, &found.v), (&expected.q, &expected.v), "at {} s", found.t);
        assert_eq!(found.signals, expected.signals, "at {} s", found.t);
    }
    let current = crate::support::coordinate(&with_units, "i_integral");
    let last = found.samples.last().expect("samples").v[current];
    assert!((last - 1.5).abs() < 0.3, "{last} A");
}

/// A pendulum of 2 kg on a rod of 1.5 m.
const PENDULUM: &str = "
[bodies.bob]
mass = \"2 kg\"
com = [0, \"-1.5 m\"]
[joints.A]
type = \"revolute\"
between = [\"ground\", \"bob\"]
[loads.gravity]
type = \"gravity\"
acceleration = [0, \"-9.81 m/s^2\"]
[initial]
A = { angle = \"70 deg\" }
[solve]
t_end = \"2 s\"
every = \"0.1 s\"
rtol = 1e-10
atol = 1e-12
";

#[test]
fn outputs_name_accelerations_and_reactions_of_results() {
    let outputs = "[outputs]\ntwice = \"sway + sway\"\nsway = \"bob.ax\"\nswing = \"A.acceleration\"\n\
                   pull = \"hypot(reactions.A.fx, reactions.A.fy)\"\nangle = \"A.angle\"\nrate = \"A.rate\"\n";
    let mechanism = derive(model(&format!("{PENDULUM}{outputs}")));
    let place = |name: &str| {
        let all = &mechanism.model.named_signals;
        let place = all.iter().position(|signal| signal.name == name).expect("an output");
        assert!(all[place].is_output);
        (place, all[place].unit.clone())
    };
    let motion = solve(&mechanism);
    let (g, l, m) = (9.81, 1.5, 2.0);
    for sample in &motion.samples {
        let [angle, rate] = ["angle", "rate"].map(|name| sample.signals[place(name).0]);
        let swing = -g / l * angle.sin();
        let sway = l * (swing * angle.cos() - rate * rate * angle.sin());
        for (name, unit, expected) in [
            ("twice", "m/s^2", 2.0 * sway),
            ("sway", "m/s^2", sway),
            ("swing", "1/s^2", swing),
            ("pull", "N", m * (g * angle.cos() + l * rate * rate)),
        ] {
            let (place, found) = place(name);
            close(name, sample.signals[place], expected, Within { relative: 0.0, absolute: 1e-8 });
            assert_eq!(found, unit, "{name}");
        }
    }
}

#[test]
fn nothing_of_the_motion_depends_on_an_output_that_uses_accelerations() {
    let with = |section: &str| format!("{PENDULUM}{section}[outputs]\nsway = \"bob.ax\"\n");
    for section in [
        "[loads.f]\ntype = \"force\"\non = \"bob\"\nvector = [\"1 kg*sway\", 0]\n",
        "[signals.s]\nvalue = \"sway\"\n",
        "[states.s]\nrate = \"sway\"\nstart = \"0 m/s\"\n",
    ] {
        let text = with(section);
        let faults = read(&Source::new(&text, "pendulum")).diagnostics;
        let is_told = |fault: &bksim::model::diagnostic::Diagnostic| {
            fault.code.0 == "M028" && fault.message.contains("sway")
        };
        assert!(faults.iter().any(is_told), "{section}: {faults:?}");
    }
}

#[test]
fn written_numbers_in_outputs_are_pure_numbers() {
    let outputs = "[outputs]\nhalf = \"A.angle/2\"\ntwice = \"2*bob.x\"\nrate = \"60*A.rate/(2*pi)\"\n\
                   inverse = \"1/A.rate\"\nsum = \"A.angle/2 + 1\"\n";
    let of = |units: &str| model(&format!("{units}{PENDULUM}{outputs}"));
    for model in [of(""), of("[units]\nlength = \"mm\"\nangle = \"deg\"\n")] {
        let units: Vec<_> = model.named_signals.iter().map(|one| one.unit.as_str()).collect();
        assert_eq!(units, ["rad", "m", "1/s", "s", "rad"]);
    }
    // In loads they stay coefficients of whatever unit is needed.
    let load = "[loads.f]\ntype = \"torque\"\non = \"bob\"\nvalue = \"-2*A.rate\"\n";
    let faults = read(&Source::new(&format!("{PENDULUM}{load}"), "pendulum")).diagnostics;
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn a_state_with_a_bare_start_has_the_unit_of_its_rate() {
    let with = |sections: &str| format!("{PENDULUM}{sections}");
    // A rate in kg, through a signal that stands behind the one that uses the state.
    let torque = "[loads.f]\ntype = \"torque\"\non = \"bob\"\nvalue = \"e\"\n";
    let through = "[signals.a]\nvalue = \"e\"\n[signals.b]\nvalue = \"3 kg\"\n\
                   [states.e]\nrate = \"b\"\nstart = 0\n";
    for (sections, used) in [
        (format!("[states.e]\nrate = \"3 kg\"\nstart = 0\n{torque}"), "\"e\""),
        (format!("{through}{}", torque.replace("\"e\"", "\"a\"")), "\"a\""),
    ] {
        let text = with(&sections);
        let faults = read(&Source::new(&text, "pendulum")).diagnostics;
        let [fault] = faults.as_slice() else { panic!("{faults:?}") };
        assert!(fault.message.contains("kg s"), "{}", fault.message);
        let at = text.rfind(used).expect("the use of the state") + 1;
        assert_eq!(fault.labels[0].span.start, at);
    }
    // A start in the units of the file, as with its unit.
    let units = "[units]\nlength = \"mm\"\n";
    let starts = ["2", "\"2 mm s\""].map(|start| {
        let state = format!("[states.e]\nrate = \"bob.x\"\nstart = {start}\n");
        let mechanism = derive(model(&format!("{units}{PENDULUM}{state}")));
        let e = crate::support::coordinate(&mechanism, "e_integral");
        solve(&mechanism).samples[0].v[e]
    });
    assert_eq!(starts[0], starts[1]);
    close("the start", starts[0], 0.002, Within { relative: 1e-15, absolute: 0.0 });
}

#[test]
fn what_outputs_measure_leaves_the_formulation_as_it_is() {
    let outputs = "[outputs]\npull = \"reactions.A.fy\"\nalong = \"reactions.A.fx_joint\"\n";
    let text = |sections: &str| format!("{PENDULUM}{sections}");
    let names = |text: &str| {
        let mechanism = derive(model(text));
        let system = &mechanism.system;
        let names: Vec<String> =
            system.coordinates().iter().map(|coordinate| coordinate.name.clone()).collect();
        (names, system.constraints.len())
    };
    let plain = names(&text(""));
    assert_eq!(plain.1, 0, "a pendulum needs no constraint");
    assert_eq!(names(&text(outputs)), plain);
    // A signal that nothing uses is measured, no more; a load that follows it needs the multiplier.
    let signal = "[signals.pull]\nvalue = \"reactions.A.fy\"\n";
    assert_eq!(names(&text(signal)), plain);
    let load = "[loads.f]\ntype = \"torque\"\non = \"bob\"\nvalue = \"-0.01 m*pull\"\n";
    assert!(names(&text(&format!("{signal}{load}"))).1 > 0);
    // The outputs are the reactions that are reported.
    let mechanism = derive(model(&text(outputs)));
    for sample in &solve(&mechanism).samples {
        let within = Within { relative: 1e-12, absolute: 1e-12 };
        close("pull", sample.signals[0], sample.reactions[0][1], within);
        close("along", sample.signals[1], sample.reactions[0][0], within);
    }
}

#[test]
fn outputs_name_the_efforts_of_drives() {
    let driven = PENDULUM.replace(
        "[initial]\nA = { angle = \"70 deg\" }\n",
        "[drives.swing]\njoint = \"A\"\nmotion = \"0.4 rad*sin(3 rad/s*t)\"\n",
    );
    let outputs = "[outputs]\ntorque = \"drives.swing\"\npower = \"drives.swing*A.rate\"\n";
    let model = model(&format!("{driven}{outputs}"));
    let units: Vec<_> = model.named_signals.iter().map(|one| one.unit.as_str()).collect();
    assert_eq!(units, ["N m", "W"]);
    let (g, l, m) = (9.81, 1.5, 2.0);
    for sample in &solve(&derive(model)).samples {
        let [s, c] = [(3.0 * sample.t).sin(), (3.0 * sample.t).cos()];
        let torque = m * l * (l * -3.6 * s + g * (0.4 * s).sin());
        let within = Within { relative: 1e-9, absolute: 1e-9 };
        close("torque", sample.signals[0], torque, within);
        close("power", sample.signals[1], torque * 1.2 * c, within);
    }
    // Loads know no efforts of drives, and names are looked up.
    for (section, word) in [
        ("[loads.f]\ntype = \"torque\"\non = \"bob\"\nvalue = \"drives.swing\"\n", "drives"),
        ("[outputs]\nx = \"drives.swin\"\n", "swing"),
    ] {
        let text = format!("{driven}{section}");
        let faults = read(&Source::new(&text, "pendulum")).diagnostics;
        let [fault] = faults.as_slice() else { panic!("{faults:?}") };
        let words = format!("{} {}", fault.message, fault.help.clone().unwrap_or_default());
        assert!(words.contains(word), "{words}");
    }
}
