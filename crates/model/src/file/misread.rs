//! Faults of texts that are no expressions, and the words of other languages with what they are here.

use bksim_expr::{ParseError, ParseErrorKind, function_names};

use super::codes;
use super::letters::{first_foreign, meant};
use super::marks::{is_typographic, with_points};
use super::quantity::syntax_of;
use super::reader::Reader;
use super::tree::Quoted;
use super::units::UNITS;
use super::value::Scope;
use super::words::{closest, cut, suggest};
use crate::diagnostic::Diagnostic;
use crate::joint::{MotionKind, motion_words};

/// Functions of other languages, and what to write for them.
const FUNCTIONS: [(&str, &str); 35] = [
    ("pow", "`a^b`"),
    ("power", "`a^b`"),
    ("sqr", "`x^2`"),
    ("square", "`x^2`"),
    ("cbrt", "`x^(1/3)`"),
    ("log", "`ln(x)`, the natural logarithm; to base 10 it is `ln(x)/ln(10)`"),
    ("log10", "`ln(x)/ln(10)`"),
    ("log2", "`ln(x)/ln(2)`"),
    ("arcsin", "`asin(x)`"),
    ("arccos", "`acos(x)`"),
    ("arctan", "`atan(x)`"),
    ("arctan2", "`atan2(y, x)`"),
    ("cosine", "`cos(x)`"),
    ("tangent", "`tan(x)`"),
    ("cot", "`1/tan(x)`"),
    ("sec", "`1/cos(x)`"),
    ("csc", "`1/sin(x)`"),
    ("fabs", "`abs(x)`"),
    ("mag", "`abs(x)`, or `hypot(x, y)` of components"),
    ("sgn", "`sign(x)`"),
    ("signum", "`sign(x)`"),
    ("heaviside", "`step(x)`: 1 where x >= 0, else 0"),
    ("fmod", "`mod(a, b)`"),
    ("modulo", "`mod(a, b)`"),
    ("rem", "`mod(a, b)`"),
    ("ceiling", "`ceil(x)`"),
    ("clip", "`clamp(x, least, largest)`"),
    ("saturate", "`clamp(x, least, largest)`"),
    ("limit", "`clamp(x, least, largest)`"),
    ("radians", "a unit: `30 deg`, or `x deg` for a number x"),
    ("deg2rad", "a unit: `30 deg`, or `x deg` for a number x"),
    ("degrees", "nothing: an angle is an angle in any unit"),
    ("iff", "`if(condition, x, y)`"),
    ("where", "`if(condition, x, y)`"),
    ("ifelse", "`if(condition, x, y)`"),
];

/// Words between operands in other languages, and what to write for them.
const WORDS: [(&str, &str); 16] = [
    (",", "a point in decimals: `0.5`; a comma stands between arguments alone"),
    ("AND", "`and`"),
    ("And", "`and`"),
    ("OR", "`or`"),
    ("Or", "`or`"),
    ("mod", "the remainder of a/b as `mod(a, b)`"),
    ("MOD", "the remainder of a/b as `mod(a, b)`"),
    ("div", "`(a - mod(a, b))/b`"),
    ("then", "`if` before the condition: `if a > b then x else y`"),
    ("THEN", "`then` in small letters, after `if`"),
    ("else", "`if` before it: `if a > b then x else y`"),
    ("ELSE", "`else` in small letters, after `then`"),
    ("elseif", "`else if`"),
    ("elsif", "`else if`"),
    ("elif", "`else if`"),
    ("is", "a comparison: `<`, `<=`, `>` or `>=`"),
];

/// Names of other languages, and what to write for them.
const NAMES: [(&str, &str); 8] = [
    ("time", "`t`"),
    ("PI", "`pi`"),
    ("Pi", "`pi`"),
    ("π", "`pi`"),
    ("e", "`exp(1)`"),
    ("true", "`1`"),
    ("false", "`0`"),
    ("inf", "a number below 1e308"),
];

/// Usual letters for angles, for positions, and for their rates.
const MOTIONS: [(&[&str], MotionKind, usize); 4] = [
    (
        &["theta", "phi", "alpha", "beta", "psi", "gamma", "angle", "rotation", "q"],
        MotionKind::Rotation,
        0,
    ),
    (
        &[
            "omega",
            "w",
            "dtheta",
            "thetadot",
            "theta_dot",
            "dphi",
            "phidot",
            "phi_dot",
            "rate",
            "rpm",
            "n",
        ],
        MotionKind::Rotation,
        1,
    ),
    (&["x", "s", "z", "position", "pos", "displacement", "stroke"], MotionKind::Translation, 0),
    (&["v", "xdot", "x_dot", "dx", "velocity", "speed", "vel"], MotionKind::Translation, 1),
];

/// The help for a function of another language, with the texts of its arguments in place of `a`, `b` and `x`, `y`.
pub(super) fn foreign_function(name: &str, arguments: &[&str]) -> Option<String> {
    let (_, written) = FUNCTIONS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    let is_operand = |c: char| c.is_alphanumeric() || matches!(c, '.' | '_');
    let argument = |word: &str| {
        let place = [["a", "x"], ["b", "y"]].iter().position(|names| names.contains(&word))?;
        let text = arguments.get(place)?;
        let is_bare = text.chars().all(is_operand) || !written.contains(['^', '/']);
        Some(if is_bare { (*text).to_owned() } else { format!("({text})") })
    };
    // The names in what is written, one after the other.
    let mut own = String::new();
    let mut rest = *written;
    while let Some(start) = rest.find(is_operand) {
        let end = rest[start..].find(|c| !is_operand(c)).map_or(rest.len(), |end| start + end);
        let word = &rest[start..end];
        own.push_str(&rest[..start]);
        let is_in_code = own.matches('`').count() % 2 == 1;
        let text = argument(word).filter(|_| is_in_code);
        own.push_str(text.as_deref().unwrap_or(word));
        rest = &rest[end..];
    }
    Some(format!("write {own}{rest}"))
}

/// The help where a word stands in place of an operator.
fn after_operand(found: &str) -> String {
    match WORDS.iter().find(|(known, _)| *known == found) {
        Some((_, written)) => format!("write {written}"),
        None => format!("write `*` before `{}` to multiply", cut(found)),
    }
}

/// The help for a character that is in no expression.
fn character(found: char) -> &'static str {
    match found {
        '=' => "the comparisons are `<`, `<=`, `>` and `>=`",
        '!' => "write `not` before a condition; the comparisons are `<`, `<=`, `>` and `>=`",
        '&' => "write `and`",
        '|' => "write `or` between conditions, and `abs(x)` for the magnitude of x",
        '%' => "write `mod(a, b)` for the remainder of a/b, and 0.05 for 5 percent",
        '?' | ':' => "write `if a > b then x else y`",
        '√' => "write `sqrt(x)`",
        '÷' => "write `/`",
        '[' | ']' | '{' | '}' => "parentheses are round: `(`, `)`",
        ';' => "arguments are divided by commas",
        found if is_typographic(found) => "remove it: the quotes around the value are enough",
        _ => "use + - * / ^ ( ), numbers, units, names, functions; a point in decimals",
    }
}

/// Units under names that others use, and what to write for them.
const UNIT_WORDS: [(&str, &str); 8] = [
    ("grad", "`deg` if degrees are meant; a gradian is 0.9 deg"),
    ("Grad", "`deg`"),
    ("degree", "`deg`"),
    ("degrees", "`deg`"),
    ("minute", "`min`"),
    ("minutes", "`min`"),
    ("kgm2", "`kg m^2`"),
    ("kgmm2", "`kg mm^2`"),
];

/// The digits at the end of a text.
fn last_digits(text: &str) -> &str {
    &text[text.trim_end_matches(|c: char| c.is_ascii_digit()).len()..]
}

/// The digits at the start of a text.
fn first_digits(text: &str) -> &str {
    &text[..text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len()]
}

/// A number in groups of three digits: `1 000`, `1,000`, with `mark` between the groups; without the marks.
fn without_groups(text: &str, mark: char) -> Option<String> {
    let mut groups = text.split(mark);
    let mut written = groups.next()?.to_owned();
    let mut n_groups = 0;
    for group in groups {
        let (before, digits) = (last_digits(&written), first_digits(group));
        let is_group = digits.len() == 3
            && !before.is_empty()
            && !before.starts_with('0')
            && (before.len() <= 3 || n_groups > 0)
            && !written[..written.len() - before.len()].ends_with('.');
        if is_group {
            n_groups += 1;
        } else {
            written.push(mark);
        }
        written.push_str(group);
    }
    (n_groups > 0).then_some(written)
}

/// A text with a mixed number as a sum: `1 1/2 in`, where the fraction begins at `at`.
fn mixed_number(text: &str, at: usize) -> Option<String> {
    let before = text[..at].trim_end();
    let whole = last_digits(before);
    let above = first_digits(&text[at..]);
    let under = first_digits(text[at + above.len()..].strip_prefix('/')?);
    if whole.is_empty() || above.is_empty() || under.is_empty() || before.len() == at {
        return None;
    }
    let rest = &text[at + above.len() + 1 + under.len()..];
    let start = &before[..before.len() - whole.len()];
    Some(format!("{start}({whole} + {above}/{under}){rest}"))
}

/// A text with the brackets that a function needs: of `cos 0.1`, and of `sin^2(x)`, where the argument begins at `at`.
fn with_brackets(text: &str, at: usize) -> Option<String> {
    let before = text[..at].trim_end();
    let (called, power) = match before.rsplit_once('^') {
        Some((called, power)) if !power.is_empty() && last_digits(power) == power => {
            (called, Some(power))
        }
        _ => (before, None),
    };
    let start = called.trim_end_matches(|c: char| c.is_ascii_alphanumeric() || c == '_').len();
    let name = &called[start..];
    if !function_names().any(|known| known == name) {
        return None;
    }
    let rest = &text[at..];
    let end = if rest.starts_with('(') {
        let mut depth = 0;
        let closing = rest.char_indices().find(|(_, c)| {
            depth += i32::from(*c == '(') - i32::from(*c == ')');
            depth == 0
        });
        closing?.0 + 1
    } else {
        rest.find(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '.' | '_')))
            .unwrap_or(rest.len())
    };
    let argument = rest[..end].trim_start_matches('(').trim_end_matches(')');
    let inside = if rest.starts_with('(') { &rest[1..end - 1] } else { argument };
    let power = power.map_or_else(String::new, |power| format!("^{power}"));
    Some(format!("{}{name}({inside}){power}{}", &called[..start], &rest[end..]))
}

/// A choice as Python writes it, `a if c else b`, in the order of bksim.
fn choice(text: &str, at: usize) -> Option<String> {
    let (condition, other) = text[at..].strip_prefix("if ")?.split_once(" else ")?;
    let first = text[..at].trim();
    Some(format!("if {} then {first} else {}", condition.trim(), other.trim()))
}

impl Reader<'_> {
    /// The help for the first of the texts that is an expression.
    fn first_readable(&self, texts: impl IntoIterator<Item = Option<String>>) -> Option<String> {
        let is_own = |name: &str| self.is_own_name(name);
        let is_readable = |text: &String| syntax_of(text, self.nesting, &is_own).is_ok();
        let found = texts.into_iter().flatten().find(is_readable)?;
        Some(format!("write \"{found}\""))
    }

    /// The help where an operand follows another one, from what may be meant.
    fn without_operator(&self, text: &str, at: usize) -> Option<String> {
        self.first_readable([
            mixed_number(text, at),
            without_groups(text, ' '),
            with_brackets(text, at),
            choice(text, at),
        ])
    }

    /// The help for a sign that is in no expression, from what may be meant in `what`.
    fn with_other_sign(&self, text: &str, found: char, what: &str) -> Option<String> {
        let (before, after) = text.split_once(found)?;
        let is_ratio = !last_digits(before.trim_end()).is_empty()
            && !first_digits(after.trim_start()).is_empty();
        match found {
            ':' if is_ratio && !text.contains('?') => {
                let quotient = format!("{}/{}", before.trim_end(), after.trim_start());
                let help = self.first_readable([Some(quotient)])?;
                Some(format!("{help}, a quotient"))
            }
            '=' if what.starts_with("`relation`") => {
                let (left, right) = (before.trim(), after.trim());
                let right = if right.contains([' ', '+', '-']) {
                    format!("({right})")
                } else {
                    right.to_owned()
                };
                let difference = format!("{left} - {right}");
                let help = self.first_readable([Some(difference)])?;
                Some(format!("{help}: a relation is an expression that is zero"))
            }
            '\'' => Some("write feet and inches as units: `1 ft + 6 in`".to_owned()),
            _ => None,
        }
    }

    /// The help for a name of another language, or for a letter that books use for a motion.
    pub(super) fn foreign_name(&self, name: &str, scope: Scope) -> Option<String> {
        if let Some((_, written)) = NAMES.iter().find(|(known, _)| *known == name) {
            return Some(format!("write {written}"));
        }
        let (_, kind, at) = MOTIONS.iter().find(|(letters, ..)| letters.contains(&name))?;
        if matches!(scope, Scope::Constant | Scope::Time) {
            return None;
        }
        let joints = self.names.joints.iter().filter_map(|joint| {
            let freedoms = joint.freedoms?;
            let idx = freedoms.iter().position(|freedom| freedom == kind)?;
            Some(format!("`{}.{}`", joint.name, motion_words(freedoms, idx)[*at]))
        });
        let written: Vec<String> = joints.take(4).collect();
        match written.as_slice() {
            [] => None,
            [one] => Some(format!("write {one}")),
            many => Some(format!("one of {}", many.join(", "))),
        }
    }

    /// A text with points in its decimals, where these make it an expression.
    fn decimals(&self, text: &str) -> Option<String> {
        let is_own = |name: &str| self.is_own_name(name);
        with_points(text).filter(|text| syntax_of(text, self.nesting, &is_own).is_ok())
    }

    /// Reports why a text is no expression.
    pub(super) fn report_parse_error(
        &mut self,
        error: &ParseError,
        quoted: &Quoted<'_>,
        what: &str,
    ) {
        let location = quoted.span_of(&error.span);
        let fault = |message: String| Diagnostic::error(codes::EXPRESSION, message);
        let fault = match &error.kind {
            // Parentheses.
            ParseErrorKind::UnclosedParenthesis => fault("`(` is not closed".to_owned())
                .at(location, "opened here")
                .help("add `)` where it ends"),
            ParseErrorKind::UnopenedParenthesis => fault("`)` closes nothing".to_owned())
                .at(location, "never opened")
                .help("remove it, or add `(` before it"),
            ParseErrorKind::TooDeep { limit } => {
                Diagnostic::error(codes::NESTING, format!("parentheses nested deeper than {limit}"))
                    .at(location, "the first one too deep")
                    .help("use a parameter for a part of it, or allow more with `--max-nesting`")
            }
            // Words and their order.
            ParseErrorKind::UnknownUnit { name } => {
                let units: Vec<&str> = UNITS.iter().map(|unit| unit.name).collect();
                let joined = quoted.text.replace(name.as_str(), &name.replace('_', " "));
                let divided = name.starts_with('_').then(|| self.first_readable([Some(joined)]));
                let word = UNIT_WORDS.iter().find(|(known, _)| known == name);
                let help = if let Some(help) = divided.flatten() {
                    help
                } else if let Some((_, written)) = word {
                    format!("write {written}")
                } else if WORDS.iter().any(|(known, _)| known == name) {
                    after_operand(name)
                } else if self.names.plain(name).is_some() {
                    format!("write `*` between the number and `{name}`")
                } else if closest(name, &units).is_some() || first_foreign(name).is_some() {
                    suggest(name, &units)
                } else {
                    "units: `bksim explain M030` lists them".to_owned()
                };
                let message = format!("unknown unit `{}`", cut(name));
                Diagnostic::error(codes::UNKNOWN_UNIT, message)
                    .at(location, "not a unit")
                    .help(help)
            }
            ParseErrorKind::UnexpectedEnd { expected } => {
                let help = if expected.contains("else") {
                    format!("write \"{} else 0\" if it is 0 otherwise", quoted.text.trim_end())
                } else {
                    format!("write {expected} at the end")
                };
                fault(format!("{what} ends where {expected} must follow"))
                    .at(location, "ends here")
                    .help(help)
            }
            ParseErrorKind::UnexpectedToken { found, expected } => {
                let decimals = self.decimals(quoted.text).filter(|_| found == ",");
                let is_word = WORDS.iter().any(|(known, _)| known == found);
                let thousands = without_groups(quoted.text, ',');
                let meant = || self.without_operator(quoted.text, error.span.start);
                let meant = (*expected == "an operator").then(meant).flatten();
                let help = match decimals {
                    Some(text) => match self.first_readable([thousands]) {
                        Some(other) => format!(
                            "write \"{text}\" if decimals follow the comma, or {other} if it divides thousands"
                        ),
                        None => format!("write \"{text}\""),
                    },
                    None if meant.is_some() => meant.unwrap_or_default(),
                    None if *expected == "an operator" || is_word => after_operand(found),
                    None => format!("write {expected} before it, or remove it"),
                };
                fault(format!("found `{}` where {expected} must stand", cut(found)))
                    .at(location, "not expected here")
                    .help(help)
            }
            // Characters and digits.
            // Letters that look like others: the one at fault, and the whole text without them.
            ParseErrorKind::UnexpectedCharacter { .. } if first_foreign(quoted.text).is_some() => {
                let [plain, _] = meant(quoted.text);
                let letter = first_foreign(quoted.text).map(|letter| {
                    let place = letter.at..letter.at + letter.letter.len_utf8();
                    (quoted.span_of(&place), letter.character, letter.named())
                });
                let (place, character, named) = letter.unwrap_or((location, 1, String::new()));
                fault(format!("{what}: character {character} is {named}"))
                    .at(place, "not in expressions")
                    .help(format!("write \"{plain}\""))
            }
            ParseErrorKind::UnexpectedCharacter { found } => {
                // Signs of other languages are doubled: `&&`.
                let after = &quoted.text[error.span.end.min(quoted.text.len())..];
                let is_double = matches!(found, '&' | '|' | '=') && after.starts_with(*found);
                let end = error.span.end + usize::from(is_double);
                let location = quoted.span_of(&(error.span.start..end));
                let shown = match found {
                    '\'' | '"' => found.to_string(),
                    found => found.escape_debug().to_string(),
                };
                let help = self.with_other_sign(quoted.text, *found, what);
                fault(format!("an expression cannot contain `{shown}`"))
                    .at(location, "")
                    .help(help.unwrap_or_else(|| character(*found).to_owned()))
            }
            ParseErrorKind::BadNumber { found } => fault(format!("`{}` is no number", cut(found)))
                .at(location, "")
                .help("write digits and one point, such as 0.5 or 1.2e-3"),
            other => {
                fault(format!("{what}: {other}")).at(location, "").help("see `bksim explain M020`")
            }
        };
        self.report(fault);
    }
}
