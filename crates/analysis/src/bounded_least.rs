//! Least squares with bounds on the unknowns.
//!
//! ```text
//! |K x − r| least,   least ≤ x ≤ most;   of equal ones the smallest x
//! ```
//!
//! Source: C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems* (1974), chapter 23, for bounds on both sides.

use nalgebra::{DMatrix, DVector};

use crate::reduced::pseudo_inverse;

/// Changes of the set of unknowns at their bounds; each lowers the residual.
const MAX_CHANGES: usize = 200;
/// Slopes of the residual below this part of the largest are rounding.
const ROUNDING: f64 = 1e-12;

/// The solution, and which unknowns keep off their bounds; every range has zero in it.
pub(crate) fn bounded_least(
    k: &DMatrix<f64>,
    r: &DVector<f64>,
    bounds: &[[f64; 2]],
) -> (DVector<f64>, Vec<bool>) {
    let n = k.ncols();
    let mut x = DVector::zeros(n);
    let mut is_free = vec![true; n];
    for _ in 0..MAX_CHANGES {
        let free: Vec<usize> = (0..n).filter(|&i| is_free[i]).collect();
        let own = k.select_columns(&free);
        let fixed = DVector::from_fn(n, |i, _| if is_free[i] { 0.0 } else { x[i] });
        let target = pseudo_inverse(&own) * (r - k * fixed);

        // As far towards it as the bounds allow.
        let share = |(at, &i): (usize, &usize)| {
            let (from, to) = (x[i], target[at]);
            let [least, most] = bounds[i];
            if to > most {
                (most - from) / (to - from)
            } else if to < least {
                (least - from) / (to - from)
            } else {
                1.0
            }
        };
        let shares: Vec<f64> = free.iter().enumerate().map(share).collect();
        let part = shares.iter().fold(1.0, |a: f64, b| a.min(*b));
        for (at, &i) in free.iter().enumerate() {
            x[i] += part * (target[at] - x[i]);
            if shares[at] <= part && part < 1.0 {
                x[i] = if target[at] > bounds[i][1] { bounds[i][1] } else { bounds[i][0] };
                is_free[i] = false;
            }
        }
        if part < 1.0 {
            continue;
        }

        // An unknown at its bound that would better leave it.
        let slopes = k.transpose() * (r - k * &x);
        let size = k.abs().transpose() * (r.abs() + k.abs() * x.abs());
        let gain = |&i: &usize| {
            let inwards = if x[i] >= bounds[i][1] { -slopes[i] } else { slopes[i] };
            let is_wide = bounds[i][1] > bounds[i][0];
            (!is_free[i] && is_wide && inwards > ROUNDING * size[i]).then_some(inwards)
        };
        let best = (0..n).filter(|i| gain(i).is_some());
        let best = best.max_by(|a, b| gain(a).unwrap_or(0.0).total_cmp(&gain(b).unwrap_or(0.0)));
        let Some(best) = best else { break };
        is_free[best] = true;
    }
    (x, is_free)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_stays_at_the_bound_that_it_would_pass() {
        let k = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 1.0]);
        let r = DVector::from_column_slice(&[3.0, -0.5]);
        let (x, is_free) = bounded_least(&k, &r, &[[-1.0, 1.0], [-1.0, 1.0]]);
        assert_eq!((x.as_slice(), is_free), (&[1.0, -0.5][..], vec![false, true]));
    }

    #[test]
    fn an_unknown_leaves_the_bound_that_it_was_put_at_on_the_way() {
        // x + y = 2, x − y = 1 with x ≤ 0.25: then y has what is left of both, −0.25 … 1.75 halved.
        let k = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, -1.0]);
        let r = DVector::from_column_slice(&[2.0, 1.0]);
        let (x, _) = bounded_least(&k, &r, &[[0.0, 0.25], [-9.0, 9.0]]);
        assert!((x[0] - 0.25).abs() < 1e-14 && (x[1] - 0.5).abs() < 1e-14, "{x}");
    }

    #[test]
    fn unknowns_that_share_one_load_take_equal_parts_within_their_bounds() {
        let k = DMatrix::from_row_slice(1, 3, &[1.0, 1.0, 1.0]);
        let r = DVector::from_column_slice(&[9.0]);
        let (x, _) = bounded_least(&k, &r, &[[-1.0, 1.0], [0.0, 9.0], [0.0, 9.0]]);
        for (found, expected) in x.iter().zip([1.0, 4.0, 4.0]) {
            assert!((found - expected).abs() < 1e-13, "{x}");
        }
    }
}
