//! A unit as it stands behind a number: `mm`, `N m/rad`.

use bksim_expr::{ParseOptions, SyntaxKind, UnitFactor, parse};

use super::lower::MAX_UNIT_EXPONENT;
use super::quantity::join_units;
use super::units::{Dimension, Scale, find_unit};

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
    /// use crate::file::WrittenUnit;
    ///
    /// let unit = WrittenUnit::parse("N mm").expect("a unit");
    /// assert_eq!(unit.to_si(250.0), 0.25);
    /// assert_eq!(WrittenUnit::parse("quux"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Self> {
        let text = join_units(&format!("1 {text}"));
        let is_unit = |name: &str| find_unit(name).is_some();
        let options = ParseOptions { max_depth: 1, is_unit: &is_unit, is_name: &|_| false };
        let syntax = parse(&text, &options).ok()?;
        match syntax.nodes.as_slice() {
            [node] => match &node.kind {
                SyntaxKind::Quantity { factors, .. } => Self::of(factors),
                _ => None,
            },
            _ => None,
        }
    }

    /// The unit that these factors are.
    pub(super) fn of(factors: &[UnitFactor]) -> Option<Self> {
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

    /// The SI unit of the same quantity, as text.
    pub fn si(&self) -> String {
        let unit = self.dimension.to_string();
        if unit.is_empty() && self.is_angle { "rad".to_owned() } else { unit }
    }
}
