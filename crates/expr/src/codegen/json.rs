//! The tape as JSON, for readers that bring their own evaluator.
//!
//! ```text
//! {"format": "bksim-tape", "version": 1, "name": …,
//!  "constants": [number …], "parameters": [{"name", "unit"} …], "inputs": [{"name", "unit"} …],
//!  "instructions": [["multiply", a, b] …], "n_prologue": n,
//!  "outputs": [{"name", "unit", "register"} …],
//!  "tests": [{"parameters": […], "inputs": […], "outputs": […]} …]}
//! ```
//!
//! Registers are numbered from 0: constants, parameters, inputs, then one for each instruction. The
//! first `n_prologue` instructions depend on constants and parameters alone. Numbers that JSON
//! lacks are the strings `"inf"`, `"-inf"` and `"nan"`.

use super::{Program, Quantity};
use crate::op::Function;
use crate::tape::{Action, Instruction};
use std::fmt::Write;

impl Program<'_> {
    /// The tape as JSON; the module's documentation gives the format.
    ///
    /// An instruction is its name with the registers it reads: `add`, `subtract`, `multiply`,
    /// `divide`, `negate`, `power`, or a function as in the text form. Registers are numbered from
    /// 0: constants, parameters, inputs, then one for each instruction.
    pub fn to_json(&self) -> String {
        let tape = self.tape;
        let outputs =
            self.signature.outputs.iter().zip(&tape.outputs).map(|(quantity, register)| {
                let Quantity { name, unit } = quantity;
                format!(
                    "{{\"name\": {}, \"unit\": {}, \"register\": {register}}}",
                    text(name),
                    text(unit)
                )
            });
        let tests = self.points.iter().map(|point| {
            let [parameters, inputs, outputs] =
                [&point.parameters, &point.inputs, &point.outputs].map(|v| numbers(v));
            format!(
                "{{\"parameters\": {parameters}, \"inputs\": {inputs}, \"outputs\": {outputs}}}"
            )
        });
        let note = match self.note.join("\n") {
            note if note.is_empty() => note,
            note => format!("  \"note\": {},\n", text(&note)),
        };
        format!(
            "{{\n  \"format\": \"bksim-tape\",\n  \"version\": 1,\n  \"name\": {},\n{note}  \
             \"constants\": {},\n  \"parameters\": {},\n  \"inputs\": {},\n  \
             \"instructions\": {},\n  \"n_prologue\": {},\n  \"outputs\": {},\n  \"tests\": {}\n}}\n",
            text(&self.signature.name),
            numbers(&tape.constants),
            list(self.signature.parameters.iter().map(quantity)),
            list(self.signature.inputs.iter().map(quantity)),
            list(tape.operations().map(|(_, i)| instruction(&i))),
            tape.first_body - tape.first_prologue(),
            list(outputs),
            list(tests),
        )
    }
}

fn list(items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.collect();
    if items.is_empty() {
        "[]".to_owned()
    } else {
        format!("[\n    {}\n  ]", items.join(",\n    "))
    }
}

fn numbers(values: &[f64]) -> String {
    let number = |value: &f64| {
        if value.is_finite() {
            format!("{value:?}")
        } else if value.is_nan() {
            "\"nan\"".to_owned()
        } else {
            format!("\"{value}\"")
        }
    };
    format!("[{}]", values.iter().map(number).collect::<Vec<_>>().join(", "))
}

fn quantity(quantity: &Quantity) -> String {
    format!("{{\"name\": {}, \"unit\": {}}}", text(&quantity.name), text(&quantity.unit))
}

fn instruction(instruction: &Instruction) -> String {
    let Instruction { action, a, b, c } = instruction;
    let (name, n_operands) = match action {
        Action::Add => ("add", 2),
        Action::Subtract => ("subtract", 2),
        Action::Multiply => ("multiply", 2),
        Action::Divide => ("divide", 2),
        Action::Negate => ("negate", 1),
        Action::Power => ("power", 2),
        Action::Call(Function::If) => ("if", 3),
        Action::Call(function) => (function.name(), function.arity()),
        Action::Turn => unreachable!("operations are single"),
    };
    let operands: Vec<String> = [a, b, c][..n_operands].iter().map(ToString::to_string).collect();
    format!("[\"{name}\", {}]", operands.join(", "))
}

/// A JSON string.
fn text(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c < ' ' => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
