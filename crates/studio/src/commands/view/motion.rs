//! From a model or a log to what a window shows, as often as the file changes.

use std::path::{Path, PathBuf};

use bksim::analysis::ModeRequest;
use bksim::playback::PlaybackError;
use bksim::solved::solve;
use bksim_view::show::Show;
use bksim_view::window::{Loaded, Task};

use crate::curve_fault::no_curve;
use crate::modal::mode_of;
use bksim_cli::args::ModelArgs;
use bksim_cli::exit::Failure;
use bksim_cli::render;
use bksim_cli::source::logged::{is_log, playback};
use bksim_cli::source::shown::shown_units;
use bksim_cli::source::{Text, derive, is_stdin, load};

/// Where a window's motion comes from.
pub(super) struct Motion {
    pub(super) model: ModelArgs,
    /// The units that values are told in; those of the model unless given.
    pub(super) units: Option<String>,
    pub(super) nesting: usize,
    /// Curves laid over the mechanism.
    pub(super) curves: Vec<String>,
    /// The mode that is shown in place of the run.
    pub(super) mode: Option<ModeRequest>,
    /// True where it is to be cut by a plane.
    pub(super) is_cut: bool,
}

impl Motion {
    /// True if the window can change values of parameters: of a model that is solved.
    pub(super) fn takes_values(&self) -> bool {
        self.mode.is_none() && !is_log(&self.model.model)
    }

    /// Reads the file, and solves it if it is a model.
    pub(super) fn load(&self, task: &Task) -> Loaded {
        let path = &self.model.model;
        let loaded = match &self.mode {
            Some(request) => self.swinging(request),
            None if is_log(path) => Self::log(path),
            None => self.solved(task),
        };
        let mut loaded = self.with_curves(loaded);
        if let Some(show) = &mut loaded.show {
            let text = &show.playback().log().header.model_text;
            // Whether it is a list of units was checked before the window opened.
            let asked = shown_units(self.units.as_deref(), text, show.units.clone());
            show.units = asked.unwrap_or_default();
            if self.is_cut && show.scene().is_planar && loaded.fault.is_none() {
                let why = "--section is for spatial mechanisms, and this one is planar";
                loaded.fault = Some(why.to_owned());
            }
        }
        // The file itself is watched whatever is wrong with it.
        if !is_stdin(path) {
            loaded.files.push(path.clone());
        }
        loaded
    }

    /// A mode of small motions.
    fn swinging(&self, request: &ModeRequest) -> Loaded {
        match mode_of(&self.model, self.nesting, request) {
            Ok(swinging) => {
                let show = Some(Box::new(Show::new(swinging.playback)));
                Loaded { show, ..Loaded::default() }
            }
            Err(failure) => faulty(&failure),
        }
    }

    /// The motion with its curves, or why there are none.
    fn with_curves(&self, mut loaded: Loaded) -> Loaded {
        if let Some(show) = &mut loaded.show
            && let Err(error) = show.lay_over(&self.curves)
        {
            loaded.fault = Some(render::failure_text(&no_curve(&self.model.model, &error)));
        }
        loaded
    }

    /// The motion in a log, which may still be written.
    fn log(path: &Path) -> Loaded {
        match playback(path, "shown") {
            Ok(playback) => {
                Loaded { show: Some(Box::new(Show::new(playback))), ..Loaded::default() }
            }
            Err(failure) => faulty(&failure),
        }
    }

    /// The motion of a model.
    fn solved(&self, task: &Task) -> Loaded {
        let mut model = self.model.clone();
        model.set.0.extend(task.values());
        let read = match load(&model, self.nesting) {
            Ok(read) => read,
            Err(failure) => return faulty(&failure),
        };
        let (source, solver) = (read.source, read.model.solve.clone());
        let files = files_of(&source);
        let mechanism = match derive(&source, read.model) {
            Ok(mechanism) => mechanism,
            Err(failure) => return faulty(&failure),
        };
        let length = solver.t_end - solver.t_start;
        let go_on = |t: f64| {
            task.set_part((t - solver.t_start) / length);
            !task.is_stopped()
        };
        let solved = solve(mechanism, &source.text, &go_on);
        if task.is_stopped() {
            return Loaded { files, is_abandoned: true, ..Loaded::default() };
        }
        match solved {
            Ok(solved) => {
                let fault = solved.fault.map(|fault| render::plain_text(&source, &fault));
                let show = Some(Box::new(Show::new(solved.playback)));
                Loaded { show, fault, files, is_abandoned: false }
            }
            Err(PlaybackError::Model(rejected)) => faulty(&source.rejected(rejected.0).into()),
            Err(error) => Loaded { fault: Some(error.to_string()), files, ..Loaded::default() },
        }
    }
}

/// A fault in the words of the other commands, and the files in which it may be put right.
fn faulty(failure: &Failure) -> Loaded {
    let files = match failure {
        Failure::Model { source, .. } => files_of(source),
        Failure::File { path, .. } | Failure::Input { path, .. } => vec![path.clone()],
        _ => Vec::new(),
    };
    Loaded { fault: Some(render::failure_text(failure)), files, ..Loaded::default() }
}

fn files_of(source: &Text) -> Vec<PathBuf> {
    source.files().into_iter().map(Path::to_owned).collect()
}
