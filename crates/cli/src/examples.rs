//! The models of the folder `examples`, inside of the program.

/// A model that comes with bksim.
#[derive(Debug)]
pub struct Example {
    /// Name of its folder.
    pub name: &'static str,
    /// The heading of its page.
    pub title: &'static str,
    /// Names and contents of the files that it is made of.
    pub files: &'static [(&'static str, &'static [u8])],
}

include!(concat!(env!("OUT_DIR"), "/examples.rs"));
