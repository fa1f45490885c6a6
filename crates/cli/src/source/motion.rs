//! A motion to look at: of a log, or of a model, which is solved in memory.

use bksim::log::Outcome;
use bksim::playback::{Playback, PlaybackError};
use bksim::solved::{Solved, solve};
use serde_json::{Value, json};

use super::logged::{is_log, playback, unplayable};
use super::{derive, load};
use crate::args::ModelArgs;
use crate::exit::Failure;
use crate::origin::{file_of, label_of};
use crate::progress::{Progress, StopWish};
use crate::render;

/// A motion that can be looked at.
#[derive(Debug)]
pub struct Opened {
    /// The motion, at its start.
    pub playback: Playback,
    /// The file of its model, as results name it.
    pub file: String,
    /// True if it reached its end.
    pub is_complete: bool,
    /// Warnings of the model, and why it was not solved to its end.
    pub diagnostics: Value,
}

/// The way a motion is opened.
#[derive(Clone, Copy, Debug)]
pub struct Opening<'a> {
    /// The word for what comes to nothing without it: `drawn`.
    pub cannot: &'a str,
    /// Levels to which a model may nest.
    pub nesting: usize,
    /// True if faults go into JSON; they are printed otherwise.
    pub as_json: bool,
    /// Ends the solving.
    pub stop: &'a StopWish,
}

/// Opens a log, or reads and solves a model.
///
/// # Errors
/// A file that cannot be read, faults of the model, a log without motion.
pub fn open(args: &ModelArgs, opening: Opening<'_>) -> Result<Opened, Failure> {
    let Opening { cannot, as_json, .. } = opening;
    let path = &args.model;
    if !is_log(path) {
        return solved(args, opening);
    }
    let of_models = [!args.set.is_empty(), args.drawing.units.is_some()];
    if of_models.contains(&true) || args.drawing.tolerance.is_some() {
        return Err(Failure::usage(
            "--set, --units and --tolerance are for models, and this is a log",
            "solve the model with them, or name the model",
        ));
    }
    let playback = playback(path, cannot)?;
    let end = playback.log().end.as_ref();
    let is_complete = end.is_some_and(|end| end.outcome == Outcome::ReachedEnd);
    if end.is_none() && !as_json {
        let [_, t] = playback.span();
        let path = path.display();
        render::warning(&format!("`{path}` was cut off before its run ended, at t = {t} s"));
    }
    let file = file_of(&playback.log().header);
    Ok(Opened { playback, file, is_complete, diagnostics: json!([]) })
}

fn solved(args: &ModelArgs, opening: Opening<'_>) -> Result<Opened, Failure> {
    let Opening { cannot, nesting, as_json, stop } = opening;
    let loaded = load(args, nesting)?;
    let source = &loaded.source;
    let mechanism = derive(source, loaded.model)?;
    let mut diagnostics = loaded.warnings;
    let [t_start, t_end] = [mechanism.model.solve.t_start, mechanism.model.solve.t_end];
    let progress = Progress::new(t_start, t_end);
    let go_on = |t: f64| {
        progress.reached(t);
        stop.status().is_none()
    };
    let solved = solve(mechanism, &source.text, &go_on);
    progress.finish();
    match solved {
        Ok(Solved { playback, fault }) => {
            let is_complete = fault.is_none();
            diagnostics.extend(fault);
            if !as_json {
                render::print_all(source, &diagnostics);
            }
            let diagnostics = render::json_all(source, &diagnostics);
            let file = label_of(&source.path);
            Ok(Opened { playback, file, is_complete, diagnostics })
        }
        Err(PlaybackError::Model(rejected)) => Err(source.rejected(rejected.0).into()),
        Err(other) => Err(unplayable(&args.model, cannot, &other)),
    }
}
