//! `bksim code`: the functions of a mechanism as files in other languages.

use std::fs;
use std::io::Write;
use std::path::Path;

use bksim::Mechanism;
use bksim::analysis::{
    AnalysisError, Channels, ExportedFunction, Part, exported, exported_linear, linear_matlab,
    linearize,
};
use bksim::expr::Program;
use bksim::fmu::{Core, Request, ScriptKind, Solver, Variable, script, solver};
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
    if let Some(kind) = script_kind(args)? {
        return of_script(loaded, args, kind, &label, as_json);
    }
    // All texts, then all files, so that either all are written or none is begun.
    let with_files =
        |functions: Vec<ExportedFunction>| (files_of(&functions, args.lang), functions);
    let found = match args.part {
        PartArg::Dynamics => {
            of_equations(&loaded.source, loaded.model, Part::Dynamics, args)?.map(with_files)
        }
        PartArg::Kinematics => {
            of_equations(&loaded.source, loaded.model, Part::Kinematics, args)?.map(with_files)
        }
        PartArg::Linear | PartArg::Solver => of_linear(loaded.model, args, &loaded.source),
    };
    let (files, functions) = found.map_err(|error| loaded.source.rejected(error.diagnostics()))?;
    let written = write(args, files, &label)?;

    if as_json {
        let functions: Vec<Value> = functions.iter().map(described).collect();
        let mut body = json!({ "functions": functions, "files": written });
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("code", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    output::report(report(&functions, &written).trim_end())?;
    Ok(Status::Done)
}

/// Functions with their sizes, and the files.
fn report(functions: &[ExportedFunction], written: &[String]) -> String {
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
    functions.iter().map(line).chain(files).collect()
}

/// The program that a script is for; `None` of languages without scripts.
fn script_kind(args: &Code) -> Result<Option<ScriptKind>, Failure> {
    let kind = match args.lang {
        Language::Casadi => ScriptKind::Casadi,
        Language::Jax => ScriptKind::Jax,
        Language::Sympy => ScriptKind::Sympy,
        Language::Matlab if args.part == PartArg::Linear => return Ok(None),
        Language::Matlab => ScriptKind::Matlab,
        Language::Modelica => ScriptKind::Modelica,
        Language::C | Language::Rust | Language::Python | Language::Json => return Ok(None),
    };
    if args.part != PartArg::Dynamics {
        let help = "leave `--part` out, or choose `--lang c`, `rust` or `python`";
        return Err(Failure::usage("a script holds the equations of motion alone", help));
    }
    Ok(Some(kind))
}

/// Writes the equations of motion as a script.
fn of_script(
    loaded: Loaded,
    args: &Code,
    kind: ScriptKind,
    label: &str,
    as_json: bool,
) -> Result<Status, Failure> {
    let Loaded { source, model, warnings, .. } = loaded;
    let mechanism = derive(&source, model)?;
    let inputs = inputs_of(&mechanism, args);
    let script = script(&mechanism, &inputs, kind);
    let script = script.map_err(|error| source.rejected(error.diagnostics()))?;
    let written = write(args, script.files, label)?;
    let mut function = script.equations.function;
    let contacts = script.equations.contacts;
    if !contacts.is_empty() {
        let names = contacts.join("`, `");
        function.note = format!("Stops are open and friction does not stick here: `{names}`.");
    }
    if as_json {
        let mut body = json!({ "functions": [described(&function)], "files": written });
        body["diagnostics"] = render::json_all(&source, &warnings);
        output::json("code", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&source, &warnings);
    output::report(report(&[function], &written).trim_end())?;
    Ok(Status::Done)
}

/// The inputs of the options, or else those that the model states and that are parameters.
fn inputs_of(mechanism: &Mechanism, args: &Code) -> Vec<String> {
    let is_parameter = |name: &&String| mechanism.model.parameters.iter().any(|p| p.name == **name);
    let stated = mechanism.model.io.inputs.iter().filter(is_parameter).cloned();
    if args.input.is_empty() { stated.collect() } else { args.input.clone() }
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
    let inputs = inputs_of(&mechanism, args);
    Ok(exported(&mechanism, part, &inputs))
}

/// Files with their names and texts, and the functions in them.
type WithFiles = (Vec<(String, String)>, Vec<ExportedFunction>);

/// The functions of the linear equations, and their files.
fn of_linear(model: Model, args: &Code, source: &Text) -> Result<WithFiles, AnalysisError> {
    let name = model.name.clone();
    let channels =
        Channels { inputs: args.input.clone(), outputs: args.of.clone(), states: Vec::new() };
    let linear = linearize(model, args.at, &channels)?;
    let units = ShownUnits::of_model(&source.text);
    let function = exported_linear(&name, &linear)?;
    let note = format!("Linear {}.", about(&linear.state, &units));
    let functions = vec![ExportedFunction { note: note.clone(), ..function }];
    if args.lang != Language::Matlab {
        let files = files_of(&functions, args.lang);
        return Ok((files, functions));
    }
    let id = program_of(&functions[0]).identifier().to_owned();
    let text = linear_matlab(&id, &linear, &note);
    Ok((vec![(format!("{id}.m"), text)], functions))
}

/// The files of all functions.
fn files_of(functions: &[ExportedFunction], language: Language) -> Vec<(String, String)> {
    functions.iter().flat_map(|function| texts(&program_of(function), language)).collect()
}

fn program_of(function: &ExportedFunction) -> Program<'_> {
    let program = function.tape.program(&function.signature);
    program.expect("a signature is made for its tape").with_note(&function.note)
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
        // Of the others, scripts and matrices are written elsewhere.
        _ => vec![file(".json", program.to_json())],
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
