//! Bundles the page's scripts and styles, `web/`, with the libraries they use.
//!
//! ```text
//! web/ ── npm ci ── esbuild ──→ OUT_DIR/page.js, page.css, LICENCES, and `cfg(bundled)`
//! ```
//!
//! Without Node.js, or with no way to its registry, the crate is built without a page and says so
//! when one is asked for: nothing else of bksim needs Node.js.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// What the bundle is made of.
const SOURCES: [&str; 4] = ["src", "package.json", "package-lock.json", ".npmrc"];

fn main() {
    println!("cargo::rustc-check-cfg=cfg(bundled)");
    println!("cargo::rerun-if-changed=build.rs");
    for source in SOURCES {
        println!("cargo::rerun-if-changed=web/{source}");
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    match bundle(Path::new("web"), &out) {
        Ok(()) => println!("cargo::rustc-cfg=bundled"),
        Err(reason) => {
            // Tried again once there is another path, or with every build if npm itself failed.
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
    let place = out.join("web");
    for source in SOURCES {
        copy(&web.join(source), &place.join(source)).map_err(|e| format!("{source}: {e}"))?;
    }
    install(&place)?;
    let mut esbuild = Command::new("node");
    esbuild.current_dir(&place).arg("node_modules/esbuild/bin/esbuild").args([
        "src/main.js",
        "--bundle",
        "--minify",
        "--format=iife",
        "--target=es2022",
        "--legal-comments=none",
        "--log-level=warning",
    ]);
    esbuild.arg(format!("--outfile={}", out.join("page.js").display()));
    succeed("esbuild", &mut esbuild)?;
    let licence = fs::read_to_string(place.join("node_modules/uplot/LICENSE"));
    let licence = licence.map_err(|e| format!("the licence of uPlot: {e}"))?;
    fs::write(out.join("LICENCES"), licence).map_err(|e| e.to_string())
}

/// Installs the libraries of the lock file, unless they are there.
fn install(place: &Path) -> Result<(), String> {
    let lock = fs::read(place.join("package-lock.json")).map_err(|e| e.to_string())?;
    let installed = place.join("node_modules/installed-lock.json");
    if fs::read(&installed).is_ok_and(|known| known == lock) {
        return Ok(());
    }
    let mut npm = npm();
    npm.current_dir(place).args([
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

fn succeed(what: &str, command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{what} cannot be started: {e}"))?;
    if output.status.success() {
        return Ok(());
    }
    let words = String::from_utf8_lossy(&output.stderr);
    let words = words.lines().next_back().unwrap_or_default();
    Err(format!("{what} failed: {words}"))
}

/// Copies a file, or a folder of files.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if !from.is_dir() {
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent)?;
        }
        return fs::copy(from, to).map(drop);
    }
    // What is no longer there goes from the copy too.
    if to.is_dir() {
        fs::remove_dir_all(to)?;
    }
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}
