//! Editing: documents, and sessions.

mod document;
mod scripts;
mod session;
