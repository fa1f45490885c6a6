//! `bksim bode` with a picture: gain and phase over the frequency.

use std::path::Path;

use bksim::analysis::{Response, Transfer};
use bksim_cli::args::analysis::Bode;
use bksim_cli::commands::analysis::bode;
use bksim_cli::exit::{Failure, Status};
use bksim_plot::{Axis, Curve, Figure, Format, Panel, Scale, Theme};

/// Draws the response that is asked for.
pub(crate) fn run(args: &Bode, path: &Path, json: bool, nesting: usize) -> Result<Status, Failure> {
    let format = Format::of(path);
    let draw = |name: &str, found: &Response| {
        let drawn = figure(name, found).render(format, None, &Theme::LIGHT);
        drawn.map_err(|error| Failure::file(path, format!("cannot be drawn: {error}"), None))
    };
    bode::run(args, Some(&draw), json, nesting)
}

/// Gain above phase, each over the logarithm of the frequency.
fn figure(name: &str, found: &Response) -> Figure {
    let curves = |value: &dyn Fn(&Transfer, usize) -> f64| {
        let curve = |transfer: &Transfer| {
            let points = found.omega.iter().enumerate().map(|(k, w)| [*w, value(transfer, k)]);
            let pair = format!("{} by {}", transfer.output, transfer.input);
            Curve::new(&pair, points.collect())
        };
        found.transfers.iter().map(curve).collect::<Vec<_>>()
    };
    let logarithmic =
        |label: &str, unit: &str| Axis { scale: Scale::Logarithmic, ..Axis::new(label, unit) };
    let omega = || logarithmic("frequency", "rad/s");
    let gain = Panel::new(omega(), logarithmic("gain", ""), curves(&|t, k| t.gain[k]));
    let degrees = curves(&|t, k| t.phase[k].to_degrees());
    let phase = Panel::new(omega(), Axis::new("phase", "deg"), degrees);
    Figure::new(name, vec![gain, phase])
}
