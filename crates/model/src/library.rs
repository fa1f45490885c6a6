//! The parts that come with bksim: models of their own, used by name with `part = "gas-spring"`.

/// A part of the library.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LibraryPart {
    /// The name by which it is used.
    pub name: &'static str,
    /// The text of its model, which begins with what it is.
    pub text: &'static str,
}

macro_rules! parts {
    ($($name:literal),* $(,)?) => {
        /// All parts, in the order of their names.
        pub const LIBRARY: &[LibraryPart] =
            &[$(LibraryPart { name: $name, text: include_str!(concat!("../parts/", $name, ".toml")) }),*];
    };
}

parts![
    "band-brake",
    "bump-stop",
    "bushing",
    "clutch-brake",
    "dc-motor",
    "flywheel",
    "gas-spring",
    "hydraulic-cylinder",
    "induction-motor",
    "leaf-spring",
    "one-way-clutch",
    "pid",
    "pneumatic-cylinder",
    "ratchet",
    "stepper-motor",
];

impl LibraryPart {
    /// The part of this name.
    pub fn named(name: &str) -> Option<Self> {
        LIBRARY.iter().find(|part| part.name == name).copied()
    }

    /// The comment that its text begins with.
    pub fn about(&self) -> String {
        let lines = self.text.lines().take_while(|line| line.starts_with('#'));
        let words: Vec<&str> = lines.map(|line| line.trim_start_matches('#').trim()).collect();
        words.join("\n")
    }
}
