//! Every way to differentiate against the values of the function, by a path of its own.

use crate::common::{Point, Recipe, every_function, points, recipes, symbols, value_at};
use bksim_expr::{Expr, Pool, SymbolId};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// ∂/∂(direction) of the last step, by central differences of plain floating-point values; `None`
/// where the function is too steep, jumps, or has no value.
fn difference_quotient(recipe: &Recipe, point: &Point, direction: &Point) -> Option<f64> {
    let value = |h: f64| {
        let mut moved = *point;
        moved.iter_mut().zip(direction).for_each(|(x, d)| *x += h * d);
        let values = recipe.values(&moved);
        values[values.len() - 1]
    };
    let quotient = |h: f64| (value(h) - value(-h)) / (2.0 * h);
    let one_sided = |h: f64| (value(h) - value(0.0)) / h;
    let (coarse, fine) = (quotient(4e-5), quotient(1e-5));
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-5 * fine.abs().max(1.0);
    // A kink shows in the two one-sided quotients.
    let has_kink = (one_sided(1e-5) - one_sided(-1e-5)).abs() > 1e-2 * fine.abs().max(1.0);
    let expected = recipe.expected(point);
    let is_usable = expected.has_value && !expected.is_on_edge && expected.scale < 1e4;
    (is_usable && close(coarse, fine) && !has_kink && fine.is_finite()).then_some(fine)
}

/// Whether two derivatives of one function agree where both have values.
fn agree(a: f64, b: f64, tolerance: f64) -> bool {
    let is_huge = a.abs().max(b.abs()) > 1e8;
    !a.is_finite() || !b.is_finite() || is_huge || (a - b).abs() <= tolerance * a.abs().max(1.0)
}

fn unit(i: usize) -> Point {
    let mut direction = [0.0; 5];
    direction[i] = 1.0;
    direction
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 800, failure_persistence: None, rng_seed: RngSeed::Fixed(1684), ..ProptestConfig::default() })]

    #[test]
    fn derivatives_are_those_of_the_values(
        recipe in recipes(every_function(), 10),
        point in points(),
    ) {
        let pool = Pool::new();
        let e = recipe.build(&pool);
        let xs = symbols(&pool);
        let gradient = pool.gradient(e, &xs);
        for (i, &x) in xs.iter().enumerate() {
            let Some(expected) = difference_quotient(&recipe, &point, &unit(i)) else { continue };
            let forward = value_at(&pool, pool.diff(e, x), &point);
            // A derivative may have a removable singularity of its own: that of 0^x is 0·ln 0.
            let is_close = (forward - expected).abs() <= 1e-3 * expected.abs().max(1.0);
            prop_assert!(!forward.is_finite() || is_close, "{} by {i}: {forward} is not {expected}", pool.to_text(e));
            let backward = value_at(&pool, gradient[i], &point);
            prop_assert!(agree(forward, backward, 1e-9), "{forward} forward, {backward} backward");
        }
    }

    /// J d by one forward sweep, dᵀ Jᵀ w by one backward sweep, and both from J itself.
    #[test]
    fn products_with_the_jacobian_agree(
        recipe in recipes(every_function(), 12),
        point in points(),
        direction in prop::array::uniform5(-2i64..3),
        weights in prop::array::uniform3(-2i64..3),
    ) {
        let expected = recipe.expected(&point);
        if expected.is_on_edge || expected.scale > 1e4 {
            return Ok(());
        }
        let pool = Pool::new();
        let xs = symbols(&pool);
        let last = recipe.build(&pool);
        let outputs = [last, pool.mul(last, pool.symbol("a")), pool.sin(pool.symbol("q2"))];
        let numbers = |n: &[i64]| n.iter().map(|&n| pool.int(n)).collect::<Vec<Expr>>();
        let value = |e: Expr| value_at(&pool, e, &point);

        let forward = pool.jvp(&outputs, &xs, &numbers(&direction));
        let backward = pool.vjp(&outputs, &numbers(&weights), &xs);
        let jacobian = pool.jacobian(&outputs, &xs);
        let (mut rows, mut columns) = ([0.0; 3], [0.0; 5]);
        for &(i, j, entry) in &jacobian.entries {
            rows[i] += value(entry) * direction[j] as f64;
            columns[j] += value(entry) * weights[i] as f64;
        }
        for (found, expected) in forward.iter().zip(rows) {
            prop_assert!(agree(expected, value(*found), 1e-8), "{expected}, {}", pool.to_text(*found));
        }
        for (found, expected) in backward.iter().zip(columns) {
            prop_assert!(agree(expected, value(*found), 1e-8), "{expected}, {}", pool.to_text(*found));
        }
    }

    #[test]
    fn second_derivatives_are_symmetric_and_those_of_the_first(
        recipe in recipes(crate::common::SMOOTH.to_vec(), 7),
        point in points(),
    ) {
        let pool = Pool::new();
        let xs = symbols(&pool);
        let e = recipe.build(&pool);
        let hessian = pool.hessian(e, &xs);
        let entry = |i: usize, j: usize| {
            let found = hessian.entries.iter().find(|entry| (entry.0, entry.1) == (i, j));
            found.map_or(pool.zero(), |entry| entry.2)
        };
        for (i, &x) in xs.iter().enumerate() {
            for (j, &y) in xs.iter().enumerate() {
                prop_assert_eq!(entry(i, j), entry(j, i));
                let expected = value_at(&pool, pool.diff(pool.diff(e, y), x), &point);
                let found = value_at(&pool, entry(i, j), &point);
                prop_assert!(agree(expected, found, 1e-7), "{expected} is not {found}, {i} {j}");
            }
        }
    }

    /// Twice along time: the chain rule over positions, velocities and accelerations.
    #[test]
    fn rates_are_those_along_a_path(
        recipe in recipes(crate::common::SMOOTH.to_vec(), 8),
        start in prop::array::uniform5(-1.5..1.5),
        speed in prop::array::uniform5(-1.0..1.0),
        bend in prop::array::uniform5(-1.0..1.0),
    ) {
        let pool = Pool::new();
        let e = recipe.build(&pool);
        let (mut rates, mut at) = (Vec::new(), Vec::new());
        for (i, &q) in symbols(&pool).iter().enumerate() {
            let [v, a] = ["v", "a_"].map(|l| pool.symbol(&format!("{l}{i}")));
            let id = |e: Expr| pool.symbol_id(e).expect("a symbol");
            rates.extend([(q, v), (id(v), a)]);
            at.extend([(q, start[i]), (id(v), speed[i]), (id(a), bend[i])]);
        }
        let value = |e: Expr| {
            let of = |s: SymbolId| at.iter().find(|known| known.0 == s).map(|known| known.1);
            pool.evaluate(e, &of).expect("bound")
        };
        let first = pool.total_derivative(e, &rates);
        let second = pool.total_derivative(first, &rates);
        let path = |t: f64| {
            let q: Vec<f64> = (0..5).map(|i| start[i] + t * speed[i] + t * t * bend[i] / 2.0).collect();
            let values = recipe.values(&q.try_into().expect("five"));
            values[values.len() - 1]
        };
        let h = 1e-3;
        let (low, here, high) = (path(-h), path(0.0), path(h));
        let near = (path(h / 2.0) - path(-h / 2.0)) / h;
        let expected = (high - low) / (2.0 * h);
        let bent = (high - 2.0 * here + low) / (h * h);
        let bent_near = (path(h / 2.0) - 2.0 * here + path(-h / 2.0)) / (h * h / 4.0);
        let close = |a: f64, b: f64, tolerance: f64| (a - b).abs() <= tolerance * b.abs().max(1.0);
        let there = recipe.expected(&start);
        if close(expected, near, 1e-5) && there.scale < 1e3 && !there.is_on_edge {
            let found = value(first);
            prop_assert!(!found.is_finite() || close(found, near, 1e-4), "{found} is not {near}");
            if close(bent, bent_near, 1e-3) {
                let found = value(second);
                let is_close = close(found, bent_near, 1e-2);
                prop_assert!(!found.is_finite() || is_close, "{found} is not {bent_near}");
            }
        }
    }
}

#[test]
fn weights_and_directions_are_not_differentiated() {
    let pool = Pool::new();
    let [x, y] = ["x", "y"].map(|name| pool.symbol(name));
    let wrt = [x, y].map(|e| pool.symbol_id(e).expect("a symbol"));
    let f = [pool.mul(x, y)];
    assert_eq!(pool.jvp(&f, &wrt, &[x, x]), [pool.parse("x*y + x^2").expect("valid")]);
    let expected = ["x*y", "x^2"].map(|text| pool.parse(text).expect("valid"));
    assert_eq!(pool.vjp(&f, &[x], &wrt), expected);
    // A symbol listed twice gets its column twice; nothing to differentiate gives nothing.
    assert_eq!(pool.vjp(&f, &[y], &[wrt[0], wrt[0]]), [pool.powi(y, 2); 2]);
    assert!(pool.vjp(&f, &[y], &[]).is_empty() && pool.jvp(&[], &wrt, &[x, y]).is_empty());
    assert_eq!(pool.jvp(&f, &[], &[]), [pool.zero()]);
}

/// The value of a derivative at a point, taken forward and backward.
fn slope_at(text: &str, name: &str, point: &[(&str, f64)]) -> [f64; 2] {
    let pool = Pool::new();
    let e = pool.parse(text).expect(text);
    let x = pool.find_symbol(name).expect("was parsed");
    let value = |s| point.iter().find(|known| known.0 == pool.symbol_name(s)).map(|known| known.1);
    let backward = pool.vjp(&[e], &[pool.one()], &[x])[0];
    [pool.diff(e, x), backward].map(|slope| pool.evaluate(slope, &value).expect("bound"))
}

/// min + max is a + b, and so is its derivative, at a tie too.
#[test]
fn at_a_tie_each_side_counts_once() {
    for (text, expected) in [
        ("min(x, y) + max(x, y)", 1.0),
        ("min(2*x, 3*x) + max(2*x, 3*x)", 5.0),
        ("min(x^2, 5*x) + max(5*x, x^2)", 5.0),
    ] {
        assert_eq!(slope_at(text, "x", &[("x", 0.0), ("y", 0.0)]), [expected; 2], "{text}");
    }
}

/// A root or power of a product that is zero whatever x is does not change with it.
#[test]
fn what_stays_zero_has_the_derivative_zero() {
    let zero = [0.0; 2];
    for (text, expected) in [
        ("sqrt(x*z)", zero),
        ("sqrt(3*x*z)", zero),
        ("sqrt(2*x*z*(1 + x))", zero),
        ("(x*z)^0.3", zero),
        ("sqrt(sin(x)*z) + x", [1.0; 2]),
        ("0^x", zero),
        ("0^(2*x)", zero),
        ("sqrt(8*x*y*z + 4*x^2)", [2.0; 2]),
        ("sqrt(6*x*y)", [3.0; 2]),
    ] {
        let found = slope_at(text, "x", &[("x", 0.5), ("y", 3.0), ("z", 0.0)]);
        let is_close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14);
        assert!(is_close, "{text}: {found:?} is not {expected:?}");
    }
    // 0^x jumps at x = 0 and has no value below.
    for x in [0.0, -1.0] {
        let found = slope_at("0^x", "x", &[("x", x)]);
        assert!(found.iter().all(|slope| !slope.is_finite()), "at {x}: {found:?}");
    }
}
