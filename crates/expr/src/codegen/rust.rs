//! Rust without `std`: the elementary functions come from a trait that the user implements.
//!
//! `core` has no sine. The generated trait lists exactly the functions that the code calls, so an
//! implementation is a few lines over `libm` or `std`, and calls to it cost nothing. Arguments are
//! arrays of fixed length: nothing can be out of range, and nothing panics.

use super::{Dialect, Program, listed};
use crate::op::Function;
use crate::tape::Action;
use std::collections::BTreeMap;
use std::fmt::Write;

struct Rust;

impl Dialect for Rust {
    fn literal(&self, value: f64) -> String {
        if value.is_finite() {
            format!("{value:?}_f64")
        } else if value.is_nan() {
            "f64::NAN".to_owned()
        } else {
            format!("{}f64::INFINITY", if value < 0.0 { "-" } else { "" })
        }
    }

    fn call(&self, function: Function, [a, b, c]: [&str; 3]) -> String {
        match function {
            Function::Sign => {
                format!("if {a} > 0.0 {{ 1.0 }} else if {a} < 0.0 {{ -1.0 }} else {{ {a} }}")
            }
            Function::Atan2 => format!("M::atan2({a}, {b})"),
            Function::Abs => format!("f64::from_bits({a}.to_bits() & (u64::MAX >> 1))"),
            Function::Min => format!("if {a} <= {b} || {a}.is_nan() {{ {a} }} else {{ {b} }}"),
            Function::Max => format!("if {a} >= {b} || {a}.is_nan() {{ {a} }} else {{ {b} }}"),
            Function::Lt => format!("if {a} < {b} {{ 1.0 }} else {{ 0.0 }}"),
            Function::Le => format!("if {a} <= {b} {{ 1.0 }} else {{ 0.0 }}"),
            Function::Gt => format!("if {a} > {b} {{ 1.0 }} else {{ 0.0 }}"),
            Function::Ge => format!("if {a} >= {b} {{ 1.0 }} else {{ 0.0 }}"),
            Function::If => {
                format!("if {a}.is_nan() {{ {a} }} else if {a} == 0.0 {{ {c} }} else {{ {b} }}")
            }
            _ => format!("M::{}({a})", function.name()),
        }
    }

    fn power(&self, base: &str, exponent: &str) -> String {
        format!("M::powf({base}, {exponent})")
    }

    fn declaration(&self, name: &str, value: &str) -> String {
        format!("let {name}: f64 = {value};")
    }
}

impl Program<'_> {
    /// The tape as a Rust module for the editions 2021 and 2024 that needs `core` alone, with its
    /// test points as unit tests.
    pub fn to_rust(&self) -> String {
        let methods = self.rust_methods();
        let name = &self.names.function;
        let mut code: String = self
            .legend()
            .iter()
            .map(|line| format!("//! {line}").trim_end().to_owned() + "\n")
            .collect();
        code.push('\n');
        if !methods.is_empty() {
            code.push_str(
                "/// The elementary functions of `f64` that the code calls.\npub trait Math {\n",
            );
            for (method, (arguments, _)) in &methods {
                let _ = writeln!(
                    code,
                    "    /// The function called `{method}` in `std`.\n    fn {method}({arguments}) -> f64;"
                );
            }
            code.push_str("}\n\n");
        }
        let generic = if methods.is_empty() { "" } else { "<M: Math>" };
        let (n, m, k) = (self.tape.n_inputs, self.tape.n_parameters, self.tape.n_outputs());
        let _ = writeln!(
            code,
            "/// Computes all outputs.\n#[allow(non_snake_case, clippy::all)]\n\
             pub fn {name}{generic}(inputs: &[f64; {n}], parameters: &[f64; {m}], outputs: &mut [f64; {k}]) {{\n\
             \x20   let _ = (inputs, parameters);"
        );
        for statement in self.statements(&Rust) {
            let _ = writeln!(code, "    {statement}");
        }
        let _ = writeln!(code, "    *outputs = [{}];\n}}", self.results(&Rust).join(", "));
        self.rust_tests(&methods, &mut code);
        code
    }

    /// Methods of the trait: arguments, and the body that calls `std`.
    fn rust_methods(&self) -> BTreeMap<&'static str, (&'static str, String)> {
        let mut methods = BTreeMap::new();
        for (_, instruction) in self.instructions() {
            let (name, is_binary) = match instruction.action {
                Action::Power => ("powf", true),
                Action::Call(Function::Atan2) => ("atan2", true),
                Action::Call(function)
                    if function.arity() == 1
                        && !matches!(function, Function::Sign | Function::Abs) =>
                {
                    (function.name(), false)
                }
                _ => continue,
            };
            let arguments = if is_binary { "a: f64, b: f64" } else { "a: f64" };
            let call = if is_binary { format!("a.{name}(b)") } else { format!("a.{name}()") };
            methods.insert(name, (arguments, call));
        }
        methods
    }

    fn rust_tests(
        &self,
        methods: &BTreeMap<&'static str, (&'static str, String)>,
        code: &mut String,
    ) {
        code.push_str("\n#[cfg(test)]\nmod tests {\n");
        if !methods.is_empty() {
            code.push_str(
                "    extern crate std;\n\n    struct Std;\n\n    impl super::Math for Std {\n",
            );
            for (method, (arguments, call)) in methods {
                let _ = writeln!(
                    code,
                    "        fn {method}({arguments}) -> f64 {{\n            {call}\n        }}"
                );
            }
            code.push_str("    }\n\n");
        }
        let call = if methods.is_empty() { "" } else { "::<Std>" };
        let _ = writeln!(
            code,
            "    #[test]\n    fn outputs_are_as_expected() {{\n        let points: [([f64; {}], [f64; {}], [f64; {}]); {}] = [",
            self.tape.n_inputs,
            self.tape.n_parameters,
            self.tape.n_outputs(),
            self.points.len(),
        );
        for point in &self.points {
            let [inputs, parameters, outputs] =
                [&point.inputs, &point.parameters, &point.outputs].map(|v| listed(&Rust, v));
            let _ = writeln!(code, "            ([{inputs}], [{parameters}], [{outputs}]),");
        }
        let tolerance = self.tolerance();
        let _ = writeln!(
            code,
            "        ];\n        for (inputs, parameters, expected) in points {{\n            let mut outputs = expected;\n            \
             super::{}{call}(&inputs, &parameters, &mut outputs);\n            \
             for (found, expected) in outputs.into_iter().zip(expected) {{\n                \
             let is_same = found == expected || (found - expected).abs() <= {tolerance} * expected.abs();\n                \
             assert!(is_same || (found.is_nan() && expected.is_nan()), \"{{found}} is not {{expected}}\");\n            \
             }}\n        }}\n    }}\n}}",
            self.names.function,
        );
    }
}
