//! Mass, centre of mass and moment of inertia of each body: stated, or those of a plate.
//!
//! A stated mass comes before a computed one; what is not stated besides is that of a uniform plate of
//! this mass in the shape of the outline.

use bksim_mbs::diagnostic::Diagnostic;

use super::part::{Part, find, text_of};
use super::{Composer, MassSource};
use crate::attachment::{Content, Value};
use crate::codes;
use crate::geometry::Point;
use crate::kind::Section;
use crate::mass::AreaProperties;

/// What a body weighs, as texts of a model file.
#[derive(Clone, Debug)]
pub(super) struct Weight {
    /// `None` where nothing says it.
    pub(super) mass: Option<String>,
    pub(super) source: MassSource,
    /// Moment about the centre of mass, unless it is stated itself.
    pub(super) inertia: Option<String>,
    /// Centre of mass in world axes.
    pub(super) centre: Point,
    /// Areas and moments of the outline, drawing units.
    pub(super) area: Option<AreaProperties>,
}

impl Composer<'_> {
    /// The mass properties of a body; a fault if it has no mass.
    pub(super) fn weigh(&mut self, part_idx: usize) -> Weight {
        let part = &self.parts[part_idx];
        let area = part.outline.as_ref().and_then(|outline| AreaProperties::of(outline).ok());
        let mass = self.mass(part_idx, area.as_ref());
        let part = &self.parts[part_idx];
        let frame = part.frame.unwrap_or_default();
        let centroid = area.as_ref().map(|area| area.centroid);
        let centre = part.centre.or(centroid).unwrap_or(frame.origin);
        // Of a mass that is stated alone, the rest is that of a plate with this mass.
        let inertia = match (&area, &mass, part.value("inertia")) {
            (Some(area), Some((mass, _)), None) => {
                let metres = self.drawing.unit.metres;
                let gyration_squared = area.polar / area.area * metres * metres;
                Some(format!("{}*({gyration_squared} m^2)", factor(mass)))
            }
            _ => None,
        };
        let (mass, source) = match mass {
            Some((mass, source)) => (Some(mass), source),
            None => (None, MassSource::Missing),
        };
        Weight { mass, source, inertia, centre, area }
    }

    fn mass(
        &mut self,
        part_idx: usize,
        area: Option<&AreaProperties>,
    ) -> Option<(String, MassSource)> {
        let part = &self.parts[part_idx];
        if let Some(value) = part.value("mass") {
            return Some((self.text(value, "kg"), MassSource::Stated));
        }
        let [density, thickness] = ["density", "thickness"].map(|key| part.value(key).cloned());
        let default = |text: Option<&str>| text.map(str::to_owned);
        let texts = [
            density.as_ref().map(|value| self.text(value, "kg/m^3")).or(default(self.plate[0])),
            thickness
                .as_ref()
                .map(|value| self.text(value, self.drawing.unit.name))
                .or(default(self.plate[1])),
        ];
        match (texts, area) {
            ([Some(density_text), Some(thickness)], Some(area)) => {
                let metres = self.drawing.unit.metres;
                let area = area.area * metres * metres;
                let mass = format!("{}*{}*({area} m^2)", factor(&density_text), factor(&thickness));
                Some((mass, MassSource::Computed))
            }
            ([Some(_), Some(_)], None) => {
                // One mistake, one message.
                if !self.parts[part_idx].has_bad_outline {
                    self.shapeless(part_idx, density.as_ref());
                }
                None
            }
            _ => {
                self.massless(part_idx, density.or(thickness).as_ref());
                None
            }
        }
    }

    fn shapeless(&mut self, part_idx: usize, density: Option<&Value>) {
        let part = &self.parts[part_idx];
        let location =
            density.map(|value| value.location.clone()).or_else(|| part.location.clone());
        let message = format!("body `{}` has a density but no closed outline", part.name);
        let help = "close its outline (ends must meet within the tolerance), or state its mass \
                    with the attribute MASS";
        let fault = Diagnostic::error(codes::NO_MASS, message).help(help);
        match location {
            Some(location) => self.fault(fault, &location),
            None => self.faults.push(fault),
        }
    }

    fn massless(&mut self, part_idx: usize, half: Option<&Value>) {
        let part = &self.parts[part_idx];
        let name = &part.name;
        let (message, help) = if let Some(key) = half.map(|value| value.key) {
            let other = if key == "density" { "thickness" } else { "density" };
            let message = format!("body `{name}` has a {key} but no {other}");
            (message, format!("state its {other}, too, or its mass"))
        } else {
            let help = format!(
                "put BK_BODY with MASS, or DENSITY and THICKNESS, inside of it, or state `mass` \
                 in `[bodies.{name}]` of a model file beside"
            );
            (format!("body `{name}` has no mass"), help)
        };
        let location = half.map(|value| value.location.clone()).or_else(|| part.location.clone());
        let fault = Diagnostic::error(codes::NO_MASS, message).help(help);
        match location {
            Some(location) => self.fault(fault, &location),
            None => self.faults.push(fault),
        }
    }

    /// What a bare number means that in SI were in `unit`: the model may have units of its own.
    fn bare_unit(&self, unit: &str) -> String {
        let model = self.attachments.iter().filter(|it| it.kind.section == Section::Model);
        let stated = |key: &str, si: &str| {
            let beside = self.side.unit(key);
            let drawn = || model.clone().find_map(|it| text_of(it, key)).map(str::to_owned);
            beside.or_else(drawn).unwrap_or_else(|| si.to_owned())
        };
        match unit {
            "kg" => stated("mass", "kg"),
            "kg/m^3" => format!("{}/{}^3", stated("mass", "kg"), stated("length", "m")),
            "m/s^2" => format!("{}/{}^2", stated("length", "m"), stated("time", "s")),
            "N" => stated("force", "N"),
            drawn => drawn.to_owned(),
        }
    }

    /// A value as the text of a model file; a bare number is in `unit`, or what the model has in its
    /// location.
    pub(super) fn text(&self, value: &Value, unit: &str) -> String {
        let unit = &self.bare_unit(unit);
        match &value.content {
            Content::Text(text) if text.parse::<f64>().is_ok() && !unit.is_empty() => {
                format!("{text} {unit}")
            }
            Content::Text(text) => text.clone(),
            Content::Number(number) if !unit.is_empty() => format!("{number} {unit}"),
            Content::Number(number) => number.to_string(),
            Content::Length(length) => format!("{length} {}", self.drawing.unit.name),
            Content::Entity(_) => String::new(),
        }
    }
}

impl Part {
    /// The point about which the inertia is stated.
    pub(super) fn about(&self) -> Option<&Value> {
        find(&self.values, "about")
    }
}

/// A text that may be multiplied.
pub(super) fn factor(text: &str) -> String {
    format!("({text})")
}
