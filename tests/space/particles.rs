//! Masses without inertia, whose turning nothing asks for.

use crate::support::{Measures, Within, all_close, derive, model, solve};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// A ball on a rod without mass, by a link, a pin or a ball joint, in the plane and in space, with the tree from
/// either side: a pendulum of the length 1 m, as with an inertia that never matters.
#[test]
fn a_point_mass_hangs_on_a_rod() {
    let pendulum = |space: &str, inertia: &str, joint: &str, between: &str| {
        let spatial = space == "spatial";
        let gravity = if spatial { "[0, 0, \"-9.81 m/s^2\"]" } else { "[0, \"-9.81 m/s^2\"]" };
        let start = match (spatial, joint.contains("link")) {
            (true, true) => "ball = { x = 0.6, y = 0, guess = { z = -0.8 }, vx = 0, vy = 0.5 }",
            (true, false) => {
                "ball = { x = 0.6, y = 0, guess = { z = -0.8 }, vx = 0, vy = 0.5 }\nrod = { wx = 0 }"
            }
            _ => "ball = { x = 0.6, guess = { y = -0.8 }, vx = 0.4 }",
        };
        let (rod_inertia, at, pivot) = if spatial {
            ("[0.1, 0.1, 0.1]", "[0, 0, -1]", "spherical")
        } else {
            ("0.1", "[0, -1]", "revolute")
        };
        let rod = if joint.contains("link") {
            String::new()
        } else {
            format!(
                "[bodies.rod]\nmass = 0.5\ninertia = {rod_inertia}\npoints = {{ E = {at} }}\n\
                 [joints.O]\ntype = \"{pivot}\"\nbetween = [\"ground\", \"rod\"]\n"
            )
        };
        let text = format!(
            "space = \"{space}\"\n[bodies.ball]\nmass = 1\n{inertia}\nfree = true\n{rod}\
             [joints.P]\ntype = {joint}\nbetween = {between}\n\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = {gravity}\n\
             [initial]\n{start}\n[solve]\nt_end = 2\nevery = 0.25\nrtol = 1e-11\natol = 1e-12\n"
        );
        derive(model(&text))
    };
    let cases = [
        ("planar", "inertia = 0.3", "\"link\"\nlength = 1", "[\"ground\", \"ball\"]"),
        ("planar", "inertia = 0.3", "\"revolute\"", "[\"rod.E\", \"ball\"]"),
        ("planar", "inertia = 0.3", "\"revolute\"\ncut = true", "[\"ball\", \"rod.E\"]"),
        ("spatial", "inertia = [1, 1, 1]", "\"link\"\nlength = 1", "[\"ground\", \"ball\"]"),
        ("spatial", "inertia = [1, 1, 1]", "\"spherical\"", "[\"rod.E\", \"ball\"]"),
        ("spatial", "inertia = [1, 1, 1]", "\"spherical\"", "[\"ball\", \"rod.E\"]"),
        ("spatial", "inertia = [1, 1, 1]", "\"spherical\"\ncut = true", "[\"rod.E\", \"ball\"]"),
    ];
    for (space, inertia, joint, between) in cases {
        let mut body = pendulum(space, inertia, joint, between);
        // The body turns by itself.
        let particle = pendulum(space, "", joint, between);
        let n_turns = body.system.coordinates().len() - particle.system.coordinates().len();
        assert_eq!(n_turns, if space == "planar" { 1 } else { 4 }, "{joint} {between}");
        let names = ["ball.x", "ball.y", "ball.z", "ball.vx", "ball.vy", "ball.vz"];
        body.model.solve.rtol = 1e-11;
        let (expected, found) = (solve(&body), solve(&particle));
        let (of_body, of_particle) =
            (Measures::new(&body, &names), Measures::new(&particle, &names));
        for (a, b) in expected.samples.iter().zip(&found.samples) {
            all_close(joint, &of_particle.at(b), &of_body.at(a), within(2e-8));
        }
    }
}

/// A particle between two rods, and one that is thrown.
#[test]
fn particles_are_counted_by_their_positions() {
    let text = "[bodies.a]\nmass = 1\ninertia = 0.1\ncom = [0.5, 0]\npoints = { E = [1, 0] }\n\
         [bodies.b]\nmass = 1\ninertia = 0.1\ncom = [0.5, 0]\npoints = { S = [0, 0] }\n\
         [bodies.ball]\nmass = 2\n[bodies.stone]\nmass = 1\nfree = true\n\
         [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"a\"]\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"a.E\", \"ball\"]\n\
         [joints.B]\ntype = \"revolute\"\nbetween = [\"ball\", \"b.S\"]\n\
         [initial]\nstone = { x = 0, y = 0, vx = 3, vy = 4 }\nO = { angle = 0, rate = 1 }\nb = { angle = 0, rate = 0 }\n\
         [solve]\nt_end = 1\nevery = 0.5\n";
    let mechanism = derive(model(text));
    assert_eq!(mechanism.system.coordinates().len(), 4, "two angles, and the stone's x and y");
    let motion = solve(&mechanism);
    let stone = Measures::new(&mechanism, &["stone.x", "stone.y"]);
    let last = motion.samples.last().expect("samples");
    all_close("thrown", &stone.at(last), &[3.0, 4.0], within(1e-9));
}

/// Where something turns it, or asks for its angle, the inertia is missing.
#[test]
fn a_mass_that_is_turned_needs_inertia() {
    let asks = [
        "[loads.M]\ntype = \"torque\"\non = \"ball\"\nvalue = 1\n",
        "[loads.F]\ntype = \"force\"\non = \"ball.P\"\nvector = [1, 0]\n",
        "[initial]\nball = { angle = 0 }\n",
        "[states.e]\nrate = \"ball.rate\"\nstart = 0\n",
        "[joints.P]\ntype = \"link\"\nbetween = [\"ground\", \"ball.P\"]\nlength = 1\n",
    ];
    for ask in asks {
        let text =
            format!("[bodies.ball]\nmass = 1\nfree = true\npoints = {{ P = [0.1, 0] }}\n{ask}");
        let mechanism = derive(model(&text));
        assert_eq!(
            mechanism.system.coordinates().iter().filter(|c| c.name == "ball_angle").count(),
            1,
            "{ask}"
        );
    }
}
