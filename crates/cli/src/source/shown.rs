//! The units in which results are shown.

use bksim::model::file::ShownUnits;

use crate::exit::Failure;

/// The units of a list such as `mm, deg, rpm`, or those of the model's text for `model`; `default` unless asked.
///
/// # Errors
/// The first that is no unit.
pub fn shown_units(
    asked: Option<&str>,
    model_text: &str,
    default: ShownUnits,
) -> Result<ShownUnits, Failure> {
    match asked {
        None => Ok(default),
        Some("model") => Ok(ShownUnits::of_model(model_text)),
        Some(list) => ShownUnits::parse(list).map_err(|fault| {
            Failure::usage(fault, "write for example `--units mm,deg,rpm`, `si` or `model`")
        }),
    }
}
