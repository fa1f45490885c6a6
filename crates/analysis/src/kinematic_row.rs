//! A row of a table of positions, with rates; where branches cross, by the poses on both sides of the branch that is followed.
//!
//! ```text
//! ∂Φ/∂q v = −∂Φ/∂t        singular where branches cross, though v goes through smoothly along each of them
//! v(s₀) = Σ L_k(s₀) v(s_k)     L_k: Lagrange's polynomials through poses at ± 1, 2, 3 steps
//! ```

use nalgebra::DVector;

use crate::around::yielding_below;
use crate::curve::{Curve, Equations};
use crate::path::Path;
use crate::pose_values::PoseValues;
use crate::rows::wrapped;
use crate::scalar::Rates;

/// Part of the largest singular value of the slopes below which rates are found from both sides.
const SINGULAR: f64 = 3e-4;
/// Distance of the poses, in radians and longest links.
const STEP: f64 = 0.02;

/// All quantities with their rates at one position; NaN where rates are not determined.
pub(crate) fn row(
    curve: &mut Curve<Path<'_>>,
    (rates, values): (&mut Rates, &mut PoseValues),
    (z, tangent): (&DVector<f64>, &DVector<f64>),
    given: (&[f64], &[f64]),
) -> Vec<f64> {
    let (_, slopes) = curve.equations.at(z);
    if yielding_below(&slopes, SINGULAR).len() > 1
        && let Some(found) = from_both_sides(curve, (rates, values), (z, tangent), given)
    {
        return found;
    }
    own_row(curve, (rates, values), z, given).unwrap_or_else(|unknown| unknown)
}

/// The row by the rows at one position.
///
/// # Errors
/// The row without rates, where the rows do not determine them.
fn own_row(
    curve: &mut Curve<Path<'_>>,
    (rates, values): (&mut Rates, &mut PoseValues),
    z: &DVector<f64>,
    (u_dot, u_ddot): (&[f64], &[f64]),
) -> Result<Vec<f64>, Vec<f64>> {
    let n = curve.equations.rows.n();
    let t = curve.equations.time(z[n]);
    let x = &z.as_slice()[..n];
    let found = curve.equations.rows.rates(t, x, (u_dot, u_ddot));
    let q = curve.equations.rows.unscaled(x);
    let rows = &mut *curve.equations.rows;
    let mut of = |[v, a]: [Vec<f64>; 2]| -> Vec<f64> {
        let own: Vec<f64> = if rows.has_jerks() {
            let jerks = rows.jerks(t, x, [&v, &a]).unwrap_or_else(|| vec![f64::NAN; n]);
            rates.with_jerk(t, [&q, &v, &a, &jerks]).into_iter().flatten().collect()
        } else {
            rates.at(t, [&q, &v, &a]).into_iter().flatten().collect()
        };
        own.into_iter().chain(values.at(t, [&q, &v, &a])).collect()
    };
    match found {
        Some(found) => Ok(of(found)),
        None => Err(of([vec![f64::NAN; n], vec![f64::NAN; n]])),
    }
}

/// The row by those of poses on both sides.
fn from_both_sides(
    curve: &mut Curve<Path<'_>>,
    (rates, values): (&mut Rates, &mut PoseValues),
    (z, tangent): (&DVector<f64>, &DVector<f64>),
    given: (&[f64], &[f64]),
) -> Option<Vec<f64>> {
    let n = z.len() - 1;
    let mut rows: Vec<(f64, Vec<f64>)> = Vec::new();
    for k in [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0] {
        let mut there = z + tangent * (k * STEP);
        curve.correct(&mut there, tangent)?;
        rows.push((there[n], own_row(curve, (&mut *rates, &mut *values), &there, given).ok()?));
    }
    let ascends = rows.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if !(ascends || rows.windows(2).all(|pair| pair[0].0 > pair[1].0)) {
        return None;
    }
    let weight = |i: usize| -> f64 {
        let others = (0..rows.len()).filter(|&j| j != i);
        others.map(|j| (z[n] - rows[j].0) / (rows[i].0 - rows[j].0)).product()
    };
    let weights: Vec<f64> = (0..rows.len()).map(weight).collect();
    // Angles about fixed axes jump by whole turns.
    let n_own = rows[0].1.len() - values.columns.len();
    let turns = |c: usize| c >= n_own && values.columns[c - n_own].unit == "rad";
    let from_first = |c: usize, x: f64| {
        let first = rows[0].1[c];
        if turns(c) { first + wrapped(x - first) } else { x }
    };
    let column =
        |c: usize| rows.iter().zip(&weights).map(|((_, row), w)| w * from_first(c, row[c])).sum();
    let found: Vec<f64> = (0..rows[0].1.len()).map(column).collect();
    found.iter().all(|x| x.is_finite()).then_some(found)
}
