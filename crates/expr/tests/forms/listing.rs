//! Lists of steps: as long as the graph, the same in every pool, and a way back to equal expressions.

use crate::common::{every_function, recipes};
use bksim_expr::{ListingError, Pool};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, rng_seed: RngSeed::Fixed(20), ..ProptestConfig::default() })]

    #[test]
    fn an_expression_survives_its_listing(recipe in recipes(every_function(), 24)) {
        let (pool, other) = (Pool::new(), Pool::new());
        // Other handles, and others of the symbols.
        other.parse("q3*b + sin(a)").expect("an expression");
        let e = recipe.build(&pool);
        let listing = pool.listing(&[e]);
        let copy = other.read_listing(&listing).expect("a listing")[0];
        // Built again, a part may fold further than it did in the order of its author; but it does so in every pool.
        let again = pool.read_listing(&listing).expect("a listing")[0];
        prop_assert_eq!(other.to_text(copy), pool.to_text(again));
        prop_assert_eq!(other.listing(&[copy]), pool.listing(&[again]));
        let numbers = |pool: &Pool, e| {
            let symbols = pool.symbols_of(e);
            pool.evaluate(e, &|symbol| symbols.contains(&symbol).then_some(0.7)).ok()
        };
        if let (Some(a), Some(b)) = (numbers(&pool, e), numbers(&pool, again)) {
            prop_assert!((a - b).abs() <= 1e-9 * (1.0 + a.abs()) || !a.is_finite(), "{a} and {b}");
        }
    }

    #[test]
    fn a_damaged_listing_is_expressions_or_an_error(
        recipe in recipes(every_function(), 12), at in 0..400usize, byte in 0u8..128,
    ) {
        let pool = Pool::new();
        let mut bytes = pool.listing(&[recipe.build(&pool)]).into_bytes();
        let at = at % bytes.len();
        bytes[at] = byte;
        let text = String::from_utf8(bytes).expect("ASCII");
        if let Ok(found) = pool.read_listing(&text) {
            prop_assert!(found.iter().all(|&e| !pool.to_text(e).is_empty()));
        }
    }
}

#[test]
fn numbers_keep_their_kind_and_every_digit() {
    let pool = Pool::new();
    let texts = ["3^200/7", "1e-300", "22/7", "-5", "2^(1/2)"];
    let mut all: Vec<_> = texts.iter().map(|text| pool.parse(text).expect(text)).collect();
    let floats = [0.1, -0.0, 1e300, f64::INFINITY, f64::MIN_POSITIVE / 8.0];
    all.extend(floats.map(|value| pool.float(value)));
    assert_eq!(pool.read_listing(&pool.listing(&all)).expect("a listing"), all);
}

#[test]
fn a_listing_is_as_long_as_the_graph() {
    let pool = Pool::new();
    let mut e = pool.symbol("x");
    for _ in 0..200 {
        // Written out, this has 2²⁰⁰ symbols.
        e = pool.sin(pool.add(pool.mul(e, e), e));
    }
    let listing = pool.listing(&[e]);
    assert!(listing.lines().count() < 1000, "{} lines", listing.lines().count());
    assert_eq!(pool.read_listing(&listing), Ok(vec![e]));
}

#[test]
fn what_is_no_listing_is_told_by_its_line() {
    let pool = Pool::new();
    for (text, line) in [
        ("", 1),
        ("symbol x\n", 2),
        ("symbol x\nsin 1\n= 0\n", 2),
        ("symbol x\nsinus 0\n= 0\n", 2),
        ("symbol x\natan2 0\n= 0\n", 2),
        ("symbol x\npair 0 0\nsin 1\n= 2\n", 3),
        ("number 1/0\n= 0\n", 1),
        ("pi\n= 0 1\n", 2),
    ] {
        assert_eq!(pool.read_listing(text), Err(ListingError(line)), "{text:?}");
    }
}
