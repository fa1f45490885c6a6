//! Faults of a model as data: a stable code, a message, the positions, and the help.
//!
//! Nothing here renders or prints; the command line draws the excerpts and `--json` passes the
//! fields on unchanged.

use std::ops::Range;

/// The weight of a fault.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Severity {
    /// The model is rejected.
    Error,
    /// The run goes on; the author should know.
    Warning,
}

/// A stable diagnostic code such as `M012`; every code has a page, which `bksim explain` shows.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Code(pub &'static str);

/// A code with what `bksim explain` says about it; see [`codes`](crate::codes!).
#[derive(Clone, Copy, Debug)]
pub struct Page {
    /// The stable code.
    pub code: Code,
    /// The subject in a few words.
    pub title: &'static str,
    /// The page in Markdown: meaning, an example, the way out.
    pub text: &'static str,
}

/// Codes as constants, and the table `PAGES` of their pages, which lie in `docs/diagnostics`: one row
/// each, `NAME = "M001", "title";`.
#[macro_export]
macro_rules! codes {
    ($($name:ident = $code:literal, $title:literal;)*) => {
        $crate::codes! { pages "/../../docs/diagnostics/"; $($name = $code, $title;)* }
    };
    // The pages lie there from the manifest of the crate.
    (pages $pages:literal; $($name:ident = $code:literal, $title:literal;)*) => {
        $(#[doc = $title] pub const $name: $crate::diagnostic::Code =
            $crate::diagnostic::Code($code);)*

        /// Every code of this room, in order, with its page.
        pub const PAGES: &[$crate::diagnostic::Page] = &[$($crate::diagnostic::Page {
            code: $name,
            title: $title,
            text: include_str!(concat!(
                env!("CARGO_MANIFEST_DIR"),
                $pages,
                $code,
                ".md"
            )),
        }),*];
    };
}

/// Byte range in the model text.
pub type Span = Range<usize>;

/// A position in the model text with a remark.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Label {
    /// Position in bytes of the model text.
    pub span: Span,
    /// A remark on it in a few lower-case words; may be empty.
    pub text: String,
}

/// One fault of a model.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Diagnostic {
    /// The stable code.
    pub code: Code,
    /// Error or warning.
    pub severity: Severity,
    /// The message: lower case, no full stop, names in backticks, numbers with units.
    pub message: String,
    /// The offending token; the first label is the position shown in `file:line:column`.
    /// Empty only for a fault of the whole model, whose message then names the parts.
    pub labels: Vec<Label>,
    /// Further facts, one line each.
    pub notes: Vec<String>,
    /// The text to write instead; works when applied literally.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error without a position yet.
    pub fn error(code: Code, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Error, message.into())
    }

    /// A warning without a position yet.
    pub fn warning(code: Code, message: impl Into<String>) -> Self {
        Self::new(code, Severity::Warning, message.into())
    }

    fn new(code: Code, severity: Severity, message: String) -> Self {
        Self { code, severity, message, labels: Vec::new(), notes: Vec::new(), help: None }
    }

    /// Adds a position; the first one added is the primary one.
    #[must_use]
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Adds a fact.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Says what to write instead.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// True if this fault rejects the model.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

/// Why a model was rejected or a run stopped; at least one diagnostic is an error.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{}", .0.iter().map(|d| format!("[{}] {}", d.code.0, d.message)).collect::<Vec<_>>().join("; "))]
pub struct Rejected(pub Vec<Diagnostic>);
