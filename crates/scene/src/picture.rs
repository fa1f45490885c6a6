//! [`Picture`]: regions, lines and words in pixels, the last on top.

use serde::Serialize;

use crate::Color;

/// What is seen at one instant.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Picture {
    /// Width and height, pixels.
    pub size: [f32; 2],
    /// Behind everything; transparent if none.
    pub background: Option<Color>,
    /// In painter's order.
    pub items: Vec<Item>,
}

/// A line's colour and width in pixels.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Stroke {
    /// Its colour.
    pub color: Color,
    /// Its width, pixels.
    pub width: f32,
}

/// Where a text lies against its place.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
pub enum Align {
    /// It begins there.
    Start,
    /// It is centred there.
    Middle,
    /// It ends there.
    End,
}

/// One thing of a picture; places are pixels from the upper left corner.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub enum Item {
    /// An area bounded by closed rings, filled by the even–odd rule.
    Region {
        /// The rings.
        rings: Vec<Vec<[f32; 2]>>,
        /// Its colour.
        fill: Color,
    },
    /// A line through points, with round joins and ends.
    Line {
        /// The points.
        points: Vec<[f32; 2]>,
        /// Whether the last is joined to the first.
        is_closed: bool,
        /// How it is drawn.
        stroke: Stroke,
    },
    /// A line of words.
    Text {
        /// Where its baseline lies.
        at: [f32; 2],
        /// Which part of it lies there.
        align: Align,
        /// The words.
        text: String,
        /// Height of the letters, pixels.
        size: f32,
        /// Their colour.
        color: Color,
    },
}
