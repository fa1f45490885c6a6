//! A million nodes in one chain pass through everything: no pass recurses, none goes quadratic.

use bksim_expr::{Expr, Pool, Quantity, Signature, SymbolId, Tape};

fn symbol(pool: &Pool, name: &str) -> (Expr, SymbolId) {
    let e = pool.symbol(name);
    (e, pool.symbol_id(e).expect("a symbol"))
}

/// Takes a chain over `x` and `y` through every pass, and holds the values together.
fn check_passes(pool: &Pool, e: Expr) {
    let (x, y) = (symbol(pool, "x").1, symbol(pool, "y").1);
    let nodes = pool.len();
    let value =
        |e: Expr| pool.evaluate(e, &|s| Some(if s == x { 0.3 } else { 0.4 })).expect("bound");
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(1e-3) || a.is_nan();

    let derivative = pool.diff(e, x);
    let gradient = pool.gradient(e, &[x, y]);
    assert!(close(value(derivative), value(gradient[0])), "gradient");
    let second = pool.jvp(&[e], &[x, y], &[pool.zero(), pool.one()]);
    assert!(close(value(gradient[1]), value(second[0])), "jvp");
    let adjoint = pool.vjp(&[e], &[pool.int(2)], &[x]);
    assert!(close(2.0 * value(derivative), value(adjoint[0])), "vjp");

    assert!(close(value(e), value(pool.simplify_all(&[e])[0])), "simplified");
    assert!(close(value(e), value(pool.expand(e))), "expanded");
    let replaced = pool.substitute(e, &[(x, pool.symbol("z"))]);
    assert!(!pool.depends_on(replaced, x));

    assert!(pool.to_text(e).len() > 50_000 && pool.to_latex(e).len() > 50_000);

    let tape = Tape::compile(pool, &[e, derivative], &[x], &[y]).expect("all bound");
    let mut out = [0.0; 2];
    tape.evaluate(&mut tape.workspace(&[0.4]), &[0.3], &mut out);
    assert!(close(value(e), out[0]) && close(value(derivative), out[1]), "{out:?}");
    let named = |names: &[&str]| names.iter().map(|name| Quantity::new(name, "")).collect();
    let (inputs, parameters, outputs) = (named(&["x"]), named(&["y"]), named(&["f", "slope"]));
    let signature = Signature { name: "chain".to_owned(), inputs, parameters, outputs };
    let program = tape.program(&signature).expect("valid names");
    assert!(program.to_c().source.len() > tape.len());

    // Every pass together leaves a small multiple of what it started from.
    let grown = pool.len() / nodes;
    assert!(grown < 40, "{grown} times the nodes");
}

/// One derivative, one simplification, text, code.
#[test]
fn a_million_alternating_operations() {
    let pool = Pool::new();
    let e = alternating(&pool, 1_000_000);
    let (x, y) = (symbol(&pool, "x").1, symbol(&pool, "y").1);
    let slope = pool.diff(e, x);
    let simple = pool.simplify(e);
    assert!(pool.to_text(simple).len() > 1_000_000);
    let tape = Tape::compile(&pool, &[e, simple, slope], &[x], &[y]).expect("all bound");
    let mut out = [0.0; 3];
    tape.evaluate(&mut tape.workspace(&[0.4]), &[0.3], &mut out);
    assert!((out[0] - out[1]).abs() <= 1e-12 && out[2].is_finite(), "{out:?}");
    let n_nodes = pool.len();
    drop(pool);
    assert!(n_nodes > 1_000_000);
}

fn alternating(pool: &Pool, n_nodes: usize) -> Expr {
    let ((x, _), (y, _)) = (symbol(pool, "x"), symbol(pool, "y"));
    let mut e = x;
    let mut i = 0;
    while pool.len() < n_nodes {
        e = match i % 4 {
            0 => pool.sin(e),
            1 => pool.add(e, y),
            2 => pool.mul(e, x),
            _ => pool.sub(y, e),
        };
        i += 1;
    }
    e
}

#[test]
fn alternating_operations() {
    let pool = Pool::new();
    let e = alternating(&pool, 50_000);
    check_passes(&pool, e);
}

#[test]
fn nested_functions() {
    let pool = Pool::new();
    let ((x, _), (y, _)) = (symbol(&pool, "x"), symbol(&pool, "y"));
    let mut e = pool.add(x, y);
    for i in 0..20_000 {
        e = match i % 5 {
            0 => pool.sin(e),
            1 => pool.sqrt(pool.abs(e)),
            2 => pool.atan(e),
            3 => pool.max(pool.powi(e, 2), y),
            _ => pool.min(e, pool.mul(x, y)),
        };
    }
    check_passes(&pool, e);
}

#[test]
fn sums_term_by_term() {
    let pool = Pool::new();
    let ((x, _), (y, _)) = (symbol(&pool, "x"), symbol(&pool, "y"));
    let mut e = y;
    for i in 0..10_000 {
        e = pool.add(e, pool.mul(pool.rational(1, 1 + i), pool.powi(x, 1 + i % 1000)));
        e = pool.sub(e, pool.sin(pool.mul(pool.int(i), y)));
    }
    check_passes(&pool, e);
}

#[test]
fn products_factor_by_factor() {
    let pool = Pool::new();
    let ((x, _), (y, _)) = (symbol(&pool, "x"), symbol(&pool, "y"));
    let mut e = y;
    for i in 0..4_000 {
        let x = pool.mul(pool.float(1e-6), pool.cos(pool.mul(x, pool.int(i))));
        e = pool.mul(e, pool.add(pool.one(), x));
        e = pool.div(e, pool.add(pool.one(), pool.mul(pool.rational(i, 1_000_000_000), y)));
    }
    check_passes(&pool, e);
}

#[test]
fn many_symbols_in_one_sum() {
    let pool = Pool::new();
    let symbols: Vec<Expr> = (0..150_000).map(|i| pool.symbol(&format!("s{i}"))).collect();
    let sum = pool.sum(symbols.iter().copied());
    assert_eq!(pool.operation_count(&[sum]).additions, 149_999);
    let ids: Vec<SymbolId> = symbols.iter().filter_map(|&s| pool.symbol_id(s)).collect();
    assert!(pool.gradient(sum, &ids).iter().all(|&d| d == pool.one()));
    assert_eq!(pool.simplify(sum), sum);
    // Built one by one it is another chain, of pieces; simplified it is the same.
    let pieces = symbols.iter().fold(pool.zero(), |sum, &s| pool.add(sum, s));
    assert_eq!(pool.simplify(pieces), sum);
    let read = Pool::new();
    let again = read.parse(&pool.to_text(sum)).expect("printed text is valid");
    assert_eq!(read.operation_count(&[again]).additions, 149_999);
}
