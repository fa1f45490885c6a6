//! One mechanism at many parameter values.
//!
//! The equations are derived and compiled once; every case is a start and a run of what is shared.
//! A case that fails is a row with its reason. Whole sweeps stream to Parquet and go on where they
//! were interrupted.
//!
//! ```
//! use bksim_sweep::{Axis, Design, Monitor, Plan, Request, Study};
//!
//! let model = r#"
//! [parameters]
//! l = "1 m"
//! [bodies.bob]
//! mass = "1 kg"
//! com = [0, "-l"]
//! [joints.A]
//! type = "revolute"
//! between = ["ground", "bob"]
//! coordinate = "phi"
//! [loads.gravity]
//! type = "gravity"
//! acceleration = [0, "-9.81 m/s^2"]
//! [initial]
//! phi = "30 deg"
//! [solve]
//! t_end = "1 s"
//! "#;
//! let axes = [Axis::parse("l", "0.5:2:4")?].into_iter().flatten().collect();
//! let plan = Plan::new(axes, Design::Grid)?;
//! let mut request = Request::new(model, "pendulum", plan);
//! request.outputs = vec!["max(energy.kinetic)".to_owned()];
//!
//! let study = Study::prepare(request)?;
//! let rows = study.rows(0..study.n_cases(), 0, &Monitor::default())?.expect("nothing stopped it");
//! let fastest: Vec<f64> = rows.iter().map(|row| row.outputs[0]).collect();
//! assert!(fastest.is_sorted(), "longer pendulums fall deeper: {fastest:?}");
//! # Ok::<(), bksim_sweep::SweepError>(())
//! ```

mod axis;
mod case;
mod cases;
mod chosen;
mod csv;
mod error;
mod influence;
mod input;
mod output;
mod parquet;
mod plan;
mod request;
mod resume;
mod row;
mod run;
mod sampling;
mod slopes;
mod stated;
mod study;
mod table;

pub use axis::{Axis, Spacing, Values};
pub use bksim::sweep_codes as codes;
pub use cases::axes_of_table;
pub use chosen::{Chosen, Comparison, NoCases};
pub use error::SweepError;
pub use influence::Influence;
pub use input::si_unit;
pub use output::{NeedsSlopes, Output, Outputs, Take};
pub use parquet::Column;
pub use plan::{Design, LARGEST, Plan};
pub use request::Request;
pub use resume::{Existing, FaultCount, Parts, Report, is_whole, parts_of, write};
pub use row::{Ending, Fault, Row};
pub use run::Monitor;
pub use stated::stated_axes;
pub use study::Study;
pub use table::{Table, column_named};
