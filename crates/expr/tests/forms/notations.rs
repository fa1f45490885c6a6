//! The notations other than text: their marks, and that they can be typeset.

use bksim_expr::{Expr, Notation, Pool, Printer};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const TYPESET: [Notation; 3] = [Notation::Latex, Notation::Typst, Notation::MathMl];

fn check(notation: Notation, text: &str, expected: &str) {
    let pool = Pool::new();
    let e = pool.parse(text).expect(text);
    assert_eq!(Printer::new(&pool, notation).expr(e), expected, "{text}");
}

#[test]
fn latex_reads_like_a_paper() {
    let check = |text, expected| check(Notation::Latex, text, expected);
    check("m*x2_dot^2/2", r"\frac{1}{2} \, m \, \dot{x}_{2}^{2}");
    check("a/(b+c)", r"\frac{a}{b + c}");
    check("a/(2*b)", r"\frac{a}{2 \, b}");
    check("-9.81*m*0.5", r"-4.905 \, m");
    check("4*a/15", r"\frac{4}{15} \, a");
    check("sin(theta1)", r"\sin \theta_{1}");
    check("sin(p + q)^2", r"\sin^{2}(p + q)");
    check("(a+b)^2*c", r"c \, (a + b)^{2}");
    check("c*(a/b + 1)", r"c \, \left( \frac{a}{b} + 1 \right)");
    check("sqrt(a + 1)*abs(b)", r"\sqrt{a + 1} \, \left| b \right|");
    check("x^(a + 1)", r"x^{a + 1}");
    check("atan2(y, x)", r"\operatorname{atan2}(y, x)");
    check("1e-20*x", r"1 \cdot 10^{-20} \, x");
    check(
        "if(a < b, a, 2)",
        r"\begin{cases} a & \text{if } a < b \\ 2 & \text{otherwise} \end{cases}",
    );
    check("c*(a <= b)", r"c \, [a \le b]");
    check("ld1*speed", r"\mathrm{ld}_{1} \, \mathrm{speed}");
}

#[test]
fn typst_names_every_letter() {
    let check = |text, expected| check(Notation::Typst, text, expected);
    check("m*x2_dot^2/2", "frac(1, 2) thin m thin dot(x)_(2)^(2)");
    check("A_angle_ddot*crank.x", "dot.double(A)_(\"angle\") thin x_(\"crank\")");
    check("cos(phi)^2 + atan2(y, x)", "cos^(2) phi + op(\"atan2\")(y, x)");
    check("a/(b*c)", "frac(a, b thin c)");
    check("if(a < b, a, 2)", "cases(a & \"if \" a < b, 2 & \"otherwise\")");
}

#[test]
fn mathml_has_an_element_for_everything() {
    let check = |text, expected| check(Notation::MathMl, text, expected);
    check("x^2", "<msup><mi>x</mi><mn>2</mn></msup>");
    check("a/b", "<mfrac><mrow><mi>a</mi></mrow><mrow><mi>b</mi></mrow></mfrac>");
    let theta =
        "<msub><mover accent=\"true\"><mi>θ</mi><mo>˙</mo></mover><mrow><mn>1</mn></mrow></msub>";
    check("theta1_dot", theta);
}

#[test]
fn unicode_has_the_letters_of_the_blackboard() {
    let check = |text, expected| check(Notation::Unicode, text, expected);
    check("m*theta2_ddot^2/2 - g", "0.5·m·θ\u{308}₂² − g");
    check("A_angle_dot", "A\u{307}_angle");
    check("-sqrt(2*a)*abs(b)", "−√(2·a)·|b|");
}

#[test]
fn lines_break_at_signs_and_keep_to_the_width() {
    let pool = Pool::new();
    let terms = ["a1*x1", "-a2*x2", "c*(b1 + b2 + b3 + b4 - b5)", "a3"];
    let terms = terms.map(|text| pool.parse(text).expect(text));
    let printer = Printer::new(&pool, Notation::Text);
    let lines = |width| printer.lines(&terms, width);
    assert_eq!(lines(80.0), ["a1*x1 - a2*x2 + c*(b1 + b2 + b3 + b4 - b5) + a3"]);
    assert_eq!(lines(38.0), ["a1*x1 - a2*x2", "+ c*(b1 + b2 + b3 + b4 - b5) + a3"]);
    // A sum in parentheses breaks when it is too long by itself.
    assert_eq!(lines(18.0), ["a1*x1 - a2*x2", "+ c*(b1 + b2 + b3", "+ b4 - b5) + a3"]);
    // A line that cannot break stays.
    assert_eq!(lines(3.0).concat().replace(' ', ""), lines(80.0).concat().replace(' ', ""));
    // The halves of a split pair of parentheses do not wait for each other.
    let latex = Printer::new(&pool, Notation::Latex).lines(&terms, 9.0);
    assert!(latex.iter().any(|line| line.contains(r"\bigl(")), "{latex:?}");
}

#[test]
fn fractions_stay_fractions_and_parameters_come_before_coordinates() {
    let pool = Pool::new();
    let e = pool.parse("73/2400*A_angle*r + x/12000").expect("valid");
    let latex = pool.to_latex(e);
    assert!(latex.contains(r"\frac{73}{2400}") && latex.contains("{12000}"), "{latex}");
    let moving = ["A_angle", "x"].map(|name| pool.find_symbol(name).expect("was parsed"));
    let text = Printer::new(&pool, Notation::Text).moving(&moving).expr(e);
    assert_eq!(text, "73/2400*r*A_angle + 1/12000*x");
}

#[test]
fn trailing_symbols_stand_at_the_end_of_products() {
    let pool = Pool::new();
    let e = pool.parse("a*ld1*cos(q) - ld1^2*z").expect("valid");
    let ids = [pool.find_symbol("ld1").expect("was parsed")];
    let text = Printer::new(&pool, Notation::Text).trailing(&ids).expr(e);
    assert_eq!(text, "a*cos(q)*ld1 - z*ld1^2");
}

/// Every notation of expressions with nested quotients, powers, cases and odd names.
fn expressions() -> impl Strategy<Value = String> {
    let names = ["x", "theta1_dot", "A_angle", "crank.x", "ld1_", "_a", "m_rod2_ddot", "pi", "é"];
    let leaf = prop_oneof![
        (0..names.len()).prop_map(move |i| names[i].to_owned()),
        (0..40i32).prop_map(|n| n.to_string()),
        (1..999i32, 1..999i32).prop_map(|(a, b)| format!("{a}/{b}")),
        Just("1.5e-30".to_owned()),
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        let two = (inner.clone(), inner.clone());
        prop_oneof![
            two.clone().prop_map(|(a, b)| format!("({a} + {b})")),
            two.clone().prop_map(|(a, b)| format!("({a} - {b})")),
            two.clone().prop_map(|(a, b)| format!("({a})*({b})")),
            two.clone().prop_map(|(a, b)| format!("({a})/({b})")),
            two.clone().prop_map(|(a, b)| format!("({a})^({b})")),
            two.clone().prop_map(|(a, b)| format!("({a} < {b})")),
            two.clone().prop_map(|(a, b)| format!("if({a}, {b}, x)")),
            two.prop_map(|(a, b)| format!("atan2({a}, {b})")),
            inner.clone().prop_map(|a| format!("sqrt({a})")),
            inner.clone().prop_map(|a| format!("abs({a})")),
            inner.prop_map(|a| format!("sin({a})^3")),
        ]
    })
}

fn balance(text: &str, open: char, close: char) -> i64 {
    text.chars().map(|c| i64::from(c == open) - i64::from(c == close)).sum()
}

fn well_formed(notation: Notation, source: &str) {
    match notation {
        Notation::MathMl => {
            let page = format!("<math>{}</math>", source.replace("&#x2061;", ""));
            if let Err(fault) = roxmltree::Document::parse(&page) {
                panic!("{fault}: {page}");
            }
        }
        Notation::Latex => {
            assert_eq!(balance(source, '{', '}'), 0, "{source}");
            let n = |word: &str| source.matches(word).count();
            assert_eq!(n(r"\left"), n(r"\right"), "{source}");
            assert_eq!(n(r"\begin"), n(r"\end"), "{source}");
        }
        _ => {
            let source = source.replace(r"\(", "").replace(r"\)", "");
            assert_eq!(balance(&source, '(', ')'), 0, "{source}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, rng_seed: RngSeed::Fixed(1675), ..ProptestConfig::default() })]

    #[test]
    fn every_formula_is_well_formed(text in expressions(), width in 1.0..60.0f64) {
        let pool = Pool::new();
        let e = pool.parse(&text).expect(&text);
        for notation in TYPESET {
            let printer = Printer::new(&pool, notation);
            well_formed(notation, &printer.expr(e));
            for line in printer.lines(&[e, pool.symbol("z")], width) {
                well_formed(notation, &line);
            }
        }
    }

    #[test]
    fn text_reads_back_in_lines_too(text in expressions()) {
        let pool = Pool::new();
        let e = pool.parse(&text).expect(&text);
        for width in [20.0, f64::INFINITY] {
            let lines = Printer::new(&pool, Notation::Text).lines(&[e], width).join(" ");
            // A float reads back as the exact decimal it shows, so values are compared.
            let again = pool.parse(&lines).expect("what is printed");
            let certificate = pool.certificate(e, again);
            let is_equal = certificate.n_points == 0 || certificate.worst_double < 1e-6;
            prop_assert!(again == e || is_equal, "{} {:?}", lines, certificate);
        }
    }
}

#[test]
fn a_long_chain_prints_in_every_notation() {
    let pool = Pool::new();
    let mut e: Expr = pool.symbol("x");
    for i in 0..200_000 {
        let call = if i % 2 == 0 { pool.sin(e) } else { pool.exp(e) };
        e = pool.add(call, pool.symbol("a"));
    }
    for notation in
        [Notation::Text, Notation::Unicode, Notation::Latex, Notation::Typst, Notation::MathMl]
    {
        let lines = Printer::new(&pool, notation).lines(&[e], 80.0);
        assert!(lines.iter().map(String::len).sum::<usize>() > 1_000_000, "{notation:?}");
    }
}

#[test]
fn collected_terms_come_in_reading_order() {
    let pool = Pool::new();
    let e = pool.parse("a*cos(A) + b*cos(A + B) - c*cos(D) - d + a*B*x - A").expect("valid");
    let constants = ["a", "b", "c", "d"].map(|name| pool.find_symbol(name).expect("was parsed"));
    let terms = pool.split_terms(e, &constants);
    let varying: Vec<String> = terms.iter().map(|term| pool.to_text(term.varying)).collect();
    assert_eq!(varying, ["A", "B*x", "cos(A)", "cos(A + B)", "cos(D)", "1"]);
}
