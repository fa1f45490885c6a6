//! A look at pivots that were computed elsewhere.

#![expect(clippy::inline_always, reason = "the kernel is compiled with the widest registers")]

use pulp::{Arch, Simd, WithSimd};

use super::{Elimination, Order, SMALLEST_PIVOT};

/// Pivots that are looked at together.
const WIDTH: usize = 4;

/// Numbers of a state of which `n` are its pivots: whole blocks, the last of the pivots in the rest of them.
pub(crate) fn n_padded(n: usize) -> usize {
    n.next_multiple_of(WIDTH)
}

/// Pivots with the last of them once more, up to [`n_padded`].
pub(crate) fn padded<T: Copy>(pivots: &[T]) -> impl Iterator<Item = T> {
    let n_more = n_padded(pivots.len()) - pivots.len();
    pivots.iter().copied().chain(pivots.last().copied().into_iter().cycle().take(n_more))
}

/// A look at pivots of states one after the other, each padded: the largest magnitudes so far, and the least of these.
struct Look<'a> {
    pivots: &'a [f64],
    signs: &'a [f64],
    best: &'a mut [f64],
}

/// True where all are regular, and the rank margin.
type Found = (bool, f64);

impl WithSimd for Look<'_> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Found {
        let Self { pivots, signs, best } = self;
        let n_blocks = signs.len() / WIDTH;
        let pivots = pivots.as_chunks::<WIDTH>().0;
        let (mut margin, mut are_regular) = ([1.0; WIDTH], [true; WIDTH]);
        let blocks = best.as_chunks_mut::<WIDTH>().0.iter_mut().zip(signs.as_chunks().0);
        for (b, (best, sign)) in blocks.enumerate() {
            let sign: &[f64; WIDTH] = sign;
            // NaN where a pivot is not finite.
            let (mut largest, mut least, mut remainder) =
                (*best, [f64::INFINITY; WIDTH], [0.0; WIDTH]);
            for state in pivots.chunks_exact(n_blocks) {
                for lane in 0..WIDTH {
                    let magnitude = sign[lane] * state[b][lane];
                    largest[lane] =
                        if magnitude > largest[lane] { magnitude } else { largest[lane] };
                    least[lane] = if magnitude < least[lane] { magnitude } else { least[lane] };
                    remainder[lane] += 0.0 * magnitude;
                }
            }
            for lane in 0..WIDTH {
                let floor = SMALLEST_PIVOT * largest[lane];
                are_regular[lane] &= least[lane] + remainder[lane] > floor;
                let part = if sign[lane] < 0.0 { least[lane] / largest[lane] } else { 1.0 };
                margin[lane] = if part < margin[lane] { part } else { margin[lane] };
            }
            *best = largest;
        }
        let margin = margin.iter().fold(1.0, |a, &b| if b < a { b } else { a });
        (are_regular == [true; WIDTH], margin)
    }
}

impl Elimination {
    /// Looks at pivots that were computed elsewhere, in this order of elimination; false where one of them
    /// vanishes, has the wrong sign or is not finite.
    pub(crate) fn accept_pivots(&mut self, pivots: &[f64]) -> bool {
        self.accept_lanes(pivots.iter().map(|&pivot| [pivot]))
    }

    /// Accepts the pivots of several states at once.
    pub(crate) fn accept_lanes<const N: usize>(
        &mut self,
        pivots: impl Iterator<Item = [f64; N]>,
    ) -> bool {
        let Self { order, best, .. } = self;
        let Order { nq, nodes, .. } = &**order;
        let (mut are_regular, mut margin) = (true, 1.0);
        for ((best, &node), pivots) in best.iter_mut().zip(nodes).zip(pivots) {
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

    /// Accepts the pivots of states one after the other, each [`padded`].
    pub(crate) fn accept_states(&mut self, pivots: &[f64]) -> bool {
        let Self { order, best, .. } = self;
        let (are_regular, margin) =
            Arch::new().dispatch(Look { pivots, signs: &order.signs, best });
        self.rank_margin = if are_regular { margin } else { 0.0 };
        are_regular
    }

    /// Keeps the best pivots in the room of solutions.
    pub(crate) fn keep_best(&mut self) {
        let n = self.x.len();
        self.x.copy_from_slice(&self.best[..n]);
    }

    /// Takes back the best pivots that were kept; nothing may have been solved since.
    pub(crate) fn restore_best(&mut self) {
        self.best[..self.x.len()].copy_from_slice(&self.x);
    }
}
