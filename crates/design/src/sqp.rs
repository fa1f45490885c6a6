//! Sequential quadratic programming with bounds, for the largest of several functions.
//!
//! ```text
//! min maxₖ fₖ(x)      cᵢ(x) = 0,  cⱼ(x) ≥ 0,  0 ≤ x ≤ 1
//! QP: min σ + ½ dᵀ B d     fₖ + ∇fₖ·d ≤ σ,   c + ∇c·d = or ≥ 0
//! ```
//!
//! B follows the Lagrangian by damped updates of Broyden, Fletcher, Goldfarb and Shanno; steps are taken by an exact
//! penalty with a second-order correction; rows that exclude each other are relaxed in part. Source: Nocedal,
//! Wright, Numerical Optimization, ch. 18. A published crate does not serve here: multipliers are part of the
//! answer, equations and points without a value are needed, and points are evaluated many at a time.

use nalgebra::{DMatrix, DVector};

use crate::quadratic::minimum;

/// Functions of unknowns at many points at once; `None` where a point has no values.
pub(crate) type Evaluate<'a> = dyn Fn(&[Vec<f64>]) -> Vec<Option<Vec<f64>>> + 'a;

/// A problem: how many functions of each kind there are, and their values at many points at once.
pub(crate) struct Problem<'a> {
    /// Number of unknowns, each from 0 to 1.
    pub(crate) n: usize,
    /// Functions whose largest is least.
    pub(crate) n_goals: usize,
    /// Functions that are zero; the rest are not below zero.
    pub(crate) n_equal: usize,
    /// Goals, equations, other conditions at every point; `None` where a point has none.
    pub(crate) evaluate: &'a Evaluate<'a>,
    /// Slopes of all functions at a point, a row for each, where they are found better than by differences.
    pub(crate) slopes: &'a dyn Fn(&[f64]) -> Option<DMatrix<f64>>,
    pub(crate) stop: &'a dyn Fn() -> bool,
    /// Called with the number of the iteration and the merit.
    pub(crate) reached: &'a dyn Fn(usize, f64),
}

/// Where it ended.
#[derive(Clone, Debug)]
pub(crate) struct Ended {
    pub(crate) x: Vec<f64>,
    pub(crate) values: Vec<f64>,
    /// By function: shares of goals, which sum to one, and multipliers of conditions.
    pub(crate) multipliers: Vec<f64>,
    /// Multipliers of the lower, then of the upper bounds.
    pub(crate) of_bounds: Vec<f64>,
    /// Largest slope of the Lagrangian over the size of the terms.
    pub(crate) stationarity: f64,
    pub(crate) violation: f64,
    pub(crate) n_iterations: usize,
}

/// Step of the differences, in parts of the range.
const STEP: f64 = 1e-3;
const MAX_ITERATIONS: usize = 120;
/// Slopes of the Lagrangian below this part of their terms are zero.
const STATIONARY: f64 = 1e-9;
/// Curvature of the bound of the goals: none at the solution, where it does not move.
const CURVATURE_OF_BOUND: f64 = 1e-3;

impl Problem<'_> {
    fn one(&self, x: &[f64]) -> Option<Vec<f64>> {
        (self.evaluate)(&[x.to_vec()]).pop().flatten()
    }

    pub(crate) fn goal(&self, values: &[f64]) -> f64 {
        values[..self.n_goals].iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b))
    }

    /// Largest violation of a condition.
    pub(crate) fn violation(&self, values: &[f64]) -> f64 {
        self.violations(values).fold(0.0, f64::max)
    }

    fn violations<'v>(&'v self, values: &'v [f64]) -> impl Iterator<Item = f64> + 'v {
        let first_free = self.n_goals + self.n_equal;
        let of =
            move |i: usize| if i < first_free { values[i].abs() } else { (-values[i]).max(0.0) };
        (self.n_goals..values.len()).map(of)
    }

    /// Slopes of all functions, a row for each: those that are given, else by differences of fourth order within the bounds.
    fn slopes(&self, x: &[f64], values: &[f64]) -> Option<DMatrix<f64>> {
        let given = (self.slopes)(x).filter(|slopes| slopes.iter().all(|slope| slope.is_finite()));
        given.or_else(|| self.differences(x, values))
    }

    fn differences(&self, x: &[f64], values: &[f64]) -> Option<DMatrix<f64>> {
        const CENTRAL: [(f64, f64); 4] =
            [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
        const AHEAD: [(f64, f64); 4] = [(1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)];
        const OF_CENTRE: f64 = -25.0 / 12.0;
        let mut slopes = DMatrix::zeros(values.len(), self.n);
        // Central where there is room, else to the side; where a point has no value, to the other one.
        let mut open: Vec<(usize, Vec<f64>)> = (0..self.n)
            .map(|k| {
                let sides = match x[k] {
                    low if low < 2.0 * STEP => vec![1.0, 0.0, -1.0],
                    high if high > 1.0 - 2.0 * STEP => vec![-1.0, 0.0, 1.0],
                    _ => vec![0.0, 1.0, -1.0],
                };
                (k, sides)
            })
            .collect();
        while !open.is_empty() {
            let stencil = |side: f64| -> Vec<(f64, f64)> {
                if side == 0.0 {
                    return CENTRAL.to_vec();
                }
                AHEAD.iter().map(|(at, weight)| (side * at, side * weight)).collect()
            };
            let at = |(k, sides): &(usize, Vec<f64>)| {
                let (k, side) = (*k, sides[0]);
                let moved = move |(at, _): (f64, f64)| {
                    let mut x = x.to_vec();
                    x[k] += at * STEP;
                    x
                };
                stencil(side).into_iter().map(moved).collect::<Vec<_>>()
            };
            let points: Vec<Vec<f64>> = open.iter().flat_map(at).collect();
            let found = (self.evaluate)(&points);
            let mut left = Vec::new();
            for ((k, sides), found) in open.into_iter().zip(found.chunks(4)) {
                if let Some(found) = found.iter().cloned().collect::<Option<Vec<_>>>() {
                    let side = sides[0];
                    for row in 0..values.len() {
                        let own = if side == 0.0 { 0.0 } else { side * OF_CENTRE * values[row] };
                        let terms = stencil(side).into_iter().zip(&found);
                        let sum: f64 = terms.map(|((_, weight), found)| weight * found[row]).sum();
                        slopes[(row, k)] = (own + sum) / STEP;
                    }
                } else if sides.len() > 1 {
                    left.push((k, sides[1..].to_vec()));
                } else {
                    return None;
                }
            }
            open = left;
        }
        slopes.iter().all(|slope| slope.is_finite()).then_some(slopes)
    }

    /// A point of which the values alone are known.
    fn bare(&self, x: Vec<f64>, values: Vec<f64>) -> Ended {
        Ended {
            violation: self.violation(&values),
            multipliers: vec![0.0; values.len()],
            of_bounds: vec![0.0; 2 * self.n],
            stationarity: f64::INFINITY,
            n_iterations: 0,
            x,
            values,
        }
    }

    /// From a point that has values, to where the conditions of a minimum hold.
    pub(crate) fn minimize(&self, from: Vec<f64>) -> Option<Ended> {
        let mut x = from;
        let mut values = self.one(&x)?;
        if self.n == 0 {
            // Nothing varies: the values are those of the model.
            return Some(Ended { stationarity: 0.0, ..self.bare(x, values) });
        }
        let Some(mut slopes) = self.slopes(&x, &values) else {
            return (self.stop)().then(|| self.bare(x, values));
        };
        let mut b = DMatrix::identity(self.n, self.n);
        let mut weight: f64 = 1.0;
        let mut is_fresh = true;
        let mut best: Option<Ended> = None;
        for iteration in 0..MAX_ITERATIONS {
            (self.reached)(iteration, self.goal(&values));
            let Some((d, multipliers)) = self.step(&b, &x, &values, &slopes) else {
                if is_fresh {
                    break;
                }
                (b, is_fresh) = (DMatrix::identity(self.n, self.n), true);
                continue;
            };
            let ended = self.ended(&x, &values, &slopes, &multipliers, iteration);
            let is_done = ended.stationarity < STATIONARY && ended.violation < 1e-10;
            best = Some(ended);
            if is_done || (self.stop)() {
                break;
            }

            // Down along the penalty.
            let n_f = values.len();
            let largest = multipliers.rows(self.n_goals, n_f - self.n_goals).amax();
            weight = weight.max(1.5 * largest);
            let penalty =
                |values: &[f64]| self.goal(values) + weight * self.violations(values).sum::<f64>();
            let now = penalty(&values);
            let linear: Vec<f64> =
                (0..n_f).map(|i| values[i] + slopes.row(i).dot(&d.transpose())).collect();
            let expected = penalty(&linear) - now;
            let noise = 1e-14 * now.abs().max(1.0);
            let mut taken = None;
            let mut share = 1.0;
            for tried in 0..30 {
                let at: Vec<f64> =
                    (0..self.n).map(|k| (x[k] + share * d[k]).clamp(0.0, 1.0)).collect();
                if let Some(found) = self.one(&at) {
                    if penalty(&found) <= now + 1e-4 * share * expected + noise {
                        taken = Some((at, found));
                        break;
                    }
                    // The full step may fail by the curvature of the conditions alone.
                    if tried == 0
                        && let Some(corrected) = self.corrected(&b, &x, (&found, &slopes), &d)
                        && let Some(found) = self.one(&corrected)
                        && penalty(&found) <= now + 1e-4 * expected + noise
                    {
                        taken = Some((corrected, found));
                        break;
                    }
                }
                share *= if tried < 3 { 0.5 } else { 0.25 };
                if share * d.amax() < 1e-13 {
                    break;
                }
            }
            let Some((at, found)) = taken else {
                if is_fresh {
                    break;
                }
                (b, is_fresh) = (DMatrix::identity(self.n, self.n), true);
                continue;
            };
            let moved =
                DVector::from_iterator(self.n, at.iter().zip(&x).map(|(new, old)| new - old));
            let Some(new_slopes) = self.slopes(&at, &found) else {
                if (self.stop)() {
                    best = Some(self.bare(at, found));
                }
                break;
            };
            let lagrangian = |slopes: &DMatrix<f64>| -> DVector<f64> {
                let signs = DVector::from_fn(n_f, |i, _| {
                    if i < self.n_goals { multipliers[i] } else { -multipliers[i] }
                });
                slopes.transpose() * signs
            };
            let change = lagrangian(&new_slopes) - lagrangian(&slopes);
            if moved.amax() > 0.0 {
                update(&mut b, &moved, &change, is_fresh);
                is_fresh = false;
            }
            let is_still = moved.amax() < 1e-12;
            (x, values, slopes) = (at, found, new_slopes);
            if is_still {
                break;
            }
        }
        best
    }

    /// The step of the quadratic program, with the multipliers of functions, lower and upper bounds.
    fn step(
        &self,
        b: &DMatrix<f64>,
        x: &[f64],
        values: &[f64],
        slopes: &DMatrix<f64>,
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        let mut share = 1.0;
        for _ in 0..12 {
            if let Some(found) = self.relaxed(b, x, values, slopes, share) {
                return Some(found);
            }
            share *= 0.5;
        }
        self.relaxed(b, x, values, slopes, 0.0)
    }

    /// The quadratic program in which violated rows shrink by a share.
    fn relaxed(
        &self,
        b: &DMatrix<f64>,
        x: &[f64],
        values: &[f64],
        slopes: &DMatrix<f64>,
        share: f64,
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        let (n, n_f) = (self.n, values.len());
        let goal = self.goal(values);
        let mut h = DMatrix::zeros(n + 1, n + 1);
        h.view_mut((0, 0), (n, n)).copy_from(b);
        h[(n, n)] = CURVATURE_OF_BOUND;
        let mut g = DVector::zeros(n + 1);
        g[n] = 1.0;
        // Equations first, then goals, conditions and bounds.
        let equal = self.n_goals..self.n_goals + self.n_equal;
        let order: Vec<usize> =
            equal.clone().chain((0..n_f).filter(|i| !equal.contains(i))).collect();
        let mut a = DMatrix::zeros(n_f + 2 * n, n + 1);
        let mut right = DVector::zeros(n_f + 2 * n);
        for (row, &i) in order.iter().enumerate() {
            let is_goal = i < self.n_goals;
            let sign = if is_goal { -1.0 } else { 1.0 };
            for k in 0..n {
                a[(row, k)] = sign * slopes[(i, k)];
            }
            if is_goal {
                a[(row, n)] = 1.0;
                right[row] = values[i] - goal;
            } else {
                let is_violated = equal.contains(&i) || values[i] < 0.0;
                right[row] = -values[i] * if is_violated { share } else { 1.0 };
            }
        }
        for k in 0..n {
            a[(n_f + k, k)] = 1.0;
            right[n_f + k] = -x[k];
            a[(n_f + n + k, k)] = -1.0;
            right[n_f + n + k] = x[k] - 1.0;
        }
        let found = minimum(&h, &g, (&a, &right), self.n_equal)?;
        let mut multipliers = DVector::zeros(n_f + 2 * n);
        for (row, &i) in order.iter().enumerate() {
            multipliers[i] = found.multipliers[row];
        }
        multipliers.rows_mut(n_f, 2 * n).copy_from(&found.multipliers.rows(n_f, 2 * n));
        Some((found.x.rows(0, n).into_owned(), multipliers))
    }

    /// The full step with the values of the functions at its end in place of their linear forms.
    fn corrected(
        &self,
        b: &DMatrix<f64>,
        x: &[f64],
        (found, slopes): (&[f64], &DMatrix<f64>),
        d: &DVector<f64>,
    ) -> Option<Vec<f64>> {
        let shifted: Vec<f64> =
            (0..found.len()).map(|i| found[i] - slopes.row(i).dot(&d.transpose())).collect();
        let (d, _) = self.step(b, x, &shifted, slopes)?;
        Some((0..self.n).map(|k| (x[k] + d[k]).clamp(0.0, 1.0)).collect())
    }

    fn ended(
        &self,
        x: &[f64],
        values: &[f64],
        slopes: &DMatrix<f64>,
        multipliers: &DVector<f64>,
        n_iterations: usize,
    ) -> Ended {
        let (n, n_f) = (self.n, values.len());
        let mut worst: f64 = 0.0;
        for k in 0..n {
            let mut sum = multipliers[n_f + n + k] - multipliers[n_f + k];
            let mut size = sum.abs();
            for i in 0..n_f {
                let term = multipliers[i] * slopes[(i, k)];
                sum += if i < self.n_goals { term } else { -term };
                size += term.abs();
            }
            worst = worst.max(sum.abs() / size.max(1e-3));
        }
        // A condition that is not met exactly counts with its multiplier.
        for i in self.n_goals..n_f {
            worst =
                worst.max((multipliers[i] * values[i]).abs() / self.goal(values).abs().max(1.0));
        }
        Ended {
            x: x.to_vec(),
            values: values.to_vec(),
            multipliers: multipliers.rows(0, n_f).iter().copied().collect(),
            of_bounds: multipliers.rows(n_f, 2 * n).iter().copied().collect(),
            stationarity: worst,
            violation: self.violation(values),
            n_iterations,
        }
    }
}

/// Damped update: B s stays on the side of the change.
fn update(b: &mut DMatrix<f64>, s: &DVector<f64>, y: &DVector<f64>, is_fresh: bool) {
    let sy = s.dot(y);
    if is_fresh && sy > 0.0 {
        *b *= (y.norm_squared() / sy).clamp(1e-8, 1e12);
    }
    let bs = &*b * s;
    let sbs = s.dot(&bs);
    let theta = if sy >= 0.1 * sbs { 1.0 } else { 0.9 * sbs / (sbs - sy) };
    let r = y * theta + &bs * (1.0 - theta);
    let sr = s.dot(&r);
    if sr > 1e-300 && sbs > 1e-300 {
        *b += &r * r.transpose() / sr - &bs * bs.transpose() / sbs;
        *b = (&*b + b.transpose()) * 0.5;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solved(
        n: usize,
        n_goals: usize,
        n_equal: usize,
        f: &dyn Fn(&[f64]) -> Vec<f64>,
        from: &[f64],
    ) -> Ended {
        let evaluate = |points: &[Vec<f64>]| points.iter().map(|x| Some(f(x))).collect();
        let problem = Problem {
            n,
            n_goals,
            n_equal,
            evaluate: &evaluate,
            slopes: &|_| None,
            stop: &|| false,
            reached: &|_, _| (),
        };
        problem.minimize(from.to_vec()).expect("a minimum")
    }

    #[test]
    fn the_curved_valley_ends_in_its_minimum() {
        let f = |x: &[f64]| {
            let (a, b) = (4.0 * x[0] - 2.0, 4.0 * x[1] - 2.0);
            vec![(1.0 - a).powi(2) + 100.0 * (b - a * a).powi(2)]
        };
        let found = solved(2, 1, 0, &f, &[0.2, 0.7]);
        assert!((found.x[0] - 0.75).abs() < 1e-7 && (found.x[1] - 0.75).abs() < 1e-7, "{found:?}");
    }

    #[test]
    fn the_largest_of_two_is_least_where_they_are_equal() {
        let f = |x: &[f64]| vec![x[0], 1.0 - x[0] + x[0] * x[0] / 8.0];
        let found = solved(1, 2, 0, &f, &[0.9]);
        // x = 1 − x + x²/8.
        let exact = 8.0 - 56.0_f64.sqrt();
        assert!((found.x[0] - exact).abs() < 1e-10, "{} for {exact}", found.x[0]);
    }

    #[test]
    fn multipliers_are_what_a_condition_is_worth() {
        // min x² + y², x + y = 1 and y ≥ 0.6: d/d0.6 of 0.16 + 0.36 is 2·0.6 − 2·0.4.
        let f = |x: &[f64]| vec![x[0] * x[0] + x[1] * x[1], x[0] + x[1] - 1.0, x[1] - 0.6];
        let found = solved(2, 1, 1, &f, &[0.9, 0.3]);
        assert!((found.x[1] - 0.6).abs() < 1e-9, "{found:?}");
        assert!((found.multipliers[2] - 0.4).abs() < 1e-6, "{found:?}");
    }
}
