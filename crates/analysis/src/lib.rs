//! Questions to a mechanism besides its motion in time: positions over a range, equilibria, modes, efforts.
//!
//! Every question takes a model and gives plain data; nothing here opens files or prints.

mod assemblies;
mod cam;
pub mod codes;
mod curve;
mod drive;
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

pub use assemblies::{Assemblies, Assembly, assemblies};
pub use cam::{CamLine, CamProfile, CamReport, CamRequest, Located, Peaks, cam};
pub use drive::{Drive, Range, position, quantity};
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
pub use statics::{Equilibrium, Stability, Statics, statics};
pub use table::{Column, Table};
