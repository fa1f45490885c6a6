//! Implicit differential-algebraic equations `0 = F(t, y, y′)` of index up to three, solved by
//! Radau IIA methods of order 1, 5, 9 and 13, fixed or variable ([`Order`]); and ordinary ones,
//! `y′ = f(t, y)`, solved by the explicit method of order 8 of Dormand and Prince as long as they
//! are not stiff ([`ExplicitSolver`]).
//!
//! Both show their steps as [`Step`] with dense output, on which [`EventSearch`] finds zero
//! crossings of functions of the state, and both can be saved and continued bit for bit
//! ([`Checkpoint`]). Sensitivities to parameters and initial values come from
//! [`SensitivitySolver`].
//!
//! A system gives its shape ([`Layout`], [`Pattern`]), its residual and its Jacobians; [`solve`]
//! runs it, or [`Solver`] step by step. A pendulum in Cartesian coordinates, its constraint posed
//! for velocities (index 2):
//!
//! ```
//! use bksim_dae::{Control, Index, Layout, NotFinite, Pattern, Settings, Start, System, solve};
//!
//! /// `y = (x, y, vx, vy, λ)`: q′ = v, v′ = −λ q − (0, g), q·v = 0.
//! struct Pendulum { layout: Layout, pattern: Pattern }
//!
//! impl System for Pendulum {
//!     fn layout(&self) -> &Layout { &self.layout }
//!     fn pattern(&self) -> &Pattern { &self.pattern }
//!     fn residual(
//!         &mut self, _t: f64, y: &[f64], ydot: &[f64], out: &mut [f64],
//!     ) -> Result<(), NotFinite> {
//!         out[0] = ydot[0] - y[2];
//!         out[1] = ydot[1] - y[3];
//!         out[2] = ydot[2] + y[4] * y[0];
//!         out[3] = ydot[3] + y[4] * y[1] + 9.81;
//!         out[4] = y[0] * y[2] + y[1] * y[3];
//!         Ok(())
//!     }
//!     fn jacobian(
//!         &mut self, _t: f64, y: &[f64], _: &[f64], df_dy: &mut [f64], df_dydot: &mut [f64],
//!     ) -> Result<(), NotFinite> {
//!         // Both arrays follow the full pattern, by columns.
//!         let at = |row: usize, col: usize| col * 5 + row;
//!         df_dy.fill(0.0);
//!         df_dydot.fill(0.0);
//!         for i in 0..2 {
//!             df_dydot[at(i, i)] = 1.0;
//!             df_dydot[at(2 + i, 2 + i)] = 1.0;
//!             df_dy[at(i, 2 + i)] = -1.0;
//!             df_dy[at(2 + i, i)] = y[4];
//!             df_dy[at(2 + i, 4)] = y[i];
//!             df_dy[at(4, i)] = y[2 + i];
//!             df_dy[at(4, 2 + i)] = y[i];
//!         }
//!         Ok(())
//!     }
//! }
//!
//! let pendulum = Pendulum {
//!     layout: Layout::from_groups(&[(4, Index::One), (1, Index::Two)]),
//!     pattern: Pattern::dense(5),
//! };
//! let start = Start {
//!     t: 0.0,
//!     y: vec![1.0, 0.0, 0.0, 0.0, 0.0],
//!     ydot: vec![0.0, 0.0, 0.0, -9.81, 0.0],
//! };
//! let settings = Settings { rtol: 1e-8, ..Settings::default() };
//!
//! // Every accepted step passes by; here the lowest point is noted.
//! let mut lowest = 0.0f64;
//! let end = solve(pendulum, start, 10.0, settings, &mut |step| {
//!     lowest = lowest.min(step.y1()[1]);
//!     Control::Continue
//! })?;
//!
//! let [x, y, vx, vy] = [end.y[0], end.y[1], end.y[2], end.y[3]];
//! let energy = (vx * vx + vy * vy) / 2.0 + 9.81 * y;
//! assert!(energy.abs() < 1e-4);
//! assert!((x * x + y * y - 1.0).abs() < 1e-5);
//! assert!(lowest < -0.99);
//! # Ok::<(), bksim_dae::SolveError>(())
//! ```
//!
//! Notation follows E. Hairer and G. Wanner, *Solving Ordinary Differential Equations II*, second
//! edition, Springer 1996, cited as HW2; `RADAU5` is their code of the same method.

mod accessors;
mod checkpoint;
mod collocation;
mod contraction;
mod controller;
mod dense;
mod error;
mod estimate;
mod events;
mod explicit;
mod iteration_matrix;
mod lanes;
mod limits;
mod newton;
mod noise;
mod order;
mod run;
mod scale;
mod sensitivity;
mod settings;
mod solve;
mod stats;
mod step;
mod system;
mod tableau;

pub use checkpoint::{Checkpoint, Loader, Method, Saver};
pub use collocation::{
    AdjointCollocation, AdjointStep, Costates, LinearCoefficients, LinearCollocation, LinearStep,
    eliminate,
};
pub use dense::Step;
pub use error::{Cause, SolveError, Standstill, WorstUnknown};
pub use events::{Crossing, Event, EventSearch, Events};
pub use explicit::{
    Advance, ExplicitSolver, N_STEP_VECTORS, Recorder, STABLE_RANGE, STEP_END, record_step,
    solve_ode,
};
pub use noise::Noise;
pub use run::{Control, End, Outcome, Start};
pub use sensitivity::{SensitivitySolver, SensitivityStart, SensitivityStep, SensitivitySystem};
pub use settings::{
    ErrorTest, LinearSolver, NewtonSettings, Order, Settings, Stages, StepControl, Tolerance,
};
pub use solve::{Solver, solve};
pub use stats::Stats;
pub use system::{Attempt, Index, Layout, NotFinite, Ode, Pattern, StepSpan, System};
