//! From a path to a model: model files and drawings are opened here and read by the library, and their
//! faults put back into the file, line and column that they are about.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use bksim_load::{Request, load};
//!
//! let loaded = load(&Request::new(Path::new("examples/slider-crank/model.toml")))?;
//! println!("{} bodies, {} warnings", loaded.model.bodies.len(), loaded.warnings.len());
//! # Ok::<(), bksim_load::InputError>(())
//! ```
//!
//! | file, each on those above it alone | holds |
//! |---|---|
//! | `text.rs` | the text of a model, and where its faults are in the files it came from |
//! | `excerpt.rs` | faults for people and for programs |
//! | `error.rs` | why there is no model |
//! | `request.rs`, `file.rs` | the model that is asked for; files as bytes |
//! | `drawing.rs` | models that come out of drawings |
//! | `parts.rs` | models of several files |
//! | `watch.rs` | changes of files |
//! | `load.rs` | from a path to a model: a model file, a drawing, or one that names the other |
//!
//! # Invariants
//!
//! Opens files and prints nothing.

mod drawing;
mod error;
mod excerpt;
mod file;
mod folder;
mod load;
mod parts;
mod request;
mod text;
mod watch;

pub use drawing::read_sheet;
pub use error::{InputError, plain_words, without_number};
pub use excerpt::{WIDTH, json, json_all, plain, styled, titled};
pub use file::{is_log, is_stdin, read_bytes};
pub use load::{Loaded, is_drawn, label_of, load, load_text, name_of, parse, parse_recorded};
pub use parts::whole;
pub use request::Request;
pub use text::{Drawn, Located, Parts, Text, line_and_column};
pub use watch::Watch;
