//! The model file: text with spans in, [`Model`] and every fault out.
//!
//! ```text
//! text -> syntax (TOML) -> tree -> names -> parameters -> bodies, joints, loads, … -> checks
//! ```
//!
//! Names are gathered first, so that the order of tables in the file is free. Reading never stops
//! at the first fault; what depends on a faulty part is skipped in silence, so that one mistake
//! gives one message.
//!
//! ```
//! use bksim_model::file::{Source, read};
//!
//! let text = r#"
//! [bodies.bob]
//! mass = "1 kg"
//! points = { pin = [0, "0.5 m"] }
//! [joints.pivot]
//! type = "revolute"
//! between = ["ground", "bob.pin"]
//! "#;
//! let reading = read(&Source::new(text, "pendulum"));
//! assert!(reading.diagnostics.is_empty());
//! assert_eq!(reading.model.expect("a model").joints[0].name, "pivot");
//! ```

mod arcs;
mod axes;
mod beam_parts;
mod belts;
mod between;
mod bodies;
mod cams;
mod cases;
mod checks;
mod clearance;
mod codes;
mod compliance;
mod contacts;
mod couplings;
mod curves;
mod decimal_commas;
mod definition;
mod degrees;
mod dimension;
mod expand;
mod flanks;
mod flexible;
mod formulas;
mod frames;
mod friction;
mod function;
mod gather;
mod grids;
mod hertz;
mod implausible;
mod initial;
mod io;
mod joint_types;
mod joints;
mod latched;
mod laws;
mod leaving;
mod letters;
mod lifting;
mod loads;
mod lookup;
mod lower;
mod marks;
mod misplaced;
mod misread;
mod monotone;
mod names;
mod naming;
mod needed_unit;
mod orientation;
mod other_forms;
mod outline;
mod outlines;
mod parameters;
mod pieces;
mod piecewise;
mod places;
mod plausible;
mod play;
mod points;
mod products;
mod promote;
mod quantity;
mod ranges;
mod rate_of;
mod rates;
mod reader;
mod replay;
mod rolling;
mod ropes;
mod sampled;
mod schema;
mod sections;
mod shown_units;
mod solids;
mod solve;
mod springs;
mod stated;
mod states;
mod stresses;
mod surfaces;
mod syntax;
mod tables;
mod tangent_planes;
mod teeth;
mod token;
mod tree;
mod units;
mod value;
mod wheels;
mod words;
mod written_unit;

use bksim_expr::{Expr, Pool};

pub use codes::PAGES;
pub use compliance::NoCompliance;
pub use degrees::{amplitude_like_degrees, looks_like_degrees};
pub use expand::{Expansion, LOOP_OF_LINKS, Open, SourceFile, expand, triangles};
pub use naming::{NAMED, OWNERS, is_name, is_word};
pub use quantity::names_in;
pub use ranges::stated_ranges;
pub use replay::Recording;
pub use schema::{Holds, SectionForm, TableForm, sections};
pub use sections::SECTIONS;
pub use shown_units::{ShownUnit, ShownUnits};
pub use syntax::decode;
pub use words::{closest, did_you_mean, suggest};
pub use written_unit::WrittenUnit;

use cases::place_values;
use names::Names;
use reader::Reader;
use replay::Constants;
use units::FileUnits;

use crate::diagnostic::Diagnostic;
use crate::model::Model;

/// The codes of all faults of a model file, by name.
pub mod code {
    pub use super::codes::*;
}

/// The override that chooses a load case, `case=loaded`, unless it is a parameter of the model.
pub const CASE: &str = "case";

/// A model text with its name, overrides and limits.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// The text of the file.
    pub text: &'a str,
    /// Name of the model unless the text states one.
    pub name: &'a str,
    /// Replaced definitions of parameters, `(name, value)`; a value is written as in the file,
    /// `25 mm` or `l1/2`, without quotes. Values of the file that are no parameters are named by their
    /// path: `crank.mass`, `loads.gravity.acceleration.1`. [`CASE`] chooses a load case, over which the others go.
    pub overrides: &'a [(String, String)],
    /// Values of the file, by their path, that become parameters of this name.
    pub promoted: &'a [String],
    /// Limits that protect against hostile input.
    pub limits: Limits,
    /// True if positions alone are asked for: bodies need no masses then.
    pub is_geometry: bool,
}

impl<'a> Source<'a> {
    /// A text by itself.
    pub fn new(text: &'a str, name: &'a str) -> Self {
        Self {
            text,
            name,
            overrides: &[],
            promoted: &[],
            limits: Limits::default(),
            is_geometry: false,
        }
    }
}

/// Limits that protect against hostile input.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Deepest nesting of brackets, in the file (where TOML ends at 80) and in one expression.
    /// Default 64.
    pub nesting: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { nesting: 64 }
    }
}

/// The result of reading.
#[derive(Debug)]
pub struct Reading {
    /// The model, unless there was an error.
    pub model: Option<Model>,
    /// Errors and warnings in file order, each once; about [`MAX_DIAGNOSTICS`] at most.
    pub diagnostics: Vec<Diagnostic>,
}

/// More faults than this are not worth reading.
pub const MAX_DIAGNOSTICS: usize = 100;

/// Reads a model.
pub fn read(source: &Source<'_>) -> Reading {
    read_recorded(source, &[]).0
}

/// Reads a model, and how its parameters and settings follow from those that vary: each of these is
/// among the overrides with a number and perhaps a unit.
///
/// ```
/// use bksim_model::file::{Source, read_recorded};
///
/// let text = r#"
/// [parameters]
/// l = 1
/// m = "2 kg/m*l"
/// [bodies.bob]
/// mass = "m"
/// com = ["l", 0]
/// [joints.A]
/// type = "revolute"
/// between = ["ground", "bob"]
/// "#;
/// let set = [("l".to_owned(), "0.5 m".to_owned())];
/// let source = Source { overrides: &set, ..Source::new(text, "pendulum") };
/// let (reading, recording) = read_recorded(&source, &["l".to_owned()]);
/// let mut solve = reading.model.expect("a model").solve;
/// let recording = recording.expect("a model");
/// let (mut all, mut values) = ([0.0; 2], Vec::new());
/// assert!(recording.replay(&[0.75], &mut values, &mut all, &mut solve));
/// assert_eq!(all, [0.75, 1.5]);
/// assert!(!recording.replay(&[-1.0], &mut values, &mut all, &mut solve), "a negative mass");
/// ```
pub fn read_recorded(source: &Source<'_>, varied: &[String]) -> (Reading, Option<Recording>) {
    let mut reader = Reader { constants: Constants::new(varied), ..Reader::of(source) };
    let model = reader.read(source);
    let values = reader.recorded.take();
    let recording = model.as_ref().and(values).map(|values| reader.constants.finish(values));
    (Reading { model, diagnostics: reader.faults }, recording)
}

/// A formula of time and parameters that is read with a model but is no part of its text.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Formula<'a> {
    /// Name of the result, as in messages.
    pub what: &'a str,
    /// Formula as written: `100 mm*t/(1 s)`, or a call of one of the tables and laws of the model.
    pub text: &'a str,
    /// `rad` or `m`, the unit of its values; empty of plain numbers.
    pub unit: &'a str,
}

/// Reads formulas with the names, tables and units of a model, and the model with what they use of it.
///
/// # Errors
/// The faults of the model, with positions in its text, or those of formulas, without.
pub fn read_formulas(
    source: &Source<'_>,
    formulas: &[Formula<'_>],
) -> Result<(Model, Vec<Expr>), Vec<Diagnostic>> {
    let mut reader = Reader { formulas, ..Reader::of(source) };
    let model = reader.read(source);
    let (found, faults) = (reader.found, reader.faults);
    model.zip((found.len() == formulas.len()).then_some(found)).ok_or(faults)
}

impl<'a> Reader<'a> {
    /// A reader that has read nothing yet.
    fn of(source: &Source<'a>) -> Self {
        Self {
            text: source.text,
            nesting: source.limits.nesting,
            needs_masses: !source.is_geometry,
            pool: Pool::new(),
            units: FileUnits::default(),
            names: Names::default(),
            parameters: Vec::new(),
            parameter_order: Vec::new(),
            faults: Vec::new(),
            spatial: None,
            functions: Vec::new(),
            table_calls: Vec::new(),
            tables: Vec::new(),
            measured: Vec::new(),
            curves: Vec::new(),
            laws: Vec::new(),
            local: None,
            values: Vec::new(),
            sampled: Vec::new(),
            belts: Vec::new(),
            ropes: Vec::new(),
            rope_loads: Vec::new(),
            flexible: Vec::new(),
            belt_signals: Vec::new(),
            at_start: Vec::new(),
            waiting: Vec::new(),
            counts: Vec::new(),
            latched: Vec::new(),
            joint_ends: Vec::new(),
            joint_bodies: Vec::new(),
            topology_unknown: false,
            read_as_pure: Vec::new(),
            recorded: None,
            constants: Constants::new(&[]),
            formulas: &[],
            found: Vec::new(),
            cases: Vec::new(),
            plays: Vec::new(),
        }
    }

    fn read(&mut self, source: &Source<'_>) -> Option<Model> {
        let root = syntax::parse(source.text, source.limits.nesting, &mut self.faults);
        root.and_then(|mut root| {
            self.check_sections(&mut root);
            self.merge_case(&mut root, source);
            let overrides = place_values(&mut root, source.overrides);
            let source = &Source { overrides: &overrides, ..*source };
            let set = source.overrides.iter().map(|(name, _)| name);
            let paths = source.promoted.iter().chain(set).map(String::as_str);
            let promoted = promote::promoted(&mut root, paths);
            self.read_model(&root, &promoted, source)
        })
    }
}

/// The faults of a text as TOML, whatever it says about a model.
pub fn check_syntax(text: &str, limits: Limits) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    syntax::parse(text, limits.nesting, &mut faults);
    faults
}
