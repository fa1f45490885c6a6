//! Machine code of a tape in lanes, in memory that can be executed.

#![expect(unsafe_code, reason = "machine code is called through raw pointers")]

use super::allocation::{Callees, assemble};
use super::{LANES, Lanes, Quad};
use crate::eval::jit::{JitError, MOST_INSTRUCTIONS, Memory};
use crate::op::{Function, power};
use crate::sincos::sin_cos_lanes;
use crate::tape::Tape;

/// Machine code of one tape at four points.
pub(super) struct QuadCode {
    function: Compiled,
    /// Owns the memory of `function`.
    _memory: Memory,
}

type Compiled = unsafe extern "sysv64" fn(*mut Quad, *const Lanes, *mut Lanes);

impl std::fmt::Debug for QuadCode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("QuadCode").finish_non_exhaustive()
    }
}

impl QuadCode {
    /// Compiles the body.
    ///
    /// # Errors
    /// [`JitError`] for tapes that are too long, and processors without 256-bit registers.
    pub(super) fn of(tape: &Tape) -> Result<Self, JitError> {
        if !std::arch::is_x86_feature_detected!("avx2") {
            return Err(JitError::Host { reason: "no AVX2" });
        }
        if tape.body.len() > MOST_INSTRUCTIONS {
            let (found, limit) = (tape.body.len(), MOST_INSTRUCTIONS);
            return Err(JitError::TooLong { found, limit });
        }
        let callees = Callees {
            turn: turn as unsafe extern "sysv64" fn(_, _) as usize as u64,
            elementary: elementary as unsafe extern "sysv64" fn(_, _, _) as usize as u64,
            power: general_power as unsafe extern "sysv64" fn(_, _, _) as usize as u64,
        };
        let (memory, address) = Memory::of(&assemble(tape, callees))?;
        // SAFETY: the bytes are a function of three pointers in this convention, and their memory lives as
        // long as `memory`.
        let function = unsafe { std::mem::transmute::<*const u8, Compiled>(address) };
        Ok(Self { function, _memory: memory })
    }

    /// Computes all outputs; lengths have been checked.
    pub(super) fn evaluate(&self, registers: &mut [Quad], inputs: &[Lanes], out: &mut [Lanes]) {
        // SAFETY: the code stays within the three arrays, whose lengths were checked against its tape, and
        // the processor has been found to have its instructions.
        unsafe { (self.function)(registers.as_mut_ptr(), inputs.as_ptr(), out.as_mut_ptr()) }
    }
}

/// Turns `n` quads of angles into their sines, and writes their cosines after them.
///
/// # Safety
/// `angles` leads to `2 n` quads, and the processor has AVX2.
#[target_feature(enable = "avx2")]
unsafe extern "sysv64" fn turn(angles: *mut Quad, n: usize) {
    // SAFETY: as stated.
    let quads = unsafe { std::slice::from_raw_parts_mut(angles, 2 * n) };
    let (sines, cosines) = quads.split_at_mut(n);
    for (sine, cosine) in sines.iter_mut().zip(cosines) {
        (sine.0, cosine.0) = sin_cos_lanes(sine.0);
    }
}

/// Replaces a quad by a function of it and another.
///
/// # Safety
/// Both pointers lead to quads.
unsafe extern "sysv64" fn elementary(a: *mut Quad, b: *const Quad, function: usize) {
    let function = Function::from_index(function).expect("code passes the index of a function");
    // SAFETY: as stated.
    let (a, b) = unsafe { (&mut (*a).0, &(*b).0) };
    for lane in 0..LANES {
        a[lane] = function.value(a[lane], b[lane]);
    }
}

/// Replaces a quad by its power.
///
/// # Safety
/// Both pointers lead to quads.
unsafe extern "sysv64" fn general_power(a: *mut Quad, b: *const Quad, _: usize) {
    // SAFETY: as stated.
    let (a, b) = unsafe { (&mut (*a).0, &(*b).0) };
    for lane in 0..LANES {
        a[lane] = power(a[lane], b[lane]);
    }
}
