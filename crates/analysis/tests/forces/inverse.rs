//! Efforts and reactions of given motions against references of 15 digits.

use crate::support::{Problem, difference, model};
use bksim_analysis::{
    Actuators, AnalysisError, EffortLimit, Inverse, Motion, MotorCurve, Range, inverse,
};

/// Compares both tables of a reference: the drive of the model over the times at which the crank is where the
/// rows say, at a constant rate and along a polynomial.
fn needs_these(name: &str, t_end: f64) {
    let problem = Problem::load(name);
    let rows = problem.rows();
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    let times = Range { from: 0.0, to: (last[0] - first[0]) / first[1], n: rows.len() };
    check(&problem, problem.model(), &times, &rows);
    let polynomial = problem.0["model"]["toml_polynomial"].as_str().expect("a model");
    let rows = problem.rows_of("rows_polynomial");
    let times = Range { from: 0.0, to: t_end, n: rows.len() };
    check(&problem, model(polynomial), &times, &rows);
}

fn check(problem: &Problem, model: bksim_model::Model, times: &Range, rows: &[Vec<f64>]) {
    let found = inverse(model, &[], times, &Actuators::default()).expect("efforts");
    for (k, column) in problem.columns().iter().enumerate() {
        let name = match column.as_str() {
            "crank.angle" => "on_A.angle".to_owned(),
            "crank.rate" => "on_A.rate".to_owned(),
            "crank.acceleration" => "on_A.acceleration".to_owned(),
            "drive on A" => "on_A.effort".to_owned(),
            name => name.replace(".F", ".f").replace(".M", ".m"),
        };
        let expected: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        let values = found.table.column(&name).unwrap_or_else(|| panic!("no column {name}"));
        let off = difference(&values, &expected, column.rsplit('.').next() == Some("angle"));
        assert!(off < 1e-10, "{column} differs by {off:e}");
    }
}

#[test]
fn four_bar() {
    needs_these("inv-four-bar", 0.8);
}

#[test]
fn six_bar() {
    needs_these("inv-watt", 0.9);
}

#[test]
fn walking_leg() {
    needs_these("inv-jansen", 1.25);
}

#[test]
fn efforts_follow_the_branches_of_loads_along_the_motion() {
    // A ram that is driven outwards meets a piece beyond 1 m, and a spring by a table.
    let ram = model(
        r#"
        [tables.spring]
        points = [[0, 0], [1, 30], [2, 100]]
        units = ["m", "N"]
        interpolation = "linear"
        [bodies.ram]
        mass = 2
        inertia = 0
        [joints.guide]
        type = "prismatic"
        between = ["ground", "ram"]
        axis = [1, 0]
        coordinate = "x"
        [loads]
        piece = { type = "force", on = "ram", vector = ["if(x > 1 and ram.vx > 0, -7, 0)", 0] }
        table = { type = "force", on = "ram", vector = ["-spring(x)", 0] }
        [drives.motor]
        joint = "guide"
        motion = "1 m/s*t"
        "#,
    );
    let times = Range { from: 0.1, to: 1.9, n: 10 };
    let found = inverse(ram, &[], &times, &Actuators::default()).expect("efforts").table;
    let effort = found.column("motor.effort").expect("the drive's force");
    let reaction = found.column("guide.fy").expect("the guide's force");
    for (k, x) in times.values().into_iter().enumerate() {
        let expected = if x > 1.0 { 7.0 + 30.0 + 70.0 * (x - 1.0) } else { 30.0 * x };
        assert!((effort[k] - expected).abs() < 1e-12, "{x} m: {} N, not {expected}", effort[k]);
        assert!(reaction[k].abs() < 1e-12);
    }
}

/// A parallelogram with a motor at each of its cranks, which lift a weight.
const PARALLELOGRAM: &str = r#"
    [ground]
    points = { O1 = [0, 0], O2 = [0.5, 0] }
    [bodies]
    one = { mass = 1, inertia = 0.01, com = [0.1, 0], points = { O = [0, 0], B = [0.2, 0] } }
    two = { mass = 1.5, inertia = 0.02, com = [0.1, 0], points = { O = [0, 0], B = [0.2, 0] } }
    bar = { mass = 4, inertia = 0.1, com = [0.3, 0], points = { B1 = [0, 0], B2 = [0.5, 0] } }
    [joints]
    A1 = { type = "revolute", between = ["ground.O1", "one.O"] }
    A2 = { type = "revolute", between = ["ground.O2", "two.O"] }
    B1 = { type = "revolute", between = ["one.B", "bar.B1"] }
    B2 = { type = "revolute", between = ["two.B", "bar.B2"] }
    [loads.weight]
    type = "gravity"
    acceleration = [0, -9.81]
    [initial]
    A1 = { guess = { angle = 0.6 } }
    A2 = { guess = { angle = 0.6 } }
    bar = { guess = { angle = 0 } }
    "#;

fn column(found: &Inverse, name: &str) -> Vec<f64> {
    found.table.column(name).unwrap_or_else(|| panic!("no {name} in {:?}", found.table.columns))
}

fn swung(actuators: &Actuators) -> Inverse {
    let own = model(PARALLELOGRAM);
    let motion = Motion::formula(&own, "A1.angle", "0.6 + 0.8*sin(3*t)").expect("a motion");
    let times = Range { from: 0.0, to: 2.0, n: 41 };
    inverse(own, &[motion], &times, actuators).expect("efforts")
}

#[test]
fn two_motors_share_a_load_by_their_limits() {
    let alone = column(&swung(&Actuators::default()), "A1.effort");
    let limit = |name: &str, limit: f64| EffortLimit { name: name.to_owned(), limit };
    let actuators = Actuators {
        named: vec!["A1".to_owned(), "A2".to_owned()],
        limits: vec![limit("A1", 8.0), limit("A2", 16.0)],
        curves: Vec::new(),
    };
    let found = swung(&actuators);
    let peak = alone.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(peak > 10.0 && peak < 24.0, "{peak}");
    assert_eq!((found.n_inner, found.missing.len(), found.impossible.len()), (1, 0, 0));
    let [one, two, least, most] = ["A1.effort", "A2.effort", "A1.effort_min", "A1.effort_max"]
        .map(|name| column(&found, name));
    for (k, whole) in alone.iter().enumerate() {
        // The smallest (τ₁/8)² + (τ₂/16)² with τ₁ + τ₂ = τ.
        assert!((one[k] - whole * 64.0 / 320.0).abs() < 1e-9 * peak, "{} of {whole}", one[k]);
        assert!((one[k] + two[k] - whole).abs() < 1e-9 * peak);
        let ends = [(-8.0_f64).max(whole - 16.0), 8.0_f64.min(whole + 16.0)];
        assert!((least[k] - ends[0]).abs() < 1e-5 && (most[k] - ends[1]).abs() < 1e-5);
    }
    let use_of_one = &found.limits[0];
    assert!((use_of_one.share - peak * 0.2 / 8.0).abs() < 1e-9);
}

#[test]
fn limits_that_nothing_keeps_are_told_by_time() {
    let limit = |name: &str| EffortLimit { name: name.to_owned(), limit: 3.0 };
    let actuators = Actuators {
        named: vec!["A1".to_owned(), "A2".to_owned()],
        limits: vec![limit("A1"), limit("A2")],
        curves: Vec::new(),
    };
    let alone = column(&swung(&Actuators::default()), "A1.effort");
    let found = swung(&actuators);
    let beyond = alone.iter().filter(|effort| effort.abs() > 6.0).count();
    assert!(beyond > 0);
    assert_eq!(found.impossible.len(), beyond);
}

/// Two links that hang on each other.
const ARM: &str = r#"
    [bodies]
    upper = { mass = 2, inertia = 0.05, com = [0.25, 0], points = { O = [0, 0], E = [0.5, 0] } }
    fore = { mass = 1, inertia = 0.02, com = [0.2, 0], points = { E = [0, 0], H = [0.4, 0] } }
    [joints]
    A = { type = "revolute", between = ["ground", "upper.O"] }
    B = { type = "revolute", between = ["upper.E", "fore.E"] }
    [loads.weight]
    type = "gravity"
    acceleration = [0, -9.81]
    [initial]
    A = { guess = { angle = 0.3 } }
    B = { guess = { angle = 0.9 } }
    "#;

#[test]
fn a_hand_that_is_led_along_a_line_needs_the_efforts_of_its_joints() {
    let own = model(ARM);
    let motions = [("fore.H.x", "0.6 - 0.2*t"), ("fore.H.y", "0.45 + 0.1*t")]
        .map(|(name, text)| Motion::formula(&own, name, text).expect("a motion"));
    let named = vec!["A".to_owned(), "B".to_owned()];
    let actuators = Actuators { named, ..Actuators::default() };
    let times = Range { from: 0.0, to: 1.0, n: 201 };
    let led = inverse(own, &motions, &times, &actuators).expect("efforts");
    let x = column(&led, "fore.H.x.position");
    assert!((x[200] - 0.4).abs() < 1e-12);
    // The same by the angles that it has shown.
    let own = model(ARM);
    let motions = ["A", "B"].map(|joint| {
        let level = |word: &str| column(&led, &format!("{joint}.{word}"));
        let [value, rate, second] = [level("angle"), level("rate"), level("acceleration")];
        let samples = (0..value.len()).map(|k| [value[k], rate[k], second[k]]).collect();
        let name = format!("{joint}.angle");
        Motion::samples(&own, &name, times.values(), samples).expect("a motion")
    });
    let same = inverse(own, &motions, &times, &Actuators::default()).expect("efforts");
    for name in ["A.effort", "B.effort", "A.fx", "B.fy"] {
        let off = difference(&column(&same, name), &column(&led, name), false);
        assert!(off < 1e-10, "{name}: {off:e}");
    }
}

#[test]
fn operating_points_are_told_beside_the_curve_of_a_motor() {
    let curve = MotorCurve::new("A1", vec![[0.0, 9.0], [2.0, 9.0], [4.0, 1.0]]).expect("a curve");
    let actuators = Actuators { curves: vec![curve], ..Actuators::default() };
    let found = swung(&actuators);
    let duty = &found.duties[0];
    assert_eq!(duty.units, ["rad/s", "N*m"]);
    for [t, speed, effort, limit] in &duty.points {
        assert!((speed - 2.4 * (3.0 * t).cos()).abs() < 1e-9);
        let expected = if speed.abs() < 2.0 { 9.0 } else { 9.0 - 4.0 * (speed.abs() - 2.0) };
        assert!((limit - expected).abs() < 1e-9);
        let is_outside = duty.outside().any(|point| point[0] == *t);
        assert_eq!(is_outside, effort.abs() > expected);
    }
    assert!(duty.outside().count() > 0);
}

#[test]
fn a_table_of_the_model_is_the_curve_of_a_motor() {
    let own = model(
        "[tables.motor]\nunits = [\"rpm\", \"N m\"]\npoints = [[0, 12], [1000, 9.5], [1500, 0]]\n\
         interpolation = \"linear\"\n\
         [tables.smooth]\nunits = [\"rpm\", \"N m\"]\npoints = [[0, 12], [1000, 9.5], [1500, 0]]\n\
         [tables.held]\npoints = [[0, 12], [100, 9.5]]\nextrapolate = \"constant\"\n\
         [tables.push]\nunits = [\"m/s\", \"N\"]\npoints = [[0, 12], [1, 0]]\n\
         [tables.below]\npoints = [[0, 12], [100, -1]]\n\
         [tables.plane]\npoints = [[0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 1, 1]]\n\
         [bodies.rod]\nmass = 1\ninertia = 1\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\n",
    );
    let of = |table: &str| MotorCurve::of_table(&own, "A", table);
    let rpm = std::f64::consts::PI / 30.0;
    let straight = of("motor").expect("a curve");
    for (speed, effort) in
        [(0.0, 12.0), (-500.0, 10.75), (1250.0, 4.75), (1500.0, 0.0), (1600.0, 0.0)]
    {
        assert!((straight.at(speed * rpm) - effort).abs() < 1e-12, "at {speed} rpm");
    }
    assert_eq!(straight.points().len(), 3);
    // The natural spline through three points: its only bend, M, follows from 2 (h0 + h1) M = 6 (d1 - d0).
    let smooth = of("smooth").expect("a curve");
    let bend = 6.0 * (-9.5 / 500.0 + 2.5 / 1000.0) / (2.0 * 1500.0);
    let middle = 10.75 - bend * 1000.0_f64.powi(2) / 16.0;
    assert!((smooth.at(500.0 * rpm) - middle).abs() < 1e-12, "{}", smooth.at(500.0 * rpm));
    assert!(smooth.points().len() > 20);
    assert_eq!(of("held").expect("a curve").at(1e4), 9.5);

    assert!(matches!(of("below"), Err(AnalysisError::BadCurve { .. })));
    let Err(AnalysisError::UnknownTable { known, .. }) = of("plane") else {
        panic!("two arguments")
    };
    assert_eq!(known, ["motor", "smooth", "held", "push", "below"]);

    // It belongs to an actuator of its kind.
    let asked = |curve: MotorCurve| {
        let actuators = Actuators { curves: vec![curve], ..Actuators::default() };
        let turning = Motion::formula(&own, "A.angle", "10*t").expect("a motion");
        let times = Range { from: 0.0, to: 1.0, n: 3 };
        inverse(own.snapshot().to_model(), &[turning], &times, &actuators)
    };
    assert_eq!(asked(straight).expect("efforts").duties[0].outside().count(), 0);
    let Err(other) = asked(of("push").expect("a curve")) else { panic!("a force on a pin") };
    assert_eq!(other.to_string(), "the motor of `A` has N m over rad/s, and its table N over m/s");
    let unknown = MotorCurve::of_table(&own, "B", "motor").expect("a curve");
    let Err(AnalysisError::NoActuator { known, .. }) = asked(unknown) else { panic!("no joint B") };
    assert_eq!(known, ["A"]);
}

#[test]
fn a_motion_that_is_missing_is_asked_for_by_the_option_of_the_question() {
    let own = model(
        "[bodies.rod]\nmass = 1\ninertia = 1\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\n",
    );
    let times = Range { from: 0.0, to: 1.0, n: 3 };
    let refused = inverse(own, &[], &times, &Actuators::default()).expect_err("a free motion");
    assert_eq!(refused.to_string(), "1 motion is free, and 0 motions are prescribed");
    let help = refused.diagnostics()[0].help.clone().unwrap_or_default();
    assert!(help.contains("add `--motion A.angle=0`"), "{help}");
}

#[test]
fn motions_of_one_joint_have_efforts_of_their_own() {
    // A quill that slides and turns about a vertical axis.
    let quill = model(
        "[bodies.quill]\nmass = 2\ninertia = [0.1, 0.1, 0.05]\n\
         [joints.C]\ntype = \"cylindrical\"\nbetween = [\"ground\", \"quill\"]\naxis = [0, 0, 1]\n\
         [loads.weight]\ntype = \"gravity\"\nacceleration = [0, 0, -10]\n",
    );
    let motion = |name: &str, law: &str| Motion::formula(&quill, name, law).expect("a motion");
    let motions = [motion("C.position", "0.1*t^2"), motion("C.angle", "3*t^2")];
    let times = Range { from: 0.0, to: 1.0, n: 3 };
    let found = inverse(quill.snapshot().to_model(), &motions, &times, &Actuators::default());
    let found = found.expect("efforts");
    let names: Vec<&String> = found.table.columns.iter().map(|column| &column.name).collect();
    assert!(names.iter().enumerate().all(|(k, name)| !names[..k].contains(name)), "{names:?}");
    // m (g + 0.2 m/s²) and I 6 rad/s².
    for (name, effort) in [("C.position.effort", 20.4), ("C.angle.effort", 0.3)] {
        let column = found.table.column(name).unwrap_or_else(|| panic!("no {name}"));
        assert!(column.iter().all(|value| (value - effort).abs() < 1e-9), "{name}: {column:?}");
    }
}
