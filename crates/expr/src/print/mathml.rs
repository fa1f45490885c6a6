//! Presentation MathML: the content of a `<math>` element.

use super::mark::{
    FunctionName, Height, Mark, MarkPart, SymbolNames, digits, function_name, relation,
};
use super::name::{Name, Word};

/// Between a function's name and its argument.
const APPLY: &str = "<mo>&#x2061;</mo>";

/// Appends a mark as MathML.
pub(super) fn write(mark: &Mark, names: &SymbolNames<'_>, out: &mut String) {
    let fixed = match *mark {
        // Marks with a number or a name in them.
        Mark::Number(ref n) => {
            let (mantissa, exponent) = digits(n);
            out.extend(["<mn>", &mantissa, "</mn>"]);
            if let Some(exponent) = exponent {
                let exponent = exponent.replace('-', "−");
                out.extend(["<mo>·</mo><msup><mn>10</mn><mn>", &exponent, "</mn></msup>"]);
            }
            return;
        }
        Mark::Symbol(symbol) => return out.push_str(&name(&names.of(symbol))),
        Mark::RaisedSymbol(symbol, n) => {
            return out.push_str(&element(&names.of(symbol), Some(n)));
        }
        Mark::Raised(n) => return out.extend(["</mrow><mn>", &n.to_string(), "</mn></msup>"]),
        Mark::Function(function, power) => {
            let name = ["<mi>", function_name(function), "</mi>"].concat();
            return match power {
                1 => out.extend([&name, APPLY]),
                n => out.extend(["<msup>", &name, "<mn>", &n.to_string(), "</mn></msup>", APPLY]),
            };
        }
        Mark::Named(function) => {
            let FunctionName { name: text, primes, by } = names.of_function(function);
            let by: String = by.iter().map(|variable| name(variable)).collect();
            if !by.is_empty() {
                out.extend(["<msub><mo>∂</mo><mrow>", &by, "</mrow></msub>"]);
            }
            out.push_str(&name(&text));
            if !primes.is_empty() {
                out.extend(["<mo lspace=\"0\">", &"′".repeat(primes.len()), "</mo>"]);
            }
            return out.push_str(APPLY);
        }
        Mark::Relation(function) => match relation(function) {
            Some('≤') => "<mo>≤</mo>",
            Some('≥') => "<mo>≥</mo>",
            Some('>') => "<mo>&gt;</mo>",
            _ => "<mo>&lt;</mo>",
        },
        // Signs.
        Mark::Pi => "<mi>π</mi>",
        Mark::Plus => "<mo form=\"infix\">+</mo>",
        Mark::Minus => "<mo form=\"infix\">−</mo>",
        Mark::Sign => "<mo form=\"prefix\">−</mo>",
        Mark::Times => "<mo lspace=\"0\" rspace=\"0.17em\">&#x2062;</mo>",
        Mark::Over => "<mo>/</mo>",
        // Fractions, powers, roots, bars and parentheses around others.
        Mark::Fraction(MarkPart::Start) => "<mfrac><mrow>",
        Mark::Fraction(MarkPart::Middle) | Mark::Power(MarkPart::Middle) => "</mrow><mrow>",
        Mark::Fraction(MarkPart::End) => "</mrow></mfrac>",
        Mark::Power(MarkPart::Start) => "<msup><mrow>",
        Mark::Power(MarkPart::End) => "</mrow></msup>",
        Mark::Root(MarkPart::Start) => "<msqrt>",
        Mark::Root(_) => "</msqrt>",
        Mark::Absolute(MarkPart::Start) => "<mrow><mo fence=\"true\">|</mo>",
        Mark::Absolute(_) => "<mo fence=\"true\">|</mo></mrow>",
        // A partner in another line must not stretch this one, nor leave a row open.
        Mark::Parenthesis(MarkPart::Start, Height::Split) => "<mo form=\"prefix\">(</mo>",
        Mark::Parenthesis(MarkPart::End, Height::Split) => "<mo form=\"postfix\">)</mo>",
        Mark::Parenthesis(part, height) | Mark::Arguments(part, height) => match (part, height) {
            (MarkPart::Start, Height::Line) => {
                "<mrow><mo form=\"prefix\" stretchy=\"false\">(</mo>"
            }
            (MarkPart::End, Height::Line) => {
                "<mo form=\"postfix\" stretchy=\"false\">)</mo></mrow>"
            }
            (MarkPart::Start, _) => "<mrow><mo form=\"prefix\">(</mo>",
            (MarkPart::Middle, _) => "<mo separator=\"true\">,</mo>",
            (MarkPart::End, _) => "<mo form=\"postfix\">)</mo></mrow>",
        },
        // Functions and conditions.
        Mark::Apply => "<mspace width=\"0.17em\"/>",
        Mark::Cases(MarkPart::Start) => "<mrow><mo form=\"prefix\">{</mo><mtable><mtr><mtd>",
        Mark::Cases(MarkPart::Middle) => "</mtd><mtd><mtext>if&#xa0;</mtext>",
        Mark::Cases(MarkPart::End) => {
            "</mtd><mtd><mtext>otherwise</mtext></mtd></mtr></mtable></mrow>"
        }
        Mark::Otherwise => "</mtd></mtr><mtr><mtd>",
        Mark::NotZero => "<mo>≠</mo><mn>0</mn>",
        Mark::Truth(MarkPart::Start) => "<mrow><mo form=\"prefix\">[</mo>",
        Mark::Truth(_) => "<mo form=\"postfix\">]</mo></mrow>",
    };
    out.push_str(fixed);
}

/// `x2_dot` becomes x with a dot and the index 2.
pub(super) fn name(text: &str) -> String {
    element(text, None)
}

/// An identifier, to a power if there is one.
fn element(text: &str, power: Option<u64>) -> String {
    let name = Name::of(text);
    let letter = word(name.letter);
    let letter = match name.n_dots {
        0 => letter,
        1 => format!("<mover accent=\"true\">{letter}<mo>˙</mo></mover>"),
        _ => format!("<mover accent=\"true\">{letter}<mo>¨</mo></mover>"),
    };
    let power = power.map(|n| format!("<mn>{n}</mn>"));
    if name.subscripts.is_empty() {
        return match power {
            Some(power) => format!("<msup>{letter}{power}</msup>"),
            None => letter,
        };
    }
    let subscripts: Vec<String> = name.subscripts.into_iter().map(word).collect();
    let comma = "<mo separator=\"true\">,</mo>";
    let subscript = format!("<mrow>{}</mrow>", subscripts.join(comma));
    match power {
        Some(power) => format!("<msubsup>{letter}{subscript}{power}</msubsup>"),
        None => format!("<msub>{letter}{subscript}</msub>"),
    }
}

fn word(word: Word<'_>) -> String {
    match word {
        Word::Greek(_, c) | Word::Letter(c) => format!("<mi>{c}</mi>"),
        Word::Text(text) => format!("<mi mathvariant=\"normal\">{text}</mi>"),
        Word::Digits(digits) => format!("<mn>{digits}</mn>"),
    }
}
