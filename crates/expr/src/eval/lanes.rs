//! A tape at several points at once: every instruction once for all of them, in the lanes of registers.
//!
//! ```text
//! interpreter   any machine
//! code          machine code of AVX and AVX-512, by an assembler of its own: `assembler`, `allocation`
//! no_code       in its place on other processors, where all tapes are interpreted
//! ```

#[cfg(target_arch = "x86_64")]
mod allocation;
#[cfg(target_arch = "x86_64")]
mod assembler;
#[cfg(target_arch = "x86_64")]
mod code;
#[cfg(not(target_arch = "x86_64"))]
#[path = "lanes/no_code.rs"]
mod code;
mod interpreter;
#[cfg(target_arch = "x86_64")]
mod program;
#[cfg(target_arch = "x86_64")]
mod turn;

pub(super) use self::code::AnyAngleCode;
use super::due::{Due, Jit};
use crate::tape::Tape;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// Lanes that this machine has machine code for: eight with AVX-512, else four.
pub fn widest_lanes() -> usize {
    if code::has_eight_lanes() { 8 } else { 4 }
}

/// Eight numbers, where no vector straddles two cache lines.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Block([f64; 8]);

/// Numbers at `N` points, so in memory that registers of `N` lanes are loaded from them at once.
#[derive(Clone, Debug)]
pub struct LaneValues<const N: usize> {
    blocks: Vec<Block>,
    n: usize,
}

impl<const N: usize> LaneValues<N> {
    /// `n` zeros at all points.
    pub fn zeros(n: usize) -> Self {
        Self { blocks: vec![Block([0.0; 8]); (N * n).div_ceil(8)], n }
    }

    /// Adds zeros where there are fewer than `n`.
    fn hold(&mut self, n: usize) {
        if self.n < n {
            self.blocks.resize((N * n).div_ceil(8), Block([0.0; 8]));
            self.n = n;
        }
    }
}

impl<const N: usize> Deref for LaneValues<N> {
    type Target = [[f64; N]];

    fn deref(&self) -> &[[f64; N]] {
        &bytemuck::cast_slice::<Block, f64>(&self.blocks).as_chunks().0[..self.n]
    }
}

impl<const N: usize> DerefMut for LaneValues<N> {
    fn deref_mut(&mut self) -> &mut [[f64; N]] {
        &mut bytemuck::cast_slice_mut::<Block, f64>(&mut self.blocks).as_chunks_mut().0[..self.n]
    }
}

/// The registers of a tape at `N` points, one, four or eight, with its parameters set.
#[derive(Clone, Debug)]
pub struct LaneWorkspace<const N: usize> {
    /// Some that code needs, those of the tape before its body, then as many as the interpreter or code has asked for.
    registers: LaneValues<N>,
    /// Number of values before the body.
    n_known: usize,
}

/// Places of inputs and outputs: numbers of the first quantity at all points, then of the second and so on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Layout {
    /// There are as many points as lanes; code knows the place of every number.
    Packed,
    /// There may be more; code is told how many.
    Columns,
}

/// Neighbouring points, one in each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// Points that there are numbers of.
    pub(super) n_points: usize,
    /// The point in the first lane.
    pub(super) first: usize,
}

/// A tape to be evaluated at `N` points at once, one, four or eight, as machine code once that pays.
///
/// Points agree bit for bit with those of the interpreter of one point. Each may have parameters of its own.
///
/// ```
/// use bksim_expr::{Jit, LaneRunner, Pool, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let e = pool.parse("a*x^2")?;
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let tape = Tape::compile(&pool, &[e], &[id("x")], &[id("a")])?;
/// let runner = LaneRunner::<4>::new(tape, Jit::On);
/// let mut workspace = runner.workspace(&[2.0]);
/// runner.set_parameters(&mut workspace, 3, &[5.0]);
/// let mut out = [[0.0; 4]];
/// runner.evaluate(&mut workspace, &[[1.0, 2.0, 3.0, 4.0]], &mut out);
/// assert_eq!(out, [[2.0, 8.0, 18.0, 80.0]]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct LaneRunner<const N: usize> {
    tape: Tape,
    layout: Layout,
    jit: Jit,
    code: Arc<Due<AnyAngleCode<N>>>,
}

/// Compiling costs about as much as interpreting the tape so often.
const EVALUATIONS_PER_COMPILATION: usize = 50;

impl<const N: usize> LaneRunner<N> {
    /// A runner of `tape`.
    pub fn new(tape: Tape, jit: Jit) -> Self {
        Self::with_layout(tape, jit, Layout::Packed)
    }

    pub(super) fn with_layout(tape: Tape, jit: Jit, layout: Layout) -> Self {
        Self { tape, layout, jit, code: Arc::default() }
    }

    /// The tape.
    pub fn tape(&self) -> &Tape {
        &self.tape
    }

    /// True where there is machine code, which is made now.
    pub fn has_code(&self) -> bool {
        self.jit != Jit::Off && self.code.made(|| self.make()).is_some()
    }

    /// True once evaluations run machine code.
    pub fn is_compiled(&self) -> bool {
        self.code.is_compiled()
    }

    /// Registers with everything computed that depends on parameters only, which are the same at all points so far.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one.
    pub fn workspace(&self, parameters: &[f64]) -> LaneWorkspace<N> {
        let n_known = self.tape.first_body;
        let known = self.tape.known(parameters, n_known);
        let mut registers = LaneValues::zeros(EXTRA.len() + n_known);
        let (extra, rest) = registers.split_at_mut(EXTRA.len());
        extra.iter_mut().zip(EXTRA).for_each(|(all, value)| *all = [value; N]);
        rest.iter_mut().zip(known).for_each(|(all, value)| *all = [value; N]);
        LaneWorkspace { registers, n_known }
    }

    /// Gives a lane of a workspace parameters of its own.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one, `ws` is of another tape, or there is no such lane.
    pub fn set_parameters(&self, ws: &mut LaneWorkspace<N>, lane: usize, parameters: &[f64]) {
        self.check(ws);
        let known = self.tape.known(parameters, ws.n_known);
        let registers = ws.registers[EXTRA.len()..].iter_mut();
        registers.zip(known).for_each(|(all, value)| all[lane] = value);
    }

    /// Computes all outputs at all points.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut LaneWorkspace<N>, inputs: &[[f64; N]], out: &mut [[f64; N]]) {
        let group = Group { n_points: N, first: 0 };
        self.evaluate_group(ws, group, inputs.as_flattened(), out.as_flattened_mut());
    }

    /// Computes all outputs at the points of a group from where inputs stand to where outputs shall stand.
    ///
    /// # Panics
    /// When `inputs` or `out` do not hold the numbers of all points, these end before the last lane, they are not as many as
    /// lanes where they are packed, or `ws` is of another tape.
    pub(super) fn evaluate_group(
        &self,
        ws: &mut LaneWorkspace<N>,
        group: Group,
        inputs: &[f64],
        out: &mut [f64],
    ) {
        let Group { n_points, first } = group;
        // Checked products: code relies on these lengths, and adds up places without looking at them again.
        let length = |n_columns: usize| n_points.checked_mul(n_columns);
        assert_eq!(Some(inputs.len()), length(self.tape.n_inputs), "values of all inputs");
        assert_eq!(Some(out.len()), length(self.tape.outputs.len()), "values of all outputs");
        assert!(first < n_points && N <= n_points - first, "a point in each lane");
        assert!(
            n_points == N || self.layout == Layout::Columns,
            "as many points as there are lanes"
        );
        self.check(ws);
        let registers = &mut ws.registers;
        if let Some(code) = self.code()
            && code.evaluate(&self.tape, registers, group, inputs, out)
        {
            return;
        }
        registers.hold(EXTRA.len() + self.tape.n_registers);
        interpreter::evaluate(&self.tape, &mut registers[EXTRA.len()..], group, inputs, out);
    }

    fn check(&self, ws: &LaneWorkspace<N>) {
        assert_eq!(ws.n_known, self.tape.first_body, "a workspace of this tape");
    }

    /// The machine code if it is there or due now.
    fn code(&self) -> Option<&AnyAngleCode<N>> {
        self.code.code(self.jit, EVALUATIONS_PER_COMPILATION, || self.make())
    }

    /// New machine code, where the tape can be compiled.
    fn make(&self) -> Option<AnyAngleCode<N>> {
        AnyAngleCode::of(&self.tape, self.layout)
    }
}

/// Numbers in memory before the registers of a tape. Bits of the first ones are read with those behind them.
pub(super) const EXTRA: [f64; Extra::N] = {
    use crate::sincos::{C, HALF_PI, REST_OF_HALF_PI, ROUND, S};
    let mut extra = [0.0; Extra::N];
    extra[Extra::SignMask as usize] = -0.0;
    extra[Extra::AbsMask as usize] = f64::from_bits(!(1 << 63));
    extra[Extra::One as usize] = 1.0;
    extra[Extra::Half as usize] = 0.5;
    extra[Extra::TwoOverPi as usize] = std::f64::consts::FRAC_2_PI;
    extra[Extra::Round as usize] = ROUND;
    extra[Extra::HalfPi0 as usize] = HALF_PI[0];
    extra[Extra::HalfPi1 as usize] = HALF_PI[1];
    extra[Extra::HalfPi2 as usize] = HALF_PI[2];
    extra[Extra::RestOfHalfPi as usize] = REST_OF_HALF_PI;
    let mut i = 0;
    while i < S.len() {
        extra[Extra::SINE[i] as usize] = S[i];
        extra[Extra::COSINE[i] as usize] = C[i];
        i += 1;
    }
    extra
};

/// Registers before those of a tape.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(target_arch = "x86_64"), expect(dead_code))]
enum Extra {
    /// A second operand of a call.
    Operand,
    /// The sum of the magnitudes of angles, after the code has run.
    TotalAngle,
    /// The sign bit.
    SignMask,
    /// All bits but it.
    AbsMask,
    One,
    Zero,
    Half,
    TwoOverPi,
    Round,
    HalfPi0,
    HalfPi1,
    HalfPi2,
    RestOfHalfPi,
    S0,
    S1,
    S2,
    S3,
    S4,
    S5,
    C0,
    C1,
    C2,
    C3,
    C4,
    C5,
    /// Read together with the one before.
    Unused,
}

impl Extra {
    /// How many there are.
    const N: usize = Self::Unused as usize + 1;

    /// The coefficients of the polynomials of sine and cosine, see [`crate::sincos`].
    const SINE: [Self; 6] = [Self::S0, Self::S1, Self::S2, Self::S3, Self::S4, Self::S5];
    const COSINE: [Self; 6] = [Self::C0, Self::C1, Self::C2, Self::C3, Self::C4, Self::C5];
}
