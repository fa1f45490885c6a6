//! The tape from the state to the poses, which the page evaluates.
//!
//! ```text
//! {"names": [operation …], "constants": [x …], "parameters": [x …], "inputs": n,
//!  "code": [operation, register …, operation, register …], "prologue": n, "outputs": [register …]}
//! ```
//!
//! Registers are those of the tape's JSON: constants, parameters, inputs, then one for each
//! operation. The first `prologue` operations depend on constants and parameters alone. An
//! operation is an index into `names`, followed by the registers it reads.

use bksim::Mechanism;
use bksim::expr::{Quantity, Signature};
use bksim::sim::pose::Poses;
use serde_json::{Value, json};

use crate::error::PageError;

/// The tape of a mechanism with the values of its parameters.
pub(crate) fn tape(mechanism: &Mechanism) -> Result<Value, PageError> {
    let poses = Poses::compile(&mechanism.model, &mechanism.system)?;
    let tape = poses.tape();
    let unnamed = |n: usize| (0..n).map(|i| Quantity::new(&format!("x{i}"), "")).collect();
    let signature = Signature {
        name: "poses".to_owned(),
        inputs: unnamed(tape.n_inputs()),
        parameters: unnamed(tape.n_parameters()),
        outputs: unnamed(tape.n_outputs()),
    };
    let whole: Value = serde_json::from_str(&tape.program(&signature)?.to_json())?;

    // The same operations as numbers, which take many fewer characters.
    let mut names: Vec<&str> = Vec::new();
    let mut code: Vec<u64> = Vec::new();
    for operation in list(&whole["instructions"]) {
        let (name, registers) = list(operation).split_first().expect("an operation has a name");
        let name = name.as_str().expect("names of operations are text");
        let known = names.iter().position(|known| *known == name);
        let number = known.unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        });
        code.push(number as u64);
        let register = |value: &Value| value.as_u64().expect("registers are counted from 0");
        code.extend(registers.iter().map(register));
    }
    let outputs: Vec<&Value> =
        list(&whole["outputs"]).iter().map(|output| &output["register"]).collect();
    Ok(json!({
        "names": names,
        "constants": whole["constants"],
        "parameters": mechanism.parameters,
        "inputs": tape.n_inputs(),
        "code": code,
        "prologue": whole["n_prologue"],
        "outputs": outputs,
    }))
}

/// A list in the tape's JSON.
fn list(value: &Value) -> &[Value] {
    value.as_array().expect("instructions, their registers and outputs are lists")
}
