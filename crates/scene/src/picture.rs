//! [`Picture`]: regions, lines and words in pixels, the last on top.

use serde::Serialize;

use crate::Color;

/// The picture of one instant.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Picture {
    /// Width and height, pixels.
    pub size: [f32; 2],
    /// Colour of the background; transparent if none.
    pub background: Option<Color>,
    /// In painter's order: the last is on top.
    pub items: Vec<Item>,
}

/// A line's colour and width in pixels.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Stroke {
    /// Colour of the stroke.
    pub color: Color,
    /// Width of the stroke, pixels.
    pub width: f32,
}

/// Alignment of a text along its baseline.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
pub enum Align {
    /// It begins at its position.
    Start,
    /// It is centred at its position.
    Middle,
    /// It ends at its position.
    End,
}

/// One element of a picture; positions are pixels from the upper left corner.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub enum Item {
    /// An area bounded by closed rings, filled by the even–odd rule.
    Region {
        /// The rings.
        rings: Vec<Vec<[f32; 2]>>,
        /// Colour of the filling.
        fill: Color,
    },
    /// A line through points, with round joins and ends.
    Line {
        /// The points.
        points: Vec<[f32; 2]>,
        /// True if the last is joined to the first.
        is_closed: bool,
        /// Colour and width of the line.
        stroke: Stroke,
    },
    /// A line of words.
    Text {
        /// A point of its baseline.
        at: [f32; 2],
        /// The part of the text that lies at that point.
        align: Align,
        /// The words.
        text: String,
        /// Height of the letters, pixels.
        size: f32,
        /// Their colour.
        color: Color,
    },
}
