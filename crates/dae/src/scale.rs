//! The size of an error: weights of the unknowns, and norms with them.

use crate::error::WorstUnknown;
use crate::settings::{Settings, StepControl, Tolerance};
use crate::system::{Index, Layout};

/// Weights that turn errors into units of their tolerance.
///
/// ```text
/// weight_i = |h|^{index_i − 1} / (atol_i + rtol |y_i|)
/// ```
///
/// The power of `h` discounts unknowns of index 2 and 3 (header of `RADAU5`).
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    weight: Vec<f64>,
    /// Unknowns that take part in the error test, and their number.
    is_tested: Vec<bool>,
    n_tested: usize,
}

/// The denominator of [`Scale`].
#[derive(Clone, Debug)]
pub(crate) enum Unit {
    /// Error control: `atol + rtol |y|`.
    Tolerance { rtol: f64, atol: Tolerance },
    /// Fixed steps have no error tolerance: `1 + |y|`.
    Magnitude,
}

impl Unit {
    pub(crate) fn new(settings: &Settings) -> Self {
        match settings.step {
            StepControl::Adaptive => {
                Self::Tolerance { rtol: settings.rtol, atol: settings.atol.clone() }
            }
            StepControl::Fixed { .. } => Self::Magnitude,
        }
    }

    fn of(&self, i: usize, y: f64) -> f64 {
        match self {
            Self::Tolerance { rtol, atol } => atol.of(i) + rtol * y.abs(),
            Self::Magnitude => 1.0 + y.abs(),
        }
    }
}

impl Scale {
    pub(crate) fn new(n: usize) -> Self {
        Self { weight: vec![1.0; n], is_tested: vec![true; n], n_tested: n }
    }

    /// Number of unknowns.
    pub(crate) fn len(&self) -> usize {
        self.weight.len()
    }

    /// Restricts the error test to some unknowns; where there are none, it takes all.
    pub(crate) fn test_only(&mut self, is_tested: impl Fn(usize) -> bool) {
        let n = self.weight.len();
        self.n_tested = (0..n).filter(|&i| is_tested(i)).count();
        let any = self.n_tested > 0;
        self.is_tested.iter_mut().enumerate().for_each(|(i, t)| *t = !any || is_tested(i));
        if !any {
            self.n_tested = n;
        }
    }

    /// Root mean square of the weighted entries of `x` that take part in the error test: one or
    /// more vectors of length `n`.
    pub(crate) fn rms_tested(&self, x: &[f64]) -> f64 {
        let n = self.weight.len();
        if n == 0 {
            return 0.0;
        }
        let square = |(i, x): (usize, &f64)| {
            if self.is_tested[i] { (x * self.weight[i]).powi(2) } else { 0.0 }
        };
        let sum: f64 =
            x.chunks_exact(n).map(|x| x.iter().enumerate().map(square).sum::<f64>()).sum();
        (sum / (self.n_tested * (x.len() / n)) as f64).sqrt()
    }

    /// Takes the weights at state `y` and step size `h`.
    pub(crate) fn update(&mut self, unit: &Unit, index: &[Index], y: &[f64], h: f64) {
        for (i, weight) in self.weight.iter_mut().enumerate() {
            *weight = h.abs().powi(index[i].power()) / unit.of(i, y[i]);
        }
    }

    /// Takes the weights of unknowns, all of index 1: of each the larger magnitude in two states.
    pub(crate) fn weigh(&mut self, unit: &Unit, [a, b]: [&[f64]; 2]) {
        let larger = |a: f64, b: f64| a.abs().max(b.abs());
        let sizes = a.iter().zip(b).map(|(&a, &b)| larger(a, b));
        let weights = self.weight.iter_mut();
        // One loop for each kind, without a choice at every unknown.
        match unit {
            Unit::Tolerance { rtol, atol: Tolerance::PerUnknown(atol) } => weights
                .zip(atol)
                .zip(sizes)
                .for_each(|((weight, atol), size)| *weight = 1.0 / (atol + rtol * size)),
            Unit::Tolerance { .. } | Unit::Magnitude => weights
                .zip(sizes)
                .enumerate()
                .for_each(|(i, (weight, size))| *weight = 1.0 / unit.of(i, size)),
        }
    }

    /// Root mean square of the weighted differences of two vectors of length `n`.
    pub(crate) fn rms_of_difference(&self, a: &[f64], b: &[f64]) -> f64 {
        let square = |((a, b), weight): ((&f64, &f64), &f64)| {
            let scaled = (a - b) * weight;
            scaled * scaled
        };
        let sum: f64 = a.iter().zip(b).zip(&self.weight).map(square).sum();
        (sum / self.weight.len().max(1) as f64).sqrt()
    }

    /// Mean of the products of the weighted differences of two pairs of vectors of length `n`.
    pub(crate) fn product_of_differences(&self, [a, b]: [&[f64]; 2], [c, d]: [&[f64]; 2]) -> f64 {
        let product = |(i, weight): (usize, &f64)| (a[i] - b[i]) * (c[i] - d[i]) * weight * weight;
        let sum: f64 = self.weight.iter().enumerate().map(product).sum();
        sum / self.weight.len().max(1) as f64
    }

    /// Root mean square of the weighted entries of `x`: one or more vectors of length `n`.
    pub(crate) fn rms(&self, x: &[f64]) -> f64 {
        self.mean_square(x).sqrt()
    }

    /// Mean square, without the root.
    pub(crate) fn mean_square(&self, x: &[f64]) -> f64 {
        let n = self.weight.len();
        if n == 0 {
            return 0.0;
        }
        let sum: f64 = x
            .chunks_exact(n)
            .map(|x| x.iter().zip(&self.weight).map(|(x, w)| (x * w) * (x * w)).sum::<f64>())
            .sum();
        sum / x.len() as f64
    }

    /// Weighted magnitude of entry `i`, the largest over the vectors in `x`.
    fn magnitude(&self, x: &[f64], i: usize) -> f64 {
        let n = self.weight.len();
        // `f64::max` drops NaN, which must come out on top here.
        x.iter()
            .skip(i)
            .step_by(n)
            .map(|x| (x * self.weight[i]).abs())
            .fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
    }

    /// The three unknowns whose entries in `x` have the largest weighted magnitude, worst first.
    pub(crate) fn worst(&self, layout: &Layout, x: &[f64]) -> Vec<WorstUnknown> {
        let mut all: Vec<(usize, f64)> =
            (0..layout.n()).map(|i| (i, self.magnitude(x, i))).collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all.truncate(3);
        all.into_iter()
            .map(|(i, scaled)| WorstUnknown { i, name: layout.name(i), scaled })
            .collect()
    }
}
