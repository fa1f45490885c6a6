//! Axes that a model states: those of its `[ranges]`.

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::stated_ranges;

use crate::axis::Axis;

/// Axes between the ends that the model states, for samples; without those of quantities that are `fixed`.
///
/// # Errors
/// A diagnostic with [`crate::codes::BAD_AXIS`] of ends that are no numbers with one unit.
pub fn stated_axes(text: &str, fixed: &[(String, String)]) -> Result<Vec<Axis>, Diagnostic> {
    let axis = |(name, [from, to]): (String, [String; 2])| {
        Axis::parse(&name, &format!("{from}:{to}")).transpose()
    };
    let is_free = |(name, _): &(String, _)| fixed.iter().all(|(own, _)| own != name);
    stated_ranges(text).into_iter().filter(is_free).filter_map(axis).collect()
}
