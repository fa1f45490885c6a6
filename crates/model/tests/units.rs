//! Numbers with units, and without.

use bksim_model::file::{Source, read};
use bksim_model::{LoadKind, Measure, StateId};

use crate::reading::{FLOATING, assert_close, model, value};

#[test]
fn bare_numbers_are_in_the_units_of_the_file() {
    let text = "[units]\nlength = \"mm\"\nangle = \"deg\"\n[parameters]\nl = 80\n[bodies.b]\nmass = 2\n\
                inertia = 500\npoints = { A = [\"l\", \"l + 20\"], B = [\"2*l\", \"1 cm + l\"] }\n\
                free = true\n[initial]\nb = { angle = 90, y = 5 }\n";
    let model = model(text);
    let body = &model.bodies[1];
    assert_close(value(&model, body.inertia.moments[2]), 500e-6);
    let [a, b] = [0, 1].map(|idx| body.points[idx].position.map(|e| value(&model, e)));
    assert_eq!((a, b), ([0.08, 0.1, 0.0], [0.16, 0.09, 0.0]));
    let start: Vec<f64> = model.initial.iter().map(|start| value(&model, start.value)).collect();
    assert_close(start[0], std::f64::consts::FRAC_PI_2);
    assert_eq!(start[1], 0.005);
}

/// A coefficient of friction, teeth, a ratio and a share, in a file whose bare lengths are millimetres.
#[test]
fn parameters_without_unit_are_pure_numbers_where_they_are_multiplied() {
    let units = "[units]\nlength = \"mm\"\nforce = \"kN\"\n";
    let text = format!(
        "{units}[parameters]\nmu = 0.1\nz1 = 18\nz2 = 54\nF = \"120 N\"\ni = \"z2/z1\"\ns = 0.5\n\
         [signals.share]\nvalue = \"2*F*s/(1 + s^2)\"\n\
         [loads.f]\ntype = \"force\"\non = \"b\"\nvector = [\"mu*F*i + share\", 3]\n{FLOATING}"
    );
    let reading = read(&Source::new(&text, "test"));
    assert!(reading.diagnostics.is_empty(), "{:?}", reading.diagnostics);
    let model = reading.model.expect("a model");
    let LoadKind::Force { vector, .. } = &model.loads[0].kind else { panic!("a force") };
    assert_close(value(&model, vector[0]), 0.1 * 120.0 * 3.0 + 2.0 * 120.0 * 0.5 / 1.25);
    assert_close(value(&model, vector[1]), 3000.0);

    // Where that does not fit, the fault says which numbers were taken so.
    let text = format!(
        "{units}[parameters]\na = 50\nI = \"1 kg*a^2\"\n[bodies.c]\nmass = \"1 kg\"\ninertia = \"I\"\n{FLOATING}"
    );
    let reading = read(&Source::new(&text, "test"));
    let fault = reading.diagnostics.iter().find(|fault| fault.code.0 == "M031").expect("a fault");
    assert_eq!(fault.notes, ["`a` has no unit, and is a pure number where multiplied"]);
}

#[test]
fn motions_that_are_rates_and_rates_that_are_values_are_cured() {
    let help = |motion: &str| {
        let text = format!(
            "[bodies.b]\nmass = 1\ninertia = 1\n[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"b\"]\n\
             [drives.d]\njoint = \"A\"\nmotion = \"{motion}\"\n"
        );
        let faults = read(&Source::new(&text, "test")).diagnostics;
        faults.into_iter().next().and_then(|fault| fault.help)
    };
    for (motion, cured) in [
        ("100 rpm", "100 rpm*t"),
        ("2*pi rad/s + 3 rad/s", "(2*pi rad/s + 3 rad/s)*t"),
        ("-60 deg*t", "-60 deg/s*t"),
        ("t*60 deg", "t*60 deg/s"),
    ] {
        let found = help(motion).unwrap_or_default();
        assert!(found.ends_with(&format!("write \"{cured}\"")), "{motion}: {found}");
        assert_eq!(help(cured), None, "{cured}");
    }
}

#[test]
fn electrical_units_make_mechanical_ones() {
    let text = format!(
        "[parameters]\nU = \"12 V\"\nI = \"500 mA\"\nP = \"U*I + 1 W\"\nR = \"U/I\"\nk = \"0.05 V s/rad\"\n\
         torque = \"k*I\"\nL = \"0.5 mH\"\ntau = \"L/R\"\nslope = \"U/L\"\nQ = \"2 Ah\"\nE = \"Q*U\"\n\
         C = \"sqrt(4 F^2)\"\nZ = \"4.7 kΩ\"\nB = \"0.8 T\"\npull = \"B*I*2 m\"\nheat = \"R*I^2*60 s\"\n{FLOATING}"
    );
    let model = model(&text);
    let all = |name: &str| {
        let found = model.parameters.iter().find(|p| p.name == name).expect("a parameter");
        (found.unit.as_str(), found.value)
    };
    let expected = [
        ("P", "W", 7.0),
        ("R", "ohm", 24.0),
        ("k", "N m/A", 0.05),
        ("torque", "N m", 0.025),
        ("L", "H", 5e-4),
        ("tau", "s", 5e-4 / 24.0),
        ("slope", "A/s", 24_000.0),
        ("Q", "C", 7200.0),
        ("E", "N m", 86_400.0),
        ("C", "F", 2.0),
        ("Z", "ohm", 4700.0),
        ("pull", "N", 0.8),
        ("heat", "N m", 360.0),
    ];
    for (name, unit, value) in expected {
        assert_eq!(all(name).0, unit, "{name}");
        assert_close(all(name).1, value);
    }
}

/// A volt is kg m² s⁻³ A⁻¹: none of the units of the file may enter it.
#[test]
fn volts_hold_no_millimetres() {
    let units = "[units]\nlength = \"mm\"\nmass = \"g\"\ntime = \"ms\"\nforce = \"kN\"\n";
    let text = format!(
        "{units}[parameters]\nU = \"12 V + 3\"\nR = \"2 ohm + 1\"\nk = \"0.05 N m/A + 0.01\"\n\
         torque = \"0.05 N m/A*2 A\"\nmore = \"torque + 500\"\n{FLOATING}\
         [states.i]\nrate = \"(U - R*i)/(2 mH) + 7\"\nstart = \"0.5 A\"\n"
    );
    let model = model(&text);
    let values: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    // A torque is mechanical: 500 kN mm.
    let expected = [15.0, 3.0, 0.06, 0.1, 500.1];
    for (found, expected) in values.iter().zip(expected) {
        assert_close(*found, expected);
    }
    let state = &model.states[0];
    assert_eq!(state.units, ["C", "A", "A/s"]);
    assert_eq!(state.exponents, Some([0, 0, 0, 1]));
    let i = model.signals.iter().find(|s| s.measure == Measure::State(StateId(0)));
    let i = i.expect("a signal").symbol;
    let of = |symbol| {
        let known = model.parameters.iter().find(|p| p.symbol == symbol);
        known.map(|p| p.value).or((symbol == i).then_some(0.5))
    };
    let rate = model.pool.evaluate(state.rate, &of).expect("a value");
    assert_close(rate, (15.0 - 3.0 * 0.5) / 2e-3 + 7.0);
}
