//! `bksim code`: what can be written.

use std::path::PathBuf;

use bksim::analysis::About;
use clap::{Args, ValueEnum};

use super::ModelArgs;

#[derive(Args, Debug)]
pub(crate) struct Code {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The language.
    #[arg(long, value_enum, default_value_t = Language::C)]
    pub(crate) lang: Language,
    /// The functions that are written.
    #[arg(long, value_enum, default_value_t = Part::Dynamics)]
    pub(crate) part: Part,
    /// A parameter that loads depend on, as an argument of the functions; with `--part linear` as of `bksim
    /// linearize`. May be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) input: Vec<String>,
    /// With `--part linear`: an output, as of `bksim linearize`; may be repeated.
    #[arg(long = "of", value_name = "NAME")]
    pub(crate) of: Vec<String>,
    /// With `--part linear`: the state that the equations are linear about, as of `bksim linearize`.
    #[arg(long, value_name = "STATE", default_value = "static")]
    pub(crate) at: About,
    /// The folder for the files; it is made where it does not exist.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Overwrite existing files.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Language {
    /// C99: a header, a source and a program that tests it.
    C,
    /// Rust without dependencies, with its tests.
    Rust,
    /// Python with NumPy, on batches too, with a test.
    Python,
    /// The operations as data.
    Json,
    /// A script for CasADi: terms, accelerations, ODE and DAE.
    Casadi,
    /// A script for JAX.
    Jax,
    /// A script for SymPy.
    Sympy,
    /// A function for MATLAB and Octave; with `--part linear` A, B, C and D.
    Matlab,
    /// A flat model of Modelica, and one that tests it.
    Modelica,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Part {
    /// M, f, G and γ; constraints; of small mechanisms accelerations and multipliers.
    Dynamics,
    /// Positions and rates of joints, bodies and points.
    Kinematics,
    /// ẋ = A x + B u, z = C x + D u about a state.
    Linear,
    /// Start, steps and events as one file of C.
    Solver,
}
