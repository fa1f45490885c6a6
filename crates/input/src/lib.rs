//! Model files and drawings: opened here, read by the library, and their faults put back into the
//! file, line and column that they are about.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use bksim_input::{Request, load};
//!
//! let loaded = load(&Request::new(Path::new("examples/slider-crank/model.toml")))?;
//! println!("{} bodies, {} warnings", loaded.model.bodies.len(), loaded.warnings.len());
//! # Ok::<(), bksim_input::InputError>(())
//! ```
//!
//! | room | holds |
//! |---|---|
//! | `load.rs` | from a path to a model: a model file, a drawing, or one beside the other |
//! | `text.rs` | the text of a model, and whence it came |
//! | `drawn.rs` | models that come out of drawings, and where in those their faults are |
//! | `excerpt.rs` | faults for people and for programs |
//! | `error.rs` | why there is no model |
//!
//! # Invariants
//!
//! Opens files and prints nothing.

mod drawn;
mod error;
mod excerpt;
mod load;
mod text;

pub use drawn::{Drawn, Located, read_sheet};
pub use error::{InputError, plain_words, without_number};
pub use excerpt::{WIDTH, json, json_all, plain, styled, titled};
pub use load::{Loaded, Request, load, parse, parse_recorded, read_bytes};
pub use text::{Text, line_and_column};
