//! Checks of every run, whatever its method: its input, and the smallest step.

use crate::error::SolveError;

/// Steps below this do not move `t` reliably; near `t = 0` a tiny part of the run takes over.
pub(crate) fn step_floor(t: f64, span: f64, h_min: f64) -> f64 {
    let at_zero = 1e-6 * f64::EPSILON * span.abs();
    let rounding = 16.0 * f64::EPSILON * t.abs();
    h_min.max(rounding).max(at_zero).max(f64::MIN_POSITIVE)
}

/// Size and end of the next adaptive step; the last one ends at `t_end` to the bit.
pub(crate) fn next_adaptive(t: f64, h: f64, t_end: f64) -> (f64, f64) {
    let left = t_end - t;
    if (1.0001 * h).abs() >= left.abs() {
        (left, t_end)
    } else if (2.0 * h).abs() > left.abs() {
        // Two halves: a sliver left for the last step would spoil the multipliers, whose errors
        // grow like 1/h.
        (0.5 * left, t + 0.5 * left)
    } else {
        (h, t + h)
    }
}

/// Size and end of the next step of constant size, `taken` of which have left `start`.
pub(crate) fn next_fixed(t: f64, h: f64, t_end: f64, (start, taken): (f64, usize)) -> (f64, f64) {
    // The grid is counted, so that rounding does not pile up into an extra step.
    let t1 = start + (taken + 1) as f64 * h;
    let is_last = (t_end - t1) / h < 1e-6;
    if is_last { (t_end - t, t_end) } else { (h, t1) }
}

/// The first of some numbers that is not finite.
pub(crate) fn first_not_finite(numbers: &[f64]) -> Option<usize> {
    // What is finite leaves nothing when it is multiplied by zero. Without a branch at each number, four are looked at
    // together.
    let (blocks, rest) = numbers.as_chunks::<4>();
    let mut left = [0.0; 4];
    for block in blocks {
        for lane in 0..4 {
            left[lane] += 0.0 * block[lane];
        }
    }
    if rest.iter().chain(&left).fold(0.0, |sum, x| sum + 0.0 * x) == 0.0 {
        return None;
    }
    numbers.iter().position(|x| !x.is_finite())
}

/// Refuses a vector of another length than the system has unknowns.
pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), SolveError> {
    if expected == found { Ok(()) } else { Err(SolveError::WrongLength { what, expected, found }) }
}

/// Refuses values that are not finite.
pub(crate) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), SolveError> {
    match values.iter().find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(&value) => Err(SolveError::InvalidStart { what, value }),
    }
}
