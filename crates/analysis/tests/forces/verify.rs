//! Runs against their independent twins.

use crate::support::model;
use bksim_analysis::{Verified, Watch, verify};

fn verified(text: &str) -> Verified {
    let found = verify(model(text), Watch::NONE).expect("two runs");
    let [own, twin] = &found.ways;
    assert_ne!(own.n_coordinates, twin.n_coordinates);
    assert!(twin.tolerances[0] < own.tolerances[0]);
    assert!(!found.times.is_empty() && !found.channels.is_empty());
    found
}

const DOUBLE: &str = "[bodies]\nupper = { mass = 2, inertia = 0.1, com = [0.3, 0], points = { B = [0.6, 0] } }\n\
    lower = { mass = 1, inertia = 0.05, com = [0.2, 0] }\n\
    [joints]\nA = { type = \"revolute\", between = [\"ground\", \"upper\"] }\n\
    B = { type = \"revolute\", between = [\"upper.B\", \"lower\"] }\n\
    [loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
    [initial]\nA = { angle = -0.4, rate = 1.5 }\nB = { angle = 0.3, rate = -2 }\n";

#[test]
fn a_double_pendulum_keeps_to_its_tolerances_in_other_coordinates() {
    let found = verified(&format!("{DOUBLE}[solve]\nt_end = 2\n"));
    let [own, twin] = &found.ways;
    assert_eq!([own.n_coordinates, twin.n_coordinates], [2, 6], "joints, then bodies");
    let worst = found.channels.iter().find(|channel| channel.largest > channel.allowed);
    assert!(found.is_within(), "{worst:?}");
    for name in ["A.angle", "B.rate", "lower.ax", "B.fx", "energy.kinetic"] {
        assert!(found.channels.iter().any(|channel| channel.name == name), "{name}");
    }
}

#[test]
fn a_coarse_run_is_found_out() {
    let found =
        verified(&format!("{DOUBLE}[solve]\nt_end = 2\nstep = 0.05\nrtol = 1e-9\natol = 1e-11\n"));
    assert!(!found.is_within(), "fixed steps of 0.05 s are not exact to 1e-9");
}

/// A body on a ball joint: its quaternion becomes the body's own.
#[test]
fn a_spinning_top_is_the_same_in_both_coordinates() {
    let found = verified(
        "space = \"spatial\"\n[bodies.top]\nmass = 1\ninertia = [0.02, 0.02, 0.04]\ncom = [0, 0, 0.3]\n\
         [joints.ball]\ntype = \"spherical\"\nbetween = [\"ground\", \"top\"]\n\
         [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
         [initial]\ntop = { rpy = [0.3, 0, 0], wx = 0.5, wy = 2, wz = 20 }\n[solve]\nt_end = 1\n",
    );
    let worst = found.channels.iter().find(|channel| channel.largest > channel.allowed);
    assert!(found.is_within(), "{worst:?}");
}

/// Two bodies on ball joints whose frames are turned on both sides: a quaternion in a joint is not that of its body.
#[test]
fn balls_in_turned_frames_are_the_same_in_both_coordinates() {
    for coordinates in ["relative", "absolute"] {
        let found = verified(&format!(
            "space = \"spatial\"\ncoordinates = \"{coordinates}\"\n\
             [ground.points]\nO = {{ at = [0.1, 0.05, 0], rpy = [0.3, -0.4, 0.6] }}\n[bodies]\n\
             a = {{ mass = 1.5, inertia = [0.02, 0.015, 0.018], com = [0.1, 0, 0.1], points = {{ \
             P = {{ at = [0, 0, 0], rpy = [0.5, 0.2, -0.9] }}, Q = {{ at = [0.3, 0, 0], rpy = [0, 1, 0.2] }} }} }}\n\
             b = {{ mass = 1, inertia = [0.01, 0.015, 0.012], com = [0, 0.2, 0], points = {{ \
             Q = {{ at = [0, 0, 0.1], rpy = [-0.4, 0, 0.7] }} }} }}\n[joints]\n\
             first = {{ type = \"spherical\", between = [\"ground.O\", \"a.P\"] }}\n\
             second = {{ type = \"spherical\", between = [\"a.Q\", \"b.Q\"] }}\n\
             [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
             [initial]\na = {{ w = [1, 2, -1], frame = \"body\" }}\n[solve]\nt_end = 0.5\n"
        ));
        let worst = found.channels.iter().find(|channel| channel.largest > channel.allowed);
        assert!(found.is_within(), "{coordinates}: {worst:?}");
    }
}

/// A stiff motion by Radau IIA: its twin need not be explicit throughout.
#[test]
fn a_stiff_motion_is_verified_too() {
    let text = "[bodies.rod]\nmass = 1\ninertia = 0.1\ncom = [0.4, 0]\npoints = { P = [0.8, 0] }\n\
                [ground.points]\nS = [0.8, 0.5]\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\n\
                [loads.s]\ntype = \"spring\"\nbetween = [\"ground.S\", \"rod.P\"]\nstiffness = 100\nlength = 0.3\n\
                [loads.d]\ntype = \"damper\"\nbetween = [\"ground.S\", \"rod.P\"]\ndamping = 5000\n\
                [solve]\nt_end = 2\nmethod = \"radau\"\n";
    let found = verified(text);
    let worst = found.channels.iter().find(|channel| channel.largest > channel.allowed);
    assert!(found.is_within(), "{worst:?}");
}

/// Wheels whose turns count: their joints keep their coordinates.
#[test]
fn gears_are_verified() {
    let text = include_str!("../../../../tests/fixtures/planetary-gear.toml");
    let found = verify(model(text), Watch::NONE).expect("two runs");
    let beyond = found.channels.iter().filter(|channel| channel.largest > channel.allowed);
    let beyond: Vec<_> = beyond.map(|c| (&c.name, c.largest, c.allowed, c.t)).collect();
    assert!(found.is_within(), "{beyond:?} by {:?}", found.ways);
}

#[test]
fn a_chaotic_motion_is_judged_up_to_the_time_at_which_differences_hide_it() {
    // Turned over its top a double pendulum forgets its start.
    let wild = DOUBLE
        .replace("angle = -0.4, rate = 1.5", "angle = 2.6, rate = 0")
        .replace("angle = 0.3, rate = -2", "angle = 0.5, rate = 3");
    let found = verified(&format!("{wild}[solve]\nt_end = 30\n"));
    let growth = found.growth.as_ref().expect("differences that grow");
    let horizon = growth.horizon.expect("a horizon");
    assert!((2.0..28.0).contains(&horizon), "{horizon}");
    assert!(growth.rate > 0.3 && growth.rate < 10.0, "{}", growth.rate);
    let beyond: Vec<_> = found.channels.iter().filter(|c| !c.is_within).collect();
    assert!(found.is_within() && !found.is_whole(), "{beyond:?}");
    // Beyond the horizon the runs are far apart.
    let angle = found.channels.iter().find(|c| c.name == "A.angle").expect("a channel");
    assert!(angle.differences.iter().any(|off| off.abs() > 0.1));
}

#[test]
fn a_run_that_is_stopped_is_compared_as_far_as_it_came() {
    use std::cell::Cell;
    let steps = Cell::new(0);
    let name = Cell::new("");
    let watch = Watch {
        reached: &|run, _| name.set(run),
        stop: &|| {
            steps.set(steps.get() + usize::from(name.get() == "the same in another way"));
            steps.get() > 60
        },
    };
    let found = verify(model(&format!("{DOUBLE}[solve]\nt_end = 4\n")), watch).expect("two runs");
    let last = *found.times.last().expect("times");
    assert!(last > 0.0 && last < 4.0, "{last}");
    assert!(found.is_within() && !found.is_whole());
}

/// A wheel that is locked and turned by turns: its acceleration jumps at instants that are those of samples.
#[test]
fn samples_at_a_change_of_modes_may_show_either_side() {
    let found = verified(include_str!("../../../../examples/geneva/model.toml"));
    let worst = found.channels.iter().find(|channel| channel.largest > channel.allowed);
    assert!(found.is_within(), "{worst:?}");
    let jumps = [0.125, 0.375, 1.125, 1.375];
    assert!(jumps.iter().all(|jump| found.times.iter().all(|t| (t - jump).abs() > 1e-6)));
    assert_eq!((found.times.len(), found.is_whole()), (697, true));
}
