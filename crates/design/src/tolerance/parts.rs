//! [`Part`]: a parameter with its limits, and how its values lie between them.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::base::Quantity;

/// How values lie between limits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Spread {
    Uniform,
    Normal,
    Triangular,
}

impl Spread {
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "uniform" => Some(Self::Uniform),
            "normal" => Some(Self::Normal),
            "triangular" => Some(Self::Triangular),
            _ => None,
        }
    }

    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Normal => "normal",
            Self::Triangular => "triangular",
        }
    }

    /// Standard deviation in parts of the limit.
    pub(super) fn sigma(self) -> f64 {
        match self {
            Self::Uniform => 1.0 / 3f64.sqrt(),
            Self::Normal => 1.0 / 3.0,
            Self::Triangular => 1.0 / 6f64.sqrt(),
        }
    }

    pub(super) fn sample(self, rng: &mut Pcg64Mcg) -> f64 {
        match self {
            Self::Uniform => 2.0 * rng.random::<f64>() - 1.0,
            Self::Triangular => rng.random::<f64>() - rng.random::<f64>(),
            // Box and Muller.
            Self::Normal => {
                let u = 1.0 - rng.random::<f64>();
                let v: f64 = rng.random();
                (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos() / 3.0
            }
        }
    }
}

/// A parameter with its limits.
pub(super) struct Part {
    pub(super) name: String,
    pub(super) unit: String,
    /// Place among the parameters of the model.
    pub(super) place: usize,
    pub(super) nominal: f64,
    pub(super) limits: [f64; 2],
    pub(super) spread: Spread,
}

impl Part {
    pub(super) fn half(&self) -> f64 {
        0.5 * (self.limits[1] - self.limits[0])
    }

    pub(super) fn middle(&self) -> f64 {
        self.nominal + 0.5 * (self.limits[0] + self.limits[1])
    }
}

/// Limits such as `±0.1 mm`, `+-0.1 mm`, `0.1 mm`, `+0.2/-0.1 mm`, `+0.02/+0.01 mm` or `0/-0.02 mm`.
pub(super) fn limits_of(text: &str) -> Option<([f64; 2], Quantity)> {
    let text = text.trim();
    let symmetric = ["±", "+-", "+/-"].into_iter().find_map(|sign| text.strip_prefix(sign));
    if let Some(one) =
        symmetric.or((!text.starts_with(['+', '-']) && !text.contains('/')).then_some(text))
    {
        let limit = Quantity::read(one)?;
        return (limit.value > 0.0).then(|| ([-limit.value, limit.value], limit));
    }
    let (upper, lower) = text.split_once('/')?;
    let lower = Quantity::read(lower)?;
    let with_unit = if upper.trim().parse::<f64>().is_ok() {
        format!("{upper} {}", lower.unit)
    } else {
        upper.to_owned()
    };
    let upper = Quantity::read(&with_unit)?;
    (lower.value < upper.value).then_some(([lower.value, upper.value], lower))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_in_all_their_forms() {
        let of = |text: &str| limits_of(text).map(|(limits, _)| limits.map(|x| (x * 1e6).round()));
        assert_eq!(of("±0.1 mm"), Some([-100.0, 100.0]));
        assert_eq!(of("+-0.1 mm"), Some([-100.0, 100.0]));
        assert_eq!(of("0.1 mm"), Some([-100.0, 100.0]));
        assert_eq!(of("+0.2/-0.1 mm"), Some([-100.0, 200.0]));
        assert_eq!(of("0/-20 um"), Some([-20.0, 0.0]));
        assert_eq!(of("-0.1/+0.1 mm"), None, "the upper one comes first");
        assert_eq!(of("much"), None);
    }
}
