//! Taylor series of tapes against derivatives by the algebra.

use bksim_expr::{Composition, Pool, Tape, TapeSeries};

const ORDER: usize = 9;

/// Coefficients of `text` along `x = x0 + t`, by the rules of series.
fn series(text: &str, x0: f64, k: f64) -> Option<Vec<f64>> {
    let pool = Pool::new();
    let e = pool.parse(text).expect("valid");
    let [x, parameter] = ["x", "k"].map(|name| {
        pool.symbol(name);
        pool.find_symbol(name).expect("just made")
    });
    let tape = Tape::compile(&pool, &[e], &[x], &[parameter]).expect("bound");
    let mut series = TapeSeries::of(&tape)?;
    let mut composition = Composition::new(1, 1);
    let (zero, one) = (composition.constant(0.0), composition.constant(1.0));
    let coefficients = (0..ORDER).map(|order| {
        let x = [Some(composition.input(0)), Some(one)].get(order).copied().flatten();
        series.extend(&mut composition, &[x])[0].unwrap_or(zero)
    });
    let coefficients: Vec<_> = coefficients.collect();
    let tape = composition.finish(&coefficients);
    let mut out = vec![0.0; ORDER];
    tape.evaluate(&mut tape.workspace(&[k]), &[x0], &mut out);
    Some(out)
}

/// The same by derivatives, one after the other.
fn derivatives(text: &str, x0: f64, k: f64) -> Vec<f64> {
    let pool = Pool::new();
    let mut e = pool.parse(text).expect("valid");
    let [x, parameter] = ["x", "k"].map(|name| {
        pool.symbol(name);
        pool.find_symbol(name).expect("just made")
    });
    let mut factorial = 1.0;
    (0..ORDER)
        .map(|order| {
            if order > 0 {
                e = pool.simplify(pool.diff(e, x));
                factorial *= order as f64;
            }
            let tape = Tape::compile(&pool, &[e], &[x], &[parameter]).expect("bound");
            let mut out = [0.0];
            tape.evaluate(&mut tape.workspace(&[k]), &[x0], &mut out);
            out[0] / factorial
        })
        .collect()
}

#[test]
fn every_smooth_function_has_the_series_that_its_derivatives_give() {
    let texts = [
        "k*x - 2 + x/3",
        "x*x*(x + k)",
        "(x - k)*(x + 1)*x",
        "1/(1 + x*x)",
        "k/x",
        "(x + 1)/(x*x + k)",
        "x^3 - x^(-2)",
        "x^7",
        "x^2.5",
        "x^k",
        "k^x",
        "(1 + x)^(x/2)",
        "sqrt(1 + x^2)",
        "sin(k*x) + cos(x)*cos(x)",
        "sin(x^2)*cos(sin(x))",
        "tan(x)",
        "asin(x/3)",
        "acos(x/3)",
        "atan(2*x)",
        "atan2(x, 1 + x*x)",
        "atan2(sin(x), k - x)",
        "sinh(x)*cosh(2*x)",
        "tanh(x)",
        "exp(-x^2)",
        "ln(1 + x) + ln(k)*x",
        "abs(k)*x",
    ];
    for text in texts {
        for x0 in [0.37, 1.1] {
            let (found, wanted) = (series(text, x0, 2.3), derivatives(text, x0, 2.3));
            let found = found.expect(text);
            let size = wanted.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
            for (order, (a, b)) in found.iter().zip(&wanted).enumerate() {
                assert!((a - b).abs() < 1e-11 * size, "{text} at {x0}, {order}: {a} is not {b}");
            }
        }
    }
}

#[test]
fn kinks_of_what_changes_have_no_series() {
    for text in ["abs(x)", "max(x, k)", "floor(x)*x", "if(x < 1, x, 1)", "sign(x)"] {
        assert_eq!(series(text, 0.37, 2.3), None, "{text}");
    }
}
