//! Manifests have what a registry asks for, and the crates name each other by version.

use std::fs;
use std::path::{Path, PathBuf};

/// Categories of crates.io that are used here.
const CATEGORIES: [&str; 5] =
    ["simulation", "science", "mathematics", "command-line-utilities", "visualization"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn manifest(path: &Path) -> toml::Table {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Manifests of all crates, that of the facade first.
fn manifests() -> Vec<(PathBuf, toml::Table)> {
    let crates = fs::read_dir(root().join("crates")).expect("crates");
    let mut paths: Vec<PathBuf> =
        crates.map(|entry| entry.expect("a folder").path().join("Cargo.toml")).collect();
    paths.sort();
    paths.insert(0, root().join("Cargo.toml"));
    paths.into_iter().map(|path| (path.clone(), manifest(&path))).collect()
}

fn words<'t>(table: &'t toml::Table, key: &str) -> Vec<&'t str> {
    let list = table.get(key).and_then(toml::Value::as_array).expect("a list");
    list.iter().map(|word| word.as_str().expect("a word")).collect()
}

#[test]
fn every_manifest_has_what_a_registry_asks_for() {
    let all = manifests();
    assert!(all.len() > 20, "{} manifests", all.len());
    let workspace = all[0].1["workspace"]["package"].as_table().expect("a table").clone();
    let keywords = words(&workspace, "keywords");
    assert!((1..=5).contains(&keywords.len()), "{keywords:?}");
    let is_word = |word: &&str| word.len() <= 20 && word.bytes().all(|b| b.is_ascii_lowercase());
    assert!(keywords.iter().all(is_word), "{keywords:?}");
    let categories = words(&workspace, "categories");
    assert!(categories.iter().all(|one| CATEGORIES.contains(one)), "{categories:?}");
    for (path, manifest) in &all {
        let package = manifest["package"].as_table().expect("a package");
        let name = package["name"].as_str().expect("a name");
        assert!(name == "bksim" || name.starts_with("bksim-"), "{name}");
        let description = package["description"].as_str().expect("a description");
        let is_sentence = description.len() < 200 && !description.ends_with('.');
        assert!(is_sentence, "{}: {description}", path.display());
        for key in ["version", "edition", "rust-version", "license", "keywords", "categories"] {
            let value = package.get(key).and_then(toml::Value::as_table);
            let is_shared = value.is_some_and(|table| table["workspace"].as_bool() == Some(true));
            assert!(is_shared, "{}: `{key}` is not that of the workspace", path.display());
        }
        // Documentation is built once, with all features.
        let pages = package.get("metadata").and_then(|of| of.get("docs")?.get("rs"));
        let pages = pages.unwrap_or_else(|| panic!("{}: nothing for docs.rs", path.display()));
        assert_eq!(words(pages.as_table().expect("a table"), "targets").len(), 1, "{name}");
        let has_features = manifest.contains_key("features");
        let has_all = pages.get("all-features").and_then(toml::Value::as_bool) == Some(true);
        assert_eq!(has_features, has_all, "{}: features on docs.rs", path.display());
    }
}

#[test]
fn crates_name_each_other_by_their_version() {
    let manifest = manifest(&root().join("Cargo.toml"));
    let version = &manifest["workspace"]["package"]["version"];
    let dependencies = manifest["workspace"]["dependencies"].as_table().expect("dependencies");
    let own = dependencies.iter().filter(|(name, _)| name.starts_with("bksim"));
    let mut n = 0;
    for (name, dependency) in own {
        assert_eq!(dependency.get("version"), Some(version), "{name}");
        n += 1;
    }
    assert!(n > 20, "{n} crates");
    // The pinned compiler is the oldest one that is promised.
    let toolchain = self::manifest(&root().join("rust-toolchain.toml"));
    let channel = toolchain["toolchain"]["channel"].as_str().expect("a version");
    let oldest = manifest["workspace"]["package"]["rust-version"].as_str().expect("a version");
    assert!(channel.starts_with(oldest), "{channel} is pinned, {oldest} is promised");
}
