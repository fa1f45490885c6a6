//! One attempt at an explicit step: stages, result, error estimate, extension. No policy.

use super::coefficients::{A, C, D, E3, E5, N_EXTENDED, N_STAGES, Term};
use crate::dense::ContinuousExtension;
use crate::error::WorstUnknown;
use crate::scale::{Scale, Unit};
use crate::settings::Settings;
use crate::stats::Stats;
use crate::system::{Index, Layout, NotFinite, Ode};

/// Buffers of one step, allocated once.
pub(super) struct StageWork {
    /// `k_0 … k_15`, one after the other.
    k: Vec<f64>,
    /// Argument of the stage evaluated last.
    argument: Vec<f64>,
    /// Argument of stage 11, which lies at the end of the step.
    last_argument: Vec<f64>,
    /// End of the step and its derivative.
    pub(super) y1: Vec<f64>,
    pub(super) f1: Vec<f64>,
    error5: Vec<f64>,
    error3: Vec<f64>,
    scale: Scale,
    unit: Unit,
    /// All [`Index::One`]: powers of `h` do not enter.
    index: Vec<Index>,
}

impl StageWork {
    pub(super) fn new(n: usize, settings: &Settings) -> Self {
        let zero = || vec![0.0; n];
        Self {
            k: vec![0.0; N_EXTENDED * n],
            argument: zero(),
            last_argument: zero(),
            y1: zero(),
            f1: zero(),
            error5: zero(),
            error3: zero(),
            scale: Scale::new(n),
            unit: Unit::new(settings),
            index: vec![Index::One; n],
        }
    }

    /// `f(t, y)`, with every entry finite.
    pub(super) fn evaluate<S: Ode>(
        &mut self,
        system: &mut S,
        t: f64,
        y: &[f64],
        out: &mut [f64],
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        self.argument.copy_from_slice(y);
        derivative(system, t, y, out, stats)
    }

    /// StageWork 1 to 11 and `y1`, from `(y, f(t, y))`.
    pub(super) fn step<S: Ode>(
        &mut self,
        system: &mut S,
        (t, h): (f64, f64),
        (y, ydot): (&[f64], &[f64]),
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        let n = y.len();
        self.k[..n].copy_from_slice(ydot);
        for i in 1..N_STAGES {
            self.stage(system, i, (t, h), y, stats)?;
        }
        self.last_argument.copy_from_slice(&self.argument);
        combine(h, A[N_STAGES], &self.k, &mut self.y1);
        self.y1.iter_mut().zip(y).for_each(|(y1, y)| *y1 += y);
        Ok(())
    }

    fn stage<S: Ode>(
        &mut self,
        system: &mut S,
        i: usize,
        (t, h): (f64, f64),
        y: &[f64],
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        let n = y.len();
        combine(h, A[i], &self.k, &mut self.argument);
        self.argument.iter_mut().zip(y).for_each(|(argument, y)| *argument += y);
        let (_, rest) = self.k.split_at_mut(i * n);
        derivative(system, t + C[i] * h, &self.argument, &mut rest[..n], stats)
    }

    /// The error estimate in units of the tolerance, and [`StageWork::worst`] prepared.
    pub(super) fn error(&mut self, h: f64, y: &[f64]) -> f64 {
        // The larger of both ends is the magnitude an error is relative to.
        for ((size, y), y1) in self.argument.iter_mut().zip(y).zip(&self.y1) {
            *size = y.abs().max(y1.abs());
        }
        self.scale.update(&self.unit, &self.index, &self.argument, 1.0);
        combine(h, E5, &self.k, &mut self.error5);
        combine(h, E3, &self.k, &mut self.error3);
        let [five, three] = [self.scale.rms(&self.error5), self.scale.rms(&self.error3)];
        if five == 0.0 && three == 0.0 {
            return 0.0;
        }
        five * five / (five * five + 0.01 * three * three).sqrt()
    }

    /// Projects the end of the step and evaluates `f` there.
    pub(super) fn finish<S: Ode>(
        &mut self,
        system: &mut S,
        t1: f64,
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        system.project(t1, &mut self.y1)?;
        self.argument.copy_from_slice(&self.y1);
        derivative(system, t1, &self.y1, &mut self.f1, stats)
    }

    /// `|h| ρ`, see `stiffness`.
    pub(super) fn stability(&mut self, h: f64) -> f64 {
        let n = self.y1.len();
        let last = &self.k[(N_STAGES - 1) * n..N_STAGES * n];
        for (difference, (f1, k)) in self.error5.iter_mut().zip(self.f1.iter().zip(last)) {
            *difference = f1 - k;
        }
        for (difference, (y1, argument)) in
            self.error3.iter_mut().zip(self.y1.iter().zip(&self.last_argument))
        {
            *difference = y1 - argument;
        }
        let ratio = self.scale.rms(&self.error5) / self.scale.rms(&self.error3);
        if ratio.is_finite() { ratio * h.abs() } else { 0.0 }
    }

    /// The extra stages, and the extension of the step from `last.y0` to `y1`.
    pub(super) fn extend<S: Ode>(
        &mut self,
        system: &mut S,
        last: &mut ContinuousExtension,
        y1: &[f64],
        f1: &[f64],
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        let (n, at) = (y1.len(), (last.t0, last.h));
        self.k[N_STAGES * n..(N_STAGES + 1) * n].copy_from_slice(f1);
        for i in N_STAGES + 1..N_EXTENDED {
            self.stage(system, i, at, &last.y0, stats)?;
        }
        for i in 0..n {
            let change = y1[i] - last.y0[i];
            let second = last.h * self.k[i] - change;
            last.terms[i] = change;
            last.terms[n + i] = second;
            last.terms[2 * n + i] = change - last.h * f1[i] - second;
        }
        for (row, terms) in D.iter().zip(last.terms[3 * n..].chunks_exact_mut(n.max(1))) {
            combine(last.h, row, &self.k, terms);
        }
        Ok(())
    }

    /// Size of the first step (HNW1 §II.4, starting step size; code of `DOP853`): a trial step of
    /// Euler's method shows the second derivative.
    pub(super) fn first_step<S: Ode>(
        &mut self,
        system: &mut S,
        (t, span): (f64, f64),
        (y, f): (&[f64], &[f64]),
        stats: &mut Stats,
    ) -> f64 {
        self.scale.update(&self.unit, &self.index, y, 1.0);
        let (size, slope) = (self.scale.rms(y), self.scale.rms(f));
        let trial = if size.min(slope) <= 1e-5 { 1e-6 } else { 0.01 * size / slope };
        let trial = trial.min(span.abs()).copysign(span);

        for (argument, (y, f)) in self.argument.iter_mut().zip(y.iter().zip(f)) {
            *argument = y + trial * f;
        }
        if derivative(system, t + trial, &self.argument, &mut self.f1, stats).is_err() {
            return 0.01 * trial.abs();
        }
        self.f1.iter_mut().zip(f).for_each(|(f1, f)| *f1 -= f);
        let curvature = self.scale.rms(&self.f1) / trial.abs();
        let largest = slope.max(curvature);
        let guess = if largest <= 1e-15 {
            1e-6f64.max(1e-3 * trial.abs())
        } else {
            (0.01 / largest).powf(1.0 / 8.0)
        };
        guess.min(100.0 * trial.abs())
    }

    /// Argument of the stage evaluated last.
    pub(super) fn argument(&self) -> &[f64] {
        &self.argument
    }

    /// The unknowns with the largest scaled error of order 5 in the last estimate.
    pub(super) fn worst(&self, layout: &Layout) -> Vec<WorstUnknown> {
        self.scale.worst(layout, &self.error5)
    }
}

/// `out = h Σ factor_j k_j`.
fn combine(h: f64, row: &[Term], k: &[f64], out: &mut [f64]) {
    let n = out.len();
    out.fill(0.0);
    for &(j, factor) in row {
        let factor = h * factor;
        for (out, k) in out.iter_mut().zip(&k[j * n..(j + 1) * n]) {
            *out += factor * k;
        }
    }
}

fn derivative<S: Ode>(
    system: &mut S,
    t: f64,
    y: &[f64],
    out: &mut [f64],
    stats: &mut Stats,
) -> Result<(), NotFinite> {
    stats.n_residual += 1;
    system.derivative(t, y, out)?;
    out.iter().position(|x| !x.is_finite()).map_or(Ok(()), |row| Err(NotFinite { row }))
}
