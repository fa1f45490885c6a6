//! [`Growth`]: how a small difference of the start grows in a motion, and up to when a comparison of runs means anything.
//!
//! ```text
//! v + δ s Z c at the start, c a unit vector      Z: free motions, so that the constraints hold; s: largest rate
//! factor(t) = max over t' ≤ t of (|Δq|/δ, |Δv|/(δ s)), at least 1
//! horizon: 10 rtol · factor reaches a hundredth of the motion
//! ```
//!
//! Every error that a run makes on its way grows as this difference does, so a chaotic motion exceeds any fixed bound,
//! by whatever method. Both runs have a hundredth of the tolerances.
//!
//! Source: the largest Lyapunov exponent by two neighbouring motions, G. Benettin, L. Galgani and J.-M. Strelcyn,
//! Physical Review A 14 (1976) 2338.

use bksim_model::Outputs;
use bksim_sim::run::Sample;
use bksim_sim::{Mechanism, Motion};
use nalgebra::DVector;

use crate::error::AnalysisError;
use crate::reduced::null_space;
use crate::rows::{Clock, Rows};
use crate::watch::Watch;

/// Growth of a small difference.
#[derive(Clone, PartialEq, Debug)]
pub struct Growth {
    /// By time: the largest factor up to there.
    pub factors: Vec<f64>,
    /// ln(factor) over the time that it took, up to the horizon or the end, 1/s.
    pub rate: f64,
    /// The time from which on differences as small as the tolerances hide the motion, s.
    pub horizon: Option<f64>,
}

/// Part of the motion that a difference may reach.
const HIDDEN: f64 = 0.01;
/// Differences of positions that a run may have, in tolerances.
const OWN: f64 = 10.0;

/// The growth in `motion` of `own` by `times`; `None` where nothing is free to differ.
pub(crate) fn growth(
    own: &Mechanism,
    motion: &Motion,
    times: &[f64],
    watch: Watch<'_>,
) -> Result<Option<Growth>, AnalysisError> {
    let options = &own.model.solve;
    let rtol = options.rtol.max(1e-12);
    let delta = OWN * rtol;
    let Some((direction, units, speed)) = free_direction(own, motion)? else { return Ok(None) };

    // The same motion more exactly, and one next to it.
    let mut model = own.model.snapshot().to_model();
    model.solve.step = None;
    (model.solve.rtol, model.solve.atol) = (0.01 * rtol, (0.01 * options.atol).max(1e-14));
    model.solve.outputs = Outputs::Times(times.to_vec());
    let mechanism = Mechanism::derive(model, Vec::new())?;
    let simulation = mechanism.simulation()?;
    let start = simulation.start()?;
    let mut beside = start.clone();
    for (v, along) in beside.v.iter_mut().zip(&direction) {
        *v += delta * speed * along;
    }
    let base = watch.run("the same more exactly", &simulation, start)?;
    let other = watch.run("a motion beside it", &simulation, beside)?;

    let mut factors = Vec::with_capacity(times.len());
    let (mut most, mut horizon) = (1.0_f64, None);
    let at = |motion: &Motion, t: f64| motion.samples.iter().rposition(|sample| sample.t == t);
    for &t in times {
        let pair = at(&base, t).zip(at(&other, t));
        match pair {
            Some((i, k)) => {
                let (a, b) = (&base.samples[i], &other.samples[k]);
                most = most.max(apart((a, b), &units, delta, speed));
                if most * OWN * rtol >= HIDDEN {
                    horizon = horizon.or(Some(t));
                }
            }
            // Not known, as the runs were stopped before.
            None => horizon = horizon.or(Some(t)),
        }
        factors.push(most);
    }
    let begin = times.first().copied().unwrap_or(0.0);
    let last = horizon.or(times.last().copied()).unwrap_or(begin);
    let reached = times.iter().rposition(|t| (t - begin).abs() <= (last - begin).abs());
    let factor = reached.map_or(1.0, |k| factors[k]);
    let span = (last - begin).abs();
    let rate = if span > 0.0 { factor.ln() / span } else { 0.0 };
    Ok(Some(Growth { factors, rate, horizon }))
}

/// How far two samples are apart, in units of the first difference.
fn apart((a, b): (&Sample, &Sample), units: &[f64], delta: f64, speed: f64) -> f64 {
    let off = |x: &[f64], y: &[f64]| {
        let parts = x.iter().zip(y).zip(units).map(|((x, y), unit)| ((x - y) / unit).abs());
        parts.fold(0.0, f64::max)
    };
    (off(&a.q, &b.q) / delta).max(off(&a.v, &b.v) / (delta * speed))
}

/// A direction of the free motions at the start in units of the coordinates, these units, and the largest rate in them.
type FreeDirection = (Vec<f64>, Vec<f64>, f64);

fn free_direction(
    own: &Mechanism,
    motion: &Motion,
) -> Result<Option<FreeDirection>, AnalysisError> {
    let system = own.system.integrated();
    let start = &motion.start;
    let size = if start.longest_link > 0.0 { start.longest_link } else { 1.0 };
    let parameters = start.parameters_with_modes(&own.parameters);
    let is_active = |row: &usize| !start.inactive_rows().contains(row);
    let kept: Vec<usize> = (0..system.constraints.len()).filter(is_active).collect();
    let numbers = (parameters.as_slice(), size, Clock::Running);
    let mut rows = Rows::compile(&own.model, system, &[], &kept, numbers)?;
    let x = rows.scaled(&start.q);
    let free = null_space(&rows.at(start.t, &x, &[]).jacobian);
    if free.ncols() == 0 {
        return Ok(None);
    }
    // All free motions alike, of either sign.
    let signs = DVector::from_fn(free.ncols(), |k, _| if k % 2 == 0 { 1.0 } else { -1.0 });
    let along = (&free * signs).normalize();
    let units = rows.unit_of_column.clone();
    let rates =
        motion.samples.iter().flat_map(|s| s.v.iter().zip(&units).map(|(v, u)| (v / u).abs()));
    let speed = rates.fold(0.0, f64::max);
    Ok(Some((rows.unscaled(along.as_slice()), units, if speed > 0.0 { speed } else { 1.0 })))
}
