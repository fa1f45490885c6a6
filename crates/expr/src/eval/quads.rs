//! A tape at four points at once: every instruction once for four of them, in the lanes of one register.
//!
//! ```text
//! interpreter   any machine
//! code          machine code of 256-bit registers, by an assembler of its own: `assembler`, `allocation`
//! ```

#[cfg(all(feature = "jit", target_arch = "x86_64"))]
mod allocation;
#[cfg(all(feature = "jit", target_arch = "x86_64"))]
mod assembler;
#[cfg(all(feature = "jit", target_arch = "x86_64"))]
mod code;
mod interpreter;

use super::runner::Jit;
use crate::tape::Tape;
#[cfg(all(feature = "jit", target_arch = "x86_64"))]
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
#[cfg(all(feature = "jit", target_arch = "x86_64"))]
use std::sync::{Arc, OnceLock};

/// Points of a [`QuadRunner`].
pub(super) const LANES: usize = 4;

/// A number at each of the points.
pub(super) type Lanes = [f64; LANES];

/// Numbers of one register, where no vector straddles two cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Quad(Lanes);

/// The registers of a tape at four points, with its parameters set.
#[derive(Clone, Debug)]
pub struct QuadWorkspace {
    registers: Vec<Quad>,
    /// Registers of the tape; after them come some that code needs.
    n: usize,
}

/// A tape to be evaluated at four points at once, as machine code once that pays.
///
/// Points agree bit for bit with those of the interpreter of one point.
///
/// ```
/// use bksim_expr::{Jit, Pool, QuadRunner, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let e = pool.parse("a*x^2")?;
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let runner = QuadRunner::new(Tape::compile(&pool, &[e], &[id("x")], &[id("a")])?, Jit::On);
/// let mut workspace = runner.workspace(&[2.0]);
/// let mut out = [[0.0; 4]];
/// runner.evaluate(&mut workspace, &[[1.0, 2.0, 3.0, 4.0]], &mut out);
/// assert_eq!(out, [[2.0, 8.0, 18.0, 32.0]]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct QuadRunner {
    tape: Tape,
    #[cfg(all(feature = "jit", target_arch = "x86_64"))]
    jit: Jit,
    #[cfg(all(feature = "jit", target_arch = "x86_64"))]
    code: Arc<Code>,
}

#[cfg(all(feature = "jit", target_arch = "x86_64"))]
#[derive(Debug, Default)]
struct Code {
    n_interpreted: AtomicUsize,
    /// `None` where the tape cannot be compiled.
    compiled: OnceLock<Option<code::QuadCode>>,
}

/// Compiling costs about as much as interpreting the tape so often.
#[cfg(all(feature = "jit", target_arch = "x86_64"))]
const EVALUATIONS_PER_COMPILATION: usize = 50;

impl QuadRunner {
    /// A runner of `tape`.
    pub fn new(tape: Tape, jit: Jit) -> Self {
        #[cfg(not(all(feature = "jit", target_arch = "x86_64")))]
        let _ = jit;
        Self {
            tape,
            #[cfg(all(feature = "jit", target_arch = "x86_64"))]
            jit,
            #[cfg(all(feature = "jit", target_arch = "x86_64"))]
            code: Arc::default(),
        }
    }

    /// The tape.
    pub fn tape(&self) -> &Tape {
        &self.tape
    }

    /// Registers with everything computed that depends on parameters only.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one.
    pub fn workspace(&self, parameters: &[f64]) -> QuadWorkspace {
        let one = self.tape.workspace(parameters).registers;
        let n = one.len();
        let registers = one.into_iter().chain(EXTRA).map(|value| Quad([value; LANES]));
        QuadWorkspace { registers: registers.collect(), n }
    }

    /// Gives a lane of a workspace parameters of its own.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one, `ws` is of another tape, or there is no such lane.
    pub fn set_parameters(&self, ws: &mut QuadWorkspace, lane: usize, parameters: &[f64]) {
        assert_eq!(ws.n, self.tape.n_registers, "a workspace of this tape");
        let one = self.tape.workspace(parameters).registers;
        let known = ws.registers.iter_mut().zip(&one[..self.tape.first_body]);
        known.for_each(|(Quad(all), &one)| all[lane] = one);
    }

    /// Computes all outputs at four points.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut QuadWorkspace, inputs: &[Lanes], out: &mut [Lanes]) {
        assert_eq!(inputs.len(), self.tape.n_inputs, "number of inputs");
        assert_eq!(out.len(), self.tape.outputs.len(), "number of outputs");
        assert_eq!(ws.n, self.tape.n_registers, "a workspace of this tape");
        #[cfg(all(feature = "jit", target_arch = "x86_64"))]
        if let Some(code) = self.code() {
            return code.evaluate(&mut ws.registers, inputs, out);
        }
        interpreter::evaluate(&self.tape, &mut ws.registers, inputs, out);
    }

    /// The machine code if it is there or due now.
    #[cfg(all(feature = "jit", target_arch = "x86_64"))]
    fn code(&self) -> Option<&code::QuadCode> {
        if let Some(compiled) = self.code.compiled.get() {
            return compiled.as_ref();
        }
        let n_paid = match self.jit {
            Jit::Off => return None,
            Jit::On => 0,
            Jit::Auto => EVALUATIONS_PER_COMPILATION,
        };
        // Exactly one evaluation reaches the count: other threads go on interpreting meanwhile.
        if self.code.n_interpreted.fetch_add(1, Relaxed) != n_paid {
            return None;
        }
        self.code.compiled.get_or_init(|| code::QuadCode::of(&self.tape).ok()).as_ref()
    }
}

/// Numbers in the registers after those of a tape.
const EXTRA: [f64; 5] = {
    let mut extra = [0.0; 5];
    extra[Extra::SignMask as usize] = -0.0;
    extra[Extra::AbsMask as usize] = f64::from_bits(!(1 << 63));
    extra[Extra::One as usize] = 1.0;
    extra
};

/// Registers after those of a tape.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(all(feature = "jit", target_arch = "x86_64")), expect(dead_code))]
enum Extra {
    /// A second operand of a call.
    Operand,
    /// The sign bit.
    SignMask,
    /// All bits but it.
    AbsMask,
    One,
    Zero,
}
