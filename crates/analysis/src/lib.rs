//! Questions to a mechanism besides its motion in time: positions over a range, equilibria, modes, efforts.
//!
//! Every question takes a model and gives plain data; nothing here opens files or prints.

mod assemblies;
mod assur;
mod balance;
mod balancing;
mod bode;
mod branches;
mod cam;
mod centrodes;
mod channels;
pub mod codes;
mod continuation;
mod coupler_curve;
mod curve;
mod curves;
mod doctor;
mod double_points;
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
mod linear_code;
mod linear_outputs;
mod loaded;
mod mode_motion;
mod modes;
mod path;
mod polygons;
mod positions;
mod quantity;
mod reduced;
mod region;
mod rows;
mod scalar;
mod statics;
mod swept;
mod table;
mod trace;
mod verify;
mod workspace;

pub use assemblies::{Assemblies, Assembly, assemblies};
pub use assur::{Dyad, Proof, Root, Triad};
pub use balancing::{Balanced, balanced};
pub use bode::{Frequencies, Response, Transfer, bode};
pub use branches::PointKind;
pub use cam::{CamLine, CamProfile, CamReport, CamRequest, Located, Peaks, cam};
pub use centrodes::{CentrePlace, Centrodes, InstantCentre};
pub use channels::Channels;
pub use continuation::{BranchPoint, Continuation, EquilibriumBranch, statics_over};
pub use curves::{Curves, CurvesRequest, PointCurve, PointCurves, curves};
pub use doctor::{
    Alignment, Condition, Count, Cure, Doctor, DriveCheck, FreeMotion, Repeated, SingularPose,
    Singularity, doctor, singular_poses,
};
pub use double_points::{Cusp, DoublePoint, PoseOf};
pub use drive::{Drive, Range, position, quantity};
pub use equilibrium::{Equilibrium, Stability};
pub use error::AnalysisError;
pub use exported::{ExportedFunction, Part, exported};
pub use extreme::Extreme;
pub use inverse::{Inverse, Load, Motion, inverse};
pub use kinematics::{Kinematics, Prescribed, kinematics};
pub use limits::{Branch, Limits, LimitsRequest, OutputLimits, RangeOf, limits};
pub use linear::{About, Linear, linearize};
pub use linear_code::exported_linear;
pub use loaded::Loaded;
pub use mode_motion::{ModeMotion, ModeRequest, mode_motion};
pub use modes::{Mode, Modes, modes};
pub use polygons::{Polygon, PolygonVector, Polygons, VectorPart, Vertex, polygons};
pub use positions::Positions;
pub use quantity::PoseQuantity;
pub use region::union;
pub use statics::{Statics, statics};
pub use swept::Swept;
pub use table::{Column, Table};
pub use verify::{Compared, Verified, Way, verify};
pub use workspace::{Workspace, workspaces};
