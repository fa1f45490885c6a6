//! The arguments of `bksim import`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

#[derive(Args, Debug)]
pub(crate) struct Import {
    /// The file (URDF, MJCF, SDF, Adams `.adm`), a drawing without attributes (DXF, DWG, SVG), or a link of PMKS+ in quotes; with
    /// `--to` also a model file or a drawing with attributes.
    pub(crate) file: PathBuf,
    /// The model file; standard output unless given. Of a drawing also a drawing of its kind: the same one with what was
    /// understood attached to it.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Write the model as a robot file of this format in place of a model file.
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) to: Option<To>,
    /// Folder in which `package://NAME` and `model://NAME` are looked for; may be given several times.
    #[arg(long = "path", value_name = "FOLDER")]
    pub(crate) paths: Vec<PathBuf>,
    /// Let the first link of a robot in URDF move freely, in place of fixing it to the ground.
    #[arg(long)]
    pub(crate) free: bool,
    /// Answer a question that a drawing leaves, by its key: `drive=A`; may be given several times.
    #[arg(long = "answer", value_name = "KEY=ANSWER")]
    pub(crate) answers: Vec<String>,
    /// Length of one unit of a drawing, such as mm or inch, in place of its own.
    #[arg(long, value_name = "UNIT")]
    pub(crate) units: Option<String>,
    /// Density of the bodies of a drawing, kg/m³, from their outlines and `--thickness`.
    #[arg(long, value_name = "KG_PER_M3", requires = "thickness")]
    pub(crate) density: Option<f64>,
    /// Thickness of the bodies of a drawing, m.
    #[arg(long, value_name = "M", requires = "density")]
    pub(crate) thickness: Option<f64>,
    /// Draw what was understood of a drawing over it, as SVG.
    #[arg(long, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

/// A format of robots.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum To {
    /// A tree of links: ROS, Pinocchio, PyBullet, Isaac.
    Urdf,
    /// MuJoCo's models, loops as equalities.
    Mjcf,
    /// Gazebo's models, loops as joints.
    Sdf,
}
