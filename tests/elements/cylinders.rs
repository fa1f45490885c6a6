//! Distances of two points: actuators, ropes, rods whose length changes; efforts and springs in motions of joints.

use crate::support::{Measures, Within, all_close, at, close, derive, model, reaction, solve};
use bksim::Motion;
use bksim::sim::run::Sample;

const G: f64 = 9.81;

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

fn total(sample: &Sample) -> f64 {
    sample.energy.kinetic + sample.energy.potential
}

/// An arm of 1 m about the origin with 5 kg at its end, and a cylinder from (0.8 m, −0.6 m) to its middle.
fn arm(rest: &str) -> String {
    format!(
        "[ground]\npoints = {{ B = [0.8, -0.6] }}\n\
         [bodies.arm]\nmass = \"5 kg\"\ncom = [1, 0]\ninertia = 0.2\npoints = {{ P = [0.5, 0] }}\n\
         [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\ncoordinate = \"phi\"\n\
         [joints.ram]\ntype = \"cylinder\"\nbetween = [\"ground.B\", \"arm.P\"]\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n{rest}\
         [solve]\nt_end = 2\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n"
    )
}

/// The law of cosines gives the angle of the arm for each length, and the balance of moments the force.
#[test]
fn a_driven_cylinder_lifts_an_arm() {
    let drive = "[drives.pump]\njoint = \"ram\"\nmotion = \"0.6 m + 0.1 m/s*t\"\n[initial]\narm = { guess = { angle = 0 } }\n";
    for method in ["auto", "radau"] {
        let text = format!("{}method = \"{method}\"\n", arm(drive));
        let mechanism = derive(model(&text));
        let names = ["arm.angle", "arm.rate", "ram.position", "ram.velocity"];
        let (motion, measures) = (solve(&mechanism), Measures::new(&mechanism, &names));
        let (base, lever) = (0.8_f64.hypot(0.6), 0.5);
        let below = (-0.6_f64).atan2(0.8);
        for sample in &motion.samples {
            let length = 0.6 + 0.1 * sample.t;
            let opening =
                ((base * base + lever * lever - length * length) / (2.0 * base * lever)).acos();
            let [angle, rate, position, velocity] = measures.at(sample)[..] else { panic!("four") };
            close("angle", angle, below + opening, within(1e-9));
            close("length", position, length, within(1e-10));
            close("speed", velocity, 0.1, within(1e-9));
            // dL/dφ = B M sin(opening)/L.
            let slope = base * lever * opening.sin() / length;
            close("rate", rate, 0.1 / slope, within(1e-8));

            // I φ″ = F dL/dφ − m g cos φ.
            let inertia = 0.2 + 5.0;
            let force = (inertia * sample.a[0] + 5.0 * G * angle.cos()) / slope;
            let [fx, fy, ..] = reaction(&mechanism, sample, "ram");
            let [dx, dy] = [0.5 * angle.cos() - 0.8, 0.5 * angle.sin() + 0.6];
            close("force", fx, force * dx / length, within(1e-6));
            close("force", fy, force * dy / length, within(1e-6));
        }
    }
}

/// A stated force along a cylinder, a spring and a damper in it are the loads between its points.
#[test]
fn loads_in_a_cylinder_are_loads_between_its_points() {
    let ends = "between = [\"ground.B\", \"arm.P\"]";
    let joint = "joint = \"ram\"";
    let loads = |where_: &str| {
        arm(&format!(
            "[loads.push]\ntype = \"force\"\n{where_}\nvalue = \"60 N - 20 N s/m*ram.velocity\"\n\
             [loads.spring]\ntype = \"spring\"\n{where_}\nstiffness = 300\nlength = 0.7\ndamping = 20\n\
             [loads.damper]\ntype = \"damper\"\n{where_}\ndamping = 5\n[initial]\nO = {{ angle = 0, rate = 0 }}\n"
        ))
    };
    let [between, along] = [loads(ends), loads(joint)].map(|text| derive(model(&text)));
    let (one, other) = (solve(&between), solve(&along));
    for (a, b) in one.samples.iter().zip(&other.samples) {
        close("angle", a.q[0], b.q[0], within(1e-9));
        close("energy", total(a), total(b), within(1e-8));
    }
    // The reaction of the cylinder is all that acts along it.
    let measures = Measures::new(&along, &["ram.position", "ram.velocity"]);
    for sample in &other.samples {
        let [length, speed] = measures.at(sample)[..] else { panic!("two") };
        let force = 60.0 - 20.0 * speed - 300.0 * (length - 0.7) - 25.0 * speed;
        let [fx, fy, ..] = reaction(&along, sample, "ram");
        let [dx, dy] = [0.5 * sample.q[0].cos() - 0.8, 0.5 * sample.q[0].sin() + 0.6];
        close("force", fx * dx / length + fy * dy / length, force, within(1e-7));
    }
}

/// A ball falls 0.5 m until its rope of 1 m is tight, and hangs on it from then on.
#[test]
fn a_rope_pulls_but_does_not_push() {
    let text = "[bodies.ball]\nmass = \"2 kg\"\ninertia = 0.01\nfree = true\n\
         [joints.rope]\ntype = \"distance\"\nbetween = [\"ground\", \"ball\"]\nmax = \"1 m\"\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
         [initial]\nball = { x = 0, y = -0.5, angle = 0, vx = 0, vy = 0, rate = 0 }\n\
         [solve]\nt_end = 1\nevery = 0.05\nrtol = 1e-10\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let tight = (2.0 * 0.5 / G).sqrt();
    for sample in &motion.samples {
        let y = if sample.t < tight { -0.5 - 0.5 * G * sample.t * sample.t } else { -1.0 };
        close("height", sample.q[1], y, within(1e-9));
        let pull = if sample.t < tight { 0.0 } else { 2.0 * G };
        close("pull", reaction(&mechanism, sample, "rope")[1], pull, within(1e-7));
    }
}

/// A pendulum whose rod changes its length obeys θ″ = −(2 L′ θ′ + g sin θ)/L.
#[test]
fn a_rod_changes_its_length() {
    let pendulum = |joint: &str| {
        format!(
            "[bodies.ball]\nmass = \"2 kg\"\ninertia = 0.01\nfree = true\n\
             [joints.rod]\ntype = \"{joint}\"\nbetween = [\"ground\", \"ball\"]\nlength = \"1 m + 0.2 m*sin(3 rad/s*t)\"\n\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
             [initial]\nball = {{ x = \"0.6 m\", guess = {{ y = -0.8 }}, angle = 0, vx = 0, rate = 0 }}\n\
             [solve]\nt_end = 3\nevery = 0.5\nrtol = 1e-12\natol = 1e-12\n"
        )
    };
    // Runge and Kutta's method on the angle.
    let slope = |t: f64, [theta, rate]: [f64; 2]| {
        let (length, speed) = (1.0 + 0.2 * (3.0 * t).sin(), 0.6 * (3.0 * t).cos());
        [rate, -(2.0 * speed * rate + G * theta.sin()) / length]
    };
    let step = |t: f64, y: [f64; 2], h: f64| {
        let plus = |k: [f64; 2], f: f64| [y[0] + f * k[0], y[1] + f * k[1]];
        let a = slope(t, y);
        let b = slope(t + h / 2.0, plus(a, h / 2.0));
        let c = slope(t + h / 2.0, plus(b, h / 2.0));
        let d = slope(t + h, plus(c, h));
        std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
    };
    // x = L sin θ, with x′ = 0: L′ sin θ + L cos θ θ′ = 0.
    let theta = 0.6_f64.asin();
    let start = [theta, -0.6 * theta.sin() / theta.cos()];
    for joint in ["distance", "link"] {
        let mechanism = derive(model(&pendulum(joint)));
        let motion = solve(&mechanism);
        let mut y = start;
        let n = 5000;
        for k in 0..6 {
            for i in 0..n {
                let h = 0.5 / f64::from(n);
                y = step(0.5 * f64::from(k) + h * f64::from(i), y, h);
            }
            let t = 0.5 * f64::from(k + 1);
            let sample = at(&motion, t);
            let length = 1.0 + 0.2 * (3.0 * t).sin();
            close("x", sample.q[0], length * y[0].sin(), within(1e-9));
            close("y", sample.q[1], -length * y[0].cos(), within(1e-9));
        }
        assert!(work_is_accounted_for(&motion), "the winch works on the pendulum");
    }
}

/// T + V changes by the work of what moves the rod.
fn work_is_accounted_for(motion: &Motion) -> bool {
    let (first, last) = (&motion.samples[0], &motion.samples[motion.samples.len() - 1]);
    let work = last.work - first.work;
    (total(last) - total(first) - work).abs() < 1e-7 && work.abs() > 1e-2
}

/// A motor about an axis in space turns a wheel about that axis; a spring in a prismatic joint swings a block along it.
#[test]
fn efforts_and_springs_act_in_motions_of_joints() {
    let text = "[bodies.wheel]\nmass = 1\ninertia = [0.4, 0.3, 0.2]\n\
         [joints.axle]\ntype = \"revolute\"\nbetween = [\"ground\", \"wheel\"]\naxis = [1, 0, 0]\n\
         [bodies.block]\nmass = \"2 kg\"\ninertia = [1, 1, 1]\n\
         [joints.rail]\ntype = \"cylindrical\"\nbetween = [\"ground\", \"block\"]\naxis = [0, 3, 4]\ncut = CUT\n\
         [loads.motor]\ntype = \"torque\"\njoint = \"axle\"\nvalue = \"2 N m\"\n\
         [loads.turning]\ntype = \"torque\"\njoint = \"rail\"\nvalue = \"0.5 N m\"\n\
         [loads.spring]\ntype = \"spring\"\njoint = \"rail\"\nstiffness = 200\nlength = \"-0.1 m\"\n\
         [initial]\naxle = { angle = 0, rate = 0 }\n\
         rail = { position = \"0.1 m\", velocity = 0, angle = 0, rate = 0 }\n\
         [solve]\nt_end = 1\nevery = 0.1\nrtol = 1e-11\natol = 1e-13\n";
    for cut in ["false", "true"] {
        let mechanism = derive(model(&text.replace("CUT", cut)));
        let names = ["axle.angle", "rail.position", "rail.angle"];
        let (motion, measures) = (solve(&mechanism), Measures::new(&mechanism, &names));
        for sample in &motion.samples {
            let t = sample.t;
            let [angle, position, turned] = measures.at(sample)[..] else { panic!("three") };
            close("angle of the wheel", angle, 2.0 / 0.4 * t * t / 2.0, within(1e-9));
            close("position of the block", position, -0.1 + 0.2 * (10.0 * t).cos(), within(1e-9));
            close("angle of the block", turned, 0.25 * t * t, within(1e-9));
        }
    }
}

/// A pin along z of the crank and along another direction of the rod: the same motion as with a frame at the rod's
/// point, whichever way the tree goes.
#[test]
fn an_axis_has_a_direction_in_each_body() {
    let arm = |points: &str, joint: &str, cut: &str| {
        let text = format!(
            "[bodies.crank]\nmass = 1\ninertia = [0.1, 0.2, 0.3]\ncom = [0.2, 0, 0]\npoints = {{ A = [0.4, 0, 0.1] }}\n\
             [bodies.rod]\nmass = 2\ninertia = [0.2, 0.1, 0.15]\ncom = [0, 0.1, 0.3]\npoints = {{ B = {points} }}\n\
             [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\naxis = [0, 1, 0]\n\
             [joints.A]\ntype = \"revolute\"\nbetween = [\"crank.A\", \"rod.B\"]\n{joint}\ncut = {cut}\n\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, 0, \"-9.81 m/s^2\"]\n\
             [initial]\nO = {{ angle = 0.3, rate = 1 }}\nA = {{ angle = 0.5, rate = -2 }}\n\
             [solve]\nt_end = 1\nevery = 0.25\nrtol = 1e-11\natol = 1e-12\n"
        );
        derive(model(&text))
    };
    let names = ["rod.x", "rod.y", "rod.z", "A.rate", "rod.cxx", "rod.cyz"];
    let frame = arm("{ at = [0, 0, 0.2], rpy = [\"-90 deg\", 0, 0] }", "", "false");
    let (expected, measures) = (solve(&frame), Measures::new(&frame, &names));
    for cut in ["false", "true"] {
        // The smallest turn from z to y is −90° about x, that of the frame.
        let second = arm("[0, 0, 0.2]", "second = [0, 2, 0]", cut);
        let (motion, own) = (solve(&second), Measures::new(&second, &names));
        for (a, b) in expected.samples.iter().zip(&motion.samples) {
            all_close("motion", &own.at(b), &measures.at(a), within(1e-8));
        }
    }
}

/// A force, a spring and a damper in a prismatic joint of a turning arm, against the same between two points of its
/// line, whose distance is the position of the joint.
#[test]
fn loads_in_a_prismatic_joint_act_along_it() {
    let slider = |where_: &str, cut: &str| {
        let text = format!(
            "[bodies.arm]\nmass = 3\ninertia = 0.4\ncom = [0.3, 0]\npoints = {{ S = [0.1, 0.2] }}\n\
             [bodies.block]\nmass = 2\ninertia = 0.1\ncom = [0.05, 0.1]\npoints = {{ B = [0, 0] }}\n\
             [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n\
             [joints.S]\ntype = \"prismatic\"\nbetween = [\"arm.S\", \"block.B\"]\naxis = [3, 4]\ncut = {cut}\n\
             [loads.push]\ntype = \"force\"\n{where_}\nvalue = \"6 N + 2 N s/m*S.velocity\"\n\
             [loads.spring]\ntype = \"spring\"\n{where_}\nstiffness = 300\nlength = 0.5\ndamping = 2\n\
             [loads.damper]\ntype = \"damper\"\n{where_}\ndamping = 5\n\
             [initial]\nO = {{ angle = 0, rate = 1 }}\nS = {{ position = 0.4, velocity = 0 }}\n\
             [solve]\nt_end = 1\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n"
        );
        derive(model(&text))
    };
    let names = ["arm.angle", "arm.rate", "S.position", "S.velocity"];
    let between = slider("between = [\"arm.S\", \"block.B\"]", "false");
    let (expected, measures) = (solve(&between), Measures::new(&between, &names));
    for cut in ["false", "true"] {
        let along = slider("joint = \"S\"", cut);
        let (motion, own) = (solve(&along), Measures::new(&along, &names));
        for (a, b) in expected.samples.iter().zip(&motion.samples) {
            all_close("motion", &own.at(b), &measures.at(a), within(1e-8));
            all_close(
                "reaction",
                &reaction(&along, b, "O"),
                &reaction(&between, a, "O"),
                within(1e-6),
            );
        }
    }
}
