//! The pages of all examples, in a real browser.
//!
//! The pages are written by the command, then `crates/page/web/test` looks at them with Chromium, and
//! compares the poses that it finds there with those of the facade's playback. Screenshots of every
//! page are left in `target/page-screenshots`; some are compared with the reference pictures next to the
//! test, which `BKSIM_BLESS=1` writes again.

#[path = "live/browser.rs"]
mod live;
#[path = "live/served.rs"]
mod served;

use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::common::{CRATE, Scratch, text};
use bksim::log::LogReader;
use bksim::playback::Playback;
use bksim::sim::pose::Pose;
use serde_json::{Value, json};

/// The examples; the first one is played with and photographed.
const EXAMPLES: [&str; 9] = [
    "four-bar",
    "cart-pole",
    "five-link",
    "governor",
    "parallelogram",
    "press",
    "quick-return",
    "slider-crank",
    "spring-pendulum",
];

/// A page is to be sent by mail: 2 MB, and not more.
const MAX_BYTES: u64 = 2_000_000;

/// Where the browser may be; `BKSIM_CHROMIUM` names another place.
const BROWSERS: [&str; 3] =
    ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/// Parts of a run, next to its ends, whose poses are compared; none is an even time.
const PARTS: [f64; 5] = [0.0, 0.123_456_7, std::f64::consts::FRAC_1_PI, 0.777_777, 1.0];

/// Comments that a hostile author writes.
const HOSTILE: [&str; 3] = [
    "</script><script>globalThis.isBroken = 1</script>",
    "</pre><img src=x onerror='globalThis.isBroken = 1'>",
    "<!-- <script> \"quotes\" & 'more' \u{2028}",
];

const HOSTILE_TITLE: &str = "</title><script>globalThis.isBroken = 1</script> \"Q\" & co";

#[test]
fn pages_show_what_the_equations_say_in_a_browser() {
    let place = Scratch::new();
    let pages: Vec<Value> = EXAMPLES.map(|example| of_example(&place, example)).into();
    let plan = json!({
        "browser": browser(),
        "screenshots": screenshots(),
        "pages": pages,
        "hostile": hostile(&place),
    });
    place.write("plan.json", plan.to_string());
    let web = installed();
    let mut node = Command::new("node");
    node.current_dir(&web).args(["--test", "--test-reporter=spec", "test/page.test.mjs"]);
    node.env("BKSIM_PAGES", place.path().join("plan.json"));
    node.env("BKSIM_REFERENCES", Path::new(CRATE).join("../page/web/test/references"));
    let output = node.output().expect("node starts: install Node.js 18 or later");
    assert!(output.status.success(), "{}\n{}", text(&output.stdout), text(&output.stderr));
}

/// Solves an example, writes its page, and says where the bodies are at some instants.
fn of_example(place: &Scratch, example: &str) -> Value {
    let folder = Path::new(CRATE).join("../../examples").join(example);
    let model = folder.join("model.toml");
    let model = if model.exists() { model } else { folder.join("drawing.dxf") };
    let log = place.path().join(format!("{example}.mcap"));
    let mut solve = place.bksim();
    solve.arg("solve").arg(&model).arg("-o").arg(&log);
    let output = solve.output().expect("bksim starts");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = place.run(&format!("page {example}.mcap"));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = place.path().join(format!("{example}.html"));
    let n_bytes = fs::metadata(&page).expect("the page").len();
    assert!(n_bytes < MAX_BYTES, "the page of {example} has {n_bytes} bytes");

    let mut playback = opened(&log);
    let [first, last] = playback.span();
    let instant = |part: f64| {
        let t = first + part * (last - first);
        playback.seek(t).expect("the motion of the model");
        let poses: Vec<f64> = playback.poses().iter().flat_map(numbers).collect();
        json!({ "t": t, "poses": poses })
    };
    let instants = PARTS.map(instant);
    json!({ "name": example, "file": page, "span": [first, last], "instants": instants })
}

/// A pose in the order of the page's tape.
fn numbers(pose: &Pose) -> Vec<f64> {
    let [a, b, c] = pose.r_world_from_body;
    [pose.origin, a, b, c, pose.velocity, pose.omega].concat()
}

fn opened(log: &Path) -> Playback {
    let file = BufReader::new(File::open(log).expect("the log"));
    Playback::open(LogReader::open(file).expect("a log")).expect("a run")
}

/// The page of a model whose text and title try to break out.
fn hostile(place: &Scratch) -> Value {
    let model = format!(
        "# {}\n[bodies.b]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\n\
         axis = [1, 0]\n[initial]\nS = {{ velocity = 1 }}\n[solve]\nt_end = 1\n",
        HOSTILE.join(" ")
    );
    place.write("hostile.toml", model);
    let output = place.run("solve hostile.toml -o hostile.mcap");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let mut page = place.bksim();
    let output = page.args(["page", "hostile.mcap", "--title", HOSTILE_TITLE]).output();
    let output = output.expect("bksim starts");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let file = place.path().join("hostile.html");
    json!({ "file": file, "texts": HOSTILE, "title": HOSTILE_TITLE })
}

fn browser() -> PathBuf {
    let named = std::env::var_os("BKSIM_CHROMIUM").map(PathBuf::from);
    let found = named.or_else(|| BROWSERS.iter().map(PathBuf::from).find(|path| path.exists()));
    found.expect("Chromium: install the package `chromium`, or name it in BKSIM_CHROMIUM")
}

fn screenshots() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("page-screenshots")
}

/// Copies a folder of sources with those in it.
fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder of sources");
    for entry in fs::read_dir(from).expect("a folder of sources") {
        let path = entry.expect("a readable folder").path();
        let copy = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy_folder(&path, &copy);
        } else {
            fs::copy(&path, copy).expect("a source");
        }
    }
}

/// A copy of the tests with their libraries, which are installed when the lock file has changed.
fn installed() -> PathBuf {
    static INSTALLED: OnceLock<PathBuf> = OnceLock::new();
    INSTALLED.get_or_init(install).clone()
}

fn install() -> PathBuf {
    let from = Path::new(CRATE).join("../page/web");
    let to = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page-web");
    fs::create_dir_all(to.join("test")).expect("a directory for the test");
    let tests = ["page", "live", "firefox", "module"].map(|name| format!("test/{name}.test.mjs"));
    for name in ["package.json", "package-lock.json", ".npmrc", "tsconfig.json"]
        .map(str::to_owned)
        .iter()
        .chain(&tests)
    {
        fs::copy(from.join(name), to.join(name)).expect("a file of the test");
    }
    copy_folder(&from.join("src"), &to.join("src"));
    let lock = fs::read(to.join("package-lock.json")).expect("a lock file");
    let known = to.join("node_modules/installed-lock.json");
    if fs::read(&known).is_ok_and(|known| known == lock) {
        return to;
    }
    let npm = Command::new("npm").current_dir(&to).args(["ci", "--ignore-scripts"]).output();
    let npm = npm.expect("npm starts: install Node.js 18 or later with npm");
    assert!(npm.status.success(), "npm ci: {}", text(&npm.stderr));
    fs::write(known, lock).expect("a note of what is installed");
    to
}

#[test]
fn the_command_refuses_what_it_should() {
    let place = Scratch::new();
    place.write("rest.toml", "[bodies.b]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\n[solve]\nt_end = 1\n");
    assert!(place.run("solve rest.toml").status.success());
    // A page of the same model is replaced.
    for _ in 0..2 {
        let page = place.run("page rest.mcap -o rest.html");
        assert!(page.status.success(), "{}", text(&page.stderr));
    }
    place.write("mine.html", "<p>of my own</p>\n");
    for (command, status, words) in [
        ("page rest.mcap -o mine.html", 4, "`mine.html` exists ("),
        ("page rest.mcap -o rest.mcap --force", 2, "this command writes HTML"),
        ("page missing.mcap", 4, "there is no such file"),
    ] {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(status), "{command}");
        assert!(text(&output.stderr).contains(words), "{command}: {}", text(&output.stderr));
    }
    assert!(place.run("page rest.toml -o other.html").status.success(), "a model is solved first");
    assert!(place.run("page rest.mcap -o mine.html --force").status.success());
}
