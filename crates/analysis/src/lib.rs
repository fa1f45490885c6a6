//! Questions to a mechanism besides its motion in time: positions over a range, equilibria, modes, efforts.
//!
//! Every question takes a model and gives plain data; nothing here opens files or prints.

mod assemblies;
mod balance;
mod balancing;
mod bode;
mod cam;
pub mod codes;
mod continuation;
mod curve;
mod doctor;
mod drive;
mod equilibrium;
mod equilibrium_path;
mod error;
mod exported;
mod extreme;
mod follow;
mod forces;
mod inverse;
mod kinematics;
mod limits;
mod linear;
mod loaded;
mod modes;
mod path;
mod positions;
mod quantity;
mod reduced;
mod rows;
mod scalar;
mod statics;
mod table;
mod trace;
mod verify;

pub use assemblies::{Assemblies, Assembly, assemblies};
pub use balancing::{Balanced, balanced};
pub use bode::{Frequencies, Response, Transfer, bode};
pub use cam::{CamLine, CamProfile, CamReport, CamRequest, Located, Peaks, cam};
pub use continuation::{
    BranchPoint, Continuation, EquilibriumBranch, PointKind, statics_over,
};
pub use doctor::{Alignment, Condition, Count, Cure, Doctor, FreeMotion, Repeated, doctor};
pub use drive::{Drive, Range, position, quantity};
pub use equilibrium::{Equilibrium, Stability};
pub use error::AnalysisError;
pub use exported::{ExportedFunction, Part, exported};
pub use extreme::Extreme;
pub use inverse::{Inverse, Load, Motion, inverse};
pub use kinematics::{Kinematics, Prescribed, kinematics};
pub use limits::{Branch, Limits, LimitsRequest, OutputLimits, RangeOf, limits};
pub use linear::{About, Channels, Linear, linearize};
pub use loaded::Loaded;
pub use modes::{Mode, Modes, modes};
pub use positions::Positions;
pub use quantity::PoseQuantity;
pub use statics::{Statics, statics};
pub use table::{Column, Table};
pub use verify::{Compared, Verified, Way, verify};
