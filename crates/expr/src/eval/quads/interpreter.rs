//! One instruction after the other, each for all lanes.

#![expect(clippy::inline_always, reason = "the caller's instruction set must reach every loop")]

use super::{LANES, Lanes, Quad};
use crate::op::{Function, power, select};
use crate::sincos::sin_cos_lanes;
use crate::tape::{Action, Tape};
use pulp::{Arch, Simd, WithSimd};

/// Computes all outputs; lengths have been checked.
pub(super) fn evaluate(tape: &Tape, registers: &mut [Quad], inputs: &[Lanes], out: &mut [Lanes]) {
    let places = &mut registers[tape.input_registers()];
    places.iter_mut().zip(inputs).for_each(|(place, input)| place.0 = *input);
    Arch::new().dispatch(Run { tape, registers });
    for (value, &register) in out.iter_mut().zip(&tape.outputs) {
        *value = registers[register as usize].0;
    }
}

struct Run<'a> {
    tape: &'a Tape,
    registers: &'a mut [Quad],
}

impl WithSimd for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { tape, registers } = self;
        let mut next = tape.first_body;
        for instruction in &tape.body {
            if instruction.action == Action::Turn {
                let angles = tape.angles_of(instruction);
                for (sine, &angle) in (next..).zip(angles) {
                    let (sines, cosines) = sin_cos_lanes(registers[angle as usize].0);
                    registers[sine].0 = sines;
                    registers[sine + angles.len()].0 = cosines;
                }
            } else {
                let [a, b, c] = [instruction.a, instruction.b, instruction.c]
                    .map(|register| registers[register as usize].0);
                registers[next].0 = value(instruction.action, a, b, c);
            }
            next += instruction.n_results();
        }
    }
}

#[inline(always)]
fn value(action: Action, a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    match action {
        Action::Add => each(a, b, |a, b| a + b),
        Action::Subtract => each(a, b, |a, b| a - b),
        Action::Multiply => each(a, b, |a, b| a * b),
        Action::Divide => each(a, b, |a, b| a / b),
        Action::Negate => a.map(|a| -a),
        Action::Power => each(a, b, power),
        Action::Call(Function::If) => std::array::from_fn(|lane| select(a[lane], b[lane], c[lane])),
        Action::Call(function) => each(a, b, |a, b| function.value(a, b)),
        Action::Turn => unreachable!("turns are executed elsewhere"),
    }
}

#[inline(always)]
fn each(a: Lanes, b: Lanes, operation: impl Fn(f64, f64) -> f64) -> Lanes {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        out[lane] = operation(a[lane], b[lane]);
    }
    out
}
