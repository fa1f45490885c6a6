//! A tape over many points: interpreted, each instruction for [`WIDTH`] of them, until [machine code](super::lanes) pays.
//!
//! Reading an instruction costs more than executing it, so it is read once for many points; the
//! arithmetic between is plain loops that compile to the widest vectors the machine has.
//! Registers are used again once nothing reads them any more: all of them together stay in the
//! fastest cache.

#![expect(clippy::inline_always, reason = "the caller's instruction set must reach every loop")]

use super::due::Jit;
use super::lanes::{Group, LaneRunner, LaneValues, LaneWorkspace, Layout, widest_lanes};
use crate::op::{Function, power, select};
use crate::sincos::sin_cos_lanes;
use crate::tape::{Action, Instruction, Tape};
use pulp::{Arch, Simd, WithSimd};

/// Points per vector operation: as many as the widest registers take.
const LANES: usize = 8;
/// Vector operations per instruction: enough to hide the cost of reading it.
const BLOCKS: usize = 8;
/// Points per instruction.
const WIDTH: usize = LANES * BLOCKS;

/// One register at all points, aligned so that no vector straddles two cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Wide([[f64; LANES]; BLOCKS]);

impl Wide {
    fn splat(value: f64) -> Self {
        Self([[value; LANES]; BLOCKS])
    }
}

/// A [`Tape`] with its parameters set, to be evaluated at many points at once.
///
/// ```
/// use bksim_expr::{Pool, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let outputs = [pool.parse("k*x + y")?, pool.parse("x*y")?];
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let tape = Tape::compile(&pool, &outputs, &[id("x"), id("y")], &[id("k")])?;
/// let mut batch = tape.batch(&[10.0]);
/// let mut out = [0.0; 6];
/// // Three points: all x, then all y; out come all values of the first output, then the second's.
/// batch.evaluate(3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut out);
/// assert_eq!(out, [14.0, 25.0, 36.0, 4.0, 10.0, 18.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Batch {
    steps: Vec<SlotInstruction>,
    /// Registers of the inputs.
    inputs: Vec<u32>,
    outputs: Vec<Output>,
    registers: Vec<Wide>,
    code: BatchCode,
    /// Points of all calls so far.
    n_points: usize,
}

/// Machine code for the lanes that this machine has; clones of a batch share it.
#[derive(Clone, Debug)]
enum BatchCode {
    Four(Groups<4>),
    Eight(Groups<8>),
}

/// A tape at `N` points at once, group by group, where they stand in their columns.
#[derive(Clone, Debug)]
struct Groups<const N: usize> {
    runner: LaneRunner<N>,
    parameters: Vec<f64>,
    /// Once they are needed.
    buffers: Option<GroupBuffers<N>>,
}

#[derive(Clone, Debug)]
struct GroupBuffers<const N: usize> {
    workspace: LaneWorkspace<N>,
    /// Of a last group of fewer points.
    inputs: LaneValues<N>,
    out: LaneValues<N>,
}

/// Points for which interpreting costs about what making machine code does.
const POINTS_PER_COMPILATION: usize = 4096;

/// Source of the values of an output.
#[derive(Clone, Copy, Debug)]
enum Output {
    /// Value that is equal at all points.
    Known(f64),
    /// A register.
    Varying(u32),
}

/// One instruction, or one angle of a turn, on registers that are used again.
#[derive(Clone, Copy, Debug)]
struct SlotInstruction {
    action: Action,
    a: u32,
    b: u32,
    c: u32,
    /// The register written; for a turn that of the sine, and `c` is that of the cosine.
    out: u32,
}

impl Tape {
    /// The tape for many points, with everything computed that depends on parameters only.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one.
    pub fn batch(&self, parameters: &[f64]) -> Batch {
        let known = self.known(parameters, self.n_registers);
        let mut packing = Packing::new(self);
        let inputs = self.input_registers().map(|register| packing.slot(register)).collect();
        let mut steps = Vec::with_capacity(self.body.len());
        let mut next = self.first_body;
        for (time, instruction) in self.body.iter().enumerate() {
            packing.pack(self, time, instruction, next, &mut steps);
            next += instruction.n_results();
        }
        let is_known =
            |register| register < self.first_body && !self.input_registers().contains(&register);
        let output = |&register: &u32| match register as usize {
            register if is_known(register) => Output::Known(known[register]),
            register => Output::Varying(packing.slot(register)),
        };
        let outputs = self.outputs.iter().map(output).collect();
        let mut registers = vec![Wide::splat(0.0); packing.n_slots as usize];
        for (value, slot) in known.iter().zip(&packing.slots).take(self.first_body) {
            if let Some(slot) = slot {
                registers[*slot as usize] = Wide::splat(*value);
            }
        }
        let code = if widest_lanes() == 8 {
            BatchCode::Eight(Groups::new(self, parameters))
        } else {
            BatchCode::Four(Groups::new(self, parameters))
        };
        Batch { steps, inputs, outputs, registers, code, n_points: 0 }
    }
}

impl<const N: usize> Groups<N> {
    fn new(tape: &Tape, parameters: &[f64]) -> Self {
        let runner = LaneRunner::with_layout(tape.clone(), Jit::On, Layout::Columns);
        Self { runner, parameters: parameters.to_vec(), buffers: None }
    }

    /// Evaluation ([`Batch::evaluate`]) if there is machine code, or it pays to make it.
    fn evaluate(&mut self, pays: bool, n_points: usize, inputs: &[f64], out: &mut [f64]) -> bool {
        let Self { runner, parameters, buffers } = self;
        if !(runner.is_compiled() || pays && runner.has_code()) {
            return false;
        }
        let buffers = buffers.get_or_insert_with(|| GroupBuffers {
            workspace: runner.workspace(parameters),
            inputs: LaneValues::zeros(runner.tape().n_inputs),
            out: LaneValues::zeros(runner.tape().outputs.len()),
        });
        let n_whole = n_points - n_points % N;
        for first in (0..n_whole).step_by(N) {
            let group = Group { n_points, first };
            runner.evaluate_group(&mut buffers.workspace, group, inputs, out);
        }
        if n_whole < n_points {
            buffers.evaluate_last(runner, Group { n_points, first: n_whole }, inputs, out);
        }
        true
    }
}

impl<const N: usize> GroupBuffers<N> {
    /// Computes all outputs at a last group of fewer points; lanes without one repeat the last one.
    fn evaluate_last(
        &mut self,
        runner: &LaneRunner<N>,
        Group { n_points, first }: Group,
        inputs: &[f64],
        out: &mut [f64],
    ) {
        for (lanes, values) in self.inputs.iter_mut().zip(inputs.chunks_exact(n_points)) {
            *lanes = std::array::from_fn(|lane| values[(first + lane).min(n_points - 1)]);
        }
        runner.evaluate(&mut self.workspace, &self.inputs, &mut self.out);
        for (lanes, values) in self.out.iter().zip(out.chunks_exact_mut(n_points)) {
            values[first..].copy_from_slice(&lanes[..n_points - first]);
        }
    }
}

/// Allocation of slots: every register of a tape has one that no other needs at the same time.
struct Packing {
    slots: Vec<Option<u32>>,
    n_slots: u32,
    free: Vec<u32>,
    /// Position in the body of the last instruction that reads each register; those read by
    /// outputs, and those before the body, are never released.
    last_read: Vec<usize>,
}

impl Packing {
    fn new(tape: &Tape) -> Self {
        let mut last_read = vec![0; tape.n_registers];
        for (time, instruction) in tape.body.iter().enumerate() {
            operands(tape, instruction, |register| last_read[register] = time);
        }
        last_read[..tape.first_body].fill(usize::MAX);
        tape.outputs.iter().for_each(|&register| last_read[register as usize] = usize::MAX);
        let slots = vec![None; tape.n_registers];
        let mut packing = Self { slots, n_slots: 0, free: Vec::new(), last_read };
        // A value known beforehand must not take a slot that was in use before.
        let mut known = |register: usize| {
            if register < tape.first_body {
                packing.slot(register);
            }
        };
        tape.body.iter().for_each(|instruction| operands(tape, instruction, &mut known));
        tape.outputs.iter().for_each(|&register| known(register as usize));
        packing
    }

    /// The slot of a register, given to it now if it has none.
    fn slot(&mut self, register: usize) -> u32 {
        if let Some(slot) = self.slots[register] {
            return slot;
        }
        let slot = self.free.pop().unwrap_or_else(|| {
            self.n_slots += 1;
            self.n_slots - 1
        });
        self.slots[register] = Some(slot);
        slot
    }

    /// Appends the steps of an instruction whose first result is the register `result`.
    fn pack(
        &mut self,
        tape: &Tape,
        time: usize,
        instruction: &Instruction,
        result: usize,
        steps: &mut Vec<SlotInstruction>,
    ) {
        let &Instruction { action, a, b, c } = instruction;
        if action == Action::Turn {
            let angles = tape.angles_of(instruction);
            for (sine, &angle) in (result..).zip(angles) {
                let a = self.slot(angle as usize);
                let out = self.slot(sine);
                let c = self.slot(sine + angles.len());
                steps.push(SlotInstruction { action, a, b: a, c, out });
            }
            self.release(tape, time, instruction);
        } else {
            let [a, b, c] = [a, b, c].map(|register| self.slot(register as usize));
            // A result may take the slot of an operand: lanes are read before they are written.
            self.release(tape, time, instruction);
            let out = self.slot(result);
            steps.push(SlotInstruction { action, a, b, c, out });
        }
    }

    /// Frees the slots of operands that are read for the last time.
    fn release(&mut self, tape: &Tape, time: usize, instruction: &Instruction) {
        let Self { slots, free, last_read, .. } = self;
        operands(tape, instruction, |register| {
            if last_read[register] == time {
                free.extend(slots[register].take());
            }
        });
    }
}

/// Visits the registers that an instruction reads.
fn operands(tape: &Tape, instruction: &Instruction, mut visit: impl FnMut(usize)) {
    if instruction.action == Action::Turn {
        tape.angles_of(instruction).iter().for_each(|&angle| visit(angle as usize));
    } else {
        for register in [instruction.a, instruction.b, instruction.c] {
            visit(register as usize);
        }
    }
}

impl Batch {
    /// Computes all outputs at `n_points` points.
    ///
    /// `inputs` holds all values of the first input, then all of the second and so on; `out`
    /// takes the outputs in the same way.
    ///
    /// # Panics
    /// When `inputs` or `out` do not hold `n_points` values of each input and output.
    pub fn evaluate(&mut self, n_points: usize, inputs: &[f64], out: &mut [f64]) {
        assert_eq!(inputs.len(), n_points * self.inputs.len(), "values of all inputs");
        assert_eq!(out.len(), n_points * self.outputs.len(), "values of all outputs");
        self.n_points = self.n_points.saturating_add(n_points);
        let pays = self.n_points >= POINTS_PER_COMPILATION;
        let is_done = match &mut self.code {
            BatchCode::Four(groups) => groups.evaluate(pays, n_points, inputs, out),
            BatchCode::Eight(groups) => groups.evaluate(pays, n_points, inputs, out),
        };
        if is_done {
            return;
        }
        Arch::new().dispatch(Run { batch: self, n_points, inputs, out });
    }
}

/// One call of [`Batch::evaluate`], compiled for every instruction set there may be.
struct Run<'a> {
    batch: &'a mut Batch,
    n_points: usize,
    inputs: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { batch: Batch { steps, inputs, outputs, registers, .. }, n_points, .. } = self;
        for (values, output) in self.out.chunks_exact_mut(n_points.max(1)).zip(&*outputs) {
            if let &Output::Known(value) = output {
                values.fill(value);
            }
        }
        for first in (0..n_points).step_by(WIDTH) {
            for (values, &register) in self.inputs.chunks_exact(n_points).zip(&*inputs) {
                load(&values[first..], &mut registers[register as usize]);
            }
            for step in &*steps {
                execute(step, registers);
            }
            for (values, output) in self.out.chunks_exact_mut(n_points).zip(&*outputs) {
                if let &Output::Varying(register) = output {
                    store(&registers[register as usize], &mut values[first..]);
                }
            }
        }
    }
}

/// Fills a register with the first of the values; lanes without one repeat the first, so that they
/// cost nothing unusual.
#[inline(always)]
fn load(values: &[f64], Wide(register): &mut Wide) {
    let (blocks, rest) = values.as_chunks::<LANES>();
    if let Some(blocks) = blocks.first_chunk::<BLOCKS>() {
        copy(blocks, register);
        return;
    }
    let (full, idle) = register.split_at_mut(blocks.len());
    full.copy_from_slice(blocks);
    idle.as_flattened_mut().fill(values[0]);
    idle.as_flattened_mut()[..rest.len()].copy_from_slice(rest);
}

/// Stores a register's lanes in as many of the values as there are.
#[inline(always)]
fn store(Wide(register): &Wide, values: &mut [f64]) {
    let (blocks, rest) = values.as_chunks_mut::<LANES>();
    if let Some(blocks) = blocks.first_chunk_mut::<BLOCKS>() {
        copy(register, blocks);
        return;
    }
    let (full, partial) = register.split_at(blocks.len());
    blocks.copy_from_slice(full);
    rest.copy_from_slice(&partial.as_flattened()[..rest.len()]);
}

#[expect(clippy::manual_memcpy, reason = "a few vector moves cost less than the call of a copy")]
#[inline(always)]
fn copy(from: &[[f64; LANES]; BLOCKS], to: &mut [[f64; LANES]; BLOCKS]) {
    for block in 0..BLOCKS {
        to[block] = from[block];
    }
}

#[inline(always)]
fn execute(step: &SlotInstruction, registers: &mut [Wide]) {
    match step.action {
        Action::Add => each(step, registers, |a, b| a + b),
        Action::Subtract => each(step, registers, |a, b| a - b),
        Action::Multiply => each(step, registers, |a, b| a * b),
        Action::Divide => each(step, registers, |a, b| a / b),
        Action::Negate => each(step, registers, |a, _| -a),
        Action::Power => each(step, registers, power),
        Action::Turn => turn(step, registers),
        Action::Call(Function::If) => {
            let Wide(c) = registers[step.c as usize];
            for (block, c) in c.iter().enumerate() {
                let (a, b) =
                    (registers[step.a as usize].0[block], registers[step.b as usize].0[block]);
                let lane = |lane| select(a[lane], b[lane], c[lane]);
                registers[step.out as usize].0[block] = std::array::from_fn(lane);
            }
        }
        #[expect(clippy::disallowed_methods, reason = "exact everywhere, so lanes may have it")]
        Action::Call(Function::Sqrt) => each(step, registers, |a, _| a.sqrt()),
        Action::Call(function) => call(step, registers, function),
    }
}

/// Applies an operation to two operands at all points.
#[inline(always)]
fn each(step: &SlotInstruction, registers: &mut [Wide], operation: impl Fn(f64, f64) -> f64) {
    for block in 0..BLOCKS {
        let (a, b) = (registers[step.a as usize].0[block], registers[step.b as usize].0[block]);
        let lane = |lane| operation(a[lane], b[lane]);
        registers[step.out as usize].0[block] = std::array::from_fn(lane);
    }
}

/// Applies a function of two operands at all points.
#[inline(always)]
fn call(step: &SlotInstruction, registers: &mut [Wide], function: Function) {
    for block in 0..BLOCKS {
        let (a, b) = (registers[step.a as usize].0[block], registers[step.b as usize].0[block]);
        registers[step.out as usize].0[block] = function.lanes(a, b);
    }
}

#[inline(always)]
fn turn(step: &SlotInstruction, registers: &mut [Wide]) {
    for block in 0..BLOCKS {
        let (sines, cosines) = sin_cos_lanes(registers[step.a as usize].0[block]);
        registers[step.out as usize].0[block] = sines;
        registers[step.c as usize].0[block] = cosines;
    }
}
