//! Arithmetic that is put together without expressions.

use super::ways::check_agreement;
use bksim_expr::{Composition, Value};

/// 1e16 + 1 − 1e16 is one where the large numbers come first, and none in this order.
#[test]
fn terms_that_are_known_first_are_added_first() {
    let sum = |late: usize| {
        let mut composition = Composition::new(3, 0);
        composition.delay_input(late, 100);
        let inputs: Vec<Value> = (0..3).map(|i| composition.input(i)).collect();
        let sum = composition.signed_sum(&inputs[..2], &inputs[2..]);
        let tape = composition.finish(&[sum]);
        check_agreement(&tape, &[], &[vec![1e16, 1.0, 1e16]])[0][0]
    };
    assert_eq!((sum(1), sum(2)), (1.0, 0.0));
}

#[test]
fn sums_have_their_signs_whatever_the_number_of_their_terms() {
    for n_plus in 0..4 {
        for n_minus in 0..4 {
            let mut composition = Composition::new(8, 0);
            let inputs: Vec<Value> = (0..8).map(|i| composition.input(i)).collect();
            let zero = composition.constant(0.0);
            let plus = [&inputs[..n_plus], &[zero]].concat();
            let sum = composition.signed_sum(&plus, &inputs[4..4 + n_minus]);
            let tape = composition.finish(&[sum]);
            assert!(tape.operation_count() <= (n_plus + n_minus).max(1) - usize::from(n_plus > 0));
            let point: Vec<f64> = (0..8).map(|i| f64::from(1 << i)).collect();
            let expected = point[..n_plus].iter().sum::<f64>();
            let expected = expected - point[4..4 + n_minus].iter().sum::<f64>();
            let found = check_agreement(&tape, &[], &[point])[0][0];
            assert_eq!(found, expected, "{n_plus} terms less {n_minus}");
        }
    }
}

#[test]
fn products_with_one_and_with_zero_are_no_operations() {
    let mut composition = Composition::new(1, 0);
    let x = composition.input(0);
    let factors = [1.0, -1.0, 0.0].map(|factor| composition.constant(factor));
    let left = factors.map(|factor| composition.multiply(factor, x));
    let right = factors.map(|factor| composition.multiply(x, factor));
    let tape = composition.finish(&[left, right].concat());
    // The sign of −x.
    assert_eq!(tape.operation_count(), 1);
    let values = check_agreement(&tape, &[], &[vec![3.5]]);
    assert_eq!(values, [[3.5, -3.5, 0.0, 3.5, -3.5, 0.0]]);
}
