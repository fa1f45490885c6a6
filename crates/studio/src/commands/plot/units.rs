//! The units that curves are drawn in.

use bksim::log::{Header, Selection};
use bksim::model::file::{ShownUnit, ShownUnits};
use bksim_cli::exit::Failure;

/// Units of all quantities, and those of single channels before them.
#[derive(Clone, Debug, Default)]
pub(super) struct Units {
    all: ShownUnits,
    own: Vec<(String, ShownUnit)>,
}

/// A channel as it is asked for: `A.angle:deg`, or without a unit.
pub(super) fn name_and_unit(asked: &str) -> (&str, Option<&str>) {
    asked.rsplit_once(':').map_or((asked, None), |(name, unit)| (name, Some(unit)))
}

impl Units {
    /// Units of all, and those that channels were asked for in.
    ///
    /// # Errors
    /// A unit that is none, or of another quantity than its channels.
    pub(super) fn new(
        all: ShownUnits,
        asked: &[String],
        headers: &[&Header],
    ) -> Result<Self, Failure> {
        let mut own = Vec::new();
        for asked in asked {
            let (name, Some(text)) = name_and_unit(asked) else { continue };
            let unit = ShownUnit::parse(text).ok_or_else(|| {
                let message = format!("`{text}` in `{asked}` is no unit");
                Failure::usage(message, "write a channel, a colon and a unit: `A.angle:deg`")
            })?;
            for header in headers {
                let Ok(named) = Selection::new(header, [name]) else { continue };
                for column in named.columns() {
                    if !unit.measures(&column.unit) {
                        let message =
                            format!("`{}` is in {}, not in {text}", column.name, column.unit);
                        let help = "give it a unit of the same quantity";
                        return Err(Failure::usage(message, help));
                    }
                    own.push((column.name.clone(), unit.clone()));
                }
            }
        }
        Ok(Self { all, own })
    }

    /// The unit of a channel whose SI unit this is.
    pub(super) fn of(&self, name: &str, si: &str) -> ShownUnit {
        let own = self.own.iter().find(|(known, _)| known == name).map(|(_, unit)| unit.clone());
        own.unwrap_or_else(|| self.all.of(si))
    }
}
