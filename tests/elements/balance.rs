//! All wrenches on a body that is cut free, with its inertia, are in balance.

use crate::support::{derive, elements, example_text, model};
use bksim::mbs::acting::{acting, inertia, point_of};
use bksim::mbs::force::Wrench;
use bksim::model::{BodyId, JointId};
use bksim::sim::wrenches::{WrenchAt, Wrenches};
use bksim::solved;

/// Largest part of the largest force, and of the largest moment, that the sum over a body is along the run.
fn imbalance(text: &str) -> f64 {
    let solved = solved::solve(derive(model(text)), text, &|_| true);
    let mut solved = solved.unwrap_or_else(|e| panic!("{e}"));
    assert!(solved.fault.is_none(), "{:?}", solved.fault);
    let playback = &mut solved.playback;
    let mechanism = playback.mechanism();
    let (model, system) = (&mechanism.model, &mechanism.system);
    let n_joints = model.joints.len();
    let joints = model.joints.iter().map(|j| [j.predecessor.body.0, j.successor.body.0]);
    let joints: Vec<[usize; 2]> = joints.collect();
    let n_bodies = model.bodies.len();
    let points = (0..n_joints).map(|joint| point_of(model, system, JointId(joint)));
    let inertias = (0..n_bodies).map(|body| inertia(model, system, BodyId(body)));
    let others = acting(model, system).into_iter().map(|of| of.wrench);
    let all: Vec<Wrench> = points.chain(inertias).chain(others).collect();
    let bodies: Vec<usize> = all.iter().map(|wrench| wrench.body.0).collect();
    let mut wrenches = Wrenches::compile(mechanism, &all).expect("compiles");
    let [first, last] = playback.span();
    let mut worst = 0.0_f64;
    for k in 0..=40 {
        playback.seek(first + (last - first) * f64::from(k) / 40.0).expect("replays");
        let sample = playback.sample();
        let numbers = wrenches.at(sample, playback.modes());
        for body in 1..n_bodies {
            let mut own: Vec<WrenchAt> = Vec::new();
            for (joint, ends) in joints.iter().enumerate() {
                let Some(end) = ends.iter().position(|&of| of == body) else { continue };
                let sign = if end == 1 { 1.0 } else { -1.0 };
                let [fx, fy, fz, mx, my, mz] = sample.reactions[joint].map(|x| sign * x);
                let point = numbers[joint].point;
                own.push(WrenchAt { force: [fx, fy, fz], point, moment: [mx, my, mz] });
            }
            let rest = numbers.iter().zip(&bodies).skip(n_joints);
            own.extend(rest.filter(|(_, of)| **of == body).map(|(w, _)| *w));
            let size = |v: [f64; 3]| v[0].hypot(v[1]).hypot(v[2]);
            let about = own[0].point;
            let force = own.iter().map(|w| size(w.force)).fold(0.0, f64::max);
            let moment = own.iter().map(|w| size(w.moment_about(about))).fold(0.0, f64::max);
            let sum = WrenchAt::sum(&own, own.len());
            let left = WrenchAt { moment: sum.moment_about(about), ..sum };
            worst = worst.max(size(left.force) / force.max(1e-9));
            worst = worst.max(size(left.moment) / moment.max(force * 1e-3));
        }
    }
    worst
}

/// A box on a slope with friction and a spring, and a lever that a torque turns against friction in its pin.
const BOX: &str = r#"
[ground]
points = { A = ["-1 m", "0 m"], B = ["3 m", "0 m"] }

[bodies.box]
free = true
mass = "2 kg"
inertia = "0.05 kg m^2"
points = { L = ["-0.2 m", "-0.1 m"], R = ["0.2 m", "-0.1 m"], T = [0, "0.05 m"] }

[bodies.lever]
mass = "1 kg"
inertia = "0.02 kg m^2"
com = ["0.1 m", "0.02 m"]

[joints.A]
type = "revolute"
between = ["ground.B", "lever"]

[contacts.floor]
between = [{ line = ["ground.A", "ground.B"] }, { outline = ["box.L", "box.R", "box.T"] }]
mu = 0.2

[loads.gravity]
type = "gravity"
acceleration = ["1 m/s^2", "-9.81 m/s^2"]

[loads.spring]
type = "spring"
between = ["ground.B", "box.T"]
stiffness = "30 N/m"
length = "1 m"
damping = "2 N s/m"

[loads.motor]
type = "torque"
on = "lever"
value = "0.4 N m*sin(3 rad/s*t)"

[loads.rub]
type = "friction"
joint = "A"
torque = "0.05 N m"

[initial]
box = { x = "0.5 m", y = "0.1 m", angle = 0, vx = "1.5 m/s" }
A = { angle = 0.2, rate = 1 }

[solve]
t_end = "1.2 s"
"#;

#[test]
fn of_contacts_friction_springs_and_torques() {
    let worst = imbalance(BOX);
    assert!(worst < 1e-9, "{worst:.1e}");
}

#[test]
fn of_closed_chains_with_drives() {
    for text in [example_text("slider-crank"), elements::text("engine")] {
        let worst = imbalance(&text);
        assert!(worst < 1e-9, "{worst:.1e}");
    }
}
