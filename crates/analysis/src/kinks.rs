//! Kinks of the forces in a pose: on either side of it the stiffness is another one.
//!
//! ```text
//! K_r(q ± ε z)       of a smooth law they differ by ε alone
//! ω = 2/(1/ω₋ + 1/ω₊)    one free motion: half a period on each side
//! ```

use bksim_mbs::coordinate::CoordinateKind;
use nalgebra::DMatrix;

use crate::balance::Balance;
use crate::reduced::Reduced;

/// A motion along which the forces have a kink.
#[derive(Clone, PartialEq, Debug)]
pub struct Kink {
    /// The independent quantity.
    pub name: String,
    /// Stiffness below and above the pose, SI.
    pub stiffness: [f64; 2],
    /// Of a mechanism with one free motion the angular frequencies of either side, and that of the whole swing, rad/s.
    pub omega: Option<[f64; 3]>,
}

/// Distance from the pose to either side, rad or longest links.
const ASIDE: f64 = 1e-6;
/// Part of the stiffness that no smooth law changes by so near to a pose.
const KINK: f64 = 1e-3;

impl Balance<'_> {
    /// The kinks of the forces in a pose with multipliers of the rows that hold.
    pub(crate) fn kinks(&mut self, q: &[f64], lambda: &[f64]) -> Vec<Kink> {
        let at = self.at(q, lambda);
        let Ok(reduced) = self.reduced(q, &at.jacobian) else { return Vec::new() };
        let mass = reduced.project(&at.mass);
        let mut found = Vec::new();
        for k in 0..reduced.n() {
            let [below, above] =
                [-1.0, 1.0].map(|side| self.stiffness_aside(q, lambda, (&reduced, k, side)));
            let size = below.amax().max(above.amax());
            if !size.is_finite() || (&above - &below).amax() <= KINK * size {
                continue;
            }
            let stiffness = [below[(k, k)], above[(k, k)]];
            let omega = (reduced.n() == 1 && stiffness.iter().all(|k| *k > 0.0)).then(|| {
                let [a, b] = stiffness.map(|k| (k / mass[(0, 0)]).sqrt());
                [a, b, 2.0 / (1.0 / a + 1.0 / b)]
            });
            let omega = omega.filter(|all| all.iter().all(|omega| omega.is_finite()));
            found.push(Kink { name: reduced.names[k].clone(), stiffness, omega });
        }
        found
    }

    /// The stiffness next to a pose, along one of the free motions.
    fn stiffness_aside(
        &mut self,
        q: &[f64],
        lambda: &[f64],
        (reduced, k, side): (&Reduced, usize, f64),
    ) -> DMatrix<f64> {
        let coordinates = self.loaded.system().coordinates();
        let is_length = |i: usize| coordinates[i].kind == CoordinateKind::Length;
        let along = reduced.basis.column(k);
        let longest = (0..q.len()).fold(0.0, |a: f64, i| {
            a.max(along[i].abs() / if is_length(i) { self.loaded.size } else { 1.0 })
        });
        let step = side * ASIDE / longest.max(f64::MIN_POSITIVE);
        let there: Vec<f64> = q.iter().zip(along.iter()).map(|(q, d)| q + step * d).collect();
        reduced.project(&self.at(&there, lambda).stiffness)
    }
}
