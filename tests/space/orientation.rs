//! Starts of bodies that turn about all axes: orientation and spin, stated in each way, and their faults.

use crate::support::{Measures, Within, at, close, derive, model, solve};
use bksim::model::Space;
use bksim::model::file::{Source, read};
use bksim::sim::run::Sample;

const EXACT: Within = Within { relative: 1e-14, absolute: 1e-14 };

#[test]
fn an_orientation_is_stated_in_three_ways_and_a_spin_in_two() {
    let (s, c) = (0.3_f64.sin(), 0.3_f64.cos());
    let spin = [c * 2.0, s * 2.0, 0.5];
    let starts = [
        "rpy = [0, 0, 0.3], w = [2, 0, 0.5], frame = \"body\"".to_owned(),
        format!("quaternion = [{:?}, 0, 0, {:?}], w = {spin:?}", 0.15_f64.cos(), 0.15_f64.sin()),
        format!(
            "axes = {{ x = [{c:?}, {s:?}, 0], z = [0, 0, 1] }}, w = {spin:?}, frame = \"world\""
        ),
    ];
    for coordinates in ["", "coordinates = [\"a\", \"b\", \"c\", \"d\", \"e\", \"f\"]\n"] {
        for start in &starts {
            let text = format!(
                "space = \"spatial\"\n[bodies.rod]\nmass = 1\ninertia = [1, 2, 3]\nfree = true\n\
                 {coordinates}[initial]\nrod = {{ {start} }}\n"
            );
            let mechanism = derive(model(&text));
            let start = mechanism.start().expect("a start");
            let names = ["rod.yaw", "rod.pitch", "rod.cxx", "rod.e3", "rod.wx", "rod.wy_body"];
            let measures = Measures::new(&mechanism, &names);
            let sample = Sample {
                q: start.q.clone(),
                v: start.v.clone(),
                ..solve(&mechanism).samples[0].clone()
            };
            let expected = [0.3, 0.0, c, 0.15_f64.sin(), spin[0], 0.0];
            for ((name, found), expected) in names.iter().zip(measures.at(&sample)).zip(expected) {
                close(name, found, expected, Within { relative: 1e-12, absolute: 1e-12 });
            }
        }
    }
}

/// A pendulum on a ball joint.
fn pendulum(keys: &str, start: &str) -> String {
    format!(
        "space = \"spatial\"\n\
         [bodies.bob]\nmass = 1\ninertia = [0.02, 0.03, 0.04]\ncom = [0, 0, -0.5]\n\
         [joints.ball]\ntype = \"spherical\"\nbetween = [\"ground\", \"bob\"]\n{keys}\n\
         [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
         [initial]\n{start}\n\
         [solve]\nt_end = 1\nevery = 0.5\nrtol = 1e-10\natol = 1e-11\n"
    )
}

#[test]
fn angles_of_a_ball_joint_are_stated_as_before() {
    let start =
        "ball = { angle1 = 0.4, angle2 = -0.9, angle3 = 2.5, rate1 = 1, rate2 = 0, rate3 = -2 }";
    let [quaternion, angles] = ["", "coordinate = [\"a\", \"b\", \"c\"]"].map(|keys| {
        let mechanism = derive(model(&pendulum(keys, start)));
        let motion = solve(&mechanism);
        let names = ["ball.angle1", "ball.angle2", "ball.angle3", "ball.rate1", "bob.x", "bob.wy"];
        let measures = Measures::new(&mechanism, &names);
        [measures.at(&motion.samples[0]), measures.at(at(&motion, 0.5))]
    });
    for (a, b) in quaternion.concat().iter().zip(&angles.concat()) {
        close("by quaternion and by angles", *a, *b, Within { relative: 1e-7, absolute: 1e-7 });
    }
}

/// A body on a hinge about z.
fn hinged(start: &str) -> String {
    format!(
        "space = \"spatial\"\n[bodies.crank]\nmass = 1\ninertia = [1, 1, 1]\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\n\
         [initial]\ncrank = {{ {start} }}\n"
    )
}

#[test]
fn an_orientation_that_a_joint_does_not_allow_is_named_as_one() {
    let faults = |start: &str| {
        let rejected = derive(model(&hinged(start))).start().expect_err("it does not close");
        crate::support::messages(&rejected.0)
    };
    let turned = faults("rpy = [\"30 deg\", 0, \"20 deg\"]");
    assert_eq!(turned, "[S002] the stated orientation of `crank` cannot be reached");
    let both = faults("rpy = [0, 0, \"20 deg\"], angle = \"30 deg\"");
    assert!(
        both.contains("`crank` and `crank.angle`") || both.contains("`crank.angle` and `crank`"),
        "{both}"
    );
    let spin = faults("w = [1, 0, 2]");
    assert!(spin.contains("`crank.wx`"), "{spin}");
    let start = derive(model(&hinged("rpy = [0, 0, \"20 deg\"], w = [0, 0, 2]"))).start();
    let start = start.expect("about z it turns");
    close("the angle", start.q[0], 20.0_f64.to_radians(), EXACT);
    close("its rate", start.v[0], 2.0, EXACT);
}

#[test]
fn faults_of_an_orientation_say_what_to_write_instead() {
    let cases = [
        ("quaternion = [1, 0.1, 0, 0]", "M070", "has the length 1.00499, not 1"),
        ("quaternion = [1, 0, 0]", "M007", ""),
        ("axes = { x = [1, 0, 0], z = [1, 0, 1] }", "M070", "45 deg apart, not 90"),
        ("axes = { x = [1, 0, 0], y = [0, 1, 0], z = [0, 0, -1] }", "M070", "3 axes"),
        ("rpy = [0, 0, 0], quaternion = [1, 0, 0, 0]", "M055", "both `rpy` and `quaternion`"),
        ("frame = \"body\"", "M006", "`frame` without `w`"),
        ("w = [0, 0, 1], frame = \"rod\"", "", "frame"),
    ];
    for (start, code, words) in cases {
        let text = hinged(start);
        let faults = read(&Source::new(&text, "test")).diagnostics;
        let told = crate::support::messages(&faults);
        assert!(faults.iter().any(|fault| fault.is_error() && fault.help.is_some()), "{told}");
        assert!(code.is_empty() || faults.iter().any(|f| f.code.0 == code), "{start}: {told}");
        assert!(told.contains(words), "{start}: {told}");
    }
}

#[test]
fn names_of_a_free_bodys_angles_can_be_stated_and_used() {
    let text = "space = \"spatial\"\n[bodies.rod]\nmass = 1\ninertia = [1, 2, 3]\nfree = true\n\
        coordinates = [\"x\", \"y\", \"z\", \"a\", \"b\", \"c\"]\n\
        [loads.brake]\ntype = \"torque\"\non = \"rod\"\nvector = [\"-0.5 N m s*a_dot\", 0, 0]\n\
        [initial]\nz = 0.7\na = 0.3\nb = { guess = -0.4 }\na_dot = 2\n\
        [solve]\nt_end = 1\nevery = 0.1\nrtol = 1e-10\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let first = &motion.samples[0];
    for (idx, expected) in [(2, 0.7), (3, 0.3), (4, -0.4)] {
        close("a coordinate", first.q[idx], expected, EXACT);
    }
    close("a rate", first.v[3], 2.0, EXACT);
    let last = motion.samples.last().expect("an end");
    assert!(last.energy.kinetic < 0.9 * first.energy.kinetic, "the brake takes energy");
}

#[test]
fn a_body_in_the_plane_is_turned_about_z() {
    let text = "[bodies.rod]\nmass = 1\ninertia = 0.1\nfree = true\n\
                [initial]\nrod = { rpy = [0, 0, 0.3], w = [0, 0, 2] }\n";
    let mechanism = derive(model(text));
    assert_eq!(mechanism.model.space, Space::Planar);
    let start = mechanism.start().expect("a start");
    close("the angle", start.q[2], 0.3, EXACT);
    close("its rate", start.v[2], 2.0, EXACT);
}
