//! Linear forms in letters, against textbooks and against numbers of the other way.

use crate::support::{Problem, model};
use bksim_analysis::{About, Channels, Letters, letters, linearize};
use bksim_expr::Pool;
use bksim_model::Model;

fn channels(inputs: &[&str], outputs: &[&str]) -> Channels {
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    Channels { inputs: owned(inputs), outputs: owned(outputs), states: Vec::new() }
}

fn written(model: Model, channels: &Channels) -> Letters {
    let found = letters(model, channels).expect("a form").expect("a small one");
    assert!(found.largest_difference < 1e-9, "{}", found.largest_difference);
    found
}

/// Equal expressions, proved.
fn same(found: &str, expected: &str) {
    let pool = Pool::new();
    let [a, b] = [found, expected].map(|text| pool.parse(text).expect("an expression"));
    assert!(pool.certificate(a, b).is_equal(), "{found} instead of {expected}");
}

const PENDULUM: &str = "[parameters]\nm = 2\nl = 0.5\nJ = 0.1\nd = 0.3\ng = 9.81\nu = 0\n\
     [bodies.rod]\nmass = \"m\"\ninertia = \"J\"\ncom = [\"l\", 0]\n\
     [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\ncoordinate = \"phi\"\n\
     [loads]\nweight = { type = \"gravity\", acceleration = [\"g\", 0] }\n\
     motor = { type = \"torque\", joint = \"A\", value = \"u - d*A.rate\" }\n";

/// A pendulum with a damper: A = [0, 1; −m g l/(J + m l²), −d/(J + m l²)].
#[test]
fn a_pendulum_has_the_letters_of_the_textbook() {
    let found = written(model(PENDULUM), &channels(&["u"], &[]));
    assert_eq!(found.a[0], ["0", "1"]);
    // cos phi is a letter: the pose is one of many in which the same form holds.
    same(&found.a[1][0], "-m*g*l*cos(phi)/(J + m*l^2)");
    same(&found.a[1][1], "-d/(J + m*l^2)");
    same(&found.b[1][0], "1/(J + m*l^2)");
    assert_eq!(found.pose[0], ("phi".to_owned(), 0.0));
    assert!(found.c.is_empty() && found.d.is_empty());
}

#[test]
fn outputs_of_a_pendulum_have_the_letters_of_the_textbook() {
    let outputs = ["A.angle", "rod.x", "rod.vy", "A.acceleration", "reactions.A.fy"];
    let found = written(model(PENDULUM), &channels(&["u"], &outputs));
    let names: Vec<&str> = found.outputs.iter().map(|output| output.name.as_str()).collect();
    assert_eq!(names, outputs);
    assert_eq!(
        (found.c[0].clone(), found.d[0].clone()),
        (vec!["1".into(), "0".into()], vec!["0".to_owned()])
    );
    same(&found.c[1][0], "-l*sin(phi)");
    same(&found.c[2][1], "l*cos(phi)");
    // Of rates the change with the pose is zero at rest.
    assert_eq!((found.c[2][0].as_str(), found.c[1][1].as_str()), ("0", "0"));
    same(&found.c[3][0], &found.a[1][0]);
    same(&found.c[3][1], &found.a[1][1]);
    same(&found.d[3][0], &found.b[1][0]);
    // fy = m ÿ of the centre of mass, across to gravity: m l cos φ φ̈.
    same(&found.d[4][0], "m*l*cos(phi)/(J + m*l^2)");
    same(&found.c[4][1], "-d*m*l*cos(phi)/(J + m*l^2)");
}

/// The largest difference of C and D in letters, at the pose that they tell, from those in numbers.
fn off_from_numbers(make: &dyn Fn() -> Model, channels: &Channels) -> f64 {
    let found = written(make(), channels);
    let parameters = make().parameters;
    let linear = linearize(make(), About::Static, channels).expect("a linear system");
    let pool = Pool::new();
    let mut known = found.pose.clone();
    known.extend(parameters.into_iter().map(|p| (p.name, p.value)));
    let value_of = |text: &String, known: &[(String, f64)]| {
        let e = pool.parse(text).expect("an expression");
        let value = |symbol| {
            let name = pool.symbol_name(symbol);
            known.iter().find(|(letter, _)| *letter == name).map(|(_, x)| *x)
        };
        pool.evaluate(e, &value).expect("a value")
    };
    for (name, definition) in &found.blocks {
        known.push((name.clone(), value_of(definition, &known)));
    }
    let number = |text: &String| value_of(text, &known);
    let mut off = 0.0_f64;
    for (i, (c, d)) in found.c.iter().zip(&found.d).enumerate() {
        let size = linear.c.row(i).amax().max(linear.d.row(i).amax()).max(1e-3);
        let pairs = c.iter().enumerate().map(|(j, text)| (number(text), linear.c[(i, j)]));
        let others = d.iter().enumerate().map(|(j, text)| (number(text), linear.d[(i, j)]));
        for (found, expected) in pairs.chain(others) {
            off = off.max((found - expected).abs() / size);
        }
    }
    off
}

#[test]
fn a_four_bar_with_a_loop_agrees_with_numbers_at_random_points() {
    let problem = Problem::load("lti-four-bar");
    let asked = channels(&["crank.angle"], &["rocker.angle", "rocker.rate", "rocker.ay"]);
    let found = written(problem.model(), &asked);
    assert_eq!(found.states.len(), 2);
    // Multipliers are letters: their forces turn with the mechanism.
    assert!(found.pose.len() > 3, "{:?}", found.pose);
    let off = off_from_numbers(&|| problem.model(), &asked);
    assert!(off < 1e-9, "{off}");
}

#[test]
fn reactions_of_a_loop_agree_with_numbers_at_the_pose() {
    // A crank with a parameter for its torque, a rocker on a spring, closed by a coupler.
    let text = r#"
[parameters]
u = "2 N m"
k = "300 N m/rad"
[ground.points]
D = ["0.9 m", 0]
[bodies.crank]
mass = "2 kg"
inertia = "0.1 kg m^2"
com = ["0.2 m", 0]
[bodies.crank.points]
B = ["0.4 m", 0]
[bodies.coupler]
mass = "1 kg"
inertia = "0.1 kg m^2"
com = ["0.5 m", "0.1 m"]
[bodies.coupler.points]
C = ["1 m", 0]
[bodies.rocker]
mass = "1.5 kg"
inertia = "0.2 kg m^2"
com = ["0.3 m", 0]
[bodies.rocker.points]
C = ["0.7 m", 0]
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "coupler"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker"] }
[initial]
A = { angle = 1.0 }
D = { guess = { angle = 1.6 } }
[loads.weight]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[loads.spring]
type = "torsion"
joint = "A"
stiffness = "k"
angle = "1 rad"
damping = "3 N m s/rad"
[loads.motor]
type = "torque"
joint = "A"
value = "u"
"#;
    let asked = channels(
        &["u"],
        &["reactions.D.fx", "reactions.A.fy", "reactions.C.fx", "coupler.ax", "coupler.C.vy"],
    );
    let off = off_from_numbers(&|| model(text), &asked);
    assert!(off < 1e-9, "{off}");
}

/// Two loops: written out, the determinant of their rows spreads over thousands of terms.
#[test]
fn a_six_bar_has_names_for_what_is_long_and_agrees_with_numbers() {
    let text = include_str!("../../../../tests/fixtures/six-bar.toml");
    let asked = channels(&["A.angle"], &["D.angle", "G.acceleration", "reactions.D.fx"]);
    let found = written(model(text), &asked);
    let names: Vec<&str> = found.blocks.iter().map(|(name, _)| name.as_str()).collect();
    for name in ["G_1_t_B", "Z_t_B_t_A", "M_t_A_t_A", "K_t_A_1"] {
        assert!(names.contains(&name), "{name} is not among {names:?}");
    }
    let texts = found.blocks.iter().map(|(_, text)| text);
    let entries = [&found.a, &found.b, &found.c, &found.d].into_iter().flatten().flatten();
    let n_characters: usize = texts.chain(entries).map(String::len).sum();
    // Written out they have more than a million.
    assert!(n_characters < 60_000, "{n_characters} characters");
    let off = off_from_numbers(&|| model(text), &asked);
    assert!(off < 1e-9, "{off}");
}

#[test]
fn states_and_signals_are_outputs_in_letters() {
    let text = "[parameters]\nm = 2\nk = 50\ni = 20\nr = 0.3\n\
         [bodies.cart]\nmass = \"m\"\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\n\
         axis = [1, 0]\ncoordinate = \"x\"\n[states.z]\nrate = \"r - x\"\nstart = 0\n\
         [signals.u]\nvalue = \"k*(r - x) + i*z\"\n\
         [loads.control]\ntype = \"force\"\njoint = \"rail\"\nvalue = \"u - 8*rail.velocity\"\n";
    let found = written(model(text), &channels(&["r"], &["z", "signals.u"]));
    assert_eq!(found.c[0], ["0", "0", "1"]);
    same(&found.c[1][0], "-k");
    same(&found.c[1][2], "i");
    same(&found.d[1][0], "k");
}
