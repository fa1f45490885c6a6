//! Cancellation: what is cancelled, and under which conditions.

use bksim_expr::{Expr, Pool};

/// Input, result, what must not be zero, what must not be negative.
type Row = (&'static str, &'static str, &'static [&'static str], &'static [&'static str]);

#[rustfmt::skip]
const ROWS: [Row; 22] = [
    ("x/x",                               "1",                 &["x"],          &[]),
    ("a*b/(a*c)",                         "b/c",               &["a"],          &[]),
    ("(a^2 - b^2)/(a - b)",               "a + b",             &["a - b"],      &[]),
    ("(a^2 - b^2)/(b - a)",               "-a - b",            &["a - b"],      &[]),
    ("(x^3 - y^3)/(x^2 - y^2)",           "(x*(x + y) + y^2)/(x + y)", &["x - y"], &[]),
    ("(a*x + a*y)/(x + y)",               "a",                 &["x + y"],      &[]),
    ("x^3/x",                             "x^2",               &["x"],          &[]),
    ("x/x + y",                           "y + 1",             &["x"],          &[]),
    ("a/(a + b) + b/(a + b)",             "1",                 &["a + b"],      &[]),
    ("x/(x/y)",                           "y",                 &["x"],          &[]),
    ("(2*x + 4*y)/(6*x*z + 12*y*z)",      "1/(3*z)",           &["x + 2*y"],    &[]),
    ("(x/2 + y/3)/(3*x + 2*y)",           "1/6",               &["3*x + 2*y"],  &[]),
    ("sin((x^2 - 1)/(x - 1))",            "sin(x + 1)",        &["x - 1"],      &[]),
    ("exp(x)*y/(exp(x)*z)",               "y/z",               &[],             &[]),
    ("(m*x + n*x)*k/((m + n)*l)",         "k*x/l",             &["m + n"],      &[]),
    ("exp(ln(x))",                        "x",                 &[],             &["x"]),
    ("sin(asin(x))",                      "x",                 &[],             &["1 - x^2"]),
    ("sqrt(x)^2",                         "x",                 &[],             &["x"]),
    ("cos(asin(x))^2 + x^2",              "1",                 &[],             &["1 - x^2"]),
    ("sin(atan2(y, x))",                  "y/sqrt(x^2 + y^2)", &["x^2 + y^2"],  &[]),
    ("cos(atan2(y, x))*sqrt(x^2 + y^2)",  "x",                 &["x^2 + y^2"],  &[]),
    ("a + b",                             "a + b",             &[],             &[]),
];

#[test]
fn what_is_cancelled_states_its_condition() {
    for (input, expected, nonzero, not_negative) in ROWS {
        let pool = Pool::new();
        let e = pool.parse(input).expect(input);
        let cancelled = pool.cancel(&[e]);
        let found = cancelled.roots[0];
        assert_eq!(
            found,
            pool.parse(expected).expect(expected),
            "{input}: {}",
            pool.to_text(found)
        );
        assert!(pool.certificate(e, found).is_equal(), "{input}");
        let check = |conditions: &[Expr], expected: &[&str]| {
            let missing = |text: &&&str| {
                let e = pool.parse(text).expect(text);
                !conditions.contains(&e) && !conditions.contains(&pool.neg(e))
            };
            let texts: Vec<String> = conditions.iter().map(|&e| pool.to_text(e)).collect();
            assert!(expected.iter().find(missing).is_none(), "{input}: {texts:?}");
            assert_eq!(texts.len(), expected.len(), "{input}: {texts:?}");
        };
        check(&cancelled.nonzero, nonzero);
        check(&cancelled.not_negative, not_negative);
    }
}

/// Where the conditions hold, the values are the same; where they do not, they need not be.
#[test]
fn the_values_are_the_same_under_the_conditions() {
    let values = [-2.0, -1.0, -0.5, 0.0, 0.25, 1.0, 3.0];
    for (input, ..) in ROWS {
        let pool = Pool::new();
        let e = pool.parse(input).expect(input);
        let cancelled = pool.cancel(&[e]);
        let mut n_compared = 0;
        for k in 0..200usize {
            let at = |e| {
                let value = |s: bksim_expr::SymbolId| {
                    let name = pool.symbol_name(s).as_bytes()[0];
                    Some(values[(k * usize::from(name) + k / 7 + usize::from(name) % 5) % 7])
                };
                pool.evaluate(e, &value).expect("bound")
            };
            let holds = cancelled.nonzero.iter().all(|&c| at(c) != 0.0)
                && cancelled.not_negative.iter().all(|&c| at(c) >= 0.0);
            let (before, after) = (at(e), at(cancelled.roots[0]));
            let is_same = (before - after).abs() <= 1e-12 * before.abs().max(1.0);
            let has_none = !before.is_finite() && !after.is_finite();
            assert!(!holds || is_same || has_none, "{input}: {before} and {after}");
            n_compared += usize::from(holds && is_same);
        }
        assert!(n_compared > 5, "{input}");
    }
}

#[test]
fn large_quotients_end_in_time() {
    let pool = Pool::new();
    let sum = |letter: &str| -> Expr {
        pool.sum((0..9).map(|i| pool.symbol(&format!("{letter}{i}"))).collect::<Vec<_>>())
    };
    let (a, b) = (sum("a"), sum("b"));
    let e = pool.div(
        pool.sub(pool.powi(a, 6), pool.powi(b, 6)),
        pool.mul(pool.sub(a, b), pool.powi(pool.add(a, pool.one()), 5)),
    );
    let cancelled = pool.cancel(&[e]);
    assert!(pool.certificate(e, cancelled.roots[0]).is_equal());
}
