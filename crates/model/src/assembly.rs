//! [`ChosenAssembly`]: the way of closing that a start is to have.

use crate::diagnostic::Span;
use crate::measure::{Initial, Measure};

/// One of the ways in which the joints close, as `[initial]` chooses it.
#[derive(Clone, Debug)]
pub struct ChosenAssembly {
    /// Which one.
    pub choice: AssemblyChoice,
    /// Position of the value.
    pub span: Span,
    /// The assembly itself, once it has been looked for; its pose is then guessed in `Model::initial`.
    pub found: Option<FoundAssembly>,
}

/// A number or a name of an assembly.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum AssemblyChoice {
    /// From one, in the order in which assemblies are listed.
    Number(usize),
    /// A name: `A-B-C-D crossed`.
    Name(String),
}

/// An assembly that was found.
#[derive(Clone, Debug)]
pub struct FoundAssembly {
    /// From one.
    pub number: usize,
    /// Name of the assembly.
    pub name: String,
    /// Measures that tell assemblies apart by being held.
    pub held: Vec<Measure>,
    /// Stated and guessed values as they were written, without its pose.
    pub written: Vec<Initial>,
}
