//! `bksim fmu`: a model as a functional mock-up unit.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use bksim::fmu::{Core, Platform, Request, Unit, Version, archive};
use bksim::model::message::counted;
use serde_json::{Value, json};

use crate::args::fmu::{Fmi, Fmu};
use crate::exit::{Failure, Status};
use crate::output;
use crate::output_file::{OutputFile, check_ending};
use crate::render;
use crate::source::{derive, load};
use crate::waiting::waiting;

const UNDONE: &str = "no unit was written";

/// Options of the compiler: products and sums are not fused, so that all machines compute the same.
const OPTIONS: [&str; 5] = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared"];

pub(crate) fn run(args: &Fmu, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    check_ending(&args.output, &["fmu"])?;
    let loaded = load(&args.model, nesting)?;
    let mut mechanism = derive(&loaded.source, loaded.model)?;
    let request = Request { inputs: args.input.clone(), outputs: args.of.clone() };
    let core = waiting("writing the equations in C", || Core::of(&mut mechanism, &request));
    let core = core.map_err(|error| loaded.source.rejected(error.diagnostics()))?;
    let version = match args.fmi {
        Fmi::Two => Version::Two,
        Fmi::Three => Version::Three,
    };
    let unit = Unit::new(core, version);
    let model: &[&Path] = &[&args.model.model];
    let file = OutputFile::plan(&args.output, ("model", model), args.force, UNDONE)?;
    let compiled = if args.sources {
        Err("left out as `--sources` asks".to_owned())
    } else {
        waiting("compiling", || program(&unit, &args.compiler))
    };
    let (program, left_out) = match compiled {
        Ok(program) => (Some(program), None),
        Err(why) => (None, Some(why)),
    };
    let platform = program.as_ref().map(|(platform, _)| platform.name);
    let bytes = archive(&unit.files(program));
    let mut out = file.create()?;
    out.write_all(&bytes)
        .map_err(|error| Failure::file(file.path(), format!("cannot be written: {error}"), None))?;
    out.finish()?;

    if as_json {
        let mut body = described(&unit, file.path(), platform);
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("fmu", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    output::report(&summary(&unit, file.path(), platform, left_out.as_deref()))?;
    Ok(Status::Done)
}

/// The source compiled for this machine, or why it is not.
fn program(unit: &Unit, compiler: &Path) -> Result<(Platform, Vec<u8>), String> {
    use std::env::consts::{ARCH, OS};
    let platform = Platform::of(ARCH, OS)
        .ok_or_else(|| format!("units have no programs for {ARCH} with {OS} by `bksim fmu`"))?;
    let wrong = |error: std::io::Error| error.to_string();
    let folder = tempfile::tempdir().map_err(wrong)?;
    // Names without a path, so that the same source gives the same program.
    fs::write(folder.path().join("unit.c"), &unit.source).map_err(wrong)?;
    let ran = Command::new(compiler)
        .args(OPTIONS)
        .args(["-fvisibility=hidden", "unit.c", "-o", "unit.bin", "-lm"])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output();
    let compiler = compiler.display();
    let ran =
        ran.map_err(|error| format!("the compiler `{compiler}` cannot be started: {error}"))?;
    if !ran.status.success() {
        let said = String::from_utf8_lossy(&ran.stderr);
        let first = said.lines().find(|line| line.contains("error")).unwrap_or_default();
        return Err(format!("the compiler `{compiler}` failed: {first}"));
    }
    let bytes = fs::read(folder.path().join("unit.bin")).map_err(wrong)?;
    Ok((platform, bytes))
}

fn version_of(unit: &Unit) -> &'static str {
    match unit.version {
        Version::Two => "2.0",
        Version::Three => "3.0",
    }
}

fn described(unit: &Unit, path: &Path, platform: Option<&str>) -> Value {
    let core = &unit.core;
    let named = |variables: &[bksim::fmu::Variable]| -> Vec<Value> {
        let one = |v: &bksim::fmu::Variable| json!({ "name": v.name, "unit": v.unit });
        variables.iter().map(one).collect()
    };
    let (inputs, parameters) = core.values.split_at(core.n_inputs);
    json!({
        "file": path.display().to_string(),
        "fmi": version_of(unit),
        "token": unit.token,
        "platform": platform,
        "states": core.n_states(),
        "event_indicators": core.n_events(),
        "inputs": named(inputs),
        "parameters": named(parameters),
        "outputs": named(&core.outputs[..core.n_outputs]),
    })
}

fn summary(unit: &Unit, path: &Path, platform: Option<&str>, left_out: Option<&str>) -> String {
    let core = &unit.core;
    let program = match (platform, left_out) {
        (Some(platform), _) => format!("program for {platform}"),
        (None, why) => format!("no program: {}", why.unwrap_or_default()),
    };
    format!(
        "  FMI {}, model exchange and co-simulation; {}, {}, {}, {}, {}\n  source in C, {program}\nwrote {}",
        version_of(unit),
        counted(core.n_states(), "state", "states"),
        counted(core.n_events(), "event indicator", "event indicators"),
        counted(core.n_inputs, "input", "inputs"),
        counted(core.n_outputs, "output", "outputs"),
        counted(core.values.len() - core.n_inputs, "parameter", "parameters"),
        path.display()
    )
}
