//! Folds of inverse, exponential and hyperbolic functions and of half angles: each input simplifies
//! to a form that costs no more than the one next to it, and keeps its value.

use crate::common::cost;
use bksim_expr::{Expr, Pool};

/// Input and ideal form.
type Row = (&'static str, &'static str);

#[rustfmt::skip]
const FOLDS: [Row; 44] = [
    // Functions of inverse functions.
    ("tan(atan(x))",                                "x"),
    ("sin(atan(x))",                                "x/sqrt(1 + x^2)"),
    ("cos(atan(x))",                                "1/sqrt(1 + x^2)"),
    ("sin(2*atan(x))",                              "2*x/(1 + x^2)"),
    ("cos(2*atan(x))",                              "(1 - x^2)/(1 + x^2)"),
    ("sin(2*asin(x))",                              "2*x*sqrt(1 - x^2)"),
    ("sin(2*acos(x))",                              "2*x*sqrt(1 - x^2)"),
    ("cos(asin(x))",                                "sqrt(1 - x^2)"),
    ("sin(acos(x))",                                "sqrt(1 - x^2)"),
    ("tan(asin(x))",                                "x/sqrt(1 - x^2)"),
    ("a*cos(asin(x)) + b*cos(asin(x))",             "(a + b)*sqrt(1 - x^2)"),
    ("sin(atan2(y, 2))",                            "y/sqrt(y^2 + 4)"),
    ("cos(atan2(y, x^2 + 1))*(x^2 + 1)",            "(x^2 + 1)^2/sqrt((x^2 + 1)^2 + y^2)"),
    ("sqrt(x^2)",                                   "abs(x)"),
    // Exponentials.
    ("exp(x)*exp(y)",                               "exp(x + y)"),
    ("exp(x)*exp(-x)",                              "1"),
    ("exp(x)/exp(y)",                               "exp(x - y)"),
    ("exp(x)^2*exp(y)^3",                           "exp(2*x + 3*y)"),
    ("ln(exp(x))",                                  "x"),
    ("ln(exp(x)*exp(y))",                           "x + y"),
    ("exp(ln(x^2 + 1))",                            "x^2 + 1"),
    ("exp(ln(abs(x)))",                             "abs(x)"),
    ("sqrt(exp(x))",                                "exp(x/2)"),
    ("(exp(x) + 1)^2 - exp(2*x) - 1",               "2*exp(x)"),
    ("exp(x)*(a*exp(-x) + b*exp(x))",               "a + b*exp(2*x)"),
    // Hyperbolic functions.
    ("cosh(x)^2 - sinh(x)^2",                       "1"),
    ("a*cosh(x)^2 - a*sinh(x)^2",                   "a"),
    ("sinh(x)*cosh(y) + cosh(x)*sinh(y)",           "sinh(x + y)"),
    ("sinh(x)*cosh(y) - cosh(x)*sinh(y)",           "sinh(x - y)"),
    ("cosh(x)*cosh(y) + sinh(x)*sinh(y)",           "cosh(x + y)"),
    ("2*sinh(x)*cosh(x)",                           "sinh(2*x)"),
    ("cosh(x)^2 + sinh(x)^2",                       "cosh(2*x)"),
    ("sinh(x)/cosh(x)",                             "tanh(x)"),
    ("tanh(x)*cosh(x)",                             "sinh(x)"),
    ("(exp(x) + exp(-x))/2",                        "cosh(x)"),
    ("cosh(x) + sinh(x)",                           "exp(x)"),
    // Half angles.
    ("2*tan(q/2)/(1 + tan(q/2)^2)",                 "sin(q)"),
    ("(1 - tan(q/2)^2)/(1 + tan(q/2)^2)",           "cos(q)"),
    ("l*(1 - tan(q/2)^2)/(1 + tan(q/2)^2) + l",     "l*(1 + cos(q))"),
    ("a/(1 + tan(q)^2)",                            "a*cos(q)^2"),
    ("1/(1 + tan(q)^2) + 1/(1 + cos(q)^2/sin(q)^2)", "1"),
    ("sin(q)/cos(q)",                               "tan(q)"),
    ("tan(q)*cos(q)",                               "sin(q)"),
    ("2*sin(q/2)*cos(q/2)",                         "sin(q)"),
];

#[test]
fn functions_fold_to_the_ideal_cost() {
    let mut worse = Vec::new();
    for (input, ideal) in FOLDS {
        let pool = Pool::new();
        let [e, ideal] = [input, ideal].map(|text| pool.parse(text).expect(text));
        assert!(pool.certificate(e, ideal).is_equal(), "the row itself is wrong: {input}");
        let simple = pool.simplify(e);
        let certificate = pool.certificate(e, simple);
        assert!(certificate.is_equal(), "{input}: {} {certificate:?}", pool.to_text(simple));
        if cost(&pool, simple) > cost(&pool, ideal) {
            worse.push(format!("{input} gave {}", pool.to_text(simple)));
        }
    }
    assert!(worse.is_empty(), "{} of {}: {worse:#?}", worse.len(), FOLDS.len());
}

/// Rules that would give another value, or one where there was none, somewhere.
#[test]
fn what_holds_somewhere_only_stays() {
    for (text, at) in [
        ("asin(sin(x))", 2.0),
        ("acos(cos(x))", -1.0),
        ("atan(tan(x))", 2.0),
        ("sin(asin(x))", 2.0),
        ("exp(ln(x))", -1.0),
        ("ln(x^2)", -1.0),
        ("sqrt(x)^2", -1.0),
        ("sin(atan2(x, x))", 0.0),
        ("cos(atan2(0*x, x))", 0.0),
    ] {
        let pool = Pool::new();
        let e = pool.parse(text).expect(text);
        let value = |e| pool.evaluate(e, &|_| Some(at)).expect("bound");
        let (before, after) = (value(e), value(pool.simplify(e)));
        let is_same = (before - after).abs() < 1e-15 || before.is_nan() && after.is_nan();
        assert!(is_same, "{text} at {at}: {before} became {after}");
    }
}

/// Positions of a chain by recursion, x' = x cos q − y sin q and its like: short because each is
/// made of the one before.
fn chain(pool: &Pool, n: usize) -> Vec<Expr> {
    let name = |letter: &str, i: usize| pool.symbol(&format!("{letter}{i}"));
    let (mut x, mut y) = (pool.zero(), pool.zero());
    let mut all = Vec::new();
    for i in 0..n {
        let (c, s) = (pool.cos(name("q", i)), pool.sin(name("q", i)));
        let along = pool.add(x, name("l", i));
        (x, y) = (
            pool.sub(pool.mul(along, c), pool.mul(y, s)),
            pool.add(pool.mul(along, s), pool.mul(y, c)),
        );
        all.extend([x, y]);
    }
    all
}

#[test]
fn outputs_together_never_grow() {
    for n in 2..9 {
        let pool = Pool::new();
        let outputs = chain(&pool, n);
        let simple = pool.simplify_all(&outputs);
        let [before, after] =
            [&outputs, &simple].map(|roots| pool.operation_count(roots).operations().total());
        assert!(after <= before, "{n} links: {before} operations became {after}");
        for (&a, &b) in outputs.iter().zip(&simple) {
            assert!(pool.certificate(a, b).is_equal(), "{}", pool.to_text(b));
        }
        // One output by itself must not grow either.
        let last = outputs[2 * n - 1];
        let count = |e| pool.operation_count(&[e]).operations().total();
        assert!(count(pool.simplify(last)) <= count(last), "the last of {n} links");
    }
}

#[test]
fn outputs_that_gain_are_simplified_beside_those_that_do_not() {
    let pool = Pool::new();
    let mut outputs = chain(&pool, 6);
    outputs.push(pool.parse("a*cos(p)*cos(r) - a*sin(p)*sin(r)").expect("valid"));
    let simple = pool.simplify_all(&outputs);
    assert_eq!(pool.to_text(simple[12]), "a*cos(p + r)");
}
