//! Models of other programs as the text of bksim models.
//!
//! ```text
//! bytes → XML, statements or a link → Draft (bodies, joints, loads by legal names) → text of a model
//!           xml, adams, pmks          urdf, mjcf, sdf, …                             write
//! ```
//!
//! ```
//! use bksim_import::{Base, import};
//!
//! let urdf = r#"<robot name="arm">
//!   <link name="base"/>
//!   <link name="rod"><inertial><mass value="2"/>
//!     <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
//!   <joint name="pin" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
//! </robot>"#;
//! let imported = import("arm.urdf", urdf.as_bytes(), &|_| None, Base::Fixed);
//! let model = imported.model.expect("a model");
//! assert!(model.contains("[joints.pin]\ntype = \"revolute\""));
//! ```
//!
//! # Invariants
//!
//! Opens no files: other files that a file names come from the caller. The same input gives the same text. Any bytes
//! lead to a text or to faults.

mod adams;
pub mod codes;
mod draft;
mod export;
mod job;
mod loads;
mod mjcf;
mod names;
pub mod plain;
mod pmks;
mod sdf;
mod shapes;
mod spatial;
mod straighten;
mod urdf;
mod write;
mod xml;

pub use codes::PAGES;
pub use export::{Exported, export};
pub use job::{Fault, LeftOut, Place, Source};
pub use names::Renamed;

use draft::Draft;
use job::Job;
use names::Names;

/// Gives the bytes of a file that another one names; `None` where there is none.
pub type Files<'a> = dyn Fn(&str) -> Option<Vec<u8>> + 'a;

/// Largest file, bytes.
const MAX_BYTES: usize = 64 << 20;

/// How the first link of a robot is held where its file does not say.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Base {
    /// On the ground.
    #[default]
    Fixed,
    /// By a free joint.
    Free,
}

/// A format that is read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Format {
    /// Unified robot description format.
    Urdf,
    /// MuJoCo's models.
    Mjcf,
    /// Simulation description format.
    Sdf,
    /// Statements of Adams/Solver.
    Adams,
    /// A link of PMKS+.
    Pmks,
}

impl Format {
    /// Name of the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
            Self::Sdf => "SDF",
            Self::Adams => "Adams",
            Self::Pmks => "PMKS+",
        }
    }
}

/// The outcome of an import.
#[derive(Clone, PartialEq, Debug)]
pub struct Imported {
    /// Text of the model; `None` where a fault is an error.
    pub model: Option<String>,
    /// The format that was recognised.
    pub format: Option<Format>,
    /// All files that were read, the main one first.
    pub sources: Vec<Source>,
    /// Faults in the order in which they were found.
    pub faults: Vec<Fault>,
    /// Names that had to change.
    pub renamed: Vec<Renamed>,
    /// Parts of the files that the model does not have.
    pub left_out: Vec<LeftOut>,
    /// Number of bodies of the model.
    pub n_bodies: usize,
    /// Number of joints of the model.
    pub n_joints: usize,
}

impl Imported {
    /// The parts that are left out with their lines, those of one kind together: file, kind, lines.
    pub fn left_out_by_kind(&self) -> Vec<(usize, String, Vec<String>)> {
        write::left_out_by_kind(&self.sources, &self.left_out)
    }
}

/// Line, counted from 1, of a byte of a text.
pub fn line_of(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|byte| *byte == b'\n').count()
}

/// Reads a file and writes it as a model; `name` is that of the file, `files` gives those that it names, by their
/// names as written there.
pub fn import(name: &str, bytes: &[u8], files: &Files<'_>, base: Base) -> Imported {
    let mut job = Job::new(files);
    let too_large = bytes.len() > MAX_BYTES;
    let file = job.add(name, if too_large { &[] } else { bytes });
    let mut names = Names::default();
    let start = Place { file, span: 0..0 };
    let format = recognised(&job.sources[file]);
    let draft = match format {
        _ if too_large => {
            let message = format!("the file has {} MiB", bytes.len() >> 20);
            let help =
                "import a file of 64 MiB at most; meshes and pictures are files of their own";
            job.error(codes::TOO_LARGE, message, (&start, ""), help);
            None
        }
        Some(Format::Adams) => Some(adams::draft(&mut job, &mut names, file)),
        Some(Format::Pmks) => pmks::draft(&mut job, &mut names, file),
        Some(format) => of_xml(&mut job, &mut names, (file, format), base),
        None => {
            let message = "the file is of no format that is imported".to_owned();
            let help = "import a URDF (`<robot>`), MJCF (`<mujoco>`) or SDF (`<sdf>`) file, an Adams `.adm` file \
                or a link of PMKS+; drawings and model files need no import";
            job.error(codes::UNKNOWN_FORMAT, message, (&start, ""), help);
            None
        }
    };
    finish(job, names, format, draft)
}

fn of_xml(
    job: &mut Job<'_>,
    names: &mut Names,
    (file, format): (usize, Format),
    base: Base,
) -> Option<Draft> {
    let mut tree = xml::Tree::default();
    let root = tree.read(job, file)?;
    match format {
        Format::Urdf => Some(urdf::draft(job, names, (&tree, root), base)),
        Format::Mjcf => Some(mjcf::draft(job, names, tree, root)),
        _ => Some(sdf::draft(job, names, tree, root)),
    }
}

fn finish(
    mut job: Job<'_>,
    names: Names,
    format: Option<Format>,
    draft: Option<Draft>,
) -> Imported {
    let mut draft = draft.unwrap_or_default();
    draft.limit_frictions(&mut job);
    draft.write_starts();
    if !draft.is_planar {
        straighten::straighten(&mut draft, &mut job);
    }
    if !job.has_errors() && draft.bodies.is_empty() {
        let start = Place { file: 0, span: 0..0 };
        let help = "import the file that has the links or bodies of the mechanism";
        job.error(codes::NO_BODIES, "the file has no bodies".to_owned(), (&start, ""), help);
    }
    for body in &draft.bodies {
        if let (Some(why), Some(place)) = (body.inertia.fault(), &body.place) {
            let message = format!("no body has the inertia of `{}`: {why}", body.name);
            let help = "the model takes the numbers as they are, `as_stated`; motions that depend on them may speed up \
                without end";
            job.warn(codes::IMPOSSIBLE_INERTIA, message, (place, "taken as stated"), help);
        }
    }
    let model = (!job.has_errors())
        .then(|| write::text(&draft, &job.sources, &job.left_out, &names.renamed));
    Imported {
        model,
        format,
        sources: job.sources,
        faults: job.faults,
        renamed: names.renamed,
        left_out: job.left_out,
        n_bodies: draft.bodies.len(),
        n_joints: draft.joints.len(),
    }
}

/// The format of a text, by what it begins with.
fn recognised(source: &Source) -> Option<Format> {
    let text = source.text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with('<') {
        let roots = [("robot", Format::Urdf), ("mujoco", Format::Mjcf), ("sdf", Format::Sdf)];
        let first = first_element(text)?;
        let known = roots.into_iter().find(|(tag, _)| *tag == first).map(|(_, format)| format);
        return known.or(match first {
            "mujocoinclude" => Some(Format::Mjcf),
            "model" | "world" => Some(Format::Sdf),
            _ => None,
        });
    }
    let one_line = !text.trim_end().contains('\n');
    if one_line && (text.starts_with('?') || text.starts_with("http")) && text.contains('?') {
        return Some(Format::Pmks);
    }
    let is_adams = source.name.to_ascii_lowercase().ends_with(".adm")
        || text.lines().any(|line| line.trim_start().to_ascii_uppercase().starts_with("PART/"));
    is_adams.then_some(Format::Adams)
}

/// The name of the first element of a text of XML, without a prefix.
fn first_element(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        rest = &rest[rest.find('<')?..];
        if let Some(comment) = rest.strip_prefix("<!--") {
            rest = &comment[comment.find("-->")?..];
        } else if rest.starts_with("<?") || rest.starts_with("<!") {
            rest = &rest[rest.find('>')?..];
        } else {
            let name =
                rest[1..].split(|c: char| c.is_whitespace() || c == '>' || c == '/').next()?;
            return Some(name.rsplit(':').next().unwrap_or(name));
        }
    }
}
