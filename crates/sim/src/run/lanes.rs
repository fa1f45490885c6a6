//! [`LaneMotion`]: the accelerations of a small mechanism at four states at once.

use bksim_dae::{LANES, Lanes};

use crate::compiled::CompiledSystem;
use crate::function::LaneBuffers;
use crate::multiplier::MultiplierSystem;

/// The straight-line code of a mechanism in lanes, with its buffers.
pub(super) struct LaneMotion<'a> {
    compiled: &'a CompiledSystem,
    line: LaneBuffers,
    power: Option<LaneBuffers>,
    /// When the states of the last evaluation were.
    times: Lanes,
}

impl<'a> LaneMotion<'a> {
    /// The motion at one set of parameters, modes included; `None` where there is no straight-line code, or
    /// loads follow a law.
    pub(super) fn new(compiled: &'a CompiledSystem, parameters: &[f64]) -> Option<Self> {
        if !compiled.has_lanes() {
            return None;
        }
        let power = compiled.power.as_ref();
        Some(Self {
            compiled,
            line: compiled.unrolled.as_ref()?.lane_buffers(parameters)?,
            power: power.map_or(Some(None), |power| power.lane_buffers(parameters).map(Some))?,
            times: [0.0; LANES],
        })
    }

    /// Writes the derivatives of (q, v, W); false where a state needs a closer look.
    pub(super) fn derivative(
        &mut self,
        multipliers: &mut MultiplierSystem,
        t: Lanes,
        y: &[Lanes],
        ydot: &mut [Lanes],
    ) -> bool {
        let Self { compiled, line, power, times } = self;
        let (Some(unrolled), nq) = (&compiled.unrolled, compiled.nq()) else { return false };
        *times = t;
        let state = &y[..2 * nq];
        let results = unrolled.evaluate_lanes(line, &[&[t], state]);
        let (solution, factors) = results.split_at(nq + compiled.nc());
        let (vdot, lambda) = solution.split_at(nq);
        let (rates, work) = ydot.split_at_mut(2 * nq);
        rates[..nq].copy_from_slice(&state[nq..]);
        rates[nq..].copy_from_slice(vdot);
        work[0] = match (&compiled.power, power) {
            (Some(function), Some(buffers)) => {
                function.evaluate_lanes(buffers, &[&[t], state, lambda])[0]
            }
            _ => [0.0; LANES],
        };
        multipliers.accept_lanes(solution, factors)
    }

    /// The factors of the state nearest to `t` in the last evaluation, and the lane it was in.
    pub(super) fn factors_near(&self, t: f64) -> (&[Lanes], usize) {
        let distance = |lane: &usize| (self.times[*lane] - t).abs();
        let lane = (0..LANES).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let n = self.compiled.nq() + self.compiled.nc();
        (&self.line.results()[n..], lane.unwrap_or_default())
    }
}
