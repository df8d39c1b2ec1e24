//! Each instruction of x86-64 is decoded by iced-x86 and has the given operands; whole functions
//! consist of instructions of the instruction set.

use iced_x86::{
    Code as Decoded, CpuidFeature, Decoder, DecoderOptions, Instruction, Mnemonic, OpKind, Register,
};

use super::check_functions;
use super::sets_of_x86_64;
use crate::generate::x86_64::{Encoder, Encoding, Opcode, Operands, Place, opcodes as op};
use crate::helper::{Helpers, Linkage};
use crate::instruction_set::InstructionSet;
use crate::real::Real;
use crate::values::Negated;

fn decode(code: &[u8]) -> Instruction {
    let mut decoder = Decoder::with_ip(64, code, 0, DecoderOptions::NONE);
    let instruction = decoder.decode();
    assert_eq!(instruction.len(), code.len(), "{code:02x?} {instruction:?}");
    assert_ne!(instruction.code(), Decoded::INVALID, "{code:02x?}");
    instruction
}

fn register(number: u8, bytes: usize) -> Register {
    let first = match bytes {
        32 => Register::YMM0,
        64 => Register::ZMM0,
        _ => Register::XMM0,
    };
    first + u32::from(number)
}

/// Registers with all combinations of the bits that encodings separate.
const REGISTERS: [u8; 8] = [0, 3, 7, 9, 15, 16, 23, 31];

const BASES: [(u8, Register); 4] =
    [(0, Register::RAX), (3, Register::RBX), (7, Register::RDI), (10, Register::R10)];

const DISTANCES: [i32; 9] = [0, 8, -128, 120, 128, 248, -4096, 100_000, 7];

/// Returns whether the last operand is the given one.
fn is_place(instruction: &Instruction, operand: u32, place: Place, bytes: usize) -> bool {
    match place {
        Place::Register(number) => {
            instruction.op_kind(operand) == OpKind::Register
                && instruction.op_register(operand) == register(number, bytes)
        }
        Place::Memory(base, distance) => {
            let base = BASES.iter().find(|(number, _)| *number == base).expect("one of them").1;
            instruction.op_kind(operand) == OpKind::Memory
                && instruction.memory_base() == base
                && instruction.memory_index() == Register::None
                && instruction.memory_displacement64() as i64 == i64::from(distance)
        }
    }
}

/// All operations with a destination, a first source and a last operand, with their mnemonics as
/// AVX has them.
fn three_operands(size: usize, scalar: bool) -> Vec<(Opcode, Mnemonic, bool)> {
    use Mnemonic as M;
    let names = match (size, scalar) {
        (8, true) => [M::Vaddsd, M::Vsubsd, M::Vmulsd, M::Vdivsd, M::Vmaxsd],
        (8, false) => [M::Vaddpd, M::Vsubpd, M::Vmulpd, M::Vdivpd, M::Vmaxpd],
        (_, true) => [M::Vaddss, M::Vsubss, M::Vmulss, M::Vdivss, M::Vmaxss],
        (_, false) => [M::Vaddps, M::Vsubps, M::Vmulps, M::Vdivps, M::Vmaxps],
    };
    let bytes = [op::ADD, op::SUBTRACT, op::MULTIPLY, op::DIVIDE, op::MAXIMUM];
    let mut all: Vec<_> = bytes.iter().zip(names).map(|(&byte, name)| (byte, name)).collect();
    if !scalar {
        let names = match size {
            8 => [M::Vandpd, M::Vandnpd, M::Vorpd, M::Vxorpd, M::Vunpcklpd],
            _ => [M::Vandps, M::Vandnps, M::Vorps, M::Vxorps, M::Vunpcklps],
        };
        let bytes = [op::AND, op::AND_NOT, op::OR, op::XOR, op::UNPACK_LOW];
        all.extend(bytes.iter().zip(names).map(|(&byte, name)| (byte, name)));
    }
    let arithmetic = |(byte, name)| (op::arithmetic(byte, scalar, size), name, true);
    let mut all: Vec<_> = all.into_iter().map(arithmetic).collect();
    let signs = [(false, false), (false, true), (true, false), (true, true)]
        .map(|(product, addend)| Negated { product, addend });
    let fused = match (size, scalar) {
        (8, true) => [
            [M::Vfmadd132sd, M::Vfmsub132sd, M::Vfnmadd132sd, M::Vfnmsub132sd],
            [M::Vfmadd213sd, M::Vfmsub213sd, M::Vfnmadd213sd, M::Vfnmsub213sd],
            [M::Vfmadd231sd, M::Vfmsub231sd, M::Vfnmadd231sd, M::Vfnmsub231sd],
        ],
        (8, false) => [
            [M::Vfmadd132pd, M::Vfmsub132pd, M::Vfnmadd132pd, M::Vfnmsub132pd],
            [M::Vfmadd213pd, M::Vfmsub213pd, M::Vfnmadd213pd, M::Vfnmsub213pd],
            [M::Vfmadd231pd, M::Vfmsub231pd, M::Vfnmadd231pd, M::Vfnmsub231pd],
        ],
        (_, true) => [
            [M::Vfmadd132ss, M::Vfmsub132ss, M::Vfnmadd132ss, M::Vfnmsub132ss],
            [M::Vfmadd213ss, M::Vfmsub213ss, M::Vfnmadd213ss, M::Vfnmsub213ss],
            [M::Vfmadd231ss, M::Vfmsub231ss, M::Vfnmadd231ss, M::Vfnmsub231ss],
        ],
        (_, false) => [
            [M::Vfmadd132ps, M::Vfmsub132ps, M::Vfnmadd132ps, M::Vfnmsub132ps],
            [M::Vfmadd213ps, M::Vfmsub213ps, M::Vfnmadd213ps, M::Vfnmsub213ps],
            [M::Vfmadd231ps, M::Vfmsub231ps, M::Vfnmadd231ps, M::Vfnmsub231ps],
        ],
    };
    for (form, names) in [0x90, 0xa0, 0xb0].into_iter().zip(fused) {
        for (negated, name) in signs.into_iter().zip(names) {
            all.push((op::multiply_add(form, negated, scalar, size), name, false));
        }
    }
    all
}

#[test]
fn three_operands_are_decoded_unchanged() {
    let mut encoded = 0;
    for (size, scalar) in [(8, true), (8, false), (4, true), (4, false)] {
        let vectors: &[usize] = if scalar { &[16] } else { &[16, 32, 64] };
        for (opcode, mnemonic, _) in three_operands(size, scalar) {
            for &vector in vectors {
                let memory = if scalar { size } else { vector };
                let in_memory = BASES.iter().flat_map(|(base, _)| {
                    DISTANCES.iter().map(|&distance| Place::Memory(*base, distance))
                });
                let places = in_memory.chain(REGISTERS.map(Place::Register));
                for place in places {
                    for (first, source) in REGISTERS.into_iter().zip([3, 31, 0, 15, 9, 23, 16, 7]) {
                        let last = if let Place::Register(last) = place { last } else { 0 };
                        let high = first.max(source).max(last) > 15 || vector == 64;
                        let encoding = if high { Encoding::Evex } else { Encoding::Vex };
                        let operands = Operands {
                            vector,
                            register: first,
                            source,
                            place,
                            memory,
                            immediate: None,
                        };
                        let mut encoder = Encoder::default();
                        encoder.vector(encoding, opcode, &operands);
                        let decoded = decode(&encoder.code);
                        assert_eq!(decoded.mnemonic(), mnemonic);
                        assert_eq!(decoded.op_register(0), register(first, vector));
                        assert_eq!(decoded.op_register(1), register(source, vector));
                        assert!(is_place(&decoded, 2, place, vector), "{operands:?} {decoded:?}");
                        encoded += 1;
                    }
                }
            }
        }
    }
    assert!(encoded > 20_000, "{encoded}");
}

#[test]
fn two_operands_are_decoded_unchanged() {
    use Mnemonic as M;
    let cases = [
        (op::arithmetic(op::ADD, true, 8), M::Addsd),
        (op::arithmetic(op::SUBTRACT, true, 4), M::Subss),
        (op::arithmetic(op::MULTIPLY, false, 8), M::Mulpd),
        (op::arithmetic(op::DIVIDE, false, 4), M::Divps),
        (op::arithmetic(op::XOR, false, 8), M::Xorpd),
        (op::arithmetic(op::AND_NOT, false, 4), M::Andnps),
        (op::arithmetic(op::SQUARE_ROOT, true, 8), M::Sqrtsd),
        (op::arithmetic(op::LOAD, false, 8), M::Movupd),
        (op::arithmetic(op::COPY, false, 4), M::Movaps),
        (op::UNPACK_LOW_DOUBLE, M::Unpcklpd),
        (op::LOAD_HIGH, M::Movhpd),
    ];
    for (opcode, mnemonic) in cases {
        for place in BASES
            .iter()
            .flat_map(|(base, _)| DISTANCES.map(|distance| Place::Memory(*base, distance)))
            .chain([0, 3, 7, 9, 15].map(Place::Register))
        {
            // Between registers it moves the lower half up.
            if mnemonic == M::Movhpd && matches!(place, Place::Register(_)) {
                continue;
            }
            for first in [0, 3, 7, 9, 15] {
                let operands = Operands {
                    vector: 16,
                    register: first,
                    source: 0,
                    place,
                    memory: 16,
                    immediate: None,
                };
                let mut encoder = Encoder::default();
                encoder.vector(Encoding::Legacy, opcode, &operands);
                let decoded = decode(&encoder.code);
                assert_eq!(decoded.mnemonic(), mnemonic);
                assert_eq!(decoded.op_register(0), register(first, 16));
                assert!(is_place(&decoded, 1, place, 16), "{operands:?} {decoded:?}");
            }
        }
    }
}

/// Returns all processor features of an instruction set.
fn has(instruction_set: InstructionSet, feature: CpuidFeature) -> bool {
    use CpuidFeature as F;
    let baseline = [F::INTEL8086, F::INTEL386, F::X64, F::CMOV, F::SSE, F::SSE2];
    let avx2 = [F::AVX, F::AVX2, F::FMA];
    let avx512 = [F::AVX512F, F::AVX512DQ, F::AVX512VL];
    baseline.contains(&feature)
        || instruction_set >= InstructionSet::Avx2 && avx2.contains(&feature)
        || instruction_set >= InstructionSet::Avx512 && avx512.contains(&feature)
}

fn whole_functions<S: Real>(name: &str) {
    for instruction_set in sets_of_x86_64() {
        let linkage = Linkage::Addresses(Helpers::new::<S>());
        check_functions::<S>(name, instruction_set, &linkage, |generated| {
            let code = &generated.code[..generated.size.bytes];
            let mut decoder = Decoder::with_ip(64, code, 0, DecoderOptions::NONE);
            let mut count = 0;
            let mut returns = 0;
            while decoder.can_decode() {
                let instruction = decoder.decode();
                assert!(
                    !instruction.is_invalid(),
                    "{name} {instruction_set:?} {}",
                    instruction.ip()
                );
                let features = instruction.cpuid_features();
                assert!(
                    features.iter().all(|&feature| has(instruction_set, feature)),
                    "{name} {instruction_set:?} {instruction:?} {features:?}"
                );
                count += 1;
                if instruction.mnemonic() == Mnemonic::Ret {
                    assert_eq!(count, generated.size.instructions);
                    returns += 1;
                }
            }
            assert_eq!((returns, decoder.position()), (1, code.len()));
        });
    }
}

#[test]
fn functions_have_the_instructions_of_their_level() {
    for name in ["arm7", "quadruped", "joint_zoo"] {
        whole_functions::<f64>(name);
        whole_functions::<f32>(name);
    }
}
