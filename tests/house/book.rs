//! The book of `docs/`: every page is in its table of contents, and no link of a page leads to nothing.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// Markdown files below a folder.
fn pages(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.insert(path);
        }
    }
}

/// Targets of links and pictures in Markdown, those in blocks of code aside.
fn targets(text: &str) -> Vec<String> {
    let prose: String = text.split("```").step_by(2).collect();
    let inline = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let html = ["src=\"", "srcset=\""];
    let pictures = html.iter().flat_map(|key| {
        prose.split(key).skip(1).filter_map(|rest| rest.split('"').next()).collect::<Vec<_>>()
    });
    inline.chain(pictures).map(str::to_owned).collect()
}

/// Links of a page that lead to no file.
fn dead_links(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).expect("a readable page");
    let is_dead = |target: &String| {
        let file = target.split('#').next().unwrap_or_default();
        let is_elsewhere = file.is_empty() || file.contains("://");
        !is_elsewhere && !page.parent().expect("a folder").join(file).exists()
    };
    targets(&text).into_iter().filter(is_dead).collect()
}

#[test]
fn the_table_of_contents_has_every_page_once() {
    let contents = fs::read_to_string(docs().join("SUMMARY.md")).expect("a table of contents");
    let listed = targets(&contents);
    let listed_once: BTreeSet<_> = listed.iter().map(|page| docs().join(page)).collect();
    assert_eq!(listed.len(), listed_once.len(), "a page is listed twice");
    let mut there = BTreeSet::new();
    pages(&docs(), &mut there);
    there.remove(&docs().join("SUMMARY.md"));
    let missing: Vec<_> = there.difference(&listed_once).collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md lacks {missing:?}");
    let gone: Vec<_> = listed_once.difference(&there).collect();
    assert!(gone.is_empty(), "docs/SUMMARY.md lists {gone:?}, which are not there");
}

#[test]
fn no_link_leads_to_nothing() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = BTreeSet::from([root.join("README.md"), root.join("CONTRIBUTING.md")]);
    pages(&docs(), &mut all);
    pages(&root.join("examples"), &mut all);
    let dead: Vec<_> = all
        .iter()
        .flat_map(|page| {
            dead_links(page).into_iter().map(|link| format!("{}: {link}", page.display()))
        })
        .collect();
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

#[test]
fn links_are_found() {
    let text = "See [a](b.md#c) and ![p](d.svg).\n```sh\n[no](x)\n```\n<img src=\"e.svg\">";
    assert_eq!(targets(text), ["b.md#c", "d.svg", "e.svg"]);
}
