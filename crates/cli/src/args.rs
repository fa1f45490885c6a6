//! The command line: what can be written, with its help.

pub mod analysis;
pub(crate) mod cad;
pub mod changes;
pub(crate) mod code;
pub mod design;
pub(crate) mod draw;
pub(crate) mod edit;
pub(crate) mod fmu;
pub(crate) mod groups;
pub(crate) mod import;
pub(crate) mod info;
mod inputs;
pub mod live;
pub mod mode;
pub mod page;
pub mod plot;
pub mod render;
pub(crate) mod report;
pub mod run;
pub mod sheet;
pub(crate) mod shell;
mod size;
pub(crate) mod speech;
pub mod sweep;
pub(crate) mod text;
mod time;
pub(crate) mod translated;
pub mod view;

use std::path::{Path, PathBuf};

use self::changes::Changes;
use self::run::RunArgs;
use self::size::log_size;
use self::text::{Equations, Expand, Explain, ModelText, Parts, TextFile};
use self::time::time;
use bksim::model;
use clap::{Args, Parser, Subcommand, ValueEnum};

/// A drawn mechanism becomes equations a person can read, and motion they can trust.
#[derive(Parser, Debug)]
// Usage names the main command, whichever program or module reads it.
#[command(name = "bksim", bin_name = "bksim", version, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print one JSON object on stdout instead of text.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print faults and results alone: no warnings, no progress, no word on files that were written.
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Do it again whenever the model, or a file that it is read from, changes.
    #[arg(long, global = true)]
    pub(crate) watch: bool,
    /// How deeply tables, arrays and parentheses of a model may nest.
    #[arg(long, global = true, default_value_t = 64, value_name = "N")]
    pub(crate) max_nesting: usize,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Write a small commented model that solves, or one of the examples.
    New(New),
    /// Report every fault of a model, and count its freedoms.
    Check(ModelText),
    /// Write a model of several files and repeated parts as one text.
    Expand(Expand),
    /// List the parts that come with bksim, or print one.
    Parts(Parts),
    /// Print energies, Lagrange equations and constraints.
    Equations(Equations),
    /// Find the consistent start.
    Assemble(ModelText),
    /// Compute positions and rates over a range, limits and assemblies.
    Kinematics(analysis::Kinematics),
    /// Trace coupler curves, centrodes, swept regions and workspaces.
    Curves(analysis::Curves),
    /// Draw the velocity and acceleration polygons of a pose.
    Polygons(analysis::Polygons),
    /// Find equilibria, their stability and their reactions.
    Static(analysis::Static),
    /// Linearize about a state: A, B, C, D.
    Linearize(analysis::Linearize),
    /// Find frequencies, damping and shapes of small motions.
    Modes(analysis::Modes),
    /// Compute a frequency response, its poles and zeros.
    Bode(analysis::Bode),
    /// Solve in two independent ways and compare every channel.
    Verify(analysis::Verify),
    /// Differentiate one result by many parameters at once.
    Gradient(analysis::Gradient),
    /// Find unwanted freedoms and redundant constraints, and cures.
    Doctor(analysis::Doctor),
    /// Find the efforts, reactions and powers of a motion.
    Inverse(analysis::Inverse),
    /// Examine a cam: motion, pressure angle, curvature, profile.
    Cam(analysis::Cam),
    /// Write the equations as C, Rust or Python that tests itself.
    Code(code::Code),
    /// Write a model as a functional mock-up unit (FMI).
    Fmu(fmu::Fmu),
    /// Solve a model and log its motion.
    Solve(Solve),
    /// Solve at many parameter values, on all cores, into one table.
    Sweep(sweep::Sweep),
    /// Find the best values of parameters under conditions.
    Optimize(design::Optimize),
    /// Find parameters from measured curves, with standard errors.
    Fit(design::Fit),
    /// Find what limits of lengths do: proved bounds, samples.
    Tolerance(design::Tolerance),
    /// Find linkages for a task, each a model that solves.
    Synthesize(design::Synthesize),
    /// Write a picture or a film, without a window.
    Render(render::Render),
    /// Show a model or a log moving, in a window.
    View(view::View),
    /// Write channels of a run as CSV or Parquet.
    Export(Export),
    /// Summarise a log or the run of a model.
    Info(info::Info),
    /// Report limits, strokes, time ratios, peaks and energies.
    Report(report::Report),
    /// Make a sheet of the largest pin forces of all load cases.
    Sheet(sheet::Sheet),
    /// Draw curves of runs as SVG, PNG, PDF or text.
    Plot(plot::Plot),
    /// Write a page of HTML: animation, curves, equations.
    Page(page::Page),
    /// Open a model in a page, to drag, draw and change it.
    Edit(live::Edit),
    /// Differentiate, simplify, solve or typeset an expression.
    Expr(Expression),
    /// Read and edit the mechanism in a drawing.
    #[command(subcommand)]
    Cad(cad::Cad),
    /// Write a robot or linkage of another program as a model.
    Import(import::Import),
    /// Explain a diagnostic code, or list them all.
    Explain(Explain),
    /// Serve an editor: the language server of model files.
    Lsp,
    /// Print the JSON Schema of model files.
    Schema(TextFile),
    /// Print the completions for a shell.
    Completions(shell::Completions),
    /// Print a page of the manual, or write all of them.
    Man(shell::Man),
}

#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option that is given or not")]
pub(crate) struct New {
    /// Name of the model; the file is NAME.toml.
    #[arg(required_unless_present = "list")]
    pub(crate) name: Option<String>,
    /// Take this example in place of the small model; `--list` tells them.
    #[arg(long, value_name = "EXAMPLE")]
    pub(crate) template: Option<String>,
    /// Take the drawing of the example.
    #[arg(long, requires = "template")]
    pub(crate) drawing: bool,
    /// List the examples.
    #[arg(long, conflicts_with_all = ["name", "template", "force"])]
    pub(crate) list: bool,
    /// With small pictures.
    #[arg(long, requires = "list")]
    pub(crate) pictures: bool,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

/// A model, and how it is read.
#[derive(Args, Clone, Debug)]
pub struct ModelArgs {
    /// The model file, or a drawing (DXF, DWG).
    pub model: PathBuf,
    /// Values in place of the model's.
    #[command(flatten)]
    pub set: Changes,
    /// How a drawing is read.
    #[command(flatten)]
    pub drawing: DrawingArgs,
}

impl DrawingArgs {
    /// The units that results of this file are asked for in.
    pub fn shown(&self, path: &Path) -> Option<&str> {
        let units = || self.units.as_deref().filter(|_| !bksim_load::is_drawn(path));
        self.shown.as_deref().or_else(units)
    }
}

impl ModelArgs {
    /// A file with nothing else said.
    pub fn of(model: &Path) -> Self {
        Self { model: model.to_owned(), set: Changes::default(), drawing: DrawingArgs::default() }
    }
}

/// How a drawing is read, and the units of results.
#[derive(Args, Clone, Debug, Default)]
pub struct DrawingArgs {
    /// Units of what is shown, such as "mm, deg, rpm, kN"; `si` for SI, `model` for those of the model's `[units]`. Of a
    /// drawing, the length of its unit, such as mm or inch: use --in there.
    #[arg(long, value_name = "UNITS")]
    pub units: Option<String>,
    /// Units of what is shown, of drawings, too.
    #[arg(long = "in", value_name = "UNITS")]
    pub shown: Option<String>,
    /// Points of a drawing nearer than this, in its units, are one; a ten-thousandth of its size
    /// unless given.
    #[arg(long, value_name = "LENGTH", value_parser = tolerance)]
    pub tolerance: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Switch {
    On,
    Off,
}

#[derive(Args, Debug)]
pub(crate) struct Solve {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The log; NAME.mcap in the working directory unless given.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing log.
    #[arg(long)]
    pub(crate) force: bool,
    /// Continue a run that was stopped or killed: in place of a model, name its log.
    #[arg(long, conflicts_with_all = [
        "set", "compliance", "t_end", "rtol", "atol", "step", "every", "method", "formulation", "channels",
    ])]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) compliance: analysis::ComplianceArgs,
    #[command(flatten)]
    pub(crate) tuning: Tuning,
    /// Log the derivatives of the motion by this parameter (`l1`) or stated initial value
    /// (`A.rate`), too, across impacts and kinks; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) sensitivity: Vec<String>,
    /// Contents of the log besides the samples and the motion between them.
    #[arg(long, value_enum, value_name = "WHICH", default_value = "all")]
    pub(crate) channels: Channels,
    /// Stop when the log has this size, such as 500MB or 10GB; 2 GB unless given. The run can go on with --resume.
    #[arg(long, value_name = "SIZE", default_value_t = LOG_LIMIT, hide_default_value = true, value_parser = log_size)]
    pub(crate) log_limit: u64,
}

/// The largest log unless another one is asked for, bytes.
pub(crate) const LOG_LIMIT: u64 = 2_000_000_000;

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Channels {
    /// Also what Foxglove, Lichtblick and Rerun show: transforms, shapes, joint states.
    All,
    /// Nothing for other programs.
    Own,
}

/// Settings of a solution in place of the model's.
#[derive(Args, Clone, Debug, Default)]
pub struct Tuning {
    /// End time, s, in place of the model's.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub t_end: Option<f64>,
    /// Relative tolerance, in place of the model's.
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    pub rtol: Option<f64>,
    /// Absolute tolerance, in place of the model's.
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    pub atol: Option<f64>,
    /// Fixed steps of this size, s, without error control.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub step: Option<f64>,
    /// Output interval, s, in place of the model's.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub every: Option<f64>,
    /// Method that integrates the equations.
    #[arg(long, value_enum, value_name = "METHOD")]
    pub method: Option<Method>,
    /// The form of the equations that Radau integrates.
    #[arg(long, value_enum, value_name = "FORM")]
    pub formulation: Option<Formulation>,
    /// When the equations become machine code; results are the same.
    #[arg(long, value_enum, value_name = "WHEN")]
    pub jit: Option<Jit>,
}

/// When the equations become machine code.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Jit {
    /// Once that pays.
    Auto,
    /// From the first evaluation.
    On,
    /// Never.
    Off,
}

/// The integrator.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Method {
    /// Explicit steps as long as the motion is not stiff, then Radau.
    Auto,
    /// Radau IIA.
    Radau,
    /// Dormand–Prince 8(5,3) on the accelerations, with projection.
    Explicit,
}

/// The form of the equations that Radau integrates.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Formulation {
    /// Stabilised index 2 (Gear, Gupta and Leimkuhler).
    Ggl,
    /// Velocity constraints only.
    Index2,
    /// Position constraints only.
    Index3,
    /// Acceleration constraints, with projection after every step.
    Index1,
}

/// Channels of a run as a table.
#[derive(Args, Debug)]
pub struct Export {
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
    /// Channels: `state.A_angle`, a whole topic `energy`, a pattern `reactions.*`, or what the model can name, as
    /// `rod.B.x`; with a unit as `A.angle:deg`. All of the log if none.
    pub channels: Vec<String>,
    /// The table; its ending chooses the format (.csv, .parquet). Standard output, as CSV, if none.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub force: bool,
}

impl Export {
    /// The table, if its ending asks for Parquet.
    pub(crate) fn parquet(&self) -> Option<&Path> {
        let is_parquet = |path: &&Path| {
            path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
        };
        self.output.as_deref().filter(is_parquet)
    }
}

/// Operations are done in the order of this list, whatever the order of the options.
#[derive(Args, Debug)]
#[command(after_help = EXPRESSION_EXAMPLES)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option that is given or not")]
pub(crate) struct Expression {
    /// Infix text: `+ - * / ^`, parentheses, functions, names; `-` reads standard input.
    #[arg(allow_hyphen_values = true, value_name = "EXPRESSION")]
    pub(crate) text: String,
    /// Replace symbols by expressions, all at once.
    #[arg(long, value_name = "NAME=EXPR", value_parser = assignment)]
    pub(crate) substitute: Vec<(String, String)>,
    /// Differentiate; once more for each further --diff.
    #[arg(long, value_name = "NAME")]
    pub(crate) diff: Vec<String>,
    /// Taylor polynomial about a point.
    #[arg(long, value_name = "NAME=POINT", value_parser = assignment)]
    pub(crate) series: Option<(String, String)>,
    /// Order of the Taylor polynomial.
    #[arg(long, value_name = "N", default_value_t = 3, requires = "series",
          value_parser = clap::value_parser!(u32).range(..=40))]
    pub(crate) order: u32,
    /// Solve for a symbol in which the expression is linear: it is zero, or an equation `a = b`.
    #[arg(long, value_name = "NAME")]
    pub(crate) solve: Option<String>,
    /// Multiply out, powers of sums up to the twelfth.
    #[arg(long)]
    pub(crate) expand: bool,
    /// Find the cheapest form.
    #[arg(long)]
    pub(crate) simplify: bool,
    /// The value where symbols have these values.
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub(crate) at: Vec<(String, String)>,
    /// How the result is written.
    #[arg(long, value_enum, default_value_t = FormulaNotation::Text)]
    pub(crate) format: FormulaNotation,
    /// Short form of --format latex.
    #[arg(long, conflicts_with = "format")]
    pub(crate) latex: bool,
    /// Count operations, each shared part once, before and after.
    #[arg(long)]
    pub(crate) count: bool,
    /// Compare values before and after --expand and --simplify, at random points in two precisions.
    #[arg(long)]
    pub(crate) certificate: bool,
    #[command(flatten)]
    pub(crate) file: TextFile,
}

const EXPRESSION_EXAMPLES: &str = "\
Examples:
  bksim expr 'sin(a)*cos(b) + cos(a)*sin(b)' --simplify --certificate
  bksim expr 'l*sin(w*t)' --diff t --diff t --latex
  bksim expr 'sqrt(1 + x)' --series x=0 --order 2
  bksim expr 'm*a + c*v = f' --solve a
  bksim expr 'sqrt(x^2 + y^2)' --at x=3 --at y=4
  echo 'a*(b + c)' | bksim expr - --expand --count";

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum FormulaNotation {
    /// Infix text that reads back.
    Text,
    /// Text with Greek letters, dots and indices.
    Unicode,
    /// LaTeX, for mathematics mode.
    Latex,
    /// Typst, for mathematics mode.
    Typst,
    /// Presentation MathML, inside of `<math>`.
    Mathml,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length) if length.is_finite() && length >= 0.0 => Ok(length),
        _ => Err("expected a length in drawing units, such as 0.05".to_owned()),
    }
}

fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected NAME=VALUE, such as l1=0.8 or l1=\"25 mm\"".to_owned()),
    }
}

impl From<Jit> for model::Jit {
    fn from(word: Jit) -> Self {
        match word {
            Jit::Auto => Self::Auto,
            Jit::On => Self::On,
            Jit::Off => Self::Off,
        }
    }
}

impl From<Method> for model::Method {
    fn from(word: Method) -> Self {
        match word {
            Method::Auto => Self::Auto,
            Method::Radau => Self::Radau,
            Method::Explicit => Self::Explicit,
        }
    }
}

impl From<Formulation> for model::Formulation {
    fn from(word: Formulation) -> Self {
        match word {
            Formulation::Ggl => Self::Ggl,
            Formulation::Index2 => Self::Index2,
            Formulation::Index3 => Self::Index3,
            Formulation::Index1 => Self::Index1,
        }
    }
}
