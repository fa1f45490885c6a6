//! Derivatives of outputs by the quantities of the axes, back along the motion: one run, and a way back for each output.

use bksim::analysis::Weighed;
use bksim::sim::run::Sample;

use crate::case::Worker;
use crate::study::Study;

/// Part of the span of an axis by which parameters are moved while the samples are held.
const MOVED: f64 = 1e-5;

impl Study {
    /// True if outputs may have derivatives back along the motion ([`Study::slopes_at`]).
    pub fn may_have_slopes(&self) -> bool {
        self.outputs.slopes_by().is_some() && !self.recording.has_settings()
    }

    /// The derivatives of the first `n` outputs by the numbers of all axes at a point, by output; `spans` are the sizes of the
    /// changes that count. `None` where the motion or an output has none, and where the model is another one there.
    pub fn slopes_at(
        &self,
        n: usize,
        (point, spans): (&[f64], &[f64]),
        stop: &dyn Fn() -> bool,
    ) -> Option<Vec<Vec<f64>>> {
        let names = self.outputs.slopes_by().filter(|_| self.may_have_slopes())?;
        let points = [point.to_vec()];
        let simulation = Worker::at(self, Some(&points)).replayed()?;
        let start = simulation.start().ok()?;
        let run = (&simulation, &start);
        let by: Vec<String> = self.plan().axes().iter().map(|axis| axis.name.clone()).collect();
        let new = || Weighed::named(run, &names, &by).ok();
        let known = self.ways_back.get_or_init(new).as_ref()?;
        let weighed = known.at(run).or_else(new)?;
        let parameters = simulation.parameters();

        // What remains where the samples are held: differences, as nothing runs.
        let mut rest: Option<Vec<Vec<f64>>> = None;
        let mut weigh = |samples: &[Sample]| {
            let held = self.outputs.held(&self.channels, parameters, samples);
            let Some((mut weights, mut held)) =
                held.and_then(|mut held| Some((held.weights(parameters)?, held)))
            else {
                return Vec::new();
            };
            let moved = |k: usize, by: f64| {
                let mut point = point.to_vec();
                point[k] += by;
                let si = self.inputs.iter().zip(&point).map(|(input, &x)| input.to_si(x));
                self.parameters_at(&si.collect::<Vec<f64>>())
            };
            let mut slope = |k: usize| -> Option<Vec<f64>> {
                let by = MOVED * spans[k];
                let [low, high] = [held.at(&moved(k, -by)?)?, held.at(&moved(k, by)?)?];
                Some(low.iter().zip(&high).map(|(low, high)| (high - low) / (2.0 * by)).collect())
            };
            rest = (0..point.len()).map(&mut slope).collect();
            weights.truncate(n);
            weights
        };
        let found = weighed.slopes(run, &mut weigh, stop).ok().flatten()?;
        let rest = rest?;
        let si = |k: usize| self.inputs[k].to_si(1.0) - self.inputs[k].to_si(0.0);
        let whole = |(output, by): (usize, Vec<f64>)| -> Vec<f64> {
            by.iter().enumerate().map(|(k, slope)| slope * si(k) + rest[k][output]).collect()
        };
        Some(found.into_iter().enumerate().map(whole).collect())
    }
}
