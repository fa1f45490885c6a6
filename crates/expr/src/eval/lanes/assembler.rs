//! The machine instructions that code in lanes is made of, as bytes: those of AVX on one number or four, those of
//! AVX-512 on eight, and a few around calls.
//!
//! Encodings: Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, §2.3 (the VEX prefix), §2.7 (the
//! EVEX prefix) and the pages of the instructions.

#[cfg(test)]
mod tests;

use super::Layout;

/// Numbers in the lanes of a register.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Width {
    /// The lowest lane of 128 bits.
    One,
    /// 256 bits, AVX2.
    Four,
    /// 512 bits, AVX-512 with its F and DQ instructions.
    Eight,
}

impl Width {
    /// The width of so many lanes, where the processor has it.
    pub(super) fn of(n_lanes: usize) -> Option<Self> {
        let has_avx = std::arch::is_x86_feature_detected!("avx2");
        let has_avx512 = std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512dq");
        match n_lanes {
            1 if has_avx => Some(Self::One),
            4 if has_avx => Some(Self::Four),
            8 if has_avx512 => Some(Self::Eight),
            _ => None,
        }
    }

    /// Bytes of the numbers in all lanes.
    fn bytes(self) -> i32 {
        match self {
            Self::One => 8,
            Self::Four => 32,
            Self::Eight => 64,
        }
    }

    /// Vector registers there are.
    pub(super) fn n_vectors(self) -> u8 {
        match self {
            Self::One | Self::Four => 16,
            Self::Eight => 32,
        }
    }
}

/// A vector register, by its number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Vector(pub(super) u8);

/// An array that numbers lie in, by the register that holds its address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Base {
    /// Registers of the tape, rbx.
    Registers = 3,
    /// Outputs, r14.
    Outputs = 14,
    /// Inputs, r15.
    Inputs = 15,
}

/// The last operand of an instruction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Operand {
    Vector(Vector),
    /// The numbers in all lanes at this place of an array.
    Memory(Base, i32),
}

/// Opcodes of instructions on numbers or their bits, `out = a op b`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Opcode {
    Sqrt = 0x51,
    And = 0x54,
    Or = 0x56,
    Xor = 0x57,
    Add = 0x58,
    Multiply = 0x59,
    Subtract = 0x5c,
    Divide = 0x5e,
}

/// Predicates of a comparison; all are quiet, and hold for ordered numbers alone unless they say so.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Predicate {
    Equal = 0x00,
    Unordered = 0x03,
    EqualOrUnordered = 0x08,
    Less = 0x11,
    LessOrEqual = 0x12,
    GreaterOrEqual = 0x1d,
    Greater = 0x1e,
}

/// General registers of the first three arguments of a call.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Argument {
    First = 7,
    Second = 6,
    Third = 2,
}

impl Opcode {
    fn is_of_bits(self) -> bool {
        matches!(self, Self::And | Self::Or | Self::Xor)
    }
}

const LOAD: u8 = 0x10;
const STORE: u8 = 0x11;
const COMPARE: u8 = 0xc2;
const BLEND: u8 = 0x4b;
/// Opcode of a blend by a mask register.
const BLEND_BY_MASK: u8 = 0x65;
/// Bits of 64, moved by an immediate operand; to the left, by the extension of the opcode.
const SHIFT: u8 = 0x73;
const TO_THE_LEFT: Vector = Vector(6);
/// Opcode maps: the second one, and those of three-byte opcodes, the last with an immediate operand.
const MAP_0F: u8 = 1;
const MAP_0F38: u8 = 2;
const MAP_0F3A: u8 = 3;

/// Operands of an instruction.
#[derive(Clone, Copy, Debug)]
struct Operation {
    map: u8,
    opcode: u8,
    /// True where one lane is taken as a whole register: bits have no instructions of their own on a part of it.
    is_packed: bool,
    /// Written, or the source of a store.
    reg: Vector,
    /// The first source; register 0 where there is none.
    first: Vector,
    /// The last operand.
    last: Operand,
    /// Of eight lanes: none or the mask register 1, and whether lanes that it leaves out become zero.
    mask: u8,
    is_zeroing: bool,
}

/// Collects the bytes of a function `f(registers, inputs, outputs, stride)` in the System V convention.
#[derive(Debug)]
pub(super) struct Assembler {
    pub(super) bytes: Vec<u8>,
    width: Width,
    /// Of inputs and outputs; r12 holds the stride of columns, in bytes.
    layout: Layout,
    /// The mask of the last comparison, where masks are vectors.
    mask: Vector,
}

impl Assembler {
    /// No code yet; `mask` takes the masks of comparisons.
    pub(super) fn new(width: Width, layout: Layout, mask: Vector) -> Self {
        Self { bytes: Vec::new(), width, layout, mask }
    }

    /// Keeps the registers of the caller, and takes the arguments.
    pub(super) fn enter(&mut self) {
        // push rbx; push rbp; push r12; push r14; push r15; an odd number keeps the stack aligned for calls
        self.put(&[0x53, 0x55, 0x41, 0x54, 0x41, 0x56, 0x41, 0x57]);
        // mov rbx, rdi; mov r15, rsi; mov r14, rdx; mov r12, rcx
        self.put(&[0x48, 0x89, 0xfb, 0x49, 0x89, 0xf7, 0x49, 0x89, 0xd6, 0x49, 0x89, 0xcc]);
    }

    /// Returns to the caller.
    pub(super) fn leave(&mut self) {
        // pop r15; pop r14; pop r12; pop rbp; pop rbx; ret
        self.clear_upper();
        self.put(&[0x41, 0x5f, 0x41, 0x5e, 0x41, 0x5c, 0x5d, 0x5b, 0xc3]);
    }

    /// `out = a op b`; a square root reads `b` alone.
    pub(super) fn operate(&mut self, opcode: Opcode, out: Vector, a: Vector, b: Operand) {
        // The root of one number takes the rest of its register from the first source.
        let first = match (opcode, self.width, b) {
            (Opcode::Sqrt, Width::One, Operand::Vector(b)) => b,
            (Opcode::Sqrt, Width::One, Operand::Memory(..)) => out,
            (Opcode::Sqrt, ..) => Vector(0),
            _ => a,
        };
        let is_packed = opcode.is_of_bits();
        self.instruction(&Operation { is_packed, ..plain(opcode as u8, out, first, b) });
    }

    /// `out = a`.
    pub(super) fn load(&mut self, out: Vector, a: Operand) {
        // One number is loaded alone, but copied with its register.
        let is_packed = matches!(a, Operand::Vector(_));
        self.instruction(&Operation { is_packed, ..plain(LOAD, out, Vector(0), a) });
    }

    /// Stores `a` at this place of an array.
    pub(super) fn store(&mut self, base: Base, number: i32, a: Vector) {
        self.instruction(&plain(STORE, a, Vector(0), Operand::Memory(base, number)));
    }

    /// `out = a` with its bits moved to the left.
    pub(super) fn shift_left(&mut self, out: Vector, a: Vector, n: u8) {
        let operation = plain(SHIFT, TO_THE_LEFT, out, Operand::Vector(a));
        self.instruction(&Operation { is_packed: true, ..operation });
        self.put(&[n]);
    }

    /// Sets the mask: all bits where `a` compares so with `b`, none elsewhere.
    pub(super) fn compare(&mut self, predicate: Predicate, a: Vector, b: Operand) {
        let mask = if self.width == Width::Eight { Vector(1) } else { self.mask };
        self.instruction(&plain(COMPARE, mask, a, b));
        self.put(&[predicate as u8]);
    }

    /// `b` where the mask is set, `a` elsewhere.
    pub(super) fn blend(&mut self, out: Vector, a: Vector, b: Operand) {
        if self.width == Width::Eight {
            let operation = plain(BLEND_BY_MASK, out, a, b);
            self.instruction(&Operation { map: MAP_0F38, mask: 1, ..operation });
            return;
        }
        let operation = plain(BLEND, out, a, b);
        self.instruction(&Operation { map: MAP_0F3A, is_packed: true, ..operation });
        self.put(&[self.mask.0 << 4]);
    }

    /// `a` where the mask is set, zero elsewhere.
    pub(super) fn keep(&mut self, out: Vector, a: Operand) {
        if self.width == Width::Eight {
            let operation = plain(LOAD, out, Vector(0), a);
            self.instruction(&Operation { mask: 1, is_zeroing: true, ..operation });
        } else {
            self.operate(Opcode::And, out, self.mask, a);
        }
    }

    /// An address in the registers of the tape as an argument.
    pub(super) fn pass_address(&mut self, argument: Argument, number: i32) {
        // lea argument, [rbx + disp32]
        self.put(&[0x48, 0x8d, 0x83 | (argument as u8) << 3]);
        self.put(&(self.width.bytes() * number).to_le_bytes());
    }

    /// A number as an argument.
    pub(super) fn pass_number(&mut self, argument: Argument, number: u32) {
        // mov argument, imm32
        self.put(&[0xb8 | argument as u8]);
        self.put(&number.to_le_bytes());
    }

    /// Calls a function at an address; no vector register survives.
    pub(super) fn call(&mut self, address: u64) {
        // mov rax, imm64; call rax
        self.clear_upper();
        self.put(&[0x48, 0xb8]);
        self.put(&address.to_le_bytes());
        self.put(&[0xff, 0xd0]);
    }

    /// Code on narrower registers would wait for the upper halves.
    fn clear_upper(&mut self) {
        self.put(&[0xc5, 0xf8, 0x77]);
    }

    fn instruction(&mut self, operation: &Operation) {
        let Operation { opcode, reg, last, .. } = *operation;
        let column = self.column(last);
        if let Some(column) = column {
            // imul rax, r12, imm32
            self.put(&[0x49, 0x69, 0xc4]);
            self.put(&column.to_le_bytes());
        }
        match self.width {
            Width::Eight => self.evex(operation),
            Width::One | Width::Four => self.vex(operation),
        }
        let reg = (reg.0 & 7) << 3;
        match last {
            Operand::Vector(Vector(number)) => self.put(&[opcode, 0xc0 | reg | number & 7]),
            // [base + rax]
            Operand::Memory(base, _) if column.is_some() => {
                self.put(&[opcode, 0x04 | reg, base as u8 & 7]);
            }
            Operand::Memory(base, number) => {
                let base = base as u8 & 7;
                // Short displacements are counted in bytes, and by EVEX in operands.
                let displacement = self.width.bytes() * number;
                let short = if self.width == Width::Eight { number } else { displacement };
                if let Ok(short) = i8::try_from(short) {
                    self.put(&[opcode, 0x40 | reg | base]);
                    self.put(&short.to_le_bytes());
                } else {
                    self.put(&[opcode, 0x80 | reg | base]);
                    self.put(&displacement.to_le_bytes());
                }
            }
        }
    }

    /// The column that an operand is in, where columns are a stride apart.
    fn column(&self, operand: Operand) -> Option<i32> {
        match operand {
            Operand::Memory(Base::Inputs | Base::Outputs, column) => {
                (self.layout == Layout::Columns).then_some(column)
            }
            _ => None,
        }
    }

    /// The prefix of an instruction on one number or four.
    fn vex(&mut self, &Operation { map, is_packed, reg, first, last, .. }: &Operation) {
        // R, X, B and the first source are inverted. L tells four numbers from one, pp packed ones from a single one.
        let (r, b) = (!(reg.0 >> 3) & 1, !last.number() >> 3 & 1);
        let l = u8::from(self.width == Width::Four);
        let pp = if self.width == Width::One && !is_packed { 0b11 } else { 0b01 };
        let rest = (!first.0 & 15) << 3 | l << 2 | pp;
        if map == MAP_0F && b == 1 {
            self.put(&[0xc5, r << 7 | rest]);
        } else {
            self.put(&[0xc4, r << 7 | 1 << 6 | b << 5 | map, rest]);
        }
    }

    /// The prefix of an instruction on eight numbers.
    fn evex(&mut self, operation: &Operation) {
        let &Operation { map, reg, first, last, mask, is_zeroing, .. } = operation;
        // Bits 3 and 4 of the registers are inverted; X is bit 4 of a vector, and not of a base.
        let bit = |number: u8, bit: u8| !(number >> bit) & 1;
        let x = if matches!(last, Operand::Vector(_)) { bit(last.number(), 4) } else { 1 };
        let registers =
            bit(reg.0, 3) << 7 | x << 6 | bit(last.number(), 3) << 5 | bit(reg.0, 4) << 4;
        let source = 1 << 7 | (!first.0 & 15) << 3 | 1 << 2 | 0b01;
        let lanes = u8::from(is_zeroing) << 7 | 0b10 << 5 | bit(first.0, 4) << 3 | mask;
        self.put(&[0x62, registers | map, source, lanes]);
    }

    fn put(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }
}

/// An instruction of the second map on numbers.
fn plain(opcode: u8, reg: Vector, first: Vector, last: Operand) -> Operation {
    let (map, is_packed, mask, is_zeroing) = (MAP_0F, false, 0, false);
    Operation { map, opcode, is_packed, reg, first, last, mask, is_zeroing }
}

impl Operand {
    /// The number of the register that it is, or that holds its address.
    fn number(self) -> u8 {
        match self {
            Self::Vector(Vector(number)) => number,
            Self::Memory(base, _) => base as u8,
        }
    }
}
