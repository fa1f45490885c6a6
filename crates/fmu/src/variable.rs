//! The variables of a unit: names, units, start values.

/// Name, unit and meaning of a number that goes in or comes out.
#[derive(Clone, PartialEq, Debug)]
pub struct Variable {
    /// Name as the author of the model wrote it: `u`, `crank.angle`.
    pub name: String,
    /// SI unit as text, empty of a pure number.
    pub unit: String,
    /// Meaning in a few words.
    pub description: String,
    /// Value at first, SI; of what is computed, zero.
    pub start: f64,
}

impl Variable {
    pub(crate) fn new(name: &str, unit: &str, description: &str) -> Self {
        let [name, unit, description] = [name, unit, description].map(str::to_owned);
        Self { name, unit, description, start: 0.0 }
    }

    pub(crate) fn starting_at(self, start: f64) -> Self {
        Self { start, ..self }
    }
}

/// A name as an identifier of C.
pub(crate) fn identifier(name: &str) -> String {
    let allowed = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(allowed).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("m_{name}") }
}
