//! `bksim code`: the functions of a mechanism as files in other languages.

use std::fs;
use std::io::Write;
use std::path::Path;

use bksim::analysis::{
    AnalysisError, Channels, ExportedFunction, Part, exported, exported_linear, linearize,
};
use bksim::expr::Program;
use bksim::fmu::{Core, Request, Solver, Variable, solver};
use bksim::model::Model;
use bksim::model::file::ShownUnits;
use bksim::model::message::counted;
use serde_json::{Value, json};

use super::analysis::state::about;
use crate::args::code::{Code, Language, Part as PartArg};
use crate::exit::{Failure, Status};
use crate::origin::{is_of_model, label_of, stamped};
use crate::output;
use crate::output_file::OutputFile;
use crate::render;
use crate::source::{Loaded, Text, derive, load};

const UNDONE: &str = "no code was written";

pub(crate) fn run(args: &Code, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let loaded = load(&args.model, nesting)?;
    let label = label_of(&loaded.source.path);
    if args.part == PartArg::Solver {
        return of_solver(loaded, args, &label, as_json);
    }
    let found = match args.part {
        PartArg::Dynamics => of_equations(&loaded.source, loaded.model, Part::Dynamics, args)?,
        PartArg::Kinematics => of_equations(&loaded.source, loaded.model, Part::Kinematics, args)?,
        PartArg::Linear | PartArg::Solver => of_linear(loaded.model, args, &loaded.source),
    };
    let functions = found.map_err(|error| loaded.source.rejected(error.diagnostics()))?;

    // All texts, then all files, so that either all are written or none is begun.
    let mut files = Vec::new();
    for function in &functions {
        let program = function.tape.program(&function.signature);
        let program = program.expect("a signature is made for its tape").with_note(&function.note);
        files.extend(texts(&program, args.lang));
    }
    let written = write(args, files, &label)?;

    if as_json {
        let functions: Vec<Value> = functions.iter().map(described).collect();
        let mut body = json!({ "functions": functions, "files": written });
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("code", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    let line = |function: &ExportedFunction| {
        let ExportedFunction { tape, signature, summary, note, .. } = function;
        let counts = format!(
            "{}, {}",
            counted(tape.operation_count(), "operation", "operations"),
            counted(tape.n_outputs(), "output", "outputs")
        );
        let note = if note.is_empty() { String::new() } else { format!("  {note}\n") };
        format!("{note}  {}: {summary}; {counts}\n", signature.name)
    };
    let files = written.iter().map(|path| format!("wrote {path}\n"));
    let text: String = functions.iter().map(line).chain(files).collect();
    output::report(text.trim_end())?;
    Ok(Status::Done)
}

/// Writes files into the folder of the options; all are planned before the first is written.
fn write(args: &Code, files: Vec<(String, String)>, label: &str) -> Result<Vec<String>, Failure> {
    fs::create_dir_all(&args.output).map_err(|error| {
        Failure::file(&args.output, format!("cannot be made: {error}; {UNDONE}"), None)
    })?;
    let planned: Result<Vec<_>, Failure> = files
        .into_iter()
        .map(|(name, text)| {
            let path = args.output.join(name);
            let model: &[&Path] = &[&args.model.model];
            let may_replace = args.force || is_of_model(&path, label);
            Ok((OutputFile::plan(&path, ("model", model), may_replace, UNDONE)?, text))
        })
        .collect();
    let mut written = Vec::new();
    for (file, text) in planned? {
        let mut out = file.create()?;
        let bytes = stamped(file.path(), text.into_bytes(), label);
        out.write_all(&bytes).map_err(|error| {
            Failure::file(file.path(), format!("cannot be written: {error}"), None)
        })?;
        out.finish()?;
        written.push(file.path().display().to_string());
    }
    Ok(written)
}

/// Writes the solver.
fn of_solver(loaded: Loaded, args: &Code, label: &str, as_json: bool) -> Result<Status, Failure> {
    if args.lang != Language::C {
        return Err(Failure::usage("the solver is written in C alone", "leave `--lang` out"));
    }
    let Loaded { source, model, warnings, .. } = loaded;
    let mut mechanism = derive(&source, model)?;
    let request = Request { inputs: args.input.clone(), outputs: args.of.clone() };
    let core = Core::of(&mut mechanism, &request);
    let core = core.map_err(|error| source.rejected(error.diagnostics()))?;
    let Solver { name, header, source: code, test } = solver(&core);
    let files = [(".h", header), (".c", code), ("_test.c", test)];
    let files = files.map(|(ending, text)| (format!("{name}{ending}"), text));
    let written = write(args, files.into(), label)?;
    if as_json {
        let value = |v: &Variable| json!({ "name": v.name, "unit": v.unit, "value": v.start });
        let output = |v: &Variable| json!({ "name": v.name, "unit": v.unit });
        let values: Vec<Value> = core.values.iter().map(value).collect();
        let outputs: Vec<Value> = core.outputs.iter().map(output).collect();
        let mut body = json!({
            "solver": { "values": values, "outputs": outputs },
            "files": written,
        });
        body["diagnostics"] = render::json_all(&source, &warnings);
        output::json("code", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&source, &warnings);
    let counts = format!(
        "  {name}: start, steps and events; {}, {}\n",
        counted(core.values.len(), "value", "values"),
        counted(core.outputs.len(), "output", "outputs")
    );
    let lines: Vec<String> = written.iter().map(|path| format!("wrote {path}")).collect();
    output::report((counts + &lines.join("\n")).trim_end())?;
    Ok(Status::Done)
}

/// The functions of the equations, or why there are none.
fn of_equations(
    source: &Text,
    model: Model,
    part: Part,
    args: &Code,
) -> Result<Result<Vec<ExportedFunction>, AnalysisError>, Failure> {
    let mechanism = derive(source, model)?;
    // Of the inputs that the model states, those that are arguments.
    let is_parameter = |name: &&String| mechanism.model.parameters.iter().any(|p| p.name == **name);
    let stated = mechanism.model.io.inputs.iter().filter(is_parameter).cloned();
    let inputs = if args.input.is_empty() { stated.collect() } else { args.input.clone() };
    Ok(exported(&mechanism, part, &inputs))
}

/// The function of the linear equations.
fn of_linear(
    model: Model,
    args: &Code,
    source: &Text,
) -> Result<Vec<ExportedFunction>, AnalysisError> {
    let name = model.name.clone();
    let channels =
        Channels { inputs: args.input.clone(), outputs: args.of.clone(), states: Vec::new() };
    let linear = linearize(model, args.at, &channels)?;
    let units = ShownUnits::of_model(&source.text);
    let function = exported_linear(&name, &linear)?;
    let note = format!("Linear {}.", about(&linear.state, &units));
    Ok(vec![ExportedFunction { note, ..function }])
}

/// The files of a function, each with its name.
fn texts(program: &Program<'_>, language: Language) -> Vec<(String, String)> {
    let name = program.identifier();
    let file = |ending: &str, text: String| (format!("{name}{ending}"), text);
    match language {
        Language::C => {
            let code = program.to_c();
            vec![file(".h", code.header), file(".c", code.source), file("_test.c", code.test)]
        }
        Language::Rust => vec![file(".rs", program.to_rust())],
        Language::Python => vec![file(".py", program.to_python())],
        Language::Json => vec![file(".json", program.to_json())],
    }
}

fn described(function: &ExportedFunction) -> Value {
    let ExportedFunction { tape, signature, summary, parameters, note } = function;
    let named = |quantities: &[bksim::expr::Quantity]| -> Vec<Value> {
        quantities.iter().map(|q| json!({ "name": q.name, "unit": q.unit })).collect()
    };
    json!({
        "name": signature.name,
        "summary": summary,
        "note": note,
        "inputs": named(&signature.inputs),
        "parameters": named(&signature.parameters),
        "parameter_values": parameters,
        "outputs": named(&signature.outputs),
        "operations": tape.operation_count(),
    })
}
