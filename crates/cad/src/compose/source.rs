//! The drawing as every stage reads it: its attachments, and the lengths that follow from its size.

use crate::attachment::Attachment;
use crate::drawing::{Drawing, LengthUnit};
use crate::geometry::Point;
use crate::kind::Section;

/// The snapping tolerance over the diagonal of the drawing, unless it is given.
pub const RELATIVE_TOLERANCE: f64 = 1e-4;

/// Points nearer than this part of the size of the drawing are one but for rounding.
const RELATIVE_ROUNDING: f64 = 1e-12;

/// Coordinates are written to this many digits of the size of the drawing: what is below is rounding.
const DIGITS: i32 = 14;

/// Digits of corners of outlines, which are for pictures.
const PICTURE_DIGITS: i32 = 6;

/// Outlines for pictures are polygons within this part of the diagonal of the drawing.
const PICTURE_TOLERANCE: f64 = 1e-4;

/// Numbers are written with fewer decimals than this: powers of ten end near there.
const MAX_DECIMALS: i32 = 300;

/// A drawing, its attachments and its scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) drawing: &'a Drawing,
    pub(super) attachments: &'a [Attachment],
    pub(super) scale: Scale,
}

impl<'a> Source<'a> {
    /// The unit of lengths of the drawing.
    pub(super) fn unit(&self) -> LengthUnit {
        self.drawing.unit
    }

    /// The attachments of a section, in the order of the drawing.
    pub(super) fn attached(&self, section: Section) -> impl Iterator<Item = &'a Attachment> {
        self.attachments.iter().filter(move |attachment| attachment.kind.section == section)
    }
}

/// Lengths within which points are one, and the digits that numbers are written with.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Scale {
    /// Points nearer than this are taken as one, drawing units.
    pub(super) tolerance: f64,
    /// Points nearer than this are one but for rounding, drawing units.
    pub(super) rounding: f64,
    /// Polygons for pictures keep to their curves within this, drawing units.
    pub(super) picture_tolerance: f64,
    decimals: usize,
    picture_decimals: usize,
}

impl Scale {
    /// Of a drawing between two corners; the tolerance may be given.
    pub(super) fn of([low, high]: [Point; 2], tolerance: Option<f64>) -> Self {
        let size = (high[0] - low[0]).hypot(high[1] - low[1]);
        let reach = size.max(low[0].abs()).max(low[1].abs()).max(high[0].abs()).max(high[1].abs());
        // The last decimal that a number of the size of the drawing has; none has, of size zero.
        let decimals = |digits: i32| {
            let has_digits = |n: &i32| reach * 10_f64.powi(*n) >= 10_f64.powi(digits);
            let last = (0..MAX_DECIMALS).find(has_digits).unwrap_or(0);
            usize::try_from(last).expect("decimals are counted from zero")
        };
        Self {
            tolerance: tolerance.unwrap_or(RELATIVE_TOLERANCE * size),
            rounding: reach * RELATIVE_ROUNDING,
            picture_tolerance: size * PICTURE_TOLERANCE,
            decimals: decimals(DIGITS),
            picture_decimals: decimals(PICTURE_DIGITS),
        }
    }

    /// A point without what rounding left beyond the digits of the drawing.
    pub(super) fn tidy(&self, point: Point) -> Point {
        point.map(|x| rounded(x, self.decimals))
    }

    /// A length without what rounding left beyond the digits of the drawing.
    pub(super) fn tidy_length(&self, length: f64) -> f64 {
        rounded(length, self.decimals)
    }

    /// A point for pictures.
    pub(super) fn coarse(&self, point: Point) -> Point {
        point.map(|x| rounded(x, self.picture_decimals))
    }
}

fn rounded(x: f64, decimals: usize) -> f64 {
    let text = format!("{x:.decimals$}");
    let rounded: f64 = text.parse().expect("a printed number can be read");
    // Adding zero turns a negative zero into a plain one.
    rounded + 0.0
}
