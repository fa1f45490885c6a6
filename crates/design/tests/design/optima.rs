//! Optima against closed forms.

use std::sync::atomic::{AtomicBool, Ordering};

use bksim_design::{EndOfStart, OptimizeWish, Optimized, Source, Watch, optimize};

pub(crate) fn solved(text: &str) -> Optimized {
    let source = Source { text: text.to_owned(), name: "model".to_owned(), ..Source::default() };
    let wish = OptimizeWish::of_model(text).expect("a question");
    optimize(&source, &wish, Watch::default()).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn value(found: &Optimized, name: &str) -> f64 {
    let of = |q: &&bksim_design::Optimum| q.name == name;
    found.quantities.iter().find(of).map_or(f64::NAN, |q| q.after)
}

#[track_caller]
pub(crate) fn is_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected.abs(), "{value} for {expected}");
}

/// An arm held by a spring over 30 to 150 degrees from the upward vertical: the moment that is left.
pub(crate) fn arm(question: &str) -> String {
    format!(
        r#"
[parameters]
mass = "4.5 kg"
k = "800 N/m"
L0 = "0.09 m"
[ground]
points = {{ H = [0, "0.25 m"] }}
[bodies.arm]
mass = "mass"
inertia = 0
com = ["0.42 m", 0]
points = {{ P = ["0.12 m", 0] }}
[joints.A]
type = "revolute"
between = ["ground", "arm"]
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[loads.spring]
type = "spring"
between = ["ground.H", "arm.P"]
stiffness = "k"
length = "L0"
[drives.motor]
joint = "A"
motion = "60 deg - 120 deg/s*t"
[outputs]
moment = "drives.motor"
[solve]
t_end = "1 s"
every = "0.2 ms"
[optimize]
{question}
"#
    )
}

const RMS: &str = r#"minimize = "rms(outputs.moment)"
vary = { k = ["100 N/m", "3 kN/m"] }"#;
const PEAK: &str = r#"minimize = "max(abs(outputs.moment))"
vary = { k = ["100 N/m", "3 kN/m"] }"#;

#[test]
fn a_spring_of_least_rms_balances_an_arm() {
    let found = solved(&arm(RMS));
    is_close(value(&found, "k"), 930.609421454451, 1e-6);
    is_close(found.after, 1.75922923355553, 1e-7);
    assert!(found.converged, "{found:?}");
    assert!(found.model.contains("k = \"0.930"), "the unit of the range stays: {}", found.model);
}

#[test]
fn a_spring_of_least_peak_has_two_equal_peaks() {
    let found = solved(&arm(PEAK));
    is_close(value(&found, "k"), 1001.81395207158, 1e-6);
    is_close(found.after, 2.80742278079187, 1e-7);
}

#[test]
fn a_spring_without_length_balances_everywhere() {
    let text = arm(RMS).replace("L0 = \"0.09 m\"", "L0 = 0");
    let found = solved(&text);
    is_close(value(&found, "k"), 618.03, 1e-8);
    assert!(found.after < 1e-6, "{}", found.after);
}

#[test]
fn a_condition_has_its_worth() {
    // The peak as a condition of the least stiffness.
    let question = r#"minimize = "k"
vary = { k = ["100 N/m", "3 kN/m"] }
subject_to = ["max(abs(outputs.moment)) <= 3.5 N*m"]"#;
    let found = solved(&arm(question));
    let condition = &found.conditions[0];
    assert!(condition.is_active, "{condition:?}");
    // Against the optimum with a bound that is a little larger.
    let more = solved(&arm(&question.replace("3.5", "3.51")));
    let slope = (more.after - found.after) / 0.01;
    is_close(condition.worth, slope, 2e-2);
}

#[test]
fn counterweights_take_the_shaking_force_of_a_four_bar_away() {
    let text = r#"
[parameters]
ux1 = "0 kg*m"
uy1 = "0 kg*m"
ux2 = "0 kg*m"
uy2 = "0 kg*m"
[ground]
points = { A = [0, 0], D = ["0.18 m", 0] }
[bodies.crank]
mass = "0.3 kg"
inertia = "1e-4 kg*m^2"
com = ["0.025 m + ux1/0.3 kg^-1", "0.004 m + uy1/0.3 kg^-1"]
points = { A = [0, 0], B = ["0.06 m", 0] }
[bodies.coupler]
mass = "0.5 kg"
inertia = "1e-3 kg*m^2"
com = ["0.07 m", "0.02 m"]
points = { B = [0, 0], C = ["0.16 m", 0] }
[bodies.rocker]
mass = "0.4 kg"
inertia = "1e-3 kg*m^2"
com = ["0.05 m + ux2/0.4 kg^-1", "-0.006 m + uy2/0.4 kg^-1"]
points = { D = [0, 0], C = ["0.11 m", 0] }
[joints]
A = { type = "revolute", between = ["ground.A", "crank.A"] }
B = { type = "revolute", between = ["crank.B", "coupler.B"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker.D"] }
[drives.motor]
joint = "A"
motion = "0.1 rad + 40 rad/s*t"
[initial]
D = { guess = { angle = "100 deg" } }
[solve]
t_end = "0.157 s"
every = "1 ms"
[optimize]
minimize = "rms(hypot(reactions.A.fx + reactions.D.fx, reactions.A.fy + reactions.D.fy))"
vary = { ux1 = ["-0.1 kg*m", "0.1 kg*m"], uy1 = ["-0.1 kg*m", "0.1 kg*m"], ux2 = ["-0.1 kg*m", "0.1 kg*m"], uy2 = ["-0.1 kg*m", "0.1 kg*m"] }
"#
    .replace("ux1/0.3 kg^-1", "ux1/(0.3 kg)")
    .replace("uy1/0.3 kg^-1", "uy1/(0.3 kg)")
    .replace("ux2/0.4 kg^-1", "ux2/(0.4 kg)")
    .replace("uy2/0.4 kg^-1", "uy2/(0.4 kg)");
    let found = solved(&text);
    for (name, exact) in
        [("ux1", -0.024375), ("uy1", 0.00255), ("ux2", -0.0440625), ("uy2", -0.004475)]
    {
        let value = value(&found, name);
        assert!((value - exact).abs() < 1e-7, "{name}: {value} for {exact}");
    }
    assert!(found.after < 1e-4 && found.before.is_some_and(|before| before > 40.0), "{found:?}");
}

#[test]
fn the_least_flywheel_keeps_a_press_within_its_fluctuation() {
    let text = r#"
[parameters]
J = "60 kg*m^2"
[bodies.shaft]
mass = "1 kg"
inertia = "J"
[joints.A]
type = "revolute"
between = ["ground", "shaft"]
[loads.torque]
type = "torque"
joint = "A"
value = "900 N m/(6*pi) - if(A.angle > 150 deg, if(A.angle < 180 deg, 900 N m*sin(pi*(A.angle - 150 deg)/(30 deg)), 0 N m), 0 N m)"
[initial]
A = { angle = "0 rad", rate = "12 rad/s" }
[solve]
t_end = "0.523 s"
every = "50 us"
[optimize]
minimize = "J"
vary = { J = ["10 kg*m^2", "200 kg*m^2"], "A.rate" = ["8 rad/s", "16 rad/s"] }
subject_to = [
  "max(A.rate) - min(A.rate) <= 0.04*12 rad/s",
  "0.5*(max(A.rate) + min(A.rate)) == 12 rad/s",
]
"#;
    let found = solved(text);
    is_close(value(&found, "J"), 47.8163664406686, 1e-5);
    assert!(found.conditions.iter().all(|c| c.is_active), "{found:?}");
}

#[test]
fn a_swing_is_met_over_positions_without_masses() {
    let text = r#"
[parameters]
a = "0.03 m"
[ground]
points = { A = [0, 0], D = ["0.18 m", 0] }
[bodies.crank]
points = { A = [0, 0], B = ["a", 0] }
[bodies.coupler]
points = { B = [0, 0], C = ["0.17 m", 0] }
[bodies.rocker]
points = { D = [0, 0], C = ["0.12 m", 0] }
[joints]
A = { type = "revolute", between = ["ground.A", "crank.A"] }
B = { type = "revolute", between = ["crank.B", "coupler.B"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker.D"] }
[initial]
A = { angle = "40 deg" }
D = { guess = { angle = "85 deg" } }
[optimize]
maximize = "a"
over = "A.angle=0:360 deg:2001"
vary = { a = ["10 mm", "65 mm"] }
subject_to = ["peak_to_peak(D.angle) <= 40 deg"]
"#;
    let found = solved(text);
    // The limits of the rocker: crank and coupler in line.
    let (a, b, c, d) = (value(&found, "a"), 0.17_f64, 0.12_f64, 0.18_f64);
    let at = |r: f64| ((c * c + d * d - r * r) / (2.0 * c * d)).acos();
    let swing = (at(b + a) - at(b - a)).to_degrees();
    assert!((swing - 40.0).abs() < 1e-4, "{swing}, {found:?}");
    assert!(found.conditions[0].worth > 0.0, "{found:?}");
}

#[test]
fn an_equilibrium_is_where_it_is_wanted_in_the_worst_case() {
    // k φ = m g l cos φ.
    let text = r#"
[parameters]
k = "10 N m/rad"
m = "2 kg"
[bodies.bob]
mass = "m"
inertia = 0
com = ["0.5 m", 0]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[loads.spring]
type = "torque"
joint = "A"
value = "-k*A.angle"
[initial]
A = { angle = "-20 deg" }
[optimize]
minimize = "k"
over = "static"
vary = { k = ["5 N m/rad", "60 N m/rad"] }
subject_to = ["A.angle >= -30 deg"]
cases = { light = { m = "1 kg" }, heavy = { m = "2 kg" } }
"#;
    let found = solved(text);
    let exact =
        2.0 * 9.81 * 0.5 * (std::f64::consts::PI / 6.0).cos() / (std::f64::consts::PI / 6.0);
    is_close(value(&found, "k"), exact, 1e-8);
    let active: Vec<bool> = found.conditions.iter().map(|c| c.is_active).collect();
    assert_eq!(active, [true, false], "heavy, then light: {:?}", found.conditions);
}

#[test]
fn conditions_that_exclude_each_other_are_named() {
    let question = r#"minimize = "k"
vary = { k = ["100 N/m", "3 kN/m"] }
subject_to = ["max(abs(outputs.moment)) <= 1 N m"]"#;
    let text = arm(question);
    let source = Source { text: text.clone(), name: "model".to_owned(), ..Source::default() };
    let wish = OptimizeWish::of_model(&text).expect("a question");
    let error = optimize(&source, &wish, Watch::default()).expect_err("a fault");
    let fault = &error.diagnostics()[0];
    assert_eq!(fault.code.0, "O008");
    assert!(fault.message.contains("<= 1 N m") && fault.message.contains("1.8"), "{fault:?}");
}

#[test]
fn the_best_row_of_a_catalogue_is_chosen() {
    // With a free length of zero, m g l = k h r balances the arm everywhere: k = 618 N/m.
    let question = r#"minimize = "rms(outputs.moment)"
over = "motion"
[optimize.choose.spring]
soft = { k = "500 N/m", L0 = "0 m" }
right = { k = "618.03 N/m", L0 = "0 m" }
stiff = { k = "700 N/m", L0 = "0 m" }
[optimize.choose.load]
light = { mass = "4.5 kg" }
heavy = { mass = "5.5 kg" }"#;
    let found = solved(&arm(question));
    assert_eq!(found.choices.len(), 6);
    assert_eq!(found.choices[0].rows["spring"], "right");
    assert_eq!(found.choices[0].rows["load"], "light");
    assert!(found.after < 1e-3 && found.choices[1].after > Some(found.after), "{}", found.after);
    assert!(found.model.contains("k = \"618.03 N/m\"") && found.quantities.is_empty());
    // What varies is best for each row.
    let found = solved(&arm(&format!("{question}\n[optimize.vary]\nmass = [\"3 kg\", \"7 kg\"]")));
    let masses: Vec<f64> = found.choices.iter().filter_map(|choice| choice.after).collect();
    assert!(masses.iter().all(|residual| *residual < 1e-6), "{masses:?}");
}

#[test]
fn a_search_that_is_stopped_has_the_best_so_far_and_is_resumed_from_there() {
    let text = arm(RMS).replace("0.2 ms", "5 ms").replace("vary = {", "starts = 4\nvary = {");
    let whole = solved(&text);
    let source = Source { text: text.clone(), name: "model".to_owned(), ..Source::default() };
    let wish = OptimizeWish::of_model(&text).expect("a question");
    for at in ["start 1, iteration 0", "start 1, iteration 2", "start 3, iteration 1"] {
        let is_stopped = AtomicBool::new(false);
        let watch = Watch {
            stop: &|| is_stopped.load(Ordering::Relaxed),
            reached: &|words, _| is_stopped.store(words.starts_with(at), Ordering::Relaxed),
            ..Watch::default()
        };
        let stopped = optimize(&source, &wish, watch).unwrap_or_else(|error| panic!("{error}"));
        let [before, after] = [stopped.before.expect("a value"), stopped.after];
        assert!(stopped.stopped && after <= before, "{at}: {after} from {before}");
        assert!(stopped.evaluations < whole.evaluations, "{} evaluations", stopped.evaluations);

        // On from there: the whole answer, with fewer evaluations.
        let quantities = |end: &EndOfStart| {
            let one = |(name, value): (&String, &f64)| (name.clone(), value.to_string());
            end.quantities.iter().map(one).collect()
        };
        let from = stopped.ends.iter().map(quantities).collect();
        let wish = OptimizeWish { from, starts: Some(0), ..wish.clone() };
        let on = optimize(&source, &wish, Watch::default()).unwrap_or_else(|e| panic!("{e}"));
        is_close(on.after, whole.after, 1e-9);
        assert_eq!(on.starts, whole.starts, "as many starts are followed");
    }
}

#[test]
fn a_point_to_begin_from_varies() {
    let text = arm(RMS).replace("vary = {", "from = [{ mass = \"1 kg\" }]\nvary = {");
    let wish = OptimizeWish::of_model(&text).expect("a question");
    let source = Source { text, name: "model".to_owned(), ..Source::default() };
    let error = optimize(&source, &wish, Watch::default()).expect_err("a fault");
    assert!(error.to_string().contains("`mass`, which does not vary"), "{error}");
}

#[test]
fn ranges_of_the_model_are_what_varies() {
    let goal = "minimize = \"rms(outputs.moment)\"\n";
    let of = |question: &str| OptimizeWish::of_model(&arm(question));
    let own =
        of(&format!("{goal}vary = {{ k = [\"100 N/m\", \"3000 N/m\"] }}\n")).expect("a question");
    let ranges = "[ranges]\nk = [\"100 N/m\", \"3000 N/m\"]\nA.angle = [0, \"90 deg\"]\n";
    let named = of(&format!("{goal}vary = [\"k\"]\n{ranges}")).expect("a question");
    assert_eq!(named.vary, own.vary);
    let all = of(&format!("{goal}{ranges}")).expect("a question");
    let names: Vec<&str> = all.vary.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["A.angle", "k"]);
    let fault = of(&format!("{goal}vary = [\"L0\"]\n{ranges}")).expect_err("no range");
    assert!(fault.to_string().contains("no range of"), "{fault}");
}

#[test]
fn the_best_transmission_of_a_wiper_is_where_two_poses_are_alike() {
    let text = r#"
[parameters]
a = "60 mm"
b = "300 mm"
c = "100 mm"
[ground]
points = { A = [0, 0], D = ["300 mm", 0] }
[bodies.crank]
points = { A = [0, 0], B = ["a", 0] }
[bodies.coupler]
points = { B = [0, 0], C = ["b", 0] }
[bodies.rocker]
points = { D = [0, 0], C = ["c", 0] }
[joints]
A = { type = "revolute", between = ["ground.A", "crank.A"] }
B = { type = "revolute", between = ["crank.B", "coupler.B"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker.D"] }
[initial]
A = { angle = "40 deg" }
D = { guess = { angle = "85 deg" } }
[optimize]
maximize = "min(abs(sin(rocker.angle - coupler.angle)))"
over = "A.angle=0:360 deg:361"
vary = { a = ["20 mm", "100 mm"], b = ["150 mm", "400 mm"], c = ["60 mm", "200 mm"] }
subject_to = ["max(state.D_angle) - min(state.D_angle) == 90 deg"]
"#;
    let found = solved(text);
    assert!(found.converged, "{found:?}");
    // Crank over rocker is sin 45°, d² + a² = b² + c²: the transmission is alike in both poses with the crank along the ground.
    let (c, d) = (0.06_f64, 0.3_f64);
    let a = c * 0.5_f64.sqrt();
    let b = (d * d + a * a - c * c).sqrt();
    let cosine = (b * b + c * c - (d - a).powi(2)) / (2.0 * b * c);
    for (name, expected) in [("a", a), ("b", b), ("c", c)] {
        is_close(value(&found, name), expected, 1e-4);
    }
    is_close(found.after, (1.0 - cosine * cosine).sqrt(), 1e-5);
}

#[test]
fn peaks_at_different_times_are_alike_where_the_largest_is_least() {
    // Of x = p sin t + q sin 3t over half a turn, with p = 1 and q free, the peak is least at q = 1/6: √3/2.
    let text = r#"
[parameters]
q = "0.05 m"
[bodies.block]
mass = "1 kg"
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[drives.motor]
joint = "guide"
motion = "1 m*sin(t*(1 rad/s)) + q*sin(3*t*(1 rad/s))"
[solve]
t_end = "3.141592653589793 s"
every = "1 ms"
[optimize]
minimize = "max(block.x)"
vary = { q = ["0 m", "0.5 m"] }
"#;
    let found = solved(text);
    is_close(value(&found, "q"), 1.0 / 6.0, 2e-4);
    is_close(found.after, 0.75_f64.sqrt(), 1e-6);
}

/// A tool against a force that ends where it has come to p = 0.4 + 0.1 s: its peak f(s) = 100 p (1 + 4 (s − 0.6)²) is just
/// before that event, between samples.
#[test]
fn a_least_peak_at_a_load_that_jumps() {
    let found = solved(
        r#"
[parameters]
s = 0.5
p = "0.4 + 0.1*s"
[bodies.b]
mass = 1
[joints.S]
type = "prismatic"
between = ["ground", "b"]
axis = [1, 0]
[drives.go]
joint = "S"
motion = "1 m/s*t"
[loads.f]
type = "force"
on = "b"
vector = ["-if(S.position < p, 100*S.position*(1 + 4*(s - 0.6)^2), 0)", 0]
[outputs]
effort = "drives.go"
[solve]
t_end = 1
every = 0.07
[optimize]
minimize = "max(abs(outputs.effort))"
vary = { s = [0.3, 0.9] }
"#,
    );
    // f′ = 0 at u = s − 0.6.
    let u = (-368.0 + f64::sqrt(368.0 * 368.0 - 4800.0)) / 240.0;
    is_close(value(&found, "s"), 0.6 + u, 1e-5);
    is_close(found.after, (46.0 + 10.0 * u) * (1.0 + 4.0 * u * u), 1e-7);
    assert!(found.converged, "{found:?}");
}

/// A start outside of its range is evaluated where the model states it, and the search begins at the nearest end.
#[test]
fn a_start_outside_of_its_range_has_its_own_value_and_a_warning() {
    let asked = |range: &str| {
        let question = format!("minimize = \"max(abs(outputs.moment))\"\nvary = {{ k = {range} }}");
        solved(&arm(&question))
    };
    let around = asked("[\"700 N/m\", \"900 N/m\"]");
    assert!(around.warnings.is_empty(), "{:?}", around.warnings);
    let beyond = asked("[\"850 N/m\", \"900 N/m\"]");
    let before = around.before.expect("a value");
    is_close(beyond.before.expect("a value"), before, 1e-9);
    let [warning] = beyond.warnings.as_slice() else { panic!("{:?}", beyond.warnings) };
    assert_eq!(warning.code.0, "M127");
    assert!(warning.message.contains("800 N/m"), "{}", warning.message);
    assert!((850.0..=900.0).contains(&value(&beyond, "k")));
}
