//! A tape that is interpreted until machine code pays.

use super::interpreter::Workspace;
#[cfg(feature = "jit")]
use super::jit::MachineCode;
use crate::tape::Tape;
#[cfg(feature = "jit")]
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
#[cfg(feature = "jit")]
use std::sync::{Arc, OnceLock};

/// The time at which a tape is compiled to machine code.
///
/// Results do not depend on it: interpreter and machine code agree bit for bit.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Jit {
    /// Once interpreting has cost about what compiling costs, so that the two together never take
    /// twice as long as the better of them would have.
    #[default]
    Auto,
    /// At the first evaluation.
    On,
    /// Never.
    Off,
}

/// A tape with the choice of its evaluator: clones share the machine code.
///
/// Tapes that cannot be compiled, and all tapes where the crate is built without the feature `jit`,
/// are interpreted.
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
    #[cfg(feature = "jit")]
    jit: Jit,
    #[cfg(feature = "jit")]
    code: Arc<Code>,
}

/// The machine code shared by the clones of a runner.
#[cfg(feature = "jit")]
#[derive(Debug, Default)]
struct Code {
    n_interpreted: AtomicUsize,
    /// `None` where the tape cannot be compiled.
    compiled: OnceLock<Option<MachineCode>>,
}

/// Compiling costs as much as interpreting the tape so often, whatever its length: measured,
/// 3.3 µs against 2.2 ns per instruction, with little that does not grow with the tape.
#[cfg(feature = "jit")]
const EVALUATIONS_PER_COMPILATION: usize = 1500;

impl Runner {
    /// A runner of `tape`.
    pub fn new(tape: Tape, jit: Jit) -> Self {
        #[cfg(not(feature = "jit"))]
        let _ = jit;
        Self {
            tape,
            #[cfg(feature = "jit")]
            jit,
            #[cfg(feature = "jit")]
            code: Arc::default(),
        }
    }

    /// The tape.
    pub fn tape(&self) -> &Tape {
        &self.tape
    }

    /// Whether evaluations run machine code from now on.
    pub fn is_compiled(&self) -> bool {
        #[cfg(feature = "jit")]
        return matches!(self.code.compiled.get(), Some(Some(_)));
        #[cfg(not(feature = "jit"))]
        false
    }

    /// Computes all outputs.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut Workspace, inputs: &[f64], out: &mut [f64]) {
        #[cfg(feature = "jit")]
        if let Some(code) = self.code() {
            return code.evaluate(ws, inputs, out);
        }
        self.tape.evaluate(ws, inputs, out);
    }

    /// The machine code if it is there or due now.
    #[cfg(feature = "jit")]
    fn code(&self) -> Option<&MachineCode> {
        if let Some(compiled) = self.code.compiled.get() {
            return compiled.as_ref();
        }
        let n_paid = match self.jit {
            Jit::Off => return None,
            Jit::On => 0,
            // Evaluations are counted, not time: runs can be repeated exactly.
            Jit::Auto => EVALUATIONS_PER_COMPILATION,
        };
        // Exactly one evaluation reaches the count: other threads go on interpreting meanwhile.
        if self.code.n_interpreted.fetch_add(1, Relaxed) != n_paid {
            return None;
        }
        self.code.compiled.get_or_init(|| self.tape.machine_code().ok()).as_ref()
    }
}
