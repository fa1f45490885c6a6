//! Names of quantities as identifiers that C, Rust and Python all accept.

use super::{Quantity, Signature};
use std::collections::HashSet;

/// Words that no variable may be called: keywords of the three languages, macros of `math.h`, and
/// names in generated code itself.
#[rustfmt::skip]
const RESERVED: &[&str] = &[
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum",
    "extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict",
    "return", "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union",
    "unsigned", "void", "volatile", "while", "asm", "linux", "unix", "main",
    "abstract", "as", "async", "await", "become", "box", "crate", "dyn", "fn", "final", "gen",
    "impl", "in", "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub",
    "ref", "self", "Self", "super", "trait", "true", "false", "try", "type", "typeof", "unsized",
    "use", "virtual", "where", "yield", "f64", "usize", "M", "Math",
    "False", "None", "True", "and", "assert", "class", "def", "del", "elif", "except", "finally",
    "from", "global", "import", "is", "lambda", "nonlocal", "not", "or", "pass", "raise", "with",
    "np", "numpy", "inputs", "parameters", "outputs", "NAN", "INFINITY", "HUGE_VAL", "bool",
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt",
    "fabs", "atan2", "pow", "math_errhandling", "signgam", "check", "tests", "shape", "results", "core",
    "std", "Std", "bksim_sin", "bksim_cos", "bksim_turn", "memcpy", "uint64_t", "printf", "fprintf", "enumerate", "len", "test",
];

/// Identifiers, distinct from each other.
#[derive(Debug)]
pub(super) struct Names {
    pub(super) function: String,
    pub(super) inputs: Vec<String>,
    pub(super) parameters: Vec<String>,
}

impl Names {
    pub(super) fn new(signature: &Signature) -> Self {
        Self::avoiding(signature, &[])
    }

    /// Identifiers none of which is one of `words`.
    pub(super) fn avoiding(signature: &Signature, words: &[&str]) -> Self {
        let mut taken = words.iter().map(|&word| word.to_owned()).collect();
        let function = identifier(&signature.name, &mut taken);
        let mut all = |quantities: &[Quantity]| {
            quantities.iter().map(|quantity| identifier(&quantity.name, &mut taken)).collect()
        };
        let inputs = all(&signature.inputs);
        Self { function, inputs, parameters: all(&signature.parameters) }
    }
}

/// A new identifier as close to `name` as possible.
fn identifier(name: &str, taken: &mut HashSet<String>) -> String {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut identifier: String =
        name.chars().map(|c| if is_allowed(c) { c } else { '_' }).collect();
    // No leading digit, and no leading underscore, which C reserves.
    if !identifier.starts_with(|c: char| c.is_ascii_alphabetic()) {
        identifier.insert(0, 'x');
    }
    let is_register = identifier
        .strip_prefix('v')
        .is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit()));
    let is_macro =
        ["M_", "FP_", "HUGE_", "MATH_"].iter().any(|prefix| identifier.starts_with(prefix));
    while is_register && !identifier.ends_with('_')
        || is_macro && !identifier.starts_with('x')
        || RESERVED.contains(&identifier.as_str())
        || taken.contains(&identifier)
    {
        if is_macro && !identifier.starts_with('x') {
            identifier.insert(0, 'x');
        } else {
            identifier.push('_');
        }
    }
    taken.insert(identifier.clone());
    identifier
}

/// Text within one line of a comment in any of the languages.
pub(super) fn line(text: &str) -> String {
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    line.replace("*/", "* /").replace("/*", "/ *").replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_distinct_and_allowed_everywhere() {
        let mut taken = HashSet::new();
        let found: Vec<String> = ["q1", "q1", "lambda", "v7", "2x", "q'", "α", "M_PI", "", "f64"]
            .iter()
            .map(|name| identifier(name, &mut taken))
            .collect();
        let expected = ["q1", "q1_", "lambda_", "v7_", "x2x", "q_", "x_", "xM_PI", "x", "f64_"];
        assert_eq!(found, expected);
    }
}
