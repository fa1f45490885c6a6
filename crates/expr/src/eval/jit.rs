//! Machine code for a tape, functions of three arrays that are called one after the other.
//!
//! ```text
//! f₁(registers, inputs, outputs); f₂(registers, inputs, outputs); …
//! ```
//!
//! Each function is one section of the body. The time that the code generator takes for a function grows faster
//! than its length, so long bodies have many; what a later section uses is stored in the workspace.
//!
//! Numbers in the workspace (constants, parameters, the prologue's results, sines and cosines) and
//! inputs are read from memory each time they are used: an operand in memory costs nothing,
//! a register kept alive may cost a spill. Outputs are stored as soon as they are known. Nothing is
//! reordered or fused, and elementary functions are calls back into this crate, so results equal
//! the interpreter's bit for bit.

#![expect(unsafe_code, reason = "machine code is called through raw pointers")]

use super::interpreter::Workspace;
use super::memory::{JitError, MOST_INSTRUCTIONS, Memory, module, signature};
use super::sections::{Body, SECTION, Section};
use crate::op::{Function, power};
use crate::sincos::{FEW, sin_cos_few};
use crate::tape::{Action, Instruction, Tape};
use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::types::{F64, I64};
use cranelift_codegen::ir::{AbiParam, FuncRef, InstBuilder, MemFlagsData, Value};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::JITModule;
use cranelift_module::{FuncId, Linkage, Module, ModuleError};

/// Machine code of one [`Tape`].
///
/// It works on the workspaces of its tape, is shared freely between threads, and frees its memory
/// when dropped.
///
/// ```
/// use bksim_expr::{Pool, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let e = pool.parse("l*sin(q)")?;
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let tape = Tape::compile(&pool, &[e], &[id("q")], &[id("l")])?;
/// let code = tape.machine_code()?;
/// let mut workspace = tape.workspace(&[2.0]);
/// let (mut ours, mut theirs) = ([0.0], [0.0]);
/// code.evaluate(&mut workspace, &[0.5], &mut ours);
/// tape.evaluate(&mut workspace, &[0.5], &mut theirs);
/// assert_eq!(ours, theirs);
/// # Ok(())
/// # }
/// ```
pub struct MachineCode {
    /// One for each section of the body, in order.
    functions: Vec<Compiled>,
    /// Owns the memory of `functions`.
    _memory: Memory,
    n_registers: usize,
    n_inputs: usize,
    n_outputs: usize,
}

type Compiled = unsafe extern "C" fn(*mut f64, *const f64, *mut f64);

impl std::fmt::Debug for MachineCode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MachineCode")
            .field("n_registers", &self.n_registers)
            .finish_non_exhaustive()
    }
}

impl Tape {
    /// Compiles the body to machine code.
    ///
    /// # Errors
    /// [`JitError::TooLong`] for bodies beyond 500 000 instructions, [`JitError::Host`] where the
    /// processor is not supported.
    pub fn machine_code(&self) -> Result<MachineCode, JitError> {
        if self.body.len() > MOST_INSTRUCTIONS {
            let (found, limit) = (self.body.len(), MOST_INSTRUCTIONS);
            return Err(JitError::TooLong { found, limit });
        }
        let mut module = module_with_callees()?;
        match define(&mut module, self) {
            Ok(ids) => {
                let function = |id| {
                    let address = module.get_finalized_function(id);
                    // SAFETY: the function was declared with three pointers and no result, in the
                    // calling convention of the host, and its memory lives as long as the module.
                    unsafe { std::mem::transmute::<*const u8, Compiled>(address) }
                };
                let functions = ids.into_iter().map(function).collect();
                Ok(MachineCode {
                    functions,
                    _memory: Memory::holding(module),
                    n_registers: self.n_registers,
                    n_inputs: self.n_inputs,
                    n_outputs: self.outputs.len(),
                })
            }
            Err(fault) => {
                // SAFETY: no function of the module was ever called or handed out.
                unsafe { module.free_memory() };
                Err(fault.into())
            }
        }
    }
}

impl MachineCode {
    /// Computes all outputs, as [`Tape::evaluate`] does.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut Workspace, inputs: &[f64], out: &mut [f64]) {
        assert_eq!(inputs.len(), self.n_inputs, "number of inputs");
        assert_eq!(out.len(), self.n_outputs, "number of outputs");
        let registers = ws.registers();
        assert_eq!(registers.len(), self.n_registers, "a workspace of this tape");
        for function in &self.functions {
            // SAFETY: the code stays within the three lengths that were just checked.
            unsafe { function(registers.as_mut_ptr(), inputs.as_ptr(), out.as_mut_ptr()) }
        }
    }
}

/// Sines and cosines of the first `N` of four angles.
extern "C" fn turn<const N: usize>(
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    sines: &mut [f64; N],
    cosines: &mut [f64; N],
) {
    sin_cos_few([a, b, c, d], sines, cosines);
}

/// The functions that generated code calls to turn one to four angles.
const TURNS: [&str; FEW] = ["turn_1", "turn_2", "turn_3", "turn_4"];

extern "C" fn elementary(function: usize, a: f64, b: f64) -> f64 {
    let function = Function::from_index(function);
    function.expect("generated code passes the index of a function").value(a, b)
}

extern "C" fn general_power(base: f64, exponent: f64) -> f64 {
    power(base, exponent)
}

/// A module for this processor that knows the functions called back.
fn module_with_callees() -> Result<JITModule, JitError> {
    let turns = [turn::<1> as *const u8, turn::<2> as _, turn::<3> as _, turn::<4> as _];
    let others = [("elementary", elementary as *const u8), ("power", general_power as _)];
    module(TURNS.into_iter().zip(turns).chain(others))
}

/// Compiles the body of the tape, section by section.
fn define(module: &mut JITModule, tape: &Tape) -> Result<Vec<FuncId>, Box<ModuleError>> {
    let mut import = |name: &str, parameters: &[_], result: Option<_>| {
        let mut signature = module.make_signature();
        signature.params.extend(parameters.iter().map(|&kind| AbiParam::new(kind)));
        signature.returns.extend(result.map(AbiParam::new));
        module.declare_function(name, Linkage::Import, &signature).map_err(Box::new)
    };
    let mut turns = Vec::with_capacity(FEW);
    for name in TURNS {
        turns.push(import(name, &[F64, F64, F64, F64, I64, I64], None)?);
    }
    let elementary = import("elementary", &[I64, F64, F64], Some(F64))?;
    let power = import("power", &[F64, F64], Some(F64))?;

    let body = Body::of(tape);
    let mut scratch = FunctionBuilderContext::new();
    let mut context = module.make_context();
    let mut ids = Vec::with_capacity(body.sections.len());
    for (number, section) in body.sections.iter().enumerate() {
        context.func.signature = signature(module);
        let name = format!("section_{number}");
        let id = module.declare_function(&name, Linkage::Export, &context.func.signature);
        let id = id.map_err(Box::new)?;
        let mut builder = FunctionBuilder::new(&mut context.func, &mut scratch);
        let mut callee = |id| module.declare_func_in_func(id, builder.func);
        let turns = turns.iter().map(|&id| callee(id)).collect();
        let callees = Callees { turns, elementary: callee(elementary), power: callee(power) };
        let block = builder.create_block();
        builder.append_block_params_for_function_params(block);
        builder.switch_to_block(block);
        builder.seal_block(block);
        let mut emitter = Emitter::new(&body, *section, builder, callees);
        emitter.emit();
        emitter.builder.ins().return_(&[]);
        emitter.builder.finalize(module.target_config());
        module.define_function(id, &mut context).map_err(Box::new)?;
        module.clear_context(&mut context);
        ids.push(id);
    }
    module.finalize_definitions().map_err(Box::new)?;
    Ok(ids)
}

/// The functions that generated code calls.
struct Callees {
    /// By the number of angles, from one.
    turns: Vec<FuncRef>,
    elementary: FuncRef,
    power: FuncRef,
}

/// Location of a register of the tape in generated code.
#[derive(Clone, Copy)]
enum Location {
    Memory { base: Value, offset: i32 },
    Value(Value),
}

/// Writes the code of one section.
struct Emitter<'a> {
    body: &'a Body<'a>,
    section: Section,
    builder: FunctionBuilder<'a>,
    callees: Callees,
    registers: Value,
    inputs: Value,
    out: Value,
    /// Locations of the section's results so far.
    locations: Vec<Location>,
}

/// Accesses never trap: lengths are checked before the call.
const TRUSTED: MemFlagsData = MemFlagsData::trusted();

/// Distance of the `n`-th number from the first of an array.
fn offset(n: usize) -> i32 {
    i32::try_from(8 * n).expect("arrays of short tapes are shorter than 2^31 bytes")
}

impl<'a> Emitter<'a> {
    fn new(
        body: &'a Body<'a>,
        section: Section,
        builder: FunctionBuilder<'a>,
        callees: Callees,
    ) -> Self {
        let block = builder.current_block().expect("the entry block is current");
        let &[registers, inputs, out] = builder.block_params(block) else {
            unreachable!("the signature has three parameters")
        };
        let locations = Vec::with_capacity(SECTION);
        Self { body, section, builder, callees, registers, inputs, out, locations }
    }

    /// The whole section; outputs, and what later sections use, are stored as soon as they are known.
    fn emit(&mut self) {
        let tape = self.body.tape;
        let [start, end] = self.section.instructions;
        if start == 0 {
            self.store_outputs(0);
        }
        for instruction in &tape.body[start..end] {
            let first = self.next_register();
            if instruction.action == Action::Turn {
                self.turn(instruction);
            } else {
                let value = self.value(instruction);
                self.locations.push(Location::Value(value));
                if self.body.is_used_later[first - tape.first_body] {
                    self.builder.ins().store(TRUSTED, value, self.registers, offset(first));
                }
            }
            self.store_outputs(first);
        }
    }

    /// The register of the next result.
    fn next_register(&self) -> usize {
        self.section.first + self.locations.len()
    }

    /// Stores the outputs that are held by registers from `first` on.
    fn store_outputs(&mut self, first: usize) {
        let (outputs, next) = (&self.body.outputs, self.next_register());
        let start = outputs.partition_point(|&(register, _)| register < first);
        let end = outputs.partition_point(|&(register, _)| register < next);
        for &(register, position) in &outputs[start..end] {
            let value = self.read(register);
            self.builder.ins().store(TRUSTED, value, self.out, offset(position));
        }
    }

    fn read(&mut self, register: usize) -> Value {
        let tape = self.body.tape;
        let own = register.checked_sub(self.section.first);
        let location = match own {
            Some(result) => self.locations[result],
            None if tape.input_registers().contains(&register) => {
                let offset = offset(register - tape.first_input());
                Location::Memory { base: self.inputs, offset }
            }
            None => Location::Memory { base: self.registers, offset: offset(register) },
        };
        match location {
            Location::Value(value) => value,
            Location::Memory { base, offset } => {
                self.builder.ins().load(F64, TRUSTED, base, offset)
            }
        }
    }

    /// Hands over a few angles at a time; the results lie in the workspace's own registers.
    fn turn(&mut self, instruction: &Instruction) {
        let angles = self.body.tape.angles_of(instruction);
        let first = self.next_register();
        for (chunk, angles_here) in angles.chunks(FEW).enumerate() {
            let angle = |lane| *angles_here.get(lane).unwrap_or(&angles_here[0]) as usize;
            let sines = first + chunk * FEW;
            let mut arguments = [0, 1, 2, 3].map(|lane| self.read(angle(lane))).to_vec();
            arguments.extend(
                [sines, sines + angles.len()]
                    .map(|n| self.builder.ins().iadd_imm_s(self.registers, i64::from(offset(n)))),
            );
            self.builder.ins().call(self.callees.turns[angles_here.len() - 1], &arguments);
        }
        let base = self.registers;
        let results = first..first + 2 * angles.len();
        self.locations.extend(results.map(|n| Location::Memory { base, offset: offset(n) }));
    }

    fn value(&mut self, instruction: &Instruction) -> Value {
        let a = self.read(instruction.a as usize);
        match instruction.action {
            Action::Negate => return self.builder.ins().fneg(a),
            Action::Call(function) if function.arity() == 1 => return self.call_one(function, a),
            _ => (),
        }
        let b = self.read(instruction.b as usize);
        match instruction.action {
            Action::Add => self.builder.ins().fadd(a, b),
            Action::Subtract => self.builder.ins().fsub(a, b),
            Action::Multiply => self.builder.ins().fmul(a, b),
            Action::Divide => self.builder.ins().fdiv(a, b),
            Action::Power => {
                let call = self.builder.ins().call(self.callees.power, &[a, b]);
                self.builder.inst_results(call)[0]
            }
            Action::Call(Function::If) => {
                let c = self.read(instruction.c as usize);
                self.branch(a, b, c)
            }
            Action::Call(function) => self.call_two(function, a, b),
            Action::Negate | Action::Turn => unreachable!("emitted elsewhere"),
        }
    }

    fn call_one(&mut self, function: Function, a: Value) -> Value {
        match function {
            Function::Sqrt => self.builder.ins().sqrt(a),
            Function::Abs => self.builder.ins().fabs(a),
            Function::Sign => {
                let (zero, one) = (self.number(0.0), self.number(1.0));
                let is_plain = self.builder.ins().fcmp(FloatCC::UnorderedOrEqual, a, zero);
                let sign = self.builder.ins().fcopysign(one, a);
                self.builder.ins().select(is_plain, a, sign)
            }
            _ => self.elementary(function, a, a),
        }
    }

    fn call_two(&mut self, function: Function, a: Value, b: Value) -> Value {
        match function {
            Function::Min => self.extremum(FloatCC::LessThanOrEqual, a, b),
            Function::Max => self.extremum(FloatCC::GreaterThanOrEqual, a, b),
            Function::Lt => self.comparison(FloatCC::LessThan, a, b),
            Function::Le => self.comparison(FloatCC::LessThanOrEqual, a, b),
            Function::Gt => self.comparison(FloatCC::GreaterThan, a, b),
            Function::Ge => self.comparison(FloatCC::GreaterThanOrEqual, a, b),
            _ => self.elementary(function, a, b),
        }
    }

    /// `a` where it compares so with `b` or is NaN, else `b`.
    fn extremum(&mut self, condition: FloatCC, a: Value, b: Value) -> Value {
        let is_nan = self.builder.ins().fcmp(FloatCC::Unordered, a, a);
        let other = self.builder.ins().select(is_nan, a, b);
        let is_first = self.builder.ins().fcmp(condition, a, b);
        self.builder.ins().select(is_first, a, other)
    }

    fn comparison(&mut self, condition: FloatCC, a: Value, b: Value) -> Value {
        let (zero, one) = (self.number(0.0), self.number(1.0));
        let holds = self.builder.ins().fcmp(condition, a, b);
        self.builder.ins().select(holds, one, zero)
    }

    /// `if(a, b, c)`: c where a is zero, a where it is NaN, else b.
    fn branch(&mut self, a: Value, b: Value, c: Value) -> Value {
        let zero = self.number(0.0);
        let is_false = self.builder.ins().fcmp(FloatCC::Equal, a, zero);
        let taken = self.builder.ins().select(is_false, c, b);
        let is_nan = self.builder.ins().fcmp(FloatCC::Unordered, a, a);
        self.builder.ins().select(is_nan, a, taken)
    }

    fn elementary(&mut self, function: Function, a: Value, b: Value) -> Value {
        let index = self.builder.ins().iconst(I64, function as i64);
        let call = self.builder.ins().call(self.callees.elementary, &[index, a, b]);
        self.builder.inst_results(call)[0]
    }

    fn number(&mut self, value: f64) -> Value {
        self.builder.ins().f64const(value)
    }
}
