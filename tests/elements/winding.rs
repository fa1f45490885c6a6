//! Ropes and belts that turn by more than half a turn: around pegs, posts and drums, and around wheels on arms.

use std::f64::consts::{PI, TAU};

use crate::support::{Within, at, close, derive, model, signal, solve};
use bksim::Motion;
use bksim::model::file::{Source, read};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// A ball on a string of 1 m, or of the length that its start needs.
fn string(over: &str, keys: &str, start: &str, rest: &str) -> String {
    format!(
        "[ground]\npoints = {{ O = [0, 0], P = [0, -0.65] }}\n\
         [bodies.bob]\nmass = 1.5\nfree = true\npoints = {{ Z = [0, 0] }}\n\
         [couplings.rope]\ntype = \"rope\"\nover = [{over}, \"bob.Z\"]\n{keys}\n\
         [initial]\nbob = {{ {start} }}\n{rest}\n\
         [outputs]\nx = \"bob.x\"\ny = \"bob.y\"\nvx = \"bob.vx\"\nvy = \"bob.vy\"\n\
         [solve]\nrtol = 1e-10\natol = 1e-12\n"
    )
}

const WEIGHT: &str = "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]";

fn energy(motion: &Motion) {
    let worst = motion.summary.energy.worst_error;
    assert!(worst < 1e-7, "the energy is off by {worst}");
}

/// The string meets the peg below the level from which the ball falls, and winds round and round: a circle of 0.35 m, with
/// the pull m (v²/r − g·e).
#[test]
fn a_string_winds_round_a_peg_by_many_turns() {
    let peg = "\"ground.O\", { pulley = \"ground.P\", radius = 0, turn = \"left\", leaves = true }";
    for keys in ["length = 1\nslack = true", ""] {
        let text = string(peg, keys, "x = -1, y = 0, vx = 0, vy = 0", WEIGHT);
        let text = text.replace("[outputs]\n", "[outputs]\npull = \"couplings.rope\"\n")
            + "t_end = 4\nevery = 0.02\n";
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let (mut turned, mut last) = (0.0, -PI / 2.0);
        for sample in &motion.samples {
            let of = |name| signal(&mechanism, sample, name);
            let [x, y] = [of("x"), of("y") + 0.65];
            if sample.t < 0.9 {
                continue;
            }
            close("radius", x.hypot(y), 0.35, within(1e-7));
            let square = of("vx").powi(2) + of("vy").powi(2);
            close("speed", square, -2.0 * 9.81 * of("y"), within(1e-6));
            close("pull", of("pull"), 1.5 * (square / 0.35 - 9.81 * y / 0.35), within(1e-5));
            let angle = y.atan2(x);
            turned += (angle - last + PI).rem_euclid(TAU) - PI;
            last = angle;
        }
        assert!(turned > 3.0 * TAU, "{turned}");
        energy(&motion);
    }
}

/// Without weight a ball keeps its speed, and its string gets shorter as it winds on a drum: l² = l₀² − 2 r v t.
#[test]
fn a_string_winds_on_a_drum_by_many_turns() {
    let over = "{ drum = \"ground.O\", radius = 0.05, turn = \"left\" }";
    let start = "x = 1, y = -0.05, vx = 0, vy = 3";
    for (keys, loose) in [("", 1e-7), ("slack = true", 1e-7), ("EA = 2e5\nlength = 1", 1e-3)] {
        let text = string(over, keys, start, "") + "t_end = 3.2\nevery = 0.1\n";
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        for sample in &motion.samples {
            let [x, y] = ["x", "y"].map(|name| signal(&mechanism, sample, name));
            let free = (1.0 - 2.0 * 0.05 * 3.0 * sample.t).sqrt();
            close(keys, x.hypot(y), free.hypot(0.05), within(loose));
        }
        energy(&motion);
    }
}

/// On a post to which it is held, and on one that it may leave, a string that winds on does the same, and leaves nothing.
#[test]
fn a_string_that_winds_on_a_post_does_not_leave_it() {
    let ends = ["false", "true"].map(|leaves| {
        let over = format!(
            "\"ground.O\", {{ pulley = \"ground.P\", radius = 0.05, turn = \"left\", leaves = {leaves} }}"
        );
        let start = "x = 0.052, y = -1, vx = 7";
        let text = string(&over, "", start, WEIGHT) + "t_end = 0.15\nevery = 0.005\n";
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        assert_eq!(motion.summary.left, None);
        energy(&motion);
        let first = signal(&mechanism, &motion.samples[0], "rope_length");
        for sample in &motion.samples {
            close("length", signal(&mechanism, sample, "rope_length"), first, within(1e-9));
        }
        let end = at(&motion, 0.15);
        ["x", "y"].map(|name| signal(&mechanism, end, name))
    });
    let [held, free] = ends;
    close("x", free[0], held[0], within(1e-7));
    close("y", free[1], held[1], within(1e-7));
}

/// The planet of a belt on an arm turns by ω_arm + (r₁/r₂) (ω_sun − ω_arm), for as long as it likes.
#[test]
fn a_belt_on_an_arm_goes_round_by_many_turns() {
    for keys in ["", "stiffness = 1e5\nlength = 1.47"] {
        let text = format!(
            "[bodies]\narm = {{ mass = 1, inertia = 0.1, points = {{ T = [0.5, 0] }} }}\n\
             planet = {{ mass = 0.5, inertia = 0.002 }}\nsun = {{ mass = 1, inertia = 0.01 }}\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"arm\"] }}\n\
             S = {{ type = \"revolute\", between = [\"ground\", \"sun\"] }}\n\
             P = {{ type = \"revolute\", between = [\"arm.T\", \"planet\"] }}\n\
             [drives]\nd = {{ joint = \"A\", motion = \"4 rad/s*t\" }}\n\
             e = {{ joint = \"S\", motion = \"1 rad/s*t\" }}\n\
             [couplings.b]\ntype = \"belt\"\nturns = [\"left\", \"left\"]\nbetween = [\"S\", \"P\"]\n\
             radii = [0.1, 0.05]\n{keys}\n[outputs]\nangle = \"planet.angle\"\n\
             [initial]\nP = {{ rate = -6 }}\n[solve]\nt_end = 5\nevery = 0.1\nrtol = 1e-9\n"
        );
        let text =
            if keys.is_empty() { text.replace("[initial]\nP = { rate = -6 }\n", "") } else { text };
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        for sample in &motion.samples {
            let angle = signal(&mechanism, sample, "angle");
            let expected = (4.0 + 2.0 * (1.0 - 4.0)) * sample.t;
            close("planet", angle, expected, within(1e-6));
        }
    }
}

/// From a drum of the ground over a roller on an arm that turns round and round: the way stays as long as the rope.
#[test]
fn a_rope_over_a_roller_on_an_arm_keeps_its_length() {
    let text = "[ground]\npoints = { Q = [0, 0] }\n\
        [bodies]\narm = { mass = 1, inertia = 0.1, points = { T = [1, 0.1] } }\n\
        roll = { mass = 0.2, inertia = 1e-3, points = { C = [0, 0] } }\n\
        bob = { mass = 1, points = { C = [0, 0] } }\n\
        [joints]\nA = { type = \"revolute\", between = [\"ground\", \"arm\"] }\n\
        R = { type = \"revolute\", between = [\"arm.T\", \"roll\"] }\n\
        s = { type = \"prismatic\", between = [\"arm\", \"bob\"], axis = [1, 0] }\n\
        [drives.d]\njoint = \"A\"\nmotion = \"5 rad/s*t\"\n\
        [couplings.r]\ntype = \"rope\"\n\
        over = [{ drum = \"ground.Q\", radius = 0.0999, turn = \"right\" }, { pulley = \"roll.C\", radius = 0.1, turn = \"right\" }, \"bob.C\"]\n\
        length = 1.6\n\
        [outputs]\nposition = \"s.position\"\n[solve]\nt_end = 3\nevery = 0.01\nrtol = 1e-9\natol = 1e-11\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    energy(&motion);
    // The span from the roller lies along the arm: while the arm turns by φ it rolls off r φ of it, less the turn of the
    // roller, (r₂ − r₁) φ/r₂.
    let position = |t: f64| signal(&mechanism, at(&motion, t), "position");
    for k in 0..=300_u32 {
        let t = f64::from(k) * 0.01;
        close("position", position(t), position(0.0) - 0.0999 * 5.0 * t, within(1e-7));
    }
}

/// Two loads on a rope with whole turns about a bollard: it holds as far as exp(μ φ), and slips beyond.
#[test]
fn a_rope_grips_a_bollard_by_the_whole_angle() {
    let text = |turns: u32, heavy: f64| {
        format!(
            "[ground]\npoints = {{ O = [0, 0], L = [-0.1, -1], R = [0.1, -1] }}\n\
             [bodies]\na = {{ points = {{ Z = [0, 0] }}, mass = {heavy} }}\n\
             b = {{ points = {{ Z = [0, 0] }}, mass = 2 }}\n\
             [joints]\nga = {{ type = \"prismatic\", between = [\"ground.L\", \"a\"], axis = [0, 1] }}\n\
             gb = {{ type = \"prismatic\", between = [\"ground.R\", \"b\"], axis = [0, 1] }}\n\
             [couplings.rope]\ntype = \"rope\"\n\
             over = [\"a.Z\", {{ pulley = \"ground.O\", radius = 0.1, turn = \"right\", mu = 0.3, whole_turns = {turns} }}, \"b.Z\"]\n\
             {WEIGHT}\n[outputs]\ngrip = \"2*rope_1_grip\"\nway = \"rope_length\"\n\
             v = \"ga.velocity\"\n[solve]\nt_end = 0.2\nevery = 0.1\n"
        )
    };
    for turns in [0, 1, 3] {
        let angle = PI + TAU * f64::from(turns);
        let most = (0.3 * angle).exp();
        // Below the limit it holds, and says how much of it is taken.
        let mechanism = derive(model(&text(turns, 2.0 * 0.9 * most)));
        let motion = solve(&mechanism);
        assert_eq!(motion.summary.wound, None);
        let end = at(&motion, 0.2);
        close("at rest", signal(&mechanism, end, "v"), 0.0, within(1e-10));
        let part = (0.9 * most).ln() / (0.3 * angle);
        close("grip", signal(&mechanism, end, "grip"), 2.0 * part, within(1e-9));
        close("way", signal(&mechanism, end, "way"), 2.0 + 0.1 * angle, within(1e-9));
        // Above it slips.
        let heavy = 2.0 * 1.5 * most;
        let mechanism = derive(model(&text(turns, heavy)));
        let motion = solve(&mechanism);
        let slips = -9.81 * (heavy - 2.0 * most) / (heavy + 2.0 * most) * 0.2;
        close("slips", signal(&mechanism, at(&motion, 0.2), "v"), slips, within(1e-8));
    }
}

#[test]
fn whole_turns_are_whole_and_about_a_pulley() {
    for (keys, expected) in [
        ("radius = 0.1, turn = \"left\", whole_turns = 1.5", "a whole number"),
        ("radius = 0.1, turn = \"left\", whole_turns = -1", "a whole number"),
        ("radius = 0, whole_turns = 1", "goes around nothing"),
    ] {
        let over = format!("\"ground.O\", {{ pulley = \"ground.P\", {keys} }}");
        let text = string(&over, "", "x = 0.3, y = -1, vx = 0, vy = 0", WEIGHT) + "t_end = 1\n";
        let found = read(&Source::new(&text, "test")).diagnostics;
        assert!(found.iter().any(|fault| fault.message.contains(expected)), "{keys}: {found:?}");
    }
}

/// A string that swings over the top goes through its post from the other side, which is warned about.
#[test]
fn a_string_that_comes_to_a_post_from_its_other_side_is_warned_about() {
    let left = |turn: &str| {
        let over = format!(
            "\"ground.O\", {{ pulley = \"ground.P\", radius = 0, turn = \"{turn}\", leaves = true }}"
        );
        let text = string(&over, "", "x = -0.1, y = -1.2, vx = -9", WEIGHT) + "t_end = 1.2\n";
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        energy(&motion);
        // Straight below its end, to the left of which it began.
        motion.summary.left.map(|(t, _)| signal(&mechanism, at(&motion, t), "x"))
    };
    let x = left("left").expect("a warning");
    assert!(x < 0.0 && x > -0.5, "{x}");
    assert_eq!(left("right"), None);
}

/// A signal is read before the ropes of which an output takes its value.
#[test]
fn a_signal_that_uses_an_output_of_a_rope_is_refused() {
    let text = |section: &str| {
        let text = string("\"ground.O\"", "", "x = 0.3, y = -1, vx = 0, vy = 0", WEIGHT);
        text.replace("[outputs]\n", "[outputs]\nway = \"2*rope_length\"\nmore = \"way + 1 m\"\n")
            + "t_end = 1\n"
            + section
    };
    let mechanism = derive(model(&text("")));
    let motion = solve(&mechanism);
    let length = 0.3_f64.hypot(1.0);
    close(
        "more",
        signal(&mechanism, &motion.samples[0], "more"),
        2.0 * length + 1.0,
        within(1e-12),
    );
    let found = read(&Source::new(&text("[signals.s]\nvalue = \"more\"\n"), "test")).diagnostics;
    assert!(
        found.iter().any(|fault| fault.is_error() && fault.message.contains("`more`")),
        "{found:?}"
    );
}
