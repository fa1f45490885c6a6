//! The contract of `simplify`: bounded work, a result whatever happens, and a report.

use crate::common::{points, recipes, value_at};
use bksim_expr::{Budget, Expr, Limit, Pool};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::time::Duration;

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
        for nodes in [3_000, Budget::default().nodes] {
            let before = pool.len() as u64;
            let done = pool.simplify_within(&[e], &Budget { nodes, time: None });
            let report = done.report;
            assert!(report.work <= nodes, "{name}: {} of {nodes}", report.work);
            let size = report.before.total();
            let grown = pool.len() as u64 - before;
            assert!(grown <= 8 * (nodes + size), "{name}: {grown} new nodes");
            assert_eq!(report.ended_by.is_some(), report.n_kept > 0, "{name}: {report:?}");
            assert!(done.report.after.total() <= 2 * size, "{name}: {report:?}");
            let again = pool.simplify_within(&[e], &Budget { nodes, time: None });
            assert_eq!(again.roots, done.roots, "{name}");
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
    let needed = pool.simplify_within(&[short], &Budget::default()).report.work;
    let budget = Budget { nodes: needed.div_ceil(2) + 8, time: None };
    let done = pool.simplify_within(&[short, long], &budget);
    assert_eq!(done.report.ended_by, Some(Limit::Nodes));
    assert!(done.report.n_kept > 0);
    assert_eq!(pool.to_text(done.roots[0]), "cos(p + q)");
    assert!(pool.operation_count(&[done.roots[1]]).shared() > 2);

    let enough = pool.simplify_within(&[short, long], &Budget::default());
    assert_eq!(pool.to_text(enough.roots[1]), "sqrt(a)*exp(cos(p + q))");
    assert_eq!((enough.report.ended_by, enough.report.n_kept), (None, 0));
}

#[test]
fn no_time_means_no_change() {
    let pool = Pool::new();
    let e = pool.parse("sin(q)^2 + cos(q)^2").expect("valid");
    let none = Budget { time: Some(Duration::ZERO), ..Budget::default() };
    let done = pool.simplify_within(&[e], &none);
    assert_eq!((done.roots[0], done.report.ended_by), (e, Some(Limit::Time)));
    let ample = Budget { time: Some(Duration::MAX), ..Budget::default() };
    let done = pool.simplify_within(&[e], &ample);
    assert_eq!((done.roots[0], done.report.ended_by), (pool.one(), None));
}

#[test]
fn reports_count_by_kind_shared_and_printed() {
    let pool = Pool::new();
    let e = pool.parse("a*sin(q)*(cos(q)/b + sin(q)) + cos(q)*a*cos(q)").expect("valid");
    let report = pool.simplify_within(&[e, e], &Budget::default()).report;
    let kinds = |n: bksim_expr::Operations| [n.multiplications, n.additions, n.divisions, n.calls];
    // a*(1 + sin(q)*cos(q)/b): one sine and cosine shared by everything before.
    assert_eq!(kinds(report.before), [4, 2, 1, 2]);
    assert_eq!(kinds(report.printed_before), [8, 4, 2, 8]);
    assert!(report.after.total() <= report.before.total());
    assert!(report.printed_after.total() < report.printed_before.total());
    assert!(report.work > 0);
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
        let done = pool.simplify_within(&[e, pool.neg(e)], &Budget { nodes, time: None });
        prop_assert!(done.report.work <= 2 * nodes);
        let expected = recipe.expected(&point);
        for (root, sign) in done.roots.iter().zip([1.0, -1.0]) {
            let found = sign * value_at(&pool, *root, &point);
            prop_assert!(expected.allows(found), "{}: {} {:?}", pool.to_text(*root), found, expected);
        }
        prop_assert!(done.certificates(&pool, &[e, pool.neg(e)]).iter().all(|c| c.n_points == 0 || c.is_equal()));
    }
}
