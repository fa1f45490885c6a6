//! A look at pivots that were computed elsewhere.

#![expect(clippy::inline_always, reason = "the kernel is compiled with the widest registers")]

use pulp::{Arch, Simd, WithSimd};

use super::{Elimination, SMALLEST_PIVOT};

/// The extremes of each pivot over states, with the largest magnitudes of all states so far.
struct Extremes<'a> {
    pivots: &'a [f64],
    signs: &'a [f64],
    best: &'a mut [f64],
    least: &'a mut [f64],
    /// NaN where a pivot is not finite, else zero.
    remainder: &'a mut [f64],
}

impl WithSimd for Extremes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { pivots, signs, best, least, remainder } = self;
        least.fill(f64::INFINITY);
        remainder.fill(0.0);
        let ((signs, last_signs), zero) = (S::as_simd_f64s(signs), simd.splat_f64s(0.0));
        let (best, last_best) = S::as_mut_simd_f64s(best);
        let (least, last_least) = S::as_mut_simd_f64s(least);
        let (remainder, last_remainder) = S::as_mut_simd_f64s(remainder);
        for state in pivots.chunks_exact((signs.len() * S::F64_LANES + last_signs.len()).max(1)) {
            let (state, last) = S::as_simd_f64s(state);
            let sums = best.iter_mut().zip(&mut *least).zip(&mut *remainder);
            for (((best, least), remainder), (&sign, &pivot)) in sums.zip(signs.iter().zip(state)) {
                let magnitude = simd.mul_f64s(sign, pivot);
                *best = simd.max_f64s(magnitude, *best);
                *least = simd.min_f64s(magnitude, *least);
                *remainder = simd.add_f64s(*remainder, simd.mul_f64s(zero, magnitude));
            }
            let sums = last_best.iter_mut().zip(&mut *last_least).zip(&mut *last_remainder);
            for (((best, least), remainder), (&sign, &pivot)) in
                sums.zip(last_signs.iter().zip(last))
            {
                let magnitude = sign * pivot;
                *best = if magnitude > *best { magnitude } else { *best };
                *least = if magnitude < *least { magnitude } else { *least };
                *remainder += 0.0 * magnitude;
            }
        }
    }
}

impl Elimination {
    /// Looks at pivots that were computed elsewhere, in this order of elimination; false where one of them
    /// vanishes, has the wrong sign or is not finite.
    pub(crate) fn accept_pivots(&mut self, pivots: &[f64]) -> bool {
        self.accept_lanes(pivots.iter().map(|&pivot| [pivot]))
    }

    /// The same for the pivots of several states at once.
    pub(crate) fn accept_lanes<const N: usize>(
        &mut self,
        pivots: impl Iterator<Item = [f64; N]>,
    ) -> bool {
        let Self { nq, nodes, best, .. } = self;
        let (mut are_regular, mut margin) = (true, 1.0);
        for ((best, &node), pivots) in best.iter_mut().zip(&*nodes).zip(pivots) {
            let is_multiplier = node >= *nq;
            let magnitudes = pivots.map(|pivot| if is_multiplier { -pivot } else { pivot });
            let largest = magnitudes.iter().fold(*best, |a, &b| if b > a { b } else { a });
            *best = largest;
            // NaN fails the comparison.
            let floor = SMALLEST_PIVOT * largest;
            are_regular &= magnitudes.iter().filter(|&&m| m > floor).count() == N;
            let least = magnitudes.iter().fold(largest, |a, &b| if b < a { b } else { a });
            if is_multiplier && least < margin * largest {
                margin = least / largest;
            }
        }
        self.rank_margin = if are_regular { margin } else { 0.0 };
        are_regular
    }

    /// The same for the pivots of states one after the other.
    pub(crate) fn accept_states(&mut self, pivots: &[f64]) -> bool {
        let Self { nq, nodes, signs, best, extremes: [least, remainder], .. } = self;
        Arch::new().dispatch(Extremes { pivots, signs, best, least, remainder });
        let (mut are_regular, mut margin) = (true, 1.0);
        for (i, &node) in nodes.iter().enumerate() {
            let (largest, least) = (best[i], least[i]);
            are_regular &= least + remainder[i] > SMALLEST_PIVOT * largest;
            if node >= *nq && least < margin * largest {
                margin = least / largest;
            }
        }
        self.rank_margin = if are_regular { margin } else { 0.0 };
        are_regular
    }

    /// Keeps the best pivots in the room of solutions.
    pub(crate) fn keep_best(&mut self) {
        self.x.copy_from_slice(&self.best);
    }

    /// Takes back the best pivots that were kept; nothing may have been solved since.
    pub(crate) fn restore_best(&mut self) {
        self.best.copy_from_slice(&self.x);
    }
}
