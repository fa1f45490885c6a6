//! [`track`]: one solution of a family of equations followed along its parameter.
//!
//! ```text
//! H(x, s) = 0,   dx/ds = −H_x⁻¹ H_s         predicted by the classical method of Runge and Kutta,
//!                                            corrected by Newton's iteration
//! ```
//!
//! Source: A. J. Sommese and C. W. Wampler, *The Numerical Solution of Systems of Polynomials* (2005), section 2.3.

use nalgebra::{DMatrix, DVector};

use crate::C;

/// Values and slopes of a family at one point.
#[derive(Clone, Debug)]
pub struct At {
    /// H.
    pub value: DVector<C>,
    /// ∂H/∂x.
    pub jacobian: DMatrix<C>,
    /// ∂H/∂s.
    pub rate: DVector<C>,
}

impl At {
    /// Zeros for `n` equations in as many unknowns.
    pub fn zeros(n: usize) -> Self {
        let vector = || DVector::from_element(n, C::default());
        Self {
            value: vector(),
            jacobian: DMatrix::from_element(n, n, C::default()),
            rate: vector(),
        }
    }
}

/// Equations that depend on a parameter from 0 to 1.
pub trait Family {
    /// Number of equations and of unknowns.
    fn n(&self) -> usize;

    /// Writes value and slopes at `x` and `s`; every entry is written.
    fn at(&self, x: &DVector<C>, s: f64, at: &mut At);
}

/// Where a path ended.
#[derive(Clone, PartialEq, Debug)]
pub enum End {
    /// The solution at the end.
    Arrived(DVector<C>),
    /// The steps became too short: a singular solution, or one at infinity.
    Lost {
        /// The parameter.
        s: f64,
    },
}

/// Follows the solution `x` at zero to the other end.
pub fn track(family: &dyn Family, x: &DVector<C>) -> End {
    const FIRST: f64 = 0.05;
    const LONGEST: f64 = 0.2;
    const SHORTEST: f64 = 1e-9;
    const MOST_STEPS: usize = 5000;
    /// Steps in sequence after which one twice as long is tried.
    const GOOD: usize = 3;
    let mut at = At::zeros(family.n());
    let (mut x, mut s, mut step, mut n_good) = (x.clone(), 0.0, FIRST, 0);
    for _ in 0..MOST_STEPS {
        if s >= 1.0 {
            return polished(family, x, &mut at).map_or(End::Lost { s }, End::Arrived);
        }
        let h = f64::min(step, 1.0 - s);
        let next = if h < 1.0 - s { s + h } else { 1.0 };
        let there = predicted(family, &x, s, next, &mut at);
        if let Some(there) = there.and_then(|there| corrected(family, there, next, &mut at)) {
            (x, s) = (there, next);
            n_good += 1;
            if n_good == GOOD {
                (step, n_good) = (f64::min(2.0 * step, LONGEST), 0);
            }
        } else {
            (step, n_good) = (0.5 * h, 0);
            if step < SHORTEST {
                break;
            }
        }
    }
    End::Lost { s }
}

/// dx/ds.
fn slope(family: &dyn Family, x: &DVector<C>, s: f64, at: &mut At) -> Option<DVector<C>> {
    family.at(x, s, at);
    let slope = at.jacobian.clone().lu().solve(&at.rate)?;
    slope.iter().all(|x| x.re.is_finite() && x.im.is_finite()).then(|| -slope)
}

fn predicted(
    family: &dyn Family,
    x: &DVector<C>,
    s: f64,
    next: f64,
    at: &mut At,
) -> Option<DVector<C>> {
    let h = next - s;
    let (half, full) = (C::from(0.5 * h), C::from(h));
    let k1 = slope(family, x, s, at)?;
    let k2 = slope(family, &(x + &k1 * half), s + 0.5 * h, at)?;
    let k3 = slope(family, &(x + &k2 * half), s + 0.5 * h, at)?;
    let k4 = slope(family, &(x + &k3 * full), next, at)?;
    Some(x + (k1 + (k2 + k3) * C::from(2.0) + k4) * C::from(h / 6.0))
}

/// Newton's iteration; none where the prediction was so far off that another path may be nearer.
fn corrected(family: &dyn Family, mut x: DVector<C>, s: f64, at: &mut At) -> Option<DVector<C>> {
    /// Largest first correction and the one that ends the iteration, of the size of x.
    const FARTHEST: f64 = 1e-3;
    const NEAR: f64 = 1e-9;
    /// Rounding near to a singular point.
    const NEARLY: f64 = 1e-6;
    const MOST: usize = 3;
    let mut last = f64::INFINITY;
    for k in 0..MOST {
        family.at(&x, s, at);
        let step = at.jacobian.clone().lu().solve(&at.value)?;
        let share = step.norm() / (1e-30 + x.norm());
        if share.is_nan() || (k == 0 && share > FARTHEST) {
            return None;
        }
        x -= step;
        if share < NEAR || (share < NEARLY && share > 0.1 * last) {
            return Some(x);
        }
        last = share;
    }
    None
}

/// A solution at the end of a path to all digits; none where Newton's iteration leaves it.
fn polished(family: &dyn Family, mut x: DVector<C>, at: &mut At) -> Option<DVector<C>> {
    const MOST: usize = 6;
    /// Rounding of a solution that is nearly singular.
    const NEARLY: f64 = 1e-4;
    let size = 1e-30 + x.norm();
    let mut last = f64::INFINITY;
    for _ in 0..MOST {
        family.at(&x, 1.0, at);
        let step = at.jacobian.clone().lu().solve(&at.value)?;
        let share = step.norm() / size;
        if share.is_nan() || share > 1e-3 {
            return None;
        }
        // As near as rounding lets it come.
        if share >= 0.5 * last {
            break;
        }
        x -= step;
        last = share;
    }
    (last < NEARLY).then_some(x)
}
