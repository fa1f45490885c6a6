//! Models are read to the values their authors meant.

use bksim_expr::Expr;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::{Source, code, read};
use bksim_model::{GROUND, JointKind, LoadKind, Measure, Model, Outputs, Space};

pub(crate) fn model(text: &str) -> Model {
    let reading = read(&Source::new(text, "test"));
    reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics))
}

/// The value of an expression at the parameters of the model.
pub(crate) fn value(model: &Model, e: Expr) -> f64 {
    let of = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    model.pool.evaluate(e, &of).expect("an expression of parameters")
}

pub(crate) fn assert_close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * expected.abs().max(1e-12),
        "{found} for {expected}"
    );
}

pub(crate) const FLOATING: &str = "[bodies.b]\nmass = 1\nfree = true\n";

#[test]
fn the_model_of_the_reference_is_read() {
    let page = include_str!("../../../docs/model-reference.md");
    let text = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let reading = read(&Source::new(text.expect("an example"), "test"));
    assert!(reading.diagnostics.is_empty(), "{:?}", reading.diagnostics);
    let model = reading.model.expect("a model");
    assert_eq!((model.name.as_str(), model.space), ("slider-crank", Space::Planar));
    assert_eq!((model.bodies.len(), model.joints.len()), (4, 4));
    assert_close(value(&model, model.bodies[1].inertia.moments[2]), 0.5 * 0.01 / 12.0);
    assert_eq!(model.signals.len(), 1);
    assert_eq!(model.signals[0].measure, Measure::JointVelocity(model_joint(&model, "A"), 0));
    assert_eq!(model.initial.iter().filter(|start| start.is_guess).count(), 1);
}

fn model_joint(model: &Model, name: &str) -> bksim_model::JointId {
    let idx = model.joints.iter().position(|joint| joint.name == name);
    bksim_model::JointId(idx.expect("a joint"))
}

#[test]
fn quantities_are_exact_in_si() {
    let text = format!("[parameters]\na = \"25 mm\"\nb = \"30 deg\"\nc = 0.1\n{FLOATING}");
    let model = model(&text);
    let [a, b, c] = [0, 1, 2].map(|idx| model.parameters[idx].definition);
    assert_eq!(a, model.pool.rational(1, 40));
    assert_eq!(b, model.pool.mul(model.pool.rational(1, 6), model.pool.pi()));
    assert_eq!(c, model.pool.rational(1, 10));
    let units: Vec<&str> = model.parameters.iter().map(|p| p.unit.as_str()).collect();
    assert_eq!(units, ["m", "rad", ""]);
}

#[test]
fn units_and_parameters_of_one_name_are_told_apart() {
    let text = format!(
        "[parameters]\nm = \"2 kg\"\nh = \"3 m\"\nk = \"4 N/m\"\nT = \"4 N m\"\n\
         I = \"5 kg*h^2\"\nW = \"2 m/s^2 * m\"\n{FLOATING}"
    );
    let model = model(&text);
    let units: Vec<(&str, f64)> =
        model.parameters.iter().map(|p| (p.unit.as_str(), p.value)).collect();
    let expected =
        [("kg", 2.0), ("m", 3.0), ("N/m", 4.0), ("N m", 4.0), ("kg m^2", 45.0), ("N", 4.0)];
    assert_eq!(units, expected);
}

/// After a written `*`, also the parameter of a curve, a signal and a coordinate.
#[test]
fn names_come_before_units_of_the_same_name() {
    for name in ["s", "T", "A", "V"] {
        let text = format!(
            "[curves.track]\ntype = \"formula\"\nparameter = \"{name}\"\n\
             formula = [\"0.5 m*{name}\", \"0.3 m*{name}^2\"]\n\
             [bodies.b]\nmass = 1\ninertia = 1\nfree = true\n\
             [joints.roller]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"b\"]\ncurve = \"track\"\n\
             [bodies.slide]\nmass = 1\n[joints.guide]\ntype = \"prismatic\"\naxis = [1, 0]\n\
             between = [\"ground\", \"slide\"]\ncoordinate = \"C\"\n\
             [signals.H]\nvalue = \"2 N/m*C\"\n[loads.push]\ntype = \"force\"\non = \"slide\"\n\
             vector = [\"3 s/s*H + H/(0.2 m)*C\", 0]\n"
        );
        let reading = read(&Source::new(&text, "test"));
        assert!(reading.diagnostics.is_empty(), "{name}: {:?}", reading.diagnostics);
    }
}

#[test]
fn definitions_keep_the_names_of_parameters_and_come_in_order() {
    let text = format!("[parameters]\ns = \"l/2\"\nl = 3\n{FLOATING}");
    let model = model(&text);
    let names: Vec<&str> = model.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["l", "s"]);
    let l = model.pool.symbol("l");
    assert_eq!(model.parameters[1].definition, model.pool.div(l, model.pool.int(2)));
    assert_eq!(model.parameters[1].value, 1.5);
}

#[test]
fn values_are_replaced_by_their_path() {
    let text = r#"
        [units]
        length = "mm"
        [parameters]
        l = "40 mm"
        [bodies.rod]
        mass = 2
        com = [20, "l/2"]
        inertia = "3 kg mm^2"
        [bodies.A]
        mass = "1 kg"
        [joints.pin]
        type = "revolute"
        between = ["ground", "rod"]
        [joints.guide]
        type = "prismatic"
        between = ["ground", "A"]
        axis = [1, 0]
    "#;
    let set = |pairs: &[(&str, &str)]| {
        let pair = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        let overrides: Vec<(String, String)> = pairs.iter().map(pair).collect();
        read(&Source { overrides: &overrides, ..Source::new(text, "test") })
    };
    let reading = set(&[("rod.mass", "0.5 kg"), ("rod.com.1", "2*l"), ("bodies.A.mass", "7")]);
    assert_eq!(reading.diagnostics, []);
    let model = reading.model.expect("a model");
    let value = |e| value(&model, e);
    let [rod, block] = [1, 2].map(|body| &model.bodies[body]);
    assert_eq!([rod.mass, block.mass].map(value), [0.5, 7.0]);
    // The other entry is in the units of the file, as it was.
    assert_eq!([rod.com[0], rod.com[1]].map(value), [0.02, 0.08]);
    let names: Vec<&str> = model.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["l", "rod.mass", "rod.com.1", "bodies.A.mass"]);

    // A path that leads nowhere, to a table, or to two sections, is refused.
    for path in ["rod.weight", "rod.com.7", "bodies.rod", "A.mas"] {
        let codes: Vec<_> = set(&[(path, "1")]).diagnostics.iter().map(|d| d.code).collect();
        assert_eq!(codes, [code::UNKNOWN_OVERRIDE], "{path}");
    }
    // A fault points at the value that is replaced.
    let reading = set(&[("rod.inertia", "3 kg m")]);
    let fault = &reading.diagnostics[0];
    assert_eq!(&text[fault.labels[0].span.clone()], "\"3 kg mm^2\"", "{fault:?}");
}

/// A rectangle a × b about its centre: m (a² + b²)/12. Clockwise corners must not change it.
#[test]
fn a_plate_has_the_mass_properties_of_its_outline() {
    let text = "[parameters]\na = 3\nb = 2\n[bodies.p]\ndensity = 10\nthickness = \"100 mm\"\n\
                outline = [[1, 1], [1, \"1 + b\"], [\"1 + a\", \"1 + b\"], [\"1 + a\", 1]]\n\
                free = true\n";
    let model = model(text);
    let plate = &model.bodies[1];
    assert_close(value(&model, plate.mass), 6.0);
    let com = plate.com.map(|e| value(&model, e));
    assert_eq!(com, [2.5, 2.0, 0.0]);
    assert_close(value(&model, plate.inertia.moments[2]), 6.0 * (9.0 + 4.0) / 12.0);
}

#[test]
fn axes_become_unit_vectors() {
    let text = "[bodies.s]\nmass = 1\n[bodies.p]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\n\
                between = [\"ground\", \"s\"]\naxis = [3, 4]\n[joints.P]\ntype = \"slot\"\n\
                between = [\"s\", \"p\"]\ndirection = \"90 deg\"\ncoordinate = [\"u\", \"phi\"]\n";
    let model = model(text);
    let pool = &model.pool;
    assert_eq!(model.joints[0].axis, [pool.rational(3, 5), pool.rational(4, 5), pool.zero()]);
    let axis = model.joints[1].axis.map(|e| value(&model, e));
    assert!(axis[0].abs() < 1e-15 && axis[1] == 1.0, "{axis:?}");
    assert_eq!(model.joints[1].kind, JointKind::PinInSlot);
    assert_eq!(model.joints[1].coordinate_names, ["u", "phi"]);
}

#[test]
fn a_part_out_of_the_plane_makes_the_model_spatial() {
    let text = "[bodies.b]\nmass = 1\n[joints.A]\ntype = \"revolute\"\n\
                between = [\"ground\", \"b\"]\naxis = [1, 0, 0]\n";
    assert_eq!(model(text).space, Space::Spatial);
    assert_eq!(model(&text.replace("[1, 0, 0]", "[0, 0, -2]")).space, Space::Planar);
}

#[test]
fn a_torque_at_a_joint_acts_between_its_bodies() {
    let text = "[bodies.b]\nmass = 1\n[joints.A]\ntype = \"revolute\"\n\
                between = [\"ground\", \"b\"]\n[loads.M]\ntype = \"torque\"\njoint = \"A\"\n\
                value = \"3*sin(2*t)\"\n";
    let model = model(text);
    let LoadKind::Effort { joint, motion_idx, .. } = model.loads[0].kind else {
        panic!("a torque in a joint")
    };
    assert_eq!((joint.0, motion_idx), (0, 0));
    // Components are in the axes of the ground, whichever axis the joint has.
    let text = text.replace("value = \"3*sin(2*t)\"", "vector = [0, 0, 1]");
    let LoadKind::Torque { on, from, .. } = self::model(&text).loads[0].kind else {
        panic!("a torque")
    };
    assert_eq!((on.0, from), (1, GROUND));
}

#[test]
fn warnings_do_not_reject() {
    let text = format!("{FLOATING}points = {{ A = [250, 0] }}\n");
    let reading = read(&Source::new(&text, "test"));
    assert!(reading.model.is_some());
    assert_eq!(reading.diagnostics.len(), 1);
    assert!(!reading.diagnostics.iter().any(Diagnostic::is_error));
}

/// Example 1 of Lê Hồng Lam and Đinh Văn Phong (2008), as its authors cut it.
#[test]
fn the_slider_crank_of_the_paper_is_read_with_its_names() {
    let text = r#"
[parameters]
g = 9.8
m1 = 5
m2 = 5
m3 = 20
i1 = 1
i2 = 1
s1 = 0.5
s2 = 1.5
l1 = 1
q1 = 55

[bodies.crank]
mass = "m1"
com = ["s1", 0]
inertia = { value = "i1", about = "A" }
points = { A = [0, 0], B = ["l1", 0] }

[bodies.rod]
mass = "m2"
inertia = "i2"
points = { B = ["-s2", 0], C = ["s2", 0] }
coordinates = ["x2", "y2", "theta2"]

[bodies.slider]
mass = "m3"

[joints.A]
type = "revolute"
between = ["ground", "crank.A"]
coordinate = "theta1"
[joints.B]
type = "revolute"
between = ["crank.B", "rod.B"]
cut = true
[joints.C]
type = "revolute"
between = ["rod.C", "slider"]
cut = true
[joints.D]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
coordinate = "x3"

[loads.gravity]
type = "gravity"
acceleration = [0, "-g"]
[loads.motor]
type = "torque"
on = "crank"
value = "q1 - 0*theta1_dot*x2"

[initial]
theta1 = 0
theta1_dot = 0
rod = { guess = { x = 1 } }
"#;
    let reading = read(&Source::new(text, "test"));
    // The paper's inertia about the pin is less than m1 s1²: the only thing to say.
    let codes: Vec<&str> = reading.diagnostics.iter().map(|fault| fault.code.0).collect();
    assert_eq!(codes, ["M042"]);
    let model = reading.model.expect("a model");
    let pool = &model.pool;
    assert_eq!(model.bodies[2].points[0].position[0], pool.neg(pool.symbol("s2")));
    assert_eq!(model.bodies[1].inertia.moments[2], pool.symbol("i1"));
    let LoadKind::Gravity { acceleration } = model.loads[0].kind else { panic!("gravity") };
    assert_eq!(acceleration[1], pool.neg(pool.symbol("g")));
    let starts: Vec<(&str, bool)> =
        model.initial.iter().map(|start| (start.name.as_str(), start.is_guess)).collect();
    assert_eq!(starts, [("theta1", false), ("theta1_dot", false), ("rod.x", true)]);
    assert_eq!(model.initial[0].measure, Measure::JointPosition(model_joint(&model, "A"), 0));
    let signals: Vec<String> =
        model.signals.iter().map(|signal| pool.symbol_name(signal.symbol)).collect();
    assert_eq!(signals, ["theta1_dot", "x2"]);
    assert_eq!(model.joints[1].cut, Some(true));
}

#[test]
fn outputs_are_an_interval_or_every_step_or_given_times() {
    let read_with = |line: &str| {
        let text = format!(
            "[bodies.bob]\nmass = 1\n[joints.J]\ntype = \"revolute\"\n\
             between = [\"ground\", \"bob\"]\n[solve]\n{line}\n"
        );
        let reading = read(&Source::new(&text, "bob"));
        let codes: Vec<&str> = reading.diagnostics.iter().map(|d| d.code.0).collect();
        (reading.model.map(|model| (model.solve.every, model.solve.outputs)), codes)
    };
    let cases = [
        ("every = \"20 ms\"", Some((Some(0.02), Outputs::Even)), vec![]),
        ("every = \"step\"", Some((None, Outputs::Steps)), vec![]),
        ("times = [0.1, \"500 ms\"]", Some((None, Outputs::Times(vec![0.1, 0.5]))), vec![]),
        ("times = [0.1]\nevery = 0.1", None, vec!["M055"]),
        ("times = 0.1", None, vec!["M007"]),
        ("every = \"steps\"", None, vec!["M021"]),
    ];
    for (line, expected, codes) in cases {
        assert_eq!(read_with(line), (expected, codes), "{line}");
    }
}

/// Every name that a message may suggest is found again, and coordinates, states, reactions and drives have theirs.
#[test]
fn a_name_finds_its_measure() {
    let text = "[bodies.rod]\nmass = 1\npoints = { tip = [1, 0] }\n[joints.A]\ntype = \"revolute\"\n\
        between = [\"ground\", \"rod\"]\ncoordinate = \"phi\"\n[bodies.ball]\nmass = 1\nfree = true\n\
        [states.i]\nrate = \"phi\"\nstart = \"0 rad*s\"\n[drives.motor]\njoint = \"A\"\nmotion = \"2 rad/s*t\"\n\
        [outputs]\npin = \"reactions.A.force\"\n";
    let model = model(text);
    let names = Measure::names(&model);
    for name in &names {
        assert!(Measure::named(&model, name).is_some(), "{name}");
    }
    let unit =
        |name: &str| Measure::named(&model, name).map(|measure| measure.unit(&model).to_owned());
    let same = [
        ("phi", "A.angle", "rad"),
        ("state.phi", "A.angle", "rad"),
        ("phi_dot", "A.rate", "rad/s"),
        ("acceleration.phi_ddot", "A.acceleration", "rad/s^2"),
        ("ball_x", "ball.x", "m"),
        ("ball_angle_dot", "ball.rate", "rad/s"),
        ("states.i", "i", "s"),
    ];
    for (name, other, si) in same {
        assert_eq!(Measure::named(&model, name), Measure::named(&model, other), "{name}");
        assert_eq!(unit(name).as_deref(), Some(si), "{name}");
    }
    for (name, si) in
        [("reactions.A.force", "N"), ("reactions.A.moment", "N m"), ("drives.motor", "N m")]
    {
        assert_eq!(unit(name).as_deref(), Some(si), "{name}");
        assert!(names.iter().any(|known| known == name), "{name}");
    }
    for name in ["psi", "A.angl", "reactions.B.force", "drives.A", "states.phi2"] {
        assert_eq!(Measure::named(&model, name), None, "{name}");
    }
    // An expression has a resultant by the signals of its components.
    let components: Vec<bool> =
        model.signals.iter().map(|signal| signal.measure.is_reaction()).collect();
    assert_eq!(components.iter().filter(|is_one| **is_one).count(), 3);
}

#[test]
fn ranges_are_in_the_kind_of_their_values() {
    let of = |ranges: &str| {
        let text = format!(
            "[units]\nangle = \"deg\"\n[parameters]\nl1 = \"100 mm\"\nn = 3\nk = \"2*l1\"\n[bodies.b]\nmass = \"1 kg\"\n\
             com = [0, \"l1\"]\n[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"b\"]\n[initial]\nA.angle = \"20 deg\"\n\
             [drives.m]\njoint = \"A\"\nmotion = \"20 deg + 1 rad/s*t\"\n[ranges]\n{ranges}\n"
        );
        read(&Source::new(&text, "test"))
    };
    let reading = of(
        "l1 = [\"80 mm\", \"l1 + 2 cm\"]\nn = [1, 5]\nA.angle = [0, \"90 deg\"]\nbodies.b.mass = [\"500 g\", 2]\n\
         k = [\"100 mm\", \"1 m\"]",
    );
    assert!(reading.diagnostics.is_empty(), "{:?}", reading.diagnostics);
    let ranges = reading.model.expect("a model").ranges;
    let expected = [
        ("parameters.l1", [0.08, 0.12]),
        ("parameters.n", [1.0, 5.0]),
        ("initial.A.angle", [0.0, std::f64::consts::FRAC_PI_2]),
        ("bodies.b.mass", [0.5, 2.0]),
        ("parameters.k", [0.1, 1.0]),
    ];
    assert_eq!(ranges.len(), expected.len());
    for (range, (path, ends)) in ranges.iter().zip(expected) {
        assert_eq!(range.path, path);
        assert_close(range.ends[0], ends[0]);
        assert_close(range.ends[1], ends[1]);
    }
    for (line, code) in [
        ("l2 = [1, 2]", "M125"),
        ("A.rate = [\"0 deg/s\", \"1 deg/s\"]", "M125"),
        ("m.motion = [\"0 deg\", \"1 deg\"]", "M125"),
        ("b.com = [\"0 m\", \"1 m\"]", "M125"),
        ("l1 = [\"80 mm\"]", "M126"),
        ("l1 = [\"120 mm\", \"80 mm\"]", "M126"),
        ("l1 = \"80 mm\"", "M007"),
        ("l1 = [\"80 kg\", \"90 kg\"]", "M031"),
        ("n = [\"1 mm\", \"5 mm\"]", "M031"),
        ("l1 = [\"80 mm\", \"l3\"]", "M021"),
        ("l1 = [\"110 mm\", \"120 mm\"]", "M127"),
    ] {
        let codes: Vec<&str> = of(line).diagnostics.iter().map(|fault| fault.code.0).collect();
        assert_eq!(codes, [code], "{line}");
    }
}
