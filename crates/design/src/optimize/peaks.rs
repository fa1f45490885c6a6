//! Objectives and conditions in smooth parts: both sides of magnitudes, and peaks by the windows of time in which they are.
//!
//! ```text
//! min max |x(t)|   =   min z      z ≥ max x(t), z ≥ −min x(t)     of each window of the time
//! ```
//!
//! Where the greatest of several peaks is least, some of them are alike: a kink of their maximum, but not of any of them.

use bksim::analysis::Drive;

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

/// Value of a peak in a window without samples, the sign left out; no number of a mechanism is as large.
pub(super) const ABSENT: f64 = 1e30;

/// A peak as those of the windows, of which each is smooth where peaks at different times are alike: greatest values times a
/// sign above zero, least ones times one below.
pub(super) fn windowed(sign: f64, text: &str, windows: &[[f64; 2]]) -> Vec<String> {
    let take = if sign > 0.0 { "max" } else { "min" };
    let outside = -sign * ABSENT;
    match argument(text, take) {
        Some(of) if !windows.is_empty() => {
            let within = |[from, to]: &[f64; 2]| {
                format!("{take}(if(t >= {from:e} and t < {to:e}, {of}, {outside:e}))")
            };
            windows.iter().map(within).collect()
        }
        _ => vec![text.to_owned()],
    }
}

/// The parts of the time, or of the range of positions, in which peaks are looked for one by one; none of a pose.
pub(super) fn windows(source: &Source, over: &str) -> Result<Vec<[f64; 2]>, DesignError> {
    /// A peak in each, if they are evenly apart as those of a few turns are.
    const N: usize = 12;
    let [from, to] = match over.split_once('=') {
        _ if over == "static" => return Ok(Vec::new()),
        None => {
            let solve = source.model(&[], false)?.solve;
            [solve.t_start, source.changes.t_end.unwrap_or(solve.t_end)]
        }
        // A range that cannot be read has its fault later.
        Some((name, values)) => {
            let model = source.model(&[], true)?;
            let range = Drive::parse(&model, name.trim(), values.trim()).map(|d| d.range.values());
            let values = range.unwrap_or_default();
            let ends = |fold: fn(f64, f64) -> f64| values.iter().copied().reduce(fold);
            [ends(f64::min).unwrap_or(0.0), ends(f64::max).unwrap_or(0.0)]
        }
    };
    let at = |k: usize| match k {
        0 => -ABSENT,
        N => ABSENT,
        k => from + (to - from) * k as f64 / N as f64,
    };
    Ok((0..N).map(|k| [at(k), at(k + 1)]).collect())
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
