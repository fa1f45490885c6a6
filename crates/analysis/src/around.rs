//! [`Around`]: the poses that equations leave around one of them, where the slopes alone do not show them.
//!
//! ```text
//! Φ(z + a d) = 0,  d · δz = a     for directions d with Φ′ d = 0, solved by Gauss and Newton on all rows
//! every d leads on                a surface of poses: rows follow from others
//! none does, or not all of them   the pose yields, but goes nowhere: a stretched toggle
//! two pairs of them do            curves of poses cross: a flat parallelogram
//! one does, regular next to it    a curve, in a pose where some rows follow from others
//! ```
//!
//! Slopes that follow from others in one pose alone say nothing of its neighbours; rows that are left out for that would
//! be torn by any motion. Source: E. L. Allgower and K. Georg, *Introduction to Numerical Continuation Methods*
//! (2003), chapter 8.

use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::curve::{Equations, independent_rows};

/// The poses around one of them.
#[derive(Clone, Debug)]
pub(crate) enum Around {
    /// A surface with this number of independent directions.
    Regular(usize),
    /// A singular pose: no poses in some directions in which the slopes yield; these, orthonormal.
    Nowhere(Vec<DVector<f64>>),
    /// Curves that cross there; a single one where slopes yield in other directions, too, which lead nowhere, as of three
    /// equal cranks in line with the bar that they move.
    Crossing(Vec<Way>),
}

/// A curve of poses that others cross.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    /// Direction of the way, of length one.
    pub(crate) tangent: DVector<f64>,
    /// A pose on it a little ahead, where the slopes show all.
    pub(crate) ahead: DVector<f64>,
}

/// Part of the largest singular value of the slopes below which one yields.
const YIELDS: f64 = 1e-6;
/// Steps that are tried, in radians and longest links.
const STEPS: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Step to either side by which the direction of a curve is found.
const NEAR: f64 = 1e-3;
/// Residual of a pose, and times that of the first one.
const CLOSED: f64 = 1e-11;
const ROUNDING: f64 = 10.0;
/// Part of a step that a pose may be aside of it.
const BEND: f64 = 0.1;
/// Cosine between directions that are one.
const ONE: f64 = 0.998;

/// Directions that slopes leave free, orthonormal.
pub(crate) fn yielding(jacobian: &DMatrix<f64>) -> Vec<DVector<f64>> {
    yielding_below(jacobian, YIELDS)
}

/// Directions along which slopes are at most this part of the largest, orthonormal.
pub(crate) fn yielding_below(jacobian: &DMatrix<f64>, part: f64) -> Vec<DVector<f64>> {
    let n = jacobian.ncols();
    let mut square = DMatrix::zeros(n.max(jacobian.nrows()), n);
    square.rows_mut(0, jacobian.nrows()).copy_from(jacobian);
    let Some(svd) = Svd::new(&square) else { return Vec::new() };
    let floor = part * svd.largest().max(1e-300);
    let free = (0..n).filter(|&k| svd.singular_values[k] <= floor);
    free.map(|k| svd.v_t.row(k).transpose()).collect()
}

/// The poses around a solution `z` of `equations`, all rows of which are looked at.
pub(crate) fn around<E: Equations>(equations: &mut E, z: &DVector<f64>) -> Around {
    let (value, jacobian) = equations.at(z);
    let n_rows = jacobian.nrows();
    // A row that vanishes but for rounding is none.
    let sizes: Vec<f64> = jacobian.row_iter().map(|row| row.norm()).collect();
    let floor = YIELDS * sizes.iter().fold(0.0, |most: f64, size| most.max(*size));
    let has_all = sizes.iter().all(|size| *size > floor);
    if has_all && independent_rows(&jacobian).len() == n_rows {
        return Around::Regular(z.len() - n_rows);
    }
    let free = yielding(&jacobian);
    let k = free.len();
    if k == 0 || n_rows + k == z.len() {
        return Around::Regular(k);
    }
    let rounding = CLOSED.max(ROUNDING * value.amax());
    let mut pose = Pose { equations, z, rounding };
    let mut random = Pcg64::seed_from_u64(1);
    let mut any = || -> DVector<f64> {
        let mix = free.iter().fold(DVector::zeros(z.len()), |sum: DVector<f64>, d| {
            sum + d * random.random_range(-1.0..1.0)
        });
        if mix.norm() > 0.0 { mix.normalize() } else { free[0].clone() }
    };
    // Directions at random lead on where all do.
    let n_tried = if k == 1 { 1 } else { 3 };
    if (0..n_tried).all(|_| pose.leads_on(&any())) {
        return Around::Regular(k);
    }
    let mut tried: Vec<DVector<f64>> = free.clone();
    if k > 1 {
        tried.extend((0..16 * k).map(|_| any()));
    }
    for step in STEPS {
        let halves = pose.halves(&tried, step);
        if !halves.is_empty() {
            return pose.sorted(&free, &halves);
        }
    }
    Around::Nowhere(free)
}

/// The pose at a step along a direction, if one is near.
pub(crate) fn neighbour<E: Equations>(
    equations: &mut E,
    z: &DVector<f64>,
    direction: &DVector<f64>,
    step: f64,
) -> Option<DVector<f64>> {
    let rounding = CLOSED.max(ROUNDING * equations.at(z).0.amax());
    Pose { equations, z, rounding }.at(direction, step)
}

/// A pose with its neighbours.
struct Pose<'e, E> {
    equations: &'e mut E,
    z: &'e DVector<f64>,
    rounding: f64,
}

impl<E: Equations> Pose<'_, E> {
    /// The pose at a step along a direction, if one is near.
    fn at(&mut self, direction: &DVector<f64>, step: f64) -> Option<DVector<f64>> {
        const MOST: usize = 40;
        let mut next = self.z + direction * step;
        for _ in 0..MOST {
            let (value, jacobian) = self.equations.at(&next);
            let ahead = direction.dot(&(&next - self.z)) - step;
            if value.amax() <= self.rounding && ahead.abs() <= self.rounding {
                return ((&next - self.z).norm() <= 4.0 * step.abs()).then_some(next);
            }
            let n_rows = jacobian.nrows();
            let mut slopes = jacobian.insert_row(n_rows, 0.0);
            slopes.row_mut(n_rows).copy_from(&direction.transpose());
            let right = -value.push(ahead);
            let floor = 1e-12 * slopes.norm();
            let change = Svd::new(&slopes)?.solve(&right, floor);
            let length = change.norm();
            if !length.is_finite() {
                return None;
            }
            next += change * (step.abs() / length).min(1.0);
        }
        None
    }

    /// True where the poses go on both ways in a direction itself.
    fn leads_on(&mut self, direction: &DVector<f64>) -> bool {
        STEPS.iter().any(|&step| {
            [step, -step].iter().all(|&step| {
                let next = self.at(direction, step);
                next.is_some_and(|next| {
                    (next - self.z - direction * step).norm() <= BEND * step.abs()
                })
            })
        })
    }

    /// Poses about a step away, one in each direction in which there are any.
    fn halves(&mut self, tried: &[DVector<f64>], step: f64) -> Vec<DVector<f64>> {
        let mut found: Vec<DVector<f64>> = Vec::new();
        for direction in tried {
            for step in [step, -step] {
                let Some(next) = self.at(direction, step) else { continue };
                let towards = |next: &DVector<f64>| (next - self.z).normalize();
                let own = towards(&next);
                if !found.iter().any(|known| towards(known).dot(&own) > ONE) {
                    found.push(next);
                }
            }
        }
        found
    }

    /// Equilibria around a pose, from the poses on all sides, of which the slopes leave the directions `free`.
    fn sorted(&mut self, free: &[DVector<f64>], halves: &[DVector<f64>]) -> Around {
        let towards: Vec<DVector<f64>> =
            halves.iter().map(|next| (next - self.z).normalize()).collect();
        // Directions that no pose leads along.
        let spanned = DMatrix::from_columns(&towards);
        let own = DMatrix::from_columns(free);
        let mut left: Vec<DVector<f64>> = Vec::new();
        if let Some(svd) = Svd::new(&(own.transpose() * &spanned)) {
            let n = free.len();
            let is_left = |k: &usize| svd.singular_values.get(*k).is_none_or(|s| *s < 0.05);
            left.extend((0..n.min(svd.u.ncols())).filter(is_left).map(|k| &own * svd.u.column(k)));
            if svd.u.ncols() < n {
                left = across(&own, &svd.u);
            }
        }
        let n_there =
            |next: &DVector<f64>, equations: &mut E| yielding(&equations.at(next).1).len();
        let dimensions: Vec<usize> =
            halves.iter().map(|next| n_there(next, self.equations)).collect();
        let are_curves = dimensions.iter().all(|&n| n == 1);
        // What yields in this pose alone, aside of curves that are regular next to it, bars none of them.
        if !left.is_empty() && !are_curves {
            return Around::Nowhere(left);
        }
        if !are_curves {
            return Around::Regular(dimensions.into_iter().min().unwrap_or(0));
        }
        let mut ways = Vec::new();
        for (k, own) in towards.iter().enumerate() {
            let is_known = |way: &Way| way.tangent.dot(own).abs() > ONE;
            if ways.iter().any(is_known) {
                continue;
            }
            let pair = self.at(own, NEAR).zip(self.at(own, -NEAR));
            let tangent = pair.map_or(own.clone(), |(a, b)| (a - b).normalize());
            ways.push(Way { tangent, ahead: halves[k].clone() });
        }
        ways.sort_by(|a, b| key(b).partial_cmp(&key(a)).unwrap_or(std::cmp::Ordering::Equal));
        Around::Crossing(ways)
    }
}

/// Rates of the unknowns along a way for a rate of one of the first that moves, rounded: ways are in descending order of them.
fn key(way: &Way) -> Vec<f64> {
    let moves = |x: &&f64| x.abs() > 1e-5;
    let first = way.tangent.iter().find(moves).copied().unwrap_or(1.0);
    way.tangent.iter().map(|x| (x / first * 1e5).round()).collect()
}

/// Directions among the columns of `own` that are across their combinations `u`.
fn across(own: &DMatrix<f64>, u: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let mut left = Vec::new();
    let mut basis: Vec<DVector<f64>> = u.column_iter().map(|c| own * c).collect();
    for column in own.column_iter() {
        let mut rest = column.clone_owned();
        for known in &basis {
            let along = known.dot(&rest);
            rest -= known * along;
        }
        if rest.norm() > 0.1 {
            let rest = rest.normalize();
            basis.push(rest.clone());
            left.push(rest);
        }
    }
    left
}
