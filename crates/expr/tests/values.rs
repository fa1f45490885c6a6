//! Whatever is done to an expression, its value stays: generated expressions at random points.

use bksim_expr::{Expr, Pool, SymbolId, Tape};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Building instructions of an expression, as text.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        4 => prop::sample::select(vec!["a", "b", "q1", "q2", "q3"]).prop_map(str::to_owned),
        1 => (-5i32..6).prop_map(|n| n.to_string()),
        1 => prop::sample::select(vec!["0.5", "1/3", "2.25", "pi"]).prop_map(str::to_owned),
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        let call =
            prop::sample::select(vec!["sin", "cos", "sin", "cos", "tan", "exp", "sqrt", "abs"]);
        let power = prop::sample::select(vec!["2", "3", "-1", "-2"]);
        prop_oneof![
            3 => (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} + {b})")),
            2 => (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} - {b})")),
            4 => (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a})*({b})")),
            1 => (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a})/({b})")),
            2 => (inner.clone(), power).prop_map(|(a, n)| format!("({a})^({n})")),
            4 => (call, inner).prop_map(|(f, a)| format!("{f}({a})")),
        ]
    })
}

/// Values of the symbols at a point, by name.
fn point() -> impl Strategy<Value = [f64; 5]> {
    prop::array::uniform5(-2.0..2.0)
}

fn value_of(pool: &Pool, e: Expr, point: &[f64; 5]) -> f64 {
    let value = |symbol: SymbolId| {
        let index =
            ["a", "b", "q1", "q2", "q3"].iter().position(|n| pool.symbol_name(symbol) == *n);
        index.map(|i| point[i])
    };
    pool.evaluate(e, &value).expect("all symbols have values")
}

/// Largest magnitude of any part: cancellation loses digits relative to it.
fn scale_of(pool: &Pool, text: &str, point: &[f64; 5]) -> f64 {
    let mut scale: f64 = 1.0;
    let syntax = bksim_expr::parse(text, &bksim_expr::ParseOptions::default()).expect("valid");
    for n in 1..=syntax.nodes.len() {
        let part = bksim_expr::Syntax { nodes: syntax.nodes[..n].to_vec() };
        let e = pool.lower(&part, &mut |name, _| {
            Ok::<_, ()>(if name == "pi" { pool.pi() } else { pool.symbol(name) })
        });
        scale = scale.max(value_of(pool, e.expect("lowers"), point).abs());
    }
    scale
}

/// Equal up to rounding of parts as large as `scale`; only finite values are held together.
fn close(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 1e-9 * scale.max(a.abs()) || !a.is_finite() || scale > 1e6
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, rng_seed: RngSeed::Fixed(2008), ..ProptestConfig::default() })]

    #[test]
    fn simplify_and_expand_keep_the_value(text in expression(), point in point()) {
        let pool = Pool::new();
        let e = pool.parse(&text).expect("generated text is valid");
        let (value, scale) = (value_of(&pool, e, &point), scale_of(&pool, &text, &point));
        let simple = pool.simplify(e);
        let found = value_of(&pool, simple, &point);
        prop_assert!(close(value, found, scale), "{value} became {found}: {}", pool.to_text(simple));
        let expanded = pool.expand(e);
        let found = value_of(&pool, expanded, &point);
        prop_assert!(close(value, found, scale), "{value} became {found}: {}", pool.to_text(expanded));
    }

    #[test]
    fn simplify_does_not_depend_on_the_pool(text in expression()) {
        let (pool, other) = (Pool::new(), Pool::new());
        // Other handles for the same symbols.
        for name in ["z", "q3", "b", "q2", "a"] {
            other.sin(other.mul(other.symbol(name), other.symbol("q1")));
        }
        let simplified = |pool: &Pool| pool.to_text(pool.simplify(pool.parse(&text).expect("valid")));
        prop_assert_eq!(simplified(&pool), simplified(&other));
    }

    #[test]
    fn printed_text_reads_back_as_the_same_expression(text in expression()) {
        let pool = Pool::new();
        let e = pool.parse(&text).expect("generated text is valid");
        let printed = pool.to_text(e);
        prop_assert_eq!(pool.parse(&printed).expect("printed text is valid"), e, "{}", printed);
    }

    #[test]
    fn derivatives_agree_with_central_differences(text in expression(), point in point()) {
        let pool = Pool::new();
        let e = pool.parse(&text).expect("generated text is valid");
        pool.symbol("q1");
        let q1 = pool.find_symbol("q1").expect("just made");
        let exact = value_of(&pool, pool.diff(e, q1), &point);
        let shifted = |h: f64| {
            let mut moved = point;
            moved[2] += h;
            value_of(&pool, e, &moved)
        };
        // Two steps: where they disagree, the function is too steep for differences to be a test.
        let quotient = |h: f64| (shifted(h) - shifted(-h)) / (2.0 * h);
        let (coarse, fine) = (quotient(2e-5), quotient(1e-5));
        let is_smooth = (coarse - fine).abs() <= 1e-5 * fine.abs().max(1.0);
        let scale = scale_of(&pool, &text, &point);
        let is_test = is_smooth && exact.is_finite() && scale < 1e4;
        let error = (exact - fine).abs();
        prop_assert!(!is_test || error <= 1e-4 * fine.abs().max(scale), "{exact} is not {fine}");
    }

    #[test]
    fn tape_agrees_with_the_reference(text in expression(), point in point()) {
        let pool = Pool::new();
        let e = pool.parse(&text).expect("generated text is valid");
        let ids = ["a", "b", "q1", "q2", "q3"].map(|name| {
            pool.symbol(name);
            pool.find_symbol(name).expect("just made")
        });
        let tape = Tape::compile(&pool, &[e, pool.neg(e)], &ids[2..], &ids[..2]).expect("all bound");
        let mut out = [0.0; 2];
        tape.evaluate(&mut tape.workspace(&point[..2]), &point[2..], &mut out);
        let value = value_of(&pool, e, &point);
        let scale = scale_of(&pool, &text, &point);
        prop_assert!(close(value, out[0], scale), "{value} is not {}", out[0]);
        prop_assert!(close(out[0], -out[1], scale), "{} is not minus {}", out[0], out[1]);
    }
}
