//! Linear equations as a function that leaves the program: ẋ = A x + B u, z = C x + D u.

use bksim_expr::{Expr, Pool, Quantity, Signature, SymbolId, Tape};
use bksim_mbs::quantity::rate_unit;
use nalgebra::DMatrix;

use crate::error::AnalysisError;
use crate::exported::ExportedFunction;
use crate::linear::Linear;

/// The linear equations of the model called `name` as a function of deviations of states and inputs; its results are
/// the rates of the states, then the outputs.
///
/// # Errors
/// [`AnalysisError::Compile`] where matrices are too large for a tape.
pub fn exported_linear(name: &str, linear: &Linear) -> Result<ExportedFunction, AnalysisError> {
    let pool = Pool::new();
    let n = linear.states.len();
    let symbols: Vec<Expr> =
        (0..n + linear.inputs.len()).map(|k| pool.symbol(&format!("x{k}"))).collect();
    let row = |of_states: &DMatrix<f64>, of_inputs: &DMatrix<f64>, i: usize| {
        let entries =
            of_states.row(i).iter().chain(of_inputs.row(i).iter()).copied().collect::<Vec<f64>>();
        let terms = entries.iter().zip(&symbols);
        let terms: Vec<Expr> = terms.map(|(entry, x)| pool.mul(pool.float(*entry), *x)).collect();
        pool.sum(terms)
    };
    let rates = (0..n).map(|i| row(&linear.a, &linear.b, i));
    let outputs = (0..linear.outputs.len()).map(|i| row(&linear.c, &linear.d, i));
    let results: Vec<Expr> = rates.chain(outputs).collect();
    let arguments: Vec<SymbolId> =
        symbols.iter().filter_map(|symbol| pool.symbol_id(*symbol)).collect();
    let tape = Tape::compile(&pool, &results, &arguments, &[])?;
    let states = || linear.states.iter();
    let rate = |column: &crate::table::Column| {
        Quantity::new(&format!("d/dt {}", column.name), &rate_unit(&column.unit, 1))
    };
    let own = |column: &crate::table::Column| Quantity::new(&column.name, &column.unit);
    let signature = Signature {
        name: format!("{name}_linear"),
        inputs: states()
            .map(own)
            .chain(linear.inputs.iter().map(|input| Quantity::new(input, "")))
            .collect(),
        parameters: Vec::new(),
        outputs: states().map(rate).chain(linear.outputs.iter().map(own)).collect(),
    };
    let summary = "rates of the states, then outputs, by deviations from the state";
    Ok(ExportedFunction { tape, signature, summary, parameters: Vec::new(), note: String::new() })
}
