//! What switches: kinks of the author's expressions, stops, and dry friction.
//!
//! Between two events the equations are smooth, because whatever could switch is a *mode*, a
//! parameter that stays as it is until the next event:
//!
//! ```text
//! abs(u)           σ u                            σ = sign u(t, q, v)
//! sign(u)          σ
//! min, max, if     the branch that σ selects      u = a − b of the two that are compared
//! stop             κ φ(t, q) = 0                  κ = 1 in contact, else 0;  φ ≤ 0, λ ≥ 0, λ φ = 0
//! friction         −ς F on the joint's motion p   ς = sign p′ while it slides
//!                  κ (p₀ − p) = 0, |λ| ≤ F₀       κ = 1 while it sticks at p₀
//! ```
//!
//! A function that decides a mode is watched; where it changes its sign the run is interrupted,
//! the modes are chosen anew, and the run goes on from there as from a start. So no step ever
//! contains a kink. Rows of contacts that are open are rows of zeros.
//!
//! | file | what |
//! | --- | --- |
//! | `contact` | stops and friction as constraint rows with their laws |
//! | `freeze` | the equations with modes in place of everything that switches |
//! | `modes` | the values of the modes |
//! | `frozen` | the mechanism in one set of modes, as matrices |
//! | `watch` | the functions that decide, compiled |
//! | `impact` | velocities after a blow |
//! | `settle` | the modes that are consistent at one instant |
//! | `lookout` | what is watched during a leg, as events of the integrator |
//! | `switching` | the modes of a run, from event to event |
//!
//! Sources: C. Glocker and F. Pfeiffer, *Multibody Dynamics with Unilateral Contacts*, Wiley 1996,
//! ch. 5 (complementarity of contacts) and 8 (impacts); A. F. Filippov, *Differential Equations
//! with Discontinuous Righthand Sides*, Kluwer 1988, §4 (sliding along a switching surface).

mod fixed;
mod impact;
mod indicators;
mod mode_search;
mod modes;
mod monitor;
mod switching;

pub(crate) use indicators::{Watch, Watcher};
pub use mode_search::Unsettled;
pub(crate) use mode_search::{Bands, Instant, Settled, settle_smoothly};
pub(crate) use modes::Modes;
pub(crate) use monitor::{Crossed, Lookout};
pub(crate) use switching::Switching;
pub use switching::{Change, ChangeKind};
