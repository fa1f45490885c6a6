//! The structure that `docs/architecture.md` states, held against the code: crates use those above them
//! in its list, no modules at the top of a crate use each other in a circle, and every file of tests is a
//! module of its program.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Folder of the workspace.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The crates in the order of the storeys, lowest first: the first cells of the table's rows.
fn storeys() -> Vec<String> {
    let page = read(&Path::new(ROOT).join("docs/architecture.md"));
    let table = page.split("## Storeys").nth(1).expect("the page has a table of storeys");
    let rows = table.lines().skip_while(|line| !line.starts_with("| `"));
    let rows = rows.take_while(|line| line.starts_with("| `"));
    let name = |row: &str| row.split('`').nth(1).expect("a crate in backticks").to_owned();
    rows.map(name).collect()
}

fn folder(member: &str) -> PathBuf {
    if member == "." { ROOT.into() } else { Path::new(ROOT).join(member) }
}

/// Packages of the workspace that a manifest asks for outside of tests.
fn dependencies(member: &str) -> Vec<String> {
    let manifest = read(&folder(member).join("Cargo.toml"));
    let own = manifest.split("\n[dependencies]\n").nth(1).unwrap_or_default();
    let own = own.split("\n[").next().unwrap_or_default();
    let names = own.lines().filter_map(|line| line.split(['.', ' ', '=']).next());
    names.filter(|name| name.starts_with("bksim")).map(str::to_owned).collect()
}

/// The name of the package in a folder.
fn package(member: &str) -> String {
    match member.strip_prefix("crates/") {
        Some(folder) => format!("bksim-{folder}"),
        None => "bksim".to_owned(),
    }
}

/// Source files below a folder, sorted.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).expect("a readable folder") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The code of a file: no comments, and nothing from its tests on.
fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]\n").next().unwrap_or_default();
    let is_code = |line: &&str| !line.trim_start().starts_with("//");
    code.lines().filter(is_code).collect::<Vec<_>>().join("\n")
}

/// The modules that `code` names by `crate::`.
fn modules_in(code: &str) -> BTreeSet<String> {
    let word = |text: &str| -> String {
        text.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect()
    };
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            Some(list) => {
                let list = list.split('}').next().unwrap_or_default();
                found.extend(list.split(',').map(|item| word(item.trim())));
            }
            None => {
                found.insert(word(rest));
            }
        }
    }
    found
}

/// The top modules of a crate, each with those that it uses.
fn uses(member: &str) -> BTreeMap<String, BTreeSet<String>> {
    let folder = folder(member).join("src");
    let mut uses: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in sources(&folder) {
        let inner = path.strip_prefix(&folder).expect("the file is below its folder");
        let top = inner.iter().next().and_then(|top| top.to_str()).expect("names are plain");
        let top = top.trim_end_matches(".rs").to_owned();
        if top != "lib" && top != "main" {
            uses.entry(top).or_default().extend(modules_in(&code(&read(&path))));
        }
    }
    let known: BTreeSet<String> = uses.keys().cloned().collect();
    for (top, used) in &mut uses {
        used.retain(|module| known.contains(module) && module != top);
    }
    uses
}

/// The modules that are left when, again and again, those go that use none of the others: circles, and
/// what uses them.
fn circles(mut uses: BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    loop {
        let known: BTreeSet<String> = uses.keys().cloned().collect();
        for used in uses.values_mut() {
            used.retain(|module| known.contains(module));
        }
        let before = uses.len();
        uses.retain(|_, used| !used.is_empty());
        if uses.len() == before {
            return uses;
        }
    }
}

#[test]
fn every_crate_uses_those_above_it_in_the_list() {
    let storeys = storeys();
    let mut members: Vec<String> = fs::read_dir(Path::new(ROOT).join("crates"))
        .expect("crates")
        .map(|entry| format!("crates/{}", entry.expect("an entry").file_name().to_string_lossy()))
        .chain([".".to_owned()])
        .collect();
    members.sort();
    let mut listed = storeys.clone();
    listed.sort();
    assert_eq!(listed, members, "the list has every crate once");

    let packages: Vec<String> = storeys.iter().map(|member| package(member)).collect();
    for (storey, member) in storeys.iter().enumerate() {
        for used in dependencies(member) {
            let below = packages.iter().position(|package| *package == used);
            let below =
                below.unwrap_or_else(|| panic!("{member} uses {used}, which is not listed"));
            assert!(below < storey, "{member} uses {used}, which stands below it in the list");
        }
    }
}

#[test]
fn no_modules_use_each_other_in_a_circle() {
    for member in &storeys() {
        let circles = circles(uses(member));
        assert!(
            circles.is_empty(),
            "{member} has modules in a circle, or that use one: {circles:#?}"
        );
    }
}

/// The crates of each crate's own `dependencies`, without those that it reaches through another one.
fn arrows(storeys: &[String]) -> Vec<(&str, &str)> {
    let of_package: BTreeMap<String, usize> =
        storeys.iter().enumerate().map(|(storey, member)| (package(member), storey)).collect();
    let used: Vec<BTreeSet<usize>> = storeys
        .iter()
        .map(|member| dependencies(member).iter().map(|name| of_package[name]).collect())
        .collect();
    let mut reached: Vec<BTreeSet<usize>> = Vec::new();
    for used in &used {
        let further = used.iter().flat_map(|&storey| reached[storey].iter().copied());
        reached.push(used.iter().copied().chain(further).collect());
    }
    let mut arrows = Vec::new();
    for (storey, used) in used.iter().enumerate() {
        let is_direct = |&below: &usize| !used.iter().any(|&other| reached[other].contains(&below));
        let direct = used.iter().copied().filter(is_direct);
        arrows.extend(direct.map(|below| (storeys[storey].as_str(), storeys[below].as_str())));
    }
    arrows
}

#[test]
fn the_picture_of_the_storeys_is_that_of_the_manifests() {
    let word = |member: &str| match member.strip_prefix("crates/") {
        Some(name) => name.to_owned(),
        None => "bksim".to_owned(),
    };
    let storeys = storeys();
    let arrows = arrows(&storeys);
    let lines =
        arrows.iter().map(|(above, below)| format!("    {} --> {}\n", word(above), word(below)));
    let picture = format!("```mermaid\nflowchart TD\n{}```\n", lines.collect::<String>());

    let path = Path::new(ROOT).join("docs/architecture.md");
    let page = read(&path);
    let (before, rest) = page.split_once("```mermaid\n").expect("the page has a picture");
    let (_, after) = rest.split_once("```\n").expect("the picture ends");
    if std::env::var_os("BKSIM_BLESS").is_some() {
        fs::write(&path, [before, &picture, after].concat()).expect("the page is written");
        return;
    }
    assert!(page.contains(&picture), "BKSIM_BLESS=1 draws it anew:\n{picture}");
}

#[test]
fn the_list_of_rooms_has_every_module_of_its_crates() {
    let page = read(&Path::new(ROOT).join("docs/rooms.md"));
    for section in page.split("\n## `").skip(1) {
        let (member, rows) = section.split_once('`').expect("a crate in backticks");
        let first_cells =
            rows.lines().filter_map(|row| row.strip_prefix("| `")?.split(" |").next());
        let listed: BTreeSet<&str> = first_cells
            .flat_map(|cell| cell.split('`').step_by(2))
            .filter(|s| !s.is_empty())
            .collect();
        let names = fs::read_dir(folder(member).join("src")).expect("sources").map(|entry| {
            let entry = entry.expect("an entry");
            let is_folder = entry.file_type().expect("a kind").is_dir();
            entry.file_name().to_string_lossy().into_owned() + if is_folder { "/" } else { "" }
        });
        let modules: BTreeSet<String> =
            names.filter(|name| !matches!(name.as_str(), "lib.rs" | "main.rs")).collect();
        let modules: BTreeSet<&str> = modules.iter().map(String::as_str).collect();
        assert_eq!(listed, modules, "{member}: the list, and what is there");
    }
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a readable folder");
    entries.map(|entry| entry.expect("a readable entry").path()).collect()
}

/// The files in a folder of tests that its `main.rs` or `mod.rs` has no `mod` for, and that are no program of the
/// manifest: none of their tests runs.
fn forgotten_tests(place: &Path, list: &Path, manifest: &Path) -> Vec<PathBuf> {
    let (list, manifest) = (read(list), read(manifest));
    let between = |line: &'_ str, before, after| {
        Some(line.strip_prefix(before)?.strip_suffix(after)?.to_owned())
    };
    let modules = list.lines().map(|line| line.trim_start_matches("pub(crate) "));
    let modules = modules.map(|line| line.trim_start_matches("pub "));
    let modules = modules.filter_map(|line| between(line, "mod ", ";"));
    let programs = manifest.lines().filter_map(|line| between(line, "name = \"", "\""));
    let named: BTreeSet<String> =
        modules.chain(programs).chain(["main", "mod"].map(str::to_owned)).collect();
    entries(place)
        .into_iter()
        .filter(|path| {
            path.extension().is_some_and(|ending| ending == "rs")
                && path.file_stem().is_some_and(|name| !named.contains(&*name.to_string_lossy()))
        })
        .collect()
}

#[test]
fn every_file_of_tests_is_a_module_of_its_program() {
    let mut n_lists = 0;
    for member in &storeys() {
        let manifest = folder(member).join("Cargo.toml");
        let tests = folder(member).join("tests");
        if !tests.is_dir() {
            continue;
        }
        for place in entries(&tests).into_iter().filter(|path| path.is_dir()).chain([tests]) {
            for list in ["main.rs", "mod.rs"].map(|name| place.join(name)) {
                if list.is_file() {
                    let forgotten = forgotten_tests(&place, &list, &manifest);
                    assert!(forgotten.is_empty(), "no `mod` and no manifest names {forgotten:?}");
                    n_lists += 1;
                }
            }
        }
    }
    assert!(n_lists >= 20, "{n_lists} lists of tests are found");
}

/// The modules of the Python package, each with those that it imports, for types alone or not.
fn python_imports() -> BTreeMap<String, BTreeSet<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/py/python/bksim");
    let mut imports = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("the Python package") {
        let path = entry.expect("a readable entry").path();
        if path.extension().is_none_or(|ending| ending != "py") {
            continue;
        }
        let text = read(&path);
        let lines = text.lines().filter_map(|line| line.trim_start().strip_prefix("from ."));
        let used = lines.flat_map(|line| match line.strip_prefix(" import ") {
            Some(names) => names.split(',').map(|name| name.trim().to_owned()).collect::<Vec<_>>(),
            None => line.split_whitespace().take(1).map(str::to_owned).collect(),
        });
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        imports.insert(name, used.collect());
    }
    imports
}

#[test]
fn no_modules_of_python_import_each_other_in_a_circle() {
    let imports = python_imports();
    assert!(imports["_solution"].contains("_samples"), "{imports:?}");
    let circles = circles(imports);
    assert!(circles.is_empty(), "modules of Python in a circle, or that use one: {circles:#?}");
}

#[test]
fn a_circle_is_seen() {
    let uses = |of: &[(&str, &[&str])]| -> BTreeMap<String, BTreeSet<String>> {
        let set = |used: &[&str]| used.iter().map(|&module| module.to_owned()).collect();
        of.iter().map(|&(module, used)| (module.to_owned(), set(used))).collect()
    };
    assert!(circles(uses(&[("a", &["b", "c"]), ("b", &["c"]), ("c", &[])])).is_empty());
    let circle = circles(uses(&[("a", &["b"]), ("b", &["c"]), ("c", &["b"]), ("d", &[])]));
    assert_eq!(circle.len(), 3, "{circle:?}");
    let named = modules_in("use crate::a::{B, C};\nuse crate::{d, e::F};\nlet x = crate::g::h();");
    assert_eq!(named.into_iter().collect::<Vec<_>>(), ["a", "d", "e", "g"]);
    assert_eq!(
        code("use crate::a;\n// crate::b\n#[cfg(test)]\nmod tests { use crate::c; }"),
        "use crate::a;"
    );
}
