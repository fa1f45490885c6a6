//! The multiplier system of mechanisms with massless coordinates.
//!
//! ```text
//! [ M + w GᵀG  Gᵀ ] [ x ]   [ b + w Gᵀ r ]        has the solution of        [ M  Gᵀ ] [ x ]   [ b ]
//! [ G          0  ] [ λ ] = [ r          ]                                   [ G  0  ] [ λ ] = [ r ]
//! ```
//!
//! for every w, and its upper left block is positive definite where M is so on the motions that G
//! leaves free, as it must be for accelerations to exist. Source: M. Benzi, G. H. Golub and
//! J. Liesen, *Numerical solution of saddle point problems*, Acta Numerica 14 (2005), §5.3.

use std::collections::BTreeMap;

use crate::linear::elimination::{Elimination, Singular};
use crate::linear::shape::Shape;

/// The recorded elimination of the augmented system.
#[derive(Clone, Debug)]
pub(crate) struct Augmented {
    elimination: Elimination,
    /// Index of each value of M among those of M + w GᵀG.
    of_mass: Vec<usize>,
    /// Two values of G, and the index of the entry that their product adds to.
    products: Vec<(usize, usize, usize)>,
    /// Values of M + w GᵀG.
    mass: Vec<f64>,
    weight: f64,
    /// (value of G, number of its row among the active ones, coordinate).
    couplings: Vec<(usize, usize, usize)>,
    nq: usize,
}

impl Augmented {
    /// Plans the elimination; `active` are the rows of G that take part.
    pub(crate) fn new(shape: &Shape, active: &[usize]) -> Self {
        // Values of G in active rows, and the same by row.
        let mut number_of_row = vec![None; shape.nc];
        active.iter().enumerate().for_each(|(k, &row)| number_of_row[row] = Some(k));
        let couplings: Vec<(usize, usize, usize)> = shape
            .jacobian
            .iter()
            .enumerate()
            .filter_map(|(value, &(row, i))| number_of_row[row].map(|k| (value, k, i)))
            .collect();
        let mut by_row: Vec<Vec<(usize, usize)>> = vec![Vec::new(); active.len()];
        for &(value, k, i) in &couplings {
            by_row[k].push((value, i));
        }

        // Entries of M, then those that the rows add.
        let mut indices: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let mut mass = Vec::new();
        let mut index = |i: usize, j: usize| {
            let entry = (i.max(j), i.min(j));
            *indices.entry(entry).or_insert_with(|| {
                mass.push(entry);
                mass.len() - 1
            })
        };
        let of_mass = shape.mass.iter().map(|&(i, j)| index(i, j)).collect();
        let mut products = Vec::new();
        for row in &by_row {
            for (a, &(value, i)) in row.iter().enumerate() {
                products.extend(row[a..].iter().map(|&(other, j)| (value, other, index(i, j))));
            }
        }
        let n_entries = mass.len();
        let shape = Shape { mass, ..shape.clone() };
        Self {
            elimination: Elimination::new(&shape, active),
            of_mass,
            products,
            mass: vec![0.0; n_entries],
            weight: 1.0,
            couplings,
            nq: shape.nq,
        }
    }

    /// Factors the system with these values of M and G, in the order of the shape.
    ///
    /// # Errors
    /// [`Singular`] says whose pivot vanishes.
    pub(crate) fn factor(&mut self, mass: &[f64], jacobian: &[f64]) -> Result<(), Singular> {
        let largest = |values: &[f64]| values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let weight = largest(mass) / largest(jacobian).powi(2);
        self.weight = if weight > 0.0 && weight.is_finite() { weight } else { 1.0 };
        self.mass.fill(0.0);
        for (&index, value) in self.of_mass.iter().zip(mass) {
            self.mass[index] += value;
        }
        for &(a, b, index) in &self.products {
            self.mass[index] += self.weight * jacobian[a] * jacobian[b];
        }
        self.elimination.factor(&self.mass, jacobian)
    }

    /// Rank margin; see [`Elimination::rank_margin`].
    pub(crate) fn rank_margin(&self) -> f64 {
        self.elimination.rank_margin()
    }

    /// Best pivots; see [`Elimination::best_pivots`].
    pub(crate) fn best_pivots(&self) -> &[f64] {
        self.elimination.best_pivots()
    }

    /// Best pivots to be overwritten; see [`Elimination::best_pivots_mut`].
    pub(crate) fn best_pivots_mut(&mut self) -> &mut [f64] {
        self.elimination.best_pivots_mut()
    }

    /// Solves the original system with these values of G, in place.
    pub(crate) fn solve_in_place(&mut self, jacobian: &[f64], x: &mut [f64]) {
        let (upper, lower) = x.split_at_mut(self.nq);
        for &(value, k, i) in &self.couplings {
            upper[i] += self.weight * jacobian[value] * lower[k];
        }
        self.elimination.solve_in_place(x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A massless coordinate between two bodies: x = a + b, y = b.
    #[test]
    fn a_massless_coordinate_follows_its_constraint() {
        let shape = Shape {
            nq: 3,
            nc: 1,
            mass: vec![(0, 0), (2, 2)],
            jacobian: vec![(0, 0), (0, 1), (0, 2)],
            of_rates: Vec::new(),
        };
        let (mass, jacobian) = ([2.0, 3.0], [1.0, -1.0, 1.0]);
        let plain = Elimination::new(&shape, &[0]).factor(&mass, &jacobian);
        assert_eq!(plain, Err(Singular::Coordinate));
        let mut augmented = Augmented::new(&shape, &[0]);
        augmented.factor(&mass, &jacobian).expect("regular on the motions left free");
        let mut x = [4.0, 0.0, 9.0, 0.5];
        augmented.solve_in_place(&jacobian, &mut x);
        // No force on the massless coordinate: λ = 0, so that x₀ = 2, x₂ = 3 and x₁ = x₀ + x₂ − ½.
        for (found, wanted) in x.into_iter().zip([2.0, 4.5, 3.0, 0.0]) {
            assert!((found - wanted).abs() < 1e-14, "{found} against {wanted}");
        }
    }
}
