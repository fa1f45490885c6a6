//! Pictures of all ways in which the start of a mechanism closes.

use bksim::Mechanism;
use bksim::analysis::{AnalysisError, Assemblies, assembly_panels};
use bksim::panels::Sheet;
use bksim_scene::Theme;

/// A sentence and the pictures next to each other, in the colours of both themes; the style shows one of them.
///
/// # Errors
/// As [`assembly_panels`].
pub(crate) fn html(mechanism: &Mechanism) -> Result<String, AnalysisError> {
    let mut model = mechanism.model.snapshot().to_model();
    for (parameter, value) in model.parameters.iter_mut().zip(&mechanism.parameters) {
        parameter.value = *value;
    }
    let name = model.name.clone();
    let (found, panels) = assembly_panels(model)?;
    let pictures = [(Theme::LIGHT, "light"), (Theme::DARK, "dark")].map(|(theme, class)| {
        let svg = Sheet::of(&panels, theme).moving(&format!("Assemblies of {name}"));
        format!("<div class=\"sheet {class}\">\n{svg}</div>\n")
    });
    Ok(format!("<p>{}</p>\n{}", words(&found), pictures.concat()))
}

/// How many there are, and whether these are all.
fn words(found: &Assemblies) -> String {
    let n = found.assemblies.len();
    let what = if n == 1 { "assembly" } else { "assemblies" };
    let all = match (&found.proof, n) {
        (None, _) => " found",
        (Some(_), 1) => ", the only one",
        (Some(_), _) => ", all there are",
    };
    format!("{n} {what}{all}")
}
