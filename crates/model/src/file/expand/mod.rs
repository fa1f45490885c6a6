//! Models of several files: parts that are used, files of tables, and elements that repeat, put into one text.
//!
//! ```text
//! files -> trees -> repeated -> renamed -> merged -> one text, with the place that each piece came from
//! ```
//!
//! The text is what everything else reads: a log keeps it, a sweep varies it. Files are opened by the caller.
//!
//! ```
//! use bksim_model::file::{Limits, expand};
//!
//! let text = "[bodies.link]\ncount = 2\nmass = 1\n";
//! let mut open = |name: &str| Err(format!("there is no file `{name}`"));
//! let expansion = expand("chain.toml", text, Limits::default(), &mut open).expect("something repeats");
//! assert_eq!(expansion.text, "[bodies.link1]\nmass = 1\n\n[bodies.link2]\nmass = 1\n");
//! ```

mod emit;
mod merge;
mod meshes;
mod rename;
mod repeat;
mod rows;
mod uses;

use super::Limits;
use super::syntax::{self, decode};
use super::tree::{Table, Value};
use crate::diagnostic::{Diagnostic, Label, Span};
use emit::Piece;
pub(super) use meshes::MOST_FACES;
pub use meshes::triangles;

/// Opens a file that a model names: its bytes, or why there are none, worded to follow the file's name.
pub type Open<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>;

/// The end of the words for a link that leads to no file, in the words of the caller who opens files.
pub const LOOP_OF_LINKS: &str = "it is a link that leads back to itself";

/// Why a file cannot be used.
pub(super) struct Unopened {
    /// The fault, worded to follow the file's name.
    pub(super) why: String,
    /// A way out, where the fault has one of its own.
    pub(super) help: Option<String>,
}

impl From<String> for Unopened {
    fn from(why: String) -> Self {
        Self { why, help: None }
    }
}

impl From<&str> for Unopened {
    fn from(why: &str) -> Self {
        why.to_owned().into()
    }
}

/// The beginning of the names of files that come with bksim.
const OF_LIBRARY: &str = "bksim:";

/// A model put into one text.
#[derive(Clone, PartialEq, Debug)]
pub struct Expansion {
    /// The whole model: nothing in it is in another file, or repeats. Empty where there are errors.
    pub text: String,
    /// The files that it came from, the model itself first.
    pub files: Vec<SourceFile>,
    /// Errors and warnings; their spans are of the files laid end to end, see [`Expansion::source`].
    pub faults: Vec<Diagnostic>,
    pieces: Vec<Piece>,
}

/// A file that a model came from.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SourceFile {
    /// Name of the file as the model gives it, against the model's folder.
    pub name: String,
    /// Text of the source file.
    pub text: String,
    /// Bytes of the files before it.
    start: usize,
}

impl SourceFile {
    /// True of a file that comes with bksim.
    pub fn is_of_library(&self) -> bool {
        self.name.starts_with(OF_LIBRARY)
    }
}

/// True of a model with parts, files of tables or meshes, or elements that repeat.
fn is_of_pieces(root: &Table) -> bool {
    root.entries.iter().any(|section| {
        let Value::Table(table) = &section.node.value else { return false };
        section.key == "use"
            || section.key == "ground" && meshes::is_of_file(table)
            || table.entries.iter().any(|entry| match &entry.node.value {
                Value::Table(keys) => {
                    keys.get("count").is_some()
                        || section.key == "tables" && keys.get("file").is_some()
                        || section.key == "bodies" && meshes::is_of_file(keys)
                }
                _ => false,
            })
    })
}

/// Puts a model into one text; `None` where it is one already, or is not TOML.
pub fn expand(name: &str, text: &str, limits: Limits, open: Open<'_>) -> Option<Expansion> {
    let may_have_pieces = ["use", "count", "file"].iter().any(|word| text.contains(word));
    if !may_have_pieces {
        return None;
    }
    let mut faults = Vec::new();
    let root = syntax::parse(text, limits.nesting, &mut faults)?;
    if !is_of_pieces(&root) {
        return None;
    }
    let mut expander = Expander {
        open,
        nesting: limits.nesting,
        files: Vec::new(),
        sources: String::new(),
        stack: Vec::new(),
        left: MOST_NODES,
        is_full: false,
        faults: Vec::new(),
    };
    let root = expander.whole(name, text.to_owned()).unwrap_or_default();
    let Expander { files, sources, faults, .. } = expander;
    // Nobody reads a whole that has faults.
    let is_whole = !faults.iter().any(Diagnostic::is_error);
    let root = if is_whole { root } else { Table::default() };
    let emit::Emitted { text, pieces } = emit::emitted(&root, &sources);
    Some(Expansion { text, files, faults, pieces })
}

/// Nodes of all trees together: more would fill the memory with copies.
const MOST_NODES: usize = 1_000_000;

/// The files that were opened so far.
struct Expander<'a> {
    open: Open<'a>,
    nesting: usize,
    files: Vec<SourceFile>,
    /// The files end to end, a newline after each: all spans are of it.
    sources: String,
    /// Names of the files that use each other, down to the one that is read.
    stack: Vec<String>,
    /// Nodes that may still be copied.
    left: usize,
    /// True once more were asked for.
    is_full: bool,
    faults: Vec<Diagnostic>,
}

impl Expander<'_> {
    /// The tree of a file with its parts; `None` where it is not TOML.
    fn whole(&mut self, name: &str, text: String) -> Option<Table> {
        let mut root = self.tree_of(name, text)?;
        self.repeat(&mut root);
        self.read_rows(&mut root, name);
        self.read_meshes(&mut root, name);
        self.stack.push(name.to_owned());
        self.use_parts(&mut root);
        self.stack.pop();
        Some(root)
    }

    /// The tree of a file, with spans of all files end to end.
    fn tree_of(&mut self, name: &str, text: String) -> Option<Table> {
        let start = self.keep(name, text);
        let text = &self.files[self.files.len() - 1].text;
        let mut faults = Vec::new();
        let root = syntax::parse(text, self.nesting, &mut faults);
        self.faults.extend(faults.into_iter().map(|fault| moved(fault, start)));
        let mut root = root?;
        root.shift(start);
        Some(root)
    }

    /// The bytes of a file, or why there are none.
    fn opened(&mut self, path: &str) -> Result<Vec<u8>, Unopened> {
        (self.open)(path).map_err(|why| {
            let is_loop = why.ends_with(LOOP_OF_LINKS);
            let help = is_loop.then(|| format!("put a file in the place of the link `{path}`"));
            Unopened { why, help }
        })
    }

    /// The text of a file, or why there is none.
    fn text_of(&mut self, path: &str) -> Result<String, Unopened> {
        let bytes = self.opened(path)?;
        match decode(&bytes) {
            Ok(text) => Ok(text.to_owned()),
            Err(fault) => Err(Unopened {
                why: format!("cannot be read: {}", fault.message),
                help: fault.help,
            }),
        }
    }

    /// Keeps the text of a file: where it starts among all of them.
    fn keep(&mut self, name: &str, text: String) -> usize {
        let start = self.sources.len();
        self.sources.push_str(&text);
        self.sources.push('\n');
        self.files.push(SourceFile { name: name.to_owned(), text, start });
        start
    }

    fn report(&mut self, fault: Diagnostic) {
        self.faults.push(fault);
    }
}

/// A fault with its spans later by some bytes.
fn moved(fault: Diagnostic, by: usize) -> Diagnostic {
    let shifted =
        |label: Label| Label { span: label.span.start + by..label.span.end + by, ..label };
    Diagnostic { labels: fault.labels.into_iter().map(shifted).collect(), ..fault }
}

impl Expansion {
    /// The file, by its place in [`Expansion::files`], and the span there, of a span of the files laid end to
    /// end.
    pub fn source(&self, span: &Span) -> (usize, Span) {
        let after = self.files.partition_point(|file| file.start <= span.start);
        let file_idx = after.saturating_sub(1);
        let start = self.files[file_idx].start;
        (file_idx, span.start - start..span.end.max(span.start) - start)
    }

    /// Origin of a span of [`Expansion::text`]; `None` for what is in no file.
    pub fn origin(&self, span: &Span) -> Option<(usize, Span)> {
        let until = |end: usize| self.pieces.partition_point(|piece| piece.at.start < end);
        let first = self.pieces[..until(span.start + 1)].last()?;
        let last = self.pieces[..until(span.end.max(span.start + 1))].last()?;
        let is_within = span.start < first.at.end.max(first.at.start + 1);
        is_within.then(|| self.source(&Piece::source_of(span, [first, last])))
    }
}
