//! A run as one page of HTML that needs nothing else: the moving mechanism, curves, equations, the
//! model and the run's certificate.
//!
//! ```text
//! Playback ─┬─ motion   q, v and reactions over every step, as values at Chebyshev points
//!           ├─ poses    the tape from q and v to the poses of the bodies
//!           ├─ scene    shapes on bodies, and their paint in both themes
//!           ├─ curves   every channel at even times and at both sides of jumps
//!           └─ report, assemblies, equations, certificate, model_text: HTML
//! document: all of it with the script of `web/`, which draws any instant from the polynomials
//! ```
//!
//! A live page has a module of `crates/live` in place of a run, and a script that edits, poses and solves with it.
//!
//! The page loads nothing: its policy forbids the network, and allows no script but its own.

mod assemblies;
mod budget;
mod certificate;
mod curves;
mod document;
mod equations;
mod error;
mod escape;
mod letters;
mod live;
mod loads;
mod model_text;
mod motion;
mod poses;
mod report;
mod scene;
mod solids;

use bksim::model::file::ShownUnits;
use bksim::playback::Playback;

pub use budget::Budget;
pub use error::PageError;
pub use live::{LiveOptions, live};
pub use motion::Thinning;

/// Options of a page.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Options {
    /// The heading; the model's name unless given.
    pub title: Option<String>,
    /// Curves laid over the mechanism, as [`bksim::overlay::overlays`] reads them.
    pub curves: Vec<String>,
    /// Pictures of all ways in which the start closes.
    pub has_assemblies: bool,
    /// Units of curves and of the report; SI unless given.
    pub units: ShownUnits,
    /// Sizes of the parts.
    pub budget: Budget,
}

/// A page, with figures on its contents.
#[derive(Clone, PartialEq, Debug)]
pub struct Page {
    /// The contents of the file.
    pub html: String,
    /// Number of polynomials of the motion.
    pub n_pieces: usize,
    /// Largest difference found between them and the equations' own motion, m, rad, m/s or rad/s.
    pub deviation: f64,
    /// The thinning of the motion, if it was too long.
    pub thinning: Option<Thinning>,
    /// Number of curves that are kept, and of curves of the run.
    pub n_channels: [usize; 2],
    /// Remarks on the page about parts that are left out.
    pub remarks: Vec<String>,
}

/// Whether this build can make pages: whether Node.js was there.
pub const IS_BUNDLED: bool = cfg!(bundled);

/// The page of a run.
///
/// # Errors
/// [`PageError`].
pub fn page(playback: &mut Playback, options: &Options) -> Result<Page, PageError> {
    if !IS_BUNDLED {
        return Err(PageError::NotBundled);
    }
    let motion = motion::take(playback, options.budget.motion)?;
    let load = loads::largest(playback);
    let curves = curves::take(playback, &motion, (&options.units, options.budget.curves), load)?;
    let poses = poses::tape(playback.mechanism())?;
    let (scene, coarser) = scene::write(playback, options.budget.solids, &options.curves)?;
    let equations = equations::sections(playback.mechanism(), options.budget.equations);

    let tables = report::html(playback, &options.units);
    let assemblies = if options.has_assemblies {
        assemblies::html(playback.mechanism())?
    } else {
        String::new()
    };

    let mut remarks: Vec<String> = motion.thinning.iter().map(Thinning::words).collect();
    remarks.extend(curves.remark());
    remarks.extend(equations.remark.clone());
    remarks.extend(coarser);
    let title = options.title.as_deref().unwrap_or(&playback.mechanism().model.name);
    let data = serde_json::json!({
        "span": motion.span(),
        "motion": motion.write(),
        "poses": poses,
        "scene": scene,
        "curves": curves.write(),
        "load": load,
    });
    let content = document::Content {
        title,
        playback,
        equations: &equations,
        tables: &tables,
        assemblies: &assemblies,
        remarks: &remarks,
    };
    let html = document::write(&content, &serde_json::to_string(&data)?);
    Ok(Page {
        html,
        n_pieces: motion.pieces.len(),
        deviation: motion.deviation,
        n_channels: curves.counts(),
        thinning: motion.thinning,
        remarks,
    })
}
