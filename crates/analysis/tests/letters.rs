//! Linear forms in letters, against numbers of the other way.

mod support;

use bksim_analysis::{Channels, letters};
use support::{Problem, model};

fn one(name: &str) -> Channels {
    Channels { inputs: vec![name.to_owned()], ..Channels::default() }
}

/// A pendulum with a damper: A = [0, 1; −m g l/(J + m l²), −d/(J + m l²)].
#[test]
fn a_pendulum_has_the_letters_of_the_textbook() {
    let pendulum = model(
        "[parameters]\nm = 2\nl = 0.5\nJ = 0.1\nd = 0.3\ng = 9.81\nu = 0\n\
         [bodies.rod]\nmass = \"m\"\ninertia = \"J\"\ncom = [\"l\", 0]\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\ncoordinate = \"phi\"\n\
         [loads]\nweight = { type = \"gravity\", acceleration = [\"g\", 0] }\n\
         motor = { type = \"torque\", joint = \"A\", value = \"u - d*A.rate\" }\n",
    );
    let found = letters(pendulum, &one("u")).expect("a form").expect("a small one");
    assert_eq!(found.a[0], ["0", "1"]);
    // cos phi is a letter: the pose is one of many in which the same form holds.
    let pool = bksim_expr::Pool::new();
    let same = |found: &str, expected: &str| {
        let [a, b] = [found, expected].map(|text| pool.parse(text).expect("an expression"));
        assert!(pool.certificate(a, b).is_equal(), "{found} instead of {expected}");
    };
    same(&found.a[1][0], "-m*g*l*cos(phi)/(J + m*l^2)");
    same(&found.a[1][1], "-d/(J + m*l^2)");
    same(&found.b[1][0], "1/(J + m*l^2)");
    assert!(found.largest_difference < 1e-12, "{}", found.largest_difference);
    assert_eq!(found.pose[0], ("phi".to_owned(), 0.0));
}

#[test]
fn a_four_bar_with_a_loop_agrees_with_numbers_at_random_points() {
    let problem = Problem::load("lti-four-bar");
    let found =
        letters(problem.model(), &one("crank.angle")).expect("a form").expect("a small one");
    assert_eq!(found.states.len(), 2);
    assert!(found.largest_difference < 1e-9, "{}", found.largest_difference);
    // Multipliers are letters: their forces turn with the mechanism.
    assert!(found.pose.len() > 3, "{:?}", found.pose);
}
