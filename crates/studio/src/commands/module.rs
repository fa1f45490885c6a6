//! Parts of live pages: their module, a file next to the program or where the build leaves it, and a drawing underneath.

use std::fs;
use std::path::{Path, PathBuf};

use bksim::cad::backdrop::Backdrop;
use bksim::cad::units;
use bksim_cli::exit::Failure;
use bksim_cli::source::{Text, read_bytes};
use bksim_load::InputError;

/// Name of the file.
const NAME: &str = "bksim_live.wasm";
/// Where `cargo build -p bksim-live --profile live --target wasm32-unknown-unknown` leaves it, against the folder of a
/// program in `target/debug` or `target/release`.
const BUILT: &str = "../wasm32-unknown-unknown/live";

/// The advice where there is none.
const HELP: &str = "build it once: rustup target add wasm32-unknown-unknown && cargo build -p bksim-live --profile live \
                    --target wasm32-unknown-unknown; or put the file of a release next to the program, or name it in BKSIM_LIVE";

/// The bytes of the module.
///
/// # Errors
/// [`Failure::Usage`] says how to have it.
pub(crate) fn module() -> Result<Vec<u8>, Failure> {
    if let Some(path) = std::env::var_os("BKSIM_LIVE").map(PathBuf::from) {
        return fs::read(&path).map_err(|e| Failure::reading(&path, &e));
    }
    let program = std::env::current_exe().ok();
    let folder = program.as_deref().and_then(Path::parent);
    let places = folder.into_iter().flat_map(|folder| {
        // Programs of tests are one folder deeper.
        ["", BUILT, "../../wasm32-unknown-unknown/live"].map(|place| folder.join(place).join(NAME))
    });
    let found = places.into_iter().find_map(|path| fs::read(path).ok());
    found.ok_or_else(|| Failure::usage("the module of live pages is not here".to_owned(), HELP))
}

/// The lines of a drawing for a live page; `unit` is the name of its unit.
///
/// # Errors
/// [`Failure`] where it cannot be read.
pub(crate) fn backdrop(path: &Path, unit: Option<&String>) -> Result<Backdrop, Failure> {
    let known =
        |name: &String| units::by_name(name).ok_or_else(|| InputError::Unit { name: name.clone() });
    let unit = unit.map(known).transpose()?;
    let read = Backdrop::read(read_bytes(path)?, unit);
    read.map_err(|refused| Failure::Model {
        source: Box::new(Text::new(path, refused.text)),
        diagnostics: refused.diagnostics,
    })
}
