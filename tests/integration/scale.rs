//! Mechanisms of many links: what they take grows with their length, and they move as they should.

use std::fmt::Write;

use crate::support::large::{Coordinates, LINK, REST, chain, windows};
use crate::support::{Within, all_close, at, close, coordinate, derive, model, path, solve};
use bksim::dae::System;
use bksim::sim::formulate::formulate;
use bksim::sim::hybrid::ChangeKind;
use bksim::{Mechanism, Motion};
use serde_json::Value;

/// A mechanism from its text, to be run to `t_end` at a tolerance.
fn mechanism(text: &str, t_end: f64, rtol: f64) -> Mechanism {
    let mut model = model(text);
    model.solve.t_end = t_end;
    model.solve.every = Some(0.1);
    model.solve.rtol = rtol;
    model.solve.atol = rtol;
    derive(model)
}

/// Nodes of the pool with everything derived, entries of M, of G, and of the iteration matrix.
fn sizes(text: &str) -> [usize; 4] {
    let mechanism = derive(model(text));
    let system = &mechanism.system;
    let equations = formulate(&mechanism.model, system, mechanism.model.solve.formulation);
    let equations = equations.expect("the equations compile");
    [
        mechanism.model.pool.len(),
        system.mass_matrix.entries().count(),
        system.constraint_jacobian.entries().count(),
        equations.at(&mechanism.parameters, &[]).pattern().n_entries(),
    ]
}

#[test]
fn expressions_and_matrices_grow_with_the_number_of_links() {
    type Text = fn(usize, Coordinates) -> String;
    let families: [(&str, Text, Coordinates); 3] = [
        ("chain", chain, Coordinates::Absolute),
        ("windows", windows, Coordinates::Absolute),
        ("windows along a tree", windows, Coordinates::Relative),
    ];
    for (name, text, coordinates) in families {
        let [short, middle, long] = [100, 200, 400].map(|n| sizes(&text(n, coordinates)));
        for what in 0..4 {
            let first = (middle[what] - short[what]) as f64;
            let second = (long[what] - middle[what]) as f64;
            let all = (short[what], middle[what], long[what]);
            let ratio = second / first;
            assert!(
                (1.95..2.05).contains(&ratio),
                "{name}, size {what}: {all:?} for 100, 200, 400"
            );
        }
    }
}

#[test]
fn a_chain_of_ten_links_follows_the_reference() {
    let mechanism = mechanism(&chain(10, Coordinates::Absolute), 1.0, 1e-9);
    let motion = solve(&mechanism);
    let file = path("tests/data/chain-10.json");
    let text = std::fs::read_to_string(file).expect("the reference is there");
    let data: Value = serde_json::from_str(&text).expect("the reference is JSON");
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let columns: Vec<usize> = list(&data["coordinates"])
        .iter()
        .map(|name| coordinate(&mechanism, name.as_str().expect("a name")))
        .collect();
    for row in list(&data["rows"]) {
        let t = row["t"].as_f64().expect("a time");
        let numbers = |key: &str| -> Vec<f64> {
            list(&row[key]).iter().map(|x| x.as_f64().expect("a number")).collect()
        };
        let sample = at(&motion, t);
        let sorted = |values: &[f64]| -> Vec<f64> { columns.iter().map(|&i| values[i]).collect() };
        let within = |absolute| Within { relative: absolute, absolute };
        all_close(&format!("q at {t}"), &sorted(&sample.q), &numbers("q"), within(1e-8));
        all_close(&format!("v at {t}"), &sorted(&sample.v), &numbers("v"), within(1e-7));
        all_close(&format!("a at {t}"), &sorted(&sample.a), &numbers("a"), within(1e-6));
        all_close(&format!("λ at {t}"), &sample.lambda, &numbers("lambda"), within(1e-6));
    }
}

/// Energy and constraints over a run, relative to what moves.
fn check_balance(motion: &Motion) {
    let energy = &motion.summary.energy;
    assert!(motion.summary.reached_end && energy.scale > 0.0);
    assert!(energy.worst_error < 1e-7 * energy.scale, "{energy:?}");
    for sample in &motion.samples {
        assert!(sample.position_residual[1] < 1e-10, "{:e} m", sample.position_residual[1]);
        assert!(sample.velocity_residual[1] < 1e-9, "{:e} m/s", sample.velocity_residual[1]);
    }
}

#[test]
fn a_hundred_links_start_like_ten_and_keep_their_energy() {
    let [short, long] = [10, 100].map(|n| {
        let mechanism = mechanism(&chain(n, Coordinates::Absolute), 0.2, 1e-8);
        solve(&mechanism)
    });
    // In line along x, what happens at one end of the chain fades by 2 − √3 with every link.
    let within = Within { relative: 0.0, absolute: 1e-7 };
    all_close("accelerations", &long.start.a[..15], &short.start.a[..15], within);
    all_close("multipliers", &long.start.lambda[..10], &short.start.lambda[..10], within);
    check_balance(&long);
}

#[test]
fn a_hundred_windows_lean_as_one_parallelogram() {
    const N: f64 = 100.0;
    const G: f64 = 9.81;
    // ½ A ω² + B g cos θ is constant, θ the angle of all uprights from the vertical.
    let (a, b) = ((N + 1.0) / 3.0 + N, 0.5 * (3.0 * N + 1.0));
    for coordinates in [Coordinates::Relative, Coordinates::Absolute] {
        let mechanism = mechanism(&windows(100, coordinates), 0.5, 1e-8);
        let motion = solve(&mechanism);
        check_balance(&motion);
        let prefix = if coordinates == Coordinates::Relative { "g" } else { "u" };
        let upright = |i: usize| coordinate(&mechanism, &format!("{prefix}{i}_angle"));
        let last = motion.samples.last().expect("an end");
        let (angle, rate) = (last.q[upright(0)], last.v[upright(0)]);
        let first_integral = 0.5 * a * rate * rate + b * G * angle.sin();
        let within = Within { relative: 1e-7, absolute: 0.0 };
        close("the first integral", first_integral, 0.5 * a + b * G, within);
        assert!(rate < -1.5, "the windows fall: {rate} rad/s");
        let angles: Vec<f64> = (0..=100).map(|i| last.q[upright(i)]).collect();
        let within = Within { relative: 0.0, absolute: 1e-7 };
        all_close("all angles", &angles, &[angle; 101], within);
    }
}

/// `n` links side by side, each on a pivot of its own and level on a stop, but for the first, which starts
/// above its stop by an angle in rad.
fn shelves(n: usize, angle: f64) -> String {
    let mut text = "coordinates = \"absolute\"\n[ground]\npoints = {".to_owned();
    let mut add = |arguments: std::fmt::Arguments<'_>| {
        text.write_fmt(arguments).expect("text takes everything");
    };
    for i in 1..=n {
        add(format_args!(" P{i} = [\"{i} m\", 0]{}", if i < n { "," } else { " }\n" }));
    }
    for i in 1..=n {
        add(format_args!("[bodies.b{i}]\n{LINK}"));
        add(format_args!("[joints.j{i}]\ntype = \"revolute\"\n"));
        add(format_args!("between = [\"ground.P{i}\", \"b{i}.O\"]\n"));
        add(format_args!("[loads.s{i}]\ntype = \"stop\"\njoint = \"j{i}\"\nmin = 0\n"));
    }
    add(format_args!("[initial]\n"));
    for i in 1..=n {
        let angle = if i == 1 { angle } else { 0.0 };
        add(format_args!("j{i} = {{ angle = \"{angle} rad\", rate = 0 }}\n"));
    }
    text + REST
}

/// Beyond the size of dense decompositions: rank, modes and the impact go by sparse elimination.
#[test]
fn a_link_falls_onto_its_stop_among_many_on_theirs() {
    const N: usize = 100;
    const G: f64 = 9.81;
    const ANGLE: f64 = 0.01;
    let mut model = model(&shelves(N, ANGLE));
    model.solve.t_end = 0.05;
    model.solve.every = Some(0.025);
    (model.solve.rtol, model.solve.atol) = (1e-8, 1e-8);
    let mechanism = derive(model);
    let motion = solve(&mechanism);

    // m g L/2 sin θ₀ is lost where 1/3 θ″ = −g/2 cos θ ends, which differs from −g/2 by θ²/2.
    let hits: Vec<f64> = motion
        .summary
        .changes
        .iter()
        .filter(|change| matches!(change.kind, ChangeKind::Hit(..)))
        .map(|change| change.t)
        .collect();
    let [hit] = hits[..] else { panic!("one link falls: {hits:?}") };
    let fall = (4.0 * ANGLE / (3.0 * G)).sqrt();
    close("hit", hit, fall, Within { relative: 1e-4, absolute: 0.0 });
    let within = Within { relative: 1e-7, absolute: 0.0 };
    close("loss", motion.summary.energy.impacts, -0.5 * G * ANGLE.sin(), within);

    // Before and after, every stop but the first bears half the weight of its link.
    let [first, last] =
        [motion.samples.first(), motion.samples.last()].map(|s| s.expect("samples"));
    for (k, contact) in mechanism.system.contacts.iter().enumerate() {
        let within = Within { relative: 1e-9, absolute: 1e-9 };
        let borne = if k == 0 { 0.0 } else { 0.5 * G };
        close("moment before", first.lambda[contact.row], borne, within);
        close("moment after", last.lambda[contact.row], 0.5 * G, within);
    }
}
