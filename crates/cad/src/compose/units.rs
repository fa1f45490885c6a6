//! Values of the drawing as texts of a model file, where a bare number needs its unit.

use super::sidecar::Sidecar;
use super::source::Source;
use crate::attachment::{Content, Value};
use crate::kind::Section;

/// The quantities that a bare number of the drawing may mean.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Quantity {
    Mass,
    Density,
    Acceleration,
    Force,
    /// A length of the drawing, in its unit whatever the model's is.
    DrawnLength,
}

/// The units of bare numbers: the model may have units of its own, in the sidecar or in the drawing.
#[derive(Clone, Debug)]
pub(super) struct BareUnits {
    drawing: &'static str,
    length: String,
    mass: String,
    time: String,
    force: String,
}

impl BareUnits {
    /// Of a drawing with its sidecar; SI where neither states a unit.
    pub(super) fn of(source: Source<'_>, sidecar: &Sidecar) -> Self {
        let drawn = |key: &str| {
            let mut models = source.attached(Section::Model);
            models.find_map(|model| model.text(key)).map(str::to_owned)
        };
        let stated = |key: &str, si: &str| {
            sidecar.unit(key).or_else(|| drawn(key)).unwrap_or_else(|| si.to_owned())
        };
        Self {
            drawing: source.unit().name,
            length: stated("length", "m"),
            mass: stated("mass", "kg"),
            time: stated("time", "s"),
            force: stated("force", "N"),
        }
    }

    fn unit(&self, quantity: Quantity) -> String {
        let Self { drawing, length, mass, time, force } = self;
        match quantity {
            Quantity::Mass => mass.clone(),
            Quantity::Density => format!("{mass}/{length}^3"),
            Quantity::Acceleration => format!("{length}/{time}^2"),
            Quantity::Force => force.clone(),
            Quantity::DrawnLength => (*drawing).to_owned(),
        }
    }

    /// A value as the text of a model file; a bare number is in the unit of the quantity.
    pub(super) fn text(&self, value: &Value, quantity: Quantity) -> String {
        let unit = self.unit(quantity);
        match &value.content {
            Content::Text(text) if text.parse::<f64>().is_ok() && !unit.is_empty() => {
                format!("{text} {unit}")
            }
            Content::Text(text) => text.clone(),
            Content::Number(number) if !unit.is_empty() => format!("{number} {unit}"),
            Content::Number(number) => number.to_string(),
            Content::Length(length) => format!("{length} {}", self.drawing),
            // No quantity: the reader of models refuses the empty text.
            Content::Entity(_) => String::new(),
        }
    }
}
