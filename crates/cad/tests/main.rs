//! Drawings: opened, read, misread, composed, written and edited.

mod common;
mod compose;
mod lisp;
mod mass;
mod misread;
mod opening;
mod rewrite;
mod writing;
