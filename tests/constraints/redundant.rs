//! The parallelogram: redundant joints, their reactions, and its change points.

use std::f64::consts::{PI, TAU};

use crate::support::{
    Probe, Within, all_close, close, derive, example, example_text, messages, model, reaction,
    solve,
};
use bksim::Mechanism;
use bksim::dae::Control;
use bksim::model::Model;
use bksim::sim::mobility::mobility;
use bksim::sim::run::Sample;

/// The parallelogram without its third crank.
fn two_cranks() -> Mechanism {
    let text = example_text("parallelogram");
    let third = ["[bodies.crank3]", "[joints.C]", "[joints.R]"];
    let kept = text.split("\n\n").filter(|block| !third.iter().any(|head| block.starts_with(head)));
    let text = kept.collect::<Vec<_>>().join("\n\n");
    let lines = text.lines().filter(|line| !line.starts_with("C = { guess"));
    derive(model(&lines.collect::<Vec<_>>().join("\n")))
}

/// The crank without mass would change nothing; so the third crank's share is taken out by hand:
/// crank 2 gets the mass of two.
fn heavy_crank_instead_of_third() -> Mechanism {
    let mut mechanism = two_cranks().model;
    let pool = &mechanism.pool;
    let two = pool.int(2);
    let crank = mechanism.bodies.iter_mut().find(|b| b.name == "crank2").expect("crank2");
    crank.mass = pool.mul(two, crank.mass);
    crank.inertia.moments[2] = pool.mul(two, crank.inertia.moments[2]);
    derive(mechanism)
}

#[test]
fn three_cranks_count_as_rigid_yet_move_and_their_reactions_are_not_unique() {
    let mechanism = derive(example("parallelogram"));
    let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
    let count = mobility(&mechanism.model, &mechanism.system, &start);
    assert_eq!((count.gruebler, count.mobility), (0, 1), "{count:?}");
    assert_eq!(count.n_constraints - count.rank, 1, "{count:?}");
    assert!(!count.redundant.is_empty() && !start.not_unique_rows().is_empty(), "{count:?}");

    let unique = heavy_crank_instead_of_third();
    let start = unique.start().unwrap_or_else(|e| panic!("{e}"));
    let count = mobility(&unique.model, &unique.system, &start);
    assert_eq!((count.gruebler, count.mobility), (1, 1), "{count:?}");
    assert!(count.redundant.is_empty(), "{count:?}");
}

#[test]
fn the_third_crank_changes_neither_the_motion_nor_the_sum_of_the_reactions() {
    let mechanisms = [derive(example("parallelogram")), heavy_crank_instead_of_third()];
    let motions = mechanisms.each_ref().map(solve);
    let probes = mechanisms.each_ref().map(|m| Probe::new(m, &["A_angle", "B_angle"]));
    let ground: [&[&str]; 2] = [&["A", "B", "C"], &["A", "B"]];
    let within = Within { relative: 1e-6, absolute: 1e-6 };
    for (a, b) in motions[0].samples.iter().zip(&motions[1].samples) {
        let what = format!("t = {:.2}", a.t);
        let (found, expected) = (probes[0].at(a), probes[1].at(b));
        all_close(&format!("{what}: angles"), &found[0], &expected[0], within);
        all_close(&format!("{what}: rates"), &found[1], &expected[1], within);
        let sums = [(0, a), (1, b)].map(|(k, sample)| {
            let mut sum = [0.0; 2];
            for joint in ground[k] {
                let six = reaction(&mechanisms[k], sample, joint);
                sum = [sum[0] + six[0], sum[1] + six[1]];
            }
            sum
        });
        all_close(&format!("{what}: on the ground"), &sums[0], &sums[1], within);
    }
}

/// The mechanism thrown at a rate, with which it turns over: at A = 0 and π all links are collinear,
/// and the motion could go on as an antiparallelogram.
fn thrown(mut model: Model, rate: f64, rtol: f64) -> Mechanism {
    let value = model.pool.float(rate);
    let stated = model.initial.iter_mut().find(|initial| initial.name == "A.rate");
    stated.expect("the rate is stated").value = value;
    (model.solve.rtol, model.solve.atol) = (rtol, rtol * 1e-2);
    derive(model)
}

#[test]
fn change_points_are_passed_as_a_parallelogram() {
    for rtol in [1e-6, 1e-8, 1e-10] {
        // 5 rad/s swing through one change point and back; more turn over and over.
        for rate in [5.0, 9.0, 20.0] {
            let mechanism = thrown(example("parallelogram"), rate, rtol);
            let motion = solve(&mechanism);
            let probe = Probe::new(&mechanism, &["A_angle", "B_angle", "A_angle + P_angle"]);
            let what = format!("{rate} rad/s, rtol {rtol:.0e}");
            for sample in &motion.samples {
                let [q, ..] = probe.at(sample);
                let at = format!("{what}, t = {:.2}", sample.t);
                let within = Within { relative: 0.0, absolute: 1e-9 };
                close(&format!("{at}: cranks stay parallel"), q[1], q[0], within);
                close(&format!("{at}: the beam stays level"), q[2], 0.0, within);
                let numbers = [&sample.a, &sample.lambda];
                assert!(numbers.into_iter().flatten().all(|x| x.is_finite()), "{at}: {sample:?}");
            }
            let energy = motion.summary.energy.worst_error / motion.summary.energy.scale;
            assert!(energy < 10.0 * rtol, "{what}: energy off by {energy:.1e} of its scale");
            // All links are collinear at every half turn of the cranks, and only there.
            let halves = |sample: &Sample| (probe.at(sample)[0][0] / PI).floor();
            let turns = motion.samples.windows(2);
            let n_passed: f64 = turns.map(|two| (halves(&two[1]) - halves(&two[0])).abs()).sum();
            let poses = &motion.summary.singular_poses;
            assert_eq!(poses.len() as f64, n_passed, "{what}: {poses:?}");
            let turned = motion.samples.last().expect("samples").q[0].abs();
            assert_eq!(turned > TAU, rate > 6.0, "{what}: A turned to {turned}");
        }
    }
}

#[test]
fn a_run_that_cannot_pass_a_change_point_says_so_and_keeps_what_it_has() {
    // Two cranks at a tolerance that rounding near the collinear pose may not allow.
    for rate in [9.0, 20.0] {
        let mechanism = thrown(two_cranks().model, rate, 1e-9);
        let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
        let simulation = mechanism.simulation().unwrap_or_else(|e| panic!("{e}"));
        let mut kept = Vec::new();
        let mut keep = |sample: &bksim::sim::run::Sample| {
            kept.push(sample.clone());
            Control::Continue
        };
        let outcome = simulation.run(&start, &mut keep, &|| false);
        assert!(kept.iter().all(|s| s.q.iter().all(|x| x.is_finite())), "{rate} rad/s");
        match outcome {
            Ok(summary) => assert!(summary.reached_end && kept.len() == 301, "{rate} rad/s"),
            Err(failure) => {
                let diagnostic = simulation.diagnose(&failure);
                let code = diagnostic.code.0;
                assert!(
                    ["R003", "R005"].contains(&code),
                    "{rate} rad/s: {}",
                    messages(&[diagnostic])
                );
                assert_eq!(kept.len(), failure.summary.n_samples, "{rate} rad/s: samples lost");
            }
        }
    }
}

/// Two pins and a guide hold each other, and rub: friction there is any up to its limit, the smallest one with which all is in
/// balance, by the reactions that it goes with. So a pin without friction has no moment.
#[test]
fn friction_in_what_cannot_move_is_in_balance_with_its_own_reactions() {
    let text = |mu: f64, force: f64| {
        format!(
            "[bodies]\narm = {{ mass = 3, inertia = 0.3, com = [0.2, 0], points = {{ P = [0.6, 0.5] }} }}\n\
             shoe = {{ mass = 2, inertia = 0.2, points = {{ A = [0, 0], B = [0.9, -0.7] }} }}\n\
             [ground]\npoints = {{ F = [1.5, -0.2] }}\n\
             [joints]\npin = {{ type = \"revolute\", between = [\"ground\", \"arm\"] }}\n\
             slide = {{ type = \"prismatic\", between = [\"arm.P\", \"shoe.A\"], axis = [0.8, 0.6] }}\n\
             foot = {{ type = \"revolute\", between = [\"ground.F\", \"shoe.B\"] }}\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             rub = {{ type = \"friction\", joint = \"pin\", mu = {mu}, radius = \"20 mm\" }}\n\
             grip = {{ type = \"friction\", joint = \"slide\", force = {force} }}\n\
             [solve]\nt_end = 0.1\nevery = 0.05\n"
        )
    };
    for (mu, force) in [(0.4, 2.0), (0.04, 2.0), (0.4, 20.0), (0.04, 0.2)] {
        let mechanism = derive(model(&text(mu, force)));
        for sample in &solve(&mechanism).samples {
            let [pin, foot] = ["pin", "foot"].map(|name| reaction(&mechanism, sample, name));
            assert!(foot[5].abs() < 1e-12, "mu = {mu}, {force} N: {} N m in a pin", foot[5]);
            let off = pin[1] + foot[1] - 5.0 * 9.81;
            assert!(off.abs() < 1e-10, "mu = {mu}, {force} N: {off} N are missing");
        }
    }
}
