//! `bksim import`: robots and linkages of other programs as model files.

use std::path::{Path, PathBuf};

use bksim::import::{Base, Format, Imported, Source, import};
use bksim::model::diagnostic::Diagnostic;
use serde_json::{Value, json};

use crate::args::ModelArgs;
use crate::args::import::Import;
use crate::exit::{Failure, Status};
use crate::output;
use crate::output_file::check_ending;
use crate::render;
use crate::source::{Text, load, parse, read_bytes};

pub(crate) fn run(args: &Import, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let is_model = args.file.extension().is_some_and(|it| it.eq_ignore_ascii_case("toml"));
    if let Some(to) = args.to.filter(|_| is_model) {
        let loaded = load(&ModelArgs::of(&args.file), nesting)?;
        return super::export_robot::run(args, to, (loaded, Vec::new()), as_json);
    }
    let written = args.file.to_string_lossy().into_owned();
    let is_link = !args.file.exists() && (written.contains("://") || written.starts_with('?'));
    let (name, bytes) = if is_link {
        ("link".to_owned(), written.clone().into_bytes())
    } else {
        (written.clone(), read_bytes(&args.file)?)
    };
    if !is_link && super::import_drawing::is_drawing(&args.file, &bytes) {
        let Some(to) = args.to else {
            return super::import_drawing::run(args, as_json, &name, &bytes);
        };
        let loaded = load(&ModelArgs::of(&args.file), nesting)?;
        return super::export_robot::run(args, to, (loaded, Vec::new()), as_json);
    }
    args.output
        .iter()
        .filter(|_| args.to.is_none())
        .try_for_each(|path| check_ending(path, &["toml"]))?;
    let places = Places::of(&args.file, &args.paths);
    let base = if args.free { Base::Free } else { Base::Fixed };
    let mut imported = import(&name, &bytes, &|wanted| places.bytes(wanted), base);
    let Some(model) = imported.model.take() else { return Err(rejected(&imported)) };
    if let Some(to) = args.to {
        for (idx, source) in imported.sources.iter().enumerate() {
            render::print_all(&text_of(source), &faults_of(&imported, idx));
        }
        let source = Text::new(args.file.with_extension("toml"), model);
        let loaded = parse(source, "robot", &[], nesting)?;
        return super::export_robot::run(args, to, (loaded, changes(&imported)), as_json);
    }
    if let Some(path) = &args.output {
        super::import_drawing::write(path, &args.file, args.force, model.as_bytes())?;
    }
    if as_json {
        output::json("import", as_object(args, &imported, &model))?;
        return Ok(Status::Done);
    }
    for (idx, source) in imported.sources.iter().enumerate() {
        render::print_all(&text_of(source), &faults_of(&imported, idx));
    }
    match &args.output {
        None => output::text(model.trim_end())?,
        Some(path) => report(path, &imported)?,
    }
    Ok(Status::Done)
}

/// Prints the counts, names that changed and parts that are left out.
fn report(path: &Path, imported: &Imported) -> Result<(), Failure> {
    let format = imported.format.map_or("", Format::name);
    let (n_bodies, n_joints) = (imported.n_bodies, imported.n_joints);
    let mut lines =
        vec![format!("wrote {}: {format}, bodies {n_bodies}, joints {n_joints}", path.display())];
    lines.extend(changes(imported));
    output::report(&lines.join("\n"))
}

/// Names that changed and parts that are left out, a line each.
fn changes(imported: &Imported) -> Vec<String> {
    let mut lines = Vec::new();
    for renamed in &imported.renamed {
        lines.push(format!("renamed {} `{}` to `{}`", renamed.kind, renamed.from, renamed.to));
    }
    for (file, what, shown) in imported.left_out_by_kind() {
        lines.push(format!(
            "left out {what} ({}:{})",
            imported.sources[file].name,
            shown.join(", ")
        ));
    }
    lines
}

fn text_of(source: &Source) -> Text {
    Text::new(PathBuf::from(&source.name), source.text.clone())
}

fn faults_of(imported: &Imported, file: usize) -> Vec<Diagnostic> {
    let faults = imported.faults.iter().filter(|fault| fault.file == file);
    faults.map(|fault| fault.diagnostic.clone()).collect()
}

/// The failure by the file of the first error; faults in other files name their lines in words.
fn rejected(imported: &Imported) -> Failure {
    let first = imported.faults.iter().find(|fault| fault.diagnostic.is_error());
    let file = first.map_or(0, |fault| fault.file);
    let mut diagnostics = faults_of(imported, file);
    for fault in imported.faults.iter().filter(|fault| fault.file != file) {
        let source = &imported.sources[fault.file];
        let at = fault.diagnostic.labels.first().map_or(0, |label| label.span.start);
        let (line, column) = bksim_load::line_and_column(&source.text, at);
        let mut elsewhere = fault.diagnostic.clone();
        elsewhere.message = format!("{}:{line}:{column}: {}", source.name, elsewhere.message);
        elsewhere.labels.clear();
        diagnostics.push(elsewhere);
    }
    Failure::Model { source: Box::new(text_of(&imported.sources[file])), diagnostics }
}

fn as_object(args: &Import, imported: &Imported, model: &str) -> Value {
    let sources = &imported.sources;
    let all = (0..sources.len())
        .map(|file| render::json_all(&text_of(&sources[file]), &faults_of(imported, file)));
    let diagnostics: Vec<Value> =
        all.flat_map(|faults| faults.as_array().cloned().unwrap_or_default()).collect();
    let names = imported
        .renamed
        .iter()
        .map(|renamed| json!({ "kind": renamed.kind, "from": renamed.from, "to": renamed.to }));
    let left_out = imported.left_out.iter().map(|part| {
        let source = &sources[part.place.file];
        let (line, column) = bksim_load::line_and_column(&source.text, part.place.span.start);
        json!({ "what": part.what, "file": source.name, "line": line, "column": column })
    });
    json!({
        "output": args.output.as_ref().map(|path| path.display().to_string()),
        "format": imported.format.map(Format::name),
        "files": sources.iter().map(|source| source.name.clone()).collect::<Vec<_>>(),
        "n_bodies": imported.n_bodies,
        "n_joints": imported.n_joints,
        "names": names.collect::<Vec<_>>(),
        "left_out": left_out.collect::<Vec<_>>(),
        "model": model,
        "diagnostics": diagnostics,
    })
}

/// The folders in which files are looked for that a file names.
struct Places {
    /// The folder of the file, then those above it.
    own: Vec<PathBuf>,
    stated: Vec<PathBuf>,
}

impl Places {
    fn of(file: &Path, stated: &[PathBuf]) -> Self {
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        let above = folder.canonicalize().unwrap_or_else(|_| folder.clone());
        let own = std::iter::once(folder).chain(above.ancestors().skip(1).map(Path::to_owned));
        Self { own: own.collect(), stated: stated.to_vec() }
    }

    /// The bytes of a file as another one names it.
    fn bytes(&self, name: &str) -> Option<Vec<u8>> {
        let found = self.candidates(name).into_iter().find(|path| path.is_file())?;
        std::fs::read(found).ok()
    }

    fn candidates(&self, name: &str) -> Vec<PathBuf> {
        let packaged =
            ["package://", "model://"].iter().find_map(|scheme| name.strip_prefix(scheme));
        let Some(rest) = packaged else {
            let name = name.strip_prefix("file://").unwrap_or(name);
            let folders = self.own.iter().take(1).chain(&self.stated);
            return folders.map(|folder| folder.join(name)).collect();
        };
        // The package by its name in a folder, or the folder itself is the package.
        let (package, inner) = rest.split_once('/').unwrap_or((rest, ""));
        let folders = self.stated.iter().chain(&self.own);
        folders
            .flat_map(|folder| {
                let is_package = folder.file_name().is_some_and(|name| name == package);
                let inside = is_package.then(|| folder.join(inner));
                [Some(folder.join(rest)), inside].into_iter().flatten()
            })
            .collect()
    }
}
