//! Taylor polynomials and linear equations.

use bksim_expr::{Expr, Pool, SolveError, SymbolId};

fn id(pool: &Pool, name: &str) -> SymbolId {
    pool.symbol_id(pool.symbol(name)).expect("a symbol")
}

#[test]
fn series_match_the_textbook() {
    let check = |text: &str, about: &str, order: u32, expected: &str| {
        let pool = Pool::new();
        let [e, about, expected] = [text, about, expected].map(|t| pool.parse(t).expect(t));
        let series = pool.series(e, id(&pool, "x"), about, order);
        assert_eq!(series, expected, "{text}: {}", pool.to_text(series));
    };
    check("sin(x)", "0", 5, "x - x^3/6 + x^5/120");
    check("cos(x + a)", "-a", 2, "1 - (x + a)^2/2");
    check("ln(x)", "1", 3, "(x - 1) - (x - 1)^2/2 + (x - 1)^3/3");
    check("1/x", "a", 1, "1/a - (x - a)/a^2");
    check("x^2 + y", "0", 7, "x^2 + y");
    check("y", "3", 2, "y");
}

/// Solves, and puts the solution back into the equations.
fn check_solves(texts: &[&str], unknowns: &[&str]) {
    let pool = Pool::new();
    let equations: Vec<Expr> = texts.iter().map(|t| pool.parse(t).expect(t)).collect();
    let ids: Vec<SymbolId> = unknowns.iter().map(|name| id(&pool, name)).collect();
    let solution = pool.solve_linear(&equations, &ids).expect("has a solution");
    let map: Vec<_> = ids.iter().copied().zip(solution.values).collect();
    for (&e, text) in equations.iter().zip(texts) {
        let rest = pool.substitute(e, &map);
        let certificate = pool.certificate(rest, pool.zero());
        assert!(certificate.is_equal(), "{text} leaves {}: {certificate:?}", pool.to_text(rest));
    }
}

#[test]
fn solutions_satisfy_their_equations() {
    check_solves(&["a*x - b"], &["x"]);
    check_solves(&["x + y - 3", "x - y - 1"], &["x", "y"]);
    check_solves(&["a*x + b*y - u", "c*x + d*y - v"], &["x", "y"]);
    check_solves(&["y - 1", "x*cos(q) + y*sin(q) - 2"], &["x", "y"]);
    check_solves(&["a*x + y + z - 1", "x + b*y + z - 2", "x + y + c*z - u"], &["x", "y", "z"]);
    check_solves(
        &["m11*a1 + m12*a2 - l1 - f1", "m12*a1 + m22*a2 - g*l1 - f2", "a1 + g*a2 - h"],
        &["a1", "a2", "l1"],
    );
    // One equation too many that agrees.
    check_solves(&["x - a", "2*x - 2*a"], &["x"]);
}

#[test]
fn pivots_that_may_be_zero_are_stated() {
    let pool = Pool::new();
    let equations = ["a*x + y - 1", "y - 2"].map(|t| pool.parse(t).expect(t));
    let unknowns = ["x", "y"].map(|name| id(&pool, name));
    let solution = pool.solve_linear(&equations, &unknowns).expect("regular");
    assert_eq!(solution.nonzero, [pool.symbol("a")]);
    assert_eq!(solution.values, [pool.parse("-1/a").expect("valid"), pool.int(2)]);
}

#[test]
fn faults_say_which_equation() {
    let fault = |texts: &[&str], unknowns: &[&str]| {
        let pool = Pool::new();
        let equations: Vec<Expr> = texts.iter().map(|t| pool.parse(t).expect(t)).collect();
        let ids: Vec<SymbolId> = unknowns.iter().map(|name| id(&pool, name)).collect();
        pool.solve_linear(&equations, &ids).expect_err("no unique solution")
    };
    assert_eq!(fault(&["x - 1", "x*y - 1"], &["x", "y"]), SolveError::NotLinear { equation: 1 });
    assert_eq!(fault(&["sin(x)"], &["x"]), SolveError::NotLinear { equation: 0 });
    assert_eq!(fault(&["abs(x) - 1"], &["x"]), SolveError::NotLinear { equation: 0 });
    assert_eq!(fault(&["x - 1", "x - 2"], &["x"]), SolveError::Contradiction { equation: 1 });
    assert!(matches!(fault(&["x - a", "x - b"], &["x"]), SolveError::Conditional { .. }));
    assert!(matches!(fault(&["x + y"], &["x", "y"]), SolveError::Undetermined { .. }));
    assert!(matches!(fault(&["x"], &["x", "x"]), SolveError::Repeated { .. }));
    // Singular, though no coefficient is the number 0 before it is simplified.
    let singular = ["a*x + b*y - 1", "a*c*x + b*c*y - 2"];
    assert!(matches!(fault(&singular, &["x", "y"]), SolveError::Undetermined { .. }));
}
