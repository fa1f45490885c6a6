//! The motion that is drawn: of a log, or of a model, which is solved in memory.

use std::path::Path;

use bksim::analysis::ModeRequest;
use bksim::log::Outcome;
use bksim::modal::Swinging;
use bksim::playback::PlaybackError;
use bksim::sim::run::Unreplayed;
use bksim_view::show::{Show, Solved, solve};
use serde_json::{Value, json};

use crate::modal::mode_of;
use bksim_cli::args::ModelArgs;
use bksim_cli::exit::Failure;
use bksim_cli::progress::{Progress, StopWish};
use bksim_cli::render;
use bksim_cli::source::logged::{is_log, playback, unplayable};
use bksim_cli::source::{derive, load};

/// A motion to draw.
pub(super) struct Opened {
    pub(super) show: Show,
    /// Whether it reached its end.
    pub(super) is_complete: bool,
    /// Warnings of the model, and why it was not solved to its end.
    pub(super) diagnostics: Value,
}

/// A mode of small motions, and its period, s.
pub(super) fn open_mode(
    args: &ModelArgs,
    nesting: usize,
    request: &ModeRequest,
) -> Result<(Opened, f64), Failure> {
    let Swinging { playback, period, .. } = mode_of(args, nesting, request)?;
    let show = Show::new(playback);
    Ok((Opened { show, is_complete: true, diagnostics: json!([]) }, period))
}

/// Opens a log, or reads and solves a model; prints what is wrong with it unless it goes into JSON.
/// A wish to stop ends the solving.
pub(super) fn open(
    args: &ModelArgs,
    nesting: usize,
    as_json: bool,
    stop: &StopWish,
) -> Result<Opened, Failure> {
    let path = &args.model;
    if !is_log(path) {
        return solved(args, nesting, as_json, stop);
    }
    let of_models = [!args.set.is_empty(), args.drawing.units.is_some()];
    if of_models.contains(&true) || args.drawing.tolerance.is_some() {
        return Err(Failure::usage(
            "--set, --units and --tolerance are for models, and this is a log",
            "solve the model with them, or render the model",
        ));
    }
    let playback = playback(path, "drawn")?;
    let end = playback.log().end.as_ref();
    let is_complete = end.is_some_and(|end| end.outcome == Outcome::ReachedEnd);
    if end.is_none() && !as_json {
        let [_, t] = playback.span();
        let path = path.display();
        render::warning(&format!("`{path}` was cut off before its run ended, at t = {t} s"));
    }
    Ok(Opened { show: Show::new(playback), is_complete, diagnostics: json!([]) })
}

fn solved(
    args: &ModelArgs,
    nesting: usize,
    as_json: bool,
    stop: &StopWish,
) -> Result<Opened, Failure> {
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
            Ok(Opened { show: Show::new(playback), is_complete, diagnostics })
        }
        Err(PlaybackError::Model(rejected)) => Err(source.rejected(rejected.0).into()),
        Err(other) => Err(unplayable(&args.model, "drawn", &other)),
    }
}

pub(super) fn unreplayed(path: &Path, error: Unreplayed) -> Failure {
    unplayable(path, "drawn", &error)
}
