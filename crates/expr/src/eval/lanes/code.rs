//! Machine code of a tape in lanes, in memory that can be executed: [`LaneCode`] of one kind, [`AnyAngleCode`] for all angles.

#![expect(unsafe_code, reason = "machine code is called through raw pointers")]

use super::allocation::{Body, Callees, assemble};
use super::assembler::Width;
use super::program::Turns;
use super::{Extra, Group, LaneValues, Layout};
use crate::eval::memory::Memory;
use crate::op::{Function, power};
use crate::sincos::{LARGEST, sin_cos, sin_cos_lanes};
use crate::tape::Tape;
use std::sync::OnceLock;

/// Longest body that is compiled: beyond, code is longer than any cache, and interpreting costs no more.
const MOST_INSTRUCTIONS: usize = 500_000;

/// True where the processor has registers of eight lanes.
pub(super) fn has_eight_lanes() -> bool {
    Width::of(8).is_some()
}

/// Machine code of one tape at `N` points, for angles of any size.
#[derive(Debug)]
pub(in crate::eval) struct AnyAngleCode<const N: usize> {
    layout: Layout,
    code: LaneCode<N>,
    /// Code for angles that the lanes do not turn by themselves, made when there is one; `None` where that cannot be.
    for_large_angles: OnceLock<Option<Box<LaneCode<N>>>>,
}

impl<const N: usize> AnyAngleCode<N> {
    /// Compiles the body; `None` for tapes that are too long, and processors without registers of this width.
    pub(in crate::eval) fn of(tape: &Tape, layout: Layout) -> Option<Self> {
        let code = LaneCode::of(tape, layout, Turns::Written)?;
        Some(Self { layout, code, for_large_angles: OnceLock::new() })
    }

    /// Computes all outputs of its tape at the points of a group; lengths have been checked, and that a packed group is
    /// whole. False where outputs are not those of the tape.
    pub(in crate::eval) fn evaluate(
        &self,
        tape: &Tape,
        registers: &mut LaneValues<N>,
        group: Group,
        inputs: &[f64],
        out: &mut [f64],
    ) -> bool {
        let mut run = |code: &LaneCode<N>| {
            registers.hold(code.n_registers);
            code.evaluate(registers, group, inputs, out)
        };
        let make = || LaneCode::of(tape, self.layout, Turns::Called).map(Box::new);
        run(&self.code) || self.for_large_angles.get_or_init(make).as_deref().is_some_and(run)
    }
}

/// Machine code of one tape at `N` points.
struct LaneCode<const N: usize> {
    function: Compiled<N>,
    n_registers: usize,
    has_angles: bool,
    /// Owns the memory of `function`.
    _memory: Memory,
}

/// A function of registers, inputs, outputs and the bytes from each column of the latter two to the next.
type Compiled<const N: usize> =
    unsafe extern "sysv64" fn(*mut [f64; N], *const f64, *mut f64, usize);
/// A function of angles and their number.
type Turn = unsafe extern "sysv64" fn(*mut f64, usize);
/// A function of two operands and the index of a [`Function`].
type Elementary = unsafe extern "sysv64" fn(*mut f64, *const f64, usize);

impl<const N: usize> std::fmt::Debug for LaneCode<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LaneCode").finish_non_exhaustive()
    }
}

impl<const N: usize> LaneCode<N> {
    /// Compiles the body, see [`AnyAngleCode::of`].
    fn of(tape: &Tape, layout: Layout, turns: Turns) -> Option<Self> {
        let width = Width::of(N)?;
        if tape.body.len() > MOST_INSTRUCTIONS {
            return None;
        }
        let (turn, elementary): (Turn, Elementary) = match width {
            Width::One => (turn_one, elementary_one),
            Width::Four => (turn_four, elementary_four),
            Width::Eight => (turn_eight, elementary_eight),
        };
        let callees = Callees {
            turn: turn as usize as u64,
            elementary: elementary as usize as u64,
            power: general_power::<N> as unsafe extern "sysv64" fn(_, _, _) as usize as u64,
        };
        let Body { bytes, n_registers, has_angles } =
            assemble(tape, (width, layout), turns, callees);
        let memory = Memory::of(&bytes)?;
        // SAFETY: the bytes are a function of these arguments in this convention, and their memory lives as
        // long as `memory`.
        let function = unsafe { std::mem::transmute::<*const u8, Compiled<N>>(memory.address()) };
        Some(Self { function, n_registers, has_angles, _memory: memory })
    }

    /// Computes all outputs at the points of a group; lengths have been checked, and that a packed group is whole. False
    /// where outputs are not those of the tape: angles are too large for the operations of the code.
    fn evaluate(
        &self,
        registers: &mut [[f64; N]],
        Group { n_points, first }: Group,
        inputs: &[f64],
        out: &mut [f64],
    ) -> bool {
        // Wrapping: where there are no columns, there may be any number of points.
        let inputs = inputs.as_ptr().wrapping_add(first);
        let out = out.as_mut_ptr().wrapping_add(first);
        let stride = n_points.wrapping_mul(size_of::<f64>());
        assert!(registers.len() >= self.n_registers, "registers for all values");
        // SAFETY: the code stays within the registers, whose number was just checked, and within `N` numbers of
        // each column from `first` on: the columns hold `first + N` numbers or more, and there is one for each of its inputs
        // and outputs. The processor has been found to have its instructions.
        unsafe { (self.function)(registers.as_mut_ptr(), inputs, out, stride) }
        // NaN fails the comparison.
        let is_small = |angle: &f64| *angle <= LARGEST;
        !self.has_angles || registers[Extra::TotalAngle as usize].iter().all(is_small)
    }
}

/// Turns `n` angles into their sines, and writes their cosines after them.
///
/// # Safety
/// `angles` leads to `2 n` numbers, and the processor has AVX2.
#[target_feature(enable = "avx2")]
unsafe extern "sysv64" fn turn_one(angles: *mut f64, n: usize) {
    // SAFETY: as stated.
    let numbers = unsafe { std::slice::from_raw_parts_mut(angles, 2 * n) };
    let (sines, cosines) = numbers.split_at_mut(n);
    let (sines, last_sines) = sines.as_chunks_mut::<4>();
    let (cosines, last_cosines) = cosines.split_at_mut(4 * sines.len());
    for (sines, cosines) in sines.iter_mut().zip(cosines.as_chunks_mut::<4>().0) {
        (*sines, *cosines) = sin_cos_lanes(*sines);
    }
    match (last_sines, last_cosines) {
        ([], _) => (),
        ([sine], [cosine]) => (*sine, *cosine) = sin_cos(*sine),
        (sines, cosines) => {
            let angle = |lane: usize| *sines.get(lane).unwrap_or(&sines[0]);
            let (s, c) = sin_cos_lanes([angle(0), angle(1), angle(2), angle(3)]);
            sines.iter_mut().zip(s).for_each(|(to, sine)| *to = sine);
            cosines.iter_mut().zip(c).for_each(|(to, cosine)| *to = cosine);
        }
    }
}

/// Sines and cosines at four points.
///
/// # Safety
/// `angles` leads to `2 n` times four numbers, and the processor has AVX2.
#[target_feature(enable = "avx2")]
unsafe extern "sysv64" fn turn_four(angles: *mut f64, n: usize) {
    // SAFETY: as stated.
    let numbers = unsafe { std::slice::from_raw_parts_mut(angles.cast::<[f64; 4]>(), 2 * n) };
    turn_lanes(numbers);
}

/// Sines and cosines at eight points.
///
/// # Safety
/// `angles` leads to `2 n` times eight numbers, and the processor has the F and DQ instructions of AVX-512.
#[target_feature(enable = "avx512f,avx512dq")]
unsafe extern "sysv64" fn turn_eight(angles: *mut f64, n: usize) {
    // SAFETY: as stated.
    let numbers = unsafe { std::slice::from_raw_parts_mut(angles.cast::<[f64; 8]>(), 2 * n) };
    turn_lanes(numbers);
}

/// Turns the first half into sines, and writes cosines into the second.
#[expect(clippy::inline_always, reason = "the caller's instruction set must reach the lanes")]
#[inline(always)]
fn turn_lanes<const N: usize>(numbers: &mut [[f64; N]]) {
    let (sines, cosines) = numbers.split_at_mut(numbers.len() / 2);
    for (sine, cosine) in sines.iter_mut().zip(cosines) {
        (*sine, *cosine) = sin_cos_lanes(*sine);
    }
}

/// Replaces a number by a function of it and another.
///
/// # Safety
/// Both pointers lead to a number.
unsafe extern "sysv64" fn elementary_one(a: *mut f64, b: *const f64, function: usize) {
    // SAFETY: as stated.
    let (a, b) = unsafe { (&mut *a, *b) };
    *a = function_at(function).value(*a, b);
}

/// Elementary functions at four points.
///
/// # Safety
/// Both pointers lead to four numbers, and the processor has AVX2.
#[target_feature(enable = "avx2")]
unsafe extern "sysv64" fn elementary_four(a: *mut f64, b: *const f64, function: usize) {
    // SAFETY: as stated.
    let (a, b) = unsafe { (&mut *a.cast::<[f64; 4]>(), *b.cast()) };
    *a = function_at(function).lanes(*a, b);
}

/// Elementary functions at eight points.
///
/// # Safety
/// Both pointers lead to eight numbers, and the processor has the F and DQ instructions of AVX-512.
#[target_feature(enable = "avx512f,avx512dq")]
unsafe extern "sysv64" fn elementary_eight(a: *mut f64, b: *const f64, function: usize) {
    // SAFETY: as stated.
    let (a, b) = unsafe { (&mut *a.cast::<[f64; 8]>(), *b.cast()) };
    *a = function_at(function).lanes(*a, b);
}

fn function_at(index: usize) -> Function {
    Function::from_index(index).expect("code passes the index of a function")
}

/// Replaces numbers by their powers.
///
/// # Safety
/// Both pointers lead to numbers in all lanes.
unsafe extern "sysv64" fn general_power<const N: usize>(
    a: *mut [f64; N],
    b: *const [f64; N],
    _: usize,
) {
    // SAFETY: as stated.
    let (a, b) = unsafe { (&mut *a, &*b) };
    for lane in 0..N {
        a[lane] = power(a[lane], b[lane]);
    }
}
