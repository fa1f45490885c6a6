//! Sensitivities `s_k = ∂y/∂p_k` to parameters and initial values, by the staggered direct method.
//!
//! ```text
//! F_y s_k + F_y′ s_k′ + F_{p_k} = 0                                  along the solution
//! F_y(i) (s_k + ζ_i) + F_y′(i) (1/h) Σ_j (A⁻¹)_ij ζ_j + F_{p_k}(i) = 0     i = 1 … s stages
//! ```
//!
//! After every accepted step the linear stage equations, with the derivatives taken at the solved
//! stages, are iterated with the factors of that step until they hold; so the sensitivities are
//! the derivatives of the discrete solution, and have its order (M. Caracotsios and
//! W. E. Stewart, Comput. Chem. Eng. 9 (1985) 359–365, the staggered method; here for Radau IIA).
//! Step sizes follow the solution alone, whose steps and bits are those of a run without
//! sensitivities. Parameters that only initial values depend on have `F_p = 0`.

use crate::checkpoint::{Checkpoint, Loader, Method, Saver};
use crate::dense::{CollocationPolynomial, Step};
use crate::error::{Cause, SolveError, Standstill};
use crate::iteration_matrix::{IterationMatrix, Jacobian};
use crate::lanes::multiply_blocks;
use crate::limits::{check_finite, check_length};
use crate::newton::Point;
use crate::run::Start;
use crate::settings::Settings;
use crate::solve::Solver;
use crate::system::{Index, NotFinite, Pattern, System};
use crate::tableau::Tableau;

/// A system that knows its derivatives by parameters.
pub trait SensitivitySystem: System {
    /// Number of parameters.
    fn n_parameters(&self) -> usize;

    /// Writes `∂F/∂p_k` to `out`, one column of length `n` after the other.
    ///
    /// # Errors
    /// [`NotFinite`] names the first row that has no finite value.
    fn parameter_jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite>;
}

/// Sensitivities where a run starts, one vector of length `n` per parameter.
///
/// Like the state they must be consistent: `F_y s + F_y′ s′ + F_p = 0`, and the derivatives of all
/// constraints. Values without memory, those of multipliers, may be zero; so may `sdot`, which only
/// starts the first iteration.
#[derive(Clone, PartialEq, Debug)]
pub struct SensitivityStart {
    /// `∂y/∂p_k`.
    pub s: Vec<Vec<f64>>,
    /// `∂y′/∂p_k`.
    pub sdot: Vec<Vec<f64>>,
}

/// The error left in the stage equations, as a fraction of the error allowed in one step: `rtol` of
/// the largest relative sensitivity.
const KAPPA: f64 = 1e-3;
/// Tolerances below this count as this: a thousandth of it is some fifty roundings, and the factors
/// leave as much.
const SMALLEST_RTOL: f64 = 1e-11;
/// Iterations before new factors are made, and before the run is given up.
const MAX_ITERATIONS: usize = 40;

/// A run with sensitivities, step by step.
pub struct SensitivitySolver<S: SensitivitySystem> {
    solver: Solver<S>,
    /// Sensitivities at the end of the last step: parameters times `n`.
    s: Vec<f64>,
    sdot: Vec<f64>,
    /// Dense output of the last step, by parameter.
    polynomials: Vec<CollocationPolynomial>,
    has_last: bool,
    work: Work,
}

/// Buffers, allocated once; stage vectors follow each other.
struct Work {
    /// `F_y`, `F_y′` at every stage.
    jacobians: Vec<Jacobian>,
    /// `F_p` at every stage: all its columns.
    by_parameters: Vec<f64>,
    y: Vec<f64>,
    /// Derivatives of the stages.
    ydot: Vec<f64>,
    zeta: Vec<f64>,
    rate: Vec<f64>,
    defect: Vec<f64>,
    delta: Vec<f64>,
    /// Tolerance of every unknown at the end of the step, with its power of `h`.
    unit: Vec<f64>,
    rtol: f64,
}

/// An accepted step with its sensitivities.
#[derive(Clone, Copy, Debug)]
pub struct SensitivityStep<'a> {
    /// The step itself.
    pub step: Step<'a>,
    s1: &'a [f64],
    sdot1: &'a [f64],
    polynomials: &'a [CollocationPolynomial],
}

impl<'a> SensitivityStep<'a> {
    /// `∂y/∂p_k` at the end of the step.
    pub fn s1(&self, k: usize) -> &'a [f64] {
        column(self.s1, self.step.y1().len(), k)
    }

    /// `∂y′/∂p_k` at the end of the step.
    pub fn sdot1(&self, k: usize) -> &'a [f64] {
        column(self.sdot1, self.step.y1().len(), k)
    }

    /// Writes `∂y/∂p_k` at `t` within the step, by the collocation polynomial.
    pub fn s_at(&self, k: usize, t: f64, out: &mut [f64]) {
        self.polynomials[k].value_into((t - self.step.t0()) / self.step.h(), out);
    }
}

fn column(x: &[f64], n: usize, k: usize) -> &[f64] {
    &x[k * n..(k + 1) * n]
}

impl<S: SensitivitySystem> SensitivitySolver<S> {
    /// Checks the input and prepares all buffers.
    ///
    /// # Errors
    /// Those of [`Solver::new`], and [`SolveError::WrongLength`] for sensitivities that do not fit.
    pub fn new(
        system: S,
        start: Start,
        sensitivities: &SensitivityStart,
        t_end: f64,
        settings: Settings,
    ) -> Result<Self, SolveError> {
        let (n, count) = (system.layout().n(), system.n_parameters());
        for (what, given) in [("s", &sensitivities.s), ("sdot", &sensitivities.sdot)] {
            check_length(what, count, given.len())?;
            for column in given {
                check_length(what, n, column.len())?;
                check_finite(what, column)?;
            }
        }
        let solver = Solver::new(system, start, t_end, settings)?;
        let c = solver.stepper.largest();
        let s_max = c.len();
        Ok(Self {
            s: sensitivities.s.concat(),
            sdot: sensitivities.sdot.concat(),
            polynomials: vec![CollocationPolynomial::new(n, c); count],
            has_last: false,
            work: Work::new(n, s_max, count, solver.system.pattern()),
            solver,
        })
    }

    /// The run itself.
    pub fn solver(&self) -> &Solver<S> {
        &self.solver
    }

    /// `∂y/∂p_k` at the time reached.
    pub fn s(&self, k: usize) -> &[f64] {
        column(&self.s, self.solver.y.len(), k)
    }

    /// Takes one accepted step; `None` once `t_end` is reached.
    ///
    /// # Errors
    /// [`SolveError`] when the run cannot go on.
    pub fn step(&mut self) -> Result<Option<SensitivityStep<'_>>, SolveError> {
        if self.solver.step()?.is_none() {
            return Ok(None);
        }
        self.follow().map_err(|cause| self.standstill(cause))?;
        self.has_last = true;
        Ok(Some(SensitivityStep {
            step: self.solver.last_step(),
            s1: &self.s,
            sdot1: &self.sdot,
            polynomials: &self.polynomials,
        }))
    }

    /// Takes the sensitivities over the step just accepted.
    fn follow(&mut self) -> Result<(), Cause> {
        let Self { solver, s, sdot, polynomials, has_last, work } = self;
        let n = solver.y.len();
        if n == 0 {
            return Ok(());
        }
        let Solver { system, last, stepper, settings, stats, y, .. } = solver;
        let (tableau, matrix, factored_h) = stepper.last_factors(last.n_stages());
        stats.n_jacobian += tableau.s;
        work.linearise(system, last, tableau)?;
        work.measure(settings, system.layout().index(), y, last.h);

        for (k, polynomial) in polynomials.iter_mut().enumerate() {
            let range = k * n..(k + 1) * n;
            let (s, sdot) = (&mut s[range.clone()], &mut sdot[range]);
            let at = Point { t: last.t0, h: last.h, y: s, ydot: sdot };
            work.predict(at, tableau, has_last.then_some(&*polynomial));
            let pattern = system.pattern();
            if work.iterate((k, pattern), at, tableau, matrix).is_err() {
                // The factors are too old for the linear equations: make those of a stage between.
                matrix
                    .factor(&work.jacobians[tableau.s / 2], tableau.gamma, &tableau.lambda, last.h)
                    .map_err(|_| Cause::Singular)?;
                *factored_h = None;
                work.predict(at, tableau, None);
                work.iterate((k, pattern), at, tableau, matrix)?;
            }
            polynomial.set(at, &tableau.c, &work.zeta[..tableau.s * n]);
            work.finish(tableau, s, sdot, last.h);
        }
        Ok(())
    }

    fn standstill(&self, cause: Cause) -> SolveError {
        let Solver { last, y, stats, .. } = &self.solver;
        let at =
            Standstill { t: last.t0, h: last.h, worst: Vec::new(), y: y.clone(), stats: *stats };
        let at = Box::new(at);
        match cause {
            Cause::NotFinite { row } => SolveError::NotFinite { row, at },
            _ => SolveError::Sensitivity { cause, at },
        }
    }

    /// The state of the run, between two steps.
    pub fn save(&self) -> Checkpoint {
        let mut checkpoint = self.solver.save();
        let mut saver = Saver::default();
        saver.flag(self.has_last);
        saver.slice(&self.s);
        saver.slice(&self.sdot);
        self.polynomials.iter().for_each(|polynomial| polynomial.save(&mut saver));
        checkpoint.append(saver);
        checkpoint
    }

    /// Continues a saved run, with the same system, settings and end as before, bit for bit.
    ///
    /// # Errors
    /// Those of [`Solver::resume`].
    pub fn resume(
        system: S,
        checkpoint: &Checkpoint,
        t_end: f64,
        settings: Settings,
    ) -> Result<Self, SolveError> {
        let (n, count) = (system.layout().n(), system.n_parameters());
        let mut loader = Loader::new(checkpoint, Method::Radau)?;
        let solver = Solver::load(system, &mut loader, t_end, settings)?;
        let c = solver.stepper.largest();
        let mut run = Self {
            has_last: loader.flag()?,
            s: vec![0.0; n * count],
            sdot: vec![0.0; n * count],
            polynomials: vec![CollocationPolynomial::new(n, c); count],
            work: Work::new(n, c.len(), count, solver.system.pattern()),
            solver,
        };
        loader.fill(&mut run.s)?;
        loader.fill(&mut run.sdot)?;
        run.polynomials.iter_mut().try_for_each(|polynomial| polynomial.load(&mut loader))?;
        Ok(run)
    }
}

impl Work {
    fn new(n: usize, s_max: usize, count: usize, pattern: &Pattern) -> Self {
        let stages = || vec![0.0; s_max * n];
        Self {
            jacobians: vec![Jacobian::new(pattern.n_entries()); s_max],
            by_parameters: vec![0.0; s_max * count * n],
            y: vec![0.0; n],
            ydot: stages(),
            zeta: stages(),
            rate: stages(),
            defect: stages(),
            delta: stages(),
            unit: vec![1.0; n],
            rtol: 0.0,
        }
    }

    /// All derivatives at the stages of the step in `last`.
    fn linearise<S: SensitivitySystem>(
        &mut self,
        system: &mut S,
        last: &CollocationPolynomial,
        tableau: &Tableau,
    ) -> Result<(), Cause> {
        let (n, s) = (last.y0.len(), tableau.s);
        multiply_blocks(&tableau.a_inv, 1.0 / last.h, n, &last.z, &mut self.ydot[..s * n]);
        let width = self.by_parameters.len() / self.jacobians.len();
        for i in 0..s {
            for (y, (y0, z)) in self.y.iter_mut().zip(last.y0.iter().zip(column(&last.z, n, i))) {
                *y = y0 + z;
            }
            let (t, ydot) = (last.t0 + tableau.c[i] * last.h, column(&self.ydot, n, i));
            self.jacobians[i].evaluate(system, t, &self.y, ydot)?;
            let out = &mut self.by_parameters[i * width..(i + 1) * width];
            system
                .parameter_jacobian(t, &self.y, ydot, out)
                .map_err(|not_finite| Cause::NotFinite { row: not_finite.row })?;
            if let Some(k) = out.iter().position(|x| !x.is_finite()) {
                return Err(Cause::NotFinite { row: k % n });
            }
        }
        Ok(())
    }

    /// Notes the tolerances of the unknowns.
    fn measure(&mut self, settings: &Settings, index: &[Index], y: &[f64], h: f64) {
        self.rtol = settings.rtol.max(SMALLEST_RTOL);
        for (i, unit) in self.unit.iter_mut().enumerate() {
            *unit =
                (settings.atol.of(i) + settings.rtol * y[i].abs()) / h.abs().powi(index[i].power());
        }
    }

    /// Starting values: the last polynomial continued, or the tangent.
    fn predict(&mut self, at: Point<'_>, tableau: &Tableau, last: Option<&CollocationPolynomial>) {
        for (zeta, c) in self.zeta.chunks_exact_mut(at.y.len()).zip(&tableau.c) {
            match last {
                Some(last) => last.change_after_end_into(1.0 + c * at.h / last.h, zeta),
                None => zeta.iter_mut().zip(at.ydot).for_each(|(z, ydot)| *z = c * at.h * ydot),
            }
        }
    }

    /// Solves the stage equations of parameter `k`.
    fn iterate(
        &mut self,
        (k, pattern): (usize, &Pattern),
        at: Point<'_>,
        tableau: &Tableau,
        matrix: &mut IterationMatrix,
    ) -> Result<(), Cause> {
        let (n, s) = (at.y.len(), tableau.s);
        let mut last_norm = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            self.defects(k, pattern, at, tableau);
            let Self { defect, delta, zeta, .. } = self;
            let (defect, delta) = (&mut defect[..s * n], &mut delta[..s * n]);
            multiply_blocks(&tableau.t_inv, 1.0, n, defect, delta);
            matrix.solve_all(n, delta);
            multiply_blocks(&tableau.t, 1.0, n, delta, defect);
            zeta.iter_mut().zip(&*defect).for_each(|(zeta, delta)| *zeta -= delta);

            // Corrections relative to the largest relative sensitivity.
            let norm = self.norm(at.y, s);
            if !norm.is_finite() {
                return Err(Cause::Newton);
            }
            let rate = norm / last_norm;
            let is_small = iteration > 0 && rate < 1.0 && norm * rate / (1.0 - rate) <= KAPPA;
            // Corrections that no longer shrink when far below the tolerance are rounding.
            let is_rounding = rate >= 0.5 && norm <= 10.0 * KAPPA;
            if norm == 0.0 || is_small || is_rounding {
                return Ok(());
            }
            if iteration > 2 && rate >= 1.0 {
                return Err(Cause::Newton);
            }
            last_norm = norm;
        }
        Err(Cause::Newton)
    }

    /// `F_y (s + ζ_i) + F_y′ ζ_i′ + F_p` at every stage.
    fn defects(&mut self, k: usize, pattern: &Pattern, at: Point<'_>, tableau: &Tableau) {
        let (n, s) = (at.y.len(), tableau.s);
        let Self { jacobians, by_parameters, y, zeta, rate, defect, .. } = self;
        let rate = &mut rate[..s * n];
        multiply_blocks(&tableau.a_inv, 1.0 / at.h, n, &zeta[..s * n], rate);
        let width = by_parameters.len() / jacobians.len();
        for i in 0..s {
            let out = &mut defect[i * n..(i + 1) * n];
            out.copy_from_slice(column(&by_parameters[i * width..], n, k));
            for (y, (s, zeta)) in y.iter_mut().zip(at.y.iter().zip(column(zeta, n, i))) {
                *y = s + zeta;
            }
            jacobians[i].add_products(pattern, y, column(rate, n, i), out);
        }
    }

    /// Root mean square of the corrections in `defect`, each relative to its unknown, over the
    /// largest relative sensitivity, in units of `rtol`.
    fn norm(&self, s0: &[f64], s: usize) -> f64 {
        let n = s0.len();
        let stages = || self.zeta[..s * n].chunks_exact(n);
        let relative = |x: &[f64], i: usize| (x[i] / self.unit[i]).abs();
        let mut largest = (0..n).map(|i| relative(s0, i)).fold(0.0, f64::max);
        for zeta in stages() {
            largest = (0..n).map(|i| relative(zeta, i)).fold(largest, f64::max);
        }
        let sum: f64 = self.defect[..s * n]
            .chunks_exact(n)
            .map(|delta| (0..n).map(|i| relative(delta, i).powi(2)).sum::<f64>())
            .sum();
        let norm = (sum / (s * n) as f64).sqrt();
        if norm == 0.0 { 0.0 } else { norm / (largest * self.rtol) }
    }

    /// Sensitivities and their derivatives at the end of the step.
    fn finish(&self, tableau: &Tableau, s1: &mut [f64], sdot1: &mut [f64], h: f64) {
        let (n, s) = (s1.len(), tableau.s);
        sdot1.fill(0.0);
        for (zeta, a) in self.zeta.chunks_exact(n).zip(&tableau.a_inv[(s - 1) * s..]) {
            sdot1.iter_mut().zip(zeta).for_each(|(sdot, zeta)| *sdot += a / h * zeta);
        }
        s1.iter_mut().zip(column(&self.zeta, n, s - 1)).for_each(|(s, zeta)| *s += zeta);
    }
}
