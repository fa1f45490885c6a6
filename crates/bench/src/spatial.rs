//! Arms, chains and trees in space against Pinocchio: M, h and g at random states, and the time of an evaluation.

use bksim::Mechanism;
use bksim::expr::{Expr, Jit, Runner, SymbolId, Tape};
use bksim::model::{JointKind, LoadKind, Model, Vector};
use serde_json::{Value, json};

use crate::context::Context;
use crate::error::BenchError;
use crate::models;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::{Samples, cpu_time, repeat_short};

/// Largest difference, relative to the largest entry of M, of h and of g.
const TOLERANCE: f64 = 1e-10;
/// Random states of each mechanism.
const N_STATES: usize = 8;
/// Calls of the peer in one sample.
const N_CALLS: usize = 2000;
/// The arm whose equations the literature counts.
pub(crate) const PUMA: &str = include_str!("../../../tests/fixtures/puma-560.toml");

/// Numbers between −1 and 1, the same in each run: a linear congruence.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn three(&mut self, size: f64) -> [f64; 3] {
        [0; 3].map(|_| size * self.next())
    }
}

/// Bodies on revolutes about any axes, in a chain or in a tree.
fn bodies_in_space(n: usize, is_tree: bool, random: &mut Random) -> String {
    let mut text = "space = \"spatial\"\ncoordinates = \"relative\"\n\
                    [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n"
        .to_owned();
    let mut joints = String::new();
    let mut parents = Vec::with_capacity(n);
    for i in 1..=n {
        let [com, place, axis] = [0.2, 0.5, 1.0].map(|size| random.three(size));
        let moments = random.three(0.2).map(|x| 1.0 + x);
        let products = random.three(0.1);
        let mass = 1.5 + random.next();
        // The one before it, or in a tree a carrier of that: then each branch is whole before the next begins, as
        // the peer asks.
        let mut before = i - 1;
        while is_tree && before > 1 && random.next() > -0.5 {
            before = parents[before - 1];
        }
        parents.push(before);
        let from = if i == 1 { "ground".to_owned() } else { format!("b{before}.P") };
        text.extend([format!(
            "[bodies.b{i}]\nmass = {mass:?}\ncom = {com:?}\n\
             inertia = [{:?}, {:?}, {:?}, {:?}, {:?}, {:?}]\npoints.O = [0, 0, 0]\n",
            moments[0], moments[1], moments[2], products[0], products[1], products[2]
        )]);
        text.extend([format!("points.P = {place:?}\n")]);
        joints.extend([format!(
            "[joints.j{i}]\ntype = \"revolute\"\nbetween = [\"{from}\", \"b{i}.O\"]\n\
             axis = {axis:?}\ncoordinate = \"q{i}\"\n"
        )]);
    }
    text + &joints
}

/// M, h and g, and the forces of inverse dynamics, as functions of q, v and v̇.
struct Functions {
    all: Tape,
    inverse: Tape,
    mass: Tape,
    n: usize,
}

impl Functions {
    fn of(mechanism: &Mechanism) -> Self {
        let (pool, system) = (&mechanism.model.pool, &mechanism.system);
        let n = system.coordinates().len();
        // In the order of the bodies, whose coordinates are q1, q2, …
        let place = |i: usize| {
            let name = format!("q{}", i + 1);
            system
                .coordinates()
                .iter()
                .position(|c| c.name == name)
                .expect("a coordinate of this name")
        };
        let order: Vec<usize> = (0..n).map(place).collect();
        let mut mass = vec![pool.zero(); n * n];
        for i in 0..n {
            for &(k, entry) in system.mass_matrix.row(order[i]) {
                let j = order.iter().position(|&place| place == k).expect("each has a place");
                mass[i * n + j] = entry;
            }
        }
        let pick = |of: fn(&bksim::mbs::coordinate::Coordinate) -> SymbolId| {
            order.iter().map(move |&k| of(&system.coordinates()[k]))
        };
        let ordered = |values: &[Expr]| order.iter().map(|&k| values[k]).collect::<Vec<_>>();
        let inputs: Vec<SymbolId> =
            pick(|c| c.q).chain(pick(|c| c.v)).chain(pick(|c| c.a)).collect();
        let parameters: Vec<SymbolId> =
            mechanism.model.parameters.iter().map(|p| p.symbol).collect();
        let tape = |outputs: &[Expr]| {
            Tape::compile(pool, outputs, &inputs, &parameters).expect("functions of the motion")
        };
        let lower: Vec<Expr> = (0..n).flat_map(|i| mass[i * n..=i * n + i].to_vec()).collect();
        let all =
            [mass.clone(), ordered(&system.bias), ordered(&system.potential_gradient)].concat();
        let inverse = tape(&ordered(&system.inverse_dynamics(pool)));
        Self { all: tape(&all), inverse, mass: tape(&lower), n }
    }
}

/// The bodies as the peer takes them, in the order of the coordinates.
pub(crate) fn description(mechanism: &Mechanism) -> (Vec<Value>, [f64; 3]) {
    let model = &mechanism.model;
    let value = |e: Expr| value(model, &mechanism.parameters, e);
    let three = |v: &Vector| v.map(value);
    let bodies = model.bodies.iter().enumerate().skip(1).map(|(idx, body)| {
        let carrying = model.joints.iter().find(|joint| joint.successor.body.0 == idx);
        let joint = carrying.expect("each body hangs on a joint");
        assert!(joint.kind == JointKind::Revolute, "a tree of revolutes");
        let from = &model.bodies[joint.predecessor.body.0];
        let place = joint.predecessor.point.map(|point| three(&from.points[point.0].position));
        let inertia = [three(&body.inertia.moments), three(&body.inertia.products)].concat();
        json!({
            "parent": joint.predecessor.body.0,
            "place": place.unwrap_or_default(),
            "axis": three(&joint.axis),
            "mass": value(body.mass),
            "com": three(&body.com),
            "inertia": inertia,
        })
    });
    let gravity = model.loads.iter().find_map(|load| match &load.kind {
        LoadKind::Gravity { acceleration } => Some(three(acceleration)),
        _ => None,
    });
    (bodies.collect(), gravity.unwrap_or_default())
}

fn value(model: &Model, parameters: &[f64], e: Expr) -> f64 {
    let of = |symbol| {
        let place = model.parameters.iter().position(|p| p.symbol == symbol)?;
        Some(parameters[place])
    };
    model.pool.evaluate(e, &of).expect("a number of parameters")
}

/// Compares and times all mechanisms.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let mut random = Random(1);
    let sizes: &[usize] = if context.effort.is_quick { &[3] } else { &[10, 30, 100] };
    let mut cases = vec![("PUMA 560".to_owned(), PUMA.to_owned())];
    for &n in sizes {
        cases.push((format!("chain of {n}"), bodies_in_space(n, false, &mut random)));
        cases.push((format!("tree of {n}"), bodies_in_space(n, true, &mut random)));
    }
    let mut report = Report::new("spatial", "Arms, chains and trees in space");
    let head =
        ["", "derived in", "operations", "difference", "inverse dynamics", "ratio", "M", "ratio"];
    let mut table = Table::new(head);
    let mut worst = 0.0_f64;
    for (name, text) in &cases {
        let model = models::model(text, name)?;
        let began = cpu_time();
        let mechanism = Mechanism::derive(model, Vec::new())
            .map_err(|e| BenchError::Model { name: name.clone(), message: e.to_string() })?;
        let functions = Functions::of(&mechanism);
        let derived = cpu_time() - began;
        let n = functions.n;
        let states: Vec<[Vec<f64>; 3]> = (0..N_STATES)
            .map(|_| [3.0, 2.0, 5.0].map(|size| (0..n).map(|_| size * random.next()).collect()))
            .collect();
        let peer = {
            let (bodies, gravity) = description(&mechanism);
            let runs = if context.effort.is_quick { 1 } else { 10 };
            context.peers.python(
                "spatial_pinocchio",
                &json!({ "bodies": bodies, "gravity": gravity, "states": states,
                         "calls": N_CALLS, "runs": runs }),
            )
        };
        let ours = [&functions.inverse, &functions.mass]
            .map(|tape| timed(context, tape, &mechanism.parameters, &states));
        let theirs = |key: &str| match &peer {
            Ok(value) => {
                let times = value[key].as_array().into_iter().flatten().filter_map(Value::as_f64);
                Samples::new(times.collect()).minimum()
            }
            Err(_) => f64::NAN,
        };
        let ratios = [ours[0] / theirs("inverse_s"), ours[1] / theirs("mass_s")];
        let difference = match &peer {
            Ok(value) => difference(&functions, &mechanism.parameters, &states, &value["found"]),
            Err(missing) => {
                report.notes.push(format!("{name}, Pinocchio: {missing}"));
                f64::NAN
            }
        };
        worst = if difference.is_nan() { f64::NAN } else { worst.max(difference) };
        let n_operations = functions.inverse.operation_count();
        report.numbers.insert(
            name.clone(),
            json!({ "difference": difference, "derived_s": derived, "inverse_s": ours[0],
                    "mass_s": ours[1], "ratios": ratios, "n_operations": n_operations }),
        );
        table.push([
            name.clone(),
            seconds(derived),
            n_operations.to_string(),
            format!("{difference:.1e}"),
            seconds(ours[0]),
            ratio(ratios[0]),
            seconds(ours[1]),
            ratio(ratios[1]),
        ]);
    }
    report.tables.push(table);
    report.checks.push(Check::at_most("largest difference from Pinocchio", worst, TOLERANCE));
    report.notes.push("the peer is called from Python, which adds about a microsecond".to_owned());
    Ok(report)
}

/// The largest difference of M, h and g, each relative to its largest entry.
fn difference(
    functions: &Functions,
    parameters: &[f64],
    states: &[[Vec<f64>; 3]],
    found: &Value,
) -> f64 {
    let n = functions.n;
    let mut workspace = functions.all.workspace(parameters);
    let mut out = vec![0.0; n * n + 2 * n];
    let mut worst = 0.0_f64;
    for (state, found) in states.iter().zip(found.as_array().into_iter().flatten()) {
        functions.all.evaluate(&mut workspace, &state.concat(), &mut out);
        let (mass, rest) = out.split_at(n * n);
        let (bias, gradient) = rest.split_at(n);
        for (ours, theirs) in
            [mass, bias, gradient].into_iter().zip(found.as_array().into_iter().flatten())
        {
            let flat: Vec<f64> = numbers(theirs);
            assert_eq!(flat.len(), ours.len(), "numbers of the peer");
            let scale = flat.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let off = ours.iter().zip(&flat).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            worst = worst.max(off / scale);
        }
    }
    worst
}

/// The numbers of arrays in arrays.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        value => value.as_f64().into_iter().collect(),
    }
}

/// Seconds of an evaluation by machine code, or by the interpreter where there is none.
fn timed(context: &Context, tape: &Tape, parameters: &[f64], states: &[[Vec<f64>; 3]]) -> f64 {
    let points: Vec<Vec<f64>> = states.iter().map(|state| state.concat()).collect();
    let mut out = vec![0.0; tape.n_outputs()];
    let mut workspace = tape.workspace(parameters);
    let runner = Runner::new(tape.clone(), Jit::On);
    let samples = repeat_short(context.effort, |n| {
        for k in 0..n {
            runner.evaluate(&mut workspace, &points[k % points.len()], &mut out);
        }
    });
    samples.minimum()
}
