//! A mechanism at an instant of its run, with the contacts and branches that hold there.

use bksim_dae::Control;
use bksim_model::Outputs;
use bksim_model::diagnostic::Rejected;
use bksim_sim::run::{Observer, Sample, Segment, StateSensitivity};

use crate::error::AnalysisError;
use crate::loaded::Loaded;

/// Observer of the end of a run.
#[derive(Default)]
struct Last {
    sample: Option<Sample>,
    segment: Segment,
}

impl Observer for Last {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.sample = Some(sample.clone());
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        self.segment.clone_from(segment);
    }
}

impl Loaded {
    /// Follows the motion from the start to the time `t`, s.
    ///
    /// # Errors
    /// [`AnalysisError::Rejected`] when the run does not come so far.
    pub(crate) fn run_to(&mut self, t: f64) -> Result<(), AnalysisError> {
        if t == self.t {
            return Ok(());
        }
        let mut simulation = self.mechanism.simulation()?;
        let mut options = simulation.options().clone();
        options.t_end = t;
        options.outputs = Outputs::Times(vec![t]);
        simulation.set_options(&options);
        let start = simulation.start()?;
        let mut last = Last::default();
        let summary = simulation
            .run(&start, &mut last, &|| false)
            .map_err(|failure| Rejected(vec![simulation.diagnose(&failure)]))?;
        let Last { sample: Some(sample), segment } = last else { return Ok(()) };
        (self.t, self.q, self.v) = (sample.t, sample.q, sample.v);
        (self.a, self.lambda) = (sample.a, sample.lambda);
        self.parameters.truncate(self.mechanism.parameters.len());
        self.parameters.extend(&segment.modes);
        self.keep_active(&segment.dependent);
        if let Some(change) = summary.uniqueness.last() {
            self.unique.clone_from(&change.uniqueness);
        }
        Ok(())
    }
}
