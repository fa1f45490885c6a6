//! One suite for all evaluators of a tape: they agree bit for bit, at every input.
//!
//! The interpreter is held against the graph evaluated directly ([`Pool::evaluate`]), all others
//! against the interpreter. All NaN count as one; zeros count with their signs.

use bksim_expr::{Expr, Function, Jit, LaneRunner, Pool, Runner, SymbolId, Tape};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::ways::{by_runner, check_agreement, in_one_batch, interpreted, is_same};

fn id(pool: &Pool, name: &str) -> SymbolId {
    pool.symbol_id(pool.symbol(name)).expect("a symbol was just made")
}

const INPUTS: [&str; 3] = ["x", "y", "z"];
const PARAMETERS: [&str; 2] = ["a", "b"];

pub(crate) fn compile(pool: &Pool, outputs: &[Expr]) -> Tape {
    let (inputs, parameters) = (INPUTS.map(|n| id(pool, n)), PARAMETERS.map(|n| id(pool, n)));
    Tape::compile(pool, outputs, &inputs, &parameters).expect("all bound")
}

/// All evaluators agree on the outputs, and with the graph itself to the last bit.
fn check(outputs: &[&str], points: &[Vec<f64>]) {
    let pool = Pool::new();
    let outputs: Vec<Expr> = outputs.iter().map(|text| pool.parse(text).expect("valid")).collect();
    let parameters = [0.75, -2.5];
    let values = check_agreement(&compile(&pool, &outputs), &parameters, points);
    for (point, values) in points.iter().zip(values) {
        let value = |symbol: SymbolId| {
            let names = INPUTS.iter().chain(&PARAMETERS);
            let index = names.into_iter().position(|&name| id(&pool, name) == symbol)?;
            point.iter().chain(&parameters).copied().nth(index)
        };
        for (&output, found) in outputs.iter().zip(values) {
            let expected = pool.evaluate(output, &value).expect("all symbols have values");
            let text = pool.to_text(output);
            assert!(is_same(found, expected), "{text} at {point:?}: {found:?}, not {expected:?}");
        }
    }
}

/// Where functions change their minds.
const SPECIAL: [f64; 27] = [
    0.0,
    -0.0,
    5e-324,
    -1e-310,
    1e-8,
    0.5,
    -0.5,
    1.0,
    -1.0,
    1.5,
    std::f64::consts::FRAC_PI_2,
    -std::f64::consts::PI,
    3.0,
    -64.0,
    65.0,
    1e6,
    1.000_001e6,
    -1e9,
    1e22,
    1e300,
    -1.3e154,
    f64::MAX,
    f64::MIN_POSITIVE,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    -f64::NAN,
];

/// All pairs of special values, with a third that varies.
pub(crate) fn special_points() -> Vec<Vec<f64>> {
    let pairs = SPECIAL.iter().flat_map(|&x| SPECIAL.map(|y| [x, y]));
    pairs.zip(SPECIAL.iter().cycle().skip(5)).map(|([x, y], &z)| vec![x, y, z]).collect()
}

#[test]
fn every_function_agrees_at_special_values() {
    let calls: Vec<String> = Function::names()
        .map(|name| {
            let function = Function::from_name(name).expect("a name of the table");
            format!("{name}({})", INPUTS[..function.arity()].join(", "))
        })
        .collect();
    let calls: Vec<&str> = calls.iter().map(String::as_str).collect();
    // One tape for all, and one for each: neighbours must not matter.
    check(&calls, &special_points());
    for call in &calls {
        check(&[call], &special_points());
    }
}

#[test]
fn every_operator_agrees_at_special_values() {
    // The tape may negate a sum instead of its terms, which shows in the sign of a zero alone.
    let pool = Pool::new();
    let e = pool.parse("-x - y").expect("valid");
    check_agreement(&compile(&pool, &[e]), &[0.0; 2], &special_points());
    let operators = ["x + y", "x - y", "x*y", "x/y", "-x", "x^y", "1/x", "y^(-2)", "x^64"];
    check(&operators, &special_points());
    for operator in &operators {
        check(&[operator], &special_points());
    }
    check(&["x^a", "a^x", "b^y", "x^0.5", "x^65", "x^(-0.5)"], &special_points());
}

#[test]
fn signs_of_zero_and_domain_errors_are_those_of_ieee_754() {
    let pool = Pool::new();
    let texts = ["sin(x)", "cos(x)", "sqrt(x)", "-x", "1/x", "ln(x)", "atan2(x, -1)", "asin(x)"];
    let outputs = texts.map(|text| pool.parse(text).expect("valid"));
    let points = [-0.0, -1.0, f64::INFINITY].map(|x| vec![x, 0.0, 0.0]);
    let values = check_agreement(&compile(&pool, &outputs), &[0.0; 2], &points);
    let expected = [-0.0, 1.0, -0.0, 0.0, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for (text, (found, expected)) in texts.iter().zip(values[0].iter().zip(expected)) {
        assert!(is_same(*found, expected), "{text} at -0: {found:?}, not {expected:?}");
    }
    assert!(is_same(values[0][6], -std::f64::consts::PI), "atan2(-0, -1) is {:?}", values[0][6]);
    assert!(values[1][2].is_nan() && values[1][5].is_nan(), "√ and ln of −1: {:?}", values[1]);
    assert!(values[2][..2].iter().all(|v| v.is_nan()), "sin and cos of ∞: {:?}", values[2]);
    assert!(values[2][7].is_nan(), "asin of ∞: {:?}", values[2][7]);
}

/// Angles are gathered in lanes: their number and their company must not change a bit.
#[test]
fn lanes_do_not_depend_on_their_neighbours() {
    let pool = Pool::new();
    let angle = |n: usize| pool.parse(&format!("{n}*x + y/{}", n + 1)).expect("valid");
    let points = [vec![0.3, -1.7, 0.0], vec![1e5, 1e9, 0.0], vec![f64::NAN, 1.0, 0.0]];
    let alone: Vec<Vec<Vec<f64>>> = (1..=70)
        .map(|n| {
            let outputs = [pool.sin(angle(n)), pool.cos(angle(n))];
            check_agreement(&compile(&pool, &outputs), &[0.0; 2], &points)
        })
        .collect();
    for n in (1..=9).chain([31, 32, 33, 70]) {
        let outputs: Vec<Expr> =
            (1..=n).flat_map(|i| [pool.sin(angle(i)), pool.cos(angle(i))]).collect();
        let values = check_agreement(&compile(&pool, &outputs), &[0.0; 2], &points);
        for (point, values) in values.iter().enumerate() {
            for (i, pair) in values.chunks(2).enumerate() {
                let same = pair.iter().zip(&alone[i][point]).all(|(a, b)| is_same(*a, *b));
                assert!(same, "angle {i} of {n}: {pair:?}, alone {:?}", alone[i][point]);
            }
        }
    }
}

#[test]
fn sines_of_sines_come_after_their_angles() {
    check(
        &[
            "sin(cos(sin(x) + y)*a) + cos(x)",
            "sin(x)",
            "cos(cos(sin(x) + y)*a)",
            "cos(sin(a) + cos(b))*sin(x)",
            "sin(exp(sin(x)))",
        ],
        &special_points(),
    );
}

#[test]
fn outputs_may_be_anything_anywhere() {
    check(
        &["x", "a", "2.5", "x", "a + b", "a + b", "y", "pi", "sin(a)", "x + a"],
        &special_points(),
    );
    check(&["a*b", "sin(b)"], &special_points());
    check(&["1/0", "-1/0", "0/0", "-0"], &special_points());
    check(&[], &special_points());
    let pool = Pool::new();
    let tape = Tape::compile(&pool, &[], &[], &[]).expect("bound");
    assert!(tape.is_empty());
    let none: [Vec<f64>; 2] = [vec![], vec![]];
    assert_eq!(check_agreement(&tape, &[], &none), none);
    let tape = Tape::compile(&pool, &[pool.int(7)], &[], &[]).expect("bound");
    assert_eq!(check_agreement(&tape, &[], &[vec![], vec![]]), [vec![7.0], vec![7.0]]);
    check_agreement(&tape, &[], &[]);
}

/// True where this processor is one that machine code is made for.
fn has_machine_code() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Numbers of one evaluation do not reach the next, nor another workspace.
#[test]
fn workspaces_are_independent() {
    let pool = Pool::new();
    let tape = compile(&pool, &[pool.parse("a*sin(x) + cos(y)*sqrt(b)/z").expect("valid")]);
    let runner = Runner::new(tape.clone(), Jit::Auto);
    let mut workspaces = [[1.0, 4.0], [-3.0, 9.0]].map(|parameters| tape.workspace(&parameters));
    let alone = [[1.0, 4.0], [-3.0, 9.0]].map(|parameters| {
        interpreted(&tape, &parameters, &[vec![0.1, 0.2, 0.3], vec![2.0, 1.0, -1.0]])
    });
    // Enough rounds that the machine code comes in between.
    for round in 0..10_000 {
        for (workspace, alone) in workspaces.iter_mut().zip(&alone) {
            let (point, expected) =
                [([0.1, 0.2, 0.3], &alone[0]), ([2.0, 1.0, -1.0], &alone[1])][round % 2];
            let mut out = [0.0];
            runner.evaluate(workspace, &point, &mut out);
            assert!(is_same(out[0], expected[0]), "round {round}: {out:?}, not {expected:?}");
        }
        if runner.is_compiled() && round % 2 == 1 {
            break;
        }
    }
    assert_eq!(runner.is_compiled(), has_machine_code());
}

#[test]
fn clones_share_machine_code_between_threads() {
    let pool = Pool::new();
    let tape = compile(&pool, &[pool.parse("sin(x)*a + y^z").expect("valid")]);
    let expected = interpreted(&tape, &[2.0, 3.0], &[vec![0.5, 1.5, 2.5]])[0][0];
    let runner = Runner::new(tape, Jit::Auto);
    std::thread::scope(|scope| {
        for clone in std::iter::repeat_n(runner.clone(), 4) {
            scope.spawn(move || {
                let mut workspace = clone.tape().workspace(&[2.0, 3.0]);
                let mut out = [0.0];
                for _ in 0..10_000 {
                    clone.evaluate(&mut workspace, &[0.5, 1.5, 2.5], &mut out);
                    assert_eq!(out, [expected]);
                }
            });
        }
    });
    assert_eq!(runner.is_compiled(), has_machine_code());
    let off = Runner::new(runner.tape().clone(), Jit::Off);
    off.evaluate(&mut off.tape().workspace(&[2.0, 3.0]), &[0.5, 1.5, 2.5], &mut [0.0]);
    assert!(!off.is_compiled());
}

/// Machine code can be made and dropped again and again.
#[test]
fn machine_code_is_freed_with_its_runner() {
    let pool = Pool::new();
    let e = pool.parse("x*y + sin(z)").expect("valid");
    let tape = compile(&pool, &[e]);
    for _ in 0..100 {
        let runner = Runner::new(tape.clone(), Jit::On);
        let mut out = [0.0];
        runner.evaluate(&mut tape.workspace(&[0.0; 2]), &[2.0, 3.0, 0.0], &mut out);
        assert_eq!((out, runner.is_compiled()), ([6.0], has_machine_code()));
    }
}

/// More values than any processor has registers, all needed again at the end.
#[test]
fn many_values_may_be_alive_at_once() {
    let pool = Pool::new();
    let (x, y) = (pool.symbol("x"), pool.symbol("y"));
    let values: Vec<Expr> = (0..3000)
        .map(|i| pool.mul(pool.add(x, pool.int(i)), pool.sub(y, pool.int(2 * i))))
        .collect();
    let mut e = pool.symbol("z");
    for pair in values.iter().zip(values.iter().rev()) {
        e = pool.div(pool.add(pool.mul(e, *pair.0), x), pool.add(*pair.1, y));
    }
    let tape = compile(&pool, &[e, pool.sum(values)]);
    check_agreement(&tape, &[0.0; 2], &[vec![0.3, 0.1, 2.0], vec![1.5, 1e-3, -1.0]]);
}

/// A long chain is interpreted: compiling it would take longer than it could save.
#[test]
fn a_million_instructions_are_evaluated() {
    let pool = Pool::new();
    let (x, y) = (pool.symbol("x"), pool.symbol("y"));
    let mut e = x;
    for i in 0..500_000 {
        let next = pool.mul(e, y);
        e = if i % 1000 == 0 { pool.sin(next) } else { pool.add(next, x) };
    }
    let tape = compile(&pool, &[e]);
    assert!(tape.len() > 900_000, "{} operations", tape.len());
    let points = [vec![0.3, 0.9, 0.0], vec![-0.2, 0.5, 0.0]];
    let expected = interpreted(&tape, &[0.0; 2], &points);
    let found = in_one_batch(&tape, &[0.0; 2], &points);
    assert_eq!(found, expected);
    assert!(expected[0][0].is_finite());
    assert_eq!(by_runner(&tape, &[0.0; 2], &points), expected);
    assert!(!LaneRunner::<4>::new(tape, Jit::On).has_code());
}

/// Values that are used again tens of thousands of instructions later.
#[test]
fn long_bodies_keep_values_for_later() {
    let pool = Pool::new();
    let (x, y) = (pool.symbol("x"), pool.symbol("y"));
    // Every value is used again by another one, half of the body later, and sines among them.
    let mut values = vec![x, y];
    for i in 2..24_000_usize {
        let (near, far) = (values[i - 1], values[i / 2]);
        let sum = pool.add(near, pool.mul(far, pool.rational(1, 3)));
        values.push(if i % 500 == 0 { pool.sin(sum) } else { pool.mul(sum, y) });
    }
    let outputs: Vec<Expr> = values.iter().copied().step_by(997).chain([x]).collect();
    let tape = compile(&pool, &outputs);
    assert!(tape.len() > 55_000, "{} operations", tape.len());
    let points = [vec![0.3, 0.7, 0.0], vec![-0.2, 0.6, 0.0]];
    check_agreement(&tape, &[0.0; 2], &points);
}

#[test]
#[should_panic(expected = "a workspace of this tape")]
fn a_workspace_of_another_tape_is_refused() {
    let pool = Pool::new();
    let parse = |text| pool.parse(text).expect("valid");
    let (tape, other) = (compile(&pool, &[parse("x*y")]), compile(&pool, &[parse("x*y + z")]));
    let runner = Runner::new(tape, Jit::On);
    runner.evaluate(&mut other.workspace(&[0.0; 2]), &[0.0; 3], &mut [0.0]);
}

/// Building instructions of an expression, as text.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        6 => prop::sample::select(vec!["x", "y", "z", "a", "b"]).prop_map(str::to_owned),
        1 => (-5i32..6).prop_map(|n| n.to_string()),
        1 => prop::sample::select(vec!["0.5", "1/3", "pi"]).prop_map(str::to_owned),
    ];
    let unary: Vec<&str> = names_of_arity(1);
    let binary: Vec<&str> = names_of_arity(2);
    leaf.prop_recursive(6, 60, 3, move |inner| {
        let (f, g) = (prop::sample::select(unary.clone()), prop::sample::select(binary.clone()));
        let pair = (inner.clone(), inner.clone());
        let triple = (inner.clone(), inner.clone(), inner.clone());
        let operator = prop::sample::select(vec!["+", "-", "*", "/", "^"]);
        prop_oneof![
            6 => (operator, pair.clone()).prop_map(|(o, (a, b))| format!("(({a}) {o} ({b}))")),
            4 => (f, inner).prop_map(|(f, a)| format!("{f}({a})")),
            3 => (prop::sample::select(vec!["sin", "cos"]), pair.clone())
                .prop_map(|(f, (a, b))| format!("{f}({a})*{b}")),
            2 => (g, pair).prop_map(|(g, (a, b))| format!("{g}({a}, {b})")),
            1 => triple.prop_map(|(a, b, c)| format!("if({a}, {b}, {c})")),
        ]
    })
}

fn names_of_arity(arity: usize) -> Vec<&'static str> {
    let has_arity = |name: &&str| Function::from_name(name).is_some_and(|f| f.arity() == arity);
    Function::names().filter(has_arity).collect()
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -3.0..3.0, 1 => prop::sample::select(SPECIAL.to_vec()), 1 => any::<f64>()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: RngSeed::Fixed(1754), ..ProptestConfig::default() })]

    #[test]
    fn generated_expressions_agree(
        texts in prop::collection::vec(expression(), 1..4),
        parameters in prop::array::uniform2(number()),
        points in prop::collection::vec(prop::collection::vec(number(), 3), 1..40),
    ) {
        let pool = Pool::new();
        let outputs: Vec<Expr> = texts.iter().map(|text| pool.parse(text).expect("valid")).collect();
        check_agreement(&compile(&pool, &outputs), &parameters, &points);
    }
}
