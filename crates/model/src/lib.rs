//! Models of mechanisms: what the author wrote, from text with spans to plain data.
//!
//! ```
//! use bksim_model::file::{Source, read};
//!
//! let text = r#"
//! [bodies.bob]
//! mass = "1 kg"
//! points = { pin = [0, "0.5 m"] }
//! [joints.pivot]
//! type = "revolute"
//! between = ["ground", "bob.pin"]
//! "#;
//! let model = read(&Source::new(text, "pendulum")).model.expect("a model without faults");
//! assert_eq!(model.bodies[1].name, "bob");
//! ```

mod assembly;
mod belt;
mod body;
mod compliance;
mod contact;
mod coupling;
pub mod cure;
mod curve;
pub mod diagnostic;
mod drive;
pub mod file;
pub mod flexible;
mod ids;
mod io;
mod joint;
pub mod library;
mod load;
mod load_case;
mod measure;
mod measure_names;
mod mesh;
pub mod message;
mod model;
mod questions;
mod range;
mod rope;
mod solve;
mod state;
mod table;

pub use assembly::{AssemblyChoice, ChosenAssembly, FoundAssembly};
pub use belt::{Belt, BeltWheel};
pub use body::{Anchor, Body, FixedTurn, Inertia, Point, Solid, SolidForm, Space};
pub use compliance::Compliance;
pub use contact::{Base, ContactPair, EdgesForm, Flat, Place, Reach, Round, Shape};
pub use coupling::{Coupling, CouplingKind, Flanks, Rack, Wheels, WormSize};
pub use curve::{Cam, CamLaw, Curve, FollowerKind, LawSegment};
pub use drive::Drive;
pub use file::NoCompliance;
pub use ids::{
    BeltId, BodyId, ClockId, ContactId, CouplingId, CurveId, DriveId, GROUND, JointId, LawId,
    LoadId, ParameterId, PointId, RopeId, StateId, Vector,
};
pub use io::Io;
pub use joint::{JOINT_TYPES, Joint, JointKind, JointType, MotionKind, motion_words};
pub use load::{FrictionLaw, Load, LoadKind, Opposed, Surface};
pub use load_case::LoadCase;
pub use measure::{
    Axis, ContactPart, Frame, Initial, LinePart, Measure, Orientation, Resultant, Signal,
};
pub use measure_names::{ENERGIES, free_motion_names, reaction_words};
pub use mesh::{Mesh, MeshFault, MeshMoments};
pub use model::{CoordinatePolicy, Model, Parameter};
pub use range::StatedRange;
pub use rope::{Rope, RopeGrip, RopeNode, RopeSection};
pub use solve::{Formulation, Jit, MOST_OUTPUTS, Method, Outputs, SolveOptions};
pub use state::{Clock, HeldChange, HeldSignal, LatchRow, NamedSignal, State};
pub use table::{FunctionPiece, MeasuredCurve, NamedFunction, TableCall};
