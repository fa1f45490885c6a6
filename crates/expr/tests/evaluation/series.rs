//! Taylor series of tapes against derivatives by the algebra.

use bksim_expr::{Composition, Function, Pool, Tape, TapeSeries, Value};

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

/// Coefficients of a tape of one input along `x = t` at zero, the operations that they take, and how many are told.
fn of_tape(write: impl Fn(&mut Composition, Value) -> Value) -> (Vec<f64>, usize, usize) {
    let mut line = Composition::new(1, 0);
    let x = line.input(0);
    let output = write(&mut line, x);
    let mut series = TapeSeries::of(&line.finish(&[output])).expect("smooth");
    let mut composition = Composition::new(1, 0);
    let (zero, one) = (composition.constant(0.0), composition.constant(1.0));
    let coefficients = (0..ORDER).map(|order| {
        let x = [Some(composition.input(0)), Some(one)].get(order).copied().flatten();
        series.extend(&mut composition, &[x])[0].unwrap_or(zero)
    });
    let coefficients: Vec<Value> = coefficients.collect();
    let tape = composition.finish(&coefficients);
    let mut out = vec![0.0; ORDER];
    tape.evaluate(&mut tape.workspace(&[]), &[0.0], &mut out);
    (out, tape.operation_count(), series.operation_counts(ORDER)[ORDER - 1])
}

/// `2 eˣ · 3 eˣ = 6 e²ˣ`, of which the coefficients are `6 · 2ᵏ/k!`.
#[test]
fn products_of_multiples_of_one_number_take_the_operations_of_a_square() {
    let (found, n_multiples, _) = of_tape(|line, x| {
        let e = line.apply(Function::Exp, &[x]);
        let [two, three] = [2.0, 3.0].map(|number| line.constant(number));
        let [a, b] = [line.multiply(two, e), line.multiply(e, three)];
        line.multiply(a, b)
    });
    let mut wanted = 6.0;
    for (k, found) in found.iter().enumerate() {
        assert!((found - wanted).abs() < 1e-14 * 6.0, "{k}: {found} is not {wanted}");
        wanted *= 2.0 / (k + 1) as f64;
    }
    let (_, n_product, _) = of_tape(|line, x| {
        let e = line.apply(Function::Exp, &[x]);
        let other = line.add(e, x);
        line.multiply(e, other)
    });
    assert!(n_multiples < n_product, "{n_multiples}, {n_product}");
}

#[test]
fn the_number_of_operations_is_told_before_they_are_written() {
    // The slope of a first exponential has terms that are zero.
    let (_, written, told) = of_tape(|line, x| {
        let e = (0..4).fold(x, |e, _| line.apply(Function::Exp, &[e]));
        let [other, root] = [line.add(e, x), line.apply(Function::Sqrt, &[e])];
        let quotient = line.divide(other, root);
        line.multiply(e, quotient)
    });
    let ratio = told as f64 / written as f64;
    assert!((0.9..1.5).contains(&ratio), "{told} operations are told, {written} written");
}
