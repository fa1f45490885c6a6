//! One attempt at an explicit step: stages, result, error estimate, extension. No policy.

use super::coefficients::{A, C, D, E3, E5, N_EXTENDED, N_STAGES, Term};
use super::derivative;
use super::stiffness::Pair;
use super::straight_line::StepVectors;
use super::sums::{Columns, combine};
use crate::dense::ContinuousExtension;
use crate::error::WorstUnknown;
use crate::scale::{Scale, Unit};
use crate::settings::Settings;
use crate::stats::Stats;
use crate::system::{Layout, NotFinite, Ode, StepSpan};

/// Buffers of one step, allocated once.
pub(super) struct StageWork {
    /// `k_0 … k_15`.
    k: Columns,
    /// Start of the step.
    y0: Columns,
    /// Argument of the stage evaluated last.
    argument: Columns,
    /// Argument of stage 11, which lies at the end of the step.
    last_argument: Columns,
    /// End of the step and its derivative.
    pub(super) y1: Columns,
    pub(super) f1: Vec<f64>,
    error5: Columns,
    error3: Columns,
    scale: Scale,
    unit: Unit,
    /// The results of a whole step at once.
    whole: Vec<f64>,
    /// True where the stages, the end before any projection and the errors are among those alone.
    is_whole: bool,
}

impl StageWork {
    pub(super) fn new(n: usize, settings: &Settings) -> Self {
        let zero = || Columns::new(n, 1);
        Self {
            k: Columns::new(n, N_EXTENDED),
            y0: zero(),
            argument: zero(),
            last_argument: zero(),
            y1: zero(),
            f1: vec![0.0; n],
            error5: zero(),
            error3: zero(),
            scale: Scale::new(n),
            unit: Unit::new(settings),
            whole: Vec::new(),
            is_whole: false,
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
        self.argument.values_mut().copy_from_slice(y);
        derivative(system, t, y, out, stats)
    }

    /// Stages 1 to 11 and `y1`, from `(y, f(t, y))`.
    pub(super) fn step<S: Ode>(
        &mut self,
        system: &mut S,
        span @ StepSpan { t, h, .. }: StepSpan,
        (y, ydot): (&[f64], &[f64]),
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        self.is_whole = self.whole(system, span, (y, ydot));
        if self.is_whole {
            stats.n_residual += N_STAGES - 1;
            return Ok(());
        }
        self.y0.values_mut().copy_from_slice(y);
        self.k.column_mut(0).copy_from_slice(ydot);
        for i in 1..N_STAGES {
            self.stage(system, i, (t, h), stats)?;
        }
        std::mem::swap(&mut self.last_argument, &mut self.argument);
        combine(h, A[N_STAGES], &self.k, Some(&self.y0), &mut self.y1);
        Ok(())
    }

    /// The step as straight-line code, where the system has it.
    fn whole<S: Ode>(
        &mut self,
        system: &mut S,
        span: StepSpan,
        (y, ydot): (&[f64], &[f64]),
    ) -> bool {
        if !system.whole_step(span, y, ydot, &mut self.whole) {
            return false;
        }
        self.y1.values_mut().copy_from_slice(StepVectors::new(y.len(), &self.whole).y1());
        true
    }

    /// The error estimates of order 5 and 3.
    fn errors(&self) -> [&[f64]; 2] {
        if self.is_whole {
            return StepVectors::new(self.f1.len(), &self.whole).errors();
        }
        [self.error5.values(), self.error3.values()]
    }

    fn stage<S: Ode>(
        &mut self,
        system: &mut S,
        i: usize,
        (t, h): (f64, f64),
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        combine(h, A[i], &self.k, Some(&self.y0), &mut self.argument);
        derivative(system, t + C[i] * h, self.argument.values(), self.k.column_mut(i), stats)
    }

    /// The error estimate in units of the tolerance, and [`StageWork::worst`] prepared.
    pub(super) fn error(&mut self, h: f64, y: &[f64]) -> f64 {
        // The larger of both ends is the magnitude an error is relative to.
        self.scale.weigh(&self.unit, [y, self.y1.values()]);
        if !self.is_whole {
            combine(h, E5, &self.k, None, &mut self.error5);
            combine(h, E3, &self.k, None, &mut self.error3);
        }
        let [five, three] = self.errors().map(|error| self.scale.mean_square(error));
        if five == 0.0 && three == 0.0 {
            return 0.0;
        }
        five / (five + 0.01 * three).sqrt()
    }

    /// Projects the end of the step and evaluates `f` there.
    pub(super) fn finish<S: Ode>(
        &mut self,
        system: &mut S,
        t1: f64,
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        if self.is_whole && system.whole_end(t1, &self.whole, self.y1.values_mut(), &mut self.f1) {
            stats.n_residual += 1;
            return Ok(());
        }
        system.project(t1, self.y1.values_mut())?;
        let found = derivative(system, t1, self.y1.values(), &mut self.f1, stats);
        if found.is_err() {
            self.argument.values_mut().copy_from_slice(self.y1.values());
        }
        found
    }

    /// `|h| ρ` and the decay, see `stiffness`; zero where the two states are as good as one.
    pub(super) fn stability(&self, h: f64) -> Pair {
        let (last, argument) = if self.is_whole {
            let step = StepVectors::new(self.f1.len(), &self.whole);
            (step.k(N_STAGES - 1), step.last_argument())
        } else {
            (self.k.column(N_STAGES - 1), self.last_argument.values())
        };
        let distance = self.scale.rms_of_difference(self.y1.values(), argument);
        let speed = self.scale.rms_of_difference(&self.f1, last);
        let ratio = speed / distance;
        if !ratio.is_finite() || ratio == 0.0 {
            return Pair::default();
        }
        let states = [self.y1.values(), argument];
        let along = self.scale.product_of_differences(states, [&self.f1, last]);
        Pair { h_rho: ratio * h.abs(), decay: -along * h.signum() / (speed * distance) }
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
        if self.is_whole {
            // Where the step has been accepted, the run has left its first derivative in exchange for the last.
            let step = StepVectors::new(n, &self.whole);
            self.y0.values_mut().copy_from_slice(&last.y0);
            self.k.column_mut(0).copy_from_slice(&self.f1);
            (1..N_STAGES).for_each(|i| self.k.column_mut(i).copy_from_slice(step.k(i)));
        }
        self.k.column_mut(N_STAGES).copy_from_slice(f1);
        for i in N_STAGES + 1..N_EXTENDED {
            self.stage(system, i, at, stats)?;
        }
        for (i, &f0) in self.k.column(0).iter().enumerate() {
            last.take_ends(i, (f0, y1[i], f1[i]));
        }
        for (row, terms) in D.iter().zip(last.terms[3 * n..].chunks_exact_mut(n.max(1))) {
            combine(last.h, row, &self.k, None, &mut self.argument);
            terms.copy_from_slice(self.argument.values());
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
        self.scale.weigh(&self.unit, [y, y]);
        let (size, slope) = (self.scale.rms(y), self.scale.rms(f));
        let trial = if size.min(slope) <= 1e-5 { 1e-6 } else { 0.01 * size / slope };
        let trial = trial.min(span.abs()).copysign(span);

        for (argument, (y, f)) in self.argument.values_mut().iter_mut().zip(y.iter().zip(f)) {
            *argument = y + trial * f;
        }
        if derivative(system, t + trial, self.argument.values(), &mut self.f1, stats).is_err() {
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

    /// The error estimate of one unknown in the last step, of size `h`.
    pub(super) fn error_of(&self, i: usize, h: f64) -> f64 {
        let [five, three] = if self.is_whole {
            self.errors().map(|error| error[i])
        } else {
            let sum = |row: &[Term]| row.iter().map(|&(j, e)| e * self.k.column(j)[i]).sum::<f64>();
            [h * sum(E5), h * sum(E3)]
        };
        if five == 0.0 { 0.0 } else { five * five / (five * five + 0.01 * three * three).sqrt() }
    }

    /// Argument of the stage evaluated last.
    pub(super) fn argument(&self) -> &[f64] {
        self.argument.values()
    }

    /// The unknowns with the largest scaled error of order 5 in the last estimate.
    pub(super) fn worst(&self, layout: &Layout) -> Vec<WorstUnknown> {
        self.scale.worst(layout, self.errors()[0])
    }
}
