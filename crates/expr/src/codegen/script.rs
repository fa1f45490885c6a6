//! The statements of a function as scripts of other programs hold them.

use super::names::Names;
use super::{Dialect, Program};
use crate::op::Function;

/// A language of scripts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ScriptLanguage {
    /// Python over `sin`, `select` and the like, which a script takes from its library.
    Python,
    /// MATLAB and Octave, with a function `select`.
    Matlab,
    /// Equations of Modelica.
    Modelica,
}

/// The inside of a function.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ScriptBody {
    /// Statements that name the elements of `inputs` and `parameters`; none in Modelica.
    pub arguments: Vec<String>,
    /// Names of all inputs.
    pub inputs: Vec<String>,
    /// Names of all parameters.
    pub parameters: Vec<String>,
    /// Each operation: the name of its result, and the statement.
    pub operations: Vec<(String, String)>,
    /// The outputs.
    pub results: Vec<String>,
}

/// Words of these languages, and names in the scripts themselves.
#[rustfmt::skip]
const WORDS: &[&str] = &[
    "absolute", "acos", "algorithm", "and", "annotation", "asin", "block", "ca", "case", "catch", "check", "connect", "connector",
    "constant", "constrainedby", "der", "discrete", "each", "edge", "elseif", "elsewhen", "encapsulated", "end", "enumeration",
    "equation", "expandable", "external", "final", "floor", "flow", "function", "ge", "gt", "initial", "inner", "inf", "input",
    "jax", "jnp", "larger", "le", "lt", "max", "min", "mod", "model", "nan", "NaN", "Inf", "noEvent", "operator", "otherwise", "outer",
    "output", "package", "parameter", "parfor", "partial", "persistent", "pi", "pre", "protected", "public", "pure", "Real", "record",
    "redeclare", "replaceable", "sample", "select", "sign", "smaller", "sp", "spmd", "stabilisation", "STABILISATION", "stream", "t",
    "terminal", "then", "time", "when", "within", "log10", "abs", "rem", "reinit", "delay", "smooth", "cross", "i", "j", "e",
];

impl Dialect for ScriptLanguage {
    fn literal(&self, value: f64) -> String {
        let is_integer = value.fract() == 0.0 && value.abs() < 1e9;
        match self {
            _ if value.is_nan() => "nan".to_owned(),
            Self::Modelica if value.is_infinite() => {
                format!("{}1e300", if value < 0.0 { "-" } else { "" })
            }
            // Powers with integers are products in every library.
            Self::Python if is_integer => format!("{value:.0}"),
            _ => format!("{value:?}"),
        }
    }

    fn call(&self, function: Function, [a, b, c]: [&str; 3]) -> String {
        let compared = |sign: &str| match self {
            Self::Matlab => format!("double({a} {sign} {b})"),
            _ => format!("noEvent(if {a} {sign} {b} then 1.0 else 0.0)"),
        };
        let name = function.name();
        let is_python = *self == Self::Python;
        match function {
            Function::Ln => format!("log({a})"),
            Function::Atan2 => format!("atan2({a}, {b})"),
            Function::Abs if is_python => format!("absolute({a})"),
            Function::Min if is_python => format!("smaller({a}, {b})"),
            Function::Max if is_python => format!("larger({a}, {b})"),
            Function::Lt | Function::Le | Function::Gt | Function::Ge if is_python => {
                format!("{name}({a}, {b})")
            }
            Function::Min | Function::Max => format!("{name}({a}, {b})"),
            Function::Lt => compared("<"),
            Function::Le => compared("<="),
            Function::Gt => compared(">"),
            Function::Ge => compared(">="),
            Function::If if *self == Self::Modelica => {
                format!("noEvent(if abs({a}) > 0.0 then {b} else {c})")
            }
            Function::If => format!("select({a}, {b}, {c})"),
            _ => format!("{name}({a})"),
        }
    }

    fn power(&self, base: &str, exponent: &str) -> String {
        match self {
            Self::Python => format!("{base} ** {exponent}"),
            _ => format!("{base} ^ {exponent}"),
        }
    }

    fn declaration(&self, name: &str, value: &str) -> String {
        match self {
            Self::Python => format!("{name} = {value}"),
            _ => format!("{name} = {value};"),
        }
    }

    fn element(&self, array: &str, index: usize) -> String {
        match self {
            Self::Matlab => format!("{array}({})", index + 1),
            _ => format!("{array}[{index}]"),
        }
    }
}

impl Program<'_> {
    /// The statements of the function in a language of scripts.
    pub fn body(&self, language: ScriptLanguage) -> ScriptBody {
        let own = Program {
            tape: self.tape,
            signature: self.signature.clone(),
            names: Names::avoiding(&self.signature, WORDS),
            points: Vec::new(),
            note: Vec::new(),
        };
        let operation = |(register, instruction)| {
            let name = own.result_name(register);
            let statement = language.declaration(&name, &own.value(&language, &instruction));
            (name, statement)
        };
        let has_arguments = language != ScriptLanguage::Modelica;
        ScriptBody {
            arguments: if has_arguments { own.arguments(&language) } else { Vec::new() },
            operations: own.instructions().map(operation).collect(),
            results: own.results(&language),
            inputs: own.names.inputs,
            parameters: own.names.parameters,
        }
    }
}
