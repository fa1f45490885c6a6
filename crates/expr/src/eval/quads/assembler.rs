//! The machine instructions that code in lanes is made of, as bytes: those of AVX on 256-bit registers, and
//! a few around calls.
//!
//! Encodings: Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, §2.3 (the VEX prefix)
//! and the pages of the instructions.

/// A vector register, 0 to 15.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Vector(pub(super) u8);

/// An array that numbers lie in, by the register that holds its address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Base {
    /// Registers of the tape, rbx.
    Registers = 3,
    /// Inputs, rbp.
    Inputs = 5,
    /// Outputs, r14.
    Outputs = 14,
}

/// The last operand of an instruction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Operand {
    Vector(Vector),
    /// The quad of this number in an array.
    Memory(Base, i32),
}

/// Opcodes of instructions on four numbers, `out = a op b`.
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

const LOAD: u8 = 0x10;
const STORE: u8 = 0x11;
const COMPARE: u8 = 0xc2;
const BLEND: u8 = 0x4b;
/// The second opcode map, and the one of instructions with an immediate third operand.
const MAP_0F: u8 = 1;
const MAP_0F3A: u8 = 3;

/// Bytes of a numbers' quad.
const QUAD: i32 = 32;

/// Collects the bytes of a function `f(registers, inputs, outputs)` in the System V convention.
#[derive(Debug, Default)]
pub(super) struct Assembler {
    pub(super) bytes: Vec<u8>,
}

impl Assembler {
    /// Keeps the registers of the caller, and takes the arguments.
    pub(super) fn enter(&mut self) {
        // push rbx; push rbp; push r14; mov rbx, rdi; mov rbp, rsi; mov r14, rdx
        self.put(&[0x53, 0x55, 0x41, 0x56]);
        self.put(&[0x48, 0x89, 0xfb, 0x48, 0x89, 0xf5, 0x49, 0x89, 0xd6]);
    }

    /// Returns to the caller.
    pub(super) fn leave(&mut self) {
        // pop r14; pop rbp; pop rbx; ret
        self.clear_upper();
        self.put(&[0x41, 0x5e, 0x5d, 0x5b, 0xc3]);
    }

    /// `out = a op b`; a square root reads `b` alone.
    pub(super) fn operate(&mut self, opcode: Opcode, out: Vector, a: Vector, b: Operand) {
        let a = if opcode == Opcode::Sqrt { Vector(0) } else { a };
        self.vex(MAP_0F, opcode as u8, out, a, b);
    }

    /// `out = a`.
    pub(super) fn load(&mut self, out: Vector, a: Operand) {
        self.vex(MAP_0F, LOAD, out, Vector(0), a);
    }

    /// Stores `a` in the quad of this number in an array.
    pub(super) fn store(&mut self, base: Base, number: i32, a: Vector) {
        self.vex(MAP_0F, STORE, a, Vector(0), Operand::Memory(base, number));
    }

    /// All bits where `a` compares so with `b`, none elsewhere.
    pub(super) fn compare(&mut self, predicate: Predicate, out: Vector, a: Vector, b: Operand) {
        self.vex(MAP_0F, COMPARE, out, a, b);
        self.put(&[predicate as u8]);
    }

    /// `b` where the bits of `mask` are set, `a` elsewhere.
    pub(super) fn blend(&mut self, out: Vector, a: Vector, b: Operand, mask: Vector) {
        self.vex(MAP_0F3A, BLEND, out, a, b);
        self.put(&[mask.0 << 4]);
    }

    /// An address in the registers of the tape as an argument.
    pub(super) fn pass_address(&mut self, argument: Argument, number: i32) {
        // lea argument, [rbx + disp32]
        self.put(&[0x48, 0x8d, 0x83 | (argument as u8) << 3]);
        self.put(&(QUAD * number).to_le_bytes());
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

    /// An instruction on 256-bit registers with the prefix `66`, as most on doubles have.
    fn vex(&mut self, map: u8, opcode: u8, reg: Vector, vvvv: Vector, rm: Operand) {
        let rm_high = match rm {
            Operand::Vector(Vector(number)) => number >> 3,
            Operand::Memory(base, _) => base as u8 >> 3,
        };
        // R, X, B and the second source are inverted; L = 1, pp = 01.
        let (r, b) = (!(reg.0 >> 3) & 1, !rm_high & 1);
        // Loads, stores and roots have no second source: none is written as register 0.
        let last = (!vvvv.0 & 15) << 3 | 0b101;
        if map == MAP_0F && b == 1 {
            self.put(&[0xc5, r << 7 | last]);
        } else {
            self.put(&[0xc4, r << 7 | 1 << 6 | b << 5 | map, last]);
        }
        let reg = (reg.0 & 7) << 3;
        match rm {
            Operand::Vector(Vector(number)) => self.put(&[opcode, 0xc0 | reg | number & 7]),
            Operand::Memory(base, number) => {
                let base = base as u8 & 7;
                let displacement = QUAD * number;
                if let Ok(short) = i8::try_from(displacement) {
                    self.put(&[opcode, 0x40 | reg | base]);
                    self.put(&short.to_le_bytes());
                } else {
                    self.put(&[opcode, 0x80 | reg | base]);
                    self.put(&displacement.to_le_bytes());
                }
            }
        }
    }

    fn put(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes of one instruction, against those of GNU `as`.
    fn check(expected: &[u8], emit: impl Fn(&mut Assembler)) {
        let mut assembler = Assembler::default();
        emit(&mut assembler);
        assert_eq!(assembler.bytes, expected, "{:02x?}", assembler.bytes);
    }

    #[test]
    fn instructions_have_the_bytes_of_another_assembler() {
        let v = Vector;
        let memory = Operand::Memory;
        // vdivpd 0x20(%r14),%ymm5,%ymm6
        check(&[0xc4, 0xc1, 0x55, 0x5e, 0x76, 0x20], |it| {
            it.operate(Opcode::Divide, v(6), v(5), memory(Base::Outputs, 1));
        });
        // vsqrtpd %ymm7,%ymm8
        check(&[0xc5, 0x7d, 0x51, 0xc7], |it| {
            it.operate(Opcode::Sqrt, v(8), v(3), Operand::Vector(v(7)));
        });
        // vmovupd 0xa0(%rbp),%ymm15
        check(&[0xc5, 0x7d, 0x10, 0xbd, 0xa0, 0, 0, 0], |it| {
            it.load(v(15), memory(Base::Inputs, 5));
        });
        // vmovupd %ymm14,0x80(%r14); vmovupd %ymm1,0xc80(%rbx)
        check(&[0xc4, 0x41, 0x7d, 0x11, 0xb6, 0x80, 0, 0, 0], |it| {
            it.store(Base::Outputs, 4, v(14));
        });
        check(&[0xc5, 0xfd, 0x11, 0x8b, 0x80, 0x0c, 0, 0], |it| {
            it.store(Base::Registers, 100, v(1));
        });
        // vcmplt_oqpd 0x20(%rbx),%ymm2,%ymm15
        check(&[0xc5, 0x6d, 0xc2, 0x7b, 0x20, 0x11], |it| {
            it.compare(Predicate::Less, v(15), v(2), memory(Base::Registers, 1));
        });
        // vblendvpd %ymm15,%ymm9,%ymm1,%ymm3; vblendvpd %ymm14,0x40(%rbx),%ymm1,%ymm3
        check(&[0xc4, 0xc3, 0x75, 0x4b, 0xd9, 0xf0], |it| {
            it.blend(v(3), v(1), Operand::Vector(v(9)), v(15));
        });
        check(&[0xc4, 0xe3, 0x75, 0x4b, 0x5b, 0x40, 0xe0], |it| {
            it.blend(v(3), v(1), memory(Base::Registers, 2), v(14));
        });
    }
}
