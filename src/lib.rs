//! A drawn mechanism becomes equations a person can read, and motion they can trust.
//!
//! This is the crate to embed: [`Mechanism`] takes a model's text to its equations, its consistent
//! start and its motion; [`mechanism_from_drawing`] takes a drawing there. The parts are there by
//! themselves as [`expr`], [`model`], [`mbs`], [`dae`], [`sim`], [`analysis`], [`cad`] and [`log`].
//!
//! ```
//! use bksim::Mechanism;
//!
//! let pendulum = Mechanism::from_toml(
//!     r#"
//!     [bodies.bob]
//!     mass = "2 kg"
//!     inertia = 0
//!     com = [0, "-0.5 m"]
//!
//!     [joints.A]
//!     type = "revolute"
//!     between = ["ground", "bob"]
//!
//!     [loads.gravity]
//!     type = "gravity"
//!     acceleration = [0, "-9.81 m/s^2"]
//!
//!     [initial]
//!     A = { angle = "30 deg" }
//!
//!     [solve]
//!     t_end = "1 s"
//!     "#,
//!     "pendulum",
//! )?;
//! assert_eq!(pendulum.equations().kinetic_energy, "0.25*A_angle_dot^2");
//!
//! let motion = pendulum.solve()?;
//! let swing = motion.samples.iter().map(|sample| sample.q[0].abs()).fold(0.0, f64::max);
//! assert!((swing - 30f64.to_radians()).abs() < 1e-6);
//! # Ok::<(), bksim::Rejected>(())
//! ```
//!
//! # Features
//!
//! All are on unless `default-features = false`; what is below them is always there.
//!
//! | feature | gives | packages |
//! | --- | --- | --- |
//! | | models, equations, motion, analyses, edits, logs, scenes | 173 |
//! | `drawings` | [`cad`], [`mechanism_from_drawing`]: DXF and DWG | 16 more |
//! | `import` | [`import`]: robot files, Adams, PMKS+, plain drawings; includes `drawings` | 6 more than `drawings` |
//! | `fmu` | [`fmu`]: functional mock-up units, solvers in C, scripts | 5 more |
//!
//! Counted by `cargo tree -p bksim --no-default-features --features NAME -e normal,build --prefix none | sed 's/ (\*)//' | sort -u`.
//! Equations and motion alone need 81: depend on [`sim`] as `bksim-sim`. The oldest compiler is Rust 1.95, the
//! `rust-version` of the manifest, which rises with minor versions alone.

pub use bksim_analysis as analysis;
#[cfg(feature = "drawings")]
pub use bksim_cad as cad;
pub use bksim_dae as dae;
pub use bksim_edit as edit;
pub use bksim_expr as expr;
#[cfg(feature = "fmu")]
pub use bksim_fmu as fmu;
#[cfg(feature = "import")]
pub use bksim_import as import;
pub use bksim_log as log;
pub use bksim_mbs as mbs;
pub use bksim_model as model;
pub use bksim_sim as sim;

pub mod answered;
pub mod design_codes;
#[cfg(feature = "drawings")]
mod drawing;
mod explain;
pub mod messages;
pub mod modal;
pub mod options;
pub mod overlay;
pub mod panels;
mod pieces;
pub mod reading;
pub mod section;
pub mod sweep_codes;
pub mod translation;

pub use bksim_model::diagnostic::Rejected;
pub use bksim_runlog::{describe, measured, overview, playback, player, record, report, solved};
pub use bksim_sim::{Mechanism, Motion, SensitivityMotion, SensitivityPlan, Simulation};
#[cfg(feature = "drawings")]
pub use drawing::mechanism_from_drawing;
pub use explain::{explain, explained_codes};
pub use options::SolveChanges;
pub use record::VERSION;
