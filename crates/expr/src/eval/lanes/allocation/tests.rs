use super::*;
use crate::tape::Composition;

/// Twenty values are alive all the time, more than there are registers, and four thousand are made of them.
#[test]
fn places_are_given_again_once_their_values_are_no_longer_read() {
    const N: usize = 20;
    let mut composition = Composition::new(N, 0);
    let mut values: Vec<_> = (0..N).map(|i| composition.input(i)).collect();
    for _ in 0..200 {
        let shifted = values[1..].iter().chain(&values[..1]).copied().collect::<Vec<_>>();
        for (value, other) in values.iter_mut().zip(shifted) {
            *value = composition.add(*value, other);
        }
    }
    let tape = composition.finish(&values);
    let callees = Callees { turn: 0, elementary: 0, power: 0 };
    let body = assemble(&tape, (Width::One, Layout::Packed), Turns::Written, callees);
    assert!(tape.n_registers > 200 * N);
    let beyond = body.n_registers - EXTRA.len() - tape.first_body;
    assert!(beyond < 3 * N, "{beyond} places for {N} values");
}
