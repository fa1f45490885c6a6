//! Exactness and bounds of numbers.

use super::*;

#[test]
fn no_digit_is_dropped() {
    let ten = Number::integer(10);
    for n in [18, 19, 20, 60, 300] {
        let large = ten.power(n).expect("short enough");
        let next = large.plus(Number::ONE);
        assert_eq!(next.plus(large.negated()), Number::ONE, "10^{n}");
        assert!(next.order(&large).is_gt(), "10^{n}");
        let small = Number::ONE.over(&large);
        assert_eq!(small.plus(Number::ONE).plus(Number::MINUS_ONE), small, "10^-{n}");
        assert_eq!(next.times(&next).exact_sqrt(), Some(next), "10^{n}");
    }
}

#[test]
fn the_smallest_integer_has_a_negative() {
    let smallest = Number::from(i64::MIN);
    assert_eq!(smallest.negated().negated(), smallest);
    assert_eq!(smallest.negated().to_f64(), 2f64.powi(63));
    assert_eq!(smallest.plus(Number::ONE), Number::from(i64::MIN + 1));
    assert_eq!(smallest.as_integer(), None);
}

#[test]
fn lengths_are_bounded() {
    let ten = Number::integer(10);
    assert_eq!(ten.power(1_000_000_000), None);
    assert_eq!(ten.power(i64::MIN), None);
    assert_eq!(Number::MINUS_ONE.power(i64::MAX), Some(Number::MINUS_ONE));
    // A product beyond the bound is a float: here it has no finite value.
    let mut large = ten.power(300).expect("short enough");
    while large.is_exact() {
        large = large.times(&large);
    }
    assert!(!large.is_finite());
}

#[test]
fn short_and_long_fractions_follow_the_same_rules() {
    let parts = [0i64, 1, -1, 2, -6, 35, (1 << 31) - 1, 1 << 31, -(1 << 33), i64::MAX];
    for (a, b) in parts.iter().flat_map(|a| parts.iter().map(move |b| (*a, *b))) {
        for (c, d) in parts.iter().flat_map(|c| parts.iter().map(move |d| (*c, *d))) {
            if b == 0 || d == 0 {
                continue;
            }
            let (x, y) = (Number::rational(a, b), Number::rational(c, d));
            let [u, v] = [(a, b), (c, d)].map(|(n, d)| BigRational::new(n.into(), d.into()));
            assert_eq!(x.plus(&y), Number::from_big(&u + &v), "{x} + {y}");
            assert_eq!(x.times(&y), Number::from_big(&u * &v), "{x} * {y}");
            assert_eq!(x.order(&y), u.cmp(&v), "{x} and {y}");
        }
    }
}

#[test]
fn decimals_of_any_length_follow_the_rules_of_fractions() {
    let decimal = |n: i64, twos: u32, fives: u32| {
        let scale = BigInt::from(2).pow(twos) * BigInt::from(5).pow(fives);
        BigRational::new(n.into(), scale)
    };
    // Numerators with and without twos and fives; denominators of 1 to 450 digits, and thirds among them.
    let numerators = [0, 3, -10, 64, 1 << 40, 5i64.pow(20), -i64::MAX, 0x1234_5678_9abc_def1];
    let scales = [(0, 0), (1, 0), (0, 1), (17, 17), (60, 3), (5, 40), (0, 441), (9, 500)];
    let decimals = numerators.iter().flat_map(|&n| scales.map(|(a, b)| decimal(n, a, b)));
    let third = BigRational::new(1.into(), 3.into());
    let fractions: Vec<BigRational> = decimals.flat_map(|d| [&d * &third, d]).collect();
    for (a, b) in fractions.iter().flat_map(|a| fractions.iter().map(move |b| (a, b))) {
        let [x, y] = [a, b].map(|fraction| Number::from_big(fraction.clone()));
        assert_eq!(x.plus(&y), Number::from_big(a + b), "{a} + {b}");
        let (numerator, denominator) = (a * b).into_raw();
        assert_eq!(x.times(&y), Number::from_factors(numerator, denominator), "{a} * {b}");
        assert_eq!(x.is_like(&y), a.abs() == b.abs(), "{a} and {b}");
    }
}

#[test]
fn greatest_common_divisors_leave_integers() {
    let gcd = Number::rational(5, 6).gcd(&Number::rational(10, 9));
    assert_eq!(gcd, Some(Number::rational(5, 18)));
    assert_eq!(Number::ONE.gcd(&Number::float(0.3)), None);
}

#[test]
fn powers_are_repeated_products() {
    let decimals =
        [(123_456_789_012_345_678, 1_000_000_007), (-3, 7), (1, 10_i64.pow(17)), (i64::MAX, 2)];
    for base in decimals.map(|(p, q)| Number::rational(p, q)) {
        let mut product = Number::ONE;
        for n in 1..=5 {
            product = product.times(&base);
            assert_eq!(base.power(n), Some(product.clone()), "({base})^{n}");
            assert_eq!(base.power(-n), Some(Number::ONE.over(&product)), "({base})^-{n}");
        }
    }
}
