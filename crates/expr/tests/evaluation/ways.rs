//! All ways to evaluate a tape, held against the interpreter.

use bksim_expr::{Batch, Jit, LaneRunner, Runner, Tape};

/// Values of all outputs at each point, by one evaluator at one set of parameters.
type Evaluator = fn(&Tape, &[f64], &[Vec<f64>]) -> Vec<Vec<f64>>;

const EVALUATORS: &[(&str, Evaluator)] = &[
    ("batch", in_one_batch),
    ("batches of three", in_batches_of_three),
    ("a batch that is machine code", in_a_long_batch),
    ("growing batches of machine code", in_growing_batches),
    ("runner", by_runner),
    ("four points, interpreted", |tape, parameters, points| {
        in_lanes::<4>(tape, Jit::Off, parameters, points)
    }),
    ("one lane", |tape, parameters, points| in_lanes::<1>(tape, Jit::On, parameters, points)),
    ("four lanes", |tape, parameters, points| in_lanes::<4>(tape, Jit::On, parameters, points)),
    // Interpreted where the processor has no registers for them.
    ("eight lanes", |tape, parameters, points| in_lanes::<8>(tape, Jit::On, parameters, points)),
];

pub(crate) fn interpreted(tape: &Tape, parameters: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut workspace = tape.workspace(parameters);
    let mut evaluate = |point: &Vec<f64>| {
        let mut out = vec![0.0; tape.n_outputs()];
        tape.evaluate(&mut workspace, point, &mut out);
        out
    };
    points.iter().map(&mut evaluate).collect()
}

/// Machine code from the first evaluation where there is any.
pub(crate) fn by_runner(tape: &Tape, parameters: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let runner = Runner::new(tape.clone(), Jit::On);
    let mut workspace = tape.workspace(parameters);
    let mut evaluate = |point: &Vec<f64>| {
        let mut out = vec![0.0; tape.n_outputs()];
        runner.evaluate(&mut workspace, point, &mut out);
        out
    };
    points.iter().map(&mut evaluate).collect()
}

/// Several points at once, the last of them repeated where there are fewer. The last lane gets its parameters by itself.
fn in_lanes<const N: usize>(
    tape: &Tape,
    jit: Jit,
    parameters: &[f64],
    points: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let runner = LaneRunner::<N>::new(tape.clone(), jit);
    let mut workspace = runner.workspace(parameters);
    runner.set_parameters(&mut workspace, N - 1, parameters);
    let mut results = Vec::new();
    for points in points.chunks(N) {
        let point = |lane: usize| &points[lane.min(points.len() - 1)];
        let input = |input: usize| std::array::from_fn(|lane| point(lane)[input]);
        let inputs: Vec<[f64; N]> = (0..tape.n_inputs()).map(input).collect();
        let mut out = vec![[0.0; N]; tape.n_outputs()];
        runner.evaluate(&mut workspace, &inputs, &mut out);
        results
            .extend((0..points.len()).map(|lane| out.iter().map(|output| output[lane]).collect()));
    }
    results
}

pub(crate) fn in_one_batch(tape: &Tape, parameters: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    in_batches(tape, parameters, points, points.len().max(1))
}

/// Points after which machine code has paid.
const MANY: usize = 5000;
/// Longer tapes have none.
const MOST_OPERATIONS: usize = 10_000;

/// The points again after so many that machine code has paid.
fn in_a_long_batch(tape: &Tape, parameters: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    if tape.operation_count() > MOST_OPERATIONS {
        return in_one_batch(tape, parameters, points);
    }
    let first = points.iter().cycle().take(if points.is_empty() { 0 } else { MANY });
    let repeated: Vec<Vec<f64>> = first.chain(points).cloned().collect();
    in_one_batch(tape, parameters, &repeated).split_off(repeated.len() - points.len())
}

/// Machine code at one point, then at the next two, and so on: lanes without a point among them.
fn in_growing_batches(tape: &Tape, parameters: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut batch = tape.batch(parameters);
    let (mut results, mut rest) = (Vec::new(), points);
    if let Some(first) = points.first()
        && tape.operation_count() <= MOST_OPERATIONS
    {
        let inputs: Vec<f64> = first.iter().flat_map(|&x| std::iter::repeat_n(x, MANY)).collect();
        batch.evaluate(MANY, &inputs, &mut vec![0.0; MANY * tape.n_outputs()]);
    }
    for n in 1.. {
        if rest.is_empty() {
            break;
        }
        let (next, later) = rest.split_at(n.min(rest.len()));
        results.extend(at_once(tape, &mut batch, next));
        rest = later;
    }
    results
}

fn in_batches_of_three(tape: &Tape, parameters: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    in_batches(tape, parameters, points, 3)
}

fn in_batches(tape: &Tape, parameters: &[f64], points: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    let mut batch = tape.batch(parameters);
    points.chunks(n).flat_map(|points| at_once(tape, &mut batch, points)).collect()
}

/// All points in one call.
fn at_once(tape: &Tape, batch: &mut Batch, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let inputs: Vec<f64> = (0..tape.n_inputs())
        .flat_map(|input| points.iter().map(move |point| point[input]))
        .collect();
    let mut out = vec![0.0; points.len() * tape.n_outputs()];
    batch.evaluate(points.len(), &inputs, &mut out);
    let of_point = |point: usize| out.iter().skip(point).step_by(points.len()).copied().collect();
    (0..points.len()).map(of_point).collect()
}

pub(crate) fn is_same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// All evaluators give the interpreter's values.
pub(crate) fn check_agreement(
    tape: &Tape,
    parameters: &[f64],
    points: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let expected = interpreted(tape, parameters, points);
    for (name, evaluate) in EVALUATORS {
        let found = evaluate(tape, parameters, points);
        assert_eq!(found.len(), expected.len(), "{name}: number of points");
        for (point, (found, expected)) in points.iter().zip(found.iter().zip(&expected)) {
            assert_eq!(found.len(), expected.len(), "{name}: number of outputs");
            for (output, (found, expected)) in found.iter().zip(expected).enumerate() {
                assert!(
                    is_same(*found, *expected),
                    "{name}: output {output} at {point:?} is {found:?}, not {expected:?}"
                );
            }
        }
    }
    expected
}
