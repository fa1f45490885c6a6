//! [`Laurent`]: polynomials in T = e^(iθ) and 1/T, and their roots with discs that hold them.
//!
//! ```text
//! p(T) = Σ cₖ Tᵏ,  conjugate on the circle  p̄(T) = Σ c̄ₖ T⁻ᵏ
//! Tᵢ ← Tᵢ − w/(1 − w Σ_{j≠i} 1/(Tᵢ − Tⱼ)),  w = p/p′          all roots at once
//! |T − Tᵢ| ≤ n (|p(Tᵢ)| + e)/(|cₙ| Π_{j≠i} |Tᵢ − Tⱼ|)          discs; one that meets no other holds one root
//! ```
//!
//! A polynomial that is real on the circle has with T the root 1/T̄. So a root whose disc is alone, mirror image included,
//! is its own mirror image and lies on the circle; that is what makes an assembly certain.
//!
//! Source: O. Aberth, *Iteration methods for finding all zeros of a polynomial simultaneously*, Math. Comp. 27 (1973)
//! 339; the discs: B. T. Smith, *Error bounds for zeros of a polynomial based upon Gerschgorin's theorems*, J. ACM 17
//! (1970) 661.

use nalgebra::Complex;

/// A complex number.
pub(super) type C = Complex<f64>;

/// A polynomial from T^low on.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Laurent {
    low: i32,
    c: Vec<C>,
}

/// A root of a polynomial in e^(iθ) with a disc that holds it and no other.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Root {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Radius of the disc.
    pub radius: f64,
    /// True on the unit circle: an assembly; else the disc does not reach it.
    pub is_assembly: bool,
}

impl Laurent {
    /// Σ cₖ Tᵏ of the pairs (k, cₖ).
    pub(super) fn new(terms: &[(i32, C)]) -> Self {
        let zero = Self { low: 0, c: Vec::new() };
        let one = |&(k, c): &(i32, C)| Self { low: k, c: vec![c] };
        terms.iter().map(one).fold(zero, |sum, term| sum.plus(&term))
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        if self.c.is_empty() || other.c.is_empty() {
            return if self.c.is_empty() { other.clone() } else { self.clone() };
        }
        let end = |p: &Self| p.low + i32::try_from(p.c.len()).unwrap_or(0);
        let low = self.low.min(other.low);
        let of =
            |p: &Self, k: i32| usize::try_from(k - p.low).ok().and_then(|i| p.c.get(i)).copied();
        let c = (low..end(self).max(end(other)))
            .map(|k| of(self, k).unwrap_or_default() + of(other, k).unwrap_or_default());
        Self { low, c: c.collect() }
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        if self.c.is_empty() || other.c.is_empty() {
            return Self { low: 0, c: Vec::new() };
        }
        let mut c = vec![C::default(); self.c.len() + other.c.len() - 1];
        for (i, a) in self.c.iter().enumerate() {
            for (j, b) in other.c.iter().enumerate() {
                c[i + j] += a * b;
            }
        }
        Self { low: self.low + other.low, c }
    }

    pub(super) fn minus(&self, other: &Self) -> Self {
        let negative = other.c.iter().map(|c| -c).collect();
        self.plus(&Self { low: other.low, c: negative })
    }

    /// Conjugate on the circle.
    pub(super) fn conjugate(&self) -> Self {
        let n = i32::try_from(self.c.len()).unwrap_or(0);
        Self { low: 1 - n - self.low, c: self.c.iter().rev().map(Complex::conj).collect() }
    }

    /// Value on the circle.
    pub(super) fn at(&self, t: C) -> C {
        let sum = self.c.iter().rev().fold(C::default(), |sum, c| sum * t + c);
        sum * t.powi(self.low)
    }

    /// All roots but zero, each in its disc; none where discs meet or do not tell whether a root is on the circle.
    /// The polynomial is real on the circle, or its values there have one phase.
    pub(super) fn roots(&self) -> Option<Vec<Root>> {
        let size = self.c.iter().map(|c| c.norm()).fold(0.0, f64::max);
        // Ends that are rounding: a mechanism of a lower degree.
        let is_some = |c: &&C| c.norm() > 1e-13 * size;
        let first = self.c.iter().position(|c| is_some(&c))?;
        let last = self.c.iter().rposition(|c| is_some(&c))?;
        let c: Vec<C> = self.c[first..=last].iter().map(|c| c / size).collect();
        if c.len() < 2 {
            return Some(Vec::new());
        }
        certified(&c, &aberth(&c)?)
    }
}

/// Value and slope of a polynomial.
fn horner(c: &[C], t: C) -> (C, C) {
    let start = (C::default(), C::default());
    c.iter().rev().fold(start, |(p, slope), c| (p * t + c, slope * t + p))
}

/// All roots at once.
fn aberth(c: &[C]) -> Option<Vec<C>> {
    const MOST: usize = 200;
    let n = c.len() - 1;
    // Around the circle, off every symmetry.
    let guess = |k: usize| C::from_polar(1.1, 0.7 + std::f64::consts::TAU * k as f64 / n as f64);
    let mut roots: Vec<C> = (0..n).map(guess).collect();
    for _ in 0..MOST {
        let mut largest: f64 = 0.0;
        for i in 0..n {
            let (p, slope) = horner(c, roots[i]);
            if p.norm() == 0.0 {
                continue;
            }
            let w = p / slope;
            let others = (0..n).filter(|&j| j != i).map(|j| (roots[i] - roots[j]).inv());
            let step = w / (C::from(1.0) - w * others.sum::<C>());
            if !(step.re.is_finite() && step.im.is_finite()) {
                return None;
            }
            roots[i] -= step;
            largest = largest.max(step.norm() / (1.0 + roots[i].norm()));
        }
        if largest < 4.0 * f64::EPSILON {
            break;
        }
    }
    Some(roots)
}

/// Roots with their discs.
fn certified(c: &[C], roots: &[C]) -> Option<Vec<Root>> {
    /// Roundings in a value and in the coefficients, which are sums of products of some lengths.
    const ROUNDINGS: f64 = 64.0;
    let n = roots.len();
    let radius = |i: usize| {
        let t = roots[i];
        let largest = c.iter().map(|c| c.norm()).fold(0.0, f64::max);
        let powers: f64 = (0..=n).map(|k| t.norm().powi(i32::try_from(k).unwrap_or(0))).sum();
        let rounding = ROUNDINGS * f64::EPSILON * largest * powers;
        let others = (0..n).filter(|&j| j != i).map(|j| (t - roots[j]).norm()).product::<f64>();
        n as f64 * (horner(c, t).0.norm() + rounding) / (c[n].norm() * others)
    };
    let radii: Vec<f64> = (0..n).map(radius).collect();
    let root = |i: usize| {
        let t = roots[i];
        let off = (t.norm() - 1.0).abs();
        let is_assembly = off <= radii[i];
        // A disc on the circle with the mirror image of its root: |T − 1/T̄| ≤ 2.5 of the distance from the circle.
        let reach = radii[i] + if is_assembly { 2.5 * (off + radii[i]) } else { 0.0 };
        let is_alone = |j: usize| j == i || (t - roots[j]).norm() > reach + radii[j];
        let is_sure = radii[i] < 0.1 * t.norm() && (0..n).all(is_alone);
        is_sure.then_some(Root { re: t.re, im: t.im, radius: radii[i], is_assembly })
    };
    (0..n).map(root).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roots on the circle at three angles, and one pair off it.
    #[test]
    fn roots_on_the_circle_are_told_from_others() {
        let angles = [0.3, -1.2, 2.5];
        let mut p = Laurent::new(&[(0, C::from(1.0))]);
        let outside = C::from_polar(1.4, 0.9);
        let inside = outside.conj().inv();
        let on = angles.map(|angle| C::from_polar(1.0, angle));
        for root in on.into_iter().chain([outside, inside]) {
            p = p.times(&Laurent::new(&[(1, C::from(1.0)), (0, -root)]));
        }
        let roots = p.roots().expect("certain roots");
        assert_eq!(roots.len(), 5);
        let found: Vec<&Root> = roots.iter().filter(|root| root.is_assembly).collect();
        assert_eq!(found.len(), 3);
        for angle in angles {
            let is_this =
                |root: &&&Root| (root.re - angle.cos()).hypot(root.im - angle.sin()) < 1e-12;
            assert_eq!(found.iter().filter(is_this).count(), 1, "{angle}");
        }
        assert!(roots.iter().all(|root| root.radius < 1e-10));
    }

    #[test]
    fn a_double_root_is_not_certain() {
        let factor = Laurent::new(&[(1, C::from(1.0)), (0, -C::from_polar(1.0, 0.4))]);
        assert_eq!(factor.times(&factor).roots(), None);
    }

    #[test]
    fn conjugates_are_those_on_the_circle() {
        let p = Laurent::new(&[(-1, C::new(0.3, -2.0)), (2, C::new(1.5, 0.2))]);
        let t = C::from_polar(1.0, 0.8);
        assert!((p.conjugate().at(t) - p.at(t).conj()).norm() < 1e-14);
    }
}
