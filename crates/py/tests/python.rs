//! The tests of the Python package, by its own interpreter: types, docstrings, pytest. What they test
//! is the library that was built for this test, next to the package's Python files.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the workspace")
}

/// The interpreter that has what the tests need.
fn python() -> PathBuf {
    let own = || root().join("target/venv/bin/python");
    env::var_os("BKSIM_PYTHON").map_or_else(own, PathBuf::from)
}

/// A folder with the package as it would be installed.
fn installed() -> PathBuf {
    let library = env::current_exe().expect("this test").with_file_name(library_name());
    let folder = root().join("target/python");
    let package = folder.join("bksim");
    let _ = fs::remove_dir_all(&package);
    fs::create_dir_all(&package).expect("a folder");
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/bksim");
    for file in fs::read_dir(sources).expect("the package").map(|file| file.expect("a file").path())
    {
        if file.is_file() {
            fs::copy(&file, package.join(file.file_name().expect("a name"))).expect("copied");
        }
    }
    fs::copy(&library, package.join(module_name()))
        .unwrap_or_else(|e| panic!("{}: {e}", library.display()));
    folder
}

fn library_name() -> &'static str {
    if cfg!(windows) {
        "_bksim.dll"
    } else if cfg!(target_os = "macos") {
        "lib_bksim.dylib"
    } else {
        "lib_bksim.so"
    }
}

fn module_name() -> &'static str {
    if cfg!(windows) { "_bksim.pyd" } else { "_bksim.abi3.so" }
}

fn run(what: &str, folder: &Path, arguments: &[&str]) {
    let output = Command::new(python())
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("PYTHONPATH", folder)
        .env("MYPYPATH", folder)
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}: run tests/setup.sh first", python().display()));
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{what}\n{out}\n{err}");
}

#[test]
fn the_package_is_typed_documented_and_tested() {
    let folder = installed();
    run("pytest", &folder, &["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "tests"]);
    let package = folder.join("bksim");
    let package = package.to_str().expect("a path");
    let doctest = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "--doctest-modules", "-c"];
    let settings = ["pyproject.toml", "--rootdir", ".", "--confcutdir", ".", "-p", "conftest"];
    run("docstrings", &folder, &[&doctest[..], &settings, &[package]].concat());
    run("mypy", &folder, &["-m", "mypy", "--strict", "-p", "bksim"]);
    run("programs", &folder, &["-m", "mypy", "--strict", "tests/typed.py"]);
    let own = python();
    let own = own.to_str().expect("a path");
    run("pyright", &folder, &["-m", "pyright", "--pythonpath", own]);
    let stubtest = ["-m", "mypy.stubtest", "bksim._bksim"];
    run("stubtest", &folder, &stubtest);
}
