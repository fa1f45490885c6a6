//! The contract of `simplify`: bounded work, and a result whatever happens.

use crate::common::{points, recipes, value_at};
use bksim_expr::{Expr, Pool};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn symbols(pool: &Pool, letter: &str, n: usize) -> Vec<Expr> {
    (0..n).map(|i| pool.symbol(&format!("{letter}{i}"))).collect()
}

/// Towers `e = f(e)` of a given height over one symbol.
fn tower(pool: &Pool, height: usize, f: impl Fn(Expr) -> Expr) -> Expr {
    (0..height).fold(pool.symbol("x"), |e, _| f(e))
}

/// Inputs whose normal forms are too long to write down.
fn explosive(pool: &Pool) -> Vec<(&'static str, Expr)> {
    let (xs, qs) = (symbols(pool, "x", 40), symbols(pool, "q", 40));
    let y = pool.symbol("y");
    let sum_of_five = |i: usize| pool.sum((0..5).map(|j| xs[(7 * i + j * j) % 40]));
    let waves = |i: usize| pool.add(pool.sin(qs[i % 40]), pool.cos(qs[(i + 3) % 40]));
    let long_term = |i: usize| pool.product([xs[i % 37], qs[i % 31], pool.sin(qs[i % 13])]);
    let speeds = |i: usize| pool.sum((0..8).map(|j| pool.mul(xs[j], pool.cos(qs[(i + j) % 20]))));
    vec![
        ("a power of a sum", pool.powi(pool.sum(xs[..4].iter().copied()), 40)),
        ("a product of sums", pool.product((0..30).map(sum_of_five))),
        ("a product of waves", pool.product((0..30).map(waves))),
        ("a long sum", pool.sum((0..100_000).map(long_term))),
        ("squares of sums", pool.sum((0..100).map(|i| pool.powi(speeds(i), 2)))),
        ("nested squares", tower(pool, 2_000, |e| pool.add(pool.powi(e, 2), y))),
        ("nested roots", tower(pool, 20_000, |e| pool.sqrt(pool.add(pool.mul(e, y), pool.one())))),
        ("nested quotients", tower(pool, 20_000, |e| pool.add(pool.div(y, e), pool.one()))),
        ("nested sines", tower(pool, 20_000, |e| pool.sin(pool.mul(e, y)))),
        ("nested tangents", tower(pool, 2_000, |e| pool.tan(pool.add(pool.powi(e, 2), e)))),
        ("a product of tangents", pool.product((0..25).map(|i| pool.add(pool.tan(qs[i]), y)))),
        (
            "shared products of waves",
            (0..2_000).fold(y, |e, i| {
                let (x, q) = (xs[i % 40], qs[i % 40]);
                pool.add(pool.mul(e, pool.sin(q)), pool.mul(e, pool.cos(x)))
            }),
        ),
    ]
}

#[test]
fn work_and_memory_stay_within_the_budget() {
    let pool = Pool::new();
    for (name, e) in explosive(&pool) {
        for nodes in [3_000, 4_000_000] {
            let before = pool.len() as u64;
            let done = pool.simplify_within(&[e], nodes);
            let [size, after] = [e, done[0]].map(|e| pool.operation_count(&[e]).shared());
            let grown = pool.len() as u64 - before;
            assert!(grown <= 8 * (nodes + size), "{name}: {grown} new nodes");
            assert!(after <= 2 * size, "{name}: {after} operations of {size}");
            assert_eq!(pool.simplify_within(&[e], nodes), done, "{name}");
        }
    }
}

#[test]
fn what_is_not_reached_stays() {
    let pool = Pool::new();
    let [short, long] = [
        "cos(q)*cos(p) - sin(q)*sin(p)",
        "sqrt(a*sin(q)^2 + a*cos(q)^2)*exp(cos(q)*cos(p) - sin(q)*sin(p))",
    ]
    .map(|text| pool.parse(text).expect(text));
    let simple = pool.simplify(short);
    assert_eq!(pool.to_text(simple), "cos(p + q)");
    let is_enough = |nodes: &u64| pool.simplify_within(&[short], *nodes) == [simple];
    let needed = (0..1_000_000).find(is_enough).expect("some budget is enough");
    assert!(needed > 10, "{needed}");

    let done = pool.simplify_within(&[short, long], needed.div_ceil(2) + 8);
    assert_eq!(done[0], simple);
    assert!(pool.operation_count(&[done[1]]).shared() > 2);
    let enough = pool.simplify_all(&[short, long]);
    assert_eq!(pool.to_text(enough[1]), "sqrt(a)*exp(cos(p + q))");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, rng_seed: RngSeed::Fixed(1905), ..ProptestConfig::default() })]

    /// Cut off anywhere, the value is the same.
    #[test]
    fn any_budget_keeps_the_value(
        recipe in recipes(crate::common::SMOOTH.to_vec(), 10),
        point in points(),
        nodes in prop_oneof![0u64..200, 0u64..20_000],
    ) {
        let pool = Pool::new();
        let e = recipe.build(&pool);
        let done = pool.simplify_within(&[e, pool.neg(e)], nodes);
        let expected = recipe.expected(&point);
        for (root, sign) in done.iter().zip([1.0, -1.0]) {
            let found = sign * value_at(&pool, *root, &point);
            prop_assert!(expected.allows(found), "{}: {} {:?}", pool.to_text(*root), found, expected);
        }
        let certificate = pool.certificate(e, done[0]);
        prop_assert!(certificate.n_points == 0 || certificate.is_equal());
    }
}
