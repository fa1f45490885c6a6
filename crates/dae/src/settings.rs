//! Options of a run: each with its default, its range and its effect.

use crate::error::SolveError;
use crate::system::{Index, Layout};

/// Options of a run. `Settings::default()` suits most problems; set `rtol` and `atol` first.
#[derive(Clone, PartialEq, Debug)]
pub struct Settings {
    /// Relative tolerance, per unknown. Default `1e-6`; range `1e-14 ..= 0.1`.
    ///
    /// Step sizes are chosen so that the root mean square of `error / (atol + rtol |y|)` in a step
    /// stays below [`Settings::local_fraction`].
    pub rtol: f64,
    /// Absolute tolerance. Default `Tolerance::Scalar(1e-6)`; positive, or zero where `rtol |y|`
    /// never vanishes.
    pub atol: Tolerance,
    /// The part of both tolerances that the error of one step may take, so that the run as a whole
    /// reaches them. Default `0.02`; range `0 < … ≤ 1`. [`crate::ExplicitSolver`] does not read it.
    ///
    /// No method knows how its errors add up. Measured on pendulum, car axis, Andrews' squeezer and
    /// slider-crank with `rtol = atol` from 1e-3 to 1e-12: with 1 the errors at the end are up to
    /// 40 times the tolerance in velocities, with 0.02 below it in positions and velocities and
    /// below ten times it in multipliers. The order is high, so that this costs a quarter of the
    /// steps. Relative tolerances are not made smaller than 1e-12 in this way (1e-10 with unknowns
    /// of index 3).
    pub local_fraction: f64,
    /// Whether step sizes follow the error estimate. Default [`StepControl::Adaptive`].
    pub step: StepControl,
    /// Size of the first step, `> 0`. Default `None`: chosen from `y′(t0)` and the tolerance.
    pub h_initial: Option<f64>,
    /// Smallest step size tried before the run ends with an error. Default `0`; range `≥ 0`.
    /// Rounding of `t` sets a floor of `16 ε |t|`, at least `1e-6 ε |t_end − t0|`, besides.
    pub h_min: f64,
    /// Largest step size. Default `f64::INFINITY`; range `> 0`.
    pub h_max: f64,
    /// Steps tried before the run ends with an error. Default `usize::MAX`, no limit; range `≥ 1`.
    pub max_steps: usize,
    /// Order of the method. Default [`Order::Auto`].
    pub order: Order,
    /// The unknowns in the error test. Default [`ErrorTest::WithoutMultipliers`].
    pub error_test: ErrorTest,
    /// Newton's iteration.
    pub newton: NewtonSettings,
    /// Kernel of the linear systems. Default [`LinearSolver::Auto`].
    pub linear_solver: LinearSolver,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            rtol: 1e-6,
            atol: Tolerance::Scalar(1e-6),
            local_fraction: 0.02,
            step: StepControl::Adaptive,
            h_initial: None,
            h_min: 0.0,
            h_max: f64::INFINITY,
            max_steps: usize::MAX,
            order: Order::Auto,
            error_test: ErrorTest::WithoutMultipliers,
            newton: NewtonSettings::default(),
            linear_solver: LinearSolver::Auto,
        }
    }
}

/// Absolute tolerance: one number for all unknowns, or one for each.
#[derive(Clone, PartialEq, Debug)]
pub enum Tolerance {
    /// One tolerance for every unknown.
    Scalar(f64),
    /// One number per unknown.
    PerUnknown(Vec<f64>),
}

impl Tolerance {
    /// Everything multiplied by `factor`.
    fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Scalar(value) => Self::Scalar(factor * value),
            Self::PerUnknown(values) => {
                Self::PerUnknown(values.iter().map(|value| factor * value).collect())
            }
        }
    }

    /// The tolerance of unknown `i`.
    pub(crate) fn of(&self, i: usize) -> f64 {
        match self {
            Self::Scalar(value) => *value,
            Self::PerUnknown(values) => values[i],
        }
    }
}

/// The choice of step sizes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum StepControl {
    /// By the error estimate and predictive control (HW2 §IV.8).
    Adaptive,
    /// Constant, without error control; the last step is shortened to end at `t_end`.
    Fixed {
        /// Step size, `> 0`.
        h: f64,
        /// Newton's iteration stops when the error left in every step, as a root mean square of
        /// `error / (1 + |y|)` with the weights of [`crate::Index`], is predicted to be smaller.
        /// Range `1e-15 ..= 0.1`; `1e-10` is a good value. Corrections below `2e-11` that stop
        /// shrinking count as rounding and end the iteration too.
        newton_tolerance: f64,
    },
}

/// The choice of the order.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Order {
    /// Three, five or seven stages, whichever is predicted to need the least work per unit of time.
    /// With [`StepControl::Fixed`], which gives no error estimate, three.
    Auto,
    /// Always the same.
    Fixed(Stages),
}

impl Order {
    /// Stages of the first step.
    pub(crate) fn initial(self) -> Stages {
        match self {
            Self::Auto => Stages::Three,
            Self::Fixed(stages) => stages,
        }
    }
}

/// The unknowns in the error test.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ErrorTest {
    /// All, those of index 2 and 3 discounted by `h` and `h²` as in `RADAU5`.
    All,
    /// All but the multipliers of index-2 forms: unknowns of index 2 whose derivative does not
    /// appear. Their value has no memory, and their effect on the other unknowns shows there.
    /// Those of the stabilised form that should vanish hold only rounding, which fails the tests
    /// of `All` below tolerances of 1e-11. Multipliers of index 3 stay: without them Newton's
    /// iteration is stopped too early and fails three times as often.
    WithoutMultipliers,
}

/// Number of stages `s` of the Radau IIA method; its order is `2s − 1`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Stages {
    /// Implicit Euler, order 1.
    One,
    /// Order 5.
    #[default]
    Three,
    /// Order 9.
    Five,
    /// Order 13.
    Seven,
}

impl Stages {
    /// The number itself.
    pub const fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Three => 3,
            Self::Five => 5,
            Self::Seven => 7,
        }
    }
}

/// Options of the simplified Newton iteration.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct NewtonSettings {
    /// Iterations allowed in one step. Default `None`: `6 + s`, 9 for three stages; range `≥ 2`.
    pub max_iterations: Option<usize>,
    /// The error left by Newton's iteration, as a fraction of the error tolerance. Default `None`:
    /// `min(√rtol, 0.01/γ²)`, 7.6e-4 at most for three stages, but not below `100 ε / rtol`.
    /// Range `> 0`, `< 1`. Smaller values cost iterations and help where the iteration error,
    /// rather than the step, limits the result.
    pub kappa: Option<f64>,
    /// The Jacobian is kept while the iteration contracts faster than this. Range `0 ..< 1`.
    /// Default `None`: `0.01`, or `0.001` with variable order or constant steps.
    ///
    /// Larger values save Jacobians and cost iterations. On mechanisms at order 5, `0.001` (that of
    /// `RADAU5`) takes 1.7 times as many Jacobians as `0.01` for 7 % fewer residuals, and `0.1` a
    /// third of them for 39 % more residuals. Steps of variable order are so long that only fresh
    /// Jacobians contract.
    pub keep_jacobian_below: Option<f64>,
}

/// Kernel of the linear systems.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum LinearSolver {
    /// Static for small systems, dense for nearly full ones, sparse otherwise.
    #[default]
    Auto,
    /// Sparse LU of the real and the complex systems at once, in an order of pivots that is kept while
    /// it is good. Its analysis takes `n²` numbers.
    Static,
    /// Column-oriented LU with partial pivoting.
    Dense,
    /// Sparse LU; the ordering and the symbolic analysis are done once.
    Sparse,
}

/// Relative tolerances of one step are not made smaller than this: rounding is near. It grows like
/// `h⁻²` in multipliers of index 3, which fail the error test two powers of ten earlier.
const SMALLEST_LOCAL_RTOL: f64 = 1e-12;
const SMALLEST_LOCAL_RTOL_OF_INDEX_3: f64 = 1e-10;

impl Settings {
    /// With the tolerances of one step, see [`Settings::local_fraction`].
    pub(crate) fn for_one_step(self, layout: &Layout) -> Self {
        let smallest = match layout.index().iter().max() {
            Some(Index::Three) => SMALLEST_LOCAL_RTOL_OF_INDEX_3,
            _ => SMALLEST_LOCAL_RTOL,
        };
        let rtol = (self.local_fraction * self.rtol).max(smallest).min(self.rtol);
        Self { rtol, atol: self.atol.scaled(rtol / self.rtol), ..self }
    }

    /// Checks every number against its range, for a system of `n` unknowns.
    pub(crate) fn check(&self, n: usize) -> Result<(), SolveError> {
        let positive = |x: f64| x > 0.0;
        let fraction = |x: f64| x > 0.0 && x < 1.0;
        // Tolerances.
        check("rtol", self.rtol, "1e-14 ..= 0.1", |x| (1e-14..=0.1).contains(&x))?;
        check("local_fraction", self.local_fraction, "0 < … ≤ 1", |x| positive(x) && x <= 1.0)?;
        match &self.atol {
            Tolerance::Scalar(value) => check_atol(*value)?,
            Tolerance::PerUnknown(values) => {
                if values.len() != n {
                    return Err(SolveError::WrongLength {
                        what: "atol",
                        expected: n,
                        found: values.len(),
                    });
                }
                values.iter().try_for_each(|&value| check_atol(value))?;
            }
        }
        // Step sizes and their number.
        if let StepControl::Fixed { h, newton_tolerance } = self.step {
            check("step.h", h, "positive and finite", |x| positive(x) && x.is_finite())?;
            let in_range = |x| (1e-15..=0.1).contains(&x);
            check("step.newton_tolerance", newton_tolerance, "1e-15 ..= 0.1", in_range)?;
        }
        if let Some(h) = self.h_initial {
            check("h_initial", h, "positive and finite", |x| positive(x) && x.is_finite())?;
        }
        check("h_min", self.h_min, "at least 0 and finite", |x| x >= 0.0 && x.is_finite())?;
        check("h_max", self.h_max, "positive and at least h_min", |x| {
            positive(x) && x >= self.h_min
        })?;
        check("max_steps", self.max_steps as f64, "at least 1", |x| x >= 1.0)?;
        // Newton's iteration.
        if let Some(kappa) = self.newton.kappa {
            check("newton.kappa", kappa, "between 0 and 1", fraction)?;
        }
        if let Some(limit) = self.newton.max_iterations {
            check("newton.max_iterations", limit as f64, "at least 2", |x| x >= 2.0)?;
        }
        if let Some(keep) = self.newton.keep_jacobian_below {
            let in_range = |x| (0.0..1.0).contains(&x);
            check("newton.keep_jacobian_below", keep, "0 ..< 1", in_range)?;
        }
        Ok(())
    }
}

fn check_atol(value: f64) -> Result<(), SolveError> {
    check("atol", value, "at least 0 and finite", |x| x >= 0.0 && x.is_finite())
}

/// Refuses a value outside of its range; NaN fails every range.
fn check(
    field: &'static str,
    value: f64,
    range: &'static str,
    is_valid: impl Fn(f64) -> bool,
) -> Result<(), SolveError> {
    if is_valid(value) { Ok(()) } else { Err(SolveError::InvalidSetting { field, value, range }) }
}
