//! A tape that is interpreted until machine code pays.

use super::due::{Due, Jit};
use super::interpreter::Workspace;
use super::lanes::{AnyAngleCode, Group, Layout};
use crate::tape::Tape;
use std::sync::Arc;

/// A tape with the choice of its evaluator: clones share the machine code.
///
/// Machine code is made for x86-64 processors with AVX2; on others all tapes are interpreted, with the same results, and
/// so are tapes that are too long.
///
/// ```
/// use bksim_expr::{Jit, Pool, Runner, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let e = pool.parse("x^2")?;
/// let x = pool.find_symbol("x").ok_or("was parsed")?;
/// let runner = Runner::new(Tape::compile(&pool, &[e], &[x], &[])?, Jit::Auto);
/// let mut workspace = runner.tape().workspace(&[]);
/// let mut out = [0.0];
/// for _ in 0..10_000 {
///     runner.evaluate(&mut workspace, &[3.0], &mut out);
/// }
/// assert_eq!(out, [9.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Runner {
    tape: Tape,
    jit: Jit,
    /// One lane.
    code: Arc<Due<AnyAngleCode<1>>>,
}

/// Evaluations that cost as much as making machine code, whatever the length of the tape: measured, 700 instructions
/// against 10 for each of its own.
const EVALUATIONS_PER_COMPILATION: usize = 100;

impl Runner {
    /// A runner of `tape`.
    pub fn new(tape: Tape, jit: Jit) -> Self {
        Self { tape, jit, code: Arc::default() }
    }

    /// The tape.
    pub fn tape(&self) -> &Tape {
        &self.tape
    }

    /// True if evaluations run machine code from now on.
    pub fn is_compiled(&self) -> bool {
        self.code.is_compiled()
    }

    /// Computes all outputs.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut Workspace, inputs: &[f64], out: &mut [f64]) {
        if let Some(code) = self.code() {
            self.tape.check(ws, inputs, out);
            let one = Group { n_points: 1, first: 0 };
            if code.evaluate(&self.tape, &mut ws.memory, one, inputs, out) {
                return;
            }
        }
        self.tape.evaluate(ws, inputs, out);
    }

    /// The machine code if it is there or due now.
    fn code(&self) -> Option<&AnyAngleCode<1>> {
        let make = || AnyAngleCode::of(&self.tape, Layout::Packed);
        self.code.code(self.jit, EVALUATIONS_PER_COMPILATION, make)
    }
}
