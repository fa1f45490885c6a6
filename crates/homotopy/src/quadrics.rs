//! [`Between`]: a family of quadratic forms from one set to another.
//!
//! ```text
//! H = (1 − s) xᵀ Aⱼ x + s xᵀ Bⱼ x,  j = 1 … n − 1,   α·x = 1
//! ```
//!
//! Where the A are in general position among forms of their kind, every isolated zero of the B is the end of a path from a zero
//! of the A.
//!
//! Source: A. J. Sommese and C. W. Wampler, *The Numerical Solution of Systems of Polynomials* (2005), theorem 7.1.4.

use nalgebra::{DMatrix, DVector};

use crate::C;
use crate::path::{At, Family};

/// Symmetric forms on n numbers, one less than these, which are zeros up to a factor.
#[derive(Clone, Debug)]
pub struct Between<'a> {
    /// A.
    pub from: &'a [DMatrix<C>],
    /// B.
    pub to: &'a [DMatrix<C>],
    /// α.
    pub patch: &'a DVector<C>,
}

impl Family for Between<'_> {
    fn n(&self) -> usize {
        self.patch.len()
    }

    fn at(&self, x: &DVector<C>, s: f64, at: &mut At) {
        let (n, rest, share) = (self.n(), C::from(1.0 - s), C::from(s));
        for (j, (from, to)) in self.from.iter().zip(self.to).enumerate() {
            let (first, last) = (from * x, to * x);
            let (a, b) = (first.dot(x), last.dot(x));
            at.value[j] = rest * a + share * b;
            at.rate[j] = b - a;
            for i in 0..n {
                at.jacobian[(j, i)] = C::from(2.0) * (rest * first[i] + share * last[i]);
            }
        }
        at.value[n - 1] = self.patch.dot(x) - C::from(1.0);
        at.rate[n - 1] = C::default();
        at.jacobian.row_mut(n - 1).copy_from(&self.patch.transpose());
    }
}
