//! The instants at which outputs need samples of a run.

use bksim::model::diagnostic::Diagnostic;
use bksim::model::{Outputs as Instants, SolveOptions};

use crate::codes;
use crate::output::{Outputs, Take};

/// The samples that the outputs of a run need, and no others where times of the outputs are all that is needed; none
/// where they are those of the options.
pub(crate) fn samples_for(outputs: &Outputs, options: &SolveOptions) -> Option<Instants> {
    let takes = || outputs.takes().map(|(take, _)| take);
    let mut times: Vec<f64> =
        takes().filter_map(|take| if let Take::At(t) = take { Some(t) } else { None }).collect();
    let (from, to) = (options.t_start.min(options.t_end), options.t_start.max(options.t_end));
    times.extend(outputs.ends().filter(|end| (from..=to).contains(end)));
    let needs_all = takes().any(|take| !matches!(take, Take::At(_) | Take::Final));
    match &options.outputs {
        _ if !needs_all => (),
        _ if times.is_empty() => return None,
        Instants::Even => times.extend(even_times(options)),
        Instants::Times(stated) => times.extend(stated),
        Instants::Steps => return None,
    }
    Some(Instants::Times(times))
}

/// Refuses times of outputs that no run has.
pub(crate) fn check_times(outputs: &Outputs, solve: &SolveOptions) -> Result<(), Diagnostic> {
    let at_steps = || "the model samples at steps: say `--every` for even samples".to_owned();
    if solve.outputs == Instants::Steps && outputs.ends().next().is_some() {
        let message = "a part of the time ends without sample".to_owned();
        return Err(Diagnostic::error(codes::UNKNOWN_OUTPUT, message).help(at_steps()));
    }
    for (take, output) in outputs.takes() {
        let Take::At(t) = take else { continue };
        let message = format!("`{output}` asks for a time without sample");
        let fault = Diagnostic::error(codes::UNKNOWN_OUTPUT, message);
        let span = (solve.t_start.min(solve.t_end), solve.t_start.max(solve.t_end));
        if t < span.0 || t > span.1 {
            let help = format!("runs go from {} s to {} s", solve.t_start, solve.t_end);
            return Err(fault.help(help));
        }
        let is_instant = |(take, _)| matches!(take, Take::At(_) | Take::Final);
        if solve.outputs == Instants::Steps && !outputs.takes().all(is_instant) {
            return Err(fault.help(at_steps()));
        }
    }
    Ok(())
}

/// The times of even outputs between start and end.
fn even_times(options: &SolveOptions) -> impl Iterator<Item = f64> {
    let (t_start, t_end, every) = (options.t_start, options.t_end, options.interval());
    let forward = (t_end - t_start).signum();
    #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
    let grid = (1u64..).map(move |idx| t_start + forward * every * idx as f64);
    // As a run takes them: a time that rounds onto the end is the end.
    grid.take_while(move |grid| (t_end - grid) * forward >= 1e-9 * every)
}
