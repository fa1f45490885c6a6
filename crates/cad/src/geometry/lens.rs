//! [`Lens`]: the piece of the unit disc between an arc and its chord.
//!
//! With half the angle of the arc α, x outwards from the middle of the chord and y along it:
//!
//! ```text
//! ∫ dA    = α − ½ sin 2α
//! ∫ x dA  = ¾ sin α + 1/12 sin 3α − α cos α
//! ∫ x² dA = ¾ α + ½ α cos 2α − 7/12 sin 2α − 1/48 sin 4α
//! ∫ y² dA = ¼ α − 1/6 sin 2α + 1/48 sin 4α
//! ```
//!
//! Each is the integral of the one before it or of powers of the sine, as moving the chord by
//! `sin α dα` adds a strip of width `2 sin α`: `a' = 2 sin² α`, `b' = a sin α`, `c' = 2 b sin α`,
//! `d' = ⅔ sin⁴ α`. At small angles the closed forms cancel (to α⁷ in `∫ x² dA`), and their
//! Taylor series takes over.

/// Moments of a lens of the unit disc about the middle of its chord.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Lens {
    /// ∫ dA.
    pub(super) area: f64,
    /// ∫ x dA.
    pub(super) first: f64,
    /// ∫ x² dA, x outwards from the chord.
    pub(super) outwards: f64,
    /// ∫ y² dA, y along the chord.
    pub(super) chord: f64,
}

/// Below this angle, rad, the series: there the closed forms have lost three digits.
const SMALL: f64 = 0.75;

/// Terms of the series; the last one is below rounding at [`SMALL`].
const N_TERMS: i32 = 16;

impl Lens {
    /// For half an angle from 0 to π, rad.
    pub(super) fn of(half: f64) -> Self {
        if half < SMALL { Self::series(half) } else { Self::closed_form(half) }
    }

    fn closed_form(a: f64) -> Self {
        let sin = |k: f64| (k * a).sin();
        Self {
            area: a - 0.5 * sin(2.0),
            first: 0.75 * sin(1.0) + sin(3.0) / 12.0 - a * a.cos(),
            outwards: 0.75 * a + 0.5 * a * (2.0 * a).cos()
                - 7.0 / 12.0 * sin(2.0)
                - sin(4.0) / 48.0,
            chord: 0.25 * a - sin(2.0) / 6.0 + sin(4.0) / 48.0,
        }
    }

    /// `Σ (−1)ᵏ c_k α^(2k+1)/(2k+1)!` with `c_k` of each closed form; it begins at the first
    /// `c_k ≠ 0`, and all `c_k` are exact in floating point as long as they matter.
    fn series(a: f64) -> Self {
        let mut lens = Self { area: 0.0, first: 0.0, outwards: 0.0, chord: 0.0 };
        // (−1)ᵏ α^(2k+1)/(2k+1)!
        let mut term = a;
        for k in 1..N_TERMS {
            let n = f64::from(2 * k + 1);
            term *= -a * a / (n * (n - 1.0));
            let power = |base: f64| base.powi(2 * k);
            let (two, three, four) = (power(2.0), power(3.0), power(4.0));
            lens.area -= term * two;
            if k >= 2 {
                lens.first += term * (0.75 + three / 4.0 - n);
                lens.chord += term * (four / 12.0 - two / 3.0);
            }
            if k >= 3 {
                lens.outwards += term * (n * two / 2.0 - 7.0 / 6.0 * two - four / 12.0);
            }
        }
        lens
    }
}

#[cfg(test)]
mod tests {
    use super::{Lens, SMALL};

    fn fields(lens: Lens) -> [f64; 4] {
        [lens.area, lens.first, lens.outwards, lens.chord]
    }

    #[test]
    fn series_and_closed_forms_agree_where_both_are_good() {
        for half in [0.6, SMALL, 0.9] {
            let (series, closed) = (fields(Lens::series(half)), fields(Lens::closed_form(half)));
            for (series, closed) in series.into_iter().zip(closed) {
                assert!((series / closed - 1.0).abs() < 2e-13, "{half}: {series} {closed}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_a_moving_chord() {
        for half in [0.01, 0.3, 0.74, 0.76, 1.5, 2.5, 3.1] {
            let h = 1e-4 * half;
            let (after, before) = (fields(Lens::of(half + h)), fields(Lens::of(half - h)));
            let lens = Lens::of(half);
            let sin = f64::sin(half);
            let exact =
                [2.0 * sin * sin, lens.area * sin, 2.0 * lens.first * sin, sin.powi(4) / 1.5];
            for k in 0..4 {
                let slope = (after[k] - before[k]) / (2.0 * h);
                assert!((slope - exact[k]).abs() < 1e-6 * exact[k].abs().max(1e-3 * half.powi(6)));
            }
        }
    }

    #[test]
    fn the_whole_disc_is_a_lens() {
        // About a point of the circle: π, π, π/4 + π and π/4.
        let whole = fields(Lens::of(std::f64::consts::PI)).map(|m| m / std::f64::consts::PI);
        for (found, exact) in whole.into_iter().zip([1.0, 1.0, 1.25, 0.25]) {
            assert!((found - exact).abs() < 1e-15, "{found} {exact}");
        }
    }

    #[test]
    fn a_thin_lens_is_the_piece_of_a_parabola() {
        let half = 1e-5_f64;
        let leading = [2.0 / 3.0 * half.powi(3), 2.0 / 15.0 * half.powi(5)];
        let lens = Lens::of(half);
        assert!((lens.area / leading[0] - 1.0).abs() < 1e-9, "{lens:?}");
        assert!((lens.first / leading[1] - 1.0).abs() < 1e-9, "{lens:?}");
        assert!((lens.outwards / (4.0 / 105.0 * half.powi(7)) - 1.0).abs() < 1e-9, "{lens:?}");
    }
}
