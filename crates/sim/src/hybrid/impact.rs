//! Velocities after a blow: Newton's law of restitution on the mechanism as a whole.
//!
//! ```text
//! M (v⁺ − v⁻) + Gᵀ Λ + Jᵀ P = 0         G v⁺ + ∂g/∂t = 0
//! ξ = J v⁺ + ε J v⁻ ≤ 0,   P ≥ 0,   Pᵀ ξ = 0
//! ```
//!
//! J v is the rate of penetration, positive on approach. A stop that takes an impulse P > 0 parts
//! with ε times the speed of approach; one that parts faster by itself takes none. Source: Glocker
//! and Pfeiffer (1996), §8.2, with J. J. Moreau's form of Newton's law.

use nalgebra::{DMatrix, DVector};

/// What a blow does.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Impact {
    /// v⁺.
    pub(crate) v: DVector<f64>,
    /// P of every stop, N s or N m s.
    pub(crate) impulses: DVector<f64>,
}

/// The stops that may take part in one blow.
pub(crate) struct Stops<'a> {
    /// J, one row per stop.
    pub(crate) jacobian: &'a DMatrix<f64>,
    /// ε of each.
    pub(crate) restitution: &'a [f64],
}

/// Sets of stops that are tried before the search is given up.
const MAX_SETS: u32 = 1 << 12;
/// Relative size of what counts as rounding in a sign.
const ROUNDING: f64 = 1e-9;
/// A pivot below this part of its row is none: such stops cannot both take an impulse.
const SMALLEST_PIVOT: f64 = 1e-11;

/// The velocities after a blow on `stops`, where `g` holds the independent rows that always hold
/// and `g_rate` is ∂g/∂t behind the blow; `None` when no set of stops is consistent.
///
/// Sets are tried in a fixed order, all stops first.
pub(crate) fn impact(
    mass: &DMatrix<f64>,
    g: &DMatrix<f64>,
    g_rate: &DVector<f64>,
    stops: &Stops<'_>,
    v: &DVector<f64>,
) -> Option<Impact> {
    let n = stops.restitution.len();
    let approach = stops.jacobian * v;
    // What each stop asks of its own speed if it takes part.
    let parting =
        DVector::from_iterator(n, approach.iter().zip(stops.restitution).map(|(u, e)| -e * u));
    let n_sets = 1u32.checked_shl(u32::try_from(n).ok()?).unwrap_or(u32::MAX).min(MAX_SETS);
    (0..n_sets).find_map(|left_out| {
        let active: Vec<usize> = (0..n).filter(|k| left_out >> k & 1 == 0).collect();
        let rows = stops.jacobian.select_rows(&active);
        let (after, impulse) = blow(mass, g, g_rate, &rows, &parting.select_rows(&active), v)?;
        let excess = stops.jacobian * &after - &parting;
        let speed = approach.amax().max((stops.jacobian * &after).amax());
        let is_parting = excess.iter().all(|xi| *xi <= ROUNDING * speed);
        let least = -ROUNDING * if impulse.is_empty() { 0.0 } else { impulse.amax() };
        let is_pushing = impulse.iter().all(|p| *p >= least);
        if !is_parting || !is_pushing {
            return None;
        }
        let mut impulses = DVector::zeros(n);
        for (k, p) in active.iter().zip(impulse.iter()) {
            impulses[*k] = p.max(0.0);
        }
        Some(Impact { v: after, impulses })
    })
}

/// v⁺ and P when all of `rows` end at the speeds `parting`; `None` when the rows are dependent.
fn blow(
    mass: &DMatrix<f64>,
    g: &DMatrix<f64>,
    g_rate: &DVector<f64>,
    rows: &DMatrix<f64>,
    parting: &DVector<f64>,
    v: &DVector<f64>,
) -> Option<(DVector<f64>, DVector<f64>)> {
    let (nq, ng, nj) = (v.len(), g.nrows(), rows.nrows());
    let n = nq + ng + nj;
    let mut matrix = DMatrix::zeros(n, n);
    let mut rhs = DVector::zeros(n);
    matrix.view_mut((0, 0), (nq, nq)).copy_from(mass);
    rhs.rows_mut(0, nq).copy_from(&(mass * v));
    for (first, block, target) in [(nq, g, -g_rate), (nq + ng, rows, parting.clone())] {
        let count = block.nrows();
        matrix.view_mut((first, 0), (count, nq)).copy_from(block);
        matrix.view_mut((0, first), (nq, count)).copy_from(&block.transpose());
        rhs.rows_mut(first, count).copy_from(&target);
    }
    // Rows of unit size, so that a small pivot means dependence and not small units.
    for i in 0..n {
        let size = matrix.row(i).amax();
        if size > 0.0 {
            matrix.row_mut(i).unscale_mut(size);
            rhs[i] /= size;
        }
    }
    let lu = matrix.lu();
    let pivots = lu.u().diagonal().map(f64::abs);
    if n > 0 && pivots.min() <= SMALLEST_PIVOT * pivots.max() {
        return None;
    }
    let x = lu.solve(&rhs)?;
    let is_finite = x.iter().all(|value| value.is_finite());
    is_finite.then(|| (x.rows(0, nq).into_owned(), x.rows(nq + ng, nj).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(mass: &DMatrix<f64>, j: &DMatrix<f64>, e: &[f64], v: &[f64]) -> Option<Impact> {
        let none = DMatrix::zeros(0, v.len());
        let stops = Stops { jacobian: j, restitution: e };
        impact(mass, &none, &DVector::zeros(0), &stops, &DVector::from_column_slice(v))
    }

    #[test]
    fn two_carts_exchange_momentum_and_part_by_the_restitution() {
        // Penetration x₁ − x₂; momentum 2·3 = 6 kg m/s, speed of approach 3 m/s.
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 1.0]));
        let j = DMatrix::from_row_slice(1, 2, &[1.0, -1.0]);
        for e in [0.0, 0.4, 1.0] {
            let found = free(&mass, &j, &[e], &[3.0, 0.0]).expect("a blow");
            let parting = found.v[1] - found.v[0];
            let momentum = 2.0 * found.v[0] + found.v[1];
            assert!((parting - 3.0 * e).abs() < 1e-13, "e = {e}: parting with {parting}");
            assert!((momentum - 6.0).abs() < 1e-13, "e = {e}: momentum {momentum}");
            // P = (1 + e) μ u, μ = 2/3 kg.
            let expected = (1.0 + e) * 2.0;
            assert!((found.impulses[0] - expected).abs() < 1e-13, "P = {}", found.impulses[0]);
        }
    }

    #[test]
    fn a_rod_that_falls_flat_on_two_supports_is_held_by_both() {
        // Height of the middle and angle; supports at ±1 m, a rod of 1 kg and 1/3 kg m².
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0 / 3.0]));
        let j = DMatrix::from_row_slice(2, 2, &[-1.0, 1.0, -1.0, -1.0]);
        let flat = free(&mass, &j, &[0.0, 0.0], &[-1.0, 0.0]).expect("a blow");
        assert!(flat.v.amax() < 1e-14, "{}", flat.v);
        assert!((flat.impulses[0] - 0.5).abs() < 1e-14 && (flat.impulses[1] - 0.5).abs() < 1e-14);

        // One end hits while the other is in touch but at rest. With 1/3 kg m² the other is pressed
        // down and takes an impulse too; with weights at the ends, 4 kg m², it is thrown up.
        let tilting = free(&mass, &j, &[0.0, 0.0], &[-0.5, -0.5]).expect("a blow");
        assert!(tilting.v.amax() < 1e-14 && tilting.impulses.min() > 0.1, "{}", tilting.v);
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0]));
        let tilting = free(&mass, &j, &[0.0, 0.0], &[-0.5, -0.5]).expect("a blow");
        assert_eq!(tilting.impulses[0], 0.0, "{}", tilting.impulses);
        assert!(tilting.impulses[1] > 0.0, "{}", tilting.impulses);
        let rates = &j * &tilting.v;
        assert!(rates[0] < -1e-3 && rates[1].abs() < 1e-14, "{rates}");
    }

    #[test]
    fn a_blow_passes_through_the_joints() {
        // A lever of two carts tied together, x₁ = x₂: both stop as one body of 3 kg.
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 1.0]));
        let g = DMatrix::from_row_slice(1, 2, &[1.0, -1.0]);
        let j = DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
        let stops = Stops { jacobian: &j, restitution: &[0.5] };
        let v = DVector::from_vec(vec![2.0, 2.0]);
        let found = impact(&mass, &g, &DVector::zeros(1), &stops, &v).expect("a blow");
        assert!((found.v - DVector::from_element(2, -1.0)).amax() < 1e-14);
        assert!((found.impulses[0] - 9.0).abs() < 1e-13);
    }

    #[test]
    fn a_stop_against_a_driven_joint_has_no_answer() {
        let mass = DMatrix::from_element(1, 1, 1.0);
        let one = DMatrix::from_element(1, 1, 1.0);
        let stops = Stops { jacobian: &one, restitution: &[0.0] };
        let rate = DVector::from_element(1, -2.0);
        let found = impact(&mass, &one, &rate, &stops, &DVector::from_element(1, 2.0));
        assert_eq!(found, None);
    }
}
