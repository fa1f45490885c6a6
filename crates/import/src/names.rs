//! Names that a model file can have for those of other formats.

use std::collections::BTreeSet;

/// Names that mean something else in every model.
const RESERVED: [&str; 14] = [
    "ground",
    "t",
    "pi",
    "mechanism",
    "reactions",
    "drives",
    "outputs",
    "if",
    "then",
    "else",
    "and",
    "or",
    "not",
    "assembly",
];

/// A name that had to change.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Renamed {
    /// `body`, `joint`, `load` or `parameter`.
    pub kind: &'static str,
    /// Name in the file.
    pub from: String,
    /// Name in the model.
    pub to: String,
}

/// The names that are taken.
#[derive(Default, Debug)]
pub(crate) struct Names {
    taken: BTreeSet<String>,
    pub(crate) renamed: Vec<Renamed>,
}

impl Names {
    /// A legal name that is not taken yet, as near to `name` as can be.
    pub(crate) fn take(&mut self, kind: &'static str, name: &str) -> String {
        let legal = legal(name, kind);
        let mut free = legal.clone();
        if self.is_taken(&free) {
            free = format!("{legal}_{kind}");
        }
        let mut number = 2;
        while self.is_taken(&free) {
            free = format!("{legal}_{kind}{number}");
            number += 1;
        }
        self.taken.insert(free.clone());
        if free != name {
            self.renamed.push(Renamed { kind, from: name.to_owned(), to: free.clone() });
        }
        free
    }

    /// A name for something that has none in the file.
    pub(crate) fn coin(&mut self, name: &str) -> String {
        let legal = legal(name, "part");
        let mut free = legal.clone();
        let mut number = 2;
        while self.is_taken(&free) {
            free = format!("{legal}_{number}");
            number += 1;
        }
        self.taken.insert(free.clone());
        free
    }

    fn is_taken(&self, name: &str) -> bool {
        RESERVED.contains(&name) || self.taken.contains(name)
    }
}

/// Letters, digits and `_` alone, not beginning with a digit.
pub(crate) fn legal(name: &str, kind: &str) -> String {
    let mut legal: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' })
        .take(120)
        .collect();
    if !legal.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        legal.insert_str(0, &kind[..1]);
    }
    legal
}
