//! A drawing of a model: every body where it starts, everything else as inserts with its words.
//!
//! ```text
//! shapes            BK_BODY_name, BK_GROUND    outlines of the model, else bars and blocks
//! frames, points    BK_MARKS                   BK_BODY, BK_COM, BK_POINT
//! joints            BK_JOINTS                  BK_REVOLUTE …, bodies and points always stated
//! loads, drives     BK_LOADS
//! couplings         BK_LOADS                   BK_GEAR, BK_BELT …, from joint to joint
//! the rest          BK_SHEET                   BK_PARAMETER, BK_TABLE, BK_STATE, BK_INITIAL …
//! ```
//!
//! Values are the words of the file; a bare number that is a whole value gets its unit, since in a
//! drawing a bare length is in drawing units. Geometry is computed and written so that it reads back to
//! the last bit.

mod bodies;
mod joints;
mod loads;
mod named;
mod positions;
mod shape;
mod sheet;
mod texts;
mod units;

use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Model, Space};
use bksim_sim::pose::PlanarPose;
use toml_edit::DocumentMut;

use self::positions::Positions;
use self::units::FileUnits;
use super::blocks::{Placed, Words, define, place};
use super::canvas::{Canvas, Release, WriteError};
use super::template::{JOINT_COLOUR, usual_size};
use crate::codes;
use crate::geometry::Point;
use crate::kind::{GROUND_LAYER, JOINT_LAYER, Kind, by_name};

/// Frames, points and centres of mass.
const MARK_LAYER: &str = "BK_MARKS";
/// Loads and drives.
const LOAD_LAYER: &str = "BK_LOADS";
/// Parameters, start and options.
const SHEET_LAYER: &str = "BK_SHEET";

/// A model to draw.
#[derive(Clone, Copy, Debug)]
pub struct ModelSource<'a> {
    /// The text of the model.
    pub text: &'a str,
    /// The model that was read from it.
    pub model: &'a Model,
    /// Where its bodies start, the ground first.
    pub poses: &'a [PlanarPose],
    /// Of the file.
    pub release: Release,
    /// Of lengths: `mm`, `cm`, `m`, `inch` or `ft`.
    pub unit: &'a str,
}

/// Draws a planar model.
///
/// # Errors
/// [`Unwritten`]: something of the model has no place in a drawing, or nothing can be written.
pub fn from_model(source: &ModelSource<'_>) -> Result<Vec<u8>, Unwritten> {
    if source.model.space == Space::Spatial {
        let message = "a drawing is plane, but this model is spatial";
        let help = "remove `space` and the z parts of its vectors if it moves in a plane; `bksim \
                    view` and `bksim render` show it in space";
        return Err(Diagnostic::error(codes::SPATIAL, message).help(help).into());
    }
    let document: DocumentMut = source.text.parse().map_err(|_| no_place("this text", "it"))?;
    let positions = Positions::new(source)?;
    let size = positions.symbol_size().max(1e-3 * usual_size(source.unit));
    let mut sketch = Sketch {
        model: source.model,
        release: source.release,
        units: FileUnits::of(&document),
        document: &document,
        size,
        canvas: Canvas::new(source.release, source.unit)?,
        positions,
        crowd: Vec::new(),
    };
    sketch.define()?;
    sketch.bodies()?;
    sketch.joints()?;
    sketch.loads()?;
    sketch.drives()?;
    sketch.couplings()?;
    sketch.sheet()?;
    Ok(sketch.canvas.bytes()?)
}

/// Why a model was not drawn.
#[derive(Debug)]
pub enum Unwritten {
    /// Something of the model has no place in a drawing.
    Model(Box<Diagnostic>),
    /// The drawing cannot be written.
    Write(WriteError),
}

impl From<Diagnostic> for Unwritten {
    fn from(fault: Diagnostic) -> Self {
        Self::Model(Box::new(fault))
    }
}

impl From<WriteError> for Unwritten {
    fn from(error: WriteError) -> Self {
        Self::Write(error)
    }
}

/// The drawing as far as it has come.
struct Sketch<'a> {
    model: &'a Model,
    release: Release,
    document: &'a DocumentMut,
    units: FileUnits,
    /// Of a symbol, in drawing units.
    size: f64,
    canvas: Canvas,
    positions: Positions<'a>,
    /// Where symbols with a name stand, so that names do not cover each other.
    crowd: Vec<Point>,
}

/// Keys of an insert and their values.
type Values = Vec<(&'static str, String)>;

impl Sketch<'_> {
    fn define(&mut self) -> Result<(), Unwritten> {
        self.canvas.layer(GROUND_LAYER, super::template::GROUND_COLOUR);
        self.canvas.layer(JOINT_LAYER, JOINT_COLOUR);
        for (layer, colour) in [(MARK_LAYER, 8), (LOAD_LAYER, 3), (SHEET_LAYER, 8)] {
            self.canvas.layer(layer, colour);
        }
        Ok(define(&mut self.canvas, self.size)?)
    }

    /// Inserts the block of a kind from `at` towards `to`.
    fn insert(
        &mut self,
        kind: &'static Kind,
        layer: &str,
        ends: [Point; 2],
        values: Values,
    ) -> Result<(), Unwritten> {
        let words = Words::Raised(self.lift(kind, ends[0]));
        self.insert_with(kind, layer, ends, words, values)
    }

    fn insert_with(
        &mut self,
        kind: &'static Kind,
        layer: &str,
        [at, to]: [Point; 2],
        words: Words,
        values: Values,
    ) -> Result<(), Unwritten> {
        self.check_lengths(&values)?;
        let placed = Placed { kind, layer, at, to, size: self.size, words, values };
        Ok(place(&mut self.canvas, &placed)?)
    }

    /// How far the words of another symbol at a point are raised, in sizes.
    fn lift(&mut self, kind: &Kind, at: Point) -> f64 {
        if !kind.keys.contains(&"name") || kind.name == "ground" {
            return 0.0;
        }
        let near = |other: &&Point| (other[0] - at[0]).hypot(other[1] - at[1]) < 0.5 * self.size;
        let others = self.crowd.iter().filter(near).count();
        self.crowd.push(at);
        0.75 * others as f64
    }

    /// Old drawings hold 255 characters in a value, new ones 2049.
    fn longest(&self) -> usize {
        if self.release < Release::R2000 { 255 } else { 2049 }
    }

    fn check_lengths(&self, values: &Values) -> Result<(), Unwritten> {
        let most = self.longest();
        for (key, value) in values {
            let length = value.chars().count();
            if length > most {
                let message = format!(
                    "a value of `{key}` has {length} characters; a drawing of this release holds {most}"
                );
                return Err(Diagnostic::error(codes::TOO_LONG, message)
                    .help("write a newer release, or name parts of it in `[parameters]`")
                    .into());
            }
        }
        Ok(())
    }
}

/// The row of a kind that is known to be there.
fn kind(name: &str) -> &'static Kind {
    by_name(name).expect("kinds of models are kinds of attachments")
}

/// The fault of a value that a drawing cannot hold.
fn no_place(what: &str, owner: &str) -> Diagnostic {
    let message = format!("{what} of {owner} has no place in a drawing");
    Diagnostic::error(codes::UNDRAWABLE, message)
}
