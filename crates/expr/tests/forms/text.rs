//! Text in, text out, and faults with their span.

use bksim_expr::{Expr, Function, ParseErrorKind, ParseOptions, Pool, SyntaxKind, parse};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn check_text(text: &str, expected: &str) {
    let pool = Pool::new();
    assert_eq!(pool.to_text(pool.parse(text).expect(text)), expected);
}

#[test]
fn text_reads_like_an_engineer_wrote_it() {
    check_text("x3_dot^2*m3*0.5", "0.5*m3*x3_dot^2");
    check_text("-a + b", "b - a");
    check_text("sin(q)*m*(a + b)/3", "1/3*m*(a + b)*sin(q)");
    check_text("a/(b*c)*d", "a*d/(b*c)");
    check_text("-x/2/y", "-0.5*x/y");
    check_text("1/x", "1/x");
    check_text("q10 + q2 + 1", "q2 + q10 + 1");
    check_text("(a^b)^c", "(a^b)^c");
    check_text("a^(b^c)", "a^(b^c)");
    check_text("(-2)^x", "(-2)^x");
    check_text("2*(a+b)", "2*(a + b)");
    check_text("if(lt(a, b), a, 2*pi)", "if(lt(a, b), a, 2*pi)");
    check_text("m2*g + y2_ddot*m2 + ld2 - ld4", "g*m2 + ld2 - ld4 + m2*y2_ddot");
}

#[test]
fn conditions_are_joined_by_words() {
    let pool = Pool::new();
    let same = |words: &str, signs: &str| {
        assert_eq!(pool.parse(words).expect(words), pool.parse(signs).expect(signs), "{words}");
    };
    same("a < b and c + 1 >= 2*d", "(a < b)*(c + 1 >= 2*d)");
    same("a < 5 or b > 2", "max(lt(a, 5), gt(b, 2))");
    same("not a < b", "1 - (a < b)");
    same("a < b or c < d and e < f", "max(lt(a, b), lt(c, d)*lt(e, f))");
    same("(a < b or c < d) and not e < f", "max(lt(a, b), lt(c, d))*(1 - lt(e, f))");
    same("if(not(a < b) and c < 1, x, y)", "if((1 - (a < b))*(c < 1), x, y)");
    // Names may begin with the words.
    same("android*orbit + nothing", "orbit*android + nothing");
    for wrong in ["and a < b", "a < b and", "a < b or or c < d", "not"] {
        assert!(pool.parse(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn branches_are_chosen_by_words() {
    let pool = Pool::new();
    let same = |words: &str, call: &str| {
        assert_eq!(pool.parse(words).expect(words), pool.parse(call).expect(call), "{words}");
    };
    same("if a < b then c else d", "if(a < b, c, d)");
    same("2*if a then b else c + d", "2*if(a, b, c + d)");
    same("(if a then b else c) + d", "d + if(a, b, c)");
    same("if (a + b)*c > d then b else c", "if((a + b)*c > d, b, c)");
    same("if (a < b) and (c < d) then 1 else 2", "if((a < b)*(c < d), 1, 2)");
    same("if not a < b then x else y", "if(1 - (a < b), x, y)");
    same("if a then b else if c then d else e", "if(a, b, if(c, d, e))");
    same("if a then if b then c else d else e", "if(a, if(b, c, d), e)");
    same("max(if a then b else c, d)", "max(if(a, b, c), d)");
    same("-if a then b else c", "-if(a, b, c)");
    same("iffy*thenar*elsewhere", "elsewhere*iffy*thenar");
    // As deep as parentheses may nest, and no deeper: the text that is printed reads back.
    let nested = |n: usize| format!("{}b{}", "if a then ".repeat(n), " else c".repeat(n));
    let deep = pool.parse(&nested(64)).expect("64 levels");
    assert_eq!(pool.parse(&pool.to_text(deep)), Ok(deep));
    let fault = pool.parse(&nested(65)).expect_err("65 levels");
    assert_eq!(fault.kind, ParseErrorKind::TooDeep { limit: 64 });
}

#[test]
fn signs_of_other_languages_and_of_books_are_read() {
    let pool = Pool::new();
    let same = |text: &str, plain: &str| {
        assert_eq!(pool.parse(text).expect(text), pool.parse(plain).expect(plain), "{text}");
    };
    same("x**2 + 2**-1", "x^2 + 0.5");
    same("x² + 3·y⁻¹ − 2×z¹⁰", "x^2 + 3/y - 2*z^10");
    same("-x²", "-(x^2)");
    same("2^x²", "2^(x^2)");
    same("sin(x)²*(a + b)³", "(a + b)^3*sin(x)^2");
    same("if x ≤ 2 and y ≥ 3 then 1 else 0", "if((x <= 2)*(y >= 3), 1, 0)");
}

#[test]
fn functions_are_made_of_others() {
    check_value("min(3, 1, 2)", 1.0);
    check_value("max(3, 1, 5, 2)", 5.0);
    check_value("step(-1) + 10*step(0) + 100*step(2)", 110.0);
    check_value("hypot(3, 4) + hypot(2, 3, 6)", 12.0);
    check_value("clamp(7, 1, 5) + clamp(-7, 1, 5) + clamp(2, 1, 5)", 8.0);
    check_value("mod(7, 3) + 10*mod(-7, 3)", 21.0);
    check_value("ceil(1.2) + 10*ceil(-1.2) + 100*round(2.5)", 292.0);
    check_value("hypot(min(3, 5, 4), max(1, 4, 2))", 5.0);
    // Written out, they stand in their operands' places.
    let pool = Pool::new();
    let e = pool.parse("min(hypot(a, b), step(c), 2)").expect("valid");
    assert_eq!(pool.to_text(e), "min(min(ge(c, 0), sqrt(a^2 + b^2)), 2)");
    assert_eq!(pool.parse(&pool.to_text(e)), Ok(e));
    let names: Vec<&str> = bksim_expr::function_names().collect();
    assert!(names.contains(&"hypot") && names.iter().filter(|name| **name == "min").count() == 1);
    for wrong in ["step()", "step(1, 2)", "hypot(1)", "clamp(1, 2)", "mod(1)", "min(1)"] {
        assert!(pool.parse(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn units_follow_any_operand() {
    let known = ["m", "s", "N", "kg", "mm", "rad", "deg", "t"];
    let options = ParseOptions {
        is_unit: &|name| known.contains(&name),
        is_name: &|name| name == "m",
        is_variable: &|name| name == "t",
        ..ParseOptions::default()
    };
    let pool = Pool::new();
    // Units as symbols that no name has.
    let read = |text: &str| {
        let syntax = parse(text, &options).expect(text);
        let mut resolve =
            |name: &str, _| Ok::<_, ()>(if name == "pi" { pool.pi() } else { pool.symbol(name) });
        let mut quantity = |value: bksim_expr::Number, factors: &[bksim_expr::UnitFactor], _| {
            let unit = |f: &bksim_expr::UnitFactor| {
                pool.powi(pool.symbol(&format!("{}_", f.name)), i64::from(f.exponent))
            };
            Ok(factors.iter().fold(pool.number(value), |e, factor| pool.mul(e, unit(factor))))
        };
        pool.lower_quantities(&syntax, &mut resolve, &mut quantity).expect(text)
    };
    let same = |text: &str, plain: &str| {
        let plain = pool.parse(plain).expect(plain);
        assert_eq!(read(text), plain, "{text} is {}", pool.to_text(read(text)));
    };
    same("2*pi rad/s*t", "2*pi*rad_/s_*t");
    same("360 deg*t/s", "360*deg_*t/s_");
    same("(a + b) mm", "(a + b)*mm_");
    same("sqrt(2) kg m²/s^2", "sqrt(2)*kg_*m_^2/s_^2");
    same("a^2 N + b^-2 N", "a^2*N_ + b^-2*N_");
    same("-2^2 N", "-4*N_");
    same("1/a N", "1/(a*N_)");
    same("a/s*b", "a/s_*b");
    same("a/N*kg", "a/N_*kg_");
    same("3 kg*m", "3*kg_*m");
    same("3 kg m", "3*kg_*m_");
    same("3 N/m", "3*N_/m_");
    same("a/m", "a/m");
    same("2 t", "2*t_");
    same("2 N*t", "2*N_*t");
    same("if a < 1 then 2 s else a s", "if(a < 1, 2*s_, a*s_)");
    for wrong in ["a m", "a t", "2 N t", "s", "1 + s", "a furlong"] {
        let syntax = parse(wrong, &options);
        let has_unit = |syntax: &bksim_expr::Syntax| {
            let mut nodes = syntax.nodes.iter();
            nodes.any(|node| matches!(node.kind, SyntaxKind::Unit { .. }))
        };
        let is_name_alone = syntax.as_ref().is_ok_and(|syntax| !has_unit(syntax));
        assert!(syntax.is_err() || is_name_alone, "{wrong}");
    }
}

#[test]
fn a_sum_among_terms_needs_no_parentheses() {
    let pool = Pool::new();
    let terms = ["b", "a - 2", "c*(a + b)"].map(|text| pool.parse(text).expect(text));
    assert_eq!(pool.terms_to_text(&terms), "b + a - 2 + c*(a + b)");
}

#[test]
fn terms_keep_the_order_given() {
    let pool = Pool::new();
    let terms = ["x*m", "-ld1", "2*(a - b)", "-3"].map(|t| pool.parse(t).expect(t));
    assert_eq!(pool.terms_to_text(&terms), "m*x - ld1 + 2*(a - b) - 3");
    assert_eq!(pool.terms_to_text(&[]), "0");
}

fn check_value(text: &str, expected: f64) {
    let pool = Pool::new();
    let value = pool.evaluate(pool.parse(text).expect(text), &|_| None).expect(text);
    assert!(
        (value - expected).abs() <= 1e-12 * expected.abs(),
        "{text} is {value}, not {expected}"
    );
}

#[test]
fn operators_bind_as_in_mathematics() {
    check_value("-2^2", -4.0);
    check_value("1 + 1 < 2*2", 1.0);
    check_value("if(3 >= 4 - 1, 5, 6)", 5.0);
    check_value("(2 > 3) + (2 <= 2)", 1.0);
    check_value("2^3^2", 512.0);
    check_value("2^-1", 0.5);
    check_value("2^-3^2*512", 1.0);
    check_value("8/4/2", 1.0);
    check_value("1 - 2 - 3", -4.0);
    check_value("2*-3", -6.0);
    check_value("--3", 3.0);
    check_value("6/2*3", 9.0);
    check_value("1.5e2 + .5", 150.5);
    check_value("min(2, max(1, 5))", 2.0);
    check_value("if(ge(2, 3), 10, 20)", 20.0);
}

fn check_fault(text: &str, kind: ParseErrorKind, span: std::ops::Range<usize>) {
    let fault = Pool::new().parse(text).expect_err(text);
    assert_eq!((fault.kind, fault.span), (kind, span), "{text}");
}

#[test]
fn faults_point_at_their_span() {
    use ParseErrorKind as K;
    let operand = "a number, a name or `(`";
    check_fault("2*(a + b", K::UnclosedParenthesis, 2..3);
    check_fault("a + b)", K::UnopenedParenthesis, 5..6);
    check_fault("a +", K::UnexpectedEnd { expected: operand }, 3..3);
    check_fault("", K::UnexpectedEnd { expected: operand }, 0..0);
    check_fault("(a +", K::UnexpectedEnd { expected: operand }, 4..4);
    check_fault("a * / b", K::UnexpectedToken { found: "/".into(), expected: operand }, 4..5);
    check_fault("a b", K::UnexpectedToken { found: "b".into(), expected: "an operator" }, 2..3);
    check_fault("a *** b", K::UnexpectedToken { found: "*".into(), expected: operand }, 4..5);
    check_fault("if a < b", K::UnexpectedEnd { expected: "`then`" }, 8..8);
    check_fault("if a < b then c", K::UnexpectedEnd { expected: "`else`" }, 15..15);
    check_fault(
        "(if a then b)",
        K::UnexpectedToken { found: ")".into(), expected: "`else`" },
        12..13,
    );
    check_fault(
        "if a else b",
        K::UnexpectedToken { found: "else".into(), expected: "`then`" },
        5..9,
    );
    let then = K::UnexpectedToken { found: "then".into(), expected: "an operator" };
    check_fault("a then b", then, 2..6);
    let operand_missing = K::UnexpectedToken { found: "then".into(), expected: operand };
    check_fault("2 + then", operand_missing, 4..8);
    check_fault("a⁻", K::BadNumber { found: "⁻".into() }, 1..4);
    check_fault("a^²", K::UnexpectedToken { found: "²".into(), expected: operand }, 2..4);
    check_fault("()", K::UnexpectedToken { found: ")".into(), expected: operand }, 1..2);
    check_fault("1.2.3", K::BadNumber { found: "1.2.3".into() }, 0..5);
    check_fault("2 mm", K::UnknownUnit { name: "mm".into() }, 2..4);
    check_fault("a ? b", K::UnexpectedCharacter { found: '?' }, 2..3);
    check_fault("sinn(a)", K::UnknownFunction { name: "sinn".into() }, 0..4);
    let arity = K::WrongArity { name: "atan2".into(), expected: 2, found: 1 };
    check_fault("1 + atan2(a)", arity, 4..9);
    let none = K::WrongArity { name: "sin".into(), expected: 1, found: 0 };
    check_fault("sin()", none, 0..3);
    check_fault(&"(".repeat(65), K::TooDeep { limit: 64 }, 64..65);
}

#[test]
fn units_follow_numbers_and_model_names_win() {
    let options = ParseOptions {
        is_unit: &|name| ["m", "s", "N", "kg", "mm"].contains(&name),
        is_variable: &|name| name == "s",
        ..ParseOptions::default()
    };
    let units = |text: &str| -> Vec<(String, i32)> {
        let syntax = parse(text, &options).expect(text);
        let quantity = syntax.nodes.iter().find_map(|node| match &node.kind {
            SyntaxKind::Quantity { factors, .. } => Some(factors.clone()),
            _ => None,
        });
        quantity.expect(text).into_iter().map(|factor| (factor.name, factor.exponent)).collect()
    };
    let pairs = |list: &[(&str, i32)]| -> Vec<(String, i32)> {
        list.iter().map(|&(name, exponent)| (name.to_owned(), exponent)).collect()
    };
    assert_eq!(units("25 mm"), pairs(&[("mm", 1)]));
    assert_eq!(units("25mm"), pairs(&[("mm", 1)]));
    assert_eq!(units("5 kg*m^2 + x"), pairs(&[("kg", 1), ("m", 2)]));
    assert_eq!(units("5 N/m^-2/kg"), pairs(&[("N", 1), ("m", 2), ("kg", -1)]));
    // `s` goes on no unit, `m(` is a call.
    assert_eq!(units("9.81 m/s^2"), pairs(&[("m", 1)]));
    assert_eq!(units("2 N*m(x)"), pairs(&[("N", 1)]));
    let fault = parse("2 furlong", &options).expect_err("no unit");
    assert_eq!(fault.span, 2..9);
}

#[test]
fn nodes_come_in_post_order_with_spans() {
    let syntax = parse("crank.B.x + f(2, -y)", &ParseOptions::default()).expect("valid");
    let covered: Vec<_> = syntax.nodes.iter().map(|node| node.span.clone()).collect();
    assert_eq!(covered, [0..9, 14..15, 18..19, 17..19, 12..20, 0..20]);
    assert_eq!(syntax.names().map(|(name, _)| name).collect::<Vec<_>>(), ["crank.B.x", "y"]);
}

#[test]
fn long_texts_do_not_overflow_the_stack() {
    let pool = Pool::new();
    let minus = format!("{}x", "-".repeat(100_001));
    assert_eq!(pool.to_text(pool.parse(&minus).expect("valid")), "-x");
    let sum = vec!["x"; 100_001].join("+");
    assert_eq!(pool.to_text(pool.parse(&sum).expect("valid")), "100001*x");
    let tower = vec!["x"; 20_001].join("^");
    let e = pool.parse(&tower).expect("valid");
    assert_eq!(pool.to_text(e).matches('x').count(), 20_001);
}

/// Pieces of text that mean something to the parser.
const PIECES: [&str; 36] = [
    "x", "q1.y", "2", "0.5e3", "m", "sin", "if", "(", "(", ")", ")", ",", "+", "-", "*", "/", "^",
    "<", ">=", " ", "sin(", "m^", "1 m", "?", "if ", " then ", " else ", " and ", "not ", "²",
    "⁻¹", "**", "·", " m ", "min(", "hypot(",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, rng_seed: RngSeed::Fixed(1679), ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_an_expression_or_has_a_fault_within_it(
        pieces in prop::collection::vec(prop::sample::select(PIECES.to_vec()), 0..12),
    ) {
        let text = pieces.concat();
        let options = ParseOptions { is_unit: &|name| name == "m", ..ParseOptions::default() };
        match parse(&text, &options) {
            Ok(syntax) => {
                prop_assert!(syntax.root().span.end <= text.len(), "{text}: {syntax:?}");
                let pool = Pool::new();
                let mut resolve = |name: &str, _| Ok::<_, ()>(pool.symbol(name));
                // Functions and units are checked here, which must not panic either.
                let lowered = pool.lower(&syntax.written_out(&|_| false), &mut resolve);
                if let Ok(e) = lowered {
                    prop_assert!(pool.parse(&pool.to_text(e)) == Ok(e), "{text}");
                }
            }
            Err(fault) => prop_assert!(fault.span.end <= text.len(), "{text}: {fault:?}"),
        }
    }
}

/// `parse(print(e))` is the node `e`.
fn check_reads_back(pool: &Pool, e: Expr) {
    let text = pool.to_text(e);
    let read = pool.parse(&text).expect("printed text is valid");
    assert!(read == e, "{text} reads back as {}", pool.to_text(read));
}

#[test]
fn long_sums_and_products_read_back_as_the_node_they_were() {
    for n in [31, 32, 33, 34, 40, 65, 66, 100, 300] {
        let pool = Pool::new();
        let symbols: Vec<_> = (0..n).map(|i| pool.symbol(&format!("x{i}"))).collect();
        let signed = |i: usize| if i.is_multiple_of(3) { pool.neg(symbols[i]) } else { symbols[i] };
        check_reads_back(&pool, pool.sum((0..n).map(signed)));
        check_reads_back(&pool, (0..n).map(signed).fold(pool.zero(), |sum, x| pool.add(sum, x)));
        check_reads_back(&pool, (0..n).map(signed).fold(pool.zero(), |sum, x| pool.sub(sum, x)));
        check_reads_back(&pool, pool.product(symbols.iter().copied()));
        check_reads_back(
            &pool,
            symbols.iter().fold(pool.one(), |product, &x| pool.mul(product, x)),
        );
        check_reads_back(
            &pool,
            symbols.iter().fold(pool.one(), |product, &x| pool.div(product, x)),
        );
        let pieces = |from: usize| pool.sum(symbols[from..].iter().copied());
        check_reads_back(&pool, pool.sum([pieces(0), pool.neg(pieces(1)), pool.symbol("y")]));
        check_reads_back(&pool, pool.mul(pool.sin(pieces(0)), pool.powi(pieces(1), -2)));
    }
}

/// A call has the value of the function at the value of the angle.
fn check_call(pool: &Pool, function: Function, angle: Expr, call: Expr) {
    let value = |e| {
        pool.evaluate(e, &|s| {
            [0.3, 1.1, 0.7].get(usize::from(pool.symbol_name(s).as_bytes()[1] - b'1')).copied()
        })
    };
    let plain =
        pool.call(function, &[pool.float(value(angle).expect("bound"))]).expect("one argument");
    let (found, expected) = (value(call).expect("bound"), value(plain).expect("bound"));
    let is_same = (found - expected).abs() < 1e-12 * expected.abs().max(1.0);
    assert!(is_same || expected.abs() > 1e9, "{}: {found} is not {expected}", pool.to_text(call));
}

#[test]
fn angles_with_eighths_of_a_turn_read_back() {
    let pool = Pool::new();
    let terms = ["q1", "-q1", "q2", "-q2", "q3/2", "-2*q3"].map(|t| pool.parse(t).expect(t));
    for &a in &terms {
        for &b in &terms {
            for eighths in -9..=9 {
                let phase = pool.mul(pool.rational(eighths, 4), pool.pi());
                let angles = [pool.add(a, phase), pool.sum([a, b, phase])];
                for angle in angles {
                    for function in [Function::Sin, Function::Cos, Function::Tan] {
                        let call = pool.call(function, &[angle]).expect("one argument");
                        check_reads_back(&pool, call);
                        check_call(&pool, function, angle, call);
                    }
                }
            }
        }
    }
    // One value, one node.
    let read = |text: &str| pool.parse(text).expect(text);
    assert_eq!(read("sin(pi/4 - q1)"), read("cos(q1 + pi/4)"));
    assert_eq!(read("sin(q1 - pi/4)"), read("-cos(q1 + pi/4)"));
}
