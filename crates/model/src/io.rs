//! [`Io`]: what goes into a mechanism and comes out of it, for questions about its linear form and for code.

/// Names of inputs and outputs, which stand where a question names none.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Io {
    /// Parameters of loads, joints or positions that an effort works on.
    pub inputs: Vec<String>,
    /// Measures of positions and rates, and components of reactions.
    pub outputs: Vec<String>,
}
