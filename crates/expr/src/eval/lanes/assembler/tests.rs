use super::*;

/// The bytes of one instruction, against those of GNU `as`.
fn check(width: Width, expected: &[u8], emit: impl Fn(&mut Assembler)) {
    check_in(Layout::Packed, width, expected, emit);
}

fn check_in(layout: Layout, width: Width, expected: &[u8], emit: impl Fn(&mut Assembler)) {
    let mut assembler = Assembler::new(width, layout, Vector(15));
    emit(&mut assembler);
    assert_eq!(assembler.bytes, expected, "{:02x?}", assembler.bytes);
}

#[test]
fn columns_are_found_by_their_stride() {
    let check = |width, bytes: &[u8], emit: fn(&mut Assembler)| {
        check_in(Layout::Columns, width, bytes, emit);
    };
    // imul $0x12c,%r12,%rax; vmovsd (%r15,%rax,1),%xmm9
    let bytes = [0x49, 0x69, 0xc4, 0x2c, 1, 0, 0, 0xc4, 0x41, 0x7b, 0x10, 0x0c, 0x07];
    check(Width::One, &bytes, |it| it.load(Vector(9), Operand::Memory(Base::Inputs, 300)));
    // imul $0x1,%r12,%rax; vdivpd (%r14,%rax,1),%ymm5,%ymm6
    let bytes = [0x49, 0x69, 0xc4, 1, 0, 0, 0, 0xc4, 0xc1, 0x55, 0x5e, 0x34, 0x06];
    check(Width::Four, &bytes, |it| {
        it.operate(Opcode::Divide, Vector(6), Vector(5), Operand::Memory(Base::Outputs, 1));
    });
    // imul $0x1,%r12,%rax; vmovupd %zmm26,(%r14,%rax,1)
    let bytes = [0x49, 0x69, 0xc4, 1, 0, 0, 0, 0x62, 0x41, 0xfd, 0x48, 0x11, 0x14, 0x06];
    check(Width::Eight, &bytes, |it| it.store(Base::Outputs, 1, Vector(26)));
    // vmovupd 0x20(%rbx),%ymm15
    check(Width::Four, &[0xc5, 0x7d, 0x10, 0x7b, 0x20], |it| {
        it.load(Vector(15), Operand::Memory(Base::Registers, 1));
    });
}

#[test]
fn instructions_on_four_numbers_have_the_bytes_of_another_assembler() {
    let check = |bytes: &[u8], emit: fn(&mut Assembler)| check(Width::Four, bytes, emit);
    // vdivpd 0x20(%r14),%ymm5,%ymm6
    check(&[0xc4, 0xc1, 0x55, 0x5e, 0x76, 0x20], |it| {
        it.operate(Opcode::Divide, Vector(6), Vector(5), Operand::Memory(Base::Outputs, 1));
    });
    // vsqrtpd %ymm7,%ymm8
    check(&[0xc5, 0x7d, 0x51, 0xc7], |it| {
        it.operate(Opcode::Sqrt, Vector(8), Vector(3), Operand::Vector(Vector(7)));
    });
    // vmovupd 0xa0(%rbx),%ymm15
    check(&[0xc5, 0x7d, 0x10, 0xbb, 0xa0, 0x00, 0x00, 0x00], |it| {
        it.load(Vector(15), Operand::Memory(Base::Registers, 5));
    });
    // vmovupd %ymm14,0x80(%r14)
    check(&[0xc4, 0x41, 0x7d, 0x11, 0xb6, 0x80, 0x00, 0x00, 0x00], |it| {
        it.store(Base::Outputs, 4, Vector(14));
    });
    // vmovupd %ymm1,0xc80(%rbx)
    check(&[0xc5, 0xfd, 0x11, 0x8b, 0x80, 0x0c, 0x00, 0x00], |it| {
        it.store(Base::Registers, 100, Vector(1));
    });
    // vcmplt_oqpd 0x20(%rbx),%ymm2,%ymm15
    check(&[0xc5, 0x6d, 0xc2, 0x7b, 0x20, 0x11], |it| {
        it.compare(Predicate::Less, Vector(2), Operand::Memory(Base::Registers, 1));
    });
    // vblendvpd %ymm15,%ymm9,%ymm1,%ymm3
    check(&[0xc4, 0xc3, 0x75, 0x4b, 0xd9, 0xf0], |it| {
        it.blend(Vector(3), Vector(1), Operand::Vector(Vector(9)));
    });
    // vandpd 0x40(%rbx),%ymm15,%ymm9
    check(&[0xc5, 0x05, 0x54, 0x4b, 0x40], |it| {
        it.keep(Vector(9), Operand::Memory(Base::Registers, 2));
    });
}

#[test]
fn instructions_on_one_number_have_the_bytes_of_another_assembler() {
    let check = |bytes: &[u8], emit: fn(&mut Assembler)| check(Width::One, bytes, emit);
    // vdivsd 0x8(%r14),%xmm5,%xmm6
    check(&[0xc4, 0xc1, 0x53, 0x5e, 0x76, 0x08], |it| {
        it.operate(Opcode::Divide, Vector(6), Vector(5), Operand::Memory(Base::Outputs, 1));
    });
    // vsqrtsd %xmm7,%xmm7,%xmm8
    check(&[0xc5, 0x43, 0x51, 0xc7], |it| {
        it.operate(Opcode::Sqrt, Vector(8), Vector(3), Operand::Vector(Vector(7)));
    });
    // vsqrtsd 0x10(%rbx),%xmm8,%xmm8
    check(&[0xc5, 0x3b, 0x51, 0x43, 0x10], |it| {
        it.operate(Opcode::Sqrt, Vector(8), Vector(3), Operand::Memory(Base::Registers, 2));
    });
    // vmovsd 0x28(%rbx),%xmm15
    check(&[0xc5, 0x7b, 0x10, 0x7b, 0x28], |it| {
        it.load(Vector(15), Operand::Memory(Base::Registers, 5));
    });
    // vmovsd %xmm14,0x400(%r14)
    check(&[0xc4, 0x41, 0x7b, 0x11, 0xb6, 0x00, 0x04, 0x00, 0x00], |it| {
        it.store(Base::Outputs, 128, Vector(14));
    });
    // vcmplt_oqsd 0x8(%rbx),%xmm2,%xmm15
    check(&[0xc5, 0x6b, 0xc2, 0x7b, 0x08, 0x11], |it| {
        it.compare(Predicate::Less, Vector(2), Operand::Memory(Base::Registers, 1));
    });
    // vblendvpd %xmm15,0x10(%rbx),%xmm1,%xmm3
    check(&[0xc4, 0xe3, 0x71, 0x4b, 0x5b, 0x10, 0xf0], |it| {
        it.blend(Vector(3), Vector(1), Operand::Memory(Base::Registers, 2));
    });
    // vxorpd 0x10(%rbx),%xmm9,%xmm3
    check(&[0xc5, 0xb1, 0x57, 0x5b, 0x10], |it| {
        it.operate(Opcode::Xor, Vector(3), Vector(9), Operand::Memory(Base::Registers, 2));
    });
}

#[test]
fn instructions_on_eight_numbers_have_the_bytes_of_another_assembler() {
    let check = |bytes: &[u8], emit: fn(&mut Assembler)| check(Width::Eight, bytes, emit);
    // vdivpd 0x40(%r14),%zmm5,%zmm26
    check(&[0x62, 0x41, 0xd5, 0x48, 0x5e, 0x56, 0x01], |it| {
        it.operate(Opcode::Divide, Vector(26), Vector(5), Operand::Memory(Base::Outputs, 1));
    });
    // vaddpd %zmm31,%zmm17,%zmm8
    check(&[0x62, 0x11, 0xf5, 0x40, 0x58, 0xc7], |it| {
        it.operate(Opcode::Add, Vector(8), Vector(17), Operand::Vector(Vector(31)));
    });
    // vsqrtpd %zmm17,%zmm8
    check(&[0x62, 0x31, 0xfd, 0x48, 0x51, 0xc1], |it| {
        it.operate(Opcode::Sqrt, Vector(8), Vector(3), Operand::Vector(Vector(17)));
    });
    // vmovupd 0x140(%rbx),%zmm15
    check(&[0x62, 0x71, 0xfd, 0x48, 0x10, 0x7b, 0x05], |it| {
        it.load(Vector(15), Operand::Memory(Base::Registers, 5));
    });
    // vmovupd %zmm30,0x2000(%rbx)
    check(&[0x62, 0x61, 0xfd, 0x48, 0x11, 0xb3, 0x00, 0x20, 0x00, 0x00], |it| {
        it.store(Base::Registers, 128, Vector(30));
    });
    // vmovupd %zmm1,0x100(%r14)
    check(&[0x62, 0xd1, 0xfd, 0x48, 0x11, 0x4e, 0x04], |it| {
        it.store(Base::Outputs, 4, Vector(1));
    });
    // vcmplt_oqpd 0x40(%rbx),%zmm18,%k1
    check(&[0x62, 0xf1, 0xed, 0x40, 0xc2, 0x4b, 0x01, 0x11], |it| {
        it.compare(Predicate::Less, Vector(18), Operand::Memory(Base::Registers, 1));
    });
    // vcmpunordpd %zmm18,%zmm18,%k1
    check(&[0x62, 0xb1, 0xed, 0x40, 0xc2, 0xca, 0x03], |it| {
        it.compare(Predicate::Unordered, Vector(18), Operand::Vector(Vector(18)));
    });
    // vblendmpd %zmm9,%zmm1,%zmm19{%k1}
    check(&[0x62, 0xc2, 0xf5, 0x49, 0x65, 0xd9], |it| {
        it.blend(Vector(19), Vector(1), Operand::Vector(Vector(9)));
    });
    // vblendmpd 0x80(%rbx),%zmm1,%zmm3{%k1}
    check(&[0x62, 0xf2, 0xf5, 0x49, 0x65, 0x5b, 0x02], |it| {
        it.blend(Vector(3), Vector(1), Operand::Memory(Base::Registers, 2));
    });
    // vmovupd 0x80(%rbx),%zmm3{%k1}{z}
    check(&[0x62, 0xf1, 0xfd, 0xc9, 0x10, 0x5b, 0x02], |it| {
        it.keep(Vector(3), Operand::Memory(Base::Registers, 2));
    });
    // vandpd 0x80(%rbx),%zmm20,%zmm3
    check(&[0x62, 0xf1, 0xdd, 0x40, 0x54, 0x5b, 0x02], |it| {
        it.operate(Opcode::And, Vector(3), Vector(20), Operand::Memory(Base::Registers, 2));
    });
}

#[test]
fn shifts_have_the_bytes_of_another_assembler() {
    // vpsllq $63,%xmm9,%xmm3
    check(Width::One, &[0xc4, 0xc1, 0x61, 0x73, 0xf1, 0x3f], |it| {
        it.shift_left(Vector(3), Vector(9), 63);
    });
    // vpsllq $62,%ymm3,%ymm12
    check(Width::Four, &[0xc5, 0x9d, 0x73, 0xf3, 0x3e], |it| {
        it.shift_left(Vector(12), Vector(3), 62);
    });
    // vpsllq $62,%zmm30,%zmm17
    check(Width::Eight, &[0x62, 0x91, 0xf5, 0x40, 0x73, 0xf6, 0x3e], |it| {
        it.shift_left(Vector(17), Vector(30), 62);
    });
}
