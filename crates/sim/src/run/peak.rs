//! The largest value of a function between two neighbours of its largest sample.
//!
//! Parabolas through the three best points, golden sections where these lead nowhere: R. P. Brent, *Algorithms for
//! Minimization without Derivatives*, 1973, chapter 5.

/// Part of the bracket to which the instant is found: a smooth peak is then exact to rounding.
const PRECISION: f64 = 1e-8;
/// Evaluations at most: golden sections alone need fewer.
const MOST: usize = 60;
/// Part of a bracket next to its end that shows whether values grow from there on.
const ALONG: f64 = 1e-4;

/// The instant and the value of the largest `value` between the first and the last of three samples, of which that in the
/// middle is largest; it may be one of the others, too. A value that is NaN is less than all.
///
/// # Errors
/// Errors of evaluating `value`.
pub fn peak<E>(
    value: &mut dyn FnMut(f64) -> Result<f64, E>,
    [first, middle, last]: [(f64, f64); 3],
) -> Result<(f64, f64), E> {
    let depth = |value: f64| if value.is_nan() { f64::INFINITY } else { -value };
    let ((from, _), (to, _), (t, of_t)) = (first, last, middle);
    let span = to - from;
    let mut best = (t, depth(of_t));
    // At an end there is a peak next to it only if values grow from there on.
    if t == from || t == to {
        let inner = if t == from { from + ALONG * span } else { to - ALONG * span };
        let found = depth(value(inner)?);
        if inner == t || found >= best.1 {
            return Ok((t, of_t));
        }
        best = (inner, found);
    }
    let golden = 0.5 * (3.0 - 5f64.sqrt());
    let (mut low, mut high) = if from < to { (from, to) } else { (to, from) };
    let tolerance = PRECISION * span.abs();
    // The best three points, and the last two steps.
    let [mut second, mut third] = [first, last].map(|(t, value)| (t, depth(value)));
    if third.1 < second.1 {
        (second, third) = (third, second);
    }
    let (mut step, mut last) = (span, span);
    for _ in 0..MOST {
        let middle = f64::midpoint(low, high);
        if (best.0 - middle).abs() <= 2.0 * tolerance - 0.5 * (high - low) {
            break;
        }
        // A parabola through the three, if it leads to less than half of the step before the last.
        let r = (best.0 - second.0) * (best.1 - third.1);
        let q = (best.0 - third.0) * (best.1 - second.1);
        let p = (best.0 - third.0) * q - (best.0 - second.0) * r;
        let shift = -p / (2.0 * (q - r));
        let is_short = last.abs() > tolerance && shift.abs() < 0.5 * last.abs();
        last = step;
        step = if is_short && best.0 + shift > low && best.0 + shift < high {
            let is_at_end =
                best.0 + shift - low < 2.0 * tolerance || high - best.0 - shift < 2.0 * tolerance;
            if is_at_end { tolerance.copysign(middle - best.0) } else { shift }
        } else {
            last = if best.0 < middle { high - best.0 } else { low - best.0 };
            golden * last
        };
        let next = best.0 + if step.abs() >= tolerance { step } else { tolerance.copysign(step) };
        // No instant is between the ends.
        if next <= low || next >= high {
            break;
        }
        let next = (next, depth(value(next)?));
        if next.1 <= best.1 {
            if next.0 < best.0 {
                high = best.0;
            } else {
                low = best.0;
            }
            (third, second, best) = (second, best, next);
            continue;
        }
        if next.0 < best.0 {
            low = next.0;
        } else {
            high = next.0;
        }
        if next.1 <= second.1 || second.0 == best.0 {
            (third, second) = (second, next);
        } else if next.1 <= third.1 || third.0 == best.0 || third.0 == second.0 {
            third = next;
        }
    }
    Ok(if best.1 < depth(of_t) { (best.0, -best.1) } else { (t, of_t) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn found(f: impl Fn(f64) -> f64, [from, to]: [f64; 2], t: f64) -> ((f64, f64), usize) {
        let mut n = 0;
        let samples = [from, t, to].map(|t| (t, f(t)));
        let mut value = |t: f64| -> Result<f64, Infallible> {
            n += 1;
            Ok(f(t))
        };
        let Ok(peak) = peak(&mut value, samples);
        (peak, n)
    }

    #[test]
    fn a_smooth_peak_takes_few_evaluations() {
        for (ends, from) in
            [([1.0, 2.0], 1.5), ([2.0, 1.0], 1.3), ([1.0, 2.5], 1.0), ([0.5, 1.58], 1.58)]
        {
            let ((t, value), n) = found(f64::sin, ends, from);
            let off = (t - std::f64::consts::FRAC_PI_2).abs();
            assert!(off < 1e-7 && (value - 1.0).abs() < 1e-15, "{t} {value} in {ends:?}");
            assert!(n <= 16, "{n} evaluations in {ends:?}");
        }
    }

    #[test]
    fn an_end_that_is_largest_is_its_own_peak() {
        assert_eq!(found(|t| -t, [0.0, 1.0], 0.0), ((0.0, 0.0), 1));
        assert_eq!(found(|t| t, [0.0, 1.0], 1.0), ((1.0, 1.0), 1));
    }

    #[test]
    fn kinks_and_jumps_are_met_too() {
        let ((t, value), n) = found(|t| 1.0 - (t - 0.37).abs(), [0.0, 1.0], 0.5);
        assert!((t - 0.37).abs() < 1e-7 && (value - 1.0).abs() < 1e-7 && n <= 60, "{t} {n}");
        let ((_, value), n) = found(|t| if t < 0.8 { t } else { f64::NAN }, [0.0, 1.0], 0.5);
        assert!((value - 0.8).abs() < 1e-7 && n <= 60, "{value} {n}");
    }
}
