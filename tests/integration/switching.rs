//! Stops, dry friction and kinks of expressions against motions known in closed form.

use crate::support::{Within, close, derive, model, solve};
use bksim::model::{CoordinatePolicy, Method};
use bksim::sim::hybrid::ChangeKind;
use bksim::{Mechanism, Motion};

/// A block of 2 kg on a guide along x, with what is appended.
fn block(rest: &str) -> String {
    format!(
        r#"
[bodies.block]
mass = "2 kg"

[joints.S]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
coordinate = "x"
{rest}
"#
    )
}

/// Block on a guide upwards, in gravity.
fn falling(rest: &str) -> String {
    let upwards = block(rest).replace("axis = [1, 0]", "axis = [0, 1]");
    format!("{upwards}\n[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n")
}

const G: f64 = 9.81;

fn run(text: &str, t_end: f64, rtol: f64) -> (Mechanism, Motion) {
    run_in(text, t_end, rtol, CoordinatePolicy::Auto)
}

fn run_in(text: &str, t_end: f64, rtol: f64, policy: CoordinatePolicy) -> (Mechanism, Motion) {
    let mut model = model(text);
    model.coordinates = policy;
    (model.solve.rtol, model.solve.atol) = (rtol, rtol);
    (model.solve.t_end, model.solve.every) = (t_end, Some(t_end / 200.0));
    let mechanism = derive(model);
    let motion = solve(&mechanism);
    (mechanism, motion)
}

/// Times of the changes that `wanted` selects.
fn times(motion: &Motion, wanted: fn(&ChangeKind) -> bool) -> Vec<f64> {
    let changes = motion.summary.changes.iter();
    changes.filter(|change| wanted(&change.kind)).map(|change| change.t).collect()
}

fn balanced(what: &str, motion: &Motion, within: f64) {
    let energy = &motion.summary.energy;
    let error = energy.worst_error / energy.scale;
    assert!(error < within, "{what}: energy off by {error:.1e}");
}

/// One message of a run that cannot go on.
fn refused(text: &str) -> String {
    let mechanism = derive(model(text));
    mechanism.solve().expect_err("the run cannot go on").to_string()
}

#[test]
fn a_ball_bounces_as_a_geometric_series_and_comes_to_rest() {
    let (e, h) = (0.8, 1.0);
    let text = falling(
        "[loads.floor]\ntype = \"stop\"\njoint = \"S\"\nmin = 0\nrestitution = 0.8\n\
         [initial]\nx = \"1 m\"\n",
    );
    for policy in [CoordinatePolicy::Relative, CoordinatePolicy::Absolute] {
        let (mechanism, motion) = run_in(&text, 6.0, 1e-9, policy);
        let speed = (2.0 * G * h).sqrt();
        let mut t = speed / G;
        let mut bounce = speed;
        let hits = times(&motion, |kind| matches!(kind, ChangeKind::Hit(..)));
        for (n, &hit) in hits.iter().take(40).enumerate() {
            let within = Within { relative: 1e-8, absolute: 0.0 };
            close(&format!("bounce {n}, {policy:?}"), hit, t, within);
            bounce *= e;
            t += 2.0 * bounce / G;
        }
        assert!((50..90).contains(&hits.len()), "{} bounces", hits.len());
        let n_step = motion.summary.stats.n_step;
        assert!(n_step < 12 * hits.len() + 100, "{n_step} steps for {} bounces", hits.len());

        // The series ends at 4.06 s; from there the floor bears the weight.
        let limit = speed / G * (1.0 + 2.0 * e / (1.0 - e));
        let rests = times(&motion, |kind| matches!(kind, ChangeKind::Rest(_)));
        assert_eq!(rests.len(), 1, "{rests:?}");
        close("rest", rests[0], limit, Within { relative: 1e-5, absolute: 0.0 });
        let last = motion.samples.last().expect("samples");
        let row = mechanism.system.contacts[0].row;
        let within = Within { relative: 0.0, absolute: 1e-12 };
        close("height at rest", last.q[last.q.len().min(2) - 1], 0.0, within);
        close("speed at rest", last.v[last.v.len().min(2) - 1], 0.0, within);
        let within = Within { relative: 1e-12, absolute: 0.0 };
        close("force of the floor", last.lambda[row], 2.0 * G, within);
        let within = Within { relative: 1e-9, absolute: 0.0 };
        close("loss by impacts", motion.summary.energy.impacts, -2.0 * G * h, within);
        balanced("bounces", &motion, 1e-9);
    }
}

#[test]
fn between_two_stops_nothing_is_lost_without_loss() {
    let text = block(
        "[loads.walls]\ntype = \"stop\"\njoint = \"S\"\nmin = \"-0.25 m\"\nmax = \"0.75 m\"\n\
         restitution = 1\n[initial]\nx_dot = \"3 m/s\"\n",
    );
    let (_, motion) = run(&text, 10.0, 1e-8);
    let hits = times(&motion, |kind| matches!(kind, ChangeKind::Hit(..)));
    // First at 0.75/3 s, then every third of a second.
    assert_eq!(hits.len(), 30);
    for (n, &hit) in hits.iter().enumerate() {
        close("hit", hit, 0.25 + n as f64 / 3.0, Within { relative: 1e-10, absolute: 0.0 });
    }
    assert!(motion.summary.energy.impacts.abs() < 1e-12);
    assert!(motion.summary.stats.n_step < 400, "{} steps", motion.summary.stats.n_step);
}

#[test]
fn a_stop_lets_go_when_it_would_have_to_pull() {
    // Lifted by a force that grows by 5 N a second against 19.62 N.
    let text = falling(
        "[loads.floor]\ntype = \"stop\"\njoint = \"S\"\nmin = 0\n\
         [loads.lift]\ntype = \"force\"\non = \"block\"\nvector = [0, \"5 N/s*t\"]\n",
    );
    let (mechanism, motion) = run(&text, 6.0, 1e-9);
    let leave = 2.0 * G / 5.0;
    let parts = times(&motion, |kind| matches!(kind, ChangeKind::Part(_)));
    assert_eq!(parts.len(), 1);
    close("lift-off", parts[0], leave, Within { relative: 1e-7, absolute: 0.0 });
    for sample in &motion.samples {
        let flown = (sample.t - leave).max(0.0);
        let within = Within { relative: 0.0, absolute: 1e-7 };
        close("height", sample.q[0], 5.0 * flown.powi(3) / 12.0, within);
        let force = sample.lambda[mechanism.system.contacts[0].row];
        let borne = (2.0 * G - 5.0 * sample.t).max(0.0);
        close("force of the floor", force, borne, Within { relative: 0.0, absolute: 1e-6 });
    }
    balanced("lifted", &motion, 1e-8);
}

#[test]
fn friction_takes_the_same_from_every_swing_until_the_spring_cannot_move() {
    // k = 200 N/m, 2 kg: ω = 10; F = 4 N takes 2F/k = 40 mm from every half swing.
    let text = block(
        "[ground]\npoints = { O = [\"-1 m\", 0] }\n\
         [loads.spring]\ntype = \"spring\"\nbetween = [\"ground.O\", \"block\"]\n\
         stiffness = \"200 N/m\"\nlength = \"1 m\"\n\
         [loads.dry]\ntype = \"friction\"\njoint = \"S\"\nforce = \"4 N\"\n\
         [initial]\nx = \"0.21 m\"\n",
    );
    let (mechanism, motion) = run(&text, 3.0, 1e-9);
    let half = std::f64::consts::PI / 10.0;
    for sample in &motion.samples {
        // Swing n goes about ±F/k from 0.21 − 0.04 n; after five, 0.01 m is within F/k = 0.02 m.
        let n = (sample.t / half).floor().min(5.0);
        let start = (0.21 - 0.04 * n) * if n % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let middle = 0.02 * start.signum();
        let phase = 10.0 * (sample.t - n * half);
        let x = if n < 5.0 { middle + (start - middle) * phase.cos() } else { start };
        let what = format!("x at {:.3} s", sample.t);
        close(&what, sample.q[0], x, Within { relative: 0.0, absolute: 1e-7 });
    }
    let last = motion.samples.last().expect("samples");
    let row = mechanism.system.contacts[0].row;
    // At x = −0.01 m the spring pushes with 2 N and friction holds against it.
    close("friction at rest", last.lambda[row], -2.0, Within { relative: 1e-6, absolute: 0.0 });
    assert_eq!(times(&motion, |kind| matches!(kind, ChangeKind::Stick(_))).len(), 1);
    balanced("swings", &motion, 1e-8);
}

#[test]
fn a_block_on_a_belt_sticks_and_slips_with_the_period_of_the_closed_form() {
    let text = include_str!("../fixtures/block-on-belt.toml");
    let (_, motion) = run(text, 20.0, 1e-9);
    let (v, omega, a) = (0.1, 5.0, 2.0 / 50.0);
    let slip = (std::f64::consts::TAU - 2.0 * f64::atan(a * omega / v)) / omega;
    let stick = 2.0 * a / v;
    let slides = times(&motion, |kind| matches!(kind, ChangeKind::Slide(_)));
    let sticks = times(&motion, |kind| matches!(kind, ChangeKind::Stick(_)));
    let within = Within { relative: 1e-6, absolute: 0.0 };
    close("first slip", slides[0], 5.0 / 50.0 / v, within);
    assert!(slides.len() >= 10, "{} slips", slides.len());
    for pair in slides.windows(2) {
        close("period", pair[1] - pair[0], slip + stick, within);
    }
    for (slide, stuck) in slides.iter().zip(&sticks) {
        close("time of a slip", stuck - slide, slip, within);
    }
    balanced("belt", &motion, 1e-8);
}

/// The force that holds reaches its limit at 1 s whatever the tolerance: rounding of forces, by which
/// it is told whether it has, is none of its time.
#[test]
fn a_block_begins_to_slip_when_its_limit_is_reached() {
    let text = include_str!("../fixtures/block-on-belt.toml");
    let equal = text.replace("static = \"5 N\"", "static = \"3 N\"");
    for rtol in [1e-4, 1e-6, 1e-9] {
        for (text, expected) in [(text, 1.0), (&equal, 0.6)] {
            let (_, motion) = run(text, 1.2, rtol);
            let slides = times(&motion, |kind| matches!(kind, ChangeKind::Slide(_)));
            close("first slip", slides[0], expected, Within { relative: 0.0, absolute: 1e-12 });
        }
    }
}

#[test]
fn a_block_thrown_up_an_incline_stops_and_stays() {
    let (angle, mu) = (20f64.to_radians(), 0.5);
    let normal = 2.0 * G * angle.cos();
    let text = falling(&format!(
        "[loads.dry]\ntype = \"friction\"\njoint = \"S\"\nforce = \"{} N\"\n\
         [initial]\nx_dot = \"2 m/s\"\n",
        mu * normal
    ))
    .replace("axis = [0, 1]", "direction = \"20 deg\"");
    let (mechanism, motion) = run(&text, 2.0, 1e-9);
    let deceleration = G * (angle.sin() + mu * angle.cos());
    let sticks = times(&motion, |kind| matches!(kind, ChangeKind::Stick(_)));
    assert_eq!(sticks.len(), 1);
    close("stop", sticks[0], 2.0 / deceleration, Within { relative: 1e-8, absolute: 0.0 });
    let last = motion.samples.last().expect("samples");
    close("way", last.q[0], 2.0 / deceleration, Within { relative: 1e-8, absolute: 0.0 });
    let row = mechanism.system.contacts[0].row;
    let held = 2.0 * G * angle.sin();
    close("friction at rest", last.lambda[row], held, Within { relative: 1e-8, absolute: 0.0 });
    // While it slides up, friction pulls down with its full size, and the log says so.
    let first = &motion.samples[1];
    close("friction", first.lambda[row], -mu * normal, Within { relative: 1e-12, absolute: 0.0 });
}

#[test]
fn a_spring_with_a_kink_is_exact_and_costs_few_steps() {
    // −(a x + b |x|): 128 N/m pulling, 32 N/m pushing; ω = 8 and 4.
    let kinked = block(
        "[loads.F]\ntype = \"force\"\non = \"block\"\nvector = [\"-80 N/m*x - 48 N/m*abs(x)\", 0]\n\
         [initial]\nx = \"0.1 m\"\n",
    );
    let (_, motion) = run(&kinked, 10.0, 1e-11);
    let (fast, slow) = (std::f64::consts::PI / 8.0, std::f64::consts::PI / 4.0);
    for sample in &motion.samples {
        let t = (sample.t + 0.5 * fast) % (fast + slow);
        let x = if t < fast { 0.1 * (8.0 * t).sin() } else { -0.2 * (4.0 * (t - fast)).sin() };
        let what = format!("x at {:.3} s", sample.t);
        close(&what, sample.q[0], x, Within { relative: 0.0, absolute: 2e-9 });
    }
    balanced("kinked", &motion, 1e-9);

    // The linear spring of the same mean period, for comparison.
    let smooth = kinked.replace("-80 N/m*x - 48 N/m*abs(x)", "-56.9 N/m*x");
    let (_, smooth) = run(&smooth, 10.0, 1e-11);
    let (n_kinked, n_smooth) = (motion.summary.stats.n_step, smooth.summary.stats.n_step);
    let n_kinks = motion.summary.changes.len();
    assert!((15..19).contains(&n_kinks), "{n_kinks} kinks");
    assert!(n_kinked < n_smooth + 25 * n_kinks, "{n_kinked} steps, {n_smooth} without kinks");
}

#[test]
fn a_force_that_is_switched_on_acts_from_that_instant() {
    let text = block(
        "[loads.F]\ntype = \"force\"\non = \"block\"\nvector = [\"1 N*if(t < 1.3, 0, 7)\", 0]\n",
    );
    let (_, motion) = run(&text, 3.0, 1e-10);
    for sample in &motion.samples {
        let x = 0.25 * 7.0 * (sample.t - 1.3).max(0.0).powi(2);
        close("x", sample.q[0], x, Within { relative: 1e-10, absolute: 1e-12 });
    }
    let switched = &motion.summary.changes;
    assert_eq!(switched.len(), 1);
    close("switch", switched[0].t, 1.3, Within { relative: 1e-14, absolute: 0.0 });
    assert!(motion.summary.stats.n_step < 60, "{} steps", motion.summary.stats.n_step);
}

#[test]
fn the_branch_not_taken_may_have_no_value() {
    let text = block(
        "[loads.F]\ntype = \"force\"\non = \"block\"\n\
         vector = [\"1 N*if(x > 0.5, 0, sqrt(max(0, 0.5 - x)/(1 m)) + 1)\", 0]\n",
    );
    let (_, motion) = run(&text, 3.0, 1e-9);
    let last = motion.samples.last().expect("samples");
    assert!(last.q[0] > 0.5 && last.a[0] == 0.0, "x = {}, a = {}", last.q[0], last.a[0]);
    balanced("branches", &motion, 1e-7);
}

#[test]
fn a_drive_with_a_kink_gives_an_impact() {
    let text = block("[drives.motor]\njoint = \"S\"\nmotion = \"3 m/s*max(0, t - 1)\"\n");
    let (_, motion) = run(&text, 2.0, 1e-8);
    let last = motion.samples.last().expect("samples");
    close("position", last.q[0], 3.0, Within { relative: 1e-12, absolute: 0.0 });
    close("work", motion.summary.energy.impacts, 9.0, Within { relative: 1e-9, absolute: 0.0 });
    balanced("kinked drive", &motion, 1e-9);
}

#[test]
fn what_cannot_go_on_is_named() {
    let sign = block(
        "[loads.F]\ntype = \"force\"\non = \"block\"\nvector = [\"-5 N*sign(x_dot)\", 0]\n\
         [initial]\nx_dot = \"1 m/s\"\n",
    );
    let said = refused(&sign);
    assert!(said.contains("R006") && said.contains("load `F`"), "{said}");

    let jump = block("[drives.motor]\njoint = \"S\"\nmotion = \"1 m*if(t < 1, 0, 1)\"\n");
    let said = refused(&jump);
    assert!(said.contains("R008") && said.contains("drive `motor` jumps by 1"), "{said}");

    let wall = block(
        "[drives.motor]\njoint = \"S\"\nmotion = \"1 m/s*t\"\n\
         [loads.wall]\ntype = \"stop\"\njoint = \"S\"\nmax = \"0.5 m\"\n",
    );
    let said = refused(&wall);
    assert!(said.contains("R007") && said.contains("`wall`") && said.contains("0.5 s"), "{said}");

    let beyond = block(
        "[loads.wall]\ntype = \"stop\"\njoint = \"S\"\nmax = \"0.5 m\"\n[initial]\nx = \"0.6 m\"\n",
    );
    let said = refused(&beyond);
    assert!(said.contains("S007") && said.contains("by 0.1"), "{said}");
}

#[test]
fn implicit_and_explicit_steps_meet_the_same_events() {
    // A block that rubs, bounces between two stops on a spring with a kink, and comes to rest.
    let text = block(
        "[loads.walls]\ntype = \"stop\"\njoint = \"S\"\nmin = \"-0.3 m\"\nmax = \"0.2 m\"\n\
         restitution = 0.7\n\
         [loads.dry]\ntype = \"friction\"\njoint = \"S\"\nforce = \"3 N\"\nstatic = \"4 N\"\n\
         [loads.F]\ntype = \"force\"\non = \"block\"\nvector = [\"-60 N/m*x - 20 N/m*abs(x)\", 0]\n\
         [initial]\nx_dot = \"3 m/s\"\n",
    );
    let runs = [Method::Auto, Method::Radau, Method::Explicit].map(|method| {
        let mut model = model(&text);
        model.solve.method = method;
        (model.solve.rtol, model.solve.atol, model.solve.t_end) = (1e-9, 1e-9, 4.0);
        let motion = solve(&derive(model));
        balanced("all together", &motion, 1e-7);
        motion
    });
    let [auto, others @ ..] = &runs;
    assert!(auto.summary.changes.len() >= 6, "{:?}", auto.summary.changes);
    for other in others {
        assert_eq!(auto.summary.changes.len(), other.summary.changes.len());
        for (a, b) in auto.summary.changes.iter().zip(&other.summary.changes) {
            let within = Within { relative: 0.0, absolute: 1e-6 };
            close(&format!("{:?} and {:?}", a.kind, b.kind), a.t, b.t, within);
        }
    }
}

/// Whoever changes a start gets the motion from there, not one in the modes that held before.
#[test]
fn a_start_that_was_changed_begins_in_modes_of_its_own() {
    let at = |velocity: &str| {
        let text = block(&format!(
            "[loads.rub]\ntype = \"friction\"\njoint = \"S\"\nforce = \"2 N\"\n\
             [initial]\nS = {{ position = 0, velocity = \"{velocity}\" }}\n"
        ));
        let mut mechanism = derive(model(&text));
        mechanism.model.solve.t_end = 2.0;
        mechanism.simulation().expect("functions")
    };
    let last = |simulation: &bksim::Simulation, start: &bksim::sim::start::Start| {
        let mut last = 0.0;
        let mut keep = |sample: &bksim::sim::run::Sample| {
            last = sample.q[0];
            bksim::dae::Control::Continue
        };
        simulation.run(start, &mut keep, &|| false).expect("a motion");
        last
    };
    let (resting, moving) = (at("0 m/s"), at("3 m/s"));
    let expected = last(&moving, &moving.start().expect("a start"));
    let mut changed = resting.start().expect("a start");
    changed.v[0] = 3.0;
    assert!(expected > 1.0, "it slides: {expected} m");
    assert_eq!(last(&resting, &changed), expected);

    // Nor does one that is advanced by hand.
    let mut held = resting.begin_at(&changed).expect("a motion");
    held.advance_to(2.0).expect("a motion");
    assert_eq!(held.state().q[0], expected);
}

#[test]
fn a_start_that_was_changed_does_not_begin_beyond_a_stop() {
    let text = block(
        "[loads.wall]\ntype = \"stop\"\njoint = \"S\"\nmax = \"1 m\"\n\
         [initial]\nS = { position = 0, velocity = \"0.5 m/s\" }\n",
    );
    let simulation = derive(model(&text)).simulation().expect("functions");
    let mut changed = simulation.start().expect("a start");
    changed.q[0] = 1.2;
    let mut ignore = |_: &bksim::sim::run::Sample| bksim::dae::Control::Continue;
    let failure = simulation.run(&changed, &mut ignore, &|| false).expect_err("it is in the wall");
    let said = simulation.diagnose(&failure);
    assert!(said.message.contains("`wall`") && said.message.contains("0.2"), "{said:?}");
    let refused = simulation.begin_at(&changed).err().expect("it is in the wall");
    assert_eq!(refused.0, [said]);
}

/// Loads follow the branches of the state that the start has, not those of all coordinates zero.
#[test]
fn a_start_is_on_its_own_side_of_a_kink() {
    let text = block(
        "[loads.pull]\ntype = \"force\"\non = \"block\"\n\
         vector = [\"2 N*sqrt(abs(S.position - 2 m)/(1 m))\", 0]\n\
         [initial]\nS = { position = \"3 m\", velocity = 0 }\n",
    );
    let start = derive(model(&text)).start().unwrap_or_else(|e| panic!("{e}"));
    let expected = derive(model(&text.replace("abs(S.position - 2 m)", "(S.position - 2 m)")));
    assert_eq!(start.a, expected.start().unwrap_or_else(|e| panic!("{e}")).a);
}

#[test]
fn a_limit_that_jumps_away_lets_go() {
    let text = block(
        "[signals.reach]\nstart = \"0 m\"\nwhen = [{ condition = \"t > 0.5 s\", value = \"1 m\" }]\n\
         [loads.push]\ntype = \"force\"\non = \"block\"\nvector = [10, 0]\n\
         [loads.gate]\ntype = \"stop\"\njoint = \"S\"\nmax = \"reach\"\n",
    );
    let (_, motion) = run(&text, 1.0, 1e-9);
    let last = motion.samples.last().expect("samples");
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    // At rest until the gate opens, then 5 m/s² for half a second.
    close("position", last.q[0], 0.5 * 5.0 * 0.25, within);
    let opened = times(&motion, |kind| matches!(kind, ChangeKind::Part(..)));
    assert_eq!(opened.len(), 1);
    close("when", opened[0], 0.5, within);
}

/// The floor takes the stone's fall and so slackens the rope; the rope, taut again, lifts the stone.
#[test]
fn stops_that_part_each_other_come_to_rest_together() {
    let text = r#"
[ground]
points = { high = [0, "0.4 m"] }
[bodies.hand]
mass = "1 kg"
[bodies.shadow]
mass = 0
[bodies.stone]
mass = "40 kg"
[joints]
way = { type = "prismatic", between = ["ground.high", "hand"], axis = [1, 0] }
along = { type = "prismatic", between = ["ground", "shadow"], axis = [1, 0] }
above = { type = "prismatic", between = ["shadow", "stone"], axis = [0, 1] }
rope = { type = "cylinder", between = ["hand", "stone"] }
[drives]
hand = { joint = "way", motion = "-0.5 m/s^2*t^2" }
[loads]
gravity = { type = "gravity", acceleration = [0, "-9.81 m/s^2"] }
floor = { type = "stop", joint = "above", min = 0 }
rope = { type = "stop", joint = "rope", max = "4.5 m" }
[initial]
above = { position = 0 }
rope = { position = "4.4999 m" }
along = { guess = { position = "4.48 m" }, velocity = 0 }
"#;
    let (mechanism, motion) = run(text, 0.5, 1e-9);
    let last = motion.samples.last().expect("samples");
    let at = |name: &str| last.q[crate::support::coordinate(&mechanism, name)];
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    close("above the floor", at("above_position"), 0.0, within);
    let behind = (4.5_f64 * 4.5 - 0.4 * 0.4).sqrt();
    close("behind the hand", at("along_position") - at("way_position"), behind, within);
    let hits = times(&motion, |kind| matches!(kind, ChangeKind::Hit(..)));
    assert!((1..40).contains(&hits.len()), "{} hits", hits.len());
}

/// A motion that comes back to the stop on which it began at rest only touches it, whatever rounding makes of the speed
/// there: an impact would shift all that follows by the root of the tolerance.
#[test]
fn a_stop_that_is_only_touched_takes_no_impact() {
    let text = |start: f64| {
        block(&format!(
            "[loads.spring]\ntype = \"force\"\non = \"block\"\nvector = [\"-2 N/m*x\", 0]\n[loads.stop]\n\
             type = \"stop\"\njoint = \"S\"\nmax = 1\nrestitution = 0\n[initial]\nx = {start}\n"
        ))
    };
    let (_, motion) = run(&text(1.0), 40.0, 1e-9);
    for sample in &motion.samples {
        close("touched", sample.q[0], sample.t.cos(), Within { relative: 0.0, absolute: 1e-6 });
    }
    // One that it reaches with a speed stops it there.
    let (_, motion) = run(&text(-1.01), 40.0, 1e-9);
    let end = motion.samples.last().expect("a sample");
    let hit = std::f64::consts::PI - (1.0_f64 / 1.01).acos();
    close("hit", end.q[0], (end.t - hit).cos(), Within { relative: 0.0, absolute: 1e-6 });
}
