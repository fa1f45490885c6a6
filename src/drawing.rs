//! From a drawing to a mechanism.

use bksim_cad::model::{ModelOptions, sheet};
use bksim_model::diagnostic::Rejected;
use bksim_sim::Mechanism;

/// Reads a drawing (DXF or DWG) and derives its equations; `name` is used unless something in
/// it states one.
///
/// # Errors
/// [`Rejected`] holds every fault; spans are those of the drawing's text, or, for faults of the
/// model that came out of it, of that model's text.
pub fn mechanism_from_drawing(
    bytes: Vec<u8>,
    options: ModelOptions<'_>,
    name: &str,
) -> Result<Mechanism, Rejected> {
    let sheet = sheet(bytes, options.unit).map_err(|refused| Rejected(refused.diagnostics))?;
    let composition = sheet.compose(options);
    if composition.text.is_empty() {
        return Err(Rejected(composition.diagnostics));
    }
    let mut mechanism = Mechanism::from_toml(&composition.text, name)?;
    mechanism.warnings.splice(0..0, composition.diagnostics);
    Ok(mechanism)
}
