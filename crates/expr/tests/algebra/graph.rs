//! Passes over the shared graph: derivatives, substitution, tapes, faults, and long chains.

use bksim_expr::{Expr, Function, Pool, SymbolId, Tape, TapeError};

fn symbol(pool: &Pool, name: &str) -> (Expr, SymbolId) {
    let e = pool.symbol(name);
    (e, pool.symbol_id(e).expect("a symbol"))
}

fn check_derivative(text: &str, expected: &str) {
    let pool = Pool::new();
    let (_, x) = symbol(&pool, "x");
    let derivative = pool.diff(pool.parse(text).expect(text), x);
    assert_eq!(derivative, pool.parse(expected).expect(expected), "{}", pool.to_text(derivative));
}

#[test]
fn derivatives_follow_the_textbook() {
    check_derivative("3", "0");
    check_derivative("x^5*y", "5*x^4*y");
    check_derivative("1/x", "-x^-2");
    check_derivative("sin(2*x)*cos(y)", "2*cos(2*x)*cos(y)");
    check_derivative("if(lt(x, 0), x^2, y)", "if(lt(x, 0), 2*x, 0)");
    check_derivative("if(lt(x, 0), z, y)", "0");
    check_derivative("abs(x)", "sign(x)");
    check_derivative("y^x", "y^x*ln(y)");
    check_derivative("exp(x^2)", "2*x*exp(x^2)");
}

#[test]
fn every_function_has_the_derivative_of_its_values() {
    let pool = Pool::new();
    let (x, x_id) = symbol(&pool, "x");
    let y = pool.float(0.35);
    for name in Function::names() {
        let function = Function::from_name(name).expect("from the table");
        let arguments = &[x, y, pool.mul(x, x)][..function.arity()];
        let e = pool.call(function, arguments).expect("the arity of the table");
        let value = |e: Expr, at: f64| pool.evaluate(e, &|_| Some(at)).expect("bound");
        for at in [0.21, 0.64] {
            let h = 1e-5;
            let difference = (value(e, at + h) - value(e, at - h)) / (2.0 * h);
            let exact = value(pool.diff(e, x_id), at);
            assert!(
                (exact - difference).abs() < 1e-8,
                "{name} at {at}: {exact} is not {difference}"
            );
        }
    }
}

#[test]
fn jacobian_lists_structural_entries_row_by_row() {
    let pool = Pool::new();
    let columns = ["x", "y", "z"].map(|name| symbol(&pool, name).1);
    let rows = ["x*y", "3", "z - x + y - y"].map(|text| pool.parse(text).expect(text));
    let jacobian = pool.jacobian(&rows, &columns);
    let listed: Vec<_> =
        jacobian.entries.iter().map(|&(i, j, e)| (i, j, pool.to_text(e))).collect();
    let expected =
        [(0, 0, "y"), (0, 1, "x"), (2, 0, "-1"), (2, 2, "1")].map(|(i, j, t)| (i, j, t.to_owned()));
    assert_eq!(listed, expected);
    assert_eq!(pool.gradient(rows[0], &columns), [pool.symbol("y"), pool.symbol("x"), pool.zero()]);
}

#[test]
fn total_derivative_is_the_gradient_along_the_rates() {
    let pool = Pool::new();
    let (x, y) = (symbol(&pool, "x").1, symbol(&pool, "y").1);
    let rates = [(x, pool.symbol("vx")), (y, pool.symbol("vy"))];
    let e = pool.parse("x^2*sin(y)").expect("valid");
    let expected = pool.parse("2*x*sin(y)*vx + x^2*cos(y)*vy").expect("valid");
    assert_eq!(pool.total_derivative(e, &rates), expected);
}

#[test]
fn substitution_is_simultaneous() {
    let pool = Pool::new();
    let ((x, x_id), (y, y_id)) = (symbol(&pool, "x"), symbol(&pool, "y"));
    let e = pool.parse("x - 2*y + sin(x - y)").expect("valid");
    let swapped = pool.substitute(e, &[(x_id, y), (y_id, x)]);
    assert_eq!(swapped, pool.parse("y - 2*x + sin(y - x)").expect("valid"));
    assert!(pool.depends_on(e, x_id) && pool.symbols_of(e) == [x_id, y_id]);
    assert_eq!(pool.substitute(e, &[(x_id, y)]), pool.neg(y));
}

#[test]
fn faults_name_the_first_operation_without_a_value() {
    let check = |text: &str, operation: &str, operands: &[f64]| {
        let pool = Pool::new();
        let value = |symbol| Some(if pool.symbol_name(symbol) == "zero" { 0.0 } else { -2.0 });
        let fault = pool.domain_fault(pool.parse(text).expect(text), &value).expect(text);
        assert_eq!((fault.operation, fault.operands.as_slice()), (operation, operands), "{text}");
    };
    check("1 + sqrt(x)", "sqrt", &[-2.0]);
    check("x/(zero*x)", "division", &[0.0]);
    check("3/0", "division", &[0.0]);
    check("exp(ln(zero))", "ln", &[0.0]);
    check("asin(x)*2", "asin", &[-2.0]);
    check("x^(1/3)", "power", &[-2.0, 1.0 / 3.0]);
    let pool = Pool::new();
    let guarded = pool.parse("if(gt(x, 0), sqrt(x), 0)").expect("valid");
    assert_eq!(pool.domain_fault(guarded, &|_| Some(-1.0)), None);
}

#[test]
fn special_values_behave_as_floats_do() {
    let pool = Pool::new();
    let (x, _) = symbol(&pool, "x");
    let at = |e: Expr, value: f64| pool.evaluate(e, &|_| Some(value)).expect("bound");
    assert!(at(pool.div(x, x), 0.0).is_nan());
    assert_eq!(at(pool.powi(x, -1), -0.0), f64::NEG_INFINITY);
    assert!(at(pool.sqrt(x), -0.0).is_sign_negative());
    assert_eq!(at(pool.atan2(x, pool.int(-1)), -0.0), -std::f64::consts::PI);
    assert!(at(pool.sin(x), f64::INFINITY).is_nan());
    assert_eq!(
        pool.as_number(pool.float(-0.0)).map(|n| n.to_f64().to_bits()),
        Some((-0.0f64).to_bits())
    );
}

#[test]
fn tape_computes_shared_parts_once_and_parameters_in_advance() {
    let pool = Pool::new();
    let (x, m, k) = (symbol(&pool, "x").1, symbol(&pool, "m").1, symbol(&pool, "k").1);
    let outputs =
        ["sin(x)*sqrt(k/m)", "sin(x)^2*sqrt(k/m) + x", "k/m"].map(|t| pool.parse(t).expect(t));
    let tape = Tape::compile(&pool, &outputs, &[x], &[m, k]).expect("all bound");
    // sin x, two products, the square, one sum; sqrt(k/m) and k/m are known before.
    assert_eq!((tape.operation_count(), tape.len()), (5, 7));
    let mut out = [0.0; 3];
    tape.evaluate(&mut tape.workspace(&[2.0, 8.0]), &[0.5], &mut out);
    let s = 0.479_425_538_604_203; // sin(0.5)
    assert_eq!(out, [2.0 * s, 2.0 * (s * s) + 0.5, 4.0]);
    let fault = Tape::compile(&pool, &outputs, &[x], &[m]).expect_err("k is unbound");
    assert_eq!(fault, TapeError::Unbound { symbol: k, name: "k".to_owned() });
}
