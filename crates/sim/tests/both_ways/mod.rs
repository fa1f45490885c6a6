//! Gradients back along a motion, compared with the derivatives forward with it.

use bksim_dae::Control;
use bksim_sim::run::Sample;
use bksim_sim::sensitivity::{SampleWeights, Sensitive, StateSensitivity};
use bksim_sim::{Mechanism, SensitivityMotion};

/// Numbers between −1 and 1 that follow no formula of a mechanism: a linear congruential generator.
struct Numbers(u64);

impl Numbers {
    fn several(&mut self, n: usize) -> Vec<f64> {
        let mut next = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let high = u32::try_from(self.0 >> 33).expect("31 bits");
            f64::from(high) / f64::from(1_u32 << 30) - 1.0
        };
        (0..n).map(|_| next()).collect()
    }
}

/// The parts of samples that a goal depends on.
#[derive(Clone, Copy, PartialEq, Debug)]
#[allow(dead_code, reason = "each test file has its own goals")]
pub(crate) enum Of {
    /// All that has derivatives.
    Everything,
    /// Motion alone, without multipliers and what is made of them.
    Motion,
}

/// The parts of samples with numbers of one kind each.
const N_PARTS: usize = 5;

fn parts(by: &StateSensitivity) -> [&Vec<f64>; N_PARTS] {
    let StateSensitivity { q, v, a, lambda, channels } = by;
    [q, v, a, lambda, channels]
}

/// Weights of every third sample and of the last.
fn weights(motion: &SensitivityMotion, of: Of) -> Vec<Option<SampleWeights>> {
    let mut numbers = Numbers(7);
    let last = motion.sensitivities.len() - 1;
    let of_sample = |(k, by): (usize, &Vec<StateSensitivity>)| {
        let [q, v, a, lambda, channels] = parts(&by[0]).map(|part| numbers.several(part.len()));
        let all = SampleWeights { q, v, a, lambda, channels };
        let weights = match of {
            Of::Everything => all,
            Of::Motion => SampleWeights { lambda: vec![], channels: vec![], ..all },
        };
        (k % 3 == 0 || k == last).then_some(weights)
    };
    motion.sensitivities.iter().enumerate().map(of_sample).collect()
}

/// Asserts that gradients of a goal are the weighted sums of the derivatives that a motion has, to a part of the sum of
/// the sizes of their terms.
pub(crate) fn both_ways(
    mechanism: &Mechanism,
    motion: &SensitivityMotion,
    sensitive: &[Sensitive],
    of: Of,
    within: f64,
) {
    let simulation = mechanism.simulation().expect("a simulation");
    let weights = weights(motion, of);
    let start = simulation.start().expect("a start");
    let plan = simulation.plan_gradient(&start, sensitive).unwrap_or_else(|e| panic!("{e}"));
    let mut n_samples = 0;
    let mut ignored = |_: &Sample| Control::Continue;
    let mut goal = |samples: &[Sample]| {
        n_samples = samples.len();
        weights.clone()
    };
    let found = simulation.gradient(&start, &plan, &mut ignored, &mut goal, &|| false);
    let found = found.unwrap_or_else(|failure| panic!("{:?}", simulation.diagnose(&failure)));
    let found = found.expect("nobody stops it");
    assert_eq!(n_samples, weights.len());
    for (k, found) in found.by.iter().enumerate() {
        let (mut expected, mut size) = (0.0, 0.0);
        for (by, weights) in motion.sensitivities.iter().zip(&weights) {
            let Some(SampleWeights { q, v, a, lambda, channels }) = weights else { continue };
            for (weights, part) in [q, v, a, lambda, channels].into_iter().zip(parts(&by[k])) {
                for (weight, by) in weights.iter().zip(part) {
                    expected += weight * by;
                    size += (weight * by).abs();
                }
            }
        }
        let name = sensitive[k].name(&mechanism.model);
        let error = (found - expected).abs();
        assert!(size > 0.0, "{name}: nothing depends on it");
        assert!(
            error <= within * size,
            "{name}: {found:e} back, {expected:e} forward, {:e} of the terms apart",
            error / size
        );
    }
}
