//! Puts the models of `examples` into the program: a table of their files, for `bksim new --template`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Endings of files that a model is made of.
const ENDINGS: [&str; 5] = ["toml", "dxf", "csv", "stl", "obj"];

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR").map_err(io::Error::other)?);
    let examples = root.join("../../examples").canonicalize()?;
    println!("cargo::rerun-if-changed={}", examples.display());
    let mut table = "/// All of them, by name.\npub const EXAMPLES: &[Example] = &[\n".to_owned();
    for folder in sorted(&examples)? {
        let files = if folder.is_dir() { sorted(&folder)? } else { Vec::new() };
        let is_model = |path: &PathBuf| {
            let ending = path.extension().and_then(|ending| ending.to_str());
            path.is_file() && ending.is_some_and(|ending| ENDINGS.contains(&ending))
        };
        let files: Vec<PathBuf> = files.into_iter().filter(is_model).collect();
        // What is about the library alone has no model.
        if files.is_empty() {
            continue;
        }
        let readme = fs::read_to_string(folder.join("README.md"))?;
        let title = readme.lines().next().unwrap_or_default().trim_start_matches(['#', ' ']);
        let line = format!("    Example {{ name: {:?}, title: {title:?}, files: &[", name(&folder));
        table.push_str(&line);
        for file in &files {
            println!("cargo::rerun-if-changed={}", file.display());
            write!(table, "({:?}, include_bytes!({:?})), ", name(file), file.display().to_string())
                .map_err(io::Error::other)?;
        }
        table.push_str("] },\n");
    }
    table.push_str("];\n");
    let out = PathBuf::from(env::var("OUT_DIR").map_err(io::Error::other)?);
    fs::write(out.join("examples.rs"), table)
}

/// The entries of a folder in the order of their names.
fn sorted(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut entries = entries.collect::<io::Result<Vec<PathBuf>>>()?;
    entries.sort();
    Ok(entries)
}

fn name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap_or_default()
}
