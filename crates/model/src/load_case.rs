//! [`LoadCase`]: named changes of a model.

/// A load case: values in place of others of the model.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LoadCase {
    /// Name by which it is chosen.
    pub name: String,
    /// Words for people, if it has any.
    pub title: Option<String>,
    /// Changed values by name, each with the new one, as written: `F` and `2 kN`, `loads.push.value` and `F*t`.
    pub changes: Vec<(String, String)>,
}
