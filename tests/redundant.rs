//! The parallelogram: redundant joints, their reactions, and its change points.

mod support;

use bksim::mbs::mobility::mobility;
use bksim::{Mechanism, Motion};
use support::{
    Probe, Within, all_close, brief, derive, example, example_text, messages, model, reaction,
    solve,
};

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

#[test]
fn change_point_probe() {
    for rate in [5.0, 9.0, 12.0, 20.0] {
        for three in [true, false] {
            for rtol in [1e-4, 1e-6, 1e-8, 1e-10] {
                let mut model = if three { example("parallelogram") } else { two_cranks().model };
                let pool = &model.pool;
                let value = pool.float(rate);
                for i in &mut model.initial {
                    if i.name == "A.rate" {
                        i.value = value;
                    }
                }
                (model.solve.rtol, model.solve.atol) = (rtol, rtol * 1e-2);
                let mechanism = derive(model);
                let probe = Probe::new(&mechanism, &["A_angle", "B_angle", "A_angle + P_angle"]);
                match mechanism.solve() {
                    Ok(motion) => {
                        let worst = motion
                            .samples
                            .iter()
                            .map(|s| {
                                let [q, ..] = probe.at(s);
                                (q[0] - q[1]).abs().max(q[2].abs())
                            })
                            .fold(0.0, f64::max);
                        let last = motion.samples.last().expect("one");
                        let finite =
                            motion.samples.iter().all(|s| s.a.iter().all(|x| x.is_finite()));
                        eprintln!(
                            "rate {rate} three {three} rtol {rtol:.0e}: end, {} steps, {} rejected, A {:.2}, skew {worst:.1e}, energy {:.1e}, finite {finite} {}",
                            motion.summary.stats.n_step,
                            motion.summary.stats.n_reject,
                            probe.at(last)[0][0],
                            motion.summary.energy.worst_error / motion.summary.energy.scale,
                            brief(&last.lambda)
                        );
                    }
                    Err(e) => {
                        eprintln!("rate {rate} three {three} rtol {rtol:.0e}: {}", messages(&e.0))
                    }
                }
            }
        }
    }
}
