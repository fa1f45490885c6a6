//! The unit of lengths of a drawing: that of `$INSUNITS`, else of `$MEASUREMENT`, else of the caller.

use bksim_model::diagnostic::Diagnostic;

use crate::codes;
use crate::drawing::LengthUnit;

const fn unit(name: &'static str, metres: f64) -> LengthUnit {
    LengthUnit { name, metres }
}

/// The values 1 to 24 of `$INSUNITS`: DXF reference, *HEADER*. Lengths are exact where defined:
/// international yard (1959), US survey foot 1200/3937 m (1893), astronomical unit (IAU 2012),
/// parsec 648000/π au (IAU 2015).
pub const INSUNITS: [LengthUnit; 24] = [
    unit("in", 0.0254),
    unit("ft", 0.3048),
    unit("mile", 1609.344),
    unit("mm", 0.001),
    unit("cm", 0.01),
    unit("m", 1.0),
    unit("km", 1000.0),
    unit("microinch", 0.0254e-6),
    unit("mil", 0.0254e-3),
    unit("yard", 0.9144),
    unit("angstrom", 1e-10),
    unit("nm", 1e-9),
    unit("um", 1e-6),
    unit("dm", 0.1),
    unit("dam", 10.0),
    unit("hm", 100.0),
    unit("Gm", 1e9),
    unit("au", 149_597_870_700.0),
    unit("light-year", 9_460_730_472_580_800.0),
    unit("parsec", 648_000.0 / std::f64::consts::PI * 149_597_870_700.0),
    unit("survey-ft", 1200.0 / 3937.0),
    unit("survey-in", 100.0 / 3937.0),
    unit("survey-yard", 3600.0 / 3937.0),
    unit("survey-mile", 5280.0 * 1200.0 / 3937.0),
];

/// The unit of a name as given by the user, such as `mm`, `inch` or `feet`.
pub fn by_name(name: &str) -> Option<LengthUnit> {
    let name = name.trim();
    let usual = match name.to_ascii_lowercase().as_str() {
        "inch" | "inches" | "\"" => "in",
        "foot" | "feet" | "'" => "ft",
        "millimetre" | "millimeter" => "mm",
        "centimetre" | "centimeter" => "cm",
        "metre" | "meter" => "m",
        "µm" | "micron" => "um",
        _ => name,
    };
    INSUNITS.into_iter().find(|unit| unit.name == usual)
}

/// The variables of a drawing's header that state its unit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Stated {
    /// `$INSUNITS`, if there is one.
    pub insunits: Option<i64>,
    /// `$MEASUREMENT`, if there is one: 0 inches, 1 millimetres.
    pub measurement: Option<i64>,
}

impl Stated {
    /// The unit the drawing states, and the variable that states it.
    pub fn unit(self) -> Option<(LengthUnit, &'static str)> {
        let number = self.insunits.and_then(|number| usize::try_from(number).ok()?.checked_sub(1));
        if let Some(unit) = number.and_then(|number| INSUNITS.get(number)) {
            return Some((*unit, "$INSUNITS"));
        }
        match self.measurement {
            Some(0) => Some((unit("in", 0.0254), "$MEASUREMENT")),
            Some(1) => Some((unit("mm", 0.001), "$MEASUREMENT")),
            _ => None,
        }
    }
}

/// The unit of a drawing of this width and height; `given` by the caller wins, with a warning
/// where it contradicts `$INSUNITS`.
///
/// # Errors
/// `D006` when neither the drawing nor the caller says what a unit is.
pub fn choose(
    stated: Stated,
    given: Option<LengthUnit>,
    size: [f64; 2],
) -> Result<(LengthUnit, Option<Diagnostic>), Diagnostic> {
    match (given, stated.unit()) {
        (Some(given), Some((own, variable))) if own != given && variable == "$INSUNITS" => {
            let message = format!(
                "lengths are taken in `{}`, though the drawing says `{}`",
                given.name, own.name
            );
            let warning = Diagnostic::warning(codes::OTHER_UNITS, message)
                .note(format!("`$INSUNITS` of the drawing stands for `{}`", own.name))
                .help("leave `--units` out to take the drawing's own");
            Ok((given, Some(warning)))
        }
        (Some(given), _) => Ok((given, None)),
        (None, Some((own, _))) => Ok((own, None)),
        (None, None) => Err(no_units(stated, size)),
    }
}

fn no_units(stated: Stated, [width, height]: [f64; 2]) -> Diagnostic {
    let message = match stated.insunits {
        None | Some(0) => "the drawing has no units".to_owned(),
        Some(number) => {
            format!("the drawing has no units: `$INSUNITS` is {number}, which means none")
        }
    };
    let shown = |name: &str, metres: f64| {
        let [width, height] = [width, height].map(|length| plain(length * metres));
        format!("{width} m × {height} m if a unit is 1 {name}")
    };
    Diagnostic::error(codes::NO_UNITS, message)
        .note(format!("all geometry is {} × {} units large:", plain(width), plain(height)))
        .note(shown("mm", 0.001))
        .note(shown("inch", 0.0254))
        .note(shown("m", 1.0))
        .help("pass --units mm, --units inch or --units m, or set the units in the CAD program")
}

/// Four significant digits.
fn plain(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().expect("a printed number can be read");
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated(insunits: Option<i64>, measurement: Option<i64>) -> Stated {
        Stated { insunits, measurement }
    }

    #[test]
    fn insunits_win_over_measurement() {
        let unit = |stated: Stated| stated.unit().map(|(unit, _)| unit.name);
        assert_eq!(unit(stated(Some(4), Some(0))), Some("mm"));
        assert_eq!(unit(stated(Some(0), Some(0))), Some("in"));
        assert_eq!(unit(stated(None, Some(1))), Some("mm"));
        assert_eq!(unit(stated(Some(25), None)), None);
        assert_eq!(unit(stated(Some(-1), None)), None);
    }

    #[test]
    fn the_page_about_units_names_them_all() {
        let mut pages = codes::PAGES.iter();
        let page = pages.find(|page| page.code == codes::NO_UNITS);
        let page = page.expect("the page of drawings without units").text;
        for unit in INSUNITS {
            assert!(
                page.contains(&format!("`{}`", unit.name)),
                "`{}` is not on the page",
                unit.name
            );
        }
    }

    #[test]
    fn lengths_of_units_agree_with_one_another() {
        let metres = |name: &str| by_name(name).expect("a unit").metres;
        let pairs = [
            (36.0 * metres("inch"), metres("yard")),
            (5280.0 * metres("ft"), metres("mile")),
            (1000.0 * metres("mil"), metres("in")),
            (12.0 * metres("survey-in"), metres("survey-ft")),
            (3.0 * metres("survey-ft"), metres("survey-yard")),
            (3.085_677_581_491_367e16, metres("parsec")),
        ];
        for (a, b) in pairs {
            assert!((a / b - 1.0).abs() < 1e-14, "{a} m against {b} m");
        }
    }

    #[test]
    fn a_drawing_without_units_is_shown_in_three() {
        let fault = choose(stated(Some(0), None), None, [300.0, 120.0]).expect_err("no units");
        assert_eq!(fault.code, codes::NO_UNITS);
        let notes = fault.notes.join("\n");
        for size in ["0.3 m × 0.12 m", "7.62 m × 3.048 m", "300 m × 120 m"] {
            assert!(notes.contains(size), "`{size}` is not in:\n{notes}");
        }
    }

    #[test]
    fn given_units_win_with_a_warning() {
        let (unit, warning) =
            choose(stated(Some(4), None), by_name("inch"), [1.0, 1.0]).expect("units");
        assert_eq!(unit.name, "in");
        assert_eq!(warning.map(|it| it.code), Some(codes::OTHER_UNITS));
        let same = choose(stated(Some(4), None), by_name("mm"), [1.0, 1.0]).expect("units");
        assert_eq!(same.1, None);
    }
}
