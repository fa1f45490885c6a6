//! Certificates distinguish equal expressions from different ones.

use bksim_expr::{Certificate, Pool};

fn certificate(a: &str, b: &str) -> Certificate {
    let pool = Pool::new();
    pool.certificate(pool.parse(a).expect(a), pool.parse(b).expect(b))
}

fn check_equal(a: &str, b: &str) {
    let found = certificate(a, b);
    assert!(found.is_equal() && found.worst_extended < 1e-24, "{a} and {b}: {found:?}");
}

#[test]
fn identities_hold_in_both_precisions() {
    check_equal("sin(2*q)", "2*sin(q)*cos(q)");
    check_equal("tan(q)^2 + 1", "cos(q)^-2");
    check_equal("exp(a + b)", "exp(a)*exp(b)");
    check_equal("ln(exp(a)*exp(b))", "a + b");
    check_equal("cosh(x)^2 - sinh(x)^2", "1");
    check_equal("tanh(x)", "(exp(2*x) - 1)/(exp(2*x) + 1)");
    check_equal("sin(atan2(y, x))*sqrt(x^2 + y^2)", "y");
    check_equal("asin(x/2) + acos(x/2)", "pi/2");
    check_equal("(x^2 - y^2)/(x - y)", "x + y");
    check_equal("x^(1/3)*x^(2/3)", "x");
    check_equal("if(lt(x, y), x, y)", "min(x, y)");
    check_equal("sqrt(x^2)", "max(x, -x)");
    check_equal("1e-40*(a + b)", "1e-40*a + 1e-40*b");
}

#[test]
fn small_differences_are_seen() {
    for (a, b) in [
        ("x", "x + 1e-15"),
        ("sin(q)", "sin(q + 1e-16)"),
        ("x*1e-40", "0"),
        ("sin(q)", "q"),
        ("sqrt(x^2)", "x"),
        ("exp(x)", "exp(x)*(1 + 2e-17)"),
        ("x*y - y*x/(1 + 1e-18)", "0"),
    ] {
        let found = certificate(a, b);
        assert!(!found.is_equal() && found.n_points > 0, "{a} and {b}: {found:?}");
    }
}

#[test]
fn without_a_common_point_nothing_is_shown() {
    let found = certificate("sqrt(-1 - x^2)", "sqrt(-1 - x^2)*1");
    assert_eq!((found.n_points, found.is_equal()), (0, false));
    assert_eq!(certificate("1/0", "1/0").n_points, 0);
}

#[test]
fn the_points_depend_on_names_alone() {
    let (pool, other) = (Pool::new(), Pool::new());
    other.sin(other.symbol("z"));
    other.add(other.symbol("b"), other.symbol("a"));
    let compare = |pool: &Pool| {
        let [a, b] = ["sin(a)*sin(b)", "cos(a)"].map(|text| pool.parse(text).expect("valid"));
        pool.certificate(a, b)
    };
    assert_eq!(compare(&pool), compare(&other));
}

#[test]
fn points_are_searched_inside_of_a_domain() {
    for (a, b) in [
        ("ln(y - 10) + ln(2)", "ln(2*y - 20)"),
        ("sqrt(x - 1000)*sqrt(1001 - x)", "sqrt((x - 1000)*(1001 - x))"),
        ("asin(x/500 - 3) + acos(x/500 - 3)", "pi/2"),
        ("ln(x - 20)*sqrt(-30 - y)", "sqrt(-30 - y)*ln(x - 20)"),
        ("(x + 5)*ln(ln(ln(x)))", "x*ln(ln(ln(x))) + 5*ln(ln(ln(x)))"),
    ] {
        let found = certificate(a, b);
        assert!(found.is_equal() && found.n_points >= 4, "{a} and {b}: {found:?}");
        let wrong = certificate(a, &format!("{b} + 1e-9"));
        assert!(!wrong.is_equal() && wrong.n_points >= 4, "{a} and {b}: {wrong:?}");
    }
}
