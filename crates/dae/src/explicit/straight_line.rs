//! A step of Dormand and Prince as straight-line code, for systems whose derivative is straight-line code itself.
//!
//! Operations are those of [`StageWork`](super::stages::StageWork) in the same order, so that the code gives the same bits.

use super::coefficients::{A, C, E3, E5, N_STAGES, Term};

/// Arithmetic that is written down, to be carried out often: straight-line code in the making.
pub trait Recorder {
    /// A number that will be known when the code runs.
    type Value: Copy;

    /// A number that is known now.
    fn constant(&mut self, value: f64) -> Self::Value;

    /// `a + b`.
    fn add(&mut self, a: Self::Value, b: Self::Value) -> Self::Value;

    /// `a b`.
    fn multiply(&mut self, a: Self::Value, b: Self::Value) -> Self::Value;
}

/// Vectors, as long as there are unknowns, that [`record_step`] gives.
pub const N_STEP_VECTORS: usize = N_STAGES - 1 + 4;

/// The number of `y1` among them, before any projection.
pub const STEP_END: usize = N_STAGES;

/// The vectors among the results of a step.
pub(super) struct StepVectors<'a> {
    n: usize,
    results: &'a [f64],
}

impl<'a> StepVectors<'a> {
    /// Of a system with `n` unknowns.
    pub(super) fn new(n: usize, results: &'a [f64]) -> Self {
        Self { n, results: &results[..N_STEP_VECTORS * n] }
    }

    fn vector(&self, number: usize) -> &'a [f64] {
        &self.results[number * self.n..][..self.n]
    }

    /// `k_i`, from 1 to 11.
    pub(super) fn k(&self, i: usize) -> &'a [f64] {
        self.vector(i - 1)
    }

    /// The argument of stage 11, then the end of the step.
    pub(super) fn last_argument(&self) -> &'a [f64] {
        self.vector(N_STAGES - 1)
    }

    pub(super) fn y1(&self) -> &'a [f64] {
        self.vector(STEP_END)
    }

    /// The error estimates of order 5 and 3.
    pub(super) fn errors(&self) -> [&'a [f64]; 2] {
        [self.vector(N_STAGES + 1), self.vector(N_STAGES + 2)]
    }
}

/// Records a step from `(t, y)` of size `h`, where `f0 = f(t, y)`, with a `derivative` that records `f`: vectors of `n`
/// numbers, in order `k_1 … k_11`, the argument of stage 11, `y1`, and the two error estimates.
pub fn record_step<R: Recorder>(
    recorder: &mut R,
    [t, h]: [R::Value; 2],
    (y, f0): (&[R::Value], &[R::Value]),
    mut derivative: impl FnMut(&mut R, R::Value, &[R::Value]) -> Vec<R::Value>,
) -> Vec<R::Value> {
    let mut k = vec![f0.to_vec()];
    let mut last_argument = Vec::new();
    for i in 1..N_STAGES {
        let (stage_time, argument) = record_stage(recorder, i, [t, h], (y, &k));
        k.push(derivative(recorder, stage_time, &argument));
        last_argument = argument;
    }
    let y1 = record_sum(recorder, (h, A[N_STAGES]), &k, Some(y));
    let [error5, error3] = [E5, E3].map(|row| record_sum(recorder, (h, row), &k, None));
    k.remove(0);
    k.extend([last_argument, y1, error5, error3]);
    k.concat()
}

/// Time and argument of stage `i`.
fn record_stage<R: Recorder>(
    recorder: &mut R,
    i: usize,
    [t, h]: [R::Value; 2],
    (y, k): (&[R::Value], &[Vec<R::Value>]),
) -> (R::Value, Vec<R::Value>) {
    let size = recorder.constant(C[i]);
    let later = recorder.multiply(size, h);
    let stage_time = recorder.add(t, later);
    (stage_time, record_sum(recorder, (h, A[i]), k, Some(y)))
}

/// `y + h Σ factor_j k_j`; without `y`, the sum alone. As [`super::sums::combine`].
fn record_sum<R: Recorder>(
    recorder: &mut R,
    (h, row): (R::Value, &[Term]),
    k: &[Vec<R::Value>],
    y: Option<&[R::Value]>,
) -> Vec<R::Value> {
    let mut sums: Vec<R::Value> = Vec::new();
    for &(j, factor) in row {
        let factor = recorder.constant(factor);
        let factor = recorder.multiply(h, factor);
        let terms: Vec<R::Value> = k[j].iter().map(|&k| recorder.multiply(factor, k)).collect();
        if sums.is_empty() {
            sums = terms;
        } else {
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum = recorder.add(*sum, term));
        }
    }
    if let Some(y) = y {
        sums.iter_mut().zip(y).for_each(|(sum, &y)| *sum = recorder.add(*sum, y));
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explicit::solve_ode;
    use crate::run::{Control, Start};
    use crate::settings::Settings;
    use crate::system::{Index, Layout, NotFinite, Ode, StepSpan};

    /// Arithmetic that is carried out at once.
    struct Eager;

    impl Recorder for Eager {
        type Value = f64;

        fn constant(&mut self, value: f64) -> f64 {
            value
        }

        fn add(&mut self, a: f64, b: f64) -> f64 {
            a + b
        }

        fn multiply(&mut self, a: f64, b: f64) -> f64 {
            a * b
        }
    }

    /// A driven oscillator of Van der Pol, which has whole steps or not.
    struct Oscillator {
        layout: Layout,
        has_whole_steps: bool,
        n_whole_steps: usize,
    }

    fn slope(t: f64, y: &[f64]) -> Vec<f64> {
        vec![y[1], 2.0 * (1.0 - y[0] * y[0]) * y[1] - y[0] + (3.0 * t).sin()]
    }

    impl Ode for Oscillator {
        fn layout(&self) -> &Layout {
            &self.layout
        }

        fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
            ydot.copy_from_slice(&slope(t, y));
            Ok(())
        }

        fn whole_step(
            &mut self,
            StepSpan { t, h, .. }: StepSpan,
            y: &[f64],
            ydot: &[f64],
            results: &mut Vec<f64>,
        ) -> bool {
            if self.has_whole_steps {
                let f = |_: &mut Eager, t: f64, y: &[f64]| slope(t, y);
                *results = record_step(&mut Eager, [t, h], (y, ydot), f);
                self.n_whole_steps += 1;
            }
            self.has_whole_steps
        }
    }

    #[test]
    fn whole_steps_give_the_bits_of_their_stages() {
        let run = |has_whole_steps: bool| {
            let layout = Layout::from_groups(&[(2, Index::One)]);
            let mut system = Oscillator { layout, has_whole_steps, n_whole_steps: 0 };
            let start = Start { t: 0.0, y: vec![2.0, 0.0], ydot: vec![0.0; 2] };
            let mut middles = Vec::new();
            let mut observe = |step: &crate::dense::Step<'_>| {
                let mut y = [0.0; 2];
                step.at(0.5 * (step.t0() + step.t1()), &mut y);
                middles.push((step.t1().to_bits(), y.map(f64::to_bits)));
                Control::Continue
            };
            let settings = Settings { rtol: 1e-9, ..Settings::default() };
            let outcome = solve_ode(&mut system, start, 20.0, settings, &mut observe);
            let stats = outcome.expect("it runs").stats;
            (middles, stats, system.n_whole_steps)
        };
        let (stages, stats, none) = run(false);
        let (whole, stats_of_whole, n) = run(true);
        assert_eq!((stages, stats), (whole, stats_of_whole));
        assert!(none == 0 && n > 50, "{n} whole steps");
    }
}
