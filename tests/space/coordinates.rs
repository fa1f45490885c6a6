//! The choice of coordinates changes the equations, not the mechanism: same motion, same reactions.

use crate::support::{
    Probe, Within, all_close, derive, example, example_text, model, reaction, solve,
};
use bksim::mbs::tree::Tree;
use bksim::model::{CoordinatePolicy, Model};
use bksim::sim::mobility::mobility;
use bksim::{Mechanism, Motion};

/// A mechanism in three sets of coordinates. The angles of the bodies are what all of them share.
struct Mechanisms {
    example: &'static str,
    t_end: f64,
    /// Angles and slides that fix the positions of all bodies, in relative coordinates.
    relative: &'static [&'static str],
    /// Mechanisms in absolute coordinates.
    absolute: &'static [&'static str],
    /// Joints cut by hand and the same quantities once more.
    cut: &'static [&'static str],
    hand_cut: &'static [&'static str],
}

const TABLE: [Mechanisms; 3] = [
    Mechanisms {
        example: "slider-crank",
        t_end: 2.0,
        relative: &["theta1", "theta1 + B_angle", "x3"],
        absolute: &["crank_angle", "theta2", "slider_x"],
        cut: &["B", "C"],
        hand_cut: &["theta1", "theta2", "x3"],
    },
    Mechanisms {
        example: "four-bar",
        t_end: 1.0,
        relative: &["A_angle", "A_angle + B_angle", "D_angle"],
        absolute: &["crank_angle", "coupler_angle", "rocker_angle"],
        cut: &["B"],
        hand_cut: &["A_angle", "D_angle - C_angle", "D_angle"],
    },
    Mechanisms {
        example: "quick-return",
        t_end: 1.0,
        relative: &["C_angle", "O_angle", "O_angle + T_angle", "guide_position"],
        absolute: &["crank_angle", "link_angle", "rod_angle", "ram_x"],
        cut: &["T"],
        hand_cut: &["C_angle", "O_angle", "-R_angle", "guide_position"],
    },
];

/// Joints to cut besides, so that the relative tree is known.
fn prepared(mechanisms: &Mechanisms, policy: CoordinatePolicy, cut: &[&str]) -> Mechanism {
    let mut model = example(mechanisms.example);
    model.coordinates = policy;
    for joint in &mut model.joints {
        joint.cut = cut.contains(&joint.name.as_str()).then_some(true);
    }
    tighten(&mut model, mechanisms.t_end);
    derive(model)
}

fn tighten(model: &mut Model, t_end: f64) {
    model.solve.rtol = 1e-11;
    model.solve.atol = 1e-12;
    model.solve.t_end = t_end;
    model.solve.every = Some(t_end / 10.0);
}

/// Asserts the same positions, rates, accelerations, energies and reactions at every output time.
fn same_motion(what: &str, one: &Solved, other: &Solved, within: Within) {
    assert_eq!(one.motion.samples.len(), other.motion.samples.len(), "{what}: samples");
    for (a, b) in one.motion.samples.iter().zip(&other.motion.samples) {
        let what = format!("{what}, t = {:.3}", a.t);
        let (found, expected) = (other.probe.at(b), one.probe.at(a));
        for (name, (found, expected)) in
            ["positions", "rates", "accelerations"].iter().zip(found.iter().zip(&expected))
        {
            all_close(&format!("{what}: {name}"), found, expected, within);
        }
        for joint in &one.mechanism.compiled.joints {
            let [found, expected] =
                [(other, b), (one, a)].map(|(s, sample)| reaction(&s.mechanism, sample, joint));
            // A force of some newtons among larger ones has the digits of the larger ones.
            let scale = a.reactions.iter().flatten().fold(1.0, |m: f64, x| m.max(x.abs()));
            let [found, expected] = [found, expected].map(|six| six.map(|x| x / scale));
            all_close(&format!("{what}: reaction of `{joint}`"), &found, &expected, within);
        }
    }
}

struct Solved {
    mechanism: Mechanism,
    motion: Motion,
    probe: Probe,
}

impl Solved {
    fn new(mechanism: Mechanism, measures: &[&str]) -> Self {
        let motion = solve(&mechanism);
        let probe = Probe::new(&mechanism, measures);
        Self { mechanism, motion, probe }
    }
}

#[test]
fn relative_absolute_and_hand_cut_coordinates_move_alike() {
    for row in &TABLE {
        let relative = prepared(row, CoordinatePolicy::Relative, &[]);
        let relative = Solved::new(relative, row.relative);
        let absolute = prepared(row, CoordinatePolicy::Absolute, &[]);
        let absolute = Solved::new(absolute, row.absolute);
        let hand_cut = prepared(row, CoordinatePolicy::Relative, row.cut);
        let hand_cut = Solved::new(hand_cut, row.hand_cut);
        let counts = [&relative, &hand_cut, &absolute].map(|s| s.mechanism.compiled.nq());
        assert!(counts.windows(2).all(|w| w[0] <= w[1]), "{}: {counts:?}", row.example);

        let within = Within { relative: 1e-8, absolute: 1e-8 };
        same_motion(&format!("{} absolute", row.example), &relative, &absolute, within);
        same_motion(&format!("{} hand-cut", row.example), &relative, &hand_cut, within);
    }
}

#[test]
fn the_reference_point_of_the_inertia_does_not_matter() {
    // The crank of the four-bar: about its centre of mass, or about its pin by Steiner's rule.
    let text = example_text("four-bar");
    let about_pin = text.replace(
        "inertia = \"0.5 kg*a^2/12\"",
        "inertia = { value = \"0.5 kg*a^2/3\", about = \"A\" }",
    );
    assert_ne!(text, about_pin);
    let solved = |text: &str| {
        let mut model = model(text);
        tighten(&mut model, 0.5);
        Solved::new(derive(model), &["A_angle", "A_angle + B_angle", "D_angle"])
    };
    let within = Within { relative: 1e-12, absolute: 1e-12 };
    same_motion("inertia about the pin", &solved(&text), &solved(&about_pin), within);
}

#[test]
fn the_body_frame_does_not_matter() {
    // The coupler's frame moved by (0.1, 0.2) m: every place in it shifts, nothing else changes.
    let text = example_text("four-bar");
    let moved = text.replace("com = [\"b/2\", 0]", "com = [\"b/2 - 0.1 m\", \"-0.2 m\"]").replace(
        "points = { B = [0, 0], C = [\"b\", 0] }",
        "points = { B = [\"-0.1 m\", \"-0.2 m\"], C = [\"b - 0.1 m\", \"-0.2 m\"] }",
    );
    assert_ne!(text, moved);
    let solved = |text: &str| {
        let mut model = model(text);
        tighten(&mut model, 0.5);
        Solved::new(derive(model), &["A_angle", "A_angle + B_angle", "D_angle"])
    };
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    same_motion("moved frame", &solved(&text), &solved(&moved), within);
}

/// A four-bar that swings under gravity, in the plane.
const SWINGING: &str = include_str!("../fixtures/swinging-four-bar.toml");

/// Model with three equal moments of inertia each, so that it is a spatial one.
fn spatial(text: &str) -> String {
    let mut text = text.to_owned();
    for value in ["0.002", "0.006", "0.004"] {
        let one = format!("\"{value} kg m^2\"");
        text =
            text.replace(&format!("inertia = {one}"), &format!("inertia = [{one}, {one}, {one}]"));
    }
    format!("space = \"spatial\"\n{text}")
}

fn swinging(text: &str, policy: CoordinatePolicy, measures: &[&str]) -> Solved {
    let mut model = model(text);
    model.coordinates = policy;
    tighten(&mut model, 1.0);
    Solved::new(derive(model), measures)
}

#[test]
fn a_plane_four_bar_in_space_is_overconstrained_by_three_and_moves_as_in_the_plane() {
    let measures = ["A_angle", "A_angle + B_angle", "D_angle"];
    let plane = swinging(SWINGING, CoordinatePolicy::Relative, &measures);
    let within = Within { relative: 1e-9, absolute: 1e-9 };

    let space = swinging(&spatial(SWINGING), CoordinatePolicy::Relative, &measures);
    same_motion("relative in space", &plane, &space, within);

    // Every joint cut: 18 coordinates, with quaternions 21, 20 rows, 17 of them independent.
    let absolute = derive({
        let mut model = model(&spatial(SWINGING));
        model.coordinates = CoordinatePolicy::Absolute;
        tighten(&mut model, 1.0);
        model
    });
    let start = absolute.start().unwrap_or_else(|e| panic!("{e}"));
    let count = mobility(&absolute.model, &absolute.system, &start);
    let found =
        (count.gruebler, count.mobility, absolute.compiled.nq(), count.n_constraints, count.rank);
    assert_eq!(found, (-2, 1, 21, 20, 17), "{count:?}");
    assert_eq!(count.redundant.len(), 4, "{count:?}");
    // About z, e = (cos θ/2, 0, 0, sin θ/2).
    let angle = |body: &str| format!("2*atan2({body}_e3, {body}_e0)");
    let angles = ["crank", "coupler", "rocker"].map(angle);
    let absolute = Solved::new(absolute, &angles.each_ref().map(String::as_str));
    for (a, b) in plane.motion.samples.iter().zip(&absolute.motion.samples) {
        let (expected, found) = (plane.probe.at(a), absolute.probe.at(b));
        // Accelerations of some 10 rad/s² carry the errors of positions and rates on.
        for (k, tolerance) in [1e-9, 1e-9, 1e-8].into_iter().enumerate() {
            let within = Within { relative: tolerance, absolute: tolerance };
            let what = format!("absolute in space, t = {}, derivative {k}", a.t);
            all_close(&what, &found[k], &expected[k], within);
        }
        let energy =
            (a.energy.kinetic + a.energy.potential) - (b.energy.kinetic + b.energy.potential);
        assert!(energy.abs() < 1e-9, "energies differ by {energy:.1e} J at t = {}", a.t);
    }
}

/// `n` rods in a row that hang in space, on `joint`.
fn hanging(n: usize, joint: &str) -> String {
    let mut text = "space = \"spatial\"\n".to_owned();
    let mut before = "ground".to_owned();
    for i in 1..=n {
        let body = "mass = 1\ninertia = [0.09, 0.01, 0.09]\npoints = { A = [0, 0.5, 0], B = [0, -0.5, 0] }";
        let between = format!("between = [\"{before}\", \"b{i}.A\"]");
        text.extend([format!("[bodies.b{i}]\n{body}\n[joints.j{i}]\n{between}\n{joint}\n")]);
        before = format!("b{i}.B");
    }
    text
}

#[test]
fn balls_in_a_row_take_coordinates_of_bodies_before_hinges_do() {
    let (relative, absolute) = (CoordinatePolicy::Relative, CoordinatePolicy::Absolute);
    let (ball, hinge) = ("type = \"spherical\"", "type = \"revolute\"\naxis = [1, 0, 0]");
    let rows = [
        (1, ball, relative),
        (3, ball, relative),
        (4, ball, absolute),
        (60, hinge, relative),
        (400, hinge, absolute),
    ];
    for (n, joint, expected) in rows {
        let chosen = Tree::of(&model(&hanging(n, joint))).policy;
        assert_eq!(chosen, expected, "{n} on {joint}");
    }
}
