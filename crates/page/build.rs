//! Bundles the page's scripts and styles, `web/`, with the libraries they use.
//!
//! ```text
//! web/ ── npm ci ── esbuild ──→ OUT_DIR/page.js, page.css, live.js, live.css, worker.js, LICENCES, and `cfg(bundled)`
//! ```
//!
//! Without Node.js, or without access to its registry, the crate is built without a page, and
//! requests for one fail with that reason: nothing else of bksim needs Node.js.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// Files and folders that the bundle is made of.
const SOURCES: [&str; 5] = ["src", "tsconfig.json", "package.json", "package-lock.json", ".npmrc"];

/// Scripts that begin a bundle, and their bundles: the page of a run, the live page, and the thread of its module.
const BUNDLES: [(&str, &str); 3] = [
    ("src/main.js", "page.js"),
    ("src/live/main.ts", "live.js"),
    ("src/live/worker.ts", "worker.js"),
];

fn main() {
    println!("cargo::rustc-check-cfg=cfg(bundled)");
    println!("cargo::rerun-if-changed=build.rs");
    for source in SOURCES {
        println!("cargo::rerun-if-changed=web/{source}");
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR for build scripts"));
    match bundle(Path::new("web"), &out) {
        Ok(()) => println!("cargo::rustc-cfg=bundled"),
        Err(reason) => {
            // Tries again when PATH changes, or with every build if npm itself failed.
            println!("cargo::rerun-if-env-changed=PATH");
            if npm().arg("--version").output().is_ok() {
                println!("cargo::rerun-if-changed=web/never-there");
            }
            println!("cargo::warning=`bksim page` is left out: {reason}");
        }
    }
}

/// Copies `web` to `out`, installs its libraries there and makes the bundle.
fn bundle(web: &Path, out: &Path) -> Result<(), String> {
    let folder = out.join("web");
    for source in SOURCES {
        copy(&web.join(source), &folder.join(source)).map_err(|e| format!("{source}: {e}"))?;
    }
    install(&folder)?;
    for (entry, bundle) in BUNDLES {
        let mut esbuild = Command::new("node");
        esbuild.current_dir(&folder).arg("node_modules/esbuild/bin/esbuild").args([
            entry,
            "--bundle",
            "--minify",
            "--format=iife",
            "--target=es2022",
            "--legal-comments=none",
            "--log-level=warning",
        ]);
        esbuild.arg(format!("--outfile={}", out.join(bundle).display()));
        succeed("esbuild", &mut esbuild)?;
    }
    let licence = fs::read_to_string(folder.join("node_modules/uplot/LICENSE"));
    let licence = licence.map_err(|e| format!("the licence of uPlot: {e}"))?;
    fs::write(out.join("LICENCES"), licence).map_err(|e| e.to_string())
}

/// Installs the libraries of the lock file, unless they are there.
fn install(folder: &Path) -> Result<(), String> {
    let lock = fs::read(folder.join("package-lock.json")).map_err(|e| e.to_string())?;
    let installed = folder.join("node_modules/installed-lock.json");
    if fs::read(&installed).is_ok_and(|known| known == lock) {
        return Ok(());
    }
    let mut npm = npm();
    npm.current_dir(folder).args([
        "ci",
        "--ignore-scripts",
        "--omit=dev",
        "--no-audit",
        "--no-fund",
    ]);
    succeed("npm ci", &mut npm)?;
    fs::write(installed, lock).map_err(|e| e.to_string())
}

fn npm() -> Command {
    Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" })
}

/// Runs a command; fails with the last line of its errors.
fn succeed(name: &str, command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{name} cannot be started: {e}"))?;
    if output.status.success() {
        return Ok(());
    }
    let errors = String::from_utf8_lossy(&output.stderr);
    let last = errors.lines().next_back().unwrap_or_default();
    Err(format!("{name} failed: {last}"))
}

/// Copies a file, or a folder of files.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if !from.is_dir() {
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent)?;
        }
        return fs::copy(from, to).map(drop);
    }
    // Files that were removed from the original must not stay in the copy.
    if to.is_dir() {
        fs::remove_dir_all(to)?;
    }
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}
