//! The house itself: the storeys of its crates, the words of its code, and the links of its book.

mod book;
mod built_once;
mod manifests;
mod rooms;
mod words;
