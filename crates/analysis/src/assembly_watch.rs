//! [`AssemblyWatch`]: positions along a curve next to the assembly that the model holds.

use bksim_sim::evaluator::Evaluator;
use bksim_sim::held_assembly::{AssemblyChange, AssemblyMonitor};

use crate::curve::{Curve, Point, independent_rows};
use crate::error::AnalysisError;
use crate::path::Path;
use crate::positions::Positions;
use crate::rows::Clock;

/// A curve that is watched.
pub(crate) struct AssemblyWatch<'a> {
    monitor: AssemblyMonitor<'a>,
    evaluator: Evaluator<'a>,
    /// Rows that follow from others.
    inactive: Vec<usize>,
    /// Length of the way so far.
    gone: f64,
    /// Changes so far, each at the value that the parameter of the curve has there.
    pub(crate) changes: Vec<AssemblyChange>,
}

impl<'a> AssemblyWatch<'a> {
    /// Watch of the assembly that a model holds; `None` where it holds none.
    pub(crate) fn of(positions: &'a Positions) -> Result<Option<Self>, AnalysisError> {
        let mechanism = &positions.mechanism;
        let parameters = &mechanism.parameters;
        let Some(monitor) = AssemblyMonitor::of(&mechanism.compiled, parameters) else {
            return Ok(None);
        };
        let mut rows = positions.rows(&[], &[], Clock::Held)?;
        let x = rows.scaled(&positions.q);
        let kept = independent_rows(&rows.at(positions.t(), &x, &[]).jacobian);
        let inactive = (0..rows.n_rows()).filter(|row| !kept.contains(row)).collect();
        let evaluator = mechanism.compiled.evaluator(parameters);
        Ok(Some(Self { monitor, evaluator, inactive, gone: 0.0, changes: Vec::new() }))
    }

    /// Takes a step of the curve.
    pub(crate) fn step(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        (from, to): (&Point, &Point),
        length: f64,
    ) {
        if self.gone == 0.0 {
            self.look(curve, from);
        }
        self.gone += length;
        let Some(change) = self.look(curve, to) else { return };
        // On the curve itself, where the side changes.
        let ends = [from, to].map(|point| self.side(curve, point));
        let place =
            curve.root(from, length, (ends[0], ends[1]), &mut |curve, p| self.side(curve, p));
        let place = place.as_ref().unwrap_or(to);
        let parameter = place.z.as_slice().get(curve.equations.rows.n()).copied();
        self.changes.push(AssemblyChange { t: parameter.unwrap_or(0.0), ..change });
    }

    /// 1 or −1 on either side of a pose in which assemblies meet.
    fn side(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> f64 {
        let (t, q, _) = state(curve, point);
        match self.monitor.is_positive(&mut self.evaluator, &self.inactive, (t, &q)) {
            Some(true) => 1.0,
            Some(false) => -1.0,
            None => 0.0,
        }
    }

    fn look(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> Option<AssemblyChange> {
        let (t, q, v) = state(curve, point);
        self.monitor.observe(&mut self.evaluator, &self.inactive, Some(t), (self.gone, &q, &v))
    }
}

/// Time, coordinates and their rates by the length of the way.
fn state(curve: &Curve<Path<'_>>, point: &Point) -> (f64, Vec<f64>, Vec<f64>) {
    let rows = &curve.equations.rows;
    let n = rows.n();
    let parameter = point.z.as_slice().get(n).copied().unwrap_or(0.0);
    let [q, v] = [&point.z, &point.tangent].map(|values| rows.unscaled(&values.as_slice()[..n]));
    (curve.equations.time(parameter), q, v)
}
