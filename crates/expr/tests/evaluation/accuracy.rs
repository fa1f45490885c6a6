//! Functions that lanes compute by themselves: by all evaluators, next to the standard ones, with the special values of
//! IEEE 754.

#![expect(clippy::disallowed_methods, reason = "the standard library is what is compared with")]

use super::evaluators::{compile, special_points};
use super::ways::{check_agreement, is_same};
use bksim_expr::{Expr, Pool};

/// A function as text, the standard library's, and the most units between them.
type Row = (&'static str, fn(f64, f64) -> f64, u64);

/// Distance in units in the last place of `b`.
fn ulps(a: f64, b: f64) -> u64 {
    if is_same(a, b) { 0 } else { a.to_bits().abs_diff(b.to_bits()) }
}

/// Values at all points, which all evaluators agree on, are within so many units of the standard library's.
fn check<const N: usize>(functions: [Row; N], points: impl Iterator<Item = (f64, f64)>) {
    let pool = Pool::new();
    let outputs: Vec<Expr> =
        functions.iter().map(|(text, ..)| pool.parse(text).expect("valid")).collect();
    let points: Vec<Vec<f64>> = points.map(|(x, y)| vec![x, y, 0.0]).collect();
    let values = check_agreement(&compile(&pool, &outputs), &[0.0; 2], &points);
    for (point, values) in points.iter().zip(values) {
        for ((text, standard, most), found) in functions.iter().zip(values) {
            let expected = standard(point[0], point[1]);
            let distance = ulps(found, expected);
            assert!(
                distance <= *most,
                "{text} at {point:?}: {found:?}, {distance} units from {expected:?}"
            );
        }
    }
}

/// Numbers of all signs and sizes, infinities and subnormal ones among them.
fn any_numbers(n: u64) -> impl Iterator<Item = f64> {
    // Multiples of the golden ratio fill the bits evenly.
    (0..n).map(|i| f64::from_bits(i.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// `n` numbers from `low` to `high`.
fn even(n: u32, low: f64, high: f64) -> impl Iterator<Item = f64> {
    (0..=n).map(move |i| low + (high - low) * (f64::from(i) / f64::from(n)))
}

/// Within 0.8 units of the truth, as the standard library is within 0.52: neighbours at most.
#[test]
fn sine_and_cosine_are_neighbours_of_the_standard_ones() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let near_quarters = (0..4000).map(|k| f64::from(k * k) * quarter);
    let dense = (-20_000..20_000).map(|i| f64::from(i) * 7.3e-4);
    let wide = (0..4000).map(|i| f64::from(i).powi(5) * 1e-9 - 5e7);
    let large = (6..300).map(|exponent| 1.7 * 10f64.powi(exponent));
    let angles = near_quarters.chain(dense).chain(wide).chain(large);
    check([("sin(x)", |x, _| x.sin(), 1), ("cos(x)", |x, _| x.cos(), 1)], angles.map(|x| (x, 0.0)));
}

#[test]
fn exponentials_are_neighbours_of_the_standard_ones() {
    let dense = even(20_000, -1.0, 1.0).chain(even(20_000, -720.0, 712.0));
    let gradual = even(4000, -746.0, -707.0);
    let tiny = (0..1080).map(|exponent| -(2f64.powi(-exponent)));
    let all = dense.chain(gradual).chain(tiny).chain(any_numbers(20_000));
    check([("exp(x)", |x, _| x.exp(), 1)], all.map(|x| (x, 0.0)));
}

#[test]
fn logarithms_are_neighbours_of_the_standard_ones() {
    let dense = even(20_000, 0.4, 3.0).chain(even(4000, 0.0, 1e4));
    let near_one = (1..53).flat_map(|n| [1.0 + 2f64.powi(-n), 1.0 - 2f64.powi(-n)]);
    let subnormal = (0..4000_u64).map(|i| f64::from_bits(i * i * i + 1));
    let all = dense.chain(near_one).chain(subnormal).chain(any_numbers(40_000));
    check([("ln(x)", |x, _| x.ln(), 1)], all.map(|x| (x, 0.0)));
}

/// The standard library's is off by two units itself, ours by one.
#[test]
fn hyperbolic_tangents_are_near_the_standard_ones() {
    let dense = even(20_000, -1.0, 1.0).chain(even(4000, -25.0, 25.0));
    let tiny = (0..1080).map(|exponent| -(2f64.powi(-exponent)));
    let all = dense.chain(tiny).chain(any_numbers(20_000));
    check([("tanh(x)", |x, _| x.tanh(), 3)], all.map(|x| (x, 0.0)));
}

#[test]
fn angles_are_neighbours_of_the_standard_ones() {
    // All around, near axes and diagonals and in between.
    let around = even(20_000, -3.2, 3.2).map(|angle| (1.7 * angle.cos(), 1.7 * angle.sin()));
    let axes = (0..1100).flat_map(|exponent| {
        let (near, far) = (3.0 * 2f64.powi(-exponent), 2f64.powi(exponent % 300) * 1.1);
        [(far, near), (-far, near), (near, far), (-near, -far), (far, near * far)]
    });
    let diagonals = (1..53).flat_map(|n| {
        let near = 1.0 + 2f64.powi(-n);
        [(1.0, near), (-near, 1.0), (near * 1e200, -1e200), (-1e-310, -1e-310 * near)]
    });
    // Quotients that are hardly numbers.
    let faint = even(20_000, 0.5, 1.5).zip(even(20_000, 1e-310, 3e-308));
    let any = any_numbers(20_000).zip(any_numbers(40_000).skip(17_711));
    let points = around.chain(axes).chain(diagonals).chain(faint).chain(any);
    check([("atan2(y, x)", |x, y| y.atan2(x), 1), ("atan(y)", |_, y| y.atan(), 1)], points);
}

#[test]
fn special_values_are_those_of_the_standard_library() {
    let points = special_points().into_iter().map(|point| (point[0], point[1]));
    let exact = points.clone().filter(|(x, y)| !is_plain(*x) && !is_plain(*y));
    let functions: [Row; 5] = [
        ("exp(x)", |x, _| x.exp(), 0),
        ("ln(x)", |x, _| x.ln(), 0),
        ("tanh(x)", |x, _| x.tanh(), 0),
        ("atan(x)", |x, _| x.atan(), 0),
        ("atan2(x, y)", f64::atan2, 0),
    ];
    check(functions, exact);
    check(functions.map(|(text, standard, _)| (text, standard, 3)), points);
}

/// True where a number is neither zero nor infinite.
fn is_plain(x: f64) -> bool {
    x != 0.0 && x.is_finite()
}
