//! Forms of expressions, read and written: text, notations, lists of steps.

mod listing;
mod notations;
mod text;
