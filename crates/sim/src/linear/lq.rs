//! The smallest solution of equations whose rows are far from depending on each other.
//!
//! ```text
//! P G = L Qᵀ,    x = Q L⁻¹ P r
//! ```
//!
//! Householder's reflections take the rows one after the other, always the one of which the most is left. Where little
//! is left of the last one, singular values must decide what counts as nothing. They take some forty times as long.
//!
//! Source: G. H. Golub and C. F. Van Loan, *Matrix Computations*, 4th ed. 2013, §5.1.3, §5.4.2, §5.6.2.

/// Part of the longest row that is left of each row without those before it. The smallest singular value is seldom
/// much smaller than that part, and counts as zero at a hundred-thousandth of it.
const CLEAR: f64 = 1e-4;

/// The shortest x with G x = r, the rows of G of length `n` one after the other in `left`; `None` where they may depend
/// on each other, or an entry is not finite.
pub(crate) fn shortest_solution(mut left: Vec<f64>, n: usize, r: &[f64]) -> Option<Vec<f64>> {
    let m = r.len();
    if m > n {
        return None;
    }
    let mut order: Vec<usize> = (0..m).collect();
    // Of each reflection 1 − β w wᵀ its β; w takes the place of what was left of its row.
    let mut factors = vec![0.0; m];
    let mut diagonal = vec![0.0; m];
    for k in 0..m {
        let rest = |row: usize| {
            let rest = left[row * n + k..][..n - k].iter();
            rest.map(|g| g * g).sum::<f64>().sqrt()
        };
        let farther = |best: (usize, f64), row: usize| {
            let rest = rest(row);
            if rest > best.1 { (row, rest) } else { best }
        };
        let (best, norm) = (k + 1..m).fold((k, rest(k)), farther);
        let longest = diagonal.first().map_or(0.0, |l: &f64| l.abs());
        if !norm.is_finite() || norm <= CLEAR * longest {
            return None;
        }
        order.swap(k, best);
        swap_rows(&mut left, n, (k, best));
        let (done, after) = left.split_at_mut((k + 1) * n);
        let w = &mut done[k * n + k..];
        diagonal[k] = if w[0] > 0.0 { -norm } else { norm };
        factors[k] = 1.0 / (norm * (norm + w[0].abs()));
        w[0] -= diagonal[k];
        after.chunks_exact_mut(n).for_each(|row| reflect(factors[k], w, &mut row[k..]));
    }

    // L y = P r, then x = Q y.
    let mut x = vec![0.0; n];
    for k in 0..m {
        let known: f64 = left[k * n..][..k].iter().zip(&x).map(|(l, y)| l * y).sum();
        x[k] = (r[order[k]] - known) / diagonal[k];
    }
    for k in (0..m).rev() {
        reflect(factors[k], &left[k * n + k..][..n - k], &mut x[k..]);
    }
    Some(x)
}

/// x less β w wᵀ x.
fn reflect(factor: f64, w: &[f64], x: &mut [f64]) {
    let along: f64 = w.iter().zip(&*x).map(|(w, x)| w * x).sum();
    let share = factor * along;
    x.iter_mut().zip(w).for_each(|(x, w)| *x -= share * w);
}

/// Exchanges two rows of n numbers, the second not before the first.
fn swap_rows(rows: &mut [f64], n: usize, (a, b): (usize, usize)) {
    if a != b {
        let (before, from_b) = rows.split_at_mut(b * n);
        before[a * n..][..n].swap_with_slice(&mut from_b[..n]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::dense::least_squares;
    use nalgebra::{DMatrix, DVector};

    fn random() -> impl FnMut() -> f64 {
        let mut state = 3_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            2.0 * ((state >> 11) as f64 / (1_u64 << 53) as f64) - 1.0
        }
    }

    /// Numbers of which many are zero, one or small, as those of Jacobians are.
    fn entry(next: &mut impl FnMut() -> f64) -> f64 {
        match next() {
            kind if kind > 0.2 => next(),
            kind if kind > 0.0 => 1.0,
            kind if kind > -0.1 => 1.5e-3,
            _ => 0.0,
        }
    }

    #[test]
    fn solutions_are_those_by_singular_values() {
        let mut next = random();
        let mut n_solved = 0;
        for case in 0..5000 {
            let m = 1 + case % 8;
            let n = m + case / 8 % 5;
            let rows: Vec<f64> = (0..m * n).map(|_| entry(&mut next)).collect();
            let r: Vec<f64> = (0..m).map(|_| next()).collect();
            let matrix = DMatrix::from_row_slice(m, n, &rows);
            let Some(found) = shortest_solution(rows, n, &r) else { continue };
            n_solved += 1;
            let (expected, rank) = least_squares(&matrix, &DVector::from_vec(r));
            assert_eq!(rank, m, "{matrix}");
            let error = (DVector::from_vec(found) - &expected).amax();
            assert!(error <= 1e-10 * expected.amax().max(1.0), "{error:e} of {matrix}");
        }
        assert!(n_solved > 3500, "{n_solved} of 5000");
    }

    #[test]
    fn rows_that_may_depend_on_each_other_are_left_to_singular_values() {
        let solved = |rows: &[f64], n: usize, r: &[f64]| shortest_solution(rows.to_vec(), n, r);
        let near = |apart: f64| solved(&[1.0, 2.0, 0.0, 2.0, 4.0 + apart, 0.0], 3, &[1.0, 1.0]);
        assert_eq!((near(0.0), near(1e-6)), (None, None));
        assert!(near(1e-2).is_some());
        assert_eq!(solved(&[0.0, f64::NAN], 2, &[1.0]), None);
        // More equations than unknowns, and none.
        assert_eq!(solved(&[1.0, 1.0], 1, &[1.0, 1.0]), None);
        assert_eq!(solved(&[], 2, &[]), Some(vec![0.0, 0.0]));
    }
}
