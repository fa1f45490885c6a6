//! Units of the parts of outputs.

use bksim::model::file::WrittenUnit;

/// The unit of a part.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Unit {
    /// That of bare numbers, which go with any.
    Bare,
    Known(WrittenUnit),
    /// That of a parameter whose value is a number without unit: in the model it may stand for any quantity.
    Unknown,
}

impl Unit {
    /// That of a channel or parameter, as its text says.
    pub(super) fn of(text: &str) -> Self {
        Self::Known(WrittenUnit::parse(text).unwrap_or(WrittenUnit::PURE))
    }

    /// False of what is known to be no pure number.
    pub(super) fn is_pure(self) -> bool {
        !matches!(self, Self::Known(unit) if !unit.is_alike(&WrittenUnit::PURE))
    }

    /// Of a power; `None` where its exponents are no simple fractions.
    pub(super) fn power(self, exponent: f64) -> Option<Self> {
        match self {
            Self::Known(unit) => unit.power(exponent).map(Self::Known),
            other => Some(other),
        }
    }

    /// Unit as those of channels are written.
    pub(super) fn text(self) -> String {
        match self {
            Self::Known(unit) => unit.si().replace(' ', "*"),
            Self::Bare | Self::Unknown => String::new(),
        }
    }
}

/// The unit of a sum.
pub(super) fn either([a, b]: [Unit; 2]) -> Unit {
    match (a, b) {
        (Unit::Known(_), _) | (_, Unit::Bare) => a,
        _ => b,
    }
}

/// The unit of a product.
pub(super) fn product([a, b]: [Unit; 2]) -> Unit {
    match (a, b) {
        (Unit::Unknown, _) | (_, Unit::Unknown) => Unit::Unknown,
        (Unit::Known(a), Unit::Known(b)) => Unit::Known(a.times(&b)),
        (Unit::Bare, other) | (other, Unit::Bare) => other,
    }
}
