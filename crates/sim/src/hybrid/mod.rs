//! Everything that switches: kinks of the author's expressions, stops, and dry friction.
//!
//! Between two events the equations are smooth, because whatever could switch is a *mode*, a
//! parameter that stays as it is until the next event:
//!
//! ```text
//! abs(u)           σ u                            σ = sign u(t, q, v, λ)
//! sign(u)          σ
//! min, max, if     the branch that σ selects      u = a − b of the two that are compared
//! stop             κ φ(t, q) = 0                  κ = 1 in contact, else 0;  φ ≤ 0, λ ≥ 0, λ φ = 0
//! friction         −ς F on the joint's motion p   ς = sign p′ while it slips
//!                  κ (p₀ − p) = 0, |λ| ≤ F₀       κ = 1 while it sticks at p₀
//! ```
//!
//! Event indicators, functions that decide a mode, are monitored; where one changes its sign the run
//! is interrupted, consistent modes are found again, and the run goes on from there as from a start.
//! So no step ever contains a kink. Rows of open contacts are rows of zeros.
//!
//! Where the mathematics lies, from the bottom up:
//!
//! | module | holds |
//! | --- | --- |
//! | `bksim_mbs::contact` | stops and friction as constraint rows with their laws |
//! | `bksim_mbs::modes` | the equations with modes in place of everything that switches |
//! | `crate::modes` | the modes as numbers, and their indicators |
//! | `fixed` | the mechanism in fixed modes: inactive rows, accelerations, projection |
//! | `complementarity` | the conditions on contacts and kinks, one function each |
//! | `impact` | velocities after an impact |
//! | `rubbing_impact` | the same where bodies rub |
//! | `cones` | forces within cones of friction |
//! | `cone_search` | the search for modes where surfaces in space touch |
//! | `lemke` | linear complementarity |
//! | `mode_sets` | all combinations of some choices, in order |
//! | `undecided` | modes that only the motion from an instant on decides |
//! | `bands` | the sizes of rounding about zero |
//! | `consistent` | an instant at which modes are chosen, and the modes that are consistent |
//! | `mode_search` | the search for them |
//! | `signs` | signs of expressions of multipliers |
//! | `bounces` | bounces that are too low to be seen |
//! | `outline_search` | the same for contacts of outlines |
//! | `latching` | modes and latched signals that agree |
//! | `monitor` | the indicators of one phase, as events of the integrator |
//! | `switching` | the modes of a run, from event to event |
//! | `passage` | an event that has been passed, with what was before it and after it |
//!
//! Sources: C. Glocker and F. Pfeiffer, *Multibody Dynamics with Unilateral Contacts*, Wiley 1996,
//! ch. 5 (complementarity of contacts) and 8 (impacts); A. F. Filippov, *Differential Equations
//! with Discontinuous Righthand Sides*, Kluwer 1988, §4 (sliding along a switching surface).

mod bands;
mod bounces;
mod complementarity;
mod cone_search;
mod cones;
mod consistent;
mod fixed;
mod impact;
mod latching;
mod lemke;
mod mode_search;
mod mode_sets;
mod monitor;
mod outline_search;
mod passage;
mod rubbing_impact;
mod signs;
mod switching;
mod undecided;

pub(crate) use bands::Bands;
pub use consistent::NoConsistentModes;
pub(crate) use consistent::{ConsistentModes, ImpactRecord, Instant};
pub(crate) use latching::latched_modes;
pub(crate) use mode_search::consistent_modes_without_impact;
pub(crate) use monitor::{Crossed, EventMonitor};
pub use passage::Passage;
pub(crate) use switching::Switching;
pub use switching::{Change, ChangeKind};
