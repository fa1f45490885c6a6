//! Adaptive Gauss quadrature for what has no closed form.

/// Nodes and weights of the positive half of the Gauss–Legendre rule with 16 nodes, which is exact
/// for polynomials of degree 31 (Abramowitz & Stegun, table 25.4).
const HALF_RULE: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_59),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];

/// Halving ends when it changes an integral by less than this, relative to the integral of its
/// absolute value.
const CHANGE: f64 = 1e-14;

/// Ends the halving at integrands without derivatives, and those that are no numbers.
const MAX_HALVINGS: usize = 512;

/// One interval with its integral and that of the absolute values.
struct Interval<const N: usize> {
    from: f64,
    to: f64,
    integral: [f64; N],
}

/// Integrals of `f` over 0 to 1; intervals are halved until that changes nothing.
pub(crate) fn adaptive<const N: usize>(f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let (integral, scale) = gauss(&f, 0.0, 1.0);
    let mut rest = vec![Interval { from: 0.0, to: 1.0, integral }];
    let mut sum = [0.0; N];
    let mut n_halvings = 0;
    while let Some(Interval { from, to, integral }) = rest.pop() {
        let middle = 0.5 * (from + to);
        let (left, _) = gauss(&f, from, middle);
        let (right, _) = gauss(&f, middle, to);
        let is_settled =
            (0..N).all(|k| (left[k] + right[k] - integral[k]).abs() <= CHANGE * scale[k]);
        if is_settled || n_halvings == MAX_HALVINGS {
            for k in 0..N {
                sum[k] += left[k] + right[k];
            }
            continue;
        }
        n_halvings += 1;
        rest.push(Interval { from, to: middle, integral: left });
        rest.push(Interval { from: middle, to, integral: right });
    }
    sum
}

/// Integrals of `f` and of its absolute values.
fn gauss<const N: usize>(f: &impl Fn(f64) -> [f64; N], from: f64, to: f64) -> ([f64; N], [f64; N]) {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let (mut sum, mut scale) = ([0.0; N], [0.0; N]);
    for (node, weight) in HALF_RULE {
        for value in [f(middle - half * node), f(middle + half * node)] {
            for k in 0..N {
                sum[k] += weight * half * value[k];
                scale[k] += weight * half * value[k].abs();
            }
        }
    }
    (sum, scale)
}

#[cfg(test)]
mod tests {
    use super::adaptive;
    use super::gauss;

    #[test]
    fn the_rule_is_exact_up_to_degree_31() {
        for degree in 0..32 {
            let (found, _) = gauss(&|t: f64| [t.powi(degree)], 0.0, 1.0);
            let exact = 1.0 / f64::from(degree + 1);
            assert!((found[0] - exact).abs() <= 4e-16, "degree {degree}: {} {exact}", found[0]);
        }
        let (found, _) = gauss(&|t: f64| [(2.0 * t - 1.0).powi(32)], 0.0, 1.0);
        assert!(
            (found[0] - 1.0 / 33.0).abs() > 1e-13,
            "no rule of 16 nodes is exact for degree 32"
        );
    }

    #[test]
    fn a_narrow_peak_is_found_by_halving() {
        // ∫ 1/(a² + (t − ½)²) = 2/a arctan(1/(2a)).
        let a = 1e-3_f64;
        let found = adaptive(|t| [1.0 / (a * a + (t - 0.5) * (t - 0.5))])[0];
        let exact = 2.0 / a * (0.5 / a).atan();
        assert!((found / exact - 1.0).abs() < 1e-13, "{found} {exact}");
    }

    #[test]
    fn numbers_that_are_none_end_the_halving() {
        assert!(adaptive(|_| [f64::NAN])[0].is_nan());
        assert!(adaptive(|t: f64| [t.powf(-0.9)])[0].is_finite());
    }
}
