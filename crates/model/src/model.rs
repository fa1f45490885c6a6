//! [`Model`]: what the author wrote, as plain data; no state, no equations.
//!
//! Every number is an [`Expr`] of the model's [`Pool`] over the parameter symbols, in SI units and
//! radians, so that the equations keep the author's names. Loads and drives may also use *signals*:
//! symbols that stand for a [`Measure`] of the motion and are replaced when the equations are made.
//!
//! Geometry is three-dimensional throughout; a planar model has z = 0 and all axes along ±z.

use bksim_expr::{Expr, Pool, SymbolId};

use crate::body::Body;
use crate::diagnostic::Span;
use crate::drive::Drive;
use crate::ids::ParameterId;
use crate::joint::Joint;
use crate::load::Load;
use crate::measure::{Initial, Signal};
use crate::solve::SolveOptions;

/// A whole mechanism as its author stated it.
#[derive(Debug)]
pub struct Model {
    /// Name of the mechanism; the file name without extension unless stated.
    pub name: String,
    /// Owns every expression of the model.
    pub pool: Pool,
    /// The time symbol `t`.
    pub time: SymbolId,
    /// In file order, except that each comes after those its definition uses.
    pub parameters: Vec<Parameter>,
    /// Planar or spatial.
    pub space: Space,
    /// Which joints are cut unless a joint says otherwise.
    pub coordinates: CoordinatePolicy,
    /// The ground first, then in file order.
    pub bodies: Vec<Body>,
    /// In file order.
    pub joints: Vec<Joint>,
    /// In file order.
    pub loads: Vec<Load>,
    /// In file order.
    pub drives: Vec<Drive>,
    /// Symbols used in expressions of loads and drives, and what they measure.
    pub signals: Vec<Signal>,
    /// Stated and guessed values of the start.
    pub initial: Vec<Initial>,
    /// Settings of the solution.
    pub solve: SolveOptions,
    /// Parameters that are functions of the motion, with a law that the run is given: none in a model
    /// that was read.
    pub inputs: Vec<ParameterId>,
}

/// A named number.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name as written.
    pub name: String,
    /// Its symbol in the pool.
    pub symbol: SymbolId,
    /// Its definition: a number, or an expression of other parameters.
    pub definition: Expr,
    /// Its value, SI.
    pub value: f64,
    /// SI unit as text (`"m/s^2"`), empty when the author gave none.
    pub unit: String,
    /// Position of the value in the model text.
    pub span: Span,
}

/// Whether motion is confined to the plane z = const.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Space {
    /// All rotation axes along z, all translations in the plane.
    Planar,
    /// No restriction.
    Spatial,
}

/// The choice of the joints that are cut.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum CoordinatePolicy {
    /// bksim chooses and reports.
    #[default]
    Auto,
    /// Fewest cuts: joint coordinates along a spanning tree.
    Relative,
    /// Every joint is cut: each body has its own coordinates.
    Absolute,
}
