//! Mass, centre of mass and moment of inertia of each body: stated, or those of a plate.
//!
//! A stated mass comes before a computed one; what else is not stated is that of a uniform plate of this
//! mass in the shape of the outline.

use bksim_model::diagnostic::Diagnostic;

use super::bodies::{Bodies, Body};
use super::faults::Faults;
use super::frame::Frame;
use super::report::MassSource;
use super::units::{BareUnits, Quantity};
use crate::attachment::Value;
use crate::codes;
use crate::drawing::LengthUnit;
use crate::geometry::Point;
use crate::mass::AreaProperties;

/// The mass properties of a body, as texts of a model file.
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

/// Units of plates, and what is known of those that say nothing.
#[derive(Clone, Copy)]
pub(super) struct Plate<'a> {
    pub(super) unit: LengthUnit,
    pub(super) units: &'a BareUnits,
    /// Density and thickness of bodies that state none.
    pub(super) default: [Option<&'a str>; 2],
    /// True if every body must have a mass.
    pub(super) needs_masses: bool,
}

/// The mass properties of every body but the ground; a fault for each that has no mass.
pub(super) fn weigh(
    bodies: &Bodies,
    frames: &[Frame],
    plate: Plate<'_>,
    faults: &mut Faults<'_>,
) -> Vec<Weight> {
    let but_ground = bodies.list.iter().zip(frames).skip(1);
    but_ground.map(|(body, frame)| weight(body, frame, plate, faults)).collect()
}

fn weight(body: &Body, frame: &Frame, plate: Plate<'_>, faults: &mut Faults<'_>) -> Weight {
    let area = body.outline.as_ref().and_then(|outline| AreaProperties::of(outline).ok());
    let (mass, source) = match mass(body, area.as_ref(), plate, faults) {
        Some((mass, source)) => (Some(mass), source),
        None => (None, MassSource::Missing),
    };
    let centroid = area.as_ref().map(|area| area.centroid);
    let centre = body.centre.or(centroid).unwrap_or(frame.origin);
    // Of a mass that is stated alone, the rest is that of a plate with this mass.
    let inertia = match (&area, &mass, body.value("inertia")) {
        (Some(area), Some(mass), None) => {
            let metres = plate.unit.metres;
            let gyration_squared = area.polar / area.area * metres * metres;
            Some(format!("{}*({gyration_squared} m^2)", factor(mass)))
        }
        _ => None,
    };
    Weight { mass, source, inertia, centre, area }
}

/// The mass of a body, stated or computed; a fault if it has none.
fn mass(
    body: &Body,
    area: Option<&AreaProperties>,
    plate: Plate<'_>,
    faults: &mut Faults<'_>,
) -> Option<(String, MassSource)> {
    if let Some(value) = body.value("mass") {
        return Some((plate.units.text(value, Quantity::Mass), MassSource::Stated));
    }
    let [density, thickness] = ["density", "thickness"].map(|key| body.value(key));
    let text = |value: Option<&Value>, quantity: Quantity, default: Option<&str>| {
        value.map(|value| plate.units.text(value, quantity)).or(default.map(str::to_owned))
    };
    let texts = [
        text(density, Quantity::Density, plate.default[0]),
        text(thickness, Quantity::DrawnLength, plate.default[1]),
    ];
    match (texts, area) {
        ([Some(density), Some(thickness)], Some(area)) => {
            let metres = plate.unit.metres;
            let area = area.area * metres * metres;
            let mass = format!("{}*{}*({area} m^2)", factor(&density), factor(&thickness));
            Some((mass, MassSource::Computed))
        }
        ([Some(_), Some(_)], None) => {
            // One mistake, one message.
            if plate.needs_masses && !body.has_bad_outline {
                add_shapeless(body, density, faults);
            }
            None
        }
        _ => {
            if plate.needs_masses {
                add_massless(body, density.or(thickness), faults);
            }
            None
        }
    }
}

fn add_shapeless(body: &Body, density: Option<&Value>, faults: &mut Faults<'_>) {
    let message = format!("body `{}` has a density but no closed outline", body.name);
    let help = "close its outline (ends must meet within the tolerance), or state its mass with \
                the attribute MASS";
    let fault = Diagnostic::error(codes::NO_MASS, message).help(help);
    faults.add(fault, density.map_or(body.location(), |value| &value.location));
}

/// Adds the fault of a body without mass that may state a half of it, its density or its thickness.
fn add_massless(body: &Body, half: Option<&Value>, faults: &mut Faults<'_>) {
    let name = &body.name;
    let (message, help) = if let Some(key) = half.map(|value| value.key) {
        let other = if key == "density" { "thickness" } else { "density" };
        let message = format!("body `{name}` has a {key} but no {other}");
        (message, format!("state its {other}, too, or its mass"))
    } else {
        let help = format!(
            "put BK_BODY with MASS, or DENSITY and THICKNESS, inside of it, or state `mass` in \
             `[bodies.{name}]` of a model file beside"
        );
        (format!("body `{name}` has no mass"), help)
    };
    let fault = Diagnostic::error(codes::NO_MASS, message).help(help);
    faults.add(fault, half.map_or(body.location(), |value| &value.location));
}

/// A text that may be multiplied.
pub(super) fn factor(text: &str) -> String {
    format!("({text})")
}
