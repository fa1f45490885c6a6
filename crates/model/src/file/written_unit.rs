//! A unit as it stands after a number: `mm`, `N m/rad`.

use bksim_expr::{ParseOptions, SyntaxKind, UnitFactor, parse};

use super::dimension::Dimension;
use super::units::{Scale, find_unit};

/// No quantity of mechanics has a higher power of a unit.
pub(super) const MAX_UNIT_EXPONENT: i32 = 12;

/// A product of powers of units.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WrittenUnit {
    pub(super) scale: Scale,
    pub(super) dimension: Dimension,
    pub(super) is_angle: bool,
}

impl WrittenUnit {
    /// The unit of this text; `None` when it is none.
    ///
    /// ```
    /// use bksim_model::file::WrittenUnit;
    ///
    /// let unit = WrittenUnit::parse("N mm").expect("a unit");
    /// assert_eq!(unit.to_si(250.0), 0.25);
    /// assert_eq!(WrittenUnit::parse("quux"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Self> {
        // As dimensions are printed: `V/(A s)`.
        let parts = text.trim_end().strip_suffix(')').and_then(|rest| rest.split_once("/("));
        let text = parts.map_or_else(
            || text.to_owned(),
            |(over, under)| {
                format!("{over}/{}", under.split_whitespace().collect::<Vec<_>>().join("/"))
            },
        );
        let is_unit = |name: &str| find_unit(name).is_some();
        let options = ParseOptions { max_depth: 1, is_unit: &is_unit, ..ParseOptions::default() };
        let syntax = parse(&format!("1 {text}"), &options).ok()?;
        match syntax.nodes.as_slice() {
            [node] => match &node.kind {
                SyntaxKind::Quantity { factors, .. } => Self::of(factors),
                _ => None,
            },
            _ => None,
        }
    }

    /// The unit that these factors are; `None` where one is unknown or has an exponent that no quantity has.
    pub fn of(factors: &[UnitFactor]) -> Option<Self> {
        let mut whole = Self { scale: Scale::ONE, dimension: Dimension::NONE, is_angle: true };
        for factor in factors {
            let unit = find_unit(&factor.name)?;
            let exponent = factor.exponent;
            if exponent.abs() > MAX_UNIT_EXPONENT {
                return None;
            }
            whole.scale = whole.scale.times(unit.scale.powi(exponent));
            let power = unit.dimension.power(f64::from(exponent))?;
            whole.dimension = whole.dimension.times(power);
            whole.is_angle &= unit.is_angle;
        }
        Some(whole)
    }

    /// A number in this unit in SI, as the reader of model files converts it.
    pub fn to_si(&self, number: f64) -> f64 {
        self.scale.apply(number)
    }

    /// The noun for what is measured in it, where there is one: `length`, `angle`.
    pub fn noun(&self) -> Option<&'static str> {
        let is_angle = self.is_angle && self.dimension == Dimension::NONE;
        if is_angle { Some("angle") } else { self.dimension.noun() }
    }

    /// The unit of pure numbers.
    pub const PURE: Self = Self { scale: Scale::ONE, dimension: Dimension::NONE, is_angle: false };

    /// True where both measure the same kind of quantity, an angle being a pure number.
    pub fn is_alike(&self, other: &Self) -> bool {
        self.dimension == other.dimension
    }

    /// The SI unit of products of quantities in these units.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        Self {
            scale: Scale::ONE,
            dimension: self.dimension.times(other.dimension),
            is_angle: self.is_angle != other.is_angle,
        }
    }

    /// The SI unit of powers; `None` where their exponents are no simple fractions.
    pub fn power(&self, exponent: f64) -> Option<Self> {
        let is_angle = self.is_angle && exponent == 1.0;
        Some(Self { scale: Scale::ONE, dimension: self.dimension.power(exponent)?, is_angle })
    }

    /// Exponents of kilogram, metre, second and ampere; `None` where they are not whole.
    pub fn exponents(&self) -> Option<[i64; 4]> {
        self.dimension.whole()
    }

    /// The SI unit of the same quantity, as text.
    pub fn si(&self) -> String {
        let unit = self.dimension.to_string();
        if unit.is_empty() && self.is_angle { "rad".to_owned() } else { unit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_products_and_powers_are_si() {
        let unit = |text| WrittenUnit::parse(text).expect("a unit");
        assert_eq!(unit("kN").times(&unit("mm")).si(), "N m");
        assert_eq!(unit("mm^2").power(0.5).map(|unit| unit.si()).as_deref(), Some("m"));
        assert_eq!(unit("deg").times(&WrittenUnit::PURE).si(), "rad");
        assert_eq!(unit("m").power(0.123), None);
        assert!(unit("deg").is_alike(&WrittenUnit::PURE) && !unit("N").is_alike(&unit("m")));
    }

    #[test]
    fn a_space_between_units_multiplies() {
        let same = [
            ("kg m^2", "kg*m^2"),
            ("N m/rad", "N*m/rad"),
            ("N  s", "N*s"),
            ("m^2 kg", "m^2*kg"),
            ("m² kg", "m^2*kg"),
            ("m s⁻¹", "m/s"),
            ("N·m", "N m"),
            ("µm m", "µm*m"),
        ];
        for (text, expected) in same {
            let unit = WrittenUnit::parse(text);
            assert!(unit.is_some() && unit == WrittenUnit::parse(expected), "{text}");
        }
        for wrong in ["", "N min (3)", "quux", "m + s", "m^s", "N s)"] {
            assert_eq!(WrittenUnit::parse(wrong), None, "{wrong}");
        }
    }
}
