//! The largest applied force of a run, next to which smaller ones are rounding.

use bksim::playback::Playback;
use bksim::sim::load_forces::LoadForces;

/// Instants that are examined, both ends included.
const INSTANTS: u32 = 61;

/// The largest size of an applied force over the run, N; zero where there is none that can be computed. The playback
/// is at another instant afterwards.
pub(crate) fn largest(playback: &mut Playback) -> f64 {
    let mechanism = playback.mechanism();
    let (model, parameters) = (&mechanism.model, &mechanism.parameters);
    let loads = LoadForces::compile(model, &mechanism.system, &mechanism.compiled, parameters);
    let Ok(mut loads) = loads else { return 0.0 };
    let [first, last] = playback.span();
    let mut largest = 0.0_f64;
    for k in 0..INSTANTS {
        let t = first + (last - first) * f64::from(k) / f64::from(INSTANTS - 1);
        if playback.seek(t).is_err() {
            break;
        }
        let sample = playback.sample();
        for at in loads.at((sample.t, &sample.q, &sample.v), &sample.lambda) {
            let [x, y, z] = at.force;
            largest = largest.max(x.hypot(y).hypot(z));
        }
    }
    if largest.is_finite() { largest } else { 0.0 }
}
