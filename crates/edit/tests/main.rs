//! Editing: documents, and sessions.

mod document;
mod session;
