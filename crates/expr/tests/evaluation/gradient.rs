//! Gradients and Jacobians are the same, whichever way they are taken.

use bksim_expr::{Expr, Pool, SymbolId, Tape};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const N: usize = 12;

fn symbols(pool: &Pool) -> Vec<SymbolId> {
    (0..N).map(|i| pool.symbol_id(pool.symbol(&format!("x{i}"))).expect("a symbol")).collect()
}

/// A piece of an expression over many symbols, as text.
fn piece() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        6 => (0..N).prop_map(|i| format!("x{i}")),
        1 => (-3i32..4).prop_map(|n| n.to_string()),
    ];
    leaf.prop_recursive(4, 24, 4, |inner| {
        let pair = || (inner.clone(), inner.clone());
        let call = prop::sample::select(vec!["sin", "cos", "tan", "exp", "sqrt", "abs", "ln"]);
        let two = prop::sample::select(vec!["atan2", "min", "max", "lt"]);
        prop_oneof![
            3 => pair().prop_map(|(a, b)| format!("({a} + {b})")),
            4 => pair().prop_map(|(a, b)| format!("({a})*({b})")),
            1 => pair().prop_map(|(a, b)| format!("({a})/({b})")),
            1 => pair().prop_map(|(a, b)| format!("({a})^({b})")),
            1 => inner.clone().prop_map(|a| format!("({a})^3")),
            3 => (call, inner.clone()).prop_map(|(f, a)| format!("{f}({a})")),
            1 => (two, pair()).prop_map(|(f, (a, b))| format!("{f}({a}, {b})")),
            1 => (inner.clone(), inner.clone(), inner.clone())
                .prop_map(|(c, a, b)| format!("if(gt({c}, 0), {a}, {b})")),
        ]
    })
}

/// A sum that mentions every symbol, nested twice so that it pays to go backward.
fn long(pieces: &[String]) -> String {
    let all: Vec<String> = (0..N).map(|i| format!("(x{i} + {i})*x{}", (i + 1) % N)).collect();
    let inner = format!("sin({})", all.join(" + "));
    let rest: Vec<String> =
        pieces.iter().map(|p| format!("cos({inner}*exp({inner}))*({p})")).collect();
    rest.join(" + ")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: RngSeed::Fixed(1676), ..ProptestConfig::default() })]

    #[test]
    fn backward_agrees_with_forward(
        pieces in prop::collection::vec(piece(), 1..4),
        point in prop::collection::vec(-2.0..2.0, N),
    ) {
        let pool = Pool::new();
        let xs = symbols(&pool);
        let e = pool.parse(&long(&pieces)).expect("generated text is valid");
        let value = |e: Expr| {
            pool.evaluate(e, &|s| xs.iter().position(|&x| x == s).map(|i| point[i])).expect("bound")
        };
        for (&x, backward) in xs.iter().zip(pool.gradient(e, &xs)) {
            let (forward, found) = (value(pool.diff(e, x)), value(backward));
            let is_close = (forward - found).abs() <= 1e-9 * forward.abs().max(1.0);
            // Only what cancels among huge parts may differ.
            let is_huge = !forward.is_finite() || forward.abs() > 1e8;
            prop_assert!(is_close || is_huge, "{found} is not {forward} for {}", pool.to_text(e));
        }
    }

    #[test]
    fn jacobians_mix_both_ways_without_a_trace(
        pieces in prop::collection::vec(piece(), 2..5),
        point in prop::collection::vec(0.1..2.0, N),
    ) {
        let pool = Pool::new();
        let xs = symbols(&pool);
        let rows: Vec<Expr> = pieces
            .iter()
            .chain([&long(&pieces), &long(&pieces[1..])])
            .map(|text| pool.parse(text).expect("generated text is valid"))
            .collect();
        let jacobian = pool.jacobian(&rows, &xs);
        let is_sorted = jacobian.entries.is_sorted_by_key(|&(row, column, _)| (row, column));
        prop_assert!(is_sorted, "{:?}", jacobian.entries);
        let value = |e: Expr| {
            pool.evaluate(e, &|s| xs.iter().position(|&x| x == s).map(|i| point[i])).expect("bound")
        };
        for (i, &row) in rows.iter().enumerate() {
            for (j, &x) in xs.iter().enumerate() {
                let entry = jacobian.entries.iter().find(|entry| (entry.0, entry.1) == (i, j));
                let found = entry.map_or(0.0, |entry| value(entry.2));
                let forward = value(pool.diff(row, x));
                let is_close = (forward - found).abs() <= 1e-9 * forward.abs().max(1.0);
                prop_assert!(is_close || !forward.is_finite() || forward.abs() > 1e8, "{found} is not {forward}");
            }
        }
    }
}

/// 8400 products of four sines, each of five out of 60 symbols.
fn large(pool: &Pool) -> (Expr, Vec<SymbolId>) {
    let xs: Vec<Expr> = (0..60).map(|i| pool.symbol(&format!("x{i}"))).collect();
    let ids = xs.iter().map(|&x| pool.symbol_id(x).expect("a symbol")).collect();
    let term = |k: usize| {
        let sine = |step: usize| {
            let at = |i: usize| xs[(k * step + i * i + k / 60) % 60];
            let weight = pool.int(i64::try_from(2 + k / 60).expect("small"));
            pool.sin(pool.sum([at(1), pool.product([weight, at(2), at(3)]), at(4), at(5)]))
        };
        pool.product([1, 7, 11, 13].map(sine))
    };
    (pool.sum((0..8400).map(term)), ids)
}

#[test]
fn gradient_of_a_large_sum_costs_a_few_evaluations() {
    let pool = Pool::new();
    let (e, ids) = large(&pool);
    let length = |outputs: &[Expr]| Tape::compile(&pool, outputs, &ids, &[]).expect("bound").len();
    let at = |s: SymbolId| (0u8..).zip(&ids).find(|&(_, &id)| id == s).map_or(0, |found| found.0);
    let gradient = pool.gradient(e, &ids);
    let forward: Vec<Expr> = ids.iter().map(|&x| pool.diff(e, x)).collect();
    let (function, backward) = (length(&[e]), length(&gradient));
    assert!(backward <= 4 * function, "{backward} instructions against {function}");
    let value =
        |e: Expr| pool.evaluate(e, &|s| Some(0.1 + 0.01 * f64::from(at(s)))).expect("bound");
    for (i, (&b, &f)) in gradient.iter().zip(&forward).enumerate() {
        let (b, f) = (value(b), value(f));
        assert!((b - f).abs() <= 1e-9 * f.abs().max(1.0), "{i}: {b} is not {f}");
    }
}

/// Weight 0 must not meet an infinite derivative of the branch not taken.
#[test]
fn branches_not_taken_do_not_spoil_a_gradient() {
    let pool = Pool::new();
    let xs = symbols(&pool);
    let squares: Vec<String> = (0..N).map(|i| format!("x{i}^2")).collect();
    let text =
        format!("sin({0})*cos({0})*if(gt(x0, 0), sqrt(x0 - x1), x0*x2)", squares.join(" + "));
    let e = pool.parse(&text).expect("valid");
    for derivative in pool.gradient(e, &xs) {
        let value = pool.evaluate(derivative, &|_| Some(-0.5)).expect("bound");
        assert!(value.is_finite(), "{}", pool.to_text(derivative));
    }
}

/// Sines, products and sums in one chain; every symbol occurs all along it.
#[test]
fn long_chains_go_backward_without_overflow() {
    let pool = Pool::new();
    let xs = symbols(&pool);
    let mut e = pool.one();
    for i in 0..30_000 {
        let x = pool.symbol_expr(xs[(i / 3) % N]);
        e = match i % 3 {
            0 => pool.sin(e),
            1 => pool.add(e, x),
            _ => pool.mul(e, x),
        };
    }
    let before = pool.len();
    let gradient = pool.gradient(e, &xs);
    let n_new = pool.len() - before;
    assert!(n_new < 40 * before, "{n_new} new nodes for {before}");
    let value = |e: Expr| {
        pool.evaluate(e, &|s| xs.iter().position(|&x| x == s).map(|i| 0.6 + 0.02 * i as f64))
    };
    let (backward, forward) = (value(gradient[3]), value(pool.diff(e, xs[3])));
    let (backward, forward) = (backward.expect("bound"), forward.expect("bound"));
    assert!((backward - forward).abs() <= 1e-9 * forward.abs(), "{backward} is not {forward}");
}
