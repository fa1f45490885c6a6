//! A sweep as it is asked for, and the model read at values of its parameters.

use bksim::analysis::compliances;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, Reading, Recording, Source, read, read_recorded};
use bksim::model::{Compliance, Model};
use bksim::{Rejected, SolveChanges};

use crate::output::NeedsSlopes;
use crate::plan::Plan;

/// A model, its cases and the numbers to keep of each.
#[derive(Clone, Debug)]
pub struct Request {
    /// Text of the model.
    pub model: String,
    /// Name of the model unless the text states one.
    pub name: String,
    /// The file of the model, as tables name it; the name unless given.
    pub file: String,
    /// Limits that protect against hostile models.
    pub limits: Limits,
    /// Parameters with one other value, as for [`Source::overrides`].
    pub fixed: Vec<(String, String)>,
    /// Joints that yield, each by name and stiffness.
    pub compliance: Vec<(String, String)>,
    /// True if positions alone are asked for: bodies need no masses then, and no case can be run.
    pub is_geometry: bool,
    /// The cases.
    pub plan: Plan,
    /// The outputs of each run, as for [`Outputs::read`](crate::Outputs::read).
    pub outputs: Vec<String>,
    /// Settings of the solution.
    pub changes: SolveChanges,
    /// Whether outputs are to have derivatives ([`Study::slopes_at`](crate::Study::slopes_at)); none unless given.
    pub slopes: NeedsSlopes,
}

impl Request {
    /// A model and its cases; the rest as the model says.
    pub fn new(model: &str, name: &str, plan: Plan) -> Self {
        Self {
            model: model.to_owned(),
            name: name.to_owned(),
            file: name.to_owned(),
            limits: Limits::default(),
            fixed: Vec::new(),
            compliance: Vec::new(),
            is_geometry: false,
            plan,
            outputs: Vec::new(),
            changes: SolveChanges::default(),
            slopes: NeedsSlopes::No,
        }
    }

    /// The springs of the joints that yield.
    pub(crate) fn compliances(&self, model: &Model) -> Result<Vec<Compliance>, Rejected> {
        compliances(model, &self.compliance).map_err(|error| Rejected(error.diagnostics()))
    }

    /// Varied values that are no parameters, by their path: `crank.mass`.
    fn promoted(&self, model: &Model) -> Vec<String> {
        let is_stated = |name: &str| model.initial.iter().any(|initial| initial.name == name);
        let names = self.plan.axes().iter().map(|axis| axis.name.as_str());
        names.filter(|name| name.contains('.') && !is_stated(name)).map(str::to_owned).collect()
    }

    /// Reads the model as it is written, with the parameters that its axes vary.
    pub(crate) fn read_stated(&self) -> Result<Model, Vec<Diagnostic>> {
        let model = self.read(&[])?;
        let promoted = self.promoted(&model);
        if promoted.is_empty() {
            return Ok(model);
        }
        let (text, name, limits) = (&self.model, &self.name, self.limits);
        let (overrides, promoted, is_geometry) = (&self.fixed, &promoted, self.is_geometry);
        let source = Source { overrides, promoted, limits, is_geometry, ..Source::new(text, name) };
        let Reading { model, diagnostics } = read(&source);
        model.ok_or(diagnostics)
    }

    /// Reads the model with these parameters set, too.
    pub(crate) fn read(&self, set: &[(String, String)]) -> Result<Model, Vec<Diagnostic>> {
        let (Reading { model, diagnostics }, _) = self.read_recorded(set);
        model.ok_or(diagnostics)
    }

    /// Reading ([`Request::read`]) with how the model follows from the parameters that are set.
    pub(crate) fn read_recorded(&self, set: &[(String, String)]) -> (Reading, Option<Recording>) {
        let overrides = [self.fixed.as_slice(), set].concat();
        let (text, name, limits) = (&self.model, &self.name, self.limits);
        let varied: Vec<String> = set.iter().map(|(name, _)| name.clone()).collect();
        let is_geometry = self.is_geometry;
        let source =
            Source { overrides: &overrides, limits, is_geometry, ..Source::new(text, name) };
        read_recorded(&source, &varied)
    }
}
