//! Code that travels: a tape as a function in C, Rust or Python, or as JSON.
//!
//! Every form takes inputs and parameters in the order they were compiled, names them with their
//! units, and contains points to test itself at: inputs with the outputs of our own evaluation. The
//! statements are those of the tape, one per instruction, so that all forms compute the same
//! operations in the same order; only the libraries' elementary functions differ.

mod c;
mod json;
mod names;
mod python;
mod rust;
mod script;

pub use c::{CCode, c_prelude};
pub use script::{ScriptBody, ScriptLanguage};

use crate::op::Function;
use crate::tape::{Action, Instruction, Tape};
use names::Names;

/// A named number that goes into or comes out of a function.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Quantity {
    /// The name in the documentation; identifiers are made of it.
    pub name: String,
    /// The unit, for documentation alone; empty for a plain number.
    pub unit: String,
}

impl Quantity {
    /// A quantity with a unit such as `m` or `rad/s`, or with an empty one.
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned() }
    }
}

/// Name, inputs, parameters and outputs of a generated function, in the tape's order.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Signature {
    /// The function's name; characters that no identifier may have become underscores.
    pub name: String,
    /// One for each input of the tape.
    pub inputs: Vec<Quantity>,
    /// One for each parameter of the tape.
    pub parameters: Vec<Quantity>,
    /// One for each output of the tape.
    pub outputs: Vec<Quantity>,
}

/// Reason why no code can be written.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CodegenError {
    /// The signature does not fit the tape.
    #[error("the tape has {expected} {what}, but {found} are named")]
    WrongCount {
        /// `inputs`, `parameters` or `outputs`.
        what: &'static str,
        /// How many the tape has.
        expected: usize,
        /// How many the signature names.
        found: usize,
    },
}

/// A point and the outputs there.
#[derive(Clone, PartialEq, Debug)]
pub struct TestPoint {
    /// Values of the inputs.
    pub inputs: Vec<f64>,
    /// Values of the parameters.
    pub parameters: Vec<f64>,
    /// The outputs as the tape evaluates them.
    pub outputs: Vec<f64>,
}

/// A tape with names, ready to be written in any of the languages.
///
/// ```
/// use bksim_expr::{Pool, Quantity, Signature, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let energy = pool.parse("m*g*l*(1 - cos(q))")?;
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let tape = Tape::compile(&pool, &[energy], &[id("q")], &["m", "g", "l"].map(id))?;
/// let program = tape.program(&Signature {
///     name: "potential".to_owned(),
///     inputs: vec![Quantity::new("q", "rad")],
///     parameters: ["m", "g", "l"].map(|name| Quantity::new(name, "")).to_vec(),
///     outputs: vec![Quantity::new("energy", "J")],
/// })?;
/// assert!(program.to_c().source.contains("cos(q)"));
/// assert!(program.to_rust().contains("M::cos(q)"));
/// assert!(program.to_python().contains("np.cos(q)"));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Program<'t> {
    tape: &'t Tape,
    signature: Signature,
    names: Names,
    points: Vec<TestPoint>,
    /// Lines about the function as a whole.
    note: Vec<String>,
}

/// Points that generated code is tested at.
const N_POINTS: usize = 3;

/// Largest relative difference that generated tests allow, as a power of ten: the last digits of the elementary
/// functions of other libraries.
const TOLERANCE: i32 = -14;

/// Times by which a relative change of the inputs may grow in the outputs until tests allow more.
const GROWTH: f64 = 10.0;

/// Relative change of the inputs by which that is measured.
const CHANGE: f64 = 1e-9;

impl Tape {
    /// Names inputs, parameters and outputs of the tape, to write it as code.
    ///
    /// # Errors
    /// [`CodegenError::WrongCount`] when the signature has more or fewer names than the tape.
    pub fn program(&self, signature: &Signature) -> Result<Program<'_>, CodegenError> {
        for (what, expected, found) in [
            ("inputs", self.n_inputs, signature.inputs.len()),
            ("parameters", self.n_parameters, signature.parameters.len()),
            ("outputs", self.outputs.len(), signature.outputs.len()),
        ] {
            if expected != found {
                return Err(CodegenError::WrongCount { what, expected, found });
            }
        }
        let points = test_points(self);
        Ok(Program {
            tape: self,
            names: Names::new(signature),
            signature: signature.clone(),
            points,
            note: Vec::new(),
        })
    }
}

/// Pseudo-random points, preferably such that all outputs are finite.
fn test_points(tape: &Tape) -> Vec<TestPoint> {
    let mut state = 1;
    let mut fallback = Vec::new();
    let mut points = Vec::new();
    // Where a function has a small domain, more of the points tried fall outside.
    for _ in 0..16 * N_POINTS {
        let mut values = |n| -> Vec<f64> {
            (0..n).map(|_| 0.1 + 1.5 * crate::pool::unit_random(&mut state)).collect()
        };
        let (parameters, inputs) = (values(tape.n_parameters), values(tape.n_inputs));
        let mut outputs = vec![0.0; tape.n_outputs()];
        tape.evaluate(&mut tape.workspace(&parameters), &inputs, &mut outputs);
        let is_finite = outputs.iter().all(|value| value.is_finite());
        let list = if is_finite { &mut points } else { &mut fallback };
        list.push(TestPoint { inputs, parameters, outputs });
        if points.len() == N_POINTS {
            break;
        }
    }
    points.extend(fallback);
    points.truncate(N_POINTS);
    points
}

/// How many times larger than a relative change of inputs and parameters that of an output is at a point.
fn growth(tape: &Tape, point: &TestPoint) -> f64 {
    let mut state = 1;
    let mut most: f64 = 0.0;
    for _ in 0..4 {
        let mut aside = |values: &[f64]| -> Vec<f64> {
            let share =
                |x: &f64| x * (1.0 + CHANGE * (2.0 * crate::pool::unit_random(&mut state) - 1.0));
            values.iter().map(share).collect()
        };
        let (parameters, inputs) = (aside(&point.parameters), aside(&point.inputs));
        let mut outputs = vec![0.0; tape.n_outputs()];
        tape.evaluate(&mut tape.workspace(&parameters), &inputs, &mut outputs);
        for (there, here) in outputs.iter().zip(&point.outputs) {
            let change = ((there - here) / (CHANGE * here)).abs();
            if change.is_finite() {
                most = most.max(change);
            }
        }
    }
    most
}

/// Values and calls in one language.
trait Dialect {
    /// A number.
    fn literal(&self, value: f64) -> String;
    /// A function of one, two or three arguments.
    fn call(&self, function: Function, arguments: [&str; 3]) -> String;
    /// `base^exponent`.
    fn power(&self, base: &str, exponent: &str) -> String;
    /// A statement that gives a value a name.
    fn declaration(&self, name: &str, value: &str) -> String;
    /// An element of an array.
    fn element(&self, array: &str, index: usize) -> String {
        format!("{array}[{index}]")
    }
}

impl Program<'_> {
    /// Largest relative difference that tests allow: more where an output changes by much more than the inputs.
    fn tolerance(&self) -> String {
        let most = self.points.iter().map(|point| growth(self.tape, point)).fold(GROWTH, f64::max);
        #[expect(clippy::cast_possible_truncation, reason = "a power of ten of a number")]
        let beyond = (most / GROWTH).log10().ceil() as i32;
        format!("1e{}", TOLERANCE + beyond)
    }

    /// Program with lines about the function as a whole in its header.
    #[must_use]
    pub fn with_note(mut self, note: &str) -> Self {
        self.note = note.lines().map(names::line).collect();
        self
    }

    /// The name of the function in the code.
    pub fn identifier(&self) -> &str {
        &self.names.function
    }

    /// The points that every form of the code is tested at.
    pub fn test_points(&self) -> &[TestPoint] {
        &self.points
    }

    /// The operations that anything reads, each with the register it writes.
    fn instructions(&self) -> impl Iterator<Item = (usize, Instruction)> {
        let is_read = self.read_registers();
        self.tape.operations().filter(move |&(register, _)| is_read[register])
    }

    /// A register in an expression: its value or its name.
    fn operand(&self, dialect: &dyn Dialect, register: u32) -> String {
        let register = register as usize;
        let tape = self.tape;
        if let Some(&value) = tape.constants.get(register) {
            let literal = dialect.literal(value);
            return if literal.starts_with('-') { format!("({literal})") } else { literal };
        }
        let offset = register - tape.constants.len();
        if let Some(name) = self.names.parameters.get(offset) {
            return name.clone();
        }
        match self.names.inputs.get(offset - tape.n_parameters) {
            Some(name) => name.clone(),
            None => format!("v{}", offset - tape.n_parameters - tape.n_inputs),
        }
    }

    /// The name that an instruction's register is given.
    fn result_name(&self, register: usize) -> String {
        format!("v{}", register - self.tape.first_prologue())
    }

    /// Declarations of all that is read from the arguments, then of every instruction.
    fn statements(&self, dialect: &dyn Dialect) -> Vec<String> {
        let mut statements = self.arguments(dialect);
        for (register, instruction) in self.instructions() {
            let value = self.value(dialect, &instruction);
            statements.push(dialect.declaration(&self.result_name(register), &value));
        }
        statements
    }

    /// Declarations of all that is read from the arguments.
    fn arguments(&self, dialect: &dyn Dialect) -> Vec<String> {
        let is_read = self.read_registers();
        let first = self.tape.constants.len();
        let arguments = [("parameters", &self.names.parameters), ("inputs", &self.names.inputs)];
        let indexed = arguments.into_iter().flat_map(|(array, names)| {
            names.iter().enumerate().map(move |(index, name)| (array, index, name))
        });
        let read = indexed.enumerate().filter(|&(offset, _)| is_read[first + offset]);
        read.map(|(_, (array, i, name))| dialect.declaration(name, &dialect.element(array, i)))
            .collect()
    }

    /// Whether each register is read by an instruction or an output.
    fn read_registers(&self) -> Vec<bool> {
        let mut is_read = vec![false; self.tape.n_registers];
        let read = self.tape.operations().flat_map(|(_, i)| [i.a, i.b, i.c]);
        for register in read.chain(self.tape.outputs.iter().copied()) {
            is_read[register as usize] = true;
        }
        is_read
    }

    fn value(&self, dialect: &dyn Dialect, instruction: &Instruction) -> String {
        let [a, b, c] =
            [instruction.a, instruction.b, instruction.c].map(|r| self.operand(dialect, r));
        match instruction.action {
            Action::Add => format!("{a} + {b}"),
            Action::Subtract => format!("{a} - {b}"),
            Action::Multiply => format!("{a} * {b}"),
            Action::Divide => format!("{a} / {b}"),
            Action::Negate => format!("-{a}"),
            Action::Power => dialect.power(&a, &b),
            Action::Call(function) => dialect.call(function, [&a, &b, &c]),
            Action::Turn => unreachable!("operations are single"),
        }
    }

    /// The operands that are the outputs.
    fn results(&self, dialect: &dyn Dialect) -> Vec<String> {
        self.tape.outputs.iter().map(|&register| self.operand(dialect, register)).collect()
    }

    /// Lines that document each argument.
    fn legend(&self) -> Vec<String> {
        let signature = &self.signature;
        let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let mut lines = vec![
            format!(
                "{}: {} from {} and {}.",
                names::line(&signature.name),
                count(signature.outputs.len(), "output"),
                count(signature.inputs.len(), "input"),
                count(signature.parameters.len(), "parameter"),
            ),
            String::new(),
        ];
        if !self.note.is_empty() {
            lines.extend(self.note.iter().cloned().chain([String::new()]));
        }
        for (array, quantities) in [
            ("inputs", &signature.inputs),
            ("parameters", &signature.parameters),
            ("outputs", &signature.outputs),
        ] {
            for (index, quantity) in quantities.iter().enumerate() {
                let (name, unit) = (names::line(&quantity.name), names::line(&quantity.unit));
                let suffix = if unit.is_empty() { unit } else { format!(", in {unit}") };
                lines.push(format!("{array}[{index}]: {name}{suffix}"));
            }
        }
        lines
    }
}

/// Values separated by commas.
fn listed(dialect: &dyn Dialect, values: &[f64]) -> String {
    let literals: Vec<String> = values.iter().map(|&value| dialect.literal(value)).collect();
    literals.join(", ")
}
