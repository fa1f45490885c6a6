//! Loads that can be solved but are hardly meant: warnings, with the numbers.

use super::bodies::VectorValue;
use super::codes;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::units::Quantity;
use super::value::Scalar;
use crate::diagnostic::{Diagnostic, Span};
use crate::message::short;

/// The acceleration of free fall on Earth lies in this range, m/s².
const EARTH: std::ops::Range<f64> = 9.7..9.9;

/// Units of length that are mixed up with metres, m.
const MIXED_UP: [(&str, f64); 4] = [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("ft", 0.3048)];

/// Foams have 20 kg/m³ and more; what bodies of machines are made of has between 0.5 and 25 g/cm³.
const LIGHTEST: f64 = 20.0;

impl Reader<'_> {
    /// A density without a unit whose number is that of a solid in g/cm³.
    pub(super) fn check_density(&mut self, what: &str, density: f64, span: &Span) {
        if !(0.5..=LIGHTEST).contains(&density) {
            return;
        }
        let message = format!("{what} is {} kg/m^3, less than that of foam", short(density));
        let written = short(density);
        self.report(
            Diagnostic::warning(codes::IMPLAUSIBLE_SIZE, message)
                .at(span.clone(), "without a unit it is in the units of the file")
                .help(format!(
                    "write \"{written} g/cm^3\", or \"{written} kg/m^3\" if it is right"
                )),
        );
    }

    fn hardly_meant(&mut self, message: String, span: Span, label: &str, help: String) {
        self.report(
            Diagnostic::warning(codes::IMPLAUSIBLE_LOAD, message).at(span, label).help(help),
        );
    }

    /// Gravity whose number is that of the Earth in another unit of length.
    pub(super) fn check_gravity(&mut self, what: &str, vector: &VectorValue) {
        let Some(position) = vector.position.as_ref().filter(|position| position.is_bare) else {
            return;
        };
        let size = position.numbers().iter().map(|x| x * x).sum::<f64>().sqrt();
        for (unit, metres) in MIXED_UP {
            for (found, meant) in [(size / metres, "m"), (size * metres, unit)] {
                if EARTH.contains(&found) {
                    let message = format!("{what} is {} m/s^2", short(size));
                    let factor = if meant == "m" { 1.0 / metres } else { 1.0 };
                    let entries = position.numbers().map(|x| match x {
                        0.0 => "0".to_owned(),
                        x => format!("\"{} {meant}/s^2\"", short(x * factor)),
                    });
                    let n = if position.numbers()[2] == 0.0 { 2 } else { 3 };
                    let help = format!(
                        "write [{}] if the gravity of the Earth is meant",
                        entries[..n].join(", ")
                    );
                    let label = "without a unit these numbers are in the units of the file";
                    return self.hardly_meant(message, vector.span.clone(), label, help);
                }
            }
        }
    }

    /// A load that puts no force on anything that moves.
    pub(super) fn without_effect(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        label: &str,
        help: &str,
    ) {
        let span = fields.get(key).map_or(fields.span.clone(), |node| node.span.clone());
        let message = format!("{} has no effect on the motion", fields.owner);
        self.hardly_meant(message, span, label, help.to_owned());
    }

    /// An unloaded length below zero pulls even where the ends meet.
    pub(super) fn check_free_length(&mut self, what: &str, length: &Scalar) {
        if let Some(value) = length.value.map(Constant::look).filter(|value| *value < 0.0) {
            let message = format!("{what} is {} m", short(value));
            let help = format!(
                "write \"{} m\", or 0 for a spring that pulls its ends together",
                short(-value)
            );
            self.hardly_meant(message, length.span.clone(), "no spring is so short", help);
        }
    }

    /// A stiffness below zero pushes away from the unloaded shape.
    pub(super) fn check_stiffness(&mut self, what: &str, stiffness: &Scalar, quantity: Quantity) {
        if let Some(value) = stiffness.value.map(Constant::look).filter(|value| *value < 0.0) {
            let unit = quantity.dimension();
            let message = format!("{what} is {} {unit}", short(value));
            let help = format!("write \"{} {unit}\" if it should draw back", short(-value));
            let label = "a negative stiffness drives away from the unloaded shape";
            self.hardly_meant(message, stiffness.span.clone(), label, help);
        }
    }

    /// Static friction is never less than that of sliding.
    pub(super) fn check_static_friction(
        &mut self,
        fields: &Fields<'_>,
        [sliding, sticking]: [&Scalar; 2],
        quantity: Quantity,
    ) {
        let (Some(slides), Some(sticks)) = (sliding.value, sticking.value) else { return };
        let (slides, sticks) = (slides.look(), sticks.look());
        if sticks >= slides || sticks < 0.0 {
            return;
        }
        let with_unit =
            |value: f64| format!("{} {}", short(value), quantity.dimension()).trim_end().to_owned();
        let message = format!(
            "{} is {}, less than the {} of sliding",
            fields.what("static"),
            with_unit(sticks),
            with_unit(slides)
        );
        let help = format!("write \"{}\" or more, or leave `static` out", with_unit(slides));
        let label = "no surface holds with less than it rubs";
        self.hardly_meant(message, sticking.span.clone(), label, help);
    }
}
