//! Packages that the README's two commands both need are built once: their features are the same in both.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Of every package in a tree of dependencies, the sets of features that it is built with.
fn features(selection: &[&str]) -> BTreeMap<String, BTreeSet<String>> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["tree", "--offline", "--prefix", "none", "--format", "{p}|{f}"]);
    command.args(selection).current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = command.output().expect("cargo runs");
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut packages: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in text.lines() {
        let Some((package, features)) = line.split_once('|') else { continue };
        let package = package.split(' ').take(2).collect::<Vec<_>>().join(" ");
        let features = features.trim_end_matches(" (*)").to_owned();
        packages.entry(package).or_default().insert(features);
    }
    packages
}

#[test]
fn dependencies_have_the_same_features_in_the_main_command_and_in_the_tests() {
    let program = features(&["--package", "bksim-cli", "--edges", "normal,build"]);
    let tests = features(&["--workspace", "--edges", "normal,build,dev"]);
    assert!(program.len() > 100, "{} packages", program.len());
    let differ = |(package, own): (&String, &BTreeSet<String>)| {
        let known = tests.get(package)?;
        (!own.is_subset(known)).then(|| format!("{package}: {own:?}, in the tests {known:?}"))
    };
    let differences: Vec<String> = program.iter().filter_map(differ).collect();
    assert!(
        differences.is_empty(),
        "built twice; features belong into crates/cli/Cargo.toml:\n{}",
        differences.join("\n")
    );
}
