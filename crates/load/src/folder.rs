//! Names in a folder, for messages about a file that is not there.

use std::fs;
use std::path::Path;

/// The names of models and drawings in a folder, `model.toml` first.
pub(crate) fn models_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let is_model = |name: &String| {
        let ending = Path::new(name).extension().map(std::ffi::OsStr::to_ascii_lowercase);
        ending.is_some_and(|ending| ["toml", "dxf", "dwg"].iter().any(|known| ending == *known))
    };
    let mut names: Vec<String> = names.filter(is_model).collect();
    names.sort_by_key(|name| (name != "model.toml", name.clone()));
    names
}
