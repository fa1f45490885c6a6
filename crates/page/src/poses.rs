//! The tape from the state to the poses, as the page evaluates it.
//!
//! ```text
//! {"names": [operation …], "constants": [x …], "parameters": [x …], "inputs": n,
//!  "code": [operation, register …, operation, register …], "prologue": n, "outputs": [register …]}
//! ```
//!
//! Registers are those of the tape's JSON: constants, parameters, inputs, then one for each operation.
//! The first `prologue` operations depend on constants and parameters alone. An operation is a place
//! in `names`, followed by the registers it reads.

use bksim::Mechanism;
use bksim::expr::{Quantity, Signature};
use bksim::sim::pose::Poses;
use serde_json::{Value, json};

use crate::PageError;

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

    // The same operations as numbers, of which there are many fewer characters.
    let mut names: Vec<&str> = Vec::new();
    let mut code: Vec<u64> = Vec::new();
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    for operation in whole["instructions"].as_array().into_iter().flatten() {
        let name = operation[0].as_str().unwrap_or_default();
        let known = names.iter().position(|known| *known == name);
        let number = known.unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        });
        code.push(number as u64);
        code.extend(list(operation).iter().skip(1).filter_map(Value::as_u64));
    }
    let outputs: Vec<Value> =
        list(&whole["outputs"]).iter().map(|output| output["register"].clone()).collect();
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
