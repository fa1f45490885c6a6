//! Objectives and conditions in smooth parts: both sides of magnitudes, and peaks by the windows of time in which they are.
//!
//! ```text
//! min max |x(t)|   =   min z      z ≥ max x(t), z ≥ −min x(t)     of each window of the time
//! ```
//!
//! Where the greatest of several peaks is least, some of them are alike: a kink of their maximum, but not of any of them.

use bksim::analysis::Drive;
use bksim::model::Outputs;

use crate::base::Source;
use crate::error::DesignError;
use crate::formula::argument;

/// The two sides of a condition and its sign.
pub(super) fn sides(text: &str) -> Option<(&str, &str, &str)> {
    let found = ["<=", ">=", "=="].into_iter().find_map(|sign| {
        let (left, right) = text.split_once(sign)?;
        Some((left.trim(), sign, right.trim()))
    })?;
    (!found.0.is_empty() && !found.2.is_empty()).then_some(found)
}

/// Texts whose largest value, each times its sign, is that of the text: the peak of a magnitude is that of either side, and
/// a peak is the largest of those of all windows.
pub(super) fn peaks(text: &str, windows: &[[f64; 2]]) -> Vec<(f64, String)> {
    let sides = if let Some(of) = argument(text, "max").and_then(|of| argument(of, "abs")) {
        vec![(1.0, format!("max({of})")), (-1.0, format!("min({of})"))]
    } else if let Some(of) = argument(text, "abs") {
        vec![(1.0, of.to_owned()), (-1.0, of.to_owned())]
    } else {
        vec![(1.0, text.to_owned())]
    };
    let split = |(sign, text): (f64, String)| {
        windowed(sign, &text, windows).into_iter().map(move |text| (sign, text))
    };
    sides.into_iter().flat_map(split).collect()
}

/// A peak as those of the windows, of which each is smooth where peaks at different times are alike: greatest values times a
/// sign above zero, least ones times one below.
pub(super) fn windowed(sign: f64, text: &str, windows: &[[f64; 2]]) -> Vec<String> {
    let take = if sign > 0.0 { "max" } else { "min" };
    match argument(text, take) {
        Some(of) if !windows.is_empty() => windows
            .iter()
            .map(|[from, to]| format!("{take}_between({of}, {from:e}, {to:e})"))
            .collect(),
        _ => vec![text.to_owned()],
    }
}

/// The parts of the time, or of the range of positions, in which peaks are looked for one by one; none of a pose, nor
/// where samples are those of steps.
pub(super) fn windows(source: &Source, over: &str) -> Result<Vec<[f64; 2]>, DesignError> {
    /// A peak in each, if they are evenly apart as those of a few turns are.
    const N: usize = 12;
    /// Beyond all times: the first and the last part have no end of their own.
    const BEYOND: f64 = 1e30;
    // Between samples, so that none is added.
    let place = |k: usize, n: usize| (k * n + N / 2) / N;
    let mut ends: Vec<f64> = match over.split_once('=') {
        _ if over == "static" => return Ok(Vec::new()),
        None => {
            let mut solve = source.model(&[], false)?.solve;
            source.changes.apply(&mut solve);
            let span = solve.t_end - solve.t_start;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and saturates"
            )]
            let n = (span.abs() / solve.interval()).floor() as usize;
            let every = solve.interval().copysign(span);
            match solve.outputs {
                Outputs::Steps => return Ok(Vec::new()),
                Outputs::Even => {
                    (1..N).map(|k| solve.t_start + every * place(k, n) as f64).collect()
                }
                Outputs::Times(_) => {
                    (1..N).map(|k| solve.t_start + span * (k as f64 / N as f64)).collect()
                }
            }
        }
        // A range that cannot be read has its fault later.
        Some((name, values)) => {
            let model = source.model(&[], true)?;
            let drive = Drive::parse(&model, name.trim(), values.trim()).ok();
            let values = drive.map(|drive| drive.range.values());
            let values = values.filter(|values| !values.is_empty()).unwrap_or_else(|| vec![0.0]);
            (1..N).map(|k| values[place(k, values.len().saturating_sub(1))]).collect()
        }
    };
    ends.extend([-BEYOND, BEYOND]);
    ends.sort_by(f64::total_cmp);
    Ok(ends.windows(2).map(|ends| [ends[0], ends[1]]).collect())
}

/// The smooth parts of an objective, the largest of which is least; true where these are of its square.
pub(super) fn parts_of(
    goal: &str,
    objective: &str,
    windows: &[[f64; 2]],
) -> (Vec<(f64, String)>, bool) {
    if goal == "maximize" {
        let parts = windowed(-1.0, objective, windows);
        return (parts.into_iter().map(|text| (-1.0, text)).collect(), false);
    }
    // The square of a root of squares is smooth where it vanishes.
    if argument(objective, "rms").is_some() {
        return (vec![(1.0, format!("({objective})^2"))], true);
    }
    (peaks(objective, windows), false)
}
