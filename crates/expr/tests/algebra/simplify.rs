//! Rules of simplification beyond the folding suite.

use bksim_expr::{Expr, Pool, SymbolId};

fn check_simplified(text: &str, expected: &str) {
    let pool = Pool::new();
    let simple = pool.simplify(pool.parse(text).expect(text));
    assert_eq!(pool.to_text(simple), expected, "from {text}");
    assert_eq!(pool.simplify(simple), simple, "a second pass changes {expected}");
}

#[test]
fn quotients_of_sine_and_cosine_fold() {
    check_simplified("sin(q)/cos(q)", "tan(q)");
    check_simplified("(1 - sin(q)^2)/cos(q)", "cos(q)");
    check_simplified("tan(q)^2*cos(q)^2 + cos(q)^2", "1");
}

#[test]
fn folds_reach_into_roots_divisors_and_arguments() {
    check_simplified("sqrt(1 - sin(q)^2)", "abs(cos(q))");
    check_simplified("exp(a*sin(q)^2 + a*cos(q)^2)", "exp(a)");
    check_simplified("b/(a*sin(q)^2 + a*cos(q)^2)", "b/a");
    check_simplified("atan2(a*x + a*y, x*b + y*b)", "atan2(a*(x + y), b*(x + y))");
}

#[test]
fn what_can_be_zero_does_not_cancel() {
    check_simplified("x/x", "x/x");
    check_simplified("(a*x + a*y)/(x + y)", "a*(x + y)/(x + y)");
}

#[test]
fn expand_multiplies_out() {
    let pool = Pool::new();
    let expanded = pool.expand(pool.parse("(a + b)^2*(a - b) - a^3").expect("valid"));
    assert_eq!(expanded, pool.parse("a^2*b - a*b^2 - b^3").expect("valid"));
}

/// The mass matrix of a planar chain of `n` links, from its kinetic energy in relative angles.
fn chain_mass_matrix(pool: &Pool, n: usize) -> Vec<Expr> {
    let name = |letter: &str, i: usize| pool.symbol(&format!("{letter}{i}"));
    let id = |e: Expr| pool.symbol_id(e).expect("a symbol");
    let (mut angle, mut x, mut y) = (pool.zero(), pool.zero(), pool.zero());
    let mut rates: Vec<(SymbolId, Expr)> = Vec::new();
    let mut energy = Vec::new();
    for i in 0..n {
        rates.push((id(name("q", i)), name("v", i)));
        angle = pool.add(angle, name("q", i));
        let reach =
            |from: Expr, length: Expr, direction: Expr| pool.add(from, pool.mul(length, direction));
        let (c, s) = (pool.cos(angle), pool.sin(angle));
        let (cx, cy) = (reach(x, name("a", i), c), reach(y, name("a", i), s));
        let squares = [cx, cy].map(|p| pool.powi(pool.total_derivative(p, &rates), 2));
        energy.push(pool.product([pool.rational(1, 2), name("m", i), pool.sum(squares)]));
        (x, y) = (reach(x, name("l", i), c), reach(y, name("l", i), s));
    }
    let speeds: Vec<SymbolId> = (0..n).map(|i| id(name("v", i))).collect();
    let momenta = pool.gradient(pool.sum(energy), &speeds);
    momenta.into_iter().flat_map(|p| pool.gradient(p, &speeds)).collect()
}

#[test]
fn mass_matrix_of_a_chain_becomes_short_and_stays_symmetric() {
    let pool = Pool::new();
    let matrix = chain_mass_matrix(&pool, 6);
    let simple = pool.simplify_all(&matrix);
    for i in 0..6 {
        for j in 0..6 {
            assert_eq!(simple[6 * i + j], simple[6 * j + i], "row {i}, column {j}");
        }
    }
    let (before, after) = (pool.operation_count(&matrix), pool.operation_count(&simple));
    assert!(5 * after.as_printed < 3 * before.as_printed, "{after:?} against {before:?}");
    // The first link's angle drops out: inertia does not depend on where the chain points.
    let q0 = pool.find_symbol("q0").expect("used");
    assert!(simple.iter().all(|&entry| !pool.depends_on(entry, q0)));
}
