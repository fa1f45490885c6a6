//! A tape that is interpreted until machine code pays.

#[cfg(feature = "jit")]
use super::due::Due;
use super::due::Jit;
use super::interpreter::Workspace;
#[cfg(feature = "jit")]
use super::jit::MachineCode;
#[cfg(all(feature = "jit", target_arch = "x86_64"))]
use super::lanes::{AnyAngleCode, Group, Layout};
use crate::tape::Tape;
#[cfg(feature = "jit")]
use std::sync::Arc;

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
    code: Arc<Due<PointCode>>,
}

/// Machine code of one point.
#[cfg(feature = "jit")]
#[derive(Debug)]
enum PointCode {
    /// By the assembler of lanes, of which there is one.
    #[cfg(target_arch = "x86_64")]
    Lane(AnyAngleCode<1>),
    /// By cranelift, for other processors.
    Generated(MachineCode),
}

/// Evaluations that cost as much as making machine code, whatever the length of the tape: measured, 700 instructions
/// against 10 for each of its own.
#[cfg(all(feature = "jit", target_arch = "x86_64"))]
const EVALUATIONS_PER_COMPILATION: usize = 100;
/// By cranelift: 3.3 µs against 2.2 ns.
#[cfg(all(feature = "jit", not(target_arch = "x86_64")))]
const EVALUATIONS_PER_COMPILATION: usize = 1500;

#[cfg(feature = "jit")]
impl PointCode {
    /// The code of a tape, where there can be any.
    fn of(tape: &Tape) -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if let Ok(code) = AnyAngleCode::of(tape, Layout::Packed) {
            return Some(Self::Lane(code));
        }
        tape.machine_code().ok().map(Self::Generated)
    }

    /// Computes all outputs; false where they are not those of the tape.
    fn evaluate(&self, tape: &Tape, ws: &mut Workspace, inputs: &[f64], out: &mut [f64]) -> bool {
        tape.check(ws, inputs, out);
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Lane(code) => {
                let one = Group { n_points: 1, first: 0 };
                code.evaluate(tape, &mut ws.memory, one, inputs, out)
            }
            Self::Generated(code) => {
                code.evaluate(ws, inputs, out);
                true
            }
        }
    }
}

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
        return self.code.is_compiled();
        #[cfg(not(feature = "jit"))]
        false
    }

    /// Computes all outputs.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut Workspace, inputs: &[f64], out: &mut [f64]) {
        #[cfg(feature = "jit")]
        if let Some(code) = self.code()
            && code.evaluate(&self.tape, ws, inputs, out)
        {
            return;
        }
        self.tape.evaluate(ws, inputs, out);
    }

    /// The machine code if it is there or due now.
    #[cfg(feature = "jit")]
    fn code(&self) -> Option<&PointCode> {
        self.code.code(self.jit, EVALUATIONS_PER_COMPILATION, || PointCode::of(&self.tape))
    }
}
