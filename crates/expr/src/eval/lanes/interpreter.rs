//! One instruction after the other, each for all lanes.

#![expect(clippy::inline_always, reason = "the caller's instruction set must reach every loop")]

use super::Group;
use crate::op::{Function, power, select};
use crate::sincos::sin_cos_lanes;
use crate::tape::{Action, Tape};
use pulp::{Arch, Simd, WithSimd};

/// Computes all outputs at the points of a group; lengths have been checked.
pub(super) fn evaluate<const N: usize>(
    tape: &Tape,
    registers: &mut [[f64; N]],
    Group { n_points, first }: Group,
    inputs: &[f64],
    out: &mut [f64],
) {
    let arguments = registers[tape.input_registers()].iter_mut();
    for (value, column) in arguments.zip(inputs.chunks_exact(n_points)) {
        value.copy_from_slice(&column[first..][..N]);
    }
    Arch::new().dispatch(Run { tape, registers });
    for (column, &register) in out.chunks_exact_mut(n_points).zip(&tape.outputs) {
        column[first..][..N].copy_from_slice(&registers[register as usize]);
    }
}

struct Run<'a, const N: usize> {
    tape: &'a Tape,
    registers: &'a mut [[f64; N]],
}

impl<const N: usize> WithSimd for Run<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { tape, registers } = self;
        let mut next = tape.first_body;
        for instruction in &tape.body {
            if instruction.action == Action::Turn {
                let angles = tape.angles_of(instruction);
                for (sine, &angle) in (next..).zip(angles) {
                    let (sines, cosines) = sin_cos_lanes(registers[angle as usize]);
                    registers[sine] = sines;
                    registers[sine + angles.len()] = cosines;
                }
            } else {
                let [a, b, c] = [instruction.a, instruction.b, instruction.c]
                    .map(|register| registers[register as usize]);
                registers[next] = value(instruction.action, a, b, c);
            }
            next += instruction.n_results();
        }
    }
}

#[inline(always)]
fn value<const N: usize>(action: Action, a: [f64; N], b: [f64; N], c: [f64; N]) -> [f64; N] {
    match action {
        Action::Add => each(a, b, |a, b| a + b),
        Action::Subtract => each(a, b, |a, b| a - b),
        Action::Multiply => each(a, b, |a, b| a * b),
        Action::Divide => each(a, b, |a, b| a / b),
        Action::Negate => a.map(|a| -a),
        Action::Power => each(a, b, power),
        Action::Call(Function::If) => std::array::from_fn(|lane| select(a[lane], b[lane], c[lane])),
        Action::Call(function) => function.lanes(a, b),
        Action::Turn => unreachable!("turns are executed elsewhere"),
    }
}

#[inline(always)]
fn each<const N: usize>(a: [f64; N], b: [f64; N], operation: impl Fn(f64, f64) -> f64) -> [f64; N] {
    let mut out = [0.0; N];
    for lane in 0..N {
        out[lane] = operation(a[lane], b[lane]);
    }
    out
}
