//! [`Attachment`]: what is attached to a drawing, the same whichever way it was written.

use crate::drawing::{Handle, Location};
use crate::geometry::Point;
use crate::kind::Kind;

/// One thing attached to the drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct Attachment {
    /// What it is.
    pub kind: &'static Kind,
    /// Number of the entity it is attached to, in [`crate::drawing::Drawing::entities`].
    pub entity_idx: usize,
    /// Type and position of that entity.
    pub location: Location,
    /// How it is attached.
    pub way: Way,
    /// Stated values; empty ones are left out.
    pub values: Vec<Value>,
    /// Its point, where it has one; drawing units.
    pub at: Option<Point>,
    /// Its direction, of any length.
    pub axis: Option<Point>,
    /// Its second point.
    pub to: Option<Point>,
}

/// How something is attached.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Way {
    /// Extended data; the number of the record on its entity.
    Xdata(usize),
    /// An insert of a block with attributes.
    Block,
    /// By its layer.
    Layer,
}

/// A key and its value.
#[derive(Clone, PartialEq, Debug)]
pub struct Value {
    /// As in [`Kind::keys`].
    pub key: &'static str,
    /// What it says.
    pub content: Content,
    /// What it stands in.
    pub location: Location,
}

/// What a value says.
#[derive(Clone, PartialEq, Debug)]
pub enum Content {
    /// As written: a name, a quantity or an expression.
    Text(String),
    /// A number in SI.
    Number(f64),
    /// A length in drawing units.
    Length(f64),
    /// An entity; stands for the body it belongs to.
    Entity(Handle),
}
