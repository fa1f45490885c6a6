//! The arguments of `bksim cad`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::edit::Change;
use super::{DrawingArgs, ModelArgs, draw};

#[derive(Subcommand, Debug)]
pub(crate) enum Cad {
    /// Areas, centres of mass and moments of inertia of bodies.
    Mass(Mass),
    /// Distances of joints on each body: the lengths of the links.
    Dist(Drawing),
    /// Everything that is attached to a drawing, and where.
    List(Drawing),
    /// Everything that is wrong with a drawing, or looks wrong, with its place and its cure.
    Doctor(Doctor),
    /// The model of a drawing as a model file.
    ToToml(ToToml),
    /// Attach, change and remove bodies.
    #[command(subcommand)]
    Body(Change),
    /// Attach, change and remove joints.
    #[command(subcommand)]
    Joint(Change),
    /// Attach, change and remove forces, springs and other loads.
    #[command(subcommand)]
    Load(Change),
    /// Attach, change and remove drives.
    #[command(subcommand)]
    Drive(Change),
    /// A drawing with the blocks ready to insert, and layers to draw on.
    Template(draw::Template),
    /// Draw a model that has no drawing.
    FromToml(draw::FromToml),
    /// Add what a run looks like to its drawing: paths, envelopes, hodographs, reactions, ghosts.
    Trace(draw::Trace),
}

#[derive(Args, Debug)]
pub(crate) struct Drawing {
    /// The drawing (DXF, DWG).
    pub(crate) drawing: PathBuf,
    #[command(flatten)]
    pub(crate) reading: DrawingArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Mass {
    #[command(flatten)]
    pub(crate) drawing: Drawing,
    /// Only this body.
    #[arg(long, value_name = "NAME")]
    pub(crate) body: Option<String>,
    /// Density of bodies that state none, such as "7850 kg/m^3".
    #[arg(long, value_name = "DENSITY")]
    pub(crate) density: Option<String>,
    /// Thickness of bodies that state none, such as "5 mm".
    #[arg(long, value_name = "LENGTH")]
    pub(crate) thickness: Option<String>,
}

#[derive(Args, Debug)]
pub(crate) struct Doctor {
    #[command(flatten)]
    pub(crate) drawing: Drawing,
    /// A copy of the drawing (DXF) with the findings marked in it, on the layer `BK_DOCTOR`.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args, Debug)]
pub(crate) struct ToToml {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The model file; standard output unless given.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}
