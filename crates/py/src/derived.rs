//! The common part of models with the same equations: all that does not depend on the values of their
//! parameters.

use bksim::Mechanism;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::Recording;
use bksim::record::Channels;
use bksim_load::Text;

/// Names, units and channels of a model, which other values leave as they are.
pub(crate) struct Derived {
    pub(crate) source: Text,
    pub(crate) name: String,
    /// Parameters, with their SI units.
    pub(crate) units: Vec<(String, String)>,
    /// About the values that it was derived with.
    pub(crate) warnings: Vec<Diagnostic>,
    pub(crate) channels: Channels,
    /// How values follow from those that vary, where some do.
    pub(crate) recording: Option<Recording>,
}

impl Derived {
    pub(crate) fn new(
        source: Text,
        mechanism: &Mechanism,
        warnings: Vec<Diagnostic>,
        recording: Option<Recording>,
    ) -> Self {
        let parameters = mechanism.model.parameters.iter();
        Self {
            source,
            name: mechanism.model.name.clone(),
            units: parameters.map(|p| (p.name.clone(), p.unit.clone())).collect(),
            warnings,
            channels: Channels::new(mechanism),
            recording,
        }
    }
}
