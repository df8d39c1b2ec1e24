//! Each instruction of aarch64 is decoded by yaxpeax-arm and has the given operands; whole
//! functions consist of instructions.

use yaxpeax_arch::{Decoder as _, U8Reader};
use yaxpeax_arm::armv8::a64::{InstDecoder, Instruction, Opcode};

use super::check_functions;
use crate::generate::aarch64::{Access, Encoder, opcodes as op};
use crate::helper::Linkage;
use crate::instruction_set::InstructionSet;
use crate::real::Real;
use crate::values::Negated;

pub(super) fn decode(word: u32) -> Instruction {
    let bytes = word.to_le_bytes();
    let decoded = InstDecoder::default().decode(&mut U8Reader::new(&bytes));
    decoded.unwrap_or_else(|error| panic!("{word:08x}: {error:?}"))
}

/// Returns the instructions as text.
fn texts(write: impl FnOnce(&mut Encoder)) -> Vec<String> {
    let mut encoder = Encoder::default();
    write(&mut encoder);
    encoder.words.iter().map(|&word| decode(word).to_string()).collect()
}

/// Registers with all combinations of the bits that fields have.
const REGISTERS: [u8; 7] = [0, 3, 8, 13, 16, 21, 31];

/// Returns registers for four operands, in several orders.
fn orders() -> impl Iterator<Item = [u8; 4]> {
    (0..7).flat_map(|i| {
        let at = move |k: usize| REGISTERS[k % 7];
        [[at(i), at(i + 1), at(i + 3), at(i + 6)], [at(i + 2), at(i), at(i), at(i + 5)]]
    })
}

#[test]
fn operations_are_decoded_unchanged() {
    let arithmetic = [
        (op::ADD, "fadd"),
        (op::SUBTRACT, "fsub"),
        (op::MULTIPLY, "fmul"),
        (op::DIVIDE, "fdiv"),
        (op::EQUAL, "fcmeq"),
        (op::GREATER_OR_EQUAL, "fcmge"),
        (op::GREATER, "fcmgt"),
    ];
    let unary = [(op::SQUARE_ROOT, "fsqrt"), (op::NEGATE, "fneg")];
    let fused = [
        (Negated { product: false, addend: false }, "fmadd"),
        (Negated { product: true, addend: false }, "fmsub"),
        (Negated { product: true, addend: true }, "fnmadd"),
        (Negated { product: false, addend: true }, "fnmsub"),
    ];
    for [a, b, c, d] in orders() {
        for (size, scalar, lanes) in [(8, "d", "2d"), (4, "s", "4s")] {
            for (opcode, name) in arithmetic {
                let listing = texts(|e| {
                    e.three(opcode.of(true, size), [a, b, c]);
                    e.three(opcode.of(false, size), [a, b, c]);
                });
                let expected = [
                    format!("{name} {scalar}{a}, {scalar}{b}, {scalar}{c}"),
                    format!("{name} v{a}.{lanes}, v{b}.{lanes}, v{c}.{lanes}"),
                ];
                assert_eq!(listing, expected);
            }
            for (opcode, name) in unary {
                let listing = texts(|e| {
                    e.two(opcode.of(true, size), [a, b]);
                    e.two(opcode.of(false, size), [a, b]);
                });
                let expected = [
                    format!("{name} {scalar}{a}, {scalar}{b}"),
                    format!("{name} v{a}.{lanes}, v{b}.{lanes}"),
                ];
                assert_eq!(listing, expected);
            }
            for (negated, name) in fused {
                let listing = texts(|e| e.four(op::multiply_add(negated, size), [a, b, c, d]));
                let expected = format!("{name} {scalar}{a}, {scalar}{b}, {scalar}{c}, {scalar}{d}");
                assert_eq!(listing, [expected]);
            }
            let listing = texts(|e| {
                e.three(op::accumulate(false, size), [a, b, c]);
                e.three(op::accumulate(true, size), [a, b, c]);
                e.three(op::compare_flags(size), [0, b, c]);
                e.two(op::shift_to_sign(size), [a, b]);
                e.two(op::broadcast(size), [a, b]);
                e.three(op::join(size), [a, b, c]);
            });
            let expected = [
                format!("fmla v{a}.{lanes}, v{b}.{lanes}, v{c}.{lanes}"),
                format!("fmls v{a}.{lanes}, v{b}.{lanes}, v{c}.{lanes}"),
                format!("fcmp {scalar}{b}, {scalar}{c}"),
                format!("shl v{a}.{lanes}, v{b}.{lanes}, #0x{:x}", 8 * size - 1),
                format!("mov v{a}.{lanes}, v{b}.{scalar}[0]"),
                format!("zip1 v{a}.{lanes}, v{b}.{lanes}, v{c}.{lanes}"),
            ];
            assert_eq!(listing, expected);
        }
        let listing = texts(|e| {
            e.three(op::AND, [a, b, c]);
            e.three(op::CLEAR, [a, b, c]);
            e.three(op::OR, [a, b, c]);
            e.three(op::XOR, [a, b, c]);
            e.three(op::SELECT, [a, b, c]);
            e.two(op::NOT, [a, b]);
            e.copy(a, b);
            e.two(op::MINIMUM_ACROSS, [a, b]);
            e.two(op::TO_GENERAL, [9, b]);
            e.two(op::COMPARE_WITH_ALL_BITS, [31, 9]);
            e.word(op::SKIP_IF_EQUAL);
            e.word(op::SKIP_IF_LESS);
        });
        let bytes = |name: &str| format!("{name} v{a}.16b, v{b}.16b, v{c}.16b");
        let or = if b == c { format!("mov v{a}.16b, v{b}.16b") } else { bytes("orr") };
        let expected = [
            bytes("and"),
            bytes("bic"),
            or,
            bytes("eor"),
            bytes("bsl"),
            format!("mvn v{a}.16b, v{b}.16b"),
            format!("mov v{a}.16b, v{b}.16b"),
            format!("uminv s{a}, v{b}.4s"),
            format!("fmov w9, s{b}"),
            "cmn w9, #0x1".into(),
            "b.eq $+0x8".into(),
            "b.mi $+0x8".into(),
        ];
        assert_eq!(listing, expected);
    }
}

#[test]
fn memory_is_decoded_unchanged() {
    let name = |access: Access| if access == Access::Load { "ld" } else { "st" };
    for (bytes, kind) in [(4, 's'), (8, 'd'), (16, 'q')] {
        for access in [Access::Load, Access::Store] {
            for (register, base) in [(0, 8), (31, 31), (13, 16)] {
                let base_name = if base == 31 { "sp".into() } else { format!("x{base}") };
                let texts = |offset| texts(|e| e.memory(access, bytes, register, base, offset));
                let direct = format!("{}r {kind}{register}, [{base_name}", name(access));
                assert_eq!(texts(0), [format!("{direct}]")]);
                for units in [1, 5, 4095] {
                    let offset = units * bytes as u32;
                    assert_eq!(texts(offset), [format!("{direct}, #0x{offset:x}]")]);
                }
                let unaligned = format!("{}ur {kind}{register}, [{base_name}", name(access));
                for offset in [3, 255] {
                    assert_eq!(texts(offset), [format!("{unaligned}, #0x{offset:x}]")]);
                }
                let far = 4096 * bytes as u32;
                for (offset, words) in [
                    (257, 1),
                    (far, 1 + usize::from(bytes == 16)),
                    (far + 2, 1 + usize::from(bytes == 16)),
                    (0x1234_5678, 2),
                ] {
                    let listing = texts(offset);
                    assert_eq!(listing.len(), words + 1);
                    assert_eq!(constant(&listing[..words]), u64::from(offset));
                    assert_eq!(listing[words], format!("{direct}, x9]"));
                }
            }
        }
    }
    for offset in [0, 17, 4095] {
        let listing = texts(|e| e.address(2, 31, offset));
        let expected =
            if offset == 0 { "mov x2, sp".into() } else { format!("add x2, sp, #0x{offset:x}") };
        assert_eq!(listing, [expected]);
    }
    let above_stack = texts(|e| e.address(1, 31, 0x12_3456));
    assert_eq!(constant(&above_stack[..2]), 0x12_3456);
    assert_eq!(above_stack[2], "add x1, sp, x9");
    let listing = texts(|e| e.address(1, 14, 5000));
    assert_eq!(constant(&listing[..1]), 5000);
    assert_eq!(listing[1], "add x1, x14, x9");
    for value in [0, 1, 0xffff, 0x1_0000, 0x7f12_3456_789a, u64::MAX] {
        assert_eq!(constant(&texts(|e| e.constant(9, value))), value);
    }
}

/// Returns the constant that instructions load into x9.
fn constant(texts: &[String]) -> u64 {
    let mut value = 0;
    for (i, text) in texts.iter().enumerate() {
        let first = text.strip_prefix("mov x9, #0x");
        let part = first.or_else(|| text.strip_prefix("movk x9, #0x"));
        assert_eq!(first.is_some(), i == 0, "{text}");
        let part = part.unwrap_or_else(|| panic!("{text}"));
        let (digits, shift) = part.split_once(", lsl #").unwrap_or((part, "0"));
        let shift: u32 = shift.parse().expect("a number");
        value |= u64::from_str_radix(digits, 16).expect("digits") << shift;
    }
    value
}

fn whole_functions<S: Real>(name: &str) {
    check_functions::<S>(name, InstructionSet::Neon, &Linkage::Relative, |generated| {
        let code = &generated.code[..generated.size.bytes];
        let words = code.chunks_exact(4);
        assert!(words.remainder().is_empty());
        let words = words.map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")));
        let decoded: Vec<Instruction> = words.map(decode).collect();
        let is_return = |i: &Instruction| i.opcode == Opcode::RET;
        assert_eq!(decoded.iter().filter(|&i| is_return(i)).count(), 1);
        let before = decoded.iter().position(is_return).expect("a return");
        assert_eq!(before + 1, generated.size.instructions);
        assert_eq!(4 * (before + 1), generated.end);
    });
}

#[test]
fn functions_are_instructions() {
    for name in ["arm7", "quadruped", "joint_zoo"] {
        whole_functions::<f64>(name);
        whole_functions::<f32>(name);
    }
}
