//! One attempt at a step: Jacobian, factors, prediction, Newton's iteration, error estimate.
//!
//! Mechanism only: which size to try and what to do with the outcome is decided in `solve`.

use crate::checkpoint::{Loader, Saver};
use crate::contraction::{Contraction, Retreat};
use crate::dense::CollocationPolynomial;
use crate::error::{Cause, SolveError, WorstUnknown};
use crate::estimate::{Filter, error_estimate};
use crate::iteration_matrix::{IterationMatrix, Jacobian};
use crate::newton::{NewtonWork, Point};
use crate::order::{Gammas, Smoothness};
use crate::scale::Unit;
use crate::settings::{ErrorTest, Order, Settings, Stages, StepControl};
use crate::stats::Stats;
use crate::system::{Index, Layout, System};
use crate::tableau::Tableau;

/// Newton iterations allowed beyond the number of stages.
const EXTRA_ITERATIONS: usize = 6;
/// Newton iterations allowed with a fixed step, which cannot be cut.
const FIXED_STEP_ITERATIONS: usize = 25;

/// The Jacobian is evaluated at this part of a step, on the last polynomial continued.
///
/// `RADAU5` evaluates it at the start. It represents those of all stages, which lie closer to the
/// end: on mechanisms, whose steps are limited by Newton's iteration, the better point makes steps
/// longer by half. Measured from 0 to 0.7, 0.65 takes least work, 0.6 two per cent more, 0.5 five.
const AHEAD: f64 = 0.65;
/// After so many failures the polynomial is not trusted, and the start of the step taken.
const FAILURES_AHEAD: usize = 2;

/// Outcome of an attempt.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Attempt {
    /// The stage equations are solved; `error` is the estimate, `None` without error control.
    Solved { error: Option<f64> },
    /// They are not; a step cut by `shrink` might do, or a new Jacobian when it `is_stale`.
    Failed { cause: Cause, shrink: f64, is_stale: bool },
}

/// State of the method between two steps, and all buffers.
pub(crate) struct Stepper {
    /// The methods of this run by ascending order, and the index of the one in use.
    tableaus: Vec<&'static Tableau>,
    current: usize,
    work: NewtonWork,
    unit: Unit,
    has_error_control: bool,
    error_test: ErrorTest,
    keep_jacobian_below: f64,
    jacobian: Jacobian,
    matrix: IterationMatrix,
    /// Age of the Jacobian.
    freshness: Freshness,
    /// It was evaluated ahead of the start.
    is_ahead: bool,
    /// Failures of Newton's iteration in the present step.
    n_failed: usize,
    /// Step size of the factors, if they belong to the Jacobian.
    factored_h: Option<f64>,
}

/// Age of the Jacobian.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Freshness {
    /// Evaluated for the present step.
    Current,
    /// Of an earlier step, and still contracting well.
    Kept,
    /// Must be evaluated before the next attempt.
    Expired,
}

/// Newton iterations allowed in one step.
pub(crate) fn max_iterations(settings: &Settings, stages: usize) -> usize {
    settings.newton.max_iterations.unwrap_or(match settings.step {
        StepControl::Adaptive => EXTRA_ITERATIONS + stages,
        StepControl::Fixed { .. } => FIXED_STEP_ITERATIONS,
    })
}

/// Rounding of one evaluation, relative to the state.
const ROUNDING: f64 = 100.0 * f64::EPSILON;
/// Where corrections stop shrinking, this many roundings may be their cause,
const ROUNDINGS_AT_STALL: f64 = 1e3;
/// and a stall beyond this fraction of the error tolerance is never accepted.
const MAX_STALL: f64 = 1e-2;
/// Largest default of `kappa` is this over `γ²`.
///
/// The error that Newton's iteration leaves in a constraint of index 3 enters the next error
/// estimate times `γ²`, at any step size, and would make the error test fail for ever. HW2 §IV.8
/// advises `10⁻¹` to `10⁻²` without the division; measured on mechanisms, the smaller value gains
/// half a digit to a digit for a sixth more work.
const MAX_KAPPA_GAMMA_SQUARED: f64 = 1e-2;

/// The monitor of Newton's iteration, with the tolerances of these settings.
fn contraction(settings: &Settings, tableau: &Tableau) -> Contraction {
    let gamma = tableau.gamma;
    let (tolerance, lax, retreat) = match settings.step {
        StepControl::Adaptive => {
            let (kappa, rtol) = (settings.newton.kappa, settings.rtol);
            let rounding = ROUNDING / rtol;
            let default = || rtol.sqrt().min(MAX_KAPPA_GAMMA_SQUARED / (gamma * gamma));
            let tolerance = kappa.unwrap_or_else(default).max(rounding.min(MAX_STALL));
            (
                tolerance,
                tolerance.max((ROUNDINGS_AT_STALL * rounding).min(MAX_STALL)),
                Retreat::Shrink,
            )
        }
        StepControl::Fixed { newton_tolerance, .. } => {
            let lax = newton_tolerance.max(ROUNDINGS_AT_STALL * ROUNDING);
            (newton_tolerance, lax, Retreat::None)
        }
    };
    Contraction::new(tolerance, lax, max_iterations(settings, tableau.s), retreat)
}

/// Largest last coefficient of the polynomial of a step, in tolerances: dense output and events rest on it.
const LARGEST_TAIL: f64 = 1e4;

impl Stepper {
    pub(crate) fn new<S: System>(system: &S, settings: &Settings) -> Result<Self, SolveError> {
        let tableaus: Vec<&Tableau> = match settings.order {
            Order::Fixed(stages) => vec![Tableau::of(stages)],
            Order::Auto => [Stages::Three, Stages::Five, Stages::Seven].map(Tableau::of).into(),
        };
        let (tableau, s_max) = (&tableaus[0], tableaus[tableaus.len() - 1].s);
        let n_complex = (s_max - 1) / 2;
        let pattern = system.pattern();
        // Buffers are made for the largest method, then cut to the first.
        let mut work = NewtonWork::new(pattern.n(), s_max, contraction(settings, tableau));
        work.set_stages(tableau.s, contraction(settings, tableau));
        let matrix = IterationMatrix::new(system, n_complex, settings.linear_solver)?;
        Ok(Self {
            work,
            unit: Unit::new(settings),
            has_error_control: settings.step == StepControl::Adaptive,
            error_test: settings.error_test,
            keep_jacobian_below: settings.newton.keep_jacobian_below.unwrap_or(
                match (settings.order, settings.step) {
                    (Order::Fixed(_), StepControl::Adaptive) => 1e-2,
                    _ => 1e-3,
                },
            ),
            jacobian: Jacobian::new(pattern.n_entries()),
            matrix,
            freshness: Freshness::Expired,
            is_ahead: false,
            n_failed: 0,
            factored_h: None,
            tableaus,
            current: 0,
        })
    }

    /// The method in use.
    pub(crate) fn tableau(&self) -> &Tableau {
        self.tableaus[self.current]
    }

    /// Nodes of the method with most stages.
    pub(crate) fn largest(&self) -> &[f64] {
        &self.tableaus[self.tableaus.len() - 1].c
    }

    /// Continues with another number of stages. The Jacobian is kept; the factors cannot be, as
    /// no two of the methods share an eigenvalue.
    pub(crate) fn set_order(&mut self, stages: Stages, settings: &Settings) {
        let k = self.tableaus.iter().position(|tableau| tableau.stages == stages);
        self.current = k.expect("the order changes between the methods of this run");
        let tableau = &self.tableaus[self.current];
        self.work.set_stages(tableau.s, contraction(settings, tableau));
        self.factored_h = None;
    }

    /// Number of stages in use.
    pub(crate) fn stages(&self) -> Stages {
        self.tableau().stages
    }

    /// The method of the last accepted step, which had `s` stages, and its factors with the step
    /// size that they are known to belong to. A change of order leaves the factors as they are.
    pub(crate) fn last_factors(
        &mut self,
        s: usize,
    ) -> (&Tableau, &mut IterationMatrix, &mut Option<f64>) {
        let k = self.tableaus.iter().position(|tableau| tableau.s == s);
        let k = k.expect("the last step was taken by a method of this run");
        (self.tableaus[k], &mut self.matrix, &mut self.factored_h)
    }

    /// The real eigenvalues of the methods that variable order chooses from.
    pub(crate) fn gammas(&self) -> Gammas {
        let [three, five, seven] = self.tableaus.as_slice() else {
            unreachable!("variable order has three methods")
        };
        [three.gamma, five.gamma, seven.gamma]
    }

    /// Smoothness of the solution, as the step just accepted shows it.
    pub(crate) fn smoothness(&mut self, h: f64, error: f64) -> Smoothness {
        let tail = [self.tail(0), self.tail(1)];
        Smoothness { h, error, tail, rate: self.work.contraction.rate() }
    }

    /// Size of one of the last two coefficients of the collocation polynomial, of the unknowns that are tested.
    fn tail(&mut self, k: usize) -> f64 {
        let NewtonWork { z, defect, scale, .. } = &mut self.work;
        let n = scale.len();
        let coefficient = &mut defect[..n];
        coefficient.fill(0.0);
        for (z, factor) in z.chunks_exact(n.max(1)).zip(&self.tableaus[self.current].tail[k]) {
            coefficient.iter_mut().zip(z).for_each(|(sum, z)| *sum += factor * z);
        }
        scale.rms_tested(coefficient)
    }

    /// Tries one step of size `at.h` from `at`.
    ///
    /// `last` predicts the stages; without it they start on the tangent.
    pub(crate) fn attempt<S: System>(
        &mut self,
        system: &mut S,
        at: Point<'_>,
        last: Option<&CollocationPolynomial>,
        filter: Filter,
        stats: &mut Stats,
    ) -> Attempt {
        // Weights of the errors and starting values of the stages.
        self.work.scale.update(&self.unit, system.layout().index(), at.y, at.h);
        self.predict(at, last);

        // Linearise and factor, unless the old factors serve.
        let is_same_matrix = self.factored_h == Some(at.h) && self.freshness != Freshness::Expired;
        if let Err(cause) = self.prepare_matrix(system, at, last, stats) {
            return Attempt::Failed { cause, shrink: 0.5, is_stale: false };
        }

        // Solve for the stages.
        self.work.contraction.start(is_same_matrix);
        if let Err(failure) =
            self.work.solve(system, at, self.tableaus[self.current], &mut self.matrix, stats)
        {
            self.n_failed += 1;
            let is_stale = self.freshness == Freshness::Kept;
            if is_stale || (self.is_ahead && self.n_failed >= FAILURES_AHEAD) {
                self.freshness = Freshness::Expired;
            }
            return Attempt::Failed { cause: failure.cause, shrink: failure.shrink, is_stale };
        }

        // Estimate the error.
        if !self.has_error_control {
            return Attempt::Solved { error: None };
        }
        let error = error_estimate(
            system,
            at,
            self.tableaus[self.current],
            &mut self.matrix,
            &mut self.work,
            filter,
            stats,
        );
        // Where constraints leave no freedom, the ends of steps have no error however long they are.
        let error = error.max(self.tail(1) / LARGEST_TAIL);
        if error.is_finite() {
            Attempt::Solved { error: Some(error) }
        } else {
            Attempt::Failed { cause: Cause::ErrorTest, shrink: 0.5, is_stale: false }
        }
    }

    /// Takes over a solved step: its polynomial into `last`; returns state and derivative at its
    /// end, which are those of the last stage, `y1 = y0 + z_s`.
    pub(crate) fn finish(
        &mut self,
        at: Point<'_>,
        last: &mut CollocationPolynomial,
    ) -> (&[f64], &[f64]) {
        let tableau = &self.tableaus[self.current];
        self.work.load_end(at, tableau);
        last.set(at, &tableau.c, &self.work.z);
        (&self.work.y_stage, &self.work.ydot_stage)
    }

    /// Newton iterations of the last attempt.
    pub(crate) fn iterations(&self) -> usize {
        self.work.contraction.iterations()
    }

    /// Contraction of Newton's iteration in the last attempt, once there were two iterations.
    pub(crate) fn rate(&self) -> Option<f64> {
        self.work.contraction.rate()
    }

    /// The unknowns of the last attempt with the largest error, if that failed, or else with the
    /// largest Newton correction.
    pub(crate) fn worst(&self, layout: &Layout, cause: Cause) -> Vec<WorstUnknown> {
        let NewtonWork { error, delta, scale, .. } = &self.work;
        scale.worst(layout, if cause == Cause::ErrorTest { error } else { delta })
    }

    /// State at which the system was evaluated last.
    pub(crate) fn last_tried(&self) -> &[f64] {
        &self.work.y_stage
    }

    /// Takes note that the step was accepted: the Jacobian has aged.
    ///
    /// Returns whether it is still good, which makes keeping the step size worthwhile.
    pub(crate) fn age_jacobian(&mut self) -> bool {
        self.n_failed = 0;
        // One iteration shows no rate, and needs none.
        let rate = self.rate().unwrap_or(0.0);
        let is_good = rate < self.keep_jacobian_below;
        self.freshness = if is_good { Freshness::Kept } else { Freshness::Expired };
        is_good
    }

    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.count(self.tableau().s);
        saver.count(match self.freshness {
            Freshness::Current => 0,
            Freshness::Kept => 1,
            Freshness::Expired => 2,
        });
        saver.option(self.factored_h);
        saver.real(self.work.contraction.eta());
        saver.slice(&self.jacobian.df_dy);
        saver.slice(&self.jacobian.df_dydot);
        self.matrix.save(saver);
    }

    /// Makes the factors again; they come out the same.
    pub(crate) fn load<S: System>(
        &mut self,
        loader: &mut Loader<'_>,
        system: &S,
        settings: &Settings,
    ) -> Result<(), SolveError> {
        let s = loader.count()?;
        let Some(k) = self.tableaus.iter().position(|tableau| tableau.s == s) else {
            return Err(SolveError::Checkpoint { reason: "saved with another order" });
        };
        self.current = k;
        let tableau = &self.tableaus[k];
        self.work.set_stages(s, contraction(settings, tableau));
        self.freshness = match loader.index(3)? {
            0 => Freshness::Current,
            1 => Freshness::Kept,
            _ => Freshness::Expired,
        };
        let factored_h = loader.option()?;
        self.work.contraction.set_eta(loader.real()?);
        loader.fill(&mut self.jacobian.df_dy)?;
        loader.fill(&mut self.jacobian.df_dydot)?;
        self.matrix.load(loader)?;
        if self.freshness != Freshness::Expired {
            self.choose_tested(system);
        }
        self.factored_h = None;
        if let Some(h) = factored_h {
            let Tableau { gamma, lambda, .. } = &self.tableaus[self.current];
            self.matrix
                .factor(&self.jacobian, *gamma, lambda, h)
                .map_err(|_| SolveError::Checkpoint { reason: "its matrix is singular" })?;
            self.factored_h = Some(h);
        }
        Ok(())
    }

    /// Has the Jacobian evaluated before the next attempt.
    pub(crate) fn expire_jacobian(&mut self) {
        self.freshness = Freshness::Expired;
    }

    /// Starting values of the stages: the last polynomial continued (HW2 §IV.8), or the
    /// tangent.
    fn predict(&mut self, at: Point<'_>, last: Option<&CollocationPolynomial>) {
        let n = at.y.len();
        for (z, c) in self.work.z.chunks_exact_mut(n.max(1)).zip(&self.tableaus[self.current].c) {
            match last {
                Some(last) => last.change_after_end_into(1.0 + c * at.h / last.h, z),
                None => z.iter_mut().zip(at.ydot).for_each(|(z, ydot)| *z = c * at.h * ydot),
            }
        }
    }

    /// Takes multipliers out of the error test where the settings ask for it.
    fn choose_tested<S: System>(&mut self, system: &S) {
        if self.error_test == ErrorTest::WithoutMultipliers {
            let (index, pattern) = (system.layout().index(), system.pattern());
            let jacobian = &self.jacobian;
            self.work
                .scale
                .test_only(|i| index[i] != Index::Two || !jacobian.is_algebraic(pattern, i));
        }
    }

    fn prepare_matrix<S: System>(
        &mut self,
        system: &mut S,
        at: Point<'_>,
        last: Option<&CollocationPolynomial>,
        stats: &mut Stats,
    ) -> Result<(), Cause> {
        if self.freshness == Freshness::Expired {
            self.factored_h = None;
            let last = last.filter(|_| self.n_failed < FAILURES_AHEAD);
            self.is_ahead = last.is_some_and(|last| self.linearise_ahead(system, at, last, stats));
            if !self.is_ahead {
                let (y, ydot) = (at.y, at.ydot);
                stats.n_jacobian += 1;
                self.jacobian.evaluate(system, at.t, y, ydot)?;
            }
            self.freshness = Freshness::Current;
            self.choose_tested(system);
        }
        if self.factored_h != Some(at.h) {
            self.factored_h = None;
            stats.n_factor += 1;
            let Tableau { gamma, lambda, .. } = &self.tableaus[self.current];
            self.matrix
                .factor(&self.jacobian, *gamma, lambda, at.h)
                .map_err(|_| Cause::Singular)?;
            self.factored_h = Some(at.h);
        }
        Ok(())
    }

    /// Evaluates the Jacobian where the last polynomial expects the solution; false where it has
    /// no value.
    fn linearise_ahead<S: System>(
        &mut self,
        system: &mut S,
        at: Point<'_>,
        last: &CollocationPolynomial,
        stats: &mut Stats,
    ) -> bool {
        let NewtonWork { y_stage, ydot_stage, .. } = &mut self.work;
        let tau = 1.0 + AHEAD * at.h / last.h;
        last.value_into(tau, y_stage);
        last.derivative_into(tau, ydot_stage);
        stats.n_jacobian += 1;
        self.jacobian.evaluate(system, at.t + AHEAD * at.h, y_stage, ydot_stage).is_ok()
    }
}
