//! A sequence of points that fills a cube evenly, however many there are of them.

/// The additive sequence x_j = k φ^−(j+1) mod 1 in [−½, ½)ⁿ with φ the positive root of φ^(n+1) = φ + 1, whose
/// first point is the centre.
///
/// Source: M. Roberts, *The unreasonable effectiveness of quasirandom sequences* (2018); for n = 1
/// the sequence of the golden section.
pub(super) struct Sequence {
    /// φ^−(j+1) by coordinate.
    shares: Vec<f64>,
}

impl Sequence {
    pub(super) fn new(n: usize) -> Self {
        let root = root(n);
        let next = |share: &f64| Some(share / root);
        Self { shares: std::iter::successors(Some(1.0 / root), next).take(n).collect() }
    }

    /// Point `k`.
    pub(super) fn point(&self, k: usize) -> impl Iterator<Item = f64> {
        self.shares.iter().map(move |share| (0.5 + k as f64 * share).fract() - 0.5)
    }
}

/// The positive root of x^(n+1) = x + 1, which lies in [1, 2], by halving.
fn root(n: usize) -> f64 {
    let power = |x: f64| (0..=n).fold(1.0, |power, _| power * x);
    let halved = |(low, high): (f64, f64), _| {
        let middle = 0.5 * (low + high);
        if power(middle) > middle + 1.0 { (low, middle) } else { (middle, high) }
    };
    (0..60).fold((1.0, 2.0), halved).0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_fill_every_cell_of_a_square() {
        const N: u32 = 8;
        let sequence = Sequence::new(2);
        let points: Vec<Vec<f64>> = (0..256).map(|k| sequence.point(k).collect()).collect();
        let edge = |i: u32| f64::from(i) / f64::from(N) - 0.5;
        let met = |i: u32, j: u32| {
            let is_in = |x: f64, i: u32| (edge(i)..edge(i + 1)).contains(&x);
            points.iter().filter(|p| is_in(p[0], i) && is_in(p[1], j)).count()
        };
        let counts: Vec<usize> = (0..N * N).map(|cell| met(cell / N, cell % N)).collect();
        assert_eq!(points[0], [0.0, 0.0]);
        assert!(counts.iter().all(|n| (1..=8).contains(n)), "{counts:?}");
    }
}
