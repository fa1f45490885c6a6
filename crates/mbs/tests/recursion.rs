//! The recursion in body frames against Lagrange's equations written out, and its size.

use bksim_expr::{Expr, Tape};
use bksim_mbs::assemble::{assemble, assemble_by};
use bksim_mbs::constraint::Source as RowSource;
use bksim_mbs::equations::{Notation, ReadingForm, proof};
use bksim_mbs::reaction::reactions;
use bksim_mbs::system::{Derivation, SymbolicSystem};
use bksim_model::file::{Source, read};
use bksim_model::{CoordinatePolicy, Model};

/// The arm of six joints that the literature counts operations on.
const PUMA: &str = include_str!("../../../tests/fixtures/puma-560.toml");
/// Every kind of joint in the tree, forwards and backwards, with frames that are turned against each
/// other, full tensors of inertia, springs, dampers, forces and torques.
const BRANCHED_ARM: &str = include_str!("../../../tests/fixtures/branched-arm.toml");

/// Bodies that turn about all axes, freely and in joints, forwards and backwards, in frames that are turned.
const TUMBLING_ARM: &str = include_str!("../../../tests/fixtures/tumbling-arm.toml");

fn model(text: &str) -> Model {
    let reading = read(&Source::new(text, "arm"));
    let faults = reading.diagnostics;
    reading.model.unwrap_or_else(|| panic!("{faults:?}"))
}

/// T, V, then M, h, ∂V/∂q, their sum with h and Q, then the reactions.
fn outputs(model: &Model, system: &SymbolicSystem) -> Vec<Expr> {
    let pool = &model.pool;
    let nq = system.coordinates().len();
    let mut outputs = vec![system.kinetic_energy, system.potential_energy];
    for (i, j) in (0..nq).flat_map(|i| (0..nq).map(move |j| (i, j))) {
        outputs.push(system.mass_matrix.get(i, j).unwrap_or(pool.zero()));
    }
    outputs.extend(&system.bias);
    outputs.extend(&system.potential_gradient);
    outputs.extend(&system.resistance);
    outputs.extend(system.inverse_dynamics(pool));
    outputs.extend(&system.applied_force);
    outputs.extend(reactions(model, system).iter().flat_map(|r| [r.force, r.moment].concat()));
    outputs
}

fn tape(model: &Model, system: &SymbolicSystem, outputs: &[Expr]) -> Tape {
    let coordinates = system.coordinates();
    let of = coordinates.iter().map(|c| c.q);
    let inputs = of.chain(coordinates.iter().map(|c| c.v)).chain(coordinates.iter().map(|c| c.a));
    let inputs: Vec<_> = [model.time].into_iter().chain(inputs).collect();
    let parameters: Vec<_> = model.parameters.iter().map(|p| p.symbol).collect();
    Tape::compile(&model.pool, outputs, &inputs, &parameters).expect("a tape")
}

fn values(model: &Model, tape: &Tape, shift: f64) -> Vec<f64> {
    let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let inputs: Vec<f64> =
        (0..tape.n_inputs()).map(|k| (1.7 * k as f64 + shift).sin() * 1.3).collect();
    let mut out = vec![0.0; tape.n_outputs()];
    tape.evaluate(&mut tape.workspace(&parameters), &inputs, &mut out);
    out
}

#[test]
fn both_ways_give_equal_equations_and_reactions() {
    for text in [PUMA, BRANCHED_ARM, TUMBLING_ARM] {
        let mut model = model(text);
        model.coordinates = CoordinatePolicy::Relative;
        let [lagrange, recursion] =
            [Derivation::Lagrange, Derivation::Recursion].map(|derivation| {
                let system = assemble_by(&model, derivation);
                tape(&model, &system, &outputs(&model, &system))
            });
        for shift in [0.3, 2.1, 4.4] {
            let [a, b] = [&lagrange, &recursion].map(|tape| values(&model, tape, shift));
            let scale = a.iter().map(|x| x.abs()).fold(1.0, f64::max);
            for (k, (a, b)) in a.iter().zip(&b).enumerate() {
                assert!((a - b).abs() <= 1e-12 * scale, "{}: output {k}: {a} {b}", model.name);
            }
        }
    }
}

#[test]
fn the_inverse_dynamics_of_an_arm_take_few_operations() {
    let model = model(PUMA);
    let system = assemble(&model);
    assert_eq!(system.derivation, Derivation::Recursion);
    let pool = &model.pool;
    let n = tape(&model, &system, &system.inverse_dynamics(pool)).operation_count();
    // Recursion by hand without the terms that vanish: 489.
    assert!(n <= 440, "{n} operations");
}

/// A chain of bars in space, about x and y in turn.
fn chain(n: usize) -> Model {
    let mut text = String::from("space = \"spatial\"\ncoordinates = \"relative\"\n");
    for k in 1..=n {
        let before = if k == 1 { "ground".to_owned() } else { format!("b{}.end", k - 1) };
        let axis = if k % 2 == 0 { "[1, 0, 0]" } else { "[0, 1, 0]" };
        let link = format!(
            "[bodies.b{k}]\nmass = 1\ninertia = [0.2, 0.3, 0.1]\ncom = [0, 0, 0.5]\n\
             points = {{ end = [0, 0, 1] }}\n\
             [joints.J{k}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{k}\"]\naxis = {axis}\n"
        );
        text.push_str(&link);
    }
    text += "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n";
    model(&text)
}

#[test]
fn a_chain_grows_by_the_same_work_and_text_with_every_link() {
    let size = |n: usize| {
        let model = chain(n);
        let system = assemble(&model);
        let form = ReadingForm::grouped(&model, &system);
        let text: usize =
            form.groups.iter().map(|g| model.pool.to_text(g.definition(&model.pool)).len()).sum();
        let n_operations =
            tape(&model, &system, &system.inverse_dynamics(&model.pool)).operation_count();
        (n_operations, text)
    };
    let [a, b, c] = [10, 20, 30].map(size);
    assert!(a.0 <= 900, "{} operations", a.0);
    assert!((c.0 - b.0).abs_diff(b.0 - a.0) <= (b.0 - a.0) / 50, "operations: {a:?}, {b:?}, {c:?}");
    assert!(c.1 - b.1 < (b.1 - a.1) * 5 / 4, "characters: {a:?}, {b:?}, {c:?}");
}

/// A free body with two chains of joints about oblique axes: turns, slides, screws, crosses, balls.
fn oblique_tree(n: usize) -> Model {
    let mut text = String::from(
        "space = \"spatial\"\ncoordinates = \"relative\"\n[bodies.base]\nmass = 3\ninertia = [1, 2, 3]\n\
         com = [100, 0.2, -3]\npoints = { L = [99, 0, -3], R = { at = [101, 0, -3], rpy = [0.2, 0.1, 0.3] } }\n\
         [joints.base_free]\ntype = \"free\"\nbetween = [\"ground\", \"base\"]\n",
    );
    let kinds = [
        "type = \"revolute\"\naxis = [1, 2, 2]",
        "type = \"spherical\"",
        "type = \"prismatic\"\naxis = [0, 1, 2]",
        "type = \"revolute\"\naxis = [0, 0, 1]",
        "type = \"universal\"\naxis = [2, 1, 0]\nsecond = [0, 0, 1]",
        "type = \"screw\"\naxis = [1, 0, 1]\nlead = 0.3",
        "type = \"cylindrical\"\naxis = [2, 2, 1]",
    ];
    for (side, k) in ["L", "R"].into_iter().flat_map(|side| (1..=n).map(move |k| (side, k))) {
        let before = match k {
            1 => format!("base.{side}"),
            _ => format!("{side}{}.end", k - 1),
        };
        text.extend([format!(
            "[bodies.{side}{k}]\nmass = 1\ninertia = [0.2, 0.3, 0.15, 0.01, 0.02, 0]\ncom = [0.1, 0, 0.5]\n\
             points = {{ end = [0.1, 0.2, 1] }}\n[joints.J{side}{k}]\n{}\n\
             between = [\"{before}\", \"{side}{k}\"]\n",
            kinds[(k - 1) % kinds.len()]
        )]);
    }
    text += "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n";
    model(&text)
}

/// Columns of M are what unit accelerations add to the forces of the inverse dynamics, which Newton and Euler's passes
/// give without it, in short trees and in long ones.
#[test]
fn the_mass_matrix_is_what_accelerations_add_to_the_inverse_dynamics() {
    for model in [oblique_tree(1), oblique_tree(8), chain(12)] {
        let system = assemble(&model);
        assert_eq!(system.derivation, Derivation::Recursion);
        let (pool, nq) = (&model.pool, system.coordinates().len());
        let forces = tape(&model, &system, &system.inverse_dynamics(pool));
        let entries: Vec<Expr> = (0..nq * nq)
            .map(|k| system.mass_matrix.get(k / nq, k % nq).unwrap_or(pool.zero()))
            .collect();
        let matrix = tape(&model, &system, &entries);
        let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
        let state: Vec<f64> = (0..=2 * nq).map(|k| (1.7 * k as f64 + 0.4).sin()).collect();
        let at = |tape: &Tape, accelerations: &[f64]| {
            let mut out = vec![0.0; tape.n_outputs()];
            let inputs = [&state[..], accelerations].concat();
            tape.evaluate(&mut tape.workspace(&parameters), &inputs, &mut out);
            out
        };
        let (m, rest) = (at(&matrix, &vec![0.0; nq]), at(&forces, &vec![0.0; nq]));
        let largest = m.iter().chain(&rest).fold(0.0, |most: f64, x| most.max(x.abs()));
        for j in 0..nq {
            let mut unit = vec![0.0; nq];
            unit[j] = 1.0;
            for (i, (with, without)) in at(&forces, &unit).iter().zip(&rest).enumerate() {
                let (expected, found) = (with - without, m[i * nq + j]);
                let off = (found - expected).abs();
                assert!(off < 1e-13 * largest, "{nq}: M[{i}, {j}] = {found}, not {expected}");
            }
        }
    }
}

/// In the axes of the ground an entry is two scalar products; what a link takes once does not count in long chains.
#[test]
fn the_mass_matrix_of_a_long_chain_takes_few_operations_an_entry() {
    let size = |n: usize| {
        let model = chain(n);
        let system = assemble(&model);
        let nq = system.coordinates().len();
        let below = (0..nq).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let entries: Vec<Expr> = below.filter_map(|(i, j)| system.mass_matrix.get(i, j)).collect();
        tape(&model, &system, &entries).operation_count()
    };
    let [half, whole] = [25, 50].map(size);
    let n_entries = 50 * 51 / 2 - 25 * 26 / 2;
    // From frame to frame it would be 30.
    assert!(whole - half < 22 * n_entries, "{half} and {whole} operations");
}

#[test]
fn the_recursion_is_read_with_names_and_certified() {
    let model = model(PUMA);
    let system = assemble(&model);
    let form = ReadingForm::grouped(&model, &system);
    let proof = proof(&model, &system, &form);
    assert!(proof.derivation.is_equal(), "{:?}", proof.derivation);
    assert!(proof.grouping.is_equal(), "{:?}", proof.grouping);
    let text = form.write(&model, Notation::Text);
    assert_eq!(text.equations[5], "N_b6_z");
    assert!(proof.work.shown.printed.total() < 1000, "{:?}", proof.work.shown);
}

#[test]
fn quaternions_are_certified_at_every_length() {
    let model = model(TUMBLING_ARM);
    let system = assemble(&model);
    assert_eq!(system.derivation, Derivation::Recursion);
    let form = ReadingForm::grouped(&model, &system);
    let proof = proof(&model, &system, &form);
    assert!(proof.derivation.is_equal(), "{:?}", proof.derivation);
    assert!(proof.grouping.is_equal(), "{:?}", proof.grouping);
    // Each quaternion keeps its length, and no force of the motion has a part along it.
    let lengths = &system.constraints[system.constraints.len() - 3..];
    assert!(lengths.iter().all(|row| matches!(row.source, RowSource::Quaternion(_))));
    let pool = &model.pool;
    for (rows, turning) in lengths.iter().zip(&system.kinematics.turnings) {
        assert_eq!(rows.direction, "norm");
        let parts = turning.first..turning.first + 4;
        let e = turning.quaternion.0;
        let along = |of: &[Expr]| {
            let products = parts.clone().zip(e).map(|(i, e)| pool.mul(of[i], e));
            pool.sum(products.collect::<Vec<_>>())
        };
        for forces in [&system.potential_gradient, &system.applied_force] {
            assert!(pool.certificate(along(forces), pool.zero()).is_equal());
        }
    }
}

/// A planar chain of `n` bars in relative coordinates, with a damped spring over every `span` of them.
fn braced_chain(n: usize, span: usize) -> Model {
    let mut text =
        String::from("coordinates = \"relative\"\n[ground]\npoints = { P0 = [0.1, 0.2] }\n");
    for k in 1..=n {
        let before = if k == 1 { "ground.P0".to_owned() } else { format!("b{}.P{}", k - 1, k - 1) };
        text.extend([format!(
            "[bodies.b{k}]\nmass = 1.25\ninertia = 0.1\ncom = [0.5, 0.125]\npoints = {{ P{k} = [1.0625, 0.375] }}\n\
             [joints.J{k}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{k}\"]\n"
        )]);
    }
    for k in (span..=n).step_by(span) {
        let from = if k == span { "ground.P0".to_owned() } else { format!("b{0}.P{0}", k - span) };
        text.extend([format!(
            "[loads.s{k}]\ntype = \"spring\"\nbetween = [\"{from}\", \"b{k}.P{k}\"]\n\
             stiffness = 100.5\nlength = 0.75\ndamping = 2.25\n"
        )]);
    }
    model(&text)
}

/// Multiplied out, the power of a damper is a product of three sums: its terms would grow with the cube of the links
/// between its ends, and with them time and memory.
#[test]
fn damped_springs_take_operations_and_nodes_in_proportion_to_their_links() {
    let size = |n: usize, span: usize| {
        let model = braced_chain(n, span);
        let system = assemble(&model);
        assert_eq!(system.derivation, Derivation::Lagrange);
        [tape(&model, &system, &system.applied_force).operation_count(), model.pool.len()]
    };
    // One spring over all links: no more than the square of what one link takes.
    let [short, long] = [8, 16].map(|n| size(n, n));
    assert!(long[0] <= 4 * short[0] && long[0] < 2000, "operations: {short:?}, {long:?}");
    assert!(long[1] <= 5 * short[1] && long[1] < 60_000, "nodes: {short:?}, {long:?}");
    // Springs over two links each: every pair adds as much as the last.
    let [a, b, c] = [4, 6, 8].map(|n| size(n, 2));
    let [first, second] = [b[0] - a[0], c[0] - b[0]];
    assert!(second <= first + first / 4, "operations: {a:?}, {b:?}, {c:?}");
}
