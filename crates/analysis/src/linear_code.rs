//! Linear equations as a function that leaves the program: ẋ = A x + B u, z = C x + D u.

use std::fmt::Write;

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

/// The linear equations as a function of MATLAB and Octave called `id`, which gives the matrices with the names of rows
/// and columns; `note` says which state they are about.
pub fn linear_matlab(id: &str, linear: &Linear, note: &str) -> String {
    let list = |names: &mut dyn Iterator<Item = &str>| {
        let names: Vec<String> =
            names.map(|name| format!("'{}'", name.replace('\'', "''"))).collect();
        format!("{{{}}}", names.join(", "))
    };
    let mut out = format!(
        "function s = {id}()\n% x' = A x + B u, z = C x + D u, by deviations; SI units and radians. {note}\n%\n\
         %     s = {id}();\n\
         %     sys = ss(s.A, s.B, s.C, s.D, 'StateName', s.states, 'InputName', s.inputs, 'OutputName', s.outputs);\n\
         %     sampled = c2d(sys, 0.01);\n"
    );
    let matrices = [("A", &linear.a), ("B", &linear.b), ("C", &linear.c), ("D", &linear.d)];
    for (name, matrix) in matrices {
        let (rows, columns) = matrix.shape();
        let row = |i: usize| {
            let row: Vec<String> = matrix.row(i).iter().map(|x| format!("{x:?}")).collect();
            row.join(", ")
        };
        let entries: Vec<String> = (0..rows).map(row).collect();
        let value = if rows * columns == 0 {
            format!("zeros({rows}, {columns})")
        } else {
            format!("[{}]", entries.join("; ...\n    "))
        };
        let _ = writeln!(out, "s.{name} = {value};");
    }
    let states = list(&mut linear.states.iter().map(|column| column.name.as_str()));
    let inputs = list(&mut linear.inputs.iter().map(String::as_str));
    let outputs = list(&mut linear.outputs.iter().map(|column| column.name.as_str()));
    let _ =
        writeln!(out, "s.states = {states};\ns.inputs = {inputs};\ns.outputs = {outputs};\nend");
    out
}
