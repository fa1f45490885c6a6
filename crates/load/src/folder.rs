//! Names in a folder, for messages about a file that is not there.

use std::fs;
use std::path::Path;

/// Endings of models and drawings.
const MODELS: [&str; 3] = ["toml", "dxf", "dwg"];

/// The names of models and drawings in a folder, `model.toml` first.
pub(crate) fn models_in(folder: &Path) -> Vec<String> {
    ending_in(folder, &MODELS)
}

/// The names of files in a folder that end as `path` does, or of models where that ends as one.
pub(crate) fn others_in(folder: &Path, path: &Path) -> Vec<String> {
    let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some(own) if !MODELS.contains(&own) => ending_in(folder, &[own]),
        _ => models_in(folder),
    }
}

fn ending_in(folder: &Path, endings: &[&str]) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let is_model = |name: &String| {
        let ending = Path::new(name).extension().map(std::ffi::OsStr::to_ascii_lowercase);
        ending.is_some_and(|ending| endings.iter().any(|known| ending == *known))
    };
    let mut names: Vec<String> = names.filter(is_model).collect();
    names.sort_by_key(|name| (name != "model.toml", name.clone()));
    names
}
