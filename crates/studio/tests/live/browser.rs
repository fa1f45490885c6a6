//! Live pages in a real browser, where their module was built: dragged, slid, drawn, typed in.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{browser, installed, screenshots};
use crate::common::{CRATE, Scratch, text};
use serde_json::{Map, Value, json};

/// The examples that are opened, and an empty model.
const EXAMPLES: [&str; 3] = ["four-bar", "slider-crank", "spatial-four-bar"];

/// Where Firefox is, if it is.
const FIREFOX: [&str; 2] = ["/usr/bin/firefox", "/usr/bin/firefox-esr"];

#[test]
fn the_scripts_of_live_pages_have_sound_types() {
    let mut check = Command::new("node");
    check.current_dir(installed()).args(["node_modules/typescript/bin/tsc", "-p", "tsconfig.json"]);
    let output = check.output().expect("node starts: install Node.js 18 or later");
    assert!(output.status.success(), "{}", text(&output.stdout));
}

/// The module, if it was built.
fn module() -> Option<PathBuf> {
    let named = std::env::var_os("BKSIM_LIVE").map(PathBuf::from);
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent()?;
    let built = target.join("wasm32-unknown-unknown/live/bksim_live.wasm");
    named.into_iter().chain([built]).find(|path| path.exists())
}

#[test]
fn live_pages_follow_hands_in_a_browser() {
    let Some(module) = module().filter(|_| bksim_page::IS_BUNDLED) else {
        eprintln!("not run: the module of live pages was not built; docs/seeing/live.md says how");
        return;
    };
    let place = Scratch::new();
    place.write("empty.toml", "");
    let mut pages = Map::new();
    for example in EXAMPLES {
        let model = Path::new(CRATE).join("../../examples").join(example).join("model.toml");
        let file = place.path().join(format!("{example}.html"));
        let mut page = place.bksim();
        page.arg("page").arg(model).args(["--live", "-o"]).arg(&file).env("BKSIM_LIVE", &module);
        let output = page.output().expect("bksim starts");
        assert!(output.status.success(), "{}", text(&output.stderr));
        let n_bytes = std::fs::metadata(&file).expect("the page").len();
        assert!(n_bytes < 3_000_000, "the live page of {example} has {n_bytes} bytes");
        pages.insert(example.to_owned(), Value::from(file.display().to_string()));
    }
    let nothing = bksim_page::live(
        "",
        "mine",
        &std::fs::read(&module).expect("the module"),
        &bksim_page::LiveOptions::default(),
    );
    let file = place.path().join("empty.html");
    std::fs::write(&file, nothing.expect("a page")).expect("a file");
    pages.insert("empty".to_owned(), Value::from(file.display().to_string()));
    // An empty plane over a drawing.
    let drawing = Path::new(CRATE).join("../../examples/press/outlines.dxf");
    let file = place.path().join("under.html");
    let mut page = place.bksim();
    page.args(["page", "empty.toml", "--live", "--under"]).arg(drawing).arg("-o").arg(&file);
    let output = page.env("BKSIM_LIVE", &module).output().expect("bksim starts");
    assert!(output.status.success(), "{}", text(&output.stderr));
    pages.insert("under".to_owned(), Value::from(file.display().to_string()));
    let firefox = FIREFOX.iter().map(PathBuf::from).find(|path| path.exists());
    let plan = json!({
        "browser": browser(), "firefox": firefox, "screenshots": screenshots(), "pages": pages
    });
    place.write("plan.json", plan.to_string());

    let web = installed();
    let mut node = Command::new("node");
    node.current_dir(&web).args(["--test", "--test-reporter=spec", "test/live.test.mjs"]);
    node.arg("test/firefox.test.mjs");
    node.env("BKSIM_LIVE_PAGES", place.path().join("plan.json"));
    let output = node.output().expect("node starts: install Node.js 18 or later");
    assert!(output.status.success(), "{}\n{}", text(&output.stdout), text(&output.stderr));
}

/// Pose at the start and at the end of the motion of a text, 18 numbers for each body.
fn moved(text: &str, name: &str) -> [Vec<f64>; 2] {
    let mut session = bksim_edit::Session::default();
    let mut ask = |request: &Value| session.answer(&request.to_string());
    let start = ask(&json!({ "do": "open", "text": text, "name": name })).numbers;
    let solved = ask(&json!({ "do": "solve" }));
    let count = |of: &Value| of.as_array().map_or(0, Vec::len);
    let n_frames =
        usize::try_from(solved.json["n_frames"].as_u64().expect("frames")).expect("fits");
    let n = 18 * count(&solved.json["scene"]["bodies"]);
    let end = n_frames * (1 + count(&solved.json["curves"]) + n);
    [start, solved.numbers[end - n..end].to_vec()]
}

#[test]
fn the_module_of_live_pages_moves_every_example_as_the_library_does() {
    let Some(module) = module() else {
        eprintln!("not run: the module of live pages was not built; docs/seeing/live.md says how");
        return;
    };
    let folder = Path::new(CRATE).join("../../examples");
    let mut examples = Vec::new();
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("examples")
        .map(|entry| entry.expect("one").path())
        .collect();
    names.sort();
    for path in names {
        let Ok(text) = std::fs::read_to_string(path.join("model.toml")) else { continue };
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        // A model of several files is one text in a page.
        if ["file = \"", "drawing = "].iter().any(|key| text.contains(key)) {
            continue;
        }
        let [start, end] = moved(&text, &name);
        examples.push(json!({ "name": name, "text": text, "start": start, "end": end }));
    }
    assert!(examples.len() > 40, "{} examples", examples.len());
    let place = Scratch::new();
    place.write("motions.json", json!({ "module": module, "examples": examples }).to_string());
    let mut node = Command::new("node");
    node.current_dir(installed());
    node.args(["--test", "--test-reporter=spec", "test/module.test.mjs"]);
    node.env("BKSIM_LIVE_MOTIONS", place.path().join("motions.json"));
    let output = node.output().expect("node starts: install Node.js 18 or later");
    assert!(output.status.success(), "{}\n{}", text(&output.stdout), text(&output.stderr));
}
