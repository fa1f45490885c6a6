//! The compiled part of the Python package `bksim`: coarse functions over the crates, wrapped by the
//! classes of `python/bksim`.
//!
//! | room | holds |
//! |---|---|
//! | `fault.rs` | errors and panics as Python's exceptions; the interpreter lock given up around work |
//! | `file.rs` | files that take the place of others once they are whole |
//! | `arrays.rs` | numbers as NumPy arrays without a copy |
//! | `document.rs` | the text of a model as data, and back |
//! | `derivatives.rs` | functions and quantities with their derivatives |
//! | `derived.rs` | equations that models of other values share |
//! | `engine.rs` | a model with its equations, at one set of values |
//! | `laws.rs` | inputs whose laws are functions of Python |
//! | `interrupt.rs` | Ctrl-C and progress in the midst of work |
//! | `solving.rs` | a run, which Ctrl-C stops |
//! | `stepping.rs` | a run that Python advances |
//! | `solution.rs` | what a run leaves |
//! | `logged.rs` | runs as logs, and back |
//! | `functions.rs` | the compiled functions |
//! | `gradient.rs` | derivatives of one number of a motion, back along it |
//! | `expr.rs` | the algebra by itself |
//! | `questions.rs` | questions besides motion in time |
//! | `show.rs` | curves, pages and the numbers of a run |
//! | `drawing.rs` | pictures and films |
//! | `sweep.rs` | the runs of many cases, here or on other machines |
//! | `command.rs` | the command line |
//!
//! # Invariants
//!
//! No panic leaves it but as `bksim.InternalError`. Whatever takes longer than a call holds no
//! interpreter lock.

#![expect(clippy::needless_pass_by_value, reason = "what comes from Python is made for the call")]

mod arrays;
mod built;
mod command;
mod derivatives;
mod derived;
mod design;
mod document;
mod drawing;
mod engine;
mod expr;
mod fault;
mod file;
mod functions;
mod gradient;
mod interrupt;
mod laws;
mod logged;
mod questions;
mod reading;
mod show;
mod solution;
mod solving;
mod stepping;
mod sweep;

use pyo3::prelude::*;

/// The compiled part of the package.
#[pymodule(gil_used = false)]
#[pyo3(name = "_bksim")]
fn bksim_module(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", bksim::VERSION)?;
    m.add_class::<engine::Engine>()?;
    m.add_class::<solution::Run>()?;
    m.add_class::<functions::Functions>()?;
    m.add_class::<derivatives::Derivatives>()?;
    m.add_class::<stepping::Stepping>()?;
    m.add_class::<stepping::SavedState>()?;
    m.add_class::<expr::Expr>()?;
    m.add_class::<expr::Compiled>()?;
    m.add_class::<sweep::Study>()?;
    m.add_function(wrap_pyfunction!(document::to_toml, m)?)?;
    m.add_function(wrap_pyfunction!(document::from_toml, m)?)?;
    m.add_function(wrap_pyfunction!(document::with_values, m)?)?;
    m.add_function(wrap_pyfunction!(engine::check_values, m)?)?;
    m.add_function(wrap_pyfunction!(functions::compiled_functions, m)?)?;
    m.add_function(wrap_pyfunction!(derivatives::derivatives_of, m)?)?;
    m.add_function(wrap_pyfunction!(solving::solve, m)?)?;
    m.add_function(wrap_pyfunction!(gradient::weight_columns, m)?)?;
    m.add_function(wrap_pyfunction!(gradient::gradient_of, m)?)?;
    m.add_function(wrap_pyfunction!(stepping::begin, m)?)?;
    m.add_function(wrap_pyfunction!(stepping::held_again, m)?)?;
    m.add_function(wrap_pyfunction!(stepping::saved_again, m)?)?;
    m.add_function(wrap_pyfunction!(questions::closing_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::kinematics_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::limits_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::curves_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::workspaces_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::assemblies_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::static_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::linearize_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::modes_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::bode_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::inverse_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::doctor_of, m)?)?;
    m.add_function(wrap_pyfunction!(questions::verify_of, m)?)?;
    m.add_function(wrap_pyfunction!(logged::open_log, m)?)?;
    m.add_function(wrap_pyfunction!(logged::save_log, m)?)?;
    m.add_function(wrap_pyfunction!(logged::log_bytes, m)?)?;
    m.add_function(wrap_pyfunction!(logged::carried_run, m)?)?;
    m.add_function(wrap_pyfunction!(drawing::picture, m)?)?;
    m.add_function(wrap_pyfunction!(drawing::render, m)?)?;
    m.add_function(wrap_pyfunction!(show::page, m)?)?;
    m.add_function(wrap_pyfunction!(show::live_page, m)?)?;
    m.add_function(wrap_pyfunction!(show::report, m)?)?;
    m.add_function(wrap_pyfunction!(show::figure, m)?)?;
    m.add_function(wrap_pyfunction!(show::overview, m)?)?;
    m.add_function(wrap_pyfunction!(show::unit_word, m)?)?;
    m.add_function(wrap_pyfunction!(design::design_answer, m)?)?;
    m.add_function(wrap_pyfunction!(sweep::si_unit, m)?)?;
    m.add_function(wrap_pyfunction!(sweep::column_named, m)?)?;
    m.add_function(wrap_pyfunction!(command::command, m)?)?;
    m.add_function(wrap_pyfunction!(document::examples, m)?)?;
    m.add_function(wrap_pyfunction!(fault::explain, m)?)?;
    m.add_function(wrap_pyfunction!(fault::speak, m)?)?;
    m.add_function(wrap_pyfunction!(fault::said, m)?)?;
    m.add_function(wrap_pyfunction!(fault::said_answer, m)?)?;
    m.add_function(wrap_pyfunction!(fault::panic_for_tests, m)?)?;
    Ok(())
}
