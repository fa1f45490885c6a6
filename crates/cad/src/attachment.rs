//! [`Attachment`]: one thing attached to a drawing, the same whichever way it was written.

use crate::drawing::{Handle, Location};
use crate::geometry::Point;
use crate::kind::{Kind, Section};

/// One thing attached to the drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct Attachment {
    /// Kind of the attachment.
    pub kind: &'static Kind,
    /// Index of the entity it is attached to, in [`crate::drawing::Drawing::entities`].
    pub entity_idx: usize,
    /// Type and position of that entity.
    pub location: Location,
    /// How it is attached.
    pub way: Way,
    /// Stated values; empty ones are left out.
    pub values: Vec<Value>,
    /// Point of the attachment, where it has one; drawing units.
    pub at: Option<Point>,
    /// Direction of the attachment, of any length.
    pub axis: Option<Point>,
    /// Second point of the attachment.
    pub to: Option<Point>,
}

impl Attachment {
    /// The stated value of a key.
    pub fn value(&self, key: &str) -> Option<&Value> {
        find(&self.values, key)
    }

    /// The text of a key, where it has one.
    pub fn text(&self, key: &str) -> Option<&str> {
        match &self.value(key)?.content {
            Content::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Kind and name, for messages: ``joint `B` ``.
    pub(crate) fn title(&self) -> String {
        let kind = match self.kind.section {
            Section::Joints => "joint",
            Section::Points => "point",
            _ => self.kind.name,
        };
        match self.text("name") {
            Some(name) => format!("{kind} `{name}`"),
            None => kind.to_owned(),
        }
    }
}

/// The value of a key in a list.
pub(crate) fn find<'v>(values: &'v [Value], key: &str) -> Option<&'v Value> {
    values.iter().find(|value| value.key == key)
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
    /// Key as in [`Kind::keys`].
    pub key: &'static str,
    /// The value.
    pub content: Content,
    /// Where it is stated.
    pub location: Location,
}

/// The content of a value.
#[derive(Clone, PartialEq, Debug)]
pub enum Content {
    /// Text as written: a name, a quantity or an expression.
    Text(String),
    /// A number in SI.
    Number(f64),
    /// A length in drawing units.
    Length(f64),
    /// An entity; stands for the body it belongs to.
    Entity(Handle),
}
