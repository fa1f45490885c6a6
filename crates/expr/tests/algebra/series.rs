//! Series at kinks and jumps: what both sides share, and nothing else.

use bksim_expr::Pool;

/// The series of `text` in x about 0, as text.
fn series(text: &str, order: u32) -> Option<String> {
    let pool = Pool::new();
    let e = pool.parse(text).expect(text);
    let x = pool.symbol_id(pool.symbol("x")).expect("a symbol");
    let series = pool.series(e, x, pool.zero(), order);
    (!pool.is_singular(series)).then(|| pool.to_text(series))
}

#[test]
fn a_kink_has_no_series_beyond_what_both_sides_share() {
    for (text, order, expected) in [
        ("abs(x)", 0, Some("0")),
        ("abs(x)", 1, None),
        ("abs(sin(x))", 3, None),
        ("x*abs(x)", 1, Some("0")),
        ("x*abs(x)", 2, None),
        ("abs(x)^3", 2, Some("0")),
        ("abs(x)^3", 3, None),
        ("abs(x^2 + x^4) + x", 2, Some("x + x^2")),
        ("sign(x)", 0, None),
        ("min(x, x^2)", 0, Some("0")),
        ("min(x, x^2)", 1, None),
        ("min(x, 2*x) + max(x, 2*x)", 1, Some("3*x")),
        ("max(x, x + x^3)", 2, Some("x")),
        ("max(x, x + x^3)", 3, None),
        ("if(lt(x, 0), x + x^2, sin(x))", 1, Some("x")),
        ("if(lt(x, 0), x + x^2, sin(x))", 2, None),
        ("if(x, 1 + x, 1)", 1, Some("x + 1")),
        ("if(x, 1 + x, 2)", 1, None),
        // The sign of k decides on which side is which.
        ("abs(k*x)", 1, None),
        // Far from the kink there is none.
        ("abs(x - 2) + abs(x + 2)", 2, Some("4")),
        ("abs(x - 2)", 1, Some("2 - x")),
    ] {
        assert_eq!(series(text, order).as_deref(), expected, "{text} to order {order}");
    }
}
