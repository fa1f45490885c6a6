//! A mode of small motions, shown in place of a run.

use bksim::analysis::ModeRequest;
use bksim::modal::{NotSwinging, Swinging, swinging};
use bksim::model::Model;
use bksim::playback::Playback;
use bksim_cli::args::ModelArgs;
use bksim_cli::exit::Failure;
use bksim_cli::source::logged::{is_log, playback, unplayable};
use bksim_cli::source::{Text, load};

/// The mode of a model, or of that of a log.
pub(crate) fn mode_of(
    args: &ModelArgs,
    nesting: usize,
    request: &ModeRequest,
) -> Result<Swinging, Failure> {
    let path = &args.model;
    if is_log(path) {
        let playback = playback(path, "shown")?;
        return mode_of_run(&playback, args, request);
    }
    let loaded = load(args, nesting)?;
    let text = loaded.source.text.clone();
    shown(loaded.model, &text, request, (&loaded.source, args))
}

/// The mode of the mechanism of a run, with its values.
pub(crate) fn mode_of_run(
    playback: &Playback,
    args: &ModelArgs,
    request: &ModeRequest,
) -> Result<Swinging, Failure> {
    let text = playback.log().header.model_text.clone();
    let source = Text::new(args.model.clone(), text.clone());
    let model = playback.log().model_with(&playback.mechanism().parameters);
    let model = model.map_err(|rejected| source.rejected(rejected.0))?;
    shown(model, &text, request, (&source, args))
}

fn shown(
    model: Model,
    text: &str,
    request: &ModeRequest,
    (source, args): (&Text, &ModelArgs),
) -> Result<Swinging, Failure> {
    swinging(model, text, request).map_err(|error| match error {
        NotSwinging::Analysis(error) => source.rejected(error.diagnostics()).into(),
        NotSwinging::Playback(error) => unplayable(&args.model, "shown", &error),
    })
}
