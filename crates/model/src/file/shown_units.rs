//! The units that a reader of results asks for: `mm, deg, rpm`.

use bksim_expr::{ParseOptions, SyntaxKind, UnitFactor, parse};

use super::units::{FileUnits, UNITS, find_unit};
use super::words::{closest, cut, suggest};
use super::written_unit::WrittenUnit;

/// Units for results, in place of those of the SI.
///
/// A unit stands for every quantity of its dimension, and as a factor in those that have none of their own: with
/// `mm` a velocity is in mm/s, with `mm, rpm` an angular velocity in rpm. An angular velocity and a frequency
/// are told apart.
///
/// ```
/// use bksim_model::file::ShownUnits;
///
/// let units = ShownUnits::parse("mm, deg, rpm").expect("units");
/// let velocity = units.of("m/s");
/// assert_eq!((velocity.unit.as_str(), velocity.of_si(0.25)), ("mm/s", 250.0));
/// assert_eq!(units.of("rad/s").unit, "rpm");
/// assert_eq!(units.of("N*m").unit, "N*mm");
/// ```
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ShownUnits {
    units: Vec<ShownUnit>,
}

/// A unit for results, and the SI unit of the same quantity in it.
#[derive(Clone, PartialEq, Debug)]
pub struct ShownUnit {
    /// Unit as written; empty of a pure number.
    pub unit: String,
    /// Size and dimension; of a pure number none.
    written: Option<(WrittenUnit, i32)>,
}

/// The factors of a unit as text, and how often an angle is among them.
fn factors(unit: &str) -> Option<(Vec<UnitFactor>, i32)> {
    let is_unit = |name: &str| find_unit(name).is_some();
    let options = ParseOptions { is_unit: &is_unit, ..ParseOptions::default() };
    // A rate is written `1/s`.
    let text = format!(
        "1 {}",
        unit.strip_prefix("1/").map_or(unit.to_owned(), |rest| format!("rad/{rest}"))
    );
    let syntax = parse(&text, &options).ok()?;
    let [node] = syntax.nodes.as_slice() else { return None };
    let SyntaxKind::Quantity { factors, .. } = &node.kind else { return None };
    let mut factors = factors.clone();
    if unit.starts_with("1/") {
        factors.remove(0);
    }
    let is_angle = |factor: &&UnitFactor| find_unit(&factor.name).is_some_and(|unit| unit.is_angle);
    let n_angles = factors.iter().filter(is_angle).map(|factor| factor.exponent).sum();
    Some((factors, n_angles))
}

impl ShownUnit {
    /// A unit by itself; `None` when the text is none.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (factors, n_angles) = factors(text)?;
        let written = WrittenUnit::of(&factors)?;
        Some(Self { unit: text.to_owned(), written: Some((written, n_angles)) })
    }

    /// A value in SI in this unit.
    pub fn of_si(&self, value: f64) -> f64 {
        match &self.written {
            None => value,
            Some((unit, _)) => {
                let scale = unit.scale;
                value * scale.down / scale.up / std::f64::consts::PI.powi(scale.pi)
            }
        }
    }

    /// A value in this unit in SI.
    pub fn to_si(&self, value: f64) -> f64 {
        match &self.written {
            None => value,
            Some((unit, _)) => {
                let scale = unit.scale;
                value * scale.up / scale.down * std::f64::consts::PI.powi(scale.pi)
            }
        }
    }

    /// True where it is a unit of the quantity whose SI unit this is.
    pub fn measures(&self, si: &str) -> bool {
        Self::parse(si).is_some_and(|own| self.is_like(&own))
    }

    /// True where both are units of one quantity; angular velocities and frequencies are two.
    fn is_like(&self, other: &Self) -> bool {
        let kind = |unit: &Self| unit.written.map(|(written, n)| (written.dimension, n));
        kind(self) == kind(other)
    }
}

impl ShownUnits {
    /// Units in a list with commas; `si` is the empty one.
    ///
    /// # Errors
    /// A sentence about the first that is no unit, with the one that was probably meant.
    pub fn parse(list: &str) -> Result<Self, String> {
        if list.trim().eq_ignore_ascii_case("si") {
            return Ok(Self::default());
        }
        let mut units = Vec::new();
        for text in list.split(',') {
            let unit = ShownUnit::parse(text).ok_or_else(|| {
                let text = text.trim();
                let known: Vec<&str> = UNITS.iter().map(|unit| unit.name).collect();
                let help = match closest(text, &known) {
                    Some(_) => suggest(text, &known),
                    None => "write units such as `mm, deg, rpm, kN`".to_owned(),
                };
                format!("`{}` is no unit: {help}", cut(text))
            })?;
            units.push(unit);
        }
        Ok(Self { units })
    }

    /// Units of the `[units]` of a model's text; of a text that states none, none.
    pub fn of_model(text: &str) -> Self {
        let table = text.parse::<toml::Table>().ok();
        let stated = table.as_ref().and_then(|table| table.get("units")?.as_table());
        let unit = |(key, _): &(&str, _)| {
            let text = stated?.get(*key)?.as_str()?;
            ShownUnit::parse(text)
        };
        Self { units: FileUnits::KEYS.iter().filter_map(unit).collect() }
    }

    /// The unit for quantities whose SI unit is this, as channels have it: `m/s`, `N*m`.
    pub fn of(&self, si: &str) -> ShownUnit {
        let plain = || ShownUnit { unit: si.to_owned(), written: None };
        let Some(own) = ShownUnit::parse(si) else { return plain() };
        if let Some(known) = self.units.iter().find(|known| known.is_like(&own)) {
            return known.clone();
        }
        let Some((factors, _)) = factors(si) else { return plain() };
        // Factor by factor, unless none of them is another one.
        let shown = |factor: &UnitFactor| {
            let base = ShownUnit::parse(&factor.name)?;
            self.units.iter().find(|known| known.is_like(&base))
        };
        if factors.iter().all(|factor| shown(factor).is_none()) {
            return plain();
        }
        let mut over: Vec<String> = Vec::new();
        let mut under: Vec<String> = Vec::new();
        for factor in &factors {
            let name = shown(factor).map_or(factor.name.as_str(), |shown| shown.unit.as_str());
            let side = if factor.exponent > 0 { &mut over } else { &mut under };
            side.push(match factor.exponent.abs() {
                1 => name.to_owned(),
                n => format!("{name}^{n}"),
            });
        }
        let mut unit = if over.is_empty() { "1".to_owned() } else { over.join("*") };
        for divisor in under {
            unit.push('/');
            unit.push_str(&divisor);
        }
        ShownUnit::parse(&unit).unwrap_or_else(plain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stand_for_their_quantity_and_as_factors() {
        let units = ShownUnits::parse("mm, deg, rpm, kN").expect("units");
        let shown = |si: &str, value: f64| {
            let shown = units.of(si);
            (shown.unit.clone(), shown.of_si(value))
        };
        assert_eq!(shown("m", 0.25), ("mm".to_owned(), 250.0));
        assert_eq!(shown("m/s^2", 9.81).0, "mm/s^2");
        assert_eq!(shown("N", 2500.0), ("kN".to_owned(), 2.5));
        assert_eq!(shown("N*m", 1.0), ("kN*mm".to_owned(), 1.0));
        assert_eq!(shown("N m", 1.0).0, "kN*mm");
        assert_eq!(shown("kg*m^2", 1.0), ("kg*mm^2".to_owned(), 1e6));
        assert_eq!(shown("J", 3.0), ("J".to_owned(), 3.0));
        assert_eq!(shown("", 3.0), (String::new(), 3.0));
        assert_eq!(shown("1/s", 3.0), ("1/s".to_owned(), 3.0));
        let (unit, turn) = shown("rad", std::f64::consts::PI);
        assert!(unit == "deg" && (turn - 180.0).abs() < 1e-12);
        let (unit, rate) = shown("rad/s", std::f64::consts::TAU);
        assert!(unit == "rpm" && (rate - 60.0).abs() < 1e-12);
        let (unit, rate) = shown("rad/s^2", std::f64::consts::PI);
        assert!(unit == "deg/s^2" && (rate - 180.0).abs() < 1e-12);
        assert_eq!(ShownUnits::parse("Hz").expect("a unit").of("rad/s").unit, "rad/s");
    }

    #[test]
    fn what_is_no_unit_is_told() {
        assert_eq!(ShownUnits::parse("si"), Ok(ShownUnits::default()));
        let fault = ShownUnits::parse("mm, degg").expect_err("no unit");
        assert_eq!(fault, "`degg` is no unit: did you mean `deg`?");
        assert!(ShownUnits::parse("").is_err() && ShownUnits::parse("3 m").is_err());
    }

    #[test]
    fn a_model_states_units_for_its_results() {
        let units = ShownUnits::of_model("[units]\nlength = \"mm\"\nangle = \"deg\"\n[bodies.a]\n");
        assert_eq!([units.of("m").unit, units.of("rad").unit], ["mm", "deg"]);
        assert_eq!(ShownUnits::of_model("[bodies.a]\n"), ShownUnits::default());
        assert_eq!(ShownUnits::of_model("= no text"), ShownUnits::default());
    }
}
