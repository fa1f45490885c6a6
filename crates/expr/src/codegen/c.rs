//! C99: one function, no allocation, no globals.

use super::{Dialect, Program, listed};
use crate::op::Function;
use crate::tape::Action;
use std::fmt::Write;

/// A function in C.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CCode {
    /// The declaration with its documentation, to be called `<name>.h`.
    pub header: String,
    /// The definition, to be called `<name>.c`.
    pub source: String,
    /// A program that calls the function at the test points and fails where an output differs.
    pub test: String,
}

struct C;

/// Sine and cosine together as our own evaluators compute them, operation by operation: see `sincos`.
const SINE_AND_COSINE: &str = include_str!("sincos.c");

/// One of the two: large angles are left to the library.
fn c_turn(name: &str, result: &str) -> String {
    format!(
        "static double bksim_{name}(double x) {{\n    double sine, cosine;\n    \
         if (!(fabs(x) <= 1e6)) {{\n        return {name}(x);\n    }}\n    \
         bksim_turn(x, &sine, &cosine);\n    return {result};\n}}\n\n"
    )
}

/// The beginning of a file with `code` made of [`Program::to_c_part`]: the mathematics of C, and sine and cosine as our
/// own evaluators compute them where they are called.
pub fn c_prelude(code: &str) -> String {
    let turns = [("sin", "sine"), ("cos", "cosine")];
    let is_called = |name: &str| code.contains(&format!("bksim_{name}("));
    let turns = turns.into_iter().filter(|(name, _)| is_called(name));
    let turns: String = turns.map(|(name, result)| c_turn(name, result)).collect();
    let first = if turns.is_empty() { "" } else { SINE_AND_COSINE };
    format!("#include <math.h>\n{first}{turns}")
}

impl Dialect for C {
    fn literal(&self, value: f64) -> String {
        if value.is_finite() {
            format!("{value:?}")
        } else if value.is_nan() {
            "(double)NAN".to_owned()
        } else {
            format!("{}HUGE_VAL", if value < 0.0 { "-" } else { "" })
        }
    }

    fn call(&self, function: Function, [a, b, c]: [&str; 3]) -> String {
        match function {
            Function::Sin => format!("bksim_sin({a})"),
            Function::Cos => format!("bksim_cos({a})"),
            Function::Ln => format!("log({a})"),
            Function::Abs => format!("fabs({a})"),
            Function::Sign => format!("{a} > 0.0 ? 1.0 : {a} < 0.0 ? -1.0 : {a}"),
            Function::Atan2 => format!("atan2({a}, {b})"),
            Function::Min => format!("({a} <= {b} || {a} != {a}) ? {a} : {b}"),
            Function::Max => format!("({a} >= {b} || {a} != {a}) ? {a} : {b}"),
            Function::Lt => format!("{a} < {b} ? 1.0 : 0.0"),
            Function::Le => format!("{a} <= {b} ? 1.0 : 0.0"),
            Function::Gt => format!("{a} > {b} ? 1.0 : 0.0"),
            Function::Ge => format!("{a} >= {b} ? 1.0 : 0.0"),
            Function::If => format!("{a} != {a} ? {a} : {a} == 0.0 ? {c} : {b}"),
            _ => format!("{}({a})", function.name()),
        }
    }

    fn power(&self, base: &str, exponent: &str) -> String {
        format!("pow({base}, {exponent})")
    }

    fn declaration(&self, name: &str, value: &str) -> String {
        format!("const double {name} = {value};")
    }
}

impl Program<'_> {
    /// The tape as a C99 function of plain arrays.
    ///
    /// All outputs are stored after the last input is read, so the arrays may overlap.
    pub fn to_c(&self) -> CCode {
        CCode { header: self.c_header(), source: self.c_source(), test: self.c_test() }
    }

    /// The function alone, `static`, for a file that begins with [`c_prelude`].
    pub fn to_c_part(&self) -> String {
        let body = self.c_body();
        format!("static {} {{\n{body}}}\n", self.c_prototype())
    }

    /// `true` where machines of IEEE 754 compute the same bits: nothing is left to a library but square roots,
    /// which the standard defines to the last bit, and angles beyond a million.
    fn is_exact(&self) -> bool {
        let is_exact = |function| {
            use Function::{Abs, Cos, Floor, Ge, Gt, If, Le, Lt, Max, Min, Sign, Sin, Sqrt};
            matches!(
                function,
                Abs | Cos | Floor | Ge | Gt | If | Le | Lt | Max | Min | Sign | Sin | Sqrt
            )
        };
        self.instructions().all(|(_, instruction)| match instruction.action {
            Action::Call(function) => is_exact(function),
            action => action != Action::Power,
        })
    }

    fn c_prototype(&self) -> String {
        let name = &self.names.function;
        format!("void {name}(const double *inputs, const double *parameters, double *outputs)")
    }

    fn c_header(&self) -> String {
        let guard = self.names.function.to_uppercase();
        let legend: String = self
            .legend()
            .iter()
            .map(|line| format!(" * {line}").trim_end().to_owned() + "\n")
            .collect();
        let (n, m, k) = (self.tape.n_inputs, self.tape.n_parameters, self.tape.n_outputs());
        format!(
            "#ifndef {guard}_H\n#define {guard}_H\n\n\
             #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n\
             enum {{ {guard}_INPUTS = {n}, {guard}_PARAMETERS = {m}, {guard}_OUTPUTS = {k} }};\n\n\
             /**\n{legend} */\n{};\n\n\
             #ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
            self.c_prototype()
        )
    }

    fn c_source(&self) -> String {
        let mut source = format!("#include \"{}.h\"\n\n#include <math.h>\n", self.names.function);
        let calls = |function| self.instructions().any(|(_, i)| i.action == Action::Call(function));
        let (has_sine, has_cosine) = (calls(Function::Sin), calls(Function::Cos));
        source.push_str(if has_sine || has_cosine { SINE_AND_COSINE } else { "\n" });
        for (is_called, name, result) in [(has_sine, "sin", "sine"), (has_cosine, "cos", "cosine")]
        {
            if is_called {
                source.push_str(&c_turn(name, result));
            }
        }
        let _ = writeln!(source, "{} {{\n{}}}", self.c_prototype(), self.c_body());
        source
    }

    fn c_body(&self) -> String {
        let mut body = "    (void)inputs;\n    (void)parameters;\n".to_owned();
        for statement in self.statements(&C) {
            let _ = writeln!(body, "    {statement}");
        }
        for (index, result) in self.results(&C).iter().enumerate() {
            let _ = writeln!(body, "    outputs[{index}] = {result};");
        }
        body
    }

    fn c_test(&self) -> String {
        let name = &self.names.function;
        let tolerance = if self.is_exact() { "0.0".to_owned() } else { self.tolerance() };
        let mut test = format!(
            "#include \"{name}.h\"\n\n#include <math.h>\n#include <stdio.h>\n\n\
             static int check(const double *inputs, const double *parameters, const double *expected) {{\n\
             \x20   double outputs[{}];\n    int failed = 0;\n    {name}(inputs, parameters, outputs);\n\
             \x20   for (int i = 0; i < {}; i++) {{\n\
             \x20       const double difference = fabs(outputs[i] - expected[i]);\n\
             \x20       const int is_same = outputs[i] == expected[i] || difference <= {tolerance} * fabs(expected[i])\n\
             \x20           || (outputs[i] != outputs[i] && expected[i] != expected[i]);\n\
             \x20       printf(\"%.17g\\n\", outputs[i]);\n\
             \x20       if (!is_same) {{\n\
             \x20           fprintf(stderr, \"output %d is %.17g, not %.17g\\n\", i, outputs[i], expected[i]);\n\
             \x20           failed = 1;\n        }}\n    }}\n    return failed;\n}}\n\n\
             int main(void) {{\n    int failed = 0;\n",
            self.tape.n_outputs().max(1),
            self.tape.n_outputs(),
        );
        for point in &self.points {
            // C has no empty arrays.
            let array = |values: &[f64]| match values {
                [] => "0.0".to_owned(),
                _ => listed(&C, values),
            };
            let _ = writeln!(
                test,
                "    {{\n        const double inputs[] = {{{}}};\n        const double parameters[] = {{{}}};\n\
                 \x20       const double expected[] = {{{}}};\n        failed |= check(inputs, parameters, expected);\n    }}",
                array(&point.inputs),
                array(&point.parameters),
                array(&point.outputs),
            );
        }
        test.push_str("    fputs(failed ? \"FAILED\\n\" : \"all outputs as expected\\n\", stderr);\n    return failed;\n}\n");
        test
    }
}
